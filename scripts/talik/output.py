# SPDX-License-Identifier: GPL-2.0-or-later
"""Files that a run leaves behind: a ParaView series of all point fields, frames for pictures, a summary.

	series = talik.output.ParaViewSeries(mpm, "output/slope")  # open output/slope/surface.pvd
	frames = talik.output.Frames(mpm, times=[2.5, 5, 10, 15])  # or days=True: days of the calendar
	O.engines = [mpm, talik.output.runner(series.write, iterPeriod=100), frames.runner()]
	talik.output.writeSummary("output/slope/summary.json", points=mpm.pointCount, ...)

Of several ranks (talik.ranks) the first one writes.
An engine is anything with fieldNames() and field(name) -> array (n,) or (n, components); "position" (n, 2) or (n, 3) must be among them.
"""

import io
import json
import math
import os
from pathlib import Path

import numpy as np
from vtkmodules.util.numpy_support import numpy_to_vtk, numpy_to_vtkIdTypeArray
from vtkmodules.vtkCommonCore import vtkPoints
from vtkmodules.vtkCommonDataModel import VTK_LINE, VTK_TRIANGLE, VTK_VERTEX, vtkCellArray, vtkUnstructuredGrid
from vtkmodules.vtkIOXML import vtkXMLUnstructuredGridWriter

from talik import dates, ranks
from talik.files import writableFolder, writeWhole
from talik.resampling import SpaceRaster, groundOf, surfaceLevel

surfaceNodes = 1.5  # of the raster of a surface for ParaView along the side of a point: as smooth as the fields are, in a small file
tensorComponents = {3: ("xx", "yy", "xy"), 4: ("xx", "yy", "zz", "xy"), 6: ("xx", "yy", "zz", "yz", "xz", "xy")}  # of stress and strain
matrixComponents = {4: ("xx", "xy", "yx", "yy"), 9: tuple(a + b for a in "xyz" for b in "xyz")}  # of gradients
_callbacks = []


def call(place):
	"""Called by the engines that runner() made.

	>>> talik.output.runner(lambda: None, iterPeriod=10).command.startswith("import talik.output; talik.output.call(")
	True"""
	_callbacks[place]()


def runner(function, **period):
	"""A YADE PyRunner that calls a Python function; period: iterPeriod, virtPeriod or realPeriod.

	>>> O.engines = O.engines + [talik.output.runner(lambda: print(O.time), iterPeriod=100)]"""
	from yade.wrapper import PyRunner

	_callbacks.append(function)
	return PyRunner(command=f"import talik.output; talik.output.call({len(_callbacks) - 1})", **period)


def allFields(mpm):
	"""{name: array} of every field that the engine has.

	>>> talik.output.allFields(mpm)["temperature"].shape
	(16,)"""
	return {name: np.array(mpm.field(name)) for name in mpm.fieldNames()}


def columns(name, values):
	"""{name with component: array (n,)} of a field (n,) or (n, components): "stress xy", "displacement x".

	>>> list(talik.output.columns("displacement", np.zeros((3, 2))))
	['displacement x', 'displacement y']"""
	values = np.asarray(values)
	if values.ndim == 1:
		return {name: values}
	count = values.shape[1]
	gradient = name.lower().endswith("gradient") and count in matrixComponents
	parts = "xyz"[:count] if count in (2, 3) and not _isTensor(name) else matrixComponents[count] if gradient else tensorComponents.get(count, range(count))
	return {f"{name} {part}": values[:, k] for k, part in enumerate(parts)}


def _isTensor(name):
	return any(word in name.lower() for word in ("stress", "strain"))


def table(mpm, fields=None):
	"""All points of a ground as a table with flat names, "position x", "stress xy", in the order of their ids: a DataFrame where pandas is installed (Debian:
	python3-pandas), else a dictionary of arrays (n,), which pandas.DataFrame takes.

	fields  names of mpm.fieldNames(); default: all

	>>> points = talik.output.table(mpm, ["position", "temperature"])
	>>> list(points)
	['position x', 'position y', 'temperature']"""
	unknown = [name for name in fields or () if name not in mpm.fieldNames()]
	if unknown:
		raise ValueError(f"table: there is no field '{unknown[0]}'; choose among {', '.join(mpm.fieldNames())}")
	found = {}
	for name in fields or mpm.fieldNames():
		found.update(columns(name, mpm.field(name)))
	try:
		from pandas import DataFrame
	except ImportError:
		return found
	return DataFrame(found)


