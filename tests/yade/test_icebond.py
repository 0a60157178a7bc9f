# SPDX-License-Identifier: GPL-2.0-or-later
"""The ice-bond contact law in real YADE scenes of two spheres, driven by InteractionLoop, against its closed form.

Closed form (Yu & Zhao eqs 5-7 with YADE's conventions): phi = 1-(1-S^2)^2, k_n = (E0 + dE phi) R, k_s = 0.8 k_n, strength
C = C0 + dC phi over the area R^2, shear limit C R^2 + 0.5 max(N, 0). Forces and overlaps are positive in compression."""

import json
import math
import os
import re
import subprocess
from pathlib import Path

import numpy as np
import pytest
from yade import Matrix3, O, utils, wrapper

import talik

R, E0, dE, ratio, friction, C0, dC = 5e-3, 0.6e9, 3.0e9, 0.8, 0.5, 1.0e6, 50.0e6
area = R * R
near = 1e-12  # a limit is approached to this relative distance from both sides
tolerance = 1e-10
saturations = (1.0, 0.9, 0.8, 0.7, 0.5, 0.3, 0.2, 0.1, 0.05)


def phi(s):
	return 1 - (1 - s * s) ** 2


def saturationOf(phiValue):
	return math.sqrt(1 - math.sqrt(1 - phiValue))


def stiffness(s):
	return (E0 + dE * phi(s)) * R


def strength(s):
	return C0 + dC * phi(s)


def relative(measured, expected):
	return abs(measured - expected) / abs(expected)


class Pair:
	"""Two equal spheres on the x axis; the second is moved by setting its position, sheared by spinning it."""

	def __init__(self, overlap=0.0, detection=1.0, skipping=False, **material):
		self.material = wrapper.IceBondMat(young=E0, poisson=ratio, frictionAngle=math.atan(friction), density=2650, **material)
		O.materials.append(self.material)
		O.bodies.append([utils.sphere((0, 0, 0), R, fixed=True), utils.sphere((2 * R - overlap, 0, 0), R, fixed=True)])
		self.law = wrapper.Law2_ScGeom_IceBondPhys_IceBond()
		self.contactModel = wrapper.Ip2_IceBondMat_IceBondMat_IceBondPhys()
		geometry = wrapper.Ig2_Sphere_Sphere_ScGeom(interactionDetectionFactor=detection)
		O.engines = [
			wrapper.ForceResetter(),
			wrapper.InsertionSortCollider([wrapper.Bo1_Sphere_Aabb(aabbEnlargeFactor=1.1 * detection)], verletDist=1e-5 if skipping else 0),
			wrapper.InteractionLoop([geometry], [self.contactModel], [self.law]),
			wrapper.NewtonIntegrator(damping=0.4),
		]
		O.dt = 1.0
		O.step()

	@property
	def contact(self):
		return O.interactions[0, 1] if O.interactions.has(0, 1, True) else None

	@property
	def state(self):
		return self.contact.phys.bondState if self.contact else None

	def freeze(self, s):
		"""Brings ice saturation to s with nothing moving; returns the normal force."""
		self.material.iceSaturation = s
		O.step()
		return self.normal

	def overlapTo(self, overlap):
		O.bodies[1].state.pos = (2 * R - overlap, 0, 0)
		O.step()
		return self.normal

	@property
	def overlap(self):
		return 2 * R - O.bodies[1].state.pos[0]

	def shearBy(self, displacement):
		"""Tangential displacement of the second sphere's surface; returns the size of the shear force."""
		O.bodies[1].state.angVel = (0, 0, displacement / (O.bodies[1].shape.radius * O.dt))
		O.step()
		O.bodies[1].state.angVel = (0, 0, 0)
		return self.shear

	@property
	def normal(self):
		return self.contact.phys.normalForce.dot(self.contact.geom.normal) if self.contact else 0.0

	@property
	def shear(self):
		return self.contact.phys.shearForce.norm() if self.contact else 0.0

	@property
	def forceOnSecond(self):
		"""What arrives on the body [N]."""
		return np.array(O.forces.f(1))


# --- eqs (5)-(7) -----------------------------------------------------------------------------------------------------------


def test_stiffness_follows_ice_saturation_as_eqs_6_and_7():
	pair = Pair()
	table = {0.2: 0.8352, 0.5: 1.9125, 0.8: 3.2112, 1.0: 3.6}  # closed form: E_c [GPa]
	worst = 0
	for s in sorted(saturations):
		pair.freeze(s)
		worst = max(worst, relative(pair.contact.phys.kn, stiffness(s)), relative(pair.contact.phys.ks, ratio * stiffness(s)))
		if s in table:
			worst = max(worst, relative(pair.contact.phys.kn / R, table[s] * 1e9))
	print(f"\nk_n and k_s at {len(saturations)} saturations: largest relative difference to the closed form {worst:.1e}")
	assert worst < 1e-12


