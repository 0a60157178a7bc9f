# SPDX-License-Identifier: GPL-2.0-or-later
"""What a packed sample takes from the scene that it comes from: its ice or none, a time step that ice does not break, copies that are whole."""

import copy
import math
import pickle

import numpy as np
import pytest
from fixtures import sixty, sixtyWithoutIce
from yade import Matrix3, O, wrapper

import talik
from talik import rve


@pytest.fixture(scope="module")
def plainFile(sampleCache):
	"""Grains of YADE's FrictMat, as stock YADE saves them."""
	return rve.prepare(**sixtyWithoutIce, cache=sampleCache)


@pytest.fixture(scope="module")
def icyFile(sampleCache):
	return rve.prepare(**sixty, cache=sampleCache)


def still(sample, saturation=1.0, steps=2000):
	sample.freeze(saturation)
	sample.advance(Matrix3.Zero, steps)
	return sample.statistics()


def test_plain_grains_stay_frictional_when_water_freezes_packed_as_open(plainFile):
	packed, opened = rve.pack(plainFile), wrapper.OpenRveSample(source=rve.openScene(plainFile))
	contacts, before = packed.statistics()["contacts"], np.array(packed.stress)
	statistics = still(packed)
	opened.freeze(1)
	print(
		f"{contacts} contacts before; frozen packed {statistics['bondsFormed']} bonds, open "
		f"{opened.statistics()['bondsFormed']}; stress changes by {np.abs(np.array(packed.stress) - before).max():.1e} "
		"Pa"
	)
	assert statistics["bondsFormed"] == opened.statistics()["bondsFormed"] == 0
	assert statistics["contacts"] == contacts and np.allclose(packed.stress, before, atol=1)
	bothWays = dict(minSteps=200, maxStrainPerStep=1.0, maxInertialNumber=1e9)
	packed, opened = rve.pack(plainFile), wrapper.OpenRveSample(source=rve.openScene(plainFile), **bothWays)
	for name, value in bothWays.items():
		setattr(packed, name, value)
	strain = 1e-3 * Matrix3(0.2, 1, 0, -0.4, -0.5, 0, 0, 0, 0)
	one, other = packed.apply(strain, 0.7)["stress"], opened.apply(strain, 0.7)["stress"]
	error = max(abs(one[0] - other[0, 0]), abs(one[1] - other[1, 1])) / 100e3
	print(f"strained at S_i 0.7, packed and open differ by {error:.1e} of the stress")
	assert error < 1e-8


def test_bonds_hold_in_a_sample_at_rest_however_its_scene_became_one(icyFile):
	ways = {
		"pack(file)": lambda scene: rve.pack(icyFile),
		"pack(Scene)": rve.pack,
		"RveSample.fromScene": wrapper.RveSample.fromScene,
		"RveSkeleton(scenes=)": lambda scene: behindPoint(scene),
	}
	for way, make in ways.items():
		with talik.scratchScene():
			rve.openFile(icyFile.path)
			scene = O._sceneObj
		sample = make(scene)
		statistics = still(sample)
		print(f"{way}: dt {sample.dt:.3e} s, {statistics['bondsFormed']} bonds formed, {statistics['bondsBroken']} broken at rest")
		assert statistics["bondsFormed"] > 60 and statistics["bondsBroken"] == 0


def behindPoint(scene):
	O.reset()
	skeleton = wrapper.RveSkeleton(scenes=[scene])
	mpm = wrapper.MpmEngine(gridSpacing=0.5, lower=(0, 0), upper=(0.5, 0.5), skeleton=skeleton)
	mpm.addPoints(position=[(0.25, 0.25)], volume=[0.25])
	mpm.initialise()
	return skeleton.sample(0)


def test_bonds_hold_in_an_open_sample_made_of_a_scene(icyFile):
	with talik.scratchScene():
		rve.openFile(icyFile.path)
		scene = O._sceneObj
	sample = wrapper.OpenRveSample(source=scene)
	sample.freeze(1)
	sample.apply(Matrix3.Zero, 0.98)
	sample.apply(Matrix3.Zero, 1)
	statistics = sample.statistics()
	print(f"{statistics['bondsFormed']} bonds formed, {statistics['bondsBroken']} broken")
	assert statistics["bondsFormed"] > 60 and statistics["bondsBroken"] == 0


