# SPDX-License-Identifier: GPL-2.0-or-later
"""The convergence of the thaw slumps for readers: tables in a page between two markers, and a picture for each case.

The page, the pictures and the rows that they are made of lie beside each other, so that anybody can make the page anew from its rows."""

import json
import textwrap
from pathlib import Path

import numpy as np

from talik import plots
from talik.studies.accuracy import convergence
from talik.studies.accuracy.convergence import cases, knobs, measures
from talik.files import writeWhole

begin, end = "<!-- convergence of the slumps: written by scripts/accuracy slump --write -->", "<!-- end of the convergence of the slumps -->"
aim = 0.1  # by which the two finest values of a knob may differ
skeletons = {"MohrCoulomb": "law", "samples": "samples"}


def measured(case, rows):
	"""Sweeps of a case of which two rows or more are there: [(sweep, values, rows)]. Rows that failed count as not there."""
	found = []
	for sweep in convergence.sweeps():
		named = [(value, rows.get(convergence.rowKey(case, sweep, value))) for value in sweep.values]
		there = [(value, row) for value, row in named if row is not None and "failure" not in row]
		if len(there) > 1:
			found.append((sweep, *zip(*there)))
	return found


def planned(rows):
	"""Rows of the present plan, in its order: others were kept by an earlier version of it."""
	return {name: rows[name] for name in convergence.plan() if name in rows}


def groundOf(sweep):
	return f"{skeletons[sweep.ground['skeleton']]}, {sweep.ground['thawed cohesion'] / 1e3:g} kPa"


def knobOf(sweep):
	"""The knob, and which others are not draft's."""
	fixed = [knobs[name].phrase.format(knobs[name].text(value)) for name, value in sweep.fixed.items()]
	return knobs[sweep.knob].label + (f" with {', '.join(fixed)}" if fixed else "")


# ---- tables ---------------------------------------------------------------------------------------------------------------


def tableOf(case, sweepsThere):
	"""[header, line, ...] of cells: what each row came to and, in brackets, its difference to the finest of its knob that came to that day."""
	days = cases[case].tableDays
	lines = [["ground", "knob", "value", *(f"u, day {day} [m]" for day in days), *(f"V, day {day} [m³/m]" for day in days), "first event [day]", "CPU [s]"]]
	for sweep, values, rows in sweepsThere:
		for k, (value, row) in enumerate(zip(values, rows)):
			names = ["", ""] if k else [groundOf(sweep), knobOf(sweep)]
			finest = convergence.finestThatReached(case, rows[k + 1 :])
			cells = (_cell(own, finest.get(name)) for name, own in measures(case, row).items())
			lines.append([*names, knobs[sweep.knob].text(value), *cells, f"{row['cpu']:.0f}"])
	return lines


def _cell(value, finest):
	if value is None:
		return "–"
	apart = convergence.difference(value, finest)
	return f"{value:.3g}" + ("" if apart is None else f" ({round(100 * apart):+d} %)")


def verdictOf(case, sweepsThere):
	"""[header, line, ...] of cells: how far the two finest values of each knob are apart."""
	lines = [["ground", "knob", "two finest", "u", "V", "first event", f"within {aim:.0%}"]]
	for sweep, values, rows in sweepsThere:
		apart = convergence.twoFinest(case, rows)
		met = all(one is not None and one <= aim for one in (apart["displacement"], apart["volume"]))
		pair = " and ".join(knobs[sweep.knob].text(value) for value in values[-2:])
		shared = [day for day in cases[case].tableDays if day <= min(map(convergence.reached, rows[-2:]))]
		if len(shared) < len(cases[case].tableDays):
			pair += f", until day {shared[-1]}" if shared else ", no day shared"
		lines.append(
			[groundOf(sweep), knobOf(sweep), pair, *(_percent(apart[name]) for name in ("displacement", "volume", "first event")), "yes" if met else "no"]
		)
	return lines


def _percent(apart):
	return "–" if apart is None else f"{100 * apart:.0f} %"


def markdown(rows, pictures="accuracy_slump"):
	"""All there is to say of the rows, {key: row}; pictures: name of their files, less _CASE.png."""
	parts, note = [part for case in cases for part in _partsOf(case, rows, pictures)], buildsNote(rows)
	return "\n\n".join([note, *parts] if note else parts)


def buildsNote(rows):
	"""A sentence where the rows were measured by several builds of Talik, else nothing."""
	builds = {row.get("build") for row in rows.values() if "failure" not in row}
	return f"These rows were measured by {len(builds)} builds of Talik." if len(builds) > 1 else ""