# --- ParaView --------------------------------------------------------------------------------------------------------------


def contacts(mpm, ids=None):
	"""Contacts of the samples behind many points as one dictionary of arrays with a row for each contact: point (id), and start, end, normal, normalForce,
	shearForce and state as talik.packing.sampleArrays has them.

	ids  of the points; default: all that have a sample

	>>> found = talik.output.contacts(mpm, ids=[0, 5])
	>>> sorted(set(found["point"].tolist())), found["normalForce"].shape == found["state"].shape
	([0, 5], True)"""
	from talik import inspection, packing

	names = ("start", "end", "normal", "normalForce", "shearForce", "state")
	found = []
	for id in np.flatnonzero(np.isfinite(mpm.field("contacts"))) if ids is None else ids:
		with inspection.inspectPoint(mpm, id):
			sample = packing.sampleArrays()
		found.append({"point": np.full(len(sample["state"]), int(id)), **{name: sample[name] for name in names}})
	return {name: np.concatenate([one[name] for one in found]) for name in ("point", *names)} if found else {}


class ParaViewSeries:
	"""The ground for ParaView in `folder`: open surface.pvd, the ground as a surface with the fields of its points, or points.pvd, the points
	themselves. Times are those of `clock`, default O.time; lambda: mpm.calendar["day"] gives days.

	name     of the files of points, <name>.pvd and <name>_<number>.vtu; those of surfaces begin with <name>_ too, if it is not "points"
	surface  False: points only. A surface takes a tenth of a second for 1500 points, and as much room as they

	>>> file = talik.output.ParaViewSeries(mpm, folder).write()"""

	def __init__(self, mpm, folder, name="points", clock=None, surface=True):
		self.mpm, self.name, self.surface = mpm, name, surface
		self.surfaceName = "surface" if name == "points" else f"{name}_surface"
		self.folder = writableFolder(folder)
		self.clock = clock or _sceneTime
		self.entries = []

	def write(self):
		"""Adds the present state; returns the path of the new .vtu file of points."""
		number, time = len(self.entries), self.clock()
		file = f"{self.name}_{number:05d}.vtu"
		fields = allFields(self.mpm)
		box = [getattr(self.mpm, corner, None) for corner in ("lower", "upper")]
		writePoints(self.folder / file, fields["position"], {name: values for name, values in fields.items() if name != "position"})
		self.entries.append((time, file))
		writeCollection(self.folder / f"{self.name}.pvd", self.entries)
		if self.surface and "volume" in fields:
			writeSurface(self.folder / f"{self.surfaceName}_{number:05d}.vtu", fields, *box)
			writeCollection(self.folder / f"{self.surfaceName}.pvd", [(when, self._surfaceOf(place)) for place, (when, *_) in enumerate(self.entries)])
		return str(self.folder / file)

	def _surfaceOf(self, number):
		return f"{self.surfaceName}_{number:05d}.vtu"


def writeSurface(path, frame, lower=None, upper=None):
	"""One .vtu file of the ground as a surface with all fields of a frame, {"position": ..., "volume": ..., name: array by point}, in single precision. In the
	plane it is filled and covers the area of its points within 1 % (talik.resampling); in space it is closed, and needs the corners of the grid
	`lower`, `upper` [m].

	>>> talik.output.writeSurface(folder + "/surface.vtu", talik.output.allFields(mpm))"""
	if not ranks.first:
		return
	fields = {name: np.asarray(values, dtype=float) for name, values in frame.items() if np.ndim(values) in (1, 2) and name != "position"}
	draw = _surfaceInPlane if np.shape(frame["position"])[1] == 2 else _surfaceInSpace
	columns = [(name, values.reshape(len(values), -1)) for name, values in fields.items()]
	points, cells, cellType, shown = draw(frame, np.column_stack([column for _, column in columns]), lower, upper)
	ends = np.cumsum([0] + [column.shape[1] for _, column in columns])
	parts = {name: shown[:, first:last].astype(np.float32) for (name, _), first, last in zip(columns, ends, ends[1:])}
	_writeGrid(path, points, cells, cellType, {name: part[:, 0] if part.shape[1] == 1 else part for name, part in parts.items()}, {})


