# SPDX-License-Identifier: GPL-2.0-or-later
"""Pictures of slopes and samples. Every function draws into Matplotlib axes that the caller gives (and may compose) and returns
them, takes plain arrays, and needs no display; figure() makes a figure that can be saved without one.

Slope:   slopeField, markPoints; isolines, thawFront and slopeHistory (rows = times, columns = fields) return what they make
Sample:  forceChains, sampleForces, normalRose, stressPath, bondHistory
"""

from pathlib import Path

import numpy as np
from matplotlib.collections import EllipseCollection, LineCollection, PolyCollection
from matplotlib.colors import Normalize
from matplotlib.figure import Figure
from matplotlib.lines import Line2D
from matplotlib.patheffects import withStroke
from matplotlib.ticker import MaxNLocator
from matplotlib.tri import Triangulation

from talik import ranks
from talik.files import writableFolder

# state of a contact, as the ice-bond law counts it
contactNone, contactBonded, contactBroken = 0, 1, 2

# what is known about the usual fields: label, colour map, limits (None: from the data)
slopeFields = {
	"iceSaturation": ("ice saturation $S_i$ [-]", "Blues", (0.0, 1.0)),
	"deviatoricStrain": (r"deviatoric strain $\varepsilon_d$ [-]", "inferno_r", (0.0, None)),
	"displacement": ("displacement $|u|$ [m]", "viridis", (0.0, None)),
	"temperature": ("temperature [°C]", "coolwarm", (None, None)),
	"pressure": ("pore pressure [Pa]", "PuOr_r", (None, None)),
}


def figure(width, height):
	"""A figure of width x height inches that needs no display; add axes with fig.subplots(...).

	>>> axes = talik.plots.figure(6, 4).subplots()"""
	return Figure(figsize=(width, height), layout="constrained")


def save(fig, path, dpi=150):
	"""Writes a picture, making its folder if need be; in a job of several ranks rank 0 does.

	>>> picture = talik.plots.save(talik.plots.figure(6, 4), folder + "/picture.png")"""
	path = Path(path)
	if not ranks.first:
		return str(path)
	writableFolder(path.parent)
	fig.savefig(path, dpi=dpi)
	return str(path)


# --- slope -----------------------------------------------------------------------------------------------------------------


def slopeField(axes, position, values, volume, label=None, colourMap="viridis", limits=(None, None), watched=None, deformation=None):
	"""Material points as squares of their own volume, coloured by `values` (vectors by their length).

	position (n, 2) [m], values (n,) or (n, 2), volume (n,) [m2]; label of a colour bar, None: no bar; watched {letter: (x, y)} marked
	points; deformation (n, 4) gradient xx, xy, yx, yy of the points, for squares that strained with the ground. Returns the axes.

	>>> drawn = talik.plots.slopeField(axes, mpm.field("position"), mpm.field("displacement"), mpm.field("volume"), "displacement [m]")"""
	collection = _squares(axes, position, values, volume, colourMap, limits, deformation)
	axes.set_xlabel("x [m]")
	axes.set_ylabel("y [m]")
	if label:
		axes.figure.colorbar(collection, ax=axes, label=label, shrink=0.8)
	markPoints(axes, watched or {})
	return axes


def markPoints(axes, points):
	"""Rings with letters at watched points, {letter: (x, y)} [m]. Returns the axes.

	>>> drawn = talik.plots.markPoints(axes, {"A": (0.5, 0.5)})"""
	for letter, (x, y) in points.items():
		axes.plot(x, y, "o", markersize=4, markerfacecolor="white", markeredgecolor="black")
		axes.annotate(
			str(letter),
			(x, y),
			textcoords="offset points",
			xytext=(5, 4),
			fontsize=9,
			weight="bold",
			path_effects=[withStroke(linewidth=2, foreground="white")],
		)
	return axes


