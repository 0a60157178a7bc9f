# SPDX-License-Identifier: GPL-2.0-or-later
"""The Debian source package is whole, builds what it names, lintian finds nothing, and its own tests pass on what it built."""

import os
import re
import subprocess
from pathlib import Path

import pytest

root = Path(__file__).resolve().parents[2]
build = Path(os.environ["TALIK_BUILD"])


def run(*command, **settings):
	done = subprocess.run([str(c) for c in command], capture_output=True, text=True, stdin=subprocess.DEVNULL, **settings)
	assert done.returncode == 0, done.stdout + done.stderr
	return done.stdout + done.stderr


@pytest.fixture(scope="module")
def packages():
	"""Made in the folder of the build, so that the compiler's cache serves from run to run; the script lets lintian look at them."""
	print(run(root / "scripts" / "package", env={**os.environ, "TALIK_BUILD": str(build)}))
	return build / "package"


def test_source_and_binary_packages_are_made_and_lintian_finds_nothing_slow(packages):
	made = sorted(file.name for file in packages.iterdir() if file.suffix in (".deb", ".dsc", ".xz"))
	print(", ".join(made))
	version = re.search(r"project\(talik VERSION (\S+)", (root / "CMakeLists.txt").read_text())[1]
	for name in (f"talik_{version}.orig.tar.xz", f"talik_{version}-1.debian.tar.xz", f"talik_{version}-1.dsc", f"talik-doc_{version}-1_all.deb"):
		assert name in made
	assert any(re.fullmatch(rf"talik_{version}-1_\w+\.deb", name) for name in made)


@pytest.mark.parametrize("test", ["examples", "core"])
def test_the_tests_of_the_source_package_pass_on_the_files_that_it_installs_slow(packages, tmp_path, test):
	installed = tmp_path / "root"
	for file in packages.glob("talik*.deb"):
		run("dpkg-deb", "--extract", file, installed)
	(tree,) = (folder for folder in packages.glob("talik-*") if folder.is_dir())
	(tmp_path / "work").mkdir()
	script = (tree / "debian" / "tests" / test).read_text().replace("/usr/share/doc", f"{installed}/usr/share/doc")
	(tmp_path / test).write_text(script)
	path = {"PYTHONPATH": str(installed / "usr/lib/python3/dist-packages"), "AUTOPKGTEST_TMP": str(tmp_path / "work")}
	said = run("sh", tmp_path / test, cwd=tree, env={**os.environ, **path}, timeout=900)
	print(said.splitlines()[-1])