def test_a_time_step_lowered_for_ice_is_not_lowered_again(icyFile):
	packed = rve.pack(icyFile)
	again = wrapper.RveSample.fromScene(packed.open())
	with talik.scratchScene():
		rve.openFile(icyFile.path)
		free = O.dt
	print(f"{free:.4e} s without ice, {packed.dt:.4e} s with (over sqrt(6): {free / math.sqrt(6):.4e} s), {again.dt:.4e} s packed again")
	assert packed.dt == again.dt == pytest.approx(free / math.sqrt(6), rel=1e-12)


wrong = {
	"nan to freeze": (lambda s: s.freeze(float("nan")), "RveSample.freeze: iceSaturation is nan"),
	"7 to freeze": (lambda s: s.freeze(7), "RveSample.freeze: iceSaturation is 7"),
	"-0.1 to apply": (lambda s: s.apply(Matrix3.Zero, -0.1), "RveSample.apply: iceSaturation is -0.1"),
	"tension to servo": (lambda s: s.servo(-1e3, 1e3), "RveSample.servo: stressY is 1000"),
	"nan to servo": (lambda s: s.servo(float("nan"), -1e3), "RveSample.servo: stressX is nan"),
	"infinite dt": (lambda s: setattr(s, "dt", math.inf), "RveSample.dt is inf"),
	"negative thawed strength": (lambda s: setattr(s, "thawedStrength", -1), "RveSample.thawedStrength is -1"),
	"no thawed strength": (lambda s: setattr(s, "thawedStrength", float("nan")), "RveSample.thawedStrength is nan"),
	"nan to an open sample": (lambda s: wrapper.OpenRveSample(source=s.open()).freeze(float("nan")), "iceSaturation is nan"),
	**{f"radiusRatio {value}": (lambda s, value=value: wrapper.IceBondMat(radiusRatio=value), "IceBondMat.radiusRatio is") for value in (0.0, -1.0, math.nan)},
	**{
		f"{name} infinite": (lambda s, name=name: wrapper.IceBondMat(**{name: math.inf}), f"IceBondMat.{name} is inf")
		for name in ("iceYoung", "tensileStrength", "iceShearStrength", "exponent", "bondAreaFactor", "bondRange", "thawedStrength")
	},
}


@pytest.mark.parametrize("case", wrong)
def test_values_without_sense_are_refused_by_name(icyFile, case):
	sample = rve.pack(icyFile)
	before = sample.stateBytes
	act, sentence = wrong[case]
	with pytest.raises(ValueError) as refusal:
		act(sample)
	print(refusal.value)
	assert sentence in str(refusal.value) and sample.stateBytes == before


# ---- copies ---------------------------------------------------------------------------------------------------------------


def pickled(thing):
	return pickle.loads(pickle.dumps(thing))


@pytest.mark.parametrize("copied", (copy.deepcopy, copy.copy, pickled))
def test_a_copied_sample_goes_on_as_the_original_bit_for_bit(icyFile, copied):
	sample = rve.pack(icyFile)
	sample.freeze(0.6)
	sample.minSteps = 20
	other = copied(sample)
	for s in (sample, other):
		s.apply(1e-3 * Matrix3(0, 1, 0, 0, 0, 0, 0, 0, 0), 0.5)
	assert other.stateBytes == sample.stateBytes and other.minSteps == 20
	with talik.inspect(other.open()):
		assert len(O.bodies) == 60


@pytest.mark.parametrize("copied", (copy.deepcopy, pickled))
@pytest.mark.parametrize("steps", (0, 5))
def test_a_copied_engine_goes_on_as_the_original_bit_for_bit(icyFile, copied, steps):
	O.reset()
	mpm = wrapper.MpmEngine(
		gridSpacing=0.5,
		lower=(0, 0),
		upper=(1, 1.5),
		gravity=(0, -9.81),
		skeleton=wrapper.RveSkeleton(samples=[rve.pack(icyFile)]),
		heat=wrapper.HeatTransfer(thermalTimeScale=1e6),
		freezing=wrapper.FreezingCurve(),
		boundaries=[wrapper.RollerBoundary(region=side) for side in ("left", "right", "bottom")],
	)
	talik.geometry.fill(mpm, talik.geometry.rectangle(0, 0, 1, 1), temperature=-2)
	O.engines = [mpm]
	talik._talik.runSerially(steps)
	other = copied(mpm)
	ends, dt = [], O.dt
	for engine in (mpm, other):
		O.engines = [engine]
		O.dt = dt
		talik._talik.runSerially(5)
		ends.append({name: engine.field(name) for name in ("position", "stress", "temperature")})
	difference = max(np.abs(ends[0][name] - ends[1][name]).max() for name in ends[0])
	print(f"copied after {steps} steps; 5 steps later the copies differ by {difference:.1e}")
	assert difference == 0 and other is not mpm


