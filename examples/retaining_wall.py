# SPDX-License-Identifier: GPL-2.0-or-later
"""A retaining wall before saturated backfill that freezes in two winters: its thrust over the days, from air temperatures in a CSV file.

	scripts/run retaining_wall [--preset test|draft|standard] [--weather station.csv] [--porosity 0.35] [--friction 33] [--at-rest 0.5]
		[--solid-conductivity 2.5] [--start 6]

The wall is a box of YADE that does not move, of concrete, with the air on its other side. By hand: before the frost the thrust is that at
rest, K_0 gamma' H^2/2 and that of the water, gamma_w H^2/2. Frost reaches the depth d = sqrt((R k)^2 + 2 k I/L) - R k behind the wall and below the
surface, with the thermal resistance R of wall or air, the freezing index I of the air (degree seconds), conductivity k and latent heat L of
the backfill; the heat that the backfill holds is left out, so less of it freezes. The backfill grows by what its water grows
as it freezes, n S_i (rho_l/rho_i - 1) times the frozen area, if none of it leaves. No calculation by hand is known for the thrust in winter.
Give your air and backfill; change the thickness of the wall first.
"""

import argparse
import math
import sys
from pathlib import Path

import numpy as np
from yade import O, utils

import talik
from talik import bodies, output, plots, weather
from talik.files import writableFolder

parser = argparse.ArgumentParser(description=__doc__.splitlines()[0])
parser.add_argument("--preset", default="draft", choices=("test", "draft", "standard"), help="size of the job")
parser.add_argument("--weather", default=str(Path(sys.argv[0]).with_suffix(".csv")), help="series of time [s] and air temperature [degC]")
parser.add_argument("--output", default="output/retaining_wall", help="folder for the results")
parser.add_argument("--porosity", type=float, default=0.35, help="of the backfill, filled with water [-], 0.1 to 0.7")
parser.add_argument("--friction", type=float, default=33.0, help="friction angle of the backfill [degrees], 10 to 45")
parser.add_argument("--at-rest", type=float, default=0.5, help="K_0, effective horizontal over vertical stress at rest [-], 0.2 to 1")
parser.add_argument("--solid-conductivity", type=float, default=2.5, help="thermal, of the grains [W/(m K)], 0.2 to 8")
parser.add_argument("--start", type=float, default=6.0, help="temperature of the backfill in autumn [degC], 0 to 30")
options = parser.parse_args()
for name, lowest, highest in (("porosity", 0.1, 0.7), ("friction", 10, 45), ("at_rest", 0.2, 1), ("solid_conductivity", 0.2, 8), ("start", 0, 30)):
	if not lowest < getattr(options, name) < highest:
		raise SystemExit(f"--{name.replace('_', '-')} {getattr(options, name):g}: give a number between {lowest:g} and {highest:g}")
folder = writableFolder(options.output)

# days of calendar time, scale of time [-], grid spacing [m]
lastDay, scale, h = {"test": (200, 4e7, 0.25), "draft": (720, 1e7, 0.25), "standard": (720, 5e6, 0.125)}[options.preset]
height, width, thickness = 2.0, 4.0, 0.3  # of the backfill and of the wall [m]
porosity, atRest, surfaceCoefficient = options.porosity, options.at_rest, 15.0  # n, K_0, h_c [W/(m2 K)]
times, air = weather.airTemperature(options.weather)
soil = GroundMaterial(name="backfill", solidConductivity=options.solid_conductivity)
resistance = thickness / 1.7 + 1 / surfaceCoefficient  # concrete of 1.7 W/(m K), and the air before it [m2 K/W]

concrete = O.materials.append(FrictMat(frictionAngle=0.0))
wall = O.bodies.append(utils.box((-thickness / 2, height / 2, 0), (thickness / 2, height / 2 + 0.5, 0.5), fixed=True, material=concrete))
mpm = MpmEngine(
	gridSpacing=h,
	lower=(-1, 0),
	upper=(width, height + 1),
	gravity=(0, -9.81),
	damping=0.5,
	material=soil,
	bodies=BodyContact(),
	heat=HeatTransfer(thermalTimeScale=scale),
	freezing=FreezingCurve(width=0.3),
	water=PoreWater(conductivity=1e-5),
	skeleton=MohrCoulombSkeleton(young=2e7, youngFrozen=2e8, frictionAngle=options.friction, cohesion=500, cohesionFrozen=5e5, tensileStrengthFrozen=3e5),
	boundaries=[
		RollerBoundary(region="right"),
		FixedBoundary(region="bottom"),
		DrainedBoundary(region="surface"),
		SurfaceTemperature(region="surface", heatTransferCoefficient=surfaceCoefficient, times=times, values=air),
		BodyTemperature(bodies=[wall], resistance=resistance, times=times, values=air),
	],
)
backfill = dict(polygon=talik.geometry.rectangle(0, 0, width, height), porosity=porosity, temperature=options.start, pressure=lambda x, y: 9810 * (height - y))
talik.layers.fill(mpm, {"backfill": backfill}, lateralRatio=atRest)
O.engines = [ForceResetter(), mpm, NewtonIntegrator()]
places = {"behind the wall": (0.1, height / 2), "below the surface": (width / 2, height - 0.1)}
thrust = {"thrust [N/m]": lambda: -O.forces.f(wall)[0]}
O.step()
table = output.PointTable(mpm, folder / "thrust.csv", places, fields=("temperature", "pressure"), everyDays=1, others=thrust)
O.engines = O.engines + [table.engine]

