# SPDX-License-Identifier: GPL-2.0-or-later
"""A dry granular mass runs down a chute and is stopped by a rigid barrier, whose force is read with O.forces.f(id).

	scripts/run barrier [--preset test|draft|standard]

Floor (a Wall with friction) and barrier (a fixed Box) are ordinary bodies of YADE; the mass is material points with a Mohr-Coulomb
skeleton. Coordinates run along the chute, gravity is inclined. What can be checked: the momentum of the mass changes by
gravity's impulse less what the two bodies took, to round-off; and when all is at rest, they carry its weight. Change the angle of
the chute, the friction of the floor or the height of the barrier first.
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
	endTime: float  # [s]


presets = {"test": Preset(0.2, 2.0), "draft": Preset(0.1, 3.0), "standard": Preset(0.05, 3.0)}

angle = math.radians(32)  # of the chute
floorFriction = math.radians(18)
mass = [(0.4, 0), (2.4, 0), (2.4, 0.6), (0.4, 0.6)]  # outline at the start [m]
barrierAt, barrierHeight = 4.0, 1.6  # face and height [m]
restDamping, restTime = 0.3, 0.6  # local damping at the end, to come to rest; its duration [s]


def build(preset):
	material = O.materials.append(wrapper.FrictMat(frictionAngle=floorFriction))
	floor = O.bodies.append(utils.wall(0, axis=1, sense=1, material=material))
	barrier = O.bodies.append(utils.box((barrierAt + 0.2, barrierHeight / 2, 0), (0.2, barrierHeight / 2, 0.5), fixed=True, material=material))
	mpm = wrapper.MpmEngine(
		gridSpacing=preset.gridSpacing,
		lower=(0, -2 * preset.gridSpacing),
		upper=(4.8, 2.4),
		gravity=(9.81 * math.sin(angle), -9.81 * math.cos(angle)),
		skeleton=wrapper.MohrCoulombSkeleton(young=2e6, youngFrozen=2e6, poisson=0.25, cohesion=50, frictionAngle=34),
		bodies=wrapper.BodyContact(),
	)
	talik.geometry.fill(mpm, mass)
	O.engines = [wrapper.ForceResetter(), mpm, wrapper.NewtonIntegrator(damping=0)]
	return mpm, floor, barrier


class Record:
	"""Forces of every step, states at a few instants."""

	def __init__(self, mpm, floor, barrier, instants):
		self.mpm, self.ids, self.instants = mpm, (floor, barrier), list(instants)
		self.times, self.forces, self.states = [], [], []
		self.impulse = np.zeros(2)  # that the bodies took from the mass [N s]

	def run(self, endTime):
		while O.time < endTime:
			talik.runSerially(1)
			forces = np.array([O.forces.f(body) for body in self.ids])[:, :2]
			self.impulse += forces.sum(axis=0) * O.dt
			self.times.append(O.time)
			self.forces.append(forces)
			if self.instants and O.time >= self.instants[0]:
				self.instants.pop(0)
				self.states.append({"time": O.time, **output.allFields(self.mpm)})


def draw(record, path):
	fig = plots.figure(7.5, 2.5 * len(record.states) + 2.6)
	panels = fig.subplots(len(record.states) + 1, 1)
	speed = plots.bandsOf("velocity", [state["velocity"] for state in record.states])
	for axes, state in zip(panels, record.states):
		plots.ground(axes, state, "velocity", speed, bar=False, arrows="velocity")
		bodies.draw(axes, O.bodies)
		axes.set(xlim=(0, 4.6), ylim=(-0.12, 1.75), xlabel="", ylabel="across [m]")
		fastest = np.linalg.norm(state["velocity"], axis=1).max()
		axes.set_title(f"{plots.timeLabel(state['time'])}: up to {fastest:.2g} m/s; dashed: the mass at the start", loc="left", fontsize=10)
	panels[-2].set_xlabel("along the chute [m]")
	plots.colourBar(panels[:-1], speed, shrink=0.7)
	times, forces = np.array(record.times), np.array(record.forces)
	panels[-1].plot(times, forces[:, 1, 0] / 1e3, color="black", label="barrier, along")
	panels[-1].plot(times, -forces[:, 0, 1] / 1e3, color="steelblue", label="floor, down")
	panels[-1].set_xlabel("time [s]")
	panels[-1].set_ylabel("force [kN/m]")
	panels[-1].legend(frameon=False)
	plots.save(fig, path, dpi=100)


parser = argparse.ArgumentParser(description=__doc__.splitlines()[0])
parser.add_argument("--preset", default="draft", choices=sorted(presets), help="size of the job")
parser.add_argument("--output", default="output/barrier", help="folder for the results")
options = parser.parse_args()
folder, preset = writableFolder(Path(options.output)), presets[options.preset]

mpm, floor, barrier = build(preset)
mpm.initialise()
total = mpm.field("mass").sum()
weight = total * 9.81 * np.array([math.sin(angle), -math.cos(angle)])
record = Record(mpm, floor, barrier, (0.45, 0.9, preset.endTime))
record.run(preset.endTime)
momentum = np.array(mpm.balance()["momentum"])
closure = np.linalg.norm(momentum - weight * O.time + record.impulse) / np.linalg.norm(weight * O.time)
peak = max(forces[1][0] for forces in record.forces)

mpm.damping = restDamping
record.run(preset.endTime + restTime)
carried = record.forces[-1].sum(axis=0)
offWeight = np.linalg.norm(carried - weight) / np.linalg.norm(weight)
print(f"{mpm.pointCount} points, {O.iter} steps; peak force on the barrier {peak / 1e3:.2f} kN/m, at rest {record.forces[-1][1][0] / 1e3:.2f} kN/m")
print(f"momentum of the mass less gravity's and the bodies' impulses, over gravity's: {closure:.1e}")
print(f"force on both bodies at rest over the weight, less one: {offWeight:.1e}")
draw(record, folder / "barrier.png")
output.writeSummary(
	folder / "summary.json",
	**{
		"preset": options.preset,
		"points": mpm.pointCount,
		"peak force [N/m]": peak,
		"force at rest [N/m]": record.forces[-1][1][0],
		"momentum closure [-]": closure,
		"weight error at rest [-]": offWeight,
	},
)
if closure > 1e-11 or offWeight > 0.01:
	output.unexpected("the balance of momentum or of weight is worse than it should be")
print(f"picture and summary are in {folder}")
