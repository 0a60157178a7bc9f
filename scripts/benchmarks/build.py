#!/usr/bin/python3
# SPDX-License-Identifier: GPL-2.0-or-later
"""What compiling Talik takes, without ccache, by processor time, which other work on the machine changes little:

	/usr/bin/python3 scripts/benchmarks/build.py build.json FOLDER

builds _talik in FOLDER, compiles one file of Boost.Python as a measure of the machine, then compiles each effect of the ground anew and
links, as after a change of its source file."""

import argparse
import os
import shutil
import subprocess
import sys
import time
from pathlib import Path

import figures

root = Path(__file__).resolve().parents[2]
boost = '#include <boost/python.hpp>\nstruct A { int a; };\nBOOST_PYTHON_MODULE(m) { boost::python::class_<A>("A").def_readwrite("a", &A::a); }\n'
shown = 12  # of the units that take longest
longestRebuild = 20  # after a change of one effect [s]
withoutCache = {**os.environ, "CCACHE_DISABLE": "1"}


def run(*command, log):
	"""Processor time and wall time of a command and what it starts [s]."""
	before, start = os.times(), time.monotonic()
	with open(log, "a", encoding="utf-8") as said:
		done = subprocess.run([*map(str, command)], stdout=said, stderr=said, env=withoutCache, check=False)
	if done.returncode != 0:
		sys.exit(f"{' '.join(map(str, command))} failed, see {log}")
	after = os.times()
	return after.children_user + after.children_system - before.children_user - before.children_system, time.monotonic() - start


def unitTimes(folder):
	"""Processor time of each unit [s], which tests/timed left."""
	times = {}
	for file in folder.rglob("*.o"):
		lines = file.read_text().split("\n")
		times[str(file.relative_to(folder))] = sum(map(float, lines[-2].split()))
	return times


def main():
	words = argparse.ArgumentParser(description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter)
	words.add_argument("file", type=Path)
	words.add_argument("folder", type=Path)
	given = words.parse_args()
	folder, log = given.folder.resolve(), given.folder.resolve() / "build.log"
	shutil.rmtree(folder, ignore_errors=True)
	folder.mkdir(parents=True)

	source = folder / "boost.cpp"
	source.write_text(boost)
	python = subprocess.run(["/usr/bin/python3-config", "--includes"], capture_output=True, text=True, check=True).stdout.split()
	one = min(run("c++", "-O3", "-fPIC", "-std=c++17", *python, "-c", source, "-o", folder / "boost.o", log=log)[0] for _ in range(3))

	build = folder / "build"
	launcher = f"-DCMAKE_CXX_COMPILER_LAUNCHER={root / 'scripts/benchmarks/timedUnit'};{folder / 'units'}"
	run("cmake", "-S", root, "-B", build, "-DCMAKE_BUILD_TYPE=Release", launcher, log=log)
	whole, wall = run("cmake", "--build", build, "-j", os.cpu_count(), "--target", "_talik", log=log)
	times = unitTimes(folder / "units")

	rebuilds = {}
	for effect in sorted((root / "pkg/mpm/effects").glob("*.cpp")):
		(build / f"CMakeFiles/talik_core.dir/pkg/mpm/effects/{effect.name}.o").unlink()
		rebuilds[effect.stem] = run("cmake", "--build", build, "-j", os.cpu_count(), "--target", "_talik", log=log)
	longest = max(rebuilds, key=lambda name: rebuilds[name][1])

	largest = sorted(times, key=times.get, reverse=True)[:shown]
	figures.write(
		given.file,
		[
			figures.Figure("_talik, processor time", whole, "s", terms={"wall time [s]": wall, "units": len(times)}),
			figures.Figure("over one file of Boost.Python", whole / one, "x", terms={"that file [s]": one}),
			figures.Figure(
				f"after a change of one effect: {longest}, the longest, wall time",
				rebuilds[longest][1],
				"s",
				ceiling=longestRebuild,
				terms={"processor time [s]": rebuilds[longest][0]},
			),
			*(figures.Figure(name, times[name], "s") for name in largest),
		],
		["processor time of the units that take longest; without ccache"],
	)


if __name__ == "__main__":
	main()
