# SPDX-License-Identifier: GPL-2.0-or-later
"""What Talik adds to YADE's console: Ctrl-C that works, mistyped settings that are answered by name, an exception where stock YADE
would end the process, and lists of our classes in the inspector.

Stock YADE notices Ctrl-C during O.run(n, True) and O.wait() only when the run has ended by itself. With Talik the run stops between
two steps and KeyboardInterrupt comes up; the scene can be looked at, saved and run on.
"""

import builtins
import difflib
import functools
import inspect
import keyword
import os
import re
import signal
import sys
import threading
import time
import types
from contextlib import contextmanager

from yade import log

from talik import _talik, ranks

# --- Ctrl-C ----------------------------------------------------------------------------------------------------------------


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
			_talik.refuseToAbort()
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
		_talik.refuseToAbort()
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


# --- calls while O runs ----------------------------------------------------------------------------------------------------


def _betweenSteps(function):
	def call(*positional, **named):
		return _talik.callBetweenSteps(function, positional, named)

	return functools.update_wrapper(call, function, assigned=("__name__", "__doc__"), updated=())


def letCallsWait(cls):
	"""Every method and attribute of a class waits for the end of the step that is under way, and the next step waits for it: nothing is
	read or changed while an engine works on it. What Python adds to a class afterwards is made of these."""
	for name in dir(cls):
		member = inspect.getattr_static(cls, name)
		if name.startswith("__") or isinstance(member, types.FunctionType):
			continue
		if type(member) is property:
			if name not in vars(cls):
				continue  # of stock YADE; none of our steps changes it
			setter = member.fset and _betweenSteps(member.fset)
			setattr(cls, name, property(_betweenSteps(member.fget), setter, member.fdel, member.__doc__))
		elif isinstance(member, staticmethod):
			setattr(cls, name, staticmethod(_betweenSteps(member.__func__)))
		elif type(member).__name__ == "function":  # of Boost.Python
			setattr(cls, name, _betweenSteps(member))


def makeFilesSafe(omegaClass):
	"""The scene is saved between two steps of our engines, also while O runs, with a checksum if there is something of ours in it; and a
	file that is damaged is refused before YADE reads it. Doing it twice changes nothing."""
	if hasattr(omegaClass, "_stockSave"):
		return
	for name in ("saveTmp", "sceneToString"):
		setattr(omegaClass, name, _betweenSteps(getattr(omegaClass, name)))
	stockSave, stockLoad = omegaClass._stockSave, omegaClass._stockLoad = _betweenSteps(omegaClass.save), omegaClass.load

	def save(self, file, quiet=False):
		inMemory = file.startswith(":memory:")
		if not ranks.first and not inMemory:
			return
		if inMemory or not _holdsOurs(self):
			return stockSave(self, file, quiet)
		from talik.files import saveScene

		saveScene(file, lambda plain: stockSave(self, plain, quiet))
		_talik.setSceneFile(file)

	def load(self, file, quiet=False):
		if os.path.isfile(file):
			from talik.files import sceneContent

			sceneContent(file)
		try:
			stockLoad(self, file, quiet)
		except RuntimeError as problem:
			raise RuntimeError(
				f"'{file}' cannot be read ({problem}): it is damaged or cut off, or of another version of YADE or Talik; take an earlier file"
			) from None

	save.__doc__, load.__doc__ = stockSave.__doc__, stockLoad.__doc__
	omegaClass.save, omegaClass.load = save, load


def _holdsOurs(omega):
	ours = set(_talik.ownClasses())
	return any(type(part).__name__ in ours for part in [*omega.engines, *omega.materials])


# --- labels ----------------------------------------------------------------------------------------------------------------


def checkedLabels(omega, file):
	"""Makes the labels of engines and functors names, as YADE does when it loads a scene; ValueError if one is no name: YADE runs it as
	a program."""
	from yade import wrapper

	for part in _labelled(omega.engines):
		label = getattr(part, "label", "")
		if label and (
			not label.isidentifier() or keyword.iskeyword(label) or hasattr(builtins, label) and not isinstance(getattr(builtins, label), wrapper.Serializable)
		):
			raise ValueError(
				f"'{file}': the label of {type(part).__name__} is {label!r}, which is no name for it; YADE would run it as a "
				"program. Take scenes only from those whose programs you would run."
			)
	omega.engines = omega.engines


