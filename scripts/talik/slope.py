# SPDX-License-Identifier: GPL-2.0-or-later
"""Slopes with a sample behind every point: which sample a point starts with.

A slope at rest carries a different stress at every depth. Its samples are therefore brought to the geostatic stress of a few depth
bands while they are still frictional; they are frozen afterwards, by the first step, so that bonds and ice start free of stress.
"""

import math

import numpy as np

from talik import layers as groundLayers
from talik import rve
from talik.geometry import Solid, rectangle, surfaceHeight
from talik.safety import bishop, factorOfSafety, infiniteSlope  # noqa: F401: where users look for them
from yade import wrapper


def geostaticStress(depth, density, gravity=9.81, lateralRatio=0.7, smallest=2e3, load=0.0):
	"""(sigma_h, sigma_v) [Pa, tension positive] at a depth [m] below the surface in drained ground at rest, under a load [Pa] on the surface.

	Above the depth where the vertical pressure reaches `smallest` [Pa] it is kept: a sample needs some confinement to be one.

	>>> talik.slope.geostaticStress(depth=2.0, density=2000, gravity=10, lateralRatio=0.5)
	(-20000.0, -40000.0)"""
	vertical = max(density * gravity * depth + load, smallest / lateralRatio)
	return -lateralRatio * vertical, -vertical


def depthBands(position, polygon, sample, density, bandThickness=0.5, lateralRatio=0.7, gravity=9.81, seed=1, load=0.0):
	"""Samples of depth bands and the band of each point: (samples, sampleOf) for RveSkeleton.

	position       (n,2) or, in space, (n,3) of the points [m]
	polygon        outline of the ground, in space its solid (box, extruded, terrain), for the depth below its surface
	sample         RveSample, or YADE Scene of any law, frictional, that is brought to the stress in the middle of each band; a list: realisations of
				   it, assigned to the points of every band at random
	density        of the ground [kg/m3]
	bandThickness  [m]
	lateralRatio   horizontal over vertical stress at rest [-]
	seed           of that chance, see RveSkeleton.seed
	load           pressure on the surface [Pa], 0 or more

	>>> position = talik.geometry.fillPolygon([(0, 0), (1, 0), (1, 2), (0, 2)], 0.5)[0]
	>>> samples, sampleOf = talik.slope.depthBands(position, [(0, 0), (1, 0), (1, 2), (0, 2)], packed, density=2000, bandThickness=1)"""
	depth = _depth(polygon, position)
	band = np.maximum(0, np.floor(depth / bandThickness)).astype(int)
	realisations = rve.listOf(sample)
	pairs = list(zip(map(int, band), wrapper.RveSkeleton.deal(position, len(realisations), seed)))
	used = sorted(set(pairs))
	samples = [_broughtTo(realisations[k], geostaticStress((b + 0.5) * bandThickness, density, gravity, lateralRatio, load=load), b) for b, k in used]
	return samples, [used.index(pair) for pair in pairs]


