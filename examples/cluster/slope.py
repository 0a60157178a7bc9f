# SPDX-License-Identifier: GPL-2.0-or-later
"""A thawing slope with samples, as a job of a cluster: in one process, on ranks, or as one of many runs of a table.

	yade -n -x slope.py [FOLDER]

It goes on from its checkpoint in FOLDER (default output) if there is one, and leaves what came of it in a file of JSON."""

import signal
import sys
from pathlib import Path

import talik
from yade import O, utils, wrapper

utils.readParamsFromTable(warming=8.0, grains=50, spacing=0.5, seconds=2.0, noTableOk=True)  # [°C], -, [m], [s of motion]
from yade.params import table

folder = Path(sys.argv[1] if len(sys.argv) > 1 else "output")
name = f"warming{table.warming:g}_grains{table.grains:g}_spacing{table.spacing:g}_seconds{table.seconds:g}"
checkpoint, result = folder / f"{name}.checkpoint", folder / f"{name}.json"


def slope():
	mpm = wrapper.MpmEngine(
		gridSpacing=table.spacing,
		lower=(0, 0),
		upper=(10, table.spacing * round(4 / table.spacing + 4)),
		gravity=(0, -9.81),
		damping=0.02,
		skeleton=wrapper.RveSkeleton(samples=[talik.rve.pack(talik.rve.prepare(grains=table.grains))]),
		heat=wrapper.HeatTransfer(thermalTimeScale=8.64e5),
		freezing=wrapper.FreezingCurve(),
		water=wrapper.PoreWater(),
		boundaries=[
			wrapper.RollerBoundary(region="left"),
			wrapper.RollerBoundary(region="right"),
			wrapper.FixedBoundary(region="bottom"),
			wrapper.SurfaceTemperature(region="surface", times=[0], values=[table.warming]),
		],
	)
	talik.geometry.fill(mpm, [(0, 0), (10, 0), (10, 1), (6, 1), (3, 4), (0, 4)], temperature=-1)
	O.engines = [mpm]
	return mpm


if not result.exists():
	mpm = talik.resume(checkpoint) if checkpoint.exists() else slope()
	talik.checkpoint.keep(checkpoint, every=600, onSignal=signal.SIGUSR1)
	talik.runUntil(table.seconds)
	displacement = mpm.field("displacement")
	talik.output.writeSummary(
		result,
		seconds=O.time,
		steps=O.iter,
		ranks=talik.ranks.count,
		largestDisplacement=float((displacement**2).sum(axis=1).max() ** 0.5),
		bondsMelted=float(mpm.field("bondsMelted").sum()),
		bondsBroken=float(mpm.field("bondsBroken").sum()),
	)
