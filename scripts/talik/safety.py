# SPDX-License-Identifier: GPL-2.0-or-later
"""Factor of safety of slopes: by reduced strength in the ground as it is, by circles after Bishop, by the infinite slope.

	found = talik.slope.factorOfSafety(mpm)                     # of a ground before its first step, or on any day of its thaw
	print(found)
	talik.plots.save(found.draw(), "mechanism.png")
	circle = talik.slope.bishop(outline, frictionAngle=20, cohesion=10e3, unitWeight=20e3)
	F = talik.slope.infiniteSlope(angle=20, depth=1, frictionAngle=30, excessPressure=4e3)

A factor of safety F is the number by which cohesion and tan(phi) may be divided until the slope fails.
"""

import copy
import math
from dataclasses import dataclass

import numpy as np

import talik
from yade import O, wrapper

strengths = ("cohesion", "cohesionFrozen", "tensileStrength", "tensileStrengthFrozen", "cohesions", "tensileStrengths")
moduli = ("young", "youngFrozen", "youngs")
mechanical = ("FixedBoundary", "RollerBoundary", "PeriodicBoundary", "SurfaceLoad")
notTaken = (
	"skeleton",
	"skeletons",
	"boundaries",
	"heat",
	"water",
	"segregation",
	"bodies",
	"watched",
	"stopAtDay",
	"poreFill",
	"energyLedger",
	"dead",
	"label",
)
wavesOfWindow = 7  # times that a wave sqrt(E/rho) of thawed ground takes from base to crest, in which motion is measured
windows = 20  # that a trial has to come to rest
quiet = 0.05  # motion in a window over the largest in the trial, at which ground has come to rest
softness = 100.0  # bulk modulus of water over the largest pressure, and modulus of the ground over that: pore pressure stays, whatever moves
still = 5e-3  # the same over rho g H^2/E, the settlement that such ground has by its weight


# ---- strength reduction ----------------------------------------------------------------------------------------------------


@dataclass(frozen=True)
class Trial:
	"""Ground with the strength divided by `factor`: whether it stands, and motion [m] (root mean square) in each window of time, largest displacement [m].

	>>> talik.safety.Trial(1.5, False, (1e-3, 2e-3), 0.1).stands
	False"""

	factor: float
	stands: bool
	motion: tuple
	displacement: float


@dataclass(frozen=True)
class Safety:
	"""Factor of safety of a ground, between that of the last trial that stood and of the first that failed; see talik.slope.factorOfSafety.

	frame   fields of the first trial that failed, at its end: displacement and strain since its strength was reduced. Of the last trial where none failed

	>>> talik.safety.Safety((talik.safety.Trial(1.3, True, (), 0.01), talik.safety.Trial(1.5, False, (), 0.2)), None).factor
	1.4"""

	trials: tuple
	frame: dict

	@property
	def bracket(self):
		"""(largest factor at which the ground stood, smallest at which it failed: infinite where it stood in every trial)."""
		return max(t.factor for t in self.trials if t.stands), min((t.factor for t in self.trials if not t.stands), default=math.inf)

	@property
	def factor(self):
		"""Middle of the bracket. Where the ground stood in every trial, the largest factor that was tried: that of safety lies above it."""
		stood, failed = self.bracket
		return 0.5 * (stood + failed) if failed < math.inf else stood

	def __str__(self):
		stood, failed = self.bracket
		if failed == math.inf:
			return f"factor of safety above {stood:.2f}: the ground stands in every trial, so that its factor is larger, or nothing can slide"
		return f"factor of safety {self.factor:.2f}: the ground stands with its strength over {stood:.3f} and fails with {failed:.3f}"

	def _repr_png_(self):
		return self.draw()._repr_png_()

	def draw(self, circle=None):
		"""Figure: shear strain and direction of motion in the trial that failed, and displacement over the factor. circle: of bishop, for comparison."""
		from talik import plots

		fig = plots.figure(11, 3.8)
		mechanism, curve = fig.subplots(1, 2, width_ratios=(2, 1))
		plots.ground(mechanism, self.frame, "deviatoricStrain", arrows="displacement", start=False)
		if circle is not None:
			mechanism.plot(*circle.arc().T, color="black", linestyle="--", linewidth=1, label=f"Bishop, F = {circle.factor:.2f}")
		plots.legendOfLines(mechanism)
		stood, failed = self.bracket
		mechanism.set_title(f"mechanism at F = {failed:.3f}" if failed < math.inf else f"strain at F = {stood:.3f}, where it stands")
		for stands, colour, label in ((True, "seagreen", "stands"), (False, "crimson", "fails")):
			ones = sorted((t.factor, t.displacement) for t in self.trials if t.stands == stands)
			if ones:
				curve.semilogy(*np.transpose(ones), "o-", color=colour, label=label)
		curve.axvline(self.factor, color="0.4", linewidth=0.8)
		title = f"factor of safety {'above ' if failed == math.inf else ''}{self.factor:.2f}"
		curve.set(xlabel="F, by which the strength is divided", ylabel="largest displacement [m]", title=title)
		curve.legend(frameon=False)
		return fig


