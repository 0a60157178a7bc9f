# SPDX-License-Identifier: GPL-2.0-or-later
"""A footing stands on frozen ground that thaws from its surface, and settles.

	scripts/run footing_on_thawing_ground [--preset test|draft|standard] [--cohesion 1500] [--friction 20] [--young 8e6] [--start -2] [--surface 10]

The footing is an ordinary Box of YADE that falls under its own weight; the ground is material points whose cohesion and
stiffness follow the ice (MohrCoulombSkeleton). What can be checked: before the thaw and after it the footing is at rest and the
force that the ground gives it, O.forces.f(id), is its weight within 1 %. Ground and boundaries are ours. Give your soil;
change the footing's size or density first.
"""

import argparse
from dataclasses import dataclass
from pathlib import Path

import numpy as np
from yade import O, utils, wrapper

import talik
from talik import bodies, output, plots
from talik.files import writableFolder


@dataclass
class Preset:
	gridSpacing: float  # [m]
	thawTime: float  # of the surface being warm [s], f_T seconds of heat each


presets = {"test": Preset(0.5, 0.6), "draft": Preset(0.25, 3.0), "standard": Preset(0.125, 3.0)}

width, depth = 8.0, 3.0  # of the ground [m]
footing = (1.6, 1.2)  # width, height [m]
density = 2500.0  # of the footing [kg/m3]
thermalTimeScale = 4e6  # one second is 46 days of heat
restTime, warmingTime = 0.8, 0.2  # [s]


def build(preset):
	material = O.materials.append(wrapper.FrictMat(frictionAngle=0.5, density=density))
	block = utils.box((width / 2, depth + footing[1] / 2, 0), (footing[0] / 2, footing[1] / 2, 0.5), material=material)
	block.state.blockedDOFs = "zXY"
	O.bodies.append(block)
	mpm = wrapper.MpmEngine(
		gridSpacing=preset.gridSpacing,
		lower=(0, 0),
		upper=(width, depth + 1),
		gravity=(0, -9.81),
		damping=0.5,
		skeleton=wrapper.MohrCoulombSkeleton(
			young=options.young, youngFrozen=60e6, cohesion=options.cohesion, cohesionFrozen=300e3, frictionAngle=options.friction
		),
		heat=wrapper.HeatTransfer(thermalTimeScale=thermalTimeScale),
		freezing=wrapper.FreezingCurve(curve="gauss", width=0.5),
		bodies=wrapper.BodyContact(),
	)
	talik.geometry.fill(mpm, talik.geometry.rectangle(0, 0, width, depth), temperature=options.start)
	mpm.boundaries = [
		wrapper.RollerBoundary(region="left"),
		wrapper.RollerBoundary(region="right"),
		wrapper.FixedBoundary(region="bottom"),
		wrapper.SurfaceTemperature(
			region="surface",
			times=[restTime * thermalTimeScale, (restTime + warmingTime) * thermalTimeScale],
			values=[options.start, options.surface],
		),
	]
	O.engines = [wrapper.ForceResetter(), mpm, wrapper.NewtonIntegrator(gravity=(0, -9.81, 0), damping=0.4)]
	O.step()  # sets O.dt
	return mpm, block


class Record:
	def __init__(self, mpm, block):
		self.mpm, self.block, self.rows, self.states = mpm, block, [], []

	def run(self, endTime, samples=100):
		for instant in np.linspace(O.time, endTime, samples + 1)[1:]:
			while O.time < instant:
				talik.runSerially(1 + int((instant - O.time) / O.dt * 0.9))
			thawed = self.mpm.field("volume")[self.mpm.field("iceSaturation") < 0.5].sum() / width
			self.rows.append((O.time, self.block.state.displ()[1], O.forces.f(self.block.id)[1], thawed))

	def keepState(self):
		self.states.append({"time": O.time, "line": bodies.outline(self.block), **output.allFields(self.mpm)})

	def meanForce(self, last=10):
		return np.mean([row[2] for row in self.rows[-last:]])


