# SPDX-License-Identifier: GPL-2.0-or-later
"""Pictures of slopes and samples. Every function draws into Matplotlib axes that the caller gives (and may compose) and returns
them, takes plain arrays, and needs no display; figure() makes a figure that can be saved without one.

Ground:  ground (a field in contour bands, with outline, thaw front, start and arrows), slopeHistory (rows = times, columns = fields)
Points:  slopeField, markPoints; isolines, thawFront and profile return what they make
Sample:  forceChains, sampleForces, normalRose, stressPath, bondHistory
"""

import io
from dataclasses import dataclass
from pathlib import Path as FilePath

import numpy as np
from matplotlib import colormaps
from matplotlib.cm import ScalarMappable
from matplotlib.collections import EllipseCollection, LineCollection, PolyCollection
from matplotlib.colors import BoundaryNorm, Colormap, LinearSegmentedColormap, Normalize
from matplotlib.figure import Figure
from matplotlib.lines import Line2D
from matplotlib.path import Path
from matplotlib.patheffects import withStroke
from matplotlib.ticker import MaxNLocator
from matplotlib.tri import Triangulation

from talik import ranks
from talik.files import writableFolder
from talik.resampling import Resampled, atStart, groundOf, inPlane

# state of a contact, as the ice-bond law counts it
contactNone, contactBonded, contactBroken = 0, 1, 2

# thawed ground is brown, frozen ground blue; neither is white, as the air is
thawedToFrozen = "talik.thawedToFrozen"
_thawedToFrozenColours = ["#a67c4e", "#d8c3a0", "#d3e3ee", "#74add1", "#2b6cb0", "#0b3a73"]
colormaps.register(LinearSegmentedColormap.from_list(thawedToFrozen, _thawedToFrozenColours), force=True)
frontColour, frontSaturation = "crimson", 0.5  # of the thaw front

# what is known about the usual fields: label, colour map, limits (None: from the data)
slopeFields = {
	"iceSaturation": ("ice saturation $S_i$ [-]", thawedToFrozen, (0.0, 1.0)),
	"deviatoricStrain": (r"deviatoric strain $\varepsilon_d$ [-]", "YlOrRd", (0.0, None)),
	"displacement": ("displacement $|u|$ [m]", "viridis", (0.0, None)),
	"velocity": ("speed $|v|$ [m/s]", "viridis", (0.0, None)),
	"temperature": ("temperature [°C]", "coolwarm", (None, None)),
	"pressure": ("pore pressure [Pa]", "PuOr_r", (None, None)),
	"settlement": ("settlement [m]", "RdBu_r", (None, None)),
}
rising = ("deviatoricStrain",)  # fields whose bands widen with their values, 1 : 2 : 5
symmetric = ("temperature", "settlement")  # fields whose colours are centred on 0


class _Figure(Figure):
	"""A figure that a notebook shows."""

	def _repr_png_(self):
		picture = io.BytesIO()
		self.savefig(picture, format="png", dpi=100)
		return picture.getvalue()


def figure(width, height):
	"""A figure of width x height inches that needs no display; add axes with fig.subplots(...). A notebook shows it where it ends a cell.

	>>> axes = talik.plots.figure(6, 4).subplots()"""
	return _Figure(figsize=(width, height), layout="constrained")


def save(fig, path, dpi=150):
	"""Writes a picture, making its folder if need be; in a job of several ranks rank 0 does.

	>>> picture = talik.plots.save(talik.plots.figure(6, 4), folder + "/picture.png")"""
	path = FilePath(path)
	if not ranks.first:
		return str(path)
	writableFolder(path.parent)
	fig.savefig(path, dpi=dpi)
	return str(path)


# --- ground ----------------------------------------------------------------------------------------------------------------


