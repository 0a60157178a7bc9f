# SPDX-License-Identifier: GPL-2.0-or-later
"""Element tests of samples and predictions of laboratory tests in a CSV file."""

import math
import sys

import numpy as np
import pytest
from fixtures import sixty

from talik import packing, rve
from talik.studies import command, elementtests


@pytest.fixture(scope="module")
def disc(sampleCache):
	return rve.pack(rve.prepare(**sixty, cache=sampleCache))


@pytest.fixture(scope="module")
def looseSample(sampleCache):
	return rve.prepare(grains=200, dimension=3, porosity=0.45, etaRoll=0.2, cache=sampleCache)


@pytest.fixture(scope="module")
def sphere(looseSample):
	return rve.pack(looseSample)


@pytest.fixture(scope="module")
def both(disc, sphere):
	return {2: disc, 3: sphere}


@pytest.mark.parametrize("dimension", [2, 3])
def test_each_path_holds_what_its_name_says(both, dimension):
	sample, p = both[dimension], 100e3
	drained = elementtests.triaxial(sample, p, strain=0.02)
	off = np.sqrt(np.mean((drained.lateral[20:] / p - 1) ** 2))  # grains of a small sample snap
	print(
		f"triaxial: lateral stress off by {100 * off:.2f} % of 100 kPa (root mean square), tolerance 2 %; axial stress at the end {drained.axial[-1] / 1e3:.0f} kPa"
	)
	assert off < 0.02 and drained.axial[-1] > 1.2 * p
	closed = elementtests.undrained(sample, p, strain=0.02)
	print(f"undrained: volumetric strain {np.abs(closed.volume).max():.1e}, due 0 within 1e-9; axial strain {closed.strain[-1]:.4f}, due 0.0199")
	assert np.abs(closed.volume).max() < 1e-9 and closed.strain[-1] == pytest.approx(1 - (1 - 1e-4) ** 199, rel=1e-9)
	pressed = elementtests.oedometer(sample, p, 2 * p)
	byAxial = np.abs(pressed.volume - pressed.strain).max()
	atRest = pressed.lateral[-1] / pressed.axial[-1]
	print(f"oedometer: volumetric less axial strain {byAxial:.1e}, due 0; it ends at {pressed.axial[-1] / 1e3:.1f} kPa, due 200; K_0 {atRest:.2f}")
	assert byAxial < 1e-12 and 2 * p <= pressed.axial[-1] < 2.1 * p and 0.2 < atRest < 1
	squeezed = elementtests.isotropic(sample, p, 2 * p)
	equal = (1 - squeezed.strain[-1]) ** dimension
	print(
		f"isotropic: volume left {1 - squeezed.volume[-1]:.6f}, length left to the power of {dimension} {equal:.6f}; mean stress {squeezed.p[-1] / 1e3:.1f} kPa"
	)
	assert 1 - squeezed.volume[-1] == pytest.approx(equal, rel=1e-9) and 2 * p <= squeezed.p[-1] < 2.1 * p
	sheared = elementtests.simpleShear(sample, p, strain=0.02)
	held = np.sqrt(np.mean((sheared.axial[20:] / p - 1) ** 2))
	print(f"simple shear: normal stress off by {100 * held:.2f} %, tolerance 2 %; shear strain {sheared.strain[-1]:.4f}, due 0.0199")
	assert held < 0.02 and sheared.strain[-1] == pytest.approx(0.0199) and sheared.mobilised[-1] > 5
	kept = elementtests.simpleShear(sample, p, strain=0.02, drained=False)
	assert np.abs(kept.volume).max() == 0


def test_void_ratio_and_volume_of_a_record_are_those_of_the_sample(sphere):
	porosity = sphere.statistics()["porosity"]
	curve = elementtests.oedometer(sphere, 100e3, 200e3)
	expected = (1 + curve.voidRatio[0]) * (1 - curve.volume[-1]) - 1
	print(
		f"void ratio at the start {curve.voidRatio[0]:.4f}, of the sample {porosity / (1 - porosity):.4f}; at the end {curve.voidRatio[-1]:.5f}, due {expected:.5f}"
	)
	assert curve.voidRatio[0] == pytest.approx(porosity / (1 - porosity), abs=0.02) and curve.voidRatio[-1] == pytest.approx(expected, abs=1e-12)


