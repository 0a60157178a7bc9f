# SPDX-License-Identifier: GPL-2.0-or-later
"""Settings that are valid and yet hardly what was meant are answered by one line each; grounds as people mean them by none."""

import numpy as np
import pytest
from yade import O, wrapper

import talik


def ground(points=None, filled=1, **settings):
	mpm = wrapper.MpmEngine(**{"gridSpacing": 0.25, "lower": (0, 0), "upper": (2, 2), "gravity": (0, -9.81), "skeleton": wrapper.ElasticSkeleton(), **settings})
	position, volume = talik.geometry.fillPolygon([(0, 0), (1, 0), (1, 1), (0, 1)], 0.25)
	for _ in range(filled):
		mpm.addPoints(**{"position": position, "volume": volume, **(points or {})})
	return mpm


def wet(**settings):
	return ground(**{"water": wrapper.PoreWater(), **settings})


def warm(**settings):
	return ground(**{"heat": wrapper.HeatTransfer(), **settings})


def freezing(values, **settings):
	surface = wrapper.SurfaceTemperature(region="surface", days=[50 * k for k in range(len(values))], values=values)
	return wet(heat=wrapper.HeatTransfer(), freezing=wrapper.FreezingCurve(), boundaries=[surface], **settings)


def sparse():
	mpm = ground()
	mpm.gridSpacing = 0.05
	return mpm


def smallOnes():
	return ground(points={"volume": 1e-4})


def skeleton(cls, **settings):
	return ground(skeleton=cls(**settings))