@dataclass(frozen=True)
class Bands:
	"""Colours of a field in bands between levels.

	>>> talik.plots.Bands("settlement [mm]", np.array([0, 1, 2, 5]), "viridis").extend
	'neither'"""

	label: str
	levels: np.ndarray
	colourMap: object  # name or Colormap of Matplotlib
	extend: str = "neither"  # neither, min, max or both: where values lie beyond the levels

	@property
	def map(self):
		return self.colourMap if isinstance(self.colourMap, Colormap) else colormaps[self.colourMap]

	@property
	def norm(self):
		return BoundaryNorm(self.levels, self.map.N, extend=self.extend)


def bandsOf(field, values, label=None, colourMap=None, levels=None, limits=(None, None)):
	"""Colours for a field: round levels over its range, about ten of them.

	field   a name in slopeFields has label, colours and limits of its own; else the name is the label
	values  (n,) or (n, 2), or a list of such arrays of all pictures that share the colours; vectors by their length
	levels  ascending [in units of the field], or None; limits (lowest, highest) of the levels, None: those of the values

	>>> talik.plots.bandsOf("displacement", mpm.field("displacement")).label
	'displacement $|u|$ [m]'"""
	usual = slopeFields.get(field, (field, "viridis", (None, None)))
	columns = values if isinstance(values, (list, tuple)) else [values]
	low, high = finiteRange(np.concatenate([magnitude(column) for column in columns]))
	given = [mine if mine is not None else common for mine, common in zip(limits, usual[2])]
	first, last = (found if limit is None else limit for limit, found in zip(given, (low, high)))
	if levels is None:
		levels = _levels(first, last, field in rising and first == 0, field in symmetric and given == [None, None])
	levels = np.asarray(levels, dtype=float)
	chosen = colourMap or usual[1]
	if field in symmetric and colourMap is None and (levels[0] >= 0 or levels[-1] <= 0):
		chosen = _half(chosen, levels[0] >= 0)
	slack = 1e-6 * (levels[-1] - levels[0])
	ends = low < levels[0] - slack, high > levels[-1] + slack
	extend = {(False, False): "neither", (True, False): "min", (False, True): "max", (True, True): "both"}[ends]
	return Bands(label or usual[0], levels, chosen, extend)


def _half(name, upper):
	"""Colours of the values on one side of 0."""
	return LinearSegmentedColormap.from_list(name, colormaps[name](np.linspace(0.5, 1, 128) if upper else np.linspace(0, 0.5, 128)))


def _levels(low, high, widening=False, centred=False):
	if centred and low < 0 < high:
		high = max(-low, high)
		low = -high
	if not high - low > 1e-9 * max(abs(low), abs(high)):
		high = low + (abs(low) or 1.0)
	if widening:
		rows = [mantissa * 10.0**power for power in range(-12, 13) for mantissa in (1, 2, 5)]
		last = next(place for place, row in enumerate(rows) if row >= high * (1 - 1e-9))
		return np.array([0.0, *rows[last - 6 : last + 1]])
	ticks = MaxNLocator(10, steps=[1, 2, 2.5, 5, 10]).tick_values(low, high)
	spacing = ticks[1] - ticks[0]
	return ticks[(ticks > low - spacing * (1 - 1e-6)) & (ticks < high + spacing * (1 - 1e-6))]


