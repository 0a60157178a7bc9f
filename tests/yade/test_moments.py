# SPDX-License-Identifier: GPL-2.0-or-later
"""Ice bonds that carry moments, against closed forms of the parallel bond and stock YADE's law of moments."""

import math
import sys

import numpy as np
import pytest
from fixtures import ofDimension
from yade import Matrix3, O, Vector3, utils, wrapper

import talik
from stock_moments import openStock
from talik import packing, rve
from talik.studies import command, moments

friction, ratio, young, iceYoung, strength = 0.5, 0.8, 0.6e9, 3e9, 51e6
gradient = {2: Matrix3(0.6, 1.0, 0, -0.5, -1.0, 0, 0, 0, 0), 3: Matrix3(0.5, 0.9, 0.3, -0.4, -0.8, 0.2, 0.1, 0.3, -0.4)}
components = {2: ((0, 0), (1, 1), (0, 1)), 3: ((0, 0), (1, 1), (2, 2), (1, 2), (0, 2), (0, 1))}


def relative(a, b):
	return np.abs(np.subtract(a, b)).max() / np.abs(b).max()


# ---- one bond -------------------------------------------------------------------------------------------------------------


class Pair:
	"""Two spheres on the x axis with a bond of full ice saturation between them, the second sphere turned."""

	def __init__(self, radii=(1e-2, 1.4e-2), overlap=0.0, **material):
		self.radii = radii
		self.area = min(radii) ** 2
		self.bondRadius = material.get("bondRadiusFactor", 1) * math.sqrt(self.area / math.pi)
		self.grainStiffness = 2 * young * radii[0] * radii[1] / sum(radii)
		self.iceStiffness = self.grainStiffness * iceYoung / young
		O.materials.append(wrapper.MomentIceBondMat(young=young, poisson=ratio, frictionAngle=math.atan(friction), density=2650, **material))
		O.bodies.append([utils.sphere((0, 0, 0), radii[0], fixed=True), utils.sphere((sum(radii) - 1e-9, 0, 0), radii[1], fixed=True)])
		loop = wrapper.InteractionLoop(
			[wrapper.Ig2_Sphere_Sphere_ScGeom()], [wrapper.Ip2_IceBondMat_IceBondMat_IceBondPhys()], [wrapper.Law2_ScGeom_IceBondPhys_IceBond()]
		)
		O.engines = [wrapper.ForceResetter(), wrapper.InsertionSortCollider([wrapper.Bo1_Sphere_Aabb()]), loop, wrapper.NewtonIntegrator(damping=0)]
		O.dt = 1e-6
		talik.runSerially(2)
		self.setIce(1)
		O.bodies[1].state.pos = (sum(radii) - overlap, 0, 0)

	def setIce(self, saturation):
		O.materials[0].iceSaturation = saturation
		talik.runSerially(2)

	def spin(self, velocity):
		"""Both spheres turn against each other with that angular velocity [rad/s] without slip."""
		r1, r2 = self.radii
		O.bodies[0].state.angVel, O.bodies[1].state.angVel = -r2 / (r1 + r2) * Vector3(*velocity), r1 / (r1 + r2) * Vector3(*velocity)

	def turn(self, angle, steps=100):
		"""The moment of the bond [N m] after the second sphere has turned against the first one by a vector of angles."""
		self.spin(np.divide(angle, steps * O.dt))
		talik.runSerially(steps)
		self.spin((0, 0, 0))
		return np.array(self.phys.bondMoment)

	@property
	def phys(self):
		return O.interactions[0, 1].phys

	@property
	def intact(self):
		return self.phys is not None and self.phys.bondState == 1

	def bendingAngle(self, normal=0.0, contribution=1.0):
		"""Where -F_n/A_b + beta |M_b| R_b/I = C_eta, Potyondy & Cundall 2004, parallel bond."""
		inertia = math.pi * self.bondRadius**4 / 4
		moment = (strength + normal / self.area) * inertia / (contribution * self.bondRadius)
		return moment / (self.iceStiffness * self.bondRadius**2 / 4)

	def angleAtFailure(self, direction, angle, steps=4000):
		"""The angle at which the bond breaks, turned in steps of angle/steps."""
		self.spin(np.multiply(direction, angle / (steps * O.dt)))
		for k in range(2 * steps):
			talik.runSerially(1)
			if not self.intact:
				return (k + 1) * angle / steps
		raise AssertionError("the bond has not broken")


