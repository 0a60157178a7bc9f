# SPDX-License-Identifier: GPL-2.0-or-later
"""Bodies of the scene among the material points, against closed forms: Newton's second law, Coulomb's friction, weights."""

import math

import numpy as np
import pytest
from yade import O, Quaternion, Vector3, utils, wrapper

import talik

g = 9.81


def rigid(friction=0.0, density=2500.0):
	"""A material of bodies; friction is tan(phi)."""
	return O.materials.append(wrapper.FrictMat(frictionAngle=math.atan(friction), density=density))


def ground(outline, gravity=(0, -g), gridSpacing=0.1, young=1e7, lower=(-1, -1), upper=(3, 3), velocity=(0, 0), pointsPerCell=4, **attributes):
	"""An elastic piece of ground among bodies, in O.engines between those that bodies need."""
	attributes.setdefault("bodies", wrapper.BodyContact())
	mpm = wrapper.MpmEngine(
		gridSpacing=gridSpacing, lower=lower, upper=upper, gravity=gravity, skeleton=wrapper.ElasticSkeleton(young=young, poisson=0.2), **attributes
	)
	talik.geometry.fill(mpm, outline, pointsPerCell, velocity=velocity)
	O.engines = [wrapper.ForceResetter(), mpm, wrapper.NewtonIntegrator(damping=0, gravity=(*gravity, 0))]
	return mpm


def run(steps):
	talik._talik.runSerially(steps)


def mass(mpm):
	return mpm.field("mass").sum()


def momentum(mpm):
	"""Of ground and bodies that move, per metre."""
	moving = [body.state for body in O.bodies if body.clumpId in (-1, body.id) and "x" not in body.state.blockedDOFs]
	return np.array(mpm.balance()["momentum"]) + sum((state.mass * np.array(state.vel)[:2] for state in moving), np.zeros(2))


# ---- a block on an incline -------------------------------------------------------------------------------------------------


def inclinedPlane(angle, friction, kind):
	"""A plane through (1, 1) at an angle to the grid, and its unit vectors along and across."""
	along, across = np.array([math.cos(angle), math.sin(angle)]), np.array([-math.sin(angle), math.cos(angle)])
	place = lambda s, e, z=0: Vector3(*(1 + s * along + e * across), z)
	material = rigid(friction)
	if kind == "box":
		O.bodies.append(utils.box(place(0, -0.3), (2, 0.3, 0.5), orientation=Quaternion((0, 0, 1), angle), fixed=True, material=material))
	else:
		a, b, c, d = place(-2, 0, -0.5), place(2, 0, -0.5), place(2, 0, 0.5), place(-2, 0, 0.5)
		O.bodies.append([utils.facet(corners, material=material) for corners in ((a, b, c), (a, c, d))])
	return along, across, place


def blockOnPlane(angle, friction, kind):
	along, across, place = inclinedPlane(math.radians(angle), friction, kind)
	mpm = ground([tuple(place(s, e))[:2] for s, e in ((0, 0), (0.6, 0), (0.6, 0.3), (0, 0.3))])
	return mpm, along, across


@pytest.mark.parametrize("kind", ["box", "facet"])
@pytest.mark.parametrize("friction", [0.0, 0.3])
def test_a_block_slides_down_an_incline_with_the_acceleration_of_coulomb_within_one_per_cent(kind, friction):
	mpm, along, _ = blockOnPlane(30, friction, kind)
	times, speeds = [], []
	for _ in range(40):
		run(25)
		times.append(mpm.time)
		speeds.append(np.dot(mpm.balance()["momentum"], along) / mass(mpm))
	measured = np.polyfit(times[10:], speeds[10:], 1)[0]
	expected = -g * (math.sin(math.radians(30)) - friction * math.cos(math.radians(30)))
	print(f"acceleration {measured:.4f} m/s2, g (sin a - mu cos a) {expected:.4f} m/s2, ratio {measured / expected:.4f}")
	assert measured == pytest.approx(expected, rel=0.01)


