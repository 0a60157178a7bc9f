# SPDX-License-Identifier: GPL-2.0-or-later
"""What is public in talik, and the pages of the manual that list it. Needs the YADE that is running."""

import importlib
import inspect

import helptexts
import talik
from yade import wrapper

ofYade = {"dict", "updateAttrs", "qtHide", "dispHierarchy", "newAssocState"}  # what every class of YADE has
ofConsole = {"settingChanged", "usePortablePath"}  # what the console needs
parts = {"files", "studies"}  # of other modules and programs

sections = (
	(
		"engine",
		"The ground",
		"MpmEngine, its soil and its effects.",
		("MpmEngine", "GroundMaterial", "HeatTransfer", "FreezingCurve", "PoreWater", "IceSegregation", "ThawFront", "GroundEffect"),
	),
	("boundaries", "Boundaries", "Conditions on the surface of the ground and inside it. All have the attributes of GroundBoundary.", ("GroundBoundary",)),
	(
		"skeletons",
		"Skeleton laws and samples",
		"From strain to effective stress: laws, and samples of grains.",
		("SkeletonLaw", "IceStrength", "IceCreep", "RveSample", "OpenRveSample"),
	),
	("grains", "Grains with ice bonds", "For any scene of YADE, and for samples.", ("IceBondMat", "IceBondPhys", "Functor", "GrainSwelling", "CreepingBonds")),
	("scene", "Bodies, histories, checkpoints", "What stands beside the ground in a scene.", ("BodyContact", "PointWatch", "Checkpoint", "GlGround")),
)


def classes():
	"""All classes that import talik gives to the console."""
	found = {cls for cls in vars(talik).values() if inspect.isclass(cls) and issubclass(cls, wrapper.Serializable)}
	return sorted(found, key=lambda cls: cls.__name__)


def members(cls):
	"""(name, object) of attributes and methods of a class, in the order in which they are declared."""
	static = helptexts.ofStaticAttributes(cls.__doc__)
	for name, member in vars(cls).items():
		text = static.get(name) or member.__doc__ or ""
		if name.startswith("_") or name in ofYade | ofConsole or "|yhidden|" in text or not text.strip():
			continue
		yield name, member


def default(cls, name):
	"""Value of an attribute of a new object as Python writes it, or None where that says nothing."""
	try:
		value = getattr(cls(), name)
	except Exception:
		return None
	if isinstance(value, wrapper.Serializable):
		return type(value).__name__ + "()"
	text = repr(value)
	return None if text in ("''", "[]", "None") or "<" in text or len(text) > 60 else text


def modules():
	"""{name: module} of the tools of talik."""
	names = sorted({*talik._submodules} - parts | {f"studies.{name}" for name in talik.studies.tools})
	return {name: importlib.import_module("talik." + name) for name in names}


def functions(module):
	"""Names of the functions and classes that a module declares for its users."""
	return [
		name
		for name, value in vars(module).items()
		if not name.startswith("_")
		and name != "main"
		and getattr(value, "__module__", None) == module.__name__
		and (inspect.isfunction(value) or inspect.isclass(value))
	]


topFunctions = ("check", "resume", "inspect", "back", "scratchScene", "runUntilDay", "runUntil", "runSerially", "atRest", "refine", "coarsen")


def names():
	"""Full names of all that is public, for the index."""
	for cls in classes():
		yield f"talik.{cls.__name__}"
		for name, _ in members(cls):
			yield f"talik.{cls.__name__}.{name}"
	for name, module in modules().items():
		for function in functions(module):
			yield f"talik.{name}.{function}"
	for name in topFunctions:
		yield f"talik.{name}"


def _usualFirst(cls):
	"""Members of a class; of MpmEngine first the attributes that most scenes give, then (None, None), then the others."""
	own = dict(members(cls))
	if cls.__name__ != "MpmEngine":
		return list(own.items())
	usual = [name for name in talik.settings.usual if name in own]
	return [*((name, own[name]) for name in usual), (None, None), *((name, member) for name, member in own.items() if name not in usual)]


def _classPage(title, text, chosen):
	lines = [title, "=" * len(title), "", text, ""]
	for cls in chosen:
		lines += [cls.__name__, "-" * len(cls.__name__), "", f".. autoclass:: talik.{cls.__name__}", ""]
		for name, member in _usualFirst(cls):
			full = f"talik.{cls.__name__}.{name}"
			if name is None:
				lines += ["   .. rubric:: For experts, and methods", ""]
			elif isinstance(member, property) or type(member).__name__ == "StaticProperty":
				lines += [f"   .. autoattribute:: {full}", "      :no-value:", ""]
			else:
				lines += [f"   .. automethod:: {full}{helptexts.signature(member)}", ""]
	return lines


def _belongsTo(cls, bases):
	return any(base.__name__ in bases for base in cls.__mro__)


def _modulePage(name, module):
	title = f"talik.{name}"
	lines = [title, "=" * len(title), "", f".. automodule:: {title}", ""]
	for function in functions(module):
		directive = "autoclass" if inspect.isclass(getattr(module, function)) else "autofunction"
		lines += [f".. {directive}:: {title}.{function}", *(["   :members:"] if directive == "autoclass" else []), ""]
	return lines


def pages():
	"""{name of a page: its text} of the reference."""
	helptexts.linkedClasses[:] = [cls.__name__ for cls in classes()]
	found, rest = {}, classes()
	for page, title, text, bases in sections:
		chosen = sorted((cls for cls in rest if _belongsTo(cls, bases)), key=lambda cls: (*bases, cls.__name__).index(cls.__name__))
		rest = [cls for cls in rest if cls not in chosen]
		found[page] = _classPage(title, text, chosen)
	if rest:
		raise SystemExit(f"no section of the reference has {', '.join(cls.__name__ for cls in rest)}; add one in {__file__}")
	found["talik"] = [
		"Functions of talik",
		"==================",
		"",
		".. automodule:: talik",
		"",
		".. py:data:: talik.day",
		"",
		"   Seconds of a day, 86400: tables of boundaries are in seconds of calendar time, ``times=[0, 30 * talik.day]``.",
		"",
	]
	for name in topFunctions:
		found["talik"] += [f".. autofunction:: talik.{name}", ""]
	for name, module in modules().items():
		found[f"talik.{name}"] = _modulePage(name, module)
	return {page: "\n".join(lines) for page, lines in found.items()}