Material, MohrCoulomb = wrapper.GroundMaterial, wrapper.MohrCoulombSkeleton
# what was done: (ground, words in the line, said by the first step unasked)
implausible = {
	"a polygon filled twice": (lambda: ground(filled=2), ("add to 2 m^2", "filled twice"), True),
	"volumes 64 times too large": (lambda: ground(points={"volume": 64 / 64}), ("add to 64 m^2",), True),
	"volumes that leave holes": (smallOnes, ("0.0001 m^2", "0.01562 m^2"), True),
	"points farther apart than the grid can carry": (sparse, ("gridSpacing is 0.05", "farther apart"), True),
	"density in g/cm^3": (lambda: ground(material=Material(solidDensity=2.65)), ("solidDensity is 2.65", "2650"), True),
	"density in g/m^3": (lambda: ground(material=Material(liquidDensity=1e6)), ("liquidDensity is 1e+06", "1000"), True),
	"heat in kJ": (lambda: warm(material=Material(solidSpecificHeat=0.8)), ("solidSpecificHeat is 0.8", "800"), True),
	"latent heat in kJ": (lambda: warm(material=Material(latentHeat=334)), ("latentHeat is 334", "3.34e+05"), True),
	"conductivity in mW": (lambda: warm(material=Material(solidConductivity=2900)), ("solidConductivity is 2900", "2.9"), True),
	"gravity upwards": (lambda: ground(gravity=(0, 9.81)), ("gravity is (0, 9.81)", "(0, -9.81)"), True),
	"initial stress in tension": (lambda: ground(points={"stress": (2e4, 4e4, 3e4, 0)}), ("tensile, up to 4e+04", "negative"), True),
	"permeability in m^2": (lambda: wet(water=wrapper.PoreWater(conductivity=1e-15)), ("conductivity is 1e-15", "1e-14 to 1"), False),
	"conductivity of a pipe": (lambda: wet(water=wrapper.PoreWater(conductivity=20)), ("conductivity is 20", "1e-14 to 1", "0.0002315 (20 m per day)"), False),
	"friction in radians": (lambda: skeleton(MohrCoulomb, frictionAngle=0.5), ("frictionAngle is 0.5", "28.65"), True),
	"load in kPa": (lambda: ground(boundaries=[wrapper.SurfaceLoad(region="surface", pressure=20)]), ("SurfaceLoad.pressure is 20", "2e+04"), False),
	"stress in kPa": (lambda: ground(points={"stress": (-20, -40, -30, 0)}), ("stress is 40", "4e+04"), False),
	"pore pressure in kPa": (lambda: wet(points={"pressure": 10.0}), ("pressure is 10", "1e+04"), False),
	"temperature without heat": (lambda: ground(points={"temperature": -2}), ("temperature is -2 degC", "no heat", "HeatTransfer"), True),
	"pore pressure without water": (lambda: ground(points={"pressure": 2e4}), ("pressure is 2e+04 Pa", "no water", "PoreWater"), True),
	"velocity of rigid ground": (
		lambda: warm(motion=False, points={"velocity": (1, 0), "temperature": -2}),
		("velocity is 1 m/s", "no motion", "motion=True"),
		True,
	),
	"stiffness in MPa": (lambda: skeleton(wrapper.ElasticSkeleton, young=20), ("young is 20", "2e+07"), False),
	"stiffness of creeping ground in GPa": (
		lambda: ground(skeleton=wrapper.CreepingSkeleton(young=9, iceCreep=wrapper.IceCreep()), heat=wrapper.HeatTransfer()),
		("CreepingSkeleton.young is 9",),
		False,
	),
	"days of a temperature given as times": (
		lambda: warm(boundaries=[wrapper.SurfaceTemperature(region="surface", times=[0, 10], values=[-5, 10])]),
		("SurfaceTemperature.times ends at 10 s", "3.162 mm", "days=[0, 10]"),
		False,
	),
	"days of a load given as times": (
		lambda: warm(heat=wrapper.HeatTransfer(thermalTimeScale=1e6), boundaries=[wrapper.SurfaceLoad(region="surface", times=[0, 30], values=[0, 2e4])]),
		("SurfaceLoad.times ends at 30 s", "3e-05 s of motion", "days=[0, 30]"),
		False,
	),
	"ground that freezes and has water to draw": (
		lambda: freezing(points={"temperature": 1.0}, values=[1, -5]),
		("frost heave by segregation", "ice lenses", "cryosuction", "absent", "IceSegregation("),
		False,
	),
	"frozen ground that thaws and freezes again": (lambda: freezing(points={"temperature": -1.0}, values=[-5, 5, -5]), ("frost heave by segregation",), False),
	"cohesion in kPa": (lambda: skeleton(MohrCoulomb, cohesion=5), ("MohrCoulombSkeleton.cohesion is 5", "5000"), False),
	"cohesion in mPa": (lambda: skeleton(MohrCoulomb, cohesion=5e9), ("MohrCoulombSkeleton.cohesion is 5e+09", "5e+06"), False),
	"scale of the calendar upside down": (
		lambda: warm(heat=wrapper.HeatTransfer(thermalTimeScale=1e-7)),
		("thermalTimeScale is 1e-07", "1e+07"),
		False,
	),
	"seconds given as days": (
		lambda: warm(boundaries=[wrapper.SurfaceTemperature(region="surface", days=[0, 864000], values=[-5, 10])]),
		("SurfaceTemperature.days ends at day 8.64e+05", "2366 years", "times="),
		False,
	),
	"pond without its load": (
		lambda: wet(boundaries=[wrapper.DrainedBoundary(region="surface", pressure=2e4)]),
		("DrainedBoundary.pressure is 2e+04", "SurfaceLoad(region='surface',pressure=2e+04)"),
		False,
	),
	"wall where no ground is": (
		lambda: warm(boundaries=[wrapper.WallTemperature(region="top", temperature=-5)]),
		("WallTemperature(region='top')", "1.062 m away", "SurfaceTemperature"),
		True,
	),
	"computed segregation": (
		lambda: freezing(points={"temperature": 1.0}, values=[1, -5], segregation=wrapper.IceSegregation(), water=wrapper.PoreWater(impedance=8)),
		("segregationPotential is not given", "upper bound", "with any PoreWater.impedance"),
		False,
	),
	"rain on ground that may be frozen": (
		lambda: wet(
			heat=wrapper.HeatTransfer(),
			freezing=wrapper.FreezingCurve(),
			points={"temperature": -1},
			boundaries=[wrapper.WaterFlux(region="surface", flux=1e-7, temperature=1)],
		),
		("rain does not run off", "lifts it", "DrainedBoundary"),
		False,
	),
	"rain on full ground that is closed": (
		lambda: wet(boundaries=[wrapper.WaterFlux(region="surface", flux=1e-7)]),
		("rain does not run off", "lifts it", "DrainedBoundary"),
		False,
	),
	"level stress under inclined gravity": (
		lambda: ground(gravity=(3, -9.3), points={"stress": (-2e4, -4e4, -2e4, 0)}),
		("inclined by 17.9 degrees", "no shear", "infiniteColumn"),
		False,
	),
	"excess ice with explicit pressure": (
		lambda: freezing(points={"temperature": -1.0}, values=[-5, 5], material=Material(thawStrain=0.08)),
		("thawStrain is 0.08", "may flow", "pressure='implicit'"),
		False,
	),
	"rain in mm/h": (lambda: wet(boundaries=[wrapper.WaterFlux(region="surface", flux=5)]), ("flux is 5", "1.389e-06"), False),
}


