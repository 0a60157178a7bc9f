# SPDX-License-Identifier: GPL-2.0-or-later
"""What a study says: tables, the Pareto front, the cheapest setting for a stated error, pictures, and what missed its mark."""

import csv
import json
import math
from pathlib import Path

import numpy as np
from matplotlib.ticker import FuncFormatter, LogLocator, NullFormatter

from talik import plots
from talik.files import writableFolder, writeWhole

levels = (0.01, 0.03, 0.1)
cost = "CPU time [s]"  # what settings are compared by: wall time depends on what else a machine is doing
shown = ("varied", "error [-]", "wall time [s]", "CPU time [s]", "memory [MB]", "points", "steps", "runs", "on the front", "presets")


def usable(rows):
	return [row for row in rows if not row["failure"] and math.isfinite(row["error [-]"])]


def paretoFront(rows):
	"""Rows that none is both faster and better than, fastest first."""
	front = []
	for row in sorted(usable(rows), key=lambda row: (row[cost], row["error [-]"])):
		if not front or row["error [-]"] < front[-1]["error [-]"]:
			front.append(row)
	return front


def marked(rows):
	"""The rows, with a column that says which of them are on the Pareto front."""
	front = paretoFront(rows)
	return [{**row, "on the front": "yes" if row in front else ""} for row in rows]


def cheapest(rows, level):
	"""The fastest row with an error up to a level; None if there is none."""
	return min((row for row in usable(rows) if row["error [-]"] <= level), key=lambda row: row[cost], default=None)


def advice(problem, rows):
	"""For 1 / 3 / 10 % take ..., it costs ...: one sentence."""
	parts = []
	for level in levels:
		row = cheapest(rows, level)
		if row is None:
			best = min((r["error [-]"] for r in usable(rows)), default=math.nan)
			parts.append(f"{level:.0%} is not reached (best {best:.1%})")
		else:
			parts.append(
				f"for {level:.0%} take {row['varied']}: {row[cost]:.2g} s of computing ({row['wall time [s]']:.2g} s of wall time), {row['memory [MB]']:.2g} MB"
			)
	return f"{problem.name}: " + "; ".join(parts) + "."


def misses(problem, rows):
	"""What is wrong with the rows of a problem, as sentences."""
	found = [f"{problem.name}, {row['varied']}: {row['failure']}" for row in rows if row["failure"]]
	level = 0.03 if problem.exact is not None else 0.1
	if rows and cheapest(rows, level) is None:
		found.append(f"{problem.name}: no setting has an error of {level:.0%} or less")
	if not rows:
		found.append(f"{problem.name}: not measured")
	return found


def saveStudy(tables, path, quick=False):
	"""JSON: of each problem norm, reference, advice and rows; null where there is no number."""
	study = {
		problem.name: {
			"title": problem.title,
			"norm": problem.norm,
			"reference": problem.referenceName(quick),
			"advice": advice(problem, rows),
			"rows": [_numbersOrNull(row) for row in rows],
		}
		for problem, rows in tables.items()
	}
	writeWhole(path, json.dumps(study, indent="\t", allow_nan=False))


def _numbersOrNull(row):
	return {name: None if isinstance(value, float) and not math.isfinite(value) else value for name, value in row.items()}


# ---- tables ---------------------------------------------------------------------------------------------------------------


def column(rows, name):
	"""One named number of all rows."""
	return np.array([row[name] for row in rows])


def saveTable(rows, path):
	"""CSV with one line per row."""
	writableFolder(Path(path).parent)
	with open(path, "w", newline="") as file:
		writer = csv.DictWriter(file, fieldnames=list(rows[0]))
		writer.writeheader()
		writer.writerows(rows)


def printTable(rows, names=None):
	"""Rows in columns as wide as their widest entry."""
	names = names or list(rows[0])
	printAligned([list(names)] + [[_short(row[name]) for name in names] for row in rows])


def printAligned(text):
	widths = [max(len(line[c]) for line in text) for c in range(len(text[0]))]
	for line in text:
		print("  ".join(cell.rjust(width) for cell, width in zip(line, widths)))


def _short(value):
	return f"{value:.3g}" if isinstance(value, float) else "" if value is None else str(value)


# ---- pictures -------------------------------------------------------------------------------------------------------------


def drawCurves(axes, problem, rows):
	"""Error over computing time, one curve per knob through the standard setting, and the Pareto front."""
	axes.set_title(problem.title, fontsize=9)
	axes.set_xlabel("computing time, all threads [s]")
	axes.set_ylabel("error [%]")
	rows = usable(rows)
	if not rows:
		return axes
	standard = [row for row in rows if row["knob"] == "standard"]
	knobs = [knob for knob in dict.fromkeys(row["knob"] for row in rows) if knob not in ("standard", "pair")]
	for knob in knobs:
		curve = sorted([row for row in rows if row["knob"] == knob] + standard, key=lambda row: row[cost])
		named = knob in ("transfer", "shape function")  # has no order that a line could follow
		axes.plot(column(curve, cost), _percent(curve), "o" if named else "o-", markersize=3.5, linewidth=1, label=knob)
	pairs = [row for row in rows if row["knob"] == "pair"]
	if pairs:
		axes.plot(column(pairs, cost), _percent(pairs), "o", color="0.7", markersize=3, label="pairs", zorder=1)
	if standard:
		axes.plot(column(standard, cost), _percent(standard), "s", color="black", markersize=5, label="standard")
	front = paretoFront(rows)
	axes.step(column(front, cost), _percent(front), where="post", color="black", linewidth=3, alpha=0.25, label="Pareto front")
	axes.set_xscale("log")
	axes.set_yscale("log")
	for axis, limits, between, room in (
		(axes.xaxis, axes.get_xlim(), (1, 3), 2.3),
		(axes.yaxis, axes.get_ylim(), (1, 2, 5), 4),
	):  # decades with room for ticks between
		axis.set_major_locator(LogLocator(subs=between if limits[1] / limits[0] < 10 ** room else (1,)))
		axis.set_major_formatter(FuncFormatter(lambda value, _: f"{value:g}"))
		axis.set_minor_formatter(NullFormatter())
	axes.grid(color="0.92")
	axes.legend(fontsize=6.5, frameon=False)
	return axes


def _percent(rows):
	return 100 * np.maximum(column(rows, "error [-]"), 1e-6)


def drawStudy(tables):
	"""All problems, {problem: rows}, on one sheet."""
	number = len(tables)
	across = min(3, number)
	down = -(-number // across)
	fig = plots.figure(4 * across, 3.4 * down)
	panels = np.ravel(fig.subplots(down, across))
	for axes, (problem, rows) in zip(panels, tables.items()):
		drawCurves(axes, problem, rows)
	for axes in panels[number:]:
		axes.set_visible(False)
	return fig