@pytest.mark.parametrize("s", saturations)
def test_tension_breaks_a_bond_at_force_and_displacement_of_the_closed_form(s):
	pair = Pair()
	pair.freeze(s)
	limit = -strength(s) * area
	displacement = limit / stiffness(s)
	held = pair.overlapTo(displacement * (1 - near))
	assert pair.state == 1
	pair.overlapTo(displacement * (1 + near))
	print(f"\nS_i={s}: holds {held:.6f} N (closed form {limit:.6f}), breaks at {displacement:.6e} m +- {near:.0e}; relative {relative(held, limit):.1e}")
	assert relative(held, limit) < tolerance
	assert pair.contact is None and pair.law.brokenBonds == 1
	assert not pair.forceOnSecond.any()


def test_tension_table():
	"""Closed form: 1275 N at 70.8333 um, 571.875 N at 59.8039 um."""
	assert strength(1) * area == pytest.approx(1275, rel=1e-14) and strength(0.5) * area == pytest.approx(571.875, rel=1e-14)
	assert 1275 / stiffness(1) == pytest.approx(7.083333333333333e-05, rel=1e-14)
	assert 571.875 / stiffness(0.5) == pytest.approx(5.980392156862745e-05, rel=1e-14)


@pytest.mark.parametrize("s", saturations)
@pytest.mark.parametrize("load", [0.0, 10.0, 100.0])
def test_shear_breaks_a_bond_at_the_peak_of_the_closed_form_and_leaves_friction(s, load):
	pair = Pair(overlap=load / (E0 * R))
	assert pair.freeze(s) == pytest.approx(load, rel=tolerance, abs=tolerance)
	peak = strength(s) * area + friction * load
	displacement = peak / (ratio * stiffness(s))
	held = pair.shearBy(displacement * (1 - near))
	assert pair.state == 1
	residual = pair.shearBy(2 * near * displacement)
	print(
		f"\nS_i={s} N={load:g}: peak {held:.6f} N (closed form {peak:.6f}) at {displacement:.6e} m, residual {residual:.6f} N (closed form {friction * load:g})"
	)
	assert relative(held, peak) < tolerance
	assert pair.state == 2 and pair.law.brokenBonds == 1
	assert residual == pytest.approx(friction * load, rel=tolerance, abs=tolerance)
	assert pair.forceOnSecond[0] == pytest.approx(load, rel=tolerance, abs=tolerance)
	assert np.linalg.norm(pair.forceOnSecond[1:]) == pytest.approx(residual, rel=tolerance, abs=tolerance)


# --- melting under load ----------------------------------------------------------------------------------------------------


def holdTension(pair, force):
	"""Moves the second sphere until the bond carries `force` [N] again; the law is linear in between."""
	for _ in range(3):
		if pair.contact:
			pair.overlapTo(pair.overlap + (-force - pair.normal) / pair.contact.phys.kn)


@pytest.mark.parametrize("force, expected", [(100.0, 0.1745394755), (500.0, 0.4610848215), (1000.0, 0.7286689399)])  # closed form
def test_melting_under_constant_tension_breaks_the_bond_at_the_saturation_of_the_closed_form(force, expected):
	exact = saturationOf((force / area - C0) / dC)
	assert relative(exact, expected) < 1e-9
	pair = Pair()
	pair.freeze(1)
	holdTension(pair, force)
	for s in (0.9, 0.8, exact + 0.01, exact * (1 + 1e-11)):
		if s < exact:
			continue
		pair.freeze(s)
		holdTension(pair, force)
		assert pair.state == 1 and relative(pair.normal, -force) < 1e-12
	pair.freeze(exact * (1 - 1e-11))
	holdTension(pair, force)
	print(f"\n{force:g} N: holds at S_i = {exact * (1 + 1e-11):.12f}, breaks at {exact * (1 - 1e-11):.12f} (closed form {exact:.12f})")
	assert pair.contact is None and pair.law.brokenBonds == 1


@pytest.mark.parametrize("force, load, expected", [(500.0, 100.0, 0.4331237231), (500.0, 500.0, 0.3073458739)])  # closed form
def test_melting_under_constant_shear_breaks_the_bond_at_the_saturation_of_the_closed_form(force, load, expected):
	exact = saturationOf(((force - friction * load) / area - C0) / dC)
	assert relative(exact, expected) < 1e-9
	pair = Pair(overlap=load / (E0 * R))
	pair.freeze(1)
	for s in (1.0, 0.8, 0.6, exact * (1 + 1e-11)):
		pair.freeze(s)
		for _ in range(2):
			pair.shearBy((force - pair.shear) / pair.contact.phys.ks)
		assert pair.state == 1 and relative(pair.shear, force) < 1e-12
	pair.freeze(exact * (1 - 1e-11))
	pair.shearBy((force - pair.shear) / pair.contact.phys.ks)
	print(f"\n{force:g} N under {load:g} N: breaks at S_i = {exact:.12f} +- 1e-11 (closed form), residual {pair.shear:.9f} N")
	assert pair.state == 2 and relative(pair.shear, friction * load) < tolerance


