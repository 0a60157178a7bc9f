# SPDX-License-Identifier: GPL-2.0-or-later
"""Scenes of a user's own as samples, of any law and shape that stock YADE runs: held against stock YADE on the same path."""

import functools
import itertools
import sys
from pathlib import Path

import numpy as np
import pytest
from fixtures import sixtySpheres
from yade import Matrix3, O, Vector3, pack, utils, wrapper

import talik
from talik import packing

sys.path.insert(0, str(Path(__file__).parents[2] / "examples"))
import own_sample
from own_sample import pressure


def addClumps(cloud):
	for centre, r in cloud:
		clump, _ = O.bodies.appendClumped([utils.sphere(Vector3(*centre) + Vector3(d * r, 0, 0), 0.7 * r) for d in (-0.3, 0.3)])
		O.bodies[clump].state.blockedDOFs = "zXY"


@functools.lru_cache(maxsize=None)
def ownScene(kind):
	laws = {"cohesive": own_sample.cohesive, "Hertz-Mindlin": own_sample.hertzMindlin}
	return own_sample.ownScene(laws.get(kind, own_sample.frictional), 24, addClumps if kind == "clumps" else own_sample.addDiscs)


def inPlane(xx, xy, yx, yy):
	return Matrix3(xx, xy, 0, yx, yy, 0, 0, 0, 0)


def stressAcrossTheCell():
	"""Of the forces that cross the boundary of the cell: in equilibrium the stress, wherever inside a body they act."""
	total = np.zeros((3, 3))
	for i in O.interactions:
		if i.isReal:
			total -= np.outer(i.phys.normalForce + i.phys.shearForce, O.cell.hSize * Vector3(*i.cellDist)) / O.cell.volume
	return 0.5 * (total + total.T)


def touchingPairs():
	"""Pairs of spheres of different bodies that overlap, by looking at every pair and every image."""
	h, pairs = np.array(O.cell.hSize), set()
	images = [h @ (i, j, 0) for i in range(-2, 3) for j in range(-2, 3)]
	spheres = [(body.id, np.array(O.cell.wrap(body.state.pos)), body.shape.radius, body.clumpId) for body in O.bodies if isinstance(body.shape, wrapper.Sphere)]
	for (a, x, r, c), (b, y, s, d) in itertools.combinations(spheres, 2):
		if (c < 0 or c != d) and min(np.linalg.norm(y - x + image) for image in images) < (r + s) * (1 - 1e-9):
			pairs.add((a, b))
	return pairs


kinds = ("Cundall-Strack", "cohesive", "Hertz-Mindlin", "clumps")


@pytest.mark.parametrize("kind", kinds)
def test_stress_and_every_grain_are_those_of_stock_yade_on_the_same_path(kind):
	"""Also where clumps lose all contacts and their stress: open samples do what YADE does."""
	opened = wrapper.OpenRveSample(source=ownScene(kind))
	path = [inPlane(0, 2e-3, 0, 0), inPlane(-1e-3, 0, 1e-3, 1e-3), inPlane(5e-3, 0, 0, 5e-3)]
	results = [opened.apply(gradient, 0) for gradient in path]
	with talik.inspect(opened.scene):
		ours = np.array([body.state.pos for body in O.bodies])
		across, byYade, contacts = stressAcrossTheCell(), np.array(utils.getStress()), sum(i.isReal for i in O.interactions)
	with talik.scratchScene():
		O.stringToScene(textOf(ownScene(kind)))
		for gradient, result in zip(path, results):
			steps = result["steps"] - 1
			rate = np.zeros((3, 3))
			rate[:2, :2] = rootIncrement(np.eye(2) + np.array(gradient)[:2, :2], steps) / O.dt
			O.cell.velGrad = Matrix3(*rate.ravel())
			packing.advance(steps)
			O.cell.velGrad = Matrix3.Zero
			packing.advance(1)
		theirs, stock = np.array([body.state.pos for body in O.bodies]), np.array(utils.getStress())
	apart, scale = np.abs(ours - theirs).max(), pressure
	print(
		f"\n{kind}: {sum(r['steps'] for r in results)} steps, stresses "
		f"{[round(-r['stress'].trace() / 2) for r in results]} Pa, {contacts} contacts left; grains {apart:.1e} m from "
		"stock YADE's, "
		f"stress off stock YADE's by {np.abs(byYade - stock).max() / scale:.1e}, off the forces across the cell by "
		f"{np.abs(np.array(opened.stress) - across).max() / scale:.1e} of {scale:g} Pa"
	)
	assert apart < 1e-9 and np.abs(byYade - stock).max() < 1e-4 * scale
	assert not any(r["blewUp"] for r in results) and -results[0]["stress"].trace() / 2 > 0.3 * pressure
	assert np.abs(np.array(opened.stress) - across).max() < 2e-2 * scale