def test_a_block_below_the_friction_angle_stays_where_it_is():
	mpm, along, _ = blockOnPlane(15, 0.3, "box")
	mpm.damping = 0.5
	run(4000)
	settled = mpm.field("displacement") @ along
	run(2000)
	crept = np.abs(mpm.field("displacement") @ along - settled).max()
	free = 0.5 * g * math.sin(math.radians(15)) * mpm.time**2
	print(f"moved {np.abs(settled).max():.2e} m while it settled and {crept:.2e} m afterwards; without friction {free:.2f} m")
	assert np.abs(settled).max() < 1e-4 * free and crept < 1e-5 * free


# ---- weight ----------------------------------------------------------------------------------------------------------------


def test_a_footing_at_rest_presses_the_ground_with_its_weight_and_the_ground_carries_it():
	mpm = ground(talik.geometry.rectangle(0, 0, 2, 1), lower=(0, 0), upper=(2, 2), damping=0.5)
	mpm.boundaries = [wrapper.RollerBoundary(region="left"), wrapper.RollerBoundary(region="right"), wrapper.FixedBoundary(region="bottom")]
	footing = O.bodies.append(utils.box((1, 1.2, 0), (0.4, 0.2, 0.5), material=rigid(0.5)))
	O.engines[2].damping = 0.3
	run(3000)
	weight, pressing = O.bodies[footing].state.mass * g, O.forces.f(footing)[1]
	before = np.array(mpm.balance()["impulse"])
	start = mpm.time
	run(1000)
	held = (mpm.balance()["impulse"][1] - before[1]) / (mpm.time - start)
	print(
		f"weight {weight:.1f} N, force on the footing {pressing:.1f} N, unbalanced on the ground {held:.2e} N, speed {O.bodies[footing].state.vel[1]:.1e} m/s"
	)
	assert pressing == pytest.approx(weight, rel=0.01)
	assert abs(held) < 0.01 * weight


def test_thickness_of_the_ground_scales_the_force_on_a_body():
	forces = []
	for thickness in (1.0, 2.5):
		O.reset()
		O.engines = []
		floor = O.bodies.append(utils.wall(0, axis=1, sense=1, material=rigid()))
		mpm = ground(talik.geometry.rectangle(0, 0, 0.5, 0.5), damping=0.5, bodies=wrapper.BodyContact(thickness=thickness))
		run(3000)
		forces.append(-O.forces.f(floor)[1] / (mass(mpm) * g))
	print(f"force on the floor over weight per metre: {forces[0]:.4f} at 1 m, {forces[1]:.4f} at 2.5 m")
	assert forces == pytest.approx([1.0, 2.5], rel=0.01)


# ---- impacts ---------------------------------------------------------------------------------------------------------------


def strikers():
	material = rigid(0.4)
	yield "sphere", lambda: [O.bodies.append(utils.sphere((0.3, 0.85, 0), 0.3, material=material))]
	yield "box", lambda: [O.bodies.append(utils.box((0.3, 0.85, 0), (0.2, 0.25, 0.5), orientation=Quaternion((0, 0, 1), 0.3), material=material))]
	yield "clump", lambda: [
		O.bodies.appendClumped([utils.sphere((0.2, 0.8, 0), 0.2, material=material), utils.sphere((0.45, 0.85, 0), 0.2, material=material)])[0]
	]


def test_an_impact_conserves_the_momentum_of_ground_and_body_to_round_off():
	for name, make in strikers():
		O.reset()
		O.engines = []
		O.materials.append(wrapper.FrictMat(frictionAngle=math.atan(0.4), density=2500))
		striker = O.bodies[make()[0]].state
		mpm = ground(talik.geometry.rectangle(0, 0, 0.6, 0.5), gravity=(0, 0), young=1e6)
		striker.vel = (1.0, -3.0, 0)
		start = momentum(mpm)
		worst = 0.0
		for _ in range(40):
			run(5)
			worst = max(worst, np.abs(momentum(mpm) - start).max())
		exchanged = np.linalg.norm(mpm.balance()["momentum"])
		print(f"{name}: exchanged {exchanged:.0f} N s, difference of the sum at most {worst:.1e} N s")
		assert exchanged > 0.1 * np.linalg.norm(start)
		assert worst < 1e-12 * np.linalg.norm(start)
		assert mpm.cost()["bodies"] > 0


