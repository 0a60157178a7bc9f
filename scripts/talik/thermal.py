# SPDX-License-Identifier: GPL-2.0-or-later
"""Thermal spin-up: temperatures that the ground has come to before it moves. Thaw depth by columns.

	def ground(temperature):
		mpm = MpmEngine(...)
		talik.geometry.fill(mpm, outline, temperature=temperature)
		return mpm

	temperature = talik.thermal.spinUp(ground(-2), days=3650)
	mpm = ground(temperature)                                    # moves, and starts with the temperatures of ten years at rest
	columns = talik.thermal.thawDepth(mpm)                       # depth of the frozen ground below the surface, column by column
"""

import copy

import numpy as np

import talik
from yade import O

thermalBoundaries = ("PeriodicBoundary", "SurfaceTemperature", "WallTemperature", "HeatFlux", "HeatSource", "InsulatedBoundary")


def spinUp(mpm, days, boundaries=None, told=None):
	"""Lets heat alone flow in a rigid copy of a filled MpmEngine; returns the temperature [degC] as a function of the place, for fill.

	mpm         a ground with heat and points, which has not begun; it is left as it is, and so is the scene in O
	days        how long heat flows [d of the calendar], above 0, up to day 0: tables of boundaries have their first value all the time
	boundaries  thermal boundaries in place of those of the ground, e.g. with a table of weather from -days * talik.day on
	told        list that is given the largest change of a temperature in the last tenth of the time [K]

	Thermal boundaries that act by way of bodies are left out. Between the points the function is linear, outside of them that of the
	nearest. A steady state is reached when half of the changes of depth H have had H^2 C/k to die out: 10 m of silt take some three years.

	>>> def column(temperature):
	...     mpm = MpmEngine(gridSpacing=0.5, lower=(0, 0), upper=(1, 4), heat=HeatTransfer(), freezing=FreezingCurve(), motion=False)
	...     mpm.boundaries = [WallTemperature(region="top", temperature=-4), WallTemperature(region="bottom", temperature=-2)]
	...     added = talik.geometry.fill(mpm, talik.geometry.rectangle(0, 0, 1, 4), temperature=temperature)
	...     return mpm
	>>> temperature = talik.thermal.spinUp(column(-1), days=3000)
	>>> round(float(temperature(0.5, 2.0)), 1)
	-3.0"""
	if not days > 0:
		raise ValueError(f"spinUp: days is {days!r}; give a number of days above 0")
	if mpm.heat is None or mpm.pointCount == 0:
		raise ValueError("spinUp: the ground has no heat or no points; give it heat=HeatTransfer() and fill it first")
	if mpm.begun:
		raise ValueError("spinUp: the ground has begun; spin up before its first step")
	rigid = _rigidCopy(mpm, boundaries)
	with talik.scratchScene():
		O.engines = [rigid]
		rigid.initialise()
		rigid.setDay(-days)
		_runUntilDay(rigid, -0.1 * days)
		before = rigid.field("temperature")
		_runUntilDay(rigid, 0)
		temperature = rigid.field("temperature")
	if told is not None:
		told.append(float(abs(temperature - before).max()))
	return _ofPlace(rigid.field("position"), temperature)


def thawDepth(mpm, width=None, isotherm=0.0):
	"""Depth of the first frozen ground below the surface, by columns: {"place", "surface", "depth"}.

	mpm       a ground with heat and points
	width     of a column [m], above 0; default: side of a point (median), so that each column of points is one
	isotherm  temperature at and below which ground counts as frozen [degC]

	place is the middle of each column, (n,) along x or, in space, (n, 2) [m]; surface the height of its upper end [m]; depth the vertical
	distance from there to the isotherm [m], linear between points: 0 where the uppermost point is frozen, nan where the whole column has thawed. Ground
	that is frozen at the surface and thawed below has depth 0.

	>>> mpm = MpmEngine(gridSpacing=0.5, lower=(0, 0), upper=(1, 4), heat=HeatTransfer(), motion=False)
	>>> added = talik.geometry.fill(mpm, talik.geometry.rectangle(0, 0, 1, 3), temperature=lambda x, y: 4 * (y - 2))
	>>> round(float(talik.thermal.thawDepth(mpm)["depth"][0]), 6)
	1.0"""
	if mpm.heat is None or mpm.pointCount == 0:
		raise ValueError("thawDepth: the ground has no heat or no points; give it heat=HeatTransfer() and fill it first")
	position, temperature, volume = mpm.field("position"), mpm.field("temperature"), mpm.field("volume")
	size = volume ** (1 / position.shape[1])
	width = np.median(size) if width is None else width
	if not width > 0:
		raise ValueError(f"thawDepth: width is {width!r}; give a width in m above 0")
	lower = np.array(tuple(mpm.lower)[: position.shape[1] - 1], dtype=float)
	origin = np.where(np.isfinite(lower), lower, position[:, :-1].min(axis=0) - 0.5 * width)
	number = np.floor((position[:, :-1] - origin) / width + 1e-9).astype(int)
	_, columnOf = np.unique(number, axis=0, return_inverse=True)
	place, surface, depth = [], [], []
	for column in range(columnOf.max() + 1):
		points = np.flatnonzero(columnOf == column)
		points = points[np.argsort(-position[points, -1])]
		height, warmth = position[points, -1], temperature[points] - isotherm
		place.append(position[points, :-1].mean(axis=0))
		surface.append(height[0] + 0.5 * size[points[0]])
		depth.append(surface[-1] - _firstFrozen(height, warmth, surface[-1]))
	place = np.array(place)
	return {"place": place[:, 0] if place.shape[1] == 1 else place, "surface": np.array(surface), "depth": np.array(depth)}


def _firstFrozen(height, warmth, surface):
	"""Height at which a column that is ordered from above becomes cold; nan if it does not."""
	cold = np.flatnonzero(warmth <= 0)
	if not len(cold):
		return np.nan
	below = cold[0]
	if below == 0:
		return surface
	share = warmth[below - 1] / (warmth[below - 1] - warmth[below])
	return height[below - 1] + share * (height[below] - height[below - 1])


def _runUntilDay(mpm, day):
	"""Up to the last whole step before a day: after it the tables of boundaries may change."""
	talik.runSerially(1)  # sets O.dt
	while (left := (day - mpm.calendar["day"]) * talik.day) > O.dt:
		talik.runSerially(int(left / O.dt))


def _rigidCopy(mpm, boundaries):
	rigid = copy.deepcopy(mpm)
	rigid.motion, rigid.water, rigid.bodies = False, None, None
	rigid.heat.followsMotion, rigid.heat.thermalTimeScale, rigid.heat.movingTimeScale = False, 1, 1
	for soil in [rigid.material, *rigid.materials]:
		soil.thawStrain = 0
	rigid.boundaries = [one for one in (mpm.boundaries if boundaries is None else boundaries) if _isThermal(one)]  # functions of Python have no copy
	return rigid


def _isThermal(boundary):
	return type(boundary).__name__ in thermalBoundaries or getattr(boundary, "gives", "") in ("heat", "temperature")


def _ofPlace(position, temperature):
	from scipy.interpolate import NearestNDInterpolator

	from talik import _interpolation

	spans = len(position) > position.shape[1] and np.ptp(position, axis=0).all()
	return (_interpolation.linear if spans else NearestNDInterpolator)(position, temperature)