def _surfaceInPlane(frame, columns, lower, upper):
	"""Triangles of the raster, those on the outline cut there."""
	ground = groundOf(frame, surfaceNodes)
	points, triangles, rows, weights = ground.triangles()
	values = ground(np.nan_to_num(columns)).reshape(-1, columns.shape[1])
	for gappy in np.flatnonzero(~np.isfinite(columns).all(axis=0)):
		values[:, gappy] = ground(columns[:, gappy]).ravel()
	return points, triangles, VTK_TRIANGLE, (weights[:, :1] * values[rows[:, 0]] + weights[:, 1:] * values[rows[:, 1]])


def _surfaceInSpace(frame, columns, lower, upper):
	position = np.asarray(frame["position"], dtype=float)
	if lower is None or upper is None:
		lower, upper = position.min(axis=0), position.max(axis=0)
	raster = SpaceRaster(position, frame["volume"], lower, upper)
	filled = raster.smeared(1.0)
	means = [raster.smeared(column) / np.maximum(filled, 1e-12) for column in np.nan_to_num(columns).T]
	vertices, triangles, shown = raster.contour(filled / surfaceLevel, 1.0, means)
	return vertices, triangles, VTK_TRIANGLE, np.column_stack(shown)


def writePoints(path, position, fields):
	"""One .vtu file of points (n, 2) or (n, 3) with fields {name: array}.

	>>> talik.output.writePoints(folder + "/points.vtu", mpm.field("position"), {"temperature": mpm.field("temperature")})"""
	position = np.asarray(position, dtype=float)
	cells = np.arange(len(position)).reshape(-1, 1)
	_writeGrid(path, position, cells, VTK_VERTEX, pointFields=fields, cellFields={})


def writeSegments(path, start, end, fields):
	"""One .vtu file of line segments, for contacts: start and end (n, 2) or (n, 3), fields one value per segment.

	>>> talik.output.writeSegments(folder + "/lines.vtu", [(0, 0)], [(1, 1)], {"force": np.array([3.0])})"""
	points = np.vstack([np.asarray(start, dtype=float), np.asarray(end, dtype=float)])
	count = len(points) // 2
	_writeGrid(path, points, np.column_stack([np.arange(count), np.arange(count) + count]), VTK_LINE, pointFields={}, cellFields=fields)


def writeCollection(path, entries):
	"""A .pvd file of (time, file) or (time, file, part): several files at one time are its parts.

	>>> talik.output.writeCollection(folder + "/points.pvd", [(0.0, "points_0.vtu"), (0.1, "points_1.vtu")])"""
	lines = [f'\t\t<DataSet timestep="{time:.17g}" part="{part[0] if part else 0}" file="{file}"/>' for time, file, *part in entries]
	if not ranks.first:
		return
	text = '<?xml version="1.0"?>\n<VTKFile type="Collection" version="0.1" byte_order="LittleEndian">\n\t<Collection>\n'
	writeWhole(path, text + "\n".join(lines) + "\n\t</Collection>\n</VTKFile>\n")


def _writeGrid(path, points, cells, cellType, pointFields, cellFields):
	if not ranks.first:
		return
	grid = vtkUnstructuredGrid()
	grid.SetPoints(_vtkPoints(points))
	grid.SetCells(cellType, _vtkCells(cells))
	for fields, data, count in ((pointFields, grid.GetPointData(), len(points)), (cellFields, grid.GetCellData(), len(cells))):
		for name, values in fields.items():
			data.AddArray(_vtkArray(name, values, count))
	writer = vtkXMLUnstructuredGridWriter()
	writer.SetFileName(str(path))
	writer.SetInputData(grid)
	if writer.Write() != 1:
		raise OSError(f"'{path}' could not be written; is the folder yours and the disk not full?")


def _vtkPoints(position):
	points = vtkPoints()
	points.SetData(numpy_to_vtk(_padded(position), deep=True))
	return points


def _vtkCells(cells):
	array = vtkCellArray()
	offsets = np.arange(0, cells.size + 1, cells.shape[1], dtype=np.int64)
	array.SetData(numpy_to_vtkIdTypeArray(offsets, deep=True), numpy_to_vtkIdTypeArray(cells.ravel().astype(np.int64), deep=True))
	return array


