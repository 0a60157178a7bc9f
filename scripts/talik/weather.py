# SPDX-License-Identifier: GPL-2.0-or-later
"""Weather series as boundary conditions.

	times, values = talik.weather.airTemperature("station.csv")
	SurfaceTemperature(region="surface", heatTransferCoefficient=15, times=times, values=values)
"""

import math

from talik.tables import numberedRows

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
	for line, (time, temperature) in numberedRows(path, ("time", "air temperature")):
		if times and time <= times[-1]:
			raise ValueError(f"{path}, line {line}: time {time:g} s follows {times[-1]:g} s; times must increase")
		if not coldest < temperature < warmest:
			raise ValueError(f"{path}, line {line}: air temperature {temperature:g} must lie between {coldest:g} and {warmest:g} degC")
		times.append(time)
		values.append(temperature)
	if not times:
		raise ValueError(f"{path} holds no data; it must have lines with time [s] and air temperature [degC]")
	return [time - start for time in times], values
