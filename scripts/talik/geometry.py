# SPDX-License-Identifier: GPL-2.0-or-later
"""Filling of outlines with material points.

	talik.geometry.fill(mpm, [(0, 0), (10, 0), (10, 1), (6, 1), (3, 4), (0, 4)], pointsPerCell=4, temperature=-5)

Points sit on a regular lattice inside the cells of the grid. Where the outline cuts a lattice square, the point gets the area and
the centroid of the part inside, so area and first moment of the outline are kept to round-off. Lengths in m, volumes per metre of
thickness (m2). Ground in space is filled with the solids of talik.solids in the same way.
"""

import math

import numpy as np
from matplotlib.path import Path
from shapely.geometry import Polygon, box
from shapely.validation import make_valid

smallestPart = 0.2  # parts smaller than this fraction of a lattice square or cube join the nearest point


class Solid:
	"""A part of space that can be filled, see talik.solids.

	lower, upper  corners of its box (3,) [m]

	>>> talik.solids.box((0, 0, 0), (4, 2, 1)).upper.tolist()
	[4.0, 2.0, 1.0]"""

	lower, upper = None, None

	def points(self, side, origin):
		"""Positions (n, 3) [m] and volumes (n,) [m3] on the lattice of cubes of a side [m] whose corner is the origin (3,)."""
		raise NotImplementedError

	def depth(self, x, y, z):
		"""Depth below the highest surface [m] of places x, y, z [m]; boxes, extruded outlines and terrain know it."""
		raise ValueError(f"{type(self).__name__.strip('_')}: a closed surface does not know the depth below it; describe the ground by talik.solids.terrain")


def rectangle(x0, y0, x1, y1):
	"""Corners of an axis-aligned rectangle, counter-clockwise.

	>>> talik.geometry.rectangle(0, 0, 4, 2)
	[(0, 0), (4, 0), (4, 2), (0, 2)]"""
	return [(x0, y0), (x1, y0), (x1, y1), (x0, y1)]


def fill(mpm, polygon, pointsPerCell=None, holes=(), **attributes):
	"""Adds points that fill an outline, or in space a solid, to an MpmEngine, on the lattice of its grid; returns the ids of the new points (n,).

	polygon        corners (m, 2) of an outline [m], or a solid of talik.solids: box, extruded, closedSurface, terrain
	pointsPerCell  a square number, in space a cubic one; default: one where the ground has a FreezingCurve, so that a cell is one piece of ground,
				   frozen or not; otherwise two points in each direction
	holes          outlines inside a polygon that are left out, each a list of corners (m, 2) [m]

	Attributes are those of MpmEngine.addPoints: porosity [-], poreFill (part of the pores that holds water or ice) [-], temperature
	[degC], pressure (pore water) [Pa], stress (n, 4) xx yy zz xy or, in space, (n, 6) xx yy zz yz xz xy [Pa], velocity (n, 2) or (n, 3) [m/s],
	skeleton (index), material (name or index of one of mpm.materials).
	Each is a number (a row of components), an array of one value per point, or a function f(x, y), in space f(x, y, z),
	of the points' coordinates [m], arrays (n,), that returns such an array. ValueError names what lies outside of the grid's box:

	>>> mpm = MpmEngine(gridSpacing=0.5, heat=HeatTransfer())
	>>> added = talik.geometry.fill(mpm, [(0, 0), (4, 0), (0, 2)], temperature=lambda x, y: -5 + 0.5 * y, pressure=lambda x, y: 9810 * (2 - y))
	>>> len(added) == mpm.pointCount
	True"""
	solid = polygon if isinstance(polygon, Solid) else None
	_checkDimension(mpm, solid)
	if pointsPerCell is None:
		pointsPerCell = 1 if getattr(mpm, "freezing", None) is not None else 4 if solid is None else 8
	if solid is None:
		positions, volumes = fillPolygon(polygon, mpm.gridSpacing, pointsPerCell, _gridOrigin(mpm, 2), holes)
	else:
		if len(holes):
			raise ValueError("fill: holes are for polygons in the plane; leave them out of a solid")
		_refuseOutside(mpm, solid)
		positions, volumes = solid.points(_latticeSide(mpm.gridSpacing, pointsPerCell, 3), _gridOrigin(mpm, 3))
	values = {name: value(*positions.T) if callable(value) else value for name, value in attributes.items()}
	first = mpm.pointCount
	mpm.addPoints(position=positions, volume=volumes, **values)
	return np.arange(first, mpm.pointCount)


