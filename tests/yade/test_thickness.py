# SPDX-License-Identifier: GPL-2.0-or-later
"""The thickness that stress of discs is divided by: a number of its own, beside the depth of YADE's cell."""

import numpy as np
import pytest
from fixtures import hundredWithoutIce
from yade import Matrix3, O, utils, wrapper

import talik
from talik import packing, rve

thin = 0.01  # [m]: one mean diameter of the grains; their cell is ten times as deep


def inPlane(xx, xy=0.0, yy=0.0):
	return Matrix3(xx, xy, 0, 0, yy, 0, 0, 0, 0)


def components(tensor):
	return np.array([tensor[0, 0], tensor[1, 1], 0.5 * (tensor[0, 1] + tensor[1, 0])])


def ofThickness(sample, thickness):
	"""The scene of a packed sample with another thickness."""
	scene = sample.open()
	with talik.inspect(scene):
		O.tags["thickness"] = repr(thickness)
	return scene


def relative(a, b):
	return np.abs(np.subtract(a, b)).max() / np.abs(b).max()


@pytest.fixture
def frictional(sampleCache):
	return rve.pack(rve.prepare(**hundredWithoutIce, cache=sampleCache))


@pytest.fixture
def bonded(sampleCache):
	sample = rve.pack(rve.prepare(grains=100, ice=True, cache=sampleCache))
	sample.freeze(0.5)
	return sample


def both(sample):
	"""The scene of a sample as it is, and with another thickness."""
	return sample.open(), ofThickness(sample, thin)


def test_stress_is_the_tensor_of_stock_yade_times_depth_over_thickness_to_1e9_over_500_steps(frictional):
	"""At less than 1.5e-6 of strain a step: stock YADE lets shear forces grow by half the square of their turn (test_ice_strength.py)."""
	scene = ofThickness(frictional, thin)
	packed, rate = wrapper.RveSample.fromScene(scene), inPlane(0.04, 0.024, -0.064)
	opened = wrapper.OpenRveSample(source=scene)
	with talik.inspect(scene):
		depth = O.cell.hSize[2, 2]
		assert relative(components(opened.stress), components(utils.getStress()) * depth / thin) < 1e-12
		O.cell.velGrad = rate
		assert 0.064 * O.dt < 1.5e-6
		for steps, most in ((1, 1e-12), (499, 1e-9)):
			packed.advance(rate, steps)
			talik.runSerially(steps)
			stock = components(utils.getStress()) * depth / thin
			print(f"\n{steps} steps: packed against stock times {depth:g}/{thin:g}: {relative(packed.stress, stock):.1e}", end="")
			assert relative(packed.stress, stock) < most
			assert relative(packing.stress(), stock) < 1e-15


def test_stiffness_scales_exactly_by_depth_over_thickness(frictional):
	packed = [wrapper.RveSample.fromScene(scene) for scene in both(frictional)]
	opened = [wrapper.OpenRveSample(source=scene) for scene in both(frictional)]
	for form, samples, stressOf in (("packed", packed, np.array), ("open", opened, components)):
		ratios = []
		for gradient in (inPlane(-1e-5), inPlane(0, 1e-5), inPlane(-1e-5, 0, -1e-5)):
			before = [stressOf(sample.stress) for sample in samples]
			for sample in samples:
				sample.apply(gradient, 0)
			deep, shallow = (stressOf(sample.stress) - start for sample, start in zip(samples, before))
			ratios.append(np.linalg.norm(shallow) / np.linalg.norm(deep))
		print(f"\n{form}: stiffness of {thin:g} m over that of 0.1 m: {', '.join(f'{r:.12f}' for r in ratios)}", end="")
		assert ratios == pytest.approx([0.1 / thin] * 3, rel=1e-8)


def test_strength_of_bonds_scales_exactly_by_depth_over_thickness(bonded):
	peaks, broken = [], []
	for sample in (wrapper.RveSample.fromScene(scene) for scene in both(bonded)):
		curve = []
		for _ in range(60):
			sample.advance(inPlane(0.5), 100)
			curve.append(sample.stress[0])
		peaks.append(max(curve))
		broken.append(sample.statistics()["bondsBrokenInTension"])
		assert 0 < max(curve) > curve[-1], "a peak"
	ratio = peaks[1] / peaks[0]
	print(f"\ntensile strength {1e-3 * peaks[0]:.2f} kPa at 0.1 m, {1e-3 * peaks[1]:.2f} kPa at {thin:g} m, ratio {ratio:.12f}; bonds broken {broken}")
	assert broken[0] == broken[1] > 0
	assert ratio == pytest.approx(0.1 / thin, rel=1e-12)


