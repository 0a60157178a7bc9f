# SPDX-License-Identifier: GPL-2.0-or-later
"""A target of a soil in a CSV file, what is refused, and the fit of a sample to it."""

import dataclasses
import json
import math
import re
import sys
from pathlib import Path

import numpy as np
import pytest
from fixtures import rollingDiscs, rollingDiscsWithMoments
from yade import O, wrapper

import talik
from talik import rve
from talik.studies import calibrate, command, target

soils = Path(__file__).parents[2] / "examples" / "soils"
head = "S_i [-],temperature [degC],rate [1/s],confinement [kPa],E [MPa],strength [MPa],tension [MPa],phi [deg]"


def written(folder, *lines, heading=head):
	file = folder / "soil.csv"
	file.write_text("\n".join([heading, *lines]) + "\n")
	return file


@pytest.fixture(scope="module")
def rolling(sampleCache):
	return rve.pack(rve.prepare(**rollingDiscs, cache=sampleCache))


def test_a_target_is_read_in_any_unit_and_order_and_both_soils_of_the_examples_are(tmp_path):
	first = target.read(written(tmp_path, "1,-10,1e-4,0,1500,10,2,", "0,,,100,50,,,36"))
	heading = "source,phi [deg],tension [kPa],strength [GPa],E [GPa],confinement [Pa],rate [1/s],temperature [°C],S_i [-]"
	second = target.read(written(tmp_path, "a book,,2000,0.01,1.5,0,1e-4,-10,1", "another,36,,,0.05,1e5,,,0", heading=heading))
	for one, other in zip(first, second):
		assert one.wanted == pytest.approx(other.wanted) and (one.iceSaturation, one.confinement) == (other.iceSaturation, other.confinement)
	assert first[0].wanted == {"E": 1.5e9, "strength": 10e6, "tension": 2e6} and first[1].confinement == 100e3
	for soil in soils.glob("*.csv"):
		print(soil.name, *target.read(soil), sep="\n\t")
	assert len(list(soils.glob("*.csv"))) == 2


@pytest.mark.parametrize(
	"lines, heading, fault",
	[
		(["1.2,-10,1e-4,0,1500,10,2,"], head, "line 2, column S_i: '1.2' must be an ice saturation from 0 to 1"),
		(["1,-10,1e-4,0,1500,10,2,", "1,-10,1e-4,0,1500,-10,2,"], head, "line 3, column strength: '-10' must be"),
		(["1,-10,1e-4,0,1500,10,-2,"], head, "line 2, column tension: '-2' must be a tensile strength, positive"),
		(["1,-10,1e-4,0,1500,10000000,2,"], head, "line 2, column strength: '10000000' must be .*look at the unit"),
		(["1,-10,0,0,1500,10,2,"], head, "line 2, column rate: '0' must be"),
		(["1,-10,fast,0,1500,10,2,"], head, "line 2, column rate: 'fast' must be"),
		(["1,,1e-4,0,1500,10,2,"], head, "line 2, column temperature: the cell is empty; frozen ground needs"),
		(["1,3,1e-4,0,1500,10,2,"], head, "line 2, column temperature: 3 degC with ice"),
		(["1,-10,1e-4,0,1500,10,2,30"], head, "line 2, column phi: the friction angle is that of ground without ice"),
		(["0,,,100,50,,,0.63"], head, "line 2, column phi: '0.63' must be degrees"),
		(["0,,,100,50,,2,36"], head, "line 2, column tension: grains without ice carry none"),
		(["0,,,0,50,,,36"], head, "line 2, column confinement: 0 Pa; grains without ice need"),
		(["1,-10,1e-4,,1500,10,2,"], head, "line 2, column confinement: the cell is empty"),
		(["1,-10,1e-4,0,,,,"], head, "line 2, column E: nothing was measured"),
		(["1,-10,1e-4,0,1500,8,7,2,30"], head, "line 2, column 9: '30' has no heading; numbers have a decimal point"),
		([], head, "has no row below its headings"),
		(
			["1,-10,1e-4,0,1500,10,2,"],
			head.replace("strength [MPa]", "strength [psi]"),
			r"line 1, column strength: it has the unit 'psi'; write strength \[Pa\]",
		),
		(["1,-10,1e-4,0,1500,10,2,"], head.replace("rate [1/s]", "rate"), r"line 1, column rate: it has no unit; write rate \[1/s\]"),
		(["1,-10,1e-4,0,1500,10,2"], head.replace(",phi [deg]", ""), r"line 1: the column phi is missing; add phi \[deg\]"),
	],
)
def test_a_wrong_target_is_refused_by_row_and_column(tmp_path, lines, heading, fault):
	with pytest.raises(ValueError, match=fault) as refused:
		target.read(written(tmp_path, *lines, heading=heading))
	print(str(refused.value).replace(str(tmp_path), ""))