@pytest.mark.parametrize("kind", ["box", "wall"])
def test_impulse_on_a_barrier_is_the_momentum_that_the_ground_lost(kind):
	make = {"box": lambda m: utils.box((1.5, 0.3, 0), (0.2, 1, 0.5), fixed=True, material=m), "wall": lambda m: utils.wall(1.3, axis=0, sense=-1, material=m)}
	barrier = O.bodies.append(make[kind](rigid(0.3)))
	mpm = ground(talik.geometry.rectangle(0, 0, 0.6, 0.5), gravity=(0, 0), young=1e6, velocity=(5, 1))
	start, impulse = np.array(mpm.balance()["momentum"]), np.zeros(2)
	for _ in range(250):
		O.step()
		impulse += np.array(O.forces.f(barrier))[:2] * O.dt
	lost = start - mpm.balance()["momentum"]
	print(f"impulse on the barrier ({impulse[0]:.6f}, {impulse[1]:.6f}) N s, momentum lost ({lost[0]:.6f}, {lost[1]:.6f}) N s")
	assert impulse[0] > 1.05 * start[0], "the block bounces back"
	assert np.abs(impulse - lost).max() < 1e-11 * start[0]


def test_a_ball_rolls_down_the_ground_with_five_sevenths_of_the_slope_within_two_per_cent():
	slope = math.radians(20)
	gravity = (g * math.sin(slope), -g * math.cos(slope))
	mpm = ground(talik.geometry.rectangle(0, 0, 2.4, 0.3), gravity=gravity, young=5e6, lower=(0, 0), upper=(2.4, 0.6), pointsPerCell=16)
	mpm.boundaries = [wrapper.RollerBoundary(region="left"), wrapper.RollerBoundary(region="right"), wrapper.FixedBoundary(region="bottom")]
	ball = O.bodies[O.bodies.append(utils.sphere((0.5, 1.1, 0), 0.8, material=rigid(1.0, density=1000)))].state
	times, speeds = [], []
	while ball.pos[0] < 1.8:
		run(100)
		times.append(O.time)
		speeds.append(ball.vel[0])
	half = len(times) // 4
	measured, expected = np.polyfit(times[half:], speeds[half:], 1)[0], 5 / 7 * g * math.sin(slope)
	print(f"acceleration {measured:.4f} m/s2, 5/7 g sin a {expected:.4f} m/s2; rolling speed over speed {-ball.angVel[2] * 0.8 / ball.vel[0]:.4f}")
	assert measured == pytest.approx(expected, rel=0.02)


# ---- steps of different length ---------------------------------------------------------------------------------------------


def impactWithStep(dt=None, **contact):
	O.reset()
	O.engines = []
	striker = O.bodies[O.bodies.append(utils.sphere((0.3, 0.81, 0), 0.3, material=rigid(0.4)))].state
	mpm = ground(talik.geometry.rectangle(0, 0, 0.6, 0.5), gravity=(0, 0), young=1e6, bodies=wrapper.BodyContact(**contact))
	striker.vel = (1.0, -3.0, 0)
	if dt:
		mpm.automaticTimeStep = False
		O.dt = dt
	start = momentum(mpm)
	while O.time < 0.15:
		run(1)
	return mpm, striker, np.abs(momentum(mpm) - start).max() / np.linalg.norm(start)


def test_the_faster_of_ground_and_bodies_takes_more_steps_and_the_impact_stays_the_same():
	mpm, striker, _ = impactWithStep()
	reference, stable = np.array(striker.vel)[:2], mpm.stableTimeStep()
	for name, dt in (("ground takes 3 steps", 2.5 * stable), ("ground takes 1 step for 20 of the body", stable / 20.5)):
		mpm, striker, lost = impactWithStep(dt)
		difference = np.linalg.norm(np.array(striker.vel)[:2] - reference) / np.linalg.norm(reference - (1, -3))
		print(f"{name}: {O.iter} steps of O, ground at {mpm.time - O.time:+.1e} s; velocity after impact off by {difference:.2%}; momentum lost {lost:.1e}")
		assert difference < 0.05  # first order in a step that varies by a factor of fifty
		assert abs(mpm.time - O.time) < 1.01 * stable


