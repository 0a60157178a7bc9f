# SPDX-License-Identifier: GPL-2.0-or-later
"""A warm pipe buried in ice-rich permafrost thaws a bulb around itself and settles, over five years.

	scripts/run warm_pipeline [--preset test|draft|standard]

By hand: heat that a cylinder of radius r gives to ground at the melting point thaws it up to R after the time
L/(k T) (R^2/2 ln(R/r) - (R^2 - r^2)/4), from 2 pi k T/ln(R/r) = 2 pi R L dR/dt; what warms the ground and what the cold surface takes
is left out, so the bulb stays smaller. In the end its lowest point is that of two steady temperature fields around a buried pipe,
thawed within frozen, each of a line source and its image above the surface. The pipe settles by the thaw strain times the depth thawed below it.
Nothing slides along the thaw here, so frozen and thawed ground have one velocity (thawFront=None).
Change temperature, depth or radius of the pipe first.
"""

import argparse
import math

import numpy as np
from yade import O, utils

import talik
from talik import output, plots
from talik.files import writableFolder

parser = argparse.ArgumentParser(description=__doc__.splitlines()[0])
parser.add_argument("--preset", default="draft", choices=("test", "draft", "standard"), help="size of the job")
parser.add_argument("--output", default="output/warm_pipeline", help="folder for the results")
parser.add_argument("--pipe", type=float, default=6.0, help="temperature of the pipe [degC], above 0")
parser.add_argument("--ground", type=float, default=-0.5, help="temperature of ground and surface [degC], below 0")
parser.add_argument("--porosity", type=float, default=0.5, help="of the frozen ground, ice in excess included [-]")
parser.add_argument("--thawed-porosity", type=float, default=0.42, help="of the ground when it has thawed and drained [-]")
options = parser.parse_args()
folder = writableFolder(options.output)

h, years = {"test": (0.25, 0.4), "draft": (0.25, 5), "standard": (0.125, 5)}[options.preset]  # grid spacing [m]
width, depth, radius, axis = 10.0, 7.0, 0.6, 1.8  # of the ground; of the pipe and the depth of its axis [m]
warm, cold, porosity, thawedPorosity = options.pipe, options.ground, options.porosity, options.thawed_porosity
silt = GroundMaterial(name="ice-rich silt", solidConductivity=2.0, thawStrain=talik.layers.thawStrain(porosity, thawedPorosity))

pipe = utils.sphere((width / 2, depth - axis, 0), radius, material=O.materials.append(FrictMat(frictionAngle=0.4)))
pipe.state.mass, pipe.state.blockedDOFs = 1500 * math.pi * radius**2, "xzXYZ"  # per metre of thickness
O.bodies.append(pipe)
mpm = MpmEngine(
	gridSpacing=h,
	lower=(0, 0),
	upper=(width, depth + 2 * h),
	gravity=(0, -9.81),
	damping=0.5,
	thawFront=None,
	heat=HeatTransfer(thermalTimeScale=1.5e7),
	freezing=FreezingCurve(width=0.15),
	skeleton=MohrCoulombSkeleton(young=1e7, youngFrozen=4e7, frictionAngle=28, cohesion=2e3, cohesionFrozen=2e5),
	bodies=BodyContact(),
	boundaries=[
		*(RollerBoundary(region=side) for side in ("left", "right", "bottom")),
		SurfaceTemperature(region="surface", temperature=cold),
		BodyTemperature(bodies=[pipe.id], times=[0, 10 * talik.day], values=[cold, warm]),
	],
)
trench = [(width / 2 + radius * math.cos(a), depth - axis + radius * math.sin(a)) for a in np.linspace(0, 2 * math.pi, 48, endpoint=False)]
ground = dict(polygon=talik.geometry.rectangle(0, 0, width, depth), holes=[trench], porosity=porosity, temperature=cold, material=silt)
talik.layers.fill(mpm, {"silt": ground}, lateralRatio=0.5)
O.engines = [ForceResetter(), mpm, NewtonIntegrator(gravity=(0, -9.81, 0), damping=0.4)]
O.step()

