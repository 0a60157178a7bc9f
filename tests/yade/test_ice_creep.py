# SPDX-License-Identifier: GPL-2.0-or-later
"""Creep of ice bonds: the rate factor, one bond, packed and open samples, an ordinary scene, points of a ground."""

import json
import math
import subprocess
from pathlib import Path

import numpy as np
import pytest
from fixtures import eightySpheres, rollingDiscs, rollingSpheres, sixtySpheres
from yade import Matrix3, O, utils, wrapper

import talik
from frozen_pair import block, frozenPair
from talik import rve
from talik.studies import creep
from twins import withAGrainBeside

radius, young, depth = 5e-3, 3.6e9, 0.1  # E_c at full ice saturation
day = 86400.0

# Cuffey & Paterson 2010, The Physics of Glaciers, section 3.4.6: recommended rate factors [1/(s Pa^3)] over temperature [degC]
recommended = {0: 2.4e-24, -2: 1.7e-24, -5: 9.3e-25, -10: 3.5e-25, -15: 2.1e-25, -20: 1.2e-25, -25: 6.8e-26, -30: 3.7e-26, -40: 1.0e-26}


def test_rate_factors_are_those_recommended_for_glacier_ice():
	law = wrapper.IceCreep()
	error = {temperature: law.rateFactorAt(temperature) / value - 1 for temperature, value in recommended.items()}
	print("\n" + ", ".join(f"{temperature} degC {100 * e:+.1f} %" for temperature, e in error.items()))
	assert max(map(abs, error.values())) < 0.05
	assert law.rateFactorAt(3) == law.rateFactorAt(0)


def stretch(strain):
	return Matrix3(strain, 0, 0, 0, 0, 0, 0, 0, 0)


def force(sample):
	"""Tension of the bonds of a pair [N]."""
	return sample.stress[0] * 10 * radius * depth


def stretched(tension):
	"""A pair whose bonds are under a tension [N]."""
	sample = frozenPair(radius, depth)
	sample.apply(stretch(tension / (young * radius) / (2 * radius)), 1)
	return sample


@pytest.mark.parametrize("exponent", [1.0, 1.8, 3.0, 4.0])
def test_one_bond_relaxes_at_constant_length_by_the_closed_form_of_glens_law(exponent):
	start, law, errors = stretched(600), wrapper.IceCreep(exponent=exponent, rateFactor=(1e-8, 1e-14, 3.5e-25, 1e-32)[[1, 1.8, 3, 4].index(exponent)]), []
	first = force(start)
	stress = first / radius**2
	for time in (0.1, 10, 1e3, 1e5):
		sample = start.copy()
		sample.apply(Matrix3.Zero, 1, law.over(-10, time))
		flown = young * law.rateFactor * stress ** (exponent - 1) * time
		wanted = first * (math.exp(-flown) if exponent == 1 else (1 + (exponent - 1) * flown) ** (-1 / (exponent - 1)))
		errors.append(abs(force(sample) - wanted) / first)
		halves = start.copy()
		for _ in range(2):
			halves.apply(Matrix3.Zero, 1, law.over(-10, time / 2))
		errors.append(abs(force(halves) - wanted) / first)
	print(f"\nn = {exponent:g}: {first:.0f} N, after {time:g} s {force(sample):.3g} N, at once and in two calls within {max(errors):.1e}")
	assert max(errors) < 1e-9 and wanted < 0.7 * first