def _vtkArray(name, values, count):
	values = np.asarray(values)
	if values.ndim not in (1, 2) or len(values) != count:
		raise ValueError(f"field '{name}' has shape {values.shape}; it must have {count} rows")
	if values.dtype == bool:
		values = values.astype(np.uint8)
	if values.ndim == 2 and values.shape[1] == 2:
		values = _padded(values).astype(values.dtype if values.dtype == np.float32 else float)
	array = numpy_to_vtk(np.ascontiguousarray(values), deep=True)
	array.SetName(name)
	if values.ndim == 2 and _isTensor(name):
		for component, label in enumerate(tensorComponents.get(values.shape[1], ())):
			array.SetComponentName(component, label)
	return array


def _padded(vectors):
	"""ParaView's vectors have three components."""
	vectors = np.asarray(vectors, dtype=float)
	if vectors.shape[1] == 3:
		return np.ascontiguousarray(vectors)
	return np.column_stack([vectors, np.zeros(len(vectors))])


class SampleSeries:
	"""The scene that is current in O, a sample of grains: files <name>_grains_<number>.vtu and <name>_contacts_<number>.vtu, the two
	parts of each time of <name>.pvd. Contacts carry normalForce, shearForce [N] and state, 0 frictional, 1 bonded, 2 broken.

	clock  time of the files, default O.time; that of a slope is lambda: mpm.time

	>>> series = talik.output.SampleSeries(folder)
	>>> with mpm.inspect(5):
	...     files = series.write()"""

	def __init__(self, folder, name="sample", clock=None):
		self.folder, self.name = writableFolder(folder), name
		self.clock = clock or _sceneTime
		self.entries = []

	def write(self):
		"""Adds the present state of the sample in O; returns the paths of the two new .vtu files."""
		from talik.packing import sampleArrays

		sample, number = sampleArrays(), len(self.entries) // 2
		files = {part: f"{self.name}_{part}_{number:05d}.vtu" for part in ("grains", "contacts")}
		writePoints(self.folder / files["grains"], sample["centre"], {"radius": sample["radius"]})
		contactFields = {name: sample[name] for name in ("normalForce", "shearForce", "state")}
		writeSegments(self.folder / files["contacts"], sample["start"], sample["end"], contactFields)
		self.entries += [(self.clock(), file, part) for part, file in enumerate(files.values())]
		writeCollection(self.folder / f"{self.name}.pvd", self.entries)


# --- frames for pictures ---------------------------------------------------------------------------------------------------


