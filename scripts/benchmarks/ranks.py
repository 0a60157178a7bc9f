#!/usr/bin/python3
# SPDX-License-Identifier: GPL-2.0-or-later
"""One scene on one, two and four ranks, and on one and two threads, in turn:

	/usr/bin/python3 scripts/benchmarks/ranks.py ranks.json [--rounds 2] [--steps 150]

Scenes: a frozen slope in the plane whose samples follow a shear ('samples', a small Case I), the same with cells and samples of its preset
paper ('paper'), of twice the size ('twice'), with a law in place of samples ('law'), a slope in space with samples of spheres ('space'), with
a law ('spaceLaw'), a fine slope in the plane with a law that is shared out in bands ('bandsLaw'), and the slope with samples in bands, on
cells half as wide ('bandsSamples'): these follow the cost of the samples from the first sorting of points on, so that time is taken after
210 steps. Each run is a yade of its own that does the same steps. Work is the processor time of a rank less what it spends waiting for
others: it does not depend on what else the machine does, as wall time does. Four ranks may have fewer cores than that: they are compared for
the bits and the work.

	yade -n -x ranks.py --record SCENE STEPS FILE     one rank alone: what each step costs, for scripts/scaling; again: the lesser of both"""

import argparse
import json
import os
import subprocess
import sys
import tempfile
from pathlib import Path

import figures

settle = 40  # steps before time is taken: samples get states of their own, and the first deal
settleInBands = 210  # the same of samples in bands, which are cut anew when points are sorted
counts = (1, 2, 4)
inBands = {"bandsLaw": "bands of a law", "bandsSamples": "bands with samples"}


def command(ranks, threads, *arguments):
	start = ["mpirun", "-n", str(ranks), "--bind-to", "none", "--oversubscribe", *(["--allow-run-as-root"] if os.geteuid() == 0 else [])]
	return [*(start if ranks > 1 else []), "yade", "-n", "-x", f"-j{threads}", __file__, *map(str, arguments)]


def measured(scene, ranks, threads, steps):
	"""What each rank of one run says of the timed steps."""
	with tempfile.TemporaryDirectory() as folder:
		subprocess.run(command(ranks, threads, "--inside", folder, scene, steps), check=True, timeout=1800, capture_output=True)
		return [json.loads((Path(folder) / f"{rank}.json").read_text()) for rank in range(ranks)]


def best(runs):
	"""Of several runs of one kind: least wall time and least work of the busiest rank [s], and what does not depend on the run."""
	if len({rank["state"] for run in runs for rank in run}) != 1:
		raise SystemExit("ranks.py: the runs did not end with the same bits")
	return {
		"wall": min(max(rank["wall"] for rank in run) for run in runs),
		"work": min(max(rank["processor"] - rank["polling"] for rank in run) for run in runs),
		**{name: runs[0][0][name] for name in ("points", "calls", "steps", "balance", "moved", "messages", "state")},
		"bytes": max(rank["bytes"] for rank in runs[0]),
		"memory": max(rank["memory"] for rank in runs[0]),
		"inSamples": min(run[0]["inSamples"] / run[0]["wall"] for run in runs),
	}


def main():
	parser = argparse.ArgumentParser(description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter)
	parser.add_argument("file")
	parser.add_argument("--rounds", type=int, default=2)
	parser.add_argument("--steps", type=int, default=150)
	options = parser.parse_args()
	kinds = [(scene, ranks, 1) for scene in ("samples", "law", "space") for ranks in counts] + [
		("paper", 1, 1),
		("paper", 2, 1),
		("paper", 1, 2),
		("twice", 1, 1),
		("twice", 2, 1),
		("spaceLaw", 1, 1),
		("samples", 1, 2),
		*((scene, ranks, 1) for scene in inBands for ranks in counts),
	]
	runs = figures.interleaved(options.rounds, *(lambda kind=kind: measured(*kind, options.steps) for kind in kinds))
	found = {kind: best(own) for kind, own in zip(kinds, runs)}
	Path(options.file).with_name("ranks-measured.json").write_text(
		json.dumps(
			[{"scene": scene, "ranks": ranks, "threads": threads, "timed": options.steps, **found[scene, ranks, threads]} for scene, ranks, threads in kinds]
		)
	)
	for scene in ("samples", "paper", "law", "space", "twice", *inBands):
		if len({its["state"] for kind, its in found.items() if kind[0] == scene}) != 1:
			raise SystemExit(f"ranks.py: '{scene}' did not end with the same bits on any number of ranks and threads")
	figures.write(options.file, list(figuresOf(found, options.steps)), notes())


