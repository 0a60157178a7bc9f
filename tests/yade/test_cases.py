# SPDX-License-Identifier: GPL-2.0-or-later
"""What the two thaw slumps rest on and what they show, at reduced size."""

import argparse
import dataclasses
import json
import math
import sys
from pathlib import Path

import numpy as np
import pytest
from yade import Matrix3, O

import talik
import thawslump
from talik import output, plots, running, rve
from talik.studies import calibrate, command
from thaw_slump_base import case
from thawslump import commandline, page, shearband

rest = Matrix3.Zero


@pytest.fixture(scope="module")
def sample():
	return rve.pack(rve.prepare(grains=100, ice=True))


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


def thawedColumn(sample, thawStrain, duration=5.0):
	"""A column of frozen ground, 2 m high, between rollers, thawed from its base: settlement of its top [m] and the final fields."""
	icy = sample.copy()
	icy.thawStrain = thawStrain
	assert icy.servo(-12e3, -18e3)
	h, top = 0.5, 2.0
	mpm = MpmEngine(
		gridSpacing=h,
		lower=(0, 0),
		upper=(2 * h, top + 2 * h),
		gravity=(0, -9.81),
		damping=0.3,
		skeleton=RveSkeleton(samples=[icy]),
		heat=HeatTransfer(thermalTimeScale=8.64e5),
		freezing=FreezingCurve(width=0.5, residualSaturation=0.05),
		water=PoreWater(conductivity=1e-4, bulkModulus=2.2e7),
		boundaries=[
			RollerBoundary(region="left"),
			RollerBoundary(region="right"),
			FixedBoundary(region="bottom"),
			DrainedBoundary(region="surface", recharge=False),
			WallTemperature(region="bottom", times=[0, 3 * talik.day, 13 * talik.day], values=[-5, -5, 10]),
		],
	)
	talik.geometry.fill(mpm, talik.geometry.rectangle(0, 0, 2 * h, top), temperature=-5)
	O.engines = [mpm]
	talik.runUntil(0.3)
	mpm.resetDisplacement()
	talik.runUntil(duration)
	fields = {
		name: mpm.field(name)
		for name in (
			"position",
			"displacement",
			"volume",
			"temperature",
			"iceSaturation",
			"bondsIntact",
			"bondsFormed",
			"bondsBroken",
			"skeleton0.sampleIceSaturation",
		)
	}
	start = shearband.initialPosition(fields)
	return -fields["displacement"][start[:, 1] > top - h, 1].mean(), fields


def test_thaw_from_the_base_leaves_no_bond_and_takes_support_by_the_thaw_strain_only(sample):
	h, settled = 0.5, {}
	for thawStrain in (0.0, 0.03):
		O.reset()
		settled[thawStrain], fields = thawedColumn(sample, thawStrain)
		thawed = fields["skeleton0.sampleIceSaturation"] <= shearband.meltSaturation
		depth = fields["volume"][thawed].sum() / (2 * h)
		print(
			f"thaw strain {thawStrain}: {depth:.2f} m thawed from the base, bonds left there "
			f"{fields['bondsIntact'][thawed].sum():.0f}, top settled {1e3 * settled[thawStrain]:.2f} mm"
		)
		assert depth > 0.9 * h and thawed[np.argmin(fields["position"][:, 1])]
		assert not fields["bondsIntact"][thawed].any()
	lost = np.sum((1 - fields["skeleton0.sampleIceSaturation"] / fields["skeleton0.sampleIceSaturation"].max()) * fields["volume"]) / (2 * h)
	strain = settled[0.03] / lost
	print(f"settlement over the depth of ground whose ice is lost ({lost:.2f} m) {100 * strain:.2f} % at a thaw strain of 3 %")
	assert settled[0.0] < 1e-3
	assert 0.4 * 0.03 < strain < 1.2 * 0.03  # the frozen roof bridges a part of it: it parts from the ground that sinks under it


# ---- shear band -----------------------------------------------------------------------------------------------------------

block = [(0, 0), (10, 0), (10, 6), (0, 6)]


