# SPDX-License-Identifier: GPL-2.0-or-later
"""Files for ParaView are read back with VTK; summary and frames with what wrote them not."""

import json
import xml.etree.ElementTree as ElementTree

import numpy as np
import pytest
from vtkmodules.util.numpy_support import vtk_to_numpy
from vtkmodules.vtkIOXML import vtkXMLUnstructuredGridReader

from talik import geometry, output


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


def block():
	position, volume = geometry.fillPolygon([(0, 0), (4, 0), (4, 2), (0, 2)], 0.5, 4)
	return {
		"position": position,
		"volume": volume,
		"displacement": 0.1 * position,
		"stress": np.column_stack([position, position]),
		"temperature": 3 * position[:, 0],
		"bondsIntact": np.where(position[:, 0] < 2, 7.0, np.nan),
	}


def test_the_surface_beside_the_points_covers_their_area_and_has_their_fields(tmp_path):
	ground = Ground()
	ground.fields = block()
	series = output.ParaViewSeries(ground, tmp_path, clock=lambda: 0.5)
	series.write()
	series.write()
	entries = ElementTree.parse(tmp_path / "surface.pvd").getroot().findall("Collection/DataSet")
	assert [(float(entry.get("timestep")), entry.get("file")) for entry in entries] == [(0.5, "surface_00000.vtu"), (0.5, "surface_00001.vtu")]
	grid = read(tmp_path / "surface_00001.vtu")
	places = vtk_to_numpy(grid.GetPoints().GetData())
	corners = vtk_to_numpy(grid.GetCells().GetConnectivityArray()).reshape(-1, 3)
	a, b, c = (places[corners[:, k], :2] for k in range(3))
	area = 0.5 * np.abs((b - a)[:, 0] * (c - a)[:, 1] - (b - a)[:, 1] * (c - a)[:, 0]).sum()
	fields = {name: vtk_to_numpy(grid.GetPointData().GetArray(name)) for name in set(ground.fieldNames()) - {"position"}}
	inside = (np.abs(places[:, 0] - 2) < 1.6) & (np.abs(places[:, 1] - 1) < 0.6)
	off = np.abs(fields["temperature"] - 3 * places[:, 0])[inside].max()
	print(f"{len(corners)} triangles, {grid.GetNumberOfPoints()} corners: {area:.4f} of 8 m2; temperature off by up to {off:.4f} of 12 K")
	assert {grid.GetCellType(k) for k in range(grid.GetNumberOfCells())} == {5} and area == pytest.approx(8, rel=0.01)
	assert off < 0.05 and fields["displacement"].shape[1] == 3 and fields["stress"].shape[1] == 4
	assert np.nanmax(np.abs(fields["bondsIntact"] - 7)) < 1e-5 and np.isnan(fields["bondsIntact"][places[:, 0] > 3]).all()


def test_the_surface_of_ground_in_space_is_closed_and_encloses_its_volume(tmp_path):
	axes = [(np.arange(round(length / 0.25)) + 0.5) * 0.25 for length in (4, 3, 2)]
	position = np.stack(np.meshgrid(*axes, indexing="ij"), axis=-1).reshape(-1, 3)
	frame = {"position": position, "volume": np.full(len(position), 0.25**3), "displacement": position * (1, 0, 0)}
	output.writeSurface(tmp_path / "surface.vtu", frame, (0, 0, 0), (4, 3, 4))
	grid = read(tmp_path / "surface.vtu")
	places, corners = vtk_to_numpy(grid.GetPoints().GetData()), vtk_to_numpy(grid.GetCells().GetConnectivityArray()).reshape(-1, 3)
	a, b, c = (places[corners[:, k]] for k in range(3))
	volume = abs(np.einsum("ij,ij->i", a, np.cross(b, c)).sum()) / 6
	moved = vtk_to_numpy(grid.GetPointData().GetArray("displacement"))
	off = np.abs(moved[:, 0] - places[:, 0]).max()
	print(f"{len(corners)} triangles around {volume:.2f} of 24 m3; displacement off by up to {off:.3f} of 4 m")
	assert volume == pytest.approx(24, rel=0.02) and off < 0.15


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


class Sliding:
	"""Ground that rests for 100 s, then slides by 5 m within 0.2 s, and rests again."""

	calendar = None

	def __init__(self):
		self.time, self.fields = 0.0, block()

	def fieldNames(self):
		return ["position", "volume", "displacement"]

	def field(self, name):
		path = 5 * np.clip((self.time - 100) / 0.2, 0, 1)
		return np.tile([path, 0.0], (len(self.fields["volume"]), 1)) if name == "displacement" else self.fields[name]


def framesOf(byMotion):
	ground = Sliding()
	frames = output.Frames(ground, np.linspace(0, 200, 5), clock=lambda: ground.time, byMotion=byMotion)
	for ground.time in np.concatenate([np.arange(0, 100, 1), np.arange(100, 101, 0.001), np.arange(101, 201, 1)]):
		frames.take()
	return frames


def test_frames_by_motion_show_a_slide_between_two_times_in_even_steps():
	still, frames = framesOf(0), framesOf(20)
	paths = np.array([frame["displacement"][0, 0] for frame in frames.frames])
	print(f"{len(still.frames)} frames by time; {len(frames.frames) - 5} by motion, the path between two of all is at most {np.diff(paths).max():.2f} of 5 m")
	assert len(still.frames) == len(frames.timed()) == 5
	assert 10 <= len(frames.frames) - 5 <= 20 and (np.diff(paths) >= 0).all() and np.diff(paths).max() < 0.6
	assert [frame["time"] for frame in frames.timed()] == [0, 50, 100, 150, 200]


def test_frames_that_tell_are_spread_over_the_motion_not_over_time(tmp_path):
	frames = framesOf(20)
	frames.save(tmp_path / "frames.npz")
	told = output.telling(output.loadFrames(tmp_path / "frames.npz"), 4)
	shares = [output.motionOf(frame) / 5 for frame in told]
	asleep = [dict(frame, displacement=0 * frame["displacement"]) for frame in frames.frames]
	times = [frame["time"] for frame in output.telling(asleep, 3)]
	print(f"shares of the motion {np.round(shares, 2)}, a twentieth, the whole and two between due; without motion times {np.round(times)} s")
	np.testing.assert_allclose(shares, np.linspace(0.05, 1, 4), atol=0.06)
	assert told[-1]["time"] == 200 and len(output.telling(frames.frames[:3], 4)) == 3
	assert times == sorted(times) and times[-1] == 200


def test_the_summary_is_plain_json_whatever_numpy_gives(tmp_path):
	output.writeSummary(
		tmp_path / "run" / "summary.json", points=np.int64(3), wallTime=np.float64(1.5), nothing=float("nan"), stress=np.eye(2), nested={"a": (1, True)}
	)
	found = json.loads((tmp_path / "run" / "summary.json").read_text())
	assert found == dict(points=3, wallTime=1.5, nothing=None, stress=[[1, 0], [0, 1]], nested={"a": [1, True]})