def ground(axes, frame, field, bands=None, bar=True, front=True, start=True, arrows=None, watched=None, surface=None, isotherms=(), layers=None, **colours):
	"""Ground in the plane as it is seen: a field in contour bands, the outline of the ground, the thaw front, and where the ground was at the start.

	frame    {"position": (n, 2) [m], "volume": (n,) [m2], field: (n,) or (n, 2), ...}, as talik.output.allFields(mpm) and Frames have it
	field    name of a field of the frame, vectors by their length, or values (n,); whole numbers (n,) are kinds of ground: each place is of the kind of
			 most of its points. "settlement" is the way down of the points, negative where they heaved
	bands    of bandsOf, where several pictures share their colours; else made with **colours: label, colourMap, levels, limits as there
	bar      a colour bar beside the axes, and a legend of the front
	front    crimson line where the ice saturation of the frame is 1/2
	start    dashed outline of the ground before its displacement; or the Resampled of the ground then
	arrows   name of a vector of the frame, "displacement" or "velocity": its direction, where it is above 10 % of its largest, or of the top of the
			 bands if they show it
	watched  {letter: (x, y)} marked points
	surface  talik.resampling.Resampled of the frame, where it was made already
	isotherms  temperatures [degC] whose lines are drawn with their labels
	layers   number (n,) of the layer of each point, such as mpm.materialOf: borders between layers are drawn

	The field is resampled from the points, each a kernel of its area stretched at most 1 : 2 as its "deformationGradient" says; ground is drawn over
	the area of its points within 1 % (talik.resampling). slopeField draws the points themselves. Returns the axes.

	>>> drawn = talik.plots.ground(axes, talik.output.allFields(mpm), "temperature", arrows="displacement")"""
	values = valuesOf(frame, field) if isinstance(field, str) else field
	surface = surface or surfaceOf(frame)
	bands = bands or bandsOf(field if isinstance(field, str) else "", values, **colours)
	area = Path(*surface.polygons())
	drawBands(axes, surface.x, surface.y, _kinds(surface, values) if _areKinds(field) else surface(magnitude(values)), area, bands)
	for line in surface.outline():
		axes.plot(*line.T, color="0.15", linewidth=0.9, solid_joinstyle="round")
	seen = [surface]
	for number in np.unique(layers)[1:] if layers is not None else ():
		border = surface((np.asarray(layers) >= number).astype(float))
		_clip(axes, axes.contour(surface.x, surface.y, np.ma.masked_invalid(border), levels=[0.5], colors="0.25", linewidths=0.8, linestyles=":"), area)
	if len(isotherms):
		raster = np.ma.masked_invalid(surface(frame["temperature"]))
		lines = axes.contour(surface.x, surface.y, raster, levels=sorted(isotherms), colors="black", linewidths=0.7)
		_clip(axes, lines, area)
		axes.clabel(lines, fmt=lambda level: f"{level:g} °C", fontsize=8)
	if front and "iceSaturation" in frame:
		frontLine(axes, surface.x, surface.y, surface(frame["iceSaturation"]), surface.ground, area)
	if start and "displacement" in frame:
		seen.append(start if isinstance(start, Resampled) else startOf(frame))
		for line in seen[1].outline():
			axes.plot(*line.T, color="0.35", linewidth=0.8, linestyle=(0, (4, 3)))
	if arrows is not None:
		_arrows(axes, surface, surface(inPlane(frame[arrows])), bands.levels[-1] if isinstance(field, str) and arrows == field else 0.0)
	markPoints(axes, watched or {})
	metricAxes(axes, np.vstack([line for one in seen for line in one.outline()]), margin=0.01)
	axes.set_xlabel("x [m]")
	axes.set_ylabel("y [m]")
	for side in ("top", "right"):
		axes.spines[side].set_visible(False)
	if bar:
		colourBar(axes, bands)
		legendOfLines(axes)
	return axes


def valuesOf(frame, field):
	"""Values (n,) or (n, 2) of a field of a frame, by its name; "settlement" is the way down.

	>>> frame = {"displacement": np.array([[0.0, -0.1]])}
	>>> talik.plots.valuesOf(frame, "settlement")
	array([0.1])"""
	if field == "settlement":
		return -frame["displacement"][:, -1]
	if field not in frame:
		raise ValueError(f"there is no field '{field}' among those that were kept; choose one of settlement, {', '.join(sorted(frame))}")
	return frame[field]


def _areKinds(field):
	return not isinstance(field, str) and np.issubdtype(np.asarray(field).dtype, np.integer)


def _kinds(surface, numbers):
	known, place = np.unique(numbers, return_inverse=True)
	return known[np.argmax(surface(np.eye(len(known))[place]), axis=2)].astype(float)


