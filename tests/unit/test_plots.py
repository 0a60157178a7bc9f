# SPDX-License-Identifier: GPL-2.0-or-later
"""Pictures from synthetic data: what is drawn is what was given. The pictures are left in the folder TALIK_PICTURES, if set."""

import os

import numpy as np
import pytest
from matplotlib.image import imread

from talik import geometry, plots

slope = [(0, 0), (10, 0), (10, 1), (6, 1), (3, 4), (0, 4)]


@pytest.fixture
def folder(tmp_path):
	return os.environ.get("TALIK_PICTURES", str(tmp_path))


def thawingSlope(time):
	"""A front that goes in from the surface as 0.293 sqrt(t) and a slide above a circle."""
	position, volume = geometry.fillPolygon(slope, 0.2, 4)
	x, y = position.T
	depth = np.minimum(4 - y, np.where(x > 6, 1 - y, (7 - x - y) / np.sqrt(2)))
	front = 0.293 * np.sqrt(time)
	ice = 1 / (1 + np.exp(-(depth - front) / 0.05))
	band = np.exp(-(((np.hypot(x - 6.5, y - 5) - 3.9) / 0.15) ** 2)) * np.clip(time / 15, 0, 1)
	slide = np.where((np.hypot(x - 6.5, y - 5) < 3.9)[:, None], 1.0, 0.05) * np.array([0.5, -0.4]) * time / 15
	return dict(time=time, position=position + slide, volume=volume, iceSaturation=ice, deviatoricStrain=0.3 * band, displacement=slide)


def randomPacking(count=120, seed=3):
	random = np.random.default_rng(seed)
	centre = random.uniform(0, 0.1, (count, 2))
	radius = random.uniform(3e-3, 7e-3, count)
	pairs = np.array([(i, j) for i in range(count) for j in range(i) if np.hypot(*(centre[i] - centre[j])) < radius[i] + radius[j]])
	force = random.exponential(20, len(pairs))
	state = random.integers(0, 3, len(pairs))
	return centre, radius, centre[pairs[:, 0]], centre[pairs[:, 1]], force, state


def bandColours(axes):
	"""Of all bands of contourf, whether there is a collection of each or one of all."""
	filled = [c for c in axes.collections if c.get_clip_path() is not None and len(c.get_facecolor()) and not len(c.get_linestyle()[0][1] or ())]
	return np.array([colour for c in filled for colour in c.get_facecolor()])


def test_slope_history_has_a_row_per_time_a_column_per_field_and_one_scale_per_column(folder):
	frames = [{**thawingSlope(time), "day": 10 * time} for time in (2.5, 5, 10, 15)]
	fig = plots.slopeHistory(frames, watched={"A": (3.0, 2.0), "B": (4.6, 2.2)})
	path = plots.save(fig, os.path.join(folder, "slope-history.png"))
	panels = [axes for axes in fig.axes if axes.get_label() != "<colorbar>"]
	assert len(panels) == 4 * 3
	assert [axes.get_title(loc="left") for axes in panels[::3]] == [f"day {10 * t:g} ({t:g} s of motion)" for t in (2.5, 5, 10, 15)]
	for column in range(3):
		colours = [bandColours(axes) for axes in panels[column::3]]
		print(f"column {column}: {len(colours[0])} bands")
		assert len(colours[0]) >= 5 and all(np.array_equal(colours[0], other) for other in colours)
	labels = [axes.get_xlabel() for axes in fig.axes if axes.get_label() == "<colorbar>"]
	print("colour bars:", labels)
	assert all("[" in label for label in labels)
	assert imread(path).std() > 0.05


def test_squares_strained_with_the_ground_leave_no_gaps_where_it_sheared_and_shrank():
	gradient = np.array([[0.9, 1.2], [-0.1, 0.8]])
	position, volume = geometry.fillPolygon([(0, 0), (2, 0), (2, 2), (0, 2)], 0.5, 4)
	drawn = plots.slopeField(
		plots.figure(4, 3).subplots(),
		position @ gradient.T,
		np.zeros(len(position)),
		np.linalg.det(gradient) * volume,
		deformation=np.tile(gradient.ravel(), (len(position), 1)),
	)
	corners = np.vstack([path.vertices[:4] for path in drawn.collections[0].get_paths()]) @ np.linalg.inv(gradient).T
	places, shared = np.unique(np.rint(corners / 0.25), axis=0, return_counts=True)
	print(f"{len(position)} points; corners off the grid that sheared with them {np.abs(corners / 0.25 - np.rint(corners / 0.25)).max():.1e} of a square")
	assert len(places) == 9 * 9 and sorted(shared)[-49:] == [4] * 49
	assert corners / 0.25 == pytest.approx(np.rint(corners / 0.25), abs=1e-9)


