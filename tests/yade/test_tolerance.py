# SPDX-License-Identifier: GPL-2.0-or-later
"""MpmEngine.tolerance: error as an input, and the estimate of it against the error it made.

The true error is that of effective stress, root mean square over points and forty instants, against the same ground whose samples are
asked in every step at an inertial number of 2e-4, twenty-five times below that of production."""


import numpy as np
import pytest
from yade import O, wrapper

import talik
import thaw_slump_surface
import thawslump
from talik import rve

instants = 40
referenceInertialNumber = 2e-4


@pytest.fixture(scope="module")
def sample(sampleCache):
	return rve.pack(rve.prepare(grains=60, seed=3, cache=sampleCache))


def at(sample, lateral, vertical):
	"""The sample brought to a stress [Pa, compression positive]."""
	brought = sample.copy()
	assert brought.servo(-lateral, -vertical)
	return brought


def ground(sample, width, height, velocity=lambda x, y: (0, 0), **settings):
	"""Dry ground, loaded by what its samples carry, on a fixed base."""
	h = 0.25
	mpm = wrapper.MpmEngine(
		gridSpacing=h,
		lower=(-width, 0),
		upper=(2 * width, height + 2 * h),
		skeleton=wrapper.RveSkeleton(samples=[at(sample, 50e3, 50e3)]),
		boundaries=[wrapper.FixedBoundary(region="bottom"), wrapper.SurfaceLoad(region="surface", pressure=50e3)],
		**settings,
	)
	position, volume = talik.geometry.fillPolygon(talik.geometry.rectangle(0, 0, width, height), h)
	mpm.addPoints(position=position, volume=volume, velocity=[velocity(x, y) for x, y in position])
	return mpm


def compressedColumn(sample):
	"""A wave of compression to 0.3 % runs through a column and back."""
	mpm = ground(sample, 0.25, 1.5, velocity=lambda x, y: (0, -0.25 * y))
	mpm.lower, mpm.upper = (0, 0), (0.25, 2)
	mpm.boundaries = mpm.boundaries + [wrapper.RollerBoundary(region="left"), wrapper.RollerBoundary(region="right")]
	return mpm, 0.15


def shearedBlock(sample):
	"""A block is sheared to failure, 3 %."""
	return ground(sample, 0.75, 0.75, velocity=lambda x, y: (y, 0)), 0.03


def thawingColumn(sample):
	"""Ice-bonded ground thaws from its surface under its own weight."""
	h, height = 0.25, 2.0
	mpm = wrapper.MpmEngine(
		gridSpacing=h,
		lower=(0, 0),
		upper=(h, height + 2 * h),
		gravity=(0, -9.81),
		damping=0.1,
		skeleton=wrapper.RveSkeleton(samples=[at(sample, 0.7 * p, p) for p in (3e3, 13e3, 23e3, 33e3)]),
		heat=wrapper.HeatTransfer(thermalTimeScale=8.64e5),
		freezing=wrapper.FreezingCurve(),
		water=wrapper.PoreWater(bulkModulus=2.2e7),
		boundaries=[wrapper.FixedBoundary(region="bottom"), wrapper.RollerBoundary(region="left"), wrapper.RollerBoundary(region="right")]
		+ [wrapper.DrainedBoundary(region="surface", recharge=False), wrapper.SurfaceTemperature(region="surface", times=[0, 8.64e4], values=[-5, 10])],
	)
	position, volume = talik.geometry.fillPolygon(talik.geometry.rectangle(0, 0, h, height), h)
	mpm.skeleton.sampleOf = [int((height - y) / 0.5) for _, y in position]
	mpm.addPoints(position=position, volume=volume, temperature=-5.0)
	return mpm, 1.0


def stresses(build, sample, tolerance=0.0):
	"""Effective stress of all points at forty instants and the engine; tolerance 0: the reference."""
	O.reset()
	mpm, end = build(sample)
	mpm.tolerance = tolerance
	if tolerance == 0:
		mpm.skeleton.strainTolerance = mpm.skeleton.saturationTolerance = 0
		mpm.skeleton.maxInertialNumber = referenceInertialNumber
	O.engines = [mpm]
	records = []
	for instant in np.linspace(0, end, instants + 1)[1:]:
		while O.time < instant:
			O.step()
		records.append(mpm.field("stress")[:, [0, 1, 3, 3]])
	return np.array(records), mpm


@pytest.mark.parametrize("build", (compressedColumn, shearedBlock, thawingColumn))
def test_the_estimated_error_is_the_true_one_within_a_factor_of_three(build, sample):
	exact, mpm = stresses(build, sample)
	calls = mpm.skeleton.cost()["calls"]
	for tolerance in (0.1, 0.03):
		reached, mpm = stresses(build, sample, tolerance)
		error, estimated = np.sqrt(np.sum((reached - exact) ** 2) / np.sum(exact**2)), mpm.estimatedError
		fewer = calls / mpm.skeleton.cost()["calls"]
		print(
			f"{build.__name__}, tolerance {tolerance}: estimated {estimated:.4f}, true {error:.4f}, ratio {estimated / error:.2f}, 1/{fewer:.1f} of the calls"
		)
		assert 1 / 3 < estimated / error < 3
		assert fewer > 1


