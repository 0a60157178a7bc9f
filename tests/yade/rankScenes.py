# SPDX-License-Identifier: GPL-2.0-or-later
"""Scenes that tests run alone and as ranks:  [mpirun -n 2] yade -n -x rankScenes.py FOLDER SAMPLES SCENE...

Each scene leaves all that can be asked of its ground in FOLDER/<scene>.npz, and each rank the sentence with which a scene stopped."""

import os
import resource
import signal
import sys
from pathlib import Path

import numpy as np
from yade import O, utils, wrapper

import talik
from talik import rve

sys.path.insert(0, str(Path(sys.argv[0]).resolve().parents[1] / "faults"))
from breakingGround import breakingGround, stateOf

folder, cache = Path(sys.argv[1]), sys.argv[2]


def run(steps):
	O.run(steps, True)


def samples():
	"""Two that differ; a third is a copy of the first."""
	packed = rve.pack(rve.prepare(grains=30, porosity=0.19, cache=cache))
	other = packed.copy()
	other.servo(-80e3, -80e3)
	return [packed, other, packed.copy()]


def ground(**attributes):
	mpm = breakingGround(samples()[0], **attributes)
	mpm.skeleton.samples = samples()
	return mpm


def packed(steps=60):
	mpm = ground()
	run(steps)
	return mpm


def creeping():
	"""Ice that is stronger the faster and the colder it is, and creeps."""
	mpm = sampledBands(iceStrength=wrapper.IceStrength(), iceCreep=wrapper.IceCreep(rateFactor=1e-21), strainTolerance=1e-4)
	run(40)
	return mpm


def bodies():
	mpm = ground()
	mpm.bodies = wrapper.BodyContact()
	O.bodies.append(utils.sphere((0.5, 1.3, 0), 0.25))
	O.bodies[0].state.vel = (0, -3, 0)
	O.engines = [wrapper.ForceResetter(), mpm, wrapper.NewtonIntegrator(damping=0, gravity=(0, -9.81, 0))]
	run(40)
	return mpm


def blownUp(mpm, name, point, stepsAfter):
	run(5)
	bad = mpm.skeleton.sample(point)
	bad.dt *= 60
	mpm.skeleton.replaceSample(point, bad)
	sentence = ""
	try:
		run(40)
	except RuntimeError as problem:
		sentence = f"{O.iter} {mpm.time!r} {sorted(mpm.skeleton.blownUp)} {problem}"
	(folder / f"{name}.{talik.ranks.rank}.txt").write_text(sentence)
	mpm.skeleton.onBlowUp = "isolate"
	run(stepsAfter)
	return mpm


def writtenInMidRun(mpm, steps, name):
	run(steps)
	O.tags["id"], O.tags["isoTime"], O.tags["d.id"], O.tags["id.d"] = 4 * ["same"]
	talik.checkpoint.write(folder / name)
	return goOn(mpm)


def goOn(mpm):
	run(25)
	return mpm


def stared():
	"""The first rank alone looks at the ground in every step, and the others do not wait for it."""
	mpm = sampledBands()
	seen = []

	def look():
		if talik.ranks.first:
			seen.append((mpm.mostBroken(3), np.nansum(mpm.field("bondsBroken")), mpm.skeleton.sample(2).statistics()["contacts"]))

	from talik import output

	O.engines = O.engines + [output.runner(look, iterPeriod=1)]
	O.run(60, True)
	O.engines = O.engines[:1]
	assert len(seen) >= 59 if talik.ranks.first else not seen
	return mpm


def asked():
	"""Ranks take turns in looking, each alone, at fields, histories, extremes and samples that others own; what they saw is the result."""
	mpm = sampledBands()
	mpm.watch([0, 7], fields=["bondsBroken", "fabric"])
	for turn in range(6):
		run(10)
		if turn % talik.ranks.count == talik.ranks.count - 1 - talik.ranks.rank:
			np.savez(folder / f"asked{turn}.npz", **everyLook(mpm))
	talik.ranks.meet("all have looked")
	for turn in range(6):
		with np.load(folder / f"asked{turn}.npz") as file:
			looks.update({f"look {turn} {key}": file[key] for key in file.files})
	return mpm


