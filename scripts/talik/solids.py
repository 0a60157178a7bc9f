# SPDX-License-Identifier: GPL-2.0-or-later
"""Solids that talik.geometry.fill fills with material points in space: boxes, extruded outlines, closed surfaces, terrain.

	hill = talik.solids.terrain(talik.solids.readHeights("hill.asc"), base=200.0)
	talik.geometry.fill(mpm, hill, temperature=hill.layers([0.5, 2.0], [1.0, -0.5, -2.0]))

Lengths in m, volumes in m3, z upwards. Points sit on a lattice of cubes inside the cells of the grid; a cube that is cut gives a point
with the volume and the centroid of its part inside. Volume and first moment of boxes and extruded outlines are kept to round-off. Those of
surfaces and terrain are integrated along vertical lines, `linesPerPoint` squared for each point.
"""

import math
import os

import numpy as np

from talik import geometry
from talik.geometry import Solid, smallestPart

linesPerPoint = 4  # in each horizontal direction; their ends are exact


# --- boxes and extruded outlines -------------------------------------------------------------------------------------------


class _Extruded(Solid):
	def __init__(self, outline, front, back):
		self.corners = geometry.checkedPolygon(outline)
		self.front, self.back = (_number(value, name) for value, name in ((front, "front"), (back, "back")))
		if not self.front < self.back:
			raise ValueError(f"front is {self.front:g} m and back {self.back:g} m; front must be less than back")
		low, high = self.corners.min(axis=0), self.corners.max(axis=0)
		self.lower, self.upper = np.array([low[0], self.front, low[1]]), np.array([high[0], self.back, high[1]])

	def points(self, side, origin):
		section, areas = geometry.latticeInPolygon(self.corners, side, np.asarray(origin, dtype=float)[[0, 2]])
		middles, lengths = _piecesOfInterval(self.front, self.back, side, origin[1])
		x, y = np.repeat(section[:, 0], len(middles)), np.tile(middles, len(section))
		position = np.column_stack([x, y, np.repeat(section[:, 1], len(middles))])
		return _ordered(position, np.outer(areas, lengths).ravel(), side)

	def depth(self, x, y, z):
		outline = [tuple(map(float, corner)) for corner in self.corners]
		depth = np.array([geometry.surfaceHeight(outline, at) for at in np.ravel(x)]).reshape(np.shape(x)) - z
		return depth if np.ndim(depth) else float(depth)


def box(lower, upper):
	"""The box between two corners (3,) [m].

	>>> added = talik.geometry.fill(MpmEngine(gridSpacing=0.5), talik.solids.box((0, 0, 0), (4, 2, 1)))"""
	lower, upper = _corner(lower, "lower"), _corner(upper, "upper")
	if not (lower < upper).all():
		raise ValueError(f"lower is {_text(lower)} and upper {_text(upper)}; each coordinate of lower must be less than that of upper")
	return _Extruded([(lower[0], lower[2]), (upper[0], lower[2]), (upper[0], upper[2]), (lower[0], upper[2])], lower[1], upper[1])


def extruded(outline, front, back):
	"""An outline of corners (x, z) [m], in either orientation, from y = front to y = back [m]: the slope of a plane scene with a width.

	>>> slope = talik.solids.extruded([(0, 0), (10, 0), (10, 1), (0, 4)], front=0, back=5)
	>>> added = talik.geometry.fill(MpmEngine(gridSpacing=0.5), slope, temperature=lambda x, y, z: -0.5 * z)"""
	return _Extruded(outline, front, back)


# --- solids that vertical lines enter and leave ----------------------------------------------------------------------------


