# SPDX-License-Identifier: GPL-2.0-or-later
"""The slump thawed from its surface against an independent column, its own bonds and balances: every day one run of 40 days with 40 grains in
a sample for all tests, the preset draft among the slow ones."""

import dataclasses

import numpy as np
import pytest
from thaw_column import ThawColumn
from yade import O

import talik
import thawslump
from thaw_slump_base import case as heatedFromBelow
from thaw_slump_surface import case
from talik.studies import accuracy
from thawslump import page, shearband

atRest = 5e-3  # ground that has moved less has not yet moved [m]
plateau = 1.5  # width of the column far from the face [m]
failed = 0.05  # deviatoric strain of ground that has failed
spread = 0.5  # over which the freezing curve spreads the front: ground ahead of it that is partly thawed counts, too [m]


def air(time):
	"""Air of the example, counted from the start of the thaw [s of the calendar]."""
	return -5 + 15 * min(max(time / (10 * talik.day), 0.0), 1.0)


presets = {
	"reduced": thawslump.Preset(gridSpacing=0.5, grains=40, days=40.0, strainTolerance=1e-4, bandThickness=1.0, seed=3),
	"draft_slow": thawslump.presets["draft"],
}


@pytest.fixture(scope="module", autouse=True)
def withoutPictures():
	"""No test here looks at the pictures of a run, which take longer to draw than half of its days: test_cases.py does."""
	with pytest.MonkeyPatch.context() as patched:
		patched.setattr(page, "draw", lambda *given: None)
		yield


def slump(folder, preset, **options):
	run = thawslump.ThawSlump(case, preset, folder, frameDays=np.linspace(0, preset.days, 17), **options)
	run.run()
	return run


@pytest.fixture(scope="module", params=presets)
def thawing(request, tmp_path_factory):
	return slump(tmp_path_factory.mktemp("thawing"), presets[request.param])


@pytest.fixture(scope="module")
def standing(tmp_path_factory):
	"""The same slope of ground whose thawed cohesion holds the face: it stands while it thaws."""
	preset = thawslump.Preset(gridSpacing=0.5, grains=40, days=75.0, seed=3)
	folder = tmp_path_factory.mktemp("standing")
	run = thawslump.ThawSlump(case, preset, folder, thawslump.Ground(thawedCohesion=30e3), frameDays=np.linspace(0, preset.days, 17), skeleton="MohrCoulomb")
	run.run()
	return run


@pytest.fixture(scope="module")
def realisations(thawing, tmp_path_factory):
	"""The slope of other samples, too, at reduced size: of 67 points on the slip surface 7 to 14 were frozen in three of them."""
	if thawing.preset != presets["reduced"]:
		return [thawing]
	others = [slump(tmp_path_factory.mktemp("realisation"), dataclasses.replace(presets["reduced"], seed=seed)) for seed in (1, 4)]
	return [thawing, *others]


def initialPosition(frame):
	return frame["position"] - frame["displacement"]


def sizes(vectors):
	return np.linalg.norm(vectors, axis=1)


def thawedDepth(frame, points, width, initialIce):
	"""Volume per width whose ice has become water [m]."""
	return np.sum((1 - frame["iceSaturation"] / initialIce)[points] * frame["volume"][points]) / width


# ---- the front ------------------------------------------------------------------------------------------------------------


def test_reference_column_meets_neumann_where_the_freezing_curve_is_sharp():
	column = ThawColumn(1.5, 200, lambda time: 10.0, width=0.02, residual=0.0, timeScale=1.0)
	column.march(10 * 86400.0)
	exact = accuracy.neumannFront(10.0, -5.0) * np.sqrt(10 * 86400.0)
	print(f"front after 10 d {column.front():.5f} m, Neumann {exact:.5f} m, error {100 * (column.front() / exact - 1):.2f} %")
	assert column.front() == pytest.approx(exact, rel=0.01)


# the quarter-cell resistance of a free surface between nodes makes a thawing front run ahead by up to 0.43 h here
def test_front_in_ground_that_has_not_moved_is_within_half_a_cell_of_the_column(standing):
	h = standing.preset.gridSpacing
	frames = standing.frames.frames
	points = initialPosition(frames[0])[:, 0] < plateau
	reference = ThawColumn(4.0, 160, air, timeScale=1.0)
	compared = 0
	for frame in frames:
		if sizes(frame["displacement"][points]).max() > atRest:
			break
		reference.march(max(frame["day"], 0.0) * talik.day)
		front = thawedDepth(frame, points, plateau, frames[0]["iceSaturation"].max())
		print(f"day {frame['day']:5.1f}: front {front:.3f} m, column {reference.front():.3f} m, error {(front - reference.front()) / h:+.2f} h")
		assert abs(front - reference.front()) < 0.5 * h
		compared += 1
	assert compared >= 8 and front > 2 * h