def test_the_command_refuses_a_wrong_target_in_one_sentence_without_a_fit(tmp_path, monkeypatch):
	soil = written(tmp_path, "1,-10,1e-4,0,1500,-10,2,")
	monkeypatch.setattr(sys, "argv", ["calibrate", "--target", str(soil), "--output", str(tmp_path / "results")])
	with pytest.raises(SystemExit, match="line 2, column strength: '-10' must be the largest axial less lateral stress") as refused:
		command.main()
	print(str(refused.value).replace(str(tmp_path), ""))
	assert "\n" not in str(refused.value) and not list((tmp_path / "results").glob("*"))


def test_a_file_that_is_not_there_or_empty_is_refused(tmp_path):
	with pytest.raises(ValueError, match="cannot be read"):
		target.read(tmp_path / "none.csv")
	(tmp_path / "empty.csv").write_text("# nothing\n")
	with pytest.raises(ValueError, match="holds no data"):
		target.read(tmp_path / "empty.csv")


def test_a_sample_of_another_thickness_gives_what_the_same_sample_gives_under_pressures_times_its_thickness(rolling):
	"""Contacts know forces: stress is force over length and thickness."""
	with talik.inspect(rolling.open()) as scene:
		O.tags["thickness"] = "0.05"
		thin = wrapper.RveSample.fromScene(scene)
	assert (thin.thickness, rolling.thickness) == (0.05, 0.1)
	for ice, wanted in ((1.0, dict(E=1e9, strength=1e6)), (0.0, dict(E=1e7, phi=30.0))):
		row = target.Row(2, ice, -10.0, 1e-4, 100e3, wanted)
		scaled = target.test(rolling, row, thickness=0.05, strain=2e-3).values
		direct = calibrate.biaxialTest(thin, ice, 100e3, 2e-3)
		strength = dict(E=direct.elasticity()[0], strength=2 * direct.peak[1], phi=math.degrees(math.asin(direct.peak[1] / direct.peak[0])))
		for name in wanted:
			print(f"S_i = {ice:g}, {name}: scaled {scaled[name]:.6g}, of the thin sample {strength[name]:.6g}")
			assert scaled[name] == pytest.approx(strength[name], rel=0.02)


def test_an_altered_sample_has_the_friction_and_bonds_asked_for_and_the_grains_it_had(rolling):
	row = target.Row(2, 1.0, -10.0, 1e-4, 100e3, {"tension": 1e6})
	values = [target.test(target.altered(rolling, 0.5, 0.05, iceTensileStrength=strength), row, strain=8e-3).values["tension"] for strength in (10e6, 20e6)]
	print(f"tension {values[0]:.4g} and {values[1]:.4g} Pa with bonds of 10 and 20 MPa")
	assert values[1] / values[0] == pytest.approx(2, rel=0.15)
	other = target.altered(rolling, 0.3, 0.1)
	assert np.array_equal(other.arrays()["position"], rolling.arrays()["position"])
	with talik.inspect(other.open()):
		assert O.materials[0].frictionAngle == pytest.approx(math.atan(0.3)) and O.materials[0].etaRoll == pytest.approx(0.1)


def test_an_altered_sample_has_the_moments_of_bonds_asked_for(sampleCache):
	"""Bonds that bending never breaks are stronger in tension and compression than those that it breaks."""
	carrying = rve.pack(rve.prepare(**rollingDiscsWithMoments, cache=sampleCache))
	row, strengths = target.Row(2, 1.0, -10.0, 1e-4, 0.0, {"strength": 1e6}), []
	for contribution in (0.0, 1.0):
		other = target.altered(carrying, 0.5, 0.1, bondRadiusFactor=1.5, momentContribution=contribution)
		with talik.inspect(other.open()):
			contacts = [contact.phys for contact in O.interactions if contact.isReal]
			for part in (O.materials[0], *contacts):
				assert (part.bondRadiusFactor, part.momentContribution) == (1.5, contribution)
		strengths.append(target.test(other, row, strain=0.03).values["strength"])
	print(f"strength {1e-6 * strengths[0]:.2f} MPa where moments break no bond, {1e-6 * strengths[1]:.2f} MPa where they count in full")
	assert strengths[0] > 1.2 * strengths[1]