def factorOfSafety(mpm, accuracy=0.01, skeleton=None, between=(0.25, 4.0), told=None):
	"""Factor of safety of a ground in its present state, by strength reduction: Safety. The ground and the scene in O stay as they are.

	mpm       a ground with gravity, before its first step or at any time of a run
	accuracy  of the factor, relative, 0.001 to 0.2
	skeleton  MohrCoulombSkeleton in place of laws with samples, which have no strength that could be divided; talik.studies.calibrate fits one
	between   factors among which it is sought. Ground that stands with its strength over the larger one has a factor above it: give a larger one to know more
	told      is given a line for each trial, such as print

	In each trial ground in the same state, at rest, is given its cohesion, tensile strength and tan(phi) divided by a factor, frozen and thawed, and no
	dilation. It stands if it comes to rest: if its motion (root mean square, in the time that 7 waves take from base to crest) falls to 0.5 % of
	rho g H^2/E, or to a twentieth of the largest. It fails if it does not within 140 waves, or moves by half a cell. Temperature, ice and pore
	pressure stay as they are meanwhile: pressure that shear would make or spend is left out. Ice is that of the temperature. Laws without strength
	(ElasticSkeleton) stay. Moduli do not matter, and are raised where they are low beside weight and pore pressure. A SurfaceLoad stays; ground that
	touches bodies or has a MovingBoundary is refused.

	A long layer that shears without dilation yields at sigma' sin(phi) + c cos(phi) (Davis 1968), so that its factor is up to 13 % lower than that of
	infiniteSlope with phi = 30 degrees. Needs ten cells over the height of what slides: the slope of Griffiths and Lane (1999, example 1, F = 1.4) has 1.41
	with ten and 1.39 with twenty, that of ACADS 1(a) (F = 1.00) 1.03 and 1.01.

	>>> law = MohrCoulombSkeleton(young=1e8, cohesion=10e3, frictionAngle=20)
	>>> bank = MpmEngine(gridSpacing=1, lower=(0, 0), upper=(16, 8), gravity=(0, -9.81), skeleton=law)
	>>> bank.boundaries = [RollerBoundary(region="left"), FixedBoundary(region="bottom")]
	>>> layers = talik.layers.fill(bank, {"clay": dict(polygon=[(0, 0), (14, 0), (6, 6), (0, 6)])}, lateralRatio=0.5)
	>>> print(talik.slope.factorOfSafety(bank, accuracy=0.1))
	factor of safety 1.61: the ground stands with its strength over 1.542 and fails with 1.682"""
	if mpm.axisymmetric:
		raise ValueError("factorOfSafety: the ground is axisymmetric, and slopes are in plane strain or in space; leave axisymmetric out")
	if not 0.001 <= accuracy <= 0.2:
		raise ValueError(f"factorOfSafety: accuracy is {accuracy!r}; give a part of the factor, 0.001 to 0.2")
	if np.shape(between) != (2,) or not 0 < between[0] < between[1]:
		raise ValueError(f"factorOfSafety: between is {between!r}; give two factors above 0, the smaller one first")
	(lowest, highest), laws = between, _reducible(mpm, skeleton)
	trials, frames = [], {}
	with talik.scratchScene():
		rested = _ground(mpm, laws, lowest)
		if not _run(rested, lowest).stands:
			raise RuntimeError(_failsAnyway(lowest))

		def stands(factor):
			ground = _ground(rested, laws, factor)
			trial = _run(ground, factor)
			trials.append(trial)
			if not trial.stands or factor == highest:
				frames[factor] = {name: np.array(ground.field(name)) for name in ground.fieldNames()}
			if told is not None:
				told(f"F = {factor:.3f}: {'stands' if trial.stands else 'fails'}, displacement {1e3 * trial.displacement:.1f} mm")
			return trial.stands

		low, high = _bracketed(stands, lowest, highest)
		while high > low * (1 + accuracy):
			middle = math.sqrt(low * high)
			low, high = (middle, high) if stands(middle) else (low, middle)
	return Safety(tuple(sorted(trials, key=lambda trial: trial.factor)), frames[high])


