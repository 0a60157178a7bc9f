# SPDX-License-Identifier: GPL-2.0-or-later
"""Several grounds in one scene, contradictions between settings, units that differ, and errors said once."""

import math
import subprocess
from pathlib import Path

import numpy as np
import pytest
from yade import O, utils, wrapper

import talik


def column(young=1e7, lower=(0, 0), **settings):
	x, y = lower
	mpm = wrapper.MpmEngine(
		gridSpacing=0.25,
		lower=(x, y),
		upper=(x + 1, y + 2),
		gravity=(0, -9.81),
		skeleton=wrapper.ElasticSkeleton(young=young),
		**{"boundaries": [wrapper.FixedBoundary(region="bottom")], **settings},
	)
	talik.geometry.fill(mpm, [(x, y), (x + 1, y), (x + 1, y + 1), (x, y + 1)])
	return mpm


@pytest.mark.parametrize("first, second", [(1e7, 3e5), (3e5, 1e7)])
def test_two_grounds_in_one_scene_keep_the_scenes_time(first, second):
	grounds = [column(first), column(second, lower=(3, 0))]
	O.engines = grounds
	for _ in range(100):
		O.step()
	times = [ground.time for ground in grounds]
	print(f"after 100 steps O.time = {O.time:.6f} s, the grounds are at {times[0]:.6f} and {times[1]:.6f} s")
	assert times == pytest.approx([O.time, O.time], rel=1e-12)
	assert O.dt <= 1.01 * min(ground.stableTimeStep() for ground in grounds)


def test_a_second_ground_that_was_stiffened_after_a_look_limits_the_very_first_step():
	first, second = column(3e5), column(3e5, lower=(3, 0))
	O.engines = [first, second]
	soft = second.stableTimeStep()
	second.skeleton.young = 3e7
	O.step()
	print(f"first step {O.dt:.1e} s, limit {second.stableTimeStep():.1e} s, {soft:.1e} s before the change")
	assert O.dt <= 1.01 * second.stableTimeStep() < 0.5 * soft


def test_two_grounds_with_bodies_keep_the_scenes_time():
	grounds = [column(1e7, bodies=wrapper.BodyContact(mask=1)), column(3e5, lower=(3, 0), bodies=wrapper.BodyContact(mask=2))]
	for mask, x in ((1, 0.5), (2, 3.5)):
		O.bodies.append(utils.sphere((x, 1.3, 0), 0.25, mask=mask))
		O.bodies[len(O.bodies) - 1].state.blockedDOFs = "zXY"
	O.engines = [wrapper.ForceResetter(), *grounds, wrapper.NewtonIntegrator(gravity=(0, -9.81, 0))]
	impulse = {0: 0.0, 1: 0.0}
	for _ in range(300):
		O.step()
		for body in impulse:
			impulse[body] += O.forces.f(body)[1] * O.dt
	ahead = [abs(ground.time - O.time) for ground in grounds]
	print(f"after 300 steps O.time = {O.time:.6f} s, the grounds are off by {max(ahead):.1e} s, O.dt {O.dt:.1e} s")
	assert max(ahead) < 101 * O.dt and min(impulse.values()) > 0


def test_a_second_ground_with_a_time_step_of_its_own_choice_follows_as_well():
	grounds = [column(3e5), column(1e7, lower=(3, 0), automaticTimeStep=False)]
	O.engines = grounds
	for _ in range(50):
		O.step()
	assert [ground.time for ground in grounds] == pytest.approx([O.time, O.time], rel=1e-12)


def test_a_side_is_drained_or_impermeable_not_both():
	for names in (("ImpermeableBoundary", "DrainedBoundary"), ("DrainedBoundary", "ImpermeableBoundary")):
		mpm = column(water=wrapper.PoreWater(), boundaries=[getattr(wrapper, name)(region="left") for name in names])
		with pytest.raises(ValueError, match="overlaps") as refusal:
			mpm.initialise()
		assert all(name in str(refusal.value) for name in names)
	print(refusal.value)
	drained = wrapper.DrainedBoundary(region="left", lower=(-1, -1), upper=(9, 0.5))
	closed = wrapper.ImpermeableBoundary(region="left", lower=(-1, 0.5), upper=(9, 9))
	column(water=wrapper.PoreWater(), boundaries=[drained, closed]).initialise()


def frozen(**settings):
	return column(heat=wrapper.HeatTransfer(), freezing=wrapper.FreezingCurve(**settings), water=wrapper.PoreWater())


