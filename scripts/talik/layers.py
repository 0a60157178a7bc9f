# SPDX-License-Identifier: GPL-2.0-or-later
"""Ground in named layers: outlines with holes, each with its material, its skeleton law and its state at the start.

	layers = talik.layers.fill(mpm, {
		"silt": dict(polygon=[(0, 1), (4, 1), (4, 2), (0, 2)], temperature=-2),
		"ice-rich": dict(polygon=[(0, 0), (4, 0), (4, 1), (0, 1)], porosity=0.7, temperature=-2, material=GroundMaterial(thawStrain=0.4)),
	})
	mpm.field("temperature")[layers["ice-rich"]]

Layers that overlap are refused. Lengths in m, per metre of thickness.
"""

import difflib

import numpy as np
from shapely.geometry import LineString, Polygon
from shapely.validation import make_valid

from talik import geometry
from yade import wrapper

smallestOverlap = 1e-9  # of the smaller layer
ofPoints = ("porosity", "temperature", "pressure", "stress", "velocity", "poreFill")  # attributes of a layer that its points have
ofLayers = ("polygon", "holes", "material", "skeleton", *ofPoints)


def thawStrain(porosity, thawedPorosity):
	"""Volume that ground loses on thaw over its volume frozen [-]: the grains keep theirs, the pores go from the porosity of frozen ground, excess
	ice included, to that of the thawed soil under its load.

	porosity        n_0 of the frozen ground [-], 0 to below 1
	thawedPorosity  n_1 of the thawed soil [-], 0 to n_0

	>>> round(talik.layers.thawStrain(porosity=0.7, thawedPorosity=0.5), 3)
	0.4"""
	if not 0 <= thawedPorosity <= porosity < 1:
		raise ValueError(f"thawStrain: porosity is {porosity} and thawedPorosity is {thawedPorosity}; give 0 <= thawedPorosity <= porosity < 1")
	return 1 - (1 - porosity) / (1 - thawedPorosity)


def split(polygon, line):
	"""Cuts an outline along a line from side to side; returns the outlines (above, below), lists of corners (x, y) [m].

	polygon  corners (m, 2) [m]
	line     points (n, 2) [m] by increasing x; it is prolonged level beyond its ends

	ValueError if the line does not cut the outline into one part above and one below it.

	>>> above, below = talik.layers.split([(0, 0), (4, 0), (4, 3), (0, 3)], [(0, 1), (4, 2)])
	>>> sorted(below)
	[(0.0, 0.0), (0.0, 1.0), (4.0, 0.0), (4.0, 2.0)]"""
	outline = geometry.ground(polygon, ())
	points = [(float(x), float(y)) for x, y in line]
	if any(second[0] <= first[0] for first, second in zip(points, points[1:])):
		raise ValueError("layers.split: the points of the line do not have increasing x; give it from left to right")
	left, bottom, right, top = outline.bounds
	points = [(min(left, points[0][0]) - 1, points[0][1]), *points, (max(right, points[-1][0]) + 1, points[-1][1])]
	under = Polygon([*points, (points[-1][0], min(bottom, min(y for _, y in points)) - 1), (points[0][0], min(bottom, min(y for _, y in points)) - 1)])
	parts = outline.difference(under), outline.intersection(under)
	for part, place in zip(parts, ("above", "below")):
		if part.is_empty or part.geom_type != "Polygon":
			raise ValueError(f"layers.split: the line leaves {0 if part.is_empty else len(getattr(part, 'geoms', []))} parts {place} it; it must leave one")
	return tuple(list(part.exterior.coords)[:-1] for part in parts)


