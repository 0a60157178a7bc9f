# SPDX-License-Identifier: GPL-2.0-or-later
"""Silty slopes of 12, 18 and 24 degrees that thaw from their surface, beside the centrifuge tests of Harris, Rea & Davies (2001).

	scripts/run centrifuge_slopes [--preset test|draft] [--vary conductivity thawStrain …] [--cycles 4] [--assume cohesion=1200] [--skeleton samples]

Measured at a tenth of the size and ten times gravity, here in full size (doi 10.1002/ppp.373): the surface moved by 187 mm in a cycle
of frost and thaw at 12 degrees and by 651 mm at 18; at 24 degrees the slope failed as a mudflow. Each slope thaws once here, or --cycles times:
excess ice that has melted does not form again by itself, so the next cycle begins with a frozen layer of the shape that the last one left, which has
heaved normal to the slope to the volume of the first. What the paper's abstract, or another one of the same laboratory, says of the soil is marked as such in
`Assumptions`; the rest is assumed, and --vary shows what each assumption does. --skeleton samples puts a sample of discs behind every point in place of
the law, with its cohesion and about its friction, and the law beside them. With --assume segregation=1e-9 each slope freezes from its surface,
with that segregation potential SP_0 [m^2/(s K)] and water at its base, heaves, thaws, and freezes again by itself, in one run of all cycles.
With --ice column each cycle begins with frozen ground that has the excess ice of a column that has frozen so.
Runs that the folder already holds are not repeated.
Change the conductivity, the thaw strain or the cohesion first.
Friction and conductivity are such that the slope of 18 degrees is about as safe in its thaw as the paper says.
"""

import argparse
import functools
import hashlib
import json
import math
from dataclasses import asdict, dataclass, fields, replace

import numpy as np
from yade import O

import talik
from talik import output, plots
from talik.files import writableFolder, writeWhole

measured = {12: 0.187, 18: 0.651, 24: math.inf}  # of the surface in a cycle [m]; infinite: a mudflow
flowing = 1.5  # [m]: what has moved so far in one thaw flows; the slope of 18 degrees stopped at half of it
longest = 60.0  # [s of motion]
gravity, solid, water = 9.81, 2650.0, 1000.0
solidConductivity, waterConductivity = 2.0, 0.6  # thermal [W/(m K)]
iceDensity, latentHeat = 910.0, 334e3  # [kg/m^3], [J/kg]
frostTemperature, pressureDecay = -5.0, 8e-6  # of the surface in a frost [degC], of SP = SP_0 exp(-a P) [1/Pa]: assumed, with `segregation`
frost, mostCycles = 65.0, 10  # a frost that freezes the whole layer [days]
frozenImpedance = 2.0  # of ice to water in ground that freezes by itself [-], assumed
colours = ("C0", "C1", "C3")  # of the slopes


def kozenyCarman(porosity):
	return porosity**3 / (1 - porosity) ** 2


@dataclass(frozen=True)
class Assumptions:
	thickness: float = 0.8  # of the layer that thaws [m]; 0.8 to 0.9 in the same laboratory (Kern-Luetschg & Harris 2008)
	cohesion: float = 800.0  # [Pa]; least undrained strength of a thawing slope of 12 degrees, 0.8 to 9 kPa (Harris 1995)
	safetyAt18: float = 1.0  # of the infinite slope of 18 degrees in its thaw; close to 1 or slightly less (the paper): gives the friction angle
	conductivity: float = 2e-7  # [m/s], assumed; with less the upper part of the slope of 18 degrees is less safe than the paper says, see `excess`
	thawStrain: float = 0.1  # excess ice [-], assumed
	segregation: float = 0.0  # SP_0 [m^2/(s K)] of ground that draws its excess ice, with water at the base; silts have 1e-10 to 4e-9; 0: thawStrain
	porosity: float = 0.45  # assumed
	young: float = 2e6  # of thawed ground [Pa], assumed
	surfaceTemperature: float = 10.0  # during the thaw [degC], assumed
	length: float = 8.0  # between the walls of the box [m], assumed
	impedance: float = 0.0  # of ice to water [-]: none, so that the water of a row of cells that thaws can leave it before its last ice has melted
	pointsPerCell: float = 1  # rows of points that share a cell but thaw one after the other have rough stress
	motionTolerance: float = 0.1  # of the calendar [m/s]: faster ground has no calendar of its own
	frontVelocities: float = 1  # at the thaw front; 2: of frozen and of thawed ground, which then slides on it (ThawFront)
	gridSpacing: float = 0.1  # [m]

	@property
	def density(self):
		return (1 - self.porosity) * solid + self.porosity * water

	@property
	def excess(self):
		"""Pressure above that of water at rest at the thaw front [Pa], from the flow of what melts to the surface: the speed of the front falls as its depth
		grows (Stefan), so that their product and this pressure stay."""
		settled = (self.porosity - self.thawStrain) / (1 - self.thawStrain)
		heat = ((1 - settled) * solidConductivity + settled * waterConductivity) * self.surfaceTemperature
		melting = self.porosity * iceDensity * latentHeat
		return water * gravity * self.thawStrain * heat / (melting * self.conductivity * kozenyCarman(settled) / kozenyCarman(self.porosity))

	def safety(self, slope, depth, friction):
		"""Factor of safety of the infinite slope [deg] in its thaw at a depth z [m, vertical] of the front,
		F = (c + max(0, (gamma - gamma_w) z cos^2(b) - p_e) tan(phi))/(gamma z sin(b) cos(b))."""
		b, weight = math.radians(slope), self.density * gravity
		normal = (weight - water * gravity) * depth * math.cos(b) ** 2 - self.excess
		return (self.cohesion + max(0.0, normal) * friction) / (weight * depth * math.sin(b) * math.cos(b))

	@property
	def friction(self):
		"""tan(phi) by the factor of safety at the base of the slope of 18 degrees."""
		base = self.thickness / math.cos(math.radians(18))
		held, frictional = self.safety(18, base, 0), self.safety(18, base, 1) - self.safety(18, base, 0)
		return (self.safetyAt18 - held) / frictional if frictional > 0 else math.inf

	@property
	def timeScale(self):
		"""Calendar time over time of motion: seepage is accelerated with the thaw up to 0.05 m/s."""
		return min(5e5, 0.05 / self.conductivity)