def _bracketed(stands, lowest, highest):
	"""Two factors around that of safety, by steps that double from 1; twice the highest where the ground stands with it."""
	factor = min(max(1.0, lowest), highest)
	if stands(factor):
		while factor < highest:
			before, factor = factor, min(2 * factor, highest)
			if not stands(factor):
				return before, factor
		return highest, highest
	while factor > lowest:
		before, factor = factor, max(0.5 * factor, lowest)
		if stands(factor):
			return factor, before
	raise RuntimeError(_failsAnyway(lowest))


def _failsAnyway(lowest):
	return (
		f"factorOfSafety: the ground fails with {1 / lowest:g} times its strength; is it held by boundaries, and does its effective stress leave friction "
		"beside its pore pressure? Otherwise give a smaller first number of between"
	)


def _reducible(mpm, skeleton):
	"""The laws of a ground, those with samples replaced."""
	if mpm.pointCount == 0 or not mpm.motion or not tuple(mpm.gravity)[-1] < 0:
		raise ValueError("factorOfSafety: the ground has no points, no motion or no gravity downwards; fill it, and give gravity=(0, -9.81)")
	if mpm.bodies is not None or any(type(one).__name__ == "MovingBoundary" for one in mpm.boundaries):
		raise ValueError(
			"factorOfSafety: the ground has bodies or a MovingBoundary, which the trials do not know; give the ground without them, held by its sides"
		)
	laws = list(mpm.skeletons) or [mpm.skeleton]
	known = (wrapper.MohrCoulombSkeleton, wrapper.ElasticSkeleton)
	found = [law if isinstance(law, known) else skeleton for law in laws]
	if None in found:
		name = type(laws[found.index(None)]).__name__
		raise ValueError(f"factorOfSafety: {name} has no cohesion and friction to divide; give skeleton=MohrCoulombSkeleton(…), which stands in for it")
	if not any(isinstance(law, wrapper.MohrCoulombSkeleton) for law in found):
		raise ValueError("factorOfSafety: no law of the ground has a strength to divide; give it a MohrCoulombSkeleton")
	return found


def _ground(state, laws, factor):
	"""A ground in the state of another, at rest, with its strength divided by a factor, where heat and water stand still."""
	ground = wrapper.MpmEngine()
	for name, value in state.dict().items():
		if name not in notTaken:
			setattr(ground, name, value)
	ground.boundaries = [one for one in state.boundaries if type(one).__name__ in mechanical or getattr(one, "gives", "") in ("traction", "acceleration")]
	ground.damping, ground.picTime = 0.7, 0
	fields = {name: state.field(name) for name in ("position", "volume", "stress")}
	if state.heat is not None or state.water is not None:
		fields["porosity"] = state.field("porosity")
	if state.heat is not None:
		ground.heat = copy.deepcopy(state.heat)
		ground.heat.thermalTimeScale, ground.heat.movingTimeScale, ground.heat.followsMotion = 1, 1, False
		fields["temperature"] = state.field("temperature")
	least = softness * _weight(state) * _height(state) ** 2 / state.gridSpacing  # by its weight alone ground moves by a hundredth of a cell
	if state.water is not None:
		fields["pressure"] = state.field("pressure")
		bulk = softness * max(1.0, float(fields["pressure"].max()))
		least = max(least, softness * bulk)
		ground.water = copy.deepcopy(state.water)
		ground.water.pressure, ground.water.massCoefficient, ground.water.bulkModulus, ground.water.iceBulkModulus = "explicit", "printed", bulk, bulk
		ground.water.hydraulicTimeScale = 1e-11
		fields["poreFill"] = np.clip(state.field("waterMass") / _full(state, fields), 0.01, 1)
	elif state.heat is not None:
		fields["poreFill"] = np.clip((state.field("mass") - state.field("solidMass")) / _full(state, fields), 0, 1)
	else:
		fields["porosity"] = 1 - state.field("mass") / (fields["volume"] * _solidDensity(state))
		fields["poreFill"] = 0.0
	stiffer = max(1.0, least / min(law.young for law in laws))
	ground.skeletons = [_over(law, factor, stiffer) for law in laws]
	ground.addPoints(skeleton=state.skeletonOf, material=state.materialOf, **fields)
	ground.initialise()
	ground.setDay(state.calendar["day"])
	return ground


