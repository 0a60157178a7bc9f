# SPDX-License-Identifier: GPL-2.0-or-later
"""The slopes of the centrifuge tests at reduced size: Harris, Rea & Davies 2001, doi 10.1002/ppp.373."""

import json
import math
import re
import runpy
import subprocess
import sys
from pathlib import Path

import pytest

example = Path(__file__).resolve().parents[2] / "examples" / "centrifuge_slopes.py"


def defined():
	"""What the script defines before it reads its arguments."""
	names = {}
	exec(compile(example.read_text().split("\nparser = ")[0], str(example), "exec"), names)
	return names


@pytest.mark.parametrize(
	"given, remedy",
	[
		("cohesion", "'' is not a positive number; write cohesion=NUMBER, e.g. cohesion=800"),
		("cohesion=soft", "'soft' is not a positive number; write cohesion=NUMBER"),
		("cohesoin=1200", "there is no assumption 'cohesoin'; write ASSUMPTION=NUMBER with one of thickness, cohesion, "),
		("frontVelocities=3", "the thaw front has one velocity or two; write frontVelocities=1 or frontVelocities=2"),
		("safetyAt18=4", "which must lie between 0 and 1; change one by --assume"),
	],
	ids=["no number", "a word", "unknown name", "neither one nor two", "no friction angle"],
)
def test_an_assumption_that_is_none_is_refused_by_what_was_given_and_the_remedy(tmp_path, monkeypatch, capfd, given, remedy):
	monkeypatch.setattr(sys, "argv", [example.name, "--preset", "test", "--assume", given, "--output", str(tmp_path)])
	with pytest.raises(SystemExit) as refusal:
		runpy.run_path(str(example), run_name="__main__")
	said = str(refusal.value)
	print(said)
	assert remedy in said and "\n" not in said and capfd.readouterr().err == ""
	assert given in said or "tan(phi)" in said


def test_slopes_that_freeze_and_thaw_twice_settle_by_their_excess_ice_in_the_order_measured_in_the_centrifuge(tmp_path):
	"""Measured: 187 mm a cycle at 12 degrees, 651 mm at 18, a mudflow at 24."""
	command = ["yade", "-n", "-x", str(example), "--preset", "test", "--cycles", "2", "--output", str(tmp_path)]
	run = subprocess.run(command, capture_output=True, text=True, timeout=600, check=False)
	assert (tmp_path / "summary.json").exists() and (tmp_path / "centrifuge_slopes_cycles.png").stat().st_size > 10_000, run.stdout + run.stderr
	paths = {}
	for file in (tmp_path / "runs").glob("*.json"):
		kept = json.loads(file.read_text())
		paths[kept["settings"].get("cycle", 1), kept["settings"]["slope"]] = kept["path"][-1]
	summary = json.loads((tmp_path / "summary.json").read_text())
	settled, byHand = summary["settlement [m]"], summary["settlement by hand [m]"]
	for cycle in (1, 2):
		found = [paths.get((cycle, slope), math.inf) for slope in (12, 18, 24)]  # a slope that flows has no further cycle
		print(f"cycle {cycle}: {', '.join(f'{1e3 * path:.0f} mm' for path in found)} at 12, 18 and 24 degrees; measured 187, 651, mudflow")
		assert found == sorted(found) and found[0] > 0
	print(f"settled by {1e3 * settled:.1f} mm, thaw strain times thawed depth {1e3 * byHand:.1f} mm, tolerance 20 %")
	assert abs(settled - byHand) < 0.2 * byHand
	assert len(re.findall(r"^\| cycle", (tmp_path / "cycles.md").read_text(), re.M)) == 2