rows = []
while mpm.calendar["day"] < 365 * years:
	talik.runUntilDay(mpm, mpm.calendar["day"] + 36.5)
	thawed = mpm.field("iceSaturation") < 0.5
	bulb = math.sqrt(mpm.field("volume")[thawed].sum() / math.pi + radius**2)
	lowest = depth - axis - mpm.field("position")[thawed, 1].min(initial=depth - axis - radius)
	rows.append((mpm.calendar["day"], bulb, lowest, -pipe.state.displ()[1]))

thawedConductivity, frozenConductivity = (1 - porosity) * 2.0 + porosity * 0.6, (1 - porosity) * 2.0 + porosity * 2.2
latent, radii = porosity * 910 * 334e3, np.linspace(radius, 8 * radius, 2000)
days = latent / (thawedConductivity * warm * talik.day) * (radii**2 / 2 * np.log(radii / radius) - (radii**2 - radius**2) / 4)
share = frozenConductivity * -cold / (thawedConductivity * warm + frozenConductivity * -cold)
ofFront, half = share * math.acosh(axis / radius), math.sqrt(axis**2 - radius**2)
steady = half / math.tanh(ofFront) + half / math.sinh(ofFront) - axis  # lowest point of the bulb below the axis
day, bulb, lowest, settlement = rows[-1]
byHand, settledByHand = np.interp(day - 10, days, radii), silt.thawStrain * (lowest - radius)
print(f"{mpm.pointCount} points, {O.iter} steps, {day / 365:.1f} years")
print(f"radius of the thaw bulb {bulb:.2f} m, by hand {byHand:.2f} m; lowest point {lowest:.2f} m below the axis, in the end, by hand, {steady:.2f} m")
print(f"the pipe has settled by {1e3 * settlement:.0f} mm, by hand {1e3 * settledByHand:.0f} mm")

figure = plots.figure(8, 10.5)
panels = figure.subplots(3, 1, height_ratios=(2.2, 1, 1))
plots.ground(panels[0], output.allFields(mpm), "iceSaturation", start=False)
circle = np.array(trench + trench[:1])
panels[0].fill(*(circle - (0, settlement)).T, facecolor="0.75", edgecolor="black")
panels[0].plot(*circle.T, color="0.35", linestyle="--", linewidth=0.8)
panels[0].set_title(f"after {day / 365:.1f} years; dashed: the pipe at the start, grey: now", loc="left", fontsize=10)
time, bulbs, lowests, settlements = np.array(rows).T
panels[1].plot(time / 365, bulbs, color="black", label="computed")
panels[1].plot(time / 365, np.interp(time - 10, days, radii), "--", color="black", label="by hand, no heat lost to frozen ground")
panels[1].set(ylabel="radius of the thaw bulb [m]", ylim=(0, None))
panels[2].plot(time / 365, settlements, color="black", label="computed")
panels[2].plot(time / 365, silt.thawStrain * (lowests - radius), "--", color="black", label="thaw strain times the depth thawed below the pipe")
panels[2].set(xlabel="time [years]", ylabel="settlement of the pipe [m]", ylim=(0, None))
for axes in panels[1:]:
	axes.set_xlim(0, time[-1] / 365)
	axes.legend(frameon=False)
plots.save(figure, folder / "warm_pipeline.png", dpi=100)
output.writeSummary(
	folder / "summary.json",
	**{
		"radius [m]": bulb,
		"radius by hand [m]": byHand,
		"settlement [m]": settlement,
		"settlement by hand [m]": settledByHand,
		"lowest in the end [m]": steady,
	},
)
if not 0.7 * byHand < bulb < 1.05 * byHand:
	output.unexpected("the thaw bulb is not between 70 and 105 % of the calculation by hand")
if abs(settlement / settledByHand - 1) > 0.25:
	output.unexpected("the settlement of the pipe is more than 25 % off the calculation by hand")
print(f"picture and summary are in {folder}")
