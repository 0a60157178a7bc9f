# SPDX-License-Identifier: GPL-2.0-or-later
"""The calendar as scripts see it: days, scale, events, tables, checkpoints."""

import json

import numpy as np
import pytest
from yade import O, wrapper

import talik
from talik import checkpoint, output, plots, running
from talik.guards.runs import awaitEndOfStep
from thawslump import commandline

height = 1.0


def block(speed=0.0, times=None, **heat):
	"""A block that nothing stops, at -1 degC; `times` of the temperature at the left wall, which it does not touch."""
	O.reset()
	boundaries = [] if times is None else [wrapper.WallTemperature(region="left", times=times, values=np.linspace(-1, 5, len(times)).tolist())]
	mpm = wrapper.MpmEngine(
		gridSpacing=0.25,
		lower=(0, 0),
		upper=(6, 2),
		skeleton=wrapper.ElasticSkeleton(young=5e6),
		heat=wrapper.HeatTransfer(**{"thermalTimeScale": 1e6, "followsMotion": True, **heat}),
		freezing=wrapper.FreezingCurve(),
		boundaries=boundaries,
	)
	position, volume = talik.geometry.fillPolygon(talik.geometry.rectangle(0.5, 0.5, 1.5, 0.5 + height), 0.25)
	mpm.addPoints(position=position, volume=volume, temperature=-1.0, velocity=(speed, 0))
	O.engines = [mpm]
	return mpm


def test_a_day_is_its_seconds():
	assert talik.day == 24 * 60 * 60


def test_the_run_stops_after_the_step_in_which_the_day_comes_and_goes_on_beyond_it():
	mpm = block()
	for day in (0.5, 2.0):
		mpm.stopAtDay = day
		O.run()
		O.wait()
		reached, lastStep = mpm.calendar["day"], O.dt * mpm.calendar["scale"] / talik.day
		print(f"stopped on day {reached:.4f} for {day}, step {O.iter} of {lastStep:.4f} days")
		assert day <= reached < day + lastStep * (1 + 1e-9)
	before = O.iter
	O.run(5, True)
	assert O.iter == before + 5
	with pytest.raises(ValueError, match="stopAtDay"):
		mpm.stopAtDay = float("nan")
		O.step()


def test_a_run_that_reaches_its_day_while_it_is_paused_for_a_checkpoint_does_not_go_on(monkeypatch):
	mpm = block()

	def endMeanwhile(omega):
		omega.run()
		omega.wait()

	def pauseOnce():
		with talik.atRest():
			pass
		monkeypatch.setattr(running, "awaitEndOfStep", lambda omega: None)

	monkeypatch.setattr(running, "awaitEndOfStep", endMeanwhile)
	talik.runUntilDay(mpm, 300, pauseOnce, longest=1e3)
	awaitEndOfStep(O)  # a later pause has not waited for its step, which the next scene would take the ground from
	print(f"ended on day {mpm.calendar['day']:.2f} for 300")
	assert 300 <= mpm.calendar["day"] < 300.1


def test_a_constant_scale_has_a_calendar_and_no_events():
	mpm = block(followsMotion=False)
	O.run(20, True)
	print(mpm.calendar)
	assert mpm.calendar["day"] == pytest.approx(1e6 * O.time / talik.day, rel=1e-12)
	assert mpm.calendar["scale"] == 1e6 and mpm.calendar["speed"] is None
	with pytest.raises(RuntimeError, match="followsMotion=True"):
		mpm.events()
	assert "displacementBefore" not in mpm.fieldNames()


def test_a_flight_is_an_event_of_the_calendar_in_summaries_pictures_and_series(tmp_path):
	mpm = block(speed=0.5)
	frames = output.Frames(mpm, times=[0], days=True)
	frames.take()
	series = output.ParaViewSeries(mpm, tmp_path, clock=lambda: mpm.calendar["day"])
	history = [(mpm.calendar["day"], O.time, 0)]
	while O.time < 0.5:
		O.run(20, True)
	series.write()
	(event,) = mpm.events()
	history.append((mpm.calendar["day"], O.time, event["largest"]))
	print(event)
	assert event["goesOn"] and event["duration"] == pytest.approx(O.time, abs=3 * O.dt)
	assert event["largest"] == pytest.approx(0.5 * event["duration"], rel=1e-6) and event["volume"] == pytest.approx(height, rel=1e-6)
	assert event["days"] * talik.day == pytest.approx(event["duration"] * (1 + 1e6 / (1 + 50**2)), rel=1e-3)
	output.writeSummary(tmp_path / "summary.json", events=mpm.events(), calendar=mpm.calendar)
	assert json.loads((tmp_path / "summary.json").read_text())["events"][0]["day"] == event["day"]
	assert frames.frames[0]["day"] == 0
	assert f'timestep="{mpm.calendar["day"]:.17g}"' in (tmp_path / "points.pvd").read_text()
	axes = plots.figure(5, 3).subplots()
	plots.calendarHistory(axes, history, mpm.events())
	assert axes.get_xlabel() == "day" and len(axes.patches) == 1 and [text.get_text() for text in axes.texts] == ["1 m² move"]
	drawn = axes.lines[0].get_ydata()[-1] / axes.get_ylim()[1]
	print(f"the event takes {100 * drawn:.0f} % of the height of its picture")
	assert axes.get_yscale() == "linear" and axes.get_ylim()[0] == 0 and drawn > 0.8  # an axis of powers of ten would hide it among what creeps
	assert list(commandline.eventLines(mpm.events())) == [
		f"day 0.0: 1.00 m2 per metre move for {event['duration']:.2f} s, by up to {event['largest']:.2f} m, and go on"
	]


