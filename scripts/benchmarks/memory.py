# SPDX-License-Identifier: GPL-2.0-or-later
"""Resident memory of samples, from the process's own VmRSS: run by scripts/bench samples, each kind in a fresh stock yade.

usage  memory.py frictional|bonded|spheres|bondedSpheres|slope <result.json>"""

import ctypes
import gc
import sys
from pathlib import Path

import numpy as np

from yade import O, wrapper

import figures
import talik
import twins
from figures import Figure
from talik import geometry
from talik_bench import SampleGroup


def resident(entry="VmRSS"):
	"""[bytes]"""
	gc.collect()
	lines = Path("/proc/self/status").read_text().splitlines()
	return 1024 * int(next(line.split()[1] for line in lines if line.startswith(entry + ":")))


def residentAtLeast():
	"""[bytes], after what is free has been given back: samples measured from here on cannot hide in it."""
	gc.collect()
	ctypes.CDLL(None).malloc_trim(0)
	return resident()


def atRest(kind, sample, ceiling, number=1000):
	"""Samples of 400 grains, each with a history of its own, after two updates."""
	motion = twins.pureShear(1e-5)
	few = SampleGroup(sample.stateBytes, 4)
	few.apply(motion, 10)  # buffers of the thread
	before = residentAtLeast()
	group = SampleGroup(sample.stateBytes, number)
	for _ in range(2):
		group.apply(motion, 10)
	each = (resident() - before) / number / 1e3
	contacts = sample.statistics()["contacts"]
	yield Figure(
		f"memory per sample at rest, {kind}",
		each,
		"kB",
		ceiling=ceiling,
		terms={"counted by the pool [kB]": round(group.bytes / number / 1e3, 1), "contacts": contacts},
	)


def slopeOfBondedSamples():
	"""A frozen slope with heat and water; all samples are asked in every step and none is like another."""
	scale = 1.04
	outline = [(scale * x, scale * y) for x, y in ((0, 0), (10, 0), (10, 1), (6, 1), (3, 4), (0, 4))]
	sample = twins.bonded(400)
	before = residentAtLeast()
	skeleton = wrapper.RveSkeleton(samples=[sample], strainTolerance=0)
	mpm = wrapper.MpmEngine(
		gridSpacing=0.1,
		lower=(0, 0),
		upper=(10.4, 4.6),
		gravity=(0, -9.81),
		skeleton=skeleton,
		heat=wrapper.HeatTransfer(),
		freezing=wrapper.FreezingCurve(curve="gauss", width=0.5),
		water=wrapper.PoreWater(),
		boundaries=[wrapper.RollerBoundary(region="left"), wrapper.RollerBoundary(region="right"), wrapper.FixedBoundary(region="bottom")],
	)
	positions, volumes = geometry.fillPolygon(outline, mpm.gridSpacing, 4, (0.0, 0.0))
	shake = np.random.default_rng(1).normal(0, 1e-3, (len(positions), 2))  # [m/s]: no two points move alike
	mpm.addPoints(position=positions, volume=volumes, temperature=-5.0, velocity=shake)
	O.engines = [mpm]
	talik.runSerially(3)
	counters = skeleton.cost()
	size = (resident() - before) / 1e9
	if counters["distinctStates"] < len(positions):
		raise RuntimeError(f"memory.py: {counters['distinctStates']} of {len(positions)} samples have a state of their own; the slope moves too little")
	yield Figure(
		f"resident slope of {len(positions)} bonded samples",
		size,
		"GB",
		ceiling=0.8 * len(positions) / 1e4,
		terms={"of it samples, counted [GB]": round(counters["bytes"] / 1e9, 3), "highest in between [GB]": round((resident("VmHWM") - before) / 1e9, 3)},
	)


kinds = {
	"frictional": lambda: atRest("frictional", twins.frictional(400), 30),
	"bonded": lambda: atRest("bonded", twins.bonded(400), 60),
	"spheres": lambda: atRest("frictional spheres", twins.frictional(400, dimension=3), 60),
	"bondedSpheres": lambda: atRest("bonded spheres", twins.bonded(400, dimension=3), 110),
	"slope": slopeOfBondedSamples,
}
measured = list(kinds[sys.argv[1]]())
for figure in measured:
	print(f"{figure.name}: {figure.value:.4g} {figure.unit}")
figures.write(sys.argv[2], measured)
