# SPDX-License-Identifier: GPL-2.0-or-later
"""Files for ParaView are read back with VTK; summary and frames with what wrote them not."""

import json
import xml.etree.ElementTree as ElementTree

import numpy as np
import pytest
from vtkmodules.util.numpy_support import vtk_to_numpy
from vtkmodules.vtkIOXML import vtkXMLUnstructuredGridReader

from talik import output


class Ground:
	"""Looks like an engine with every kind of field."""

	def __init__(self, count=50):
		random = np.random.default_rng(1)
		self.fields = {
			"position": random.uniform(0, 10, (count, 2)),
			"displacement": random.normal(size=(count, 2)),
			"stress": random.normal(size=(count, 4)),
			"temperature": random.normal(size=count),
			"bondsIntact": random.integers(0, 500, count),
			"isThawed": random.uniform(size=count) > 0.5,
		}

	def fieldNames(self):
		return list(self.fields)

	def field(self, name):
		return self.fields[name]


def read(path):
	reader = vtkXMLUnstructuredGridReader()
	reader.SetFileName(str(path))
	reader.Update()
	return reader.GetOutput()


def test_every_point_field_is_read_back_from_the_series_bit_for_bit(tmp_path):
	ground, time = Ground(), [0.0]
	series = output.ParaViewSeries(ground, tmp_path / "series", clock=lambda: time[0])
	written = []
	for time[0] in (0.0, 0.1, 2.5):
		ground.fields["position"] = ground.fields["position"] + 0.01
		written.append((time[0], ground.field("position").copy()))
		series.write()
	entries = ElementTree.parse(tmp_path / "series" / "points.pvd").getroot().findall("Collection/DataSet")
	assert [float(entry.get("timestep")) for entry in entries] == [0.0, 0.1, 2.5]
	for entry, (_, position) in zip(entries, written):
		grid = read(tmp_path / "series" / entry.get("file"))
		np.testing.assert_array_equal(vtk_to_numpy(grid.GetPoints().GetData())[:, :2], position)
	assert grid.GetNumberOfCells() == 50
	data = grid.GetPointData()
	for name in set(ground.fieldNames()) - {"position"}:
		values = vtk_to_numpy(data.GetArray(name))
		expected = ground.field(name)
		np.testing.assert_array_equal(values[:, :2] if name == "displacement" else values, expected)
	assert [data.GetArray("stress").GetComponentName(c) for c in range(4)] == ["xx", "yy", "zz", "xy"]
	print(f"{data.GetNumberOfArrays()} fields of {grid.GetNumberOfPoints()} points at {len(entries)} times read back, difference 0")


def test_contacts_are_read_back_as_lines_with_their_forces(tmp_path):
	start, end = np.random.default_rng(2).uniform(size=(2, 7, 2))
	output.writeSegments(tmp_path / "contacts.vtu", start, end, {"force": np.arange(7.0)})
	grid = read(tmp_path / "contacts.vtu")
	assert grid.GetNumberOfCells() == 7 and grid.GetCellType(0) == 3
	np.testing.assert_array_equal(vtk_to_numpy(grid.GetCellData().GetArray("force")), np.arange(7.0))
	points = grid.GetCell(4).GetPoints()
	np.testing.assert_array_equal(points.GetPoint(0)[:2], start[4])
	np.testing.assert_array_equal(points.GetPoint(1)[:2], end[4])


def test_a_field_of_the_wrong_length_is_named(tmp_path):
	with pytest.raises(ValueError, match="'temperature' has shape"):
		output.writePoints(tmp_path / "points.vtu", np.zeros((5, 2)), {"temperature": np.zeros(4)})


def test_a_folder_that_cannot_be_written_is_named():
	with pytest.raises(RuntimeError, match="/proc/nowhere"):
		output.ParaViewSeries(Ground(), "/proc/nowhere")


def test_frames_are_taken_once_at_each_time_and_survive_saving(tmp_path):
	ground, time = Ground(), [0.0]
	frames = output.Frames(ground, [1.0, 0.5], clock=lambda: time[0])
	for time[0] in np.arange(0, 1.5, 0.125):
		frames.take()
	assert [frame["time"] for frame in frames.frames] == [0.5, 1.0]
	frames.save(tmp_path / "frames.npz")
	loaded = output.loadFrames(tmp_path / "frames.npz")
	assert loaded[1]["time"] == 1.0
	for name in ground.fieldNames():
		np.testing.assert_array_equal(loaded[1][name], ground.field(name))


def test_the_summary_is_plain_json_whatever_numpy_gives(tmp_path):
	output.writeSummary(
		tmp_path / "run" / "summary.json", points=np.int64(3), wallTime=np.float64(1.5), nothing=float("nan"), stress=np.eye(2), nested={"a": (1, True)}
	)
	found = json.loads((tmp_path / "run" / "summary.json").read_text())
	assert found == dict(points=3, wallTime=1.5, nothing=None, stress=[[1, 0], [0, 1]], nested={"a": [1, True]})
