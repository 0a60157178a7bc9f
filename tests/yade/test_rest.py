# SPDX-License-Identifier: GPL-2.0-or-later
"""MpmEngine(balanceStart=True): ground of a law rests from its first step on."""

import numpy as np
import pytest
from yade import O, wrapper

import talik
from talik.geometry import rectangle


def elastic():
	return wrapper.ElasticSkeleton(young=1e7)


def frictional():
	return wrapper.MohrCoulombSkeleton(young=1e7, cohesion=1e3)


def ground(sides=("left", "right", "bottom"), law=elastic, width=1, height=2, waterTable=None, surface=None, **settings):
	"""A column of sand, dry without a water table."""
	if waterTable is None:
		settings["poreFill"] = 0
	mpm = wrapper.MpmEngine(
		gridSpacing=0.25,
		lower=(0, 0),
		upper=(width, 3),
		gravity=(0, -9.81),
		skeleton=law(),
		boundaries=[*(wrapper.RollerBoundary(region=side) for side in sides), *([surface] if surface else [])],
		**settings,
	)
	talik.layers.fill(mpm, {"sand": dict(polygon=rectangle(0, 0, width, height), porosity=0.4)}, lateralRatio=0.5, waterTable=waterTable)
	O.reset()
	O.engines = [mpm]
	return mpm


def moved(mpm):
	"""Largest change of the vertical stress in 300 steps over the weight of the ground."""
	mpm.initialise()
	before = mpm.field("stress")[:, 1]
	O.run(300, True)
	return np.abs(mpm.field("stress")[:, 1] - before).max() / (2 * 9.81 * 0.6 * 2650)


@pytest.mark.parametrize("law, weight", [(elastic, False), (elastic, True), (frictional, True)])
def test_layers_of_a_law_with_a_balanced_start_rest(law, weight):
	"""Without bBarWeight the balanced stress of the uppermost row is tension, which only an elastic law bears."""
	change = {balanced: moved(ground(law=law, balanceStart=balanced, bBarWeight=weight)) for balanced in (False, True)}
	print("change of stress over the weight:", change, "reference: 0, tolerance: 1e-6 where it is balanced")
	assert change[True] < 1e-6 < 1e-3 < change[False]


@pytest.mark.parametrize("height", [2.0, 1.9, 1.8])  # the surface between two cells, and inside one
def test_saturated_layers_with_implicit_pressure_rest_to_round_off_wherever_their_surface_cuts_cells(height):
	water = dict(bBar=True, water=wrapper.PoreWater(pressure="implicit"), surface=wrapper.DrainedBoundary(region="surface"))
	mpm = ground(width=0.5, height=height, waterTable=height, balanceStart=True, **water)
	O.run(20, True)  # pressure becomes that of cells
	pressure, stress = mpm.field("pressure"), mpm.field("stress")[:, 1]
	O.run(500, True)
	changes = [np.abs(now - before).max() / (9810 * height) for now, before in ((mpm.field("pressure"), pressure), (mpm.field("stress")[:, 1], stress))]
	print(f"height {height} m: change of pressure and of stress in 500 steps over rho g H: {changes[0]:.1e}, {changes[1]:.1e}; reference: 0, tolerance: 1e-10")
	assert max(changes) < 1e-10


def test_ground_that_nothing_holds_cannot_be_balanced():
	with pytest.raises((ValueError, RuntimeError), match="there is no stress in which this ground rests"):
		ground(sides=("left",), balanceStart=True).initialise()
