# SPDX-License-Identifier: GPL-2.0-or-later
"""Retrogressive thaw slump in space: a hollow in a frozen hillside thaws from its surface, slides, and meets a barrier of facets.

	scripts/run thaw_slump_bowl [--preset test|draft|standard] [--skeleton MohrCoulomb] [--heights FILE] [--redraw]

The hillside is a height grid, thawbowl/hillside.asc, which thawbowl/hillside.py makes by a formula. Behind every point stands a sample of
spheres with ice bonds, brought to the weight above it before it freezes. Ground, freezing curve, air and scale of time are those of Case I of Yu &
Zhao (thaw_slump_surface). Stiffness and strength of grains and bonds are a tenth of the paper's: its discs are 0.1 m thick and of 10 mm, which
divides both by about ten; spheres have no thickness. Change the heights, the place of the barrier or the days of thaw first.
"""

import argparse
import json
import sys
import time
from dataclasses import dataclass
from pathlib import Path

import numpy as np

import talik
from talik import output, packing, plots, plots3d, solids
from talik.files import writableFolder


@dataclass
class Preset:
	gridSpacing: float  # [m], a part of the sides of the height grid; with one point a cell
	grains: int  # of a sample
	days: float  # of thaw


presets = {"test": Preset(0.9, 80, 20.0), "draft": Preset(0.6, 100, 40.0), "standard": Preset(0.45, 100, 60.0)}
skeletons = ("samples", "MohrCoulomb")

frozen, warm, porosity = -5.0, 10.0, 0.4  # [degC], [-]
lateralRatio, density = 0.7, 1964.0  # horizontal over vertical stress at rest [-], of frozen ground [kg/m3]
restTime, restDamping, damping = 0.4, 0.7, 0.02  # time to come to rest [s], local damping then and during the thaw [-]
thermalTimeScale = 8.64e5  # one second of motion stands for ten days
grainsAndIce = dict(young=60e6, iceYoung=300e6, tensileStrength=1e5, iceTensileStrength=5e6, shearStrength=1e5, iceShearStrength=5e6)  # [Pa]
barrierAt, barrierHeight, barrierReach = 7.2, 0.9, 2.1  # place along the hollow, height above its floor, half of its length [m]
frameParts, seriesLength = (0.5, 1.0), 20


def skeleton(preset, kind):
	if kind == "samples":
		sample = talik.rve.prepare(grains=preset.grains, dimension=3, ice=True, **grainsAndIce)
		return RveSkeleton(samples=[talik.rve.pack(sample)], strainTolerance=5e-5, maxInertialNumber=1e-2)
	return MohrCoulombSkeleton(
		young=5e6, youngFrozen=120e6, cohesion=200, cohesionFrozen=360e3, frictionAngle=28, tensileStrength=0, tensileStrengthFrozen=400e3
	)


def geostatic(hill, position):
	"""Effective stress (n, 6) [Pa] of ground at rest."""
	down = -density * 9.81 * hill.depth(*position.T)
	return np.column_stack([lateralRatio * down, lateralRatio * down, down, *3 * [0 * down]])


def localHeights(path):
	"""Heights of a file, with its first node at (0, 0); the barrier is at a place along them, and the base of the ground at the height 0."""
	heights = solids.readHeights(path)
	x, y, z = heights.x - heights.x[0], heights.y - heights.y[0], heights.z
	if not x[-1] > barrierAt:
		raise ValueError(f"'{path}' is {x[-1]:g} m long; it must reach beyond the barrier, which is at {barrierAt} m (barrierAt)")
	if not np.nanmax(z) - np.nanmin(z) > 0.1 * np.nanmax(z):
		raise ValueError(f"'{path}' has heights from {np.nanmin(z):g} to {np.nanmax(z):g} m, and the ground reaches down to 0; take the height of its base off")
	return solids.Heights(x, y, z)