def fillPolygon(polygon, gridSpacing, pointsPerCell=4, origin=(0.0, 0.0), holes=()):
	"""Positions (n, 2) [m] and volumes (n,) [m2] of points that fill a polygon.

	polygon        corners (m, 2), m >= 3, either orientation, not self-intersecting
	gridSpacing    cell size [m], > 0
	pointsPerCell  a square number: 1, 4, 9, 16
	origin         of the grid [m]
	holes          outlines inside the polygon that are left out [m]

	>>> position, volume = talik.geometry.fillPolygon([(0, 0), (4, 0), (0, 2)], gridSpacing=0.5)
	>>> float(round(volume.sum(), 9))
	4.0"""
	checked = ground(polygon, holes)
	rings = [np.array(ring.coords)[:-1] for ring in (checked.exterior, *checked.interiors)]
	return latticeInPolygon(rings[0], _latticeSide(gridSpacing, pointsPerCell, 2), np.asarray(origin, dtype=float), rings[1:])


def ground(polygon, holes=()):
	"""A polygon of shapely of checked corners (m, 2) [m] without holes, each a list of corners; ValueError with what is wrong otherwise.

	>>> talik.geometry.ground([(0, 0), (4, 0), (4, 2), (0, 2)], holes=[[(1, 1), (2, 1), (2, 1.5), (1, 1.5)]]).area
	7.5"""
	outline, cut = checkedPolygon(polygon), [checkedPolygon(hole, f"holes[{k}]") for k, hole in enumerate(holes)]
	whole, parts = make_valid(Polygon(outline)), [make_valid(Polygon(hole)) for hole in cut]
	for k, part in enumerate(parts):
		if part.difference(whole).area > 1e-9 * part.area:
			raise ValueError(f"holes[{k}] reaches out of the polygon; move its corners inside, or cut the polygon there")
		if any(part.intersection(other).area > 1e-9 * part.area for other in parts[:k]):
			raise ValueError(f"holes[{k}] overlaps another hole; give the outline of both as one hole")
	return Polygon(outline, cut)


def latticeInPolygon(corners, side, origin, holes=()):
	"""Positions (n, 2) [m] and volumes (n,) [m2] of the lattice squares of a side [m] inside corners (m, 2), and outside holes, that are checked.

	>>> position, volume = talik.geometry.latticeInPolygon(np.array([(0, 0), (4, 0), (0, 2)]), side=0.25, origin=np.zeros(2))
	>>> len(volume) > 60
	True"""
	centres = _latticeCentres(corners, side, origin)
	cut, inside = _touchedByOutline(corners, centres, side), Path(corners).contains_points(centres)
	for hole in holes:
		cut |= _touchedByOutline(hole, centres, side)
		inside &= ~Path(hole).contains_points(centres)
	whole = centres[~cut & inside]
	partCentres, partAreas = _parts(Polygon(corners, holes), centres[cut], side)
	positions = np.vstack([whole, partCentres])
	volumes = np.concatenate([np.full(len(whole), side * side), partAreas])
	positions, volumes = _joinSmallParts(positions, volumes, smallestPart * side * side)
	row, column = np.round(positions / side, 6)[:, ::-1].T  # round-off must not decide the order
	order = np.lexsort((column, row))
	return positions[order], volumes[order]


