# SPDX-License-Identifier: GPL-2.0-or-later
"""Fixtures of the tests that run inside the stock yade."""

import os
import sys
from pathlib import Path

import pytest
from yade import O

from talik import dates

# Arguments of talik.rve.prepare for samples that several modules take, so that each is prepared once. Seeds are those whose first packing meets
# porosity and fabric: a clone without a cache does not search for them.
thirty = dict(grains=30, porosity=0.19, seed=17)
forty = dict(grains=40, seed=3)
sixty = dict(grains=60, porosity=0.19, seed=4)
sixtyWithoutIce = dict(grains=60, porosity=0.19, seed=5, ice=False)
hundredWithoutIce = dict(grains=100, seed=8, ice=False)
spheres = dict(grains=100, dimension=3, seed=6)
eightySpheres = dict(grains=80, dimension=3, porosity=0.41, seed=3)
sixtySpheres = dict(grains=60, dimension=3, seed=7)
rollingDiscs = dict(grains=60, seed=8, etaRoll=0.05)
rollingSpheres = dict(grains=60, dimension=3, porosity=0.417, etaRoll=0.05)
rollingDiscsWithMoments = dict(**rollingDiscs, bondRadiusFactor=1.0, momentContribution=0.5)
ofDimension = {2: dict(grains=100), 3: spheres}


@pytest.fixture(autouse=True)
def emptyScene():
	"""Every test begins with an empty scene."""
	O.reset()
	O.engines = []
	yield
	O.reset()


@pytest.fixture
def ofMay(emptyScene):
	"""A scene that starts on 15 May 2024."""
	dates.start("2024-05-15")


@pytest.fixture(scope="session")
def sampleCache(tmp_path_factory):
	"""Folder of prepared samples: where ctest says so that of the build, which examples take, too, so that each is prepared once; or one of this run."""
	shared = os.environ.get("TALIK_TEST_CACHE")
	folder = Path(shared or tmp_path_factory.mktemp("cache")) / "talik" / "samples"
	folder.mkdir(parents=True, exist_ok=True)
	return folder


@pytest.fixture
def calibrateCommand(tmp_path, monkeypatch, capsys):
	"""scripts/calibrate with an option and arguments, on samples of its own: it prints and writes a table and draws a picture. Returns the lines of the table."""

	def run(option, *arguments):
		from talik.studies import command

		monkeypatch.setenv("XDG_CACHE_HOME", str(tmp_path))
		monkeypatch.setattr(sys, "argv", ["calibrate", f"--{option}", *arguments, "--output", str(tmp_path)])
		command.main()
		said, written = capsys.readouterr().out, (tmp_path / f"{option}.md").read_text()
		assert written.strip() in said
		assert (tmp_path / f"{option}.png").stat().st_size > 10_000
		return written.splitlines()

	return run