def test_a_grain_hanging_in_its_bond_falls_at_the_saturation_of_the_closed_form():
	"""Nothing is held here: the second grain is free and pulled by 500 N while the ice melts slowly."""
	pair = Pair()
	pair.freeze(1)
	O.bodies[1].state.blockedDOFs = ""
	O.bodies[1].state.vel = O.bodies[1].state.angVel = (0, 0, 0)
	O.engines = O.engines[:3] + [wrapper.ForceEngine(force=(500, 0, 0), ids=[1]), O.engines[3]]
	O.dt = 0.2 * math.sqrt(O.bodies[1].state.mass / stiffness(1))
	talik._talik.runSerially(400)
	while pair.contact and pair.material.iceSaturation > 0.1:
		pair.material.iceSaturation -= 1e-4
		talik._talik.runSerially(5)
	exact = saturationOf((500 / area - C0) / dC)
	print(f"\nfalls at S_i = {pair.material.iceSaturation:.4f}, closed form {exact:.4f}")
	assert abs(pair.material.iceSaturation - exact) < 5e-4 and pair.law.brokenBonds == 1


def test_a_bond_breaks_at_rest_when_only_its_ice_saturation_changes():
	"""Stretched to 65 um and held there: strength falls faster than force. Closed form: (C0 + dC phi) R^2 = (E0 + dE phi) R u."""
	stretch = 65e-6
	exact = saturationOf((E0 * R * stretch - C0 * area) / (dC * area - dE * R * stretch))
	pair = Pair()
	pair.freeze(1)
	pair.overlapTo(-stretch)
	for s in (0.9, 0.8, exact * (1 + 1e-11)):
		pair.freeze(s)
		assert pair.state == 1
	pair.freeze(exact * (1 - 1e-11))
	print(f"\nbreaks at S_i = {exact:.12f} +- 1e-11 without any motion")
	assert pair.contact is None and pair.law.brokenBonds == 1


# --- stiffness -------------------------------------------------------------------------------------------------------------

# closed form: overlap 1 um before freezing, 0.5 um more at S_i = 1, then melting at fixed overlap [N]
meltTable = {1: 12, 0.9: 11.72925, 0.8: 11.028, 0.6: 8.928, 0.5: 7.78125, 0.4: 6.708, 0.2: 5.088, 0: 4.5}


def test_melting_at_fixed_overlap_drops_the_force_of_the_closed_form():
	pair = Pair(overlap=1e-6)
	pair.freeze(1)
	pair.overlapTo(1.5e-6)
	measured = {s: pair.freeze(s) for s in meltTable}
	worst = max(relative(measured[s], expected) for s, expected in meltTable.items())
	print("\n" + ", ".join(f"{s}: {force:.6f}" for s, force in measured.items()) + f" N; largest relative difference {worst:.1e}")
	assert worst < tolerance
	assert pair.state == 0


def test_freezing_a_loaded_contact_creates_no_force():
	pair = Pair(overlap=1e-6)
	pair.shearBy(0.4e-6)
	normal, shear = pair.normal, pair.shear
	for s in np.linspace(0, 1, 21):
		pair.freeze(float(s))
	print(f"\n{normal:.9f} -> {pair.normal:.9f} N, shear {shear:.9f} -> {pair.shear:.9f} N")
	assert relative(pair.normal, 3.0) < tolerance and relative(normal, 3.0) < tolerance
	assert relative(pair.shear, shear) < tolerance


def test_after_freezing_both_springs_carry_the_load_and_in_tension_the_grain_spring_is_cemented():
	pair = Pair(overlap=2e-6)
	pair.freeze(1)
	for change in (1e-6, -1e-6, -5e-6):  # compression, unloading, tension
		expected = E0 * R * 2e-6 + stiffness(1) * change
		assert relative(pair.overlapTo(2e-6 + change), expected) < tolerance


def test_ice_that_melts_and_grows_again_at_rest_lets_go_of_its_load_for_good():
	"""Closed form: 12 N at S_i=1 melt to 7.78125 N at 0.5, and new ice carries nothing."""
	pair = Pair(overlap=1e-6)
	pair.freeze(1)
	pair.overlapTo(1.5e-6)
	pair.freeze(0.5)
	assert relative(pair.freeze(1), 7.78125) < tolerance
	assert relative(pair.overlapTo(1.6e-6), 7.78125 + stiffness(1) * 1e-7) < tolerance


# --- states ----------------------------------------------------------------------------------------------------------------


def test_bonds_form_above_the_upper_and_melt_below_the_lower_saturation():
	pair = Pair(overlap=1e-6)
	history = []
	for s in (0.0, 0.04, 0.0499, 0.05, 0.03, 0.021, 0.02, 0.04, 0.06):
		pair.freeze(s)
		history.append(pair.state)
	print(f"\nstates {history}")
	assert history == [0, 0, 0, 1, 1, 1, 0, 0, 1]


