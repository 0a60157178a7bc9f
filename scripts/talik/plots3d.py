# SPDX-License-Identifier: GPL-2.0-or-later
"""Shaded pictures of ground and samples in space. Each function draws into Matplotlib axes that the caller gives and returns them, takes
plain arrays, and needs no display: VTK renders in a process of its own, see _rendering.py.

	frame = talik.output.allFields(mpm)
	talik.plots3d.slope(talik.plots.figure(8, 6).subplots(), frame, "displacement", mpm.lower, mpm.upper, bodies=O.bodies)
	talik.plots3d.sample(talik.plots.figure(5, 5).subplots(), talik.packing.sampleArrays())
"""

import os
import pickle
import shutil
import subprocess
import tempfile
from contextlib import contextmanager
from pathlib import Path

import numpy as np
from matplotlib import colormaps
from matplotlib.cm import ScalarMappable
from matplotlib.colors import Normalize, to_rgb
from matplotlib.lines import Line2D
from matplotlib.ticker import MaxNLocator

from talik import bodies as bodiesOfScene
from talik.plots import Path as Outline
from talik.plots import bandsOf, colourBar, contactBonded, drawBands, finiteRange, frontLine, frontSaturation, legendOfLines, magnitude, slopeFields, symmetric
from talik.resampling import SpaceRaster, polygonsOf, surfaceLevel

python = "/usr/bin/python3"  # Debian's, which has VTK
oversampling = 2  # pixels rendered for each one shown, in each direction: smooth edges
renderTimeout = 300  # [s]
frozenColour, cutColour, bodyColour, grainColour = "#d6e6f2", "#a07850", "#9a9a9a", "#d9d3c7"
_bar = dict(shrink=0.7, aspect=35, pad=0.02)  # of colours
viewFromSlope = (-50.0, 28.0)  # azimuth from x and elevation of the viewer [deg]: down the slope, to its right


# --- ground ----------------------------------------------------------------------------------------------------------------


def slope(axes, frame, field, lower, upper, stripped=None, bodies=(), view=viewFromSlope, limits=None, label=None, colourMap=None, bar=True):
	"""Ground in space as a closed surface coloured by a field (vectors by their length).

	frame         {"position": (n, 3) [m], "volume": (n,) [m3], field: (n,) or (n, k), "iceSaturation" where `stripped` is given}
	lower, upper  corners of the grid's box (3,) [m], where the ground ends
	stripped      y [m]: up to there only what is frozen is shown, S_i of 0.5 or more, so that the thaw front lies open
	bodies        facets and boxes that are drawn too, e.g. O.bodies
	view          azimuth from x and elevation of the viewer [deg]
	limits        (low, high) of the colours; default the range of the field
	bar           a colour bar

	>>> lattice = np.stack(np.meshgrid(*3 * [np.arange(8) + 0.5]), axis=-1).reshape(-1, 3)
	>>> frame = {"position": lattice, "volume": np.ones(512), "displacement": 0.1 * lattice}
	>>> drawn = talik.plots3d.slope(axes, frame, "displacement", (0, 0, 0), (8, 8, 10))"""
	position = np.asarray(frame["position"], dtype=float)
	if position.ndim != 2 or position.shape[1] != 3:
		raise ValueError(f"slope: position has shape {position.shape}; give ground in space, (n, 3); talik.plots draws ground in the plane")
	usual = slopeFields.get(field, (field, "viridis", (None, None)))
	label, colourMap = label or usual[0], colormaps[colourMap or usual[1]]
	values = magnitude(frame[field])
	low, high = (given if given is not None else found for given, found in zip(limits or usual[2], finiteRange(values)))
	if field in symmetric and limits is None and low < 0 < high:
		low, high = -max(-low, high), max(-low, high)
	norm = Normalize(low, max(high, low + 1e-12))
	vertices, triangles, shown, bare, cut = _surface(frame, values, lower, upper, stripped)
	colours = colourMap(norm(shown))[:, :3]
	colours[bare] = to_rgb(frozenColour)
	parts = [_mesh(vertices, triangles, colours)]
	if len(cut):
		parts.append(_mesh(vertices, cut, np.tile(to_rgb(cutColour), (len(vertices), 1))))
	corners, faces = bodiesOfScene.mesh(bodies)
	if len(faces):
		parts.append(_mesh(corners, faces, np.tile(to_rgb(bodyColour), (len(corners), 1))))
	box = np.array([vertices.min(axis=0), vertices.max(axis=0)])
	place = _show(axes, parts, np.vstack([box, corners]) if len(faces) else box, view)
	_scales(axes, place, box, view)
	if bar:
		axes.figure.colorbar(ScalarMappable(norm, colourMap), ax=axes, label=label, location="bottom", ticks=MaxNLocator(6), **_extending(norm, values), **_bar)
	return axes