def settle(mpm, polygon, bandThickness=None, lateralRatio=0.7, load=0.0):
	"""Brings the samples of a filled MpmEngine to the weight above their points, before they freeze and before the first step.

	A sample that freezes at a pressure that its point does not carry expands when its ice melts: 8 mm in two metres of ground with
	samples of 100 kPa under 20 kPa. The samples and scenes of every RveSkeleton, of layers too, are replaced by those of depth bands;
	several of one are realisations. Scenes that can be packed become samples, others stay scenes, which run open. The weight is that of
	the mean density of the ground.

	polygon        outline of the ground, in space its solid (box, extruded, terrain), for the depth below its surface
	bandThickness  [m]; default a cell of the grid
	lateralRatio   horizontal over vertical effective stress at rest [-]
	load           pressure on the surface [Pa], 0 or more

	>>> mpm = MpmEngine(gridSpacing=0.5, gravity=(0, -9.81), skeleton=RveSkeleton(samples=[packed]))
	>>> added = talik.geometry.fill(mpm, [(0, 0), (1, 0), (1, 1), (0, 1)])
	>>> talik.slope.settle(mpm, [(0, 0), (1, 0), (1, 1), (0, 1)], load=20e3)"""
	laws = list(mpm.skeletons) or [mpm.skeleton]
	if not any(_hasSamples(law) for law in laws):
		raise ValueError("settle: the ground has no samples to settle; give skeleton=RveSkeleton(samples=[…]) first")
	if mpm.begun:
		raise ValueError("settle: the ground has begun; settle its samples before the first step")
	if isinstance(polygon, Solid) != (mpm.dimension == 3):
		raise ValueError(f"settle: the ground has {mpm.dimension} dimensions; give {'a solid of talik.solids' if mpm.dimension == 3 else 'its outline'}")
	gravity = tuple(mpm.gravity)
	if not gravity[-1] < 0:
		raise ValueError(f"settle: mpm.gravity is {gravity}, nothing weighs on the samples; give a gravity downwards")
	masses, weight = mpm.balance(), -gravity[-1]
	density = (masses["solidMass"] + masses["waterMass"]) / mpm.field("volume").sum()
	if mpm.water is not None:  # what the pore water carries the grains do not
		depth = _depth(polygon, mpm.field("position"))
		density -= float(mpm.field("pressure") @ depth / (depth @ depth)) / weight
	position, lawOf = mpm.field("position"), np.array(mpm.skeletonOf)
	for number, law in enumerate(laws):
		own = np.flatnonzero(lawOf == number)
		if not _hasSamples(law) or not len(own):
			continue
		realisations = [*law.samples, *map(_packedWhereItCanBe, law.scenes)]
		banded, ofOwn = depthBands(position[own], polygon, realisations, density, bandThickness or mpm.gridSpacing, lateralRatio, weight, law.seed, load)
		packed = [not isinstance(one, wrapper.Scene) for one in banded]
		order = sorted(range(len(banded)), key=lambda k: not packed[k])  # samples are numbered before scenes
		place = {former: now for now, former in enumerate(order)}
		sampleOf = np.zeros(len(position), dtype=int)
		sampleOf[own] = [place[number] for number in ofOwn]
		law.samples, law.scenes = [one for one, isPacked in zip(banded, packed) if isPacked], [one for one, isPacked in zip(banded, packed) if not isPacked]
		law.sampleOf = sampleOf.tolist()


