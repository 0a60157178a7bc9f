#!/usr/bin/python3
# SPDX-License-Identifier: GPL-2.0-or-later
"""Reference of LayerOverFoot: how fast a rigid-plastic layer on a frozen face begins to move over its foot [m/s^2].

	tests/validation/rigid_plastic_layer.py 2 4 8 16    # cells over the thickness of the layer

Of all fields of acceleration a that quadratic B-splines on a grid can have, the one with the least  1/2 a M a - F a + D(a), where D is the power of
plastic strain and of slip at the front: Mohr-Coulomb with normality and the strength of Davis (1968). Cones of strain and of slip are met by
over-relaxed steps of alternating directions; what is printed last tells how far those of strain are from being met.
"""

import sys

import numpy as np
import scipy.sparse as sparse
from scipy.sparse.linalg import splu

thickness, height, bench, friction, cohesion, density, gravity = 0.5, 3.0, 4.0, np.radians(26), 1e3, 1990.0, 9.81
ratio, shearCohesion, length = np.sin(friction), cohesion * np.cos(friction), height * np.sqrt(2)
angle = np.arctan(ratio)
steps, overRelaxation, penalty = 3000, 1.7, 0.5 * density * thickness**2


def along(x, y):
	return length + (x - y) / np.sqrt(2)


def depth(x, y):
	face, onBench = (np.clip(along(x, y), 0, length) - length) / np.sqrt(2), np.maximum(0, x)
	return np.minimum(np.hypot(x - face, y + face), np.hypot(x - onBench, y))


def spline(u):
	"""Quadratic B-spline and its derivative."""
	far = np.clip(1.5 - abs(u), 0, None)
	return np.where(abs(u) < 0.5, 0.75 - u * u, 0.5 * far**2), np.where(abs(u) < 0.5, -2 * u, -far * np.sign(u))


class Weights:
	"""Shape functions of the nodes and their gradients at points [sparse, points x nodes]; the toe is a node."""

	row = 1 << 20  # numbers of nodes along x are apart by this

	def __init__(self, x, y, h):
		count = len(x)
		i, j = np.floor(x / h).astype(int), np.floor(y / h).astype(int)
		parts = []
		for a in range(-1, 3):
			for b in range(-1, 3):
				(sx, dx), (sy, dy) = spline(x / h - i - a), spline(y / h - j - b)
				parts.append(((i + a) * self.row + j + b, sx * sy, dx * sy / h, sx * dy / h))
		self.nodes, *values = (np.concatenate(part) for part in zip(*parts))
		self.points, self.values = np.tile(np.arange(count), 16), values

	def on(self, nodes):
		place = np.clip(np.searchsorted(nodes, self.nodes), 0, len(nodes) - 1)
		known = nodes[place] == self.nodes
		shape = (self.points.max() + 1, len(nodes))
		return [sparse.csr_matrix((v[known], (self.points[known], place[known])), shape=shape) for v in self.values]


def layerPoints(h):
	x, y = np.meshgrid(np.arange(-height - 3 + h / 4, bench, h / 2), np.arange(-1 + h / 4, height + 1, h / 2))
	x, y = x.ravel(), y.ravel()
	inside = (np.clip(-x, 0, height) >= y) & (depth(x, y) < thickness) & (along(x, y) >= 0.5 * thickness) & (x >= -height)
	return x[inside], y[inside]


def front(h):
	"""Points of the front, its normals and lengths: under the face, round the toe and under the bench."""
	s, b = np.arange(0.5 * thickness + h / 8, length, h / 4), np.arange(h / 8, bench, h / 4)
	arcs = max(2, round(thickness * np.pi / h))
	turn = np.pi / 4 + (np.arange(arcs) + 0.5) / arcs * np.pi / 4
	face = (s - length) / np.sqrt(2)
	x = np.concatenate([face - thickness / np.sqrt(2), -thickness * np.cos(turn), b])
	y = np.concatenate([-face - thickness / np.sqrt(2), -thickness * np.sin(turn), np.full(len(b), -thickness)])
	normal = np.concatenate([np.full(len(s), np.pi / 4), turn, np.full(len(b), np.pi / 2)])
	size = np.concatenate([np.full(len(s), h / 4), np.full(arcs, thickness * np.pi / 4 / arcs), np.full(len(b), h / 4)])
	return x, y, np.cos(normal), np.sin(normal), size


def ontoCone(opening, shear, slope):
	"""Nearest values with opening >= slope shear >= 0."""
	nearest = np.clip((shear + slope * opening) / (1 + slope**2), 0, None)
	met = opening >= slope * shear
	return np.where(met, opening, slope * nearest), np.where(met, shear, nearest)


def acceleration(cells):
	h = thickness / cells
	x, y = layerPoints(h)
	fx, fy, nx, ny, size = front(h)
	weights, count, slips, volume = Weights(x, y, h), len(x), len(fx), 0.25 * h * h
	nodes = np.unique(weights.nodes[weights.values[0] > 0])
	shape, dx, dy = weights.on(nodes)
	atFront = Weights(fx, fy, h).on(nodes)[0]
	across = [sparse.diags(n) @ atFront for n in (nx, ny)]
	# volumetric strain, both shears, opening and slip: the latter over h
	rows = [[dx, dy], [dx, -dy], [dy, dx], [across[0] / h, across[1] / h], [-across[1] / h, across[0] / h]]
	strains = sparse.vstack([sparse.hstack(row) for row in rows]).tocsr()
	size = size * h
	measure = np.concatenate([np.full(3 * count, volume), size, size])
	power = np.concatenate([np.full(count, volume), np.zeros(2 * count), size, 0 * size]) * shearCohesion / np.tan(angle)
	mass = density * volume * np.asarray(shape.sum(0)).ravel()
	force = np.concatenate([0 * mass, -gravity * mass])
	solve = splu((sparse.diags(np.tile(mass, 2) + 1e-9 * mass.mean()) + penalty * strains.T @ sparse.diags(measure) @ strains).tocsc()).solve
	parts = np.cumsum([count, count, count, slips])
	met = dual = np.zeros(strains.shape[0])
	for _ in range(steps):
		a = solve(force + penalty * strains.T @ (measure * (met - dual)))
		strain = strains @ a
		relaxed = overRelaxation * strain + (1 - overRelaxation) * met
		volumetric, one, two, opening, slip = np.split(relaxed + dual - power / (penalty * measure), parts)
		shear = np.hypot(one, two)
		volumetric, kept = ontoCone(volumetric, shear, np.sin(angle))
		opening, slipped = ontoCone(opening, abs(slip), np.tan(angle))
		kept = kept / np.where(shear > 0, shear, 1)
		met = np.concatenate([volumetric, one * kept, two * kept, opening, np.sign(slip) * slipped])
		dual = dual + relaxed - met
	middle = abs(along(x, y) / length - 0.5) < 0.2
	ax, ay = shape @ a[: len(nodes)], shape @ a[len(nodes) :]
	return np.mean((ax - ay)[middle]) / np.sqrt(2), np.linalg.norm(strain - met) / np.linalg.norm(met)


if __name__ == "__main__":
	for cells in map(int, sys.argv[1:] or ["4"]):
		print("%d cells over the thickness: %.3f m/s^2 (cones met within %.1e)" % (cells, *acceleration(cells)), flush=True)
