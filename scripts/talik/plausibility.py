# SPDX-License-Identifier: GPL-2.0-or-later
"""Settings of a ground that are valid and yet hardly what was meant: a sentence for each, with attribute, value and what was probably meant.
`talik.check` prints them. The first step says those that are grave: nothing sensible comes of them."""

import math

import numpy as np
from yade import wrapper


class Ground:
	"""An MpmEngine with its points as they were added."""

	def __init__(self, mpm):
		self.mpm, self.points = mpm, mpm.addedPoints()
		self.count = len(self.points["position"])
		self.dimension = self.points["position"].shape[1] if self.count else len(mpm.gravity)
		self.materials = [material for material in mpm.materials or [mpm.material] if material]
		self.laws = mpm.skeletons or ([mpm.skeleton] if mpm.skeleton else [])
		self.boundaries = [boundary for boundary in mpm.boundaries if boundary]


def settings(mpm):
	"""Of all settings: (sentence, whether it is grave), a list."""
	ground = Ground(mpm)
	return [doubt for look in looks for doubt in look(ground)]


def sentences(mpm):
	return [sentence for sentence, _ in settings(mpm)]


def grave(mpm):
	return [sentence for sentence, isGrave in settings(mpm) if isGrave]


# ---- ranges ----------------------------------------------------------------------------------------------------------------

# class and attribute: least, most, unit, whether it is grave
ranges = {
	("GroundMaterial", "solidDensity"): (300, 2e4, "kg/m^3", True),
	("GroundMaterial", "iceDensity"): (300, 2e4, "kg/m^3", True),
	("GroundMaterial", "liquidDensity"): (300, 2e4, "kg/m^3", True),
	("ElasticSkeleton", "young"): (1e4, 1e12, "Pa", False),
	("CreepingSkeleton", "young"): (1e4, 1e12, "Pa", False),
	("MohrCoulombSkeleton", "young"): (1e4, 1e12, "Pa", False),
	("MohrCoulombSkeleton", "cohesion"): (10, 1e8, "Pa", False),
	("MohrCoulombSkeleton", "cohesionFrozen"): (10, 1e9, "Pa", False),
}
rangesOfHeat = {
	("GroundMaterial", "solidSpecificHeat"): (50, 2e4, "J/(kg K)", True),
	("GroundMaterial", "latentHeat"): (1e4, 1e7, "J/kg", True),
	("GroundMaterial", "solidConductivity"): (0.01, 500, "W/(m K)", True),
	("GroundMaterial", "iceConductivity"): (0.01, 500, "W/(m K)", True),
	("GroundMaterial", "liquidConductivity"): (0.01, 500, "W/(m K)", True),
}


def outOfRange(ground):
	"""Where a thousand times more or less would do, or a million times for a stiffness, that was meant."""
	objects = ground.materials + (ground.laws if ground.mpm.motion else [])
	for (cls, attribute), (least, most, unit, isGrave) in {**ranges, **(rangesOfHeat if ground.mpm.heat else {})}.items():
		for one in objects:
			value = getattr(one, attribute) if isinstance(one, getattr(wrapper, cls)) else 0
			if value == 0 or not math.isfinite(value) or least <= value <= most:
				continue
			factor = 1e6 if attribute == "young" else 1e3
			meant = value * factor if value < least else value / factor
			remedy = f"was {meant:.4g} meant?" if least <= meant <= most else f"{least:.4g} to {most:.4g} would be usual."
			yield f"{cls}.{attribute} is {value:.4g} {unit}: {remedy}", isGrave


def anglesInRadians(ground):
	for law in ground.laws if ground.mpm.motion else []:
		angle = law.frictionAngle if isinstance(law, wrapper.MohrCoulombSkeleton) else 0
		if 0 < angle < 1.58:
			yield (
				f"MohrCoulombSkeleton.frictionAngle is {angle:.4g} degrees: was {math.degrees(angle):.4g} (the same number in radians) meant?",
				True,
			)


def gravityBeside(ground):
	gravity = list(ground.mpm.gravity)
	if not ground.mpm.motion or len(gravity) != ground.dimension:
		return
	text = "({})".format(", ".join(f"{g:g}" for g in gravity))
	if gravity[-1] > 0:
		meant = ", ".join(f"{g:g}" for g in [*gravity[:-1], -gravity[-1]])
		yield f"MpmEngine.gravity is {text} m/s^2, upwards: was ({meant}) meant?", True
	elif len(gravity) == 3 and gravity[2] == 0 and any(gravity):
		yield f"MpmEngine.gravity is {text} m/s^2: z points upwards in space, was (0, 0, {-np.linalg.norm(gravity):.4g}) meant?", True


