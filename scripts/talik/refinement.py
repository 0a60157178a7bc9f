# SPDX-License-Identifier: GPL-2.0-or-later
"""Samples where they are needed: an analytic skeleton is swapped for samples of grains, and back, while the slope runs. A packed sample
goes on as a scene of YADE.

	talik.refine(mpm, where=lambda x, y: y > 2, sample=sample)  # samples at the stress and ice saturation of their points
	talik.coarsen(mpm, where=lambda x, y: y < 1, skeleton=MohrCoulombSkeleton())

A sample comes to its point as the ground did: as loose grains it is strained until it carries the stress of the point, then it is
frozen free of stress; what loose grains cannot carry (tension, steep shear) is put on after freezing. Stresses in Pa, tension positive.
"""

import math

import numpy as np

from yade import Matrix3, O, wrapper

from talik import _talik

largestObliquity = math.sin(math.radians(20))  # of the part that loose grains are asked to carry: radius over centre of Mohr's circle
leastPressure = 2e3  # [Pa] below it a sample of grains is no sample
tolerance = 2e-3  # of the stress, in units of its largest principal value or leastPressure
mostTrials = 400
largestStrain = 2e-4  # of a trial; the sample cuts it into steps of its own


class StressNotReached(ValueError):
	"""A sample cannot carry the stress of its point.

	>>> issubclass(talik.refinement.StressNotReached, ValueError)
	True"""


def refine(mpm, where, sample, **attributes):
	"""Puts a copy of `sample` behind the points of a running ground that `where` names; returns their new RveSkeleton.

	where       boolean array by point, ids, or function f(x, y) of arrays of the present positions that gives booleans
	sample      ice-free RveSample (talik.rve.pack) or prepared sample
	attributes  of the RveSkeleton, e.g. strainTolerance=1e-5

	Points with samples already keep them. StressNotReached (a ValueError) names a point whose stress the sample cannot carry;
	the ground is then as before.

	>>> law = talik.refine(elastic, where=lambda x, y: y > 0.5, sample=packed)"""
	from talik import rve

	laws, numbers = _laws(mpm), _numbers(mpm)
	chosen = [int(i) for i in _ids(mpm, where) if not isinstance(laws[numbers[i]], _class("RveSkeleton"))]
	if not chosen:
		raise ValueError("refine: where names no point that is without a sample; choose others")
	prototype = sample if hasattr(sample, "apply") else rve.pack(sample)
	samples, sampleOf = _broughtToPoints(mpm, prototype, chosen)
	law = _class("RveSkeleton")(samples=samples, sampleOf=sampleOf, **attributes)
	numbers[chosen] = len(laws)
	_exchange(mpm, laws + [law], numbers)
	return law


def coarsen(mpm, where, skeleton):
	"""Gives the points of a running ground that `where` names (as in refine) the analytic law `skeleton`, new or one in use.

	They keep their stress. Samples that stand behind no point any more are given up.

	>>> talik.coarsen(mpm, where=[0, 1], skeleton=ElasticSkeleton())"""
	laws, numbers = _laws(mpm), _numbers(mpm)
	if isinstance(skeleton, _class("RveSkeleton")):
		raise ValueError("coarsen: skeleton is an RveSkeleton; give an analytic law, or use refine")
	chosen = _ids(mpm, where)
	if len(chosen) == 0:
		raise ValueError("coarsen: where names no point; choose others")
	known = [k for k, law in enumerate(laws) if law is skeleton or law == skeleton]
	if not known:
		laws, known = laws + [skeleton], [len(laws)]
	numbers[chosen] = known[0]
	_exchange(mpm, laws, numbers)