def inclinedBand(angle, width=0.5, spacing=0.1, rotation=0.0, noise=0.0, opening=0.0):
	"""Points of a block whose upper right part slid by 0.6 m, left the line by `opening` [deg], and turned by `rotation` [deg] about its middle, along a line
	through the 	middle of the block that falls to the right; the displacement changes over `width`, down to y = 1. A `noise` [m] lies over it."""
	x, y = (values.ravel() for values in np.meshgrid(np.arange(spacing / 2, 10, spacing), np.arange(spacing / 2, 6, spacing)))
	sine, cosine = np.sin(np.radians(angle)), np.cos(np.radians(angle))
	across = (x - 5) * sine + (y - 3) * cosine
	away = np.cos(np.radians(opening)) * np.array([cosine, -sine]) + np.sin(np.radians(opening)) * np.array([sine, cosine])
	share = np.clip(0.5 + across / width, 0, 1) * (y > 1)
	turned = np.radians(rotation) * np.column_stack([-(y - 4.5), x - 7])
	start, n = np.column_stack([x, y]), len(x)
	displacement = share[:, None] * (0.6 * away + turned) + noise * np.random.default_rng(1).standard_normal((n, 2))
	strained = (share > 0) & (share < 1)
	return {
		"position": start + displacement,
		"displacement": displacement,
		"volume": np.full(n, spacing**2),
		"deviatoricStrain": 0.2 * strained,
		"iceSaturation": np.where(y > 1, 0.9, 0.0),
		"bondsFormed": np.full(n, 100.0),
		"bondsBroken": 7.0 * strained,
		"coordinationNumber": np.full(n, 3.0),
	}


@pytest.mark.parametrize("angle, opening", [(35, 0), (50, 0), (65, 20), (65, 90), (85, -10)])
def test_inclination_width_depth_opening_and_broken_bonds_of_a_drawn_band_are_found(angle, opening):
	band = shearband.measure(inclinedBand(angle, opening=opening), block)
	print(shearband.describe(band))
	assert band.opening == pytest.approx(opening, abs=1)
	assert band.inclination == pytest.approx(angle, abs=1)
	assert np.ptp(band.inclinations) < 1
	assert band.width == pytest.approx(0.5, rel=0.1)
	assert (band.top, band.depth, band.descendsTowards) == (pytest.approx(0, abs=0.1), pytest.approx(5, abs=0.1), "right")
	assert band.brokenBonds == pytest.approx(0.07, rel=0.05)


@pytest.mark.parametrize("disturbed", [dict(width=0.2), dict(width=1.0), dict(spacing=0.25), dict(noise=0.05), dict(rotation=5), dict(rotation=-5)], ids=str)
def test_inclination_hangs_neither_on_width_nor_cells_nor_noise_nor_on_a_turning_block_nor_on_the_strain_asked_for(disturbed):
	frame = inclinedBand(60, **disturbed)
	frame["deviatoricStrain"][0] = 0.5  # a lone point belongs to no band
	found = [shearband.measure(frame, block, threshold) for threshold in (0.05, 0.1, 0.2)]
	print(shearband.describe(found[0]))
	assert all(band.inclination == pytest.approx(60, abs=2) for band in found)
	assert len({band.inclination for band in found}) == 1
	assert 0 not in found[0].points


def test_without_a_jump_of_displacement_in_frozen_ground_there_is_no_band_and_A_is_still_the_frozen_point_with_most_broken_bonds():
	frame = inclinedBand(50)
	frame["displacement"] *= 0.01
	frame["iceSaturation"][frame["position"][:, 1] < 2] = 0
	frame["bondsBroken"][4000] = 50
	assert shearband.measure(frame, block) is None
	watched = shearband.watchedPoints(frame, block)
	assert watched["A"] == 4000 and frame["iceSaturation"][watched["B"]] == 0
	frame["bondsBroken"][:], frame["iceSaturation"][4100] = 0, 0.3
	assert shearband.watchedPoints(frame, block)["A"] == 4100  # where none broke: a point at the front, not the first of all
	frame["bondsBroken"][4000] = 50
	frame["coordinationNumber"][frame["iceSaturation"] == 0] = 1
	assert shearband.watchedPoints(frame, block) == watched  # thawed ground that has lost its contacts is shown as well


