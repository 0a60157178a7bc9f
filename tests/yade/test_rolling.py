# SPDX-License-Identifier: GPL-2.0-or-later
"""Grains that resist rolling on each other, against stock YADE's law of moments and closed forms."""

import math

import numpy as np
import pytest
from fixtures import ofDimension
from yade import Matrix3, O, Vector3, utils, wrapper

import talik
from stock_moments import openStock
from talik import packing, rve
from talik.studies import calibrate

alphaKr, etaRoll, friction, ratio, young = 1.5, 0.2, 0.5, 0.8, 0.6e9
gradient = {2: Matrix3(0.6, 1.0, 0, -0.5, -1.0, 0, 0, 0, 0), 3: Matrix3(0.5, 0.9, 0.3, -0.4, -0.8, 0.2, 0.1, 0.3, -0.4)}


@pytest.fixture(params=ofDimension.values(), ids=["discs", "spheres"])
def rough(request, sampleCache):
	"""A prepared sample, at rest again after its grains became rough."""
	scene = rve.openScene(rve.prepare(**request.param, cache=sampleCache))
	with talik.inspect(scene):
		material = wrapper.RollingIceBondMat(young=young, poisson=ratio, frictionAngle=math.atan(friction), density=2650, etaRoll=etaRoll, alphaKr=alphaKr)
		for body in O.bodies:
			body.material = material
		O.interactions.clear()
		O.dt = O.dt / 2
		talik.runSerially(2000)
	return rve.pack(scene)


def stockScene(scene):
	"""Grains and contacts of a scene in stock YADE's own law, at rest."""

	def contactOf(i):
		return dict(shearForce=i.phys.shearForce, moment_bending=i.phys.moment_bending)

	grain = dict(young=young, poisson=ratio, frictionAngle=math.atan(friction), normalCohesion=0, shearCohesion=0)
	openStock(scene, contactOf, alphaKr=alphaKr, etaRoll=etaRoll, alphaKtw=0, etaTwist=0, **grain)


def relative(a, b):
	return np.abs(np.subtract(a, b)).max() / np.abs(b).max()


def test_packed_grains_that_resist_rolling_follow_stock_yades_law_of_moments_to_1e9_over_500_steps(rough):
	scene = rough.open()
	with talik.inspect(scene):
		for body in O.bodies:
			body.state.vel = body.state.angVel = Vector3.Zero
	packed, velGrad, done = wrapper.RveSample.fromScene(scene), gradient[rough.dimension], 0
	stockScene(scene)
	O.cell.velGrad = velGrad
	for steps, most in ((1, 1e-12), (100, 1e-9), (500, 1e-9)):
		talik.runSerially(steps - done)
		packed.advance(velGrad, steps - done)
		done = steps
		error = relative(packed.stress, packing.stress())
		contacts = [i.phys for i in O.interactions if i.isReal]
		used = np.array([p.moment_bending.norm() / (p.maxRollPl * p.normalForce.norm()) for p in contacts if p.normalForce.norm() > 0])
		print(f"\n{steps} steps: stress differs by {error:.1e}; moments at their limit in {100 * np.mean(used > 0.999):.0f} % of the contacts", end="")
		assert error < most
	assert 0.1 < np.mean(used > 0.999) < 0.9, "both branches of the law are passed through"


def test_opened_samples_with_bonds_that_resist_rolling_go_on_as_packed_to_1e9_over_500_steps_and_come_back_to_the_last_bit(rough):
	"""At 1.5e-6 of strain a step and less: stock YADE lets the shear forces of discs grow by half the square of their turn (test_ice_strength.py)."""
	rough.freeze(0.5)
	rough.advance(gradient[rough.dimension], 200)
	before, scene = rough.stateBytes, rough.open()
	rough.repack(scene)
	assert rough.stateBytes == before
	velGrad, stress = 0.3 * gradient[rough.dimension], np.array(rough.stress)
	with talik.inspect(scene):
		strain = 0.3 * O.dt
		O.cell.velGrad = velGrad
		talik.runSerially(500)
		rough.advance(velGrad, 500)
		error, change = relative(rough.stress, packing.stress()), relative(stress, rough.stress)
		print(
			f"\n500 steps of the opened scene, {strain:.1e} of strain each: stress differs by {error:.1e}, has changed by {change:.1e}; "
			f"{rough.statistics()['bondsIntact']} bonds"
		)
		assert strain < 1.5e-6 and error < 1e-9 < 1e-2 < change


