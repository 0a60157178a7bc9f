# SPDX-License-Identifier: GPL-2.0-or-later
"""What realisations of one sample measure, and the cohesion that thawed bonds leave, at reduced size."""

import numpy as np
import pytest

from talik import rve
from talik.studies import calibrate


@pytest.fixture(scope="module")
def several(sampleCache):
	return rve.pack([rve.prepare(grains=40, seed=seed, cache=sampleCache) for seed in (3, 13, 18)])


def test_scatter_over_realisations_is_that_of_their_own_tests(several):
	said = []
	scatter = calibrate.scatterOf(several, strain=0.01)
	tests = [calibrate.biaxialTest(sample, 0.0, pressure, 0.01) for sample in several for pressure in (30e3, 100e3)]
	sines = np.array([test.peak[1] / test.peak[0] for test in tests]).reshape(3, 2).mean(axis=1)
	said.append(scatter.row())
	print(scatter.row())
	assert list(scatter.shearFriction) == [calibrate.thawedPeakFriction(sample) for sample in several]
	assert np.allclose(np.sin(np.radians(scatter.frictionAngle)), sines, rtol=1e-12)
	assert scatter.grains == 40 and (scatter.frozenStrength > 100e3).all() and (scatter.frozenYoung > 2 * scatter.young).all()
	assert f"{scatter.frictionAngle.mean():.1f} ± {scatter.frictionAngle.std(ddof=1):.1f}" in said[0]


def test_bonds_that_outlast_their_ice_give_thawed_ground_the_cohesion_asked_for(several):
	strength, measured = calibrate.thawedStrength(several, 4e3)
	none = np.mean([calibrate.thawedCohesion(sample, 0.0) for sample in several])
	print(f"bonds of {1e-6 * strength:.2f} MPa: {1e-3 * measured:.2f} kPa measured where 4 kPa were asked for; without them {none:.1e} kPa")
	assert measured == pytest.approx(4e3, rel=0.1) and abs(none) < 1e-6


def test_the_cohesion_of_thawed_bonds_is_the_same_at_every_pressure(several):
	"""Coulomb's law for a direct shear box: shear strength over normal stress is a line, and bonds raise it without turning it."""
	pressures = (2e3, 4e3, 8e3)
	cohesions = np.array([[calibrate.thawedCohesion(sample, 0.6e6, (pressure,)) for pressure in pressures] for sample in several]).mean(axis=0)
	print(", ".join(f"{1e-3 * cohesion:.2f} kPa at {1e-3 * pressure:g} kPa" for pressure, cohesion in zip(pressures, cohesions)))
	assert np.ptp(cohesions) < 0.2 * cohesions.mean()


def test_bonds_that_outlast_their_ice_carry_tension_up_to_the_apex_of_the_cone_of_mohr_and_coulomb(several):
	"""c cot(phi) is the largest tension of ground whose strength is a straight line of cohesion c and friction angle phi."""
	strength = 0.6e6
	tension, none = calibrate.thawedTension(several, strength), calibrate.thawedTension(several, 0.0)
	cohesion = np.mean([calibrate.thawedCohesion(sample, strength) for sample in several])
	friction = np.mean([calibrate.thawedShearStrength(sample, 8e3) for sample in several]) / 8e3
	apex = cohesion / friction
	print(f"tension {1e-3 * tension:.2f} kPa, {100 * tension / apex:.0f} % of c cot(phi); without bonds {1e-3 * none:.2f} kPa")
	assert 0.1 * apex < tension < apex and none < 0.02 * tension


def test_a_law_calibrated_on_realisations_has_the_friction_that_fits_all_of_their_tests(several):
	settings = dict(iceSaturations=(0.0, 1.0), pressures=(30e3, 100e3), strain=0.01)
	together, alone = calibrate.calibrate(several, **settings), [calibrate.calibrate(sample, **settings) for sample in several]
	angles = [one.frictionAngle for one in alone]
	print(
		f"friction angles alone {', '.join(f'{angle:.1f}' for angle in angles)}, together {together.frictionAngle:.1f} deg; E {1e-6 * together.young[0]:.1f} MPa"
	)
	assert len(together.tests) == 12 and min(angles) < together.frictionAngle < max(angles)
	assert together.young[0] == pytest.approx(np.mean([one.young[0] for one in alone]), rel=1e-12)


@pytest.mark.parametrize("cohesion", (-1, float("nan"), float("inf")))
def test_a_cohesion_without_sense_is_refused(several, cohesion):
	with pytest.raises(ValueError, match="thawed cohesion is"):
		calibrate.thawedStrength(several, cohesion)