def test_the_sample_shown_of_a_band_is_in_one_piece_where_any_of_its_broken_ones_is():
	frame = inclinedBand(50)
	band = shearband.measure(frame, block)
	first, second = band.points[:2]
	frame["bondsBroken"][:], frame["deviatoricStrain"][band.points] = 0, 1.0
	frame["bondsBroken"][first], frame["bondsBroken"][second] = 80, 30
	alone = shearband.watchedPoints(frame, block)["A"]
	frame["deviatoricStrain"][second] = 0.1
	found = shearband.watchedPoints(frame, block)["A"]
	print(f"all torn: the one with 80 bonds broken, {alone}; one with 30 strained by 0.1: {found} of {first}, {second}")
	assert alone == first and found == second


# ---- calibration ----------------------------------------------------------------------------------------------------------


def madeUp(iceSaturation, pressure, cohesion, friction):
	"""A test whose deviator rises linearly to the peak of Mohr and Coulomb and stays there."""
	sine, cosine = np.sin(np.radians(friction)), np.cos(np.radians(friction))
	peak = 2 * (cohesion * cosine + pressure * sine) / (1 - sine)
	strain = np.arange(1, 1001) * 2e-5
	deviator = np.minimum(peak * strain / 0.01, peak)
	return calibrate.BiaxialTest(iceSaturation, pressure, strain, -0.25 * strain, pressure + deviator, np.full(1000, pressure), bonds=100)


def test_cohesion_and_friction_of_made_up_tests_are_recovered():
	cohesions, friction, pressures = [2e3, 60e3, 300e3], 23.0, (10e3, 50e3, 100e3)
	saturations = np.array([0.0, 0.5, 1.0])
	tests = [madeUp(s, p, c, friction) for s, c in zip(saturations, cohesions) for p in pressures]
	found, sine, residuals = calibrate._fitStrength(tests, saturations)
	young, poisson = tests[0].elasticity()
	print(f"c {found}, phi {np.degrees(np.arcsin(sine)):.6f} deg, residuals {np.abs(residuals).max():.1e}, nu {poisson:.4f}")
	assert found == pytest.approx(cohesions, rel=1e-6) and np.degrees(np.arcsin(sine)) == pytest.approx(friction, rel=1e-6)
	assert poisson == pytest.approx(0.2, rel=1e-6)
	slopeOfTest = 2 * tests[0].peak[1] / 0.01
	assert young == pytest.approx(slopeOfTest * (1 - 0.2**2), rel=1e-6)


def test_friction_that_is_given_is_kept_and_cohesions_follow_the_peaks():
	given, measured, pressure = 0.31, math.sin(math.radians(23.0)), 50e3
	tests = [dataclasses.replace(madeUp(s, pressure, c, 23.0), bonds=100 if s else 0) for s, c in ((0.0, 0.0), (1.0, 300e3))]
	found, sine, _ = calibrate._fitStrength(tests, np.array([0.0, 1.0]), given)
	mean, shear = tests[1].peak
	wanted = (shear - mean * given) / math.sqrt(1 - given**2)
	print(f"sin phi {sine:.6f}, given {given} (peaks {measured:.2f}); frozen cohesion {found[1] / 1e3:.2f} kPa, by hand {wanted / 1e3:.2f} kPa")
	assert sine == pytest.approx(given, abs=1e-9) and found[0] == 0 and found[1] == pytest.approx(wanted, rel=1e-6)


def test_ground_without_bonds_is_given_no_cohesion():
	tests = [dataclasses.replace(madeUp(s, p, c, 23.0), bonds=100 if s else 0) for s, c in ((0.0, 1e3), (1.0, 300e3)) for p in (10e3, 100e3)]
	found, sine, residuals = calibrate._fitStrength(tests, np.array([0.0, 1.0]))
	print(f"c {found}, phi {np.degrees(np.arcsin(sine)):.2f} deg, residuals {np.round(100 * residuals, 1)} %")
	assert found[0] == 0 and found[1] == pytest.approx(300e3, rel=0.05)