@pytest.mark.parametrize("exponent, rateFactor", [(1.0, 1e-8), (3.0, 3.5e-25)])
def test_one_bond_under_constant_force_creeps_at_the_rate_of_glens_law(exponent, rateFactor):
	"""Each call restores by elastic stretching what has relaxed; what it stretches is what the bond has crept: A s^n over the length A_b E_c/k_n = R."""
	law, rates = wrapper.IceCreep(exponent=exponent, rateFactor=rateFactor), []
	for tension in (300, 600, 900):
		O.reset()
		sample, crept, calls = stretched(tension), 0.0, 100
		length = 2 * radius + tension / (young * radius)
		stress = force(sample) / radius**2
		step = 2e-4 / (young * rateFactor * stress ** (exponent - 1))
		for _ in range(calls + 1):  # the first has nothing to restore
			strain = (stress * radius**2 - force(sample)) / (young * radius) / length
			sample.apply(stretch(strain), 1, law.over(-10, step))
			crept += strain * length
			length *= 1 + strain
		rates.append(crept / (calls * step))
		wanted = rateFactor * stress**exponent * radius
		print(f"\nn = {exponent:g}, {tension} N: {rates[-1]:.4e} m/s, Glen's law {wanted:.4e} m/s", end="")
		assert rates[-1] == pytest.approx(wanted, rel=0.002)
	slope = np.polyfit(np.log((300, 600, 900)), np.log(rates), 1)[0]
	print(f"; exponent {slope:.4f}")
	assert slope == pytest.approx(exponent, abs=0.001)


def test_ice_hands_the_load_to_the_grains_and_what_stays_is_what_grains_without_ice_carry():
	"""A pair pressed together in ice: in the end the overlap is carried by the stiffness of the grains alone."""
	sample = frozenPair(radius, depth)
	overlap = 300 / (young * radius)
	sample.apply(stretch(-overlap / (2 * radius)), 1)
	before = -force(sample)
	for _ in range(5):
		sample.apply(Matrix3.Zero, 1, wrapper.IceCreep().over(-1, 1e4 * 365 * day))
	grains = 0.6e9 * radius * overlap
	print(f"\n{before:.1f} N with the ice, {-force(sample):.4f} N after, {grains:.4f} N of the grains")
	assert before == pytest.approx(300, rel=1e-3) and -force(sample) == pytest.approx(grains, rel=2e-3)
	assert sample.statistics()["bondsIntact"] == 2


def test_months_cost_no_more_than_a_second():
	start = stretched(600)
	steps = [start.copy().apply(Matrix3.Zero, 1, wrapper.IceCreep().over(-5, time))["steps"] for time in (1, 90 * day)]
	print(f"\nDEM steps of a call: {steps[0]} for a second, {steps[1]} for 90 days, {start.copy().apply(Matrix3.Zero, 1)['steps']} without creep")
	assert steps[0] == steps[1]


# ---- samples --------------------------------------------------------------------------------------------------------------

shear = {2: Matrix3(0, 4e-5, 0, 0, -2e-5, 0, 0, 0, 0), 3: Matrix3(0, 4e-5, 0, 0, -2e-5, 0, 0, 2e-5, 0)}


kinds = {
	"discs": dict(grains=100),
	"spheres": eightySpheres,
	"rolling discs": rollingDiscs,
	"rolling spheres": rollingSpheres,
}


@pytest.fixture(params=kinds)
def frozen(request, sampleCache):
	sample = rve.pack(rve.prepare(ice=True, cache=sampleCache, **kinds[request.param]))
	sample.freeze(1)
	return sample


def stressOf(result, dimension):
	s = result["stress"]
	if isinstance(s, tuple):
		return np.array(s)
	pairs = ((0, 0), (1, 1), (0, 1)) if dimension == 2 else ((0, 0), (1, 1), (2, 2), (1, 2), (0, 2), (0, 1))
	return np.array([s[i, j] for i, j in pairs])