def test_melting_drops_the_strength_that_remains_without_ice():
	"""Just above S_melt a bond holds more than C0 R^2 = 25 N, at S_melt nothing."""
	pair = Pair()
	pair.freeze(0.5)
	pair.freeze(0.0201)
	held = pair.overlapTo(-strength(0.0201) * area / stiffness(0.0201) * (1 - near))
	print(f"\nS_i=0.0201: {held:.6f} N (closed form {-strength(0.0201) * area:.6f}), S_i=0.02: {pair.freeze(0.02)} N")
	assert relative(held, -strength(0.0201) * area) < tolerance and abs(held) > 25
	assert pair.contact is None and pair.law.brokenBonds == 0  # melted, not broken


@pytest.mark.parametrize("heal", [False, True])
def test_a_broken_contact_stays_broken_until_melted_unless_healing_is_asked_for(heal):
	pair = Pair(overlap=1e-4)
	pair.law.healBroken = heal
	pair.freeze(1)
	pair.shearBy(1e-4)
	pair.shearBy(1e-4)
	assert pair.state == 2
	states = []
	for s in (0.04, 0.3, 0.01, 0.3):
		pair.freeze(s)
		states.append(pair.state)
	print(f"\nbroken, then S_i = 0.04, 0.3, 0.01, 0.3: states {states}")
	assert states == [2, 1 if heal else 2, 0, 1]


def test_a_broken_bond_in_compression_keeps_its_ice_until_it_opens():
	"""Closed form: grain spring and ice spring while the overlap exceeds that at freezing, the grain spring alone ever after."""
	u = 1e-4
	pair = Pair(overlap=u)
	pair.freeze(1)
	compressed = pair.overlapTo(u + 1e-6)
	assert relative(compressed, E0 * R * u + stiffness(1) * 1e-6) < tolerance
	peak = strength(1) * area + friction * compressed
	pair.shearBy(1.001 * peak / (ratio * stiffness(1)))
	assert pair.state == 2 and relative(pair.shear, friction * compressed) < tolerance
	assert relative(pair.overlapTo(u + 2e-6), E0 * R * u + stiffness(1) * 2e-6) < tolerance
	assert relative(pair.contact.phys.kn, stiffness(1)) < 1e-14
	assert relative(pair.overlapTo(u - 1e-6), E0 * R * (u - 1e-6)) < tolerance
	assert relative(pair.overlapTo(u + 1e-6), E0 * R * (u + 1e-6)) < tolerance
	assert relative(pair.contact.phys.kn, stiffness(0)) < 1e-14
	pair.overlapTo(-1e-6)
	assert pair.contact is None


def test_healing_keeps_what_the_ice_of_a_broken_bond_still_carries():
	"""Closed form: 300 N on the grains at freezing, 18 N more on both springs; melting to 0.04 leaves the ice its share of stiffness."""
	u = 1e-4
	pair = Pair(overlap=u)
	pair.law.healBroken = True
	pair.freeze(1)
	pair.overlapTo(u + 1e-6)
	pair.shearBy(1e-4)
	pair.shearBy(1e-4)
	expected = E0 * R * (u + 1e-6) + (stiffness(0.04) - stiffness(0)) * 1e-6
	assert pair.state == 2 and relative(pair.freeze(0.04), expected) < tolerance
	shear = pair.shear
	assert relative(pair.freeze(0.3), expected) < tolerance and pair.state == 1
	assert relative(pair.shear, shear) < tolerance


def test_a_contact_without_ice_is_stock_yades():
	"""Frictional contact under loading, sliding and unloading: the same forces as Law2_ScGeom_FrictPhys_CundallStrack."""

	def forces(material, contactModel, law):
		O.reset()
		O.materials.append(material)
		O.bodies.append([utils.sphere((0, 0, 0), R, fixed=True), utils.sphere((2 * R - 1e-6, 0, 0), R, fixed=True)])
		O.engines = [
			wrapper.ForceResetter(),
			wrapper.InsertionSortCollider([wrapper.Bo1_Sphere_Aabb()]),
			wrapper.InteractionLoop([wrapper.Ig2_Sphere_Sphere_ScGeom()], [contactModel], [law]),
			wrapper.NewtonIntegrator(),
		]
		O.dt = 1e-3
		result = []
		for velocity, spin in (((-1e-4, 2e-4, 0), (1e-3, 0, 2e-2)), ((1e-4, 0, 3e-4), (0, -5e-2, 0)), ((5e-4, 1e-4, 0), (0, 0, 0))):
			O.bodies[1].state.vel, O.bodies[1].state.angVel = velocity, spin
			for _ in range(10):
				O.step()
				result.append([*O.forces.f(0), *O.forces.t(0), *O.forces.f(1), *O.forces.t(1)])
		return np.array(result)

	common = dict(young=E0, poisson=ratio, frictionAngle=math.atan(friction), density=2650)
	ours = forces(wrapper.IceBondMat(**common), wrapper.Ip2_IceBondMat_IceBondMat_IceBondPhys(), wrapper.Law2_ScGeom_IceBondPhys_IceBond())
	stock = forces(wrapper.FrictMat(**common), wrapper.Ip2_FrictMat_FrictMat_FrictPhys(), wrapper.Law2_ScGeom_FrictPhys_CundallStrack())
	difference = np.abs(ours - stock).max() / np.abs(stock).max()
	print(f"\n30 steps, largest force {np.abs(stock).max():.3g} N; relative difference to stock YADE {difference:.1e}")
	assert np.abs(stock).max() > 1 and (stock[-1] == 0).all()
	assert difference < 1e-13