def seenBefore(mpm, points):
	"""Some samples are replaced, and temperatures set, just after rank 0 looked at them alone; the last rank has looked before, alone."""

	def look():
		seen = {"before: temperature": np.array(mpm.field("temperature")), "before: fabric": np.array(mpm.field("fabric"))}
		for point in points:
			with mpm.inspect(point):
				seen[f"before: sample {point}"] = np.array([[*body.state.pos, body.shape.radius] for body in O.bodies])
		return seen

	run(10)
	other = samples()[1]
	if talik.ranks.rank == talik.ranks.count - 1:
		look()
	talik.ranks.meet("the last rank has looked")
	if talik.ranks.first:
		looks.update(look())
	for point in points:
		mpm.skeleton.replaceSample(point, other)
	mpm.setTemperature(-3)
	run(5)
	return mpm


def bandsReplaced():
	return seenBefore(sampledBands(), (2, 100, 190))


def bandsHeated():
	return seenBefore(sampledBands(), ())


def bandedGround(space=False, thrown=False, top=5):
	"""Wet ground of a law that thaws from its surface, its upper half pushed sideways; each rank computes a band of its strips."""
	upright = (0, 0, -9.81) if space else (0, -9.81)
	mpm = wrapper.MpmEngine(
		gridSpacing=0.25,
		lower=(-1, 0, 0) if space else (-1, 0),
		upper=(3, 1, 8) if space else (7.5, top),
		gravity=upright,
		distribute="ground",
		energyLedger=True,
		skeleton=wrapper.MohrCoulombSkeleton(young=2e6, youngFrozen=2e8, cohesion=1e3, cohesionFrozen=1e5, frictionAngle=30),
		heat=wrapper.HeatTransfer(thermalTimeScale=1e5, followsMotion=True),
		freezing=wrapper.FreezingCurve(),
		water=wrapper.PoreWater(),
		boundaries=[
			wrapper.FixedBoundary(region="bottom"),
			wrapper.SurfaceTemperature(region="surface", times=[0, 5e3], values=[-1, 15]),
			wrapper.DrainedBoundary(region="surface"),
		],
	)
	if space:
		sides = [np.arange(0.0625, length, 0.125) for length in (2, 1, 6)]
		position, volume = np.stack(np.meshgrid(*sides, indexing="ij"), axis=-1).reshape(-1, 3), 0.125**3
	else:
		position, volume = talik.geometry.fillPolygon([(0, 0), (6.5, 0), (6.5, 3), (0, 4)], 0.25)
	height = position[:, -1]
	velocity = np.zeros_like(position)
	velocity[:, 0] = 0.4 * height
	if thrown:
		velocity[np.argmax(height), 1] = 100
	mpm.addPoints(position=position, volume=volume, porosity=0.4, temperature=np.where(height > 1.9, 0.5, -1.0), velocity=velocity)
	O.engines = [mpm]
	return mpm


def bands():
	"""Looked at by all ranks, by the first alone and by none; changed by hand."""
	mpm = bandedGround()
	mpm.watch([0, 100], fields=["temperature", "stress"])
	run(150)
	if talik.ranks.first:
		mpm.field("velocity")
	run(7)
	mpm.setTemperature(np.where(mpm.field("position")[:, 0] > 2, -0.2, 0.3))
	run(120)
	return mpm


def bandsInSpace():
	mpm = bandedGround(space=True)
	run(60)
	return mpm


