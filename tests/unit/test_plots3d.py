# SPDX-License-Identifier: GPL-2.0-or-later
"""Pictures in space from synthetic data: what is drawn is what was given. They are left in the folder TALIK_PICTURES, if set."""

import os

import numpy as np
import pytest

from talik import plots, plots3d

box = (0, 0, 0), (4, 3, 4)


def block(height=2.0, side=0.25):
	"""Ground of 4 by 3 m, frozen below 1 m, that moved by its x."""
	axes = [(np.arange(round(length / side)) + 0.5) * side for length in (4, 3, height)]
	position = np.stack(np.meshgrid(*axes, indexing="ij"), axis=-1).reshape(-1, 3)
	return dict(
		position=position,
		volume=np.full(len(position), side**3),
		displacement=position * (1, 0, 0),
		iceSaturation=(position[:, 2] < 1).astype(float),
	)


def volumeWithin(vertices, triangles):
	a, b, c = (vertices[triangles[:, k]] for k in range(3))
	return abs(np.einsum("ij,ij->i", a, np.cross(b, c)).sum()) / 6


@pytest.fixture
def folder(tmp_path):
	return os.environ.get("TALIK_PICTURES", str(tmp_path))


def test_the_surface_drawn_encloses_the_volume_of_the_points_and_has_their_values():
	frame = block()
	vertices, triangles, values, bare, cut = plots3d._surface(frame, frame["displacement"][:, 0], *box, stripped=None)
	volume, off = volumeWithin(vertices, triangles) / 24 - 1, np.abs(values - vertices[:, 0]).max()
	print(f"{len(triangles)} triangles; volume {volume:+.1%}, values off by up to {off:.3f} of 4 m; top at {vertices[:, 2].max():.3f} m")
	assert abs(volume) < 0.02 and off < 0.15 and abs(vertices[:, 2].max() - 2) < 0.05 and not bare.any() and not len(cut)


def test_the_stripped_part_ends_at_the_thaw_front_and_the_cut_is_a_plane_of_what_has_thawed():
	frame = block()
	vertices, triangles, _, bare, cut = plots3d._surface(frame, frame["displacement"][:, 0], *box, stripped=1.4)
	stripped, whole, plane = vertices[bare & (vertices[:, 1] < 1.4)], vertices[vertices[:, 1] > 1.4], vertices[cut]
	area = 0.5 * np.linalg.norm(np.cross(plane[:, 1] - plane[:, 0], plane[:, 2] - plane[:, 0]), axis=1).sum()
	print(
		f"stripped up to z = {stripped[:, 2].max():.2f} m, the rest up to {whole[:, 2].max():.2f} m; cut of {area:.2f} m2 (4 due) at y = {plane[..., 1].max()} m"
	)
	assert abs(stripped[:, 2].max() - 1) < 0.07 and abs(whole[:, 2].max() - 2) < 0.05
	assert np.ptp(plane[..., 1]) == 0 and plane[0, 0, 1] == 1.4 and abs(area / 4 - 1) < 0.1
	assert abs(volumeWithin(vertices, np.concatenate([triangles, cut])) / (4 * 1.4 * 1 + 4 * 1.6 * 2) - 1) < 0.02


def coloursOf(axes):
	return axes.images[0].get_array().reshape(-1, 3).astype(int)


def test_a_slope_in_space_is_drawn_with_scales_in_metres_and_a_labelled_colour_bar(folder):
	fig = plots.figure(6, 5)
	axes = plots3d.slope(fig.subplots(), block(), "displacement", *box, stripped=1.5)
	texts, bars = {text.get_text() for text in axes.texts}, [other.get_xlabel() for other in fig.axes if other is not axes]
	plots.save(fig, f"{folder}/slope_in_space.png", dpi=70)
	seen = len(np.unique(coloursOf(axes), axis=0))
	print(f"texts {sorted(texts)}, colour bars {bars}, {seen} colours")
	assert {"x [m]", "y [m]", "z [m]", "0", "2", "4"} <= texts and bars == ["displacement $|u|$ [m]"] and seen > 500


