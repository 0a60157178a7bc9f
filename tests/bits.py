#!/usr/bin/python3
# SPDX-License-Identifier: GPL-2.0-or-later
"""Does a change keep the bits? Hashes of all fields and balances of small scenes, of this build and of another one.

tests/bits.py                     prints the hashes of the build in build/ (or TALIK_BUILD)
tests/bits.py --against COMMIT    compares them with those of a commit, which is built in a folder of its own
tests/bits.py --against FILE      compares them with those that an earlier  tests/bits.py > FILE  printed
tests/bits.py --repeat            compares two runs of this build with each other

The scenes are those of tests/unit/slopeScenes.hpp, in the plane and in space: each on one thread, on several, on two ranks and through a
checkpoint. All four have to agree. The commit is built with the scenes of this tree, so that it must have the same settings."""

import argparse
import os
import subprocess
import sys
import tempfile
from pathlib import Path

root = Path(__file__).resolve().parents[1]
scenes = ["tests/bits.cpp", "tests/unit/slopeScenes.hpp", "tests/unit/groundState.hpp", "tests/unit/threadRanks.hpp"]
target = """
add_executable(talik_bits tests/bits.cpp)
target_include_directories(talik_bits PRIVATE tests/unit)
target_link_libraries(talik_bits PRIVATE talik_core)
"""


def run(*command, **settings):
	done = subprocess.run([*map(str, command)], stdout=subprocess.PIPE, stderr=subprocess.STDOUT, text=True, **settings)
	if done.returncode != 0:
		sys.exit(done.stdout[-4000:] + f"\n{' '.join(map(str, command))} failed")
	return done.stdout


def hashesIn(lines):
	"""By scene, way and name."""
	rows = [line.rsplit(" | ", 1) for line in lines.splitlines() if line.count(" | ") == 3]
	return {key: value for key, value in rows}


def hashesOfBuild(build, options):
	return hashesIn(run(Path(build) / "talik_bits", *options))


def hashesOfCommit(commit, options):
	"""Of a work tree in a temporary folder. Where ccache is installed it compiles only what differs."""
	with tempfile.TemporaryDirectory(prefix="talik-bits-") as folder:
		tree = Path(folder) / "tree"
		build = tree / "build"  # ccache finds the same paths relative to it
		run("git", "-C", root, "worktree", "add", "--detach", tree, commit)
		try:
			for file in scenes:
				(tree / file).write_bytes((root / file).read_bytes())
			lists = tree / "CMakeLists.txt"
			if "talik_bits" not in lists.read_text():
				lists.write_text(lists.read_text() + target)
			configure = ["cmake", "-S", tree, "-B", build, "-DCMAKE_BUILD_TYPE=Release"]
			if subprocess.run(["which", "ccache"], stdout=subprocess.DEVNULL, check=False).returncode == 0:
				configure.append("-DCMAKE_CXX_COMPILER_LAUNCHER=ccache")
			environment = {**os.environ, "CCACHE_BASEDIR": str(tree), "CCACHE_NOHASHDIR": "1"}
			run(*configure, env=environment)
			run("cmake", "--build", build, "-j", os.cpu_count(), "--target", "talik_bits", env=environment)
			return hashesOfBuild(build, options)
		finally:
			run("git", "-C", root, "worktree", "remove", "--force", tree)


def differing(one, other):
	"""What has another hash, or is in one of them only."""
	return sorted(key for key in set(one) | set(other) if one.get(key) != other.get(key))


def scenesThatDependOnTheWay(hashes):
	"""Scenes, with the number concerned, whose ways do not agree."""
	by = {}
	for key, value in hashes.items():
		scene, _, name = key.split(" | ")
		by.setdefault((scene, name), set()).add(value)
	return sorted(f"{scene}: {name}" for (scene, name), values in by.items() if len(values) > 1)


def main():
	words = argparse.ArgumentParser(description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter)
	words.add_argument("--against", metavar="COMMIT|FILE", help="what to compare with")
	words.add_argument("--repeat", action="store_true", help="compare two runs of this build")
	words.add_argument("--build", default=os.environ.get("TALIK_BUILD", root / "build"), help="folder of this build (default: build)")
	words.add_argument("--only", default="", help="scenes whose name contains this, such as 'plane' or 'segregation'")
	words.add_argument("--steps", type=int, default=220, help="steps in the plane, a fourth of them in space; points are sorted after 200")
	given = words.parse_args()
	options = ["--steps", given.steps, "--only", given.only]

	here = hashesOfBuild(given.build, options)
	if not given.against and not given.repeat:
		print("\n".join(f"{key} | {value}" for key, value in here.items()))
	for name in scenesThatDependOnTheWay(here):
		print(f"threads, ranks or a checkpoint change {name}")
	failed = len(here) == 0 or len(scenesThatDependOnTheWay(here)) > 0
	others = []
	if given.repeat:
		others.append(("a second run", hashesOfBuild(given.build, options)))
	if given.against and Path(given.against).is_file():
		known = hashesIn(Path(given.against).read_text())
		others.append((given.against, {key: known[key] for key in known if not given.only or key in here}))
	elif given.against:
		others.append((f"commit {given.against}", hashesOfCommit(given.against, options)))
	for what, other in others:
		keys = differing(here, other)
		for key in keys[:40]:
			print(f"differs: {key}")
		scenesCount = len({key.split(" | ")[0] for key in here})
		print(f"{len(keys)} of {len(here)} hashes of {scenesCount} scenes differ from {what} (reference: 0)", flush=True)
		failed = failed or len(keys) > 0
	return 1 if failed else 0


if __name__ == "__main__":
	sys.exit(main())
