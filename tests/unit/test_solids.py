# SPDX-License-Identifier: GPL-2.0-or-later
"""Filling of solids in space against closed forms."""

import math
from pathlib import Path

import numpy as np
import pytest

from talik import geometry, solids

slope = [(0, 0), (10, 0), (10, 1), (6, 1), (3, 4), (0, 4)]


class Ground:
	"""What fill() asks of an engine."""

	dimension, gridSpacing, pointCount = 0, 0.5, 0
	lower = upper = gravity = (math.nan, math.nan)

	def __init__(self, **settings):
		vars(self).update(settings)

	def addPoints(self, **arrays):
		vars(self).update(arrays)
		self.pointCount += len(arrays["volume"])


def filled(solid, **settings):
	ground = Ground(**settings)
	geometry.fill(ground, solid)
	return ground.position, ground.volume


def sphere(radius, around=32):
	"""Vertices and triangles of a ball of given radius about (1, 2, 3), by longitude and latitude."""
	angle, height = np.arange(2 * around) * math.pi / around, np.arange(1, around) * math.pi / around
	rings = [(math.sin(t) * math.cos(a), math.sin(t) * math.sin(a), math.cos(t)) for t in height for a in angle]
	corners = np.array(rings + [(0, 0, 1), (0, 0, -1)]) * radius + (1, 2, 3)
	n, last = 2 * around, (around - 2) * 2 * around
	triangles = []
	for k in range(n):
		m = (k + 1) % n
		triangles += [(n * (around - 1), k, m), (n * (around - 1) + 1, last + m, last + k)]
		for ring in range(0, last, n):
			triangles += [(ring + k, ring + n + k, ring + n + m), (ring + k, ring + n + m, ring + m)]
	return corners, np.array(triangles)


def volumeOf(corners, triangles):
	a, b, c = (corners[triangles[:, k]] for k in range(3))
	return abs(np.einsum("ij,ij->i", a, np.cross(b, c)).sum()) / 6


@pytest.mark.parametrize("gridSpacing", [0.5, 0.2, 0.13])
def test_volume_and_first_moment_of_an_extruded_outline_are_its_own(gridSpacing):
	position, volume = filled(solids.extruded(slope, 0.3, 2.0), gridSpacing=gridSpacing)
	area, centroid = geometry.polygonArea(slope)
	volumeError = abs(volume.sum() / (1.7 * area) - 1)
	momentError = np.abs(volume @ position / volume.sum() - [centroid[0], 1.15, centroid[1]]).max()
	print(f"h = {gridSpacing} m: {len(volume)} points, volume error {volumeError:.1e}, centroid off by {momentError:.1e} m")
	assert volumeError < 1e-12 and momentError < 1e-11


def test_a_box_on_the_grid_is_filled_with_cubes():
	position, volume = filled(solids.box((0, 0, 0), (2, 1, 1.5)))
	print(f"{len(volume)} points of {volume.min()} to {volume.max()} m3")
	assert len(volume) == 4 * 2 * 3 * 8 and np.ptp(volume) < 1e-15
	np.testing.assert_allclose(np.unique(position[:, 1]), [0.125, 0.375, 0.625, 0.875], rtol=1e-13)


@pytest.mark.parametrize("kind", ["stl", "gts", "arrays"])
def test_a_closed_surface_is_filled_with_its_volume(kind, tmp_path):
	corners, triangles = sphere(1.1)
	path = str(tmp_path / f"ball.{kind}")
	if kind == "stl":
		facets = (
			"facet normal 0 0 0\nouter loop\n" + "".join("vertex %.9g %.9g %.9g\n" % tuple(corners[v]) for v in t) + "endloop\nendfacet\n" for t in triangles
		)
		open(path, "w").write("solid ball\n" + "".join(facets) + "endsolid ball\n")
	if kind == "gts":
		pytest.importorskip("gts")
		edges = {}
		faces = [[edges.setdefault((min(a, b), max(a, b)), len(edges) + 1) for a, b in ((t[0], t[1]), (t[1], t[2]), (t[2], t[0]))] for t in triangles]
		lines = [f"{len(corners)} {len(edges)} {len(faces)} GtsSurface GtsFace GtsEdge GtsVertex"]
		lines += ["%.12g %.12g %.12g" % tuple(corner) for corner in corners] + [f"{a + 1} {b + 1}" for a, b in edges]
		open(path, "w").write("\n".join(lines + ["%d %d %d" % tuple(face) for face in faces]) + "\n")
	position, volume = filled(solids.closedSurface((corners, triangles) if kind == "arrays" else path), gridSpacing=0.2)
	error, off = volume.sum() / volumeOf(corners, triangles) - 1, np.abs(volume @ position / volume.sum() - (1, 2, 3)).max()
	print(f"{kind}: {len(volume)} points, volume error {error:.1e}, centroid off by {off:.1e} m")
	assert abs(error) < 2e-3 and off < 1e-3