def test_thawed_ground_is_brown_frozen_ground_blue_and_none_is_white_as_the_air(folder):
	frame = {**thawingSlope(10), "day": 100}
	fig = plots.figure(8, 4)
	axes = plots.ground(fig.subplots(), frame, "iceSaturation", arrows="displacement", watched={"A": (3.0, 2.0)})
	pixels = imread(plots.save(fig, os.path.join(folder, "ground.png"), dpi=100))[..., :3]
	place = lambda x, y: axes.transData.transform((x, y))  # in pixels, from below
	colour = lambda x, y: pixels[round(len(pixels) - place(x, y)[1]), round(place(x, y)[0])]
	thawed, frozen, air = colour(1.5, 3.7), colour(1.0, 1.0), colour(8.0, 3.0)
	print(f"thawed {np.round(thawed, 2)}, frozen {np.round(frozen, 2)}, air {np.round(air, 2)} (red, green, blue)")
	assert thawed[0] > thawed[2] + 0.2 and frozen[2] > frozen[0] + 0.2 and (air == 1).all()
	assert [bar.get_ylabel() for bar in fig.axes if bar.get_label() == "<colorbar>"] == ["ice saturation $S_i$ [-]"]
	dashed = [line for line in axes.lines if line.is_dashed()]
	start = dashed[0].get_xydata()
	print(f"dashed line from ({start[:, 0].min():.2f}, {start[:, 1].min():.2f}) to ({start[:, 0].max():.2f}, {start[:, 1].max():.2f}) m")
	assert len(dashed) == 1 and np.abs([start.min(axis=0) - (0, 0), start.max(axis=0) - (10, 4)]).max() < 0.05
	assert [text.get_text() for text in axes.texts] == ["A"]


@pytest.mark.parametrize(
	"field, values, levels",
	[
		("iceSaturation", [0.05, 0.95], np.linspace(0, 1, 11)),
		("deviatoricStrain", [0, 3.1], [0, 0.05, 0.1, 0.2, 0.5, 1, 2, 5]),
		("displacement", [0, 4.55], np.arange(0, 5.1, 0.5)),
		("displacement", [[0.0, 0.0], [0.3, 0.4]], np.arange(0, 0.51, 0.05)),
		("temperature", [-3.0, 9.5], np.arange(-10, 10.1, 2)),
		("settlement [mm]", [7.0, 7.0], None),
	],
)
def test_bands_have_round_levels_over_the_range_of_a_field(field, values, levels):
	bands = plots.bandsOf(field, np.array(values))
	print(f"{field} {values}: levels {bands.levels.tolist()}, extend {bands.extend}")
	assert bands.extend == "neither" and (np.diff(bands.levels) > 0).all()
	if levels is not None:
		np.testing.assert_allclose(bands.levels, levels, atol=1e-12)


def test_values_beyond_given_limits_are_told_by_an_arrow_of_the_colour_bar():
	found = [plots.bandsOf("settlement [mm]", np.array([-5.0, 5.0]), limits=limits).extend for limits in ((-5, 5), (0, 5), (-5, 2), (-2, 2))]
	print(found)
	assert found == ["neither", "min", "max", "both"]


def test_ground_whose_value_equals_a_level_has_one_colour_whatever_its_round_off(folder):
	x = np.linspace(0, 1, 50)
	noise = 1e-12 * np.random.default_rng(1).standard_normal((50, 50))
	whole = plots.Path([(0, 0), (1, 0), (1, 1), (0, 1), (0, 0)])
	bands = plots.bandsOf("temperature", np.array([-2.6, -0.8]), levels=np.arange(-2.6, -0.7, 0.2))
	for value in (-2.6, -1.6, -0.8):  # lowest level, one between, highest
		fig = plots.figure(2, 2)
		axes = fig.subplots()
		axes.set_axis_off()
		plots.drawBands(axes, x, x, value + noise, whole, bands)
		pixels = imread(plots.save(fig, os.path.join(folder, "level.png"), dpi=100))[40:-40, 40:-40, :3]
		colours = len(np.unique(pixels.reshape(-1, 3), axis=0))
		print(f"{value} degC with a round-off of 1e-12: {colours} colour(s)")
		assert colours == 1


