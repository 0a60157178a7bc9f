# SPDX-License-Identifier: GPL-2.0-or-later
"""Element tests of soil laboratories on samples without ice, of discs or spheres, and predictions of tests in a CSV file.

	sample = talik.rve.pack(talik.rve.prepare(grains=300, dimension=3, porosity=0.45, etaRoll=0.2))
	test = talik.studies.elementtests.triaxial(sample, pressure=100e3)     # drained, lateral stress constant
	print(test.numbers())
	scripts/calibrate --elements tests.csv --fit A,B                       # fitted on tests A and B, predicts the others: table, picture

The tests: `triaxial` (lateral stress constant), `undrained` (void ratio constant), `oedometer` (no lateral strain), `isotropic` and `simpleShear`
(normal stress or void ratio constant). Of discs they are in plane strain, and void ratios are those of areas. Compression and shortening are positive
here, as in a laboratory.

A prediction takes samples of many void ratios, each compacted with a friction of its own, and interpolates between the two nearest in void ratio. Fitted are
contact friction, rolling friction, and what the void ratio of the samples is below that of the sand: spheres pack denser than angular grains.
"""

import dataclasses
import math

import numpy as np
import talik
from talik import packing, plots, tables
from talik.studies import calibrate, target
from yade import Matrix3

perCall = 1e-4  # strain of a call: a quarter of it changes the peak angle of 300 spheres by less than chance does
inertialNumber = 2e-3  # largest in a test
averaged = 21  # calls over which a record is smoothed
endPart = 0.05  # of the record over which its end is averaged


@dataclasses.dataclass(frozen=True)
class Curve:
	"""Record of an element test, arrays over its calls; compression and shortening positive.

	>>> curve = talik.studies.elementtests.triaxial(packed, pressure=50e3, strain=5e-3)
	>>> bool(curve.q[-1] > 0)
	True"""

	strain: np.ndarray  # axial, in simple shear the shear strain [-]
	volume: np.ndarray  # volumetric strain [-]
	voidRatio: np.ndarray  # [-]
	axial: np.ndarray  # stress [Pa]; in simple shear across the planes that slide
	lateral: np.ndarray  # mean of the other normal stresses [Pa]
	shear: np.ndarray  # shear stress [Pa], in simple shear along the planes that slide
	dimension: int
	isShear: bool = False  # simple shear

	@property
	def q(self):
		return self.axial - self.lateral

	@property
	def p(self):
		"""Mean stress [Pa], of discs that in the plane."""
		return (self.axial + (self.dimension - 1) * self.lateral) / self.dimension

	@property
	def mobilised(self):
		"""Mobilised friction angle [degrees] in compression, smoothed; in simple shear that of shear over normal stress."""
		top, below = (self.shear, self.axial) if self.isShear else (self.q, self.axial + self.lateral)
		ratio = np.clip(_smooth(top) / np.maximum(_smooth(below), 1e-9), -0.99, 0.99)
		return np.degrees(np.arctan(ratio) if self.isShear else np.arcsin(ratio))

	def numbers(self):
		"""{name: number} of the peak and the end: phiPeak, phiEnd [degrees], strainAtPeak [-], dilation (largest increase of volume over shortening within 1 % [-]),
		volumeEnd [-], e0, eEnd [-], E50 (secant at half of the largest deviator or shear stress [Pa])."""
		angle, strain, volume = self.mobilised, _smooth(self.strain), _smooth(self.volume)
		load = _smooth(self.shear if self.isShear else self.q)
		end, peak = max(1, round(endPart * len(angle))), int(angle.argmax())
		half = max(1, int(np.argmax(load - load[0] > 0.5 * (load.max() - load[0]))))
		over = min(len(strain) - 1, round(0.01 / perCall))
		rate = (volume[: len(volume) - over] - volume[over:]) / (strain[over:] - strain[: len(strain) - over]) if over else np.zeros(1)
		return dict(
			phiPeak=float(angle[peak]),
			strainAtPeak=float(strain[peak]),
			phiEnd=float(angle[-end:].mean()),
			dilation=float(rate.max(initial=0.0)),
			volumeEnd=float(volume[-end:].mean()),
			e0=float(self.voidRatio[0]),
			eEnd=float(self.voidRatio[-end:].mean()),
			E50=float((load[half] - load[0]) / (strain[half] - strain[0])),
		)