@pytest.mark.parametrize("case", implausible)
def test_a_setting_that_was_hardly_meant_is_named_with_value_and_what_was_probably_meant(case, capfd):
	make, words, grave = implausible[case]
	mpm = make()
	(line,) = talik.check(mpm)
	assert capfd.readouterr().out.strip() == line
	print(line)
	assert all(word in line for word in words), line
	mpm.initialise()
	assert (line in capfd.readouterr().err) == grave
	mpm.initialise()
	assert capfd.readouterr().err == ""


plausible = {
	"as it stands": ground,
	"wet": wet,
	"warm": warm,
	"random points of equal volume": lambda: scattered(),
	"one point per cell": lambda: filled(pointsPerCell=1),
	"sixteen points per cell": lambda: filled(pointsPerCell=16),
	"a slope with cut cells": lambda: filled(outline=[(0, 0), (2, 0), (1.1, 0.55), (0.3, 1.7)]),
	"two layers": lambda: layered(),
	"without friction": lambda: skeleton(MohrCoulomb, frictionAngle=0),
	"soft clay of small cohesion": lambda: skeleton(MohrCoulomb, frictionAngle=20, cohesion=50, young=2e6),
	"no gravity": lambda: ground(gravity=(0, 0)),
	"frozen, with heat": lambda: warm(points={"temperature": -2}),
	"excess ice with implicit pressure": lambda: freezing(
		points={"temperature": -1.0}, values=[-5, 5], material=Material(thawStrain=0.08), water=wrapper.PoreWater(pressure="implicit")
	),
	"frozen ground that thaws": lambda: freezing(points={"temperature": -1.0}, values=[-5, 5]),
	"ground that freezes and draws water": lambda: freezing(
		points={"temperature": 1.0}, values=[1, -5], segregation=wrapper.IceSegregation(segregationPotential=1e-9)
	),
	"freezing ground without water that flows": lambda: warm(
		freezing=wrapper.FreezingCurve(), boundaries=[wrapper.SurfaceTemperature(region="surface", temperature=-5)], points={"temperature": 1.0}
	),
	"seepage on the scale of the heat": lambda: wet(heat=wrapper.HeatTransfer(thermalTimeScale=1e5)),
	"a pond with its load": lambda: wet(
		boundaries=[wrapper.DrainedBoundary(region="surface", pressure=2e4), wrapper.SurfaceLoad(region="surface", pressure=2e4)]
	),
	"a calendar that follows the motion, with seepage": lambda: wet(heat=wrapper.HeatTransfer(thermalTimeScale=1e5, followsMotion=True)),
	"a load that comes in seconds": lambda: ground(boundaries=[wrapper.SurfaceLoad(region="surface", times=[0, 0.1], values=[0, 2e4])]),
	"rain on full ground that drains": lambda: wet(boundaries=[wrapper.WaterFlux(region="surface", flux=1e-7), wrapper.DrainedBoundary(region="bottom")]),
	"a slope along the grid with its shear": lambda: ground(gravity=(3, -9.3), points={"stress": (-2e4, -4e4, -2e4, 1e4)}),
	"compressed": lambda: ground(points={"stress": (-2e4, -4e4, -3e4, 0)}),
}


def scattered():
	mpm = wrapper.MpmEngine(gridSpacing=0.25, lower=(0, 0), upper=(2, 2), skeleton=wrapper.ElasticSkeleton())
	mpm.addPoints(position=np.random.default_rng(5).uniform(0, 1, (200, 2)), volume=1 / 200)
	return mpm


def filled(outline=((0, 0), (1, 0), (1, 1), (0, 1)), **settings):
	mpm = wrapper.MpmEngine(gridSpacing=0.25, lower=(0, 0), upper=(2, 2), skeleton=wrapper.ElasticSkeleton())
	talik.geometry.fill(mpm, outline, **settings)
	return mpm


def layered():
	mpm = filled()
	talik.geometry.fill(mpm, [(0, 1), (1, 1), (1, 1.6), (0, 1.6)])
	return mpm


@pytest.mark.parametrize("case", plausible)
def test_of_grounds_as_people_mean_them_nothing_is_said(case, capfd):
	mpm = plausible[case]()
	assert talik.check(mpm) == []
	mpm.initialise()
	assert capfd.readouterr() == ("", "")


