# SPDX-License-Identifier: GPL-2.0-or-later
"""A surveyed hillside of 40 corners with clay, silt and gravel, and the temperatures of a borehole, thaws for a summer.

	scripts/run surveyed_profile [--preset test|draft|standard] [--survey corners.csv] [--borehole temperatures.csv]

The layers are cut out of the outline by lines; the ground is stable, so frozen and thawed ground need no velocities of their own
(thawFront=None). By hand, at a place of each soil: thaw reaches the depth sqrt(2 k I/L) of Stefan's formula, with the thawing index I of the surface (degree
seconds), and conductivity k and latent heat L of the soil; what warms the frozen ground is left out, so the thaw stays shallower. The surface
settles by the thaw strain times the depth thawed. Change the two tables first.
"""

import argparse
import sys
from pathlib import Path

import numpy as np
from yade import O

import talik
from talik import output, plots
from talik.files import writableFolder

here = Path(sys.argv[0]).parent
parser = argparse.ArgumentParser(description=__doc__.splitlines()[0])
parser.add_argument("--preset", default="draft", choices=("test", "draft", "standard"), help="size of the job")
parser.add_argument("--survey", default=str(here / "surveyed_profile.csv"), help="corners x, y [m] of the ground")
parser.add_argument("--borehole", default=str(here / "surveyed_borehole.csv"), help="depth [m] and temperature [degC]")
parser.add_argument("--output", default="output/surveyed_profile", help="folder for the results")
options = parser.parse_args()
folder = writableFolder(options.output)

h, scale, lastDay = {"test": (0.25, 4e6, 60), "draft": (0.125, 2e6, 100), "standard": (0.125, 1e6, 100)}[options.preset]
warm, warming = 8.0, 10.0  # surface in summer [degC], and the days until it has warmed
clay = GroundMaterial(name="clay", solidConductivity=1.5, thawStrain=talik.layers.thawStrain(0.55, 0.50))
silt = GroundMaterial(name="silt", solidConductivity=2.0, thawStrain=talik.layers.thawStrain(0.45, 0.41))
gravel = GroundMaterial(name="gravel", solidConductivity=3.0)

outline = talik.tables.outline(options.survey)
temperature = talik.tables.ofDepth(options.borehole, outline, "temperature")
width, top = max(x for x, _ in outline), max(y for _, y in outline)
fine, coarse = talik.layers.split(outline, [(0, 1.6), (width, 1.2)])
hollow, siltBody = talik.layers.split(fine, [(0, top + 1), (13.3, top + 1), (13.5, 2.0), (width, 1.9)])
soils = {
	"gravel": dict(polygon=coarse, porosity=0.30, material=gravel),
	"silt": dict(polygon=siltBody, porosity=0.45, material=silt),
	"clay": dict(polygon=hollow, porosity=0.55, material=clay),
}
mpm = MpmEngine(
	gridSpacing=h,
	lower=(0, 0),
	upper=(width, h * round(top / h + 2)),
	gravity=(0, -9.81),
	damping=0.3,
	thawFront=None,
	heat=HeatTransfer(thermalTimeScale=scale),
	freezing=FreezingCurve(width=0.2),
	skeleton=MohrCoulombSkeleton(young=1e7, youngFrozen=5e7, frictionAngle=30, cohesion=5e3, cohesionFrozen=3e5),
	boundaries=[RollerBoundary(region=side) for side in ("left", "right", "bottom")]
	+ [SurfaceTemperature(region="surface", times=[0, warming * talik.day], values=[0, warm])],
)
layers = talik.layers.fill(mpm, {name: dict(soil, temperature=temperature) for name, soil in soils.items()}, lateralRatio=0.5)
places = {"silt": 3.0, "clay": 17.0}  # x [m]
O.engines = [mpm]
O.step()
surface = {name: (x, talik.geometry.surfaceHeight(outline, x)) for name, x in places.items()}
table = output.PointTable(mpm, folder / "points.csv", surface, fields=("temperature", "displacement"), everyDays=1)
O.engines = [mpm, table.engine]
start, startVolume = mpm.field("position"), mpm.field("volume")
atStart = output.allFields(mpm)
talik.runUntilDay(mpm, lastDay)
talik.runSerially(500)  # the last cell comes to rest

ice, displacement = mpm.field("iceSaturation"), mpm.field("displacement")
index = warm * (lastDay - warming / 2) * talik.day
results = {}
for name, x in places.items():
	soil, n = soils[name]["material"], soils[name]["porosity"]
	near = np.abs(start[:, 0] - x) < 1.0
	depth = np.array([talik.geometry.surfaceHeight(outline, place) for place in start[near, 0]]) - start[near, 1]
	thawed = startVolume[near & (ice < 0.5)].sum() / 2.0
	settled = -displacement[near, 1][depth < h].mean()
	k, latent = (1 - n) * soil.solidConductivity + n * soil.liquidConductivity, n * soil.iceDensity * soil.latentHeat
	results[name] = thawed, (2 * k * index / latent) ** 0.5, settled, soil.thawStrain * thawed
print(f"{mpm.pointCount} points in {len(layers)} layers of an outline of {len(outline)} corners, {O.iter} steps, {lastDay} days")
for name, (thawed, byHand, settled, settledByHand) in results.items():
	print(f"{name}: thawed {thawed:.2f} m, by hand {byHand:.2f} m; settled {1e3 * settled:.0f} mm, by hand {1e3 * settledByHand:.0f} mm")

figure = plots.figure(8, 9)
panels = figure.subplots(3, 1)
lines = [*outline, outline[0]]
now = output.allFields(mpm)
plots.ground(panels[0], atStart, "temperature", colourMap="YlGnBu_r", start=False, front=False)
plots.ground(panels[1], now, "iceSaturation", start=False)
plots.ground(panels[2], now, -1e3 * displacement[:, 1], label="settlement [mm]", limits=(0, None), start=False)
for axes, title in zip(panels, ("start, from the borehole; lines: borders of silt, clay and gravel", f"day {lastDay}", f"day {lastDay}; dashed: the survey")):
	axes.set_title(title, loc="left", fontsize=10)
	for soil in soils.values():
		axes.plot(*zip(*soil["polygon"], soil["polygon"][0]), color="0.3", linewidth=0.6)
panels[2].plot(*zip(*lines), color="0.35", linestyle="--", linewidth=0.8)
plots.save(figure, folder / "surveyed_profile.png", dpi=100)
output.writeSummary(folder / "summary.json", **{f"{name}: thawed, by hand, settled, by hand [m]": values for name, values in results.items()})
for name, (thawed, byHand, settled, settledByHand) in results.items():
	if not 0.8 < thawed / byHand < 1.35:
		output.unexpected(f"the thaw of {name} is not between 80 and 135 % of the calculation by hand")
	if abs(settled / settledByHand - 1) > 0.2:
		output.unexpected(f"the settlement of {name} is more than 20 % off the calculation by hand")
print(f"picture, table of points and summary are in {folder}")