def bandsOfBodies():
	"""A warm ball that falls across the border of two bands, one that comes later, and a plate that is pushed along."""
	mpm = bandedGround()
	mpm.bodies = wrapper.BodyContact()
	mpm.boundaries = mpm.boundaries + [wrapper.BodyTemperature(bodies=[0], temperature=20)]
	O.bodies.append([utils.sphere((3.2, 3.75, 0), 0.25), utils.box((5.5, 3.55, 0), (0.4, 0.2, 0.5))])
	O.bodies[0].state.vel, O.bodies[1].state.vel = (1, -2, 0), (1, -0.5, 0)
	O.engines = [wrapper.ForceResetter(), mpm, wrapper.NewtonIntegrator(damping=0, gravity=(0, -9.81, 0))]
	run(120)
	O.bodies.append(utils.sphere((1.5, 4.1, 0), 0.2))
	run(120)
	looks.update({f"body {body.id}": np.array([*body.state.pos, *body.state.vel, *O.forces.f(body.id)]) for body in O.bodies})
	return mpm


def bandsOfIceRichGround():
	mpm = bandedGround()
	mpm.materials = [wrapper.GroundMaterial(thawStrain=0.05)]
	run(230)
	return mpm


def bandsCheckpoint():
	return writtenInMidRun(bandedGround(), 60, "bands.checkpoint")


def bandsResumed():
	return goOn(talik.resume(folder / "bands.checkpoint"))


def bandsUnderRoom():
	"""The upper two thirds of the box are empty: the last of three ranks has strips without points."""
	return writtenInMidRun(bandedGround(top=12), 205, "room.checkpoint")


def bandsUnderRoomResumed():
	return goOn(talik.resume(folder / "room.checkpoint"))


def softLaw(step):
	"""Of products of matrices and functions whose last bits may depend on how many points they see at once."""
	stiffness = np.diag([4e6, 4e6, 4e6, 2e6]) + np.array([[0, 1, 1, 0], [1, 0, 1, 0], [1, 1, 0, 0], [0, 0, 0, 0]]) * 2e6
	step.state[:, 0] += np.tanh(np.abs(step.strain).sum(axis=1))
	step.stress += np.exp(step.iceSaturation)[:, None] * (step.strain @ stiffness)


def bandsOfScripts():
	"""A law and boundaries in Python: on the surface, which the ground leaves and thaws, and in a disc across the border of two bands."""
	mpm = bandedGround()
	mpm.skeleton = wrapper.PythonSkeleton(law=softLaw, modulus=3e7, states=["strained"], canFail=False)
	mpm.boundaries = mpm.boundaries + [
		wrapper.PythonBoundary(region="surface", function=lambda nodes: 200 - 5.67e-8 * ((nodes.temperature + 273.15) ** 4 - 260**4)),
		wrapper.PythonBoundary(region="surface", gives="traction", function=lambda nodes: -200 * nodes.velocity - 50 * nodes.normal),
		wrapper.PythonBoundary(
			region="disc", lower=(2.4, 0.7), upper=(4, 2.3), function=lambda nodes: 10 * np.sin(nodes.position[:, 0]) + nodes.pressure * 1e-4
		),
	]
	run(230)
	return mpm


def bandsShaken():
	"""Dry ground, a law in Python for the half of it, and a box that is shaken by the mean velocity in it."""
	mpm = bandedGround()
	mpm.water, mpm.boundaries = None, mpm.boundaries[:2]
	function = lambda nodes: np.zeros_like(nodes.velocity) - 5 * nodes.velocity.mean(axis=0)
	mpm.boundaries = mpm.boundaries + [wrapper.PythonBoundary(region="box", lower=(1, 0.5), upper=(5, 2), gives="acceleration", function=function)]
	scripted = wrapper.PythonSkeleton(law=softLaw, modulus=3e7, states=["strained"], canFail=False)
	mpm.exchangeSkeletons([mpm.skeleton, scripted], [int(k % 3 == 0) for k in range(mpm.pointCount)])
	run(230)
	return mpm


def bandsLawFails():
	"""A law that fails at one point, of one band; what is left of the ground is not looked at."""

	def failing(step):
		if O.iter == 12 and (step.id == 40).any():
			raise ValueError("there is no such soil")
		softLaw(step)

	mpm = bandedGround()
	mpm.skeleton = wrapper.PythonSkeleton(law=failing, modulus=3e7, states=["strained"], canFail=False)
	sentence = ""
	try:
		run(30)
	except RuntimeError as problem:
		sentence = f"{O.iter} {problem}"
	(folder / f"bandsLawFails.{talik.ranks.rank}.txt").write_text(sentence)
	mpm = bandedGround()
	run(1)
	return mpm


