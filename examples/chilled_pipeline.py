# SPDX-License-Identifier: GPL-2.0-or-later
"""A chilled pipe in unfrozen silt freezes a bulb around itself, draws water to its front and heaves for two years, beside a calculation by hand.

	scripts/run chilled_pipeline [--preset test|draft|standard]

By hand, with the segregation potential of Konrad & Morgenstern (1984, Canadian Geotechnical Journal 21, 100): heat flows radially to a pipe of the
radius r. Behind the front at the radius R the gradient is G = T/(R ln(R/r)), and the front draws q = SP_0 exp(-a P) G. P is the effective weight of the
ground above its lowest point. The heat k G freezes what is drawn and the water of the pores, less the heat that comes from outside, which is
solved on radial cells: from ground without end, or from a surface that stays warm, which is as far for heat as a cylinder of twice the depth of
the axis. What is drawn below the pipe lifts it by 1.1 times its volume. Part of the 9 % by which the pore water expands is added. What the pipe
presses together below, and what holds the bulb down beside its weight, are left out by hand.
One half of the section is computed. Change the temperature of the pipe, its depth or the segregation potential first.
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
parser.add_argument("--output", default="output/chilled_pipeline", help="folder for the results")
parser.add_argument("--pipe", type=float, default=-4.0, help="temperature of the pipe [degC], below 0")
parser.add_argument("--segregation-potential", type=float, default=1e-9, help="of the soil without load [m^2/(s K)]")
parser.add_argument("--porosity", type=float, default=0.4, help="of the soil [-]")
parser.add_argument("--conductivity", type=float, default=2.0, help="thermal, of the grains [W/(m K)]")
parser.add_argument("--diameter", type=float, default=1.2, help="of the pipe [m]")
parser.add_argument("--years", type=float, help="that are computed")
options = parser.parse_args()
folder = writableFolder(options.output)

h, years = {"test": (0.25, 0.25), "draft": (0.25, 2), "standard": (0.125, 2)}[options.preset]  # grid spacing [m]
years = options.years or years
width, depth, radius, axis = 6.0, 7.0, options.diameter / 2, 1.8  # of half the ground; of the pipe and the depth of its axis [m]
warm, cold, chilling = 4.0, options.pipe, 10.0  # of the ground and of the pipe, which it reaches after some days [degC]
porosity, solidConductivity, conductivity = options.porosity, options.conductivity, 1e-8  # [W/(m K)], [m/s]; the water table is at the surface
segregation = IceSegregation(segregationPotential=options.segregation_potential, pressureDecay=8e-6)  # a silt [m^2/(s K), 1/Pa]

pipe = utils.sphere((0, depth - axis, 0), radius, material=O.materials.append(FrictMat(frictionAngle=0.4)))
pipe.state.mass, pipe.state.blockedDOFs = 1600 * math.pi * radius**2 / 2, "xzXYZ"  # per metre of thickness
O.bodies.append(pipe)
mpm = MpmEngine(
	gridSpacing=h,
	lower=(0, 0),
	upper=(width, depth + 4 * h),
	gravity=(0, -9.81),
	damping=0.5,
	thawFront=None,
	material=GroundMaterial(name="silt", solidConductivity=solidConductivity),
	heat=HeatTransfer(thermalTimeScale=4e6),
	freezing=FreezingCurve(width=0.3),
	water=PoreWater(conductivity=conductivity, cavitationPressure=-1e5),
	segregation=segregation,
	skeleton=MohrCoulombSkeleton(young=1e7, youngFrozen=5e7, frictionAngle=28, cohesion=1e3, cohesionFrozen=5e5),
	bodies=BodyContact(),
	boundaries=[
		*(RollerBoundary(region=side) for side in ("left", "right", "bottom")),
		DrainedBoundary(region="surface"),
		DrainedBoundary(region="bottom", pressure=9810 * depth),
		SurfaceTemperature(region="surface", temperature=warm),
		WallTemperature(region="bottom", temperature=warm),
		BodyTemperature(bodies=[pipe.id], times=[0, chilling * talik.day], values=[warm, cold]),
	],
)
trench = [(radius * math.cos(a), depth - axis + radius * math.sin(a)) for a in np.linspace(math.pi / 2, -math.pi / 2, 25)]
ground = dict(
	polygon=[(0, 0), (width, 0), (width, depth), (0, depth), *trench],
	porosity=porosity,
	temperature=warm,
	pressure=lambda x, y: 9810 * (depth - y),
)
talik.layers.fill(mpm, {"silt": ground}, lateralRatio=0.5, pointsPerCell=4)  # the first frozen ring is thinner than a cell
O.engines = [ForceResetter(), mpm, NewtonIntegrator(gravity=(0, -9.81, 0), damping=0.4)]
O.step()

start = mpm.field("position")
below = (start[:, 0] < h) & (start[:, 1] < depth - axis - radius)
rows = []
while mpm.calendar["day"] < 365 * years - 1e-6:
	talik.runUntilDay(mpm, min(365 * years, mpm.calendar["day"] + 365 * years / 40))
	frozen = mpm.field("iceSaturation")[below].sum() / 0.95 * (h / 2) ** 2 / h
	ice = mpm.field("segregatedVolume")[below].sum() / h
	rows.append((mpm.calendar["day"], frozen, ice, pipe.state.displ()[1]))
day, frozen, ice, heave = np.array(rows).T


def byHand(outer, cell=0.1):
	"""Days, thickness of frozen ground below the pipe and excess ice there [m]; outer: radius at which the ground stays warm [m]."""
	solid, latent = (1 - porosity) * solidConductivity, 334e3
	frozenConductivity, unfrozenConductivity = solid + porosity * (0.95 * 2.2 + 0.05 * 0.6), solid + porosity * 0.6
	capacity = (1 - porosity) * 2650 * 800 + porosity * 1000 * 4200
	faces = radius + cell * np.arange(round((outer - radius) / cell) + 1)
	middles = faces[1:] - 0.5 * cell
	temperature, front, drawn, time, result = np.full(len(middles), warm), radius + 1e-3, 0.0, 0.0, [(0.0, 0.0, 0.0)]
	step = 0.2 * cell**2 * capacity / unfrozenConductivity
	while time < years * 365 * talik.day:
		time += step
		ofPipe = np.interp(time, [0, chilling * talik.day], [warm, cold])
		first = int(np.argmax(middles > front + 0.5 * cell)) if ofPipe < 0 else 0  # unfrozen cell
		inner, value = (front, 0.0) if ofPipe < 0 else (radius, ofPipe)
		flow = np.zeros(len(middles) + 1)  # heat towards the pipe, over 2 pi [W/m]
		flow[1:-1] = faces[1:-1] * unfrozenConductivity * np.diff(temperature) / cell
		flow[-1] = outer * unfrozenConductivity * (warm - temperature[-1]) / (0.5 * cell)
		flow[first] = 0.5 * (inner + middles[first]) * unfrozenConductivity * (temperature[first] - value) / (middles[first] - inner)
		temperature[first:] += step * np.diff(flow)[first:] / (capacity * middles[first:] * cell)
		if ofPipe < 0:
			gradient = -ofPipe / (front * math.log(front / radius))
			load = 9.81 * (1 - porosity) * (2650 - 1000) * (axis + front)
			intake = segregation.segregationPotential * math.exp(-segregation.pressureDecay * load) * gradient
			freezing = frozenConductivity * gradient - flow[first] / front - 1000 * latent * intake
			front = max(radius + 1e-3, front + step * freezing / (910 * latent * porosity * 0.95))
			drawn += step * intake / 0.91
		result.append((time / talik.day, front - radius, drawn))
	return np.array(result).T


endless, nearSurface = byHand(8.0), byHand(2 * axis)
thin = 45.0  # [days]: the frozen ring is thinner than two cells before
hands = [(np.interp(day[-1], hand[0], hand[1]), np.interp(day[-1], hand[0], hand[2])) for hand in (endless, nearSurface)]
later = [np.interp(day[-1], hand[0], hand[2]) - np.interp(thin, hand[0], hand[2]) for hand in (endless, nearSurface)]
laterIce = ice[-1] - np.interp(thin, day, ice)
print(f"{mpm.pointCount} points, {O.iter} steps, {day[-1]:.0f} days")
print(f"{frozen[-1]:.2f} m of ground are frozen below the pipe, by hand {hands[0][0]:.2f} m without end, {hands[1][0]:.2f} m with the heat of the surface")
print(f"excess ice below the pipe {1e3 * ice[-1]:.0f} mm, by hand {1e3 * hands[0][1]:.0f} and {1e3 * hands[1][1]:.0f} mm")
print(f"since day {thin:.0f} {1e3 * laterIce:.0f} mm, by hand {1e3 * later[0]:.0f} and {1e3 * later[1]:.0f} mm")
print(f"the pipe has heaved by {1e3 * heave[-1]:.0f} mm")
for first, last in ((0, 200), (200, 500), (500, 1095)):
	if last <= day[-1] + 1e-6:
		rate = (np.interp(last, day, heave) - np.interp(first, day, heave, left=0.0)) / (last - first)
		print(f"from day {first} to {last} by {1e3 * rate:.3f} mm a day")

figure = plots.figure(8, 11)
panels = figure.subplots(3, 1, height_ratios=(2.4, 1, 1))
plots.ground(panels[0], output.allFields(mpm), "iceSaturation", start=False)
circle = np.array(trench)
panels[0].fill(*(circle + (0, heave[-1])).T, facecolor="0.75", edgecolor="black")
panels[0].plot(*circle.T, color="0.35", linestyle="--", linewidth=0.8)
panels[0].set_title(f"half the section after {day[-1] / 365:.2g} years; dashed: the pipe at the start, grey: now", loc="left", fontsize=10)
panels[1].plot(day / 365, frozen, color="black", label="computed")
panels[1].plot(endless[0] / 365, endless[1], "--", color="black", label="by hand, ground without end")
panels[1].plot(nearSurface[0] / 365, nearSurface[1], ":", color="black", label="by hand, with the heat of the surface")
panels[1].set(ylabel="frozen below the pipe [m]", ylim=(0, None))
panels[2].plot(day / 365, 1e3 * heave, color="black", label="heave of the pipe")
panels[2].plot(day / 365, 1e3 * ice, color="tab:blue", label="excess ice below the pipe")
panels[2].plot(endless[0] / 365, 1e3 * endless[2], "--", color="tab:blue", label="by hand, ground without end")
panels[2].plot(nearSurface[0] / 365, 1e3 * nearSurface[2], ":", color="tab:blue", label="by hand, with the heat of the surface")
panels[2].set(xlabel="time [years]", ylabel="[mm]", ylim=(0, 1.6e3 * nearSurface[2][-1]))
for axes in panels[1:]:
	axes.set_xlim(0, day[-1] / 365)
	axes.legend(frameon=False, loc="lower right" if axes is panels[1] else "upper left")
plots.save(figure, folder / "chilled_pipeline.png", dpi=100)
output.writeSummary(
	folder / "summary.json",
	**{
		"frozen below the pipe [m]": frozen[-1],
		"frozen by hand [m]": [hand[0] for hand in hands],
		"excess ice [m]": ice[-1],
		"excess ice by hand [m]": [hand[1] for hand in hands],
		"heave of the pipe [m]": heave[-1],
	},
)
if not 0.9 * hands[1][0] < frozen[-1] < 1.1 * hands[0][0]:
	output.unexpected("the frozen ground below the pipe is not within 10 % of the two calculations by hand")
if not 0.8 * min(later) < laterIce < 1.2 * max(later):
	output.unexpected("the excess ice below the pipe since its front has passed the first cells is not within 20 % of the two calculations by hand")
print(f"picture and summary are in {folder}")