class Frames:
	"""Keeps all fields at given simulated times, for talik.plots; `frames` is a list of {"time": t [s], "day": of the calendar, field: array}.

	days      the times are days of the engine's calendar, not those of the clock
	byMotion  0, or an even number: so many frames at most, half of it or more once the ground has moved, are taken between them whenever the mean
			  displacement of the ground has changed by as much again. Their numbers have single precision

	A slide of seconds lies between two days of a calendar: frames by motion show it.

	>>> frames = talik.output.Frames(mpm, times=[0.1, 0.2])
	>>> O.engines = O.engines + [frames.runner()]"""

	firstMotion = 2e-4  # change of the mean displacement over the size of the ground, for the first frames by motion

	def __init__(self, mpm, times, clock=None, days=False, byMotion=0):
		self.mpm, self.clock, self.days, self.byMotion = mpm, clock or _sceneTime, days, int(byMotion)
		self.times = sorted(float(t) for t in times)
		self.frames = []
		self.moved, self.change = 0.0, None  # mean displacement at the last frame by motion, and how much it has to change for the next [m]

	def take(self):
		"""Keeps a frame when the next of the times is reached, or when the ground has moved."""
		reached = self.mpm.calendar["day"] if self.days else self.clock()
		taken = len(self.timed())
		if taken < len(self.times) and reached >= self.times[taken] * (1 - 1e-12):
			self.takeNow()
		elif self.byMotion and self.frames:
			self._takeIfMoved()

	def takeNow(self):
		"""Keeps a frame, whatever the time."""
		self.frames.append(self._present())

	def _present(self):
		day = self.mpm.calendar["day"] if self.days else _dayOf(self.mpm)
		return {"time": self.clock(), **({} if day is None else {"day": day}), **allFields(self.mpm)}

	def timed(self):
		"""Those of the frames that their times took."""
		return [frame for frame in self.frames if not _byMotion(frame)]

	def _takeIfMoved(self):
		now = motionOf({name: self.mpm.field(name) for name in ("volume", "displacement")})
		if self.change is None:
			position = self.frames[0]["position"]
			self.change = self.firstMotion * float(np.ptp(position, axis=0).max())
		if abs(now - self.moved) < self.change:
			return
		self.moved = now
		single = {name: value.astype(np.float32) if getattr(value, "dtype", None) == np.float64 else value for name, value in self._present().items()}
		self.frames.append({**single, "byMotion": 1})
		while len(self.frames) - len(self.timed()) > self.byMotion:
			self._thinOut()

	def _thinOut(self):
		"""Twice the change between two frames by motion; those that lie closer are given up."""
		self.change *= 2
		kept, last = [], 0.0
		for frame in self.frames:
			if _byMotion(frame):
				moved = motionOf(frame)
				if abs(moved - last) < 0.999 * self.change:
					continue
				last = moved
			kept.append(frame)
		self.frames[:] = kept

	def runner(self, iterPeriod=1):
		"""A YADE PyRunner that takes the frames that are due, every `iterPeriod` steps."""
		return runner(self.take, iterPeriod=iterPeriod)

	def save(self, path):
		"""All frames in one compressed NumPy file; loadFrames(path) reads it back."""
		if not ranks.first:
			return
		arrays = {f"{index}/{name}": value for index, frame in enumerate(self.frames) for name, value in frame.items()}
		content = io.BytesIO()
		np.savez_compressed(content, **arrays)
		writeWhole(path, content.getvalue())


def _byMotion(frame):
	return "byMotion" in frame


def motionOf(frame):
	"""Mean displacement of the ground of a frame [m], weighted by volume.

	>>> talik.output.motionOf(talik.output.allFields(mpm)) < 1e-3
	True"""
	return float(np.average(np.linalg.norm(frame["displacement"], axis=1), weights=frame["volume"]))


def telling(frames, count=4, first=0.05):
	"""Of many frames so many that tell what happened, in their order: spread over the share of motion, from where `first` of it was done to the end. Frames
	without motion are spread over time.

	>>> frames = talik.output.Frames(mpm, times=[0])
	>>> frames.take()
	>>> len(talik.output.telling(frames.frames, 3))
	1"""
	if len(frames) <= count:
		return list(frames)
	share = progressOf(frames)
	targets = np.linspace(first, 1, count) if count > 1 else [1.0]
	chosen, begin = [], 0
	for place, target in enumerate(targets):
		left = len(frames) - (count - place - 1)  # one for each that comes after
		found = begin + int(np.argmin(np.abs(share[begin:left] - target))) if place < count - 1 else len(frames) - 1
		chosen.append(frames[found])
		begin = found + 1
	return chosen


def progressOf(frames, byTime=0.0):
	"""Share (n,) of the path of the ground that is done at each frame, 0 to 1; byTime: of so much of it the share of time instead. That of time alone
	where nothing moved.

	>>> frames = talik.output.Frames(mpm, times=[0])
	>>> frames.take()
	>>> talik.output.progressOf(frames.frames).tolist()
	[1.0]"""
	times = np.array([frame.get("day", frame["time"]) for frame in frames], dtype=float)
	elapsed = (times - times[0]) / (times[-1] - times[0]) if times[-1] > times[0] else np.linspace(0, 1, len(times)) if len(times) > 1 else np.ones(1)
	if "displacement" not in frames[0]:
		return elapsed
	path, last = [0.0], frames[0]
	for frame in frames[1:]:
		same = frame["displacement"].shape == last["displacement"].shape
		moved = motionOf({**frame, "displacement": frame["displacement"] - last["displacement"]}) if same else abs(motionOf(frame) - motionOf(last))
		path.append(path[-1] + moved)
		last = frame
	if not path[-1] > 1e-6 * np.ptp(frames[0]["position"], axis=0).max():
		return elapsed
	return byTime * elapsed + (1 - byTime) * np.array(path) / path[-1]


