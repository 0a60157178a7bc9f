# SPDX-License-Identifier: GPL-2.0-or-later
"""A bank of ground behind whose points stand samples of your own: any YADE scene with a periodic cell, whatever its law.

	scripts/run own_sample [--preset test|draft]

Two samples of discs are made with YADE's own classes and engines, and with nothing of Talik: one with the cohesive-frictional law
(CohFrictMat, Law2_ScGeom6D_CohFrictPhys_CohesionMoment), one with Hertz-Mindlin contacts (MindlinPhys). The same vertical bank
stands on the first and slides on the second. Laws that the packed form does not know run open: a YADE scene behind every point,
stepped by its own engines; RveSkeleton says so once. What that costs is measured here, with discs that can run in both forms.
"""

import argparse
import time
from pathlib import Path

import numpy as np
from yade import Matrix3, O, Vector3, pack, utils, wrapper

import talik
from talik import output, packing, plots
from talik.files import writableFolder
from talik.running import runUntil

presets = {"test": (20, 0.5, 0.02, 10), "draft": (24, 0.25, 0.45, 100)}  # grains, grid spacing [m], end time [s], calls that are timed

radius, pressure = 5e-3, 10e3  # mean radius [m]; what the samples are compacted to [Pa]
contact = dict(young=5e7, poisson=0.3, frictionAngle=0.5, density=2650)


# --- two scenes of your own ------------------------------------------------------------------------------------------------


def cohesive():
	material = wrapper.CohFrictMat(isCohesive=True, normalCohesion=2e6, shearCohesion=2e6, momentRotationLaw=True, **contact)
	contacts = wrapper.InteractionLoop(
		[wrapper.Ig2_Sphere_Sphere_ScGeom6D()],
		[wrapper.Ip2_CohFrictMat_CohFrictMat_CohFrictPhys(setCohesionOnNewContacts=True)],
		[wrapper.Law2_ScGeom6D_CohFrictPhys_CohesionMoment()],
	)
	return material, contacts


def hertzMindlin():
	contacts = wrapper.InteractionLoop(
		[wrapper.Ig2_Sphere_Sphere_ScGeom()], [wrapper.Ip2_FrictMat_FrictMat_MindlinPhys()], [wrapper.Law2_ScGeom_MindlinPhys_Mindlin()]
	)
	return wrapper.FrictMat(**contact), contacts


def frictional():
	"""Cundall and Strack's law: the one that runs packed as well as open."""
	contacts = wrapper.InteractionLoop(
		[wrapper.Ig2_Sphere_Sphere_ScGeom()], [wrapper.Ip2_FrictMat_FrictMat_FrictPhys()], [wrapper.Law2_ScGeom_FrictPhys_CundallStrack()]
	)
	return wrapper.FrictMat(**contact), contacts


def addDiscs(cloud):
	cloud.toSimulation()
	for body in O.bodies:
		body.state.blockedDOFs = "zXY"


def ownScene(law, grains, addGrains=addDiscs):
	"""Grains in a periodic cell, one layer, compacted by PeriTriaxController and left at rest: a Scene."""
	with talik.scratchScene():
		O.periodic = True
		side = 2.4 * radius * np.sqrt(grains)
		O.cell.hSize = Matrix3(side, 0, 0, 0, side, 0, 0, 0, 10 * radius)
		material, contacts = law()
		O.materials.append(material)
		cloud = pack.SpherePack()
		cloud.makeCloud(Vector3(0, 0, radius), Vector3(side, side, radius), rMean=radius, rRelFuzz=0.3, num=grains, periodic=True, seed=1)
		addGrains(cloud)
		triax = wrapper.PeriTriaxController(
			goal=(-pressure, -pressure, 0), stressMask=3, dynCell=True, mass=0.2, maxStrainRate=(3, 3, 0), maxUnbalanced=1e9, relStressTol=1e-2
		)
		O.engines = [
			wrapper.ForceResetter(),
			wrapper.InsertionSortCollider([wrapper.Bo1_Sphere_Aabb()]),
			contacts,
			triax,
			wrapper.NewtonIntegrator(damping=0.3),
		]
		O.dt = 0.3 * utils.PWaveTimeStep()
		for _ in range(200):
			packing.advance(500)
			if utils.unbalancedForce() < 0.01 and abs(utils.getStress().trace() / 2 + pressure) < 0.05 * pressure:
				break
		O.engines = [engine for engine in O.engines if not isinstance(engine, wrapper.PeriTriaxController)]
		O.cell.velGrad = Matrix3.Zero
		packing.advance(2000)
		O.cell.trsf = Matrix3.Identity
		print(f"{law.__name__}: {len(O.bodies)} bodies at {-utils.getStress().trace() / 2e3:.2f} kPa")
		return O._sceneObj


# --- the price -------------------------------------------------------------------------------------------------------------


