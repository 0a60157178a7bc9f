# SPDX-License-Identifier: GPL-2.0-or-later
"""Bodies of the scene among the material points, for pictures: their outlines in the plane, their triangles in space.

	talik.bodies.draw(axes, O.bodies)
	vertices, triangles = talik.bodies.mesh(O.bodies)
"""

import math

import numpy as np

edgesOfBox = np.array([(-1, -1), (1, -1), (1, 1), (-1, 1), (-1, -1)], dtype=float)
cornersOfBox = np.array([(x, y, z) for x in (-1, 1) for y in (-1, 1) for z in (-1, 1)], dtype=float)
_sides = [(0, 1, 3, 2), (4, 6, 7, 5), (0, 4, 5, 1), (2, 3, 7, 6), (0, 2, 6, 4), (1, 5, 7, 3)]
facesOfBox = np.array([triangle for a, b, c, d in _sides for triangle in ((a, b, c), (a, c, d))])


def outline(body, corners=60):
	"""Polyline (n, 2) [m] in which the body meets the ground; None for a wall, which has no end, and for what has no outline.

	>>> talik.bodies.outline(utils.sphere((0, 1, 0), 0.5)).shape
	(60, 2)"""
	shape, position, rotation = body.shape, np.array(body.state.pos), _rotation(body)
	if hasattr(shape, "radius"):
		angle = np.linspace(0, 2 * math.pi, corners) + math.atan2(rotation[1, 0], rotation[0, 0])
		return position[:2] + shape.radius * np.column_stack([np.cos(angle), np.sin(angle)])
	if hasattr(shape, "extents"):
		local = edgesOfBox * np.array(shape.extents)[:2]
		return position[:2] + local @ rotation[:2, :2].T
	if hasattr(shape, "vertices"):
		return (position + np.array(shape.vertices) @ rotation.T)[[0, 1, 2, 0], :2]
	return None


def mesh(bodies):
	"""Vertices (n, 3) [m] and triangles (m, 3) of the facets and boxes among the bodies.

	>>> vertices, triangles = talik.bodies.mesh([utils.box((0, 0, 0), (1, 1, 1))])
	>>> len(triangles)
	12"""
	vertices, triangles, count = [np.zeros((0, 3))], [np.zeros((0, 3), dtype=int)], 0
	for body in bodies:
		if hasattr(body.shape, "extents"):
			corners, faces = cornersOfBox * np.array(body.shape.extents), facesOfBox
		elif hasattr(body.shape, "vertices"):
			corners, faces = np.array(body.shape.vertices), np.array([(0, 1, 2)])
		else:
			continue
		vertices.append(np.array(body.state.pos) + corners @ _rotation(body).T)
		triangles.append(faces + count)
		count += len(corners)
	return np.vstack(vertices), np.vstack(triangles)


def _rotation(body):
	turned = body.state.ori.toRotationMatrix()
	return np.array([[turned[i, j] for j in range(3)] for i in range(3)])


def draw(axes, bodies, **style):
	"""Outlines of all bodies, with a radius that shows how a sphere has turned; walls as lines across.

	>>> talik.bodies.draw(axes, O.bodies)"""
	style = {"color": "black", "linewidth": 1.0, **style}
	for body in bodies:
		line, position = outline(body), np.array(body.state.pos)[:2]
		if line is not None:
			axes.fill(*line.T, facecolor="0.75", edgecolor="none", zorder=2)
			axes.plot(*line.T, zorder=3, **style)
			if hasattr(body.shape, "radius"):
				axes.plot(*np.array([position, line[0]]).T, zorder=3, **style)
		elif hasattr(body.shape, "axis") and body.shape.axis < 2:
			across = axes.axvline if body.shape.axis == 0 else axes.axhline
			across(body.state.pos[body.shape.axis], zorder=3, **style)
