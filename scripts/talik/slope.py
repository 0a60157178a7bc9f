# SPDX-License-Identifier: GPL-2.0-or-later
"""Slopes with a sample behind every point: which sample a point starts with.

A slope at rest carries a different stress at every depth. Its samples are therefore brought to the geostatic stress of a few depth
bands while they are still frictional; they are frozen afterwards, by the first step, so that bonds and ice start free of stress.
"""

import numpy as np

from talik import rve
from talik.geometry import Solid, surfaceHeight
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
	sample         RveSample, frictional, that is brought to the stress in the middle of each band; a list: realisations of it, dealt to
				   the points of every band by chance
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
	samples of 100 kPa under 20 kPa. The samples of every RveSkeleton, of layers too, are replaced by those of depth bands; several of one are
	realisations. The weight is that of the mean density of the ground.

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
		law.samples, ofOwn = depthBands(
			position[own], polygon, list(law.samples), density, bandThickness or mpm.gridSpacing, lateralRatio, weight, law.seed, load
		)
		sampleOf = np.zeros(len(position), dtype=int)
		sampleOf[own] = ofOwn
		law.sampleOf = sampleOf.tolist()


def _hasSamples(law):
	return isinstance(law, wrapper.RveSkeleton) and len(law.samples) > 0


def _depth(ground, position):
	if isinstance(ground, Solid):
		return ground.depth(*np.transpose(position))
	return np.array([surfaceHeight(ground, x) - y for x, y in position])


def _broughtTo(sample, goal, band):
	banded, (across, down) = sample.copy(), goal
	if not banded.servo(*(across,) * (banded.dimension - 1), down):
		raise RuntimeError(f"depthBands: the sample does not reach {goal[0]:.0f}, {goal[1]:.0f} Pa of band {band}; choose a lateralRatio nearer to 1")
	return banded


def __getattr__(name):
	if name in ("pack", "openScene"):
		raise AttributeError(f"talik.slope.{name} is talik.rve.{name} now")
	raise AttributeError(f"module 'talik.slope' has no attribute '{name}'")
