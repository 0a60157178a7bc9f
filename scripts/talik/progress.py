# SPDX-License-Identifier: GPL-2.0-or-later
"""Progress of a long run: simulated time, day of the calendar, steps per second, expected end.

	progress = talik.progress.Progress(endDay=150, calendar=lambda: mpm.calendar)
	O.engines = [mpm, progress.runner()]
	O.run(); O.wait(); progress.close()

On a terminal a tqdm bar; elsewhere (a log file) one line about every ten seconds.
"""

import sys
import time
from datetime import timedelta

import numpy as np
from tqdm import tqdm

from talik import ranks

_running = []  # bars that PyRunner commands refer to by their place here


def update(place):
	"""Called by the engines that Progress.runner made.

	>>> progress = talik.progress.Progress(endTime=15)
	>>> progress.runner().command.startswith("import talik.progress")
	True"""
	_running[place].update()


class Progress:
	"""Follows a run towards `endTime` [s of simulated time], `endDay` of the calendar or `endStep`.

	calendar          function returning MpmEngine.calendar: day and scale are shown
	ground            MpmEngine whose calendar follows the motion: where ground moves so that the calendar goes less than half as fast as at rest,
					  place and speed of the fastest ground are shown
	interval          [s of wall time] between two lines when the output is not a terminal
	details           function returning {name: value} shown at the end of the line
	clock, step       functions for simulated time [s] and step number; default those of O
	stream            default sys.stderr

	>>> progress = talik.progress.Progress(endDay=150, calendar=lambda: mpm.calendar)
	>>> O.engines = O.engines + [progress.runner()]"""

	def __init__(
		self,
		endTime=None,
		endStep=None,
		endDay=None,
		calendar=None,
		interval=10.0,
		details=None,
		clock=None,
		step=None,
		stream=None,
		ground=None,
	):
		goals = {"endTime": endTime, "endStep": endStep, "endDay": endDay}
		given = [name for name, end in goals.items() if end is not None]
		if len(given) != 1:
			raise ValueError(f"endTime is {endTime!r}, endStep is {endStep!r} and endDay is {endDay!r}; give one of the three")
		name, end = given[0], goals[given[0]]
		if not end > 0:
			raise ValueError(f"{name} is {end!r}; it must be greater than 0")
		if name == "endDay" and calendar is None:
			raise ValueError(f"endDay is {endDay!r} without a calendar; give calendar=lambda: mpm.calendar")
		self.clock, self.step, self.calendar = clock or _sceneTime, step or _sceneStep, calendar
		self.goal = {"endTime": self.clock, "endStep": self.step, "endDay": self._day}[name]
		self.end, self.interval = float(end), interval
		self.details = details or dict
		self.ground = ground if ranks.count == 1 else None
		self.stream = stream or sys.stderr
		self.wallStart = self.wallLast = time.monotonic()
		self.goalStart, self.stepStart = self.goal(), self.step()
		self.bar = self._bar() if self.stream.isatty() and ranks.first else None

	def runner(self, realPeriod=0.5):
		"""A YADE PyRunner that updates the progress every `realPeriod` seconds of wall time."""
		from yade.wrapper import PyRunner

		_running.append(self)
		command = f"import talik.progress; talik.progress.update({len(_running) - 1})"
		return PyRunner(command=command, realPeriod=realPeriod)

	def update(self):
		"""Shows the present state; cheap enough to be called often. Of several ranks the first shows it."""
		if not ranks.first:
			return
		if self.bar is not None:
			self.bar.n = min(self.goal(), self.end)
			self.bar.set_postfix_str(self._state(), refresh=False)
			self.bar.refresh()
		elif time.monotonic() - self.wallLast >= self.interval:
			self.wallLast = time.monotonic()
			self._line()

	def close(self):
		"""Shows the last state and leaves the line."""
		if not ranks.first:
			return
		if self.bar is not None:
			self.update()
			self.bar.close()
			self.bar = None
		else:
			self._line()

	def fraction(self):
		"""Done part of the run, 0 ... 1."""
		return min(max(self.goal() / self.end, 0.0), 1.0)

	def stepsPerSecond(self):
		"""Steps per second of wall time since this object was made."""
		return (self.step() - self.stepStart) / max(time.monotonic() - self.wallStart, 1e-9)

	def secondsLeft(self):
		"""Expected wall time to the end [s]; None before anything is known."""
		done = self.goal() - self.goalStart
		if done <= 0:
			return None
		return max(self.end - self.goal(), 0.0) * (time.monotonic() - self.wallStart) / done

	def _day(self):
		return self.calendar()["day"]

	def _bar(self):
		form = "{percentage:3.0f}%|{bar}| {postfix} [{elapsed}<{remaining}]"
		return tqdm(total=self.end, initial=self.goalStart, bar_format=form, file=self.stream, dynamic_ncols=True, miniters=0)

	def _line(self):
		left = self.secondsLeft()
		expected = "" if left is None else f", end in {timedelta(seconds=round(left))}"
		elapsed = timedelta(seconds=round(time.monotonic() - self.wallStart))
		print(f"{100 * self.fraction():5.1f} %  {self._state()}, {elapsed} so far{expected}", file=self.stream, flush=True)

	def _state(self):
		parts = [f"t = {self.clock():.4g} s"]
		if self.calendar is not None:
			calendar = self.calendar()
			parts.append(f"day {calendar['day']:.1f}, {calendar['scale']:.2g} times as fast")
			parts += self._holdUp()
		parts += [f"step {self.step()}", f"{self.stepsPerSecond():.1f} steps/s"]
		parts += [f"{ranks.count} ranks"] if ranks.count > 1 else []
		parts += [f"{name} {value}" for name, value in self.details().items()]
		return ", ".join(parts)

	def _holdUp(self):
		moving = None if self.ground is None else whatSlowsTheCalendar(self.ground)
		return [] if moving is None else [f"slowed by ground at {_place(moving['position'])} that moves at {moving['speed']:.2g} m/s"]