def _extending(norm, values):
	"""Whether the colour bar ends in an arrow: where there is more than it shows."""
	return {"extend": "max"} if np.nanmax(values) > norm.vmax * (1 + 1e-9) else {}


def section(axes, frame, field, y, lower, upper, limits=None, label=None, colourMap=None, bar=True, levels=None):
	"""Ground in space cut at a y [m]: a field in contour bands over x and z, the outline of the ground black, the thaw front crimson where there is ice.

	Arguments as those of slope() and talik.plots.ground; vectors by their length.

	>>> lattice = np.stack(np.meshgrid(*3 * [np.arange(8) + 0.5]), axis=-1).reshape(-1, 3)
	>>> frame = {"position": lattice, "volume": np.ones(512), "displacement": 0.1 * lattice}
	>>> drawn = talik.plots3d.section(axes, frame, "displacement", 4.2, (0, 0, 0), (8, 8, 10))"""
	raster = SpaceRaster(frame["position"], frame["volume"], lower, upper)
	x, z, filled = raster.cut(1.0, y)
	mean = lambda values: raster.cut(values, y)[2] / np.maximum(filled, 1e-12)
	level, shown = filled / surfaceLevel, mean(magnitude(frame[field]))
	bands = bandsOf(field, shown[level >= 1], label, colourMap, levels, limits or (None, None))
	outline = Outline(*polygonsOf(x, z, level, 1.0))
	drawBands(axes, x, z, shown, outline, bands)
	axes.contour(x, z, level, levels=[1.0], colors="0.15", linewidths=0.9)
	if "iceSaturation" in frame:
		frontLine(axes, x, z, mean(frame["iceSaturation"]), level >= 1, outline)
	axes.set_aspect("equal")
	axes.set_xlabel("x [m]")
	axes.set_ylabel("z [m]")
	if bar:
		colourBar(axes, bands, location="bottom", **_bar)
		legendOfLines(axes)
	return axes


def _surface(frame, values, lower, upper, stripped):
	"""(vertices (n, 3), triangles (m, 3), value (n,) at the vertices, bare (n,): whether only frozen ground is shown, triangles (k, 3) of the cut)."""
	raster = SpaceRaster(frame["position"], frame["volume"], lower, upper)
	filled = raster.smeared(1.0)
	mean = lambda field: raster.smeared(field) / np.maximum(filled, 1e-12)
	level, bare = filled / surfaceLevel, np.zeros(filled.shape)
	if stripped is not None:
		bare[:, raster.nodes(1) < stripped] = 1
		level = np.where(bare > 0, np.minimum(level, mean(frame["iceSaturation"]) / frontSaturation), level)
	vertices, triangles, (shown, bare) = raster.contour(level, 1.0, [mean(values), bare])
	cut = np.zeros(len(triangles), dtype=bool)
	if bare.any() and not bare.all():  # between the last row that is stripped and the next the surface is a stair: it becomes a plane
		last = raster.nodes(1)[raster.nodes(1) < stripped][-1]
		between = np.abs(vertices[:, 1] - last - 0.5 * raster.step[1]) < 0.501 * raster.step[1]
		vertices[between, 1], cut = stripped, between[triangles].all(axis=1)
	return vertices, triangles[~cut], shown, bare > 0.5, triangles[cut]


# --- sample ----------------------------------------------------------------------------------------------------------------