def test_packed_samples_creep_as_open_ones_to_1e9_over_500_steps(frozen):
	law, dimension = wrapper.IceCreep(), frozen.dimension
	bonds, start = frozen.statistics()["bondsIntact"], frozen.copy()
	opened, steps, error = wrapper.OpenRveSample(source=frozen.open()), 0, 0.0
	largest, relaxed = 0.0, 0.0
	for sample in (frozen, opened, start):
		sample.minSteps = 20
	for k in range(24):
		crept = law.over(-5, {2: 3.0, 3: 1.0}[dimension] * (k % 3))  # a call of no time among them
		one, other = frozen.apply(shear[dimension], 1, crept), opened.apply(shear[dimension], 1, crept)
		start.apply(shear[dimension], 1)
		assert one["steps"] == other["steps"]
		steps += one["steps"]
		a, b = stressOf(one, dimension), stressOf(other, dimension)
		largest, relaxed = max(largest, np.abs(a).max()), np.abs(a).max() / np.abs(start.stress).max()
		error = max(error, np.abs(a - b).max())
	left = frozen.statistics()["bondsIntact"]
	print(f"\n{steps} steps: stress differs by {error / largest:.1e}; {relaxed:.2f} of the stress without creep; {left} of {bonds} bonds intact")
	assert steps >= 500 and error < 1e-9 * largest
	assert relaxed < 0.9 and frozen.statistics()["bondsIntact"] == opened.statistics()["bondsIntact"]


def damped(sample, damping):
	"""The sample, packed, with another damping by YADE's NewtonIntegrator."""
	scene = sample.open()
	with talik.inspect(scene):
		O.engines[-1].damping = damping
		return wrapper.RveSample.fromScene(scene)


def test_spheres_that_vibrate_as_they_creep_differ_open_as_twins_do_because_yades_damping_jumps_with_the_sign_of_the_velocity(sampleCache):
	"""The forces that relax set small grains swinging. Under YADE's damping, which jumps with the sign of force times velocity, swinging grains part from
	a twin one unit in the last place beside, some e-fold in 24 steps; with little damping they do not, and packed equals open to 1e-9 for longer, too."""
	apart = {}
	for damping in (0.3, 0.05):
		sample = damped(rve.pack(rve.prepare(**eightySpheres, cache=sampleCache)), damping)
		sample.freeze(1)
		twin, opened, law, steps = withAGrainBeside(sample), wrapper.OpenRveSample(source=sample.open()), wrapper.IceCreep(), 0
		largest = ofTwin = ofOpened = 0.0
		for each in (sample, twin, opened):
			each.minSteps = 20
		for k in range(40):
			crept = law.over(-5, k % 3)
			packed, beside, other = (each.apply(shear[3], 1, crept) for each in (sample, twin, opened))
			steps, largest = steps + packed["steps"], max(largest, np.abs(packed["stress"]).max())
			ofTwin = max(ofTwin, np.abs(np.subtract(packed["stress"], beside["stress"])).max())
			ofOpened = max(ofOpened, np.abs(packed["stress"] - stressOf(other, 3)).max())
		apart[damping] = ofTwin / largest, ofOpened / largest
		print(f"\ndamping {damping:g}: after {steps} steps a twin differs by {apart[damping][0]:.1e}, open from packed by {apart[damping][1]:.1e}", end="")
	assert max(apart[0.05]) < 1e-9
	assert min(apart[0.3]) > 100 * max(apart[0.05]), "both part where grains swing"


def test_samples_that_crept_come_back_from_a_file_and_from_an_open_scene_to_the_last_bit(frozen, tmp_path):
	law = wrapper.IceCreep()
	for _ in range(5):
		frozen.apply(shear[frozen.dimension], 1, law.over(-5, 2.0))
	before, scene = frozen.stateBytes, frozen.open()
	frozen.repack(scene)
	assert frozen.stateBytes == before
	O.engines = [frozen]
	O.save(str(tmp_path / "sample.yade.gz"))
	frozen.apply(shear[frozen.dimension], 1, law.over(-5, 2.0))
	O.load(str(tmp_path / "sample.yade.gz"))
	loaded = O.engines[0]
	loaded.apply(shear[frozen.dimension], 1, law.over(-5, 2.0))
	assert loaded.stateBytes == frozen.stateBytes


def test_creep_over_no_time_changes_no_bit(frozen):
	other, law = frozen.copy(), wrapper.IceCreep()
	frozen.apply(shear[frozen.dimension], 1)
	other.apply(shear[frozen.dimension], 1, law.over(-5, 0))
	assert frozen.stateBytes == other.stateBytes


