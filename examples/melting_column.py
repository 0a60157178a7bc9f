# SPDX-License-Identifier: GPL-2.0-or-later
"""A column of grains bonded by ice hangs from a ceiling that warms: it melts from the top until it tears off.

	scripts/run melting_column [--preset draft|standard|paper]

An ordinary YADE scene, without any ground around it: spheres on a cubic lattice, InteractionLoop with the ice-bond law, a load
pulling at the lowest layer. Every layer has a material of its own, whose iceSaturation follows the temperature of a half-space
whose surface warms steadily, and a gauss freezing curve. Bonds weaken, the warmest layer fails first, and the rest falls.

Grains and bonds are those of Yu & Zhao, section 3.1 (E_c 0.6 to 3.6 GPa, strength 1 to 51 MPa, k_s/k_n 0.8, friction 0.5); column,
load and heating are ours. Heat is accelerated until it keeps pace with the short time of a DEM run. With the load P on each vertical
chain of grains the column must tear where C(S_i) R^2 = P: the closed form that the run is compared with.
"""

import argparse
import math
from dataclasses import dataclass
from pathlib import Path

import numpy as np
from yade import O, Vector3, utils, wrapper

import talik
from talik import output, plots
from talik.files import writableFolder


@dataclass
class Column:
	"""Size of the job; lengths in grains."""

	layers: int
	width: int
	meltSteps: int  # DEM steps until the ceiling has lost its ice
	fallSteps: int = 600  # steps to watch after the column has torn


presets = {
	"test": Column(layers=6, width=2, meltSteps=4000, fallSteps=200),
	"draft": Column(layers=20, width=4, meltSteps=20000),
	"standard": Column(layers=30, width=6, meltSteps=30000),
	"paper": Column(layers=40, width=8, meltSteps=40000),
}

radius = 5e-3  # [m]
load = 500.0  # P, pull at each chain of grains [N]
cold, warm = -1.2, 0.2  # initial temperature and that of the ceiling in the end [degC]
freezingWidth = 0.5  # W of the gauss freezing curve [K]
penetration = 10.0  # depth that the heat reaches during the melt, sqrt(4 alpha t) [grain diameters]
loadSteps = 2000  # over which the load comes on
recordSteps = 50


def iceSaturation(temperature):
	"""Gauss freezing curve without residual water."""
	return np.where(temperature < 0, 1 - np.exp(-((temperature / freezingWidth) ** 2)), 0.0)


def temperatureOfLayers(progress, layers):
	"""Half-space at `cold` whose surface warms steadily to `warm`, 4 i2erfc(z/sqrt(4 alpha t)); progress from 0 to 1."""
	spread = [rampResponse(layer / (penetration * math.sqrt(max(progress, 1e-12)))) for layer in range(layers)]
	return cold + (warm - cold) * progress * np.array(spread)


def rampResponse(x):
	return (1 + 2 * x * x) * math.erfc(x) - 2 / math.sqrt(math.pi) * x * math.exp(-x * x)


def build(column):
	"""Layer 0 is held by the ceiling; z points down from it as the layers are counted."""
	layers = []
	for layer in range(column.layers):
		material = wrapper.IceBondMat(young=0.6e9, poisson=0.8, frictionAngle=math.atan(0.5), density=2650, label=f"layer{layer}")
		O.materials.append(material)
		layers.append(material)
		for i in range(column.width):
			for j in range(column.width):
				centre = (2 * radius * i, 2 * radius * j, -2 * radius * (1 - 1e-6) * layer)
				O.bodies.append(utils.sphere(centre, radius, fixed=layer == 0, material=f"layer{layer}"))
	lowest = [body.id for body in O.bodies if body.material.label == f"layer{column.layers - 1}"]
	pull = wrapper.ForceEngine(ids=lowest)
	law = wrapper.Law2_ScGeom_IceBondPhys_IceBond()
	# ice bonds neighbours across a small gap, too: contacts are looked for a little further than grains touch, once
	O.engines = [
		wrapper.ForceResetter(),
		wrapper.InsertionSortCollider([wrapper.Bo1_Sphere_Aabb(aabbEnlargeFactor=1.02, label="bounds")]),
		wrapper.InteractionLoop(
			[wrapper.Ig2_Sphere_Sphere_ScGeom(interactionDetectionFactor=1.02, label="geometry")],
			[wrapper.Ip2_IceBondMat_IceBondMat_IceBondPhys(bondNewContacts=True, label="contactModel")],
			[law],
		),
		pull,
		wrapper.NewtonIntegrator(gravity=(0, 0, -9.81), damping=0.3),
	]
	O.dt = 0.2 * math.sqrt(O.bodies[0].state.mass / (3.6e9 * radius))
	return layers, lowest, pull, law