outOfRange = {
	"half a skeleton": (lambda s: column().addPoints(position=[(0.5, 1.5)], volume=0.01, skeleton=0.5), "skeleton is 0.5"),
	"a skeleton that is no number": (lambda s: column().addPoints(position=[(0.5, 1.5)], volume=0.01, skeleton=math.nan), "skeleton is nan"),
	"no residual water": (lambda s: frozen(residualSaturation=0).initialise(), "FreezingCurve.residualSaturation is 0"),
	"hardly any residual water": (lambda s: frozen(residualSaturation=0.005).initialise(), "FreezingCurve.residualSaturation is 0.005"),
	"no exchange of heat": (
		lambda s: column(
			heat=wrapper.HeatTransfer(), boundaries=[wrapper.SurfaceTemperature(region="surface", temperature=1, heatTransferCoefficient=0)]
		).initialise(),
		"heatTransferCoefficient = 0",
	),
	"an infinite time step of a sample": (lambda s: setattr(s, "dt", math.inf), "RveSample.dt is inf"),
	"friction of bodies in radians": (
		lambda s: column(bodies=wrapper.BodyContact(frictionAngle=0.5)).initialise(),
		"BodyContact.frictionAngle = 0.5: is in degrees",
	),
}


@pytest.mark.parametrize("case", outOfRange)
def test_what_the_pages_exclude_is_refused(case, smallSample):
	do, sentence = outOfRange[case]
	with pytest.raises(ValueError) as refusal:
		do(smallSample.copy())
	print(refusal.value)
	assert sentence in str(refusal.value)


def test_without_water_the_sharp_front_of_neumann_may_leave_no_residual():
	mpm = column(heat=wrapper.HeatTransfer(), freezing=wrapper.FreezingCurve(curve="sharp", residualSaturation=0), motion=False, boundaries=[])
	mpm.initialise()
	assert mpm.initialised


def test_the_angle_of_friction_of_a_body_is_in_degrees():
	"""A sliding block decelerates by Coulomb's law."""
	decelerations = []
	for angle in (10, 20):
		O.reset()
		mpm = column(young=2e7, damping=0.0, bodies=wrapper.BodyContact(frictionAngle=angle, thickness=1))
		O.bodies.append(utils.box((0.5, 1.25, 0), (0.2, 0.2, 0.5), fixed=False))
		block = O.bodies[0]
		block.state.mass, block.state.blockedDOFs = 400.0, "zXYZ"
		O.engines = [wrapper.ForceResetter(), mpm, wrapper.NewtonIntegrator(gravity=(0, -9.81, 0), damping=0.2)]
		while O.time < 0.4:
			O.step()
		block.state.vel = (0.5, 0, 0)
		forces = []
		for _ in range(60):
			O.step()
			forces.append(np.array(O.forces.f(0))[:2])
		sideways, upwards = -np.sum(forces, axis=0)[0], np.sum(forces, axis=0)[1]
		decelerations.append(sideways / upwards)
	print(
		f"tangential over normal force {decelerations[0]:.3f} and {decelerations[1]:.3f}, tangents of 10 and 20 degrees "
		f"{math.tan(math.radians(10)):.3f} and {math.tan(math.radians(20)):.3f}"
	)
	assert decelerations == pytest.approx([math.tan(math.radians(10)), math.tan(math.radians(20))], rel=0.1)


failing = """
import talik
from yade import O, wrapper
mpm = wrapper.MpmEngine(gridSpacing=0.25, lower=(0, 0), upper=(1, 1), skeleton=wrapper.ElasticSkeleton(), picTime=-7)
talik.geometry.fill(mpm, [(0, 0), (1, 0), (1, 1), (0, 1)])
O.engines = [mpm]
{start}
"""


@pytest.mark.parametrize("start", ["O.run(5, True)", "O.step()"])
def test_the_error_of_a_step_is_said_once(start, tmp_path):
	script = tmp_path / "script.py"
	script.write_text(failing.format(start=start))
	run = subprocess.run(["yade", "-n", "-x", str(script)], capture_output=True, text=True, timeout=60, cwd=tmp_path)
	said = run.stdout + run.stderr
	print(f"{start}: the sentence stands {said.count('MpmEngine.picTime is -7')} times, FATAL {said.count('FATAL')} times")
	assert said.count("MpmEngine.picTime is -7") == 1 and "FATAL" not in said and "encountered" not in said and run.returncode != 0


def test_drawings_take_the_bodies_of_the_scene_with_spheres_among_them():
	O.bodies.append([utils.sphere((0, 1, 0), 0.5), utils.box((2, 1, 0), (0.5, 0.5, 0.5)), utils.wall(0, axis=1)])
	axes = talik.plots.figure(4, 4).subplots()
	talik.bodies.draw(axes, O.bodies)
	assert len(axes.lines) == 4 and len(axes.patches) == 2


def test_every_tool_is_there_after_import_talik_alone(tmp_path):
	script = tmp_path / "script.py"
	names = sorted(file.stem for file in (Path(talik.__file__).parent).glob("*.py") if not file.stem.startswith("_"))
	script.write_text(f"import talik\nfor name in {names!r}:\n\tgetattr(talik, name)\nprint('ALL', len({names!r}))\n")
	run = subprocess.run(["yade", "-n", "-x", str(script)], capture_output=True, text=True, timeout=60, cwd=tmp_path)
	assert f"ALL {len(names)}" in run.stdout, run.stderr