def test_a_time_step_that_the_contact_does_not_stand_is_refused():
	striker = O.bodies.append(utils.sphere((0.3, 0.52, 0), 0.02, material=rigid(density=100)))
	mpm = ground(talik.geometry.rectangle(0, 0, 0.6, 0.5), automaticTimeStep=False)
	O.dt = 0.01
	with pytest.raises(RuntimeError, match=r"O.dt = 0.01.*too long for the contact"):
		run(1)
	mpm.automaticTimeStep = True
	run(200)
	print(f"automatic step {O.dt:.2e} s, of the ground alone {mpm.stableTimeStep():.2e} s")
	assert O.dt < mpm.stableTimeStep()
	assert abs(O.bodies[striker].state.vel[1]) < 1


def test_a_time_stepper_of_the_bodies_keeps_the_last_word():
	material = O.materials.append(wrapper.FrictMat(young=1e10, density=2500))
	O.bodies.append([utils.sphere((0.3, 0.8, 0), 0.2, material=material), utils.sphere((0.3, 1.19, 0), 0.2, material=material)])
	mpm = ground(talik.geometry.rectangle(0, 0, 0.6, 0.5), lower=(-0.2, 0), upper=(0.8, 1))
	mpm.boundaries = [wrapper.FixedBoundary(region="bottom")]
	loop = wrapper.InteractionLoop(
		[wrapper.Ig2_Sphere_Sphere_ScGeom()], [wrapper.Ip2_FrictMat_FrictMat_FrictPhys()], [wrapper.Law2_ScGeom_FrictPhys_CundallStrack()]
	)
	stepper = wrapper.GlobalStiffnessTimeStepper(timeStepUpdateInterval=5, defaultDt=1e-5)
	O.engines = [wrapper.ForceResetter(), wrapper.InsertionSortCollider([wrapper.Bo1_Sphere_Aabb()]), loop, stepper, mpm, O.engines[2]]
	run(200)
	chosen = O.dt
	print(f"O.dt {chosen:.2e} s by the time stepper; stable step of the ground {mpm.stableTimeStep():.2e} s; ground at {mpm.time - O.time:+.1e} s")
	assert chosen < mpm.stableTimeStep()
	assert abs(mpm.time - O.time) <= mpm.stableTimeStep()
	assert all(np.isfinite(body.state.pos).all() for body in O.bodies)
	O.engines = [engine for engine in O.engines if engine is not stepper and "Stepper" not in type(engine).__name__]
	run(20)
	wave = 0.2 * math.sqrt(2500 / O.materials[0].young)
	print(f"without it {O.dt:.2e} s, wave through a sphere {wave:.2e} s")
	assert O.dt <= 0.3 * wave * (1 + 1e-9)


# ---- at home in YADE -------------------------------------------------------------------------------------------------------


def test_a_saved_impact_goes_on_bit_for_bit(tmp_path):
	def built():
		O.reset()
		O.engines = []
		striker = O.bodies.append(utils.sphere((0.3, 0.81, 0), 0.3, material=rigid(0.4)))
		mpm = ground(talik.geometry.rectangle(0, 0, 0.6, 0.5), young=1e6, automaticTimeStep=False)
		O.bodies[striker].state.vel = (1, -3, 0)
		O.dt = mpm.stableTimeStep() / 7
		run(100)
		return mpm

	def result():
		return np.hstack([O.engines[1].field("velocity").ravel(), np.array(O.bodies[0].state.vel), np.array(O.bodies[0].state.angVel)])

	built()
	O.save(str(tmp_path / "scene.yade.gz"))
	run(150)
	through = result()
	O.load(str(tmp_path / "scene.yade.gz"))
	run(150)
	difference = np.abs(result() - through).max()
	print(f"difference after saving, loading and 150 steps: {difference}")
	assert difference == 0