def _weight(state):
	"""Mean unit weight [N/m3]."""
	return -tuple(state.gravity)[-1] * float(state.field("mass").sum() / state.field("volume").sum())


def _height(state):
	return float(np.ptp(state.field("position")[:, -1])) + state.gridSpacing


def _solidDensity(state):
	soils = list(state.materials) or [state.material]
	return np.array([soil.solidDensity for soil in soils])[state.materialOf]


def _full(state, fields):
	"""Water and ice of each point if it were full [kg]."""
	soil = state.materials[0] if state.materials else state.material
	ice = state.field("iceSaturation") if state.freezing is not None else 0.0
	return fields["porosity"] * fields["volume"] * ((1 - ice) * soil.liquidDensity + ice * soil.iceDensity)


def _over(law, factor, stiffer):
	"""A law with its strength divided, and its moduli multiplied."""
	weaker = copy.deepcopy(law)
	for name in moduli:
		if hasattr(law, name):
			value = getattr(law, name)
			setattr(weaker, name, [each * stiffer for each in value] if np.ndim(value) else value * stiffer)
	if isinstance(law, wrapper.MohrCoulombSkeleton):
		for name in strengths:
			value = getattr(law, name)
			setattr(weaker, name, [each / factor for each in value] if np.ndim(value) else value / factor)
		weaker.frictionAngle = math.degrees(math.atan(math.tan(math.radians(law.frictionAngle)) / factor))
		weaker.dilationAngle = 0
	return weaker


def _run(ground, factor):
	"""Lets a ground move until it rests or has failed."""
	O.engines = [ground]
	volume, h = ground.field("volume"), ground.gridSpacing
	settled = _weight(ground) * _height(ground) ** 2 / min(law.young for law in ground.skeletons if isinstance(law, wrapper.MohrCoulombSkeleton))
	steps = math.ceil(wavesOfWindow * math.sqrt(settled / -tuple(ground.gravity)[-1]) / ground.stableTimeStep())  # a wave takes H sqrt(rho/E)
	floor = still * settled
	motion, before = [], ground.field("displacement")
	for _ in range(windows):
		talik.runSerially(steps)
		now = ground.field("displacement")
		motion.append(math.sqrt(float(volume @ ((now - before) ** 2).sum(axis=1)) / volume.sum()))
		before, largest = now, float(np.linalg.norm(now, axis=1).max())
		if motion[-1] < max(floor, quiet * max(motion)):
			return Trial(factor, True, tuple(motion), largest)
		if largest > 0.5 * h:
			break
	return Trial(factor, False, tuple(motion), largest)


# ---- limit equilibrium -----------------------------------------------------------------------------------------------------


@dataclass(frozen=True)
class Circle:
	"""The circle with the smallest factor of safety, see talik.slope.bishop.

	centre (x, y), radius [m]; first, last: x where it meets the surface [m]

	>>> talik.safety.Circle(1.2, (0.0, 1.0), 1.0, -0.5, 0.5).arc(3)[1].tolist()
	[0.0, 0.0]"""

	factor: float
	centre: tuple
	radius: float
	first: float
	last: float

	def __str__(self):
		x, y = self.centre
		return f"factor of safety {self.factor:.2f} on the circle around ({x:.2f}, {y:.2f}) m with a radius of {self.radius:.2f} m"

	def arc(self, count=100):
		"""Places (count, 2) on it [m]."""
		x = np.linspace(self.first, self.last, count)
		return np.column_stack([x, self.centre[1] - np.sqrt(self.radius**2 - (x - self.centre[0]) ** 2)])


