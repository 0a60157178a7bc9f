# SPDX-License-Identifier: GPL-2.0-or-later
"""A strip footing on ice-rich frozen ground settles for a year by Glen's law, beside an estimate by hand.

	scripts/run creeping_footing [--preset test|draft|standard]

The ground is elastic and flows by Glen's law (CreepingSkeleton) at the rate of glacier ice, as ice-rich soil does to order of magnitude. The
footing is a Box of YADE under a constant force. By hand, after Ladanyi (Ladanyi & Johnston 1974, Ladanyi 1975): the footing pushes the ground
aside as a cylinder of radius B/2 does that expands under the pressure q of the footing, and its lower half takes what the footing pushes
away. In ground without end its wall moves by u' = A (q/n)^n B/2 (Nye 1953):

	B s' = π (B/2) u'    s' = (π/4) B A (q/n)^n

Change width, temperature or loads first. The weight of the ground is left out: it presses from all sides alike, and volume does not creep.
"""

import argparse
import math

import numpy as np
from yade import O, utils, wrapper

import talik
from talik import bodies, output, plots
from talik.files import writableFolder

parser = argparse.ArgumentParser(description=__doc__.splitlines()[0])
parser.add_argument("--preset", default="draft", choices=("test", "draft", "standard"), help="size of the job")
parser.add_argument("--output", default="output/creeping_footing", help="folder for the results")
parser.add_argument("--exponent", type=float, default=3.0, help="n of Glen's law; A keeps the rate at 100 kPa")
options = parser.parse_args()
folder = writableFolder(options.output)

spacing = {"test": 0.5, "draft": 0.25, "standard": 0.125}[options.preset]  # [m]
footingWidth, footingHeight, width, depth = 2.0, 0.5, 16.0, 8.0  # [m]
loads = (100e3, 140e3, 200e3)  # [Pa]
temperature, year, motion, loading = -2.0, 365 * talik.day, 0.3, 0.03  # [degC], [s], [s], [s]
law = wrapper.IceCreep(exponent=options.exponent)
law.rateFactor *= 100e3 ** (3 - law.exponent)


def build():
	"""Ground with the footing on it: engine, box, how far the middle of the ground is below a point."""
	O.reset()
	material = O.materials.append(wrapper.FrictMat(frictionAngle=0.5, density=2500))
	box = utils.box((width / 2, depth + footingHeight / 2, 0), (footingWidth / 2, footingHeight / 2, 0.5), material=material)
	box.state.blockedDOFs = "xzXYZ"
	O.bodies.append(box)
	mpm = wrapper.MpmEngine(
		gridSpacing=spacing,
		lower=(0, 0),
		upper=(width, depth + 1),
		damping=0.3,
		heat=wrapper.HeatTransfer(thermalTimeScale=year / motion),
		skeleton=wrapper.CreepingSkeleton(young=1e9, iceCreep=law),
		bodies=wrapper.BodyContact(),
		boundaries=[
			wrapper.RollerBoundary(region="left"),
			wrapper.RollerBoundary(region="right"),
			wrapper.FixedBoundary(region="bottom"),
		],
	)
	talik.geometry.fill(mpm, talik.geometry.rectangle(0, 0, width, depth), temperature=temperature)
	O.engines = [wrapper.ForceResetter(), mpm, wrapper.NewtonIntegrator(damping=0.4)]
	O.step()  # sets O.dt
	return mpm, box


def settle(load):
	"""Days and settlements [m] of a year under a load [Pa], with the engine and the box in the end."""
	mpm, box = build()
	rows = []
	for instant in np.linspace(0, motion, 121)[1:]:
		O.forces.setPermF(box.id, (0, -load * footingWidth * min(1.0, instant / loading), 0))
		talik.runSerially(max(1, round((instant - O.time) / O.dt)))
		rows.append((mpm.calendar["day"], -box.state.displ()[1], O.forces.f(box.id)[1] + load * footingWidth))
	return np.array(rows), mpm, box


def byHand(load):
	"""Settlement in a year [m]."""
	return math.pi / 4 * footingWidth * law.rateFactorAt(temperature) * (load / law.exponent) ** law.exponent * year


