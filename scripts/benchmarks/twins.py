# SPDX-License-Identifier: GPL-2.0-or-later
"""The same sample twice, in the same state and on the same path: as a scene that stock YADE's engines run, and packed."""

import math
import statistics
import time

from yade import FrictMat, Matrix3, O, Vector3, utils, wrapper

from yade import log as yadeLog

import talik
from talik import rve

yadeLog.setLevel("NewtonIntegrator", 1)  # it warns, whenever it is saved, that densityScaling is not in use

pressure = 100e3  # [Pa]


def seconds(call):
	"""CPU time of this thread [s]: what other programs do on the machine does not enter it."""
	start = time.thread_time()
	call()
	return time.thread_time() - start


def pureShear(rate):
	"""Velocity gradient [1/s], or displacement gradient [-], of pure shear."""
	return Matrix3(rate, 0, 0, 0, -rate, 0, 0, 0, 0)


class Twin:
	"""A sample opened as a scene of stock YADE and the same sample packed, under one velocity gradient.

	window   DEM steps of one timing
	repeats  of the packed window, from the same state: it is short"""

	def __init__(self, packed, rate, window, repeats=5):
		self.packed, self.velGrad, self.window, self.repeats = packed.copy(), pureShear(rate), window, repeats
		self.grains = len(packed.arrays()["radius"])
		self.scene = packed.open()
		self.pressures = [], []
		talik._talik.exchangeScene(self.scene)
		O.cell.velGrad = self.velGrad
		self.runStock()
		self.packed.advance(self.velGrad, window)

	def runStock(self):
		talik._talik.exchangeScene(self.scene)
		talik.runSerially(self.window)

	def stock(self):
		"""Next window of stock YADE: time per grain and step [ns]."""
		duration = seconds(self.runStock)
		stress = utils.getStress()
		self.pressures[0].append(-sum(stress[d, d] for d in range(self.packed.dimension)) / self.packed.dimension)
		return self._perGrainStep(duration)

	def fused(self):
		"""The same window of the packed sample: time per grain and step [ns]."""
		duration = self._time(keep=True)
		self.pressures[1].append(-sum(self.packed.stress[: self.packed.dimension]) / self.packed.dimension)
		return self._perGrainStep(duration)

	def fusedPortable(self):
		"""As fused, on the path without vectors, without going on."""
		wrapper.RveSample.usePortablePath(True)
		try:
			return self._perGrainStep(self._time(keep=False))
		finally:
			wrapper.RveSample.usePortablePath(False)

	def _time(self, keep):
		times = []
		for _ in range(self.repeats):
			sample = self.packed.copy()
			times.append(seconds(lambda: sample.advance(self.velGrad, self.window)))
		if keep:
			self.packed = sample
		return statistics.median(times)

	def _perGrainStep(self, duration):
		return duration / (self.grains * self.window) * 1e9

	def meanPressures(self):
		"""Mean pressure [kPa] of both over the windows: they walk the same path."""
		return tuple(1e-3 * statistics.mean(p) for p in self.pressures)


def frictional(grains, dimension=2):
	"""A dense sample of FrictMat discs or spheres at 100 kPa, prepared by stock YADE, packed."""
	return rve.pack(rve.prepare(grains=grains, pressure=pressure, ice=False, dimension=dimension))


def bonded(grains, iceSaturation=1.0, dimension=2):
	"""The same of IceBondMat grains, frozen: every contact carries a bond."""
	sample = rve.pack(rve.prepare(grains=grains, pressure=pressure, ice=True, dimension=dimension))
	sample.freeze(iceSaturation)
	return sample


def strainedUntilBonds(sample, brokenPart, rate):
	"""The sample strained until this part of its bonds has broken."""
	sample = sample.copy()
	bonds = sample.statistics()["bondsIntact"]
	while sample.statistics()["bondsIntact"] > (1 - brokenPart) * bonds:
		sample.advance(pureShear(rate), 200)
	return sample


def tiled(grains, times):
	"""A dense frictional sample of times x times copies of a prepared one, brought to 100 kPa again: large samples without an hour of compaction."""
	part = rve.prepare(grains=grains, pressure=pressure, ice=False)
	with talik.scratchScene():
		rve.openFile(part.path)
		discs = [(b.state.pos, b.shape.radius, b.state.mass, b.state.inertia) for b in O.bodies]
		h, step, engines = O.cell.hSize, O.dt, O.engines
		O.resetThisScene()
		O.periodic = True
		O.cell.hSize = Matrix3(times * h[0, 0], times * h[0, 1], 0, times * h[1, 0], times * h[1, 1], 0, 0, 0, h[2, 2])
		p = part.parameters
		O.materials.append(FrictMat(young=p["young"], poisson=p["stiffnessRatio"], frictionAngle=math.atan(p["friction"]), density=p["density"]))
		for i in range(times):
			for j in range(times):
				for position, radius, mass, inertia in discs:
					body = utils.sphere(position + h * Vector3(i, j, 0), radius)
					body.state.mass, body.state.inertia, body.state.blockedDOFs = mass, inertia, "zXY"
					O.bodies.append(body)
		O.engines, O.dt = engines, step
		talik.runSerially(1)
		sample = wrapper.RveSample.fromScene(O._sceneObj)
	if not sample.servo(-pressure, -pressure):
		raise RuntimeError(f"tiled: {times} x {times} x {grains} grains do not come to rest at {pressure:g} Pa")
	return sample
