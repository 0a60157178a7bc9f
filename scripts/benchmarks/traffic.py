# SPDX-License-Identifier: GPL-2.0-or-later
"""Bytes that a point of the ground carries and moves in a step, beside a copy of memory: run by scripts/bench traffic, inside the stock yade.

usage  traffic.py <talik_performance> <result.json>

Bytes moved are counted by valgrind in a cache of 1 MB: lines that come in, and lines that are written back. The time of a step and that of
the copy are processor times, taken in turn."""

import json
import re
import statistics
import subprocess
import sys
import tempfile
import time
from pathlib import Path

import numpy as np
from yade import O, wrapper

import figures
import talik

line, warm, timed, points = 64, 5, 40, 40000  # bytes of a line of the cache; steps and points of tests/performance/bench_effects.cpp
calls = ("p2g", "solveNodes", "g2p", "updateStrainAndPressure", "updateEffectiveStress")
heat = lambda: dict(heat=wrapper.HeatTransfer(), freezing=wrapper.FreezingCurve())
scenes = {
	"dry": lambda: dict(skeleton=wrapper.ElasticSkeleton(), bBar=False),
	"dry, heat, freezing": lambda: dict(skeleton=wrapper.ElasticSkeleton(), bBar=False, **heat()),
	"water, heat, freezing": lambda: dict(skeleton=wrapper.ElasticSkeleton(), water=wrapper.PoreWater(), **heat()),
}


def carried(name):
	"""Bytes of the fields of a point, and of those of nodes and cells for each point."""
	mpm = wrapper.MpmEngine(gridSpacing=0.01, lower=(0, 0), upper=(1.4, 1.12), gravity=(0, -9.81), deformationRecord=False, **scenes[name]())
	talik.geometry.fill(mpm, talik.geometry.rectangle(0.2, 0, 1.2, 1), pointsPerCell=4, porosity=0.4, **({"temperature": -1} if "heat" in name else {}))
	O.engines = [mpm]
	mpm.initialise()
	ofPoints = sum(field["bytes"] for field in mpm.fields() if field["place"] == "points")
	return ofPoints / mpm.pointCount, (sum(field["bytes"] for field in mpm.fields()) - ofPoints) / mpm.pointCount


def moved(program, name):
	"""Bytes between the second-level cache and what is behind it, a point and step."""
	with tempfile.TemporaryDirectory() as folder:
		file = Path(folder) / "counts"
		toggles = [f"--toggle-collect=talik::Ground<2>::{call}()" for call in calls]
		cache = ["--cache-sim=yes", "--simulate-wb=yes", f"--LL={1 << 20},16,{line}"]
		command = ["valgrind", "--tool=callgrind", f"--callgrind-out-file={file}", "--collect-atstart=no", *toggles, *cache, program]
		subprocess.run([*command, f"--benchmark_filter=^effects/{name}/1 thread"], check=True, capture_output=True)
		text = file.read_text()
	events, counts = (re.search(rf"^(?:{word}): (.*)$", text, re.M).group(1).split() for word in ("events", "totals|summary"))
	count = dict(zip(events, map(int, counts)))
	return line * sum(count.get(event, 0) for event in ("DLmr", "DLmw", "DLdmr", "DLdmw")) / (points * (warm + timed))


def nanoseconds(program, name):
	with tempfile.NamedTemporaryFile() as file:
		subprocess.run([program, f"--benchmark_filter=^effects/{name}/1 thread", f"--benchmark_out={file.name}"], check=True, capture_output=True)
		run = json.loads(Path(file.name).read_text())["benchmarks"][0]
	return run["cpu_time"] / run["points"]


def copied(megabytes=256):
	"""GB/s that a copy of memory reads and writes together."""
	source = np.ones(megabytes << 17)
	target = np.zeros_like(source)
	start = time.thread_time()
	for _ in range(4):
		np.copyto(target, source)
	return 8 * source.nbytes / (time.thread_time() - start) / 1e9


def main(program, result):
	measured = []
	for name in scenes:
		times, copies = figures.interleaved(7, lambda: nanoseconds(program, name), copied)
		ofPoint, ofNodes = carried(name)
		bytesMoved = moved(program, name)
		share = figures.medianRatio([bytesMoved / t for t in times], copies)
		terms = {"ns": statistics.median(times), "carried by a point": ofPoint, "by nodes": ofNodes, "moved": bytesMoved}
		terms.update({"GB/s": bytesMoved / statistics.median(times), "copy of memory [GB/s]": statistics.median(copies)})
		measured.append(figures.Figure(f"{name}: GB/s over a copy of memory", share, "x", terms=terms))
	figures.write(result, measured, ["bytes moved: valgrind, a cache of 1 MB; a copy reads and writes"])


main(*sys.argv[1:])