def test_calibrated_law_yields_where_the_sample_does_within_fifteen_per_cent(sample, tmp_path):
	result = calibrate.calibrate(sample, iceSaturations=(0.0, 0.5, 1.0))
	print(result.report())
	assert np.abs(result.residuals).max() < 0.15
	assert 15 < result.frictionAngle < 32
	for values in (result.cohesion, result.young, result.tensileStrength):
		assert np.all(np.diff(values) > 0)
	assert result.tensileStrength[0] < 100  # Pa: noise of colliding grains
	law = MohrCoulombSkeleton(**result.parameters())
	mpm = MpmEngine(gridSpacing=0.5, lower=(0, 0), upper=(1, 1), skeleton=law)
	mpm.addPoints(position=[(0.25, 0.25)], volume=0.25, porosity=0.4)
	mpm.initialise()
	assert (list(law.cohesions), list(law.youngs)) == (list(result.cohesion), list(result.young))
	picture = plots.save(result.draw(), tmp_path / "calibration.png", dpi=50)
	assert Path(picture).stat().st_size > 5000


def test_friction_of_thawed_samples_is_that_of_samples_without_thaw_strain(sample):
	icy = sample.copy()
	icy.thawStrain = 0.1
	plain, ofIcy = (calibrate.thawedFriction(each, pressures=(8e3,)) for each in (sample, icy))
	print(f"friction in simple shear {plain:.4f}, of a sample with a thaw strain of 10 % {ofIcy:.4f}")
	assert 0.2 < plain < 0.5 and ofIcy == plain and icy.thawStrain == 0.1


def test_the_command_gives_the_law_the_friction_of_its_sample_in_simple_shear_where_asked(sample, tmp_path, monkeypatch):
	monkeypatch.setattr(sys, "argv", ["calibrate", "--grains", "100", "--friction", "simple-shear", "--output", str(tmp_path)])
	command.main()
	law = json.loads((tmp_path / "calibration.json").read_text())
	sheared = calibrate.thawedFriction(sample)
	print(f"sin phi of the law {math.sin(math.radians(law['frictionAngle'])):.4f}, of the same sample in simple shear {sheared:.4f}")
	assert math.sin(math.radians(law["frictionAngle"])) == pytest.approx(sheared, rel=1e-6)


def test_calibration_of_a_frozen_sample_or_at_one_pressure_is_refused(sample):
	frozen = sample.copy()
	frozen.freeze(0.9)
	with pytest.raises(ValueError, match="holds ice"):
		calibrate.calibrate(frozen)
	with pytest.raises(ValueError, match="two or more"):
		calibrate.calibrate(sample, pressures=(1e4,))
	with pytest.raises(ValueError, match="0 and 1 among them"):
		calibrate.calibrate(sample, iceSaturations=(0.0, 0.5))
	with pytest.raises(ValueError, match="friction is 31; give shear over normal stress"):
		calibrate.calibrate(sample, friction=31)


# ---- the cases ------------------------------------------------------------------------------------------------------------


def labels(figure):
	"""Every label of axes and colour bars, subfigures included."""
	return {text for axes in figure.axes for text in (axes.get_xlabel(), axes.get_ylabel()) if text}


def asCommanded(folder, **options):
	"""Options of an example's command line at --preset test."""
	return argparse.Namespace(
		**{
			**dict(
				preset="test",
				output=folder,
				resume=False,
				redraw=False,
				film=False,
				pore_pressure="implicit",
				days=None,
				no_thaw=False,
				thaw_strain=0.03,
				skeleton="samples",
				compare=None,
				grains=None,
				thickness=0.1,
				realisations=1,
				seed=1,
				thawed_cohesion=None,
				grid_offset=0.0,
				calendar=None,
			),
			**options,
		}
	)


def summaries(folder):
	return {file.parent.name: json.loads(file.read_text()) for file in sorted(folder.glob("**/summary.json"))}