def _smooth(values):
	width = min(averaged, len(values))
	return np.convolve(values, np.ones(width) / width, "valid")


def triaxial(sample, pressure, strain=0.25):
	"""Drained compression from an isotropic `pressure` [Pa] at constant lateral stress: Curve. Of discs the biaxial test.

	>>> curve = talik.studies.elementtests.triaxial(packed, pressure=50e3, strain=5e-3)"""
	tested = _at(sample, pressure)
	controls = [_control(tested, pressure) for _ in range(tested.dimension - 1)]
	return _run(tested, strain, lambda stress: _axial(tested.dimension, [c.strain(s) for c, s in zip(controls, _laterals(stress, tested.dimension))]))


def undrained(sample, pressure, strain=0.1):
	"""Compression from an isotropic `pressure` [Pa] at constant void ratio: the effective stresses of a saturated sample that cannot drain: Curve.

	>>> curve = talik.studies.elementtests.undrained(packed, pressure=50e3, strain=5e-3)
	>>> bool(abs(curve.volume[-1]) < 1e-9)
	True"""
	tested = _at(sample, pressure)
	aside = (1 - perCall) ** (-1 / (tested.dimension - 1)) - 1
	return _run(tested, strain, lambda stress: _axial(tested.dimension, [aside] * (tested.dimension - 1)))


def oedometer(sample, start, end):
	"""Compression without lateral strain from an isotropic stress `start` to an axial stress `end` [Pa]: Curve.

	>>> curve = talik.studies.elementtests.oedometer(packed, start=50e3, end=60e3)"""
	tested = _at(sample, start)
	return _run(tested, 0.3, lambda stress: _axial(tested.dimension, [0.0] * (tested.dimension - 1)), lambda stress: -stress[1] >= end, 0.2)


def isotropic(sample, start, end):
	"""Equal strain in all directions from an isotropic stress `start` to a mean stress `end` [Pa]: Curve.

	>>> curve = talik.studies.elementtests.isotropic(packed, start=50e3, end=60e3)"""
	tested = _at(sample, start)
	d = tested.dimension
	return _run(tested, 0.3, lambda stress: _axial(d, [-perCall] * (d - 1)), lambda stress: -sum(stress[:d]) / d >= end, 0.2)


def simpleShear(sample, pressure, strain=0.5, drained=True):
	"""Simple shear from an isotropic `pressure` [Pa] at constant normal stress, or with drained=False at constant void ratio: Curve.

	>>> curve = talik.studies.elementtests.simpleShear(packed, pressure=50e3, strain=5e-3)
	>>> bool(curve.shear[-1] > 0)
	True"""
	tested = _at(sample, pressure)
	control = _control(tested, pressure)
	return _run(tested, strain, lambda stress: Matrix3(0, perCall, 0, 0, control.strain(stress[1]) if drained else 0.0, 0, 0, 0, 0))


def compressionIndex(curve, start, end):
	"""Fall of the void ratio over a decade of axial stress between two stresses [Pa].

	>>> curve = talik.studies.elementtests.oedometer(packed, start=50e3, end=60e3)
	>>> bool(talik.studies.elementtests.compressionIndex(curve, 51e3, 59e3) > 0)
	True"""
	stress = np.maximum.accumulate(curve.axial)
	first, last = np.interp([start, end], stress, curve.voidRatio)
	return float((first - last) / math.log10(end / start))


def _at(sample, pressure):
	if sample.iceSaturation > 0:
		raise ValueError(f"elementtests: the sample holds ice (iceSaturation {sample.iceSaturation:g}); give one without")
	if not 0 < pressure < math.inf:
		raise ValueError(f"elementtests: pressure is {pressure!r}; give a pressure above 0 in Pa")
	tested = sample.copy()
	tested.maxInertialNumber, tested.minSteps = inertialNumber, 10
	if not tested.servo(*[-pressure] * tested.dimension):
		raise RuntimeError(f"elementtests: the sample does not reach an isotropic pressure of {pressure:g} Pa")
	return tested


