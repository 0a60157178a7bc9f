# SPDX-License-Identifier: GPL-2.0-or-later
"""Stress with which points begin: that of their samples, which are brought to the weight above them; or given, in the order in which it comes out."""

import numpy as np
import pytest
from fixtures import sixty
from yade import O, wrapper

import talik
from talik import rve, slope

block = [(0, 0), (1, 0), (1, 2), (0, 2)]
load = 20e3


@pytest.fixture(scope="module")
def packed(sampleCache):
	return rve.pack(rve.prepare(**sixty, cache=sampleCache))


def column(packed, **settings):
	O.reset()
	mpm = wrapper.MpmEngine(
		gridSpacing=0.5,
		lower=(0, 0),
		upper=(1, 3),
		gravity=(0, -9.81),
		damping=0.5,
		skeleton=wrapper.RveSkeleton(samples=[packed.copy()]),
		heat=wrapper.HeatTransfer(),
		freezing=wrapper.FreezingCurve(),
		**settings,
		boundaries=[
			wrapper.RollerBoundary(region="left"),
			wrapper.RollerBoundary(region="right"),
			wrapper.FixedBoundary(region="bottom"),
			wrapper.SurfaceLoad(region="surface", pressure=load),
		],
	)
	talik.geometry.fill(mpm, block, pointsPerCell=4, temperature=-5)
	O.engines = [mpm]
	return mpm


def run(duration):
	end = O.time + duration
	while O.time < end:
		talik._talik.runSerially(20)


def riseOnThaw(mpm):
	"""Of the top, from frozen at rest to thawed at rest [m]."""
	run(0.3)
	frozen = mpm.field("displacement")[-1, 1]
	for temperature in (-0.5, -0.2, -0.05, 0.5):
		mpm.setTemperature(temperature)
		run(0.1)
	run(0.3)
	return mpm.field("displacement")[-1, 1] - frozen


def test_a_loaded_column_of_settled_samples_does_not_rise_as_it_thaws(packed):
	rises = {}
	for settled in (False, True):
		mpm = column(packed)
		if settled:
			slope.settle(mpm, block, load=load)
		rises[settled] = riseOnThaw(mpm)
	print(
		f"2 m under 20 kPa without thaw strain: rise of the top on thaw {1e3 * rises[False]:.2f} mm with samples of 100 "
		f"kPa, {1e3 * rises[True]:.2f} mm settled; exact 0"
	)
	assert rises[False] > 4e-3 and abs(rises[True]) < 1e-3 and abs(rises[True]) < 0.12 * rises[False]


def test_settled_samples_carry_the_weight_and_the_load_above_them_at_the_start(packed):
	mpm = column(packed)
	slope.settle(mpm, block, bandThickness=0.25, load=load)
	depth = 2 - mpm.field("position")[:, 1]
	masses = mpm.balance()
	weight = 9.81 * (masses["solidMass"] + masses["waterMass"]) / 2
	stress = mpm.field("stress")
	print(
		f"{len(mpm.skeleton.samples)} samples; vertical stress over that of weight and load "
		f"{np.min(stress[:, 1] / -(load + weight * depth)):.3f} to {np.max(stress[:, 1] / -(load + weight * depth)):.3f}"
	)
	assert np.allclose(stress[:, 1], -(load + weight * depth), rtol=0.01) and np.allclose(stress[:, 0], 0.7 * stress[:, 1], rtol=0.02)


def test_what_pore_water_carries_settled_samples_do_not(packed):
	O.reset()
	wet = wrapper.MpmEngine(
		gridSpacing=0.5,
		lower=(0, 0),
		upper=(1, 3),
		gravity=(0, -9.81),
		skeleton=wrapper.RveSkeleton(samples=[packed.copy()]),
		water=wrapper.PoreWater(),
		boundaries=[wrapper.RollerBoundary(region=side) for side in ("left", "right", "bottom")],
	)
	talik.geometry.fill(wet, block, pressure=lambda x, y: 9810 * (2 - y))
	slope.settle(wet, block, bandThickness=0.25)
	depth = 2 - wet.field("position")[:, 1]
	due = -9.81 * 0.6 * (2650 - 1000) * depth
	below = depth > 0.5
	print(
		f"vertical effective stress over that of submerged weight {(wet.field('stress')[:, 1] / due)[below].min():.3f} "
		f"to {(wet.field('stress')[:, 1] / due)[below].max():.3f}"
	)
	assert np.allclose(wet.field("stress")[below, 1], due[below], rtol=0.02)


@pytest.mark.parametrize(
	"change, sentence",
	[
		(lambda mpm: setattr(mpm, "skeleton", wrapper.ElasticSkeleton()), "has no samples to settle"),
		(lambda mpm: setattr(mpm, "gravity", (0, 0)), "nothing weighs on the samples"),
		(lambda mpm: talik._talik.runSerially(1), "the ground has begun"),
	],
)
def test_what_cannot_be_settled_is_refused(packed, change, sentence):
	mpm = column(packed)
	change(mpm)
	with pytest.raises(ValueError, match=sentence) as refusal:
		slope.settle(mpm, block)
	print(refusal.value)


def test_a_stress_given_to_points_with_samples_is_refused_because_samples_begin_with_their_own(packed):
	mpm = column(packed)
	mpm.addPoints(position=[(0.25, 2.25)], volume=0.25, temperature=-5, stress=(-1e3, -2e3, -1.5e3, 0))
	with pytest.raises(ValueError, match="stress of point 32 is given, but its RveSkeleton begins with the stress of its sample: .*settle") as refusal:
		mpm.initialise()
	print(refusal.value)


def test_stress_goes_in_as_it_comes_out_and_another_number_of_components_is_told():
	O.reset()
	mpm = wrapper.MpmEngine(gridSpacing=0.5, lower=(0, 0), upper=(1, 1), skeleton=wrapper.ElasticSkeleton())
	position, volume = talik.geometry.fillPolygon(talik.geometry.rectangle(0, 0, 1, 1), 0.5)
	given = np.arange(len(position))[:, None] * 10 + np.array([-1e3, -2e3, -3e3, 4e2])
	mpm.addPoints(position=position, volume=volume, stress=given)
	assert (mpm.field("stress") == given).all()
	for wrong in ((-1e3, -2e3, 0), given[:, :3]):
		with pytest.raises(
			ValueError, match="stress has .* numbers for 16 points: give 4 or 64, in the order of field\\('stress'\\): xx, yy, zz, xy"
		) as refusal:
			mpm.addPoints(position=position + 1, volume=volume, stress=wrong)
		print(refusal.value)
