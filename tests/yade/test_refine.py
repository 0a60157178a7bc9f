# SPDX-License-Identifier: GPL-2.0-or-later
"""An analytic skeleton is swapped for samples, and back, while the ground runs."""

import numpy as np
import pytest
from yade import O

import talik

column = talik.geometry.rectangle(0, 0, 1, 2)


@pytest.fixture(scope="module")
def sample():
	return talik.rve.pack(talik.rve.prepare(grains=60, seed=3))


def restingColumn(temperature=-1.0, **settings):
	"""A frozen column two metres high at rest under its weight."""
	freezing = dict(heat=HeatTransfer(), freezing=FreezingCurve()) if temperature < 0 else {}
	mpm = MpmEngine(
		gridSpacing=0.25,
		lower=(0, 0),
		upper=(1, 2.5),
		gravity=(0, -9.81),
		damping=0.7,
		skeleton=MohrCoulombSkeleton(young=50e6, cohesion=5e3),
		**freezing,
		boundaries=[RollerBoundary(region="left"), RollerBoundary(region="right"), FixedBoundary(region="bottom")],
		**settings,
	)
	talik.geometry.fill(
		mpm,
		column,
		pointsPerCell=1,
		temperature=temperature,
		stress=lambda x, y: np.stack([-0.6 * (2 - y) * 19e3, -(2 - y) * 19e3, -0.8 * (2 - y) * 19e3, 0 * y], axis=-1),
	)
	O.engines = [mpm]
	O.run(600, True)
	return mpm


def whole(mpm):
	return {name: mpm.field(name) for name in mpm.fieldNames()}


@pytest.mark.parametrize("stress", [(-50e3, -80e3, 0), (-80e3, -50e3, 15e3), (-5e3, -9e3, -1e3)])
@pytest.mark.parametrize("iceSaturation", [0.0, 0.6])
def test_a_sample_is_brought_to_any_stress_that_grains_carry(sample, stress, iceSaturation):
	copy = sample.copy()
	talik.refinement.bringTo(copy, stress, iceSaturation)
	error = np.abs(np.array(copy.stress) - stress).max() / np.abs(stress).max()
	print(f"stress {stress} Pa at S_i = {iceSaturation}: missed by {error:.1e} of its largest component (limit 2e-3)")
	assert error < 2e-3


def test_bonds_carry_the_tension_and_shear_that_grains_cannot(sample):
	for goal in ((30e3, -40e3, 0.0), (-20e3, -20e3, 60e3)):
		copy = sample.copy()
		talik.refinement.bringTo(copy, goal, 1.0)
		error = np.abs(np.array(copy.stress) - goal).max() / np.abs(goal).max()
		print(f"stress {goal} Pa at S_i = 1: missed by {error:.1e} of its largest component, {copy.statistics()['bondsBroken']} bonds broken")
		assert error < 2e-3
	with pytest.raises(talik.refinement.StressNotReached, match="xx, yy, xy"):
		talik.refinement.bringTo(sample.copy(), (30e3, -40e3, 0.0), 0.0)


@pytest.mark.parametrize("temperature", [-1.0, 5.0])
def test_ground_at_rest_stays_at_rest_when_samples_come_and_go(sample, temperature):
	mpm = restingColumn(temperature)
	before, start = mpm.field("stress"), mpm.field("displacement")
	law = talik.refine(mpm, where=lambda x, y: (y > 0.5) & (y < 1.5), sample=sample)
	chosen = np.array(mpm.skeletonOf) == 1
	jump = np.abs(mpm.field("stress") - before)[:, (0, 1, 3)].max() / np.abs(before).max()
	assert chosen.sum() == mpm.pointCount // 2 and law.cost()["points"] == chosen.sum()
	O.run(400, True)
	withSamples = np.abs(mpm.field("displacement") - start).max()
	assert np.isfinite(mpm.field("bondsIntact")[chosen]).all() and np.isnan(mpm.field("bondsIntact")[~chosen]).all()
	talik.coarsen(mpm, where=chosen, skeleton=mpm.skeletons[0])
	assert set(mpm.skeletonOf) == {0} and len(mpm.skeletons) == 1 and "bondsIntact" not in mpm.fieldNames()
	O.run(400, True)
	after = np.abs(mpm.field("displacement") - start).max()
	print(
		f"{temperature} degC: stress jumps by {jump:.1e} of its largest value, then the column moves "
		f"{1e3 * withSamples:.4f} mm, {1e3 * after:.4f} mm after the way back"
	)
	assert jump < 3e-3
	assert max(withSamples, after) < 2e-4


