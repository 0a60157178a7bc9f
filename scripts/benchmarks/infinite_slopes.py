# SPDX-License-Identifier: GPL-2.0-or-later
"""Infinite slopes at the defaults, as columns of one cell: which stand, which slide, and how fast, over the factor of safety by hand.

yade -n -x infinite_slopes.py FOLDER [dry|explicit|implicit|thaw|samples]...   some of the cases; default: all

A row of FOLDER/infinite_slopes.csv for each column, and a picture of them.
"""

import csv
import itertools
import math
import sys
from pathlib import Path

import matplotlib

matplotlib.use("Agg")
from matplotlib import pyplot

import numpy as np
import talik
from talik.studies import calibrate
from yade import O
from yade.wrapper import (
	DrainedBoundary,
	FreezingCurve,
	GroundMaterial,
	HeatTransfer,
	MohrCoulombSkeleton,
	MpmEngine,
	PoreWater,
	RveSkeleton,
	SurfaceTemperature,
)

gravity, porosity, depth = 9.81, 0.4, 2.0
dryDensity, liquidDensity = 0.6 * 2650.0, 1000.0
young, poisson = 2e7, 0.3
stands, slides = 1.1, 0.9  # factors of safety from which on a column has to stand, and up to which it has to slide
largestPath = 5e-3  # of a column that stands [m]
largestError = 0.1  # of the acceleration of one that slides [-]
duration = 2.0  # [s of motion]
tilting = 1.0  # time in which a column of samples is tilted [s]
warm, thawed = 6.0, 1.0  # temperature of the surface of a column that thaws [degC], and how deep it thaws [m]
motionPerDay = 86400 / 1e6  # [s]


def stressPart(case):
	"""Effective over total stress across the slope at the base, or at the front of a column that thaws. Soil that ice parted begins to bear as it
	thaws: with the excess pressure of Morgenstern and Nixon (1971) it bears 1/(1 + 2 R^2) of the buoyant weight (McRoberts 1978)."""
	if case["water"] == "dry":
		return 1.0
	return (1 - liquidDensity / densityOf(case)) / (1 + 2 * case.get("R", 0.0) ** 2)


def densityOf(case):
	return dryDensity + (0.0 if case["water"] == "dry" else porosity * liquidDensity)


def strengthOf(case):
	"""(frictionAngle [degrees], cohesion [Pa]) of the factor of safety: in simple shear without dilation the law bears c cos phi + sigma' sin phi
	(Davis 1968). Up to 35 degrees there is no cohesion."""
	slope, part = math.radians(case["angle"]), stressPart(case)
	sine, most = case["factor"] * math.tan(slope) / part, math.sin(math.radians(35))
	if sine <= most:
		return math.degrees(math.asin(sine)), 0.0
	height = thawed if "R" in case else depth
	return 35.0, (sine - most) * part * densityOf(case) * gravity * height * math.cos(slope) / math.cos(math.radians(35))


def neumann(conductivity, latent, capacity):
	"""alpha of X = alpha sqrt(t) for ground that is frozen next to its freezing point [m/sqrt(s)]."""
	diffusivity, stefan = conductivity / capacity, capacity * warm / latent
	low, high = 0.0, 5.0
	for _ in range(60):
		x = 0.5 * (low + high)
		low, high = (x, high) if math.sqrt(math.pi) * x * math.exp(x * x) * math.erf(x) < stefan else (low, x)
	return 2 * low * math.sqrt(diffusivity)


def speedOfThaw():
	soil = GroundMaterial()
	conductivity = (1 - porosity) * soil.solidConductivity + porosity * soil.liquidConductivity
	capacity = (1 - porosity) * soil.solidDensity * soil.solidSpecificHeat + porosity * soil.liquidDensity * 4200
	return neumann(conductivity, porosity * soil.iceDensity * soil.latentHeat, capacity)


def column(case):
	"""A column that never froze, or (with R) one that thaws from its surface."""
	friction, cohesion = strengthOf(case)
	settings, boundaries, layer = {}, [], dict(thickness=depth, porosity=porosity)
	if case["water"] == "dry":
		layer["poreFill"] = 0.0
	else:
		oedometer = young * (1 - poisson) / ((1 + poisson) * (1 - 2 * poisson))
		conductivity = 1e-4 if not case.get("R") else speedOfThaw() ** 2 / (4 * case["R"] ** 2) * liquidDensity * gravity / oedometer
		# as in the theory, neither thaw nor warmth changes the volume of the pore content, and frozen soil has no effective stress
		settings["water"] = PoreWater(conductivity=conductivity, referencePorosity=porosity, pressure=case["water"], zetaActive=not case.get("R"))
		boundaries.append(DrainedBoundary(region="surface"))
	if "R" in case:
		settings.update(heat=HeatTransfer(thermalTimeScale=86400 / motionPerDay, followsMotion=True), freezing=FreezingCurve())
		settings["material"] = GroundMaterial(thawStrain=case["thawStrain"], solidExpansivity=0, iceExpansivity=0, liquidExpansivity=0)
		boundaries.append(SurfaceTemperature(region="surface", temperature=warm))
		layer["temperature"] = -1.0
		if case["R"]:
			slope = math.radians(case["angle"])
			layer["pressure"] = lambda x, y: densityOf(case) * gravity * math.cos(slope) * (depth - y)
			layer["stress"] = lambda x, y: np.stack([0 * y, 0 * y, 0 * y, densityOf(case) * gravity * math.sin(slope) * (depth - y)], axis=1)
	law = MohrCoulombSkeleton(young=young, poisson=poisson, frictionAngle=friction, cohesion=cohesion)
	mpm = MpmEngine(gridSpacing=case["spacing"], skeleton=law, boundaries=boundaries, **settings)
	water = {} if case["water"] == "dry" else dict(waterDepth=0)
	talik.slope.infiniteColumn(mpm, case["angle"], {"soil": layer}, pointsPerCell=case["points"], **water)
	return mpm