@pytest.mark.parametrize("factor", [1.0, 1.5])
def test_moment_of_one_bond_is_that_of_a_beam_of_circular_section(factor):
	for axis in range(3):
		O.reset()
		pair = Pair(bondRadiusFactor=factor)
		stiffness = pair.iceStiffness * pair.bondRadius**2 * (ratio / 2 if axis == 0 else 1 / 4)
		angle = 1e-4 * np.eye(3)[axis]
		moment = pair.turn(angle)
		print(f"\n{'twisting' if axis == 0 else 'bending'} stiffness {stiffness:.1f} N m: moment {moment} N m, of the beam {-stiffness * angle}", end="")
		assert moment == pytest.approx(-stiffness * angle, rel=1e-9, abs=1e-15)


@pytest.mark.parametrize("overlap", [0.0, -2e-5, 2e-5], ids=["unloaded", "in tension", "pressed"])
def test_bond_breaks_in_bending_where_stress_at_the_edge_of_its_section_reaches_its_tensile_strength(overlap):
	pair = Pair(overlap=overlap)
	talik.runSerially(1)
	normal = pair.phys.normalForce.dot(O.interactions[0, 1].geom.normal)
	angle = pair.bendingAngle(normal)
	broken = pair.angleAtFailure((0, 1, 0), angle)
	left = pair.phys.normalForce.norm() if pair.phys else 0
	print(f"\nF_n {normal:.0f} N: breaks at {1e3 * broken:.4f} mrad, closed form {1e3 * angle:.4f}; normal force after it {left:.0f} N")
	assert broken == pytest.approx(angle, rel=1e-3)
	assert pair.phys is None or pair.phys.bondMoment.norm() == 0
	assert left == pytest.approx(pair.grainStiffness * max(overlap, 0), rel=1e-6, abs=1e-3)


def test_bond_breaks_in_twisting_where_stress_at_the_edge_of_its_section_reaches_its_shear_strength():
	"""tau = |M_t| R_b/J = C_tau, Potyondy & Cundall 2004, parallel bond."""
	pair = Pair()
	polar = math.pi * pair.bondRadius**4 / 2
	angle = strength * polar / pair.bondRadius / (ratio * pair.iceStiffness * pair.bondRadius**2 / 2)
	broken = pair.angleAtFailure((1, 0, 0), angle)
	print(f"\nbreaks at {1e3 * broken:.4f} mrad, closed form {1e3 * angle:.4f}")
	assert broken == pytest.approx(angle, rel=1e-3)


def test_moments_of_no_contribution_never_break_a_bond_and_half_a_contribution_takes_twice_the_moment():
	half = Pair(momentContribution=0.5)
	angle = half.bendingAngle(contribution=0.5)
	broken = half.angleAtFailure((0, 0, 1), angle)
	O.reset()
	none = Pair(momentContribution=0)
	moment = none.turn((0, 0, 10 * angle))
	print(f"\nbeta = 0.5 breaks at {1e3 * broken:.3f} mrad, closed form {1e3 * angle:.3f}; beta = 0 holds {np.linalg.norm(moment):.1f} N m")
	assert broken == pytest.approx(angle, rel=1e-3)
	assert none.intact


def test_melting_ice_takes_its_share_of_the_moment_away_and_new_ice_begins_without():
	pair = Pair()
	full = pair.turn((1e-4, 2e-4, -1e-4))
	pair.setIce(0.5)
	half, phi = np.array(pair.phys.bondMoment), 1 - (1 - 0.5**2) ** 2
	pair.setIce(0.9)
	again = np.array(pair.phys.bondMoment)
	pair.setIce(0)
	thawed = np.array(pair.phys.bondMoment)
	pair.setIce(1)
	print(f"\nmoment kept at S_i = 0.5: {np.linalg.norm(half) / np.linalg.norm(full):.6f}, phi(0.5) = {phi:.6f}")
	assert half == pytest.approx(phi * full, rel=1e-9)
	assert (again == half).all() and (thawed == 0).all()
	assert pair.phys.bondState == 1 and (np.array(pair.phys.bondMoment) == 0).all()
	assert np.linalg.norm(pair.turn((0, 1e-4, 0))) == pytest.approx(1e-4 * pair.iceStiffness * pair.bondRadius**2 / 4, rel=1e-9)


# ---- samples --------------------------------------------------------------------------------------------------------------


@pytest.fixture(params=[(2, {}), (3, {}), (2, {"etaRoll": 0.1}), (3, {"etaRoll": 0.1})], ids=["discs", "spheres", "rolling discs", "rolling spheres"])
def frozen(request, sampleCache):
	"""A frozen sample whose bonds carry moments, at rest."""
	dimension, rolling = request.param
	scene = rve.openScene(rve.prepare(**ofDimension[dimension], cache=sampleCache))
	with talik.inspect(scene):
		weak = {2: 10e6, 3: 1e6}[dimension]  # some bonds break in 500 steps
		material = wrapper.MomentIceBondMat(
			young=young,
			poisson=ratio,
			frictionAngle=math.atan(friction),
			density=2650,
			bondRadiusFactor=2,
			iceTensileStrength=weak,
			iceShearStrength=weak,
			**rolling,
		)
		for body in O.bodies:
			body.material = material
		O.interactions.clear()
		O.dt = O.dt / 3
		talik.runSerially(2000)
	sample = rve.pack(scene)
	sample.freeze(1)
	return sample


