# SPDX-License-Identifier: GPL-2.0-or-later
"""What goes wrong in one place stays there: a sample that explodes, points that leave the grid, a step that cannot be ended."""

import sys
from pathlib import Path

import numpy as np
import pytest
from yade import O, wrapper

import talik

sys.path.insert(0, str(Path(__file__).parent))
from breakingGround import breakingGround, largestDifference, run, stateOf

poisoned = 5  # point whose sample explodes


def withPoison(sample, folder, **ofSkeleton):
	"""Ground in mid-run, one of whose samples has a time step far beyond its critical one."""
	mpm = breakingGround(sample, blowUpFolder=str(folder), **ofSkeleton)
	run(5)
	bad = mpm.skeleton.sample(poisoned)
	bad.dt *= 60
	mpm.skeleton.replaceSample(poisoned, bad)
	return mpm, bad.stateBytes


def runToBlowUp(steps=40):
	with pytest.raises(RuntimeError) as blowUp:
		run(steps)
	return str(blowUp.value)


def test_a_sample_that_explodes_stops_the_run_after_a_whole_step_and_is_named_and_kept(tmp_path, smallSample):
	mpm, _ = withPoison(smallSample, tmp_path / "blown")
	sentence = runToBlowUp()
	print(sentence)
	assert f"point {poisoned} blew up" in sentence and mpm.failure == sentence and list(mpm.skeleton.blownUp) == [poisoned]
	assert mpm.time == pytest.approx(O.time, rel=1e-12) and O.subStep == -1
	for name in mpm.fieldNames():
		assert np.isfinite(mpm.field(name)).all(), name
	file = tmp_path / "blown" / f"point{poisoned}.yade"
	with talik.scratchScene():
		O.load(str(file), quiet=True)
		positions = np.array([body.state.pos for body in O.bodies])
		print(f"its last good state is a YADE scene of {len(O.bodies)} grains and {len(list(O.interactions))} interactions in {file.name}")
		assert len(O.bodies) == 30 and np.isfinite(positions).all() and O.periodic
	steps = O.iter
	mpm.skeleton.onBlowUp = "isolate"
	run(10)
	assert O.iter == steps + 10 and np.isfinite(mpm.field("stress")).all()


def test_an_isolated_point_keeps_its_stress_and_the_others_are_not_harmed(tmp_path, smallSample):
	breakingGround(smallSample)
	run(30)
	healthy = O.engines[0].field("position")
	O.reset()
	mpm, before = withPoison(smallSample, "", onBlowUp="isolate")
	while not mpm.skeleton.blownUp:
		run(1)
	stress = mpm.field("stress")[poisoned]
	run(30 - O.iter)
	moved = np.linalg.norm(mpm.field("position") - healthy, axis=1)
	print(
		f"after {O.iter} steps: point {poisoned} holds {stress.round(1)} Pa; the others are within {np.delete(moved, poisoned).max():.1e} m of a run without poison"
	)
	assert (mpm.field("stress")[poisoned] == stress).all()
	assert list(mpm.skeleton.blownUp) == [poisoned] and np.isfinite(moved).all() and moved.max() < 0.05
	assert mpm.skeleton.sample(poisoned).stateBytes == before


def test_an_isolated_point_stays_so_after_resuming(tmp_path, smallSample):
	mpm, _ = withPoison(smallSample, "", onBlowUp="isolate")
	while not mpm.skeleton.blownUp:
		run(1)
	talik.checkpoint.write(tmp_path / "x")
	run(10)
	through, named = stateOf(mpm), mpm.skeleton.blownUp
	O.reset()
	mpm = talik.resume(tmp_path / "x")
	run(10)
	assert mpm.skeleton.blownUp == named and list(named) == [poisoned]
	assert largestDifference(through, stateOf(mpm)) == 0


def flying(**settings):
	"""A wet block that warms while it flies towards the wall of its box, unsupported."""
	mpm = wrapper.MpmEngine(
		gridSpacing=0.25,
		lower=(0, 0),
		upper=(2, 2),
		energyLedger=True,
		skeleton=wrapper.ElasticSkeleton(young=5e6),
		heat=wrapper.HeatTransfer(thermalTimeScale=1e4, source=100),
		water=wrapper.PoreWater(),
		boundaries=[wrapper.SurfaceTemperature(region="surface", temperature=20)],
		**settings,
	)
	position, volume = talik.geometry.fillPolygon(talik.geometry.rectangle(0.5, 0.5, 1, 1), 0.25)
	mpm.addPoints(position=position, volume=volume, temperature=1.0, velocity=(20, 0))
	O.engines = [mpm]
	return mpm


def test_points_that_leave_the_grid_are_named_and_the_run_goes_on_from_its_last_checkpoint(tmp_path):
	mpm = flying()
	run(10)
	talik.checkpoint.write(tmp_path / "x")
	before = stateOf(mpm)
	with pytest.raises(RuntimeError) as left:
		run(5000)
	print(left.value)
	assert "left the grid's box" in str(left.value) and "enlarge the box" in str(left.value)
	assert O.subStep == -1
	with pytest.raises(RuntimeError, match="ended half way.*go on from a checkpoint"):
		O.step()
	O.reset()
	mpm = talik.resume(tmp_path / "x")
	assert largestDifference({k: before[k] for k in ("position", "velocity")}, {k: mpm.field(k) for k in ("position", "velocity")}) == 0
	run(1)


def test_the_error_of_a_background_run_is_not_lost_when_the_run_ends_before_it_is_waited_for():
	import time

	mpm = flying()
	O.run(5000)
	while O.running:
		time.sleep(0.01)
	with pytest.raises(RuntimeError, match="left the grid's box"):
		O.wait()
	print(mpm.failure)
	assert "left the grid's box" in mpm.failure


def test_points_that_rest_against_the_walls_of_the_box_do_not_leave_it():
	mpm = wrapper.MpmEngine(
		gridSpacing=0.25,
		lower=(0, 0),
		upper=(1, 1),
		gravity=(3, -10),
		skeleton=wrapper.ElasticSkeleton(young=1e6),
		boundaries=[wrapper.RollerBoundary(region=side) for side in ("left", "right", "bottom", "top")],
	)
	rng = np.random.default_rng(3)
	position = rng.uniform(0, 1, (60, 2))
	position[:8] = [(0, 0), (1, 0), (0, 1), (1, 1), (0, 0.5), (1, 0.5), (0.5, 0), (0.5, 1)]
	mpm.addPoints(position=position, volume=1 / 60, velocity=rng.uniform(-5, 5, (60, 2)))
	O.engines = [mpm]
	run(500)
	assert O.iter == 500 and np.isfinite(mpm.field("stress")).all()


def test_a_run_that_became_unstable_says_so_in_that_step_with_the_remedy():
	mpm = flying()
	run(3)
	mpm.gravity = (0, -1e308)
	with pytest.raises(RuntimeError) as unstable:
		run(50)
	print(unstable.value)
	assert "in step 3 is not a number: the run became unstable" in str(unstable.value) and "use a smaller time step" in str(unstable.value)