def test_a_slope_that_freezes_and_thaws_by_itself_heaves_by_its_ice_and_settles_again():
	"""A box of 1 m with a layer of 0.4 m: heave normal to the slope is that of the ice, and of the pore water that expands and stays; thaw takes it back."""
	names = defined()
	names["frost"] = 20.0
	ground = names["withIce"](names["Assumptions"](segregation=1e-9, conductivity=4e-8, length=1.0, thickness=0.4))
	slope = names["OwnIce"](12, ground, 20.0)
	first, second = slope.next(), slope.next()
	expansion = ground.porosity * 0.95 * (1000 / 910 - 1) * ground.thickness
	for name, run in (("first", first), ("second", second)):
		heave, ice, settled, path = (1e3 * value for value in (run["heave"], run["ice"], run["settlement"][-1], run["path"][-1]))
		print(f"{name} cycle: {ice:.2f} mm of excess ice, heave {heave:.2f} mm, settled {settled:.2f} mm, moved {path:.2f} mm down the slope")
		assert run["frozen"] == 1 and run["ice"] > 5e-3
		assert run["ice"] - 2e-3 < run["heave"] < run["ice"] + expansion
		assert abs(run["settlement"][-1] / run["heave"] - 1) < 0.25
	print(f"excess ice of the second cycle over the first {second['ice'] / first['ice']:.3f}")
	assert abs(second["ice"] / first["ice"] - 1) < 0.25


def test_segregated_ice_of_the_slopes_is_that_of_a_quasi_steady_front():
	"""A front with the gradient G behind it draws q = SP G and moves by Z' = (kappa - rho_w L SP) G/(rho_i L n S): excess ice over soil 1.1 q/Z'."""
	names = defined()
	ground = names["Assumptions"](segregation=1e-9, conductivity=4e-8)  # of water: the less, the longer the steps of the calendar
	rows = names["rowsOf"](ground)
	ice = 0.95
	conductivity = (1 - ground.porosity) * 2.0 + ground.porosity * (ice * 2.2 + (1 - ice) * 0.6)
	load = (1 - ground.porosity) * 1650 * 9.81 * 0.5 * ground.thickness
	potential = ground.segregation * math.exp(-names["pressureDecay"] * load)
	byHand = potential / 0.91 * 910 * 334e3 * ground.porosity * ice / (conductivity - 1000 * 334e3 * potential)
	byHand /= 1 + byHand
	middle = sum(rows[1:-1]) / len(rows[1:-1])  # without the cells at surface and base
	print(f"excess ice of frozen ground {middle:.4f}, by hand {byHand:.4f} without the heat of the ground itself, tolerance 27 %")
	assert 0.73 * byHand < middle < byHand
	layers = names["layersOf"]({}, ground, names["even"](ground))
	assert [each["material"].thawStrain for each in layers.values()] == list(rows)


def test_slopes_with_segregated_ice_settle_by_it_in_the_order_measured_in_the_centrifuge_slow(tmp_path):
	command = ["yade", "-n", "-x", str(example), "--preset", "test", "--assume", "segregation=2e-9", "--ice", "column", "--output", str(tmp_path)]
	run = subprocess.run(command, capture_output=True, text=True, timeout=900, check=False)
	summary = json.loads((tmp_path / "summary.json").read_text())
	found = list(summary["path of the surface [m]"].values())
	print(f"{', '.join(f'{1e3 * path:.0f} mm' for path in found)} at 12, 18 and 24 degrees; measured 187, 651, mudflow")
	assert run.returncode == 0 and "frost creep by hand" in run.stdout, run.stdout + run.stderr


def test_slopes_whose_ice_forms_in_them_move_farther_where_they_are_steeper_slow(tmp_path):
	command = [
		"yade",
		"-n",
		"-x",
		str(example),
		"--preset",
		"test",
		"--slopes",
		"12",
		"18",
		"--assume",
		"segregation=1e-9",
		"length=1",
		"--output",
		str(tmp_path),
	]
	run = subprocess.run(command, capture_output=True, text=True, timeout=1800, check=False)
	print("\n".join(line for line in run.stdout.splitlines() if "excess ice, heave" in line))
	assert run.returncode == 0 and run.stdout.count("frost creep by hand") == 3, run.stdout + run.stderr
	paths = json.loads((tmp_path / "summary.json").read_text())["path of the surface [m]"]
	assert 0 < paths["12 deg"] < paths["18 deg"]