def test_a_section_shows_the_field_inside_the_ground_and_the_thaw_front():
	frame = block()
	axes = plots3d.section(plots.figure(6, 4).subplots(), frame, "displacement", 1.5, *box)
	filled = [c for c in axes.collections if len(c.get_facecolor())]
	bands = [path.vertices for c in filled for path in c.get_paths() if len(path.vertices)]
	lines = [path.vertices for c in axes.collections if not len(c.get_facecolor()) for path in c.get_paths() if len(path.vertices)]
	front = lines[-1][:, 1]
	ends = np.sort([band[:, 0].min() for band in bands])
	print(f"{len(bands)} bands begin at x = {ends.round(2).tolist()} m, half a metre each due; front at z = {front.min():.3f} to {front.max():.3f} m")
	assert len(bands) >= 7 and np.abs(ends[1:] - 0.5 * np.arange(1, len(bands))).max() < 0.1  # displacement is x, bands of half a metre
	assert np.abs(front - 1).max() < 0.05


def test_a_sample_of_spheres_shows_intact_bonds_red_and_counts_them(folder):
	centre = np.array([(x, y, z) for x in (0, 0.01) for y in (0, 0.01) for z in (0, 0.01)], dtype=float)
	start, end = centre[[0, 2, 4, 0]], centre[[1, 3, 5, 2]]
	arrays = dict(centre=centre, radius=np.full(8, 5e-3), start=start, end=end, normalForce=[1.0, 4.0, 2.0, 0.0], state=[1, 1, 2, 0])
	fig = plots.figure(5, 5)
	axes = plots3d.sample(fig.subplots(), arrays)
	plots.save(fig, f"{folder}/sample_in_space.png", dpi=70)
	red, green, blue = coloursOf(axes).T
	legend = [text.get_text() for text in axes.get_legend().get_texts()]
	print(f"{legend}, {np.sum((red > 100) & (green < 60))} red pixels")
	assert legend == ["intact bonds (2)", "broken or frictional (2)"] and np.sum((red > 100) & (green < 60) & (blue < 90)) > 1000
	assert "x [mm]" in {text.get_text() for text in axes.texts}


def test_what_cannot_be_drawn_in_space_is_refused_with_a_sentence(monkeypatch):
	axes = plots.figure(3, 3).subplots()
	plane = {"position": np.zeros((3, 2)), "volume": np.ones(3), "displacement": np.zeros((3, 2))}
	with pytest.raises(ValueError, match="talik.plots draws ground in the plane"):
		plots3d.slope(axes, plane, "displacement", *box)
	with pytest.raises(ValueError, match="talik.plots.sampleForces draws discs"):
		plots3d.sample(axes, dict(centre=np.zeros((2, 2)), radius=np.ones(2)))
	monkeypatch.setattr(plots3d.shutil, "which", lambda program: None)
	with pytest.raises(RuntimeError, match="install Debian's package xvfb") as refusal:
		plots3d.slope(axes, block(), "displacement", *box)
	print(refusal.value)


def test_ground_in_utm_has_the_surface_of_the_same_ground_at_the_origin_and_whole_numbers_at_its_axes():
	"""Places of VTK have single precision, which is half a metre in the north of UTM."""
	north = np.array([524300.0, 8690120.0, 105.0])
	lattice = np.stack(np.meshgrid(*3 * [np.arange(6) + 0.5]), axis=-1).reshape(-1, 3)
	surface = lambda shift: plots3d._surface(dict(position=lattice + shift, volume=np.ones(216)), np.ones(216), shift, shift + (6, 6, 8), None)[0] - shift
	apart = np.abs(surface(north) - surface(np.zeros(3))).max()
	axes = plots.figure(6, 4).subplots()
	plots3d.slope(axes, dict(position=lattice + north, volume=np.ones(216), displacement=lattice), "displacement", north, north + (6, 6, 8))
	numbers = [text.get_text() for text in axes.texts]
	print(f"apart by {1e3 * apart:.4f} mm; {numbers}")
	assert apart < 1e-6 and "8690122" in numbers and not any("e+" in text for text in numbers)