def test_a_surface_with_a_hole_is_refused_with_the_place():
	corners, triangles = sphere(1.0)
	with pytest.raises(ValueError, match="is not closed: 3 edges have no neighbour, the first at ") as refusal:
		solids.closedSurface((corners, triangles[1:]))
	print(refusal.value)


def test_terrain_has_the_volume_between_base_and_surface():
	hill = solids.terrain(lambda x, y: 2 + 0.3 * x - 0.2 * y, base=-0.3, lower=(0.1, 0), upper=(4, 3.05))
	position, volume = filled(hill, gridSpacing=0.25)
	exact = 3.9 * 3.05 * (2.3 + 0.3 * 2.05 - 0.2 * 1.525)
	print(f"{len(volume)} points, volume {volume.sum():.4f} m3, exact {exact:.4f} m3; highest point {position[:, 2].max():.3f} m")
	assert abs(volume.sum() / exact - 1) < 5e-3


def test_heights_of_an_ascii_grid_are_read_with_their_places_and_gaps(tmp_path):
	path = tmp_path / "hill.asc"
	path.write_text("ncols 3\nnrows 3\nxllcorner 100\nyllcorner 50\ncellsize 2\nNODATA_value -9999\n7 8 9\n4 5 6\n1 2 -9999\n")
	heights = solids.readHeights(path)
	middle = heights(np.array([102.0, 103.0]), np.array([54.0, 53.0]))
	print(f"x {heights.x}, y {heights.y}; heights at two places {middle}; the gap {heights.z[2, 0]}")
	np.testing.assert_allclose(heights.x, [101, 103, 105])
	np.testing.assert_allclose(middle, [6, 5])
	assert np.isnan(heights.z[2, 0]) and np.isnan(heights(np.array([104.9]), np.array([51.1]))[0])


def geoTiff(path, northUp=True, system="EPSG:25832", place=None):
	"""Six heights on cells of 2 m whose lower left corner is (100, 50), and a gap."""
	rasterio = pytest.importorskip("rasterio")
	z = np.array([[7, 8, 9], [4, 5, 6], [1, 2, -9999]], dtype=np.float32)
	place = place or (rasterio.Affine(2, 0, 100, 0, -2, 56) if northUp else rasterio.Affine(2, 0, 100, 0, 2, 50))
	shape = dict(width=3, height=3, count=1, dtype="float32", nodata=-9999, crs=system, transform=place)
	with rasterio.open(path, "w", driver="GTiff", **shape) as file:
		file.write(z if northUp else z[::-1], 1)
	return path


@pytest.mark.parametrize("northUp", [True, False], ids=["rows to the south", "rows to the north"])
def test_heights_of_a_geotiff_are_those_of_the_same_ascii_grid(northUp, tmp_path):
	path = tmp_path / "hill.asc"
	path.write_text("ncols 3\nnrows 3\nxllcorner 100\nyllcorner 50\ncellsize 2\nNODATA_value -9999\n7 8 9\n4 5 6\n1 2 -9999\n")
	ascii, tiff = solids.readHeights(path), solids.readHeights(geoTiff(tmp_path / "hill.tif", northUp))
	print(f"x {tiff.x}, y {tiff.y}, the gap {tiff.z[2, 0]}")
	for name in ("x", "y", "z"):
		np.testing.assert_array_equal(getattr(tiff, name), getattr(ascii, name))


