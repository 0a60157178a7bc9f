# SPDX-License-Identifier: GPL-2.0-or-later
"""Strength of ice bonds over temperature and strain rate: one bond, samples, points of a ground."""

import math

import numpy as np
import pytest
from fixtures import eightySpheres, rollingDiscs, rollingDiscsWithMoments, rollingSpheres, sixtySpheres
from yade import Matrix3, O, utils, wrapper

from frozen_pair import block, frozenPair
from talik import rve
from talik.studies import calibrate
from twins import withAGrainBeside


@pytest.fixture
def packed(sampleCache):
	return rve.pack(rve.prepare(grains=100, ice=True, cache=sampleCache))


def under(sample, law, temperature=-10.0, rate=1e-4):
	"""A copy of a sample whose bonds have the strength of a temperature and a rate."""
	other = sample.copy()
	other.tensileStrengthFactor, other.shearStrengthFactor = law.factors(temperature, rate)
	return other


def test_factors_are_those_of_the_published_tests():
	law = wrapper.IceStrength()
	byCold = np.divide(law.factors(-56.7, 1e-4), law.factors(0, 1e-4))
	byRate = np.divide(law.factors(-10, 2.9), law.factors(-10, 1.2e-4))
	print(
		f"\n0 to -56.7 degC: shear {byCold[1]:.2f} fold (compression in Haynes & Karalius 1977: tenfold), tensile {byCold[0]:.2f} fold (half an order); "
		f"1.2e-4 to 2.9 1/s: shear {byRate[1]:.2f} fold (compression in Haynes et al. 1975: tenfold), tensile {byRate[0]:.2f} fold (hardly)"
	)
	assert byCold == pytest.approx([math.sqrt(10), 10], rel=0.01)
	assert byRate == pytest.approx([1, 10], rel=0.01)
	assert law.factors(-10, 1e-4) == (1, 1)
	assert law.factors(5, 1e-4) == law.factors(0, 1e-4) and law.factors(-10, 0) == law.factors(-10, 1e-7)


def test_one_bond_breaks_at_its_strength_times_the_factor_of_temperature_and_rate():
	"""Two discs side by side in a cell that is stretched along their line: the largest tension of the bond is C_eta A_b."""
	radius, depth, law = 5e-3, 0.1, wrapper.IceStrength(tensileRateExponent=0.1)
	start = frozenPair(radius, depth)
	strength, width = 51e6 * radius**2, 10 * radius * depth
	for temperature, rate in ((-10, 1e-4), (-40, 1e-4), (-2, 1e-2)):
		sample = under(start, law, temperature, rate)
		largest = 0.0
		while sample.statistics()["bondsIntact"] == 2:
			largest = max(largest, sample.apply(Matrix3(1e-6, 0, 0, 0, 0, 0, 0, 0, 0), 1)["stress"][0] * width)
			assert largest < 10 * strength
		expected = strength * math.exp(0.0203 * (-10 - temperature)) * (rate / 1e-4) ** 0.1
		print(f"\n{temperature} degC, {rate:g} 1/s: broken above {largest:.3f} N, C_eta A_b with its factor is {expected:.3f} N", end="")
		assert largest == pytest.approx(expected, rel=1e-3) and largest <= expected


def test_factors_of_one_leave_the_bits_of_a_sample_and_thawed_ground_has_none(packed):
	law, gradient = wrapper.IceStrength(), Matrix3(1e-4, 0, 0, 0, -2e-4, 0, 0, 0, 0)
	frozen = [sample.copy() for sample in (packed, under(packed, law))]
	thawed = [sample.copy() for sample in (packed, under(packed, law, -40, 1))]
	for samples, ice in ((frozen, 1), (thawed, 0)):
		for sample in samples:
			for _ in range(20):
				sample.apply(gradient, ice)
		assert samples[0].stateBytes == samples[1].stateBytes
	assert frozen[0].statistics()["bondsIntact"] > 0


kinds = {
	"discs": dict(grains=100),
	"rolling discs": rollingDiscs,
	"discs with moments": rollingDiscsWithMoments,
	"spheres": eightySpheres,
	"rolling spheres": rollingSpheres,
	"spheres with moments": dict(**sixtySpheres, bondRadiusFactor=1.0, momentContribution=0.5),
}