def secondsPerCall(makeSample, calls):
	"""Of a sample sheared to 2 % in small calls, as a ground makes them; the fastest of three, whatever else the machine does."""
	fastest = np.inf
	for _ in range(3):
		sample, steps, begin = makeSample(), 0, time.perf_counter()
		for _ in range(calls):
			steps += sample.apply(Matrix3(0, 2e-2 / calls, 0, 0, 0, 0, 0, 0, 0), 0)["steps"]
		fastest = min(fastest, (time.perf_counter() - begin) / calls)
	return fastest, steps / calls


def price(grains, calls):
	scene = ownScene(frictional, grains)
	packed, steps = secondsPerCall(lambda: wrapper.RveSample.fromScene(scene), calls)
	opened, _ = secondsPerCall(lambda: wrapper.OpenRveSample(source=scene), calls)
	print(f"a call of {steps:.0f} DEM steps of {grains} discs: {1e3 * packed:.2f} ms packed, {1e3 * opened:.2f} ms open, {opened / packed:.1f} times as long")
	return packed, opened


# --- the same bank on both -------------------------------------------------------------------------------------------------


def bank(scene, spacing, endTime):
	"""A vertical bank, 1 m high; nothing else than its samples decides whether it stands."""
	O.reset()
	mpm = wrapper.MpmEngine(
		gridSpacing=spacing,
		lower=(0, 0),
		upper=(4, 2),
		gravity=(0, -9.81),
		damping=0.1,
		skeleton=wrapper.RveSkeleton(scenes=[scene], strainTolerance=1e-4, maxInertialNumber=2e-2),  # coarse, to be seen within a minute
		boundaries=[wrapper.RollerBoundary(region="left"), wrapper.FixedBoundary(region="bottom")],
	)
	talik.geometry.fill(mpm, [(0, 0), (1.5, 0), (1.5, 1), (0, 1)], pointsPerCell=4, porosity=0.2)
	O.engines = [mpm]
	runUntil(endTime)
	return mpm


def drawBank(axes, mpm, title, widest):
	frame = output.allFields(mpm)
	plots.ground(axes, frame, "displacement", plots.bandsOf("displacement", frame["displacement"], limits=(0, widest)), arrows="displacement")
	axes.set(title=title, xlim=(0, 2.4), ylim=(0, 1.1))


def summaryOf(mpm):
	moved, counters = np.linalg.norm(mpm.field("displacement"), axis=1), mpm.skeleton.cost()
	return {
		"displacement [m]": moved.max(),
		"calls": counters["calls"],
		"DEM steps": counters["steps"],
		"seconds per call": counters["seconds"] / max(counters["calls"], 1),
	}


def draw(banks, file):
	"""Each bank above the sample at its toe."""
	fig = plots.figure(11, 7.5)
	panels = fig.subplots(2, 2, height_ratios=(1, 1.5))
	widest = max(summaryOf(mpm)["displacement [m]"] for mpm in banks.values())
	for (name, mpm), (above, below) in zip(banks.items(), panels.T):
		with mpm.inspect(mpm.pick(1.4, 0.1)):
			sample = packing.sampleArrays()
		drawBank(above, mpm, f"{name}, {mpm.time:.2g} s", widest)
		plots.sampleForces(below, sample, widest=4, legend=False).set_title(
			f"sample at the toe, widest force {np.abs(sample['normalForce']).max(initial=0):.2g} N"
		)
	return plots.save(fig, file, dpi=80)


def main():
	parser = argparse.ArgumentParser(description=__doc__.splitlines()[0])
	parser.add_argument("--preset", default="draft", choices=sorted(presets), help="size of the job")
	parser.add_argument("--output", default="output/own_sample", help="folder for the results")
	options = parser.parse_args()
	folder = writableFolder(Path(options.output))
	grains, spacing, endTime, calls = presets[options.preset]

	packed, opened = price(grains, calls)
	banks, summary = {}, {}
	for name, law in {"cohesive-frictional": cohesive, "Hertz-Mindlin": hertzMindlin}.items():
		banks[name] = bank(ownScene(law, grains), spacing, endTime)
		summary[name] = its = summaryOf(banks[name])
		print(
			f"{name}: largest displacement {its['displacement [m]']:.3f} m after {endTime:.2f} s; {its['calls']} calls of "
			f"{its['DEM steps'] / max(its['calls'], 1):.0f} DEM steps, {banks[name].skeleton.cost()['form']}, "
			f"{1e3 * its['seconds per call']:.2f} ms each"
		)
	draw(banks, folder / "own_sample.png")
	output.writeSummary(
		folder / "summary.json",
		**{"seconds per call, packed": packed, "seconds per call, open": opened, "open over packed": opened / packed, **summary},
	)
	print(f"picture and summary are in {folder}")
	if not summary["cohesive-frictional"]["displacement [m]"] < summary["Hertz-Mindlin"]["displacement [m]"]:
		output.unexpected("cohesion should hold the bank better than friction alone")


if __name__ == "__main__":
	main()