def bishop(outline, frictionAngle, cohesion, unitWeight, ru=0.0, pressure=None, deepest=None):
	"""Smallest factor of safety of an outline against sliding on circles, by Bishop's simplified method: Circle.

	outline        corners (m, 2) [m] of the ground
	frictionAngle  effective [degrees], a number or a function f(x, y) of arrays, for layers
	cohesion       effective [Pa], a number or such a function
	unitWeight     of the ground, water included [N/m3]
	ru             pore pressure over the weight of the ground above [-]
	pressure       pore pressure as a function f(x, y) [Pa], in place of ru
	deepest        height of what no circle cuts [m], such as a frozen base; a number or a function f(x). Default: the base of the outline

	F = sum [(c b + (W - u b) tan phi)/m]/sum W sin a, m = cos a + sin a tan phi/F, of vertical slices (Bishop 1955). Of 7000 circles the five weakest are
	improved.

	>>> circle = talik.slope.bishop([(0, 0), (32, 0), (12, 10), (0, 10)], frictionAngle=20, cohesion=10e3, unitWeight=20e3)
	>>> round(circle.factor, 2)
	1.38"""
	from scipy.optimize import minimize

	x, y = _surface(outline)
	bottom = min(corner[1] for corner in outline) if deepest is None else deepest
	soil = _Soil(x, y, *map(_function, (frictionAngle, cohesion)), unitWeight, ru, pressure, _function(bottom))
	ends = np.linspace(x[0], x[-1], 30)
	start = np.array([(a, b, s) for k, a in enumerate(ends) for b in ends[k + 1 :] for s in np.linspace(0.02, 0.5, 16)])
	factors = soil.factors(start)
	if not np.isfinite(factors).any():
		raise ValueError("bishop: no circle cuts the outline so that ground slides; look at its corners, and at deepest")
	spread = np.diag([0.5 * (ends[1] - ends[0])] * 2 + [0.015])
	better = [
		minimize(lambda v: min(1e6, soil.factors(v[None])[0]), c, method="Nelder-Mead", options={"xatol": 1e-4, "initial_simplex": np.vstack([c, c + spread])})
		for c in start[np.argsort(factors)[:5]]
	]
	best = min(better, key=lambda found: found.fun)
	xc, yc, radius = (float(part[0]) for part in soil.circles(best.x[None]))
	return Circle(float(best.fun), (xc, yc), radius, float(best.x[0]), float(best.x[1]))


def _function(value):
	return value if callable(value) else lambda *place: np.full(np.shape(place[0]), float(value))


def _surface(outline):
	"""x, y of the upper side of an outline."""
	from talik.geometry import surfaceHeight

	corners = np.asarray(outline, dtype=float)
	left, right = corners[:, 0].min(), corners[:, 0].max()
	x = np.unique(np.concatenate([np.linspace(left, right, 401), corners[:, 0]]))
	inside = np.clip(x, left + 1e-9 * (right - left), right - 1e-9 * (right - left))
	return x, np.array([surfaceHeight(outline, one) for one in inside])


@dataclass(frozen=True)
class _Soil:
	"""What circles are cut through: surface x, y, strength, weight, water."""

	x: np.ndarray
	y: np.ndarray
	frictionAngle: object
	cohesion: object
	unitWeight: float
	ru: float
	pressure: object
	deepest: object

	def circles(self, cuts):
		"""Centre x, y and radius (n,) of cuts (n, 3): x at both ends, and the depth of the arc below its chord over the chord."""
		first, last, depth = cuts.T
		left, right = np.interp(first, self.x, self.y), np.interp(last, self.x, self.y)
		chord = np.hypot(last - first, right - left)
		radius = chord * (0.25 + depth**2) / (2 * depth)
		above = (radius - depth * chord) / chord
		return 0.5 * (first + last) - (right - left) * above, 0.5 * (left + right) + (last - first) * above, radius

	def factors(self, cuts, slices=50):
		"""Factors of safety (n,) of cuts, infinite where there is no such circle in the ground."""
		first, last = cuts[:, 0, None], cuts[:, 1, None]
		with np.errstate(all="ignore"):
			xc, yc, radius = (part[:, None] for part in self.circles(cuts))
			width = (last - first) / slices
			x = first + width * (np.arange(slices) + 0.5)
			sine = (x - xc) / radius
			cosine = np.sqrt(1 - sine**2)
			base = yc - radius * cosine
			height = np.interp(x, self.x, self.y) - base
			weight = self.unitWeight * width * height
			driving = (weight * sine).sum(axis=1)
			sine, driving = sine * np.sign(driving)[:, None], abs(driving)
			water = self.ru * self.unitWeight * height if self.pressure is None else self.pressure(x, base)
			friction = np.tan(np.radians(self.frictionAngle(x, base)))
			resisting = self.cohesion(x, base) * width + np.maximum(0.0, weight - water * width) * friction
			factor = np.ones(len(cuts))
			for _ in range(20):
				turned = cosine + sine * friction / factor[:, None]
				factor = (resisting / turned).sum(axis=1) / driving
			inGround = (first < last) & (first >= self.x[0]) & (last <= self.x[-1]) & (height >= -1e-9 * radius) & (base >= self.deepest(x) - 1e-9 * radius)
			sensible = (turned.min(axis=1) > 0.2) & (driving > 1e-6 * weight.sum(axis=1)) & (cuts[:, 2] > 0)
			ends = np.maximum(*(np.interp(cuts[:, k], self.x, self.y) for k in (0, 1))) <= yc[:, 0]  # the arc is the lower one
			return np.where(inGround.all(axis=1) & sensible & ends, factor, np.inf)