def test_thawed_grains_do_not_creep(sampleCache):
	thawed = rve.pack(rve.prepare(grains=100, ice=True, cache=sampleCache))
	other = thawed.copy()
	thawed.apply(shear[2], 0)
	other.apply(shear[2], 0, wrapper.IceCreep().over(-1, day))
	assert np.abs(np.subtract(thawed.stress, other.stress)).max() < 1e-3 * np.abs(thawed.stress).max(), "two more steps at rest are all"


# a bond between spheres carries some tenth of what one between discs does that are a slice of 0.1 m
loadsOfCreep = {2: (50e3, 100e3, 200e3), 3: (500e3, 1e6, 2e6)}


def checkExponent(exponent, rateFactor, dimension, cache):
	two = (dict(grains=100), dict(grains=100, seed=8)) if dimension == 2 else (eightySpheres, sixtySpheres)
	frozen = [sample for one in two for sample in creep.frozenSamples(realisations=1, cache=cache, **one)]
	law = wrapper.IceCreep(exponent=exponent, rateFactor=rateFactor)
	stresses = loadsOfCreep[dimension]
	for load in creep.steady:
		tests = [[creep.creepTest(sample, law, load, stress, relaxed=0.1) for sample in frozen] for stress in stresses]
		rates = np.array([[test.secondaryRate() for test in row] for row in tests])
		found = np.polyfit(np.log(stresses), np.log(rates), 1)[0]
		error = max(test.error for row in tests for test in row)
		print(f"\n{load}: exponents {np.round(found, 3)} of two samples, {exponent:g} of their bonds; stress held to {100 * error:.1f} %", end="")
		assert found == pytest.approx(exponent, rel=0.05) and error < 0.02


@pytest.mark.parametrize("exponent, rateFactor, dimension", [(2.0, 1e-17, 2), (3.0, 3.5e-25, 2), (4.0, 1e-32, 2), (3.0, 3.5e-25, 3)])
def test_the_exponent_of_a_samples_secondary_creep_is_that_of_its_bonds_within_five_per_cent(exponent, rateFactor, dimension, sampleCache):
	checkExponent(exponent, rateFactor, dimension, sampleCache)


@pytest.mark.parametrize("exponent, rateFactor", [(2.0, 1e-17), (4.0, 1e-32)])
def test_other_exponents_of_samples_of_spheres_are_those_of_their_bonds_within_five_per_cent_slow(exponent, rateFactor, sampleCache):
	checkExponent(exponent, rateFactor, 3, sampleCache)


def test_rates_of_samples_follow_the_rate_factor_over_temperature(sampleCache):
	(frozen,), law = creep.frozenSamples(realisations=1, cache=sampleCache), wrapper.IceCreep()
	rates = [creep.creepTest(frozen, law, "tension", 100e3, temperature, relaxed=0.1).secondaryRate() for temperature in (-2, -20)]
	ratio = recommended[-2] / recommended[-20]
	print(f"\nrate at -2 over that at -20 degC {rates[0] / rates[1]:.2f}; Cuffey & Paterson 2010 {ratio:.2f}")
	assert rates[0] / rates[1] == pytest.approx(ratio, rel=0.05)


def test_shorter_calls_bring_the_rate_of_a_sample_to_a_limit_slow(sampleCache):
	(frozen,), law = creep.frozenSamples(realisations=1, cache=sampleCache), wrapper.IceCreep()
	rates = [creep.creepTest(frozen, law, "shear", 100e3, relaxed=relaxed).secondaryRate() for relaxed in (0.04, 0.02, 0.01, 0.005)]
	changes = np.diff(rates) / rates[-1]
	print(f"\nrates {', '.join(f'{rate:.3e}' for rate in rates)} 1/s with calls half as long each time: {', '.join(f'{100 * c:+.1f} %' for c in changes)}")
	assert (np.diff(np.abs(changes)) < 0).all() and abs(changes[-1]) < 0.05


def test_the_command_writes_table_and_picture_slow(calibrateCommand):
	assert len(calibrateCommand("creep", "--grains", "60", "--realisations", "1")) == 3 + 2 * len(creep.stresses)


# ---- an ordinary scene ----------------------------------------------------------------------------------------------------