def test_command_lines_are_read_and_impossible_ones_refused(tmp_path, monkeypatch):
	monkeypatch.setattr(sys, "argv", ["example", "--thaw-strain", "full", "--compare", "thaw-strain", "--skeleton", "MohrCoulomb"])
	options = commandline.arguments("example", "output", thawStrain=0.03)
	assert (options.thaw_strain, options.compare, options.skeleton) == ("full", "thaw-strain", "MohrCoulomb")
	monkeypatch.setattr(sys, "argv", ["example"])
	assert commandline.arguments("example", "output", thawStrain=0.03).thaw_strain == 0.03
	runs = {
		name: list(commandline.comparison(argparse.Namespace(compare=name, skeleton="samples", thaw_strain=0.05)).values())
		for name in (None, "thaw-strain", "skeleton", "both", "thickness")
	}
	law = dict(thawStrain=0.0, skeleton="MohrCoulomb")
	strains = [dict(thawStrain=value, skeleton="samples") for value in (0.0, 0.05, "full")]
	thick = [dict(strains[1], thickness=value) for value in (0.1, 0.01)]
	assert runs == {None: strains[1:2], "thaw-strain": strains, "skeleton": [strains[1], law], "both": [*strains, law], "thickness": thick}
	assert commandline.groundOf(asCommanded("", thickness=0.05), strains[1]).thickness == 0.05
	assert commandline.groundOf(asCommanded("", thickness=0.05), thick[1]).thickness == 0.01
	grounds = {
		name: commandline.groundOf(asCommanded("", skeleton=name, **given), dict(skeleton=name, thawStrain=0.0))
		for name, given in (("samples", {}), ("MohrCoulomb", {}))
	}
	assert not grounds["samples"].followsMotion and grounds["samples"].thawedCohesion == 0
	assert grounds["MohrCoulomb"].followsMotion and grounds["MohrCoulomb"].thawedCohesion == 2000
	explicit = commandline.groundOf(asCommanded("", skeleton="MohrCoulomb", pore_pressure="explicit"), dict(skeleton="MohrCoulomb", thawStrain=0.0))
	assert {name: getattr(explicit, name) for name in thawslump.softened} == thawslump.softened and explicit.porePressure == "explicit"
	assert grounds["MohrCoulomb"].frozenModulus == thawslump.softened["frozenModulus"]
	assert all(ground.porePressure == "implicit" and math.isnan(ground.bulkModulus) for ground in grounds.values())  # water as stiff as it is
	assert math.isinf(grounds["samples"].frozenModulus)
	thin = commandline.groundOf(asCommanded("", skeleton="MohrCoulomb", thickness=0.01), law)
	assert thin.frozenModulus == pytest.approx(10 * thawslump.softened["frozenModulus"])  # five times thawed ground of such samples, too
	compared = commandline.groundOf(asCommanded("", compare="skeleton", calendar="follows-motion"), law)
	assert compared.followsMotion and compared.thawedCohesion == 0 and math.isinf(compared.frozenModulus)
	assert compared.picTimeFactor == grounds["MohrCoulomb"].picTimeFactor == 4 and grounds["samples"].picTimeFactor == 1
	for wrong in (
		["--days", "-5"],
		["--duration", "20"],
		["--skeleton", "Cam-Clay"],
		["--thaw-strain", "much"],
		["--compare", "weather"],
		["--grains", "0"],
		["--realisations", "2.5"],
		["--realisations", "-1"],
		["--thawed-cohesion", "-5"],
		["--thickness", "0"],
		["--thickness", "2"],
		["--seed", "x"],
	):
		monkeypatch.setattr(sys, "argv", ["example", *wrong])
		with pytest.raises(SystemExit):
			commandline.arguments("example", "output")
	with pytest.raises(FileNotFoundError, match="holds no frames.npz to draw from"):
		commandline.runCase(case, asCommanded(tmp_path, redraw=True))
	with pytest.raises(ValueError, match="skeleton is 'Cam-Clay'; choose one of samples, MohrCoulomb"):
		thawslump.ThawSlump(case, "test", skeleton="Cam-Clay")


