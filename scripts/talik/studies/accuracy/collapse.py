# SPDX-License-Identifier: GPL-2.0-or-later
"""Collapse of a column of frictional ground against the finest run.

The finest run is one with transfer tpic: at 80 cells apic and tpic agree within 0.3 %. At 40 cells the front (98 % of the ground behind it)
of flip is 2 to 3 % behind theirs with picTime = sqrt(h/g), the default. From 40 to 80 cells the front of tpic moves on by 3 %, and by about
two per cent more, were the cells halved again and again."""

import numpy as np
from yade import O, wrapper

import talik
from talik.studies.accuracy import ground
from talik.studies.accuracy.problem import Problem, Stopwatch, groundRun, largestRelative

height, width, end = 1.0, 1.0, 1.2  # [m], [m], [s]


def column(settings):
	h = height / settings["cells"]
	mpm = wrapper.MpmEngine(
		gridSpacing=h,
		lower=(0, 0),
		upper=(h * round(4 / h), h * (round(height / h) + 2)),
		gravity=(0, -9.81),
		**ground.march(settings, h),
		skeleton=wrapper.MohrCoulombSkeleton(young=2e6, youngFrozen=2e6, poisson=0.25, cohesion=50, frictionAngle=30),
		boundaries=[wrapper.RollerBoundary(region="left"), wrapper.FixedBoundary(region="bottom")],
	)
	talik.geometry.fill(mpm, talik.geometry.rectangle(0, 0, width, height), pointsPerCell=settings["points per cell"])
	return mpm


def run(settings):
	mpm = column(settings)
	O.engines = [mpm]
	mpm.initialise()
	watch = Stopwatch()
	with watch:
		while O.time < end:
			O.step()
	x, y = mpm.field("position").T
	weight = mpm.field("volume") / mpm.field("volume").sum()
	return groundRun(mpm, (_quantile(x, weight, 0.98), _quantile(y, weight, 0.98), weight @ x, weight @ y), watch, O.iter)


def _quantile(values, weight, part):
	"""Where all but the outermost two per cent of the ground ends: single points that fly ahead say nothing of it."""
	order = np.argsort(values)
	return np.interp(part, np.cumsum(weight[order]), values[order])


problem = Problem(
	name="column collapse",
	title="Collapse of a dry frictional column, 1 m by 1 m",
	norm="largest of the relative errors of front, crest and centre of mass",
	reference="finest run",
	standard={"cells": 10, **ground.standard},
	sweeps={"cells": (3, 24), **ground.sweeps, "points per cell": (16,)},
	quick={"cells": (5, 20), **ground.quick},
	pairs=(
		("cells", "points per cell"),
		("cells", "transfer"),
		("cells", "PIC time over sqrt(h/g)"),
		("transfer", "time-step fraction"),
		("PIC time over sqrt(h/g)", "time-step fraction"),
	),
	together=({"cells": 20, "transfer": "tpic"},),
	togetherInFull=({"cells": 40, "transfer": "apic"}, {"cells": 40, "transfer": "tpic"}, {"cells": 40, "PIC time over sqrt(h/g)": 1e6}),
	run=run,
	error=largestRelative,
	finest={"cells": 80, "transfer": "tpic"},
	quickFinest={"cells": 40, "transfer": "tpic"},
)
