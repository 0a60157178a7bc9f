# SPDX-License-Identifier: GPL-2.0-or-later
"""A steep frozen slope creeps for half a year by Glen's law of its ice bonds, against the infinite slope.

	scripts/run creeping_slope [--preset test|draft|standard]

A layer of frozen ground lies on rock that is so steep that friction does not hold it: ice does, and flows. A creep test on the sample gives its
strain over A(T) t σⁿ, with the stresses of a slope of this inclination. The rate factor of the bonds is chosen so that the sample creeps like ice in
the end. By hand every depth z of an infinite slope follows that test with its own stress τ = ρ g z sin(slope), and the surface moves by

	u = 2 ∫ ε(A t τⁿ) dz,   in the end at Glen's speed 2 A_s τ_0ⁿ H/(n+1)

Change slope, temperature or years first. At 75° the shear stress is 3.7 times the normal stress; in a gentle slope the grains
hold each other. The layer is nine times as long as thick; one of five times its thickness is 19 % too fast.
"""

import argparse
import math

import numpy as np
from yade import O, wrapper

import talik
from talik import output, plots
from talik.studies import creep
from talik.files import writableFolder

parser = argparse.ArgumentParser(description=__doc__.splitlines()[0])
parser.add_argument("--preset", default="draft", choices=("test", "draft", "standard"), help="size of the job")
parser.add_argument("--output", default="output/creeping_slope", help="folder for the results")
options = parser.parse_args()
folder = writableFolder(options.output)

presets = {
	"test": (1.0, 28.0, 0.5, 0.03, dict(grains=40, seed=3)),
	"draft": (1.0, 36.0, 2.0, 0.01, dict(grains=100)),
	"standard": (0.5, 36.0, 2.0, 0.01, dict(grains=100)),
}
# [m], [m], [s of motion], part of the stress of a bond that a call of the creep test relaxes, what the sample is prepared from
spacing, length, motion, relaxed, prepared = presets[options.preset]
thickness, slope, temperature, years = 4.0, math.radians(75), -1.0, 0.5

(frozen,) = creep.frozenSamples(**prepared, realisations=1)
ice = wrapper.IceCreep()
test = creep.creepTest(frozen, ice, (None, -1 / math.tan(slope), 1.0), stress=60e3, strain=0.05, relaxed=relaxed, calls=40000)
ofBonds = ice.rateFactorAt(-10) * test.stress**ice.exponent
factor = test.secondaryRate() / ofBonds
law = wrapper.IceCreep(rateFactor=ice.rateFactor / factor)
print(f"the sample creeps {factor:.3g} times as fast as its bonds; their rate factor is divided by that")

mpm = wrapper.MpmEngine(
	gridSpacing=spacing,
	lower=(0, 0),
	upper=(length + 8 * spacing, thickness + 2 * spacing),
	gravity=(9.81 * math.sin(slope), -9.81 * math.cos(slope)),
	damping=0.3,
	heat=wrapper.HeatTransfer(thermalTimeScale=years * 365 * 86400 / motion),
	skeleton=wrapper.RveSkeleton(samples=[frozen], iceCreep=law, strainTolerance=0, prediction=False),
	boundaries=[wrapper.FixedBoundary(region="bottom")],
)
position, volume = talik.geometry.fillPolygon(talik.geometry.rectangle(2 * spacing, 0, 2 * spacing + length, thickness), spacing)
mpm.addPoints(position=position, volume=volume, porosity=0.4, temperature=temperature)
O.engines = [mpm]
mpm.initialise()

atMidLength = np.abs(position[:, 0] - 2 * spacing - 0.5 * length) < spacing
heights = np.unique(position[atMidLength, 1])
rows = []
while mpm.time < motion:
	O.step()
	if O.iter % 20 == 0:
		moved = mpm.field("displacement")[:, 0]
		rows.append((mpm.calendar["day"], *(moved[atMidLength & (position[:, 1] == height)].mean() for height in heights)))
rows = np.array(rows)
days, surface = rows[:, 0], rows[:, -1]
density = float(mpm.field("mass")[0] / mpm.field("volume")[0])


def byHand(day, height):
	"""Displacement [m] at a height over the rock."""
	z = np.linspace(0, height, 400)
	stress = density * 9.81 * math.sin(slope) * (thickness - z)
	flown = law.rateFactorAt(temperature) * day * 86400 * stress**law.exponent
	known = np.concatenate(([0], ice.rateFactorAt(-10) * test.time * test.stress**ice.exponent))
	return 2 * np.trapz(np.interp(flown, known, np.concatenate(([0], test.strain))), z)


expected = np.array([byHand(day, heights[-1]) for day in days])
late = len(days) // 2
speed, wanted = ((u[-1] - u[late]) / (days[-1] - days[late]) * 365 for u in (surface, expected))
stressAtRock = density * 9.81 * math.sin(slope) * thickness
glen = 2 * factor * law.rateFactorAt(temperature) * stressAtRock**law.exponent * thickness / (law.exponent + 1) * 365 * 86400
print(f"{mpm.pointCount} points, {O.iter} steps; in {days[-1]:.0f} days the surface moves by {1e3 * surface[-1]:.0f} mm, by hand {1e3 * expected[-1]:.0f} mm")
print(f"speed in the second half {1e3 * speed:.1f} mm a year, by hand {1e3 * wanted:.1f}, Glen's infinite slope in the end {1e3 * glen:.1f}")

figure = plots.figure(9, 4)
ofTime, ofHeight = figure.subplots(1, 2)
ofTime.plot(days, 1e3 * surface, color="black", label="surface at mid-length")
ofTime.plot(days, 1e3 * expected, "--", color="crimson", label="infinite slope by hand")
ofTime.set(xlabel="time [days]", ylabel="displacement [mm]")
ofTime.legend(frameon=False)
ofHeight.plot(1e3 * rows[-1, 1:], heights, "o", color="black", label="points at mid-length")
ofHeight.plot([1e3 * byHand(days[-1], height) for height in heights], heights, "--", color="crimson", label="infinite slope by hand")
ofHeight.set(xlabel=f"displacement after {days[-1]:.0f} days [mm]", ylabel="height over the rock [m]")
plots.save(figure, folder / "creeping_slope.png", dpi=100)
output.writeSummary(folder / "summary.json", **{"speed [m/year]": float(speed), "by hand [m/year]": float(wanted), "Glen in the end [m/year]": float(glen)})
if abs(speed / wanted - 1) > 0.15:
	output.unexpected("the speed is more than 15 % off the calculation by hand")
print(f"picture and summary are in {folder}")