@pytest.mark.parametrize("gap, bonds", [(0.049, True), (0.051, False)])
def test_ice_bonds_grains_across_a_gap_free_of_stress(gap, bonds):
	pair = Pair(overlap=-gap * R, detection=1.05)
	pair.contactModel.bondNewContacts = True
	pair.freeze(1)
	assert (pair.state == 1) == bonds
	if not bonds:
		return
	assert pair.normal == 0 and not pair.forceOnSecond.any()
	for change in (2e-6, -2e-6):
		assert relative(pair.overlapTo(-gap * R + change), stiffness(1) * change) < tolerance
	limit = -strength(1) * area
	held = pair.overlapTo(-gap * R + limit / stiffness(1) * (1 - near))
	print(f"\ngap {gap} R: breaks at {held:.6f} N (closed form {limit})")
	assert relative(held, limit) < tolerance
	pair.overlapTo(-gap * R + limit / stiffness(1) * (1 + near))
	assert pair.contact is None


def test_contacts_made_in_frozen_ground_are_frictional():
	pair = Pair(overlap=-1e-6)
	pair.freeze(1)
	pair.overlapTo(1e-6)
	assert pair.state == 0 and relative(pair.normal, E0 * R * 1e-6) < tolerance


def test_of_two_different_grains_the_one_with_less_ice_and_strength_decides_whichever_comes_first():
	results = []
	for order in (1, -1):
		O.reset()
		materials = [wrapper.IceBondMat(young=E0, frictionAngle=0.4, iceTensileStrength=20e6), wrapper.IceBondMat(young=2 * E0, frictionAngle=0.6, exponent=3)]
		for m in materials[::order]:
			O.materials.append(m)
		O.bodies.append([utils.sphere((x, 0, 0), R, fixed=True, material=i) for i, x in enumerate((0, 1.99 * R))])
		O.engines = [
			wrapper.ForceResetter(),
			wrapper.InsertionSortCollider([wrapper.Bo1_Sphere_Aabb()], verletDist=0),
			wrapper.InteractionLoop(
				[wrapper.Ig2_Sphere_Sphere_ScGeom()], [wrapper.Ip2_IceBondMat_IceBondMat_IceBondPhys()], [wrapper.Law2_ScGeom_IceBondPhys_IceBond()]
			),
		]
		O.dt = 1
		O.step()
		materials[0].iceSaturation, materials[1].iceSaturation = 0.9, 0.6
		O.step()
		phys = O.interactions[0, 1].phys
		results.append((phys.kn, phys.iceSaturation, phys.tangensOfFrictionAngle))
		assert phys.iceSaturation == 0.6
	assert results[0] == results[1]


def test_bonds_of_two_materials_follow_a_parameter_that_changes_in_one_of_them():
	"""Ice over grains is the smaller ratio of the two, strength the smaller one: k_n and the load at which the bond breaks, in closed form."""
	materials = [wrapper.IceBondMat(young=E0, frictionAngle=0.4, density=2650), wrapper.IceBondMat(young=E0, frictionAngle=0.4, density=2650)]
	for material in materials:
		O.materials.append(material)
	O.bodies.append([utils.sphere((x, 0, 0), R, fixed=True, material=i) for i, x in enumerate((0, 2 * R))])
	law = wrapper.Law2_ScGeom_IceBondPhys_IceBond()
	O.engines = [
		wrapper.ForceResetter(),
		wrapper.InsertionSortCollider([wrapper.Bo1_Sphere_Aabb(aabbEnlargeFactor=1.1)], verletDist=0),
		wrapper.InteractionLoop(
			[wrapper.Ig2_Sphere_Sphere_ScGeom(interactionDetectionFactor=1.1)], [wrapper.Ip2_IceBondMat_IceBondMat_IceBondPhys(bondNewContacts=True)], [law]
		),
	]
	O.dt = 1
	for material in materials:
		material.iceSaturation = 1
	O.step()
	phys = O.interactions[0, 1].phys
	seen = [(phys.kn, (E0 + dE) * R)]
	materials[1].iceYoung = dE / 2
	O.step()
	seen.append((phys.kn, (E0 + dE / 2) * R))
	materials[0].young = 4 * E0  # an attribute of stock YADE, which tells nobody; the grain spring of a contact stays as it was made
	O.step()
	seen.append((phys.kn, E0 * R * (1 + min(dE / (4 * E0), dE / 2 / E0))))
	materials[1].iceTensileStrength = 1e6
	limit = (C0 + 1e6) * area / phys.kn
	for share in (1 - 1e-9, 1 + 1e-9):
		O.bodies[1].state.pos = (2 * R + share * limit, 0, 0)
		O.step()
		seen.append((law.brokenBonds, 0 if share < 1 else 1))
	for measured, reference in seen:
		print(f"{measured:.12g}, closed form {reference:.12g}, tolerance {tolerance}")
		assert measured == pytest.approx(reference, rel=tolerance)


