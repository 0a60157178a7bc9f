# SPDX-License-Identifier: GPL-2.0-or-later
"""Grains of Hertz and Mindlin, against closed forms and stock YADE's own law."""

import math

import numpy as np
import pytest
from fixtures import eightySpheres, ofDimension
from yade import Matrix3, O, Vector3, utils, wrapper

import talik
from talik import packing, rve

young, poisson, friction = 2e10, 0.2, 0.5
hertz = dict(young=young, poisson=poisson, frictionAngle=math.atan(friction), density=2650)
gradient = {2: Matrix3(0.6, 1.0, 0, -0.5, -1.0, 0, 0, 0, 0), 3: Matrix3(0.5, 0.9, 0.3, -0.4, -0.8, 0.2, 0.1, 0.3, -0.4)}


def relative(a, b):
	return np.abs(np.subtract(a, b)).max() / np.abs(b).max()


def loop(stock):
	if stock:
		functors = [wrapper.Ip2_FrictMat_FrictMat_MindlinPhys()], [wrapper.Law2_ScGeom_MindlinPhys_Mindlin()]
	else:
		functors = [wrapper.Ip2_IceBondMat_IceBondMat_IceBondPhys()], [wrapper.Law2_ScGeom_IceBondPhys_IceBond()]
	return wrapper.InteractionLoop([wrapper.Ig2_Sphere_Sphere_ScGeom()], *functors)


def pair(stock, second=(young, poisson), radii=(1e-2, 1.4e-2), overlap=1e-6):
	"""Two spheres on the x axis in stock YADE's law or Talik's; the second one is moved."""
	O.reset()
	for youngOf, poissonOf in ((young, poisson), second):
		material = {**hertz, "young": youngOf, "poisson": poissonOf}
		O.materials.append(wrapper.FrictMat(**material) if stock else wrapper.IceBondMat(**material, hertzMindlin=True))
	O.bodies.append(utils.sphere((0, 0, 0), radii[0], fixed=True, material=O.materials[0]))
	O.bodies.append(utils.sphere((sum(radii) - overlap, 0, 0), radii[1], fixed=True, material=O.materials[1]))
	O.engines = [wrapper.ForceResetter(), wrapper.InsertionSortCollider([wrapper.Bo1_Sphere_Aabb()]), loop(stock), wrapper.NewtonIntegrator(damping=0)]
	O.dt = 1e-6


def follow(path):
	"""Forces on the second grain [N] after each piece (velocity [m/s], spin [rad/s], steps)."""
	forces = []
	for velocity, spin, steps in path:
		O.bodies[1].state.vel, O.bodies[1].state.angVel = velocity, spin
		for _ in range(steps):
			O.step()
			forces.append((*O.interactions[0, 1].phys.normalForce, *O.interactions[0, 1].phys.shearForce))
	return np.array(forces)


def test_normal_force_is_4_3_E_sqrt_R_u_1_5_and_stiffnesses_are_its_tangents():
	radii = (1e-2, 1.4e-2)
	effective, radius = young / (2 * (1 - poisson**2)), radii[0] * radii[1] / sum(radii)
	shear = young / (2 * (1 + poisson)) / (2 * (2 - poisson))
	for overlap in (1e-7, 1e-6, 1e-5):
		pair(False, overlap=overlap)
		O.step()
		phys = O.interactions[0, 1].phys
		found = phys.normalForce[0], phys.kn, phys.ks
		wanted = (
			4 / 3 * effective * math.sqrt(radius) * overlap**1.5,
			2 * effective * math.sqrt(radius * overlap),
			8 * shear * math.sqrt(radius * overlap),
		)
		print(f"\noverlap {overlap:g} m: F_n {found[0]:.6e} N, k_n {found[1]:.6e}, k_s {found[2]:.6e} N/m; off by {relative(found, wanted):.1e}", end="")
		for value, expected in zip(found, wanted):
			assert value == pytest.approx(expected, rel=1e-9)


@pytest.mark.parametrize("second", [(young, poisson), (5e9, 0.35)], ids=["one material", "two materials"])
def test_forces_are_those_of_stock_yades_mindlin_law_on_one_path_to_round_off(second):
	path = [
		((-0.01, 0, 0), (0, 0, 0), 100),
		((0, 2e-4, 0), (0, 0, 0), 200),
		((-0.005, -3e-4, 1e-4), (0, 0.02, 0.03), 200),
		((0.004, 5e-3, 0), (0, 0, 0), 200),
		((0.002, -4e-4, 2e-4), (0.1, 0, 0), 300),
	]
	forces = []
	for stock in (True, False):
		pair(stock, second)
		forces.append(follow(path))
	error, slides = relative(forces[1], forces[0]), np.linalg.norm(forces[0][:, 3:], axis=1) / (friction * np.linalg.norm(forces[0][:, :3], axis=1))
	print(
		f"\n{len(forces[0])} steps: forces up to {np.abs(forces[0]).max():.3f} N differ by {error:.1e}; at the limit in {100 * np.mean(slides > 0.999):.0f} %"
	)
	assert error < 1e-12 and 0.05 < np.mean(slides > 0.999) < 0.95


