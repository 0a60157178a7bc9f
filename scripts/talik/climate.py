# SPDX-License-Identifier: GPL-2.0-or-later
"""Series of reanalyses and climate models (ERA5, ERA5-Land, CMIP) in netCDF files, with their units checked.

	talik.dates.start("2020-09-01")
	times, values = talik.climate.series("era5.nc", "t2m", at=(78.2, 15.8))          # or "tas" of CMIP: K becomes degC
	SurfaceTemperature(region="surface", times=times, values=talik.weather.surfaceTemperature(values, thawing=0.9, freezing=0.4))
	times, rain = talik.climate.series("era5.nc", "tp", at=(78.2, 15.8), accumulatedOver=3600)     # m in an hour become m/s
	WaterFlux(region="surface", times=times, values=rain)

Classic netCDF files are read without a further package, those of netCDF-4 by Debian's python3-netcdf4.
"""

from datetime import datetime, timedelta

import numpy as np

from talik import dates

secondsOf = {"second": 1.0, "minute": 60.0, "hour": 3600.0, "day": 86400.0}
celsius = {"k": -273.15, "kelvin": -273.15, "degc": 0.0, "c": 0.0, "celsius": 0.0, "°c": 0.0, "degree_celsius": 0.0, "degrees_celsius": 0.0}  # what is added
rates = {"kgm-2s-1": 1e-3, "mmday-1": 1e-3 / 86400, "mms-1": 1e-3, "ms-1": 1.0, "wm-2": 1.0}  # to m/s of water, W/m2
amounts = {"m": 1.0, "mofwaterequivalent": 1.0, "mm": 1e-3, "kgm-2": 1e-3, "jm-2": 1.0}  # to m of water, J/m2
names = {"time": ("time", "valid_time"), "latitude": ("latitude", "lat"), "longitude": ("longitude", "lon")}


def series(path, name, at=None, accumulatedOver=None, start=0.0):
	"""Times [s] and values of a variable of a netCDF file at one place, for the attributes times and values of a boundary.

	path             netCDF file
	name             of the variable: t2m, skt, tp (ERA5); tas, ts, pr (CMIP); or another one
	at               (latitude, longitude) [degrees]: the nearest place of the grid is taken. None: the file has one place
	accumulatedOver  time over which amounts (m, kg/m2, J/m2) were summed before each time of the file [s]: ERA5 3600, its monthly means 86400.
					 ERA5-Land sums from midnight: take differences first
	start            time of the series [s] at which the run begins

	Temperatures are returned in degC, water in m/s, heat in W/m2. Times count from the date of talik.dates.start, in UTC as the file has them.
	ValueError names file, variable and what is wrong.

	>>> from scipy.io import netcdf_file
	>>> with netcdf_file(folder + "/air.nc", "w") as file:
	...     file.createDimension("time", 2)
	...     for name, units, values in (("time", "days since 2024-05-15", [0, 1]), ("tas", "K", [263.15, 273.15])):
	...         variable = file.createVariable(name, "d", ("time",))
	...         variable[:] = values
	...         variable.units = units
	>>> talik.dates.start("2024-05-15")
	>>> times, values = talik.climate.series(folder + "/air.nc", "tas")
	>>> times, [round(value, 6) for value in values]
	([0.0, 86400.0], [-10.0, 0.0])"""
	file = _read(path)
	if name not in file:
		raise ValueError(f"{path} has no variable '{name}'; it has {', '.join(sorted(file))}")
	known = {kind: next((one for one in alternatives if one in file), None) for kind, alternatives in names.items()}
	dimensions, values, attributes = file[name]
	if known["time"] not in dimensions:
		raise ValueError(f"{path}: '{name}' has the dimensions {', '.join(dimensions) or 'none'}, and no time")
	values = np.moveaxis(values, dimensions.index(known["time"]), 0)
	axes = [one for one in dimensions if one != known["time"]]
	for kind, wanted in zip(("latitude", "longitude"), at or (None, None)):
		if known[kind] in axes:
			place = axes.index(known[kind]) + 1
			values = np.take(values, _nearest(path, kind, file[known[kind]][1], wanted), axis=place)
			axes.remove(known[kind])
	if values.size != len(values):
		raise ValueError(f"{path}: '{name}' has several values at each time, along {', '.join(axes)}; keep one of them")
	values = _inUnits(path, name, values.reshape(-1), attributes.get("units", ""), accumulatedOver)
	if not np.isfinite(values).all():
		raise ValueError(f"{path}: {(~np.isfinite(values)).sum()} of {len(values)} values of '{name}' are missing at this place; choose another one")
	times = [dates.dayOf(moment.isoformat()) * dates.secondsPerDay for moment in _moments(path, *file[known["time"]][1:])]
	if not (np.diff(times) > 0).all():
		raise ValueError(f"{path}: its times do not increase")
	return [time - start for time in times], values.tolist()


