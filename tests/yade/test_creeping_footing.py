# SPDX-License-Identifier: GPL-2.0-or-later
"""The example of a footing on creeping ground at reduced size, with ice of two powers."""

import json
import subprocess
from pathlib import Path

import pytest


def checkFooting(exponent, factor, folder):
	"""Level: Nye's closed form for a cylinder that expands in ground without end (1953), taken for a footing after Ladanyi, within a factor on the load."""
	example = Path(__file__).resolve().parents[2] / "examples" / "creeping_footing.py"
	run = subprocess.run(
		["yade", "-n", "-x", str(example), "--preset", "test", "--exponent", str(exponent), "--output", str(folder)],
		capture_output=True,
		text=True,
		timeout=600,
		check=False,
	)
	assert (folder / "summary.json").exists() and (folder / "creeping_footing.png").stat().st_size > 10_000, run.stdout + run.stderr
	summary = json.loads((folder / "summary.json").read_text())
	print("\n".join(line for line in run.stdout.splitlines() if "by hand" in line or "power" in line))
	assert summary["exponent [-]"] == pytest.approx(exponent, rel=0.05)
	assert 1 / factor < summary["load over that by hand [-]"] < factor


def test_a_strip_footing_on_frozen_ground_settles_with_the_power_of_the_load_that_its_ice_has(tmp_path):
	checkFooting(3.0, 1.5, tmp_path)


def test_a_strip_footing_on_ice_of_another_power_settles_with_that_power_slow(tmp_path):
	checkFooting(2.0, 2.0, tmp_path)