def _labelled(engines):
	for engine in engines:
		yield engine
		for holder in [engine, *(getattr(engine, name, None) for name in ("geomDispatcher", "physDispatcher", "lawDispatcher", "boundDispatcher"))]:
			yield from getattr(holder, "functors", ())
		yield from getattr(engine, "comb", ())


# --- attributes ------------------------------------------------------------------------------------------------------------

_wanted = {
	"Real": "a number",
	"int": "a whole number",
	"long": "a whole number",
	"bool": "True or False",
	"string": "a text",
	"Vector2r": "two numbers",
	"Vector3r": "three numbers",
	"GroundVector": "two numbers, or three in space",
	"vector<Real>": "a list of numbers",
	"vector<int>": "a list of whole numbers",
}


def nameAttributesInErrors(cls):
	"""A value of a wrong type and a name that does not exist are refused by one sentence: class, attribute, value, remedy."""
	stockInit, stockSet, stockUpdate = cls.__init__, cls.__setattr__, cls.updateAttrs

	def __setattr__(self, name, value):
		if not hasattr(type(self), name):
			raise AttributeError(_unknown(type(self), name)) from None
		with _seenByGrounds(self, [name], stockSet):
			try:
				stockSet(self, name, value)
			except (TypeError, OverflowError):
				raise TypeError(f"{type(self).__name__}.{name} is {value!r}: give {_remedy(type(self), name)}.") from None

	def updateAttrs(self, attributes):
		with _seenByGrounds(self, [name for name in attributes if hasattr(type(self), name)], stockSet):
			stockUpdate(self, attributes)

	def __init__(self, *positional, **attributes):
		try:
			stockInit(self, *positional, **attributes)
		except (TypeError, AttributeError, OverflowError):
			if not positional:
				_findCulprit(cls, attributes)
			raise

	__init__.__doc__, updateAttrs.__doc__ = stockInit.__doc__, stockUpdate.__doc__
	cls.__init__, cls.__setattr__, cls.updateAttrs = __init__, _betweenSteps(__setattr__), _betweenSteps(updateAttrs)


@contextmanager
def _seenByGrounds(part, names, stockSet):
	"""What the block changes of a part of a ground: a ground that has begun was built with it, so that it is set back and refused; one that
	was only looked at is made anew."""
	from yade import wrapper

	used = [name for name in names if _usedByRunningGround(part, name)]
	waiting = [name for name in names if isinstance(getattr(type(part), name), property)] if wrapper.MpmEngine.heldByWaitingGround(part) else []
	before = {name: getattr(part, name) for name in {*used, *waiting}}
	yield
	for name in used:
		value = getattr(part, name)
		if not _same(before[name], value):
			for changed in used:
				stockSet(part, changed, before[changed])
			raise ValueError(
				f"{type(part).__name__}.{name} is {value!r} too late: the running ground was built with {before[name]!r} and stays so. "
				f"Set it before the first step or begin anew{_whatChangesInTime(part, name)}."
			)
	if any(not _same(before[name], getattr(part, name)) for name in waiting):
		wrapper.MpmEngine.renewWaitingGrounds(part)


def _whatChangesInTime(part, name):
	"""The remedy for who wanted a number that changes in time, where there is one."""
	if hasattr(type(part), "times"):
		return "; what changes in time is given by times, or days, and values"
	if (type(part).__name__, name) == ("HeatTransfer", "source"):
		return "; a source that changes in time is a boundary, HeatSource(region='box', days=[…], values=[…])"
	return ""


# What a running ground reads again and again; with all else of an MpmEngine and of the objects that it holds it was built.
_readWhileRunning = {
	"MpmEngine": {
		"gravity",
		"damping",
		"picTime",
		"courantNumber",
		"heatFraction",
		"motionFraction",
		"tolerance",
		"resting",
		"automaticTimeStep",
		"limitInterval",
		"inspected",
		"stopAtDay",
		"label",
		"dead",
		"ompThreads",
		"timingDeltas",
		"execCount",
		"execTime",
	},
	"HeatTransfer": {"thermalTimeScale", "movingTimeScale", "motionTolerance"},
	"BodyContact": {"mask", "thickness", "frictionAngle", "bodySteps"},
	"RveSkeleton": {"device", "threads", "onBlowUp", "blowUpFolder"},
}