def packedSample():
	"""Of 100 grains, with its friction in steady simple shear at the pressures of the column."""
	if not known:
		sample = talik.rve.pack(talik.rve.prepare(grains=100))
		known.append((sample, calibrate.thawedFriction(sample)))
	return known[0]


known = []


def columnOfSamples(case):
	"""Level, with the weight on each sample: (ground, gravity along the slope). The friction is that of the sample, the angle follows from it."""
	sample, _ = packedSample()
	mpm = MpmEngine(gridSpacing=case["spacing"], skeleton=RveSkeleton(samples=[sample], maxInertialNumber=case["inertial"]))
	talik.slope.infiniteColumn(mpm, case["angle"], {"soil": dict(thickness=depth, porosity=porosity)}, pointsPerCell=case["points"])
	talik.slope.settle(mpm, talik.geometry.rectangle(0, 0, case["spacing"], depth))
	along, across = mpm.gravity
	mpm.gravity = (0, across)
	return mpm, along


def judgedOfSamples(case):
	"""As judged(), of a column that is tilted within a second; its acceleration is that of the two seconds that follow."""
	O.reset()
	mpm, along = columnOfSamples(case)
	O.engines = [mpm]
	O.step()
	upper, across = mpm.field("position")[:, 1] > 0.5 * depth, mpm.gravity[1]
	while O.time < tilting:
		mpm.gravity = (along * min(1.0, O.time / tilting), across)
		O.run(20, True)
	mpm.gravity = (along, across)

	def now():
		return mpm.field("displacement")[upper, 0].mean(), mpm.field("velocity")[upper, 0].mean()

	start, began = now(), O.time
	talik.runUntil(began + duration)
	path, faster = (after - before for after, before in zip(now(), start))
	due = along * (1 - case["factor"])
	ratio = faster / (due * (O.time - began)) if due > 0 else math.nan
	right = (path < largestPath) == (case["factor"] > 1)
	return {**case, "path": path, "stood": int(path < largestPath), "ratio": ratio, "right": int(right)}


def judged(case):
	"""The case with what came of it: path of the upper half of what is thawed [m], its acceleration over that which is due, and whether it is right."""
	if case["water"] == "samples":
		return judgedOfSamples(case)
	O.reset()
	mpm = column(case)
	O.engines = [mpm]
	O.step()
	upper = mpm.field("position")[:, 1] > depth - 0.5 * (thawed if "R" in case else depth)

	def path():
		return mpm.field("displacement")[upper, 0].mean()

	# room of melted ice closes along gravity, which leads ground downhill
	allowed = largestPath + case.get("thawStrain", 0.0) * thawed * math.sin(math.radians(case["angle"]))
	start, began, ratio = path(), O.time, math.nan
	if "R" in case:
		days = (thawed / speedOfThaw()) ** 2 / 86400
		talik.runUntilDay(mpm, days, look=lambda: path() > allowed + 0.1, longest=began + 3 * days * motionPerDay)
		right = (path() - start < allowed) == (case["factor"] > 1)
	else:
		talik.runUntil(began + duration)
		due = gravity * math.sin(math.radians(case["angle"])) * (1 - case["factor"])
		ratio = (path() - start) / (0.5 * due * (O.time - began) ** 2) if due > 0 else math.nan
		right = abs(ratio - 1) < largestError if due > 0 else path() - start < allowed
	return {**case, "path": path() - start, "stood": int(path() - start < allowed), "ratio": ratio, "right": int(right)}