def _inPlane(position):
	position = np.asarray(position, dtype=float)
	if position.ndim != 2 or position.shape[1] != 2:
		raise ValueError(f"position has shape {position.shape}; pictures are of ground in the plane, (n, 2); talik.output.ParaViewSeries shows ground in space")
	return position


def _squares(axes, position, values, volume, colourMap, limits, deformation=None):
	position, values = _inPlane(position), magnitude(values)
	half = 0.5 * np.sqrt(np.asarray(volume, dtype=float))  # their thin edges leave no gaps between rows
	corners = np.array([[-1, -1], [1, -1], [1, 1], [-1, 1]], dtype=float)
	squares = position[:, None, :] + half[:, None, None] * _strained(corners, deformation)
	low, high = (value if limit is None else limit for limit, value in zip(limits, finiteRange(values)))
	collection = PolyCollection(squares, array=values, cmap=colourMap, norm=Normalize(low, max(high, low + 1e-12)), edgecolor="face", linewidth=0.6, snap=False)
	axes.add_collection(collection)
	metricAxes(axes, position)
	return collection


def _strained(corners, deformation):
	"""Corners (4, 2) of a unit square in the ground before it strained, (n, 4, 2) after, of the same area."""
	if deformation is None:
		return corners
	gradient = np.asarray(deformation, dtype=float).reshape(-1, 2, 2)
	return np.einsum("nij,kj->nki", gradient / np.sqrt(np.abs(np.linalg.det(gradient)))[:, None, None], corners)


def thawFront(axes, position, iceSaturation, volume, level=0.5, **style):
	"""The line where the ice saturation is `level`; nothing where there is no front. Returns the contour set or None.

	>>> front = talik.plots.thawFront(axes, mpm.field("position"), mpm.field("iceSaturation"), mpm.field("volume"))"""
	return isolines(axes, position, iceSaturation, volume, [level], unit=None, **{"colors": "crimson", "linewidths": 1.2, **style})


def isolines(axes, position, values, volume, levels=None, unit="", **style):
	"""Lines of equal value through material points, in axes that may hold a slopeField. Returns the contour set, or None where there is no line.

	position (n, 2) [m], values (n,) or (n, 2), vectors by their length, volume (n,) [m2]; points without a value (NaN) are left out, and no
	line crosses a gap wider than two and a half points. levels: the values of the lines, None: about eight round ones between the
	least and the largest; unit: written behind the numbers on the lines, None: no numbers; style: of Matplotlib's tricontour.

	>>> lines = talik.plots.isolines(axes, mpm.field("position"), mpm.field("temperature"), mpm.field("volume"), [-1, 0, 1], unit=" °C")"""
	position, values = _inPlane(position), magnitude(values)
	known = np.isfinite(values)
	position, values, sizes = position[known], values[known], np.sqrt(np.asarray(volume, dtype=float))
	if len(values) < 3:
		return None
	wanted = MaxNLocator(9, steps=[1, 2, 5, 10]).tick_values(values.min(), values.max()) if levels is None else np.atleast_1d(levels)
	wanted = [level for level in np.unique(wanted) if values.min() < level < values.max()]
	if not wanted:
		return None
	mesh = Triangulation(position[:, 0], position[:, 1])
	mesh.set_mask(_longestSides(mesh) > 2.5 * np.median(sizes))
	lines = axes.tricontour(mesh, values, levels=wanted, **{"colors": "black", "linewidths": 0.8, **style})
	if unit is not None:
		axes.clabel(lines, fmt=lambda level: f"{level:g}{unit}", fontsize=8)
	return lines


