# SPDX-License-Identifier: GPL-2.0-or-later
"""Friction with which samples slip at the thaw front where a scene states none: RveSkeleton asks for it when one of them thaws there first."""

import math

import numpy as np
from yade import Matrix3, wrapper

from talik import _talik
from talik.studies import calibrate

perCall, perCallOpen = 4e-5, 1e-4  # shear of a call [-]; samples that run open move as fast as behind points, which takes a tenth of the steps
leastShear, mostShear, grainsTimesShear = 0.3, 1.0, 100  # of a run: the mean of as many grains over as much shear is equally sure
runsOfPacked, runsOfOpen = 8, 2
known = {}  # scenes that a script makes again and again from the same samples measure them once


def steady(samples, scenes, dimension, threads):
	"""Shear over normal stress in steady simple shear without ice, mean over runs that differ in sample, plane and direction, its standard error from
	their scatter, and how many samples were sheared; and, where more than half of the runs blow up, why. Each run has a pressure of its own, that of
	its sample where that lies between 2 and 50 kPa, else 10 kPa.

	samples    RveSamples
	scenes     YADE scenes that cannot be packed
	dimension  of the ground
	threads    0: as many as yade has; what comes out does not depend on them

	>>> mean, error, sheared, problem = talik.studies._friction.steady([packed], [], 2, 0)"""
	key = (*(sample.stateBytes for sample in samples), *map(_talik.sceneBytes, scenes), dimension, threads)
	if key not in known:
		known[key] = _measured(samples, scenes, dimension, threads)
	return known[key]


def _measured(samples, scenes, dimension, threads):
	sources = len(samples) + len(scenes)
	number = runsOfOpen if scenes else min(runsOfPacked, (4 if dimension == 2 else 8) * sources)
	runs = list(_plan(dimension, sources, number))
	packed = [_run(samples[run[0]], runsOfPacked / number, *run[1:]) for run in runs if run[0] < len(samples)]
	outcomes = [(_friction(shear, normal, perCall), failure) for shear, normal, failure in _talik.shearTests(packed, threads)]
	outcomes += [_ofOpen(scenes[run[0] - len(samples)], dimension, *run[1:]) for run in runs if run[0] >= len(samples)]
	failures = [failure for _, failure in outcomes if failure]
	found = [friction for friction, failure in outcomes if not failure]
	if 2 * len(found) < number:
		return math.nan, math.nan, 0, failures[-1]
	mean = sum(found) / len(found)
	variance = max(0.0, sum(friction * friction for friction in found) / len(found) - mean * mean)
	return mean, math.sqrt(variance / (len(found) - 1)) if len(found) > 1 else 0.0, len({run[0] for run in runs}), ""


def _plan(dimension, sources, number):
	"""(source, along, across, direction) of each run: those that share a sample differ in planes and directions, others in directions only."""
	for r in range(number):
		source = r * sources // number
		variant = r - (source * number + sources - 1) // sources
		across = dimension - 1 - variant // 2 % 2
		yield source, (across + 1 + variant // 4) % dimension, across, -1 if (r if sources > 1 else variant) % 2 else 1


def _run(sample, longer, along, across, direction):
	"""What shearTests takes of a run."""
	tested = sample.copy()
	tested.maxInertialNumber, tested.maxStrainPerStep, tested.minSteps, tested.timeStepFollowsIce = calibrate.quasiStaticFlow, 1e-5, 10, True
	shear = longer * min(mostShear, max(leastShear, grainsTimesShear / len(sample.arrays()["radius"])))
	return tested, direction * perCall, _heldPressure(sample.stress[: sample.dimension]), round(shear / perCall), along, across


def _heldPressure(normalStresses):
	own = -sum(normalStresses) / len(normalStresses)
	return own if 2e3 <= own <= 50e3 else 10e3


def _friction(shearStress, normalStress, perCall):
	"""Of the means over what comes after the first shear."""
	first = round(calibrate.forgottenShear / perCall)
	shear, normal = (np.cumsum(stress[first:])[-1:].sum() for stress in (shearStress, normalStress))
	return float(max(0.0, -shear / normal)) if normal < 0 else 0.0


def _ofOpen(scene, dimension, along, across, direction):
	sample = wrapper.OpenRveSample(source=scene)
	stress, stresses = sample.stress, []
	pressure = _heldPressure([stress[d, d] for d in range(dimension)])
	control = calibrate.NormalStressControl(pressure, perCallOpen, max(100 * pressure, sample.stiffness(across)))
	for _ in range(round(leastShear / perCallOpen)):
		gradient = np.zeros((3, 3))
		gradient[along, across], gradient[across, across] = direction * perCallOpen, control.strain(stress[across, across])
		result = sample.apply(Matrix3(*gradient.ravel()), 0)
		if result["blewUp"]:
			return 0.0, result["reason"] or "it blew up"
		stress = result["stress"]
		stresses.append((direction * stress[along, across], stress[across, across]))
	return _friction(*np.transpose(stresses), perCallOpen), ""
