# SPDX-License-Identifier: GPL-2.0-or-later
"""A small Case I with samples on one and two ranks, and on one and two threads, in turn:

	/usr/bin/python3 scripts/benchmarks/ranks.py ranks.json [--rounds 3] [--steps 300] [--spacing 0.5] [--grains 100]

Each run is a yade of its own that does the same steps of a frozen slope whose samples follow a shear. Processor time does not depend on
what else the machine does; wall time does, and is given as the best of the rounds."""

import argparse
import json
import os
import subprocess
import sys
import tempfile
from pathlib import Path

import figures

settle = 40  # steps before time is taken: samples get states of their own, and the first deal


def command(ranks, threads, *arguments):
	start = ["mpirun", "-n", str(ranks), "--bind-to", "none", "--oversubscribe", *(["--allow-run-as-root"] if os.geteuid() == 0 else [])]
	return [*(start if ranks > 1 else []), "yade", "-n", "-x", f"-j{threads}", __file__, *map(str, arguments)]


def measured(ranks, threads, options):
	"""What each rank of one run says of the timed steps."""
	with tempfile.TemporaryDirectory() as folder:
		subprocess.run(
			command(ranks, threads, "--inside", folder, options.steps, options.spacing, options.grains), check=True, timeout=1800, capture_output=True
		)
		return [json.loads((Path(folder) / f"{rank}.json").read_text()) for rank in range(ranks)]


def main():
	parser = argparse.ArgumentParser(description=__doc__)
	parser.add_argument("file")
	parser.add_argument("--rounds", type=int, default=3)
	parser.add_argument("--steps", type=int, default=300)
	parser.add_argument("--spacing", type=float, default=0.5)
	parser.add_argument("--grains", type=int, default=100)
	options = parser.parse_args()
	kinds = {"1 rank": (1, 1), "2 ranks": (2, 1), "2 threads": (1, 2)}
	best = {}
	for ranks, own in zip(kinds, figures.interleaved(options.rounds, *(lambda kind=kind: measured(*kind, options) for kind in kinds.values()))):
		best[ranks] = {
			"wall": min(max(rank["wall"] for rank in run) for run in own),
			"work": min(max(rank["processor"] - rank["polling"] for rank in run) for run in own),
			"run": own[0],
		}
	first, alone = best["2 ranks"]["run"][0], best["1 rank"]["run"][0]
	steps = options.steps
	if {rank["state"] for kind in best.values() for rank in kind["run"]} != {alone["state"]}:
		raise SystemExit("ranks.py: the runs did not end with the same bits")
	per = {"points": first["points"], "calls a step": first["calls"] / steps, "ms a step": 1e3 * alone["wall"] / steps}
	figures.write(
		options.file,
		[
			figures.Figure(
				"work of one rank over that of the busier of two, by processor time", best["1 rank"]["work"] / best["2 ranks"]["work"], "x", aim=1.8, terms=per
			),
			figures.Figure("part of the time of one rank that is in samples", alone["inSamples"] / alone["wall"]),
			figures.Figure("balance: mean over largest cost of the ranks", first["balance"], terms={"states moved": first["moved"]}),
			figures.Figure("messages a step", first["messages"] / steps),
			figures.Figure("sent by a rank in a step", max(rank["bytes"] for rank in best["2 ranks"]["run"]) / steps / 1e3, "kB"),
			figures.Figure("speed of two ranks, wall time", best["1 rank"]["wall"] / best["2 ranks"]["wall"], "x", aim=1.8),
			figures.Figure("speed of two threads, wall time", best["1 rank"]["wall"] / best["2 threads"]["wall"], "x"),
		],
		[
			f"Load of the machine when it ended: {Path('/proc/loadavg').read_text().split()[0]}. Speeds by wall time mean something only where it does nothing else.",
			"Processor time leaves out the waiting for other ranks, and so the cost of messages and of a bad balance within a step.",
			"The ground, all fields of points and samples, had the same bits at the end of all runs.",
		],
	)


# --- inside a yade ---------------------------------------------------------------------------------------------------------


def slope(spacing, grains):
	import numpy as np
	import talik
	from yade import O, wrapper

	outline = [(0, 0), (10, 0), (10, 1), (6, 1), (3, 4), (0, 4)]  # of Case I [m]
	mpm = wrapper.MpmEngine(
		gridSpacing=spacing,
		lower=(0, 0),
		upper=(10, spacing * round(4 / spacing + 4)),
		gravity=(0, -9.81),
		damping=0.02,
		skeleton=wrapper.RveSkeleton(samples=[talik.rve.pack(talik.rve.prepare(grains=grains))]),
		heat=wrapper.HeatTransfer(thermalTimeScale=8.64e5),
		freezing=wrapper.FreezingCurve(),
		water=wrapper.PoreWater(),
		boundaries=[wrapper.RollerBoundary(region="left"), wrapper.RollerBoundary(region="right"), wrapper.FixedBoundary(region="bottom")],
	)
	position, volume = talik.geometry.fillPolygon(outline, spacing)
	mpm.addPoints(position=position, volume=volume, temperature=-5, velocity=np.stack([0.2 * position[:, 1], 0 * position[:, 1]], axis=1))
	O.engines = [mpm]
	return mpm


def inside(folder, steps, spacing, grains):
	import hashlib
	import time

	import talik
	from yade import O

	mpm = slope(spacing, grains)
	O.run(settle, True)
	counters, traffic = mpm.skeleton.counters, talik.ranks.traffic()
	wall, processor = time.monotonic(), time.process_time()
	O.run(steps, True)
	wall, processor = time.monotonic() - wall, time.process_time() - processor
	after, sent = mpm.skeleton.counters, talik.ranks.traffic()
	state = hashlib.sha256(b"".join(mpm.field(name).tobytes() for name in mpm.fieldNames())).hexdigest()
	result = {"wall": wall, "processor": processor, "state": state, "points": mpm.pointCount, "inSamples": after["seconds"] - counters["seconds"]}
	result.update({name: after[name] - counters[name] for name in ("calls", "steps")})
	result.update({name: sent[name] - traffic[name] for name in sent})
	result.update({"balance": after.get("balance", 1), "moved": after.get("moved", 0)})
	(Path(folder) / f"{talik.ranks.rank}.json").write_text(json.dumps(result))


if sys.argv[1:2] == ["--inside"]:
	inside(sys.argv[2], int(sys.argv[3]), float(sys.argv[4]), int(sys.argv[5]))
else:
	main()
