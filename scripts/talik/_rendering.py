# SPDX-License-Identifier: GPL-2.0-or-later
"""Renders one picture in space by VTK, in a process of its own: graphics that fail cannot end a simulation.

	DISPLAY=:7 /usr/bin/python3 _rendering.py scene.pickle picture.npz

The scene is made by talik.plots3d: meshes, spheres and tubes with colours, a camera, a size. The picture is an array of pixels and the matrix
that takes places in space to them.
"""

import pickle
import sys

import numpy as np
import vtkmodules.vtkRenderingOpenGL2  # noqa: F401: the factory of renderers
from vtkmodules.util.numpy_support import numpy_to_vtk, numpy_to_vtkIdTypeArray, vtk_to_numpy
from vtkmodules.vtkCommonCore import VTK_UNSIGNED_CHAR, vtkPoints
from vtkmodules.vtkCommonDataModel import vtkCellArray, vtkPolyData
from vtkmodules.vtkFiltersCore import vtkGlyph3D, vtkPolyDataNormals, vtkTubeFilter
from vtkmodules.vtkFiltersSources import vtkSphereSource
from vtkmodules.vtkRenderingCore import vtkActor, vtkLight, vtkPolyDataMapper, vtkRenderer, vtkRenderWindow, vtkWindowToImageFilter


def polyData(points, cells, kind):
	data, places, array = vtkPolyData(), vtkPoints(), vtkCellArray()
	places.SetData(numpy_to_vtk(np.ascontiguousarray(points, dtype=float), deep=True))
	offsets = np.arange(0, cells.size + 1, cells.shape[1], dtype=np.int64)
	array.SetData(numpy_to_vtkIdTypeArray(offsets, deep=True), numpy_to_vtkIdTypeArray(cells.ravel().astype(np.int64), deep=True))
	data.SetPoints(places)
	(data.SetPolys if kind == "polygons" else data.SetLines if kind == "lines" else data.SetVerts)(array)
	return data


def attach(data, **arrays):
	for name, values in arrays.items():
		array = numpy_to_vtk(np.ascontiguousarray(values), deep=True, array_type=VTK_UNSIGNED_CHAR if values.dtype == np.uint8 else None)
		array.SetName(name)
		data.GetPointData().AddArray(array)


def mesh(part):
	data = polyData(part["points"], part["triangles"], "polygons")
	attach(data, colour=part["colours"])
	normals = vtkPolyDataNormals()
	normals.SetInputData(data)
	normals.SetFeatureAngle(40)
	return normals


def spheres(part):
	points = part["points"]
	data, ball, glyph = polyData(points, np.arange(len(points)).reshape(-1, 1), "vertices"), vtkSphereSource(), vtkGlyph3D()
	attach(data, colour=part["colours"], diameter=2 * part["radii"])
	ball.SetThetaResolution(32)
	ball.SetPhiResolution(24)
	data.GetPointData().SetActiveScalars("diameter")
	glyph.SetInputData(data)
	glyph.SetSourceConnection(ball.GetOutputPort())
	glyph.SetScaleModeToScaleByScalar()
	glyph.SetScaleFactor(1)
	return glyph


def tubes(part):
	"""Segments (n, 2, 3), each a tube of its own radius."""
	segments = part["segments"]
	data, tube = polyData(segments.reshape(-1, 3), np.arange(2 * len(segments)).reshape(-1, 2), "lines"), vtkTubeFilter()
	attach(data, colour=np.repeat(part["colours"], 2, axis=0), radius=np.repeat(part["radii"], 2))
	data.GetPointData().SetActiveScalars("radius")
	tube.SetInputData(data)
	tube.SetVaryRadiusToVaryRadiusByAbsoluteScalar()
	tube.SetNumberOfSides(16)
	tube.CappingOn()
	return tube


def actor(part):
	mapper, shown = vtkPolyDataMapper(), vtkActor()
	source = {"mesh": mesh, "spheres": spheres, "tubes": tubes}[part["kind"]](part)  # its port does not keep it alive
	mapper.SetInputConnection(source.GetOutputPort())
	mapper.SetScalarModeToUsePointFieldData()
	mapper.SelectColorArray("colour")
	mapper.SetColorModeToDirectScalars()
	shown.SetMapper(mapper)
	surface = shown.GetProperty()
	surface.SetAmbient(0.25)
	surface.SetDiffuse(0.8)
	surface.SetSpecular(part["gloss"])
	surface.SetSpecularPower(25)
	surface.SetOpacity(part["opacity"])
	return shown


def lit(renderer, camera):
	"""Light of a low sun from behind the viewer's left, some from the viewer, and some of the sky."""
	focus, towards = np.array(camera["focus"]), np.array(camera["position"]) - camera["focus"]
	left = np.cross(np.array([0, 0, 1.0]), -towards)
	size = np.linalg.norm(towards)
	for direction, strength in (
		(towards + 0.9 * size * left / np.linalg.norm(left) + [0, 0, 0.5 * size], 0.65),
		(towards, 0.35),
		(np.array([0, 0, size]), 0.2),
	):
		light = vtkLight()
		light.SetLightTypeToSceneLight()
		light.SetPosition(*(focus + direction))
		light.SetFocalPoint(*focus)
		light.SetIntensity(strength)
		renderer.AddLight(light)


def render(parts, camera, size):
	"""Pixels (height, width, 3) and the matrix (4, 4) of the projection."""
	renderer, window = vtkRenderer(), vtkRenderWindow()
	renderer.SetBackground(1, 1, 1)
	renderer.AutomaticLightCreationOff()
	lit(renderer, camera)
	for part in parts:
		renderer.AddActor(actor(part))
	view = renderer.GetActiveCamera()
	view.SetParallelProjection(True)
	view.SetPosition(*camera["position"])
	view.SetFocalPoint(*camera["focus"])
	view.SetViewUp(0, 0, 1)
	view.SetParallelScale(camera["scale"])
	renderer.ResetCameraClippingRange()
	window.SetOffScreenRendering(1)
	window.SetMultiSamples(0)
	renderer.SetUseFXAA(False)
	window.SetSize(*size)
	window.AddRenderer(renderer)
	window.Render()
	grab = vtkWindowToImageFilter()
	grab.SetInput(window)
	grab.ReadFrontBufferOff()
	grab.Update()
	image = grab.GetOutput()
	width, height, _ = image.GetDimensions()
	pixels = vtk_to_numpy(image.GetPointData().GetScalars()).reshape(height, width, -1)[::-1].copy()
	matrix = view.GetCompositeProjectionTransformMatrix(width / height, -1, 1)
	window.Finalize()
	return pixels, np.array([[matrix.GetElement(i, j) for j in range(4)] for i in range(4)])


def main(scene, picture):
	with open(scene, "rb") as file:
		given = pickle.load(file)
	pixels, matrix = render(**given)
	np.savez(picture, pixels=pixels, matrix=matrix)


if __name__ == "__main__":
	main(*sys.argv[1:])