def test_a_prepared_sample_carries_its_pressure_over_its_thickness_and_its_file_keeps_it(sampleCache, tmp_path):
	sample = rve.prepare(grains=60, thickness=thin, pressure=200e3, ice=True, cache=sampleCache)
	loaded, packed = rve.load(sample.path), rve.pack(sample)
	with talik.inspect(packed.open()):
		byYade = components(utils.getStress())
		depth = O.cell.hSize[2, 2]
		O.save(str(tmp_path / "opened.yade.gz"))
	saved = rve.load(str(tmp_path / "opened.yade.gz"))
	print(f"\nprepared at 200 kPa over {thin:g} m: {sample.stress[0]:.0f} and {sample.stress[1]:.0f} Pa; by YADE over {depth:g} m {byYade[0]:.0f} Pa")
	assert sample.thickness == loaded.thickness == saved.thickness == packed.thickness == thin
	assert np.allclose(sample.stress[:2], -200e3, rtol=1e-2)
	assert np.allclose(byYade[:2], -200e3 * thin / depth, rtol=1e-2)
	assert relative(loaded.stress, sample.stress) < 1e-12 and relative(packed.stress[:2], sample.stress[:2]) < 1e-9


def test_samples_prepared_at_one_pressure_are_stiffer_and_stronger_by_the_inverse_of_their_thickness_slow(sampleCache):
	figures = []
	for thickness in (0.1, thin):
		sample = rve.pack(rve.prepare(grains=400, ice=True, thickness=thickness, cache=sampleCache))
		frozen = sample.copy()
		frozen.freeze(1)
		frozen.advance(Matrix3.Zero, 2000)
		moduli = []
		for form, ice in ((sample, 0), (frozen, 1)):
			before, strained = form.stress[1], form.copy()
			strained.apply(inPlane(0, 0, -2e-5), ice)
			moduli.append((strained.stress[1] - before) / -2e-5)
		curve = [frozen.apply(inPlane(0, 0, 1e-4), 1)["stress"][1] for _ in range(50)]
		assert max(curve) > curve[-1], "a peak"
		figures.append((*moduli, max(curve)))
		print(
			f"\n400 discs at 100 kPa, {thickness:g} m: stiffness {1e-6 * moduli[0]:.0f} MPa thawed, {1e-6 * moduli[1]:.0f} MPa frozen, "
			f"tensile strength {1e-6 * max(curve):.2f} MPa",
			end="",
		)
	# two packings of their own: contacts differ in number by a tenth
	assert np.divide(figures[1], figures[0]) == pytest.approx([0.1 / thin] * 3, rel=0.15)


def test_a_prepared_sample_is_brought_to_another_stress_packed_and_by_stock_yade(sampleCache):
	sample, goal = rve.prepare(grains=60, thickness=thin, pressure=200e3, ice=True, cache=sampleCache), (-250e3, -220e3)
	packed, brought = rve.pack(sample), rve.servo(sample, *goal, cache=sampleCache)
	assert packed.servo(*goal)
	print(f"\nasked for {goal} Pa: packed {packed.stress}, by stock YADE {brought.stress}")
	assert np.allclose(packed.stress[:2], goal, rtol=2e-3) and np.allclose(brought.stress[:2], goal, rtol=5e-3)
	assert brought.thickness == thin


def test_a_sample_keeps_its_thickness_opened_repacked_and_in_an_archive(bonded, tmp_path):
	packed = wrapper.RveSample.fromScene(ofThickness(bonded, thin))
	before, scene = packed.stateBytes, packed.open()
	packed.repack(scene)
	assert packed.stateBytes == before
	O.engines = [packed]
	O.save(str(tmp_path / "packed.yade.gz"))
	O.reset()
	O.load(str(tmp_path / "packed.yade.gz"))
	assert O.engines[0].stateBytes == before and O.engines[0].thickness == thin


def test_without_a_thickness_of_its_own_a_sample_has_the_depth_of_its_cell(frictional):
	with talik.inspect(frictional.open()):
		assert "thickness" not in O.tags.keys()
		assert packing.thickness() == O.cell.hSize[2, 2] == 0.1
		assert (packing.stress() == components(utils.getStress())).all()
	assert frictional.thickness == 0.1


@pytest.mark.parametrize("thickness", [0, -0.01, float("nan"), float("inf"), 1e-3, 2.0])
def test_a_thickness_out_of_range_is_refused_with_its_limits(thickness, sampleCache):
	with pytest.raises(ValueError, match="^thickness is .*between the smallest radius, 0.003 m, and 1 m"):
		rve.prepare(thickness=thickness, cache=sampleCache)


@pytest.mark.parametrize("thickness", ["thin", "0", "-1", "nan", "inf", "0.01 m"])
def test_a_scene_with_a_wrong_thickness_is_refused_packed_and_open(thickness, frictional):
	scene = frictional.open()
	with talik.inspect(scene):
		O.tags["thickness"] = thickness
		with pytest.raises(ValueError, match="must be the thickness of the discs in m"):
			packing.stress()
	for make in (wrapper.RveSample.fromScene, lambda s: wrapper.OpenRveSample(source=s).stress):
		with pytest.raises(ValueError, match="must be the thickness of the discs in m"):
			make(scene)
	print(f"\n'{thickness}' is refused packed and open")
