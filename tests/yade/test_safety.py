# SPDX-License-Identifier: GPL-2.0-or-later
"""Factors of safety of published slopes: by reduced strength, by Bishop's circles, by the infinite slope; and of columns of one."""

import math

import numpy as np
import pytest
from scipy.optimize import brentq
from yade import O, wrapper

import talik

# outline [m], friction angle [degrees], cohesion [Pa], unit weight [N/m3]
griffithsLane1 = ([(0, 0), (32, 0), (12, 10), (0, 10)], 20, 10e3, 20e3)  # Griffiths & Lane 1999, example 1: 2:1, c/(gamma H) = 0.05
acads1a = ([(20, 20), (70, 20), (70, 25), (50, 25), (30, 35), (20, 35)], 19.6, 3e3, 20e3)  # Giam & Donald 1989, slope 1(a), mirrored; F = 1.00


def bank(slope, h, perCell=4, ru=None):
	"""A homogeneous slope with the strength in tension that its cone has."""
	outline, phi, c, weight = slope
	corners = np.array(outline)
	lower, upper = corners.min(axis=0), corners.max(axis=0)
	cone = c / math.tan(math.radians(phi))
	water = {} if ru is None else dict(water=wrapper.PoreWater())
	grains = weight / 9.81 / 0.6 if ru is None else (weight / 9.81 - 400) / 0.6
	held = (corners[:, 0] == upper[0]).sum() > 1  # the ground goes on to the right
	sides = ["left", "right"] if held else ["left"]
	mpm = wrapper.MpmEngine(
		gridSpacing=h,
		lower=lower.tolist(),
		upper=(float(upper[0]) + (0 if held else 2 * h), float(lower[1]) + h * math.ceil((upper[1] - lower[1]) / h + 2)),
		gravity=(0, -9.81),
		material=wrapper.GroundMaterial(solidDensity=grains),
		skeleton=wrapper.MohrCoulombSkeleton(young=1e7, cohesion=c, frictionAngle=phi, tensileStrength=cone),
		boundaries=[*(wrapper.RollerBoundary(region=side) for side in sides), wrapper.FixedBoundary(region="bottom")],
		**water,
	)
	soil = dict(polygon=outline, porosity=0.4)
	if ru is not None:
		soil["pressure"] = lambda x, y: ru * weight * (np.interp(x, [0, 12, 32], [10, 10, 0]) - y)
	talik.layers.fill(mpm, {"soil": soil}, lateralRatio=0.5, pointsPerCell=perCell)
	return mpm


def off(name, found, reference, tolerance):
	print(f"{name}: {found}; reference {reference}, off by {100 * (found.factor / reference - 1):+.1f} %, tolerance {100 * tolerance:.0f} %")
	return abs(found.factor / reference - 1) < tolerance


def test_reduced_strength_finds_the_factor_of_griffiths_and_lane_with_ten_cells_over_the_height():
	mpm = bank(griffithsLane1, h=1.0)
	O.engines = [mpm]
	found = talik.slope.factorOfSafety(mpm, between=(0.7, 2.0), accuracy=0.015)
	assert off("900 points", found, 1.4, 0.03)
	assert O.engines == [mpm] and not mpm.begun
	moved = found.frame["displacement"]
	print(f"at failure {np.linalg.norm(moved, axis=1).max():.2f} m; {sum(t.stands for t in found.trials)} of {len(found.trials)} trials stood")
	toe = found.frame["position"][:, 0] > 25
	assert moved[toe, 0].mean() > 5 * abs(moved[found.frame["position"][:, 0] < 5]).mean()  # the mechanism leaves by the toe


def test_reduced_strength_finds_the_factor_of_griffiths_and_lane_with_twenty_cells_over_the_height_slow():
	mpm = bank(griffithsLane1, h=0.5)
	found = talik.slope.factorOfSafety(mpm, between=(0.7, 2.0), accuracy=0.005)
	assert off(f"{mpm.pointCount} points", found, 1.4, 0.03)


def test_reduced_strength_finds_the_factor_of_acads_1a_with_ten_cells_over_the_height():
	mpm = bank(acads1a, h=1.0)
	found = talik.slope.factorOfSafety(mpm, between=(0.7, 1.4), accuracy=0.02)
	assert off(f"{mpm.pointCount} points", found, 1.0, 0.03)
	moved, place = np.linalg.norm(found.frame["displacement"], axis=1), found.frame["position"]
	assert place[moved > 0.5 * moved.max(), 0].max() < 53  # the mechanism leaves by the toe, which is at 50 m