def _partsOf(case, rows, pictures):
	there, title = measured(case, rows), cases[case].title
	if not there:
		return []
	own = [row for row in planned(rows).values() if row["settings"]["case"] == case]
	unfinished = [f"- {convergence.describe(row['settings'])}: {why}" for row in own if (why := row.get("failure") or row.get("shortfall"))]
	return [
		f"### {title}",
		f"How far the two finest values of each knob are apart, at most over days {', '.join(str(day) for day in cases[case].tableDays)}:",
		_markdownTable(verdictOf(case, there)),
		"Every row, with its difference to the finest of its knob that came to that day:",
		_markdownTable(tableOf(case, there)),
		*(["Did not come to their end:\n\n" + "\n".join(map(_wrapped, unfinished))] if unfinished else []),
		f"![{title}: largest displacement over the days, one panel for each knob]({pictures}_{case}.png)",
	]


def _wrapped(item):
	"""An item of a list in lines that the page takes."""
	return textwrap.fill(item, 150, subsequent_indent="  ", break_long_words=False, break_on_hyphens=False)


def _markdownTable(lines):
	header, *body = lines
	return "\n".join("| " + " | ".join(line) + " |" for line in (header, ["---"] * len(header), *body))


# ---- pictures -------------------------------------------------------------------------------------------------------------


def draw(case, sweepsThere):
	"""Largest displacement over the days: one panel for each sweep, one curve for each value."""
	across = min(3, len(sweepsThere))
	down = -(-len(sweepsThere) // across)
	fig = plots.figure(4 * across, 2.9 * down)
	panels = np.ravel(fig.subplots(down, across))
	for axes, (sweep, values, rows) in zip(panels, sweepsThere):
		for value, row in zip(values, rows):
			days, largest, _ = np.transpose(row["history"])
			axes.plot(days, largest, linewidth=1.2, label=knobs[sweep.knob].text(value))
		axes.set_title(f"{groundOf(sweep)}: {knobOf(sweep)}".replace(" with ", "\nwith ").replace(", a scale", ",\na scale"), fontsize=8)
		axes.set_xlabel("day of the thaw")
		axes.set_ylabel("largest displacement [m]")
		axes.set_ylim(bottom=0)
		axes.grid(color="0.92")
		axes.legend(fontsize=7, frameon=False, title=knobs[sweep.knob].label, title_fontsize=7)
	for axes in panels[len(sweepsThere) :]:
		axes.set_visible(False)
	return fig


def drawAll(rows, folder, name="accuracy_slump"):
	"""One picture for each case of which there are rows; returns their paths."""
	pictures = []
	for case in cases:
		there = measured(case, rows)
		if there:
			pictures.append(plots.save(draw(case, there), Path(folder) / f"{name}_{case}.png", dpi=80))
	return pictures


# ---- the page -------------------------------------------------------------------------------------------------------------


def rowsBeside(page):
	"""The file of the rows that a page is made of."""
	return Path(page).with_name(Path(page).stem + "_slump.json")


def write(page, rows):
	"""Puts tables into a page between its markers, rows and pictures beside it."""
	page = Path(page)
	before, _, after = parts(page)
	writeWhole(rowsBeside(page), "{\n" + ",\n".join(f"{json.dumps(name)}: {json.dumps(row)}" for name, row in planned(rows).items()) + "\n}\n")
	drawAll(rows, page.parent, rowsBeside(page).stem)
	writeWhole(page, f"{before}{begin}\n{markdown(rows, rowsBeside(page).stem)}\n{end}{after}")


def parts(page):
	"""Text of a page before, between and after the markers."""
	try:
		text = Path(page).read_text()
	except OSError as failure:
		raise ValueError(f"{page} cannot be read ({failure.strerror}); name a page with the two markers of these tables") from None
	if begin not in text or end not in text:
		raise ValueError(f"{page} lacks the two markers of these tables; write them where the tables shall stand:\n{begin}\n{end}")
	before, rest = text.split(begin, 1)
	between, after = rest.split(end, 1)
	return before, between.strip("\n"), after


def agrees(page):
	"""Whether the tables of a page are those of the rows beside it."""
	shown, rows = parts(page)[1], rowsBeside(page)
	if not rows.exists():
		raise ValueError(f"{rows} is not there: write the page with scripts/accuracy slump --write {page}")
	return shown == markdown(json.loads(rows.read_text()), rows.stem)