def test_a_contact_with_a_material_of_linear_springs_is_linear():
	pair(False)
	O.materials[1].hertzMindlin = False
	O.step()
	phys = O.interactions[0, 1].phys
	assert phys.kno == 0 and phys.kn == phys.grainStiffness


@pytest.mark.parametrize("value", [-0.1, 0.5, math.nan])
def test_poissons_ratio_that_no_grain_has_is_refused_with_its_remedy(value):
	with pytest.raises(ValueError, match="IceBondMat.poisson is .*Poisson's ratio of the grains"):
		wrapper.IceBondMat(hertzMindlin=True, poisson=value)
	with pytest.raises(ValueError, match="poisson is .*Poisson's ratio"):
		rve.prepare(poisson=value)


def hertzian(parameters, cache, **material):
	"""A prepared sample, at rest again after its grains became those of Hertz and Mindlin."""
	scene = rve.openScene(rve.prepare(**parameters, cache=cache))
	with talik.inspect(scene):
		kind = wrapper.RollingIceBondMat if material else wrapper.IceBondMat
		grain = kind(**hertz, **material, hertzMindlin=True)
		for body in O.bodies:
			body.material = grain
		O.interactions.clear()
		O.dt = O.dt / 2
		talik.runSerially(2000)
	return rve.pack(scene)


@pytest.mark.parametrize(
	"dimension, material",
	[(3, dict(etaRoll=0.1)), (3, {}), (2, dict(etaRoll=0.1)), (2, {})],
	ids=["spheres that resist rolling", "spheres_slow", "discs that resist rolling_slow", "discs_slow"],
)
def test_opened_samples_go_on_as_packed_with_ice_and_without_and_come_back_to_the_last_bit(dimension, material, sampleCache):
	sample = hertzian(ofDimension[dimension], sampleCache, **material)
	for ice in (0.0, 0.5):
		if ice > 0:
			sample.freeze(ice)
		sample.advance(0.3 * gradient[dimension], 200)
		before, scene = sample.stateBytes, sample.open()
		sample.repack(scene)
		assert sample.stateBytes == before
		with talik.inspect(scene):
			O.cell.velGrad = 0.3 * gradient[dimension]
			talik.runSerially(200)
			sample.advance(0.3 * gradient[dimension], 200)
			error = relative(sample.stress, packing.stress())
			print(f"\nS_i {ice:g}: 200 steps of the opened scene, stress differs by {error:.1e}; {sample.statistics()['bondsIntact']} bonds", end="")
			assert error < 1e-9


def test_packed_grains_follow_stock_yades_mindlin_law_over_500_steps_slow(sampleCache):
	sample = hertzian(ofDimension[3], sampleCache)
	scene = sample.open()
	with talik.inspect(scene):
		for body in O.bodies:
			body.state.vel = body.state.angVel = Vector3.Zero
		packed = wrapper.RveSample.fromScene(scene)
		grain = wrapper.FrictMat(**hertz)
		contacts = {(i.id1, i.id2): i.phys.shearForce for i in O.interactions if i.isReal}
		for body in O.bodies:
			body.material = grain
		O.interactions.clear()
		O.engines = [loop(True) if isinstance(engine, wrapper.InteractionLoop) else engine for engine in O.engines]
		dt, O.dt = O.dt, 1e-30  # contacts come into being
		O.step()
		for ids, force in contacts.items():
			O.interactions[ids].phys.shearForce = force
			O.interactions[ids].phys.shearElastic = force
		O.dt = dt
		O.cell.velGrad = gradient[3]
		O.run(500, True)
		packed.advance(gradient[3], 500)
		error = relative(packed.stress, packing.stress())
		print(f"\n500 steps: stress differs from stock YADE's by {error:.1e}")
		assert error < 1e-9


def test_bulk_stiffness_grows_with_the_pressure_to_the_power_of_a_third_or_more_slow(sampleCache):
	exponents = {}
	for name, sample in dict(linear=rve.pack(rve.prepare(**eightySpheres, cache=sampleCache)), hertz=hertzian(eightySpheres, sampleCache)).items():
		pressures, moduli = np.array([25e3, 50e3, 100e3, 200e3, 400e3]), []
		for pressure in pressures:
			assert sample.servo(-pressure, -pressure, -pressure)
			probe, strain = sample.copy(), 2e-5
			probe.apply(-strain * Matrix3.Identity, 0.0)
			moduli.append((np.mean(sample.stress[:3]) - np.mean(probe.stress[:3])) / (3 * strain))
		exponents[name] = np.polyfit(np.log(pressures), np.log(moduli), 1)[0]
		print(f"\n{name}: K {np.array2string(1e-6 * np.array(moduli), precision=1)} MPa, to the power of {exponents[name]:.3f} of the pressure", end="")
	assert exponents["hertz"] >= 0.33 > exponents["linear"]