def fill(mpm, layers, pointsPerCell=None, lateralRatio=None, load=0.0, waterTable=None):
	"""Fills an MpmEngine in the plane with layers; returns {name: ids of the points (n,)}.

	layers         {name: dict(polygon=corners (m, 2) [m], …)} with, where wanted, holes=[corners, …] that are left out, material=GroundMaterial(…),
				   which is named like the layer unless it has a name, skeleton=a skeleton law, and attributes of talik.geometry.fill: porosity,
				   temperature, pressure, velocity, poreFill
	pointsPerCell  a square number; default that of talik.geometry.fill
	lateralRatio   horizontal over vertical effective stress at rest [-]: points start with the stress of the weight above them; None: with none.
				   Samples have theirs by talik.slope.settle
	load           pressure on the surface at the start [Pa], with lateralRatio
	waterTable     height of the water table [m], a number or a function of arrays x: pore water below it starts with hydrostatic pressure, above
				   it with none; in place of the pressure of layers. The poreFill of a layer is that above it; below it pores are full. A pond above the
				   ground presses on it, too: give load, and SurfaceLoad

	A layer without material has MpmEngine.material, one without skeleton MpmEngine.skeleton. ValueError names layers that overlap.

	>>> mpm = MpmEngine(gridSpacing=0.5, gravity=(0, -9.81), heat=HeatTransfer(), freezing=FreezingCurve(), skeleton=ElasticSkeleton())
	>>> silt = dict(polygon=talik.geometry.rectangle(0, 1, 4, 2), temperature=-2)
	>>> iceRich = dict(polygon=talik.geometry.rectangle(0, 0, 4, 1), porosity=0.7, temperature=-2, material=GroundMaterial(thawStrain=0.4))
	>>> layers = talik.layers.fill(mpm, {"silt": silt, "ice-rich": iceRich}, lateralRatio=0.5)
	>>> len(layers["ice-rich"])
	16"""
	_refuseUnknown(layers)
	_refuseWrongFill(mpm, layers)
	outlines = {name: _outlineOf(name, layer) for name, layer in layers.items()}
	_refuseOverlaps(outlines)
	if lateralRatio is not None:
		_requireWeight(mpm, lateralRatio)
	numbers = _numbersOfMaterials(mpm, layers)
	laws = _numbersOfLaws(mpm, layers)
	hydrostatic = None if waterTable is None else _hydrostatic(mpm, layers, waterTable)
	columns = []
	for name, layer in layers.items() if lateralRatio is not None else ():
		dry, wet = _density(mpm, layer), _density(mpm, {**layer, "poreFill": 1.0})
		columns.append((outlines[name], dry, wet if waterTable is not None else dry))
	height = waterTable if callable(waterTable) else lambda x: -np.inf if waterTable is None else waterTable
	ids = {}
	for name, layer in layers.items():
		state = {key: value for key, value in layer.items() if key in ofPoints}
		if waterTable is not None:
			state["pressure"] = hydrostatic
			if "poreFill" in layer:
				state["poreFill"] = _fullBelow(height, layer["poreFill"])
		if lateralRatio is not None and not isinstance(layer.get("skeleton", mpm.skeleton), wrapper.RveSkeleton):
			state["stress"] = _geostatic(mpm, columns, lateralRatio, load, state.get("pressure", 0.0), height)
		first = mpm.pointCount
		try:
			geometry.fill(mpm, layer["polygon"], pointsPerCell, holes=layer.get("holes", ()), material=numbers[name], skeleton=laws[name], **state)
		except ValueError as problem:
			raise ValueError(f"layer '{name}': {problem}") from None
		ids[name] = np.arange(first, mpm.pointCount)
	return ids


def _refuseUnknown(layers):
	for name, layer in layers.items():
		for key in layer:
			if key not in ofLayers:
				close = difflib.get_close_matches(key, ofLayers, n=1)
				hint = f"did you mean {close[0]}?" if close else f"choose among {', '.join(ofLayers)}"
				raise ValueError(f"layer '{name}' has '{key}', which no layer has; {hint}")


leastFill = 0.01  # of ground with water


def _refuseWrongFill(mpm, layers):
	least = 0 if mpm.water is None else leastFill
	for name, layer in layers.items():
		fill = layer.get("poreFill", 1.0)
		if not callable(fill) and not (least <= np.nanmin(fill) and np.nanmax(fill) <= 1):
			raise ValueError(
				f"layer '{name}' has poreFill {np.nanmin(fill):g} to {np.nanmax(fill):g}; give {least:g} to 1, the part of its pores that holds water"
			)


def _requireWeight(mpm, lateralRatio):
	if not 0 < lateralRatio <= 10:
		raise ValueError(f"layers.fill: lateralRatio is {lateralRatio!r}; give the ratio of horizontal to vertical effective stress, above 0 up to 10")
	if not tuple(mpm.gravity)[-1] < 0:
		raise ValueError(
			f"layers.fill: lateralRatio is {lateralRatio}, and MpmEngine.gravity is {tuple(mpm.gravity)}, which gives no weight; set gravity=(0, -9.81) before filling"
		)


def _hydrostatic(mpm, layers, waterTable):
	"""Function of x, y [m] that gives the pressure of pore water at rest [Pa]."""
	if mpm.water is None:
		raise ValueError("layers.fill: waterTable is given, and the ground has no water; set water=PoreWater() before filling, or leave it out")
	for name, layer in layers.items():
		if "pressure" in layer:
			raise ValueError(f"layers.fill: waterTable is given, and layer '{name}' has a pressure of its own; leave one of the two out")
	unitWeight = (mpm.materials[0] if mpm.materials else mpm.material).liquidDensity * -tuple(mpm.gravity)[-1]
	height = waterTable if callable(waterTable) else lambda x: waterTable
	return lambda x, y: np.maximum(0.0, unitWeight * (height(x) - y))


def _fullBelow(height, poreFill):
	def fill(x, y):
		above = poreFill(x, y) if callable(poreFill) else poreFill
		return np.where(y < height(x), 1.0, above)

	return fill


def _outlineOf(name, layer):
	if "polygon" not in layer:
		raise ValueError(f"layer '{name}' has no polygon; give its corners (x, y) in m")
	try:
		return geometry.ground(layer["polygon"], layer.get("holes", ()))
	except ValueError as problem:
		raise ValueError(f"layer '{name}': {problem}") from None