def bandsThrough():
	mpm = bandedGround()
	run(75)
	return mpm


def bandsKept():
	"""All ranks write a checkpoint in every step. The last rank cannot for a while, which does not stop the run, and then dies while it writes."""
	mpm = bandedGround()
	keeper = talik.checkpoint.keep(folder / "kept.checkpoint", every=0)
	last = talik.ranks.rank == talik.ranks.count - 1
	run(50)
	if last:
		resource.setrlimit(resource.RLIMIT_FSIZE, (8192, resource.RLIM_INFINITY))  # python ignores the signal of it
	run(3)
	if last:
		resource.setrlimit(resource.RLIMIT_FSIZE, (resource.RLIM_INFINITY, resource.RLIM_INFINITY))
	if talik.ranks.first:
		(folder / "kept.txt").write_text(f"{keeper.failures} {keeper.problem}")
	run(7)
	if last:
		signal.signal(signal.SIGXFSZ, signal.SIG_DFL)
		resource.setrlimit(resource.RLIMIT_CORE, (0, 0))
		resource.setrlimit(resource.RLIMIT_FSIZE, (8192, resource.RLIM_INFINITY))
	run(10)
	return mpm


def bandsKeptResumed():
	mpm = talik.resume(folder / "kept.checkpoint")
	O.engines = [mpm]
	run(75 - O.iter)
	return mpm


def bandsLeft():
	"""A point of one band leaves the box."""
	mpm = bandedGround(thrown=True)
	sentence = ""
	try:
		run(400)
	except RuntimeError as problem:
		sentence = f"{O.iter} {mpm.time!r} {problem}"
	(folder / f"bandsLeft.{talik.ranks.rank}.txt").write_text(sentence)
	return mpm


def sampledBands(space=False, size=0.125, long=6.5, stretch=0, **ofSkeleton):
	"""A long block whose points have samples, sheared and so fast that points go from band to band."""
	mpm = ground(**ofSkeleton)
	mpm.boundaries = [wrapper.RollerBoundary(region="bottom"), *mpm.boundaries[1:]]
	sheared = wrapper.MpmEngine(
		gridSpacing=0.25,
		lower=(-1, 0, 0) if space else (-1, 0),
		upper=(8, 0.5, 1.5) if space else (8, 2),
		gravity=(0, 0, -9.81) if space else (0, -9.81),
		distribute="ground",
		**{name: getattr(mpm, name) for name in ("damping", "energyLedger", "skeleton", "heat", "freezing", "water", "boundaries")},
	)
	sheared.pointsDivide = stretch > 0
	sides = [np.arange(0.5 * size, length, size) for length in ((long, 0.25, 0.5) if space else (long, 0.5))]
	position = np.stack(np.meshgrid(*sides, indexing="ij"), axis=-1).reshape(-1, len(sides))
	velocity = np.zeros_like(position)
	velocity[:, 0] = 10 + 12 * position[:, -1] + stretch * position[:, 0]
	sheared.addPoints(position=position, volume=size ** len(sides), porosity=0.4, temperature=-1.0, velocity=velocity)
	O.engines = [sheared]
	return sheared


def bandsOfSamples():
	"""Copies, bonds that break and melt, points that cross; looked at by all ranks, by the first alone and by none, and changed by hand."""
	mpm = sampledBands()
	mpm.watch([0, 7], fields=["bondsBroken", "fabric", "stress"])
	run(210)
	if talik.ranks.first:
		mpm.mostBroken(3)
		mpm.skeleton.sample(100)
	run(3)
	mpm.setTemperature(np.where(mpm.field("position")[:, 0] > 3, 1.0, -1.0))
	mpm.skeleton.replaceSample(3, mpm.skeleton.sample(190))
	with mpm.inspect(150, live=True):
		O.bodies[3].state.vel = (1e-3, 0, 0)
	run(40)
	mpm.setTemperature(-2)
	run(160)
	looks.update(everyLook(mpm))
	return mpm