variations = {
	"conductivity": (1.4e-7, 3e-7),
	"thawStrain": (0.05, 0.15),
	"segregation": (5e-10, 1e-9, 2e-9),
	"cohesion": (400.0, 1200.0, 2000.0),
	"safetyAt18": (0.9, 0.95, 1.1),
	"young": (1e6, 5e6),
	"surfaceTemperature": (5.0, 15.0),
	"length": (4.0, 16.0),
	"impedance": (6.0,),
	"pointsPerCell": (4.0,),
	"motionTolerance": (0.05, 0.2),
	"frontVelocities": (2.0,),
	"gridSpacing": (0.2, 0.2 / 3),
}
units = {
	"motionTolerance": "m/s",
	"conductivity": "m/s",
	"segregation": "m²/(s K)",
	"cohesion": "Pa",
	"young": "Pa",
	"surfaceTemperature": "°C",
	"length": "m",
	"gridSpacing": "m",
}


@dataclass(frozen=True)
class Grains:
	"""Samples of discs behind the points, with about the friction of the soil in simple shear."""

	grains: int = 60
	porosity: float = 0.16
	etaRoll: float = 0.2
	realisations: int = 4


@functools.lru_cache(maxsize=None)
def iceOf(potential, thickness, porosity, conductivity, h, slope=18):
	"""Excess ice over the volume of frozen ground [-] of the rows of cells of a layer that freezes from its surface, from its base up. Water comes from the
	base, at the pressure of a water table at the surface."""
	O.reset()
	down = gravity * math.cos(math.radians(slope))
	mpm = MpmEngine(
		gridSpacing=h,
		lower=(0, 0),
		upper=(h, 1.5 * thickness),
		gravity=(0, -down),
		damping=0.3,
		material=GroundMaterial(name="silt", solidConductivity=solidConductivity),
		heat=HeatTransfer(thermalTimeScale=min(1e6, 0.04 / conductivity)),
		freezing=FreezingCurve(width=0.3),
		water=PoreWater(conductivity=conductivity, referencePorosity=porosity, cavitationPressure=-1e5),
		segregation=IceSegregation(segregationPotential=potential, pressureDecay=pressureDecay),
		skeleton=MohrCoulombSkeleton(young=1e7, youngFrozen=2e7, frictionAngle=30, cohesion=0, cohesionFrozen=5e5),
		boundaries=[
			*(RollerBoundary(region=side) for side in ("left", "right", "bottom")),
			DrainedBoundary(region="bottom", pressure=water * down * thickness),
			SurfaceTemperature(region="surface", days=[0, 1], values=[1, frostTemperature]),
		],
	)
	column = dict(polygon=talik.geometry.rectangle(0, 0, h, thickness), porosity=porosity, temperature=1, pressure=lambda x, y: water * down * (thickness - y))
	talik.layers.fill(mpm, {"silt": column}, lateralRatio=0.5)
	O.engines = [mpm]
	O.step()
	row = np.minimum(mpm.field("position")[:, 1] // h, round(thickness / h) - 1).astype(int)
	while mpm.field("iceSaturation").min() < 0.9:
		talik.runUntilDay(mpm, mpm.calendar["day"] + 1)
		if mpm.calendar["day"] > 365:
			raise SystemExit(f"a layer of {thickness:g} m does not freeze within a year at {frostTemperature:g} degC: take less segregation or thickness")
	return tuple(np.bincount(row, mpm.field("segregatedVolume")) / np.bincount(row, mpm.field("volume")))


def rowsOf(ground):
	return iceOf(ground.segregation, ground.thickness, ground.porosity, ground.conductivity, ground.gridSpacing)


def withIce(ground):
	"""The same ground with the mean of its segregated ice as thaw strain, from which its factor of safety and friction follow."""
	return replace(ground, thawStrain=float(np.mean(rowsOf(ground)))) if ground.segregation else ground


@functools.lru_cache(maxsize=1)
def samplesOf(grains, cohesion):
	"""(samples without ice whose bonds keep a cohesion [Pa] when their ice has gone, that cohesion as measured [Pa], their friction angle [deg] in
	simple shear without it)."""
	packed = talik.rve.pack(talik.rve.prepare(ice=True, **asdict(grains)))
	friction = talik.studies.calibrate.thawedPeakFriction(packed, pressures=(8e3,))
	strength, measured = talik.studies.calibrate.thawedStrength(packed, cohesion)
	for sample in packed:
		sample.thawedStrength = strength
	return packed, measured, math.degrees(math.atan(friction))


def thaw(slope, ground, days, profile=None, grains=None):
	"""One slope [deg] that thaws for some days, in a box that is tilted with it: days, path of the surface down the slope and settlement at
	mid-length [m], heights and paths of the points there at the end [m], depth thawed [m], and the profile of the surface at the end, its
	places and heights [m]. profile: the one that it has at the start; default: even. grains: of the samples; None: the law."""
	O.reset()
	profile = profile or even(ground)
	mpm = scene(math.radians(slope), ground, profile, grains)
	O.engines = [mpm]
	O.step()
	mpm.resetDisplacement()
	start = mpm.field("position")
	middle = np.abs(start[:, 0] - 0.5 * ground.length) < 0.25 * ground.length
	top = start[:, 1] > np.interp(start[:, 0], *profile) - 0.75 * ground.gridSpacing
	surface = middle & top
	rows = []
	while not rows or (rows[-1][0] < days and rows[-1][1] < flowing and O.time < longest):
		talik.runSerially(300)
		path = mpm.field("displacement")
		rows.append((mpm.calendar["day"], path[surface, 0].mean(), -path[surface, 1].mean()))
	heights = np.unique(start[middle, 1].round(6))
	paths = [path[middle & (np.abs(start[:, 1] - height) < 1e-6), 0].mean() for height in heights]
	thawed = ground.thickness * np.mean(mpm.field("iceSaturation")[middle] < 0.02)
	run = dict(zip(("days", "path", "settlement"), np.transpose(rows).tolist())) | dict(heights=heights.tolist(), paths=paths, thawed=float(thawed))
	return run | dict(profile=heaved(mpm.field("position")[top], ground))


def even(ground):
	return [0.0, ground.length], [ground.thickness, ground.thickness]


def heaved(surface, ground):
	"""Profile of a layer whose surface has come to these positions and that heaves normal to the slope until it has its first volume again."""
	places = np.linspace(0, ground.length, round(0.5 * ground.length / ground.gridSpacing) + 1)
	order = np.argsort(surface[:, 0])
	heights = np.interp(places, surface[order, 0], surface[order, 1])
	area = np.sum(0.5 * (heights[1:] + heights[:-1]) * np.diff(places))
	heights *= ground.thickness * ground.length / area
	return places.tolist(), heights.tolist()


class OwnIce:
	"""One slope [deg] that freezes and thaws by itself, one cycle after the other in one run."""

	def __init__(self, slope, ground, days):
		O.reset()
		self.ground, self.days, self.done = ground, days, 0
		self.mpm = sceneOfIce(math.radians(slope), ground, days)
		O.engines = [self.mpm]
		O.step()
		self.mpm.resetDisplacement()
		self.start = self.mpm.field("position")

	def next(self):
		"""The next frost and thaw, as thaw() returns them, with what the frost did: heave normal to the slope and path down the slope [m], excess ice
		[m] and its part of the volume of each row of cells, from the base up."""
		ground, mpm, days, begin = self.ground, self.mpm, self.days, self.done * (frost + self.days)
		before = self.path()
		talik.runUntilDay(mpm, begin + frost)
		middle, surface, rows = *self.parts(), (self.start[:, 1] // ground.gridSpacing).astype(int)
		frozen, length = self.path(), 0.5 * ground.length
		ice, volume = mpm.field("segregatedVolume"), mpm.field("volume")
		winter = dict(
			heave=float((frozen - before)[surface, 1].mean()),
			frostPath=float((frozen - before)[surface, 0].mean()),
			ice=float(ice[middle].sum() / length),
			rows=(np.bincount(rows[middle], ice[middle]) / np.bincount(rows[middle], volume[middle])).tolist(),
			frozen=float(np.mean(mpm.field("iceSaturation") > 0.9)),
		)
		history, instant = [], O.time
		while not history or (history[-1][0] < days and history[-1][1] < flowing and O.time - instant < longest):
			talik.runSerially(300)
			moved = self.path() - frozen
			history.append((mpm.calendar["day"] - begin - frost, moved[surface, 0].mean(), -moved[surface, 1].mean()))
		self.done += 1
		moved = self.path() - frozen
		heights = np.unique(self.start[middle, 1].round(6))
		paths = [float(moved[middle & (np.abs(self.start[:, 1] - height) < 1e-6), 0].mean()) for height in heights]
		thawed = ground.thickness * np.mean(mpm.field("iceSaturation")[middle] < 0.02)
		run = dict(zip(("days", "path", "settlement"), np.transpose(history).tolist()))
		return run | dict(heights=heights.tolist(), paths=paths, thawed=float(thawed)) | winter

	def path(self):
		return self.mpm.field("displacement")

	def parts(self):
		"""Whether points lie in the middle half, and in it at the surface."""
		place = self.mpm.field("position")[:, 0]
		middle = np.abs(place - 0.5 * self.ground.length) < 0.25 * self.ground.length
		return middle, middle & (self.start[:, 1] > self.ground.thickness - 0.5 * self.ground.gridSpacing)


def sceneOfIce(b, ground, days):
	"""A slope before its first frost, at rest under its weight. Water stands at its surface, and is fed at its base."""
	h, height, across, down = ground.gridSpacing, ground.thickness, gravity * math.sin(b), gravity * math.cos(b)
	day, period, warm = [0.0, 1.0], frost + days, ground.surfaceTemperature
	for cycle in range(mostCycles):
		day += [cycle * period + frost, cycle * period + frost + 1, (cycle + 1) * period, (cycle + 1) * period + 1]
	mpm = MpmEngine(
		gridSpacing=h,
		lower=(0, 0),
		upper=(ground.length, height + 1.6),
		gravity=(across, -down),
		damping=0.1,
		material=GroundMaterial(name="silt", solidConductivity=solidConductivity),
		heat=HeatTransfer(thermalTimeScale=ground.timeScale, followsMotion=True, motionTolerance=ground.motionTolerance),
		freezing=FreezingCurve(width=0.3),
		water=PoreWater(
			conductivity=ground.conductivity,
			referencePorosity=ground.porosity,
			bulkModulus=5e6,
			impedance=ground.impedance or frozenImpedance,
			cavitationPressure=-1e5,
		),
		segregation=IceSegregation(segregationPotential=ground.segregation, pressureDecay=pressureDecay),
		skeleton=skeletonOf(ground, None),
		boundaries=[
			RollerBoundary(region="left"),
			RollerBoundary(region="right"),
			FixedBoundary(region="bottom"),
			DrainedBoundary(region="surface"),
			DrainedBoundary(region="bottom", pressure=water * down * height),
			SurfaceTemperature(
				region="surface",
				days=day,
				values=[0.5 * warm, frostTemperature] + mostCycles * [frostTemperature, warm, warm, frostTemperature],
			),
		],
	)
	x, y = np.arange(0.5 * h, ground.length, h), np.arange(0.25 * h, height, 0.5 * h)  # two rows of points in a cell
	position = np.stack(np.meshgrid(x, y, indexing="ij"), axis=-1).reshape(-1, 2)
	above, stress = height - position[:, 1], np.zeros((len(position), 4))
	stress[:, 1] = -(ground.density - water) * down * above
	stress[:, 0] = stress[:, 2] = 0.5 * stress[:, 1]
	stress[:, 3] = ground.density * across * above
	mpm.addPoints(
		position=position,
		volume=np.full(len(above), 0.5 * h * h),
		porosity=ground.porosity,
		temperature=0.5 * warm,  # about what a thaw leaves
		pressure=water * down * above,
		stress=stress,
	)
	return mpm


def skeletonOf(ground, grains):
	if grains:
		return RveSkeleton(samples=samplesOf(grains, ground.cohesion)[0], strainTolerance=5e-5)
	# the law does not dilate: in simple shear its strength is c cos(phi) + s sin(phi), which is to be the soil's c + s tan(phi)
	angle = math.asin(ground.friction)
	return MohrCoulombSkeleton(
		young=ground.young,
		youngFrozen=2e7,
		frictionAngle=math.degrees(angle),
		cohesion=ground.cohesion / math.cos(angle),
		tensileStrength=ground.cohesion / ground.friction,
		cohesionFrozen=5e5,
		tensileStrengthFrozen=3e5,
	)


def layersOf(layer, ground, profile):
	"""One layer, or as many as rows of segregated ice, each with its own thaw strain."""
	if not ground.segregation:
		return {"silt": layer}
	places, heights = np.array(profile)
	rows, layers = rowsOf(ground), {}
	for k, ice in enumerate(rows):
		below, above = heights * k / len(rows), heights * (k + 1) / len(rows)
		outline = [*zip(places, below), *zip(places[::-1], above[::-1])]
		material = GroundMaterial(name=f"silt {k + 1}", solidConductivity=solidConductivity, thawStrain=ice)
		layers[material.name] = layer | dict(polygon=outline, material=material)
	return layers


def scene(b, ground, profile, grains=None):
	h, height = ground.gridSpacing, ground.thickness
	mpm = MpmEngine(
		gridSpacing=h,
		lower=(0, 0),
		upper=(ground.length, height + 1.6),
		gravity=(gravity * math.sin(b), -gravity * math.cos(b)),
		damping=0.1,
		heat=HeatTransfer(thermalTimeScale=ground.timeScale, followsMotion=True, motionTolerance=ground.motionTolerance),
		freezing=FreezingCurve(width=0.3),
		water=PoreWater(conductivity=ground.conductivity, referencePorosity=ground.porosity, bulkModulus=5e6, impedance=ground.impedance),
		skeleton=skeletonOf(ground, grains),
		thawFront=ThawFront() if ground.frontVelocities == 2 else None,
		boundaries=[
			RollerBoundary(region="left"),
			RollerBoundary(region="right"),
			FixedBoundary(region="bottom"),
			DrainedBoundary(region="surface"),
			SurfaceTemperature(region="surface", times=[0, 0.5 * talik.day, talik.day], values=[-2, -2, ground.surfaceTemperature]),
		],
	)
	if not ground.segregation:
		mpm.material = GroundMaterial(name="silt", solidConductivity=solidConductivity, thawStrain=ground.thawStrain)
	layer = dict(
		polygon=[(0, 0), (ground.length, 0), *list(zip(*profile))[::-1]],
		porosity=ground.porosity,
		temperature=-2,
		pressure=lambda x, y: water * gravity * math.cos(b) * np.maximum(np.interp(x, *profile) - y, 0),
	)
	talik.layers.fill(mpm, layersOf(layer, ground, profile), pointsPerCell=round(ground.pointsPerCell), lateralRatio=None if grains else 0.5)
	if grains:
		talik.slope.settle(mpm, layer["polygon"], lateralRatio=0.5)
	return mpm


class Runs:
	"""Runs of a folder, each kept in a file as soon as it is done."""

	def __init__(self, folder, days, grains=None, fromColumn=False):
		self.folder, self.days, self.grains, self.fromColumn, self.running = writableFolder(folder), days, grains, fromColumn, {}

	def of(self, slope, ground, cycle=1):
		"""The thaw of a cycle; None after a mudflow."""
		ground = withIce(ground)
		if ground.segregation and not self.fromColumn:
			return self.withOwnIce(slope, ground, cycle)
		former = self.of(slope, ground, cycle - 1) if cycle > 1 else None
		if cycle > 1 and (not former or flows(former)):
			return None
		settings = dict(slope=slope, days=self.days, **asdict(ground)) | ({"cycle": cycle} if former else {}) | (asdict(self.grains) if self.grains else {})
		file = self.fileOf(settings)
		if file.exists():
			kept = json.loads(file.read_text())
			if "profile" in kept:
				return kept
		run = thaw(slope, ground, self.days, former and former["profile"], self.grains) | dict(settings=settings)
		writeWhole(file, json.dumps(run))
		return run

	def withOwnIce(self, slope, ground, cycle):
		if cycle > 1 and flows(self.withOwnIce(slope, ground, cycle - 1) or dict(path=[math.inf])):
			return None
		settings = dict(slope=slope, days=self.days, frost=frost, ownIce=True, cycle=cycle, **asdict(ground))
		file = self.fileOf(settings)
		if file.exists():
			return json.loads(file.read_text())
		key = slope, ground
		if key not in self.running:
			self.running = {key: OwnIce(slope, ground, self.days)}  # YADE has one scene
		while self.running[key].done < cycle:
			settings["cycle"] = self.running[key].done + 1
			run = self.running[key].next() | dict(settings=settings)
			writeWhole(self.fileOf(settings), json.dumps(run))
		return run

	def fileOf(self, settings):
		return self.folder / f"{hashlib.sha256(json.dumps(settings, sort_keys=True).encode()).hexdigest()[:16]}.json"


def flows(run):
	return run["path"][-1] >= flowing


def said(run):
	if flows(run):
		return f"mudflow on day {run['days'][-1]:.0f}"
	return f"{1e3 * run['path'][-1]:.0f}" + ("" if run["days"][-1] >= run["settings"]["days"] else f" on day {run['days'][-1]:.0f}, still moves")


def saidOfFrost(run):
	creep = run["heave"] * math.tan(math.radians(run["settings"]["slope"]))
	return (
		f"{run['settings']['slope']} deg, cycle {run['settings']['cycle']}: {1e3 * run['ice']:.1f} mm of excess ice, heave {1e3 * run['heave']:.1f} mm, "
		f"frost creep by hand {1e3 * creep:.1f} mm; path in the thaw {said(run)} mm, settled {1e3 * run['settlement'][-1]:.1f} mm"
	)


def named(attribute, value):
	return f"{attribute} {value:g} {units.get(attribute, '')}".strip()


def headOf(first, row):
	paths = ("mudflow" if path == math.inf else f"{1e3 * path:.0f}" for path in measured.values())
	return [f"| {first} | {' | '.join(f'{slope}°' for slope in measured)} |", "|---" * (1 + len(measured)) + "|", f"| **{row}** | {' | '.join(paths)} |"]


def tableOf(runs, base, attributes, law=None):
	"""Lines of the table: path of the surface [mm] at each slope, for the assumptions and with one of them changed; law: runs with it, beside samples."""
	lines = headOf("assumption", "measured")
	if law:
		lines.append(f"| the law | {' | '.join(said(law.of(slope, base)) for slope in measured)} |")
		print(lines[-1], flush=True)
	for attribute, value in [(None, None)] + [(attribute, value) for attribute in attributes for value in variations[attribute]]:
		ground = base if attribute is None else replace(base, **{attribute: value})
		cells = [said(runs.of(slope, ground)) for slope in measured]
		lines.append(f"| {('samples' if law else 'as assumed') if attribute is None else named(attribute, value)} | {' | '.join(cells)} |")
		print(lines[-1], flush=True)
	return lines


def cyclesOf(runs, base, cycles):
	"""Lines of the table: path of the surface [mm] in each cycle."""
	lines = headOf("", "measured, in a cycle")
	for cycle in range(1, cycles + 1):
		found = [runs.of(slope, base, cycle) for slope in measured]
		lines.append(f"| cycle {cycle} | {' | '.join(said(run) if run else '–' for run in found)} |")
		print(lines[-1], flush=True)
	return lines


def drawCycles(runs, base, cycles):
	"""Path of the surface in each cycle beside what was measured."""
	axes = (figure := plots.figure(7, 4.5)).subplots()
	for slope, colour, mark, beside in zip(measured, colours, "os^", (-0.1, 0, 0.1)):
		found = [run for cycle in range(1, cycles + 1) if (run := runs.of(slope, base, cycle))]
		paths = [1e3 * min(run["path"][-1], flowing) for run in found]
		axes.plot(beside + np.arange(1, len(found) + 1), paths, mark, color=colour, label=f"{slope}°" + (", flows" if flows(found[-1]) else ""))
		if measured[slope] < math.inf:
			axes.axhline(1e3 * measured[slope], color=colour, linestyle="--", linewidth=0.9, label=f"{slope}°, measured, mean of four cycles")
	axes.axhline(1e3 * flowing, color="0.5", linewidth=0.9, label="flows; measured at 24°" if 24 in measured else "flows")
	axes.set(xlabel="cycle of frost and thaw", ylabel="path of the surface in the cycle [mm]", yscale="log", ylim=(10, 2e3), xticks=range(1, cycles + 1))
	axes.legend(fontsize=8, loc="lower right")
	return figure


def draw(runs, base, law=None):
	"""Path of the surface over the days, and over the height at the end; dotted: the law beside samples."""
	figure = plots.figure(11, 4.5)
	history, profile = figure.subplots(1, 2)
	for slope, colour in zip(measured, colours):
		run = runs.of(slope, base)
		history.plot(run["days"], 1e3 * np.array(run["path"]), color=colour, label=f"{slope}°" + (", flows" if flows(run) else ""))
		profile.plot(1e3 * np.array(run["paths"]), run["heights"], "o-", markersize=3, color=colour, label=f"{slope}°")
		if law:
			beside = law.of(slope, base)
			history.plot(
				beside["days"], 1e3 * np.array(beside["path"]), color=colour, linestyle=":", label=f"{slope}°, law" + (", flows" if flows(beside) else "")
			)
			profile.plot(1e3 * np.array(beside["paths"]), beside["heights"], color=colour, linestyle=":")
		if measured[slope] < math.inf:
			history.axhline(1e3 * measured[slope], color=colour, linestyle="--", linewidth=0.9, label=f"{slope}°, measured, end of a cycle")
	history.set(xlabel="time [days]", ylabel="path of the surface [mm]", yscale="log", ylim=(1, 2e3), title="24° measured: a mudflow" if 24 in measured else "")
	history.legend(fontsize=8)
	profile.set(xlabel="path down the slope [mm]", ylabel="height over the base [m]", xscale="symlog", title="at the end, or as it flows")
	profile.legend(fontsize=8)
	return figure


def drawVariations(runs, base, attributes):
	"""Path of the surface with one assumption changed."""
	figure = plots.figure(11, 5)
	axes = figure.subplots()
	changed = [(attribute, value) for attribute in attributes for value in variations[attribute]]
	grounds = [base] + [replace(base, **{attribute: value}) for attribute, value in changed]
	for slope, colour, mark, beside in zip(measured, colours, "os^", (-0.2, 0, 0.2)):
		found = [runs.of(slope, ground) for ground in grounds]
		axes.plot(beside + np.arange(len(found)), [1e3 * min(run["path"][-1], flowing) for run in found], mark, color=colour, label=f"{slope}°")
		if measured[slope] < math.inf:
			axes.axhline(1e3 * measured[slope], color=colour, linestyle="--", linewidth=0.9, label=f"{slope}°, measured")
	axes.axhline(1e3 * flowing, color="0.5", linewidth=0.9, label="flows; measured at 24°" if 24 in measured else "flows")
	labels = ["as assumed"] + [named(*each) for each in changed]
	axes.set_xticks(range(len(labels)), labels, rotation=40, ha="right", fontsize=8)
	axes.set(yscale="log", ylabel="path of the surface [mm]", title="one assumption changed")
	axes.legend(fontsize=8, loc="lower left", bbox_to_anchor=(1.01, 0))
	return figure


def assumed(words):
	"""Name and value of ASSUMPTION=NUMBER."""
	name, _, value = words.partition("=")
	names = [field.name for field in fields(Assumptions)]
	if name not in names:
		raise SystemExit(f"--assume {words}: there is no assumption '{name}'; write ASSUMPTION=NUMBER with one of {', '.join(names)}")
	try:
		number = float(value)
	except ValueError:
		number = math.nan
	if not (0 < number < math.inf or (number == 0 and name in ("cohesion", "thawStrain", "impedance", "segregation"))):
		raise SystemExit(f"--assume {words}: '{value}' is not a positive number; write {name}=NUMBER, e.g. {name}={getattr(Assumptions, name):g}")
	if name == "frontVelocities" and number not in (1, 2):
		raise SystemExit(f"--assume {words}: the thaw front has one velocity or two; write {name}=1 or {name}=2")
	return name, number


parser = argparse.ArgumentParser(description=__doc__.splitlines()[0])
parser.add_argument("--preset", default="draft", choices=("test", "draft"), help="size of the job")
parser.add_argument(
	"--vary", nargs="*", default=(), choices=tuple(variations), metavar="ASSUMPTION", help=f"of {', '.join(variations)}: runs with other values"
)
parser.add_argument("--cycles", type=int, default=1, help="cycles of frost and thaw")
parser.add_argument("--slopes", nargs="+", type=int, default=tuple(measured), choices=tuple(measured), metavar="DEGREES", help="of 12, 18 and 24")
parser.add_argument("--assume", nargs="*", default=(), metavar="ASSUMPTION=NUMBER", help="in place of that of Assumptions, e.g. cohesion=1200")
parser.add_argument(
	"--ice",
	default="slope",
	choices=("slope", "column"),
	help="with --assume segregation=SP_0: it forms and melts in the slope itself, or it comes from a column that freezes",
)
parser.add_argument("--output", default="output/centrifuge_slopes", help="folder for the results")
parser.add_argument(
	"--skeleton", default="MohrCoulomb", choices=("MohrCoulomb", "samples"), help="samples: of discs behind every point, and the law beside them"
)
options = parser.parse_args()
folder = writableFolder(options.output)
measured = {slope: path for slope, path in measured.items() if slope in options.slopes}

base, days = {"test": (Assumptions(length=3.0), 4), "draft": (Assumptions(), 45)}[options.preset]
base = withIce(replace(base, **dict(map(assumed, options.assume))))
if not 0 < base.friction < 1:
	raise SystemExit(
		f"cohesion, safetyAt18, thickness, porosity and the excess pressure of {base.excess:.0f} Pa (thawStrain, surfaceTemperature, conductivity) give "
		f"tan(phi) = {base.friction:.2f}, which must lie between 0 and 1; change one by --assume"
	)
grains = Grains() if options.skeleton == "samples" else None
law = Runs(folder / "runs", days) if grains else None
ownIce = bool(base.segregation) and options.ice == "slope"
if ownIce and (grains or options.cycles > mostCycles):
	raise SystemExit(f"ice that forms in the slope itself needs the law and at most {mostCycles} cycles: leave --skeleton samples out, or give --ice column")
runs = Runs(folder / "runs", days, grains, options.ice == "column")
if grains:
	_, cohesion, friction = samplesOf(grains, base.cohesion)
	print(f"samples in simple shear: friction angle {friction:.1f} deg, cohesion {cohesion:.0f} Pa")
angles = " and ".join(str(slope) for slope in measured)
safety = ", ".join(f"{base.safety(slope, base.thickness / math.cos(math.radians(slope)), base.friction):.2f}" for slope in measured)
print(f"pressure at the thaw front {base.excess:.0f} Pa above that at rest; factor of safety at the base {safety} at {angles} deg; measured > 1, about 1, < 1")
if base.segregation:
	heave = base.thawStrain * base.thickness
	creep = ", ".join(f"{1e3 * heave * math.tan(math.radians(slope)):.0f} mm at {slope} deg" for slope in measured)
	rows = ", ".join(f"{ice:.3f}" for ice in rowsOf(base))
	print(f"excess ice of a column of this soil, from the base up, {rows}; {1e3 * heave:.0f} mm; frost creep by hand {creep}")
print(f"friction angle {math.degrees(math.atan(base.friction)):.1f} deg; path of the surface [mm]:")
if ownIce:
	for slope in measured:
		for cycle in range(1, options.cycles + 1):
			if run := runs.of(slope, base, cycle):
				print(saidOfFrost(run), flush=True)
lines = tableOf(runs, base, options.vary, law)
found = {slope: runs.of(slope, base) for slope in measured}
gentlest = found[min(found)]
settled, byHand = gentlest["settlement"][-1], base.thawStrain * gentlest["thawed"]
if ownIce:
	thawedRows = gentlest["rows"][len(gentlest["rows"]) - round(gentlest["thawed"] / base.gridSpacing) :]
	byHand = sum(base.gridSpacing * ice / (1 - ice) for ice in thawedRows)
print(f"at {min(found)} deg {gentlest['thawed']:.2f} m have thawed and settled by {1e3 * settled:.0f} mm, thaw strain times depth {1e3 * byHand:.0f} mm")
writeWhole(folder / "table.md", "\n".join(lines) + "\n")
plots.save(draw(runs, base, law), folder / "centrifuge_slopes.png", dpi=100)
if options.cycles > 1:
	writeWhole(folder / "cycles.md", "\n".join(cyclesOf(runs, base, options.cycles)) + "\n")
	plots.save(drawCycles(runs, base, options.cycles), folder / "centrifuge_slopes_cycles.png", dpi=100)
if options.vary:
	plots.save(drawVariations(runs, base, options.vary), folder / "centrifuge_slopes_varied.png", dpi=100)
output.writeSummary(
	folder / "summary.json",
	**{
		"path of the surface [m]": {f"{slope} deg": run["path"][-1] for slope, run in found.items()},
		"flows": {f"{slope} deg": flows(run) for slope, run in found.items()},
		"measured [m]": {f"{slope} deg": str(path) for slope, path in measured.items()},
		"settlement [m]": settled,
		"settlement by hand [m]": byHand,
	},
)
# a slope that flows is ranked by its day
ranks = [(flows(run), -run["days"][-1] if flows(run) else run["path"][-1]) for run in found.values()]
if ranks != sorted(ranks):
	output.unexpected("a steeper slope has moved less than a gentler one")
if not 0.6 * byHand < settled < 1.4 * byHand:
	output.unexpected(f"the slope of {min(found)} deg has not settled by 60 to 140 % of its excess ice")
print(f"table, picture and summary are in {folder}")