def test_a_dense_sample_dilates_and_a_loose_one_contracts_to_about_one_void_ratio_and_strength():
	"""Critical state of soil mechanics: what a sand was packed to is forgotten at a large strain."""
	library = elementtests.Library(100, 1, told=lambda line: None, path=((0.0, 0.0), (0.5, 0.4)))
	dense, loose = (elementtests.triaxial(elementtests.target.altered(sample, 0.5, 0.1), 100e3, 0.2).numbers() for sample in library.samples)
	print(f"void ratio {dense['e0']:.3f} -> {dense['eEnd']:.3f} and {loose['e0']:.3f} -> {loose['eEnd']:.3f}: apart by {loose['e0'] - dense['e0']:.3f} before")
	print(
		f"angle at the peak {dense['phiPeak']:.1f} and {loose['phiPeak']:.1f}, at the end {dense['phiEnd']:.1f} and {loose['phiEnd']:.1f} degrees, tolerance 6"
	)
	assert dense["volumeEnd"] < 0 < loose["volumeEnd"] and dense["phiPeak"] > loose["phiPeak"] + 3
	assert abs(dense["eEnd"] - loose["eEnd"]) < 0.4 * (loose["e0"] - dense["e0"]) and abs(dense["phiEnd"] - loose["phiEnd"]) < 6


@pytest.mark.parametrize("porosity, word", [(0.27, "densest"), (0.6, "loosest")], ids=["dense_slow", "loose"])
def test_spheres_that_no_compaction_makes_so_dense_or_loose_are_refused_with_the_limit(tmp_path, porosity, word):
	with pytest.raises(packing.PackingError, match=f"the {word} packing of these spheres at 100000 Pa has porosity 0") as refusal:
		rve.prepare(grains=30, dimension=3, porosity=porosity, etaRoll=0.2, cache=tmp_path)
	print(refusal.value)


def test_loose_spheres_that_resist_rolling_are_prepared(looseSample):
	"""With the compaction of YADE 149 s gave none of this porosity."""
	sample = looseSample
	print(f"porosity {sample.porosity:.4f}, due 0.45 within 0.005; {sample}")
	assert abs(sample.porosity - 0.45) < 0.005 and abs(sample.pressure / 100e3 - 1) < 2e-3


def test_friction_angles_of_stress_ratios_are_those_of_mohr_coulomb():
	for degrees in (20.0, 33.0, 45.0):
		sine = math.sin(math.radians(degrees))
		assert elementtests.angleOf(6 * sine / (3 - sine)) == pytest.approx(degrees)


head = "test,e0,p0_kPa,eps1_peak_pct,eta_peak,q_peak_kPa,eps1_end_pct,eta_end,epsv_end_pct,e_end"


@pytest.mark.parametrize(
	"text, fault",
	[
		("test,e0\nA,0.8\n", "the column p0_kPa is missing"),
		(head + "\n", "no row below its headings"),
		(head + "\nA,-0.8,100,,,,,,,\n", "line 2, column e0: '-0.8' must be a number from 0.2 to 2"),
		(head + "\nA,0.8,100,,15,,,,,\n", "line 2, column eta_peak: '15' must be"),
		(head + "\nA,0.8,high,,,,,,,\n", "line 2, column p0_kPa: 'high' must be"),
	],
)
def test_a_wrong_table_of_tests_is_refused_by_line_and_column(tmp_path, text, fault):
	file = tmp_path / "sand.csv"
	file.write_text(text)
	with pytest.raises(ValueError) as refusal:
		elementtests.read(file)
	assert fault in str(refusal.value)


def test_the_command_fits_on_the_tests_named_and_predicts_all(tmp_path, monkeypatch, capsys):
	file = tmp_path / "sand.csv"
	file.write_text(f"{head}\nA,0.72,100,,1.5,,1,1.4,-1,\nB,0.8,200,,1.4,,1,,,\nC,0.76,100,,,,1,,,\n")
	monkeypatch.setattr(elementtests, "looseness", [(0.0, 0.0), (0.5, 0.2)])
	arguments = ["--elements", str(file), "--fit", "A", "--grains", "40", "--realisations", "2", "--output", str(tmp_path)]
	monkeypatch.setattr(sys, "argv", ["calibrate", *arguments])
	command.main()
	table = (tmp_path / "elements.md").read_text()
	said = capsys.readouterr().out
	print(table)
	assert table.count("(fitted)") == 3 and len([line for line in table.splitlines() if line.startswith("| ")]) == 4 and "fitted on A: friction" in table
	assert (tmp_path / "elements.png").stat().st_size > 10_000 and "elements.png" in said
	monkeypatch.setattr(sys, "argv", ["calibrate", "--elements", str(file), "--fit", "C", "--output", str(tmp_path)])
	with pytest.raises(SystemExit, match="calibrate: elementtests: there are no results of a test 'C' to fit on"):
		command.main()
