# SPDX-License-Identifier: GPL-2.0-or-later
"""Figures that a benchmark measures, the limits they have to keep, the table that shows them. Needs no YADE."""

import json
import math
import os
import platform
import statistics
import subprocess
from dataclasses import asdict, dataclass, field
from pathlib import Path


@dataclass
class Figure:
	"""One measured number and what is asked of it."""

	name: str
	value: float
	unit: str = ""  # "x" for a ratio
	floor: float = None  # the value must not be below
	ceiling: float = None  # the value must not be above
	aim: float = None
	terms: dict = field(default_factory=dict)  # what the number was made of: name with unit -> value

	@property
	def reached(self):
		return (self.floor is None or self.value >= self.floor) and (self.ceiling is None or self.value <= self.ceiling)

	@property
	def limit(self):
		if self.floor is not None:
			return f">= {self.floor:g}"
		return f"<= {self.ceiling:g}" if self.ceiling is not None else ""


def interleaved(rounds, *runs):
	"""Calls the runs in turn, round after round; a list of results for each."""
	columns = [[] for _ in runs]
	for _ in range(rounds):
		for column, run in zip(columns, runs):
			column.append(run())
	return columns


def medianRatio(above, below):
	"""Median of the ratios of neighbours in time: the speed of the machine at that moment drops out."""
	return statistics.median(a / b for a, b in zip(above, below))


def machine(compiler=None):
	"""Where the figures were taken."""
	facts = dict(line.split(":", 1) for line in Path("/proc/cpuinfo").read_text().split("\n\n")[0].splitlines() if ":" in line)
	facts = {name.strip(): value.strip() for name, value in facts.items()}
	family = " ".join(f"{label} {facts[name]}" for label, name in (("family", "cpu family"), ("model", "model")) if name in facts)
	vectors = [name for name in ("avx2", "avx512f") if name in facts.get("flags", "").split()]
	return {
		"machine": platform.node(),
		"CPU": f"{facts.get('model name', platform.processor())} ({family}; {', '.join(vectors) or 'no AVX2'})",
		"cores": len(os.sched_getaffinity(0)),
		"system": f"{_distribution()}, kernel {platform.release()}",
		"compiler": compiler or "unknown",
		"load": Path("/proc/loadavg").read_text().split()[0],
	}


def compilerOf(buildFolder):
	"""Compiler and flags of a CMake build."""
	cache = (Path(buildFolder) / "CMakeCache.txt").read_text().splitlines()
	values = dict(line.split("=", 1) for line in cache if "=" in line and not line.startswith(("#", "//")))
	command = next((value for name, value in values.items() if name.startswith("CMAKE_CXX_COMPILER:")), "c++")
	version = subprocess.run([command, "--version"], capture_output=True, text=True, check=True).stdout.splitlines()[0]
	return f"{version}, {values.get('CMAKE_BUILD_TYPE:STRING', 'Release')}"


def write(path, figures, notes=()):
	Path(path).write_text(json.dumps(dict(figures=[asdict(f) for f in figures], notes=list(notes)), indent="\t") + "\n")


def read(path):
	content = json.loads(Path(path).read_text())
	return [Figure(**f) for f in content["figures"]], content["notes"]


def table(figures):
	"""Lines of text: figure, value, limit, aim, verdict, terms."""
	rows = [("figure", "measured", "to reach", "aim", "", "made of")]
	for f in figures:
		verdict = "" if f.floor is None and f.ceiling is None else ("ok" if f.reached else "MISSED")
		terms = ", ".join(f"{name} {_short(value)}" for name, value in f.terms.items())
		rows.append((f.name, f"{_short(f.value)} {f.unit}".rstrip(), f.limit, "" if f.aim is None else f"{f.aim:g}", verdict, terms))
	widths = [max(len(row[c]) for row in rows) for c in range(5)] + [0]
	lines = ["  ".join(cell.ljust(width) for cell, width in zip(row, widths)).rstrip() for row in rows]
	return [lines[0], "-" * max(map(len, lines)), *lines[1:]]


def _short(value):
	if not isinstance(value, float):
		return str(value)
	if math.isnan(value):
		return "not measured"
	return f"{value:.0f}" if abs(value) >= 1000 else f"{value:.4g}"


def _distribution():
	for line in Path("/etc/os-release").read_text().splitlines():
		if line.startswith("PRETTY_NAME="):
			return line.split("=", 1)[1].strip('"')
	return platform.system()
