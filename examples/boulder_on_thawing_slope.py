# SPDX-License-Identifier: GPL-2.0-or-later
"""A boulder lies on a frozen slope that thaws from its surface; the thawed layer slides, and the boulder rides along.

	scripts/run boulder_on_thawing_slope [--preset test|draft|standard]

The boulder is an ordinary clump of YADE's spheres, the slope is material points whose cohesion and stiffness follow the ice
(MohrCoulombSkeleton). What can be checked: while all is frozen the boulder rests and the force on it is its weight within 1 %; over
the whole run the momentum of ground and boulder changes by gravity and by what the fixed base takes, to round-off. Slope and soil are
ours. Change the boulder, the angle of the slope or the friction of thawed soil first.
"""

import argparse
import math
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
	thawTime: float  # [s], f_T seconds of heat each


presets = {"test": Preset(0.5, 1.6), "draft": Preset(0.25, 3.0), "standard": Preset(0.125, 3.0)}

toe, crest = (9.0, 1.0), (3.0, 3.5)  # ends of the slope's face [m]
outline = [(0, 0), (13, 0), (13, toe[1]), toe, crest, (0, crest[1])]
radius = 0.35  # of the boulder's spheres [m]
thermalTimeScale = 4e6  # one second is 46 days of heat
restTime, warmingTime = 0.8, 0.2  # [s]
gravity = np.array([0, -9.81])


def boulder():
	"""Three spheres on the face, a third of the way down."""
	along = np.array(toe) - crest
	along /= np.linalg.norm(along)
	across = np.array([-along[1], along[0]])
	foot = np.array(crest) + (np.array(toe) - crest) / 3
	material = O.materials.append(wrapper.FrictMat(frictionAngle=math.radians(35), density=2650))
	places = [foot + s * radius * along + e * radius * across for s, e in ((-1, 1), (1, 1), (0, 1 + math.sqrt(3)))]
	clump, members = O.bodies.appendClumped([utils.sphere((*place, 0), radius, material=material) for place in places])
	O.bodies[clump].state.blockedDOFs = "zXY"
	return O.bodies[clump], [O.bodies[member] for member in members]


def build(preset):
	mpm = wrapper.MpmEngine(
		gridSpacing=preset.gridSpacing,
		lower=(0, 0),
		upper=(13, 5),
		gravity=tuple(gravity),
		damping=0.5,
		skeleton=wrapper.MohrCoulombSkeleton(young=8e6, youngFrozen=60e6, cohesion=300, cohesionFrozen=300e3, tensileStrengthFrozen=100e3, frictionAngle=14),
		heat=wrapper.HeatTransfer(thermalTimeScale=thermalTimeScale),
		freezing=wrapper.FreezingCurve(curve="gauss", width=0.5),
		bodies=wrapper.BodyContact(thickness=4 / 3 * radius),
	)
	talik.geometry.fill(mpm, outline, temperature=-2)
	mpm.boundaries = [
		wrapper.RollerBoundary(region="left"),
		wrapper.RollerBoundary(region="right"),
		wrapper.FixedBoundary(region="bottom"),
		wrapper.SurfaceTemperature(region="surface", times=[restTime * thermalTimeScale, (restTime + warmingTime) * thermalTimeScale], values=[-2, 10]),
	]
	newton = wrapper.NewtonIntegrator(gravity=(*gravity, 0), damping=0.4)
	O.engines = [wrapper.ForceResetter(), mpm, newton]
	return mpm, newton