def polygonArea(corners):
	"""Area and centroid of a polygon: (area >= 0, (x, y)).

	>>> area, centroid = talik.geometry.polygonArea([(0, 0), (3, 0), (0, 3)])
	>>> float(area)
	4.5"""
	corners = np.asarray(corners, dtype=float)
	base = corners[0]
	x, y = (corners - base).T
	xNext, yNext = np.roll(x, -1), np.roll(y, -1)
	cross = x * yNext - xNext * y
	twice = cross.sum()
	if twice == 0:
		return 0.0, corners.mean(axis=0)
	centroid = np.array([((x + xNext) * cross).sum(), ((y + yNext) * cross).sum()]) / (3 * twice)
	return 0.5 * abs(twice), base + centroid


def surfaceHeight(polygon, x):
	"""Height of the highest edge of a polygon above x [m].

	>>> talik.geometry.surfaceHeight([(0, 0), (4, 0), (4, 1), (0, 3)], 2)
	2.0"""
	corners = list(polygon)
	heights = []
	for (x0, y0), (x1, y1) in zip(corners, corners[1:] + corners[:1]):
		if min(x0, x1) <= x <= max(x0, x1):
			heights.append(max(y0, y1) if x0 == x1 else y0 + (y1 - y0) * (x - x0) / (x1 - x0))
	if not heights:
		raise ValueError(f"surfaceHeight: x = {x:g} m lies beside the polygon")
	return max(heights)


def checkedPolygon(polygon, name="polygon"):
	"""The corners as array (n, 2); ValueError with what is wrong otherwise, under the name that messages give it.

	>>> talik.geometry.checkedPolygon([(0, 0), (3, 0), (0, 3)]).shape
	(3, 2)"""
	try:
		corners = np.array([tuple(float(c) for c in corner) for corner in polygon])
	except (TypeError, ValueError):
		raise ValueError(f"{name} is {polygon!r}; it must be a list of corners (x, y) in m") from None
	if corners.ndim != 2 or corners.shape[0] < 3 or corners.shape[1] != 2:
		raise ValueError(f"{name} has shape {corners.shape}; it must have at least three corners (x, y)")
	if not np.isfinite(corners).all():
		raise ValueError(f"{name} has a corner that is not finite; all coordinates must be numbers in m")
	crossing = _selfIntersection(corners)
	if crossing:
		raise ValueError(f"{name} crosses itself: its sides {crossing[0]} and {crossing[1]} intersect; give the corners in order around it")
	if polygonArea(corners)[0] < 1e-12 * np.ptp(corners, axis=0).max() ** 2:
		raise ValueError(f"{name} has no area; its corners lie on one line")
	return corners


def _checkDimension(mpm, solid):
	"""A polygon fills ground in the plane, a solid ground in space."""
	components = {name: len(corner) for name in ("lower", "upper", "gravity") if np.isfinite(corner := tuple(getattr(mpm, name, (math.nan,)))).any()}
	components["dimension"] = getattr(mpm, "dimension", 0)
	if solid is None and 3 in components.values():
		name = next(name for name, number in components.items() if number == 3)
		raise ValueError(f"fill: the ground is in space by MpmEngine.{name}, and a polygon fills the plane; give a solid, e.g. talik.solids.extruded(…)")
	if solid is not None and components["dimension"] == 2:
		raise ValueError("fill: MpmEngine.dimension is 2, and a solid fills space; give a polygon of corners (x, y)")


def _refuseOutside(mpm, solid):
	for name, corner, reach, beyond in (("lower", mpm.lower, solid.lower, -1), ("upper", mpm.upper, solid.upper, 1)):
		if len(corner) != 3:
			continue
		for axis, limit, end in zip("xyz", corner, reach):
			if beyond * (end - limit) > 1e-9 * max(1.0, abs(limit)):
				raise ValueError(
					f"fill: the solid reaches to {axis} = {end:g} m, outside of the grid's box; set MpmEngine.{name} to at least that, or cut the solid"
				)


