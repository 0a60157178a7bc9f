# SPDX-License-Identifier: GPL-2.0-or-later
"""Runs that Ctrl-C pauses and whose errors are raised.

Stock YADE notices Ctrl-C during O.run(n, True) and O.wait() only when the run has ended by itself. With Talik the run stops between
two steps and KeyboardInterrupt is raised; the scene can be looked at, saved and run on.
"""

import os
import signal
import threading
import time
from contextlib import contextmanager

from yade import log

from talik import _talik


def makeRunsInterruptible(omegaClass):
	"""Lets Ctrl-C pause the run that omegaClass.run(n, True) or .wait() waits for. Doing it twice changes nothing."""
	if hasattr(omegaClass, "_stockWait"):
		return
	stockRun, stockWait = omegaClass.run, omegaClass.wait
	signals, omegaClass._stockWait = _watcher(), stockWait
	unwaited = []  # a run was started and nobody has asked yet how it ended
	omegaClass._mayStep = False  # the last step of a run that was paused may still be under way

	def run(self, nSteps=-1, wait=False):
		if not self.running:
			refuseToAbort(self)
		unwaited[:] = [] if wait else [True]
		omegaClass._mayStep = True
		if not wait:
			return stockRun(self, nSteps)
		before = _failures(self)
		with _pausedBySignal(self, signals), _saidOnce():
			stockRun(self, nSteps, True)
		if _failures(self) > before:
			_raiseFailure(self)

	def wait(self):
		asked, unwaited[:] = bool(unwaited), []
		with _pausedBySignal(self, signals):
			stockWait(self)
		if asked:
			_raiseFailure(self)

	run.__doc__, wait.__doc__ = stockRun.__doc__, stockWait.__doc__
	omegaClass.run, omegaClass.wait = run, wait


def refuseToAbort(omega):
	"""What would end the whole process is said before it does."""
	_talik.refuseToAbort()
	if not omega.periodic:
		return
	for k, engine in enumerate(omega.engines):
		if type(engine).__name__ == "VTKRecorder" and not engine.dead and {"intr", "all"} & set(engine.recorders):
			raise RuntimeError(
				f"The scene cannot run: O.engines[{k}] is a VTKRecorder with {list(engine.recorders)!r}, by which stock YADE crashes in a periodic scene. "
				"Give recorders=['spheres','velocity','colors'], and write contacts by talik.output.SampleSeries."
			)


@contextmanager
def _saidOnce():
	"""What ends a run that is waited for comes up as an exception: YADE need not log it besides."""
	_talik.setRunWaitedFor(True)
	try:
		yield
	finally:
		_talik.setRunWaitedFor(False)
		for name, level in _muted.items():
			if level is None:
				log.unsetLevel(name)
			else:
				log.setLevel(name, level)
		_muted.clear()


_muted = {}  # loggers of YADE that are silent for now, and their levels


def muteLog():
	"""For an engine of ours that is about to fail in such a run."""
	for name in ("ThreadRunner", "yadeWrapper.cpp"):
		_muted[name] = log.getUsedLevels().get(name)
		log.setLevel(name, 0)


def makeStepsKnown(omegaClass):
	"""O.running is False during O.step(): lets _talik.stepUnderWay() tell of such a step. Doing it twice changes nothing."""
	if hasattr(omegaClass, "_stockStep"):
		return
	stockStep = omegaClass._stockStep = omegaClass.step

	def step(self):
		refuseToAbort(self)
		_talik.callAsStep(lambda: stockStep(self))

	step.__doc__ = stockStep.__doc__
	omegaClass.step = step


def _failures(omega):
	return sum(getattr(engine, "failures", 0) for engine in omega.engines if hasattr(engine, "failure"))


def _raiseFailure(omega):
	"""Stock YADE forgets the error of a run that has ended before it is waited for; our engines remember it."""
	for engine in omega.engines:
		if getattr(engine, "failure", ""):
			raise RuntimeError(engine.failure)


@contextmanager
def _pausedBySignal(omega, signals):
	"""YADE waits in C++, where Python's own handler of Ctrl-C is not reached: a thread learns of the signal and pauses the run."""
	if threading.current_thread() is not threading.main_thread():
		yield
		return
	former = signal.set_wakeup_fd(signals, warn_on_full_buffer=False)
	try:
		yield
	except KeyboardInterrupt:
		awaitEndOfStep(omega)
		raise
	finally:
		signal.set_wakeup_fd(former)


def _watcher():
	"""Starts the thread; returns where signals are to be told to it."""
	from yade import O

	reader, writer = os.pipe()
	os.set_blocking(writer, False)

	def watch():
		while signals := os.read(reader, 64):
			if signal.SIGINT in signals:
				O.pause()

	threading.Thread(target=watch, daemon=True).start()
	return writer


def awaitEndOfStep(omega, quiet=0.02, patience=60):
	"""Returns when no engine of a run that was paused is at work any more: YADE says that it rests while its last step is still under way.

	quiet     time for which no step may begin [s]: a step that was about to begin when the pause came
	patience  [s]: after an engine's error YADE reports its step as under way for good"""
	if omega.subStepping:
		return
	began = still = time.monotonic()
	step = omega.iter
	while time.monotonic() < still + quiet and time.monotonic() < began + patience and not _failed(omega):
		time.sleep(0.001)
		if omega.running or omega.subStep >= 0 or omega.iter != step:
			still, step = time.monotonic(), omega.iter


def awaitRest(omega, patience=1.0):
	"""Returns when the step that was under way when a run was paused has ended, at once where there was no such run or it goes on.

	patience  [s] for engines that are not ours: after an error of theirs YADE reports the step as under way for good"""
	if not omega._mayStep or omega.running or _talik.stepUnderWay() or isinstance(threading.current_thread(), threading._DummyThread):
		return
	_talik.callBetweenSteps(lambda: None, (), {})
	awaitEndOfStep(omega, patience=patience)
	type(omega)._mayStep = False


def _failed(omega):
	return any(getattr(engine, "failure", "") for engine in omega.engines)
