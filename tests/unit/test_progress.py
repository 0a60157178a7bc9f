# SPDX-License-Identifier: GPL-2.0-or-later
"""Progress lines and bars."""

import io
import re
import time

import numpy as np
import pytest

from talik.progress import Progress, whatSlowsTheCalendar


class Run:
	"""A run whose clock the test turns."""

	def __init__(self):
		self.time, self.step = 0.0, 0

	def advance(self, time, step):
		self.time, self.step = time, step


class Terminal(io.StringIO):
	def isatty(self):
		return True


def progressOf(run, stream, **settings):
	return Progress(clock=lambda: run.time, step=lambda: run.step, stream=stream, **{"endTime": 15, **settings})


def test_days_of_the_calendar_are_a_goal():
	run = Run()
	progress = progressOf(run, io.StringIO(), endTime=None, endDay=150, calendar=lambda: {"day": 50 * run.time, "scale": 1.0})
	run.advance(1.5, 10)
	assert progress.fraction() == 0.5
	with pytest.raises(ValueError, match="endDay is 150 without a calendar"):
		Progress(endDay=150)


def test_without_a_terminal_one_line_per_interval_shows_time_day_scale_rate_and_end():
	run, stream = Run(), io.StringIO()
	progress = progressOf(run, stream, calendar=lambda: {"day": 10 * run.time, "scale": 8.64e5}, interval=0.05, details=lambda: {"samples": 42})
	progress.update()
	assert stream.getvalue() == ""
	time.sleep(0.06)
	run.advance(5.0, 1000)
	progress.update()
	progress.update()
	line = stream.getvalue()
	print(line.strip())
	assert line.count("\n") == 1
	assert re.search(r"33\.3 %  t = 5 s, day 50\.0, 8\.6e\+05 times as fast, step 1000, [\d.]+ steps/s, samples 42, .* so far, end in 0:00:0", line)


class SlidingGround:
	"""Four points in three cells of 0.5 m; two of the first swing against each other, the one at (1.1, 0.2) slides."""

	gridSpacing, lower = 0.5, (-0.25, 0.0)
	calendar = {"followsMotion": True, "speed": 0.3, "day": 3.0, "scale": 900.0}
	heat = type("Heat", (), {"motionTolerance": 0.01})
	fields = {
		"position": [(0.0, 0.1), (0.1, 0.1), (0.6, 0.4), (1.1, 0.2)],
		"velocity": [(2.0, 0.0), (-2.0, 0.0), (0.1, 0.0), (0.18, -0.24)],
		"volume": [0.1, 0.1, 0.1, 0.1],
	}

	def field(self, name):
		return np.array(self.fields[name])


def test_a_slow_calendar_names_the_ground_that_moves_and_a_fast_one_names_none():
	ground, stream = SlidingGround(), io.StringIO()
	moving = whatSlowsTheCalendar(ground)
	assert moving["ids"] == [3] and moving["speed"] == pytest.approx(0.3) and tuple(moving["position"]) == (1.1, 0.2)
	progress = progressOf(Run(), stream, calendar=lambda: ground.calendar, interval=0.0, ground=ground)
	progress.update()
	print(stream.getvalue().strip())
	assert "day 3.0, 9e+02 times as fast, slowed by ground at (1.10, 0.20) m that moves at 0.3 m/s" in stream.getvalue()
	ground.calendar = dict(ground.calendar, speed=0.009)
	assert whatSlowsTheCalendar(ground) is None


def test_expected_end_is_the_time_so_far_scaled_by_what_is_left():
	run = Run()
	progress = progressOf(run, io.StringIO())
	assert progress.secondsLeft() is None
	time.sleep(0.1)
	run.advance(3.0, 10)
	left = progress.secondsLeft()
	print(f"after 0.1 s and a fifth of the way: {left:.3f} s left, expected 0.4 s")
	assert 0.38 < left < 0.6


def test_a_terminal_gets_a_bar_that_ends_at_the_end():
	run, stream = Run(), Terminal()
	progress = progressOf(run, stream, endTime=None, endStep=200)
	for step in (50, 200, 230):
		run.advance(step * 0.01, step)
		progress.update()
	progress.close()
	text = stream.getvalue()
	assert " 25%|" in text and "100%|" in text and "step 230" in text


@pytest.mark.parametrize("settings", [dict(endTime=None), dict(endTime=1, endStep=1), dict(endTime=-1)])
def test_an_end_that_is_none_is_refused(settings):
	with pytest.raises(ValueError, match="endTime"):
		progressOf(Run(), io.StringIO(), **settings)