def whatSlowsTheCalendar(mpm):
	"""What moves so fast that the calendar goes less than half as fast as at rest; None where nothing does, or where it does not follow the motion.

	A dictionary: position, the mean of the points of the fastest cell [m]; speed, that of their mean velocity [m/s]; ids of these points;
	motionTolerance, the speed at which the calendar goes half as fast as at rest [m/s].

	>>> talik.progress.whatSlowsTheCalendar(mpm)"""
	if not mpm.calendar["followsMotion"] or not mpm.calendar["speed"] > mpm.heat.motionTolerance:
		return None
	position, velocity, volume = (mpm.field(name) for name in ("position", "velocity", "volume"))
	lower = np.array(mpm.lower) if len(mpm.lower) == position.shape[1] and np.isfinite(mpm.lower).all() else 0.0
	place = np.floor((position - lower) / mpm.gridSpacing).astype(int)
	place -= place.min(axis=0)
	cell = np.ravel_multi_index(tuple(place.T), tuple(place.max(axis=0) + 1))
	size = np.bincount(cell, volume)
	means = [np.divide(np.bincount(cell, volume * component), size, out=np.zeros_like(size), where=size > 0) for component in velocity.T]
	fastest = np.linalg.norm(means, axis=0).argmax()
	ids = np.flatnonzero(cell == fastest)
	speed = float(np.linalg.norm([mean[fastest] for mean in means]))
	return {"position": position[ids].mean(axis=0), "speed": speed, "ids": ids.tolist(), "motionTolerance": mpm.heat.motionTolerance}


def _place(position):
	"""(x, y) [m] with two decimals, for messages."""
	return "(" + ", ".join(f"{x:.2f}" for x in position) + ") m"


def _sceneTime():
	from yade import O

	return O.time


def _sceneStep():
	from yade import O

	return O.iter
