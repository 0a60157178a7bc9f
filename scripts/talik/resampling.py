# SPDX-License-Identifier: GPL-2.0-or-later
"""Fields of material points as fields of the ground: on a raster, with the outline of the ground as a line. Pictures, films and ParaView's
surfaces of ground in the plane are made of it.

	ground = talik.resampling.Resampled(mpm.field("position"), mpm.field("volume"), mpm.field("deformationGradient"))
	temperature = ground(mpm.field("temperature"))  # (ground.y.size, ground.x.size)

Every point is spread over a Gaussian of its own area, stretched as its deformation gradient says but at most 1 : 2: accumulated strain makes
needles of points that have flowed, and needles are not where the ground is. The sum of the areas is 1 inside and 0 in the air, so ground is where it
exceeds 1/2. In small pieces a Gaussian is wider than what it stands for; there the level is moved until a piece covers the area of its points. Where a
straight row of points ends the ground to the left, to the right or below, as at the walls of a grid, the ground is mirrored, so that corners stay sharp.
"""

import numpy as np
from contourpy import FillType, contour_generator
from scipy import ndimage
from scipy.sparse import csr_matrix
from vtkmodules.util.numpy_support import numpy_to_vtk, vtk_to_numpy
from vtkmodules.vtkCommonDataModel import vtkImageData
from vtkmodules.vtkFiltersCore import vtkFlyingEdges3D

width = 0.6  # standard deviation of a point over its side: rows of points leave no ripple
largestStretch = 2.0  # of the axes of a point
reach = 3.0  # of a Gaussian, in its standard deviations
mostNodes = 1000  # of the raster along the longer side of the ground, if that leaves at least two along the side of a point
apart = 0.2  # pieces of ground are apart where the sum of areas is less
levels = (0.25, 0.7)  # within which the level of a piece may move; one point alone needs 0.28
straight = 0.15  # part of the width or height of the ground over which a row of points makes a straight side
pocket = 8.0  # gaps in the ground up to so many points in area, two cells of four, are gaps between points, no holes

# in space
nodesPerSpacing = 3  # of the raster on which the surface of the ground is found, for each spacing of points
smearing = 0.5  # standard deviation of a point on that raster, in spacings
surfaceLevel = 0.45  # part of the volume filled at the surface