def openSample(mpm, id, scene):
	"""Puts a scene of YADE with any law behind a point of a running ground whose samples are packed; returns the new RveSkeleton of that point.

	The scene is brought to the strain and ice of the present step. The other points keep their packed samples, and the settings are theirs.
	ValueError if the scene cannot be a sample; the ground is then as before. See MpmEngine.inspect(form="open").

	>>> law = talik.refinement.openSample(mpm, 5, mpm.skeleton.scene(5))
	>>> law.cost()["form"], mpm.skeletons[0].cost()["form"]
	('open', 'packed')"""
	laws, numbers = _laws(mpm), _numbers(mpm)
	former = laws[numbers[id]]
	if mpm.tolerance > 0:
		raise ValueError(f"MpmEngine.tolerance is {mpm.tolerance:g}, and open samples compare no rates: set it to 0 before the first step.")
	kept = {name: value for name, value in former.dict().items() if name not in ("samples", "scenes", "sampleOf", "form", "device", "skeletons")}
	if math.isnan(kept["slipFriction"]):
		kept["slipFriction"] = former.measuredFriction
	sample = _class("OpenRveSample")(source=scene, **{name: kept[name] for name in ("maxStrainPerStep", "maxInertialNumber", "minSteps", "timeStepFollowsIce")})
	shown = _talik.exchangeScene(sample.scene)
	try:
		_thawGrains(former.sample(id))
	finally:
		_talik.exchangeScene(shown)
	gradient = np.zeros((3, 3))
	accumulated = mpm.field(f"skeleton{numbers[id]}.accumulatedGradient")[id]
	size = math.isqrt(accumulated.size)
	gradient[:size, :size] = accumulated.reshape(size, size)
	sample.apply(Matrix3(*gradient.ravel()), float(_iceSaturation(mpm)[id]))
	law = _class("RveSkeleton")(scenes=[sample.scene], sampleOf=[0 if k == id else -1 for k in range(mpm.pointCount)], form="open", **kept)
	numbers[id] = len(laws)
	_exchange(mpm, laws + [law], numbers)
	return law


def _thawGrains(packed):
	"""The grains of the scene shown shrink as those of the packed sample would, eq. (14.5), if it has no engine that does it."""
	engines, grains = O.engines, [body for body in O.bodies if isinstance(body.mat, wrapper.IceBondMat)]
	if packed.thawStrain == 0 or not grains or any(isinstance(engine, wrapper.GrainSwelling) for engine in engines):
		return
	lost = 1 - grains[0].mat.radiusRatio ** packed.dimension
	frozen = packed.iceSaturation / (1 - lost / packed.thawStrain) if 0 < lost < packed.thawStrain else packed.iceSaturation
	shrink = wrapper.GrainSwelling(
		radiusRule="mechanical",
		porosity=max(packed.statistics()["porosity"], packed.thawStrain),
		dimension=packed.dimension,
		thawStrain=packed.thawStrain,
		frozenSaturation=min(1, frozen) or 1,
	)
	collider = next(k for k, engine in enumerate(engines) if isinstance(engine, wrapper.Collider))
	O.engines = engines[:collider] + [shrink] + engines[collider:]


def bringTo(sample, stress, iceSaturation=0.0):
	"""Brings an ice-free sample to the stress (xx, yy, xy) [Pa] and freezes it to an ice saturation; the sample is changed.

	StressNotReached if neither grains nor bonds can carry it.

	>>> talik.refinement.bringTo(packed.copy(), (-80e3, -100e3, 0))"""
	goal = np.asarray(stress, dtype=float)
	_load(sample, goal if iceSaturation == 0 else _carriedByGrains(goal))
	if iceSaturation > 0:
		sample.freeze(iceSaturation)
		_strainFrozen(sample, goal, iceSaturation)


# --- stress ----------------------------------------------------------------------------------------------------------------


def _carriedByGrains(goal):
	"""The stress nearest to the goal, in the sense of Mohr's circle, that loose grains carry safely."""
	centre, deviator, shear = 0.5 * (goal[0] + goal[1]), 0.5 * (goal[0] - goal[1]), goal[2]
	safe = min(centre, -leastPressure)
	radius = math.hypot(deviator, shear)
	factor = min(1.0, largestObliquity * -safe / radius) if radius > 0 else 1.0
	return np.array([safe + factor * deviator, safe - factor * deviator, factor * shear])


def _load(sample, goal):
	"""Loose grains are brought to the principal stresses along the axes of their cell and turned into the principal directions."""
	centre, deviator, shear = 0.5 * (goal[0] + goal[1]), 0.5 * (goal[0] - goal[1]), goal[2]
	angle = 0.5 * math.atan2(shear, abs(deviator)) * (1 if deviator >= 0 else -1)
	radius = math.copysign(math.hypot(deviator, shear), deviator)
	if centre + abs(radius) >= 0 or not sample.servo(centre + radius, centre - radius):
		raise StressNotReached(_missed(sample, goal, 0.0))
	if angle != 0:
		c, s = math.cos(angle), math.sin(angle)
		sample.apply(Matrix3(c - 1, -s, 0, s, c - 1, 0, 0, 0, 0), 0.0)