def infiniteColumn(mpm, angle, layers, waterDepth=math.inf, lateralRatio=1.0, pointsPerCell=None, cells=1):
	"""Makes an MpmEngine in the plane a column of a slope without end, in balance at the start; returns {name: ids of the points (n,)}.

	The grid lies along the slope, x downhill and y across it. The column gets the box, gravity, a PeriodicBoundary on its sides and a
	FixedBoundary below, which come before boundaries that it has; grid spacing, effects and skeleton law are those of the MpmEngine.

	mpm            without points, with gridSpacing; gravity is 9.81 m/s2
	angle          of the slope [degrees], 0 to below 90
	layers         {name: dict(thickness=m across the slope, …)} from the surface down, otherwise as in talik.layers.fill without polygon
	waterDepth     depth of the water table across the slope [m], with pore water: water below it flows parallel to the slope
	lateralRatio   effective stress along the slope over that across it [-]; 1: that of a slope which yields without dilation
	pointsPerCell  a square number; default that of talik.geometry.fill
	cells          width of the column [cells]: 1 where all is the same along the slope

	A column stands on its base whatever thaws above; compare talik.slope.infiniteSlope.

	>>> mpm = MpmEngine(gridSpacing=0.25, skeleton=MohrCoulombSkeleton(frictionAngle=30), water=PoreWater(conductivity=1e-6))
	>>> layers = talik.slope.infiniteColumn(mpm, angle=15, layers={"peat": dict(thickness=0.5, porosity=0.8), "silt": dict(thickness=2)}, waterDepth=0.5)
	>>> len(layers["silt"])
	32"""
	if not 0 <= angle < 90 or lateralRatio <= 0 or waterDepth < 0:
		raise ValueError(
			f"infiniteColumn: angle is {angle}, lateralRatio {lateralRatio}, waterDepth {waterDepth}; give an angle of 0 to below 90 degrees, a ratio "
			f"above 0 and a depth in m, 0 or more"
		)
	if mpm.water is None and waterDepth < math.inf:
		raise ValueError("infiniteColumn: waterDepth is given, and the ground has no water; set water=PoreWater(), or leave it out")
	if mpm.pointCount:
		raise ValueError(f"infiniteColumn: the ground has {mpm.pointCount} points already; give an MpmEngine without")
	groundLayers._refuseOtherMaterials(layers)
	h, total = mpm.gridSpacing, sum(_thicknessOf(name, layer) for name, layer in layers.items())
	along, across = 9.81 * math.sin(math.radians(angle)), 9.81 * math.cos(math.radians(angle))
	roomAbove = 4  # cells: for heave
	mpm.lower, mpm.upper, mpm.gravity = (0, 0), (cells * h, h * (math.ceil(round(total / h, 6)) + roomAbove)), (along, -across)
	mpm.boundaries = [wrapper.PeriodicBoundary(region="left"), wrapper.FixedBoundary(region="bottom"), *mpm.boundaries]
	base = [total - sum(layer["thickness"] for layer in list(layers.values())[: k + 1]) for k in range(len(layers))]
	liquid = next(iter(layers.values())).get("material", mpm.material).liquidDensity

	def pressure(x, y):
		return liquid * across * np.maximum(0.0, total - waterDepth - y) if mpm.water is not None else 0 * y

	def stress(x, y):
		mass = 0 * y
		for (dry, wet), b, layer in zip(densities, base, layers.values()):
			top = b + layer["thickness"]
			mass = mass + dry * np.clip(top - y, 0, layer["thickness"])
			mass = mass + (wet - dry) * np.clip(np.minimum(top, total - waterDepth) - np.maximum(y, b), 0, None)
		normal = np.minimum(0.0, pressure(x, y) - mass * across)
		return np.stack([lateralRatio * normal, normal, lateralRatio * normal, mass * along], axis=1)

	placed = {}
	for (name, layer), b in zip(layers.items(), base):
		outline = rectangle(0, b, cells * h, b + layer["thickness"])
		bySample = _hasSamples(layer.get("skeleton", mpm.skeleton))  # whose stress is theirs, see settle
		placed[name] = dict(polygon=outline, **({} if bySample else dict(stress=stress)), **({} if mpm.water is None else dict(pressure=pressure)))
		placed[name].update({key: value for key, value in layer.items() if key != "thickness"})
	densities = [(groundLayers._density(mpm, layer), groundLayers._density(mpm, {**layer, "poreFill": 1.0})) for layer in placed.values()]
	for layer in placed.values():
		if "poreFill" in layer:
			layer["poreFill"] = groundLayers._fullBelow(lambda x: total - waterDepth, layer["poreFill"])
	return groundLayers.fill(mpm, placed, pointsPerCell)


def _thicknessOf(name, layer):
	thickness = layer.get("thickness", 0)
	if not thickness > 0:
		raise ValueError(f"infiniteColumn: layer '{name}' has thickness {thickness!r}; give its thickness across the slope in m, above 0")
	return thickness


def _hasSamples(law):
	return isinstance(law, wrapper.RveSkeleton) and len(law.samples) + len(law.scenes) > 0


def _packedWhereItCanBe(scene):
	try:
		return rve.pack(scene)
	except ValueError:
		return scene


def _depth(ground, position):
	if isinstance(ground, Solid):
		return ground.depth(*np.transpose(position))
	return np.array([surfaceHeight(ground, x) - y for x, y in position])


def _broughtTo(sample, goal, band):
	across, down = goal
	if isinstance(sample, wrapper.Scene):
		try:
			inPlane = rve.dimensionOf(sample) == 2
			return rve.servo(sample, across, down) if inPlane else rve.servo(sample, across, across, stressZ=down)
		except rve.PackingError as problem:
			raise RuntimeError(f"depthBands: the scene does not reach the stress of band {band}: {problem}") from None
	banded = sample.copy()
	if not banded.servo(*(across,) * (banded.dimension - 1), down):
		raise RuntimeError(f"depthBands: the sample does not reach {goal[0]:.0f}, {goal[1]:.0f} Pa of band {band}; choose a lateralRatio nearer to 1")
	return banded


def __getattr__(name):
	if name in ("pack", "openScene"):
		raise AttributeError(f"talik.slope.{name} is talik.rve.{name} now")
	raise AttributeError(f"module 'talik.slope' has no attribute '{name}'")