def freeze(layers):
	for material in layers:
		material.iceSaturation = 1.0
	O.step()
	for functor, attribute, value in (
		("geometry", "interactionDetectionFactor", 1),
		("bounds", "aabbEnlargeFactor", 1),
		("contactModel", "bondNewContacts", False),
	):
		setattr(_labelled(functor), attribute, value)


def _labelled(label):
	loop, collider = O.engines[2], O.engines[1]
	functors = [*loop.geomDispatcher.functors, *loop.physDispatcher.functors, *collider.boundDispatcher.functors]
	return next(functor for functor in functors if functor.label == label)


class Record:
	"""What is counted while the column melts."""

	names = ("time", "ceilingIce", "intact", "broken", "melted", "length")

	def __init__(self, layers, lowest, law):
		self.layers, self.lowest, self.law = layers, lowest, law
		self.bonds = sum(i.phys.bondState == 1 for i in O.interactions if i.isReal)
		self.rows = []

	def take(self):
		intact = sum(i.phys.bondState == 1 for i in O.interactions if i.isReal)
		broken = self.law.brokenBonds
		length = -np.mean([O.bodies[b].state.pos[2] for b in self.lowest])
		self.rows.append((O.time, self.layers[0].iceSaturation, intact, broken, self.bonds - intact - broken, length))

	def arrays(self):
		return dict(zip(self.names, np.array(self.rows).T))


def run(column):
	"""Returns the record and the ice saturation of the ceiling when the first bond broke (NaN: none did)."""
	layers, lowest, pull, law = build(column)
	freeze(layers)
	record, torn = Record(layers, lowest, law), math.nan
	steps, stop = 0, loadSteps + column.meltSteps
	while steps < stop:
		pull.force = Vector3(0, 0, -load * min(steps / loadSteps, 1))
		ice = iceSaturation(temperatureOfLayers(max(steps - loadSteps, 0) / column.meltSteps, column.layers))
		for material, saturation in zip(layers, ice):
			material.iceSaturation = float(saturation)
		talik.runSerially(5)
		steps += 5
		if math.isnan(torn) and law.brokenBonds > 0:
			torn, stop = layers[0].iceSaturation, min(stop, steps + column.fallSteps)
		if steps % recordSteps == 0:
			record.take()
	return record.arrays(), torn


def draw(record, path):
	fig = plots.figure(7, 7)
	bonds, length = fig.subplots(2, 1, sharex=True)
	time = 1e3 * record["time"]
	for name, colour in (("intact", "red"), ("broken", "black"), ("melted", "steelblue")):
		bonds.plot(time, record[name], color=colour, label=name)
	bonds.set_ylabel("bonds [-]")
	bonds.legend(loc="center left")
	ice = bonds.twinx()
	ice.plot(time, record["ceilingIce"], color="0.6", linestyle="--")
	ice.set_ylabel("ice saturation at the ceiling (dashed) [-]")
	ice.set_ylim(0, 1.05)
	length.plot(time, 1e3 * (record["length"] - record["length"][0]), color="black")
	length.set_xlabel("time [ms]")
	length.set_ylabel("lengthening of the column [mm]")
	plots.save(fig, path)


parser = argparse.ArgumentParser(description=__doc__.splitlines()[0])
parser.add_argument("--preset", default="draft", choices=sorted(presets), help="size of the job")
parser.add_argument("--output", default="output/melting_column", help="folder for the results")
options = parser.parse_args()
folder = writableFolder(Path(options.output))
column = presets[options.preset]

record, torn = run(column)
weight = (column.layers - 1) * O.bodies[0].state.mass * 9.81
strength = (load + weight) / radius**2
expected = math.sqrt(1 - math.sqrt(1 - (strength - 1e6) / 50e6))
print(f"{'time [ms]':>10} {'ceiling S_i':>12} {'intact':>7} {'broken':>7} {'melted':>7} {'length [mm]':>12}")
for k in range(0, len(record["time"]), max(1, len(record["time"]) // 20)):
	print(
		f"{1e3 * record['time'][k]:10.2f} {record['ceilingIce'][k]:12.3f} {record['intact'][k]:7.0f} {record['broken'][k]:7.0f} "
		f"{record['melted'][k]:7.0f} {1e3 * record['length'][k]:12.3f}"
	)
print(f"first bond broke at S_i = {torn:.4f} of the ceiling; closed form C(S_i) R^2 = P: {expected:.4f}")
draw(record, folder / "melting_column.png")
np.savez(folder / "record.npz", **record)
output.writeSummary(
	folder / "summary.json",
	**{"S_i at failure": torn, "S_i closed form": expected, "bonds": int(record["intact"][0]), "bonds intact at the end": int(record["intact"][-1])},
)
print(f"picture, record and summary are in {folder}")
