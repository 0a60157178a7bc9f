# SPDX-License-Identifier: GPL-2.0-or-later
"""Strength of frozen samples that have thawed and frozen again, and stiffness over temperature.

Laboratory: sand thaws and refreezes with a contraction in the first cycle, also where it is dense (Kim, Park, Cha, Lee & Santamarina 2021,
doi 10.1061/(ASCE)GT.1943-5606.0002464, abstract); the frozen strength of sand with up to 30 % of silt grows by that densification (Lee, Yu, Han & Kim
2020, Sensors 20:5381, abstract: three cycles with repeated loads, compressed at -5 degC).
"""


import numpy as np
import pytest
from yade import O, wrapper

from talik import rve
from talik.studies import calibrate, refrozen


@pytest.fixture(scope="module")
def samples(sampleCache):
	return rve.pack([rve.prepare(grains=100, seed=seed, ice=True, cache=sampleCache) for seed in (1, 8, 2001)])


def outcomes(samples, past):
	return [refrozen.test(sample, refrozen.pasts[past]) for sample in samples]


def strengths(found):
	return np.array([outcome.compression.deviator.max() for outcome in found])


def test_a_sample_that_thaws_and_freezes_again_under_isotropic_stress_is_as_strong_as_before(samples):
	"""New ice is free of stress, and grains that are pressed from all sides alike stay where they are."""
	never, cycled = (outcomes(samples, past) for past in ("never thawed", "three cycles under isotropic stress"))
	ratios = strengths(cycled) / strengths(never)
	print(f"\nstrength over never thawed {np.round(ratios, 4)}; contraction {max(abs(outcome.contracted) for outcome in cycled):.1e}")
	assert np.abs(ratios - 1).max() < 0.01
	assert max(abs(outcome.contracted) for outcome in cycled) < 1e-4


def test_dense_samples_contract_in_the_first_cycle_under_a_deviator_and_are_no_weaker_for_it(samples):
	"""Kim et al. 2021 and Lee et al. 2020. Sand goes on settling in every cycle; samples, whose grains no ice moves, do not."""
	never, one, three = (outcomes(samples, past) for past in ("never thawed", "one cycle under a deviator", "three cycles under a deviator"))
	settled, contracted = (np.array([[getattr(outcome, name) for outcome in found] for found in (one, three)]) for name in ("settled", "contracted"))
	ratios = strengths(one) / strengths(never)
	print(
		f"\nsettled by {100 * settled[0].mean():.2f} % in the first cycle, {100 * (settled[1] - settled[0]).mean():.3f} % in two more; contracted by "
		f"{100 * contracted[0].mean():.2f} %; strength over never thawed {ratios.mean():.2f} +- {ratios.std():.2f}"
	)
	assert (settled[0] > 1e-3).all() and (contracted[0] > 0).all()
	assert 0.95 < ratios.mean() < 1.3
	assert np.abs(settled[1] - settled[0]).max() < 0.2 * settled[0].max()


def test_thaw_and_refreezing_heal_a_sample_that_has_failed(samples):
	never, failed, healed = (outcomes(samples, past) for past in ("never thawed", "failed", "failed, one cycle"))
	left, back = strengths(failed) / strengths(never), strengths(healed) / strengths(never)
	print(f"\nstrength over never thawed: {left.mean():.2f} after failure, {back.mean():.2f} when it has thawed and frozen again")
	assert left.mean() < 0.7 and 0.8 < back.mean() < 1.2


def test_frozen_samples_stiffen_as_the_freezing_curve_turns_their_water_to_ice(samples):
	"""Stiffness of bonds follows S_i and not the temperature: below the freezing range it is constant, as the modulus of frozen Manchester sand over density
	and pressure is (report A309352, 1992); frozen soil goes on stiffening, some 4.5-fold from -2 to -10 degC after Tsytovich (recalled, not read)."""
	mpm = wrapper.MpmEngine(
		gridSpacing=1.0, lower=(0, 0), upper=(6, 1), heat=wrapper.HeatTransfer(), freezing=wrapper.FreezingCurve(), skeleton=wrapper.ElasticSkeleton()
	)
	temperatures = (-0.25, -0.5, -1.0, -2.0, -5.0, -10.0)
	mpm.addPoints(position=np.array([(k + 0.5, 0.5) for k in range(6)]), volume=1.0, porosity=0.4, temperature=np.array(temperatures))
	O.engines = [mpm]
	mpm.initialise()
	ice = mpm.field("iceSaturation")
	stiffness = np.array([np.mean([calibrate.biaxialTest(sample, s, 100e3, 0.01).elasticity()[0] for sample in samples]) for s in ice])
	print("\n" + "; ".join(f"{t:g} degC: S_i {s:.2f}, E {1e-6 * e:.0f} MPa" for t, s, e in zip(temperatures, ice, stiffness)))
	print(f"-10 over -2 degC: {stiffness[-1] / stiffness[3]:.2f}-fold")
	assert (np.diff(stiffness) > -0.02 * stiffness[1:]).all() and stiffness[3] > 2 * stiffness[0]


def test_the_command_writes_table_and_picture_slow(calibrateCommand):
	assert len(calibrateCommand("refrozen", "--grains", "40", "--realisations", "1")) == 2 + len(refrozen.pasts)
