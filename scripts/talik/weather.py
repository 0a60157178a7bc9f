# SPDX-License-Identifier: GPL-2.0-or-later
"""Weather series as boundary conditions.

	times, values = talik.weather.airTemperature("station.csv")
	SurfaceTemperature(region="surface", heatTransferCoefficient=15, times=times, values=values)
"""

import csv
import math
from pathlib import Path

coldest, warmest = -100.0, 100.0  # what SurfaceTemperature accepts [degC]


def airTemperature(path, start=0.0, thermalTimeScale=None):
	"""Times [s] and air temperatures [degC] of a CSV file, for the attributes times and values of a thermal boundary.

	path   file with the columns time [s], increasing, and air temperature [degC]; further columns are passed over, as are
		   empty lines, lines that begin with #, and one line of headings
	start  time of the series [s] at which the run begins

	ValueError names file, line and fault.

	>>> with open(folder + "/station.csv", "w") as file:
	...     written = file.write("time [s],air [degC]\\n0,-10\\n86400,-5\\n")
	>>> talik.weather.airTemperature(folder + "/station.csv")
	([0.0, 86400.0], [-10.0, -5.0])"""
	if thermalTimeScale is not None:
		raise ValueError(f"thermalTimeScale is {thermalTimeScale!r}: tables are read at calendar time now, whatever the scale; leave it out")
	if not math.isfinite(start):
		raise ValueError(f"start is {start!r}; it must be a time of the series in s")
	times, values = [], []
	for line, cells in _rows(path):
		time, temperature = _numbers(path, line, cells)
		if times and time <= times[-1]:
			raise ValueError(f"{path}, line {line}: time {time:g} s follows {times[-1]:g} s; times must increase")
		if not coldest < temperature < warmest:
			raise ValueError(f"{path}, line {line}: air temperature {temperature:g} must lie between {coldest:g} and {warmest:g} degC")
		times.append(time)
		values.append(temperature)
	if not times:
		raise ValueError(f"{path} holds no data; it must have lines with time [s] and air temperature [degC]")
	return [time - start for time in times], values


def _rows(path):
	"""Lines that hold data, as (number, cells)."""
	try:
		text = Path(path).read_text(encoding="utf-8-sig")
	except (OSError, UnicodeDecodeError) as error:
		raise ValueError(f"weather series {path} cannot be read: {error}") from None
	lines = [(number, line) for number, line in enumerate(text.splitlines(), 1) if line.strip() and not line.lstrip().startswith("#")]
	rows = [(number, next(csv.reader([line]))) for number, line in lines]
	return rows[1:] if rows and _isHeading(rows[0][1]) else rows


def _isHeading(cells):
	return not any(_isNumber(cell) for cell in cells)


def _isNumber(cell):
	try:
		float(cell)
	except ValueError:
		return False
	return True


def _numbers(path, line, cells):
	if len(cells) < 2:
		raise ValueError(f"{path}, line {line}: {len(cells)} column instead of time [s] and air temperature [degC], separated by a comma")
	for cell, name in zip(cells, ("time", "air temperature")):
		if not _isNumber(cell) or not math.isfinite(float(cell)):
			raise ValueError(f"{path}, line {line}: {name} '{cell.strip()}' is not a number; give it or remove the line")
	return float(cells[0]), float(cells[1])