def test_a_corner_of_facets_pushes_once_and_holds_the_ground_in():
	material = rigid(0.3)
	corners = [(0, 1), (0, 0), (0.6, 0), (0.6, 1)]
	for (x0, y0), (x1, y1) in zip(corners, corners[1:]):
		a, b, c, d = (x0, y0, -0.5), (x1, y1, -0.5), (x1, y1, 0.5), (x0, y0, 0.5)
		O.bodies.append([utils.facet(corners, material=material) for corners in ((a, b, c), (a, c, d))])
	mpm = ground(talik.geometry.rectangle(0, 0, 0.6, 0.5), damping=0.5)
	run(2000)
	total = sum((O.forces.f(body.id) for body in O.bodies), Vector3.Zero)
	print(f"force on the trough ({total[0]:.2f}, {total[1]:.2f}) N, weight of the ground {mass(mpm) * g:.2f} N")
	assert -total[1] == pytest.approx(mass(mpm) * g, rel=0.01)
	assert abs(total[0]) < 0.01 * mass(mpm) * g


def test_ground_that_does_not_ask_for_bodies_does_not_see_them():
	O.bodies.append(utils.box((0.3, 0.2, 0), (0.1, 0.1, 0.1), material=rigid()))
	mpm = ground(talik.geometry.rectangle(0, 0, 0.6, 0.5), bodies=None)
	run(5)
	assert "bodyContact" not in mpm.fieldNames() and "contact" not in mpm.timeStepLimits() and "bodies" not in mpm.cost()
	assert O.forces.f(0) == Vector3.Zero


# ---- bodies with a temperature ---------------------------------------------------------------------------------------------


def warmPlate(**attributes):
	"""A plate of 10 degC on ground of 0 degC that nothing else heats, pushed along at 1 m/s."""
	O.reset()
	O.engines = []
	plate = O.bodies.append(utils.box((0.5, 0.6, 0), (0.2, 0.1, 0.5), fixed=True, material=rigid(0)))
	condition = wrapper.BodyTemperature(**{"bodies": [plate], "temperature": 10, **attributes})
	sides = [wrapper.RollerBoundary(region=side) for side in ("left", "right", "bottom")]
	mpm = ground(
		talik.geometry.rectangle(0, 0, 2, 0.5),
		lower=(0, 0),
		upper=(2, 0.8),
		gravity=(0, 0),
		heat=wrapper.HeatTransfer(thermalTimeScale=5e4),
		boundaries=[*sides, condition],
	)
	O.bodies[plate].state.vel = (1, 0, 0)
	return mpm


def test_a_warm_plate_that_is_pushed_along_warms_the_ground_that_it_has_passed_and_none_ahead():
	mpm = warmPlate()
	while O.time < 0.8:
		run(50)
	x, t = mpm.field("position")[:, 0], mpm.field("temperature")
	passed, ahead = t[(x > 0.5) & (x < 1.1)], t[x > 1.9]
	print(f"plate now at {O.bodies[0].state.pos[0]:.2f} m; ground that it passed {passed.mean():.2f} degC, ground ahead of it {ahead.max():.1e} degC")
	assert passed.mean() > 1 and ahead.max() < 0.01 * passed.mean()
	assert mpm.balance()["heatIn"] == pytest.approx(mpm.balance()["enthalpy"] - warmPlate().balance()["enthalpy"], rel=1e-9)


def test_resistance_of_a_body_lets_less_heat_in_and_a_table_changes_its_temperature():
	heat = []
	for attributes in ({}, {"resistance": 0.5}, {"times": [0, 1], "values": [10, 10]}, {"times": [0, 1], "values": [0, 0]}):
		mpm = warmPlate(**attributes)
		run(200)
		heat.append(mpm.balance()["heatIn"])
	print(f"heat in {heat[0]:.4g} J/m, with 0.5 m2 K/W {heat[1]:.4g}, from a table {heat[2]:.4g}, at the ground's temperature {heat[3]:.1e}")
	assert 0 < heat[1] < 0.8 * heat[0] and heat[2] == heat[0] and heat[3] == 0


def test_a_saved_scene_with_a_warm_body_goes_on_bit_for_bit(tmp_path):
	def temperatures():
		return O.engines[1].field("temperature")

	warmPlate()
	run(150)
	O.save(str(tmp_path / "warm.yade.gz"))
	run(150)
	through = temperatures()
	O.load(str(tmp_path / "warm.yade.gz"))
	run(150)
	difference = np.abs(temperatures() - through).max()
	print(f"difference after saving, loading and 150 steps: {difference}")
	assert difference == 0 and through.max() > 1