def surfaceOf(frame):
	"""talik.resampling.Resampled of the points of a frame.

	>>> round(talik.plots.surfaceOf(talik.output.allFields(mpm)).area() / mpm.field("volume").sum(), 2)
	1.0"""
	return groundOf(frame)


def startOf(frame):
	"""The same before its displacement and strain.

	>>> start = talik.plots.startOf(talik.output.allFields(mpm))"""
	return Resampled(*atStart(frame))


def drawBands(axes, x, y, field, outline, bands):
	"""Contour bands of a field (y, x) on a raster, within an outline (matplotlib.path.Path).

	>>> surface = talik.plots.surfaceOf(talik.output.allFields(mpm))
	>>> area = talik.plots.Path(*surface.polygons())
	>>> T = mpm.field("temperature")
	>>> talik.plots.drawBands(axes, surface.x, surface.y, surface(T), area, talik.plots.bandsOf("temperature", T))"""
	slack = 1e-6 * (bands.levels[-1] - bands.levels[0])  # round-off in values that equal a level is no border
	highest = None if bands.extend in ("max", "both") else bands.levels[-1] - 2 * slack
	inside = np.clip(field, None if bands.extend in ("min", "both") else bands.levels[0], highest)
	filled = axes.contourf(x, y, np.ma.masked_invalid(inside), levels=bands.levels - slack, cmap=bands.map, norm=bands.norm, extend=bands.extend)
	_clip(axes, filled, outline)


def frontLine(axes, x, y, ice, inGround, outline):
	"""The line within an outline where the ice saturation (y, x) of a raster is 1/2; nothing where there is no front.

	>>> surface = talik.plots.surfaceOf(talik.output.allFields(mpm))
	>>> talik.plots.frontLine(axes, surface.x, surface.y, surface(mpm.field("iceSaturation")), surface.ground, talik.plots.Path(*surface.polygons()))"""
	low, high = finiteRange(ice[inGround])
	if low < frontSaturation < high:
		_clip(axes, axes.contour(x, y, np.ma.masked_invalid(ice), levels=[frontSaturation], colors=frontColour, linewidths=1.4), outline)
		axes.plot([], [], color=frontColour, linewidth=1.4, label="front, $S_i = 0.5$")  # for a legend


def legendOfLines(axes):
	"""Legend of the lines in a picture of ground that have names, such as the front. Returns the axes.

	>>> drawn = talik.plots.legendOfLines(talik.plots.ground(axes, talik.output.allFields(mpm), "temperature"))"""
	if axes.get_legend_handles_labels()[0]:
		axes.legend(fontsize=8, loc="best", framealpha=0.8, edgecolor="none")
	return axes


def _clip(axes, contours, outline):
	for collection in getattr(contours, "collections", [contours]):  # one of each level in Matplotlib 3.6, one of all in 3.10
		collection.set_clip_path(outline, transform=axes.transData)