def sample(axes, arrays, view=(-60.0, 18.0), size=0.55, widest=0.3):
	"""Grains of a sample of spheres, smaller than they are, and their contacts as rods, thick by their normal force: intact bonds red,
	broken and frictional contacts black; the cell is the box.

	arrays  of talik.packing.sampleArrays()
	size    of the grains drawn, in their own
	widest  radius of the rod with the largest force, in mean radii of the grains

	>>> centres = np.array([(0, 0, 0), (0.01, 0, 0.002)])
	>>> pair = dict(centre=centres, radius=np.array([5e-3, 5e-3]), start=centres[:1], end=centres[1:], normalForce=[5.0], state=[1])
	>>> drawn = talik.plots3d.sample(axes, pair)"""
	centre = np.asarray(arrays["centre"], dtype=float)
	if centre.ndim != 2 or centre.shape[1] != 3:
		raise ValueError(f"sample: centre has shape {centre.shape}; give a sample of spheres, (n, 3); talik.plots.sampleForces draws discs")
	radius, force = np.asarray(arrays["radius"], dtype=float), np.abs(np.asarray(arrays["normalForce"], dtype=float))
	segments = np.stack([arrays["start"], arrays["end"]], axis=1)
	bonded = np.asarray(arrays["state"]) == contactBonded
	share = force / (force.max() if force.size and force.max() > 0 else 1.0)
	rods = radius.mean() * (0.05 + (widest - 0.05) * share)
	grains = dict(kind="spheres", points=centre, radii=size * radius, colours=_bytes(np.tile(to_rgb(grainColour), (len(centre), 1))), opacity=1.0, gloss=0.25)
	parts = [grains]
	for chosen, colour in ((~bonded, "#202020"), (bonded, "#c8102e")):
		if chosen.any():
			colours = _bytes(np.tile(to_rgb(colour), (chosen.sum(), 1)))
			parts.append(dict(kind="tubes", segments=segments[chosen], radii=rods[chosen], colours=colours, opacity=1.0, gloss=0.2))
	box = np.array([centre.min(axis=0) - radius.max(), centre.max(axis=0) + radius.max()])
	place = _show(axes, parts, np.vstack([box, segments.reshape(-1, 3)]), view)
	_scales(axes, place, box * 1e3, view, unit="mm", factor=1e3)
	handles = [
		Line2D([], [], color="#c8102e", linewidth=3, label=f"intact bonds ({bonded.sum()})"),
		Line2D([], [], color="#202020", linewidth=3, label=f"broken or frictional ({(~bonded).sum()})"),
	]
	widestForce = f"thickest: {force.max() if force.size else 0:.3g} N"
	axes.legend(handles=handles, title=widestForce, loc="upper center", bbox_to_anchor=(0.5, 0.02), ncol=2, frameon=False, fontsize=8, title_fontsize=8)
	return axes


# --- common ----------------------------------------------------------------------------------------------------------------


def _mesh(vertices, triangles, colours):
	return dict(kind="mesh", points=vertices, triangles=np.asarray(triangles), colours=_bytes(colours), opacity=1.0, gloss=0.05)


def _bytes(colours):
	return np.round(255 * np.asarray(colours)).astype(np.uint8)


def _direction(view):
	"""Unit vector towards the viewer."""
	azimuth, elevation = np.radians(view)
	return np.array([np.cos(elevation) * np.cos(azimuth), np.cos(elevation) * np.sin(azimuth), np.sin(elevation)])