def heldPair(**creeping):
	"""Two spheres that are held apart after they were bonded."""
	O.materials.append(wrapper.IceBondMat(young=0.6e9, poisson=0.8, frictionAngle=0.5, density=2650, iceSaturation=1))
	O.bodies.append([utils.sphere((x, 0, 0), radius, fixed=True) for x in (0, 2 * radius)])
	loop = wrapper.InteractionLoop(
		[wrapper.Ig2_Sphere_Sphere_ScGeom(interactionDetectionFactor=1.05)],
		[wrapper.Ip2_IceBondMat_IceBondMat_IceBondPhys(bondNewContacts=True)],
		[wrapper.Law2_ScGeom_IceBondPhys_IceBond()],
	)
	O.engines = [
		wrapper.ForceResetter(),
		wrapper.InsertionSortCollider([wrapper.Bo1_Sphere_Aabb(aabbEnlargeFactor=1.05)], verletDist=0),
		loop,
		wrapper.CreepingBonds(**creeping),
	]
	O.dt = 1e-6
	O.step()
	O.bodies[1].state.pos = (2 * radius + 600 / (young * radius), 0, 0)
	O.step()
	return O.interactions[0, 1].phys


def test_in_an_ordinary_scene_bonds_relax_over_the_time_scale_by_the_closed_form():
	law = wrapper.IceCreep()
	phys = heldPair(iceCreep=law, temperature=-5, timeScale=1e6)
	first = phys.normalForce.norm()
	for steps in (1, 9, 90):
		O.run(steps, True)
	flown = young * law.rateFactorAt(-5) * (first / radius**2) ** 2 * 100.0
	wanted = first / math.sqrt(1 + 2 * flown)
	print(f"\n{first:.2f} N, after 100 s {phys.normalForce.norm():.6f} N, closed form {wanted:.6f} N")
	assert first == pytest.approx(600, rel=1e-9) and phys.normalForce.norm() == pytest.approx(wanted, rel=1e-9)


# ---- ground ---------------------------------------------------------------------------------------------------------------


@pytest.fixture
def packed(sampleCache):
	sample = rve.pack(rve.prepare(grains=100, ice=True, cache=sampleCache))
	sample.freeze(1)
	return sample


@pytest.mark.parametrize("form", ("packed", "open"))
def test_behind_a_point_bonds_creep_at_its_temperature_over_calendar_time(form, packed):
	law, stresses = wrapper.IceCreep(), []
	for scale in (1, 1e5):
		O.reset()
		mpm = block(packed, form, scale, velocity=1.0, iceCreep=law)
		before = mpm.field("stress")
		direct, difference = [packed.copy() if form == "packed" else wrapper.OpenRveSample(source=packed.open()) for _ in range(4)], 0.0
		for _ in range(12):
			O.step()
			gradient, stress = mpm.field("gradient"), mpm.field("stress")
			for k in range(4):
				h = np.array(gradient[k]).reshape(2, 2)
				result = direct[k].apply(Matrix3(h[0, 0], h[0, 1], 0, h[1, 0], h[1, 1], 0, 0, 0, 0), 1, law.over(-5, scale * O.dt))
				difference = max(difference, np.abs(stressOf(result, 2) - stress[k][[0, 1, 3]]).max())
		stresses.append(np.abs(stress - before).max())
		print(
			f"\n{form}, scale {scale:g}: stress has changed by {1e-3 * stresses[-1]:.0f} kPa, differs from samples driven directly by {difference:.1e} Pa",
			end="",
		)
		assert difference < 1e-9 * stresses[-1]
	assert stresses[1] < 0.8 * stresses[0]