def bandsOfSpheres():
	mpm = sampledBands(space=True)
	mpm.skeleton.samples = [rve.pack(rve.prepare(grains=100, dimension=3, ice=True, cache=cache))]
	run(220)
	return mpm


def bandsToTolerance():
	mpm = sampledBands()
	mpm.tolerance = 0.03
	run(230)
	return mpm


def bandsExchanged():
	mpm = sampledBands()
	run(60)
	soft, fresh = wrapper.ElasticSkeleton(young=5e6, poisson=0.2), wrapper.RveSkeleton(samples=samples()[:1])
	mpm.exchangeSkeletons([mpm.skeleton, soft, fresh], [int(k % 5 == 0) + 2 * int(k % 7 == 1 and k % 5 != 0) for k in range(mpm.pointCount)])
	run(210)
	for law in (mpm.skeletons[0], fresh):
		looks.update(
			{f"sample {point}": np.frombuffer(law.sample(point).stateBytes, np.uint8) for point in range(0, mpm.pointCount, 3) if law.hasSample(point)}
		)
	return mpm


def bandsBlowUp():
	return blownUp(sampledBands(blowUpFolder=str(folder / "blownInBands")), "bandsBlowUp", point=170, stepsAfter=220)


def bandsOfSamplesCheckpoint():
	return writtenInMidRun(sampledBands(), 205, "samplesOfBands.checkpoint")


def bandsOfSamplesResumed():
	return goOn(talik.resume(folder / "samplesOfBands.checkpoint"))


def withSamples(mpm):
	looks.update({f"sample {point}": np.frombuffer(mpm.skeleton.sample(point).stateBytes, np.uint8) for point in range(0, mpm.pointCount, 3)})
	return mpm


def bandsDividing():
	"""One point a cell, drawn out: points divide, and their samples with them."""
	mpm = sampledBands(size=0.25, long=3, stretch=12)
	given = mpm.pointCount
	mpm = writtenInMidRun(mpm, 205, "dividing.checkpoint")
	assert mpm.pointCount >= given + 5 and len(mpm.field("volume")) == mpm.pointCount, mpm.pointCount
	return withSamples(mpm)


def bandsDividingResumed():
	return withSamples(goOn(talik.resume(folder / "dividing.checkpoint")))


looks = {}


def everyLook(mpm):
	seen = {name: np.array(mpm.field(name)) for name in ("bondsBroken", "fabric", "samplePorosity", "stress")}
	seen.update({f"history {name}": values for name, values in mpm.history(7).items()})
	seen["mostBroken"] = np.array(mpm.mostBroken(3))
	seen["most"] = np.array(mpm.most("contacts", 3))
	for point in (0, 5, 9):
		with mpm.inspect(point):
			seen[f"sample {point}"] = np.array([[*body.state.pos, *body.state.vel, body.shape.radius] for body in O.bodies])
	return seen


for name in sys.argv[3:]:
	O.reset()
	O.engines = []
	mpm = globals()[name]()
	state = stateOf(mpm)
	if mpm.watched is not None:
		state.update({f"history {point} {field}": values for point in mpm.watched.ids for field, values in mpm.history(point).items()})
	state.update(looks)
	looks.clear()
	sampled = [law for law in (mpm.skeleton, *mpm.skeletons) if isinstance(law, wrapper.RveSkeleton)]
	shared = sampled[0].cost() if sampled else {}
	if talik.ranks.first:
		np.savez(folder / f"{name}.npz", **state)
	print("FIGURES", name, shared.get("moved", 0), shared.get("balance", 1), talik.ranks.traffic()["messages"], flush=True)
	(folder / f"{name}.{talik.ranks.rank}.of.{talik.ranks.count}").write_text(os.environ.get("OMP_NUM_THREADS", "1"))