def _usedByRunningGround(part, name):
	cls = type(part)
	if name in _readWhileRunning.get(cls.__name__, ()) or not isinstance(getattr(cls, name), property):
		return False
	from yade import O, wrapper

	if not any(issubclass(cls, kind) for kind in _partsOfGround(wrapper.MpmEngine)):
		return False
	grounds = [engine for engine in O.engines if isinstance(engine, wrapper.MpmEngine) and engine.begun]
	return any(_talik.sameObject(part, held) for ground in grounds for held in _heldBy(ground))


@functools.lru_cache(maxsize=None)
def _partsOfGround(engineClass):
	"""Classes of the objects that an MpmEngine holds, and its own."""
	from yade import wrapper

	kinds = (re.search(r"shared_ptr<(\w+)>", getattr(engineClass, name).__doc__ or "") for name in dir(engineClass))
	return [engineClass] + [getattr(wrapper, kind.group(1)) for kind in kinds if kind and hasattr(wrapper, kind.group(1))]


@functools.lru_cache(maxsize=None)
def _holdingAttributes(engineClass):
	return [name for name in dir(engineClass) if re.search(r":yattrtype:`(vector<)?shared_ptr<", getattr(engineClass, name).__doc__ or "")]


def _heldBy(ground):
	yield ground
	for name in _holdingAttributes(type(ground)):
		value = getattr(ground, name)
		yield from (part for part in (value if isinstance(value, list) else [value]) if part is not None)


def _same(a, b):
	"""Equal values; of YADE's objects the same one."""
	if isinstance(a, (list, tuple)) and isinstance(b, (list, tuple)):
		return len(a) == len(b) and all(map(_same, a, b))
	if hasattr(a, "updateAttrs") and hasattr(b, "updateAttrs"):
		return _talik.sameObject(a, b)
	return a == b or (a != a and b != b)


def _findCulprit(cls, attributes):
	blank = cls()
	for name, value in attributes.items():
		setattr(blank, name, value)


def _unknown(cls, name):
	known = [known for known in dir(cls) if isinstance(getattr(cls, known), property)]
	close = difflib.get_close_matches(name, known, n=1)
	hint = f"did you mean {close[0]}?" if close else f"there are {', '.join(k for k in known if not k.startswith('_'))}."
	return f"{cls.__name__} has no attribute '{name}'; {hint}"


def _remedy(cls, name):
	kind = re.search(r":yattrtype:`([^`]*)`", getattr(cls, name).__doc__ or "")
	kind = kind.group(1).replace(" ", "") if kind else ""
	held = re.fullmatch(r"(vector<)?shared_ptr<(\w+)>>?", kind)
	if held:
		return f"a list of {held.group(2)}" if held.group(1) else f"a {held.group(2)} or None"
	return _wanted.get(kind, f"a {kind or 'value of the type that help() names'}")


# --- inspector -------------------------------------------------------------------------------------------------------------

ownList = re.compile(r":yattrtype:`vector<shared_ptr<(\w+)>>`")


def _ownListClass(cls, attribute):
	"""Name of the class of which an attribute is a list, None for anything else."""
	found = ownList.search(getattr(cls, attribute).__doc__ or "")
	return found and found.group(1)


class _Learning:
	"""qtHide of a class of ours: the names of attributes that the inspector is to pass over, which it asks for before it shows the first.

	There are none; but an inspector that came after us learns here."""

	def __get__(self, shown, cls):
		editor = getattr(sys.modules.get("yade.qt"), "SerializableEditor", None)
		if editor is not None:
			_teach(editor)
		return ""


def teachInspector(classes):
	"""YADE's inspector knows lists of YADE's own classes only, and an empty list of another ends it with an error: it learns ours.

	Also where yade.qt is imported later."""
	for cls in classes:
		cls.qtHide = _Learning()


def _teach(editor):
	if hasattr(editor, "_stockGuess"):
		return
	from yade import wrapper

	stockGuess = editor._stockGuess = editor.getListTypeFromDocstring

	def guess(self, attribute):
		element = getattr(wrapper, _ownListClass(type(self.ser), attribute) or "", None)
		return (element,) if element else stockGuess(self, attribute)

	editor.getListTypeFromDocstring = guess