def test_help_of_every_bond_parameter_gives_its_unit_its_range_and_how_two_materials_mix():
	names = [n for n in wrapper.IceBondMat().dict() if n not in wrapper.FrictMat().dict() and n not in ("iceSaturation", "hertzMindlin", "radiusRatio")]
	print(f"{len(names)} parameters: {', '.join(sorted(names))}")
	assert len(names) == 11
	for name in names:
		text = getattr(wrapper.IceBondMat, name).__doc__
		assert re.search(r"\[(Pa|-)\], (>|\d)", text) and "Of two materials the" in text, (name, text)


@pytest.mark.parametrize("attribute, value", [("iceSaturation", 1.2), ("exponent", 1.0), ("iceYoung", -1.0), ("bondSaturation", 0.01), ("bondAreaFactor", 0.0)])
def test_impossible_ice_is_refused_by_name(attribute, value):
	with pytest.raises(ValueError, match=f"IceBondMat.{attribute} is"):
		wrapper.IceBondMat(**{attribute: value})


# --- eq. (8) ---------------------------------------------------------------------------------------------------------------


def swollen(pair, **attributes):
	engine = wrapper.GrainSwelling(**attributes)
	O.engines = [engine] + O.engines
	O.step()
	return engine


@pytest.mark.parametrize("dimension, table", [(2, {0.18: 1.104315261, 0.4: 1.290994449}), (3, {0.18: 1.068387297, 0.4: 1.185631101})])  # closed form
def test_equivalent_radius_follows_eq_8(dimension, table):
	worst = 0
	for n0, full in table.items():
		for strain in (-0.02, 0.0, 0.02):
			engine = wrapper.GrainSwelling(porosity=n0, volumetricStrain=strain, dimension=dimension)
			for s in (0.0, 0.1, 0.25, 0.5, 0.75, 0.9, 1.0):
				expected = ((1 - n0 + (n0 + strain) * s) / (1 - n0)) ** (1 / dimension)
				worst = max(worst, relative(engine.equivalentRatio(s), expected))
		assert relative(wrapper.GrainSwelling(porosity=n0, dimension=dimension).equivalentRatio(1), full) < 1e-9
	print(f"\n{dimension}-D: largest relative difference {worst:.1e}")
	assert worst < 1e-12


def test_bookkeeping_reports_the_equivalent_radius_and_changes_nothing():
	pair = Pair(overlap=1e-6)
	engine = swollen(pair)
	pair.freeze(1)
	assert O.bodies[0].shape.radius == R and relative(pair.normal, 3.0) < tolerance
	assert relative(engine.equivalentRadius[0], R / math.sqrt(0.82)) < 1e-12
	pair.freeze(0)
	assert list(engine.equivalentRadius) == [R, R]


def test_swelling_with_a_reference_overlap_creates_no_force_and_leaves_no_trace():
	forces = {}
	for name in ("without", "with"):
		O.reset()
		pair = Pair(overlap=1e-6)
		swollen(pair, radiusRule="referenceOverlap" if name == "with" else "bookkeeping")
		forces[name] = []
		for s in (0.3, 0.7, 1.0, 0.8):
			forces[name].append(pair.freeze(s))
			if name == "with":
				assert relative(O.bodies[0].shape.radius / R, math.sqrt((0.82 + 0.18 * s) / 0.82)) < 1e-12
			forces[name] += [pair.overlapTo(1.2e-6), pair.shearBy(1e-8), pair.overlapTo(0.9e-6)]
		forces[name] += [pair.freeze(s) for s in (0.5, 0.1, 0.0)]
	difference = np.abs(np.array(forces["with"]) - forces["without"]).max() / max(forces["without"])
	print(f"\nradius to x {math.sqrt(1 / 0.82):.6f} and back: largest relative difference of forces {difference:.1e}, uRef {pair.contact.phys.uRef}")
	assert difference < 1e-9  # overlaps of 1 um between centres 1 cm apart
	assert O.bodies[0].shape.radius == R and O.bodies[1].shape.radius == R  # to the last bit
	assert pair.contact.phys.uRef == 0 and O.materials[0].radiusRatio == 1


