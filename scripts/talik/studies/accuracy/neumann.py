# SPDX-License-Identifier: GPL-2.0-or-later
"""Thaw front in rigid ground against Neumann's closed form."""

import math

import numpy as np
from yade import O, wrapper

import talik
from talik.studies.accuracy.problem import Problem, Stopwatch, groundRun, rootMeanSquare

day = 86400.0
porosity = 0.4
solid = (2650.0, 800.0, 1.0)  # density [kg/m3], specific heat [J/(kg K)], conductivity [W/(m K)]: Yu & Zhao section 3
ice = (910.0, 2060.0, 2.2)
liquid = (1000.0, 4200.0, 0.6)
latentHeat = 334e3  # [J/kg]
surface, initial = 10.0, -5.0  # [degC]
front = 0.2  # depth that the front reaches [m]
instants = 40


def neumannFront(surface, initial, fullPores=False):
	"""X/sqrt(t) [m/s^0.5] of ground at `initial` < 0 that thaws from a wall at `surface` > 0 [degC]; all pore water is ice first.

	fullPores  True: thawed pores are full of water, eq. (4) of Yu & Zhao; False: they hold the mass that the ice had"""
	density, heat, conduction = (np.array(values) for values in zip(solid, ice, liquid))
	thawedPart = np.array([1 - porosity, 0, porosity * (1 if fullPores else ice[0] / liquid[0])])
	frozenPart = np.array([1 - porosity, porosity, 0])
	thawedCapacity, frozenCapacity = ((part * density * heat).sum() for part in (thawedPart, frozenPart))
	thawedConduction, frozenConduction = (1 - porosity) * solid[2] + porosity * liquid[2], (frozenPart * conduction).sum()
	thawed, frozen = thawedConduction / thawedCapacity, frozenConduction / frozenCapacity  # diffusivities [m2/s]
	latent = porosity * ice[0] * latentHeat

	def missing(front):
		"""Heat that arrives at the front less what leaves it and what melts; falls as the front runs faster."""
		a, b = front / (2 * math.sqrt(thawed)), front / (2 * math.sqrt(frozen))
		arriving = thawedConduction * surface * math.exp(-a * a) / (math.sqrt(math.pi * thawed) * math.erf(a))
		leaving = frozenConduction * -initial * math.exp(-b * b) / (math.sqrt(math.pi * frozen) * math.erfc(b))
		return arriving - leaving - latent * front / 2

	low, high = 1e-8, 20 * math.sqrt(frozen)
	for _ in range(200):
		middle = 0.5 * (low + high)
		low, high = (middle, high) if missing(middle) > 0 else (low, middle)
	return 0.5 * (low + high)


def thawingColumn(spacing, pointsPerCell, heatFraction, thermalTimeScale):
	"""Rigid column that thaws from its base, deep enough for its far end not to be felt (ten fronts)."""
	height = spacing * math.ceil(10 * front / spacing - 1e-9)
	mpm = wrapper.MpmEngine(
		gridSpacing=spacing,
		lower=(0, 0),
		upper=(spacing, height),
		motion=False,
		heatFraction=heatFraction,
		material=wrapper.GroundMaterial(solidExpansivity=0, iceExpansivity=0, liquidExpansivity=0),
		heat=wrapper.HeatTransfer(thermalTimeScale=thermalTimeScale),
		freezing=wrapper.FreezingCurve(curve="sharp", residualSaturation=0),
		boundaries=[wrapper.WallTemperature(region="bottom", temperature=surface)],
	)
	talik.geometry.fill(mpm, talik.geometry.rectangle(0, 0, spacing, height), pointsPerCell=pointsPerCell, porosity=porosity, temperature=initial)
	return mpm


def run(settings):
	mpm = thawingColumn(front / settings["cells"], settings["points per cell"], settings["time-step fraction"], settings["thermal time scale"])
	O.engines = [mpm]
	mpm.initialise()
	rate, watch, answer = neumannFront(surface, initial) * math.sqrt(settings["thermal time scale"]), Stopwatch(), []
	for instant in np.linspace(0.5, 1, instants) * (front / rate) ** 2:
		with watch:
			while O.time < instant:
				O.step()
		thawed = np.sum((1 - mpm.field("iceSaturation")) * mpm.field("volume")) / mpm.gridSpacing
		answer.append(thawed / (rate * math.sqrt(mpm.time)))
	return groundRun(mpm, answer, watch, O.iter)


problem = Problem(
	name="Neumann thaw",
	title="Thaw from a wall, -5 °C to +10 °C, rigid ground",
	norm="rms over 40 instants of front depth over Neumann's, less 1",
	reference="Neumann (Carslaw & Jaeger 1959)",
	standard={"cells": 16, "points per cell": 4, "time-step fraction": 0.9, "thermal time scale": 1.0},
	sweeps={"cells": (64,), "points per cell": (1, 9, 16), "time-step fraction": (0.2, 0.1), "thermal time scale": (8.64e5,)},
	quick={"cells": (2, 4, 8, 16, 32), "points per cell": (1, 9), "time-step fraction": (0.4,), "thermal time scale": (8.64e5,)},
	pairs=(("cells", "points per cell"),),
	run=run,
	error=rootMeanSquare,
	exact=lambda: np.ones(instants),
)
