# SPDX-License-Identifier: GPL-2.0-or-later
"""Points become ground: what is drawn covers the area of the points and has their values, however they moved."""

import numpy as np
import pytest
from matplotlib.path import Path

from talik import geometry, plots
from talik.resampling import Resampled, groundOf

slope = [(0, 0), (10, 0), (10, 1), (6, 1), (3, 4), (0, 4)]
allowed = 0.01  # of the area of the points


def block(side=0.25):
	return geometry.fillPolygon([(0, 0), (4, 0), (4, 2), (0, 2)], side, 4)


def moved(position, volume, gradient):
	return Resampled(position @ gradient.T, np.linalg.det(gradient) * volume, np.tile(gradient.ravel(), (len(position), 1)))


def farthest(ground, corners):
	"""Largest distance [m] of the outline from the polygon through corners."""
	ends = np.array(corners + corners[:1], dtype=float)
	along = np.vstack([a + np.linspace(0, 1, 400)[:, None] * (b - a) for a, b in zip(ends, ends[1:])])
	line = np.vstack(ground.outline())
	return max(np.linalg.norm(along - place, axis=1).min() for place in line)


def turned(angle):
	return np.array([[np.cos(angle), -np.sin(angle)], [np.sin(angle), np.cos(angle)]])


@pytest.mark.parametrize(
	"name, gradient",
	[
		("at rest", np.eye(2)),
		("turned by 34 degrees", turned(0.6)),
		("sheared by 4", np.array([[1.0, 4.0], [0.0, 1.0]])),
		("twice as long and half as high", np.diag([2.0, 0.5])),
		("with a quarter more volume, turned and sheared", turned(1.0) @ np.array([[1.25, 0.5], [0.0, 1.0]])),
	],
)
def test_a_slope_that_moved_as_a_whole_is_drawn_where_it_is_over_the_area_of_its_points(name, gradient):
	position, volume = geometry.fillPolygon(slope, 0.25, 4)
	ground = moved(position, volume, gradient)
	area = ground.area() / (np.linalg.det(gradient) * volume.sum()) - 1
	off = farthest(ground, [tuple(gradient @ corner) for corner in slope])
	print(f"{name}: area {100 * area:+.3f} % off that of the points (1 % allowed), outline up to {off:.3f} m from where it is due, points 0.125 m")
	assert abs(area) < allowed
	assert off < 0.0625  # half a point
	assert len(ground.outline()) == 1


def test_a_linear_field_of_a_block_sheared_by_four_is_that_field():
	position, volume = block()
	gradient = np.array([[1.0, 4.0], [0.0, 1.0]])
	ground = moved(position, volume, gradient)
	x, y = np.meshgrid(ground.x, ground.y)
	inside = ground.ground & (y > 0.3) & (y < 1.7) & (x - 4 * y > 0.5) & (x - 4 * y < 3.5)
	error = np.abs(ground(position[:, 1]) - y)[inside].max()
	print(f"height before the shear over {inside.sum()} nodes: off by up to {error:.4f} m, points 0.125 m, field 0 to 2 m")
	assert error < 0.02


def test_needles_of_accumulated_strain_do_not_reach_out_of_the_ground():
	position, volume = block()
	needles = np.tile(np.diag([30.0, 1 / 30]).ravel(), (len(position), 1))
	ground = Resampled(position, volume, needles)
	beyond = np.vstack(ground.outline())[:, 0].max() - 4
	print(f"points stretched by 30: outline {beyond:+.3f} m beyond the ground, points 0.125 m wide; area {ground.area():.3f} of {volume.sum():.3f} m2")
	assert abs(beyond) < 0.07 and abs(ground.area() / volume.sum() - 1) < allowed


def test_a_hole_and_free_fragments_stay_and_gaps_between_points_are_closed():
	position, volume = block()
	hole = np.hypot(*(position - [2, 1]).T) < 0.5
	gap = np.hypot(*(position - [3.3, 0.7]).T) < 0.1  # two rows of points lack one
	kept = ~hole & ~gap
	fragments = np.array([[5.0, 1.0], [5.5, 1.0], [5.625, 1.0]])
	ground = Resampled(np.vstack([position[kept], fragments]), np.append(volume[kept], 3 * [volume[0]]))
	pieces = [0.5 * abs(np.dot(line[:-1, 0], line[1:, 1]) - np.dot(line[1:, 0], line[:-1, 1])) for line in ground.outline()]
	total = volume[kept].sum() + 3 * volume[0]
	print(f"lines around {np.round(sorted(pieces), 4)} m2: one point and two of {volume[0]:.4f} m2, a hole of {volume[hole].sum():.3f} m2, the block")
	assert gap.sum() >= 1 and len(pieces) == 4
	one, two, holeDrawn, _ = sorted(pieces)
	assert one == pytest.approx(volume[0], rel=0.02) and two == pytest.approx(2 * volume[0], rel=0.02)
	assert holeDrawn == pytest.approx(volume[hole].sum(), rel=0.1)
	assert ground.area() == pytest.approx(total, rel=allowed)