def test_a_damaged_pickle_is_refused(icyFile):
	data = bytearray(pickle.dumps(rve.pack(icyFile)))
	data[len(data) // 2] ^= 1
	with pytest.raises(ValueError, match="RveSample .* damaged"):
		pickle.loads(bytes(data))


# ---- strength that stays when the ice has gone ----------------------------------------------------------------------------

loading = Matrix3(0.2, 1, 0, -0.4, -0.5, 0, 0, 0, 0)
settings = dict(minSteps=300, maxStrainPerStep=1.0, maxInertialNumber=1e9)  # the same number of steps in both forms


def icy(icyFile, thawedStrength):
	"""Bonds weak enough to break early."""
	with talik.inspect(rve.pack(icyFile).open()):
		material = O.materials[0]
		material.iceTensileStrength = material.iceShearStrength = 2e6
		material.tensileStrength = material.shearStrength = 1e5
		sample = wrapper.RveSample.fromScene(O._sceneObj)
	sample.thawedStrength = thawedStrength
	for name, value in settings.items():
		setattr(sample, name, value)
	return sample


def test_bonds_that_outlast_their_ice_do_so_alike_packed_open_and_stored(icyFile):
	packed = icy(icyFile, 3e5)
	seen = dict(bondsIntact=0, brokenThawed=0, bondsFormed=0)
	for strain, saturation in (
		(0, 1),
		(1e-3, 1),
		(1e-3, 0.5),
		(1e-3, 0.03),
		(5e-4, 0.02),
		(5e-4, 0.01),
		(5e-4, 0),
		(1e-3, 0),
		(1e-3, 0.04),
		(5e-4, 0.3),
		(1e-3, 0.9),
		(1e-3, 0),
	):
		opened, stored = wrapper.OpenRveSample(source=packed.open(), **settings), pickled(packed)
		before = packed.statistics()
		byPacked, byYade, byStored = (
			packed.apply(strain * loading, saturation),
			opened.apply(strain * loading, saturation),
			stored.apply(strain * loading, saturation),
		)
		stress = byYade["stress"]
		error = np.abs(np.subtract(byPacked["stress"], (stress[0, 0], stress[1, 1], stress[0, 1]))).max() / np.abs(byPacked["stress"]).max()
		one, other = packed.statistics(), opened.statistics()
		lost = one["bondsBrokenInTension"] + one["bondsBrokenInShear"] - before["bondsBrokenInTension"] - before["bondsBrokenInShear"]
		print(
			f"strain {strain:g} at S_i {saturation:g}: {lost} / {other['bondsBroken']} broken, {one['bondsMelted']} / {other['bondsMelted']} melted, "
			f"{one['bondsIntact']} / {other['bondsIntact']} intact, {one['contacts']} / {other['contacts']} contacts, stress differs by {error:.1e}"
		)
		assert (lost, one["bondsMelted"], one["bondsIntact"], one["contacts"]) == (
			other["bondsBroken"],
			other["bondsMelted"],
			other["bondsIntact"],
			other["contacts"],
		)
		assert error < 1e-8 and stored.stateBytes == packed.stateBytes and byStored == byPacked
		if saturation == 0:
			seen["bondsIntact"] += one["bondsIntact"]
			seen["brokenThawed"] += lost
			assert packed.arrays()["bond"].max() <= 1  # what breaks without ice is frictional, and bonds again when ice grows
		seen["bondsFormed"] += other["bondsFormed"] - before["bondsIntact"] if strain else 0
	print(seen)
	assert min(seen.values()) > 5


def test_without_a_thawed_strength_samples_go_on_as_before(icyFile):
	sample = icy(icyFile, 0)
	sample.freeze(1)
	sample.freeze(0)
	statistics = sample.statistics()
	assert statistics["bondsIntact"] == 0 and statistics["bondsMelted"] == statistics["bondsFormed"] > 60
	never = icy(icyFile, 3e5)
	plain = icy(icyFile, 0)
	for s in (never, plain):  # never frozen: there is no bond that could stay
		s.apply(1e-3 * loading, 0)
	assert never.stress == plain.stress