def stockScene(scene):
	"""Grains and bonds of a scene in stock YADE's own law, its contact springs those of the grains and the ice together."""

	def contactOf(i):
		p = i.phys
		assert p.bondState == 1, "every contact is a bond"
		ice = p.kn - p.grainStiffness
		square = p.bondRadiusFactor**2 * p.bondArea / math.pi
		return dict(
			kn=p.kn,
			ks=p.ks,
			unp=(p.grainStiffness * p.uGrain + ice * p.uIce) / p.kn,
			shearForce=p.shearForce,
			kr=ice * square / 4,
			ktw=ratio * ice * square / 2,
			moment_bending=p.bondMoment - p.bondMoment.dot(i.geom.normal) * i.geom.normal,
			moment_twist=p.bondMoment.dot(i.geom.normal) * i.geom.normal,
			normalAdhesion=1e12,
			shearAdhesion=1e12,
		)

	grain = dict(young=young, poisson=ratio, frictionAngle=math.atan(friction), normalCohesion=1e12, shearCohesion=1e12)
	openStock(scene, contactOf, moving=True, reach=1.06, cohesive=True, etaRoll=-1, etaTwist=-1, fragile=True, **grain)


@pytest.mark.parametrize("frozen", [(2, {}), (3, {})], ids=["discs", "spheres"], indirect=True)
def test_bonds_with_moments_follow_stock_yades_law_of_moments_to_1e9_over_500_steps(frozen):
	"""As long as no bond breaks: what is left of a broken one is another law. Stock YADE knows one moment of a contact, not that of its bond beside
	that of its grains, which roll freely here."""
	scene = frozen.open()
	with talik.inspect(scene):
		for body in O.bodies:
			body.state.vel = body.state.angVel = Vector3.Zero
	packed, velGrad, done = wrapper.RveSample.fromScene(scene), 0.05 * gradient[frozen.dimension], 0
	stockScene(scene)
	O.cell.velGrad = velGrad
	for steps, most in ((1, 1e-12), (100, 1e-9), (500, 1e-9)):
		talik.runSerially(steps - done)
		packed.advance(velGrad, steps - done)
		done = steps
		error = relative(packed.stress, packing.stress())
		opened = packed.open()
		with talik.inspect(opened):
			moments = {(i.id1, i.id2): i.phys.bondMoment for i in O.interactions if i.isReal}
		stock = {ids: O.interactions[ids].phys.moment_bending + O.interactions[ids].phys.moment_twist for ids in moments}
		largest = max(m.norm() for m in stock.values())
		ofMoments = max((moments[ids] - m).norm() for ids, m in stock.items()) / largest
		print(f"\n{steps} steps: stress differs by {error:.1e}, moments by {ofMoments:.1e} of the largest, {largest:.1e} N m", end="")
		assert error < most and ofMoments < 1e-9
	assert packed.statistics()["bondsBroken"] == 0


def test_opened_samples_whose_bonds_carry_moments_go_on_as_packed_to_1e9_over_500_steps_and_come_back_to_the_last_bit(frozen):
	scene, velGrad, bonds = frozen.open(), gradient[frozen.dimension], frozen.statistics()["bondsIntact"]
	with talik.inspect(scene):
		O.cell.velGrad = velGrad
		talik.runSerially(500)
		frozen.advance(velGrad, 500)
		error = relative(frozen.stress, packing.stress())
	intact = frozen.statistics()["bondsIntact"]
	print(f"\n500 steps of the opened scene: stress differs by {error:.1e}; {bonds} bonds, {bonds - intact} broke")
	assert error < 1e-9 and intact < bonds
	before = frozen.stateBytes
	frozen.repack(frozen.open())
	assert frozen.stateBytes == before


def test_samples_whose_bonds_carry_moments_thaw_and_freeze_again_open_as_packed(frozen):
	opened, motion = wrapper.OpenRveSample(source=frozen.open(), timeStepFollowsIce=False), 2e-5 * gradient[frozen.dimension]
	frozen.timeStepFollowsIce = False
	for ice in (1, 0.6, 0.6, 0, 0.8, 0.8):
		packed, other = frozen.apply(motion, ice), opened.apply(motion, ice)
		error = relative(packed["stress"], [other["stress"][i][j] for i, j in components[frozen.dimension]])
		print(f"\nS_i = {ice:g}: stress differs by {error:.1e}, {frozen.statistics()['bondsIntact']} bonds", end="")
		assert error < 1e-9