def _control(tested, pressure):
	with talik.inspect(tested.open()):
		stiffness = packing.contactStiffness()
	return calibrate.NormalStressControl(pressure, perCall, stiffness)


def _laterals(stress, dimension):
	"""Stresses along x, of spheres and z."""
	return (stress[0],) if dimension == 2 else (stress[0], stress[2])


def _axial(dimension, aside):
	"""Shortening along y; strains along x, of spheres and z."""
	return Matrix3(aside[0], 0, 0, 0, -perCall, 0, 0, 0, aside[1] if dimension == 3 else 0.0)


def _run(tested, strain, step, over=lambda stress: False, part=1.0):
	"""Record of calls with the displacement gradients of `step`, each times `part`, until a strain or a stress."""
	d = tested.dimension
	ratio = tested.statistics()["porosity"]
	ratio /= 1 - ratio
	grown, stress, rows, length = 1.0, tested.stress, [], 1.0
	shear = 0.0
	for _ in range(max(averaged, math.ceil(strain / (part * perCall)))):
		rows.append((1 - length + shear, 1 - grown, (1 + ratio) * grown - 1, -stress[1], -np.mean(_laterals(stress, d)), stress[2 if d == 2 else 5]))
		if over(stress):
			break
		gradient = step(stress)
		if part != 1.0:
			gradient = Matrix3(*(part * gradient[i, j] for i in range(3) for j in range(3)))
		result = tested.apply(gradient, 0.0)
		if result["blewUp"]:
			raise RuntimeError(f"elementtests: the sample blew up at a strain of {1 - length + shear:g}: {result['reason']}")
		stress = result["stress"]
		grown *= (1 + gradient[0, 0]) * (1 + gradient[1, 1]) * (1 + gradient[2, 2])
		shear += gradient[0, 1]
		length *= 1 + gradient[1, 1] if not gradient[0, 1] else 1.0
	return Curve(*np.array(rows).T, d, shear != 0)


# ---- tests in a CSV file --------------------------------------------------------------------------------------------------

percent = 0.01
ofTest = ("test", "e0", "p0_kPa")  # columns that every row must fill
ofResult = ("eta_peak", "eta_end", "epsv_end_pct", "eps1_peak_pct", "eps1_end_pct")  # of triaxial tests; empty: to be predicted
usualEnd = 0.25  # axial strain of a test whose end the file does not give [-]


@dataclasses.dataclass(frozen=True)
class Test:
	"""One drained triaxial test of sand, in SI units, compression positive; NaN: not measured.

	>>> talik.studies.elementtests.Test("A", 0.8, 100e3, end=0.25).measured
	{}"""

	name: str
	voidRatio: float  # at its isotropic pressure
	pressure: float  # [Pa]
	end: float  # axial strain [-]
	phiPeak: float = math.nan  # [degrees]
	phiEnd: float = math.nan
	volumeEnd: float = math.nan  # [-]
	strainAtPeak: float = math.nan

	@property
	def measured(self):
		"""{name: value} of what was."""
		values = {name: getattr(self, name) for name in ("phiPeak", "phiEnd", "volumeEnd", "strainAtPeak")}
		return {name: value for name, value in values.items() if not math.isnan(value)}


def angleOf(ratio):
	"""Friction angle [degrees] of q/p in triaxial compression, sin(phi) = 3 eta/(6 + eta).

	>>> round(talik.studies.elementtests.angleOf(1.2), 1)
	30.0"""
	return math.degrees(math.asin(3 * ratio / (6 + ratio)))


