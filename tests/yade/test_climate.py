# SPDX-License-Identifier: GPL-2.0-or-later
"""Series of weather services, reanalyses and climate models arrive in degC and m/s on the days of the calendar; what they do not say is refused."""

import numpy as np
import pytest
from scipy.io import netcdf_file

import talik


pytestmark = pytest.mark.usefixtures("ofMay")


def written(
	path, name, values, units, time="hours since 1900-01-01 00:00:00.0", times=(0, 1), names=("time", "latitude", "longitude"), calendar=None, packed=()
):
	"""A file as ERA5 and CMIP come: values over time, latitude, longitude; times are counted from 15 May 2024 if since is 1900."""
	with netcdf_file(path, "w") as file:
		places = {names[1]: [79.0, 78.0, 77.0], names[2]: [14.0, 15.0, 16.0, 17.0]}
		for dimension, count in ((names[0], len(times)), (names[1], 3), (names[2], 4)):
			file.createDimension(dimension, count)
		clock = file.createVariable(names[0], "d", (names[0],))
		clock[:], clock.units = times, time
		if calendar:
			clock.calendar = calendar
		for axis, degrees in places.items():
			one = file.createVariable(axis, "f", (axis,))
			one[:] = degrees
		variable = file.createVariable(name, "h" if packed else "f", names)
		variable.units = units
		grid = np.zeros((len(times), 3, 4)) + np.array(values)[:, None, None] + np.arange(12).reshape(3, 4)[None] * (0 if packed else 1e-3)
		if packed:
			variable.scale_factor, variable.add_offset = packed
			grid = np.rint((grid - packed[1]) / packed[0])
		variable[:] = grid
	return path


sinceMay = (np.datetime64("2024-05-15") - np.datetime64("1900-01-01")).astype(int) * 24  # [h]


def test_era5_temperatures_become_degrees_celsius_at_the_nearest_place(tmp_path):
	file = written(tmp_path / "era5.nc", "t2m", [263.15, 275.15], "K", times=(sinceMay, sinceMay + 6), packed=(0.002, 270.0))
	times, values = talik.climate.series(file, "t2m", at=(78.2, 15.8))
	print(times, values)
	assert times == [0.0, 21600.0] and values == pytest.approx([-10, 2], abs=2e-3)
	file = written(tmp_path / "places.nc", "t2m", [263.15, 275.15], "K", times=(sinceMay, sinceMay + 6))
	assert talik.climate.series(file, "t2m", at=(78.2, 15.8 - 360))[1] == pytest.approx([-10 + 6e-3, 2 + 6e-3], abs=2e-4)  # row 1, column 2 of the grid


def test_cmip_counts_days_without_leap_days(tmp_path):
	"""From 1850 there are 42 leap days up to May 2024: 174 years of 365 days and 134 days of this year."""
	names = ("time", "lat", "lon")
	file = written(tmp_path / "tas.nc", "tas", [270.0, 271.0], "K", "days since 1850-01-01", (174 * 365 + 134.5, 174 * 365 + 135.5), names, "noleap")
	times, values = talik.climate.series(file, "tas", at=(78, 15))
	print(times)
	assert times == [43200.0, 129600.0]
	file = written(tmp_path / "360.nc", "tas", [270.0, 271.0], "K", "days since 1850-01-01", (0, 1), names, "360_day")
	with pytest.raises(ValueError, match="calendar is '360_day', whose days have no dates"):
		talik.climate.series(file, "tas", at=(78, 15))


def test_amounts_of_an_hour_become_rates_and_rates_stay(tmp_path):
	hours = (sinceMay, sinceMay + 1)
	rain = written(tmp_path / "tp.nc", "tp", [1.8e-3, 0], "m", times=hours, packed=(1e-7, 0.0))
	assert talik.climate.series(rain, "tp", at=(78, 15), accumulatedOver=3600)[1] == pytest.approx([5e-7, 0], rel=1e-3)
	with pytest.raises(ValueError, match="is an amount, and boundaries take rates; give accumulatedOver"):
		talik.climate.series(rain, "tp", at=(78, 15))
	pr = written(tmp_path / "pr.nc", "pr", [5e-4, 0], "kg m-2 s-1", times=hours, packed=(1e-7, 0.0))
	assert talik.climate.series(pr, "pr", at=(78, 15))[1] == pytest.approx([5e-7, 0], rel=1e-3)
	with pytest.raises(ValueError, match="is no amount; leave accumulatedOver out"):
		talik.climate.series(pr, "pr", at=(78, 15), accumulatedOver=3600)
	sun = written(tmp_path / "ssrd.nc", "ssrd", [3.6e6, 0], "J m**-2", times=hours, packed=(3600.0, 0.0))
	assert talik.climate.series(sun, "ssrd", at=(78, 15), accumulatedOver=3600)[1] == pytest.approx([1000, 0])


