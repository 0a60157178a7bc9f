# SPDX-License-Identifier: GPL-2.0-or-later
"""Samples of spheres: made by stock YADE, packed, against stock YADE's engines, opened, saved, and what is refused."""

import numpy as np
import pytest
from fixtures import spheres
from yade import Matrix3, O, wrapper

import talik
from talik import packing, rve

gradient = Matrix3(0.1, 0.2, -0.05, 0.02, -0.2, 0.1, 0.05, -0.1, 0.05)  # [1/s]
young = 0.6e9


@pytest.fixture(scope="module")
def prepared(sampleCache):
	"""100 spheres at 100 kPa, with materials that ice can bond."""
	return rve.prepare(**spheres, cache=sampleCache)


@pytest.fixture
def sample(prepared):
	return rve.pack(prepared)


def test_prepared_spheres_have_the_porosity_and_the_isotropic_stress_asked_for(prepared):
	stress = np.array(prepared.stress)
	print(f"\n{prepared}; made with friction {prepared.parameters['compactionFriction']:.3f}")
	assert prepared.dimension == 3 and prepared.grains == 100
	assert abs(prepared.porosity - 0.39) < 0.005 and prepared.fabric < 0.05
	assert np.abs(stress[:3] + 100e3).max() < 1e3 and np.abs(stress[3:]).max() < 1e3
	assert 3.5 < prepared.coordinationNumber < 7


def test_a_sample_in_the_cache_is_found_again_and_that_of_discs_is_another(prepared, sampleCache):
	again = rve.prepare(**spheres, cache=sampleCache)
	assert again == prepared
	assert rve.load(prepared.path).stress == prepared.stress


@pytest.mark.parametrize("ice", [0.0, 1.0], ids=["frictional", "bonded"])
def test_packed_spheres_move_as_under_stock_yade(ice, sample):
	sample.freeze(ice)
	scene = sample.open()
	with talik.inspect(scene):
		O.cell.velGrad = gradient
		packing.advance(1)
		one = packing.stress()
		packing.advance(499)
		many = packing.stress()
		positions = np.array([body.state.pos for body in O.bodies])
	sample.advance(gradient, 1)
	after1 = np.abs(np.array(sample.stress) - one).max() / np.abs(one).max()
	sample.advance(gradient, 499)
	after500 = np.abs(np.array(sample.stress) - many).max() / np.abs(many).max()
	moved = np.abs(sample.arrays()["position"] - positions).max()
	print(
		f"\n{sample.statistics()['bondsIntact']} bonds; stress differs by {after1:.1e} after one step, {after500:.1e} after 500, positions then by {moved:.1e} m"
	)
	assert after1 < 1e-12 and after500 < 1e-8 and moved < 1e-11


@pytest.mark.parametrize("ice", [0.0, 1.0], ids=["frictional", "bonded"])
def test_packed_and_stock_spheres_give_one_curve_of_triaxial_compression(ice, sample):
	"""1 % along z, the other two stresses held, servoed by the same rule in both."""
	sample.freeze(ice)
	scene = sample.open()
	strain, chunk, perStep = 1e-2, 20, 2e-6
	rate, held = perStep / sample.dt, -100e3
	gain = 1 / (2 * young * (1 + 5 * ice) * chunk * sample.dt)

	def velGrad(stress):
		side = [max(-2 * rate, min(2 * rate, gain * (held - s))) for s in stress[:2]]
		return Matrix3(side[0], 0, 0, 0, side[1], 0, 0, 0, -rate)

	curves = []
	for packed in (True, False):
		form = sample.copy()
		stress, curve = np.array(form.stress), []
		with talik.inspect(scene):
			for _ in range(round(strain / (perStep * chunk))):
				if packed:
					form.advance(velGrad(stress), chunk)
					stress = np.array(form.stress)
				else:
					O.cell.velGrad = velGrad(stress)
					packing.advance(chunk)
					stress = packing.stress()
				curve.append(stress)
		curves.append(np.array(curve))
	difference = np.abs(curves[0] - curves[1]).max(axis=1).mean() / np.abs(curves[1]).max(axis=1).mean()
	print(f"\nover 1 % sigma_zz goes from {sample.stress[2] / 1e3:.0f} to {curves[1][-1, 2] / 1e3:.0f} kPa, sigma_xx to {curves[1][-1, 0] / 1e3:.0f} kPa;")
	print(f"the curves differ by {difference:.1e} of that")
	assert curves[1][-1, 2] < 1.5 * held and difference < 1e-2


def test_packed_open_packed_is_the_identity_and_an_archive_keeps_every_bit(sample, tmp_path):
	sample.freeze(0.5)
	sample.advance(gradient, 100)
	before = sample.stateBytes
	sample.repack(sample.open())
	assert sample.stateBytes == before
	O.engines = [sample]
	O.save(str(tmp_path / "sample.yade.gz"))
	O.load(str(tmp_path / "sample.yade.gz"))
	restored = O.engines[0]
	assert restored.stateBytes == before and restored.dimension == 3
	for one in (sample, restored):
		one.advance(gradient, 50)
	assert restored.stateBytes == sample.stateBytes