def test_the_bar_of_a_field_of_microns_has_short_numbers_and_a_unit_with_its_power_of_ten():
	axes = plots.figure(4, 3).subplots()
	bar = plots.colourBar(axes, plots.bandsOf("displacement", np.array([0.0, 8e-5])))
	written = [text.get_text() for text in bar.ax.get_yticklabels()]
	print(bar.ax.get_ylabel(), written)
	assert bar.ax.get_ylabel() == "displacement $|u|$ [$10^{-6}$ m]" and written[0] == "0" and written[-1] == "80"
	assert plots.colourBar(axes, plots.bandsOf("deviatoricStrain", np.array([0.0, 2e-5]))).ax.get_ylabel().endswith("[$10^{-6}$]")


def test_thaw_front_lies_at_half_ice_saturation():
	frame = thawingSlope(10)
	axes = plots.figure(4, 3).subplots()
	contours = plots.thawFront(axes, frame["position"] - frame["displacement"], frame["iceSaturation"], frame["volume"])
	line = np.vstack(contours.allsegs[0])
	onBench = line[(line[:, 0] > 7) & (line[:, 0] < 9.8)]
	depth = 1 - onBench[:, 1]
	print(f"front on the bench {depth.mean():.4f} m deep, given {0.293 * np.sqrt(10):.4f} m, spread {np.ptp(depth):.4f} m")
	assert len(onBench) > 5
	assert np.abs(depth - 0.293 * np.sqrt(10)).max() < 0.02


def test_thaw_front_in_resampled_ground_lies_at_half_ice_saturation():
	frame = thawingSlope(10)
	frame = {**frame, "position": frame["position"] - frame["displacement"]}
	axes = plots.ground(plots.figure(4, 3).subplots(), frame, "iceSaturation", bar=False)
	red = [c for c in axes.collections if len(c.get_edgecolor()) and tuple(np.round(c.get_edgecolor()[0][:3], 2)) == (0.86, 0.08, 0.24)]
	line = np.vstack([path.vertices for c in red for path in c.get_paths()])
	depth = 1 - line[(line[:, 0] > 7) & (line[:, 0] < 9.8), 1]
	print(f"front on the bench {depth.mean():.4f} m deep, given {0.293 * np.sqrt(10):.4f} m, spread {np.ptp(depth):.4f} m, points 0.1 m")
	assert len(depth) > 5 and np.abs(depth - 0.293 * np.sqrt(10)).max() < 0.02


def test_thaw_front_is_absent_while_all_is_frozen():
	frame = thawingSlope(1)
	assert plots.thawFront(plots.figure(4, 3).subplots(), frame["position"], np.ones(len(frame["position"])), frame["volume"]) is None


def test_isolines_of_a_field_of_circles_are_circles_and_cross_no_gap(folder):
	position, volume = geometry.fillPolygon([(0, 0), (4, 0), (4, 4), (0, 4)], 0.1, 4)
	gap = np.abs(position[:, 0] - 3) > 0.2
	position, volume = position[gap], volume[gap]
	temperature = np.hypot(*position.T) ** 2 - 9
	temperature[np.hypot(*(position - [0.5, 0.5]).T) < 0.2] = np.nan
	axes = plots.figure(6, 5).subplots()
	plots.slopeField(axes, position, temperature, volume, "temperature [°C]", "coolwarm", (-9, 9))
	lines = plots.isolines(axes, position, temperature, volume, [-8, -5, 0, 3, 99], unit=" °C")
	print("levels", lines.levels.tolist(), "of -8, -5, 0, 3 and 99")
	assert lines.levels.tolist() == [-8, -5, 0, 3]
	assert sorted(text.get_text() for text in lines.labelTexts)[0] == "-5 °C"
	worst = 0.0
	for level, segments in zip(lines.levels, lines.allsegs):
		line = np.vstack(segments)
		worst = max(worst, np.abs(np.hypot(*line.T) - np.sqrt(9 + level)).max())
		assert len(line) > 5 and (np.abs(line[:, 0] - 3) > 0.1).all()
	print(f"farthest from the circle sqrt(9 + T): {worst:.1e} m, points 0.05 m wide")
	assert worst < 2e-3
	assert imread(plots.save(axes.figure, os.path.join(folder, "isolines.png"))).std() > 0.05


