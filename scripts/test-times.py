#!/usr/bin/python3
# SPDX-License-Identifier: GPL-2.0-or-later
"""Processor time of the tests of a run, beside the times in the tree.

usage: test-times.py <JUnit file of ctest> <build folder> <folder tests> [--record] [--ceiling]

Writes <build folder>/test-times.txt, a line for each test, and prints which tests have grown since tests/times.txt: by more than 30 % and by
more than 1 s. --record writes the times into that file. With --ceiling it ends with an error where the tests of tests/everyday.txt together
take more than their ceiling, or one of them did not run.

Times are compared as if the run had been on the machine of the times in the tree: the test 'pace' does the same work everywhere."""

import sys
import xml.etree.ElementTree as ElementTree
from pathlib import Path

ceiling = 180.0  # processor time of all everyday tests [s]
growth, least = 1.3, 1.0  # what is said to have grown: by this factor and by so much [s]


def read(file):
	"""Seconds by name."""
	if not file.is_file():
		return {}
	lines = [line.split() for line in file.read_text().splitlines() if line.strip() and not line.startswith("#")]
	return {name: float(seconds) for seconds, name in lines}


def write(file, times):
	rows = [f"{seconds:8.2f} {name}" for name, seconds in sorted(times.items(), key=lambda item: (-item[1], item[0]))]
	file.write_text("# Processor time of each test [s], written by scripts/test --record.\n" + "\n".join(rows) + "\n")


def ofRun(report, folder):
	"""Times of the tests that ran and passed; tests/timed left them."""
	times = {}
	for case in ElementTree.parse(report).getroot().findall("testcase"):
		file = folder / "test-times" / case.get("name")
		if case.get("status") == "run" and file.is_file():
			times[case.get("name")] = sum(map(float, file.read_text().split("\n")[-2].split()))
	return times


def grown(now, known, pace):
	"""Name, time now, time in the tree on this machine."""
	both = ((name, now[name], known[name] * pace) for name in now if name in known and name != "pace")
	return [row for row in both if row[1] > growth * row[2] and row[1] - row[2] > least * pace]


def report(now, known, everyday):
	"""What is said, the everyday tests without a time, and the sum of the others [s]."""
	pace = now["pace"] / known["pace"] if "pace" in now and "pace" in known else 1.0
	lines = [f"Processor time: {sum(now.values()):.0f} s in {len(now)} tests; this machine takes {pace:.2f} times as long as that of tests/times.txt."]
	for name, seconds, before in sorted(grown(now, known, pace), key=lambda row: row[2] - row[1]):
		lines.append(f"GROWN: {name} takes {seconds:.1f} s; it took {before:.1f} s")
	new = sorted(name for name in now if name not in known)
	if known and new:
		lines.append(f"not in tests/times.txt: {', '.join(new)}")
	missing = [name for name in everyday if name not in now]
	seconds = sum(now.get(name, 0) for name in everyday) / pace
	lines.append(f"The everyday tests that passed take {seconds:.0f} s at the pace of tests/times.txt; the ceiling of all is {ceiling:.0f} s.")
	return lines, missing, seconds


def main(words):
	junit, build, tests = map(Path, words[:3])
	now, tree = ofRun(junit, build), tests / "times.txt"
	everyday = [line for line in (tests / "everyday.txt").read_text().split("\n") if line and not line.startswith("#")]
	write(build / "test-times.txt", now)
	lines, missing, seconds = report(now, read(tree), everyday)
	if "--ceiling" in words:
		if missing:
			lines.append(f"MISSED: everyday tests that did not run, or failed: {', '.join(missing)}")
		if seconds > ceiling:
			lines.append("MISSED: the everyday tests are too slow. Make one shorter, or take it out of tests/everyday.txt.")
	print("\n" + "\n".join(lines))
	if "--record" in words:
		write(tree, {**read(tree), **now})
	return 1 if lines[-1].startswith("MISSED") else 0


if __name__ == "__main__":
	if len(sys.argv) < 4:
		sys.exit(__doc__)
	sys.exit(main(sys.argv[1:]))