def profile(axes, position, values, start, end, label=None, points=200, **style):
	"""Values along a straight line through the ground over the distance from its start: a borehole, a cross-section. Returns (distance, values).

	position (n, 2) [m], values (n,) or (n, 2), vectors by their length; start, end (x, y) [m] of the line; points: at so many places, linear
	between the material points and NaN outside of them; label: for the axis of the values; style: of Matplotlib's plot.

	>>> depth, temperature = talik.plots.profile(axes, mpm.field("position"), mpm.field("temperature"), (0.5, 1.0), (0.5, 0.0), "temperature [°C]")"""
	from scipy.interpolate import LinearNDInterpolator

	position, values = _inPlane(position), magnitude(values)
	start, end = np.asarray(start, dtype=float), np.asarray(end, dtype=float)
	distance = np.linspace(0, np.linalg.norm(end - start), points)
	along = start + np.linspace(0, 1, points)[:, None] * (end - start)
	found = LinearNDInterpolator(position, values)(along)
	axes.plot(distance, found, **{"color": "black", **style})
	axes.set_xlabel("distance along the line [m]")
	if label:
		axes.set_ylabel(label)
	return distance, found


def slopeHistory(frames, fields=("iceSaturation", "deviatoricStrain", "displacement"), watched=None, into=None, lines=None):
	"""A figure with one row per time and one column per field, like Fig. 6 of Yu & Zhao.

	frames   list of {"time": t [s], "day": of the calendar, "position": (n, 2), "volume": (n,), "iceSaturation": (n,), field: array, ...}
	watched  {letter: (x, y)} marked points, or {letter: id} points that are followed
	into     figure or subfigure to draw into; default: a new one
	lines    {field: levels} of isolines in the column of a field; levels None: round ones
	All rows of a column share one colour scale; the crimson line is the thaw front S_i = 0.5.

	>>> frames = talik.output.Frames(mpm, times=[0])
	>>> frames.take()
	>>> fig = talik.plots.slopeHistory(frames.frames)"""
	if not frames:
		raise ValueError("frames is empty; give at least one frame of talik.output.Frames")
	fields = [name for name in fields if name in frames[0]]
	everything = np.vstack([frame["position"] for frame in frames])
	fig = into or figure(4.2 * len(fields), historyHeight(frames))
	grid = fig.subplots(len(frames), len(fields), squeeze=False, sharex=True, sharey=True)
	for column, name in enumerate(fields):
		label, colourMap, limits = slopeFields.get(name, (name, "viridis", (None, None)))
		limits = _sharedLimits([frame[name] for frame in frames], limits)
		for row, frame in enumerate(frames):
			drawn = _slopePanel(grid[row, column], frame, name, colourMap, limits, _placesOf(watched, frame))
			if name in (lines or {}):
				isolines(grid[row, column], frame["position"], frame[name], frame["volume"], lines[name])
		fig.colorbar(drawn, ax=grid[:, column], label=label, location="bottom", shrink=0.85, aspect=30)
	for row, frame in enumerate(frames):
		grid[row, 0].set_title(timeLabel(frame["time"], frame.get("day")), loc="left", fontsize=10)
		grid[row, 0].set_ylabel("y [m]")
	for axes in grid[-1]:
		axes.set_xlabel("x [m]")
	metricAxes(grid[0, 0], everything)
	return fig


def slopeFilm(fig, frames, field, watched=None, limits=(None, None)):
	"""Makes axes and colour bar for pictures of one slope at many times; returns the function that draws a frame in place of the one before.

	frames, watched as in slopeHistory; limits (lowest, highest) value of the colours, None: from all frames. See talik.movie.

	>>> frames = talik.output.Frames(mpm, times=[0])
	>>> frames.take()
	>>> draw = talik.plots.slopeFilm(talik.plots.figure(6, 4), frames.frames, "displacement")
	>>> draw(frames.frames[0])"""
	label, colourMap, usual = slopeFields.get(field, (field, "viridis", (None, None)))
	given = [mine if mine is not None else common for mine, common in zip(limits, usual)]
	limits = _sharedLimits([frame[field] for frame in frames], given)
	axes, everything = fig.subplots(), np.vstack([frame["position"] for frame in frames])
	drawn = _slopePanel(axes, frames[0], field, colourMap, limits, None)
	fig.colorbar(drawn, ax=axes, label=label, location="bottom", shrink=0.85, aspect=40)

	def draw(frame):
		axes.clear()
		_slopePanel(axes, frame, field, colourMap, limits, _placesOf(watched, frame))
		axes.set(xlabel="x [m]", ylabel="y [m]")
		axes.set_title(timeLabel(frame["time"], frame.get("day")), loc="left", fontsize=10)
		metricAxes(axes, everything)

	return draw