def draw(record, weight, path):
	fig = plots.figure(8, 8)
	panels = fig.subplots(3, 1, height_ratios=(1, 1, 0.8))
	ice = plots.bandsOf("iceSaturation", [state["iceSaturation"] for state in record.states])
	for axes, state in zip(panels, record.states):
		plots.ground(axes, state, "iceSaturation", ice, bar=False)
		axes.fill(*state["line"].T, facecolor="0.7", edgecolor="black", zorder=3)
		axes.set(xlim=(0, width), ylim=(0, depth + 1.5), xlabel="")
		axes.set_title(plots.timeLabel(state["time"], state["time"] * thermalTimeScale / talik.day), loc="left", fontsize=10)
	panels[1].set(xlabel="x [m]")
	fig.suptitle("A footing on ground that thaws; crimson: thaw front", fontsize=10)
	plots.colourBar(panels[:2], ice, shrink=0.7)
	time, settled, force, thawed = np.array(record.rows).T
	days = time * thermalTimeScale / talik.day
	panels[2].plot(days, -1e3 * settled, color="black", label="settlement of the footing (left)")
	panels[2].set(xlabel="day", ylabel="settlement [mm]", xlim=(0, days[-1]))
	other = panels[2].twinx()
	other.plot(days, thawed, color="crimson", linestyle="--", label="thawed depth (right)")
	other.set_ylabel("thawed depth [m]")
	panels[2].legend(handles=[*panels[2].lines, *other.lines], frameon=False)
	plots.save(fig, path, dpi=100)


parser = argparse.ArgumentParser(description=__doc__.splitlines()[0])
parser.add_argument("--preset", default="draft", choices=sorted(presets), help="size of the job")
parser.add_argument("--output", default="output/footing_on_thawing_ground", help="folder for the results")
parser.add_argument("--cohesion", type=float, default=1.5e3, help="of thawed ground [Pa], 0 to 3e5")
parser.add_argument("--friction", type=float, default=20.0, help="friction angle [degrees], 10 to 45")
parser.add_argument("--young", type=float, default=8e6, help="Young's modulus of thawed ground [Pa], 1e5 to 6e7")
parser.add_argument("--start", type=float, default=-2.0, help="temperature of the frozen ground [degC], -20 to 0")
parser.add_argument("--surface", type=float, default=10.0, help="temperature of the warm surface [degC], 0 to 40")
options = parser.parse_args()
for name, lowest, highest in (("cohesion", 0, 3e5), ("friction", 10, 45), ("young", 1e5, 6e7), ("start", -20, 0), ("surface", 0, 40)):
	if not lowest < getattr(options, name) < highest:
		raise SystemExit(f"--{name.replace('_', '-')} {getattr(options, name):g}: give a number between {lowest:g} and {highest:g}")
folder, preset = writableFolder(Path(options.output)), presets[options.preset]

mpm, block = build(preset)
weight = block.state.mass * 9.81
record = Record(mpm, block)
record.run(restTime)
record.keepState()
frozen, frozenSettlement = record.meanForce() / weight, record.rows[-1][1]
record.run(restTime + preset.thawTime)
record.keepState()
thawed, settlement = record.meanForce() / weight, record.rows[-1][1]
print(f"{mpm.pointCount} points, {O.iter} steps; weight of the footing {weight / 1e3:.2f} kN/m")
print(f"force of the ground over the weight: {frozen:.4f} frozen, {thawed:.4f} thawed to {record.rows[-1][3]:.2f} m")
print(f"settlement {-1e3 * frozenSettlement:.1f} mm frozen, {-1e3 * settlement:.1f} mm thawed")
draw(record, weight, folder / "footing_on_thawing_ground.png")
output.writeSummary(
	folder / "summary.json",
	**{
		"preset": options.preset,
		"weight [N/m]": weight,
		"carried, frozen [-]": frozen,
		"carried, thawed [-]": thawed,
		"settlement [m]": -settlement,
		"thawed depth [m]": record.rows[-1][3],
	},
)
if abs(frozen - 1) > 0.01 or abs(thawed - 1) > 0.01:
	output.unexpected("the ground does not carry the weight of the footing within 1 %")
print(f"picture and summary are in {folder}")