def excessPressure(depth, consolidationRatio, buoyantWeight=9e3):
	"""Excess pore pressure at the front of ground that thaws and consolidates under its own weight [Pa] (McRoberts and Morgenstern 1974).

	depth               of thaw [m]
	consolidationRatio  R = alpha/(2 sqrt(c_v)) [-], above 0, of a front at the depth alpha sqrt(t)
	buoyantWeight       of the thawed ground [N/m3]

	u = gamma' depth/(1 + 1/(2 R^2)); in an infinite slope times cos^2 of its angle (infiniteSlope does that).

	>>> round(talik.safety.excessPressure(depth=1, consolidationRatio=0.5))
	3000"""
	if not (consolidationRatio > 0 and depth > 0):
		raise ValueError(f"excessPressure: depth is {depth!r} and consolidationRatio is {consolidationRatio!r}; give both above 0")
	return buoyantWeight * depth / (1 + 1 / (2 * consolidationRatio**2))


def infiniteSlope(angle, depth, frictionAngle, cohesion=0.0, unitWeight=19e3, waterDepth=math.inf, waterWeight=9810.0, ru=0.0, excessPressure=0.0):
	"""Factor of safety of an infinite slope against sliding along a plane parallel to its surface [-], for comparison with a run.

	angle           of the slope [degrees], above 0, below 90
	depth           of the sliding plane below the surface, vertical [m], above 0: the thaw depth, where thawed ground slides on frozen ground
	frictionAngle   effective, of what slides [degrees], 0 to below 90
	cohesion        effective [Pa], 0 or more
	unitWeight      of the ground, water included [N/m3]
	waterDepth      vertical depth of the water table [m], 0 (at the surface) or more; water below it seeps parallel to the slope
	waterWeight     of water [N/m3]
	ru              further pore pressure over the weight of the ground above, gamma z [-], 0 or more
	excessPressure  of thawing level ground at this depth [Pa], 0 or more, see talik.safety.excessPressure

	F = [c + (gamma z cos^2 beta - u) tan phi]/(gamma z sin beta cos beta), u = [gamma_w (z - z_w) + u_e] cos^2 beta + r_u gamma z, the first part below the
	water table (Skempton and DeLory 1957; McRoberts and Morgenstern 1974). Where u exceeds the normal stress, friction counts nothing.

	>>> round(talik.slope.infiniteSlope(angle=20, depth=1, frictionAngle=30), 3)
	1.586
	>>> round(talik.slope.infiniteSlope(angle=20, depth=1, frictionAngle=30, waterDepth=0), 3)
	0.767
	>>> round(talik.slope.infiniteSlope(angle=20, depth=1, frictionAngle=30, waterDepth=0, excessPressure=3e3), 3)
	0.517"""
	for name, value, valid, remedy in (
		("angle", angle, 0 < angle < 90, "degrees above 0 and below 90"),
		("depth", depth, depth > 0, "a depth in m above 0"),
		("frictionAngle", frictionAngle, 0 <= frictionAngle < 90, "degrees from 0 to below 90"),
		("cohesion", cohesion, cohesion >= 0, "a stress in Pa, 0 or more"),
		("unitWeight", unitWeight, unitWeight > 0, "a weight in N/m3 above 0"),
		("waterDepth", waterDepth, waterDepth >= 0, "a depth in m, 0 or more"),
		("ru", ru, ru >= 0, "a ratio, 0 or more"),
		("excessPressure", excessPressure, excessPressure >= 0, "a pressure in Pa, 0 or more"),
	):
		if not valid:
			raise ValueError(f"infiniteSlope: {name} is {value!r}; give {remedy}")
	slope, friction = math.radians(angle), math.radians(frictionAngle)
	weight, along = unitWeight * depth, math.cos(slope) ** 2
	pressure = (waterWeight * max(0.0, depth - waterDepth) + excessPressure) * along + ru * weight
	return (cohesion + max(0.0, weight * along - pressure) * math.tan(friction)) / (weight * math.sin(slope) * math.cos(slope))