def figuresOf(found, steps):
	"""With s, the part of the time in samples, and b, the balance."""
	for scene in ("samples", "space"):
		alone = found[scene, 1, 1]
		yield figures.Figure(
			f"{scene}: part of the time of one rank in samples",
			alone["inSamples"],
			terms={"points": alone["points"], "calls a step": alone["calls"] / steps, "ms a step": 1e3 * alone["work"] / steps},
		)
		for ranks in counts[1:]:
			its = found[scene, ranks, 1]
			yield figures.Figure(
				f"{scene}: strong efficiency of {ranks} ranks, by work of the busiest",
				alone["work"] / its["work"] / ranks,
				terms={"faster": alone["work"] / its["work"], "balance": its["balance"], "states moved": its["moved"]},
			)
		pair = found[scene, 2, 1]
		yield figures.Figure(f"{scene}: messages a step", pair["messages"] / steps, terms={"kB a step of a rank": pair["bytes"] / steps / 1e3})
	for scene in ("samples", "paper"):
		ratio = found[scene, 1, 1]["work"] / found[scene, 2, 1]["work"]
		yield figures.Figure(f"{scene}: work of one rank over that of the busier of two", ratio, "x", aim=1.8)
	half, pair = 0.5 * found["twice", 1, 1]["work"], found["twice", 2, 1]  # ground twice as large is not quite as costly a point
	yield figures.Figure(
		"samples: weak efficiency of 2 ranks, twice the ground", half / pair["work"], terms={"points": pair["points"], "balance": pair["balance"]}
	)
	for ranks in counts[1:]:
		yield figures.Figure(f"law: strong efficiency of {ranks} ranks", found["law", 1, 1]["work"] / found["law", ranks, 1]["work"] / ranks)
	for scene, name in inBands.items():
		alone = found[scene, 1, 1]
		for ranks in counts[1:]:
			its = found[scene, ranks, 1]
			yield figures.Figure(
				f"{name}: work of one rank over that of the busiest of {ranks}",
				alone["work"] / its["work"],
				"x",
				aim=1.8 if ranks == 2 else None,
				terms={
					"points": its["points"],
					"ms a step of one rank": 1e3 * alone["work"] / steps,
					"messages a step": its["messages"] / steps,
					"kB a step of a rank": its["bytes"] / steps / 1e3,
					"MB that a rank holds": its["memory"] / 1e6,
					"MB of one rank": alone["memory"] / 1e6,
					"balance of the samples": its["balance"],
				},
			)
	for scene in ("samples", "paper"):
		alone, pair, threads = (found[scene, *kind] for kind in ((1, 1), (2, 1), (1, 2)))
		yield figures.Figure(
			f"{scene}: speed of two ranks, wall time",
			alone["wall"] / pair["wall"],
			"x",
			aim=1.8 if scene == "paper" else None,
			terms={"points": alone["points"], "calls a step": alone["calls"] / steps, "two threads": alone["wall"] / threads["wall"]},
		)
		yield figures.Figure(f"{scene}: time of two ranks over that of two threads", pair["wall"] / threads["wall"], "x")


def notes():
	return [
		f"Load of the machine when it ended: {Path('/proc/loadavg').read_text().split()[0]}. Speeds by wall time mean something only where it does nothing else.",
		"Work leaves out the waiting for other ranks, and so the cost of messages and of a bad balance within a step.",
		"Without bands a law has nothing to share out: each rank computes all, and the efficiency of n ranks is 1/n.",
		"All fields of points and samples had the same bits at the end on 1, 2 and 4 ranks and on 2 threads.",
	]


# --- inside a yade ---------------------------------------------------------------------------------------------------------

outline = [(0, 0), (10, 0), (10, 1), (6, 1), (3, 4), (0, 4)]  # of Case I [m]
mirrored = [(10, 0), (10, 1), (6, 1), (3, 4), (-3, 4), (-6, 1), (-10, 1), (-10, 0)]


