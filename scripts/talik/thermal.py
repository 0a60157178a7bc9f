# SPDX-License-Identifier: GPL-2.0-or-later
"""Thermal spin-up: temperatures that the ground has come to before it moves.

	def ground(temperature):
		mpm = MpmEngine(...)
		talik.geometry.fill(mpm, outline, temperature=temperature)
		return mpm

	temperature = talik.thermal.spinUp(ground(-2), days=3650)
	mpm = ground(temperature)                                    # moves, and starts with the temperatures of ten years at rest
"""

import copy

import numpy as np

import talik
from yade import O

thermalBoundaries = ("SurfaceTemperature", "WallTemperature", "HeatFlux", "HeatSource", "InsulatedBoundary")


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
