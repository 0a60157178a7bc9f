# SPDX-License-Identifier: GPL-2.0-or-later
"""Packed samples beside those of a revision, in turn in one process: time, bits, and instructions where valgrind is installed.

usage  kernels.py <compare> <tests/unit/data> <revision> <result.json>

What a sample does not ask for shall cost its kernels less than 2 %. Versions that differ in a bit do not do the same work."""

import json
import re
import shutil
import subprocess
import sys
from pathlib import Path

import figures
from figures import Figure

most = 1.02  # of the time and of the instructions of the revision
rounds = 60


def ran(compare, data, *arguments, under=()):
	command = [*under, compare, data / "packed_reference.txt", data / "packed_spheres_reference.txt", *arguments]
	return json.loads(subprocess.run(list(map(str, command)), capture_output=True, text=True, check=True).stdout)


def instructions(compare, data, kind):
	"""Of the present and of the former version in two rounds of a kind."""
	file = Path(compare).with_name("callgrind.out")
	ran(compare, data, 2, kind, under=("valgrind", "--quiet", "--tool=callgrind", f"--callgrind-out-file={file}"))
	said = subprocess.run(["callgrind_annotate", "--inclusive=yes", str(file)], capture_output=True, text=True, check=True).stdout
	return [int(re.search(rf"^ *([0-9,]+) .*\b{version}_run", said, re.M).group(1).replace(",", "")) for version in ("present", "former")]


def measured(compare, data, counted):
	for row in ran(compare, data, rounds):
		kind = row["kind"]
		quartiles, (before, now) = row["quartiles"], row["pressure"]
		terms = {"quartiles": f"{quartiles[0]:.3f} and {quartiles[1]:.3f}"}
		yield Figure(f"{kind}: time over that of the revision", row["ratio"], "x", ceiling=most, terms=terms)
		yield Figure(f"{kind}: difference of the pressure after {row['steps']} steps", now - before, "Pa", floor=0, ceiling=0)
		if counted:
			present, former = instructions(compare, data, kind)
			yield Figure(
				f"{kind}: instructions over those of the revision", present / former, "x", ceiling=most, terms={"instructions": present, "former": former}
			)


def main(compare, data, revision, target):
	counted = shutil.which("valgrind") is not None
	notes = [f"against {revision}; ratios of neighbours in time, median of {rounds}"]
	if not counted:
		notes.append("instructions were not counted: there is no valgrind")
	figures.write(target, list(measured(compare, Path(data), counted)), notes)


if __name__ == "__main__":
	if len(sys.argv) != 5:
		sys.exit(__doc__)
	main(*sys.argv[1:])
