# SPDX-License-Identifier: GPL-2.0-or-later
"""A sample compressed by 10 % at constant lateral pressure, as accurate as the rate of its motion and the number of its grains.

Beyond one or two per cent of strain two runs of one sample that differ in the last digit find other places for their grains, and small
samples are not alike: single deviators scatter by tens of per cent. The answer is therefore the deviator's mean over parts of the path
and over several packings; eight of them leave a scatter of about a tenth."""

import functools

import numpy as np
from yade import Matrix3

from talik import rve
from talik.studies.accuracy.problem import Problem, Run, Stopwatch, relativeRootMeanSquare

pressure, strain = 50e3, 0.1  # [Pa], [-]
parts = (0, 0.003, 0.01, 0.02, 0.05, 0.1)  # of the path, limits in axial strain [-]
packings = 8
stiffness = 30e6  # order of magnitude of a thawed sample's, for the control of the lateral pressure [Pa]


@functools.lru_cache(maxsize=None)
def packed(grains, seed):
	return rve.pack(rve.prepare(grains=grains, seed=seed))


def path(sample, inertialNumber, strainOfCall):
	"""Deviator over lateral pressure, means over the parts of the path, and DEM steps."""
	sample.maxInertialNumber, sample.maxStrainPerStep = inertialNumber, 1e-4
	calls = int(round(strain / strainOfCall))
	deviator, steps, lateral, integral = [], 0, sample.stress[0], 0.0
	for _ in range(calls):
		error = (-pressure - lateral) / stiffness
		integral += 0.05 * error
		across = max(-3 * strainOfCall, min(3 * strainOfCall, 0.4 * error + integral))
		result = sample.apply(Matrix3(across, 0, 0, 0, -strainOfCall, 0, 0, 0, 0), 0.0)
		lateral, axial, _ = result["stress"]
		steps += result["steps"]
		deviator.append((lateral - axial) / pressure)
	limits = [int(round(part * calls / strain)) for part in parts if part <= strain]
	return [np.mean(deviator[begin:end]) for begin, end in zip(limits, limits[1:])], steps


def run(settings):
	watch, paths, steps, memory = Stopwatch(), [], 0, 0
	for packing in range(packings):
		sample = packed(settings["grains"], 1 + 40 * packing).copy()
		if not sample.servo(-pressure, -pressure):
			raise RuntimeError(f"a sample of {settings['grains']} grains does not reach {pressure:g} Pa")
		with watch:
			deviator, taken = path(sample, settings["inertial number"], settings["strain of a call"])
		paths.append(deviator)
		steps += taken
		memory = max(memory, len(sample.stateBytes))
	mean = np.mean(paths, axis=0).tolist()
	return Run(mean, watch.wall / packings, watch.cpu / packings, memory, settings["grains"], steps // packings)


problem = Problem(
	name="biaxial sample",
	title="Thawed sample, biaxial compression to 10 %",
	norm="rms over five parts of the path of the mean deviator of 8 packings, over that of the reference",
	reference="finest run",
	standard={"grains": 100, "inertial number": 5e-3, "strain of a call": 1e-4},
	sweeps={"grains": (60, 150, 200, 400), "inertial number": (2e-2, 1e-3, 1e-4), "strain of a call": (2e-5, 5e-4)},
	quick={"grains": (60, 100, 200), "inertial number": (5e-4, 5e-3, 1e-2), "strain of a call": (2e-4,)},
	pairs=(("grains", "inertial number"),),
	together=({"grains": 200, "inertial number": 5e-4}, {"grains": 400, "inertial number": 5e-4}, {"grains": 400, "inertial number": 2e-4}),
	run=run,
	error=relativeRootMeanSquare,
	finest={"grains": 400, "inertial number": 1e-4},
)