def _refuseOverlaps(outlines):
	names = list(outlines)
	for i, first in enumerate(names):
		for second in names[i + 1 :]:
			shared = make_valid(outlines[first]).intersection(make_valid(outlines[second]))
			if shared.area > smallestOverlap * min(outlines[first].area, outlines[second].area):
				x, y = shared.centroid.x, shared.centroid.y
				raise ValueError(
					f"layers '{first}' and '{second}' overlap in {shared.area:.3g} m2 around ({x:.3g}, {y:.3g}); move their corners, "
					f"or leave one out of the other by holes"
				)


def _numbersOfMaterials(mpm, layers):
	"""{layer: number of its material}; completes mpm.materials."""
	if not any("material" in layer for layer in layers.values()):
		return dict.fromkeys(layers, 0)
	_refuseOtherMaterials(layers)
	materials, numbers = list(mpm.materials), {}
	without = [name for name, layer in layers.items() if "material" not in layer]
	if without and materials:
		raise ValueError(f"layer '{without[0]}' has no material, and MpmEngine.materials lists several; give it one of them")
	if without or (mpm.pointCount > 0 and not materials):
		materials, mpm.material = [mpm.material], wrapper.GroundMaterial()
	for name, layer in layers.items():
		material = layer.get("material")
		if name in without:
			numbers[name] = 0
			continue
		if material not in materials:
			if not material.name:
				material.name = name
			materials.append(material)
		numbers[name] = materials.index(material)
	mpm.materials = materials
	return numbers


def _numbersOfLaws(mpm, layers):
	"""{layer: number of its skeleton law}; completes mpm.skeletons."""
	if not any("skeleton" in layer for layer in layers.values()):
		return dict.fromkeys(layers, 0)
	laws, numbers = list(mpm.skeletons) or ([mpm.skeleton] if mpm.skeleton is not None else []), {}
	for name, layer in layers.items():
		if "skeleton" not in layer:
			if mpm.skeleton is None or mpm.skeletons:
				raise ValueError(f"layer '{name}' has no skeleton law; give it one, or set MpmEngine.skeleton for layers without")
			numbers[name] = 0
			continue
		if layer["skeleton"] not in laws:
			laws.append(layer["skeleton"])
		numbers[name] = laws.index(layer["skeleton"])
	mpm.skeletons = laws
	return numbers


def _freezingPoint(curve):
	"""T_f of a FreezingCurve [degC]; of a table the temperature of its first point without ice."""
	if curve.curve != "table":
		return curve.freezingTemperature
	return next((t for t, saturation in zip(curve.temperatures, curve.liquidSaturations) if saturation == 1), 0.0)


def _refuseOtherMaterials(layers):
	for name, layer in layers.items():
		if "material" in layer and not isinstance(layer["material"], wrapper.GroundMaterial):
			raise ValueError(f"layer '{name}': material is {layer['material']!r}; give a GroundMaterial")


def _density(mpm, layer):
	"""Of a layer as a whole [kg/m3], with ice where it is colder than its freezing point."""
	material = layer.get("material", mpm.material)
	porosity, temperature = layer.get("porosity", 0.4), layer.get("temperature", 0.0)
	if callable(porosity) or np.ndim(porosity):
		raise ValueError("layers.fill: with lateralRatio a layer has one porosity; give a number, or give the stress to talik.geometry.fill")
	holds = mpm.heat is not None or mpm.water is not None
	poreFill = layer.get("poreFill", holds if np.isnan(mpm.poreFill) else mpm.poreFill)
	inside = _outlineOf("", layer).representative_point()
	temperature, poreFill = (np.mean(value(np.array([inside.x]), np.array([inside.y])) if callable(value) else value) for value in (temperature, poreFill))
	curve = getattr(material, "freezing", None) or mpm.freezing
	cold = mpm.heat is not None and curve is not None and temperature < _freezingPoint(curve)
	return (1 - porosity) * material.solidDensity + porosity * poreFill * (material.iceDensity if cold else material.liquidDensity)


def _geostatic(mpm, columns, lateralRatio, load, pressure, waterTable):
	"""Function of x, y [m] that gives the effective stress (n, 4) of ground at rest [Pa, tension positive].

	columns  outline of each layer, and its density above and below the water table"""
	weight = -mpm.gravity[1]
	top = max(outline.bounds[3] for outline, _, _ in columns) + 1.0

	def above(x, y):
		border = min(max(y, float(waterTable(x))), top)
		higher, lower = (LineString([(x, low), (x, high)]) for low, high in ((border, top), (y, border)))
		return load + weight * sum(dry * higher.intersection(outline).length + wet * lower.intersection(outline).length for outline, dry, wet in columns)

	def stress(x, y):
		carried = pressure(x, y) if callable(pressure) else pressure
		vertical = np.minimum(0.0, carried - np.array([above(*place) for place in zip(x, y)]))
		return np.stack([lateralRatio * vertical, vertical, lateralRatio * vertical, 0 * vertical], axis=1)

	return stress
