#!/usr/bin/python3
# SPDX-License-Identifier: GPL-2.0-or-later
"""The part of examples/peers.md that scripts/bench peers measured: grains of three codes, error over seconds; between its two markers.

usage  peers.py <repository> <build folder> <samples.json> <accuracy.csv> <page> [rows.json]...

page       "": the tables are printed only
rows.json  what other codes came to: a list of {problem, code, settings, error, seconds}"""

import csv
import json
import subprocess
import sys
import time
from pathlib import Path

import numpy as np
from matplotlib.figure import Figure
from matplotlib.ticker import LogLocator, NullFormatter

import figures

begin, end = "<!-- peers: written by scripts/bench peers --write -->", "<!-- end of the peers -->"
norms = {
	"Terzaghi": "pressure over the load, rms over 8 heights and T_v = 0.1, 0.2, 0.5, 0.8; Terzaghi",
	"Neumann thaw": "depth of the front, rms over 40 instants; Neumann",
	"column collapse": "largest of front, crest and centre of mass; finest run of Talik",
}

marks = {
	"Talik": ("o", "C0"),
	"Talik, implicit pressure": ("o", "C0"),
	"Talik, explicit pressure": ("^", "C2"),
	"frozen-ground-fem": ("s", "C1"),
	"mpmxdem": ("D", "C3"),
}


def studied(file):
	"""Runs of scripts/accuracy with an error below 30 % that no other of their problem beats in error and time, implicit pressure, the standard."""
	with open(file, newline="", encoding="utf-8") as lines:
		for row in csv.DictReader(lines):
			shown = row["on the front"] or "implicit" in row["varied"] or row["varied"] == "standard"
			if row["failure"] == "" and shown and float(row["error [-]"]) < 0.3:
				yield {
					"problem": row["problem"],
					"code": "Talik",
					"settings": row["varied"],
					"error": float(row["error [-]"]),
					"seconds": float(row["CPU time [s]"]),
				}


def grains(measured):
	lines = ["| 400 grains, frictional | stock YADE | LAMMPS | Talik, packed | stock YADE over Talik | LAMMPS over Talik |", "|---|---|---|---|---|---|"]
	for kind, label in (("frictional", "discs"), ("spheres, frictional", "spheres")):
		stock = next(f for f in measured if f.name.startswith(kind) and f.name.endswith("stock/packed") and "portable" not in f.name)
		other = next(f for f in measured if f.name == f"{kind}: LAMMPS/packed")
		times = stock.terms["stock [ns]"], other.terms.get("LAMMPS [ns]", "not run"), stock.terms["packed [ns]"]
		lines.append(f"| {label} | " + " | ".join(f"{t:.3g} ns" if t != "not run" else t for t in times) + f" | {stock.value:.3g} | {other.value:.3g} |")
	return lines


def errors(rows):
	lines = ["| problem | code | error in processor time [s], with settings |", "|---|---|---|"]
	for problem in norms:
		of = [row for row in rows if row["problem"] == problem]
		for code in sorted({row["code"] for row in of}, key=lambda code: (code != "Talik", code)):
			ones = sorted((row for row in of if row["code"] == code), key=lambda row: row["seconds"])
			told = [f"{100 * row['error']:.2g} % in {row['seconds']:.2g} ({row['settings']})" for row in ones]
			lines.append(f"| {problem} | {code} | {'; '.join(told)} |")
	return lines


def kind(row, rows):
	"""The code of a row, and how it solves for pore pressure where rows of its problem differ in that."""
	implicit = lambda one: "implicit" in one["settings"]
	if row["code"] != "Talik" or not any(implicit(one) for one in rows):
		return row["code"]
	return "Talik, implicit pressure" if implicit(row) else "Talik, explicit pressure"


def draw(rows, file):
	figure = Figure(figsize=(11, 3.6), layout="constrained")
	for panel, problem in zip(figure.subplots(1, len(norms)), norms):
		rowsOfIt = [row for row in rows if row["problem"] == problem]
		for code, (marker, colour) in marks.items():
			of = [row for row in rowsOfIt if kind(row, rowsOfIt) == code]
			if of:
				panel.loglog([row["seconds"] for row in of], [100 * row["error"] for row in of], marker, color=colour, label=code)
		panel.set(title=problem, xlabel="processor time [s]", ylabel="error [%]")
		if np.ptp(np.log10(panel.get_ylim())) < 2:  # a power of ten alone would say little
			panel.yaxis.set_major_locator(LogLocator(subs=(1, 2, 5)))
			panel.yaxis.set_minor_formatter(NullFormatter())
		panel.yaxis.set_major_formatter("{x:g}")
		panel.grid(alpha=0.3, which="both")
		panel.legend()
	figure.savefig(file, dpi=100)


def main(repository, build, samples, study, page, *others):
	rows = list(studied(study))
	for file in others:
		rows += json.loads(Path(file).read_text(encoding="utf-8"))
	where = figures.machine(figures.compilerOf(build))
	revision = subprocess.run(["git", "-C", repository, "describe", "--always", "--dirty"], capture_output=True, text=True, check=False).stdout.strip()
	machine = f"{where['CPU']}, {where['cores']} cores, load {where['load']}"
	said = (
		f"{time.strftime('%d %B %Y')}, revision {revision}, {machine}; {where['compiler']}; one thread, processor time. Talik alone: no other code was given."
	)
	block = [said if not others else said.partition(" Talik alone")[0], "", *grains(figures.read(samples)[0])]
	block += ["", *(f"- {name}: {norm}." for name, norm in norms.items()), "", *errors(rows)]
	print("\n".join(block))
	if page:
		page = Path(page)
		text = page.read_text(encoding="utf-8")
		page.write_text("\n".join([text[: text.index(begin) + len(begin)], *block, text[text.index(end) :]]), encoding="utf-8")
		draw(rows, page.with_suffix(".png"))


if __name__ == "__main__":
	if len(sys.argv) < 6:
		sys.exit(__doc__)
	main(*sys.argv[1:])