def besideOpen(sample, opened, gradient):
	"""(DEM steps of a call that both take, largest difference of a component of stress [Pa])."""
	one, other = sample.apply(gradient, 1), opened.apply(gradient, 1)
	assert one["steps"] == other["steps"]
	stress = other["stress"]
	places = ((0, 0), (1, 1), (0, 1)) if sample.dimension == 2 else ((0, 0), (1, 1), (2, 2), (1, 2), (0, 2), (0, 1))
	return one["steps"], np.abs(np.subtract(one["stress"], [0.5 * (stress[i, j] + stress[j, i]) for i, j in places])).max()


@pytest.mark.parametrize("kind", kinds)
def test_packed_samples_of_changing_strength_follow_open_ones_to_1e9_over_500_steps_and_break_as_many_bonds(kind, sampleCache):
	sample = rve.pack(rve.prepare(ice=True, cache=sampleCache, **kinds[kind]))
	sample.freeze(1)
	strong, opened, law = sample.copy(), wrapper.OpenRveSample(source=sample.open()), wrapper.IceStrength(tensileCold=0.4, shearCold=0.4)
	gradient, steps, error = Matrix3(0, 3e-5, 0, 0, -3e-5, 0, 0, 0, 0), 0, 0.0
	for each in (sample, strong, opened):
		each.minSteps = 25
	for temperature, rate in ((-10, 1e-4), (-2, 1e-6), (-1, 1e-7), (-5, 1e-5), (0, 1e-7)) * 4:
		for each in (sample, opened):
			each.tensileStrengthFactor, each.shearStrengthFactor = law.factors(temperature, rate)
		taken, apart = besideOpen(sample, opened, gradient)
		strong.apply(gradient, 1)
		steps, error = steps + taken, max(error, apart)
	scale = np.abs(sample.stress).max()
	bonds = [each.statistics()["bondsIntact"] for each in (sample, opened, strong)]
	print(
		f"\n{kind}: {steps} steps, stress differs by {error / scale:.1e}; bonds intact {bonds[0]} packed, {bonds[1]} open, {bonds[2]} at -10 degC and 1e-4 1/s"
	)
	assert steps >= 500 and error < 1e-9 * scale
	assert bonds[0] == bonds[1] < bonds[2]


@pytest.mark.parametrize("kind", ["discs", "spheres"])
def test_what_packed_and_open_samples_differ_by_is_of_second_order_in_the_strain_of_a_step_and_no_round_off(kind, sampleCache):
	"""Stock YADE turns shear forces by a cross product, which makes them grow by half the square of the turn (next test), where packed discs keep their
	number: over one path that is in proportion to the strain of a step. Round-off would grow with the number of steps."""
	errors, twins = [], []
	for steps in (10, 50):
		sample = rve.pack(rve.prepare(ice=True, cache=sampleCache, **kinds[kind]))
		sample.freeze(1)
		twin, opened = withAGrainBeside(sample), wrapper.OpenRveSample(source=sample.open())
		for each in (sample, twin, opened):
			each.minSteps, each.maxStrainPerStep, each.maxInertialNumber = steps, 1.0, 1e9
		for _ in range(8):
			_, apart = besideOpen(sample, opened, (gradient := Matrix3(0, 1e-4, 0, 0, -1e-4, 0, 0, 0, 0)))
			twin.apply(gradient, 1)
		scale = np.abs(sample.stress).max()
		errors.append(apart / scale)
		twins.append(np.abs(np.subtract(sample.stress, twin.stress)).max() / scale)
		assert sample.statistics()["bondsBroken"] == 0
	print(
		f"\n{kind}, 8e-4 of strain in calls of 10 and of 50 steps: packed differs from open by {errors[0]:.1e} and {errors[1]:.1e}, ratio "
		f"{errors[0] / errors[1]:.1f}; from a twin one unit in the last place beside by {twins[0]:.1e} and {twins[1]:.1e}"
	)
	assert 2.5 < errors[0] / errors[1] < 10
	assert max(twins) < 0.1 * min(errors)