def test_front_on_a_fine_column_of_the_same_ground_is_within_five_per_cent():
	ground, h, top = thawslump.Ground(), 0.1, 4.0
	mpm = MpmEngine(
		gridSpacing=h,
		lower=(0, 0),
		upper=(2 * h, top + 4 * h),
		motion=False,
		heat=HeatTransfer(thermalTimeScale=ground.thermalTimeScale),
		freezing=FreezingCurve(curve="gauss", width=ground.freezingWidth, residualSaturation=ground.residualSaturation),
		boundaries=[SurfaceTemperature(region="surface", times=[0, 10 * talik.day], values=[-5, 10])],
	)
	talik.geometry.fill(mpm, talik.geometry.rectangle(0, 0, 2 * h, top), porosity=ground.porosity, temperature=ground.temperature)
	O.engines = [mpm]
	mpm.initialise()
	initialIce = mpm.field("iceSaturation").max()
	reference = ThawColumn(top, 160, air, timeScale=1.0)
	for time in (8.0, 12.0, 16.0, 20.0):
		talik.runUntil(time)
		reference.march(mpm.calendar["day"] * talik.day)
		state = {name: mpm.field(name) for name in ("iceSaturation", "volume")}
		front, exact = thawedDepth(state, slice(None), 2 * h, initialIce), reference.front()
		print(f"t = {O.time:5.2f} s: front {front:.4f} m, column {exact:.4f} m, error {100 * (front / exact - 1):+.2f} %, X/h = {exact / h:.1f}")
		assert h <= exact / 8
		assert front == pytest.approx(exact, rel=0.05)


# ---- bonds ----------------------------------------------------------------------------------------------------------------


def test_behind_the_front_there_is_no_ice_and_no_bond(thawing):
	frames = thawing.frames.frames
	start = initialPosition(frames[0])
	column = start[:, 0] < plateau
	for frame in frames[1:]:
		thawed = frame["temperature"] > 0
		melted = frame["skeleton0.sampleIceSaturation"] <= shearband.meltSaturation
		front = thawedDepth(frame, column, plateau, frames[0]["iceSaturation"].max())
		behind = column & (4 - start[:, 1] < front - spread)
		print(f"t = {frame['time']:5.2f} s: {thawed.sum()} points thawed, {melted.sum()} samples without bonds, front on the plateau {front:.2f} m")
		assert not frame["iceSaturation"][thawed | behind].any()
		assert not frame["bondsIntact"][thawed | behind | melted].any()
	assert thawed.sum() > len(thawed) / 4


def test_ahead_of_the_front_bonds_are_lost_by_breaking_only(thawing):
	frames = thawing.frames.frames
	frozen = np.ones(len(frames[0]["iceSaturation"]), bool)
	for frame in frames:
		frozen &= np.minimum(frame["iceSaturation"], frame["skeleton0.sampleIceSaturation"]) > shearband.meltSaturation
		formed, intact, broken, melted = (frame[name] for name in ("bondsFormed", "bondsIntact", "bondsBroken", "bondsMelted"))
		lost = formed - intact
		print(f"t = {frame['time']:5.2f} s: {frozen.sum()} points frozen all along, bonds lost {lost[frozen].sum():.0f}, broken {broken[frozen].sum():.0f}")
		assert np.array_equal(lost[frozen], broken[frozen])
		assert np.array_equal(lost, broken + melted)
	assert 50 < frozen.sum() < len(frozen) and broken.sum() > 0


# ---- failure --------------------------------------------------------------------------------------------------------------


def test_failure_moves_inward(thawing):
	deepest = []
	depth = (7 - thawing.frames.frames[0]["position"].sum(axis=1)) / np.sqrt(2)  # below the face through (3, 4) and (6, 1)
	for frame in thawing.frames.frames:
		strained = frame["deviatoricStrain"] > failed
		deepest.append(depth[strained].max() if strained.any() else 0.0)
		print(f"t = {frame['time']:5.2f} s: {strained.sum()} points strained by more than {failed}, the deepest {deepest[-1]:.2f} m below the face")
	steps = np.diff(deepest)
	assert np.all(steps >= 0) and np.sum(steps > 0) >= 3


def frozenShare(run):
	"""Of the points on the slip surface."""
	return np.mean(shearband.frozen(run.frames.frames[-1])[run.slipSurface().points])


def test_the_slip_surface_follows_the_face_through_thawed_ground_and_none_is_in_frozen_ground(thawing, realisations):
	surface, band = thawing.slipSurface(), thawing.band()
	shares = [frozenShare(run) for run in realisations]
	print(
		shearband.describe(surface, "all"),
		"frozen points on it, of each realisation: " + ", ".join(f"{100 * share:.0f} %" for share in shares),
		shearband.describe(band),
		sep="\n",
	)
	assert band is None and all(run.band() is None for run in realisations)
	# by its end the slope has slid by metres: its slip surface lies between the face and the angle at which thawed ground comes to rest
	assert 17 < surface.inclination < 55 and surface.descendsTowards == "right"
	assert surface.roughness < 0.1 * surface.length
	assert np.mean(shares) < 0.2