def barrier(hill):
	"""Ids of facets that stand across the floor of the hollow, a row of upright squares cut in two."""
	wall, middle = [], 0.5 * (hill.lower[1] + hill.upper[1])
	ends = middle + np.linspace(-barrierReach, barrierReach, 8)
	for left, right in zip(ends, ends[1:]):
		foot = [hill.surface(np.array([barrierAt]), np.array([y]))[0] for y in (left, right)]
		top = hill.surface(np.array([barrierAt]), np.array([middle]))[0] + barrierHeight
		corners = [
			(barrierAt, left, foot[0]),
			(barrierAt, right, foot[1]),
			(barrierAt, right, max(top, foot[1] + 0.3)),
			(barrierAt, left, max(top, foot[0] + 0.3)),
		]
		wall += [utils.facet([corners[0], corners[1], corners[2]]), utils.facet([corners[0], corners[2], corners[3]])]
	return O.bodies.append(wall)


def boxOf(preset, hill):
	"""Corners of the grid [m]."""
	cells = np.ceil(hill.upper / preset.gridSpacing + (0, 0, 2) - 1e-9)
	return (0, 0, 0), tuple(preset.gridSpacing * cells)


def build(preset, kind, hill):
	"""The frozen hillside at rest and its barrier: (ground, ids of the facets)."""
	lower, upper = boxOf(preset, hill)
	mpm = MpmEngine(
		gridSpacing=preset.gridSpacing,
		lower=lower,
		upper=upper,
		gravity=(0, 0, -9.81),
		damping=restDamping,
		skeleton=skeleton(preset, kind),
		heat=HeatTransfer(),  # in real time until the hillside rests
		freezing=FreezingCurve(curve="gauss", width=0.5, residualSaturation=0.05),
		water=PoreWater(conductivity=1e-4, hydraulicTimeScale=1),
		bodies=BodyContact(frictionAngle=25),
		boundaries=[
			*(RollerBoundary(region=side) for side in ("left", "right", "front", "back")),
			FixedBoundary(region="bottom"),
			DrainedBoundary(region="surface", recharge=False),
			SurfaceTemperature(region="surface", times=[0, 10 * talik.day], values=[frozen, warm]),
		],
	)
	atRest = {} if kind == "samples" else {"stress": lambda x, y, z: geostatic(hill, np.column_stack([x, y, z]))}
	talik.geometry.fill(mpm, hill, porosity=porosity, temperature=frozen, **atRest)
	if kind == "samples":
		talik.slope.settle(mpm, hill, lateralRatio=lateralRatio)
	ids = barrier(hill)
	O.engines = [ForceResetter(), mpm, NewtonIntegrator(damping=0)]
	return mpm, ids


class Run:
	"""Rest and thaw: frames for pictures, a series for ParaView, a history."""

	def __init__(self, mpm, facets, preset, folder):
		self.mpm, self.facets, self.preset = mpm, facets, preset
		self.frames = output.Frames(mpm, [part * preset.days for part in frameParts], days=True)
		self.series = output.ParaViewSeries(mpm, folder / "paraview", clock=lambda: mpm.calendar["day"])
		self.history = []  # day, time of motion [s], largest displacement [m], force on the barrier along the slope [N], part that is thawed [-]

	def rest(self):
		self.mpm.setDay(-1)
		talik.runUntil(restTime)
		self.mpm.resetDisplacement()
		self.mpm.damping, self.mpm.heat.thermalTimeScale = damping, thermalTimeScale
		self.mpm.setDay(0)

	def thaw(self):
		for day in np.linspace(0, self.preset.days, seriesLength + 1):
			talik.runUntilDay(self.mpm, day)
			displacement = np.linalg.norm(self.mpm.field("displacement"), axis=1).max()
			thawed = np.average(self.mpm.field("iceSaturation") < 0.02, weights=self.mpm.field("volume"))
			self.history.append((self.mpm.calendar["day"], self.mpm.time - restTime, displacement, self.barrierForce(), thawed))
			self.series.write()
			self.frames.take()
			print("day {0:.1f}: displaced by up to {2:.3f} m, {3:.0f} N on the barrier, {4:.0%} thawed".format(*self.history[-1]), flush=True)

	def barrierForce(self):
		return sum(O.forces.f(facet)[0] for facet in self.facets)