def test_stock_yade_lets_a_shear_force_grow_by_half_the_square_of_the_turn_of_each_step():
	"""Two bonded spheres that turn about each other as one body, 1e-2 in a step, carry a shear force that should only turn."""
	radius, turn, steps = 1e-2, 1e-2, 100
	O.materials.append(wrapper.FrictMat(young=1e9, poisson=0.5, frictionAngle=1.5, density=2650))
	O.bodies.append([utils.sphere((x, 0, 0), radius, fixed=True) for x in (0, 1.99 * radius)])
	O.engines = [
		wrapper.ForceResetter(),
		wrapper.InsertionSortCollider([wrapper.Bo1_Sphere_Aabb(aabbEnlargeFactor=1.2)], verletDist=0),
		wrapper.InteractionLoop(
			[wrapper.Ig2_Sphere_Sphere_ScGeom()], [wrapper.Ip2_FrictMat_FrictMat_FrictPhys()], [wrapper.Law2_ScGeom_FrictPhys_CundallStrack()]
		),
	]
	O.dt = 1e-6
	O.step()
	phys = O.interactions[0, 1].phys
	phys.shearForce = (0, 1.0, 0)
	for k in range(1, steps + 1):
		angle = k * turn
		second = O.bodies[1].state
		second.pos = (1.99 * radius * math.cos(angle), 1.99 * radius * math.sin(angle), 0)
		O.step()
	growth = phys.shearForce.norm() - 1
	print(f"\n{steps} steps of {turn:g}: the force has grown by {growth:.6f}, by hand {(math.cos(turn) + math.sin(turn) ** 2) ** steps - 1:.6f}")
	assert growth == pytest.approx((math.cos(turn) + math.sin(turn) ** 2) ** steps - 1, rel=1e-3)


# ---- stiffness ------------------------------------------------------------------------------------------------------------

# elastic constants of ice Ih [GPa] c11, c12, c13, c33, c44: -3 degC by Gammon, Kiefte & Clouter 1980, -16 degC by Gammon et al. 1983, abstracts
constantsOfIce = {-3: (13.696, 6.966, 5.628, 14.702, 2.959), -16: (13.929, 7.082, 5.765, 15.010, 3.014)}


def youngOfPolycrystal(c11, c12, c13, c33, c44):
	"""Young's modulus of grains in all directions, mean of Voigt's and Reuss's [the unit of the constants]."""
	c = np.zeros((6, 6))
	c[:3, :3] = [[c11, c12, c13], [c12, c11, c13], [c13, c13, c33]]
	c[[3, 4, 5], [3, 4, 5]] = c44, c44, 0.5 * (c11 - c12)
	s = np.linalg.inv(c)
	(a, b, d), (p, q, r) = ((m[0, 0] + m[1, 1] + m[2, 2], m[0, 1] + m[1, 2] + m[2, 0], m[3, 3] + m[4, 4] + m[5, 5]) for m in (c, s))
	bulk = 0.5 * ((a + 2 * b) / 9 + 1 / (p + 2 * q))
	shear = 0.5 * ((a - b + 3 * d) / 15 + 15 / (4 * p - 4 * q + 3 * r))
	return 9 * bulk * shear / (3 * bulk + shear)


def test_the_growth_of_stiffness_that_the_help_gives_for_ice_is_that_of_its_elastic_constants():
	warm, cold = (youngOfPolycrystal(*constantsOfIce[temperature]) for temperature in (-3, -16))
	growth = math.log(cold / warm) / 13
	print(f"\nE of ice {warm:.3f} GPa at -3 degC and {cold:.3f} GPa at -16 degC: b = {growth:.5f} 1/K, the help says 0.0014")
	assert growth == pytest.approx(0.0014, rel=0.05)
	assert wrapper.IceStrength(stiffnessCold=growth).stiffnessFactor(-16) / wrapper.IceStrength(stiffnessCold=growth).stiffnessFactor(-3) == pytest.approx(
		cold / warm, rel=1e-12
	)


