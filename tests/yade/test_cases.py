# SPDX-License-Identifier: GPL-2.0-or-later
"""What the two thaw slumps rest on and what they show, at reduced size."""

import numpy as np
import pytest
from yade import Matrix3

import talik
from talik import rve, slope

rest = Matrix3.Zero


@pytest.fixture(scope="module")
def sample():
	return slope.pack(rve.prepare(grains=100, ice=True))


# ---- ice-rich samples -----------------------------------------------------------------------------------------------------


def grainArea(sample):
	return np.sum(sample.arrays()["radius"] ** 2)


@pytest.mark.parametrize("thawStrain", [0.0, 0.03, 0.15])
def test_thawing_grains_release_the_area_strain_asked_for_and_freezing_none(sample, thawStrain):
	icy = sample.copy()
	icy.thawStrain = thawStrain
	before = grainArea(icy)
	icy.freeze(0.95)
	assert grainArea(icy) == before
	for saturation in (0.4, 0.0, 0.95):
		icy.apply(rest, saturation)
		lowest = min(saturation, 0.4) if saturation < 0.95 else 0.0
		expected = 1 - thawStrain * (1 - lowest / 0.95)
		print(f"S_i = {saturation}: area of the grains {grainArea(icy) / before:.12f}, eq. (8) {expected:.12f}")
		assert grainArea(icy) / before == pytest.approx(expected, abs=1e-12)


def test_a_sample_held_while_it_thaws_keeps_its_stress_without_thaw_strain_and_loses_it_with_a_few_per_cent(sample):
	for thawStrain, kept in ((0.0, True), (0.03, False)):
		icy = sample.copy()
		icy.thawStrain = thawStrain
		icy.freeze(0.95)
		icy.apply(rest, 0.0)
		icy.advance(rest, 4000)
		pressure = -0.5 * (icy.stress[0] + icy.stress[1])
		print(f"thaw strain {thawStrain}: pressure {pressure / 1e3:.2f} kPa of 100 kPa")
		assert (pressure > 80e3) == kept
		assert kept or pressure == pytest.approx(0, abs=10)


@pytest.mark.parametrize("value", [-0.01, 0.3, float("nan")])
def test_an_impossible_thaw_strain_is_refused_by_name(sample, value):
	with pytest.raises(ValueError, match="RveSample.thawStrain is"):
		sample.copy().thawStrain = value


def test_thaw_strain_comes_before_the_ice(sample):
	frozen = sample.copy()
	frozen.freeze(0.9)
	with pytest.raises(ValueError, match="before the sample freezes"):
		frozen.thawStrain = 0.03
