#!/usr/bin/python3
# SPDX-License-Identifier: GPL-2.0-or-later
"""Joins what the benchmarks of one kind wrote, prints the table, fails where a figure misses its limit.

usage  report.py <title> <build folder> <result.json> <part.json>..."""

import json
import sys
from dataclasses import asdict
from pathlib import Path

import figures


def main(title, buildFolder, target, *parts):
	measured, notes = [], []
	for part in parts:
		some, said = figures.read(part)
		measured += some
		notes += said
	machine = figures.machine(figures.compilerOf(buildFolder))
	Path(target).write_text(
		json.dumps(dict(title=title, machine=machine, figures=[asdict(f) | dict(reached=f.reached) for f in measured], notes=notes), indent="\t") + "\n"
	)
	print(f"\n{title}")
	print("; ".join(f"{name}: {value}" for name, value in machine.items()))
	print("\n".join(figures.table(measured)))
	for note in notes:
		print(f"- {note}")
	missed = [f for f in measured if not f.reached]
	for f in missed:
		print(f"MISSED: {f.name}: {f.value:.4g} {f.unit}, to reach {f.limit}".rstrip(), file=sys.stderr)
	return 1 if missed else 0


if __name__ == "__main__":
	if len(sys.argv) < 5:
		sys.exit(__doc__)
	sys.exit(main(*sys.argv[1:]))