def _strainFrozen(sample, goal, iceSaturation):
	"""Newton's method with a stiffness that is learnt on the way (Broyden), from the isotropic guess of a first small strain."""
	enough = tolerance * max(np.abs(goal).max(), leastPressure)
	compliance, now = None, np.array(sample.stress)
	for _ in range(mostTrials):
		missing = goal - now
		if np.abs(missing).max() < enough:
			return
		if compliance is None:
			compliance, now = _compliance(sample, iceSaturation), np.array(sample.stress)
			missing = goal - now
		strain = compliance @ missing
		strain *= min(1.0, largestStrain / np.abs(strain).max())
		if sample.apply(_gradient(strain), iceSaturation)["blewUp"]:
			break
		change = np.array(sample.stress) - now
		now = now + change
		compliance = _learnt(compliance, strain, change)
	raise StressNotReached(_missed(sample, goal, iceSaturation))


def _missed(sample, goal, iceSaturation):
	now = sample.stress
	return (
		f"the sample does not reach the stress xx, yy, xy = {goal[0]:.0f}, {goal[1]:.0f}, {goal[2]:.0f} Pa at ice saturation {iceSaturation:g}, it stays at "
		f"{now[0]:.0f}, {now[1]:.0f}, {now[2]:.0f} Pa; choose points that carry less shear or tension, or a stronger sample"
	)


def _gradient(strain):
	"""Displacement gradient of the strains xx, yy and shear angle xy, without rotation of its own."""
	half = 0.5 * strain[2]
	return Matrix3(strain[0], half, 0, half, strain[1], 0, 0, 0, 0)


def _compliance(sample, iceSaturation):
	"""Isotropic: from the answer to a small compression, with a Poisson's ratio of 0.25."""
	probe, before = 1e-6, np.array(sample.stress)
	sample.apply(_gradient((-probe, -probe, 0)), iceSaturation)
	bulk = max(-(np.array(sample.stress) - before)[:2].mean() / (2 * probe), 1e6)
	shear = 0.6 * bulk
	return np.linalg.inv(np.array([[bulk + shear, bulk - shear, 0], [bulk - shear, bulk + shear, 0], [0, 0, shear]]))


def _learnt(compliance, strain, change):
	"""Broyden's update, kept only where it stays positive: grains that slide answer with next to nothing."""
	answer = compliance @ change
	denominator = strain @ answer
	if denominator < 0.05 * (strain @ strain):
		return compliance
	return compliance + np.outer(strain - answer, strain @ compliance) / denominator


def _broughtToPoints(mpm, prototype, ids):
	stress, saturation = mpm.field("stress"), _iceSaturation(mpm)
	samples, sampleOf, known = [], [-1] * mpm.pointCount, {}
	for i in ids:
		goal = (stress[i, 0], stress[i, 1], stress[i, 3], saturation[i])
		if goal not in known:
			copy = prototype.copy()
			try:
				bringTo(copy, goal[:3], goal[3])
			except StressNotReached as error:
				raise StressNotReached(f"refine: point {i}: {error}") from None
			known[goal] = len(samples)
			samples.append(copy)
		sampleOf[i] = known[goal]
	return samples, sampleOf


# --- the engine ------------------------------------------------------------------------------------------------------------


def _class(name):
	from yade import wrapper

	return getattr(wrapper, name)


def _laws(mpm):
	return list(mpm.skeletons) or [mpm.skeleton]


def _numbers(mpm):
	return np.array(mpm.skeletonOf)


def _iceSaturation(mpm):
	return mpm.field("iceSaturation") if "iceSaturation" in mpm.fieldNames() else np.zeros(mpm.pointCount)


def _ids(mpm, where):
	if callable(where):
		where = where(*mpm.field("position").T)
	chosen = np.asarray(where)
	if chosen.dtype == bool:
		if chosen.shape != (mpm.pointCount,):
			raise ValueError(f"where has shape {chosen.shape}; it must be a boolean for each of the {mpm.pointCount} points")
		return np.flatnonzero(chosen)
	if chosen.ndim != 1 or not np.issubdtype(chosen.dtype, np.integer) or chosen.size == 0:
		raise ValueError("where must be a boolean array by point, a list of point ids, or a function f(x, y) that gives booleans")
	if chosen.min() < 0 or chosen.max() >= mpm.pointCount:
		raise ValueError(f"where names point {chosen[(chosen < 0) | (chosen >= mpm.pointCount)][0]}; there are points 0 to {mpm.pointCount - 1}")
	return np.unique(chosen)


def _exchange(mpm, laws, numbers):
	"""Laws that no point uses any more are left out."""
	used = sorted(set(int(k) for k in numbers))
	mpm.exchangeSkeletons([laws[k] for k in used], [used.index(int(k)) for k in numbers])