def _gridOrigin(mpm, dimension):
	"""The engine's lower corner where it is set; a grid that is put around its points starts at a multiple of its spacing."""
	lower = getattr(mpm, "lower", (0.0,) * dimension)
	return [corner if math.isfinite(corner) else 0.0 for corner in (lower if len(lower) == dimension else (0.0,) * dimension)]


def _latticeSide(gridSpacing, pointsPerCell, dimension):
	if not (np.isscalar(gridSpacing) and 0 < gridSpacing < math.inf):
		raise ValueError(f"gridSpacing is {gridSpacing!r}; it must be a length in m, greater than 0")
	perSide = round(pointsPerCell ** (1 / dimension)) if isinstance(pointsPerCell, int) and pointsPerCell > 0 else 0
	if perSide == 0 or perSide**dimension != pointsPerCell:
		wanted = "a square number: 1, 4, 9 or 16" if dimension == 2 else "a cubic number: 1, 8, 27 or 64"
		raise ValueError(f"pointsPerCell is {pointsPerCell!r}; it must be {wanted}")
	return gridSpacing / perSide


def _latticeCentres(corners, side, origin):
	low = np.floor((corners.min(axis=0) - origin) / side).astype(int)
	high = np.ceil((corners.max(axis=0) - origin) / side).astype(int)
	x, y = (origin[k] + (np.arange(low[k], high[k]) + 0.5) * side for k in (0, 1))
	return np.stack(np.meshgrid(x, y), axis=-1).reshape(-1, 2)


def _touchedByOutline(corners, centres, side):
	"""Lattice squares that a side of the polygon touches (separating axes: x, y and the normal of the side)."""
	touched = np.zeros(len(centres), dtype=bool)
	half = 0.5 * side * (1 + 1e-9)
	for start, end in zip(corners, np.roll(corners, -1, axis=0)):
		middle, extent = 0.5 * (start + end), 0.5 * np.abs(end - start)
		normal = np.array([start[1] - end[1], end[0] - start[0]])
		offset = centres - middle
		inBox = (np.abs(offset) <= extent + half).all(axis=1)
		touched |= inBox & (np.abs(offset @ normal) <= half * np.abs(normal).sum())
	return touched


def _parts(outline, centres, side):
	"""Centroid and area of the parts of lattice squares inside the polygon; empty ones left out."""
	inside, half = make_valid(outline), 0.5 * side
	parts = [inside.intersection(box(x - half, y - half, x + half, y + half)) for x, y in centres]
	found = [(part.area, (part.centroid.x, part.centroid.y)) for part in parts if part.area > 1e-9 * side * side]
	return np.array([c for _, c in found]).reshape(-1, 2), np.array([a for a, _ in found])


def _joinSmallParts(positions, volumes, smallest):
	"""Adds small parts to the nearest larger point: total volume and first moment stay."""
	small = volumes < smallest
	if small.all() or not small.any():
		return positions, volumes
	kept, keptVolumes = positions[~small].copy(), volumes[~small].copy()
	nearest = np.argmin(((positions[small][:, None, :] - positions[~small][None, :, :]) ** 2).sum(axis=2), axis=1)
	for target, position, volume in zip(nearest, positions[small], volumes[small]):
		total = keptVolumes[target] + volume
		kept[target] = (keptVolumes[target] * kept[target] + volume * position) / total
		keptVolumes[target] = total
	return kept, keptVolumes


def _selfIntersection(corners):
	count = len(corners)
	sides = [(corners[i], corners[(i + 1) % count]) for i in range(count)]
	for i in range(count):
		for j in range(i + 2, count):
			if (j + 1) % count != i and _crosses(*sides[i], *sides[j]):
				return i, j
	return None


def _crosses(a, b, c, d):
	def side(p, q, r):
		return (q[0] - p[0]) * (r[1] - p[1]) - (q[1] - p[1]) * (r[0] - p[0])

	return side(a, b, c) * side(a, b, d) < 0 and side(c, d, a) * side(c, d, b) < 0