def test_the_front_holds_what_nothing_beats_in_everything():
	rows = [target.Row(2, 1.0, -10.0, 1e-4, 0.0, {"E": 1e9, "strength": 1e7})]
	made = [target.Candidate(dict(target.standard), [dict(E=e, strength=s)]) for e, s in ((1e9, 2e7), (2e9, 1e7), (2e9, 2e7), (1.2e9, 1.1e7))]
	found = target.Fit(rows, made[3], made, 60, 0.18)
	print(found.report())
	assert found.front() == [made[0], made[1], made[3]]
	assert found.bestIn("E") is made[0] and found.bestIn("strength") is made[1]
	assert made[2].misfits(rows) == pytest.approx({"E": 2.0, "strength": 2.0})


def test_the_fit_finds_a_sample_again_whose_tests_are_its_target_slow(sampleCache):
	hidden = dict(thickness=0.06, iceYoung=6e9, iceTensileStrength=25e6, iceShearStrength=80e6, friction=0.6, etaRoll=0.1)
	sample = rve.pack(rve.prepare(grains=60, pressure=30e3, ice=True, etaRoll=0.05, cache=sampleCache))
	same = target.altered(sample, **{name: value for name, value in hidden.items() if name != "thickness"})
	rows = [
		target.Row(2, 1.0, -10.0, 1e-4, 0.0, dict(E=1.0, strength=1.0, tension=1.0)),
		target.Row(3, 0.0, math.nan, math.nan, 100e3, dict(E=1.0, phi=30.0)),
	]
	rows = [dataclasses.replace(row, wanted=target.test(same, row, hidden["thickness"]).values) for row in rows]
	found = target.fit(rows, grains=60, steps=6, cache=sampleCache)
	print(found.report())
	first, last = found.candidates[0].misfits(rows), found.best.misfits(rows)
	print(f"off by {max(first.values()):.2f} at the start, {max(last.values()):.2f} at the end; hidden {hidden}")
	assert max(first.values()) > 1.5 and max(last.values()) < 1.25
	best = found.best.parameters
	assert best["thickness"] == pytest.approx(hidden["thickness"], rel=0.25)
	for name in ("iceYoung", "iceTensileStrength"):  # frozen stress depends on their ratios to the thickness
		assert best[name] / best["thickness"] == pytest.approx(hidden[name] / hidden["thickness"], rel=0.15)


def test_the_command_leaves_table_picture_and_a_sample_file_slow(tmp_path, monkeypatch, capsys, sampleCache):
	monkeypatch.setenv("XDG_CACHE_HOME", str(tmp_path))
	monkeypatch.setattr(sys, "argv", ["calibrate", "--target", str(soils / "frozen_sand.csv"), "--grains", "40", "--output", str(tmp_path / "results")])
	command.main()
	said, folder = capsys.readouterr().out, tmp_path / "results"
	print(said)
	assert re.search(r"\| best \|.*strength \d", said) and "best in tension" in (folder / "target.md").read_text()
	assert (folder / "target.png").stat().st_size > 20000
	sample, parameters = rve.load(folder / "sample.yade.gz"), json.loads((folder / "sample.json").read_text())
	assert sample.grains == 40 and sample.thickness == pytest.approx(parameters["thickness"])


def test_bonds_that_carry_moments_come_closer_to_frozen_silt_slow(sampleCache):
	"""Tenfold growth in compression at constant tension, which no sample without moments comes close to."""
	rows, off = target.read(soils / "frozen_silt.csv"), []
	for moments in (False, True):
		found = target.fit(rows, grains=100, strain=0.08, cache=sampleCache, moments=moments)
		print(found.report() + "\n")
		off.append(found.best.misfits(rows))
	assert target.fitted(rows, True)[-2:] == ["bondRadiusFactor", "momentContribution"]
	assert off[1]["strength"] < 1.6 < 2.0 < off[0]["strength"] and off[1]["tension"] < 1.2