def _show(axes, parts, box, view):
	"""The rendered picture in the axes; returns a function from places (n, 3) to pixels (n, 2) of it."""
	towards = _direction(view)
	right = np.cross([0, 0, 1.0], towards)
	right /= np.linalg.norm(right)
	up = np.cross(towards, right)
	focus = 0.5 * (box.min(axis=0) + box.max(axis=0))
	corners = np.array(np.meshgrid(*np.transpose([box.min(axis=0), box.max(axis=0)]), indexing="ij")).reshape(3, -1).T - focus
	half = 1.12 * np.abs(corners @ right).max(), 1.12 * np.abs(corners @ up).max()
	width = 1000
	size = (oversampling * width, oversampling * int(np.ceil(width * half[1] / half[0])))
	# VTK's places have single precision: they count from the focus
	camera = dict(focus=np.zeros(3), position=10 * np.linalg.norm(corners, axis=1).max() * towards, scale=half[1])
	shifted = [{name: value - focus if name in ("points", "segments") else value for name, value in part.items()} for part in parts]
	pixels, matrix = _rendered(dict(parts=shifted, camera=camera, size=size))
	height, width = (length // oversampling for length in pixels.shape[:2])
	axes.imshow(pixels.reshape(height, oversampling, width, oversampling, -1).mean(axis=(1, 3)).astype(np.uint8), interpolation="antialiased")
	axes.set_axis_off()

	def place(points):
		seen = np.column_stack([points - focus, np.ones(len(points))]) @ matrix.T
		return np.column_stack([0.5 * (seen[:, 0] + 1) * width, 0.5 * (1 - seen[:, 1]) * height])

	return place


def _rendered(scene):
	with tempfile.TemporaryDirectory(prefix="talik-picture-") as folder, _display() as display:
		given, made = Path(folder, "scene.pickle"), Path(folder, "picture.npz")
		given.write_bytes(pickle.dumps(scene))
		command = [python, "-B", str(Path(__file__).with_name("_rendering.py")), str(given), str(made)]
		done = subprocess.run(command, capture_output=True, text=True, env={**os.environ, "DISPLAY": display}, timeout=renderTimeout)
		if done.returncode != 0:
			raise RuntimeError(f"VTK did not render a picture in space: {(done.stderr or done.stdout).strip()[-500:] or f'it ended with {done.returncode}'}")
		with np.load(made) as file:
			return file["pixels"], file["matrix"]


@contextmanager
def _display():
	"""The name of an X server without a screen, which lives as long as the block."""
	if shutil.which("Xvfb") is None:
		raise RuntimeError("pictures in space are rendered on the X server Xvfb, which is not there; install Debian's package xvfb")
	reading, writing = os.pipe()
	command = ["Xvfb", "-displayfd", str(writing), "-screen", "0", "640x480x24", "-nolisten", "tcp"]
	with os.fdopen(reading, "rb") as told:
		server = subprocess.Popen(command, pass_fds=[writing], stdin=subprocess.DEVNULL, stdout=subprocess.DEVNULL, stderr=subprocess.DEVNULL)
		os.close(writing)
		try:
			number = told.readline().strip()
			if not number:
				raise RuntimeError("pictures in space are rendered on the X server Xvfb, which does not start; try  Xvfb :99  to see why")
			yield ":" + number.decode()
		finally:
			server.terminate()
			server.wait()


def _scales(axes, place, box, view, unit="m", factor=1.0):
	"""Ticks with numbers along those three edges of a box (2, 3) that a viewer has before him."""
	towards = _direction(view)
	near = [1 if towards[a] > 0 else 0 for a in range(3)]
	far = [1 - side for side in near]
	# along x on the near side of y, along y on the near side of x, both at the foot; along z on the edge to the left
	right = np.cross([0, 0, 1.0], towards)
	sides = [(near[0], far[1]), (far[0], near[1])]
	left = min(sides, key=lambda side: box[side[0], 0] * right[0] + box[side[1], 1] * right[1])
	middle = place(box.mean(axis=0)[None] / factor)[0]
	for axis, fixed in enumerate(([None, box[near[1], 1], box[0, 2]], [box[near[0], 0], None, box[0, 2]], [box[left[0], 0], box[left[1], 1], None])):
		ticks = [value for value in MaxNLocator(5, steps=[1, 2, 5, 10]).tick_values(*box[:, axis]) if box[0, axis] - 1e-9 <= value <= box[1, axis] + 1e-9]
		line = lambda values: place(np.array([[value if given is None else given for given in fixed] for value in values]) / factor)
		ends = line(box[:, axis])
		axes.plot(*ends.T, color="0.35", linewidth=0.8)
		along = (ends[1] - ends[0]) / np.linalg.norm(ends[1] - ends[0])
		out = np.array([-along[1], along[0]])
		out *= np.sign(out @ (ends.mean(axis=0) - middle)) or 1
		tick = 0.012 * np.ptp(axes.get_xlim())
		across = "center" if abs(out[0]) < 0.2 else "right" if out[0] < 0 else "left"  # so that numbers of two edges do not meet at their corner
		for value, at in zip(ticks, line(ticks)):
			axes.plot(*np.transpose([at, at + tick * out]), color="0.35", linewidth=0.8)
			axes.text(*(at + (2.6 if axis < 2 else 1.6) * tick * out), f"{value:.12g}", ha=across, va="center", fontsize=8)
		longest = max((len(f"{value:.12g}") for value in ticks), default=1)
		away = 6.8 + 0.5 * max(0, longest - 3) if axis < 2 else 2.4 + 1.3 * longest
		axes.text(*(ends.mean(axis=0) + away * tick * out), f"{'xyz'[axis]} [{unit}]", ha=across, va="center", fontsize=9)