def ground(corners, samples=None, dimension=2, spacing=0.5, **attributes):
	import numpy as np
	import talik
	from yade import O, wrapper

	left, upper = min(x for x, _ in corners), spacing * round(4 / spacing + 4)
	mpm = wrapper.MpmEngine(
		gridSpacing=spacing,
		lower=(left, 0) if dimension == 2 else (left, 0, 0),
		upper=(10, upper) if dimension == 2 else (10, 2, upper),
		gravity=(0, -9.81) if dimension == 2 else (0, 0, -9.81),
		damping=0.02,
		skeleton=wrapper.RveSkeleton(samples=samples) if samples else wrapper.MohrCoulombSkeleton(),
		heat=wrapper.HeatTransfer(thermalTimeScale=8.64e5),
		freezing=wrapper.FreezingCurve(),
		water=wrapper.PoreWater(),
		boundaries=[wrapper.RollerBoundary(region="left"), wrapper.RollerBoundary(region="right"), wrapper.FixedBoundary(region="bottom")],
		**attributes,
	)
	position, volume = talik.geometry.fillPolygon(corners, spacing)
	if dimension == 3:
		rows = np.arange(0.25 * spacing, 2, 0.5 * spacing)
		position = np.array([(x, y, z) for y in rows for x, z in position])
		volume = np.tile(volume, len(rows)) * 0.5 * spacing
	velocity = np.zeros_like(position)
	velocity[:, 0] = 0.2 * position[:, -1]
	mpm.addPoints(position=position, volume=volume, temperature=-5, velocity=velocity)
	O.engines = [mpm]
	return mpm


def scene(name):
	import talik

	def discs(grains=100):
		return [talik.rve.pack(talik.rve.prepare(grains=grains))]

	makers = {
		"samples": lambda: ground(outline, discs()),
		"paper": lambda: ground(outline, discs(400), spacing=0.2),
		"twice": lambda: ground(mirrored, discs()),
		"law": lambda: ground(outline, spacing=0.125),
		"spaceLaw": lambda: ground(outline, dimension=3, spacing=0.5),
		"bandsLaw": lambda: ground(outline, spacing=0.025, distribute="ground" if talik.ranks.count > 1 else "none"),
		"bandsSamples": lambda: ground(outline, discs(), spacing=0.25, distribute="ground" if talik.ranks.count > 1 else "none"),
		"space": lambda: ground(outline, [talik.rve.pack(talik.rve.prepare(grains=100, dimension=3, ice=True))], dimension=3, spacing=1.0),
	}
	return makers[name]()


def inside(folder, name, steps):
	import hashlib
	import time

	import talik
	from yade import O

	mpm = scene(name)
	sampled = not name.lower().endswith("law")
	counters = lambda: mpm.skeleton.cost() if sampled else {"seconds": 0, "calls": 0, "steps": 0}
	O.run(settleInBands if name == "bandsSamples" else settle, True)
	before, traffic = counters(), talik.ranks.traffic()
	wall, processor = time.monotonic(), time.process_time()
	O.run(steps, True)
	wall, processor = time.monotonic() - wall, time.process_time() - processor
	memory = int(Path("/proc/self/statm").read_text().split()[1]) * os.sysconf("SC_PAGE_SIZE")
	after, sent = counters(), talik.ranks.traffic()
	state = hashlib.sha256(b"".join(mpm.field(name).tobytes() for name in mpm.fieldNames())).hexdigest()
	result = {"wall": wall, "processor": processor, "state": state, "points": mpm.pointCount, "inSamples": after["seconds"] - before["seconds"]}
	result["memory"] = memory
	result.update({name: after[name] - before[name] for name in ("calls", "steps")})
	result.update({name: sent[name] - traffic[name] for name in sent})
	result.update({"balance": after.get("balance", 1), "moved": after.get("moved", 0)})
	(Path(folder) / f"{talik.ranks.rank}.json").write_text(json.dumps(result))


def record(name, steps, file):
	"""Processor time of each step [s], and the DEM steps that each sample took in it. Where the file is there already, from a run of the same
	steps, the lesser time of each step stays: other programs can only add to it."""
	import time

	import numpy as np
	import talik

	mpm = scene(name)

	def stepsOfSamples():
		return np.array([mpm.skeleton.sample(point).statistics()["steps"] for point in range(mpm.pointCount)], dtype=np.int64)

	talik.runSerially(settle)
	seconds, taken, last = [], [], stepsOfSamples()
	for _ in range(steps):
		begin = time.thread_time()
		talik.runSerially(1)
		seconds.append(time.thread_time() - begin)
		now = stepsOfSamples()
		taken.append(now - last)
		last = now
	taken = np.array(taken, dtype=np.int32)
	if Path(file).exists():
		with np.load(file) as before:
			if not np.array_equal(before["taken"], taken):
				raise SystemExit(f"ranks.py: {file} holds another run; delete it")
			seconds = np.minimum(seconds, before["seconds"])
	np.savez_compressed(file, seconds=seconds, taken=taken, dimension=mpm.dimension)


if sys.argv[1:2] == ["--inside"]:
	inside(sys.argv[2], sys.argv[3], int(sys.argv[4]))
elif sys.argv[1:2] == ["--record"]:
	record(sys.argv[2], int(sys.argv[3]), sys.argv[4])
elif __name__ == "__main__":
	main()