def conductivityOfWater(ground):
	k = ground.mpm.water.conductivity if ground.mpm.water else 0.01
	if k < 1e-14:
		yield f"PoreWater.conductivity is {k:.4g} m/s: soils and rocks have 1e-14 to 1 m/s; was a permeability in m^2 given?", False
	elif k > 0.05:
		yield (
			f"PoreWater.conductivity is {k:.4g} m/s: soils and rocks have 1e-14 to 1 m/s, and only coarse gravel more than 0.05; was {k / 86400:.4g} "
			f"({k:.4g} m per day) meant?",
			False,
		)


def clock(ground):
	scale = ground.mpm.heat.thermalTimeScale if ground.mpm.heat else 1
	if 0 < scale < 1:
		yield (
			f"HeatTransfer.thermalTimeScale is {scale:.4g}, so that {scale:.4g} s of the calendar pass in a second of motion: was {1 / scale:.4g} meant?",
			False,
		)


# ---- points ----------------------------------------------------------------------------------------------------------------


def _nearest(position):
	"""Median distance of points from the nearest other one; of some hundred points where there are more."""
	looked = position[:: max(1, len(position) // 300)]
	distances = [np.partition(((position - place) ** 2).sum(1), 1)[1] for place in looked]
	return math.sqrt(np.median(distances))


def places(ground):
	"""Volumes of points beside their distances."""
	position, volume, spacing, d = ground.points["position"], ground.points["volume"], ground.mpm.gridSpacing, ground.dimension
	if ground.count < 4 or not spacing > 0 or not (volume > 0).all() or not np.isfinite(position).all():
		return
	unit, usual = f"m^{d}", np.median(volume)
	boxes = np.floor((position - position.min(0)) / usual ** (1 / d) + 0.5).astype(np.int64)
	room = usual * len(np.unique(np.ravel_multi_index(boxes.T, boxes.max(0) + 1)))
	if volume.sum() > 1.8 * room:
		yield (
			f"The volumes of the points add to {volume.sum():.4g} {unit} in a room of some {room:.4g} {unit}: was an outline filled twice, or "
			f"volume (median {usual:.4g} {unit}) given for more than one point?",
			True,
		)
	apart = _nearest(position)
	if not apart <= 1.2 * spacing:
		yield (
			f"MpmEngine.gridSpacing is {spacing:.4g} m and most points have no other one within {1.2 * spacing:.4g} m: the grid cannot carry "
			"ground whose points are farther apart than its nodes; give smaller points or a coarser grid.",
			True,
		)
	elif usual < 0.1 * apart**d:
		yield (
			f"The volume of the points is {usual:.4g} {unit} (median) where their distance of {apart:.4g} m makes {apart**d:.4g} {unit}: was "
			"volume meant to be that?",
			True,
		)


def stressOfPoints(ground):
	stress = ground.points["stress"][:, :3]
	stress = stress[np.isfinite(stress[:, 0])]
	most = stress.max(1, initial=-np.inf)
	if (most > 0).any():
		yield (
			f"addPoints: stress of {(most > 0).sum()} points is tensile, up to {most.max():.4g} Pa: was compression meant? Compression is negative.",
			bool(2 * (most > 0).sum() > ground.count),
		)
	yield from _inKilopascal("addPoints: stress", abs(stress).max(initial=0), 500, ground.mpm.motion)
	yield from _inKilopascal("addPoints: pressure", abs(ground.points["pressure"]).max(initial=0), 200, ground.mpm.water)


def stressUnderInclinedGravity(ground):
	"""The weight of a slope along the grid is borne by shear."""
	gravity, stress = list(ground.mpm.gravity), ground.points["stress"]
	if ground.dimension != 2 or len(gravity) != 2 or not ground.mpm.motion or not abs(gravity[0]) > 1e-3 * abs(gravity[1]):
		return
	if ground.count and np.isfinite(stress).all() and (stress[:, 1] < 0).any() and not stress[:, 3].any():
		angle = math.degrees(math.atan2(abs(gravity[0]), abs(gravity[1])))
		yield (
			f"MpmEngine.gravity is inclined by {angle:.3g} degrees to the grid, and the stress of the points has no shear, so that the ground starts out "
			"of balance (lateralRatio is for level ground): talik.slope.infiniteColumn makes a slope that is in balance.",
			False,
		)


def _inKilopascal(name, value, least, asked):
	if asked and 0 < value < least:
		yield f"{name} is {value:.4g} Pa at most: was {value * 1e3:.4g} Pa (kPa) meant?", False


def unused(ground):
	"""What points carry for an effect that the scene does not have."""
	for attribute, effect, unit, without, remedy in (
		("temperature", "heat", "degC", "heat", "add heat=HeatTransfer()"),
		("pressure", "water", "Pa", "water", "add water=PoreWater()"),
		("velocity", "motion", "m/s", "motion", "set motion=True"),
	):
		values = ground.points[attribute]
		values = np.linalg.norm(values, axis=1) if values.ndim > 1 else values
		most = values[abs(values).argmax()] if ground.count and not getattr(ground.mpm, effect) else 0
		if most:
			yield f"addPoints: {attribute} is {most:.4g} {unit} and is not used, since the scene has no {without}: {remedy}, or leave {attribute} out.", True


# ---- boundaries ------------------------------------------------------------------------------------------------------------


def _largest(constant, table):
	return max(map(abs, table)) if table else abs(constant)


def loadsAndRain(ground):
	for boundary in ground.boundaries:
		if isinstance(boundary, wrapper.SurfaceLoad):
			yield from _inKilopascal("SurfaceLoad.pressure", _largest(boundary.pressure, boundary.values), 500, True)
		elif isinstance(boundary, wrapper.WaterFlux):
			flux = _largest(boundary.flux, boundary.values)
			if flux > 0.1:
				yield f"WaterFlux.flux is {flux:.4g} m/s: was {flux / 1e3 / 3600:.4g} m/s ({flux:.4g} mm per hour) meant?", False
			elif flux > 0 and boundary.region == "surface" and (ground.mpm.freezing or _isFullAndClosed(ground)):
				yield (
					"WaterFlux on the surface: rain does not run off here. What frozen or full ground cannot take is pressed into it and lifts it: "
					"give DrainedBoundary(region='surface') while it takes none.",
					False,
				)


def _isFullAndClosed(ground):
	return (
		not (ground.points["poreFill"] < 1).any()
		and not ground.mpm.poreFill < 1
		and not any(isinstance(boundary, wrapper.DrainedBoundary) for boundary in ground.boundaries)
	)


def ponds(ground):
	"""Water that stands on the ground presses on its grains, too."""
	if not ground.mpm.motion or any(isinstance(boundary, wrapper.SurfaceLoad) for boundary in ground.boundaries):
		return
	for boundary in ground.boundaries:
		if isinstance(boundary, wrapper.DrainedBoundary) and boundary.region == "surface":
			pressure = _largest(boundary.pressure, boundary.values)
			if pressure > 0:
				yield (
					f"DrainedBoundary.pressure is {pressure:.4g} Pa on the surface, where no load is: water that stands there presses on the ground, too. "
					f"Add SurfaceLoad(region='surface',pressure={pressure:.4g}).",
					False,
				)


def rechargeOfDryGround(ground):
	"""A drained surface is wet: ground that is not full takes water from it."""
	fills = ground.points["poreFill"]
	if not ground.mpm.water or not (fills < 1).any():
		return
	for boundary in ground.boundaries:
		if isinstance(boundary, wrapper.DrainedBoundary) and boundary.recharge and boundary.region == "surface":
			yield (
				f"DrainedBoundary on the surface lets water in, and {int((fills < 1).sum())} points have pores that are not full: was recharge=False meant, "
				"by which water only leaves?",
				False,
			)


def walls(ground):
	"""Only a side that ground touches can warm or cool it."""
	last, corners = ground.dimension - 1, (ground.mpm.lower, ground.mpm.upper)
	sides = dict(left=(0, 0), right=(0, 1), bottom=(last, 0), top=(last, 1), front=(1, 0), back=(1, 1))
	if any(corner is None or len(corner) != ground.dimension for corner in corners):
		return
	for boundary in ground.boundaries:
		if isinstance(boundary, wrapper.WallTemperature) and boundary.region in sides:
			axis, upper = sides[boundary.region]
			apart = abs(ground.points["position"][:, axis] - corners[upper][axis]).min(initial=math.inf)
			if apart > ground.mpm.gridSpacing:
				yield (
					f"WallTemperature(region='{boundary.region}'): no ground is there, the nearest point is {apart:.4g} m away: was "
					"SurfaceTemperature(region='surface') meant, or a grid that ends at the ground?",
					True,
				)


thermal = ("SurfaceTemperature", "WallTemperature", "BodyTemperature", "HeatFlux", "HeatSource")


def tablesInDays(ground):
	"""Tables in days that nobody waits for."""
	longest = 1e5  # days of a table: 274 years
	for boundary in ground.boundaries:
		end = boundary.days[-1] if boundary.days else 0
		if end > longest:
			yield (
				f"{type(boundary).__name__}.days ends at day {end:.4g}, in {end / 365.25:.4g} years: were seconds meant? They are times=, in place of days.",
				False,
			)


def tablesInSeconds(ground):
	"""Tables in seconds that are over before anything comes of them."""
	diffusivity, partOfCell, shortest = 1e-6, 0.1, 1e-3  # of ground [m^2/s]; -; of a table [s of motion]
	scale, spacing = ground.mpm.heat.thermalTimeScale if ground.mpm.heat else 1, ground.mpm.gridSpacing
	for boundary in ground.boundaries:
		end = boundary.times[-1] if len(boundary.times) > 1 else 0
		if isinstance(boundary, wrapper.MovingBoundary) or not end > 0:
			continue
		name, depth = type(boundary).__name__, math.sqrt(diffusivity * end)
		days = ", ".join(f"{time:g}" for time in boundary.times)
		said = f"{name}.times ends at {end:.4g} s of the calendar, "
		if name in thermal:
			if depth < partOfCell * spacing:
				yield f"{said}in which heat comes some {1e3 * depth:.4g} mm deep in cells of {spacing:.4g} m: was days=[{days}] meant?", False
		elif end < shortest * scale:
			yield f"{said}which pass within {end / scale:.4g} s of motion: was days=[{days}] meant?", False


def _freezes(boundary, thawed):
	"""Whether a boundary cools thawed ground below zero; ground that is frozen at first has to be warmed before."""
	name = type(boundary).__name__
	if name == "HeatFlux":
		return thawed and min(boundary.values or [boundary.flux]) < 0
	if name not in thermal or name == "HeatSource":
		return False
	values = list(boundary.values) or ([boundary.temperature] if thawed else [])
	warm = 0 if thawed else next((k + 1 for k, value in enumerate(values) if value > 0), len(values))
	return min(values[warm:], default=0) < 0


def heaveIsAbsent(ground):
	mpm = ground.mpm
	if not (mpm.water and mpm.freezing and mpm.heat) or mpm.segregation:
		return
	thawed = bool((ground.points["temperature"] >= 0).any())
	if any(_freezes(boundary, thawed) for boundary in ground.boundaries):
		yield (
			"Ground freezes here and has water to draw: frost heave by segregation (ice lenses, cryosuction) is absent. What heaves is pore water "
			"that freezes where it is, by 9 % of its volume at most. segregation=IceSegregation(segregationPotential=1e-9) adds it.",
			False,
		)


def explicitPressureOfExcessIce(ground):
	"""Ground that has just thawed bears nothing until its excess water has left."""
	water = ground.mpm.water
	if not (water and ground.mpm.freezing and ground.mpm.motion) or water.pressure != "explicit":
		return
	most = max((material.thawStrain for material in ground.materials), default=0)
	if most > 0:
		yield (
			f"GroundMaterial.thawStrain is {most:.4g} and PoreWater.pressure 'explicit', with which excess water leaves too late: a slope that stands by hand "
			"may flow as it thaws. Give PoreWater(pressure='implicit').",
			False,
		)


def segregationComputed(ground):
	"""Ice that draws water by no measured potential."""
	segregation = ground.mpm.segregation
	if segregation and math.isnan(segregation.segregationPotential):
		yield (
			"IceSegregation.segregationPotential is not given, so that frost heave is computed from freezing curve and conductivity. That is an upper bound: "
			"each lens lies where it draws most, and a silt measured in the laboratory heaved a third to a half of it, with any PoreWater.impedance. Give a "
			"measured segregationPotential; silts have 1e-10 to 4e-9 m2/(s K).",
			False,
		)


looks = (
	places,
	gravityBeside,
	outOfRange,
	stressOfPoints,
	stressUnderInclinedGravity,
	unused,
	anglesInRadians,
	conductivityOfWater,
	loadsAndRain,
	ponds,
	rechargeOfDryGround,
	walls,
	tablesInDays,
	tablesInSeconds,
	heaveIsAbsent,
	explicitPressureOfExcessIce,
	segregationComputed,
	clock,
)


# ---- samples ---------------------------------------------------------------------------------------------------------------


def _weightAbove(ground, gravity):
	"""Vertical effective stress that the weight above each point makes [Pa], compression positive, by columns as wide as a cell."""
	mpm, points = ground.mpm, ground.points
	position, spacing = points["position"], mpm.gridSpacing
	usual = mpm.poreFill if not math.isnan(mpm.poreFill) else 1 if mpm.heat or mpm.water else 0
	fill = np.where(np.isnan(points["poreFill"]), usual, points["poreFill"])
	solid, liquid = (np.array([getattr(m, name) for m in ground.materials])[points["material"].astype(int)] for name in ("solidDensity", "liquidDensity"))
	density = (1 - points["porosity"]) * solid + points["porosity"] * fill * liquid
	own = points["volume"] * gravity * density / spacing ** (ground.dimension - 1)
	_, column = np.unique(np.floor(position[:, :-1] / spacing + 1e-6), axis=0, return_inverse=True)
	order = np.lexsort((-position[:, -1], column.ravel()))
	above = np.cumsum(own[order]) - own[order]
	first = np.r_[True, np.diff(column.ravel()[order]) != 0]
	weight = np.empty(ground.count)
	weight[order] = above - above[first][np.cumsum(first) - 1]
	load = sum((b.values[0] if b.values else b.pressure) for b in ground.boundaries if isinstance(b, wrapper.SurfaceLoad))
	return load + weight + 0.5 * own - (points["pressure"] if mpm.water else 0)


def samples(mpm):
	"""Of a ground that was made and has not begun: samples whose stress does not fit their depth."""
	least, factor = 3e3, 2  # weight that a sample feels [Pa], and how far its stress may be from that [-]
	ground = Ground(mpm)
	gravity = -list(mpm.gravity)[-1]
	own = np.array([isinstance(law, wrapper.RveSkeleton) for law in ground.laws])
	if not mpm.motion or not gravity > 0 or not own.any():
		return []
	due = _weightAbove(ground, gravity)
	looked = own[ground.points["skeleton"].astype(int)] & (due >= least)
	due, found = due[looked], -mpm.field("stress")[looked, ground.dimension - 1]
	fits = (found < factor * due) & (factor * found > due)
	if 2 * (~fits).sum() <= len(due):
		return []
	return [
		f"RveSkeleton: samples begin with a vertical stress of {-np.median(found):.4g} Pa (median) where the weight above their points makes "
		f"{-np.median(due):.4g} Pa: ground bursts or falls together as it thaws; talik.slope.settle(mpm, outline) brings them to it."
	]


# ---- in a run --------------------------------------------------------------------------------------------------------------


def ofCalendar(mpm, step, reach):
	"""Tables of which nothing is left after one step were probably meant in seconds of motion, or in days; water faster than the grains hold. A list.

	step   of the ground [s]
	reach  calendar time that one step may take for the sake of heat [s]"""
	water, heat, found = mpm.water, mpm.heat, []
	scale = mpm.calendar["seepageScale"] if water else 1
	if scale < 1 and not water.hydraulicTimeScale < 1 and not (heat and heat.thermalTimeScale < 1):
		found.append(
			f"PoreWater.conductivity is {water.conductivity:g} m/s, {water.conductivity * scale:g} m/s is used: pressure in this ground rests within a "
			"fraction of a second with it, with more the water would swing."
		)
	slow = min(heat.thermalTimeScale * step if heat else step, reach if heat and heat.followsMotion else math.inf)
	for number, boundary in enumerate(mpm.boundaries):
		times = boundary.times
		if len(times) < 2 or not 0 < times[-1] < slow:
			continue
		scaled = f", and one second of motion is {heat.thermalTimeScale:g} s of the calendar" if heat and heat.thermalTimeScale != 1 else ""
		found.append(
			f"MpmEngine.boundaries[{number}], {type(boundary).__name__}.times ends at {times[-1]:g} s of calendar time, within the first step of {slow:g} s; "
			f"days are given as days * talik.day{scaled}."
		)
	return found


def lensThatParts(mpm):
	"""A lens grows along the gradient of temperature and draws its points apart in that direction. Farther apart than a cell is wide they leave cells
	between them without points. What is to be said of the first such point; empty if there is none."""
	ice, volume = mpm.field("segregatedVolume"), mpm.field("volume")
	soil = volume - ice
	with np.errstate(invalid="ignore", divide="ignore"):
		length = soil ** (1 / mpm.dimension) * volume / soil
	parted = np.flatnonzero((ice > 0.25 * soil) & (soil > 0) & (length > 1.25 * mpm.gridSpacing))  # one of five cells has no point then
	for point in parted[:1]:
		return (
			f"Talik warns: on day {mpm.calendar['day']:.3g} the ice lens in point {point} is {ice[point] / soil[point]:.3g} times as thick as its soil "
			f"and makes it {length[point]:.3g} m long, with cells of {mpm.gridSpacing:.3g} m: cells beside it have no points, and from then on up to a fifth "
			"too little ice forms. Take an MpmEngine.gridSpacing larger than the lens grows, or only the days before."
		)
	return ""
