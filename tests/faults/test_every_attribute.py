# SPDX-License-Identifier: GPL-2.0-or-later
"""Every attribute of a ground and of all that it holds, set to values without sense before the first step and after some: each is
answered by a sentence, or the ground takes it and stays finite. Python lives on: all of it happens in this one process."""

import re

import numpy as np
import pytest
from yade import O, utils, wrapper

import talik

nan, inf = float("nan"), float("inf")
senseless = [nan, inf, -inf, -1, 1e300, -1e300, 1e-300, 2.5, 10**30, "text", None, [], [nan], (nan, nan), object()]
everyday = {0: [nan, -1, 1e300, 1e-300, "text", None], 2: [nan, -1]}  # by the steps before; of the slow tests all, and the first four


def soft(step):
	step.stress += 1e6 * step.strain


def calm(nodes):
	return 0 * nodes.velocity


boundaries = {
	"FixedBoundary": dict(region="bottom"),
	"RollerBoundary": dict(region="left"),
	"MovingBoundary": dict(region="right", speed=1e-3),
	"SurfaceTemperature": dict(region="surface", temperature=5),
	"SurfaceLoad": dict(region="surface", pressure=10),
	"DrainedBoundary": dict(region="surface"),
	"WallTemperature": dict(region="bottom", temperature=-1),
	"HeatFlux": dict(region="left", flux=1),
	"HeatSource": dict(region="box", power=5),
	"WaterFlux": dict(region="left"),
	"PythonBoundary": dict(region="surface", gives="traction", function=calm),
	"BodyTemperature": dict(bodies=[0], temperature=3),
}


def everything(sample):
	"""Ground with every effect, six skeletons and a body above it: what it holds, by name."""
	O.reset()
	held = dict(
		material=wrapper.GroundMaterial(),
		heat=wrapper.HeatTransfer(thermalTimeScale=1e6),
		freezing=wrapper.FreezingCurve(),
		water=wrapper.PoreWater(),
		segregation=wrapper.IceSegregation(),
		bodies=wrapper.BodyContact(),
	)
	skeletons = [wrapper.RveSkeleton(samples=[sample.copy()], strainTolerance=2e-5), wrapper.ElasticSkeleton(), wrapper.MohrCoulombSkeleton()]
	skeletons += [wrapper.CreepingSkeleton(), wrapper.BinghamSkeleton(), wrapper.PythonSkeleton(law=soft, modulus=1e7, states=["strain"], statesAtStart=[0])]
	others = [wrapper.BulkViscosity(viscosity=10)]
	conditions = [getattr(wrapper, name)(**settings) for name, settings in boundaries.items()]
	mpm = wrapper.MpmEngine(
		gridSpacing=0.5,
		lower=(0, 0),
		upper=(2, 3),
		gravity=(0, -9.81),
		damping=0.1,
		energyLedger=True,
		skeletons=skeletons,
		boundaries=conditions,
		effects=others,
		**held,
	)
	position, volume = talik.geometry.fillPolygon(talik.geometry.rectangle(0, 0, 1, 1), 0.5)
	mpm.addPoints(position=position, volume=volume, temperature=-1.0, skeleton=[min(5, k // 3) for k in range(len(position))])
	O.bodies.append(utils.sphere((0.5, 1.3, 0), 0.2))
	O.engines = [wrapper.ForceResetter(), mpm, wrapper.NewtonIntegrator(gravity=(0, -9.81, 0))]
	return {type(part).__name__: part for part in [mpm, *held.values(), *skeletons, *conditions, *others]}


names = [
	"MpmEngine",
	"GroundMaterial",
	"HeatTransfer",
	"FreezingCurve",
	"PoreWater",
	"IceSegregation",
	"BodyContact",
	"RveSkeleton",
	"ElasticSkeleton",
	"MohrCoulombSkeleton",
	"CreepingSkeleton",
	"BinghamSkeleton",
	"PythonSkeleton",
	"BulkViscosity",
	*boundaries,
]


def answer(sample, name, attribute, value, stepsBefore):
	"""The sentence, or None if the ground ran."""
	part = everything(sample)[name]
	talik._talik.runSerially(stepsBefore)
	try:
		setattr(part, attribute, value)
		talik._talik.runSerially(2)
	except (ValueError, TypeError, AttributeError, RuntimeError, OSError) as refusal:
		return " ".join(str(refusal).split())
	mpm = O.engines[1]
	for field in ("position", "velocity", "stress", "temperature", "pressure", "volume", "porosity"):
		assert np.isfinite(mpm.field(field)).all(), f"{name}.{attribute} = {value!r}: {field}"
	assert all(np.isfinite(np.array(value)).all() for value in mpm.balance().values()), f"{name}.{attribute} = {value!r}: balance"


def checkAnswers(name, stepsBefore, values, sample):
	attributes = sorted(everything(sample)[name].dict())
	if name in boundaries and name != "SurfaceTemperature":  # what all boundaries have is asked of one
		attributes = [attribute for attribute in attributes if attribute not in ("region", "lower", "upper")]
	refused = taken = 0
	for attribute in attributes:
		for value in values:
			sentence = answer(sample, name, attribute, value, stepsBefore)
			if sentence is None:
				taken += 1
				continue
			refused += 1
			# another attribute is named where the two contradict each other, and the state where only that shows how large a number was
			assert attribute in sentence or re.search(
				r"\w+ (=|is|has) |^material point \d+ at|has no setter|no ground there", sentence
			), f"{name}.{attribute} = {value!r}: {sentence}"
	print(f"{name}, {stepsBefore} steps before: {len(attributes)} attributes, {refused} values refused, {taken} taken")
	assert refused > 0


@pytest.mark.parametrize("stepsBefore", (0, 2))
@pytest.mark.parametrize("name", names)
def test_senseless_values_of_every_attribute_are_answered_by_a_sentence_or_do_no_harm(name, stepsBefore, smallSample):
	checkAnswers(name, stepsBefore, everyday[stepsBefore], smallSample)


@pytest.mark.parametrize("stepsBefore", (0, 2))
@pytest.mark.parametrize("name", names)
def test_more_senseless_values_of_every_attribute_are_answered_by_a_sentence_or_do_no_harm_slow(name, stepsBefore, smallSample):
	checkAnswers(name, stepsBefore, senseless if stepsBefore == 0 else senseless[:4], smallSample)