def test_calendar_and_events_go_through_a_checkpoint_to_the_same_last_bit(tmp_path):
	def told(mpm):
		return mpm.calendar, mpm.events(), {name: np.array(mpm.field(name)) for name in ("temperature", "displacement", "displacementBefore")}

	mpm = block(speed=0.5)
	O.run(400, True)
	checkpoint.write(tmp_path / "block.checkpoint")
	O.run(300, True)
	calendar, events, fields = told(mpm)
	O.reset()
	mpm = talik.resume(tmp_path / "block.checkpoint")
	O.run(300, True)
	again, eventsAgain, fieldsAgain = told(mpm)
	print(calendar, events)
	assert again == calendar and eventsAgain == events and len(events) == 1
	assert all(np.array_equal(fields[name], fieldsAgain[name]) for name in fields)


def test_scales_and_tolerance_may_change_while_running_and_the_day_may_be_set():
	mpm = block()
	O.run(5, True)
	assert mpm.calendar["scale"] == 1e6
	mpm.heat.thermalTimeScale = 10
	mpm.setDay(-1)
	O.run(5, True)
	print(mpm.calendar)
	assert mpm.calendar["scale"] == 10 and mpm.calendar["day"] == pytest.approx(-1, abs=1e-3)
	for name, value in (("movingTimeScale", 11), ("movingTimeScale", -1), ("motionTolerance", 5), ("thermalTimeScale", -2)):
		before = getattr(mpm.heat, name)
		setattr(mpm.heat, name, value)
		with pytest.raises(ValueError, match=f"{name} = {value}"):
			mpm.stableTimeStep()
		setattr(mpm.heat, name, before)
	with pytest.raises(ValueError, match="too late"):
		mpm.heat.followsMotion = False
	with pytest.raises(ValueError, match="setDay: day is nan"):
		mpm.setDay(float("nan"))
	O.run(5, True)


@pytest.mark.parametrize("times, warned", [([0, 1], True), ([0, 30, 60], True), ([0, 30 * talik.day], False), ([0, 0.05 * talik.day], False)])
def test_tables_in_seconds_of_motion_or_in_days_are_warned_of(times, warned, capfd):
	mpm = block(times=times)
	mpm.initialise()
	told = capfd.readouterr().err.strip()
	print(told)
	lines = [line for line in told.splitlines() if "WallTemperature.times ends at" in line]
	assert (len(lines) == 1 and "talik.day" in lines[0]) if warned else "talik.day" not in told


@pytest.mark.parametrize("conductivity, own", [(1e-4, float("nan")), pytest.param(1e-4, 4e6, id="own scale_slow"), (1.0, float("nan"))])
def test_hastened_sand_and_gravel_run_dry_above_without_an_impossible_state(conductivity, own, capfd):
	"""A slope thaws for half a year in 4 s of motion; its water falls to the base within the first of them. What is not there does not flow."""
	O.reset()
	mpm = wrapper.MpmEngine(
		gridSpacing=0.25,
		lower=(0, 0),
		upper=(4, 3),
		gravity=(0, -9.81),
		damping=0.1,
		skeleton=wrapper.ElasticSkeleton(young=20e6),
		heat=wrapper.HeatTransfer(thermalTimeScale=4e6),
		freezing=wrapper.FreezingCurve(),
		water=wrapper.PoreWater(conductivity=conductivity, hydraulicTimeScale=own),
		boundaries=[
			wrapper.RollerBoundary(region="left"),
			wrapper.RollerBoundary(region="right"),
			wrapper.FixedBoundary(region="bottom"),
			wrapper.DrainedBoundary(region="right", recharge=False),
			wrapper.SurfaceTemperature(region="surface", times=[0, 10 * talik.day], values=[-2, 10]),
		],
	)
	talik.geometry.fill(mpm, [(0, 0), (4, 0), (4, 0.5), (2, 2), (0, 2)], temperature=-2)
	O.engines = [mpm]
	water = mpm.balance()["waterMass"]
	mpm.stopAtDay = 180
	O.run()
	O.wait()
	told = capfd.readouterr().err
	balance, fill, calendar = mpm.balance(), mpm.field("liquidFraction") / mpm.field("porosity"), mpm.calendar
	print(
		f"day {calendar['day']:.0f} after {O.time:.1f} s, seepage x {calendar['seepageScale']:.3g}: fill "
		f"{fill.min():.2g} to {fill.max():.2f}, {100 * balance['waterOut'] / water:.1f} % of the water has left"
	)
	assert 0 < fill.min() < 0.5 and balance["waterOut"] > 0
	assert balance["waterMass"] + balance["waterOut"] == pytest.approx(water, rel=1e-11)
	assert conductivity * calendar["seepageScale"] == pytest.approx(calendar["largestConductivity"], rel=1e-12)
	assert ("PoreWater.conductivity is 1 m/s" in told) == (conductivity == 1.0)