def test_ground_at_rest_relaxes_in_every_step_of_calendar_time_and_goes_on_from_a_file_to_the_last_bit(packed, tmp_path):
	states = []
	for saved in (False, True):
		O.reset()
		mpm = block(packed, iceCreep=wrapper.IceCreep(), strainTolerance=1e-4)
		for k in range(20):
			if saved and k == 9:
				O.save(str(tmp_path / "ground.yade.gz"))
				O.load(str(tmp_path / "ground.yade.gz"))
			O.step()
		mpm = O.engines[0]
		states.append((mpm.field("stress"), mpm.skeleton.cost()["calls"]))
	print(f"\n{states[0][1]} calls of 4 points in 20 steps of 2 s of calendar time")
	assert states[0][1] == 80
	assert (states[0][0] == states[1][0]).all()


# ---- refusals -------------------------------------------------------------------------------------------------------------


@pytest.mark.parametrize(
	"attribute, value",
	[
		("rateFactor", -1),
		("rateFactor", math.nan),
		("exponent", 0.9),
		("exponent", 11),
	],
)
def test_impossible_creep_laws_are_refused_by_name(attribute, value):
	with pytest.raises(ValueError, match=f"IceCreep.{attribute} is .*: give"):
		wrapper.IceCreep(**{attribute: value})


def test_impossible_times_temperatures_and_creep_are_refused_where_they_are_given(packed):
	law = wrapper.IceCreep()
	with pytest.raises(ValueError, match="IceCreep.over: time is -1"):
		law.over(-5, -1)
	with pytest.raises(ValueError, match="IceCreep.rateFactorAt: temperature is -300"):
		law.rateFactorAt(-300)
	with pytest.raises(ValueError, match="CreepingBonds.timeScale is -1"):
		wrapper.CreepingBonds(timeScale=-1)
	with pytest.raises(ValueError, match="CreepingBonds.temperature is"):
		wrapper.CreepingBonds(temperature=math.nan)
	for wrong in ((-1e-20, 3), (1e-20, 0.5), (1e-20,), (math.nan, 3), 5, "text"):
		with pytest.raises(ValueError, match="RveSample.apply: creep is .*: give what IceCreep.over"):
			packed.apply(Matrix3.Zero, 1, wrong)


def test_a_scene_whose_bonds_creep_by_themselves_is_not_packed(packed):
	scene = packed.open()
	with talik.inspect(scene):
		O.engines = O.engines + [wrapper.CreepingBonds(iceCreep=wrapper.IceCreep())]
	with pytest.raises(ValueError, match="it has a CreepingBonds"):
		wrapper.RveSample.fromScene(scene)


def test_a_hanging_frozen_column_stretches_at_the_speed_of_glens_law_slow(sampleCache):
	"""Under its own weight the rate at a height y is A_s (rho g y)^n, and the end moves by A_s (rho g)^n L^(n+1)/(n+1); A_s from a creep test."""
	(frozen,), law = creep.frozenSamples(realisations=1, cache=sampleCache), wrapper.IceCreep()
	spacing, length, scale = 0.5, 4.0, 700.0
	mpm = wrapper.MpmEngine(
		gridSpacing=spacing, lower=(0, 0), upper=(2.5, 5), gravity=(0, -9.81), damping=0.3, heat=wrapper.HeatTransfer(thermalTimeScale=scale)
	)
	mpm.skeleton = wrapper.RveSkeleton(samples=[frozen], iceCreep=law, prediction=False, strainTolerance=0)
	position = np.array([(1 + spacing * x, y) for y in np.arange(1.125, 5, 0.25) for x in (0.25, 0.75)])
	mpm.addPoints(position=position, volume=0.25**2, porosity=0.4, temperature=-10)
	mpm.boundaries = [wrapper.FixedBoundary(region="top")]
	O.engines = [mpm]
	mpm.initialise()
	ends = []
	for instant in (1.0, 2.0):
		while mpm.time < instant:
			O.step()
		ends.append((scale * mpm.time, -mpm.field("displacement")[0, 1]))
	(begin, before), (end, after) = ends
	speed, density = (after - before) / (end - begin), mpm.field("mass")[0] / 0.25**2
	test = creep.creepTest(frozen, law, "tension", 60e3)
	ofSample = test.rate(0.005, 0.015) / test.stress**3
	below = 0.125  # of the length hangs below the point
	wanted = ofSample * (density * 9.81) ** 3 / 4 * (length**4 - below**4)
	print(f"\nend of a column of 4 m: {speed:.3e} m/s, closed form {wanted:.3e} m/s ({100 * (speed / wanted - 1):+.1f} %)")
	assert speed == pytest.approx(wanted, rel=0.1)


