# SPDX-License-Identifier: GPL-2.0-or-later
"""Samples that differ by chance: prepared several at a time, dealt to the points by a seed."""

import math
import shutil

import numpy as np
import pytest
from yade import O, wrapper

import talik
from talik import checkpoint, realisation, rve, slope

settings = dict(grains=30, porosity=0.19)


@pytest.fixture(scope="module")
def folder(tmp_path_factory):
	return tmp_path_factory.mktemp("realisations")


@pytest.fixture(scope="module")
def several(folder):
	return rve.prepare(**settings, realisations=3, seed=1001, cache=folder)


def test_realisations_are_a_list_of_samples_that_differ_and_each_meets_the_tolerances(several):
	for sample in several:
		print(f"seed {sample.parameters['seed']}: {sample}")
	assert [sample.parameters["seed"] for sample in several] == [1001, 2001, 3001]
	assert len({sample.path for sample in several}) == 3
	for sample in several:
		assert sample.grains == 30 and abs(sample.porosity - 0.19) < 0.005 and abs(sample.pressure / 100e3 - 1) < 0.01


def test_a_realisation_is_the_sample_that_its_seed_gives_alone_made_here_or_by_a_yade_of_its_own(several, tmp_path):
	alone = rve.prepare(**settings, seed=2001, cache=tmp_path)
	one, other = rve.pack(alone), rve.pack(several[1])
	assert one.stateBytes == other.stateBytes
	assert talik._talik.sceneBytes(one.open()) == talik._talik.sceneBytes(other.open())  # colours, tags, speed of the run, too


def test_realisations_in_the_cache_are_not_made_again_and_lacking_ones_are(several, folder, monkeypatch):
	monkeypatch.setattr(realisation, "_byProcesses", lambda *_: pytest.fail("made again"))
	assert rve.prepare(**settings, realisations=3, seed=1001, cache=folder) == several
	monkeypatch.setattr(shutil, "which", lambda _: None)  # no yade to start: they are made here
	more = rve.prepare(**settings, realisations=4, seed=1001, cache=folder)
	assert more[:3] == several and more[3].parameters["seed"] == 4001


def test_a_realisation_that_cannot_be_made_is_told_with_its_seed():
	calls = [dict(grains=5, radius=(3e-3, 7e-3), seed=seed) for seed in (1, 2)]
	with pytest.raises(talik.packing.PackingError, match="realisation with seed .: grains is 5; it must be") as refusal:
		realisation.prepareAll(lambda call: None, lambda call: pytest.fail("made here"), calls, "2 realisations")
	print(refusal.value)


@pytest.mark.parametrize(
	"name, value",
	[
		("realisations", 0),
		("realisations", -3),
		("realisations", 2.5),
		("realisations", True),
		("seed", 1.5),
		("seed", -1),
		("seed", "one"),
		("seed", math.nan),
	],
)
def test_numbers_of_realisations_and_seeds_without_sense_are_refused_by_one_sentence(name, value, tmp_path):
	with pytest.raises(ValueError, match=f"{name} is .*; it must be a whole number, at least") as refusal:
		rve.prepare(**{**settings, "realisations": 2, "cache": tmp_path, name: value})
	print(refusal.value)


@pytest.mark.parametrize("value", (-1, 1.5, "one", math.nan))
def test_seeds_of_a_skeleton_without_sense_are_refused_by_one_sentence(several, value):
	with pytest.raises((ValueError, TypeError), match="RveSkeleton.seed is .*: give a whole number") as refusal:
		mpm = ground(several, seed=value)
		mpm.initialise()
	print(refusal.value)


# ---- dealing --------------------------------------------------------------------------------------------------------------


