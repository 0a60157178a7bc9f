# SPDX-License-Identifier: GPL-2.0-or-later
"""scripts/accuracy slump, inside yade: how the answer of the thaw slumps depends on every setting."""

import argparse
import os
import sys
import traceback

from talik.studies.accuracy import convergence, convergencepage, report, study
from talik.files import writableFolder

stopped = 130  # exit status of a command that Ctrl-C ended


class Parser(argparse.ArgumentParser):
	def error(self, message):
		raise ValueError(message)


def parse(arguments=None):
	parser = Parser(prog="scripts/accuracy slump", description="Convergence of the thaw slumps, knob by knob.")
	parser.add_argument("--case", choices=(*convergence.cases, "both"), default="both", help="thaw from the surface, from the base, or both")
	parser.add_argument("--quick", action="store_true", help="the two coarsest values of the cheapest knobs")
	parser.add_argument("--knob", action="append", choices=sorted(convergence.knobs), default=[], help="only this knob; may be given several times")
	parser.add_argument("--output", default="output/accuracy/slump", help="folder for rows, tables and pictures")
	parser.add_argument("--write", metavar="PAGE", help="also write the tables of all rows that are there into this page, rows and pictures beside it")
	parser.add_argument("--check", metavar="PAGE", help="run nothing: are the tables of this page those of the rows beside it?")
	return parser.parse_args(arguments)


def main(arguments=None):
	options = parse(arguments)
	if options.check:
		return check(options.check)
	if options.write:
		convergencepage.parts(options.write)  # a page that cannot be written is refused before the runs
	folder = writableFolder(options.output)
	results = study.Results(folder / "rows.json")
	chosen = tuple(convergence.cases) if options.case == "both" else (options.case,)
	rows = convergence.plan(chosen, options.knob, options.quick)
	if not rows:
		raise ValueError(f"--quick has no rows of {', '.join(options.knob)}; leave --quick out")
	try:
		convergence.runRows(rows, results)
	except KeyboardInterrupt:
		done = sum(name in results for name in rows)
		print(f"Stopped; {done} of {len(rows)} rows are in {results.file}, and the same command goes on with the others.", file=sys.stderr)
		return stopped
	printReport(rows, results, folder)
	if options.write:
		convergencepage.write(options.write, results.rows)
		print(f"{options.write} is written anew")
	return failures(rows, results)


def printReport(rows, results, folder):
	there = {name: results.rows[name] for name in rows}
	for case in convergence.cases:
		sweeps = convergencepage.measured(case, there)
		if sweeps:
			print(f"\n{convergence.cases[case].title}")
			print(
				f"u largest displacement, V volume displaced by more than {convergence.moved:g} m; in brackets the difference to the finest value of the knob"
			)
			report.printAligned(convergencepage.tableOf(case, sweeps))
			print("\nThe two finest values of each knob differ, at most over these days, by")
			report.printAligned(convergencepage.verdictOf(case, sweeps))
	if note := convergencepage.buildsNote(there):
		print(f"\n{note} Delete {results.file} to measure all of them anew.")
	(folder / "table.md").write_text(convergencepage.markdown(there) + "\n")
	pictures = convergencepage.drawAll(there, folder)
	print(f"\n{', '.join(pictures)}, {folder / 'table.md'}; every row as it was: {results.file}")


def failures(rows, results):
	failed = [results.rows[name] for name in rows if "failure" in results.rows[name]]
	for row in failed:
		print(f"MISSED  {convergence.describe(row['settings'])}: {row['failure']}")
	return 1 if failed else 0


def check(page):
	if convergencepage.agrees(page):
		print(f"the tables of {page} are those of {convergencepage.rowsBeside(page)}")
		return 0
	print(f"the tables of {page} are not those of {convergencepage.rowsBeside(page)}: write them anew with scripts/accuracy slump --write {page}")
	return 1


if __name__ == "__main__":
	status = 1
	try:
		status = main()
	except (ValueError, RuntimeError) as refused:
		print(f"scripts/accuracy slump: {refused}", file=sys.stderr)
	except SystemExit as help:
		status = help.code
	except BaseException:
		traceback.print_exc()
	sys.stdout.flush()
	sys.stderr.flush()
	os._exit(status)  # the exit status of yade itself is always 0