def historyHeight(frames):
	"""Height of slopeHistory [inch] at its usual width of 4.2 for each field.

	>>> frames = talik.output.Frames(mpm, times=[0])
	>>> frames.take()
	>>> height = talik.plots.historyHeight(frames.frames)"""
	extent = np.ptp(np.vstack([frame["position"] for frame in frames]), axis=0)
	return 4.2 * len(frames) * max(extent[1] / extent[0], 0.25) * 0.95 + 0.3 * len(frames) + 0.9


def _placesOf(watched, frame):
	return {letter: frame["position"][point] if np.ndim(point) == 0 else point for letter, point in (watched or {}).items()}


def timeLabel(time, day=None):
	"""Time of motion [s] and, where heat has a calendar of its own, the day.

	>>> talik.plots.timeLabel(2.0, day=20)
	'day 20 (2 s of motion)'"""
	return f"t = {time:.3g} s" if day is None else f"day {day:.3g} ({time:.3g} s of motion)"


def calendarHistory(axes, history, events, label=None):
	"""Largest displacement over the days of the calendar, events marked by what they moved.

	history  rows of day, time of motion [s], largest displacement [m]
	events   of MpmEngine.events()

	>>> talik.plots.calendarHistory(talik.plots.figure(5, 3).subplots(), [(0, 0, 0), (1, 0.1, 0.02)], [{"day": 0.5, "days": 0.01, "volume": 1.5, "largest": 0.02}])
	"""
	history = np.asarray(history, dtype=float).reshape(-1, 3)
	(line,) = axes.plot(history[:, 0], history[:, 2], linewidth=1.2, label=label)
	for event in events:
		axes.axvspan(event["day"], event["day"] + event["days"], color=line.get_color(), alpha=0.25, linewidth=1)
	apart, named = 0.04 * np.ptp(history[:, 0]), []
	for event in sorted(events, key=lambda event: -event["volume"]):
		if len(named) == 5 or any(abs(event["day"] - day) < apart for day in named):
			continue
		named.append(event["day"])
		axes.annotate(f"{event['volume']:.2g} m²", (event["day"], 1), xycoords=("data", "axes fraction"), rotation=90, va="top", ha="right", fontsize=7)
	axes.set(xlabel="day", ylabel="largest displacement [m]")
	axes.set_yscale("symlog", linthresh=0.01)
	axes.set_ylim(bottom=0)


def metricAxes(axes, position):
	"""Equal scales and limits around the points.

	>>> talik.plots.metricAxes(axes, mpm.field("position"))"""
	position = np.asarray(position, dtype=float)
	low, high = position.min(axis=0), position.max(axis=0)
	margin = 0.03 * max((high - low).max(), 1e-12)
	axes.set_aspect("equal")
	axes.set_xlim(low[0] - margin, high[0] + margin)
	axes.set_ylim(low[1] - margin, high[1] + margin)


def magnitude(values):
	"""Vectors by their length, numbers as they are.

	>>> talik.plots.magnitude([(3, 4), (0, 1)]).tolist()
	[5.0, 1.0]"""
	values = np.asarray(values, dtype=float)
	return np.linalg.norm(values, axis=1) if values.ndim == 2 else values


def finiteRange(values):
	"""Smallest and largest finite value; (0, 1) when there is none.

	>>> talik.plots.finiteRange([1.0, float("nan"), 3.0])
	(1.0, 3.0)"""
	finite = np.asarray(values)[np.isfinite(values)]
	return (float(finite.min()), float(finite.max())) if finite.size else (0.0, 1.0)


