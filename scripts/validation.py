#!/usr/bin/python3
# SPDX-License-Identifier: GPL-2.0-or-later
"""What the validation tests left in a folder (rows/*.csv, curves/*.csv), as table, drawings and page."""

import argparse
import csv
import math
import re
import sys
from pathlib import Path

begin, end = "<!-- validation table: written by scripts/test -L validation --markdown -->", "<!-- end of the validation table -->"
slowBegin, slowEnd = "<!-- slow validation table: written by scripts/test -L validation --all --markdown -->", "<!-- end of the slow validation table -->"
slabBegin, slabEnd = "<!-- slab table: written by scripts/test -L validation --all --markdown -->", "<!-- end of the slab table -->"
slabRow = re.compile(r"slab on a frozen base, (?P<what>.*): X/h = (?P<thickness>[\d.]+), front (?P<above>[\d.]+) h above a node, u over a t\^2/2")
slabTests = ("LayerOfAnyThickness", "LayerOnAFrontInclined", "MeanOfALayer")  # that the table of the slab is made of


# ---- rows -----------------------------------------------------------------------------------------------------------------


def readRows(folder):
	"""Rows of all tests as dictionaries, with numbers for error and tolerance and the case: the name before the first colon."""
	rows = []
	for file in sorted(Path(folder, "rows").glob("*.csv")):
		with file.open(newline="") as lines:
			rows += [{**row, "test": file.stem} for row in csv.DictReader(lines)]
	for row in rows:
		row["case"], _, row["figure"] = (part.strip().replace("|", "to") for part in row["name"].partition(":"))  # a bar ends a cell of the table
		row["error"], row["tolerance"] = float(row["error"]), float(row["tolerance"])
	return rows


def bySpeed(rows):
	"""(begin, end, rows) of the table of the everyday tests and of that of the slow ones, which may be empty."""
	tables = ((begin, end, False), (slowBegin, slowEnd, True))
	return [(first, last, [row for row in rows if row["test"].endswith("_slow") == slow]) for first, last, slow in tables]


def severity(row):
	"""Error over tolerance; an order of convergence (tolerance 0) counts as met or missed."""
	if row["tolerance"] == 0:
		return 0.0 if row["passed"] == "1" else math.inf
	return abs(row["error"]) / row["tolerance"]


def worstByCase(rows):
	"""One row per case, the one nearest to its tolerance, in order of appearance of the names."""
	worst = {}
	for row in rows:
		if row["case"] not in worst or severity(row) > severity(worst[row["case"]]):
			worst[row["case"]] = row
	return dict(sorted(worst.items(), key=lambda item: item[0].lower()))


def markdown(rows):
	counts = {}
	for row in rows:
		counts[row["case"]] = counts.get(row["case"], 0) + 1
	lines = ["| case | figures | reference | figure nearest to its tolerance | error | tolerance |", "|---|---|---|---|---|---|"]
	for case, row in worstByCase(rows).items():
		lines.append(f"| {case} | {counts[case]} | {row['source'] or 'exact'} | {row['figure']} | {row['error']:.1e} | {row['tolerance']:.1e} |")
	return "\n".join(lines)


def slabTable(rows):
	"""u over a t^2/2 of every slab of the slow tests, a column per thickness; empty where they were not run."""
	found, thicknesses = {}, set()
	for row in rows:
		match = slabRow.fullmatch(row["name"]) if any(name in row["test"] for name in slabTests) else None
		if not match:
			continue
		thickness = float(match["thickness"])
		thicknesses.add(thickness)
		line = found.setdefault((match["what"], match["above"] if match["what"].startswith("along") else "steps"), {})
		line[thickness] = (float(row["measured"]), row["tolerance"])
	columns = sorted(thicknesses)
	lines = ["| slab | front above a node [h] | " + " | ".join(f"X/h = {x:g}" for x in columns) + " | allowed |", "|---" * (len(columns) + 3) + "|"]
	for (what, above), line in sorted(found.items()):
		allowed = sorted({f"{100 * tolerance:.0f} %" for _, tolerance in line.values()}, key=lambda text: int(text.split()[0]))
		cells = [f"{line[x][0]:.3f}" if x in line else "–" for x in columns]
		lines.append(f"| {what} | {above} | " + " | ".join(cells) + f" | {', '.join(allowed)} |")
	return "\n".join(lines) if found else ""


def writeBetween(page, first, last, table):
	"""Puts a table between two markers of a Markdown page."""
	text = page.read_text()
	if first not in text or last not in text:
		sys.exit(f"{page}: the markers {first} and {last} are missing")
	before, rest = text.split(first, 1)
	page.write_text(f"{before}{first}\n{table}\n{last}{rest.split(last, 1)[1]}")


def writeInto(page, rows):
	"""Writes the tables of a page anew; those of slow tests only where these have left their rows."""
	for first, last, some in bySpeed(rows):
		if some:
			writeBetween(page, first, last, markdown(some))
	if slab := slabTable(rows):
		writeBetween(page, slabBegin, slabEnd, slab)


def tableOf(page, first, last):
	"""Case -> (figure, error, tolerance) of the table between two markers of a Markdown page."""
	inside = page.read_text().split(first, 1)[1].split(last, 1)[0]
	cells = [[cell.strip() for cell in line.strip("|").split("|")] for line in inside.strip().splitlines()[2:]]
	return {cell[0]: (cell[3], float(cell[4]), float(cell[5])) for cell in cells}