def test_grains_that_swell_into_contact_touch_without_force_and_part_again():
	pair = Pair(overlap=-0.05 * R, skipping=True)
	talik._talik.runSerially(5)
	swollen(pair, radiusRule="referenceOverlap")
	talik._talik.runSerially(3)
	assert pair.contact is None
	pair.freeze(1)
	assert pair.contact is not None and pair.contact.geom.penetrationDepth > 0.1 * R
	assert pair.normal == 0 and pair.state == 0
	# stiffness and later bonds are counted with r_0
	assert relative(pair.contact.phys.grainStiffness, E0 * R) < 1e-12
	assert relative(pair.overlapTo(-0.05 * R + 1e-6), E0 * R * 1e-6) < tolerance
	# apart and back: pushes where it did before
	assert pair.overlapTo(-0.05 * R - 1e-6) == 0 and pair.contact is not None
	assert relative(pair.overlapTo(-0.05 * R + 1e-6), E0 * R * 1e-6) < tolerance
	pair.freeze(0)
	O.step()
	assert pair.contact is None and O.bodies[0].shape.radius == R


def test_mechanical_shrinkage_lowers_the_contact_force_as_the_closed_form():
	thawStrain = 0.03
	pair = Pair(overlap=2e-4, iceSaturation=1)
	engine = swollen(pair, radiusRule="mechanical", thawStrain=thawStrain)
	kg = E0 * R
	assert relative(pair.normal, kg * 2e-4) < tolerance and O.bodies[0].shape.radius == R
	worst = 0
	for s in (0.9, 0.7, 0.5):
		expected = kg * (2e-4 - 2 * R * (1 - math.sqrt(1 - thawStrain * (1 - s))))
		worst = max(worst, abs(pair.freeze(s) - max(expected, 0)) / (kg * 2e-4))
	print(f"\nthaw strain {thawStrain}: contact force {kg * 2e-4:g} N -> {pair.normal:.6f} N at S_i=0.5, relative difference {worst:.1e}")
	assert worst < tolerance and pair.normal < 0.7 * kg * 2e-4
	# refreezing gives no force, and thawing again returns to the same state
	half = pair.normal
	assert relative(pair.freeze(1), half) < 1e-9
	assert relative(pair.freeze(0.5), half) < 1e-9
	assert relative(engine.thawStrainReached, 0.5 * thawStrain) < 1e-12
	assert relative(pair.freeze(0), kg * (2e-4 - 2 * R * (1 - math.sqrt(1 - thawStrain)))) < 1e-9


@pytest.mark.parametrize("thawStrain", [0.0, 0.03, 0.18])
def test_ground_settles_by_the_thaw_strain_asked_for(thawStrain):
	"""Discs on a square lattice: with the cell smaller by the thaw strain they carry the former stress again."""
	O.periodic = True
	side, overlap = 0.04, 1e-5
	spacing = side / 4
	O.cell.hSize = Matrix3(side, 0, 0, 0, side, 0, 0, 0, 0.1)
	material = wrapper.IceBondMat(young=E0, poisson=ratio, frictionAngle=0, density=2650, iceSaturation=1)
	O.materials.append(material)
	O.bodies.append([utils.sphere(((i + 0.5) * spacing, (j + 0.5) * spacing, 0.05), 0.5 * (spacing + overlap), fixed=True) for i in range(4) for j in range(4)])
	engine = wrapper.GrainSwelling(porosity=0.18, radiusRule="mechanical", thawStrain=thawStrain)
	O.engines = [
		wrapper.ForceResetter(),
		engine,
		wrapper.InsertionSortCollider([wrapper.Bo1_Sphere_Aabb()], allowBiggerThanPeriod=True, verletDist=0),
		wrapper.InteractionLoop(
			[wrapper.Ig2_Sphere_Sphere_ScGeom()], [wrapper.Ip2_IceBondMat_IceBondMat_IceBondPhys()], [wrapper.Law2_ScGeom_IceBondPhys_IceBond()]
		),
		wrapper.NewtonIntegrator(),
	]
	O.dt = 1.0
	O.step()
	before = utils.getStress()[0, 0]
	material.iceSaturation = 0
	O.step()
	thawed = utils.getStress()[0, 0]
	shrink = math.sqrt(1 - thawStrain)
	O.cell.hSize = Matrix3(side * shrink, 0, 0, 0, side * shrink, 0, 0, 0, 0.1)
	for body in O.bodies:
		x = body.state.pos
		body.state.pos = (x[0] * shrink, x[1] * shrink, x[2])
	O.step()
	after = utils.getStress()[0, 0]
	print(
		f"\nthaw strain {thawStrain} (reached {engine.thawStrainReached:.12f}, full {engine.fullThawStrain}): stress "
		f"{before:.6f} Pa frozen, {thawed:.6f} thawed, {after:.6f} after settling"
	)
	assert before == pytest.approx(-E0 * 0.5 * (spacing + overlap) * overlap / (spacing * 0.1), rel=1e-8)
	assert (thawed == 0) == (thawStrain > 0)
	assert after == pytest.approx(before, rel=1e-8)
	assert engine.thawStrainReached == pytest.approx(thawStrain, rel=1e-12, abs=1e-15)


@pytest.mark.parametrize("attribute, value", [("radiusRule", "literal"), ("porosity", 1.0), ("thawStrain", 0.2), ("dimension", 1), ("volumetricStrain", -0.5)])
def test_impossible_swelling_is_refused_by_name(attribute, value):
	with pytest.raises(ValueError, match=f"GrainSwelling.{attribute} is"):
		wrapper.GrainSwelling(**{attribute: value})