def read(path):
	"""Drained triaxial tests of a CSV file with headings, [Test].

	path  columns test, e0 (void ratio at its isotropic pressure), p0_kPa, and where they were measured eta_peak and eta_end (q/p), epsv_end_pct (compression
		  positive), eps1_peak_pct, eps1_end_pct; further columns are passed over

	ValueError names file, line, column and fault.

	>>> with open(folder + "/sand.csv", "w") as file:
	...     written = file.write("test,e0,p0_kPa,eta_peak\\nA,0.8,100,1.5\\nB,0.9,200,\\n")
	>>> [test.pressure for test in talik.studies.elementtests.read(folder + "/sand.csv")]
	[100000.0, 200000.0]"""
	rows = [(line, cells) for line, cells in tables.lines(path) if any(cell.strip() for cell in cells)]
	places = {name.strip(): k for k, name in enumerate(rows[0][1])} if rows else {}
	for name in ofTest:
		if name not in places:
			raise ValueError(f"{path}: the column {name} is missing; its first line must name {', '.join(ofTest)}, and of results {', '.join(ofResult)}")

	def number(line, cells, name, least, largest):
		text = cells[places[name]].strip() if name in places and places[name] < len(cells) else ""
		if not text and name in ofResult:
			return math.nan
		try:
			value = float(text)
		except ValueError:
			value = math.nan
		if not least <= value <= largest:
			raise ValueError(f"{path}, line {line}, column {name}: '{text}' must be a number from {least:g} to {largest:g}")
		return value

	found = []
	for line, cells in rows[1:]:
		ratio, pressure = number(line, cells, "e0", 0.2, 2.0), 1e3 * number(line, cells, "p0_kPa", 1, 1e4)
		peak, last = (number(line, cells, name, 0.1, 2.9) for name in ("eta_peak", "eta_end"))
		volume, atPeak, end = (percent * number(line, cells, name, -60, 60) for name in ("epsv_end_pct", "eps1_peak_pct", "eps1_end_pct"))
		angles = [math.nan if math.isnan(ratio_) else angleOf(ratio_) for ratio_ in (peak, last)]
		found.append(Test(cells[places["test"]].strip(), ratio, pressure, usualEnd if math.isnan(end) else end, *angles, volume, atPeak))
	if not found:
		raise ValueError(f"{path} has no row below its headings; give a test in each line")
	return found


# ---- prediction -----------------------------------------------------------------------------------------------------------

# Friction and rolling friction of compaction, from what packs densest to what packs loosest
looseness = [(friction, 0.0) for friction in (0.0, 0.06, 0.12, 0.2, 0.3, 0.5)] + [(0.5, rolling) for rolling in (0.02, 0.05, 0.1, 0.2, 0.4)]
leastPressure = 50e3  # of compaction [Pa]
bounds = {"friction": (0.35, 0.75), "etaRoll": (0.05, 0.35), "shift": (0.0, 0.15)}
scales = dict(phiPeak=1.0, phiEnd=1.0, volumeEnd=0.01)  # of what is fitted: a degree weighs as much as one per cent of volume


class Library:
	"""Samples of spheres from dense to loose, and their triaxial tests.

	grains   in a sample
	seed     of the random positions
	young    contact modulus E_c0 [Pa]
	told     is given a line for each sample
	path     (friction, rolling friction) of compaction of each sample; default `looseness`
	poisson  of grains of Hertz and Mindlin, whose Young's modulus is young; None: linear springs

	>>> library = talik.studies.elementtests.Library(30, 1, told=lambda line: None, path=((0.0, 0.0), (0.5, 0.1)))
	>>> bool(library.voidRatios[0] < library.voidRatios[1])
	True"""

	def __init__(self, grains, seed=1, young=0.15e9, told=print, path=None, poisson=None):
		material = packing.Grains(grains, 4e-3, 6e-3, None, young, 0.5, 2650.0, 0.3, True, (("etaRoll", 0.1),), 3, poisson=poisson)
		samples = []
		for friction, rolling in path or looseness:
			sample = packing.compactPacked(material, leastPressure, friction, seed, rolling)
			samples.append((_voidRatio(sample), sample))
			told(f"seed {seed}: compacted with friction {friction:g} and rolling friction {rolling:g}, void ratio {samples[-1][0]:.3f}")
		samples.sort(key=lambda pair: pair[0])
		self.voidRatios, self.samples = np.array([ratio for ratio, _ in samples]), [sample for _, sample in samples]
		self._found = {}

	def predicted(self, test, friction, etaRoll, shift):
		"""{name: number} of a Test, as Curve.numbers, between the two samples nearest in void ratio."""
		wanted = test.voidRatio - shift
		below = int(np.clip(np.searchsorted(self.voidRatios, wanted) - 1, 0, len(self.samples) - 2))
		first, second = (self._numbers(k, test, friction, etaRoll) for k in (below, below + 1))
		part = float(np.clip((wanted - first["e0"]) / (second["e0"] - first["e0"]), -0.3, 1.3))
		return {name: first[name] + part * (second[name] - first[name]) for name in first}

	def _numbers(self, k, test, friction, etaRoll):
		key = (k, friction, etaRoll, test.pressure, test.end)
		if key not in self._found:
			self._found[key] = triaxial(target.altered(self.samples[k], friction, etaRoll), test.pressure, test.end).numbers()
		return self._found[key]


