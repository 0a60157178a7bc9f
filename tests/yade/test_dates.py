# SPDX-License-Identifier: GPL-2.0-or-later
"""Dates of a scene, and tables with dates and flat names."""

import csv
import math

import numpy as np
import pytest
from yade import O, wrapper

import talik


pytestmark = pytest.mark.usefixtures("ofMay")


def column(strain=0.1, **more):
	"""A metre of ice-rich ground that thaws from its surface."""
	mpm = wrapper.MpmEngine(
		gridSpacing=0.25,
		lower=(0, 0),
		upper=(0.5, 1.5),
		gravity=(0, -9.81),
		damping=0.3,
		thawFront=None,
		skeleton=wrapper.ElasticSkeleton(young=3e7),
		heat=wrapper.HeatTransfer(thermalTimeScale=1e6),
		freezing=wrapper.FreezingCurve(width=0.1),
		material=wrapper.GroundMaterial(thawStrain=strain),
		boundaries=[
			*(wrapper.RollerBoundary(region=side) for side in ("left", "right", "bottom")),
			wrapper.SurfaceTemperature(region="surface", temperature=20),
		],
		**more,
	)
	talik.geometry.fill(mpm, talik.geometry.rectangle(0, 0, 0.5, 1), temperature=-0.2)
	return mpm


def test_a_run_goes_on_to_a_date():
	mpm = column()
	O.engines = [mpm]
	talik.runUntilDay(mpm, "2024-05-15T06:00")
	print(f"day {mpm.calendar['day']:.4f}, due 0.25")
	assert mpm.calendar["day"] == pytest.approx(0.25, abs=0.01)


def test_a_date_is_a_day_of_the_calendar_and_back():
	for date, day in (("2024-05-15", 0), ("2024-06-01T12:00", 17.5), ("2025-05-15", 365), ("2024-05-14", -1)):
		assert talik.dates.dayOf(date) == day and talik.dates.dateOf(day) == date
	assert talik.dates.dayOf(3) == 3 and talik.dates.dayOf("3.5") == 3.5
	for wrong in ("15.5.2024", "2024-13-01", "2024-05-15T12:00+02:00"):
		with pytest.raises(ValueError, match="is no date"):
			talik.dates.dayOf(wrong)
	O.reset()
	with pytest.raises(ValueError, match="give it by talik.dates.start"):
		talik.dates.dayOf("2024-05-15")


def test_the_date_of_a_scene_is_saved_with_it(tmp_path):
	O.engines = [column()]
	O.save(str(tmp_path / "scene.yade.gz"))
	O.reset()
	assert talik.dates.started() is None
	O.load(str(tmp_path / "scene.yade.gz"))
	assert talik.dates.started() == "2024-05-15"


def test_tables_begin_with_the_date_and_the_surface_settles_by_the_thaw_strain_of_what_has_thawed(tmp_path):
	mpm = column()
	points = talik.output.PointTable(mpm, tmp_path / "points.csv", {"top": (0.2, 1)}, ["temperature"], everyDays=5)
	surface = talik.output.SurfaceTable(mpm, tmp_path / "surface.csv", everyDays=5)
	O.engines = [mpm, points.engine, surface.engine]
	talik.runUntilDay(mpm, 21)
	rows = list(csv.DictReader(open(tmp_path / "surface.csv")))
	assert list(rows[0]) == ["date", "day [d]", "x [m]", "settlement [m]", "thaw depth [m]"]
	last = [{key: row[key] if key == "date" else float(row[key]) for key in row} for row in rows if row["date"] == rows[-1]["date"]]
	print(last)
	assert len(last) == 2 and rows[-1]["date"].startswith("2024-06-04") and 20 <= last[0]["day [d]"] < 21
	settled, depth = (np.mean([row[name] for row in last]) for name in ("settlement [m]", "thaw depth [m]"))
	byHand = 0.1 * (depth + settled)  # the depth is below the settled surface
	print(f"settled by {1e3 * settled:.1f} mm, thaw strain times thawed ground {1e3 * byHand:.1f} mm")
	assert settled == pytest.approx(byHand, rel=0.15) and depth > 0.2
	assert open(tmp_path / "points.csv").readline() == "date,day [d],top: temperature [degC]\n"


def test_a_table_of_points_has_flat_names_with_the_right_components():
	mpm = column()
	O.engines = [mpm]
	O.run(3, True)
	table = talik.output.table(mpm)
	names = list(table)
	print(names)
	assert {"position x", "position y", "stress xx", "stress zz", "stress xy", "temperature", "deformationGradient yx"} <= set(names)
	assert "deformationGradient zz" not in names and len(np.asarray(table["stress xy"])) == mpm.pointCount
	assert (np.asarray(table["stress yy"]) == mpm.field("stress")[:, 1]).all()
	with pytest.raises(ValueError, match="no field 'heat'"):
		talik.output.table(mpm, ["heat"])


def test_weather_may_come_with_dates(tmp_path):
	file = tmp_path / "station.csv"
	file.write_text("date,air [degC]\n2024-05-15,-3\n2024-05-16T12:00,4\n")
	assert talik.weather.airTemperature(file) == ([0.0, 1.5 * talik.day], [-3.0, 4.0])
	file.write_text("date,air [degC]\n2024-05-35,-3\n")
	with pytest.raises(ValueError, match="line 2: '2024-05-35' is no date"):
		talik.weather.airTemperature(file)


def test_events_have_dates():
	class Ground:
		def events(self):
			return [{"day": 17.5, "largest": 0.3}]

	assert talik.dates.events(Ground()) == [{"date": "2024-06-01T12:00", "day": 17.5, "largest": 0.3}]
	assert math.isclose(talik.dates.dayOf("2024-06-01T12:00"), 17.5)