def test_a_file_that_does_not_say_enough_is_refused_by_one_sentence(tmp_path):
	hours = (sinceMay, sinceMay + 1)
	file = written(tmp_path / "t2m.nc", "t2m", [263.15, 275.15], "degC", times=hours)
	for arguments, told in (
		(("t2m",), "has 3 places along latitude; give at"),
		(("tas", (78, 15)), "has no variable 'tas'; it has latitude, longitude, t2m, time"),
		(("t2m", (60, 15)), "its latitude runs from 77 to 79 degrees, and 60 lies outside"),
		(("t2m", (78, 15)), "in 'degC' runs from 263.154 to 275.171 degC|are its units those that it says"),
	):
		with pytest.raises(ValueError, match=told) as refusal:
			talik.climate.series(file, *arguments)
		print(refusal.value)
	(tmp_path / "new.nc").write_bytes(b"\x89HDF\r\n\x1a\n" + bytes(100))
	try:
		import netCDF4  # noqa: F401
	except ImportError:
		with pytest.raises(ValueError, match="install Debian's python3-netcdf4, or make it classic"):
			talik.climate.series(tmp_path / "new.nc", "t2m")
	(tmp_path / "text.nc").write_text("time,t2m")
	with pytest.raises(ValueError, match="is no netCDF file"):
		talik.climate.series(tmp_path / "text.nc", "t2m")


def test_files_of_netcdf4_are_read_where_its_package_is_installed(tmp_path):
	netCDF4 = pytest.importorskip("netCDF4")
	with netCDF4.Dataset(tmp_path / "era5.nc", "w") as file:
		file.createDimension("valid_time", 2)
		clock, air = file.createVariable("valid_time", "i8", ("valid_time",)), file.createVariable("t2m", "f4", ("valid_time",))
		clock.units, air.units = "seconds since 1970-01-01", "K"
		clock[:], air[:] = [1715731200, 1715731200 + 86400], [263.15, 273.15]
	times, values = talik.climate.series(tmp_path / "era5.nc", "t2m")
	assert times == [0.0, 86400.0] and values == pytest.approx([-10, 0], abs=1e-4)


services = {
	"DWD, hours": """STATIONS_ID;MESS_DATUM;QN_9;TT_TU;RF_TU;eor
        433;2024051500;    3;  -3.5;  80.0;eor
        433;2024051501;    3;-999;  80.0;eor
        433;2024051512;    3;   4.0;  80.0;eor
""",
	"Environment Canada, days": """"Longitude (x)","Date/Time","Year","Mean Temp (°C)"
"-133.5","2024-05-15","2024","-3.5"
"-133.5","2024-05-15T06:00","2024",""
"-133.5","2024-05-15T12:00","2024","4.0"
""",
	"NOAA, Global Summary of the Day": """"STATION","DATE","TEMP"
"01008","2024-05-15","  25.7"
"01008","2024-05-15T06:00","9999.9"
"01008","2024-05-15T12:00","  39.2"
""",
	"Meteostat, days": """time,tmin,tavg
2024-05-15,-9,-3.5
2024-05-15T06:00,,
2024-05-15T12:00,0,4.0
""",
}


@pytest.mark.parametrize("service", services)
def test_a_file_of_a_weather_service_is_read_as_it_comes(tmp_path, service):
	(tmp_path / "station.csv").write_text(services[service])
	times, values = talik.weather.airTemperature(tmp_path / "station.csv")
	print(times, values)
	assert times == [0.0, 43200.0] and values == pytest.approx([-3.5, 4.0])