def _voidRatio(sample):
	porosity = sample.statistics()["porosity"]
	return porosity / (1 - porosity)


@dataclasses.dataclass(frozen=True)
class Prediction:
	"""Tests, those fitted on, the parameters found, and for each test what each library gives.

	>>> test = talik.studies.elementtests.Test("A", 0.8, 100e3, end=0.25, phiPeak=35.0)
	>>> talik.studies.elementtests.Prediction([test], ["A"], dict(friction=0.5), [[dict(phiPeak=36.0)]]).off("phiPeak", fitted=True)
	[1.0]"""

	tests: list
	fitted: list
	parameters: dict
	numbers: list

	def mean(self, k, name):
		"""Mean over the libraries."""
		return float(np.mean([one[name] for one in self.numbers[k]]))

	def deviation(self, k, name):
		"""Standard deviation over the libraries; NaN of one."""
		values = [one[name] for one in self.numbers[k]]
		return float(np.std(values, ddof=1)) if len(values) > 1 else math.nan

	def off(self, name, fitted):
		"""Predicted less measured, of tests that were fitted on or not."""
		chosen = [(k, test) for k, test in enumerate(self.tests) if (test.name in self.fitted) == fitted and name in test.measured]
		return [self.mean(k, name) - test.measured[name] for k, test in chosen]

	def report(self):
		"""Table of all tests; angles in degrees, volume in per cent, compression positive."""
		lines = [
			"| test | void ratio | pressure [kPa] | peak angle [°] | measured | angle at the end [°] | measured | volume at the end [%] | measured | E_50 [MPa] |",
			"|---|---|---|---|---|---|---|---|---|---|",
		]
		for k, test in enumerate(self.tests):
			cells = []
			for name, factor in (("phiPeak", 1), ("phiEnd", 1), ("volumeEnd", 100)):
				spread = self.deviation(k, name)
				cells.append(f"{factor * self.mean(k, name):.1f}" + ("" if math.isnan(spread) else f" ± {factor * spread:.1f}"))
				known = test.measured.get(name)
				cells.append("" if known is None else f"{factor * known:.1f}" + (" (fitted)" if test.name in self.fitted else ""))
			cells.append(f"{1e-6 * self.mean(k, 'E50'):.3g}")
			lines.append(f"| {test.name} | {test.voidRatio:.3f} | {test.pressure / 1e3:.0f} | {' | '.join(cells)} |")
		found = ", ".join(f"{name} {value:.3g}" for name, value in self.parameters.items())
		return "\n".join([*lines, "", f"fitted on {', '.join(self.fitted)}: {found}"])

	def draw(self):
		"""Figure: peak angle, angle at the end and volume at the end over the void ratio, by pressure; measured ones as open circles."""
		figure = plots.figure(12, 4.2)
		pressures = sorted({round(test.pressure, -4) for test in self.tests})
		panels = (("phiPeak", 1, "friction angle at the peak [°]"), ("phiEnd", 1, "friction angle at the end [°]"))
		for axes, (name, factor, label) in zip(figure.subplots(1, 3), (*panels, ("volumeEnd", 100, "volume at the end [%], compression positive"))):
			for colour, pressure in enumerate(pressures):
				own = [k for k, test in enumerate(self.tests) if round(test.pressure, -4) == pressure]
				ratio = [self.tests[k].voidRatio for k in own]
				spread = [0.0 if math.isnan(self.deviation(k, name)) else factor * self.deviation(k, name) for k in own]
				axes.errorbar(ratio, [factor * self.mean(k, name) for k in own], spread, fmt="o", ms=4, color=f"C{colour}", label=f"{pressure / 1e3:.0f} kPa")
				for k in own:
					if name in self.tests[k].measured:
						axes.plot(self.tests[k].voidRatio, factor * self.tests[k].measured[name], "o", ms=9, fillstyle="none", color=f"C{colour}")
			axes.set(xlabel="void ratio of the sand", ylabel=label)
			axes.legend(fontsize=7, frameon=False)
		return figure