def disagreements(page, rows):
	"""What in a page's tables is not what the rows say. Slow tests that were not run have nothing to say."""
	return [problem for first, last, some in bySpeed(rows) for problem in _disagreements(page.name, tableOf(page, first, last), worstByCase(some))]


def _disagreements(page, shown, found):
	"""Names, tolerances, errors by more than half a tolerance; another figure that is nearer to its tolerance."""
	problems = [f"{case}: not in {page}" for case in found if case not in shown]
	for case, row in found.items():
		if case not in shown:
			continue
		figure, error, tolerance = shown[case]
		if figure != row["figure"]:
			if severity(row) > abs(error) / tolerance + 0.5:
				problems.append(f"{case}: {row['figure']} is nearer to its tolerance than what {page} shows")
		elif not math.isclose(tolerance, row["tolerance"], rel_tol=0.1):
			problems.append(f"{case}: tolerance {row['tolerance']:.1e}, {page} says {tolerance:.1e}")
		elif abs(abs(error) - abs(row["error"])) > max(0.5 * tolerance, 0.05 * abs(error)):
			problems.append(f"{case}: error {row['error']:.1e}, {page} says {error:.1e}")
	return problems


# ---- drawings -------------------------------------------------------------------------------------------------------------


def readCurve(file):
	"""Title, labels and {series: {kind: (x, y)}} of one file."""
	lines = file.read_text().splitlines()
	title, xLabel, yLabel = (line[2:] for line in lines[:3])
	series = {}
	for row in csv.DictReader(lines[3:]):
		x, y = series.setdefault(row["series"], {}).setdefault(row["kind"], ([], []))
		x.append(float(row["x"]))
		y.append(float(row["y"]))
	return title, xLabel, yLabel, series


def drawCurve(axes, file, small=False):
	title, xLabel, yLabel, series = readCurve(file)
	for number, (name, kinds) in enumerate(series.items()):
		colour = f"C{number}"
		if "reference" in kinds:
			few = len(kinds["reference"][0]) < 20
			axes.plot(*kinds["reference"], "x" if few else "-", color=colour if not few else "k", lw=1)
		if "computed" in kinds:
			axes.plot(*kinds["computed"], "o", color=colour, ms=2 if small else 4, mfc="none", label=name)
	axes.set(xlabel=xLabel, ylabel=yLabel)
	axes.set_title(title, fontsize=7 if small else 10)
	axes.grid(alpha=0.3)
	if len(series) > 1:
		axes.legend(fontsize=6 if small else 8)


def draw(folder):
	"""One PNG per curve and overview.png with all of them: markers computed, lines reference."""
	import matplotlib

	matplotlib.use("Agg")
	from matplotlib import pyplot
	from PIL import Image

	files = sorted(Path(folder, "curves").glob("*.csv"))
	for file in files:
		figure, axes = pyplot.subplots(figsize=(6, 4))
		figure.subplots_adjust(left=0.14, right=0.97, bottom=0.13, top=0.92)
		drawCurve(axes, file)
		figure.savefig(Path(folder, file.stem + ".png"), dpi=90)
		pyplot.close(figure)
	columns = 4
	rows = math.ceil(len(files) / columns)
	pyplot.rcParams.update({"font.size": 6})
	figure, grid = pyplot.subplots(rows, columns, figsize=(12, 2.4 * rows), squeeze=False)
	figure.subplots_adjust(left=0.05, right=0.99, bottom=0.15 / rows, top=1 - 0.35 / rows, wspace=0.25, hspace=0.45)
	for axes in grid.flat[len(files) :]:
		axes.axis("off")
	for axes, file in zip(grid.flat, files):
		drawCurve(axes, file, small=True)
	figure.suptitle("Computed (markers) against reference (lines)", fontsize=9, y=1 - 0.06 / rows)
	overview = Path(folder, "overview.png")
	figure.savefig(overview, dpi=80)
	Image.open(overview).convert("P", palette=Image.Palette.ADAPTIVE, colors=48).save(overview, optimize=True)
	return files


def main():
	parser = argparse.ArgumentParser(description=__doc__)
	parser.add_argument("folder", type=Path)
	parser.add_argument("--draw", action="store_true", help="a PNG per curve, and overview.png")
	parser.add_argument("--write", type=Path, help="Markdown page whose table is written anew")
	parser.add_argument("--check", type=Path, help="Markdown page whose table is compared; ends with an error if it is out of date")
	options = parser.parse_args()
	rows = readRows(options.folder)
	if not rows:
		sys.exit(f"{options.folder}: no rows; run the validation tests first")
	if options.draw:
		files = draw(options.folder)
		print(f"{len(files)} drawings and overview.png in {options.folder}")
	if options.write:
		writeInto(options.write, rows)
		print(f"{len(worstByCase(rows))} cases written into {options.write}")
	if options.check:
		problems = disagreements(options.check, rows)
		if problems:
			problems.append("the tables are written anew by  scripts/test -L validation [--all] --markdown")
		print("\n".join(problems) or f"{len(worstByCase(rows))} cases agree with {options.check.name}")
		sys.exit(1 if problems else 0)


if __name__ == "__main__":
	main()