def textOf(scene):
	with talik.inspect(scene):
		return O.sceneToString()


def rootIncrement(matrix, steps):
	"""(1 + H)^(1/steps) - 1."""
	import scipy.linalg

	return scipy.linalg.fractional_matrix_power(matrix, 1 / steps) - np.eye(2)


@pytest.mark.parametrize("kind", kinds)
def test_after_a_flip_of_its_cell_a_sample_goes_on_finding_all_contacts(kind):
	opened = wrapper.OpenRveSample(source=ownScene(kind), maxStrainPerStep=1e-4, maxInertialNumber=1e9)
	flips, found = 0, 0
	for k in range(50):
		result = opened.apply(inPlane(-5e-4 if k < 25 else 0, 4e-2, 0, -5e-4 if k < 25 else 0), 0)
		assert not result["blewUp"]
		flips += result["flipped"]
		if flips == 0 or k % 4:
			continue
		with talik.inspect(opened.scene):
			touching = touchingPairs()
			known = {tuple(sorted((i.id1, i.id2))) for i in O.interactions if i.isReal}
		found += len(touching)
		assert touching <= known, f"after step {k} pairs {sorted(touching - known)} overlap without a contact"
	print(f"\n{kind}: {flips} flips, {found} touching pairs looked at after them, each is a contact")
	assert flips >= 2 and found > 100


@pytest.mark.parametrize("kind", kinds[1:])
def test_the_user_is_told_once_that_samples_run_open_and_what_that_costs(kind, capfd):
	mpm = wrapper.MpmEngine(gridSpacing=0.5, skeleton=wrapper.RveSkeleton(scenes=[ownScene(kind)]))
	mpm.addPoints(position=[(0.25, 0.25), (0.75, 0.25)], volume=0.25, velocity=[(0.1, 0), (-0.1, 0)])
	O.engines = [mpm]
	O.run(30, True)
	told = [line for line in capfd.readouterr().err.splitlines() if line.startswith("RveSkeleton:")]
	print(f"\n{told[0]}\n{mpm.skeleton.cost()['calls']} calls")
	assert len(told) == 1 and "run open" in told[0] and "times as long" in told[0] and "cannot be packed" in told[0]
	assert mpm.skeleton.cost()["form"] == "open" and mpm.skeleton.cost()["calls"] > 0 and np.isfinite(mpm.field("stress")).all()


@pytest.mark.parametrize("kind", kinds)
def test_a_scene_of_any_law_is_brought_to_another_stress_and_the_given_one_stays(kind):
	scene, goal = ownScene(kind), (-6e3, -9e3, 0)
	before = talik._talik.sceneBytes(scene)
	banded = talik.rve.servo(scene, goal[0], goal[1])
	with talik.inspect(banded):
		reached, unbalanced = packing.stress(), utils.unbalancedForce()
	off = np.abs(reached - goal).max() / 7.5e3
	print(f"{kind}: {np.round(reached, 1)} Pa, off by {off:.1e} of the mean pressure; tolerance 2e-3; unbalanced force {unbalanced:.1e}")
	assert off < 2.1e-3 and unbalanced < 1e-2 and talik._talik.sceneBytes(scene) == before


def test_scenes_of_a_users_law_are_settled_at_the_weight_above_their_points_and_begin_there():
	block = talik.geometry.rectangle(0, 0, 1, 1)

	def column(form):
		scenes = [ownScene("Hertz-Mindlin"), ownScene("Cundall-Strack")]
		mpm = wrapper.MpmEngine(
			gridSpacing=0.5,
			lower=(0, 0),
			upper=(1, 2),
			gravity=(0, -9.81),
			skeleton=wrapper.RveSkeleton(scenes=scenes, form=form, sampleOf=[k % 2 for k in range(16)]),
			boundaries=[wrapper.RollerBoundary(region=side) for side in ("left", "right", "bottom")],
		)
		talik.geometry.fill(mpm, block, porosity=0.2)
		return mpm

	mpm = column("open")
	(before,) = talik.check(mpm) or [""]
	talik.slope.settle(mpm, block, lateralRatio=0.8)
	depth, weight = 1 - mpm.field("position")[:, 1], 9.81 * 2650 * 0.8
	band = 0.5 * (np.floor(depth / 0.5) + 0.5)
	ratio = mpm.field("stress")[:, 1] / (-weight * band)
	law = mpm.skeleton
	print(f"{len(law.samples)} samples and {len(law.scenes)} scenes; vertical stress over that of the weight {ratio.min():.4f} to {ratio.max():.4f}; {before}")
	assert abs(ratio - 1).max() < 5e-3 and (len(law.samples), len(law.scenes)) == (2, 2) and talik.check(mpm) == []