@pytest.mark.parametrize("thawing", ["draft_slow"], indirect=True)
def test_the_same_slope_kept_frozen_moves_less_than_a_centimetre_in_the_same_time_slow(thawing, tmp_path):
	frozen = slump(tmp_path, thawing.preset, thaw=False)
	moved = sizes(frozen.mpm.field("displacement")).max()
	slid = sizes(thawing.frames.frames[-1]["displacement"]).max()
	print(f"after {frozen.day():.1f} days: frozen slope {1e3 * moved:.4f} mm, thawing slope {1e3 * slid:.0f} mm")
	assert frozen.day() == pytest.approx(thawing.preset.days, rel=1e-3)
	assert moved < 0.01
	assert frozen.mpm.field("bondsIntact").sum() == frozen.mpm.field("bondsFormed").sum()


def slideOf(folder, **sampling):
	"""Day on which ground with 2 kPa of thawed cohesion begins to slide: it has moved by 0.1 m."""
	preset = thawslump.Preset(gridSpacing=0.5, grains=60, days=60.0, seed=1, **sampling)
	run = thawslump.ThawSlump(case, preset, folder, thawslump.Ground(thawedCohesion=2000.0, picTimeFactor=thawslump.flowingPicTimeFactor))
	if preset.strainTolerance == 0:
		run.skeleton.saturationTolerance = 0
	run.rest()
	for day in range(1, int(preset.days) + 1):
		talik.runUntilDay(run.mpm, day)
		if sizes(run.mpm.field("displacement")).max() > 0.1:
			return day
	return None


def test_ground_with_thawed_cohesion_slides_too_when_its_samples_are_asked_rarely_slow(tmp_path):
	"""While answers for the ice loosened the strain tolerance of each point tenfold it stood with draft's sampling, day after day."""
	draft = {name: getattr(thawslump.presets["draft"], name) for name in ("strainTolerance", "stressTolerance", "maxInertialNumber")}
	always = slideOf(tmp_path, **{**draft, "strainTolerance": 0.0})
	print(f"\nit slides on day {always} when samples are asked in every step")
	# the thawed thickness that slides goes with the root of the days
	for name, sampling, allowed in (("draft", draft, 0.3), ("the default", {}, 0.15)):
		day = slideOf(tmp_path, **sampling)
		print(f"sampled as in {name} on day {day}")
		assert day is not None and abs(day - always) <= allowed * always


# ---- balances -------------------------------------------------------------------------------------------------------------


def test_mass_water_heat_and_momentum_close_with_what_crossed_the_boundary(thawing):
	closures, balance = thawing.closures(), thawing.mpm.balance()
	print(f"heat in {balance['heatIn'] / 1e6:.1f} MJ/m, water out {balance['waterOut']:.3g} kg/m, Skempton's B {thawing.mpm.skemptonB():.3f}")
	for name, value in closures.items():
		print(f"{name}: {value:+.1e} is missing")
		assert abs(value) < 1e-11
	assert thawing.mpm.skemptonB() > 0.99  # water bears an undrained load


def test_water_of_a_slope_that_runs_dry_under_hastened_seepage_keeps_its_speed_and_its_account_slow(tmp_path):
	ground = thawslump.Ground(followsMotion=True)
	run = thawslump.ThawSlump(case, "draft", tmp_path, ground, frameDays=np.linspace(0, thawslump.presets["draft"].days, 31), skeleton="MohrCoulomb")
	run.run()
	water = sizes(run.mpm.field("liquidVelocity")).max()
	driest = run.mpm.field("waterMass").min()
	print(f"\nday {run.mpm.calendar['day']:.0f}: water moves at most {water:.2g} m/s, least water of a point {driest:.1e} kg")
	# the largest hastened conductivity, 0.05 m/s, under its own weight and the porosity of 0.4: 0.13 m/s relative to grains
	assert water < 1
	assert driest >= 0
	for name, value in run.closures().items():
		print(f"{name}: {value:+.1e} is missing")
		assert abs(value) < 1e-11


# ---- energy ----------------------------------------------------------------------------------------------------------------


def test_slip_under_the_frozen_roof_of_case_two_takes_up_no_more_than_gravity_gives_slow(tmp_path):
	"""At a quarter of the scale of time the thawed pocket has four times as long to shake between its base and the roof."""
	preset = thawslump.Preset(gridSpacing=0.5, grains=100, days=72.0)
	ground = thawslump.Ground(thawedCohesion=2000.0, followsMotion=True, thermalTimeScale=8.64e5 / 4)
	run = thawslump.ThawSlump(heatedFromBelow, preset, tmp_path, ground, skeleton="MohrCoulomb")
	run.mpm.energyLedger = True
	run.rest()
	start = run.mpm.balance()
	talik.runUntilDay(run.mpm, preset.days)
	end = run.mpm.balance()
	slip, gravity = (end[name] - start[name] for name in ("slipWork", "gravityEnergy"))
	moved = sizes(run.mpm.field("displacement")).max()
	print(f"slip takes up {slip:.0f} J/m, gravity gives {-gravity:.0f} J/m; largest displacement {moved:.3f} m under a roof that stands")
	assert slip < -gravity and moved < 0.1
