# SPDX-License-Identifier: GPL-2.0-or-later
"""Tables of a survey as outlines and as states of the ground at the start.

	outline = talik.tables.outline("survey.csv")                                   # x, y of the corners
	temperature = talik.tables.ofDepth("borehole.csv", outline, "temperature")     # depth, temperature
	pressure = talik.tables.ofPlace("piezometers.csv", "pressure")                 # x, y, pressure
	talik.geometry.fill(mpm, outline, temperature=temperature, pressure=pressure)

A table is a CSV file. Empty lines, lines that begin with #, one line of headings and further columns are passed over.
"""

import csv
import math
from pathlib import Path

import numpy as np

from talik import dates


def read(path, columns):
	"""Rows of a CSV file as a list of lists of numbers, one for each of the columns.

	columns  what stands in the first columns, for messages: ("depth [m]", "temperature [degC]")

	ValueError names file, line and fault.

	>>> with open(folder + "/borehole.csv", "w") as file:
	...     written = file.write("depth [m],temperature [degC]\\n0,-1\\n10,-3\\n")
	>>> talik.tables.read(folder + "/borehole.csv", ("depth", "temperature"))
	[[0.0, -1.0], [10.0, -3.0]]"""
	return [numbers for _, numbers in numberedRows(path, columns)]


def numberedRows(path, columns):
	"""As read, with the number of the line before each row.

	>>> with open(folder + "/borehole.csv", "w") as file:
	...     written = file.write("0,-1\\n10,-3\\n")
	>>> list(talik.tables.numberedRows(folder + "/borehole.csv", ("depth", "temperature")))
	[(1, [0.0, -1.0]), (2, [10.0, -3.0])]"""
	return [(line, _numbers(path, line, cells, columns)) for line, cells in _rows(path)]


def outline(path):
	"""Corners (x, y) [m] of an outline in a CSV file of x and y, for talik.geometry.fill and talik.layers.fill.

	A last corner that repeats the first is left out.

	>>> with open(folder + "/survey.csv", "w") as file:
	...     written = file.write("x [m],y [m]\\n0,0\\n4,0\\n4,2\\n0,0\\n")
	>>> talik.tables.outline(folder + "/survey.csv")
	[(0.0, 0.0), (4.0, 0.0), (4.0, 2.0)]"""
	corners = [tuple(row) for row in read(path, ("x", "y"))]
	if len(corners) > 1 and corners[0] == corners[-1]:
		corners.pop()
	if len(corners) < 3:
		raise ValueError(f"{path} has {len(corners)} corners; an outline has 3 or more")
	return corners


def ofDepth(path, ground, name="value"):
	"""Function of x, y [m] that gives a value by the depth below the surface of the ground, linear between the depths of a table.

	path    CSV file with the columns depth [m], increasing, and the value: a borehole
	ground  outline (m, 2) [m] of the whole ground, whose upper side is the surface
	name    of the value, for messages

	Above the first and below the last depth the value is that of the first and the last.

	>>> with open(folder + "/borehole.csv", "w") as file:
	...     written = file.write("depth [m],temperature [degC]\\n0,-1\\n10,-3\\n")
	>>> temperature = talik.tables.ofDepth(folder + "/borehole.csv", [(0, 0), (4, 0), (4, 10), (0, 10)], "temperature")
	>>> float(temperature(1.0, 5.0))
	-2.0"""
	from talik.geometry import surfaceHeight

	heights = np.vectorize(lambda x: surfaceHeight(ground, x))
	rows = numberedRows(path, ("depth", name))
	if not rows:
		raise ValueError(f"{path} holds no data; it must have lines with depth [m] and {name}")
	for (_, before), (line, row) in zip(rows, rows[1:]):
		if row[0] <= before[0]:
			raise ValueError(f"{path}, line {line}: depth {row[0]:g} m follows {before[0]:g} m; depths must increase")
	depths, values = np.array([row for _, row in rows]).T
	return lambda x, y: np.interp(heights(x) - y, depths, values)


def ofPlace(path, name="value"):
	"""Function of x, y [m] that gives a value by its place, linear between the places of a table.

	path  CSV file with the columns x [m], y [m] and the value, in any order of lines, three places or more that are not on a line
	name  of the value, for messages

	Outside of the places the value is that of the nearest one.

	>>> with open(folder + "/piezometers.csv", "w") as file:
	...     written = file.write("x [m],y [m],pressure [Pa]\\n0,0,20e3\\n4,0,10e3\\n0,2,0\\n")
	>>> pressure = talik.tables.ofPlace(folder + "/piezometers.csv", "pressure")
	>>> float(pressure(2.0, 0.0))
	15000.0"""
	from scipy.spatial import QhullError

	from talik import _interpolation

	rows = np.array(read(path, ("x", "y", name))).reshape(-1, 3)
	try:
		return _interpolation.linear(rows[:, :2], rows[:, 2])
	except (QhullError, ValueError):
		raise ValueError(f"{path} has {len(rows)} places; give three or more that do not lie on one line") from None


def lines(path):
	"""Lines of a CSV file that hold data or headings, as (number, cells).

	>>> with open(folder + "/borehole.csv", "w") as file:
	...     written = file.write("depth [m],temperature [degC]\\n\\n0,-1\\n")
	>>> talik.tables.lines(folder + "/borehole.csv")
	[(1, ['depth [m]', 'temperature [degC]']), (3, ['0', '-1'])]"""
	try:
		text = Path(path).read_text(encoding="utf-8-sig")
	except (OSError, UnicodeDecodeError) as error:
		raise ValueError(f"{path} cannot be read: {error}") from None
	kept = [(number, line) for number, line in enumerate(text.splitlines(), 1) if line.strip() and not line.lstrip().startswith("#")]
	return [(number, next(csv.reader([line]))) for number, line in kept]


def _rows(path):
	"""Lines that hold data, as (number, cells)."""
	rows = lines(path)
	return rows[1:] if rows and not any(_isNumber(cell) for cell in rows[0][1]) else rows


def _isNumber(cell):
	try:
		float(cell)
	except ValueError:
		return False
	return True


def _seconds(path, line, cell):
	"""Calendar time of a date, as a text; what is no date stays."""
	if not cell.strip()[:4].isdigit():
		return cell
	try:
		return repr(dates.secondsPerDay * dates.dayOf(cell))
	except ValueError as problem:
		raise ValueError(f"{path}, line {line}: {problem}") from None


def _numbers(path, line, cells, columns):
	if len(cells) < len(columns):
		found = "1 column" if len(cells) == 1 else f"{len(cells)} columns"
		raise ValueError(f"{path}, line {line}: {found} instead of {', '.join(columns)}, separated by a comma")
	cells = [_seconds(path, line, cell) if name == "time" and not _isNumber(cell) else cell for cell, name in zip(cells, columns)]
	for cell, name in zip(cells, columns):
		if not _isNumber(cell) or not math.isfinite(float(cell)):
			raise ValueError(f"{path}, line {line}: {name} '{cell.strip()}' is not a number; give it or remove the line")
	return [float(cell) for cell in cells[: len(columns)]]