figure = plots.figure(9, 8)
grid = figure.add_gridspec(2, 2)
ofTime, ofLoad, section = figure.add_subplot(grid[0, 0]), figure.add_subplot(grid[0, 1]), figure.add_subplot(grid[1, :])
rates, expected = [], np.array([byHand(load) for load in loads])
for load, hand, colour in zip(loads, expected, ("C0", "C1", "crimson")):
	rows, mpm, box = settle(load)
	days, settled, carried = rows.T
	late = len(days) // 2
	rates.append((settled[-1] - settled[late]) / (days[-1] - days[late]) * 365)
	ofTime.plot(days, 1e3 * settled, color=colour, label=f"{1e-3 * load:.0f} kPa")
	ofTime.plot(days, 1e3 * hand * days / 365, "--", color=colour, linewidth=0.8)
	print(
		f"{1e-3 * load:.0f} kPa: {1e3 * settled[-1]:.1f} mm in {days[-1]:.0f} days, in the end {1e3 * rates[-1]:.2f} mm a year, by hand {1e3 * hand:.2f}; "
		f"the ground carries {carried[-10:].mean() / (load * footingWidth):.3f} of the load"
	)
rates = np.array(rates)
slope = float(np.polyfit(np.log(loads), np.log(rates), 1)[0])
print(f"{mpm.pointCount} points, {O.iter} steps for each load; the rate goes with the load to the power of {slope:.3f}, that of the ice is {law.exponent:g}")
inLoad = (rates / expected) ** (-1 / law.exponent)
print(f"rate over that by hand {', '.join(f'{ratio:.2f}' for ratio in rates / expected)}; load over that which by hand has the same rate {inLoad.mean():.2f}")

ofTime.plot([], [], "--", color="0.4", linewidth=0.8, label="by hand")
ofTime.set(xlabel="time [days]", ylabel="settlement [mm]", ylim=(0, None))
ofTime.legend(frameon=False)
ofLoad.loglog(1e-3 * np.array(loads), 1e3 * rates, "o", color="black", label=f"footing, power {slope:.2f}")
ofLoad.loglog(1e-3 * np.array(loads), 1e3 * expected, "--", color="crimson", label=f"by hand, power {law.exponent:g}")
ofLoad.set_xticks(1e-3 * np.array(loads), [f"{1e-3 * load:.0f}" for load in loads])
shown = [rate for rate in (1, 2, 5, 10, 20, 50) if rates[0] * 500 < rate < expected[-1] * 2000]
ofLoad.set_yticks(shown, [str(rate) for rate in shown])
ofLoad.minorticks_off()
ofLoad.set(xlabel="load [kPa]", ylabel="rate in the second half [mm/year]")
ofLoad.legend(frameon=False)
creep = plots.bandsOf("√(½ e:e) [%]", 100 * mpm.field("skeleton0.creepStrain"), colourMap="magma_r", limits=(0, None))
plots.ground(section, output.allFields(mpm), 100 * mpm.field("skeleton0.creepStrain"), creep, bar=False)
section.fill(*bodies.outline(box).T, facecolor="0.7", edgecolor="black")
section.set(xlabel="x [m]", ylabel="y [m]", xlim=(0, width), ylim=(0, depth + 1))
section.set_title(f"creep strain after a year under {1e-3 * loads[-1]:.0f} kPa", fontsize=10)
plots.colourBar(section, creep)
plots.save(figure, folder / "creeping_footing.png", dpi=100)
output.writeSummary(
	folder / "summary.json",
	**{
		"preset": options.preset,
		"loads [Pa]": list(loads),
		"rates [m/year]": rates.tolist(),
		"by hand [m/year]": expected.tolist(),
		"load over that by hand [-]": float(inLoad.mean()),
		"exponent [-]": slope,
		"exponent of the ice [-]": law.exponent,
	},
)
if abs(slope / law.exponent - 1) > 0.05 or not 0.5 < inLoad.mean() < 2:
	output.unexpected("exponent more than 5 % off that of the ice, or load more than twice off that by hand for the same rate")
print(f"picture and summary are in {folder}")