def test_a_loaded_file_is_brought_to_another_stress_and_kept(tmp_path):
	with talik.scratchScene():
		talik._talik.exchangeScene(ownScene("Hertz-Mindlin"))
		O.save(str(tmp_path / "own.yade.gz"))
	sample = talik.rve.servo(talik.rve.load(tmp_path / "own.yade.gz"), -5e3, -7e3, cache=str(tmp_path))
	print(sample)
	assert np.allclose(sample.stress, (-5e3, -7e3, 0), atol=15)
	assert talik.rve.servo(talik.rve.load(tmp_path / "own.yade.gz"), -5e3, -7e3, cache=str(tmp_path)) == sample


def test_a_scene_that_can_neither_be_packed_nor_run_open_is_refused_with_both_reasons():
	with talik.scratchScene():
		talik._talik.exchangeScene(talik._talik.objectFromBytes(talik._talik.objectToBytes(ownScene("Cundall-Strack"))))
		O.engines = O.engines + [wrapper.PeriTriaxController()]
		with pytest.raises(ValueError, match="cannot be packed: .* PeriTriaxController, and it cannot run open: .*remove it or set dead=True") as refusal:
			talik.rve.pack(O._sceneObj)
	print(refusal.value)


def test_spheres_behind_points_in_the_plane_are_told_of_whether_they_are_packed_or_open(sampleCache, capfd):
	spheres = talik.rve.pack(talik.rve.prepare(**sixtySpheres, cache=sampleCache))
	mpm = wrapper.MpmEngine(gridSpacing=0.5, skeleton=wrapper.RveSkeleton(samples=[spheres]))
	mpm.addPoints(position=[(0.1, 0.1)], volume=0.25)
	with pytest.raises(ValueError, match=r"has spheres and the ground is in the plane: .* run it open, RveSkeleton\(scenes=\[sample.open\(\)\]\)"):
		mpm.initialise()
	mpm.skeleton = wrapper.RveSkeleton(scenes=[spheres.open()], form="open")
	capfd.readouterr()
	mpm.initialise()
	told = capfd.readouterr().err
	print(told)
	assert told.count("samples of spheres behind points in the plane run open only") == 1


def test_spheres_with_a_law_of_ones_own_reach_a_stress_of_six_components_and_carry_ground_in_space_slow():
	"""What the recipe says of space: a cube longer than four radii, grains that may turn, the law of the user."""
	goal = np.array((-10e3, -12e3, -15e3, 0, 0, 1e3))
	with talik.scratchScene():
		O.periodic = True
		O.cell.hSize = Matrix3(0.055, 0, 0, 0, 0.055, 0, 0, 0, 0.055)
		O.materials.append(wrapper.FrictMat(young=5e7, poisson=0.3, frictionAngle=0.5, density=2650))
		cloud = pack.SpherePack()
		cloud.makeCloud((0, 0, 0), (0.055, 0.055, 0.055), rMean=5e-3, rRelFuzz=0.2, num=80, periodic=True, seed=1)
		cloud.toSimulation()
		law = [wrapper.Ig2_Sphere_Sphere_ScGeom()], [wrapper.Ip2_FrictMat_FrictMat_MindlinPhys()], [wrapper.Law2_ScGeom_MindlinPhys_Mindlin()]
		collider = wrapper.InsertionSortCollider([wrapper.Bo1_Sphere_Aabb()])
		O.engines = [wrapper.ForceResetter(), collider, wrapper.InteractionLoop(*law), wrapper.NewtonIntegrator(damping=0.3)]
		O.dt = 0.3 * utils.PWaveTimeStep()
		packing.servoStress(None, goal, maxStrain=1)
		reached, mine = packing.stress(), O._sceneObj
	print(f"stress {np.round(reached)} Pa, goal {goal}; tolerance 2e-3 of the mean")
	assert np.abs(reached - goal).max() < 2.1e-3 * 12.4e3
	mpm = wrapper.MpmEngine(
		gridSpacing=0.5, lower=(0, 0, 0), upper=(1, 1, 1.5), gravity=(0, 0, -9.81), skeleton=wrapper.RveSkeleton(scenes=[mine]),
		boundaries=[wrapper.FixedBoundary(region=side) for side in ("left", "right", "front", "back", "bottom")],
	)  # fmt: skip
	talik.geometry.fill(mpm, talik.solids.box((0, 0, 0), (1, 1, 1)), pointsPerCell=1, porosity=0.4)
	O.engines = [mpm]
	O.run(3, True)
	stress = mpm.field("stress")
	print(f"{mpm.pointCount} points, mean stress {np.round(stress.mean(axis=0))} Pa")
	assert stress.shape == (mpm.pointCount, 6) and np.abs(stress - goal).max() < 0.1 * 15e3