def ground(several, order=None, **skeleton):
	O.reset()
	mpm = wrapper.MpmEngine(
		gridSpacing=0.25,
		lower=(0, 0),
		upper=(2, 1.5),
		gravity=(0, -9.81),
		skeleton=wrapper.RveSkeleton(samples=rve.pack(several), **skeleton),
		boundaries=[wrapper.RollerBoundary(region=side) for side in ("left", "right", "bottom")],
	)
	position, volume = talik.geometry.fillPolygon(talik.geometry.rectangle(0, 0, 2, 1), 0.25)
	order = np.arange(len(position)) if order is None else order
	mpm.addPoints(position=position[order], volume=volume[order])
	O.engines = [mpm]
	return mpm


def dealt(mpm):
	"""The sample of each point, told by its porosity."""
	porosity = mpm.field("samplePorosity")
	return np.unique(porosity, return_inverse=True)[1]


def test_every_sample_is_dealt_to_its_share_of_the_points_and_neighbours_are_independent(several):
	position, _ = talik.geometry.fillPolygon(talik.geometry.rectangle(0, 0, 30, 10), 0.25)
	numbers = np.array(wrapper.RveSkeleton.deal(position, 8, 1))
	n = len(numbers)
	counts = np.bincount(numbers, minlength=8)
	chi = ((counts - n / 8) ** 2 / (n / 8)).sum()
	columns = np.round((position[:, 0] - position[0, 0]) / 0.125).astype(int)
	neighbours = np.diff(columns) == 1
	alike = np.mean(numbers[1:][neighbours] == numbers[:-1][neighbours])
	spread = math.sqrt(1 / 8 * 7 / 8 / neighbours.sum())
	print(f"{n} points: {counts.tolist()}, chi^2 {chi:.1f} (7 degrees of freedom: 24.3 at 0.1 %); neighbours alike {alike:.4f} (1/8 +- {spread:.4f})")
	assert chi < 24.3 and abs(alike - 1 / 8) < 4 * spread


def test_the_same_seed_deals_alike_whatever_the_order_of_the_points_and_another_seed_otherwise(several):
	first = dealt(ground(several))
	again = dealt(ground(several))
	order = np.random.default_rng(3).permutation(len(first))
	shuffled = dealt(ground(several, order=order))
	other = dealt(ground(several, seed=2))
	print(f"{np.bincount(first).tolist()} points by sample; seed 2 gives {np.mean(first != other):.2f} of them another sample (2/3 by chance)")
	assert (first == again).all() and (first[order] == shuffled).all()
	assert 0.4 < np.mean(first != other) < 0.9 and len(set(first)) == 3


def test_what_was_dealt_lasts_through_a_checkpoint_to_the_last_bit(several, tmp_path):
	mpm = ground(several, seed=5)
	talik._talik.runSerially(10)
	before, dt = dealt(mpm), O.dt
	checkpoint.write(tmp_path / "ground.checkpoint")
	talik._talik.runSerially(10)
	through = mpm.field("stress")
	mpm = checkpoint.resume(tmp_path / "ground.checkpoint")
	assert (dealt(mpm) == before).all() and mpm.skeleton.seed == 5 and O.dt == dt
	talik._talik.runSerially(10)
	assert (mpm.field("stress") == through).all()


def test_depth_bands_deal_realisations_within_every_band(several):
	outline = [(0, 0), (4, 0), (4, 2), (0, 2)]
	position, _ = talik.geometry.fillPolygon(outline, 0.5)
	samples, sampleOf = slope.depthBands(position, outline, rve.pack(several), 2000, bandThickness=1.0)
	numbers = np.array(wrapper.RveSkeleton.deal(position, 3, 1))
	stress = np.array([samples[k].stress[1] for k in sampleOf])
	top = position[:, 1] > 1
	print(f"{len(samples)} samples; {stress[top].mean():.0f} Pa in the upper band, {stress[~top].mean():.0f} Pa in the lower")
	assert len(samples) == 6 and np.allclose(stress[top], -9810, rtol=0.01) and np.allclose(stress[~top], -29430, rtol=0.01)
	for k in range(3):
		assert len({sampleOf[p] for p in np.flatnonzero(top & (numbers == k))}) == 1
	assert slope.depthBands(position, outline, rve.pack(several[0]), 2000, bandThickness=1.0)[1] == [0 if upper else 1 for upper in top]