def test_isolines_take_round_levels_by_themselves_and_are_absent_in_a_field_of_one_value():
	frame = {**thawingSlope(10), "day": 100}
	frame["temperature"] = 3.3 * frame["position"][:, 1] - 7
	fig = plots.slopeHistory([frame], fields=("temperature", "iceSaturation"), lines={"temperature": None})
	written = sorted(float(text.get_text()) for text in fig.axes[0].texts if text.get_text())
	print("numbers on the lines:", written)
	assert len(written) >= 4 and all(level == round(level) for level in written)
	assert not [text for text in fig.axes[1].texts if text.get_text()]
	assert plots.isolines(fig.axes[1], frame["position"], np.ones(len(frame["position"])), frame["volume"]) is None


def test_a_profile_of_a_linear_field_is_a_straight_line_and_ends_with_the_ground():
	position, volume = geometry.fillPolygon([(0, 0), (4, 0), (4, 2), (0, 2)], 0.2, 4)
	axes = plots.figure(5, 4).subplots()
	distance, values = plots.profile(axes, position, 3 * position[:, 0] - 2 * position[:, 1], (0.5, 1), (5, 1), "temperature [°C]")
	inside = np.isfinite(values)
	error = np.abs(values[inside] - (3 * (0.5 + distance[inside]) - 2)).max()
	print(f"off by {error:.1e}; values up to x = {0.5 + distance[inside].max():.2f} m of 4 m")
	assert error < 1e-9 and distance[-1] == pytest.approx(4.5) and 3.9 < 0.5 + distance[inside].max() <= 4
	assert axes.get_ylabel() == "temperature [°C]" and len(axes.lines) == 1


def test_force_chains_draw_intact_bonds_red_the_others_black_and_width_by_force(folder):
	centre, radius, start, end, force, state = randomPacking()
	fig = plots.figure(5, 5)
	axes = fig.subplots()
	assert plots.forceChains(axes, start, end, force, state, centre, radius, widest=6) is axes
	plots.save(fig, os.path.join(folder, "force-chains.png"))
	lines = [c for c in axes.collections if hasattr(c, "get_segments")]
	black, red = lines
	assert len(red.get_segments()) == np.count_nonzero(state == plots.contactBonded)
	assert len(black.get_segments()) == np.count_nonzero(state != plots.contactBonded)
	widths = np.concatenate([black.get_linewidths(), red.get_linewidths()])
	expected = 0.3 + 6 * np.concatenate([force[state != 1], force[state == 1]]) / force.max()
	print(f"{len(red.get_segments())} red, {len(black.get_segments())} black, widths {widths.min():.2f} to {widths.max():.2f} points")
	np.testing.assert_allclose(widths, expected)
	assert tuple(red.get_colors()[0][:3]) == (1, 0, 0)


def test_force_chains_survive_a_sample_without_contacts():
	axes = plots.figure(4, 4).subplots()
	plots.forceChains(axes, [], [], [], [], np.array([[0.0, 0.0], [0.1, 0.1]]), np.array([0.01, 0.01]))
	assert len(axes.collections) == 3


def test_normal_rose_shows_the_given_anisotropy(folder):
	random = np.random.default_rng(0)
	anisotropy, count = 0.2, 200_000
	angles = random.uniform(0, np.pi, 4 * count)
	angles = angles[random.uniform(0, 2, len(angles)) < 1 + 2 * anisotropy * np.cos(2 * (angles - np.pi / 3))]
	fig = plots.figure(4, 4)
	axes = fig.subplots(subplot_kw=dict(projection="polar"))
	assert plots.normalRose(axes, np.column_stack([np.cos(angles), np.sin(angles)])) is axes
	plots.save(fig, os.path.join(folder, "normal-rose.png"))
	heights = np.array([bar.get_height() for bar in axes.patches])
	middle = (np.arange(36) + 0.5) * 2 * np.pi / 36
	expected = 1 + 2 * anisotropy * np.cos(2 * (middle - np.pi / 3))
	print(f"largest deviation from the given density {np.abs(heights - expected).max():.4f}; {axes.get_title()}")
	assert np.abs(heights - expected).max() < 0.03
	assert f"{anisotropy:.1f}" in axes.get_title()


def test_stress_path_is_drawn_in_mean_pressure_and_mohr_radius_in_kilopascal(folder):
	strain = np.linspace(0, 0.02, 50)
	stress = np.column_stack([np.full(50, -100e3), -100e3 - 300e3 * np.tanh(strain / 0.004), 20e3 * strain / 0.02])
	fig = plots.figure(8, 3.5)
	left, right = fig.subplots(1, 2)
	assert plots.stressPath(left, stress, label="S_i = 0.5") is left
	line = left.lines[0]
	assert plots.bondHistory(right, strain, 300 - 4000 * strain, 3000 * strain, 1000 * strain) is right
	plots.save(fig, os.path.join(folder, "stress-path.png"))
	np.testing.assert_allclose(line.get_xdata(), -0.5 * (stress[:, 0] + stress[:, 1]) / 1e3)
	np.testing.assert_allclose(line.get_ydata()[-1], np.hypot(0.5 * (stress[-1, 0] - stress[-1, 1]), 20e3) / 1e3)
	assert [text.get_text() for text in right.get_legend().get_texts()] == ["intact", "broken", "melted"]
	assert [line.get_color() for line in right.lines] == ["red", "black", "steelblue"]
	np.testing.assert_allclose(right.lines[1].get_ydata(), 3000 * strain)