def test_spheres_freeze_free_of_stress_thaw_and_shrink(sample):
	sample.thawStrain = 0.05
	radii = sample.arrays()["radius"]
	before, number = np.array(sample.stress), sample.statistics()["contacts"]
	sample.freeze(1)
	frozen, bonds = np.array(sample.stress), sample.statistics()["bondsIntact"]
	sample.freeze(0)
	thawed, left = np.array(sample.stress), sample.statistics()["bondsIntact"]
	ratio = sample.arrays()["radius"] / radii
	print(f"\n{number} contacts, {bonds} bonds; pressure {-before[:3].mean():.0f} Pa, frozen {-frozen[:3].mean():.0f}, thawed {-thawed[:3].mean():.0f}")
	assert bonds > number and left == 0
	assert np.abs(frozen - before).max() < 0.02 * 100e3
	assert np.allclose(ratio, (1 - 0.05) ** (1 / 3), rtol=1e-12)
	assert -thawed[:3].mean() < 0.9 * -before[:3].mean()


def test_arrays_stress_and_fabric_have_three_dimensions(sample):
	arrays, contacts = sample.arrays(), sample.statistics()["contacts"]
	with talik.inspect(sample.open()):
		ofScene = packing.sampleArrays()
		stress = packing.stress()
	assert arrays["position"].shape == (100, 3) and arrays["hSize"].shape == (3, 3)
	assert arrays["shear"].shape == arrays["cellDist"].shape == (contacts, 3)
	assert ofScene["centre"].shape == (100, 3) and ofScene["normal"].shape == (contacts, 3)
	assert len(sample.stress) == len(sample.statistics()["fabric"]) == 6
	assert sum(sample.statistics()["fabric"][:3]) == pytest.approx(1)
	assert stress == pytest.approx(sample.stress, rel=1e-3, abs=100)


def test_servo_brings_spheres_to_three_principal_stresses(sample):
	assert sample.servo(-80e3, -100e3, -120e3)
	print(f"\n{np.round(np.array(sample.stress) / 1e3, 2)} kPa")
	assert np.abs(np.array(sample.stress) - (-80e3, -100e3, -120e3, 0, 0, 0)).max() < 2e3


def test_a_prepared_sample_is_brought_to_another_stress_by_stock_yade(prepared, sampleCache):
	deep = rve.servo(prepared, stressX=-120e3, stressY=-120e3, stressZ=-150e3, cache=sampleCache)
	assert np.abs(np.array(deep.stress) - (-120e3, -120e3, -150e3, 0, 0, 0)).max() < 2e-3 * 130e3


@pytest.mark.parametrize(
	"settings, words",
	[
		(dict(dimension=4), "dimension is 4"),
		(dict(dimension=3, thickness=0.1), "left out for spheres"),
		(dict(dimension=3, porosity=0.18), "0.25 and 0.65"),
		(dict(dimension=3, grains=5), "at least 20"),
	],
)
def test_impossible_spheres_are_refused_with_a_sentence(settings, words):
	with pytest.raises(ValueError, match=words):
		rve.prepare(cache=False, **settings)


def test_calls_that_belong_to_the_other_dimension_are_refused_with_a_sentence(sample, prepared, sampleCache):
	discs = rve.pack(rve.prepare(grains=100, ice=True, cache=sampleCache))
	for call, words in (
		(lambda: sample.servo(-1e5, -1e5), "stressZ is missing"),
		(lambda: discs.servo(-1e5, -1e5, -1e5), "stressZ is given"),
		(lambda: sample.servo(-1e5, -1e5, 1e5), "stressZ is 100000"),
		(lambda: rve.servo(prepared, -1e5, -1e5, cache=sampleCache), "stressZ is None"),
		(lambda: discs.repack(sample.open()), "it has spheres"),
		(lambda: sample.repack(discs.open()), "it has discs"),
	):
		with pytest.raises(ValueError, match=words):
			call()
	mpm = wrapper.MpmEngine(gridSpacing=0.5, lower=(0, 0), upper=(1, 1), skeleton=wrapper.RveSkeleton(samples=[sample]))
	mpm.addPoints(position=np.array([(0.25, 0.25)]), volume=np.array([0.25]))
	with pytest.raises(ValueError, match="has spheres and the ground is in the plane"):
		mpm.initialise()


# with the share of the stress error that is removed at once kept at a fifth, a third of these targets was not reached in 400 000 steps
def test_spheres_are_brought_to_a_few_kilopascals_near_failure(sampleCache):
	sample = talik.rve.pack(talik.rve.prepare(**spheres, cache=sampleCache))
	for vertical in (-3303.3, -3308.8, -3337.4, -3348.4, -3356.1, -3362.7):
		brought, target = sample.copy(), np.array((0.6, 0.6, 1.0)) * vertical
		reached = brought.servo(*target)
		off = np.abs(np.array(brought.stress[:3]) - target).max()
		print(f"vertical {vertical} Pa, sideways 0.6 of it: reached {reached}, off by {off:.1f} Pa")
		assert reached and off < 5e-3 * abs(vertical)