def _read(path):
	"""{name: (dimensions, values with nan where they are missing, attributes)} of a netCDF file."""
	try:
		with open(path, "rb") as file:
			begin = file.read(4)
	except OSError as problem:
		raise ValueError(f"{path} cannot be read: {problem}") from None
	if begin[:3] == b"CDF":
		from scipy.io import netcdf_file

		with netcdf_file(path, mmap=False, maskandscale=True) as file:
			return {name: (one.dimensions, _plain(one[...]), {k: _text(v) for k, v in one._attributes.items()}) for name, one in file.variables.items()}
	if begin[1:4] != b"HDF":
		raise ValueError(f"{path} is no netCDF file")
	try:
		import netCDF4
	except ImportError:
		raise ValueError(f"{path} is of netCDF-4: install Debian's python3-netcdf4, or make it classic by  nccopy -k classic {path} classic.nc") from None
	with netCDF4.Dataset(path) as file:
		numbers = {name: one for name, one in file.variables.items() if one.dtype is not str}
		return {name: (one.dimensions, _plain(one[...]), {k: _text(one.getncattr(k)) for k in one.ncattrs()}) for name, one in numbers.items()}


def _plain(values):
	values = np.ma.asarray(values)
	return np.ma.filled(values.astype(float), np.nan) if values.dtype.kind in "iuf" else np.asarray(values)


def _text(value):
	return value.decode("utf-8", "replace") if isinstance(value, bytes) else value


def _nearest(path, kind, places, wanted):
	if len(places) == 1 and wanted is None:
		return 0
	if wanted is None:
		raise ValueError(f"{path} has {len(places)} places along {kind}; give at=(latitude, longitude)")
	apart = abs(places - wanted)
	if kind == "longitude":
		apart = abs((places - wanted + 180) % 360 - 180)
	step = np.diff(np.sort(places)).max() if len(places) > 1 else np.inf
	if apart.min() > step:
		raise ValueError(f"{path}: its {kind} runs from {places.min():g} to {places.max():g} degrees, and {wanted:g} lies outside")
	return int(apart.argmin())


def _inUnits(path, name, values, units, accumulatedOver):
	said = units.lower().replace("**", "").replace("^", "").replace(" ", "")
	if said in celsius and accumulatedOver is None:
		values = values + celsius[said]
		if not ((values[np.isfinite(values)] > -100) & (values[np.isfinite(values)] < 100)).all():
			raise ValueError(f"{path}: '{name}' in '{units}' runs from {np.nanmin(values):g} to {np.nanmax(values):g} degC; are its units those that it says?")
		return values
	if said in rates and accumulatedOver is None:
		return values * rates[said]
	if said in amounts and accumulatedOver is not None:
		return values * amounts[said] / accumulatedOver
	if said in amounts:
		raise ValueError(
			f"{path}: '{name}' in '{units}' is an amount, and boundaries take rates; give accumulatedOver, the seconds over which it was summed (ERA5: 3600)"
		)
	if said in {**celsius, **rates}:
		raise ValueError(f"{path}: '{name}' in '{units}' is no amount; leave accumulatedOver out")
	raise ValueError(f"{path}: '{name}' is in '{units}', which is none of the units that are known here: K, degC, kg m-2 s-1, mm, m, W m-2, J m-2")


def _moments(path, values, attributes):
	unit, _, since = attributes.get("units", "").partition(" since ")
	unit, calendar = unit.strip().lower().rstrip("s"), attributes.get("calendar", "standard").lower()
	if unit not in secondsOf or not since:
		raise ValueError(f"{path}: its time is in '{attributes.get('units', '')}'; known are seconds, minutes, hours and days since a date")
	date, _, clock = since.strip().replace("T", " ").partition(" ")
	first = datetime(*(int(part) for part in date.split("-"))) + timedelta(seconds=_secondsOfClock(clock))
	seconds = np.asarray(values, dtype=float) * secondsOf[unit]
	if calendar in ("standard", "gregorian", "proleptic_gregorian"):
		return [first + timedelta(seconds=round(float(one))) for one in seconds]
	if calendar in ("noleap", "365_day"):
		return [_withoutLeapDays(first, float(one)) for one in seconds]
	raise ValueError(f"{path}: its calendar is '{calendar}', whose days have no dates; convert it, e.g. by  cdo setcalendar,standard")


def _secondsOfClock(clock):
	parts = clock.replace("Z", "").split()
	hours, minutes, seconds = (*(float(part) for part in (parts[0] if parts else "0").split(":")), 0.0, 0.0)[:3]
	return 3600 * hours + 60 * minutes + seconds


def _withoutLeapDays(first, seconds):
	"""Date of a calendar whose years have 365 days."""
	ofYear = (datetime(2001, first.month, first.day) - datetime(2001, 1, 1)).days
	days, rest = divmod(round(seconds) + first.hour * 3600 + first.minute * 60 + first.second, 86400)
	years, day = divmod(ofYear + days, 365)
	return (datetime(2001, 1, 1) + timedelta(days=day, seconds=rest)).replace(year=first.year + years)