def _arrows(axes, surface, vectors, largest, across=24):
	"""Directions of a vector field (y, x, 2), about so many over the width of the ground, where it is above a tenth of its largest, or of `largest`."""
	step = surface.x[1] - surface.x[0]
	every = max(1, round(np.ptp(surface.x) / across / step))
	chosen = (slice(every // 2, None, every), slice(every // 2, None, every))
	x, y, vectors = surface.x[chosen[1]], surface.y[chosen[0]], vectors[chosen]
	size = np.where(surface.ground[chosen], np.nan_to_num(np.linalg.norm(vectors, axis=2)), 0.0)
	shown = size > 0.1 * max(size.max(initial=0), largest, 1e-300)
	if not shown.any():
		return
	u, v = (vectors[..., k][shown] / size[shown] for k in (0, 1))
	xs, ys = (grid[shown] for grid in np.meshgrid(x, y))
	length = 0.75 * every * step
	axes.quiver(
		xs,
		ys,
		u * length,
		v * length,
		angles="xy",
		scale_units="xy",
		scale=1,
		pivot="mid",
		width=0.0035,
		headwidth=4,
		color="white",
		edgecolor="0.2",
		linewidth=0.25,
	)


def colourBar(axes, bands, **style):
	"""Colour bar of bands beside axes, or beside several that share it; style: of Matplotlib's colorbar. Returns the bar.

	>>> bar = talik.plots.colourBar(axes, talik.plots.bandsOf("temperature", mpm.field("temperature")))"""
	figure = (axes if hasattr(axes, "figure") else np.ravel(axes)[0]).figure
	axes = axes if hasattr(axes, "figure") else list(np.ravel(axes))
	every = 1 if len(bands.levels) <= 8 else 2
	largest = np.abs(bands.levels).max()
	power = 0 if 1e-3 <= largest < 1e5 else 3 * int(np.floor(np.log10(largest) / 3))
	label = bands.label if power == 0 else _withPower(bands.label, power)
	style = {"label": label, "ticks": bands.levels[::every], "spacing": "uniform", "shrink": 0.85, **style}
	bar = figure.colorbar(ScalarMappable(bands.norm, bands.map), ax=axes, **style)
	bar.ax.minorticks_off()
	bar.formatter = lambda value, _: f"{value / 10.0**power:.6g}".replace("-", "\u2212")
	bar.update_ticks()
	return bar


def _withPower(label, power):
	"""A label whose unit is 10^power times as large."""
	factor = f"$10^{{{power}}}$"
	return label.replace("[-]", f"[{factor}]") if "[-]" in label else label.replace("[", f"[{factor} ")


# --- points ----------------------------------------------------------------------------------------------------------------


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


def _squares(axes, position, values, volume, colourMap, limits, deformation=None):
	position, values = inPlane(position), magnitude(values)
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
	position, values = inPlane(position), magnitude(values)
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

	position, values = inPlane(position), magnitude(values)
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
	fig = into or figure(4.2 * len(fields), historyHeight(frames))
	grid = fig.subplots(len(frames), len(fields), squeeze=False, sharex=True, sharey=True)
	surfaces = [surfaceOf(frame) for frame in frames]
	starts = [startOf(frame) if "displacement" in frame else False for frame in frames]
	for column, name in enumerate(fields):
		shared = bandsOf(name, [frame[name] for frame in frames])
		for axes, frame, surface, start in zip(grid[:, column], frames, surfaces, starts):
			arrows = name if name in ("displacement", "velocity") else None
			ground(axes, frame, name, shared, bar=False, start=start, arrows=arrows, watched=_placesOf(watched, frame), surface=surface)
			axes.set(xlabel="", ylabel="")
			if name in (lines or {}):
				isolines(axes, frame["position"], frame[name], frame["volume"], lines[name])
			if arrows:
				axes.set_title(f"largest {magnitude(frame[name]).max():.2g} {'m' if name == 'displacement' else 'm/s'}", loc="right", fontsize=9)
		colourBar(grid[:, column], shared, location="bottom", aspect=30)
	for row, frame in enumerate(frames):
		grid[row, 0].set_title(timeLabel(frame["time"], frame.get("day")), loc="left", fontsize=10)
		grid[row, 0].set_ylabel("y [m]")
	for axes in grid[-1]:
		axes.set_xlabel("x [m]")
	metricAxes(grid[0, 0], _ends(frames), margin=0.01)
	return fig


def slopeFilm(fig, frames, fields, watched=None, limits=(None, None)):
	"""Makes axes and colour bars for pictures of one slope at many times; returns the function that draws a frame in place of the one before.

	frames, watched as in slopeHistory; fields: a name, or several that are drawn one above the other; limits (lowest, highest) value of the
	colours of the first, None: from all frames. See talik.movie.

	>>> frames = talik.output.Frames(mpm, times=[0])
	>>> frames.take()
	>>> draw = talik.plots.slopeFilm(talik.plots.figure(6, 4), frames.frames, "displacement")
	>>> draw(frames.frames[0])"""
	names = [fields] if isinstance(fields, str) else list(fields)
	panels = fig.subplots(len(names), 1, squeeze=False, sharex=True)[:, 0]
	shared = [bandsOf(name, [frame[name] for frame in frames], limits=limits if name == names[0] else (None, None)) for name in names]
	for axes, colours in zip(panels, shared):
		colourBar(axes, colours, location="right" if len(names) > 1 else "bottom", aspect=20 if len(names) > 1 else 40)
	ends = _ends(frames)

	def draw(frame):
		surface, start = surfaceOf(frame), startOf(frame) if "displacement" in frame else False
		for axes, name, colours in zip(panels, names, shared):
			axes.clear()
			arrows = name if name in ("displacement", "velocity") else None
			ground(axes, frame, name, colours, bar=False, start=start, arrows=arrows, watched=_placesOf(watched, frame), surface=surface)
			metricAxes(axes, ends, margin=0.01)
			axes.set(xlabel="", ylabel="y [m]")
		panels[-1].set_xlabel("x [m]")
		panels[0].set_title(timeLabel(frame["time"], frame.get("day")), loc="left", fontsize=10)

	return draw


def _ends(frames):
	"""Corners (2, 2) [m] of the box around the points of all frames and where they were at the start."""
	low, high = [], []
	for frame in frames:
		half = 0.5 * np.sqrt(np.median(frame["volume"]))
		for position in [frame["position"]] + ([frame["position"] - frame["displacement"]] if "displacement" in frame else []):
			low.append(position.min(axis=0) - half)
			high.append(position.max(axis=0) + half)
	return np.array([np.min(low, axis=0), np.max(high, axis=0)])


def historyHeight(frames):
	"""Height of slopeHistory [inch] at its usual width of 4.2 for each field.

	>>> frames = talik.output.Frames(mpm, times=[0])
	>>> frames.take()
	>>> height = talik.plots.historyHeight(frames.frames)"""
	extent = np.ptp(_ends(frames), axis=0)
	return (3.75 * max(extent[1] / extent[0], 0.2) + 0.36) * len(frames) + 1.15


def _placesOf(watched, frame):
	return {letter: frame["position"][point] if np.ndim(point) == 0 else point for letter, point in (watched or {}).items()}


def timeLabel(time, day=None):
	"""Time of motion [s] and, where heat has a calendar of its own, the day.

	>>> talik.plots.timeLabel(2.0, day=20)
	'day 20 (2 s of motion)'"""
	return f"t = {time:.3g} s" if day is None else f"day {day:.3g} ({round(time, 2):.3g} s of motion)"


def calendarHistory(axes, history, events, label=None):
	"""Largest displacement over the days of the calendar, events marked by what they moved.

	history  rows of day, time of motion [s], largest displacement [m]
	events   of MpmEngine.events()

	>>> talik.plots.calendarHistory(talik.plots.figure(5, 3).subplots(), [(0, 0, 0), (1, 0.1, 0.02)], [{"day": 0.5, "days": 0.01, "volume": 1.5, "largest": 0.02}])
	"""
	history = np.asarray(history, dtype=float).reshape(-1, 3)
	(line,) = axes.plot(history[:, 0], history[:, 2], linewidth=1.2, marker=".", markersize=3, label=label)
	for event in events:
		axes.axvspan(event["day"], event["day"] + event["days"], color=line.get_color(), alpha=0.25, linewidth=1)
	apart, named = 0.04 * np.ptp(history[:, 0]), []
	for event in sorted(events, key=lambda event: -event["volume"]):
		if len(named) == 5 or any(abs(event["day"] - day) < apart for day in named):
			continue
		named.append(event["day"])
		axes.annotate(f"{event['volume']:.2g} m² move", (event["day"], 0.98), xycoords=("data", "axes fraction"), rotation=90, va="top", ha="right", fontsize=7)
	axes.set(xlabel="day", ylabel="largest displacement [m]")
	axes.set_ylim(bottom=0, top=max(1.15 * finiteRange(history[:, 2])[1], 1e-6) if len(history) else None)


def metricAxes(axes, position, margin=0.03):
	"""Equal scales and limits around the points, with a margin of so much of their extent.

	>>> talik.plots.metricAxes(axes, mpm.field("position"))"""
	position = np.asarray(position, dtype=float)
	low, high = position.min(axis=0), position.max(axis=0)
	margin = margin * max((high - low).max(), 1e-12)
	axes.set_aspect("equal")
	axes.set_xlim(low[0] - margin, high[0] + margin)
	axes.set_ylim(low[1] - margin, high[1] + margin)
	axes.ticklabel_format(useOffset=False, style="plain")


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


def _longestSides(mesh):
	corners = np.column_stack([mesh.x, mesh.y])[mesh.triangles]
	return np.linalg.norm(corners - np.roll(corners, 1, axis=1), axis=2).max(axis=1)


# --- sample ----------------------------------------------------------------------------------------------------------------


def forceChains(axes, start, end, force, state, centre=None, radius=None, widest=6.0, legend=True, cell=None):
	"""Contacts as lines between the grains, width by force: intact bonds red, broken or frictional contacts black.

	start, end  (n, 2) [m] ends of the branch vectors; force (n,) [N], its size is drawn; state (n,) 0 frictional, 1 bonded, 2 broken
	centre      (m, 2) and radius (m,) [m] of the grains, drawn pale behind
	widest      width in points of the largest force; contacts without force keep a hair line
	cell        (2, 2) [m] rows are the sides of the periodic cell, from the origin, drawn as a dotted parallelogram; contacts go on beyond it
	Returns the axes.

	>>> drawn = talik.plots.forceChains(axes, start=[(0, 0)], end=[(0.01, 0)], force=[5.0], state=[1])"""
	start, end = np.asarray(start, dtype=float).reshape(-1, 2), np.asarray(end, dtype=float).reshape(-1, 2)
	force, state = np.abs(np.asarray(force, dtype=float)), np.asarray(state, dtype=int)
	_grains(axes, centre, radius)
	corners = np.zeros((0, 2))
	if cell is not None:
		first, second = np.asarray(cell, dtype=float)
		corners = np.array([0 * first, first, first + second, second, 0 * first])
		axes.plot(*corners.T, color="0.5", linewidth=0.8, linestyle=":", zorder=1)
	width = 0.3 + widest * force / (force.max() if force.size and force.max() > 0 else 1.0)
	segments = np.stack([start, end], axis=1)
	bonded = state == contactBonded
	for chosen, colour, layer in ((~bonded, "black", 2), (bonded, "red", 3)):
		axes.add_collection(LineCollection(segments[chosen], linewidths=width[chosen], colors=colour, capstyle="round", zorder=layer))
	shown = [points for points in (start, end, centre, corners) if points is not None and len(points)]
	if shown:
		metricAxes(axes, np.vstack(shown))
	axes.locator_params(axis="x", nbins=4)  # labels of millimetres are wide
	axes.set_xlabel("x [m]")
	axes.set_ylabel("y [m]")
	if legend:
		_forceLegend(axes, force, bonded)
	return axes


def sampleForces(axes, sample, **style):
	"""forceChains of a sample as talik.packing.sampleArrays() gives it: normal forces, bond states, grains. Returns the axes.

	>>> with mpm.inspect(5):
	...     drawn = talik.plots.sampleForces(axes, talik.packing.sampleArrays())"""
	style = {"cell": sample.get("cell"), **style}
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
	axes.legend(handles=handles, title=f"widest: {float(f'{largest:.3g}'):g} N", ncol=2, frameon=False, fontsize=8, title_fontsize=8, **below)