def test_one_bond_is_as_stiff_as_its_temperature_says_and_keeps_its_force_when_that_changes():
	"""Two discs stretched along their line: F grows by (k_g + k_ice exp(b (T_0 - T))) du, and a change of temperature alone adds nothing."""
	radius, depth, law = 5e-3, 0.1, wrapper.IceStrength(stiffnessCold=0.05)
	sample, width, wanted, length = frozenPair(radius, depth), 10 * radius * depth, 0.0, 2 * radius
	previous = 0.0
	for temperature in (-10, -2, -30, -5, -10):
		sample.iceStiffnessFactor = law.stiffnessFactor(temperature)
		held = sample.apply(Matrix3.Zero, 1)["stress"][0] * width
		for _ in range(10):
			sample.apply(Matrix3(1e-6, 0, 0, 0, 0, 0, 0, 0, 0), 1)
			wanted += (0.6e9 + 3e9 * min(math.exp(0.05 * (-10 - temperature)), 2)) * radius * 1e-6 * length
			length *= 1 + 1e-6
		force = sample.stress[0] * width
		print(f"\n{temperature} degC: {force:.6f} N, by hand {wanted:.6f} N; the change of temperature added {held - previous:.1e} N", end="")
		assert force == pytest.approx(wanted, rel=1e-5) and abs(held - previous) < 1e-9 * force
		previous = force
	assert sample.statistics()["bondsIntact"] == 2


@pytest.mark.parametrize("kind", kinds)
def test_packed_samples_of_changing_stiffness_follow_open_ones_to_1e9_over_500_steps(kind, sampleCache):
	sample = rve.pack(rve.prepare(ice=True, cache=sampleCache, **kinds[kind]))
	sample.freeze(1)
	fixed, opened = sample.copy(), wrapper.OpenRveSample(source=sample.open())
	law, shear, steps, error = wrapper.IceStrength(stiffnessCold=0.05), Matrix3(0, 3e-5, 0, 0, -3e-5, 0, 0, 0, 0), 0, 0.0
	for each in (sample, fixed, opened):
		each.minSteps, each.timeStepFollowsIce = 25, False
	for temperature in (-10, -2, -20, -5, -30) * 4:
		sample.iceStiffnessFactor = opened.iceStiffnessFactor = law.stiffnessFactor(temperature)
		taken, apart = besideOpen(sample, opened, shear)
		fixed.apply(shear, 1)
		steps, error = steps + taken, max(error, apart)
	scale = np.abs(sample.stress).max()
	print(f"\n{kind}: {steps} steps, stress differs by {error / scale:.1e}; {scale / np.abs(fixed.stress).max():.2f} of that of constant stiffness")
	assert steps >= 500 and error < 1e-9 * scale
	assert abs(scale / np.abs(fixed.stress).max() - 1) > 0.02


def test_the_stiffness_of_a_sample_lies_between_that_of_grains_and_of_ice_and_falls_with_warmth(packed):
	"""E of the sample over temperature, between no growth and that of the ice alone: grains do not stiffen."""
	packed.freeze(1)
	law, modulus = wrapper.IceStrength(stiffnessCold=0.05), []
	for temperature in (-2, -10, -20):
		sample = packed.copy()
		sample.iceStiffnessFactor, sample.minSteps = law.stiffnessFactor(temperature), 2000
		before = np.array(sample.apply(Matrix3.Zero, 1)["stress"])
		after = np.array(sample.apply(Matrix3(0, 0, 0, 0, -2e-5, 0, 0, 0, 0), 1)["stress"])
		modulus.append((before - after)[1] / 2e-5)
	grew, ice = np.divide(modulus, modulus[1]), [law.stiffnessFactor(t) for t in (-2, -10, -20)]
	byHand = [(0.6 + 3 * factor) / 3.6 for factor in ice]
	print(f"\nmodulus over that at -10 degC: {grew.round(3)} at -2, -10, -20 degC; contacts {np.round(byHand, 3)}, ice {np.round(ice, 3)}")
	assert grew == pytest.approx(byHand, rel=0.02)


# ---- tables ---------------------------------------------------------------------------------------------------------------