def test_reduced_strength_finds_the_factor_of_acads_1a_with_twenty_cells_over_the_height_slow():
	mpm = bank(acads1a, h=0.5)
	found = talik.slope.factorOfSafety(mpm, between=(0.7, 1.4), accuracy=0.005)
	assert off(f"{mpm.pointCount} points", found, 1.0, 0.03)


def test_reduced_strength_with_pore_pressure_agrees_with_bishop_slow():
	"""The pressure is held: it is that of the state, whatever the stiffness of the soil."""
	outline, phi, c, weight = griffithsLane1
	for ru in (0.2, 0.3):
		circle = talik.slope.bishop(outline, phi, c, weight, ru=ru)
		found = talik.slope.factorOfSafety(bank(griffithsLane1, 1.0, ru=ru), between=(0.7, 2.0))
		assert off(f"r_u = {ru}", found, circle.factor, 0.03)


def test_circles_of_bishop_have_the_published_factors():
	outline, phi, c, weight = griffithsLane1
	found = {ru: talik.slope.bishop(outline, phi, c, weight, ru=ru).factor for ru in (0.0, 0.2)}
	acads = talik.slope.bishop(*acads1a).factor
	print(f"2:1, c/(gamma H) 0.05: {found[0.0]:.3f}, Bishop & Morgenstern 1.380; with r_u = 0.2 {found[0.2]:.3f}; ACADS 1(a) {acads:.3f}, Bishop there 0.993")
	assert found[0.0] == pytest.approx(1.380, rel=0.01) and acads == pytest.approx(0.993, rel=0.015)


def test_circles_meet_layers_pressure_and_a_frozen_base_as_functions():
	outline, phi, c, weight = griffithsLane1
	same = talik.slope.bishop(outline, lambda x, y: phi + 0 * x, lambda x, y: c + 0 * x, weight, pressure=lambda x, y: 0 * x)
	shallow = talik.slope.bishop(outline, phi, c, weight, deepest=lambda x: np.interp(x, [0, 12, 32], [10, 10, 0]) - 1.5)
	print(f"functions {same.factor:.4f}, numbers {talik.slope.bishop(outline, phi, c, weight).factor:.4f}; thawed to 1.5 m {shallow.factor:.3f}")
	assert same.factor == pytest.approx(talik.slope.bishop(outline, phi, c, weight).factor, rel=1e-6)
	infinite = talik.slope.infiniteSlope(math.degrees(math.atan(0.5)), 1.5, phi, c, weight)
	print(f"infinite slope of 1.5 m {infinite:.3f}")
	assert infinite < shallow.factor < 1.6 * infinite and (shallow.arc()[:, 1] > -1e-6).all()


def test_ground_that_cannot_be_judged_is_refused_with_a_remedy(draftSample):
	outline = talik.geometry.rectangle(0, 0, 2, 1)
	for skeleton, told in (
		(wrapper.RveSkeleton(samples=[talik.rve.pack(draftSample)]), "stands in for it"),
		(wrapper.ElasticSkeleton(), "no law of the ground"),
	):
		mpm = wrapper.MpmEngine(gridSpacing=0.5, gravity=(0, -9.81), skeleton=skeleton, boundaries=[wrapper.FixedBoundary(region="bottom")])
		talik.geometry.fill(mpm, outline)
		with pytest.raises(ValueError, match=told):
			talik.slope.factorOfSafety(mpm)


def test_ground_that_stands_in_every_trial_has_a_factor_above_the_largest_and_a_picture(tmp_path):
	level = wrapper.MpmEngine(gridSpacing=0.5, lower=(0, 0), upper=(2, 2), gravity=(0, -9.81), skeleton=wrapper.MohrCoulombSkeleton(young=1e8))
	level.boundaries = [*(wrapper.RollerBoundary(region=side) for side in ("left", "right")), wrapper.FixedBoundary(region="bottom")]
	talik.layers.fill(level, {"soil": dict(polygon=talik.geometry.rectangle(0, 0, 2, 1))}, lateralRatio=0.5)
	found = talik.slope.factorOfSafety(level, between=(0.5, 3))
	print(found)
	assert found.bracket == (3, math.inf) and found.factor == 3 and str(found).startswith("factor of safety above 3.00")
	talik.plots.save(found.draw(), tmp_path / "level.png")