@pytest.mark.parametrize(
	"boundary, words",
	[
		(lambda: wrapper.RollerBoundary(region="topp"), "region is 'topp'"),
		(lambda: wrapper.SurfaceTemperature(region="surface", temperature=-5), "heat"),
		(lambda: wrapper.SurfaceLoad(region="front", pressure=2e4), "front"),
	],
)
def test_the_check_says_what_the_first_step_will_refuse_and_leaves_the_ground_as_it_is(boundary, words, capfd):
	mpm = ground(boundaries=[boundary()])
	(line,) = talik.check(mpm)
	print(line)
	assert line.startswith("The first step refuses this ground: ") and words in line
	assert not mpm.initialised
	with pytest.raises(ValueError) as refusal:
		mpm.initialise()
	assert line.endswith(str(refusal.value))
	mpm.boundaries = []
	assert talik.check(mpm) == [] and not mpm.begun


def test_samples_that_do_not_fit_their_depth_are_named_until_they_are_settled(smallSample, capfd):
	mpm = ground(
		skeleton=wrapper.RveSkeleton(samples=[smallSample]), heat=wrapper.HeatTransfer(), freezing=wrapper.FreezingCurve(), points={"temperature": -2.0}
	)
	(line,) = talik.check(mpm)
	print(line)
	assert "samples begin with a vertical stress of -" in line and "talik.slope.settle" in line
	talik.slope.settle(mpm, [(0, 0), (1, 0), (1, 1), (0, 1)])
	assert talik.check(mpm) == []


def test_a_ground_that_is_made_anew_before_its_first_step_does_not_say_it_again(capfd):
	mpm = ground(gravity=(0, 9.81))
	mpm.field("position")
	assert "gravity" in capfd.readouterr().err
	mpm.damping = 0.1
	mpm.field("position")
	O.engines = [mpm]
	O.step()
	assert capfd.readouterr().err == ""


def test_a_ground_that_goes_on_from_a_file_does_not_say_it_again(tmp_path, capfd):
	O.engines = [ground(gravity=(0, 9.81))]
	O.step()
	assert "gravity" in capfd.readouterr().err
	talik.checkpoint.write(tmp_path / "x")
	O.reset()
	talik.resume(tmp_path / "x")
	O.step()
	assert capfd.readouterr().err == ""


def lens(potential):
	"""A column of fine cells between cold and warm ends, whose front comes to rest and draws water for days."""
	h = 0.02
	mpm = wrapper.MpmEngine(
		gridSpacing=h,
		lower=(0, 0),
		upper=(h, 0.4),
		gravity=(0, -9.81),
		damping=0.3,
		heat=wrapper.HeatTransfer(thermalTimeScale=5e5),
		freezing=wrapper.FreezingCurve(width=0.3),
		water=wrapper.PoreWater(conductivity=1e-7, cavitationPressure=-1e5),
		segregation=wrapper.IceSegregation(segregationPotential=potential),
		skeleton=wrapper.MohrCoulombSkeleton(young=1e6, youngFrozen=4e6, frictionAngle=30, cohesion=0, cohesionFrozen=5e5),
		boundaries=[
			*(wrapper.RollerBoundary(region=side) for side in ("left", "right", "bottom")),
			wrapper.WallTemperature(region="bottom", temperature=5),
			wrapper.DrainedBoundary(region="bottom", pressure=9810 * 0.2),
			wrapper.SurfaceTemperature(region="surface", days=[0, 0.1], values=[1, -5]),
		],
	)
	place, volume = talik.geometry.fillPolygon(talik.geometry.rectangle(0, 0, h, 0.2), h)
	mpm.addPoints(position=place, volume=volume, porosity=0.4, temperature=1, pressure=9810 * (0.2 - place[:, 1]))
	return mpm


@pytest.mark.parametrize("potential, parts", [(3e-9, True), (2e-10, False)])
def test_ground_whose_ice_lens_leaves_cells_without_points_says_so_once_and_what_to_change(potential, parts, capfd):
	O.reset()
	mpm = lens(potential)
	O.engines = [mpm]
	days = 0
	while days < 3:
		talik.runUntilDay(mpm, days := days + 0.25)
	lines = [line for line in capfd.readouterr().err.splitlines() if line.startswith("Talik warns")]
	height, h = mpm.field("position")[:, 1], mpm.gridSpacing
	empty = int(height.max() // h) + 1 - len(set(np.floor(height / h)))
	longest = (mpm.field("segregatedVolume") / (mpm.field("volume") - mpm.field("segregatedVolume"))).max()
	print(f"excess ice over soil in a point {longest:.2f}, cells below the surface without points {empty}, said: {lines}")
	assert bool(lines) == parts == (empty > 0)
	if parts:
		(line,) = lines
		assert "ice lens in point" in line and "gridSpacing" in line