rows, states, area = [], {}, mpm.field("volume").sum()
while mpm.calendar["day"] < lastDay:
	talik.runUntilDay(mpm, mpm.calendar["day"] + 5)
	volume, ice = mpm.field("volume"), mpm.field("iceSaturation")
	rows.append((mpm.calendar["day"], volume[ice > 0.5].sum(), (volume * ice * porosity).sum(), volume.sum() - area))
	if not states and rows[-1][0] > 165:
		states[f"day {rows[-1][0]:.0f}, late in the first winter"] = output.allFields(mpm)
day, frozen, iceArea, growth = np.array(rows).T
record = np.genfromtxt(folder / "thrust.csv", delimiter=",", skip_header=1)

density = (1 - porosity) * soil.solidDensity + porosity * soil.liquidDensity
thrustByHand = 0.5 * height**2 * 9.81 * (atRest * (density - soil.liquidDensity) + soil.liquidDensity)
autumn = np.mean(record[(record[:, 0] > 5) & (record[:, 0] < 25), -1])
midwinter = int(np.argmax(day > 90))
hours = np.arange(0, day[midwinter] * talik.day, 3600.0)
index = 3600 * np.clip(-np.interp(hours, times, air), 0, None).sum()
k = (1 - porosity) * soil.solidConductivity + porosity * soil.iceConductivity
latent = porosity * soil.iceDensity * soil.latentHeat
behind, below = (math.sqrt((R * k) ** 2 + 2 * k * index / latent) - R * k for R in (resistance, 1 / surfaceCoefficient))
frostByHand = below * width + behind * (height - below)
frost = frozen[midwinter]
growthByHand = (1 - soil.iceDensity / soil.liquidDensity) * iceArea[midwinter]  # ice of this area was less water by that
largest = [record[(record[:, 0] > first) & (record[:, 0] < first + 365), -1].max(initial=0) for first in (30, 395)]
print(f"{mpm.pointCount} points, {O.iter} steps, {day[-1]:.0f} days")
print(f"thrust before the frost {autumn / 1e3:.1f} kN/m, by hand {thrustByHand / 1e3:.1f} kN/m")
print(f"frozen area on day {day[midwinter]:.0f} {frost:.2f} m2, by hand {frostByHand:.2f} m2 ({behind:.2f} m behind the wall, {below:.2f} m below the surface)")
print(f"the backfill has grown by {growth[midwinter]:.3f} m2, by hand {growthByHand:.3f} m2")
print(
	"largest thrust of the winters "
	+ " and ".join(f"{value / 1e3:.0f} kN/m" for value in largest if value)
	+ f", {largest[0] / autumn:.1f} times that before the frost"
)

figure = plots.figure(8, 8.5)
panels = figure.subplots(3, 1, height_ratios=(1, 1, 1))
panels[0].plot(np.array(times) / talik.day, air, color="0.4")
panels[0].axhline(0, color="black", linewidth=0.6)
panels[0].set_ylabel("air [°C]")
panels[1].plot(record[:, 0], record[:, -1] / 1e3, color="black", linewidth=0.8, label="thrust on the wall")
panels[1].axhline(thrustByHand / 1e3, color="crimson", linestyle="--", label="at rest, by hand")
panels[1].set_xlabel("time [days since 1 October]")
panels[1].set_ylabel("thrust [kN/m]")
panels[1].legend()
panels[0].set_xlim(0, lastDay)
panels[1].set_xlim(0, lastDay)
for title, frame in states.items():
	plots.ground(panels[2], frame, "iceSaturation", start=False)
	bodies.draw(panels[2], [O.bodies[wall]], color="0.3")
	panels[2].set(xlim=(-0.4, width + 0.1), ylim=(-0.1, height + 0.6))
	panels[2].set_title(title, loc="left", fontsize=10)
plots.save(figure, folder / "retaining_wall.png", dpi=100)
output.writeSummary(
	folder / "summary.json",
	**{
		"thrust before the frost [N/m]": autumn,
		"thrust by hand [N/m]": thrustByHand,
		"frozen area [m2]": frost,
		"frozen area by hand [m2]": frostByHand,
		"growth [m2]": growth[midwinter],
		"growth by hand [m2]": growthByHand,
		"largest thrust of each winter [N/m]": largest,
	},
)
if abs(autumn / thrustByHand - 1) > 0.1:
	output.unexpected("the thrust before the frost is more than 10 % off the calculation by hand")
if not 0.75 * frostByHand < frost < 1.05 * frostByHand:
	output.unexpected("the frozen area is not between 75 and 105 % of the calculation by hand")
if not 0.75 * growthByHand < growth[midwinter] < 1.1 * growthByHand:
	output.unexpected("the backfill has not grown by 75 to 110 % of what its ice has")
print(f"picture, table and summary are in {folder}")