def test_a_slump_takes_realisations_grains_and_a_thawed_cohesion_for_samples_and_law(tmp_path):
	options = asCommanded(tmp_path, grains=40, realisations=2, seed=22, thawed_cohesion=2000.0)
	preset = commandline.presetOf(options, None)
	ground = thawslump.Ground(thawedCohesion=2000.0, frozenModulus=2e7, thickness=0.05)
	slump = {name: thawslump.ThawSlump(case, preset, tmp_path, ground, skeleton=name) for name in thawslump.skeletons}
	moduli = slump["MohrCoulomb"].skeleton.youngs
	assert max(moduli) == 2e7 and min(moduli) < 1e7  # frozen ground only
	samples, cohesions = slump["samples"].skeleton.samples, slump["MohrCoulomb"].skeleton.cohesions
	strength, measured = slump["samples"].thawed["strength of bonds [Pa]"], slump["samples"].thawed["cohesion measured [Pa]"]
	slump["samples"].mpm.initialise()
	porosities = {round(value, 9) for value in slump["samples"].mpm.field("samplePorosity")}
	print(
		f"{len(samples)} samples of {len(samples[0].arrays()['radius'])} grains in {len(porosities)} packings; bonds of "
		f"{strength:.0f} Pa, {measured:.0f} Pa measured; law {cohesions}"
	)
	assert all(sample.thickness == 0.05 for sample in samples)
	slipping, law = slump["samples"].skeleton, slump["MohrCoulomb"].skeleton
	print(
		f"slip of samples: friction {slipping.slipFriction:.3f}, cohesion {slipping.slipCohesion:.0f} Pa; law sin phi {math.sin(math.radians(law.frictionAngle)):.3f}"
	)
	assert slipping.slipCohesion == measured and slipping.slipFriction == pytest.approx(math.sin(math.radians(law.frictionAngle)), rel=1e-9)
	assert len(samples[0].arrays()["radius"]) == 40 and len(porosities) == len(samples) > 4
	assert all(sample.thawedStrength == strength > 0 for sample in samples) and measured == pytest.approx(2000, rel=0.2)
	assert min(cohesions) == cohesions[0] == 2000 and cohesions[-1] > 1e5
	tensions = slump["MohrCoulomb"].skeleton.tensileStrengths
	assert min(tensions) == tensions[0] == slump["MohrCoulomb"].thawed["tension measured [Pa]"] > 0


def test_compare_skeleton_runs_samples_and_the_law_calibrated_on_the_same_sample_and_shows_both_bills_slow(tmp_path, monkeypatch):
	figures = []
	sideBySide = page.sideBySide
	monkeypatch.setattr(page, "sideBySide", lambda *given: figures.append(sideBySide(*given)) or figures[-1])
	commandline.runCase(case, asCommanded(tmp_path, compare="skeleton", thaw_strain=0.0))
	runs = summaries(tmp_path)
	for skeleton in thawslump.skeletons:
		summary = runs[skeleton]
		print(f"{skeleton}: {commandline.bill(summary)}; largest displacement {1e3 * summary['largest displacement [m]']:.4f} mm")
		assert summary["largest displacement [m]"] < 1e-3
		assert (tmp_path / skeleton / "page.png").stat().st_size > 10000
	assert runs["samples"]["sample calls"] > 0 and runs["samples"]["sample memory [MB]"] > 0 and runs["samples"]["bondsFormed"] > 0
	assert runs["MohrCoulomb"]["sample calls"] == 0 and runs["MohrCoulomb"]["calibration [s]"] > 0 and "bondsFormed" not in runs["MohrCoulomb"]
	assert {"x [m]", "y [m]", "day", "largest displacement [m]"} <= labels(figures[0])
	titles = [text.get_text() for axes in figures[0].axes for text in axes.texts]
	assert any("samples: " in title and "sample calls" in title and "MB" in title for title in titles)
	assert any("MohrCoulomb: " in title and "calibration" in title for title in titles)
	drawn = (tmp_path / "skeleton.png").read_bytes()
	(tmp_path / "skeleton.png").unlink()
	commandline.runCase(case, asCommanded(tmp_path, compare="skeleton", thaw_strain=0.0, redraw=True))
	assert len(drawn) > 10000 and (tmp_path / "skeleton.png").read_bytes() == drawn


def test_compare_thaw_strain_runs_none_a_few_per_cent_and_all_of_it_slow(tmp_path):
	commandline.runCase(case, asCommanded(tmp_path, compare="thaw-strain"))
	runs = summaries(tmp_path)
	print({name: summary["ground.thawStrain"] for name, summary in runs.items()})
	assert {name: summary["ground.thawStrain"] for name, summary in runs.items()} == {
		"thaw-strain-0.0": 0.0,
		"thaw-strain-0.03": 0.03,
		"thaw-strain-full": "full",
	}
	assert (tmp_path / "thaw-strain.png").stat().st_size > 10000