def watched(mpm):
	"""Two points by letter: A, the frozen one whose sample has lost most bonds by load, or is strained most where none has; B, the thawed one that
	is strained most among those whose grains still hold each other. Spheres with friction do from about four contacts each."""
	ice, strain, broken, contacts = (mpm.field(name) for name in ("iceSaturation", "deviatoricStrain", "bondsBroken", "coordinationNumber"))
	return {
		"A": int(np.lexsort((strain, broken, ice > 0.3))[-1]),
		"B": int(np.lexsort((strain, contacts > 4, ice < 0.02))[-1]),
	}


def drawSlope(frame, box, path):
	"""The hillside coloured by displacement, as it is and with its front half stripped of what has thawed."""
	fig = plots.figure(13, 5.6)
	panels = fig.subplots(1, 2)
	(lower, upper), middle = box, 0.5 * (box[0][1] + box[1][1])
	largest = np.quantile(plots.magnitude(frame["displacement"]), 0.995)  # a few points may run ahead
	for axes, stripped in zip(panels, (None, middle)):
		plots3d.slope(axes, frame, "displacement", lower, upper, stripped, O.bodies, limits=(0, largest), colourMap="YlOrRd")
	panels[0].set_title(f"day {frame['day']:.0f} of thaw")
	panels[1].set_title("left half: only what is frozen ($S_i \\geq 0.5$); cut: thawed ground")
	return plots.save(fig, path, dpi=110)


def drawSection(frame, box, hill, path):
	"""Fields along the axis of the hollow."""
	middle, former = 0.5 * (box[0][1] + box[1][1]), np.linspace(hill.lower[0], hill.upper[0], 200)
	foot = hill.surface(np.array([barrierAt]), np.array([middle]))[0]
	fig = plots.figure(13, 3.3)
	for axes, name in zip(fig.subplots(1, 3, sharey=True), ("iceSaturation", "deviatoricStrain", "displacement")):
		plots3d.section(axes, frame, name, middle, *box)
		axes.plot(former, hill.surface(former, np.full(200, middle)), color="0.35", linestyle="--", linewidth=0.8)
		axes.plot(2 * [barrierAt], [foot, foot + barrierHeight], color="black", linewidth=2.5)
		axes.set_ylim(0, hill.upper[2] + 0.3)
		axes.set_ylabel("z [m]" if name == "iceSaturation" else "")
	fig.suptitle(f"section at y = {middle:.1f} m, day {frame['day']:.0f}; crimson: thaw front; dashed: former surface; thick: barrier", fontsize=10)
	return plots.save(fig, path, dpi=110)


def drawSamples(mpm, points, path, folder):
	"""The samples behind the watched points, also for ParaView."""
	fig = plots.figure(11, 5.8)
	series = output.SampleSeries(folder, clock=lambda: mpm.time)
	for axes, (letter, point) in zip(fig.subplots(1, 2), points.items()):
		with mpm.inspect(point):
			arrays = packing.sampleArrays()
			series.write()
		plots3d.sample(axes, arrays)
		ice, (x, y, z) = mpm.field("iceSaturation")[point], mpm.field("position")[point]
		axes.set_title(f"{letter}: sample at ({x:.1f}, {y:.1f}, {z:.1f}) m, $S_i$ = {ice:.2f}", fontsize=10)
	return plots.save(fig, path, dpi=110)


def drawHistory(history, path):
	day, _, displacement, force, thawed = np.transpose(history)
	fig = plots.figure(11, 2.8)
	for axes, values, label in zip(
		fig.subplots(1, 3), (displacement, force / 1e3, 100 * thawed), ("largest displacement [m]", "force on the barrier [kN]", "thawed [%]")
	):
		axes.plot(day, values, marker="o", markersize=3)
		axes.set(xlabel="day", ylabel=label)
		axes.set_ylim(bottom=min(0, values.min()))
	return plots.save(fig, path, dpi=110)