def test_the_infinite_slope_counts_pore_pressure_ratio_and_excess_pressure_as_by_hand():
	angle, depth, phi, c, weight = 18.0, 1.2, 28.0, 1500.0, 18e3
	b, f = math.radians(angle), math.tan(math.radians(phi))
	excess = talik.safety.excessPressure(depth, consolidationRatio=0.7, buoyantWeight=8e3)
	byHand = (c + (weight * depth - 9810 * depth - excess) * math.cos(b) ** 2 * f) / (weight * depth * math.sin(b) * math.cos(b))
	found = talik.slope.infiniteSlope(angle, depth, phi, c, weight, waterDepth=0, excessPressure=excess)
	ratio = talik.slope.infiniteSlope(angle, depth, phi, c, weight, ru=0.25)
	ratioByHand = (c + weight * depth * (math.cos(b) ** 2 - 0.25) * f) / (weight * depth * math.sin(b) * math.cos(b))
	print(f"excess {excess:.0f} Pa: {found:.4f}, by hand {byHand:.4f}; r_u = 0.25: {ratio:.4f}, by hand {ratioByHand:.4f}")
	assert found == pytest.approx(byHand, rel=1e-12) and ratio == pytest.approx(ratioByHand, rel=1e-12)
	assert excess == pytest.approx(8e3 * depth / (1 + 1 / (2 * 0.49)), rel=1e-12)
	with pytest.raises(ValueError, match="ru is -0.1; give a ratio"):
		talik.slope.infiniteSlope(angle, depth, phi, ru=-0.1)


@pytest.mark.parametrize("pores", ["dry", "seepage", "drained", "thaw"])
def test_a_column_of_an_infinite_slope_has_the_factor_of_shear_without_dilation(pores):
	"""Two metres of thawed ground, dry, with seepage along the slope, with PoreWater that has drained, and with the excess pressure of thaw at a consolidation
	ratio of 0.5 (McRoberts and Morgenstern 1974), with twice the cells: half the strength is left, and the same error is twice the part of it. A layer that
	shears without dilation, with equal normal stresses along and across it, yields at sigma' sin(phi) + c cos(phi) (Davis 1968), below the textbook's
	sigma' tan(phi) + c. A quarter of the lowest of eight cells does not slide: 3 %.
	"""
	wet = pores in ("seepage", "thaw")
	angle, phi, c, thickness, h = 20.0, 30.0, 4e3, 2.0, 0.125 if pores == "thaw" else 0.25
	mpm = wrapper.MpmEngine(
		gridSpacing=h,
		skeleton=wrapper.MohrCoulombSkeleton(young=2e7, frictionAngle=phi, cohesion=c, tensileStrength=c / math.tan(math.radians(phi))),
		**(dict(poreFill=0) if pores == "dry" else dict(water=wrapper.PoreWater(conductivity=1e-9))),
	)
	silt = dict(thickness=thickness, porosity=0.4, **(dict(poreFill=0.01) if pores == "drained" else {}))
	weight = (0.6 * 2650 + 0.4 * 1000 * wet) * 9.81
	across, along = math.cos(math.radians(angle)), math.sin(math.radians(angle))
	atFront = talik.safety.excessPressure(thickness / across, 0.5, weight - 9810) if pores == "thaw" else 0.0  # in level ground
	excess = atFront * across**2 / thickness  # linear over the depth, per metre across the slope
	if pores == "thaw":
		silt["pressure"] = lambda x, y: (9810 * across + excess) * (thickness - y)
		silt["stress"] = lambda x, y: np.outer(thickness - y, [(excess - (weight - 9810) * across)] * 3 + [weight * along])
	talik.slope.infiniteColumn(mpm, angle, {"silt": silt}, **(dict(waterDepth=0.0) if wet else {}))

	def left(factor):
		friction = math.atan(math.tan(math.radians(phi)) / factor)
		return ((weight - 9810 * wet) * across - excess) * thickness * math.sin(friction) + c / factor * math.cos(friction) - weight * thickness * along

	reference = brentq(left, 0.3, 4)
	textbook = talik.slope.infiniteSlope(angle, thickness / across, phi, c, weight, waterDepth=0.0 if wet else math.inf, excessPressure=atFront)
	found = talik.slope.factorOfSafety(mpm, accuracy=0.02)
	print(f"the textbook's infinite slope: {textbook:.3f}")
	assert off(pores, found, reference, 0.05)