def test_case_two_with_full_thaw_strain_fails_along_an_inclined_band_of_broken_bonds_that_reaches_the_top_slow(tmp_path):
	preset = thawslump.Preset(gridSpacing=0.5, grains=100, days=600.0)  # the roof breaks on day 484
	with talik.scratchScene():
		slump = thawslump.ThawSlump(case, preset, tmp_path, thawslump.Ground(thawStrain="full"))
		summary = slump.run()
		last, watched, band, surface = slump.frames.frames[-1], slump.watchedPoints(), slump.band(), slump.slipSurface()
	print(shearband.describe(band), shearband.describe(surface, "all"), f"largest displacement {summary['largest displacement [m]']:.2f} m", sep="\n")
	bonds = {letter: {name: last[name][point] for name in ("bondsFormed", "bondsIntact", "bondsBroken", "bondsMelted")} for letter, point in watched.items()}
	print(bonds)
	assert shearband.frozen(last)[band.points].all() and band.brokenBonds >= 0.01
	assert shearband.frozen(last)[watched["A"]] and bonds["A"]["bondsBroken"] >= 0.01 * bonds["A"]["bondsFormed"] and bonds["A"]["bondsIntact"] > 0
	assert not shearband.frozen(last)[watched["B"]] and bonds["B"]["bondsIntact"] == 0 and bonds["B"]["bondsFormed"] > 0
	# the uppermost points lie half a cell below the top; after 5 m of displacement the frozen part of the band ends a row or two below them
	assert surface.top < 0.6 * preset.gridSpacing and band.top < 1.5 * preset.gridSpacing
	assert band.depth > 2 * preset.gridSpacing and band.descendsTowards == "right"
	assert 45 < band.inclination <= 90 and 20 < surface.inclination < 45
	assert summary["largest displacement [m]"] > 0.5


def test_case_two_without_thaw_strain_keeps_its_support_slow(tmp_path):
	preset = thawslump.Preset(gridSpacing=0.25, grains=60, days=200.0)  # on 1/2 m two points of the thawed toe slide by 50 mm
	with talik.scratchScene():
		slump = thawslump.ThawSlump(case, preset, tmp_path)
		summary = slump.run()
	last = slump.frames.frames[-1]
	roof = np.linalg.norm(last["displacement"][shearband.frozen(last)], axis=1).max()
	print(
		f"frozen ground moved by {1e3 * roof:.2f} mm, thawed ground by {1e3 * summary['largest displacement [m]']:.2f} mm, thawed part "
		f"{summary['thawed part [-]']:.2f}"
	)
	# thawed ground at the side walls of the pocket is not held by friction there (36 mm); a roof that breaks moves by half a metre
	assert summary["thawed part [-]"] > 0.1 and roof < 0.01 and summary["largest displacement [m]"] < 0.05
	assert slump.band() is None and slump.slipSurface() is None


def test_page_shows_fields_at_four_times_and_chains_and_roses_of_both_points_and_is_drawn_anew_from_the_folder(tmp_path, monkeypatch, capsys):
	with talik.scratchScene():
		slump = commandline.runCase(case, asCommanded(tmp_path, grains=30, days=2.0))
		frames = slump.frames.frames
		sample = page.sampleOf(slump.skeleton, 0)
		page.saveSamples(tmp_path / page.samplesName, {"A": sample, "B": sample}, {"A": 0, "B": 1})
	title = f"{case.name}; {page.slipSurfaces(frames[-1], case.outline)}\n{page.linesOfPictures}"
	figure = page.page(output.telling(frames[1:], 4), {"A": sample, "B": sample}, {"A": 0, "B": 1}, title)
	fields = [axes for axes in figure.axes if axes.collections and axes.name == "rectilinear"]
	roses = [axes for axes in figure.axes if axes.name == "polar"]
	wanted = Path(plots.save(figure, tmp_path / "wanted.png", dpi=80)).read_bytes()
	(tmp_path / "page.png").unlink()
	told = capsys.readouterr().out.splitlines()[-3:]
	monkeypatch.setattr(commandline, "ThawSlump", None)  # no run
	commandline.runCase(case, asCommanded(tmp_path, redraw=True, film=True))
	assert capsys.readouterr().out.splitlines()[-3:] == told
	film = (tmp_path / "film.gif").stat().st_size
	print(f"film of {len(frames)} frames: {film / 1e6:.2f} MB, less than 2 MB due")
	assert 5000 < film < 2e6
	print(f"{len(fields)} panels, {len(roses)} roses, labels {sorted(labels(figure))}; the page drawn anew has the same {len(wanted)} bytes")
	assert len(roses) == 2 and len(fields) >= 12 + 2
	named = {label.split(" [")[0] for label in labels(figure)}  # units have a power of ten here, as little has moved
	assert {"ice saturation $S_i$", r"deviatoric strain $\varepsilon_d$", "displacement $|u|$"} <= named
	assert (tmp_path / "page.png").read_bytes() == wanted