def test_stress_path_takes_the_four_components_of_a_point_as_well_and_refuses_others():
	inPlane = np.array([[-1e5, -2e5, 3e4], [-1.5e5, -3e5, 4e4]])
	drawn = [plots.stressPath(plots.figure(3, 3).subplots(), stress).lines[0].get_xydata() for stress in (inPlane, np.insert(inPlane, 2, -9e5, axis=1))]
	np.testing.assert_array_equal(*drawn)
	with pytest.raises(ValueError, match=r"\(2, 2\)"):
		plots.stressPath(plots.figure(3, 3).subplots(), inPlane[:, :2])


def test_slope_field_colours_every_point_by_its_value_and_marks_the_watched_ones(folder):
	frame = thawingSlope(10)
	fig = plots.figure(6, 3)
	axes = fig.subplots()
	watched = {"A": (3.0, 2.0), "B": (4.6, 2.2)}
	assert plots.slopeField(axes, frame["position"], frame["displacement"], frame["volume"], label="|u| [m]", watched=watched) is axes
	plots.save(fig, os.path.join(folder, "slope-field.png"))
	squares = axes.collections[0]
	np.testing.assert_allclose(squares.get_array(), np.linalg.norm(frame["displacement"], axis=1))
	assert len(squares.get_paths()) == len(frame["position"])
	rings = [tuple(line.get_xydata()[0]) for line in axes.lines]
	print(f"{len(squares.get_paths())} squares, rings at {rings}, letters {[text.get_text() for text in axes.texts]}")
	assert rings == list(watched.values()) and [text.get_text() for text in axes.texts] == list(watched)
	assert [bar.get_ylabel() for bar in fig.axes if bar.get_label() == "<colorbar>"] == ["|u| [m]"]


def test_sample_forces_draw_normal_forces_of_sample_arrays():
	centre, radius, start, end, force, state = randomPacking()
	sample = dict(centre=centre, radius=radius, start=start, end=end, normalForce=force, shearForce=0 * force, normal=end - start, state=state)
	drawn = [
		plots.sampleForces(plots.figure(3, 3).subplots(), sample),
		plots.forceChains(plots.figure(3, 3).subplots(), start, end, force, state, centre, radius),
	]
	widths = [[collection.get_linewidths() for collection in axes.collections] for axes in drawn]
	for own, expected in zip(*widths):
		np.testing.assert_array_equal(own, expected)


def test_a_folder_that_cannot_be_written_is_named():
	with pytest.raises(RuntimeError, match="/proc/nowhere"):
		plots.save(plots.figure(1, 1), "/proc/nowhere/picture.png")


def test_ground_shows_settlement_about_zero_with_borders_of_layers_and_labelled_isotherms():
	x, y = np.meshgrid(np.arange(0.25, 10, 0.5), np.arange(0.25, 4, 0.5))
	position = np.column_stack([x.ravel(), y.ravel()])
	down = np.where(position[:, 0] < 5, 0.3, -0.1)
	frame = dict(position=position, volume=np.full(len(position), 0.25), displacement=np.column_stack([0 * down, -down]), temperature=position[:, 1] - 2)
	axes = plots.figure(6, 4).subplots()
	plots.ground(axes, frame, "settlement", layers=(position[:, 1] > 2).astype(int), isotherms=(-1, 0, 1, 50))
	levels = plots.bandsOf("settlement", down).levels
	sides = [plots.bandsOf("settlement", sign * abs(down)).map(end)[:3] for sign, end in ((1, 0.0), (-1, 1.0))]
	written = [text.get_text() for text in axes.texts]
	print(f"levels {levels}, isotherms {written}, colours of no settlement {np.round(sides, 2).tolist()}")
	assert levels[0] == -levels[-1] and sorted(written) == ["-1 °C", "0 °C", "1 °C"]
	assert all(min(colour) > 0.9 for colour in sides)  # white: no settlement, on ground that only settles and on ground that only heaves