class Pair:
	"""Two spheres on the x axis, the second of them spun."""

	def __init__(self, overlap, radii=(1e-2, 1.4e-2), **material):
		self.radii, self.overlap = radii, overlap
		O.materials.append(wrapper.RollingIceBondMat(young=young, poisson=ratio, frictionAngle=math.atan(friction), density=2650, **material))
		O.bodies.append([utils.sphere((0, 0, 0), radii[0], fixed=True), utils.sphere((sum(radii) - overlap, 0, 0), radii[1], fixed=True)])
		loop = wrapper.InteractionLoop(
			[wrapper.Ig2_Sphere_Sphere_ScGeom()], [wrapper.Ip2_IceBondMat_IceBondMat_IceBondPhys()], [wrapper.Law2_ScGeom_IceBondPhys_IceBond()]
		)
		O.engines = [wrapper.ForceResetter(), wrapper.InsertionSortCollider([wrapper.Bo1_Sphere_Aabb()]), loop, wrapper.NewtonIntegrator(damping=0)]
		O.dt = 1e-6

	def roll(self, spin, steps):
		"""Moment on the second sphere [N m] after steps of that spin [rad/s]."""
		O.bodies[1].state.angVel = spin
		O.run(steps, True)
		return np.array(O.interactions[0, 1].phys.moment_bending)


def test_moment_of_one_contact_is_rolling_stiffness_times_angle_and_then_its_share_of_the_normal_force():
	pair = Pair(1e-5, alphaKr=alphaKr, etaRoll=etaRoll)
	r1, r2 = pair.radii
	normal = 2 * young * r1 * r2 / (r1 + r2) * pair.overlap
	stiffness = alphaKr * ratio * 2 * young * (r1 * r2) ** 2 / (r1 + r2)
	angle = 0.5 * etaRoll * r1 * normal / stiffness
	elastic = pair.roll((0, 0, angle / (100 * O.dt)), 100)
	limited = pair.roll((0, 0, angle / (100 * O.dt)), 200)
	print(
		f"\nk_r {stiffness:.1f} N m: moment {elastic[2]:.6e} N m of {-stiffness * angle:.6e}; limit {limited[2]:.6e} of {-etaRoll * r1 * normal:.6e}; "
		f"torque on the second grain {O.forces.t(1)[2] - limited[2]:.3e} N m beside it, of shear"
	)
	assert elastic == pytest.approx([0, 0, -stiffness * angle], rel=1e-9, abs=1e-20)
	assert limited == pytest.approx([0, 0, -etaRoll * r1 * normal], rel=1e-9, abs=1e-20)


def test_twisting_meets_no_moment_and_neither_does_rolling_of_grains_under_tension():
	pair = Pair(1e-5, etaRoll=etaRoll, iceSaturation=0)
	assert (pair.roll((100, 0, 0), 50) == 0).all()
	O.materials[0].iceSaturation = 1
	O.run(2, True)
	O.bodies[1].state.pos = (sum(pair.radii) + 1e-7, 0, 0)
	moment, phys = pair.roll((0, 0, 100), 5), O.interactions[0, 1].phys
	print(f"\nbonded, normal force {phys.normalForce.dot(O.interactions[0, 1].geom.normal):.1f} N: moment {moment[2]:g} N m")
	assert phys.bondState == 1 and phys.normalForce.dot(O.interactions[0, 1].geom.normal) < 0
	assert (moment == 0).all()


