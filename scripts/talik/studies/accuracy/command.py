# SPDX-License-Identifier: GPL-2.0-or-later
"""scripts/accuracy, inside yade: the study, its table and pictures; ends with an error on a miss."""

import argparse
import os
import sys
import traceback

from talik import plots
from talik.studies import accuracy
from talik.studies.accuracy import report
from talik.files import writableFolder


def main():
	names = [problem.name for problem in accuracy.problems]
	parser = argparse.ArgumentParser(prog="scripts/accuracy", description="Error over computing time for every knob.")
	parser.add_argument("--quick", action="store_true", help="fewer and coarser runs")
	parser.add_argument("--problem", action="append", choices=names, help="only this problem; may be given several times")
	parser.add_argument("--output", default="output/accuracy", help="folder for tables and pictures")
	options = parser.parse_args()
	folder = writableFolder(options.output)
	problems = [problem for problem in accuracy.problems if not options.problem or problem.name in options.problem]
	results = accuracy.Results(folder / "results.json")
	accuracy.runStudy(problems, results, options.quick)
	tables = {problem: report.marked(accuracy.table(problem, results, options.quick)) for problem in problems}
	accuracy.saveTable([row for rows in tables.values() for row in rows], folder / "accuracy.csv")
	report.saveStudy(tables, folder / "accuracy.json", options.quick)
	picture = plots.save(accuracy.drawStudy(tables), folder / "accuracy.png", dpi=100)
	for problem, rows in tables.items():
		print(f"\n{problem.title}\nerror: {problem.norm}; against: {problem.referenceName(options.quick)}")
		accuracy.printTable(rows, report.shown)
	print()
	for problem, rows in tables.items():
		print(report.advice(problem, rows))
	missed = [sentence for problem, rows in tables.items() for sentence in report.misses(problem, rows)]
	print(f"\n{picture}, {folder / 'accuracy.csv'}, {folder / 'accuracy.json'}; every run as it was: {results.file}")
	for sentence in missed:
		print(f"MISSED  {sentence}")
	return 1 if missed else 0


if __name__ == "__main__":
	status = 1
	try:
		status = main()
	except Exception:
		traceback.print_exc()
	sys.stdout.flush()
	sys.stderr.flush()
	os._exit(status)  # the exit status of yade itself is always 0