def test_temperatures_of_bodies_without_sense_are_refused():
	for attributes, pattern in (
		({"bodies": []}, r"BodyTemperature.bodies = \[\]: names no body"),
		({"bodies": [7]}, "BodyTemperature.bodies names 7, which is no body that the ground meets"),
		({"bodies": [-1]}, "BodyTemperature.bodies = -1: must be numbers of bodies"),
		({"resistance": -1}, "BodyTemperature.resistance = -1: must not be negative"),
		({"resistance": float("inf")}, "BodyTemperature.resistance = inf: must not be negative"),
		({"temperature": 300}, "BodyTemperature.temperature = 300: must lie between"),
		({"region": "left"}, "BodyTemperature.region is 'left'.*leave region, lower and upper out"),
		({"lower": (0, 0)}, "BodyTemperature.region is ''.*leave region, lower and upper out"),
	):
		warmPlate(**attributes)
		refusal(pattern)
	mpm = warmPlate()
	mpm.boundaries = [*mpm.boundaries, wrapper.BodyTemperature(bodies=[0], temperature=5)]
	refusal("BodyTemperature of body 0 overlaps")
	mpm = warmPlate()
	mpm.bodies = None
	refusal("BodyTemperature of body 0: the ground meets no bodies")
	mpm = warmPlate()
	mpm.heat = None
	refusal("BodyTemperature.*the scene has no heat")


# ---- refusals --------------------------------------------------------------------------------------------------------------

block = talik.geometry.rectangle(0, 0, 0.6, 0.5)


def refusal(pattern, kind=ValueError):
	with pytest.raises(kind, match=pattern) as caught:
		O.step()
	print(caught.value)


def test_shapes_that_cannot_be_met_are_refused_by_number_and_name_unless_the_mask_leaves_them_out():
	body = wrapper.Body()
	body.shape, body.mask = wrapper.Tetra(), 2
	O.bodies.append(body)
	mpm = ground(block)
	refusal(r"O.bodies\[0\] \(Tetra\) cannot meet the ground: it is none of Sphere, Box, Wall, Facet")
	mpm.bodies.mask = 1
	run(1)


def test_boxes_and_facets_that_leave_the_plane_are_refused():
	O.bodies.append(utils.box((0.3, 2, 0), (0.1, 0.1, 0.1), orientation=Quaternion((1, 0, 0), 0.3), material=rigid()))
	ground(block)
	refusal(r"O.bodies\[0\] \(Box\).*turn boxes about z only")
	O.bodies.clear()
	O.bodies.append(utils.facet([(0, 2, 0), (1, 2, 0), (0, 2.5, 1)], material=rigid()))
	refusal(r"O.bodies\[0\] \(Facet\).*neither along nor across z")


def test_a_body_inside_the_ground_is_refused():
	O.bodies.append(utils.sphere((0.3, 0.5, 0), 0.2, material=rigid()))
	ground(block)
	refusal(r"O.bodies\[0\] \(Sphere\).*lie up to 0.\d+ m inside it")


def test_engines_in_an_order_that_loses_forces_are_refused():
	O.bodies.append(utils.sphere((0.3, 1, 0), 0.2, material=rigid()))
	ground(block)
	reset, mpm, newton = O.engines
	O.engines = [mpm, newton]
	refusal("no ForceResetter before MpmEngine")
	O.engines = [reset, newton, mpm]
	refusal("NewtonIntegrator stands before MpmEngine")


def test_settings_without_sense_are_refused():
	for attributes, pattern in (
		({"thickness": 0}, "BodyContact.thickness = 0: must be positive"),
		({"frictionAngle": 90}, "BodyContact.frictionAngle = 90: must lie in"),
		({"stiffness": -1}, "BodyContact.stiffness = -1: must be positive"),
		({"damping": 1}, "BodyContact.damping = 1: must lie in"),
	):
		ground(block, bodies=wrapper.BodyContact(**attributes))
		refusal(pattern)
	ground(block, motion=False, heat=wrapper.HeatTransfer())
	refusal("MpmEngine.bodies is set but motion is False")