@pytest.mark.parametrize("dimension", [2, 3], ids=["discs", "spheres"])
def test_time_step_follows_the_section_of_the_bonds_and_wide_ones_come_to_rest(dimension, sampleCache):
	"""(1 + k (1 + m)) of bending or twisting over sliding, m = lambda^2 a_f/(4 pi) max(1/nu_c, 2), with k = 5 the stiffness of the ice over the grains'."""

	def packed(factor):
		scene = rve.openScene(rve.prepare(**ofDimension[dimension], cache=sampleCache))
		with talik.inspect(scene):
			material = wrapper.MomentIceBondMat(young=young, poisson=ratio, frictionAngle=math.atan(friction), density=2650, bondRadiusFactor=factor)
			for body in O.bodies:
				body.material = material
			O.interactions.clear()
			O.step()
		return rve.pack(scene)

	def stiffening(factor):
		return 1 + iceYoung / young * (1 + factor**2 / (4 * math.pi) * max(1 / ratio, 2))

	narrow, wide = packed(1.0), packed(10.0)
	wide.freeze(1)
	wide.apply(1e-4 * gradient[dimension], 1)
	wide.advance(Matrix3.Zero, 4000)
	left = wide.statistics()
	print(f"\ntime step {narrow.dt:.3e} s and {wide.dt:.3e} s; unbalanced force {left['unbalancedForce']:.1e} after 4000 steps, {left['bondsIntact']} bonds")
	assert narrow.dt / wide.dt == pytest.approx(math.sqrt(stiffening(10) / stiffening(1)), rel=1e-9)
	assert left["unbalancedForce"] < 1e-3 and left["bondsIntact"] > 100


def test_a_scene_whose_bonds_carry_moments_in_another_way_than_their_material_is_not_packed(frozen):
	scene = frozen.open()
	with talik.inspect(scene):
		next(i for i in O.interactions if i.isReal).phys.bondRadiusFactor *= 2
	with pytest.raises(ValueError, match="carries moments in another way"):
		wrapper.RveSample.fromScene(scene)


def test_bonds_that_carry_moments_do_not_creep_and_are_refused_by_one_sentence_when_the_engine_starts(frozen):
	creep = wrapper.IceCreep()
	with pytest.raises(ValueError, match="Bonds that carry moments do not creep"):
		frozen.apply(Matrix3.Zero, 1, creep=creep.over(-5, 1e6))
	mpm = wrapper.MpmEngine(
		gridSpacing=0.1,
		lower=(0,) * frozen.dimension,
		upper=(0.2,) * frozen.dimension,
		heat=wrapper.HeatTransfer(),
		freezing=wrapper.FreezingCurve(),
		skeleton=wrapper.RveSkeleton(samples=[frozen], iceCreep=creep),
	)
	talik.geometry.fill(
		mpm, *([talik.geometry.rectangle(0, 0, 0.1, 0.1)] if frozen.dimension == 2 else [talik.solids.box((0, 0, 0), (0.1, 0.1, 0.1))]), porosity=0.4
	)
	with pytest.raises(ValueError, match="RveSkeleton.iceCreep: Bonds that carry moments do not creep"):
		mpm.initialise()


@pytest.mark.parametrize(
	"attribute, value", [("bondRadiusFactor", 0), ("bondRadiusFactor", math.inf), ("momentContribution", -0.1), ("momentContribution", 1.1)]
)
def test_impossible_moments_are_refused_with_their_remedy(attribute, value):
	with pytest.raises(ValueError, match=f"MomentIceBondMat.{attribute} is .*give a"):
		wrapper.MomentIceBondMat(**{attribute: value})


def test_strength_of_frozen_samples_with_moments_stands_beside_that_without_in_a_table_and_a_picture(tmp_path, monkeypatch, capsys, sampleCache):
	kinds = ("neither", "moments")
	found = moments.compare(30, 1, strain=4e-3, which=kinds, told=print, cache=sampleCache)
	rows = [line for line in capsys.readouterr().out.splitlines() if line.startswith("| ")]
	print("\n" + "\n".join(rows))
	peaks = {kind: tests[0].deviator.max() for kind, tests in found.compression.items()}
	assert len(rows) == 1 + len(kinds) and f"{1e-6 * peaks['moments']:.2f} ±" in rows[2]
	assert peaks["neither"] != peaks["moments"], "moments change how bonds break"
	monkeypatch.setattr(sys, "argv", ["calibrate", "--moments", "--grains", "30", "--realisations", "1", "--output", str(tmp_path)])
	monkeypatch.setattr(moments, "compare", lambda grains, realisations, told: told(f"{grains} {realisations}") or found)
	command.main()
	assert (tmp_path / "moments.md").read_text() == "30 1\n" and (tmp_path / "moments.png").stat().st_size > 10000