def test_ground_of_points_of_two_sizes_and_out_of_order_covers_their_area():
	coarse, coarseVolume = geometry.fillPolygon([(0, 0), (2, 0), (2, 2), (0, 2)], 0.5, 4)
	fine, fineVolume = geometry.fillPolygon([(2, 0), (4, 0), (4, 2), (2, 2)], 0.125, 4)
	position, volume = np.vstack([coarse, fine]), np.append(coarseVolume, fineVolume)
	position = position + np.random.default_rng(1).normal(size=position.shape) * 0.1 * np.sqrt(volume)[:, None]
	ground = Resampled(position, volume)
	print(f"sides {np.sqrt(coarseVolume[0]):.3f} and {np.sqrt(fineVolume[0]):.4f} m: {ground.area():.4f} of {volume.sum():.4f} m2 drawn, 1 % allowed")
	assert ground.area() == pytest.approx(volume.sum(), rel=allowed) and len(ground.outline()) == 1


def test_triangles_of_the_surface_cover_the_area_and_face_one_way():
	position, volume = geometry.fillPolygon(slope, 0.25, 4)
	ground = Resampled(position, volume, nodesPerSide=2)
	points, triangles, nodes, weights = ground.triangles()
	(ax, ay), (bx, by), (cx, cy) = (points[triangles[:, k]].T for k in range(3))
	areas = 0.5 * ((bx - ax) * (cy - ay) - (by - ay) * (cx - ax))
	print(f"{len(triangles)} triangles, {areas.sum():.4f} of {volume.sum():.4f} m2, smallest {areas.min():.1e} m2")
	assert areas.min() >= -1e-15 and areas.sum() == pytest.approx(volume.sum(), rel=allowed)
	x = np.tile(ground.x, ground.y.size)
	assert (weights * x[nodes]).sum(axis=1) == pytest.approx(points[:, 0], abs=1e-12)


def test_the_ground_in_a_picture_covers_the_area_of_its_points():
	position, volume = geometry.fillPolygon(slope, 0.25, 4)
	frame = dict(position=position, volume=volume, iceSaturation=np.clip(position[:, 1], 0, 1))
	fig = plots.figure(8, 4)
	axes = plots.ground(fig.subplots(), frame, "iceSaturation", bar=False, front=False)
	clip = axes.collections[0].get_clip_path()
	outline = clip.get_fully_transformed_path().transformed(axes.transData.inverted()) if hasattr(clip, "get_fully_transformed_path") else clip
	x, y = np.meshgrid(np.arange(0.01, 10.2, 0.02), np.arange(0.01, 4.2, 0.02))
	drawn = outline.contains_points(np.column_stack([x.ravel(), y.ravel()])).sum() * 0.02**2
	print(f"{drawn:.3f} m2 within the outline at which bands are cut, points {volume.sum():.3f} m2, 1 % allowed")
	assert drawn == pytest.approx(volume.sum(), rel=allowed)


def test_ground_does_not_reach_through_a_wall_that_uneven_points_lie_at():
	position, volume = block()
	uneven = position + np.column_stack([0 * volume, np.where(position[:, 1] < 0.1, 0.05 * np.sin(7 * position[:, 0]), 0)])
	lowest = [
		min(line[:, 1].min() for line in ground.outline())
		for ground in (Resampled(uneven, volume), groundOf(dict(position=uneven, volume=volume, displacement=uneven - position)))
	]
	print(f"lowest place of the outline {lowest[0]:.3f} m from the points alone, {lowest[1]:.3f} m where their displacement tells of the wall at 0")
	assert lowest[0] < -0.01 and lowest[1] == 0


def test_ground_that_left_a_straight_side_or_passed_it_is_drawn_where_it_is():
	position, volume = block()
	for shift in ((1.0, 0.0), (-0.7, 0.0), (0.03, 0.0)):
		ground = groundOf(dict(position=position + shift, volume=volume, displacement=np.tile(shift, (len(volume), 1))))
		ends = np.vstack(ground.outline())[:, 0].min(), np.vstack(ground.outline())[:, 0].max()
		print(f"moved by {shift[0]} m: from x = {ends[0]:.3f} to {ends[1]:.3f} m, area {ground.area():.4f} of {volume.sum():.4f} m2")
		assert ends == pytest.approx((shift[0], 4 + shift[0]), abs=0.01) and ground.area() == pytest.approx(volume.sum(), rel=allowed)


def test_points_without_a_value_leave_the_field_to_their_neighbours():
	position, volume = block()
	values = np.where(position[:, 0] < 2, 3.0, np.nan)
	field = Resampled(position, volume)(values)
	print(f"{np.isfinite(field).sum()} nodes with a value, all {np.nanmin(field)} to {np.nanmax(field)}")
	assert np.nanmax(np.abs(field - 3)) < 1e-9 and np.isnan(field).any()


@pytest.mark.parametrize(
	"position, sentence", [(np.zeros((3, 3)), "talik.output.ParaViewSeries shows ground in space"), (np.zeros((0, 2)), "at least one point")]
)
def test_what_is_no_ground_in_the_plane_is_refused_by_a_sentence(position, sentence):
	with pytest.raises(ValueError, match=sentence):
		Resampled(position, np.ones(len(position)))


def test_the_path_of_the_outline_is_one_of_matplotlib():
	position, volume = block(0.5)
	path = Path(*Resampled(position, volume).polygons())
	assert path.contains_point((2, 1)) and not path.contains_point((4.5, 1))