def draw(frame, history, box, hill, folder):
	drawSlope(frame, box, folder / "slope.png")
	drawSection(frame, box, hill, folder / "section.png")
	drawHistory(history, folder / "history.png")


def summary(run, options, points, started):
	mpm, preset = run.mpm, run.preset
	counters = mpm.skeleton.cost() if options.skeleton == "samples" else {"calls": 0, "steps": 0, "bytes": 0}
	bonds = ("bondsFormed", "bondsIntact", "bondsBroken", "bondsMelted") if options.skeleton == "samples" else ()
	return {
		"preset": options.preset,
		"skeleton": options.skeleton,
		"heights": Path(options.heights).name,
		"grid spacing [m]": preset.gridSpacing,
		"points": mpm.pointCount,
		"steps": O.iter,
		"wall time [s]": time.monotonic() - started,
		"processor time [s]": time.process_time(),
		"day": mpm.calendar["day"],
		"largest displacement [m]": run.history[-1][2],
		"volume displaced by more than 0.1 m [m3]": mpm.field("volume")[np.linalg.norm(mpm.field("displacement"), axis=1) > 0.1].sum(),
		"thawed part [-]": run.history[-1][4],
		"largest force on the barrier [N]": max(row[3] for row in run.history),
		"sample calls": counters["calls"],
		"sample DEM steps": counters["steps"],
		"sample memory [MB]": counters["bytes"] / 1e6,
		**{name: int(np.nansum(mpm.field(name))) for name in bonds},
		"points watched": points,
		"history": run.history,
		**{f"balance.{name}": value for name, value in mpm.balance().items()},
	}


def _days(text):
	if not 0 < float(text) < float("inf"):
		raise argparse.ArgumentTypeError(f"{text} is no length of time: give days, above 0")
	return float(text)


def main():
	parser = argparse.ArgumentParser(description=__doc__.splitlines()[0])
	parser.add_argument("--preset", default="draft", choices=sorted(presets), help="size of the job")
	parser.add_argument("--output", default="output/thaw_slump_bowl", help="folder for the results")
	parser.add_argument("--skeleton", default="samples", choices=skeletons, help="a sample of spheres behind every point, or a law")
	parser.add_argument("--heights", default=Path(sys.argv[0]).parent / "thawbowl" / "hillside.asc", help="height grid: ESRI ASCII grid or GeoTIFF")
	parser.add_argument("--days", type=_days, help="of thaw, in place of the preset's")
	parser.add_argument("--redraw", action="store_true", help="draw all pictures but those of the samples anew from the files in the folder, without a run")
	options = parser.parse_args()
	started, folder, preset = time.monotonic(), writableFolder(Path(options.output)), presets[options.preset]
	preset.days = options.days or preset.days
	hill = solids.terrain(localHeights(options.heights), base=0.0)
	if options.redraw:
		barrier(hill)
		draw(output.loadFrames(folder / "frames.npz")[-1], json.loads((folder / "summary.json").read_text())["history"], boxOf(preset, hill), hill, folder)
		return
	mpm, facets = build(preset, options.skeleton, hill)
	print(f"{mpm.pointCount} points, {mpm.field('volume').sum():.0f} m3 of ground, {len(facets)} facets")
	run = Run(mpm, facets, preset, folder)
	run.rest()
	run.thaw()
	points = watched(mpm) if options.skeleton == "samples" else {}
	output.writeSummary(folder / "summary.json", **summary(run, options, points, started))
	run.frames.save(folder / "frames.npz")
	draw(run.frames.frames[-1], run.history, boxOf(preset, hill), hill, folder)
	if points:
		drawSamples(mpm, points, folder / "samples.png", folder / "paraview")
	print(f"pictures, ParaView files and summary.json are in {folder}")


if __name__ == "__main__":
	main()
