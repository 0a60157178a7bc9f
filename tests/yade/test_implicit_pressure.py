# SPDX-License-Identifier: GPL-2.0-or-later
"""PoreWater(pressure="implicit") as scripts see it."""

import numpy as np
import pytest
from yade import O, wrapper

import talik
from talik import checkpoint
from talik.geometry import rectangle


def slope(boundaries=(), **water):
	mpm = wrapper.MpmEngine(
		gridSpacing=0.25,
		lower=(0, 0),
		upper=(2, 2),
		gravity=(0, -9.81),
		skeleton=wrapper.MohrCoulombSkeleton(young=1e7, youngFrozen=1e8, cohesionFrozen=2e5),
		heat=wrapper.HeatTransfer(thermalTimeScale=1e6),
		freezing=wrapper.FreezingCurve(),
		water=wrapper.PoreWater(**water),
		boundaries=[
			*(wrapper.RollerBoundary(region=side) for side in ("left", "bottom")),
			wrapper.DrainedBoundary(region="surface"),
			wrapper.SurfaceTemperature(region="surface", temperature=5),
			*boundaries,
		],
	)
	talik.geometry.fill(mpm, rectangle(0, 0, 1.5, 1), pointsPerCell=4, temperature=-1)
	O.reset()
	O.engines = [mpm]
	return mpm


def test_the_stiffness_of_water_does_not_limit_the_step():
	steps = {}
	for pressure in ("explicit", "implicit"):
		for modulus in (2.2e7, 2.2e9):
			mpm = slope(pressure=pressure, bulkModulus=modulus)
			mpm.initialise()
			steps[pressure, modulus] = mpm.timeStepLimits()["wave"]
	print("time step [s]:", steps, "reference: that of the skeleton, the same with any stiffness of water")
	assert steps["implicit", 2.2e9] == steps["implicit", 2.2e7] > steps["explicit", 2.2e7] > steps["explicit", 2.2e9]


def test_a_checkpoint_of_ground_with_implicit_pressure_goes_on_to_the_same_bits(tmp_path):
	mpm = slope(pressure="implicit", conductivity=1e-5)
	O.run(150, True)
	checkpoint.write(tmp_path / "slope.checkpoint")
	O.run(100, True)
	expected = {name: mpm.field(name) for name in ("position", "pressure", "temperature", "stress")}
	mpm = talik.resume(tmp_path / "slope.checkpoint")
	O.run(100, True)
	differing = sum(int(np.any(mpm.field(name) != values)) for name, values in expected.items())
	print("fields that differ:", differing, "reference: 0, tolerance: 0")
	assert differing == 0


def test_water_is_as_stiff_as_it_is_with_implicit_pressure_unless_told_otherwise():
	skempton = {}
	for pressure in ("explicit", "implicit"):
		mpm = slope(pressure=pressure)
		mpm.skeleton.youngFrozen = mpm.skeleton.young  # soil that has thawed: frozen ground bears more itself
		O.step()
		skempton[pressure] = mpm.skemptonB()
	print("Skempton's B:", skempton, "reference: 0.99 and more with the stiffness of water, tolerance: 0")
	assert skempton["implicit"] >= 0.99 > skempton["explicit"]


@pytest.mark.parametrize(
	"settings, words",
	[
		(dict(water=dict(pressure="semi")), "PoreWater.pressure is 'semi': choose explicit or implicit"),
		(dict(water=dict(pressure="implicit", massCoefficient="printed")), "massCoefficient"),
		(dict(water=dict(pressure="implicit"), bBar=False), "bBar"),
	],
	ids=["name", "printed", "bBar"],
)
def test_what_implicit_pressure_does_not_serve_is_refused_with_a_remedy(settings, words):
	mpm = slope(**settings["water"])
	mpm.bBar = settings.get("bBar", True)
	with pytest.raises((ValueError, RuntimeError), match=words):
		O.step()