def cases(kinds=("dry", "explicit", "implicit", "thaw", "samples"), everyDay=False):
	"""All that are asked for; everyDay: a few of them. Saturated slopes are no steeper than 25 degrees: by hand steeper ones need tension."""
	factors = (0.8, 0.9, 1.1, 1.25) if everyDay else (0.7, 0.8, 0.9, 1.1, 1.25, 1.6, 2.5)
	sizes = ((0.25, 4),) if everyDay else ((0.25, 1), (0.25, 4), (0.125, 1), (0.125, 4))
	for kind, (spacing, points) in itertools.product([kind for kind in kinds if kind not in ("thaw", "samples")], sizes):
		for angle, factor in itertools.product((15,) if everyDay else (5, 15, 25, 35) if kind == "dry" else (5, 15, 25), factors):
			yield dict(water=kind, spacing=spacing, points=points, angle=angle, factor=factor)
	if "thaw" in kinds:
		# excess ice drains at once where R is 0; with R > 0 there is none, as in the theory
		ices = ((0.1, 0.0), (0.2, 0.0)) if everyDay else ((0.0, 0.0), (0.0, 0.08), *((R, 0.0) for R in (0.05, 0.1, 0.2, 0.5, 1.0)))
		of = (ices, ("implicit",) if everyDay else ("explicit", "implicit"), (0.8, 1.25) if everyDay else (0.7, 0.9, 1.1, 1.6, 2.5))
		for (spacing, points), ((R, strain), water, factor) in itertools.product(((0.25, 1),) if everyDay else sizes, itertools.product(*of)):
			if points == 1 or R == 0:
				# where pore pressure bears more than a third of the weight, 15 degrees need tension
				yield dict(water=water, spacing=spacing, points=points, angle=15 if R < 0.5 else 5, factor=factor, R=R, thawStrain=strain)
	if "samples" in kinds:
		# the default inertial number, and that at which friction is measured
		for inertial, factor in itertools.product((5e-3, 1e-3), factors[:-1]):
			angle = math.degrees(math.atan(packedSample()[1] / factor))
			yield dict(water="samples", spacing=0.25, points=1, angle=angle, factor=factor, inertial=inertial)


def told(row):
	words = " ".join(
		f"{key} {value:g}" if isinstance(value, float) else f"{key} {value}" for key, value in row.items() if key not in ("path", "stood", "ratio", "right")
	)
	ratio = "" if math.isnan(row["ratio"]) else f", acceleration over that which is due {row['ratio']:.3f}"
	return f"{words}: path {1e3 * row['path']:.2f} mm{ratio}{'' if row['right'] else '  WRONG'}"


axesOf = dict(thaw="thaw consolidation ratio R", samples="largest inertial number of the grains")


def draw(rows, file):
	kinds = [kind for kind in ("dry", "explicit", "implicit", "thaw", "samples") if any(kindOf(row) == kind for row in rows)]
	titles = {
		"dry": "dry",
		"explicit": "saturated, explicit pressure",
		"implicit": "saturated, implicit pressure",
		"thaw": "thaws from its surface,\n15°, from R = 0.5 on 5°",
		"samples": "dry, samples of 100 grains",
	}
	figure, all_ = pyplot.subplots(1, len(kinds), figsize=(4 * len(kinds), 3.8), layout="constrained", sharey=True, squeeze=False)
	for axes, kind in zip(all_[0], kinds):
		own = [row for row in rows if kindOf(row) == kind]
		over = dict(thaw="R", samples="inertial").get(kind, "angle")
		groups, places = sorted({variant(row) for row in own}), sorted({row[over] for row in own})
		step = 0.7 / len(groups)
		axes.set_xticks(range(len(places)), [f"{place:g}" for place in places])
		axes.axhspan(slides, stands, color="0.9")
		axes.axhline(1, color="0.5", linewidth=0.8)
		for row in own:
			x = places.index(row[over]) + (groups.index(variant(row)) - 0.5 * (len(groups) - 1)) * step
			axes.plot(x, row["factor"], "o" if row["stood"] else "v", color="tab:green" if row["stood"] else "tab:orange", markersize=4)
			if not row["right"]:
				axes.plot(x, row["factor"], "x", color="black", markersize=7)
		wrong = sum(not row["right"] for row in own)
		axes.set(title=f"{titles[kind]}\n{len(own) - wrong} of {len(own)} right", xlabel=axesOf.get(kind, "angle [°]"))
	all_[0, 0].set_ylabel("factor of safety by hand")
	for marker, colour, words in (("o", "tab:green", "stands"), ("v", "tab:orange", "slides"), ("x", "black", "not as by hand")):
		all_[0, 0].plot([], [], marker, color=colour, markersize=5, label=words)
	all_[0, 0].legend(loc="upper right", bbox_to_anchor=(1, 0.9), framealpha=1)
	figure.savefig(file, dpi=110)


def kindOf(row):
	return "thaw" if "R" in row else row["water"]


def variant(row):
	return (row["spacing"], -row["points"], row["water"], row.get("thawStrain", 0.0))


def main(folder, *kinds):
	rows = []
	Path(folder).mkdir(parents=True, exist_ok=True)
	for case in cases(kinds or ("dry", "explicit", "implicit", "thaw", "samples")):
		rows.append(judged(case))
		print(told(rows[-1]), flush=True)
	with Path(folder, "infinite_slopes.csv").open("w", newline="") as file:
		table = csv.DictWriter(file, sorted({key for row in rows for key in row}))
		table.writeheader()
		table.writerows(rows)
	draw(rows, Path(folder, "infinite_slopes.png"))
	print(f"{sum(row['right'] for row in rows)} of {len(rows)} columns are right; {folder}/infinite_slopes.png")


if __name__ == "__main__":
	main(*sys.argv[1:])
