# SPDX-License-Identifier: GPL-2.0-or-later
"""The Debian package is made, installs with its dependencies met, works in the stock yade, and leaves nothing when it goes."""

import os
import re
import shutil
import subprocess
from pathlib import Path

import pytest

build = Path(os.environ["TALIK_BUILD"])


def run(*command, **settings):
	return subprocess.run([str(c) for c in command], check=True, capture_output=True, text=True, **settings).stdout


@pytest.fixture(scope="module")
def package(tmp_path_factory):
	folder = tmp_path_factory.mktemp("package")
	run("cpack", "--config", build / "CPackConfig.cmake", "-B", folder)
	(found,) = folder.glob("talik_*.deb")
	return found


@pytest.fixture
def scratchRoot(tmp_path):
	"""A root whose list of installed packages is this machine's, so that dependencies are really looked at."""
	database = tmp_path / "var/lib/dpkg"
	for part in ("info", "updates", "triggers"):
		(database / part).mkdir(parents=True)
	shutil.copy("/var/lib/dpkg/status", database / "status")
	return tmp_path


def dpkg(root, *options):
	return run("dpkg", f"--root={root}", "--force-not-root", *options)


def installedFiles(root):
	return [file for file in (root / "usr").rglob("*") if file.is_file()] if (root / "usr").exists() else []


def test_the_package_names_the_yade_that_it_needs(package):
	depends = run("dpkg-deb", "--field", package, "Depends")
	print(f"{package.name}, {package.stat().st_size / 1e6:.1f} MB, depends on {depends.strip()}")
	version = run("dpkg-query", "-W", "-f=${Version}", "yade")
	lower, upper = re.search(r"yade \(>= (\S+)\), yade \(<< (\S+)\)", depends).groups()
	assert version.startswith(lower)
	for allowed, accepted in ((version, True), (version + "+deb12u1", True), ("2024.1", False), ("2022.01a", False)):
		fits = all(
			subprocess.run(["dpkg", "--compare-versions", allowed, relation, bound]).returncode == 0 for relation, bound in (("ge", lower), ("lt", upper))
		)
		assert fits == accepted, allowed


def test_it_installs_works_in_the_stock_yade_and_leaves_nothing_behind(package, scratchRoot):
	dpkg(scratchRoot, "--install", package)
	files = installedFiles(scratchRoot)
	script = scratchRoot / "use.py"
	script.write_text(
		"import talik\n"
		"mpm = MpmEngine(gridSpacing=0.25, lower=(0, 0), upper=(1, 1), gravity=(0, -9.81), skeleton=ElasticSkeleton())\n"
		"talik.geometry.fill(mpm, talik.geometry.rectangle(0, 0, 1, 0.5))\n"
		"O.engines = [mpm]\nO.run(10, True)\nprint('used', talik.__file__, mpm.pointCount)\n"
		"try:\n\timport talik.studies.accuracy\nexcept ImportError as sentence:\n\tprint(sentence)\n"
	)
	path = str(scratchRoot / "usr/lib/python3/dist-packages")
	said = run("yade", "-n", "-x", script, cwd=scratchRoot, env={**os.environ, "PYTHONPATH": path, "PYTHONDONTWRITEBYTECODE": "1"}, stdin=subprocess.DEVNULL)
	assert f"used {path}/talik/__init__.py 32" in said
	assert "talik.studies.accuracy measures the examples of the repository: run scripts/accuracy in a clone of it" in said
	assert {scratchRoot / "usr/share/doc/talik/examples" / name for name in ("thawslump/slump.py", "thawbowl/hillside.asc")} <= set(files)
	dpkg(scratchRoot, "--remove", "talik")
	print(f"{len(files)} files installed, {len(installedFiles(scratchRoot))} left after the removal")
	assert len(files) > 20 and installedFiles(scratchRoot) == []