def test_swelling_survives_saving(tmp_path):
	pair = Pair(overlap=1e-6)
	swollen(pair, radiusRule="referenceOverlap")
	pair.freeze(0.6)
	uRef, force = pair.contact.phys.uRef, pair.normal
	O.save(str(tmp_path / "swollen.yade.gz"))
	O.load(str(tmp_path / "swollen.yade.gz"))
	O.step()
	contact = O.interactions[0, 1]
	assert contact.phys.uRef == uRef and contact.phys.normalForce.norm() == force
	O.materials[0].iceSaturation = 0
	O.step()
	assert O.bodies[0].shape.radius == R and O.interactions[0, 1].phys.uRef == 0


# --- 3-D view --------------------------------------------------------------------------------------------------------------

viewScript = """
import os, sys, time
from PyQt5.QtWidgets import QApplication
from yade import O, qt, utils, wrapper
import talik

R = 5e-3
ice = IceBondMat(young=0.6e9, poisson=0.8, density=2650)
O.materials.append(ice)
O.bodies.append([utils.sphere((i * 1.99 * R, j * 1.99 * R, 0), R, fixed=True, wire=True, color=(0, 0.4, 0.8)) for i in range(4) for j in range(3)])
O.engines = [
	wrapper.ForceResetter(),
	wrapper.InsertionSortCollider([wrapper.Bo1_Sphere_Aabb()], verletDist=0),
	wrapper.InteractionLoop([wrapper.Ig2_Sphere_Sphere_ScGeom()], [Ip2_IceBondMat_IceBondMat_IceBondPhys()], [Law2_ScGeom_IceBondPhys_IceBond()]),
	wrapper.NewtonIntegrator(),
	qt.SnapshotEngine(fileBase=sys.argv[1] + "/bonds-", iterPeriod=1, dead=True, label="camera"),
]
O.dt = 1.0
O.step()
ice.iceSaturation = 1
O.step()
O.bodies[11].state.angVel = (0, 0, 0.1)
O.step()
O.bodies[11].state.angVel = (0, 0, 0)
print("STATES", sorted(i.phys.bondState for i in O.interactions))

def draw(seconds):
	end = time.monotonic() + seconds
	while time.monotonic() < end:
		QApplication.instance().processEvents()
		time.sleep(0.005)

renderer = qt.Renderer()
renderer.intrPhys, renderer.bgColor = True, (1, 1, 1)
view = qt.View()
draw(0.2)
view.axes, view.viewDir, view.upVector = False, (0, 0, -1), (0, 1, 0)
view.fitAABB((-R, -R, -R), (7 * R, 5 * R, R))
draw(0.2)
camera.dead = False
O.run(2)
end = time.monotonic() + 30
while O.running and time.monotonic() < end:
	draw(0.02)
print("SCRIPT ENDED")
sys.stdout.flush()
os._exit(0)
"""


def test_the_3d_view_shows_intact_bonds_red_and_broken_ones_black(tmp_path):
	from matplotlib import image

	script = tmp_path / "view.py"
	script.write_text(viewScript)
	command = ["xvfb-run", "-a", "-s", "-screen 0 1024x768x24", "yade", "-x", str(script), str(tmp_path)]
	run = subprocess.run(command, capture_output=True, text=True, timeout=120, env=dict(os.environ))
	assert "SCRIPT ENDED" in run.stdout, run.stdout + run.stderr
	states = re.search(r"STATES (.*)", run.stdout).group(1)
	picture = np.rint(255 * image.imread(sorted(tmp_path.glob("bonds-*.png"))[-1])[..., :3]).astype(int)
	red = int((np.abs(picture - (230, 0, 0)).max(axis=-1) < 3).sum())
	black = int((picture.max(axis=-1) < 3).sum())
	print(f"\nbonds {states}: {red} red and {black} black pixels of {picture.shape[0] * picture.shape[1]}")
	assert states == str([1] * 15 + [2] * 2)
	assert red > 2000 and black > 200 and red > black


def test_the_melting_column_of_the_examples_tears_at_the_saturation_of_the_closed_form(tmp_path):
	example = Path(__file__).resolve().parents[2] / "examples" / "melting_column.py"
	command = ["yade", "-n", "-x", str(example), "--preset", "test", "--output", str(tmp_path)]
	run = subprocess.run(command, capture_output=True, text=True, timeout=120, env=dict(os.environ))
	assert (tmp_path / "summary.json").exists() and (tmp_path / "melting_column.png").stat().st_size > 10000, run.stdout + run.stderr
	summary = json.loads((tmp_path / "summary.json").read_text())
	print(f"\n{summary}")
	assert abs(summary["S_i at failure"] - summary["S_i closed form"]) < 2e-3
	assert summary["bonds"] == 44 and summary["bonds intact at the end"] == 40  # the four bonds of the warmest row