def test_a_geotiff_that_is_none_or_not_in_metres_or_turned_is_refused_with_a_sentence(tmp_path):
	import rasterio

	(tmp_path / "text.tif").write_text("no picture")
	degrees, turned = tmp_path / "degrees.tif", tmp_path / "turned.tif"
	geoTiff(degrees, system="EPSG:4326")
	geoTiff(turned, place=rasterio.Affine(2, 1, 100, 1, -2, 56))
	for path, message in (
		(tmp_path / "text.tif", "is no GeoTIFF that can be read"),
		(tmp_path / "nowhere.tif", "there is no file"),
		(degrees, "has coordinates of EPSG:4326, which are not metres"),
		(turned, "or they are turned"),
	):
		with pytest.raises(ValueError, match=message) as refusal:
			solids.readHeights(path)
		print(refusal.value)


def test_the_heights_of_thaw_slump_bowl_are_those_of_its_formula(monkeypatch):
	example = Path(__file__).parents[2] / "examples" / "thawbowl"
	monkeypatch.syspath_prepend(str(example))
	import hillside

	heights = solids.readHeights(example / "hillside.asc")
	off = np.abs(heights.z - hillside.height(*np.meshgrid(heights.x, heights.y, indexing="ij"))).max()
	print(f"{heights.z.shape} heights of {heights.z.min()} to {heights.z.max()} m, at most {off:.4f} m off the formula")
	assert off <= 0.005 + 1e-9 and (example / "hillside.asc").read_text().splitlines() == list(hillside.lines())


def test_depth_below_an_extruded_outline_and_terrain_is_that_below_their_surface():
	x, y, z = np.array([1.0, 4.5, 8.0]), np.array([0.5, 0.5, 0.5]), np.array([1.0, 2.0, 0.25])
	outline, hill = solids.extruded(slope, 0, 1), solids.terrain(lambda x, y: np.interp(x, [0, 3, 6, 10], [4, 4, 1, 1]), 0.0, (0, 0), (10, 1))
	print(outline.depth(x, y, z), hill.depth(x, y, z))
	np.testing.assert_allclose(outline.depth(x, y, z), [3.0, 0.5, 0.75], atol=1e-12)
	np.testing.assert_allclose(hill.depth(x, y, z), [3.0, 0.5, 0.75], atol=1e-12)
	with pytest.raises(ValueError, match="describe the ground by talik.solids.terrain"):
		solids.closedSurface(sphere(1.0)).depth(0, 0, 0)


def test_layers_of_terrain_go_by_the_depth_below_its_surface():
	hill = solids.terrain(lambda x, y: 3 + 0.1 * x, base=0, lower=(0, 0), upper=(4, 2))
	value = hill.layers([0.5, 1.0], [1, 2, 3])(np.zeros(3), np.zeros(3), np.array([2.9, 2.2, 1.0]))
	print(f"0.1, 0.8 and 2 m deep: {value}")
	assert list(value) == [1, 2, 3]


@pytest.mark.parametrize(
	"what, message",
	{
		"a solid that leaves the box": (
			lambda: filled(solids.box((0, 0, 0), (1, 1, 4)), lower=(0, 0, 0), upper=(1, 1, 3)),
			"reaches to z = 4 m, outside of the grid's box",
		),
		"a polygon in space": (lambda: filled(slope, gravity=(0, 0, -9.81)), "the ground is in space by MpmEngine.gravity"),
		"a solid in the plane": (lambda: filled(solids.box((0, 0, 0), (1, 1, 1)), dimension=2), "MpmEngine.dimension is 2"),
		"a box inside out": (lambda: solids.box((0, 0, 0), (1, -1, 1)), "each coordinate of lower must be less"),
		"terrain below its base": (lambda: solids.terrain(1.0, 2.0, (0, 0), (1, 1)), "lies nowhere above its base"),
		"terrain beside its heights": (lambda: solids.terrain(solids.Heights([0, 1], [0, 1], [[1, 1], [1, 1]]), 0.0, upper=(2, 1)), "reach from 0 to 1 m"),
		"terrain without end": (lambda: solids.terrain(1.0, 0.0), "terrain has no end"),
		"a file that is not there": (lambda: solids.closedSurface("nowhere.stl"), "there is no file 'nowhere.stl'"),
		"points that no cube makes": (lambda: geometry.fill(Ground(), solids.box((0, 0, 0), (1, 1, 1)), pointsPerCell=4), "a cubic number"),
	}.values(),
)
def test_is_refused_by_a_sentence(what, message):
	with pytest.raises(ValueError, match=message) as refusal:
		what()
	print(refusal.value)
