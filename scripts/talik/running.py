# SPDX-License-Identifier: GPL-2.0-or-later
"""Running the scene of O from a script: until a time or a day, step by step, or paused for a look.

	talik.runUntil(10.0)                        # [s] of O.time
	talik.runUntilDay(mpm, 30)                  # of the calendar of an MpmEngine
	talik.runSerially(5)                        # steps, in this thread
"""

import math
import numbers
import time
from contextlib import contextmanager

import numpy as np

from yade import O

import talik
from talik import _talik, dates, ranks
from talik.guards.runs import awaitEndOfStep, refuseToAbort
from talik.progress import Progress


def runSerially(steps):
	"""Does `steps` steps of O in the calling thread and with one thread: faster than O.run for scenes of some hundred points or bodies,
	and results do not depend on yade -j. RuntimeError while O runs.

	>>> talik.runSerially(2)"""
	refuseToAbort(O)
	_talik.runSerially(steps)


def runUntil(instant, look=None, interval=0.2, progress=False):
	"""Runs O until its time reaches `instant` [s], calling `look` every `interval` seconds of wall time; progress: shows how far it is, see
	talik.progress.

	A look that returns True ends the run after the present step. Of several ranks (talik.ranks) the first one looks, and may not end it alone.
	The engines run in YADE's background thread, so that Ctrl-C stops between two steps and leaves a usable scene.

	>>> talik.runUntil(O.time + 2 * O.dt, look=lambda: mpm.calendar["moving"])"""
	if _number("instant", instant, "s of O.time") <= O.time:
		return
	if progress:
		with _shown(Progress(endTime=instant)) as bar:
			return runUntil(instant, _both(look, bar.update), interval)
	O.stopAtTime, O.stopAtIter = instant, 0
	O.run()
	pause, nextLook = 0.002, time.monotonic() + interval
	try:
		while O.running:
			time.sleep(pause)
			pause = min(1.5 * pause, 0.01)
			if look is not None and ranks.first and time.monotonic() > nextLook:
				if _wantsToStop(look()):
					O.pause()
					awaitEndOfStep(O)
				nextLook = time.monotonic() + interval
	except KeyboardInterrupt:
		O.pause()
		awaitEndOfStep(O)
		raise
	O.wait()


def runUntilDay(mpm, day, look=None, longest=math.inf, progress=False):
	"""As runUntil, until the calendar of `mpm` reaches `day`, but at most until O.time is `longest` [s].

	day  of the calendar, or an ISO date of a scene with talik.dates.start

	>>> talik.runUntilDay(mpm, mpm.calendar["day"], longest=O.time + 1)"""
	day = dates.dayOf(day) if isinstance(day, str) else day
	if _number("day", day, "days of the calendar") <= mpm.calendar["day"]:
		return
	if not _runs(mpm, O.engines):
		raise ValueError("runUntilDay: the ground is not among O.engines, so that its calendar stands still; set O.engines = [mpm] first")
	if progress:
		with _shown(Progress(endDay=day, calendar=lambda: mpm.calendar, ground=mpm)) as bar:
			return runUntilDay(mpm, day, _both(look, bar.update), longest)
	mpm.stopAtDay = day
	runUntil(longest, look)
	if mpm.calendar["day"] < day:  # it ended before
		mpm.stopAtDay = math.inf


def _number(name, value, unit):
	"""The value, which may be infinite; ValueError if it is no number."""
	if not isinstance(value, numbers.Real) or math.isnan(value):
		raise ValueError(f"{name} is {value!r}; give a number, in {unit}")
	return value


def _runs(mpm, engines):
	return any(_talik.sameObject(mpm, engine) for engine in talik._flat(engines))


def _wantsToStop(answer):
	"""True for True alone: what a look counts or lists by the way is no answer."""
	stops = isinstance(answer, (bool, np.bool_)) and bool(answer)
	if stops and ranks.count > 1:
		raise RuntimeError("runUntil: look returned True, which would end the run on this rank alone; of several ranks set O.stopAtIter or mpm.stopAtDay")
	return stops


def _both(look, update):
	def lookAndUpdate():
		answer = None if look is None else look()
		update()
		return answer

	return lookAndUpdate


@contextmanager
def _shown(bar):
	try:
		yield bar
	finally:
		bar.close()


@contextmanager
def atRest():
	"""O rests between two steps for the block; a run goes on afterwards.

	>>> with talik.atRest():
	...     everything = mpm.field("position"), mpm.field("velocity")
	"""
	running = O.running
	if running:
		O.pause()
		awaitEndOfStep(O)
	ended = O.stopAtIter < 0  # it stopped by itself in the meantime: YADE marks that so
	yield
	if running and O.time < O.stopAtTime and not ended:
		O.run()
