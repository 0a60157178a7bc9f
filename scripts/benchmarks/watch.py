#!/usr/bin/python3
# SPDX-License-Identifier: GPL-2.0-or-later
"""One line for a commit: what Talik takes over a reference that was measured beside it, and what takes longer than in the line before.

usage  watch.py slump <part.json> <yade> <folder>           processor time of Case I with the law, over that of tests/pace.py
	   watch.py line <watch.csv> <commit> <result.json>...  adds the line to the table and prints it; what takes 5 % more is red"""

import csv
import json
import os
import re
import statistics
import subprocess
import sys
from pathlib import Path

import figures

root = Path(__file__).resolve().parents[2]
slower = 1.05

# column of the table -> the figure whose value it is, and the figure that it is over; stock/packed turned round, so that less is better everywhere
columns = {
	"discs over stock YADE": (r"frictional, (?!portable|strain).*: stock/packed", -1),
	"frozen discs over stock YADE": (r"bonded, no bond breaking: stock/packed", -1),
	"spheres over stock YADE": (r"spheres, frictional: stock/packed", -1),
	"dry ground over a minimal code": (r"dry: engine/minimum", 1),
	"water and ice over dry ground": (r"water, heat, freezing", r"dry"),
	"everything over dry ground": (r"everything", r"dry"),
	"implicit over explicit pressure": (r"level ground, implicit pressure", r"level ground"),
	"Case I with the law over the same work everywhere": (r"Case I with the law", 1),
	"_talik over a file of Boost.Python": (r"over one file of Boost.Python", 1),
}


def lineOf(measured):
	"""Ratios by column; none of what was not measured."""
	found = lambda name: next((value for known, value in measured.items() if re.fullmatch(name, known)), None)
	line = {}
	for column, (name, over) in columns.items():
		value, reference = found(name), found(over) if isinstance(over, str) else 1.0
		if value and reference:
			line[column] = float(f"{(value / reference) ** (1 if isinstance(over, str) else over):.4g}")
	return line


def add(table, commit, line, machine):
	"""Adds a line and returns the columns that take longer than in the line before of the same machine."""
	before = [row for row in (csv.DictReader(table.open()) if table.exists() else ()) if row["machine"] == machine]
	head = not table.exists()
	with table.open("a", newline="") as file:
		writer = csv.DictWriter(file, ["commit", "machine", *columns], lineterminator="\n")
		if head:
			writer.writeheader()
		writer.writerow(dict(line, commit=commit, machine=machine))
	return [name for name, value in line.items() if before and before[-1][name] and value > slower * float(before[-1][name])]


def processorTime(*command, rounds=1):
	times = []
	for _ in range(rounds):
		before = os.times()
		subprocess.run([*map(str, command)], check=True, stdout=subprocess.DEVNULL, stderr=subprocess.STDOUT)
		after = os.times()
		times.append(after.children_user + after.children_system - before.children_user - before.children_system)
	return statistics.median(times)


def slump(part, yade, folder):
	pace = processorTime(sys.executable, root / "tests" / "pace.py", rounds=3)
	scene = [root / "examples" / "thaw_slump_surface.py", "--preset", "draft", "--skeleton", "MohrCoulomb", "--output", folder]
	took = processorTime(yade, "-n", "-x", "-j1", *scene)
	figures.write(part, [figures.Figure("Case I with the law", took / pace, "x", terms={"processor time [s]": took, "tests/pace.py [s]": pace})])


def main(table, commit, *results):
	read = [json.loads(Path(result).read_text()) for result in results]
	line = lineOf({figure["name"]: figure["value"] for one in read for figure in one["figures"]})
	longer = add(Path(table), commit, line, read[0]["machine"]["CPU"])
	for name, value in line.items():
		print(f"\033[31m{value:10.4g}  {name}: more than 5 % longer than before\033[0m" if name in longer else f"{value:10.4g}  {name}")
	return 1 if longer else 0


if __name__ == "__main__":
	if sys.argv[1:2] == ["slump"] and len(sys.argv) == 5:
		slump(*sys.argv[2:])
	elif sys.argv[1:2] == ["line"] and len(sys.argv) > 4:
		sys.exit(main(*sys.argv[2:]))
	else:
		sys.exit(__doc__)
