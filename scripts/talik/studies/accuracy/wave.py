# SPDX-License-Identifier: GPL-2.0-or-later
"""Standing wave in an elastic column against the wave equation."""

import math

import numpy as np
from yade import O, wrapper

import talik
from talik.studies.accuracy import ground
from talik.studies.accuracy.problem import Problem, Stopwatch, groundRun, rootMeanSquare

length, modulus, speed, porosity = 10.0, 50e6, 0.1, 0.4  # [m], [Pa], largest initial velocity [m/s]
celerity = math.sqrt(modulus / (2650.0 * (1 - porosity)))
period = 4 * length / celerity
amplitude = speed * period / (2 * math.pi)
instants = np.linspace(0, 2, 41)[1:]  # in periods


def standingColumn(settings):
	"""Fixed below, free above, first mode, no gravity."""
	mpm = ground.column(length, settings, skeleton=wrapper.ElasticSkeleton(young=modulus, poisson=0))
	rectangle = talik.geometry.rectangle(0, 0, mpm.gridSpacing, length)
	position, volume = talik.geometry.fillPolygon(rectangle, mpm.gridSpacing, settings["points per cell"])
	mode = np.sin(math.pi * position[:, 1] / (2 * length))
	mpm.addPoints(position=position, volume=volume, porosity=porosity, velocity=np.stack([0 * mode, speed * mode], axis=1))
	return mpm, mode


def run(settings):
	mpm, mode = standingColumn(settings)
	O.engines = [mpm]
	mpm.initialise()
	mass, watch, answer = mpm.field("volume"), Stopwatch(), []
	for instant in instants * period:
		with watch:
			while O.time < instant - 0.5 * O.dt:
				O.step()
		moved = np.sum(mass * mode * mpm.field("displacement")[:, 1]) / np.sum(mass * mode**2)
		answer.append(moved / amplitude - math.sin(2 * math.pi * O.time / period))
	return groundRun(mpm, answer, watch, O.iter)


problem = Problem(
	name="elastic wave",
	title="Two periods of a standing wave in an elastic column",
	norm="rms over 40 instants of the first mode's displacement over its amplitude",
	reference="wave equation",
	standard={"cells": 20, **ground.standard},
	sweeps={"cells": (80,), **ground.sweeps},
	quick={"cells": (5, 10, 40), **ground.quick},
	pairs=(("cells", "PIC time over sqrt(h/g)"), ("cells", "time-step fraction")),
	run=run,
	error=rootMeanSquare,
	exact=lambda: np.zeros(len(instants)),
)