def test_a_slump_of_another_version_is_named_not_half_read(tmp_path):
	slump = thawslump.ThawSlump.__new__(thawslump.ThawSlump)
	slump.folder = tmp_path
	with pytest.raises(ValueError, match="slope.checkpoint: another version of Talik wrote this slump .*without --resume"):
		slump._recall({"preset": {"aSettingThatIsGone": 1}})


def test_a_slump_that_was_stopped_goes_on_from_its_folder_to_the_same_last_bit_and_beyond_its_end(tmp_path, monkeypatch):
	monkeypatch.setattr(page, "draw", lambda *given: None)  # the test of the page looks at the pictures
	monkeypatch.setattr(thawslump.slump, "seriesLength", 4)  # a checkpoint is due between two states more often than at one
	preset = thawslump.Preset(gridSpacing=0.5, grains=40, seed=3, days=1.0, strainTolerance=5e-5, bandThickness=1.0, restTime=0.05)
	whole = thawslump.ThawSlump(case, preset, tmp_path / "whole")
	whole.run()
	wanted, counted = output.allFields(whole.mpm), whole.counters()
	O.reset()

	def writeUntilThePowerFails(series):
		if len(series.entries) == 3:
			raise SystemError("the power fails")
		stockWrite(series)

	def count(slump):
		kept.append(O.time)
		stockKeep(slump)

	stockWrite, stockKeep, stockSleep, kept = output.ParaViewSeries.write, thawslump.ThawSlump._keep, running.time.sleep, []
	with monkeypatch.context() as patched:
		patched.setattr(output.ParaViewSeries, "write", writeUntilThePowerFails)
		patched.setattr(thawslump.ThawSlump, "_keep", count)
		patched.setattr(thawslump.slump, "checkpointInterval", 0)
		patched.setattr(running.runUntil, "__defaults__", (None, 0.002, False))  # looks often, however fast the steps are
		patched.setattr(running.time, "sleep", lambda seconds: stockSleep(min(seconds, 0.001)))
		with pytest.raises(SystemError):
			thawslump.ThawSlump(case, preset, tmp_path / "stopped").run()
	O.reset()
	slump = commandline.runCase(case, asCommanded(tmp_path / "stopped", resume=True))
	found = output.allFields(slump.mpm)
	different = sum(int(np.sum(~((found[name] == wanted[name]) | (np.isnan(found[name]) & np.isnan(wanted[name]))))) for name in wanted)
	print(
		f"\n{len(wanted)} fields of {slump.mpm.pointCount} points: {different} numbers differ; "
		f"{len(slump.frames.frames)} frames, {len(slump.series.entries)} states for ParaView, {len(kept)} checkpoints, "
		f"{len(set(kept))} times"
	)
	assert len(set(kept)) > 4  # one at each of three states, the others between them
	assert found.keys() == wanted.keys() and different == 0
	assert [frame["time"] for frame in slump.frames.frames] == [frame["time"] for frame in whole.frames.frames]
	assert slump.series.entries == whole.series.entries
	assert {name: slump.counters()[name] for name in ("calls", "steps")} == {name: counted[name] for name in ("calls", "steps")}
	slump.endAt(1.2)
	slump.run()
	print(f"frames of the run that was made longer: days {[round(frame['day'], 3) for frame in slump.frames.frames]}")
	assert slump.day() == pytest.approx(1.2, abs=1e-2) and len(slump.frames.frames) == len(whole.frames.frames) + 1