class Resampled:
	"""Ground in the plane from its points.

	position     (n, 2) [m]
	volume       (n,) [m2]
	deformation  (n, 4) gradient xx, xy, yx, yy, or None: round points
	nodesPerSide of the raster along the side of a point, 1.5 or more; fewer, but two, where the ground has very many points
	sides        as sidesOf gives them: straight sides that are known; one that a point has passed is none

	x, y (m,), (k,) [m] are the nodes of the raster, `filled` (k, m) is above 1/2 where there is ground. ValueError if there are no points or positions
	of another shape.

	>>> ground = talik.resampling.Resampled(mpm.field("position"), mpm.field("volume"))
	>>> ground(mpm.field("temperature")).shape == ground.filled.shape
	True"""

	def __init__(self, position, volume, deformation=None, nodesPerSide=4, sides=None):
		position, volume = inPlane(position), np.asarray(volume, dtype=float)
		if not len(position):
			raise ValueError("position is empty; give at least one point")
		volume = np.maximum(volume, 1e-6 * np.median(volume))
		side = np.sqrt(volume)
		self.side = float(np.median(side))
		longest = np.ptp(position, axis=0).max() + self.side
		step = max(self.side / nodesPerSide, min(longest / mostNodes, self.side / 2))
		inverse, largest = _kernels(volume, deformation)
		self.sides = [
			_within(position[:, axis], found, known) for axis, found, known in zip((0, 1), sidesOf(position, volume, deformation), sides or 2 * [(None, None)])
		]
		margin = reach * largest.max()
		self.x, self._stepX, self._mirrorX = _nodes(position[:, 0], side, self.sides[0], step, margin)
		self.y, self._stepY, self._mirrorY = _nodes(position[:, 1], side, self.sides[1], step, margin)
		low = (self.x[0], self.y[0])
		self._weights = self._spread(position - low, volume, inverse, reach * largest)
		self._sum = self._weights @ np.ones(len(position))
		self._area, self._piece = self._pieces(position - low, volume)
		self.filled = self._levelled()

	def __call__(self, values, outside=np.nan):
		"""Values (n,) or (n, k) of the points as a field (y, x) or (y, x, k) on the raster, the mean weighted by area; `outside` where no point reaches.
		Points without a value (NaN) are left out."""
		values = np.asarray(values, dtype=float)
		known = np.isfinite(values) if values.ndim == 1 else np.isfinite(values).all(axis=1)
		total = self._sum if known.all() else self._weights @ known.astype(float)
		near = total > 1e-3 * np.maximum(self._sum, 1e-6)
		shaped = values if values.ndim == 2 else values[:, None]
		field = np.full((len(total), shaped.shape[1]), float(outside))
		field[near] = (self._weights @ np.where(known[:, None], shaped, 0.0))[near] / total[near, None]
		return field.reshape(*self.filled.shape, *values.shape[1:])

	@property
	def ground(self):
		"""(k, m) True at nodes in the ground."""
		return self.filled > 0.5

	def outline(self):
		"""List of closed lines (n, 2) [m] around the ground and its holes, each beginning where it ends."""
		points, offsets = contour_generator(self.x, self.y, self.filled, fill_type=FillType.OuterOffset).filled(0.5, np.inf)
		return [piece[first:last] for piece, ends in zip(points, offsets) for first, last in zip(ends, ends[1:])]

	def polygons(self):
		"""(vertices (n, 2) [m], codes (n,) of matplotlib.path.Path) of all pieces with their holes."""
		return polygonsOf(self.x, self.y, self.filled, 0.5)

	def area(self):
		"""Of what is drawn [m2]; that of the points, `volume.sum()`, within one per cent."""
		return _areaWithin(self.x, self.y, self.filled, 0.5)

	def triangles(self):
		"""The ground as triangles, those on its outline cut there: (points (p, 2) [m], triangles (t, 3), nodes (p, 2), weights (p, 2)). A point lies between two
		nodes of the raster, numbered along x first, and has of each its weight."""
		height, wide = self.filled.shape
		node = np.arange(height * wide).reshape(height, wide)
		a, b, c, d = (part.ravel() for part in (node[:-1, :-1], node[:-1, 1:], node[1:, 1:], node[1:, :-1]))
		corners = np.concatenate([np.column_stack([a, b, c]), np.column_stack([a, c, d])])
		level = self.filled.ravel()
		inside = (level > 0.5)[corners]
		whole = corners[inside.all(axis=1)]
		pieces = [np.stack([whole, whole], axis=2)]  # (t, 3, 2): each corner lies between two nodes
		for count in (1, 2):  # corners inside
			cut = inside.sum(axis=1) == count
			alone = np.argmax(inside[cut] == (count == 1), axis=1)
			p, q, r = (np.take_along_axis(corners[cut], ((alone + k) % 3)[:, None], axis=1)[:, 0] for k in range(3))
			pp, qq, rr, pq, pr = (
				np.column_stack(ends) for ends in ((p, p), (q, q), (r, r), (np.minimum(p, q), np.maximum(p, q)), (np.minimum(p, r), np.maximum(p, r)))
			)
			pieces += [np.stack(three, axis=1) for three in ([(pp, pq, pr)] if count == 1 else [(pq, qq, rr), (pq, rr, pr)])]
		ends, numbers = np.unique(np.concatenate(pieces).reshape(-1, 2), axis=0, return_inverse=True)
		between = ends[:, 0] != ends[:, 1]
		share = np.zeros(len(ends))
		low, high = level[ends[between]].T
		share[between] = (0.5 - low) / (high - low)
		place = np.column_stack([np.tile(self.x, height), np.repeat(self.y, wide)])
		weights = np.column_stack([1 - share, share])
		points = weights[:, :1] * place[ends[:, 0]] + weights[:, 1:] * place[ends[:, 1]]
		return points, numbers.reshape(-1, 3), ends, weights

	def _spread(self, position, volume, inverse, radii):
		"""Matrix (nodes, points) of the area of each point that a node stands for, over the area of the node."""
		rows, columns, values = [], [], []
		half = np.ceil(radii / min(self._stepX, self._stepY)).astype(int)
		span = 2 ** np.ceil(np.log2(np.maximum(half, 1))).astype(int)  # windows of few sizes
		for size in np.unique(span):
			chosen = np.flatnonzero(span == size)
			cells = np.arange(-half[chosen].max(), half[chosen].max() + 1)
			for part in np.array_split(chosen, max(1, len(chosen) * len(cells) ** 2 // 4_000_000)):
				i = np.rint(position[part, :1] / self._stepX).astype(int) + cells
				j = np.rint(position[part, 1:] / self._stepY).astype(int) + cells
				dx, dy = (i * self._stepX - position[part, :1])[:, None, :], (j * self._stepY - position[part, 1:])[:, :, None]
				a, b, c = inverse[part].T[:, :, None, None]
				weight = np.exp(-0.5 * (a * dx**2 + 2 * b * dx * dy + c * dy**2))
				weight *= (volume[part] / np.maximum(weight.sum(axis=(1, 2)), 1e-300) / (self._stepX * self._stepY))[:, None, None]
				for seenX in _images(i, self.x.size, self._mirrorX):
					for seenY in _images(j, self.y.size, self._mirrorY):
						shown = (weight > 1e-6) & (seenX >= 0)[:, None, :] & (seenY >= 0)[:, :, None]
						rows.append((seenY[:, :, None] * self.x.size + seenX[:, None, :])[shown])
						columns.append(np.broadcast_to(part[:, None, None], shown.shape)[shown])
						values.append(weight[shown])
		shape = (self.y.size * self.x.size, len(position))
		return csr_matrix((np.concatenate(values), (np.concatenate(rows), np.concatenate(columns))), shape=shape)

	def _pieces(self, position, volume):
		"""(area of the points of each piece of ground, number of the piece at each node or 0)."""
		numbers, count = ndimage.label(self._sum.reshape(self.y.size, self.x.size) > apart)
		i, j = np.rint(position / (self._stepX, self._stepY)).astype(int).T
		return np.bincount(numbers[j, i], weights=volume, minlength=count + 1), numbers

	def _levelled(self):
		"""The sum of areas, without the gaps between points, scaled in each piece such that it is above 1/2 over the area of its points."""
		nearest = ndimage.distance_transform_edt(self._piece == 0, return_distances=False, return_indices=True)
		owner, filled = self._piece[tuple(nearest)], self._withoutPockets(self._sum.reshape(self._piece.shape))
		for _ in range(2):  # what the level of a piece opens again is closed again, and counts
			scale = np.full(len(self._area), 0.5 / levels[0])
			for number, window in enumerate(ndimage.find_objects(self._piece), start=1):
				window = tuple(slice(max(s.start - 4, 0), s.stop + 4) for s in window)  # its edge is in the air
				inside = np.where(owner[window] == number, filled[window], 0.0)
				scale[number] = 0.5 / _levelOf(self.x[window[1]], self.y[window[0]], inside, self._area[number])
			filled = self._withoutPockets(filled * scale[owner])
		return filled

	def _withoutPockets(self, filled):
		air, count = ndimage.label(filled < 0.55)
		if count < 2:
			return filled
		nodes = np.bincount(air.ravel(), minlength=count + 1)
		small = nodes * self._stepX * self._stepY <= pocket * self.side**2
		small[0] = False
		return np.where(small[air], 0.75, filled)


def sidesOf(position, volume, deformation=None):
	"""[(left, right) x, (lower, upper) y] [m] of the straight sides in which the ground of points ends, None where a side is not straight. Above there is
	none: ground ends in the air there.

	>>> lower, upper = talik.resampling.sidesOf(mpm.field("position"), mpm.field("volume"))[1]
	>>> abs(lower) < 1e-4, upper
	(True, None)"""
	position, (inverse, _) = inPlane(position), _kernels(volume, deformation)
	determinant = inverse[:, 0] * inverse[:, 2] - inverse[:, 1] ** 2
	half = [0.5 / width * np.sqrt(inverse[:, k] / determinant) for k in (2, 0)]  # of the side of a point along each axis
	found = []
	for along, across in ((0, 1), (1, 0)):
		extent = np.ptp(position[:, across]) + 2 * np.median(half[across])
		sides = []
		for sign in (-1, 1):
			ends = sign * position[:, along] + half[along]
			beside, on = ends.max() - ends < half[along], ends.max() - ends < 0.3 * half[along]
			isStraight = on.sum() > max(3, 0.8 * beside.sum()) and 2 * half[across][on].sum() > straight * extent
			sides.append(float(sign * ends.max()) + 0.0 if isStraight and (along, sign) != (1, 1) else None)
		found.append(tuple(sides))
	return found


def groundOf(frame, nodesPerSide=4):
	"""Resampled of the points of a frame, {"position": ..., "volume": ..., "deformationGradient" and "displacement" where they are known}: a side that was
	straight before the displacement and that no point has passed is a wall.

	>>> ground = talik.resampling.groundOf(talik.output.allFields(mpm))"""
	position, volume, deformation = frame["position"], np.asarray(frame["volume"], dtype=float), frame.get("deformationGradient")
	sides = sidesOf(*atStart(frame)) if "displacement" in frame else None
	return Resampled(position, volume, deformation, nodesPerSide, sides)


def atStart(frame):
	"""(position, volume) of the points of a frame before their displacement and strain.

	>>> position, volume = talik.resampling.atStart(talik.output.allFields(mpm))"""
	volume = np.asarray(frame["volume"], dtype=float)
	if "deformationGradient" in frame:
		volume = volume / np.abs(np.linalg.det(np.asarray(frame["deformationGradient"], dtype=float).reshape(-1, 2, 2)))
	return inPlane(frame["position"]) - frame["displacement"], volume


def _within(along, found, known):
	"""Sides (below, above) along an axis: those found, else known ones that no point has passed."""
	passed = along.min() <= (known[0] if known[0] is not None else np.inf), along.max() >= (known[1] if known[1] is not None else -np.inf)
	return tuple(mine if mine is not None or beyond else other for mine, other, beyond in zip(found, known, passed))


def _nodes(along, side, sides, step, margin):
	"""Nodes of the raster along one axis, their distance, and whether the raster ends in a straight side of the ground (below, above) in which it is
	mirrored; else it ends in the air."""
	ends = [
		sides[0] if sides[0] is not None else along.min() - 0.5 * side.max() - margin - 2 * step,
		sides[1] if sides[1] is not None else along.max() + 0.5 * side.max() + margin + 2 * step,
	]
	count = int(np.ceil((ends[1] - ends[0]) / step - 1e-9))
	return np.linspace(*ends, count + 1), (ends[1] - ends[0]) / count, tuple(end is not None for end in sides)


def _images(nodes, count, mirrored):
	"""Numbers of the nodes (-1: none) on which the window of a point falls, and those on which its images behind straight sides do."""
	inside = np.where((nodes >= 0) & (nodes < count), nodes, -1)
	below = np.where((nodes <= 0) & (nodes > -count), -nodes, -1)
	above = np.where((nodes >= count - 1) & (nodes < 2 * count - 1), 2 * (count - 1) - nodes, -1)
	return [inside] + [image for image, seen in zip((below, above), mirrored) if seen and (image >= 0).any()]


def _kernels(volume, deformation):
	"""(xx, xy, yy of the inverse of the covariance (n, 3), largest standard deviation (n,)) of each point."""
	variance = width**2 * np.asarray(volume, dtype=float)
	if deformation is None:
		return np.column_stack([1 / variance, 0 * variance, 1 / variance]), np.sqrt(variance)
	gradient = np.asarray(deformation, dtype=float).reshape(-1, 2, 2)
	value, axes = np.linalg.eigh(gradient @ gradient.transpose(0, 2, 1))
	ratio = np.minimum(np.sqrt(np.maximum(value[:, 1] / np.maximum(value[:, 0], 1e-12), 1)), largestStretch)
	long, short = axes[:, :, 1], axes[:, :, 0]
	inverse = _dyad(long) / (variance * ratio)[:, None] + _dyad(short) * (ratio / variance)[:, None]
	return inverse, np.sqrt(variance * ratio)


def _dyad(vector):
	return np.column_stack([vector[:, 0] ** 2, vector[:, 0] * vector[:, 1], vector[:, 1] ** 2])


def _levelOf(x, y, filled, area):
	"""The level above which `filled` covers the area, within `levels`."""
	low, high = levels
	for _ in range(12):
		middle = 0.5 * (low + high)
		low, high = (middle, high) if _areaWithin(x, y, filled, middle) > area else (low, middle)
	return 0.5 * (low + high)


def polygonsOf(x, y, filled, level):
	"""(vertices (n, 2) [m], codes (n,) of matplotlib.path.Path) of where `filled` (y, x) is above a level.

	>>> vertices, codes = talik.resampling.polygonsOf([0, 1, 2], [0, 1, 2], np.pad([[1.0]], 1), 0.5)
	>>> len(vertices)
	5"""
	points, codes = contour_generator(x, y, filled, fill_type=FillType.OuterCode).filled(level, np.inf)
	if not points:
		return np.zeros((0, 2)), np.zeros(0, dtype=np.uint8)
	return np.concatenate(points), np.concatenate(codes)


def _areaWithin(x, y, filled, level):
	"""Area within the lines of a level [m2]."""
	if min(filled.shape) < 2:
		return 0.0
	points, offsets = contour_generator(x, y, filled, fill_type=FillType.OuterOffset).filled(level, np.inf)
	return float(sum(0.5 * _twiceArea(line[first:last]) for line, ends in zip(points, offsets) for first, last in zip(ends, ends[1:])))


def _twiceArea(line):
	"""With sign: holes turn the other way."""
	x, y = line.T
	return float(np.dot(x[:-1], y[1:]) - np.dot(x[1:], y[:-1]))


def inPlane(position):
	"""Positions (n, 2) [m] as numbers; ValueError for others.

	>>> talik.resampling.inPlane([(0, 1)]).shape
	(1, 2)"""
	position = np.asarray(position, dtype=float)
	if position.ndim != 2 or position.shape[1] != 2:
		raise ValueError(f"position has shape {position.shape}; pictures are of ground in the plane, (n, 2); talik.output.ParaViewSeries shows ground in space")
	return position


# --- space -----------------------------------------------------------------------------------------------------------------


class SpaceRaster:
	"""Ground in space from its points: cells of a regular raster in the box of the grid, onto which points are smeared.

	position (n, 3) [m], volume (n,) [m3]; lower, upper: corners of the box [m], whose sides mirror the ground

	>>> lattice = np.stack(np.meshgrid(*3 * [np.arange(4) + 0.5]), axis=-1).reshape(-1, 3)
	>>> raster = talik.resampling.SpaceRaster(lattice, np.ones(64), (0, 0, 0), (4, 4, 6))
	>>> raster.smeared(1.0).max() > 0.9
	True"""

	def __init__(self, position, volume, lower, upper):
		spacing = np.median(volume) ** (1 / 3)
		lower, upper = np.array(lower, dtype=float), np.array(upper, dtype=float)
		upper[2] = min(upper[2], position[:, 2].max() + 3 * spacing)
		self.shape = np.maximum(2, np.round((upper - lower) / spacing * nodesPerSpacing).astype(int))
		self.lower, self.step = lower, (upper - lower) / self.shape
		self.position, self.volume = position, volume
		self.spread = smearing * spacing / self.step

	def nodes(self, axis):
		"""Places [m] of the cells along an axis, 0, 1 or 2."""
		return self.lower[axis] + (np.arange(self.shape[axis]) + 0.5) * self.step[axis]

	def smeared(self, weight):
		"""Density of weight times volume in the cells; the sides of the box mirror it."""
		ends = [self.lower[a] + np.arange(self.shape[a] + 1) * self.step[a] for a in range(3)]
		cells, _ = np.histogramdd(self.position, bins=ends, weights=np.broadcast_to(weight * self.volume, len(self.position)))
		return ndimage.gaussian_filter(cells / self.step.prod(), self.spread, mode="reflect")

	def cut(self, weight, y):
		"""(x (m,), z (k,) [m], smeared weight (k, m)) in the plane of a y [m], between two rows of cells that of both, from side to side of the box."""
		smeared, place = self.smeared(weight), (y - self.lower[1]) / self.step[1] - 0.5
		first = int(np.clip(np.floor(place), 0, max(self.shape[1] - 2, 0)))
		share = float(np.clip(place - first, 0, 1))
		between = (1 - share) * smeared[:, first] + share * smeared[:, min(first + 1, self.shape[1] - 1)]
		ends = [np.concatenate([[self.lower[a]], self.nodes(a), [self.lower[a] + self.shape[a] * self.step[a]]]) for a in (0, 2)]
		return *ends, np.pad(between, 1, mode="edge").T

	def contour(self, level, at, fields):
		"""Closed surface on which `level` has a value: (vertices, triangles, fields at the vertices)."""
		image, finder = vtkImageData(), vtkFlyingEdges3D()
		image.SetDimensions(*(self.shape + 2))
		image.SetOrigin(*(-0.5 * self.step))  # VTK's places have single precision, half a metre in the north of UTM: they count from `lower`
		image.SetSpacing(*self.step)
		for name, values, mode in (("level", level, "constant"), *((f"field{k}", field, "edge") for k, field in enumerate(fields))):
			array = numpy_to_vtk(np.pad(values, 1, mode=mode).ravel(order="F"), deep=True)
			array.SetName(name)
			image.GetPointData().AddArray(array)
		image.GetPointData().SetActiveScalars("level")
		finder.SetInputData(image)
		finder.SetValue(0, at)
		finder.InterpolateAttributesOn()
		finder.Update()
		surface = finder.GetOutput()
		vertices = vtk_to_numpy(surface.GetPoints().GetData()).astype(float)
		# the raster reaches half a step beyond the sides of the box
		vertices = self.lower + np.clip(vertices, 0, self.shape * self.step)
		triangles = vtk_to_numpy(surface.GetPolys().GetConnectivityArray()).reshape(-1, 3)
		return vertices, triangles, [vtk_to_numpy(surface.GetPointData().GetArray(f"field{k}")) for k in range(len(fields))]