def test_an_exchange_for_the_same_law_changes_no_bit():
	through = restingColumn()
	O.run(50, True)
	expected = whole(through)
	mpm = restingColumn()
	mpm.exchangeSkeletons(mpm.skeletons or [mpm.skeleton], mpm.skeletonOf)
	O.run(50, True)
	assert all(np.array_equal(expected[name], values) for name, values in whole(mpm).items())


def test_refined_ground_is_saved_and_goes_on_bit_for_bit(sample, tmp_path):
	mpm = restingColumn()
	talik.refine(mpm, where=lambda x, y: y > 1.5, sample=sample)
	O.run(30, True)
	O.save(str(tmp_path / "refined.yade.gz"))
	O.run(50, True)
	expected = whole(mpm)
	O.load(str(tmp_path / "refined.yade.gz"))
	O.run(50, True)
	assert all(np.array_equal(expected[name], values, equal_nan=True) for name, values in whole(O.engines[0]).items())


def test_points_that_keep_their_samples_keep_their_history(sample):
	mpm = restingColumn()
	first = talik.refine(mpm, where=lambda x, y: y > 1, sample=sample)
	O.run(100, True)
	kept = np.flatnonzero((np.array(mpm.skeletonOf) == 1) & (mpm.field("position")[:, 1] > 1.5))
	states = {int(i): bytes(first.sample(int(i)).stateBytes) for i in kept}
	talik.coarsen(mpm, where=lambda x, y: y < 1.5, skeleton=mpm.skeletons[0])
	talik.refine(mpm, where=lambda x, y: y < 0.5, sample=sample)
	assert all(bytes(first.sample(i).stateBytes) == state for i, state in states.items())
	assert len(mpm.skeletons) == 3
	with pytest.raises(ValueError, match="has no sample"):
		first.sample(0)


def test_a_refused_exchange_leaves_the_ground_as_it_was(sample):
	mpm = restingColumn()
	law = talik.refine(mpm, where=lambda x, y: y > 1, sample=sample)
	before = whole(mpm)
	refusals = [
		(lambda: mpm.exchangeSkeletons([], mpm.skeletonOf), "skeletons is empty"),
		(lambda: mpm.exchangeSkeletons(mpm.skeletons, [0]), "one per point"),
		(lambda: mpm.exchangeSkeletons(mpm.skeletons, [7] * mpm.pointCount), "index into skeletons"),
		(lambda: mpm.exchangeSkeletons([law], [0] * mpm.pointCount), "new RveSkeleton"),
		(lambda: mpm.exchangeSkeletons([MohrCoulombSkeleton(young=-1)], [0] * mpm.pointCount), "young"),
		(lambda: talik.refine(mpm, where=lambda x, y: y > 5, sample=sample), "no point"),
		(lambda: talik.refine(mpm, where=[mpm.pointCount], sample=sample), "names point"),
		(lambda: talik.refine(mpm, where=[True], sample=sample), "boolean"),
		(lambda: talik.coarsen(mpm, where=[0], skeleton=law), "analytic"),
	]
	for attempt, sentence in refusals:
		with pytest.raises(ValueError, match=sentence):
			attempt()
		assert all(np.array_equal(before[name], values, equal_nan=True) for name, values in whole(mpm).items())
	O.run(20, True)
