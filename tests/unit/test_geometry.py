# SPDX-License-Identifier: GPL-2.0-or-later
"""Filling of outlines against closed forms."""

import numpy as np
import pytest

from talik import geometry

slope = [(0, 0), (10, 0), (10, 1), (6, 1), (3, 4), (0, 4)]


def firstMoment(polygon):
	area, centroid = geometry.polygonArea(polygon)
	return area * centroid


def test_area_and_centroid_of_the_slope_are_those_of_its_rectangles_and_triangle():
	area, centroid = geometry.polygonArea(slope)
	exact = 10 * 1 + 3 * 3 + 0.5 * 3 * 3
	moment = np.array([10 * 5 + 9 * 1.5 + 4.5 * 4, 10 * 0.5 + 9 * 2.5 + 4.5 * 2])
	print(f"area {area} m2, exact {exact}; centroid {centroid}, exact {moment / exact}")
	assert abs(area - exact) < 1e-12
	np.testing.assert_allclose(centroid, moment / exact, rtol=1e-13)


@pytest.mark.parametrize("gridSpacing", [0.5, 0.2, 0.13])
@pytest.mark.parametrize("pointsPerCell", [1, 4, 9])
def test_volumes_and_first_moments_of_the_points_are_those_of_the_outline(gridSpacing, pointsPerCell):
	position, volume = geometry.fillPolygon(slope, gridSpacing, pointsPerCell)
	areaError = abs(volume.sum() - 23.5) / 23.5
	momentError = np.abs(volume @ position - firstMoment(slope)).max() / 23.5
	print(f"h = {gridSpacing} m, {pointsPerCell} per cell: {len(volume)} points, area error {areaError:.1e}, moment error {momentError:.1e}")
	assert areaError < 1e-12 and momentError < 1e-11
	side = gridSpacing / np.sqrt(pointsPerCell)
	assert volume.min() >= geometry.smallestPart * side**2 and volume.max() <= (1 + 2 * geometry.smallestPart) * side**2


def test_the_papers_slope_has_about_2350_points():
	position, volume = geometry.fillPolygon(slope, 0.2, 4)
	print(f"{len(volume)} points")
	assert abs(len(volume) - 2350) < 50


def test_a_rectangle_on_the_grid_is_filled_with_equal_points_at_lattice_places():
	position, volume = geometry.fillPolygon(geometry.rectangle(0, 0, 1, 2), 0.5, 4)
	assert len(volume) == 32
	np.testing.assert_allclose(volume, 0.0625, rtol=1e-14)
	np.testing.assert_allclose(np.unique(position[:, 0].round(12)), [0.125, 0.375, 0.625, 0.875])


def test_concave_and_clockwise_outlines_are_filled_alike():
	corners = [(0, 0), (2, 0), (2, 2), (1, 0.7), (0, 2)]
	forward, backward = geometry.fillPolygon(corners, 0.25, 4), geometry.fillPolygon(corners[::-1], 0.25, 4)
	np.testing.assert_allclose(forward[0], backward[0], atol=1e-13)
	assert abs(forward[1].sum() - geometry.polygonArea(corners)[0]) < 1e-12


def test_an_outline_with_a_cut_to_a_hole_is_filled_around_the_hole():
	outline = [(0, 0), (4, 0), (4, 4), (0, 4), (0, 0), (1, 1), (1, 3), (3, 3), (3, 1), (1, 1)]
	position, volume = geometry.fillPolygon(outline, 0.13, 4)
	inHole = ((position > 1) & (position < 3)).all(axis=1)
	print(f"{volume.sum():.14f} m2 of {16 - 4}, {inHole.sum()} points in the hole")
	assert abs(volume.sum() - 12) < 1e-12 and not inHole.any()


class Recorder:
	gridSpacing, pointCount = 0.5, 0

	def addPoints(self, **arrays):
		self.arrays = arrays
		self.pointCount += len(arrays["volume"])


def test_fill_hands_positions_volumes_and_attributes_to_the_engine():
	engine = Recorder()
	added = geometry.fill(engine, geometry.rectangle(0, 0, 2, 1), pointsPerCell=4, temperature=-5, porosity=lambda x, y: 0.4 + 0.01 * y)
	assert list(added) == list(range(32)) and engine.arrays["position"].shape == (32, 2)
	assert engine.arrays["temperature"] == -5
	np.testing.assert_allclose(engine.arrays["porosity"], 0.4 + 0.01 * engine.arrays["position"][:, 1])


@pytest.mark.parametrize(
	"polygon, message",
	[
		([(0, 0), (1, 1)], "at least three corners"),
		([(0, 0), (1, 1), (2, 2)], "one line"),
		([(0, 0), (1, float("nan")), (2, 2)], "not finite"),
		([(0, 0), (1, 1), (1, 0), (0, 1)], "crosses itself"),
		("slope", "list of corners"),
	],
)
def test_an_outline_that_is_none_is_refused_with_its_fault(polygon, message):
	with pytest.raises(ValueError, match=message):
		geometry.fillPolygon(polygon, 0.1, 4)


@pytest.mark.parametrize(
	"gridSpacing, pointsPerCell, name", [(0, 4, "gridSpacing"), (float("nan"), 4, "gridSpacing"), (0.1, 3, "pointsPerCell"), (0.1, 2.5, "pointsPerCell")]
)
def test_spacing_and_points_per_cell_are_checked(gridSpacing, pointsPerCell, name):
	with pytest.raises(ValueError, match=name):
		geometry.fillPolygon(slope, gridSpacing, pointsPerCell)