def _slopePanel(axes, frame, name, colourMap, limits, watched):
	drawn = _squares(axes, frame["position"], frame[name], frame["volume"], colourMap, limits, frame.get("deformationGradient"))
	if "iceSaturation" in frame:
		thawFront(axes, frame["position"], frame["iceSaturation"], frame["volume"])
	markPoints(axes, watched or {})
	return drawn


def _sharedLimits(columns, limits):
	low, high = finiteRange(np.concatenate([magnitude(values) for values in columns]))
	low, high = (value if limit is None else limit for limit, value in zip(limits, (low, high)))
	return low, max(high, low + 1e-12)


def _longestSides(mesh):
	corners = np.column_stack([mesh.x, mesh.y])[mesh.triangles]
	return np.linalg.norm(corners - np.roll(corners, 1, axis=1), axis=2).max(axis=1)


# --- sample ----------------------------------------------------------------------------------------------------------------


def forceChains(axes, start, end, force, state, centre=None, radius=None, widest=6.0, legend=True):
	"""Contacts as lines between the grains, width by force: intact bonds red, broken or frictional contacts black.

	start, end  (n, 2) [m] ends of the branch vectors; force (n,) [N], its size is drawn; state (n,) 0 frictional, 1 bonded, 2 broken
	centre      (m, 2) and radius (m,) [m] of the grains, drawn pale behind
	widest      width in points of the largest force; contacts without force keep a hair line
	Returns the axes.

	>>> drawn = talik.plots.forceChains(axes, start=[(0, 0)], end=[(0.01, 0)], force=[5.0], state=[1])"""
	start, end = np.asarray(start, dtype=float).reshape(-1, 2), np.asarray(end, dtype=float).reshape(-1, 2)
	force, state = np.abs(np.asarray(force, dtype=float)), np.asarray(state, dtype=int)
	_grains(axes, centre, radius)
	width = 0.3 + widest * force / (force.max() if force.size and force.max() > 0 else 1.0)
	segments = np.stack([start, end], axis=1)
	bonded = state == contactBonded
	for chosen, colour, layer in ((~bonded, "black", 2), (bonded, "red", 3)):
		axes.add_collection(LineCollection(segments[chosen], linewidths=width[chosen], colors=colour, capstyle="round", zorder=layer))
	shown = [points for points in (start, end, centre) if points is not None and len(points)]
	if shown:
		metricAxes(axes, np.vstack(shown))
	axes.set_xlabel("x [m]")
	axes.set_ylabel("y [m]")
	if legend:
		_forceLegend(axes, force, bonded)
	return axes


def sampleForces(axes, sample, **style):
	"""forceChains of a sample as talik.packing.sampleArrays() gives it: normal forces, bond states, grains. Returns the axes.

	>>> with mpm.inspect(5):
	...     drawn = talik.plots.sampleForces(axes, talik.packing.sampleArrays())"""
	return forceChains(axes, sample["start"], sample["end"], sample["normalForce"], sample["state"], sample["centre"], sample["radius"], **style)


def normalRose(axes, normals, bins=36, colour="steelblue"):
	"""Rose diagram of contact normals in polar axes, each contact counted in both directions; the line is the second-order
	fit of the contact fabric, 1 + a cos 2(theta - theta0), with anisotropy F1 - F2 = a/2 in the title. Returns the axes.

	>>> drawn = talik.plots.normalRose(talik.plots.figure(4, 4).add_subplot(projection="polar"), [(1, 0), (0, 1)])"""
	normals = np.asarray(normals, dtype=float).reshape(-1, 2)
	angles = np.arctan2(normals[:, 1], normals[:, 0])
	both = np.concatenate([angles, angles + np.pi]) % (2 * np.pi)
	counts, edges = np.histogram(both, bins=bins, range=(0, 2 * np.pi))
	density = counts / max(counts.sum(), 1) * bins  # 1 everywhere when isotropic
	axes.bar(edges[:-1], density, width=2 * np.pi / bins, align="edge", color=colour, edgecolor="white", linewidth=0.5)
	axes.set_rticks([0.5, 1.0, 1.5])
	axes.set_thetagrids([0, 90, 180, 270])
	axes.set_rlabel_position(45)
	for label in axes.get_yticklabels():
		label.set(fontsize=7, path_effects=[withStroke(linewidth=2, foreground="white")])
	if not len(normals):
		axes.set_title("no contacts", fontsize=10)
		return axes
	second = np.exp(2j * angles).mean()
	theta = np.linspace(0, 2 * np.pi, 181)
	axes.plot(theta, 1 + 2 * abs(second) * np.cos(2 * theta - np.angle(second)), color="black", linewidth=1)
	axes.set_title(f"{len(normals)} contacts, $F_1-F_2$ = {abs(second):.3f}", fontsize=10, pad=10)
	return axes