def test_the_frozen_slope_of_the_examples_creeps_at_the_speed_of_glens_infinite_slope_slow(tmp_path):
	example = Path(__file__).resolve().parents[2] / "examples" / "creeping_slope.py"
	run = subprocess.run(
		["yade", "-n", "-x", str(example), "--preset", "test", "--output", str(tmp_path)], capture_output=True, text=True, timeout=600, check=False
	)
	assert (tmp_path / "summary.json").exists() and (tmp_path / "creeping_slope.png").stat().st_size > 10_000, run.stdout + run.stderr
	summary = json.loads((tmp_path / "summary.json").read_text())
	print(f"\n{summary}")
	assert summary["speed [m/year]"] == pytest.approx(summary["by hand [m/year]"], rel=0.1)


def test_a_block_of_creeping_ground_bears_the_stress_of_glens_law_under_a_plate_that_presses_it():
	"""Plane strain, free sides: tau = q/2, so that the plate is met by q = 2 (rate/A)^(1/n) at a rate in calendar time."""
	law, height, speed, scale = wrapper.IceCreep(), 2.0, 0.02, 1e7
	mpm = wrapper.MpmEngine(
		gridSpacing=0.5,
		lower=(0, 0),
		upper=(3, height),
		damping=0.3,
		heat=wrapper.HeatTransfer(thermalTimeScale=scale),
		skeleton=wrapper.CreepingSkeleton(young=1e9, iceCreep=law),
		boundaries=[
			wrapper.RollerBoundary(region="left"),
			wrapper.RollerBoundary(region="bottom"),
			wrapper.MovingBoundary(region="top", rough=False, speed=speed),
		],
	)
	talik.geometry.fill(mpm, talik.geometry.rectangle(0, 0, 2, height), temperature=-2)
	O.engines = [mpm]
	mpm.initialise()
	while mpm.time < 0.2:
		O.step()
	length = height - speed * mpm.time
	stress, wanted = -mpm.field("stress").mean(axis=0), 2 * (speed / length / scale / law.rateFactorAt(-2)) ** (1 / law.exponent)
	print(f"\nvertical {1e-3 * stress[1]:.1f} kPa, lateral {1e-3 * stress[0]:.2f} kPa, across {1e-3 * stress[2]:.1f} kPa; Glen's law {1e-3 * wanted:.1f} kPa")
	assert stress[1] == pytest.approx(wanted, rel=0.02)
	assert stress[2] == pytest.approx(wanted / 2, rel=0.02) and abs(stress[0]) < 0.02 * wanted


def test_creeping_ground_goes_on_from_a_file_to_the_last_bit(tmp_path):
	states = []
	for saved in (False, True):
		O.reset()
		mpm = wrapper.MpmEngine(gridSpacing=0.25, lower=(0, 0), upper=(9, 5), gravity=(0, -9.81), heat=wrapper.HeatTransfer(thermalTimeScale=1e8))
		mpm.skeleton = wrapper.CreepingSkeleton(young=1e8)
		mpm.boundaries = [wrapper.FixedBoundary(region="bottom")]
		talik.geometry.fill(mpm, talik.geometry.rectangle(1, 0, 8, 4.5), temperature=-2)
		O.engines = [mpm]
		for k in range(20):
			if saved and k == 9:
				O.save(str(tmp_path / "ground.yade.gz"))
				O.load(str(tmp_path / "ground.yade.gz"))
			O.step()
		mpm = O.engines[0]
		states.append((mpm.field("stress"), mpm.field("skeleton0.creepStrain")))
	print(f"\n{mpm.pointCount} points, creep strain up to {states[0][1].max():.1e} after 20 steps")
	assert states[0][1].max() > 0
	assert all((one == other).all() for one, other in zip(*states))