def _dayOf(mpm):
	"""Day of the calendar; None where heat has no scale of its own and the clock says it all."""
	calendar = getattr(mpm, "calendar", None)
	return None if calendar is None or (calendar["scale"] == 1 and not calendar["followsMotion"]) else calendar["day"]


def loadFrames(path):
	"""The list of frames that Frames.save wrote.

	>>> frames = talik.output.Frames(mpm, times=[0])
	>>> frames.take()
	>>> frames.save(folder + "/frames.npz")
	>>> len(talik.output.loadFrames(folder + "/frames.npz"))
	1"""
	frames = {}
	with np.load(path) as file:
		for key in file.files:
			index, name = key.split("/", 1)
			frames.setdefault(int(index), {})[name] = file[key] if file[key].ndim else file[key].item()
	return [frames[index] for index in sorted(frames)]


# --- points over time --------------------------------------------------------------------------------------------------------


class _Table:
	"""A CSV file that grows with the days of the calendar. It begins with the date, where the scene has one for its day 0, see talik.dates."""

	def __init__(self, mpm, path, everyDays, headings):
		if not everyDays > 0:
			raise ValueError(f"{type(self).__name__}: everyDays is {everyDays!r}; give a number of days above 0")
		self.mpm, self.path, self.everyDays = mpm, Path(path), everyDays
		self.next, self.first = -math.inf, dates.started()
		self.engine = runner(self._takeWhenDue, iterPeriod=1)
		if ranks.first:
			writableFolder(self.path.parent)
			self.path.write_text(",".join(["date"] * (self.first is not None) + ["day [d]", *headings]) + "\n")

	def _write(self, rows):
		day = self.mpm.calendar["day"]
		begin = [] if self.first is None else [dates.dateOf(day, self.first)]
		if ranks.first:
			with open(self.path, "a") as file:
				file.writelines(",".join([*begin, *(f"{value:.9g}" for value in (day, *row))]) + "\n" for row in rows)

	def _takeWhenDue(self):
		day = self.mpm.calendar["day"]
		if day >= self.next:
			self.take()
			self.next = self.everyDays * (math.floor(day / self.everyDays) + 1)


class PointTable(_Table):
	"""Fields at chosen points over the days of the calendar, as a CSV file that any spreadsheet reads. With talik.dates.start its first column has dates.

	mpm        the ground, filled with points
	path       of the file; a line is added whenever its time has come
	places     {name: (x, y) or (x, y, z) [m]}: the material point nearest to each place at the start is followed
	fields     names of mpm.fieldNames(); vectors and tensors have a column for each component
	everyDays  time between two lines [d of the calendar], above 0; lines are those of the first step after its multiples
	others     {name with unit: function} of further columns, such as {"thrust [N]": lambda: -O.forces.f(wall)[0]}

	Its engine stands behind the ground (and behind NewtonIntegrator) in O.engines. take() writes a line now.

	>>> table = talik.output.PointTable(mpm, folder + "/points.csv", {"crest": (0.5, 1.0)}, fields=("temperature",), everyDays=1)
	>>> O.engines = O.engines + [table.engine]
	>>> table.take()
	>>> print(open(folder + "/points.csv").readline().strip())
	day [d],crest: temperature [degC]"""

	def __init__(self, mpm, path, places, fields, everyDays, others=None):
		if isinstance(fields, str):
			raise ValueError(f"PointTable: fields is {fields!r}; give a list of names, such as [{fields!r}]")
		unknown = [field for field in fields if field not in mpm.fieldNames()]
		if unknown:
			raise ValueError(f"PointTable: there is no field '{unknown[0]}'; choose among {', '.join(mpm.fieldNames())}")
		self.mpm, self.fields = mpm, tuple(fields)
		self.ids = {name: mpm.pick(*place) for name, place in places.items()}
		self.others = dict(others or {})
		super().__init__(mpm, path, everyDays, [*self._headings(), *self.others])

	def take(self):
		"""Adds a line with the present values."""
		fields = {field: self.mpm.field(field) for field in self.fields}
		values = [value for id in self.ids.values() for field in self.fields for value in np.atleast_1d(fields[field][id]).tolist()]
		self._write([values + [float(other()) for other in self.others.values()]])

	def _headings(self):
		units = {field["name"]: field["unit"] for field in self.mpm.fields()}
		for name in self.ids:
			for field in self.fields:
				for column in columns(field, self.mpm.field(field)[:1]):
					yield f"{name}: {column} [{units.get(field, '-')}]"


