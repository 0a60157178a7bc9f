# SPDX-License-Identifier: GPL-2.0-or-later
"""Consolidation of a saturated column against Terzaghi's closed form for incompressible water."""

import math

import numpy as np
from yade import O, wrapper

import talik
from talik.studies.accuracy import ground
from talik.studies.accuracy.problem import Problem, Stopwatch, groundRun, rootMeanSquare

height, modulus, load, conductivity = 1.0, 10e6, 10e3, 1e-3  # [m], [Pa], [Pa], [m/s]
gravity, waterDensity, porosity = 9.81, 1000.0, 0.4
consolidation = conductivity * modulus / (waterDensity * gravity)  # c_v [m2/s]
timeFactors = (0.1, 0.2, 0.5, 0.8)
heights = (np.arange(8) + 0.5) / 8 * height  # where pressures are compared


def exactPressure(y, timeFactor):
	"""Excess pressure over the load at a height y above the sealed base."""
	k = 2 * np.arange(400) + 1
	terms = (-1.0) ** np.arange(400) / k * np.exp(-(k**2) * math.pi**2 * timeFactor / 4) * np.cos(np.outer(y, k) * math.pi / (2 * height))
	return 4 / math.pi * terms.sum(axis=1)


def loadedColumn(settings):
	"""The water carries the whole load at first."""
	water = settings["bulk modulus of water"]
	mpm = ground.column(
		height,
		settings,
		boundaries=[wrapper.DrainedBoundary(region="surface"), wrapper.SurfaceLoad(region="surface", pressure=load)],
		damping=0.05,
		skeleton=wrapper.ElasticSkeleton(young=modulus, poisson=0),
		water=wrapper.PoreWater(pressure=settings["pore pressure"], conductivity=conductivity, bulkModulus=water, cavitationPressure=-0.01 * water),
	)
	rectangle = talik.geometry.rectangle(0, 0, mpm.gridSpacing, height)
	talik.geometry.fill(mpm, rectangle, pointsPerCell=settings["points per cell"], porosity=porosity, pressure=load)
	return mpm


def run(settings):
	mpm = loadedColumn(settings)
	O.engines = [mpm]
	mpm.initialise()
	watch, answer = Stopwatch(), []
	for factor in timeFactors:
		with watch:
			while O.time < factor * height**2 / consolidation:
				O.step()
		answer += list(_pressures(mpm) / load)
	return groundRun(mpm, answer, watch, O.iter)


def _pressures(mpm):
	"""Pressure at the heights of comparison: cell means, linear in between, zero at the drained top."""
	h = mpm.gridSpacing
	cell = np.floor(mpm.field("position")[:, 1] / h).astype(int)
	cells = np.unique(cell)
	means = [mpm.field("pressure")[cell == c].mean() for c in cells]
	return np.interp(heights, np.append((cells + 0.5) * h, height), np.append(means, 0.0))


problem = Problem(
	name="Terzaghi",
	title="Consolidation of a loaded column, drained at its top",
	norm="rms over 8 heights and T_v = 0.1, 0.2, 0.5, 0.8 of the pressure over the load",
	reference="Terzaghi, incompressible water",
	standard={"cells": 10, **ground.standard, "bulk modulus of water": 2.2e8, "pore pressure": "explicit"},
	sweeps={"cells": (40,), **ground.sweeps, "bulk modulus of water": (2.2e9,)},
	quick={"cells": (5, 20), **ground.quick, "bulk modulus of water": (2.2e7,)},
	pairs=(("cells", "bulk modulus of water"),),
	together=tuple({"cells": cells, "bulk modulus of water": 2.2e9, "pore pressure": "implicit"} for cells in (5, 10, 20)),
	run=run,
	error=rootMeanSquare,
	exact=lambda: np.concatenate([exactPressure(heights, factor) for factor in timeFactors]),
)