def stressPath(axes, stress, label=None, **style):
	"""Path in the plane of mean pressure s' = -(xx + yy)/2 and shear t = radius of Mohr's circle; stress (n, 3) [Pa], xx, yy, xy, or
	(n, 4), xx, yy, zz, xy, as MpmEngine.history() has it; tension positive. The ring marks the beginning. Drawn in kPa. Returns the axes.

	>>> drawn = talik.plots.stressPath(axes, [(-100e3, -100e3, 0), (-120e3, -80e3, 10e3)])"""
	stress = np.asarray(stress, dtype=float)
	if stress.ndim != 2 or stress.shape[1] not in (3, 4):
		raise ValueError(f"stressPath: stress has shape {stress.shape}; give (n, 3) xx, yy, xy or (n, 4) xx, yy, zz, xy")
	stress = stress[:, [0, 1, -1]]
	mean = -0.5 * (stress[:, 0] + stress[:, 1]) / 1e3
	shear = np.hypot(0.5 * (stress[:, 0] - stress[:, 1]), stress[:, 2]) / 1e3
	(line,) = axes.plot(mean, shear, label=label, **style)
	axes.plot(mean[:1], shear[:1], "o", markerfacecolor="white", markeredgecolor=line.get_color())
	axes.set_xlabel("mean pressure $s'$ [kPa]")
	axes.set_ylabel("shear stress $t$ [kPa]")
	return axes


def bondHistory(axes, strain, intact, broken, melted=None):
	"""Numbers of intact, mechanically broken and melted bonds over the strain [-]. Returns the axes.

	>>> drawn = talik.plots.bondHistory(axes, strain=[0, 0.01], intact=[50, 45], broken=[0, 5])"""
	axes.plot(strain, intact, color="red", label="intact")
	axes.plot(strain, broken, color="black", label="broken")
	if melted is not None:
		axes.plot(strain, melted, color="steelblue", label="melted")
	axes.set_xlabel("strain [-]")
	axes.set_ylabel("bonds")
	axes.locator_params(axis="x", nbins=4)
	axes.set_ylim(bottom=0)
	axes.legend(frameon=False)
	return axes


def _grains(axes, centre, radius):
	if centre is None or radius is None:
		return
	diameter = 2 * np.asarray(radius, dtype=float)
	axes.add_collection(
		EllipseCollection(
			diameter,
			diameter,
			np.zeros_like(diameter),
			units="xy",
			offsets=np.asarray(centre, dtype=float),
			offset_transform=axes.transData,
			facecolors="0.93",
			edgecolors="0.75",
			linewidths=0.4,
			zorder=1,
		)
	)


def _forceLegend(axes, force, bonded):
	largest = force.max() if force.size else 0.0
	handles = [
		Line2D([], [], color="red", linewidth=2, label=f"intact bonds ({bonded.sum()})"),
		Line2D([], [], color="black", linewidth=2, label=f"broken or frictional ({(~bonded).sum()})"),
	]
	below = dict(loc="upper center", bbox_to_anchor=(0.5, 0), borderaxespad=4)  # in heights of its letters: clear of the label of x at any size
	axes.legend(handles=handles, title=f"widest: {largest:.3g} N", ncol=2, frameon=False, fontsize=8, title_fontsize=8, **below)