class SurfaceTable(_Table):
	"""Settlement and thaw depth along the surface over the days of the calendar, as a CSV file with a line for each column of points and time.

	mpm        the ground in the plane, filled with points
	path       of the file
	everyDays  time between two sets of lines [d of the calendar], above 0

	x [m] and settlement [m] are those of the surface above the point that is uppermost in its column at the start: settlement is the way down of the
	point and half of what it has lost in height, negative where the surface heaves. thaw depth [m] is talik.thermal.thawDepth there, nan where the
	column has thawed through or there is no heat. Its engine stands behind the ground in O.engines.

	>>> table = talik.output.SurfaceTable(mpm, folder + "/surface.csv", everyDays=1)
	>>> O.engines = O.engines + [table.engine]
	>>> table.take()
	>>> print(open(folder + "/surface.csv").readline().strip())
	day [d],x [m],settlement [m],thaw depth [m]"""

	def __init__(self, mpm, path, everyDays):
		position = mpm.field("position")
		if position.shape[1] != 2:
			raise ValueError("SurfaceTable: the ground is in space; give ground in the plane, or take talik.output.table(mpm)")
		side = math.sqrt(np.median(mpm.field("volume")))
		column = np.floor((position[:, 0] - position[:, 0].min()) / side + 0.5).astype(int)
		order = np.lexsort((position[:, 1], column))
		self.ids = order[np.append(np.diff(column[order]) > 0, True)]  # the highest of each column
		self.side = np.sqrt(mpm.field("volume")[self.ids])
		self.before = self._surface(mpm)
		super().__init__(mpm, path, everyDays, ["x [m]", "settlement [m]", "thaw depth [m]"])

	def take(self):
		"""Adds the lines of the present state."""
		x = self.mpm.field("position")[self.ids, 0]
		settled = self.before - self._surface(self.mpm)
		depth = np.full(len(x), np.nan)
		if self.mpm.heat is not None:
			from talik import thermal

			columns = thermal.thawDepth(self.mpm)
			depth = columns["depth"][np.abs(x[:, None] - columns["place"]).argmin(axis=1)]
		self._write(zip(x, settled, depth))

	def _surface(self, mpm):
		"""How far the upper face of each point has risen, up to a constant [m]."""
		return mpm.field("displacement")[self.ids, 1] + 0.5 * mpm.field("volume")[self.ids] / self.side


# --- summary ---------------------------------------------------------------------------------------------------------------


def writeSummary(path, **values):
	"""A JSON file of named results; NumPy values are converted, numbers that are not finite become null.

	>>> talik.output.writeSummary(folder + "/summary.json", points=mpm.pointCount, time=mpm.time)"""
	if not ranks.first:
		return
	writableFolder(Path(path).parent)
	writeWhole(path, json.dumps(plain(values), indent="\t", allow_nan=False) + "\n")


def unexpected(sentence):
	"""Says that a result lies farther from the calculation by hand than it does with the numbers of an example: with another soil that may be right.
	In the tests of Talik (environment variable TALIK_JUDGES) it ends the script.

	>>> talik.output.unexpected("the settlement is more than 10 % off the calculation by hand")
	Remark: the settlement is more than 10 % off the calculation by hand"""
	if "TALIK_JUDGES" in os.environ:
		raise SystemExit(sentence)
	print(f"Remark: {sentence}")


def plain(value):
	"""As JSON knows it: lists and dictionaries of numbers and texts; null for numbers that are not finite.

	>>> talik.output.plain({"error": np.float64(0.5), "worst": float("nan")})
	{'error': 0.5, 'worst': None}"""
	if isinstance(value, dict):
		return {str(key): plain(item) for key, item in value.items()}
	if isinstance(value, (list, tuple, np.ndarray)):
		return [plain(item) for item in value]
	if isinstance(value, (bool, np.bool_)):
		return bool(value)
	if isinstance(value, (int, np.integer)):
		return int(value)
	if isinstance(value, (float, np.floating)):
		return float(value) if math.isfinite(value) else None
	return value if value is None else str(value)


def _sceneTime():
	from yade import O

	return O.time