@pytest.mark.parametrize("disc", [True, False], ids=["disc", "sphere"])
def test_a_grain_rolls_to_rest_on_a_plane_after_the_distance_of_rolling_friction(disc):
	radius, speed, gravity = 1e-2, 0.2, 9.81
	O.materials.append(wrapper.RollingIceBondMat(young=1e8, poisson=ratio, frictionAngle=1.0, density=2650, etaRoll=etaRoll, alphaKr=2))
	O.bodies.append([utils.box((0, -0.1, 0), (2, 0.1, 1), fixed=True), utils.sphere((0, radius, 0), radius)])
	grain = O.bodies[1].state
	if disc:
		grain.blockedDOFs = "zXY"
		grain.inertia = 0.5 * grain.mass * radius**2 * Vector3(1, 1, 1)
	load = grain.mass * gravity / (2e8 * radius)  # overlap that carries the weight; k_n = 2 E R of a sphere on a plane
	for _ in range(2):
		grain.pos, grain.vel, grain.angVel = (0, radius - load, 0), (speed, 0, 0), (0, 0, -speed / radius)
	boxes = wrapper.InsertionSortCollider([wrapper.Bo1_Sphere_Aabb(), wrapper.Bo1_Box_Aabb()])
	law = wrapper.Law2_ScGeom_IceBondPhys_IceBond(sphericalBodies=False)
	loop = wrapper.InteractionLoop([wrapper.Ig2_Box_Sphere_ScGeom()], [wrapper.Ip2_IceBondMat_IceBondMat_IceBondPhys()], [law])
	O.engines = [wrapper.ForceResetter(), boxes, loop, wrapper.NewtonIntegrator(damping=0, gravity=(0, -gravity, 0))]
	O.dt = 1e-5
	deceleration = etaRoll * gravity / (1 + (0.5 if disc else 0.4))
	furthest = 0.0
	while O.time < 1.1 * speed / deceleration:
		O.run(500, True)
		furthest = max(furthest, grain.pos[0])
	distance = speed**2 / (2 * deceleration)
	print(f"\nrolled {1e3 * furthest:.4f} mm, v^2/(2 a) with a = eta g/(1 + I/(m R^2)) is {1e3 * distance:.4f} mm, {100 * (furthest / distance - 1):+.3f} %")
	assert furthest == pytest.approx(distance, rel=5e-3)


def test_a_grain_that_resists_rolling_rolls_freely_on_one_that_does_not():
	pair = Pair(1e-5, etaRoll=etaRoll)
	smooth = wrapper.IceBondMat(young=young, poisson=ratio, frictionAngle=math.atan(friction), density=2650)
	O.bodies[0].material = smooth
	O.bodies[1].state.angVel = (0, 0, 100)
	O.run(5, True)
	assert type(O.interactions[0, 1].phys) is wrapper.IceBondPhys and pair.overlap > 0


@pytest.mark.parametrize("attribute", ["alphaKr", "etaRoll"])
@pytest.mark.parametrize("value", [0, -1, math.nan, math.inf])
def test_impossible_resistance_to_rolling_is_refused_with_its_remedy(attribute, value):
	with pytest.raises(ValueError, match=f"RollingIceBondMat.{attribute} is .*greater than 0"):
		wrapper.RollingIceBondMat(**{attribute: value})


def test_rolling_friction_raises_the_friction_angle_of_thawed_samples_slow(sampleCache):
	lines = []
	table = calibrate.rollingFriction(60, (0.18,), (0.0, 0.2), realisations=1, strain=0.04, told=lines.append, cache=sampleCache)
	print("\n" + "\n".join(lines))
	assert table.frictionAngle[0, 1] > table.frictionAngle[0, 0] + 5
	assert len(lines) == 3 and f"{table.frictionAngle[0, 1]:.1f}" in lines[2]


def test_time_step_of_samples_follows_their_rotational_stiffness():
	settings = dict(number=30, radiusMin=3e-3, radiusMax=7e-3, thickness=0.1, young=young, stiffnessRatio=ratio, density=2650.0, damping=0.3, ice=True)
	free, rough = packing.Grains(**settings, iceBond=()), packing.Grains(**settings, iceBond=(("etaRoll", 0.1),))
	assert free.timeStep / rough.timeStep == pytest.approx(math.sqrt(1 + 2 * 7 / 3), rel=1e-12)


def test_a_scene_whose_contacts_resist_rolling_in_another_way_than_their_material_is_not_packed(rough):
	scene = rough.open()
	with talik.inspect(scene):
		next(i for i in O.interactions if i.isReal).phys.maxRollPl *= 2
	with pytest.raises(ValueError, match="resists rolling in another way"):
		wrapper.RveSample.fromScene(scene)
