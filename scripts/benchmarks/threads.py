# SPDX-License-Identifier: GPL-2.0-or-later
"""Steps by all threads of this yade and by one, in turn, while other processes keep the cores busy:

	yade -n -x -j2 scripts/benchmarks/threads.py ratios.json [--rounds 15] [--busy 0,1,2] [--steps 20]

A ratio is the median over the rounds of the time of all threads over the mean of that of one before and after, and so needs no
quiet machine."""

import argparse
import os
import statistics
import subprocess
import sys
import time
from pathlib import Path

from yade import O, wrapper

import talik

sys.path.insert(0, str(Path(sys.argv[0]).resolve().parent))
import figures


def dry():
	return wrapper.MpmEngine(
		gridSpacing=0.02,
		lower=(0, 0),
		upper=(2, 2),
		gravity=(0, -9.81),
		damping=0.3,
		skeleton=wrapper.ElasticSkeleton(),
		boundaries=[wrapper.FixedBoundary(region="bottom")],
	)


def wet():
	mpm = dry()
	mpm.heat, mpm.freezing, mpm.water = wrapper.HeatTransfer(thermalTimeScale=1e4), wrapper.FreezingCurve(), wrapper.PoreWater()
	mpm.boundaries = mpm.boundaries + [wrapper.SurfaceTemperature(region="surface", temperature=5)]
	return mpm


def seconds(steps, threads):
	begin = time.perf_counter()
	if threads == 1:
		talik.runSerially(steps)
	else:
		for _ in range(steps):
			O.step()
	return time.perf_counter() - begin


def ratio(mpm, rounds, steps):
	O.reset()
	talik.geometry.fill(mpm, [(0, 0), (2, 0), (2, 0.5), (0, 0.5)], temperature=-1)
	O.engines = [mpm]
	seconds(steps, 1), seconds(steps, 2)
	ratios, serial = [], [seconds(steps, 1)]
	for _ in range(rounds):
		parallel = seconds(steps, 2)
		serial.append(seconds(steps, 1))
		ratios.append(2 * parallel / (serial[-1] + serial[-2]))
	return statistics.median(ratios), statistics.median(serial) / steps


def main():
	load = " ".join(f"{value:.1f}" for value in os.getloadavg())
	parser = argparse.ArgumentParser()
	parser.add_argument("file")
	parser.add_argument("--rounds", type=int, default=15)
	parser.add_argument("--steps", type=int, default=20)
	parser.add_argument("--busy", default="0,1,2")
	options = parser.parse_args(sys.argv[1:])
	measured = []
	for count in map(int, options.busy.split(",")):
		busy = [subprocess.Popen([sys.executable, "-c", "while True: pass"]) for _ in range(count)]
		try:
			for name, ground in (("dry", dry), ("wet and freezing", wet)):
				value, step = ratio(ground(), options.rounds, options.steps)
				what = f"{name}, {count} busy processes beside it: time of {os.environ.get('OMP_NUM_THREADS', '?')} threads over that of one"
				measured.append(figures.Figure(what, value, "x", ceiling=1.2, terms={"points": O.engines[0].pointCount, "ms a step by one": 1e3 * step}))
				print(f"{what} {value:.2f}; {1e3 * step:.2f} ms a step by one", flush=True)
		finally:
			for process in busy:
				process.kill()
				process.wait()
	figures.write(options.file, measured, ["Load of the machine when it began: " + load])


main()
os._exit(0)
