# SPDX-License-Identifier: GPL-2.0-or-later
"""Weather series as boundary conditions.

	times, values = talik.weather.airTemperature("station.csv")             # seconds or dates, or a file of a weather service as it comes
	SurfaceTemperature(region="surface", heatTransferCoefficient=15, times=times, values=values)

Where the exchange with the air is not computed, n-factors make the temperature of the surface from that of the air:

	SurfaceTemperature(region="surface", times=times, values=talik.weather.surfaceTemperature(values, thawing=0.9, freezing=0.4))
"""

import csv
import math
from pathlib import Path

import numpy as np

from talik import dates
from talik.tables import numberedRows

secondsPerDay = 86400.0
coldest, warmest = -100.0, 100.0  # what SurfaceTemperature accepts [degC]
services = {  # headings of their files: date and temperature, in Fahrenheit or not
	"DWD, hours": ("MESS_DATUM", "TT_TU", False),
	"DWD, days": ("MESS_DATUM", "TMK", False),
	"Environment Canada, days": ("Date/Time", "Mean Temp (°C)", False),
	"Environment Canada, hours": ("Date/Time (LST)", "Temp (°C)", False),
	"Meteostat, days": ("time", "tavg", False),
	"Meteostat, hours": ("time", "temp", False),
	"NOAA, Global Summary of the Day": ("DATE", "TEMP", True),
}
absent = ("", "-999", "-999.0", "9999.9")  # how services write that there is no value


def airTemperature(path, start=0.0):
	"""Times [s] and air temperatures [degC] of a CSV file, for the attributes times and values of a thermal boundary.

	path   file with the columns time [s], increasing, and air temperature [degC]; in place of times dates (2024-05-15T12:00) of a scene with
		   talik.dates.start. Further columns are passed over, as are empty lines, lines that begin with #, and one line of headings.
		   Or a file of a service as it comes, known by its headings (talik.weather.services); lines without a value are left out
	start  time of the series [s] at which the run begins

	ValueError names file, line and fault.

	>>> with open(folder + "/station.csv", "w") as file:
	...     written = file.write("time [s],air [degC]\\n0,-10\\n86400,-5\\n")
	>>> talik.weather.airTemperature(folder + "/station.csv")
	([0.0, 86400.0], [-10.0, -5.0])"""
	if not math.isfinite(start):
		raise ValueError(f"start is {start!r}; it must be a time of the series in s")
	times, values = [], []
	for line, (time, temperature) in _ofService(path) or numberedRows(path, ("time", "air temperature")):
		if times and time <= times[-1]:
			raise ValueError(f"{path}, line {line}: time {time:g} s follows {times[-1]:g} s; times must increase")
		if not coldest < temperature < warmest:
			raise ValueError(f"{path}, line {line}: air temperature {temperature:g} must lie between {coldest:g} and {warmest:g} degC")
		times.append(time)
		values.append(temperature)
	if not times:
		raise ValueError(f"{path} holds no data; it must have lines with time [s] and air temperature [degC]")
	return [time - start for time in times], values


def _ofService(path):
	"""(line, (time [s], temperature [degC])) of a file with the headings of a weather service; None of another one."""
	try:
		text = Path(path).read_text(encoding="utf-8-sig").splitlines()
	except (OSError, UnicodeDecodeError):
		return None
	separator = ";" if text and text[0].count(";") > text[0].count(",") else ","
	rows = [[cell.strip() for cell in row] for row in csv.reader(text, delimiter=separator)]
	known = [columns for columns in services.values() if rows and set(columns[:2]) <= set(rows[0])]
	if not known:
		return None
	date, temperature, fahrenheit = known[0]
	when, what = rows[0].index(date), rows[0].index(temperature)
	found = []
	for line, row in enumerate(rows[1:], 2):
		if len(row) <= max(when, what) or row[what] in absent:
			continue
		try:
			value = float(row[what])
			time = dates.dayOf(_iso(row[when])) * secondsPerDay
		except ValueError as problem:
			raise ValueError(f"{path}, line {line}: {problem}") from None
		found.append((line, (time, (value - 32) / 1.8 if fahrenheit else value)))
	return found


def _iso(date):
	"""20240515 and 2024051512 as ISO dates."""
	if not (date.isdigit() and len(date) in (8, 10)):
		return date
	return f"{date[:4]}-{date[4:6]}-{date[6:8]}" + (f"T{date[8:]}:00" if len(date) == 10 else "")


def degreeDays(times, temperature, threshold=0.0):
	"""(thawing, freezing) degree-days of a series [K d]: integrals of what is above and, as a positive number, below the threshold [degC].

	times        [s], increasing, as times of a boundary; the series is linear in between
	temperature  of air, surface or ground [degC]

	>>> talik.weather.degreeDays([0, 10 * talik.day, 20 * talik.day], [-10, 10, 10])
	(125.0, 25.0)"""
	time, value = np.asarray(times, dtype=float), np.asarray(temperature, dtype=float) - threshold
	if time.ndim != 1 or time.shape != value.shape or len(time) < 2 or not (np.diff(time) > 0).all():
		raise ValueError(
			f"degreeDays: times and temperature have the shapes {time.shape} and {value.shape}; give two series of the same length, times increasing"
		)
	if not (np.isfinite(time).all() and np.isfinite(value).all()):
		raise ValueError("degreeDays: times or temperature have a value that is not finite; leave such lines out")
	first, second, step = value[:-1], value[1:], np.diff(time) / secondsPerDay
	crosses = first * second < 0
	whole = 0.5 * (first + second) * step
	change = np.where(crosses, first - second, 1.0)
	ofFirst, ofSecond = (np.where(crosses, 0.5 * own * abs(own) / abs(change) * step, 0.0) for own in (first, second))  # triangles
	thawing = np.where(crosses, np.maximum(ofFirst, 0) + np.maximum(ofSecond, 0), np.maximum(whole, 0)).sum()
	freezing = -np.where(crosses, np.minimum(ofFirst, 0) + np.minimum(ofSecond, 0), np.minimum(whole, 0)).sum()
	return float(thawing), float(freezing)


def nFactors(times, air, surface):
	"""n-factors (thawing, freezing) of a surface [-]: its degree-days over those of the air; nan where the air has none.

	times, air, surface  series of the same length: [s], [degC], [degC]

	>>> talik.weather.nFactors([0, 10 * talik.day], [10, 20], [8, 16])
	(0.8, nan)"""
	ofAir, ofSurface = degreeDays(times, air), degreeDays(times, surface)
	return tuple(own / below if below > 0 else math.nan for own, below in zip(ofSurface, ofAir))


def surfaceTemperature(air, thawing=1.0, freezing=1.0):
	"""Temperatures of a surface [degC] from those of the air by n-factors, as a list for the attribute values of SurfaceTemperature.

	air       [degC]
	thawing   n-factor of what is above 0 degC [-], above 0
	freezing  of what is below [-], above 0; snow makes it small

	>>> talik.weather.surfaceTemperature([-20, 10], thawing=0.9, freezing=0.4)
	[-8.0, 9.0]"""
	for name, factor in (("thawing", thawing), ("freezing", freezing)):
		if not (math.isfinite(factor) and factor > 0):
			raise ValueError(f"surfaceTemperature: {name} is {factor!r}; give an n-factor above 0, usually 0.2 to 2")
	air = np.asarray(air, dtype=float)
	return np.where(air > 0, thawing * air, freezing * air).tolist()
