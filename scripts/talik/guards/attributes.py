# SPDX-License-Identifier: GPL-2.0-or-later
"""A mistyped name, a value of a wrong type, and a change that comes too late are refused by one sentence: class, attribute, value, remedy."""

import difflib
import functools
import re
from contextlib import contextmanager

from talik import _talik
from talik.guards.calls import betweenSteps


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
	cls.__init__, cls.__setattr__, cls.updateAttrs = __init__, betweenSteps(__setattr__), betweenSteps(updateAttrs)


@contextmanager
def _seenByGrounds(part, names, stockSet):
	"""Watches attributes that the block sets. If a running ground was built with one of them, the old values are restored and ValueError is
	raised. A ground that has not begun is built again. The corners of its box, of
	which components can be set, are compared in every step (GroundOfScene::checkBox)."""
	from yade import wrapper

	used = [name for name in names if _usedByRunningGround(part, name)]
	before = {name: getattr(part, name) for name in used}
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
	if isinstance(part, (*_partsOfGround(wrapper.MpmEngine), wrapper.IceStrength, wrapper.IceCreep)):
		wrapper.MpmEngine.settingChanged()


def _whatChangesInTime(part, name):
	"""The remedy for who wanted a number that changes in time, where there is one."""
	if hasattr(type(part), "times"):
		return "; what changes in time is given by times, or days, and values"
	if (type(part).__name__, name) == ("HeatTransfer", "source"):
		return "; a source that changes in time is a boundary, HeatSource(region='box', days=[…], values=[…])"
	return ""


_changeable = "May be changed while running"  # how the docstring of an attribute says that a running ground reads it again


@functools.lru_cache(maxsize=None)
def _fixedAtStart(cls, name):
	"""True if a running ground was built with this attribute, as all of ours whose docstring does not say that it may be changed."""
	owner = next((kind for kind in cls.__mro__ if name in vars(kind)), cls)
	said = getattr(cls, name).__doc__ or ""
	return owner.__name__ in _talik.ownClasses() and ":yattrtype:" in said and _changeable not in said


def _usedByRunningGround(part, name):
	cls = type(part)
	if not _fixedAtStart(cls, name):
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