class _Lined(Solid):
	def spans(self, x, y):
		"""Where vertical lines at x, y (n,) lie inside: (number of the line, lower z, upper z), each (m,)."""
		raise NotImplementedError

	def points(self, side, origin):
		origin = np.asarray(origin, dtype=float)
		first = np.floor((self.lower - origin) / side + 1e-9).astype(int)
		count = np.maximum(1, np.ceil((self.upper - origin) / side - 1e-9).astype(int) - first)
		step = side / linesPerPoint
		x, y = (origin[a] + first[a] * side + (np.arange(count[a] * linesPerPoint) + 0.5) * step for a in (0, 1))
		line, low, high = self.spans(*(grid.ravel() for grid in np.meshgrid(x, y, indexing="ij")))
		bottom = origin[2] + first[2] * side
		low, high = (np.clip((z - bottom) / side, 0, count[2]) for z in (low, high))
		piece, layer = _layersOf(low, high)
		part = np.minimum(high[piece], layer + 1) - np.maximum(low[piece], layer)
		middle = 0.5 * (np.minimum(high[piece], layer + 1) + np.maximum(low[piece], layer))
		i, j = np.divmod(line[piece], len(y))
		cube = ((i // linesPerPoint) * count[1] + j // linesPerPoint) * count[2] + layer
		sums = [np.bincount(cube, weights=part * weight, minlength=count.prod()) for weight in (1.0, x[i], y[j], bottom + middle * side)]
		inside = sums[0] > 1e-9 * linesPerPoint**2
		position = np.column_stack([moment[inside] / sums[0][inside] for moment in sums[1:]])
		return _ordered(position, sums[0][inside] * step * step * side, side)


def _layersOf(low, high):
	"""The lattice layers that intervals reach into: (number of the interval, number of the layer)."""
	first, last = np.floor(low).astype(int), np.ceil(high).astype(int)
	count = np.maximum(0, last - first)
	piece = np.repeat(np.arange(len(low)), count)
	return piece, np.arange(len(piece)) - np.repeat(np.cumsum(count) - count, count) + first[piece]


class _Surface(_Lined):
	def __init__(self, vertices, triangles, name):
		self.vertices, self.triangles, self.name = vertices, triangles, name
		self.lower, self.upper = vertices.min(axis=0), vertices.max(axis=0)
		_refuseHoles(vertices, triangles, name)

	def spans(self, x, y):
		size = max(self.upper - self.lower)
		# a line through a corner or an edge is nobody's: all are moved by what no mesh is made for
		line, height = _crossings(self.vertices[self.triangles], x + 1.37e-7 * size, y + 2.93e-7 * size)
		order = np.lexsort((height, line))
		line, height = line[order], height[order]
		if len(line) % 2 or (line[::2] != line[1::2]).any():
			numbers, counts = np.unique(line, return_counts=True)
			odd = numbers[counts % 2 == 1][0]
			raise ValueError(f"{self.name} leaks: the vertical line at x = {x[odd]:g}, y = {y[odd]:g} m enters and does not leave; close the mesh")
		return line[::2], height[::2], height[1::2]


def closedSurface(surface):
	"""The inside of a closed surface of triangles, in any orientation: a file (.stl, .gts, .obj, .ply), a gts.Surface, or (vertices (n, 3) [m],
	triangles (m, 3) of vertex numbers).

	ValueError names a place where the surface is open.

	>>> corners = [(0, 0, 0), (2, 0, 0), (0, 2, 0), (0, 0, 2)]
	>>> tetrahedron = talik.solids.closedSurface((corners, [(0, 2, 1), (0, 1, 3), (1, 2, 3), (0, 3, 2)]))
	>>> added = talik.geometry.fill(MpmEngine(gridSpacing=0.5), tetrahedron)"""
	if isinstance(surface, (str, os.PathLike)):
		name = f"'{os.fspath(surface)}'"
		vertices, triangles = _readSurface(os.fspath(surface))
	elif hasattr(surface, "faces"):
		name, (vertices, triangles) = "the surface", _fromGts(surface)
	else:
		name, (vertices, triangles) = "the surface", surface
	vertices, triangles = np.array(vertices, dtype=float), np.array(triangles, dtype=int)
	if vertices.ndim != 2 or vertices.shape[1:] != (3,) or triangles.ndim != 2 or triangles.shape[1:] != (3,) or not len(triangles):
		raise ValueError(f"{name} has no triangles; give vertices (n, 3) and triangles (m, 3)")
	if not np.isfinite(vertices).all():
		raise ValueError(f"{name} has a vertex that is not finite; all coordinates must be numbers in m")
	if triangles.min() < 0 or triangles.max() >= len(vertices):
		raise ValueError(f"{name} has a triangle with vertex {triangles.max()} of {len(vertices)}; vertices count from 0")
	return _Surface(*_merged(vertices, triangles), name)


def _readSurface(path):
	kind = os.path.splitext(path)[1].lower()
	if not os.path.isfile(path):
		raise ValueError(f"there is no file '{path}'")
	if kind == ".gts":
		import gts

		with open(path) as file:
			return _fromGts(gts.read(file))
	from vtkmodules.util.numpy_support import vtk_to_numpy
	from vtkmodules.vtkFiltersCore import vtkTriangleFilter
	from vtkmodules.vtkIOGeometry import vtkOBJReader, vtkSTLReader
	from vtkmodules.vtkIOPLY import vtkPLYReader

	readers = {".stl": vtkSTLReader, ".obj": vtkOBJReader, ".ply": vtkPLYReader}
	if kind not in readers:
		raise ValueError(f"'{path}' is no surface that can be read; give a file .stl, .gts, .obj or .ply")
	reader, triangles = readers[kind](), vtkTriangleFilter()
	reader.SetFileName(path)
	triangles.SetInputConnection(reader.GetOutputPort())
	triangles.Update()
	mesh = triangles.GetOutput()
	if mesh.GetNumberOfPolys() == 0:
		raise ValueError(f"'{path}' holds no triangles; is it a {kind[1:].upper()} file?")
	return vtk_to_numpy(mesh.GetPoints().GetData()), vtk_to_numpy(mesh.GetPolys().GetData()).reshape(-1, 4)[:, 1:]


def _fromGts(surface):
	vertices = np.array([vertex.coords() for face in surface.faces() for vertex in face.vertices()])
	return vertices, np.arange(len(vertices)).reshape(-1, 3)


def _merged(vertices, triangles):
	"""One vertex per place, give or take 1e-7 of the size; triangles without area left out."""
	grain = 1e-7 * max(np.ptp(vertices, axis=0).max(), 1e-300)
	_, first, number = np.unique(np.round(vertices / grain), axis=0, return_index=True, return_inverse=True)
	triangles = number.ravel()[triangles]
	whole = (triangles[:, 0] != triangles[:, 1]) & (triangles[:, 1] != triangles[:, 2]) & (triangles[:, 2] != triangles[:, 0])
	return vertices[first], triangles[whole]


def _refuseHoles(vertices, triangles, name):
	edges = np.sort(np.vstack([triangles[:, [0, 1]], triangles[:, [1, 2]], triangles[:, [2, 0]]]), axis=1)
	unique, counts = np.unique(edges, axis=0, return_counts=True)
	open_ = unique[counts % 2 == 1]
	if len(open_):
		raise ValueError(f"{name} is not closed: {len(open_)} edges have no neighbour, the first at {_text(vertices[open_[0]].mean(axis=0))} m; close the mesh")


def _crossings(corners, x, y):
	"""Where vertical lines at x, y (n,) on a lattice cross triangles (m, 3, 3): (number of the line, height)."""
	xs, ys = np.unique(x), np.unique(y)
	lines, heights = [], []
	for a, b, c in corners:
		i = np.arange(*np.searchsorted(xs, [min(a[0], b[0], c[0]), max(a[0], b[0], c[0])]))
		j = np.arange(*np.searchsorted(ys, [min(a[1], b[1], c[1]), max(a[1], b[1], c[1])]))
		area = (b[0] - a[0]) * (c[1] - a[1]) - (b[1] - a[1]) * (c[0] - a[0])
		if not len(i) or not len(j) or area == 0:
			continue
		px, py = xs[i][:, None] - a[0], ys[j][None, :] - a[1]
		u = (px * (c[1] - a[1]) - py * (c[0] - a[0])) / area
		v = (py * (b[0] - a[0]) - px * (b[1] - a[1])) / area
		k, m = np.nonzero((u >= 0) & (v >= 0) & (u + v <= 1))
		lines.append(i[k] * len(ys) + j[m])
		heights.append(a[2] + u[k, m] * (b[2] - a[2]) + v[k, m] * (c[2] - a[2]))
	return (np.concatenate(lines), np.concatenate(heights)) if lines else (np.zeros(0, int), np.zeros(0))


# --- terrain ---------------------------------------------------------------------------------------------------------------


class Heights:
	"""Heights on a regular grid, linear in x and in y between its nodes; nan where there are none.

	x (n,), y (m,)  increasing [m];  z (n, m)  [m]

	>>> talik.solids.Heights([0, 1], [0, 1], [[0, 0], [1, 1]])(np.array([0.25]), np.array([0.5]))
	array([0.25])"""

	def __init__(self, x, y, z):
		self.x, self.y, self.z = (np.array(values, dtype=float) for values in (x, y, z))
		for name, values in (("x", self.x), ("y", self.y)):
			if values.ndim != 1 or len(values) < 2 or not (np.diff(values) > 0).all():
				raise ValueError(f"{name} of the heights must be two or more increasing numbers in m")
		if self.z.shape != (len(self.x), len(self.y)):
			raise ValueError(f"z of the heights has shape {self.z.shape}; it must be ({len(self.x)}, {len(self.y)}), a row for each x")

	def __call__(self, x, y):
		i, s = _place(self.x, x)
		j, t = _place(self.y, y)
		z = self.z
		known = (s >= -1e-9) & (s <= 1 + 1e-9) & (t >= -1e-9) & (t <= 1 + 1e-9)
		s, t = np.clip(s, 0, 1), np.clip(t, 0, 1)
		height = (1 - s) * ((1 - t) * z[i, j] + t * z[i, j + 1]) + s * ((1 - t) * z[i + 1, j] + t * z[i + 1, j + 1])
		return np.where(known, height, np.nan)


def _place(nodes, values):
	k = np.clip(np.searchsorted(nodes, values, side="right") - 1, 0, len(nodes) - 2)
	return k, (values - nodes[k]) / (nodes[k + 1] - nodes[k])


def readHeights(path):
	"""Heights of a file [m]; each is that of the middle of its cell.

	.asc         ESRI ASCII grid: ncols, nrows, xllcorner or xllcenter, yllcorner or yllcenter, cellsize, NODATA_value, then the rows from
				 north to south
	.tif, .tiff  GeoTIFF: the first band, columns to the east and rows to the south or the north; its coordinates must be metres

	>>> lines = ["ncols 3", "nrows 2", "xllcorner 0", "yllcorner 0", "cellsize 1", "4 4 5", "1 2 3"]
	>>> size = open(folder + "/hill.asc", "w").write(chr(10).join(lines))
	>>> talik.solids.readHeights(folder + "/hill.asc").z[0]
	array([1., 4.])"""
	if not os.path.isfile(path):
		raise ValueError(f"there is no file '{os.fspath(path)}' of heights")
	if os.path.splitext(os.fspath(path))[1].lower() in (".tif", ".tiff"):
		return _readGeoTiff(os.fspath(path))
	return _readAsciiGrid(path)


def _readAsciiGrid(path):
	header, numbers = {}, []
	try:
		with open(path) as file:
			for line in file:
				words = line.split()
				if len(words) == 2 and not _isNumber(words[0]):
					header[words[0].lower()] = float(words[1])
				else:
					numbers += [float(word) for word in words]
		columns, rows, cell = int(header["ncols"]), int(header["nrows"]), header["cellsize"]
		corner = [header[f"{axis}llcenter"] if f"{axis}llcenter" in header else header[f"{axis}llcorner"] + 0.5 * cell for axis in "xy"]
	except (ValueError, KeyError, UnicodeDecodeError) as problem:
		raise ValueError(f"'{path}' is no ESRI ASCII grid ({problem}); it begins with ncols, nrows, xllcorner, yllcorner and cellsize") from None
	if len(numbers) != columns * rows:
		raise ValueError(f"'{path}' has {len(numbers)} heights where its {columns} columns and {rows} rows make {columns * rows}; is it cut off?")
	z = np.array(numbers).reshape(rows, columns)[::-1].T
	z[z == header.get("nodata_value", -9999.0)] = np.nan
	return Heights(corner[0] + cell * np.arange(columns), corner[1] + cell * np.arange(rows), z)


def _readGeoTiff(path):
	import rasterio

	try:
		with rasterio.open(path) as raster:
			heights, place, system = raster.read(1, masked=True), raster.transform, raster.crs
	except (rasterio.errors.RasterioError, OSError) as problem:
		raise ValueError(f"'{path}' is no GeoTIFF that can be read ({problem})") from None
	if system is not None and not (system.is_projected and abs(system.linear_units_factor[1] - 1) < 1e-9):
		raise ValueError(f"'{path}' has coordinates of {system}, which are not metres; project it first, e.g. gdalwarp -t_srs EPSG:25832")
	if place.is_identity or place.b or place.d or not place.a > 0:
		raise ValueError(f"'{path}' does not say where its columns and rows lie, or they are turned; write it with columns to the east and rows to the south")
	z = np.where(np.ma.getmaskarray(heights), np.nan, heights.data.astype(float)).T
	x, y = place.c + place.a * (np.arange(z.shape[0]) + 0.5), place.f + place.e * (np.arange(z.shape[1]) + 0.5)
	return Heights(x, y, z) if place.e > 0 else Heights(x, y[::-1], z[:, ::-1])


def _isNumber(word):
	try:
		float(word)
	except ValueError:
		return False
	return True


class Terrain(_Lined):
	"""Ground between a base and a surface; see terrain().

	>>> talik.solids.terrain(lambda x, y: 2 + 0 * x, base=0, lower=(0, 0), upper=(1, 1)).depth(0.5, 0.5, 1.5)
	0.5"""

	def __init__(self, surface, base, lower, upper):
		self.surface, self.base = _asHeights(surface, "surface"), _asHeights(base, "base")
		limits = [[-math.inf, -math.inf], [math.inf, math.inf]]
		for heights in (surface, base):
			if isinstance(heights, Heights):
				limits[0] = [max(limits[0][a], (heights.x, heights.y)[a][0]) for a in (0, 1)]
				limits[1] = [min(limits[1][a], (heights.x, heights.y)[a][-1]) for a in (0, 1)]
		lower = [limits[0][a] if lower is None else float(lower[a]) for a in (0, 1)]
		upper = [limits[1][a] if upper is None else float(upper[a]) for a in (0, 1)]
		if not np.isfinite(lower + upper).all():
			raise ValueError("terrain has no end: give lower=(x, y) and upper=(x, y) where surface and base are functions or numbers")
		if not (lower[0] < upper[0] and lower[1] < upper[1]):
			raise ValueError(f"terrain has no ground between ({lower[0]:g}, {lower[1]:g}) and ({upper[0]:g}, {upper[1]:g}) m: lower must be less than upper")
		for a, axis in enumerate("xy"):
			if lower[a] < limits[0][a] - 1e-9 or upper[a] > limits[1][a] + 1e-9:
				raise ValueError(
					f"terrain is wanted from {axis} = {lower[a]:g} to {upper[a]:g} m and its heights reach from {limits[0][a]:g} to {limits[1][a]:g} m; "
					"take less of it or give more heights"
				)
		self._sides = np.array(lower), np.array(upper)
		x, y = (np.unique(np.concatenate([np.linspace(lower[a], upper[a], 200), self._nodes(surface, a)])) for a in (0, 1))
		low, high = (heights(*(grid.ravel() for grid in np.meshgrid(x, y, indexing="ij"))) for heights in (self.base, self.surface))
		ground = high > low
		if not ground.any():
			raise ValueError("terrain has no ground: its surface lies nowhere above its base, or has no heights there")
		self.lower, self.upper = np.array([*lower, low[ground].min()]), np.array([*upper, high[ground].max()])

	def _nodes(self, surface, a):
		nodes = (surface.x, surface.y)[a] if isinstance(surface, Heights) else np.zeros(0)
		return nodes[(nodes >= self._sides[0][a]) & (nodes <= self._sides[1][a])]

	def spans(self, x, y):
		"""Where vertical lines at x, y (n,) lie inside: (number of the line, lower z, upper z), each (m,) [m]."""
		inside = (x >= self._sides[0][0]) & (x <= self._sides[1][0]) & (y >= self._sides[0][1]) & (y <= self._sides[1][1])
		low, high = self.base(x, y), self.surface(x, y)
		line = np.flatnonzero(inside & (high > low))
		return line, low[line], high[line]

	def depth(self, x, y, z):
		"""Depth below the surface [m] of places x, y, z [m]."""
		depth = self.surface(*np.broadcast_arrays(np.asarray(x, dtype=float), np.asarray(y, dtype=float))) - z
		return depth if np.ndim(depth) else float(depth)

	def layers(self, depths, values):
		"""A function f(x, y, z) for talik.geometry.fill: values[0] down to depths[0] [m] below the surface, values[1] down to depths[1], …;
		one value more than depths.

		>>> hill = talik.solids.terrain(lambda x, y: 3 + 0.1 * x, base=0, lower=(0, 0), upper=(4, 2))
		>>> added = talik.geometry.fill(MpmEngine(gridSpacing=0.5), hill, temperature=hill.layers([1.0], [2.0, -1.0]))"""
		depths, values = np.array(depths, dtype=float), np.array(values)
		if depths.ndim != 1 or len(values) != len(depths) + 1 or not (np.diff(depths) > 0).all():
			raise ValueError(f"layers: {len(values)} values for {depths.size} depths; give increasing depths and one value more")
		return lambda x, y, z: values[np.searchsorted(depths, self.depth(x, y, z), side="left")]


def terrain(surface, base, lower=None, upper=None):
	"""Ground between a base and a surface.

	surface, base  Heights (see readHeights), a function f(x, y) of arrays (n,) that returns such an array, or a number [m]
	lower, upper   corners (x, y) [m] of the part that is filled; default: all that the heights have

	Nothing is filled where heights are missing or the surface lies below the base.

	>>> hill = talik.solids.terrain(lambda x, y: 2 + np.sin(x), base=0, lower=(0, 0), upper=(4, 2))
	>>> added = talik.geometry.fill(MpmEngine(gridSpacing=0.5), hill)"""
	return Terrain(surface, base, lower, upper)


def _asHeights(heights, name):
	if callable(heights):
		return lambda x, y: np.broadcast_to(np.asarray(heights(x, y), dtype=float), np.shape(x))
	value = _number(heights, name)
	return lambda x, y: np.full(np.shape(x), value)


# --- common ----------------------------------------------------------------------------------------------------------------


def _piecesOfInterval(low, high, side, origin):
	"""Middles and lengths of the parts of an interval in the lattice; short ends join their neighbour."""
	first, last = math.floor((low - origin) / side + 1e-9), math.ceil((high - origin) / side - 1e-9)
	ends = np.clip(origin + np.arange(first, last + 1) * side, low, high)
	ends[0], ends[-1] = low, high
	if len(ends) > 2 and ends[1] - ends[0] < smallestPart * side:
		ends = np.delete(ends, 1)
	if len(ends) > 2 and ends[-1] - ends[-2] < smallestPart * side:
		ends = np.delete(ends, -2)
	return 0.5 * (ends[1:] + ends[:-1]), np.diff(ends)


def _ordered(position, volume, side):
	"""Small parts joined to the nearest point, with volume and first moment kept; by z, y and x."""
	small = volume < smallestPart * side**3
	if small.any() and not small.all():
		from scipy.spatial import cKDTree

		target = cKDTree(position[~small]).query(position[small])[1]
		kept, moment = volume[~small].copy(), position[~small] * volume[~small][:, None]
		np.add.at(kept, target, volume[small])
		np.add.at(moment, target, position[small] * volume[small][:, None])
		joined = np.unique(target)
		whole = position[~small].copy()
		whole[joined] = moment[joined] / kept[joined][:, None]
		position, volume = whole, kept
	order = np.lexsort(np.round(position / side, 6).T)
	return position[order], volume[order]


def _number(value, name):
	if not (np.isscalar(value) and not isinstance(value, str) and math.isfinite(value)):
		raise ValueError(f"{name} is {value!r}; it must be a number in m")
	return float(value)


def _corner(values, name):
	try:
		corner = np.array([float(value) for value in values])
	except (TypeError, ValueError):
		corner = np.zeros(0)
	if corner.shape != (3,) or not np.isfinite(corner).all():
		raise ValueError(f"{name} is {values!r}; it must be a corner (x, y, z) in m")
	return corner


def _text(corner):
	return "(" + ", ".join(f"{value:g}" for value in corner) + ")"
