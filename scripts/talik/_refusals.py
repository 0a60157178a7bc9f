# SPDX-License-Identifier: GPL-2.0-or-later
"""Settings with which a ground or its samples cannot start: what is wrong, and a sentence with attribute, value and remedy."""

import math

from yade import O, wrapper

from talik import _talik


def ofGround(mpm):
	"""The first sentence that holds for an MpmEngine; empty if none does."""
	return _first(ground, mpm)


def ofSamples(skeleton, points):
	"""The same for an RveSkeleton behind so many points."""
	return ofScheduling(skeleton) or _first(samples, skeleton, points)


def ofScheduling(skeleton):
	"""The same for what says when its samples are updated, and where."""
	for name, wrong, remedy in numbers:
		value = getattr(skeleton, name)
		if wrong(value) or (math.isinf(value) if name == "slipFriction" else not math.isfinite(value)):
			return f"RveSkeleton.{name} is {value:.10g}: {remedy}."
	return _first(choices, skeleton)


def _first(table, *objects):
	return next((sentence(*objects) for wrong, sentence in table if wrong(*objects)), "")


def _twice(names):
	return next((name for name in names if name and names.count(name) > 1), "")


def _asMade(material):
	"""Whether a material is one that nobody has described."""
	values = lambda of: {name: repr(value) for name, value in of.dict().items() if name != "name"}
	return values(material) == values(wrapper.GroundMaterial())


def _laws(m):
	return m.skeletons or [law for law in [m.skeleton] if law is not None]


def _inPython(m):
	return next((sentence for law in _laws(m) if isinstance(law, wrapper.PythonSkeleton) for sentence in [_first(pythonLaw, law)] if sentence), "")


pythonLaw = (
	(
		lambda law: not 0 < law.modulus < math.inf,
		lambda law: f"PythonSkeleton.modulus is {law.modulus:.10g}: give the largest modulus that the law may have in confined compression, in Pa, above 0.",
	),
	(lambda law: "" in law.states, lambda law: "PythonSkeleton.states has '' as a name: give each state a name of its own."),
	(lambda law: _twice(law.states), lambda law: f"PythonSkeleton.states has '{_twice(law.states)}' twice: give each state a name of its own."),
	(
		lambda law: law.statesAtStart and len(law.statesAtStart) != len(law.states),
		lambda law: f"PythonSkeleton.statesAtStart has {len(law.statesAtStart)} values for {len(law.states)} states: give one each, or none for zeros.",
	),
	(
		lambda law: not all(map(math.isfinite, law.statesAtStart)),
		lambda law: f"PythonSkeleton.statesAtStart is {next(x for x in law.statesAtStart if not math.isfinite(x)):.10g}: give finite numbers.",
	),
)

ground = (
	(
		lambda m: m.pointCount == 0,
		lambda m: "MpmEngine has no material points: fill it with talik.geometry.fill(mpm, polygon) or mpm.addPoints(…) before the first step.",
	),
	(lambda m: not m.gridSpacing > 0, lambda m: f"MpmEngine.gridSpacing is {m.gridSpacing:.10g}: give a positive spacing in m."),
	(lambda m: m.material is None, lambda m: "MpmEngine.material is None: give a GroundMaterial()."),
	(lambda m: None in m.materials, lambda m: "MpmEngine.materials holds None: give materials only."),
	(
		lambda m: m.materials and not _asMade(m.material),
		lambda m: "MpmEngine.material and MpmEngine.materials are both set: put all of them into materials.",
	),
	(
		lambda m: _twice([material.name for material in m.materials]),
		lambda m: f"MpmEngine.materials has two materials named '{_twice([material.name for material in m.materials])}': give each a name of its own.",
	),
	(lambda m: m.freezing and not m.heat, lambda m: "MpmEngine.freezing is set but heat is None: add heat=HeatTransfer()."),
	(
		lambda m: m.bodies and not m.motion,
		lambda m: "MpmEngine.bodies is set but motion is False: bodies push only ground that may move; set motion=True.",
	),
	(
		lambda m: m.water and not m.motion,
		lambda m: "MpmEngine.water is set but motion is False: water moves only in ground that may move; set motion=True.",
	),
	(
		lambda m: m.transfer in ("apic", "tpic") and not m.motion,
		lambda m: f"MpmEngine.transfer is '{m.transfer}' but motion is False: rigid ground has no velocity to transfer; leave it out.",
	),
	(
		lambda m: m.motion and not _laws(m),
		lambda m: "MpmEngine.skeleton is None: ground that moves needs one, e.g. skeleton=ElasticSkeleton(); or set motion=False.",
	),
	(lambda m: None in m.skeletons, lambda m: "MpmEngine.skeletons holds None: give skeleton laws only."),
	(lambda m: m.motion and _inPython(m), lambda m: _inPython(m)),
	(
		lambda m: m.distribute not in ("automatic", "ground", "none"),
		lambda m: f"MpmEngine.distribute is '{m.distribute}': choose automatic, ground (with the samples of its points) or none.",
	),
	(lambda m: None in m.boundaries, lambda m: "MpmEngine.boundaries holds None: give boundaries only."),
	(
		lambda m: m.effects and not m.motion,
		lambda m: "MpmEngine.effects is set but motion is False: they act on ground that moves; set motion=True.",
	),
)

numbers = (
	("threads", lambda n: n < 0, "give 0 or more"),
	("strainTolerance", lambda x: x < 0, "give a finite strain, 0 or more"),
	("saturationTolerance", lambda x: x < 0, "give a finite saturation, 0 or more"),
	("stressTolerance", lambda x: x < 0, "give a finite relative error, 0 or more"),
	("maxInertialNumber", lambda x: x <= 0, "give a positive number, e.g. 5e-3"),
	("maxStrainPerStep", lambda x: x <= 0, "give a positive number, e.g. 1e-5"),
	("slipFriction", lambda x: x < 0, "give 0 or more, or nan: it is measured on the samples"),
	("slipCohesion", lambda x: x < 0, "give a stress in Pa, 0 or more"),
	("minSteps", lambda n: n < 1, "give 1 or more"),
)

choices = (
	(lambda s: s.onBlowUp not in ("stop", "isolate"), lambda s: f"RveSkeleton.onBlowUp is '{s.onBlowUp}': choose stop or isolate."),
	(lambda s: s.device not in ("cpu", "gpu", "auto", "twin"), lambda s: f"RveSkeleton.device is '{s.device}': choose cpu, gpu, auto or twin."),
)

samples = (
	(lambda s, n: s.form not in ("packed", "open"), lambda s, n: f"RveSkeleton.form is '{s.form}': choose packed or open."),
	(lambda s, n: None in s.samples, lambda s, n: "RveSkeleton.samples holds None: give RveSamples only."),
	(lambda s, n: None in s.scenes, lambda s, n: "RveSkeleton.scenes holds None: give Scenes only."),
	(
		lambda s, n: any(_talik.sameObject(scene, O._sceneObj) for scene in s.scenes),
		lambda s, n: "RveSkeleton.scenes holds the current scene: load a sample in a scene of its own, see talik.scratchScene.",
	),
	(lambda s, n: s.seed < 0, lambda s, n: f"RveSkeleton.seed is {s.seed}: give a whole number, 0 or more."),
	(
		lambda s, n: s.sampleOf and len(s.sampleOf) != n,
		lambda s, n: f"RveSkeleton.sampleOf has {len(s.sampleOf)} numbers for {n} points: give one per point, or none.",
	),
)
