# SPDX-License-Identifier: GPL-2.0-or-later
"""One loading path of a sample in its two forms, packed and as a scene under stock YADE's engines, under the same servo of stresses.

Grains amplify a difference in the last place to whole contacts within some thousand steps, in stock YADE as in any other code. What can
be compared then are curves, and the scatter of stock YADE against itself is the yardstick: twins of one sample in which a grain lies
elsewhere by 1e-12 of its coordinates."""

import dataclasses
import itertools

import numpy as np
from yade import Matrix3, O, wrapper

import talik
from talik import packing

chunk = 20  # DEM steps between two corrections of the strain rates


def twins(sample, number):
	"""The sample itself and others that differ from it in the last places, packed."""
	made = [sample.copy()]
	for k in range(1, number):
		with talik.inspect(sample.open()):
			grain = O.bodies[0].state
			grain.pos = (grain.pos[0] * (1 + 1e-12 * k), grain.pos[1], grain.pos[2])
			made.append(wrapper.RveSample.fromScene(O._sceneObj))
	return made


class Packed:
	"""The packed form."""

	def __init__(self, sample):
		self.sample = sample.copy()
		self.dt = self.sample.dt

	def advance(self, velGrad, steps):
		"""Stress (xx, yy, xy) [Pa] after so many DEM steps."""
		self.sample.advance(velGrad, steps)
		return np.array(self.sample.stress)

	def area(self):
		"""Of the cell, relative to the prepared one [-]."""
		return np.linalg.det(np.array(self.sample.trsf))

	def bonds(self):
		"""Number of bonds intact."""
		return self.sample.statistics()["bondsIntact"]


class Stock:
	"""The same sample as a scene that stock YADE's engines run, with the law of the ice bond where it carries ice."""

	def __init__(self, sample):
		self.scene = sample.open()
		self.dt = sample.dt

	def advance(self, velGrad, steps):
		with talik.inspect(self.scene):
			O.cell.velGrad = velGrad
			packing.advance(steps)
			return packing.stress()

	def area(self):
		with talik.inspect(self.scene):
			return np.linalg.det(np.array(O.cell.trsf))

	def bonds(self):
		with talik.inspect(self.scene):
			return sum(1 for i in O.interactions if i.isReal and getattr(i.phys, "bondState", 0) == 1)


@dataclasses.dataclass
class Curve:
	"""Stress (n, 3) [Pa]: xx, yy, xy, mean over each interval of strain; area of the cell relative to the first [-] and bonds intact at
	the end of each."""

	stress: np.ndarray
	area: np.ndarray
	bonds: np.ndarray


@dataclasses.dataclass
class Path:
	"""kind: "biaxial", compression along y with the stress along x held, or "simple shear", along x with the stress along y held.
	held [Pa]; strain of the whole path, of one DEM step, of the interval over which stresses are averaged; stiffness of the sample [Pa]."""

	kind: str
	strain: float
	stiffness: float
	held: float = -100e3
	perStep: float = 1e-5
	interval: float = 2e-3

	def velGrad(self, form, stress):
		e = self.perStep / form.dt
		excess = stress[0 if self.kind == "biaxial" else 1] - self.held
		rate = max(-2 * e, min(2 * e, -excess / (10 * self.stiffness * chunk * form.dt)))
		return Matrix3(rate, 0, 0, 0, -e, 0, 0, 0, 0) if self.kind == "biaxial" else Matrix3(0, e, 0, 0, rate, 0, 0, 0, 0)

	def walk(self, form):
		stress = form.advance(Matrix3.Zero, 2)
		before = form.area()
		rows = []
		for _ in range(round(self.strain / self.interval)):
			stresses = []
			for _ in range(round(self.interval / (self.perStep * chunk))):
				stress = form.advance(self.velGrad(form, stress), chunk)
				stresses.append(stress)
			rows.append((np.mean(stresses, axis=0), form.area() / before, form.bonds()))
		return Curve(*(np.array(column) for column in zip(*rows)))


def difference(a, b):
	"""Of two curves of stress: the largest difference of a component, mean over the path, over the largest component, mean over the path."""
	return np.abs(a.stress - b.stress).max(axis=1).mean() / np.abs(b.stress).max(axis=1).mean()


def mean(curves):
	return Curve(*(np.mean([getattr(curve, name) for curve in curves], axis=0) for name in ("stress", "area", "bonds")))


def across(first, second):
	"""Mean difference of a curve of one set to one of the other, pairs of the same start left out."""
	return np.mean([difference(a, b) for (i, a), (j, b) in itertools.product(enumerate(first), enumerate(second)) if i != j])