def fit(tests, names=None, grains=300, seeds=(1, 2, 3), young=0.15e9, evaluations=10, told=print, path=None, poisson=None):
	"""Contact friction, rolling friction and shift of the void ratio fitted on some tests, and the prediction of all: Prediction.

	Samples are tested with parameters spread over `bounds`. A plane through what they give smooths the chance of single samples, and the fit is the place on the
	plane with the least squares.

	tests        of read
	names        of the tests to fit on; default those that have results
	grains       spheres in a sample
	seeds        one library for each; means over them are fitted
	young        contact modulus E_c0 of the samples [Pa]: the strengths hardly depend on it
	evaluations  sets of parameters that are tested, 5 or more
	poisson      of grains of Hertz and Mindlin, as of Library; E_50 then grows with the pressure as in sand

	>>> tests = [talik.studies.elementtests.Test("A", 0.7, 100e3, 0.01, phiPeak=30.0)]
	>>> settings = dict(grains=30, seeds=(1,), evaluations=5, told=lambda line: None, path=((0.0, 0.0), (0.5, 0.1)))
	>>> talik.studies.elementtests.fit(tests, **settings).fitted
	['A']"""
	from scipy.optimize import lsq_linear
	from scipy.stats import qmc

	names = [test.name for test in tests if test.measured] if names is None else list(names)
	for name in names:
		if not any(test.name == name and test.measured for test in tests):
			raise ValueError(f"elementtests: there are no results of a test '{name}' to fit on")
	if not names:
		raise ValueError("elementtests: no test has results; fill eta_peak, eta_end or epsv_end_pct of some")
	if evaluations < 5:
		raise ValueError(f"evaluations is {evaluations!r}; three parameters need 5 or more")
	libraries = [Library(grains, seed, young, told, path, poisson) for seed in seeds]
	low, high = np.array(list(bounds.values())).T
	wanted = [(test, name) for test in tests if test.name in names for name in test.measured if name in scales]
	measured = np.array([test.measured[name] / scales[name] for test, name in wanted])

	def parametersAt(place):
		return {name: float(value) for name, value in zip(bounds, low + place * (high - low))}

	places, found = qmc.LatinHypercube(len(bounds), seed=1).random(evaluations), []
	for place in places:
		parameters = parametersAt(place)
		given = {test.name: [library.predicted(test, **parameters) for library in libraries] for test, _ in wanted}
		found.append([np.mean([one[name] for one in given[test.name]]) / scales[name] for test, name in wanted])
		off = math.sqrt(np.mean((found[-1] - measured) ** 2))
		told(f"{', '.join(f'{name} {value:.3f}' for name, value in parameters.items())}: off by {off:.2f} (root mean square, degrees and per cent)")
	plane = np.linalg.lstsq(np.column_stack([np.ones(evaluations), places]), np.array(found), rcond=None)[0]
	best = parametersAt(lsq_linear(plane[1:].T, measured - plane[0], bounds=(0.0, 1.0)).x)
	numbers = []
	for test in tests:
		numbers.append([library.predicted(test, **best) for library in libraries])
		told(f"{test.name}: " + ", ".join(f"{name} {np.mean([one[name] for one in numbers[-1]]):.4g}" for name in ("phiPeak", "phiEnd", "volumeEnd", "E50")))
	return Prediction(list(tests), names, best, numbers)