def test_the_command_writes_table_and_picture_slow(calibrateCommand):
	assert len(calibrateCommand("strength", "--grains", "40")) == 2 + len(calibrate.rates) + len(calibrate.temperatures)


@pytest.mark.parametrize("form", ("packed", "open"))
def test_behind_a_point_strength_follows_its_temperature_and_its_strain_rate_in_natures_time(form, packed):
	law, broken = wrapper.IceStrength(shearRateExponent=0.4, referenceRate=1), []
	packed.freeze(1)
	for scale in (1, 1e4):
		O.reset()
		mpm = block(packed, form, scale, velocity=0.5, iceStrength=law)
		direct, difference = [packed.copy() if form == "packed" else wrapper.OpenRveSample(source=packed.open()) for _ in range(4)], 0.0
		for _ in range(15):
			O.step()
			gradient, stress = mpm.field("gradient"), mpm.field("stress")
			for k in range(4):
				h = np.array(gradient[k]).reshape(2, 2)
				rate = np.abs(np.linalg.eigvalsh(0.5 * (h + h.T))).max() / (scale * O.dt)
				direct[k].tensileStrengthFactor, direct[k].shearStrengthFactor = law.factors(-5, rate)
				result = np.array(direct[k].apply(Matrix3(h[0, 0], h[0, 1], 0, h[1, 0], h[1, 1], 0, 0, 0, 0), 1)["stress"])
				result = result if result.ndim == 1 else np.array((result[0, 0], result[1, 1], 0.5 * (result[0, 1] + result[1, 0])))
				difference = max(difference, np.abs(result - stress[k][[0, 1, 3]]).max())
		broken.append(int(np.nansum(mpm.field("bondsBroken"))))
		print(
			f"\n{form}, scale {scale:g}: rate {rate:.1e} 1/s, {broken[-1]} bonds broken, stress differs from samples driven directly by {difference:.1e} Pa",
			end="",
		)
		assert difference < 1e-9 * np.abs(stress).max()
	assert broken[1] > broken[0]


def test_ground_whose_bonds_follow_the_rate_goes_on_from_a_file_to_the_last_bit(packed, tmp_path):
	"""The time since a sample was asked is a field of the points."""
	packed.freeze(1)
	stresses = []
	for saved in (False, True):
		O.reset()
		mpm = block(packed, velocity=0.5, strainTolerance=1e-4, iceStrength=wrapper.IceStrength(shearRateExponent=0.4, referenceRate=1))
		for k in range(20):
			if saved and k == 9:
				O.save(str(tmp_path / "ground.yade.gz"))
				O.load(str(tmp_path / "ground.yade.gz"))
			O.step()
		mpm = O.engines[0]
		stresses.append((mpm.field("stress"), mpm.field("bondsBroken"), mpm.skeleton.cost()["calls"]))
	print(f"\n{stresses[0][2]} calls in 20 steps of 4 points, {int(np.nansum(stresses[0][1]))} bonds broken")
	assert 0 < stresses[0][2] < 80 and np.nansum(stresses[0][1]) > 0
	assert (stresses[0][0] == stresses[1][0]).all() and np.array_equal(stresses[0][1], stresses[1][1], equal_nan=True)


@pytest.mark.parametrize(
	"attribute, value",
	[("referenceRate", 0), ("shearCold", -0.1), ("stiffnessCold", -0.1), ("shearRateExponent", 1)],
)
def test_impossible_strength_laws_are_refused_by_name(attribute, value):
	with pytest.raises(ValueError, match=f"IceStrength.{attribute} is"):
		wrapper.IceStrength(**{attribute: value})


@pytest.mark.parametrize("factor", [0, -1, math.nan, math.inf])
def test_impossible_factors_are_refused(packed, factor):
	stiff = packed.copy()
	stiff.iceStiffnessFactor = factor
	with pytest.raises(ValueError, match="factor .* on the stiffness of ice"):
		stiff.apply(Matrix3.Zero, 1)
	packed.shearStrengthFactor = factor
	with pytest.raises(ValueError, match="factor .* on the strength of bonds"):
		packed.apply(Matrix3.Zero, 1)
