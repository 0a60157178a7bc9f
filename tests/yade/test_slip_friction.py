# SPDX-License-Identifier: GPL-2.0-or-later
"""Friction with which samples slip at the thaw front: what is measured where a scene gives none."""

import math

import numpy as np
import pytest
from fixtures import sixty
from yade import O, wrapper

import talik
from talik import checkpoint, rve
from talik.studies import calibrate


@pytest.fixture(scope="module")
def packed(sampleCache):
	return rve.pack(rve.prepare(**sixty, cache=sampleCache))


def ground(skeleton, thawedAbove=1, **settings):
	"""A block that is frozen below a height [m] and thawed above it."""
	O.reset()
	mpm = wrapper.MpmEngine(
		**{
			**dict(gridSpacing=0.5, gravity=(0, -9.81), skeleton=skeleton, heat=wrapper.HeatTransfer(), freezing=wrapper.FreezingCurve()),
			**settings,
		}
	)
	mpm.boundaries = [wrapper.FixedBoundary(region="bottom")]
	talik.geometry.fill(mpm, talik.geometry.rectangle(0, 0, 1, 2), temperature=lambda x, y: 10.0 * (y > thawedAbove) - 5)
	O.engines = [mpm]
	return mpm


def test_samples_without_a_stated_friction_get_that_of_their_steady_shear_with_its_error_in_one_line(packed, capfd):
	skeleton = wrapper.RveSkeleton(samples=[packed])
	ground(skeleton)
	O.step()
	said = [line for line in capfd.readouterr().err.splitlines() if "slip at the thaw front" in line]
	flowing = calibrate.shearFriction(packed, pressures=(10e3,))
	measured, error = skeleton.measuredFriction, skeleton.measuredFrictionError
	apart = abs(measured - flowing.steadyMean) / math.hypot(error, flowing.steadyError)
	print(
		f"measured {measured:.3f} +- {error:.3f}, by talik.studies.calibrate {flowing.steadyMean:.3f} +- {flowing.steadyError:.3f}: "
		f"{apart:.1f} errors apart, 4 allowed"
	)
	assert len(said) == 1 and f"{measured:.3f}"[:4] in said[0] and math.isnan(skeleton.slipFriction)
	assert 0.15 < measured < 0.45 and 0 < error < 0.03 and apart < 4


def test_the_friction_has_the_same_bits_for_any_number_of_threads(packed):
	found = []
	for threads in (1, 2):
		skeleton = wrapper.RveSkeleton(samples=[packed], threads=threads)
		ground(skeleton)
		O.step()
		found.append(skeleton.measuredFriction)
	print(f"friction {found[0]!r} with one thread, {found[1]!r} with two")
	assert found[0] == found[1]


def test_the_friction_goes_along_in_a_checkpoint(packed, tmp_path):
	skeleton = wrapper.RveSkeleton(samples=[packed])
	ground(skeleton)
	O.step()
	before = skeleton.measuredFriction
	checkpoint.write(tmp_path / "slope")
	mpm = checkpoint.resume(tmp_path / "slope")
	O.step()
	print(f"friction {before!r}, gone on with {mpm.skeleton.measuredFriction!r}")
	assert mpm.skeleton.measuredFriction == before


@pytest.mark.parametrize("without", ("a stated friction", "freezing", "a front", "thaw"))
def test_nothing_is_measured_where_a_friction_is_given_or_samples_meet_no_thaw_front(packed, without):
	skeleton = wrapper.RveSkeleton(samples=[packed], slipFriction=0.2 if without == "a stated friction" else math.nan)
	ground(skeleton, **{"freezing": dict(freezing=None), "a front": dict(thawFront=None), "thaw": dict(thawedAbove=3)}.get(without, {}))
	O.step()
	assert math.isnan(skeleton.measuredFriction)


def test_samples_that_run_open_are_measured_too(sampleCache):
	scene = rve.openScene(rve.prepare(**sixty, cache=sampleCache))
	skeleton = wrapper.RveSkeleton(scenes=[scene], form="open")
	ground(skeleton)
	O.step()
	print(f"open: {skeleton.measuredFriction:.3f} +- {skeleton.measuredFrictionError:.3f}, from 0.1 to 0.5")
	assert 0.1 < skeleton.measuredFriction < 0.5


def test_steady_friction_has_the_scatter_of_its_realisations_and_depends_on_neither_thaw_strain_nor_bonds(packed):
	icy = packed.copy()
	icy.thawStrain, icy.thawedStrength = 0.1, 1e6
	plain, ofIcy = (calibrate.shearFriction(each, pressures=(8e3,), shear=0.3) for each in (packed, icy))
	both = calibrate.shearFriction([packed, icy], pressures=(8e3,), shear=0.3)
	print(plain.report())
	assert (plain.steady == ofIcy.steady).all() and plain.peakMean == ofIcy.peakMean == calibrate.thawedPeakFriction(packed, pressures=(8e3,))
	assert both.steadyError == 0 and both.steady.shape == (2, 1, 2)
	assert plain.steadyError == pytest.approx(abs(np.subtract(*plain.steady.ravel())) / 2)
	with pytest.raises(ValueError, match="shear is 0.1; give more than 0.15"):
		calibrate.shearFriction(packed, shear=0.1)
