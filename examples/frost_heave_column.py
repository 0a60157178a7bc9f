# SPDX-License-Identifier: GPL-2.0-or-later
"""Silt above a water table freezes from its surface for a winter, draws water to the front and heaves, beside a calculation by hand.

	scripts/run frost_heave_column [--preset test|draft|standard]

By hand, as frost-heave designs do: the front at the depth Z takes the heat k T/Z away, which freezes the water of the pores, n L dZ/dt, and the water
that is drawn there, q = SP(P) T/Z, with the segregation potential under the effective stress at the front, SP = SP_0 exp(-a P). What is drawn heaves
the ground by 1.1 times its volume. It seeps up from the base, so that the pressure at the front is lower by q/k times the way. The pore water expands
by 9 % and finds its way out or not: up to that more is added. Heat of the ground itself is left out.
Change the segregation potential, the permeability, the water table or the winter first.
"""

import argparse
import math

import numpy as np
from yade import O

import talik
from talik import output, plots
from talik.files import writableFolder

parser = argparse.ArgumentParser(description=__doc__.splitlines()[0])
parser.add_argument("--preset", default="draft", choices=("test", "draft", "standard"), help="size of the job")
parser.add_argument("--output", default="output/frost_heave_column", help="folder for the results")
parser.add_argument("--surface", type=float, default=-5.0, help="temperature of the surface from the fifth day on [degC], below 0")
parser.add_argument("--segregation-potential", type=float, default=1.5e-9, help="of the soil without load [m^2/(s K)]")
parser.add_argument("--table", type=float, default=1.2, help="depth of the water table [m], 0 to 3")
options = parser.parse_args()
folder = writableFolder(options.output)

h, winter = {"test": (0.1, 40), "draft": (0.1, 120), "standard": (0.05, 120)}[options.preset]  # grid spacing [m], days
depth, table, porosity, conductivity = 3.0, options.table, 0.4, 1e-8  # of the ground and of the water table [m]; k [m/s]
cold = options.surface  # surface from the fifth day on [degC]
segregation = IceSegregation(segregationPotential=options.segregation_potential, pressureDecay=8e-6)  # a silt; measured in the laboratory [m^2/(s K), 1/Pa]

mpm = MpmEngine(
	gridSpacing=h,
	lower=(0, 0),
	upper=(h, depth + 0.4),
	gravity=(0, -9.81),
	damping=0.3,
	heat=HeatTransfer(thermalTimeScale=1e6),
	freezing=FreezingCurve(width=0.3),
	water=PoreWater(conductivity=conductivity, cavitationPressure=-1e5),
	segregation=segregation,
	skeleton=MohrCoulombSkeleton(young=1e7, youngFrozen=5e7, frictionAngle=30, cohesion=0, cohesionFrozen=5e5),
	boundaries=[
		*(RollerBoundary(region=side) for side in ("left", "right", "bottom")),
		WallTemperature(region="bottom", temperature=1),
		DrainedBoundary(region="bottom", pressure=9810 * (depth - table), recharge=True),
		SurfaceTemperature(region="surface", days=[0, 5], values=[1, cold]),
	],
)
position, volume = talik.geometry.fillPolygon(talik.geometry.rectangle(0, 0, h, depth), h, pointsPerCell=1)
below = depth - position[:, 1]
pressure = 9810 * (below - table)
stress = np.zeros((len(volume), 4))
stress[:, 1] = -9.81 * ((1 - porosity) * 2650 + porosity * 1000) * below + pressure
stress[:, 0] = stress[:, 2] = 0.5 * stress[:, 1]
mpm.addPoints(position=position, volume=volume, porosity=porosity, temperature=1, pressure=pressure, stress=stress)
O.engines = [mpm]
O.step()

top, rows = int(np.argmax(position[:, 1])), []
while mpm.calendar["day"] < winter - 1e-6:
	talik.runUntilDay(mpm, min(winter, mpm.calendar["day"] + 2))
	frozen = (mpm.field("iceSaturation") * volume).sum() / 0.95 / h
	ice = mpm.field("segregatedVolume").sum() / h
	surface = mpm.field("displacement")[top, 1] + 0.5 * (mpm.field("volume")[top] - volume[top]) / h
	rows.append((mpm.calendar["day"], frozen, ice, surface, mpm.balance()["waterDrawn"] / h / 1000))
day, frozen, ice, heave, drawn = np.array(rows).T

frozenConductivity, latent = (1 - porosity) + porosity * (0.95 * 2.2 + 0.05 * 0.6), 334e3
steps, front, byHand, drawnByHand = np.linspace(0, winter, 4000), [0.02], [0.0], 0.0
for before, after in zip(steps, steps[1:]):
	surface = np.interp(after, [0, 5], [1, cold])
	gradient = max(0, -surface) / (front[-1] + byHand[-1])
	pressure = 9810 * (front[-1] - table - drawnByHand * (depth - front[-1]) / conductivity)  # of the water at the front
	potential = segregation.segregationPotential * math.exp(-segregation.pressureDecay * (9.81 * 1990 * front[-1] - pressure))
	drawnByHand += 0.5 * (potential * gradient - drawnByHand)  # the pressure follows from it
	seconds = (after - before) * talik.day
	byHand.append(byHand[-1] + seconds * drawnByHand / 0.91)
	front.append(front[-1] + seconds * (frozenConductivity * gradient - 1000 * latent * drawnByHand) / (910 * latent * porosity * 0.95))
print(f"{mpm.pointCount} points, {O.iter} steps")
print(f"after {day[-1]:.0f} days: {frozen[-1]:.2f} m of soil are frozen, by hand {front[-1]:.2f} m")
print(f"excess ice {1e3 * ice[-1]:.0f} mm, by hand {1e3 * byHand[-1]:.0f} mm")
print(f"heave {1e3 * heave[-1]:.0f} mm, {1e3 * drawn[-1]:.0f} mm of water were drawn")

figure = plots.figure(8, 7)
panels = figure.subplots(2, 1, sharex=True)
panels[0].plot(day, frozen, color="black", label="computed")
panels[0].plot(steps, front, "--", color="black", label="by hand, without heat of the ground itself")
panels[0].set(ylabel="thickness of frozen soil [m]")
panels[0].invert_yaxis()
panels[1].plot(day, 1e3 * heave, color="black", label="heave of the surface, with the 9 % of the pore water")
panels[1].plot(day, 1e3 * ice, color="tab:blue", label="of which excess ice")
panels[1].plot(steps, 1e3 * np.array(byHand), "--", color="tab:blue", label="by hand: segregation potential and seepage")
panels[1].set(xlabel="time [days]", ylabel="[mm]")
for axes in panels:
	axes.set_xlim(0, day[-1])
	axes.legend(frameon=False)
plots.save(figure, folder / "frost_heave_column.png", dpi=100)
output.writeSummary(
	folder / "summary.json",
	**{
		"frozen soil [m]": frozen[-1],
		"frozen soil by hand [m]": front[-1],
		"excess ice [m]": ice[-1],
		"excess ice by hand [m]": byHand[-1],
		"heave [m]": heave[-1],
	},
)
if not 0.85 < ice[-1] / byHand[-1] < 1.05:  # by hand the ground itself has no heat, so that the front is deeper
	output.unexpected("the excess ice is more than 15 % below the calculation by hand, or 5 % above it")
print(f"picture and summary are in {folder}")