class Record:
	def __init__(self, mpm, stone, members):
		self.mpm, self.stone, self.members = mpm, stone, members
		self.rows, self.states = [], []
		self.force, self.impulse = np.zeros(2), np.zeros(2)

	def run(self, endTime):
		while O.time < endTime:
			talik.runSerially(1)
			self.force = sum((np.array(O.forces.f(member.id))[:2] for member in self.members), np.zeros(2))
			self.impulse += self.force * O.dt
			self.rows.append((O.time, self.stone.state.displ()[0], self.stone.state.displ()[1], *self.force))

	def keepState(self):
		stone = [bodies.outline(member) for member in self.members]
		self.states.append({"time": O.time, "day": O.time * thermalTimeScale / talik.day, "stone": stone, **output.allFields(self.mpm)})

	def momentumGap(self):
		"""Momentum of ground times thickness and boulder, less all that came from outside: what the contact would have made."""
		balance, thickness = self.mpm.balance(), self.mpm.bodies.thickness
		ground = np.subtract(balance["momentum"], balance["impulse"]) * thickness
		state = self.stone.state
		return ground + state.mass * (np.array(state.vel)[:2] - gravity * O.time) - self.impulse


def draw(record, path):
	fig = plots.figure(8, 10.5)
	panels = fig.subplots(4, 1, height_ratios=(1, 1, 1, 0.75))
	first, last = record.states[0], record.states[-1]
	for axes, (state, field) in zip(panels, ((first, "iceSaturation"), (last, "iceSaturation"), (last, "displacement"))):
		plots.ground(axes, state, field, arrows="displacement" if field == "displacement" else None)
		for line in state["stone"]:
			axes.fill(*line.T, facecolor="0.7", edgecolor="black", linewidth=0.8, zorder=3)
		axes.set(xlim=(0, 13), ylim=(0, 4.6), xlabel="")
		axes.set_title(plots.timeLabel(state["time"], state["day"]), loc="left", fontsize=10)
	panels[1].set_title("dashed: ground at the start", loc="right", fontsize=9)
	panels[2].set_xlabel("x [m]")
	rows = np.array(record.rows)
	days = rows[:, 0] * thermalTimeScale / talik.day
	panels[3].plot(days, np.hypot(rows[:, 1] - rows[0, 1], rows[:, 2] - rows[0, 2]), color="black")
	panels[3].set(xlabel="day", ylabel="path of the boulder [m]", xlim=(0, days[-1]), ylim=(0, None))
	plots.save(fig, path, dpi=100)


parser = argparse.ArgumentParser(description=__doc__.splitlines()[0])
parser.add_argument("--preset", default="draft", choices=sorted(presets), help="size of the job")
parser.add_argument("--output", default="output/boulder_on_thawing_slope", help="folder for the results")
options = parser.parse_args()
folder, preset = writableFolder(Path(options.output)), presets[options.preset]

stone, members = boulder()
mpm, newton = build(preset)
record = Record(mpm, stone, members)
record.run(restTime)
record.keepState()
weight = stone.state.mass * 9.81
carried = np.linalg.norm(record.force + stone.state.mass * gravity) / weight
rested = np.array(stone.state.pos)
mpm.resetDisplacement()
mpm.damping, newton.damping = 0.02, 0.0
start, startTime = record.momentumGap(), O.time
record.run(restTime + preset.thawTime)
record.keepState()
scale = (stone.state.mass + mpm.field("mass").sum() * mpm.bodies.thickness) * 9.81 * (O.time - startTime)
closure = np.linalg.norm(record.momentumGap() - start) / scale
path = np.linalg.norm(np.array(stone.state.pos) - rested)  # a clump of YADE has no reference position, and so no displ() from its start
print(f"{mpm.pointCount} points, {O.iter} steps; weight of the boulder {weight / 1e3:.2f} kN")
print(f"force on the boulder at rest less its weight, over its weight: {carried:.1e}")
print(f"path of the boulder {path:.2f} m, largest displacement of the ground {np.linalg.norm(mpm.field('displacement'), axis=1).max():.2f} m")
print(f"momentum of ground and boulder less all that came from outside, over gravity's impulse: {closure:.1e}")
draw(record, folder / "boulder_on_thawing_slope.png")
output.writeSummary(
	folder / "summary.json",
	**{"preset": options.preset, "weight [N]": weight, "weight error at rest [-]": carried, "path [m]": path, "momentum closure [-]": closure},
)
if carried > 0.01 or closure > 1e-11:
	output.unexpected("the balance of momentum or of weight is worse than it should be")
print(f"picture and summary are in {folder}")