def test_answers_for_the_ice_leave_the_strain_tolerance_as_it_is(sample):
	"""Ground that thaws under its fixed sides, without a load: its samples are asked a hundred times and never strained."""
	O.reset()
	mpm = wrapper.MpmEngine(
		gridSpacing=0.25,
		lower=(0, 0),
		upper=(0.5, 0.5),
		skeleton=wrapper.RveSkeleton(samples=[sample.copy()]),
		heat=wrapper.HeatTransfer(),
		freezing=wrapper.FreezingCurve(),
		boundaries=[wrapper.FixedBoundary(region=side) for side in ("left", "right", "bottom", "top")],
	)
	talik.geometry.fill(mpm, talik.geometry.rectangle(0, 0, 0.5, 0.5), temperature=-5.0)
	O.engines = [mpm]
	O.step()
	for temperature in np.linspace(-2, 0.5, 101):
		mpm.setTemperature(temperature)
		O.step()
	calls, strainTolerance = mpm.skeleton.cost()["calls"] / mpm.pointCount, mpm.field("skeleton0.strainTolerance")
	print(f"{calls:.0f} calls of each sample, strain tolerance {strainTolerance.min():g} to {strainTolerance.max():g}, given {mpm.skeleton.strainTolerance:g}")
	assert calls > 20 and mpm.field("iceSaturation").max() == 0
	assert np.all(strainTolerance == mpm.skeleton.strainTolerance)


def test_tolerance_leaves_no_trace_where_it_is_not_set(sample):
	fields = {}
	for tolerance in (0, 0.03):
		O.reset()
		mpm, _ = shearedBlock(sample)
		mpm.tolerance = tolerance
		O.engines = [mpm]
		O.step()
		fields[tolerance] = {info["name"].split(".")[-1] for info in mpm.fields()}
		assert (mpm.estimatedError is None) == (tolerance == 0)
	added = fields[0.03] - fields[0]
	print(f"fields with a tolerance only: {', '.join(sorted(added))}")
	assert fields[0] < fields[0.03] and added == {
		"inertialNumber",
		"predictionError",
		"rateError",
		"stepsSinceCall",
		"callsOfSample",
		"errorSquares",
		"stressSquares",
	}


@pytest.mark.parametrize(
	"change, remedy",
	(
		(dict(tolerance=-0.1), "MpmEngine.tolerance is -0.1"),
		(dict(tolerance=2.0), "MpmEngine.tolerance is 2"),
		(dict(tolerance=float("nan")), "MpmEngine.tolerance is nan"),
		(dict(tolerance=0.03, strainTolerance=0.0), "strainTolerance above 0"),
		(dict(tolerance=0.03, prediction=False), "prediction=True"),
		(dict(tolerance=0.03, form="open"), "MpmEngine.tolerance needs packed samples"),
	),
)
def test_a_tolerance_that_cannot_be_kept_is_refused(sample, change, remedy):
	mpm, _ = shearedBlock(sample)
	for name, value in change.items():
		setattr(mpm if name == "tolerance" else mpm.skeleton, name, value)
	with pytest.raises(ValueError, match=remedy):
		mpm.initialise()


def test_tolerance_may_be_changed_while_running_but_not_switched(sample):
	mpm, _ = shearedBlock(sample)
	mpm.tolerance = 0.1
	O.engines = [mpm]
	O.step()
	mpm.tolerance = 0.03
	O.step()
	mpm.tolerance = 0
	with pytest.raises(ValueError, match="begin anew"):
		mpm.stableTimeStep()
	mpm.tolerance = 0.03
	O.step()
	assert O.iter == 3


def slumped(folder, tolerance, heavier=0.0, days=20):
	"""Largest displacement [m], thawed volume [m2] and sample calls of Case I on cells of 0.5 m after some days of heat; tolerance 0: the reference.
	heavier: part by which gravity differs, for twins."""
	O.reset()
	preset = thawslump.Preset(gridSpacing=0.5, grains=60, days=days)
	case = thawslump.ThawSlump(thaw_slump_surface.case, preset, folder)
	mpm, O.engines = case.mpm, [case.mpm]
	mpm.tolerance, mpm.gravity = tolerance, mpm.gravity * (1 + heavier)
	if tolerance == 0:
		case.skeleton.strainTolerance = case.skeleton.saturationTolerance = 0
		case.skeleton.maxInertialNumber = referenceInertialNumber
	case.rest()
	frozen = mpm.field("iceSaturation").max()
	talik.runUntilDay(mpm, preset.days)
	runOut = np.linalg.norm(mpm.field("displacement"), axis=1).max()
	return runOut, np.sum((1 - mpm.field("iceSaturation") / frozen) * mpm.field("volume")), case.counters()["calls"]


# Runs that differ by one part in 1e9 of gravity are apart by chance: means of three are compared.
def test_on_the_slump_a_tolerance_of_one_per_cent_saves_nine_tenths_of_the_calls_at_less_than_five_per_cent_slow(tmp_path):
	"""Case I after twenty days, amid its slide: the path doubles within four days there."""
	twins = (0.0, 1e-9, -1e-9)
	asked = np.array([slumped(tmp_path, 0, twin) for twin in twins])
	saved = np.array([slumped(tmp_path, 0.01, twin) for twin in twins])
	for name, runs in (("tolerance zero", asked), ("tolerance 0.01", saved)):
		print(f"{name}: largest displacement {runs[:, 0]} m, thawed {runs[:, 1]} m2, sample calls {runs[:, 2]}")
	runOut, thawed, calls = saved.mean(axis=0) / asked.mean(axis=0)
	print(f"errors of the means: displacement {100 * (runOut - 1):+.2f} %, thawed {100 * (thawed - 1):+.3f} %; calls 1/{1 / calls:.0f}")
	assert abs(runOut - 1) < 0.05 and abs(thawed - 1) < 0.005
	assert calls < 1 / 10
