# SPDX-License-Identifier: GPL-2.0-or-later
"""Talik: thawing and freezing ground at two scales, a plugin for the YADE that is running.

``import talik`` in a YADE script or console loads the plugin and registers its classes (``MpmEngine``, ``IceBondMat``, …),
which are then available everywhere as YADE's own are. The scene is left alone.
"""
import sys as _sys

if "yade.wrapper" not in _sys.modules:
	raise ImportError('talik is a plugin of YADE: import it in a script or console started by the command "yade".')

from contextlib import contextmanager as _contextmanager
from time import sleep as _sleep

from . import _talik, ranks
from .guards import attributes as _attributes, calls as _calls, copying as _copying, inspector as _inspector, runs as _runs, scenefiles as _scenefiles

day = 86400.0  # [s]: tables of boundaries are in seconds of calendar time, times=[0, 30 * talik.day]


def _publishClasses():
	"""YADE's own way: constructors of all classes are builtins. Returns the classes."""
	import builtins
	from yade import wrapper

	names = _talik.registerClasses()
	for name in names:
		constructor = getattr(wrapper, name)
		_calls.letCallsWait(constructor)
		_attributes.nameAttributesInErrors(constructor)
		_copying.makeCopyable(constructor)
		globals()[name] = constructor
		setattr(builtins, name, constructor)
	return [getattr(wrapper, name) for name in names]


def _renewDispatchers():
	"""Dispatch matrices made before the import have no room for the new classes; setting the functors again makes them anew."""
	from yade import O

	for engine in _flat(O.engines):
		for name in ("geomDispatcher", "physDispatcher", "lawDispatcher", "boundDispatcher"):
			dispatcher = getattr(engine, name, None)
			if dispatcher is not None:
				dispatcher.functors = dispatcher.functors


def _flat(engines):
	"""Engines with those inside a ParallelEngine, whose slaves may be lists of engines."""
	for engine in engines:
		if isinstance(engine, (list, tuple)):
			yield from _flat(engine)
		else:
			yield engine
			yield from _flat(getattr(engine, "slaves", ()))


@_contextmanager
def _paused():
	"""A running simulation rests in between two steps and goes on afterwards."""
	from yade import O

	running = O.running
	if running:
		O.pause()
		while O.running:
			_sleep(0.001)
	try:
		yield
	finally:
		if running:
			O.run()


def _renewView():
	"""The 3-D view looks for drawing functors when it is made; let it look again."""
	qt = _sys.modules.get("yade.qt")
	if qt is not None and hasattr(qt, "Renderer"):
		_talik.renewRenderer(qt.Renderer())


def _arrangeHelp():
	"""help(MpmEngine) begins with what most scenes give."""
	from yade import wrapper

	usual = __getattr__("settings").usual
	wrapper.MpmEngine._fields = usual  # by which pydoc sorts
	wrapper.MpmEngine.__doc__ += f"\n\nMost scenes give {', '.join(usual)}; the other attributes are for experts. See talik.settings."
	for name in ("__getstate_manages_dict__", "__safe_for_unpickling__"):
		setattr(wrapper.Serializable, name, property(getattr(wrapper.Serializable, name).fget, doc="For Python's copy and pickle."))


ranks.join()
with _paused():
	_inspector.teachInspector(_publishClasses())
	_renewDispatchers()
	_renewView()


def _watchRunsAndSteps():
	from yade import O

	_runs.makeRunsInterruptible(type(O))
	_runs.makeStepsKnown(type(O))
	_scenefiles.makeFilesSafe(type(O))


_watchRunsAndSteps()


@_contextmanager
def scratchScene():
	"""A fresh current scene for the block; the former one comes back afterwards, untouched.

	>>> with talik.scratchScene():
	...     added = O.bodies.append(utils.sphere((0, 0, 0), 1))
	"""
	from yade import O

	_runs.awaitRest(O)
	former = _talik.exchangeScene(_talik.emptyScene())
	try:
		yield
	finally:
		_talik.exchangeScene(former)


_submodules = (
	"batch",
	"bodies",
	"checkpoint",
	"climate",
	"dates",
	"ensemble",
	"files",
	"forecast",
	"geogrid",
	"geometry",
	"layers",
	"movie",
	"output",
	"packing",
	"plausibility",
	"plots",
	"plots3d",
	"progress",
	"ranks",
	"realisation",
	"refinement",
	"resampling",
	"running",
	"rve",
	"safety",
	"slope",
	"settings",
	"soils",
	"solids",
	"studies",
	"tables",
	"thermal",
	"weather",
)


_functions = {
	"refine": "refinement",
	"coarsen": "refinement",
	"atRest": "running",
	"runSerially": "running",
	"runUntil": "running",
	"runUntilDay": "running",
}  # and their modules


def __getattr__(name):
	"""Submodules are loaded when they are first used: the import itself stays in milliseconds."""
	import importlib

	if name in _functions:
		return getattr(importlib.import_module("talik." + _functions[name]), name)
	if name in _submodules:
		return importlib.import_module("talik." + name)
	raise AttributeError(f"module 'talik' has no attribute '{name}'")


from . import inspection as _inspection
from .inspection import back, inspect

_sys.modules["yade.wrapper"].MpmEngine.inspect = _inspection.inspectPoint
_sys.modules["yade.wrapper"].MpmEngine.back = _inspection.backToGround
for _name in ("pick", "most", "mostBroken", "mostStrained"):
	setattr(_sys.modules["yade.wrapper"].MpmEngine, _name, getattr(_inspection, _name))
_arrangeHelp()


def check(mpm):
	"""Prints settings of a ground that are valid but probably a mistake, a line each with the value and what was probably meant; returns
	them as a list. It may be called before and after the first step. The first step prints those that make the results meaningless.

	>>> talik.check(mpm)
	[]"""
	if not isinstance(mpm, MpmEngine):
		raise TypeError(f"talik.check: got {mpm!r}; give an MpmEngine")
	doubts = mpm.doubts()
	for doubt in doubts:
		print(doubt)
	return doubts


def resume(file):
	"""Goes on with the run in a checkpoint: its scene becomes that of O, its MpmEngine is returned. See talik.checkpoint.

	>>> talik.checkpoint.write(folder + "/slope.checkpoint")
	>>> mpm = talik.resume(folder + "/slope.checkpoint")"""
	from . import checkpoint

	return checkpoint.resume(file)
