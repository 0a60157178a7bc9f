# SPDX-License-Identifier: GPL-2.0-or-later
"""Bodies of the scene among the material points: their outlines in the plane, for pictures.

	talik.bodies.draw(axes, O.bodies)
"""

import math

import numpy as np

edgesOfBox = np.array([(-1, -1), (1, -1), (1, 1), (-1, 1), (-1, -1)], dtype=float)


def outline(body, corners=60):
	"""Polyline (n, 2) [m] in which the body meets the ground; None for a wall, which has no end, and for what has no outline.

	>>> talik.bodies.outline(utils.sphere((0, 1, 0), 0.5)).shape
	(60, 2)"""
	shape, position, turned = body.shape, np.array(body.state.pos), body.state.ori.toRotationMatrix()
	rotation = np.array([[turned[i, j] for j in range(3)] for i in range(3)])
	if hasattr(shape, "radius"):
		angle = np.linspace(0, 2 * math.pi, corners) + math.atan2(rotation[1, 0], rotation[0, 0])
		return position[:2] + shape.radius * np.column_stack([np.cos(angle), np.sin(angle)])
	if hasattr(shape, "extents"):
		local = edgesOfBox * np.array(shape.extents)[:2]
		return position[:2] + local @ rotation[:2, :2].T
	if hasattr(shape, "vertices"):
		return (position + np.array(shape.vertices) @ rotation.T)[[0, 1, 2, 0], :2]
	return None


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
