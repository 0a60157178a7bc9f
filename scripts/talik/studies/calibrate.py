# SPDX-License-Identifier: GPL-2.0-or-later
"""MohrCoulombSkeleton calibrated on a sample: biaxial tests at several ice saturations and pressures.

	result = talik.studies.calibrate.calibrate(talik.rve.pack(talik.rve.prepare(grains=400)))
	mpm.skeleton = MohrCoulombSkeleton(**result.parameters())
	scripts/calibrate --grains 400            # the same as a command, see talik.studies

Every test starts from the ice-free sample, brings it to an isotropic pressure, freezes it there and compresses it at constant
lateral stress (plane strain). One friction angle and one cohesion for each ice saturation are fitted to the peak stresses,
t = c cos(phi) + s' sin(phi) with s' = -(xx + yy)/2 and t the radius of Mohr's circle, by least squares of relative residuals. Ground
without bonds has no cohesion: what a line through its curved envelope leaves at no pressure, 1.5 kPa, would carry a metre of it.
Young's modulus is the secant at half of the peak deviator, averaged over the pressures. Tensile strength comes from extension without
lateral stress. The law takes each of them as a table over ice saturation, linear in between. A perfectly plastic law keeps the peak;
what the brittle sample loses after it is reported as `residual`.
"""

import dataclasses
import math
import time

import numpy as np
import talik
from yade import Matrix3, wrapper

from talik import packing, plots, rve

iceSaturations = (0.0, 0.02, 0.05, 0.1, 0.2, 0.4, 0.6, 0.8, 1.0)
pressures = (10e3, 30e3, 100e3)  # [Pa]
averaged = 20  # calls over which a peak is averaged
stepsPerCall = 40  # of 2e-5 of strain: twice as many change the friction of thawed samples by 1 %, a quarter of them adds 12 %
forgottenShear = 0.15  # after which samples in simple shear no longer show how they were packed
quasiStaticFlow = 1e-3  # inertial number: at a third of it the steady friction is the same within 0.005, at twice as much larger by 0.015
thawedStiffness, frozenStiffness = 3e7, 18e7  # [Pa], order of magnitude of a sample's, for the control of a stress


@dataclasses.dataclass(frozen=True)
class BiaxialTest:
	"""Result of one test; stresses in Pa, compression positive, strains [-], shortening positive.

	>>> test = talik.studies.calibrate.biaxialTest(packed, iceSaturation=1, pressure=100e3, strain=2e-4)
	>>> bool(test.axial[-1] > 100e3)
	True"""

	iceSaturation: float
	pressure: float  # constant lateral pressure
	strain: np.ndarray  # axial
	lateralStrain: np.ndarray
	axial: np.ndarray
	lateral: np.ndarray
	bonds: int  # at the start

	def smooth(self, values):
		"""Running mean of a record (n,) over a few samples of the test."""
		return np.convolve(values, np.ones(averaged) / averaged, "valid")

	@property
	def deviator(self):
		return self.smooth(self.axial - self.lateral)

	@property
	def peak(self):
		"""(s', t) at the largest deviator."""
		k = np.argmax(self.deviator)
		return 0.5 * self.smooth(self.axial + self.lateral)[k], 0.5 * self.deviator[k]

	@property
	def peakStrain(self):
		return float(self.smooth(self.strain)[np.argmax(self.deviator)])

	@property
	def tension(self):
		"""Largest axial tension [Pa]; 0 where there is none."""
		return max(0.0, float(-self.smooth(self.axial).min()))

	@property
	def residual(self):
		"""Deviator at the end of the test over that of the peak [-]."""
		return float(self.deviator[-averaged:].mean() / self.deviator.max())

	def elasticity(self):
		"""(E, nu) in plane strain at half of the peak deviator: E/(1-nu^2) from the axial, nu/(1-nu) from the lateral strain."""
		deviator = self.deviator
		k = max(1, int(np.argmax(deviator > 0.5 * deviator.max())))
		strain, across = (self.smooth(values) for values in (self.strain, self.lateralStrain))
		span = strain[k] - strain[0]
		ratio = min(max(-(across[k] - across[0]) / span, 0.0), 0.8)
		poisson = ratio / (1 + ratio)
		return (deviator[k] - deviator[0]) / span * (1 - poisson**2), poisson


def biaxialTest(sample, iceSaturation, pressure, strain=0.02, perCall=2e-5, lateral=None):
	"""Compression (strain > 0) or extension (strain < 0) of an ice-free RveSample, frozen at an isotropic `pressure` [Pa], under the constant
	pressure `lateral` [Pa]; default that at which it froze.

	>>> test = talik.studies.calibrate.biaxialTest(packed, iceSaturation=0.5, pressure=100e3, strain=2e-4)"""
	tested = _underPressure(sample, pressure)
	tested.freeze(iceSaturation)
	return drive(tested, iceSaturation, pressure if lateral is None else lateral, strain, perCall)


def extensionTest(sample, iceSaturation, pressure=10e3, strain=0.01, perCall=2e-5):
	"""Extension of an ice-free RveSample, frozen at an isotropic `pressure` [Pa], with the lateral stress removed.

	>>> test = talik.studies.calibrate.extensionTest(packed, iceSaturation=1, strain=2e-4)
	>>> bool(test.tension > 0)
	True"""
	return biaxialTest(sample, iceSaturation, pressure, -strain, perCall, lateral=0.0)


def tensileTest(sample, iceSaturation, pressure=10e3, strain=0.01, perCall=2e-5):
	"""Largest axial tension [Pa] in extension with the lateral stress removed, of a sample frozen at `pressure` [Pa]; 0 without ice.

	>>> tension = talik.studies.calibrate.tensileTest(packed, iceSaturation=1, strain=2e-4)"""
	return extensionTest(sample, iceSaturation, pressure, strain, perCall).tension


def thawedShearStrength(sample, pressure, strain=0.01, perCall=2e-5):
	"""Largest shear stress [Pa] of an ice-free RveSample in simple shear at a constant normal stress `pressure` [Pa], when it was frozen at that
	pressure and has thawed there: bonds that outlast their ice (RveSample.thawedStrength) are all that is left of them. Mean of both directions.

	>>> strength = talik.studies.calibrate.thawedShearStrength(packed, pressure=10e3, strain=2e-3)"""
	thawed = _thawedUnder(sample, pressure)
	return float(np.mean([_largestShearStress(thawed.copy(), pressure, strain, direction * perCall) for direction in (1, -1)]))


def thawedTension(samples, strength, pressures=(2e3, 5e3), strain=0.004, perCall=2e-5):
	"""Tensile strength [Pa] that bonds of a thawed strength [Pa] leave to ice-free RveSamples that were frozen at `pressures` [Pa] and have thawed
	there: the largest axial tension in extension with the lateral stress removed, mean over realisations and pressures.

	A cohesion without it holds next to nothing close to a surface, where normal stress is small.

	>>> tension = talik.studies.calibrate.thawedTension(packed, strength=0.3e6, pressures=(5e3,), strain=4e-4)"""
	bonded = [_withThawedStrength(sample, strength) for sample in rve.listOf(samples)]
	return float(np.mean([_largestTension(_thawedUnder(sample, pressure), 0.0, strain, perCall) for sample in bonded for pressure in pressures]))


def _underPressure(sample, pressure):
	"""A copy of a sample at an isotropic pressure [Pa] that is moved slowly: jolts of single grains raise the largest shear stress of fast motion."""
	pressed = sample.copy()
	pressed.minSteps = max(pressed.minSteps, stepsPerCall)
	if not pressed.servo(-pressure, -pressure):
		raise RuntimeError(f"calibrate: the sample does not reach an isotropic pressure of {pressure:g} Pa")
	return pressed


def _thawedUnder(sample, pressure):
	"""A copy of a sample that was frozen at an isotropic pressure [Pa] and has thawed there."""
	thawed = _underPressure(sample, pressure)
	thawed.freeze(1)
	thawed.freeze(0)
	return thawed


def _withThawedStrength(sample, strength):
	"""A copy without thaw strain: a sample that has lost its contacts to it must settle by it before it shows its strength."""
	other = sample.copy()
	other.thawedStrength, other.thawStrain = strength, 0.0
	return other


def _largestTension(tested, iceSaturation, strain, perCall):
	return drive(tested, iceSaturation, 0.0, -strain, perCall).tension


def _largestShearStress(sheared, pressure, strain, perCall):
	control, stress, shear = NormalStressControl(pressure, abs(perCall), thawedStiffness), sheared.stress, []
	for _ in range(round(strain / abs(perCall))):
		result = sheared.apply(Matrix3(0, perCall, 0, 0, control.strain(stress[1]), 0, 0, 0, 0), 0.0)
		if result["blewUp"]:
			raise RuntimeError(f"calibrate: the sample blew up in simple shear at {pressure:g} Pa: {result['reason']}")
		stress = result["stress"]
		shear.append(math.copysign(1, perCall) * stress[2])
	return np.convolve(shear, np.ones(averaged) / averaged, "valid").max()


def thawedCohesion(sample, strength, pressures=(2e3, 4e3, 8e3, 16e3)):
	"""Cohesion [Pa] that bonds of a thawed strength [Pa] leave to an ice-free RveSample when it was frozen and has thawed.

	By how much its largest shear stress in simple shear exceeds that of the same sample without bonds, mean over `pressures` [Pa]: a slope fails in
	simple shear, and there the cohesion is the same at every pressure (within 5 % from 2 to 16 kPa, 100 grains, mean of eight realisations).

	>>> cohesion = talik.studies.calibrate.thawedCohesion(packed, strength=0.3e6, pressures=(8e3,))"""
	return float(np.mean(_thawedShearStrengths(sample, strength, pressures) - _thawedShearStrengths(sample, 0.0, pressures)))


@dataclasses.dataclass(frozen=True)
class ShearFriction:
	"""Shear over normal stress of ice-free samples in simple shear without bonds, by realisation and pressure: at its largest within 1 % of shear, and
	in steady flow.

	Where ground begins to fail the peak counts, in a slide of metres the steady value, which samples of any packing have in the end. It is what
	RveSkeleton.slipFriction and the friction of a law (`friction` of calibrate) take.

	>>> print(talik.studies.calibrate.shearFriction(packed, pressures=(8e3,), shear=0.3).grains)
	30"""

	grains: int  # of a sample
	pressures: tuple  # [Pa]
	peak: np.ndarray  # (realisations, pressures), mean of both directions of shear [-]
	steady: np.ndarray  # (realisations, pressures, 2), each direction by itself [-]

	@property
	def peakMean(self):
		return float(self.peak.mean())

	@property
	def steadyMean(self):
		return float(self.steady.mean())

	@property
	def peakError(self):
		"""Standard error of peakMean over the realisations [-]; of a single one over the pressures."""
		return _standardError(self.peak)

	@property
	def steadyError(self):
		"""Standard error of steadyMean over the realisations [-]; of a single one over its pressures and directions."""
		return _standardError(self.steady)

	def report(self):
		"""Both as text."""
		return (
			f"simple shear of {len(self.peak)} x {self.grains} grains at {', '.join(f'{1e-3 * p:g}' for p in self.pressures)} kPa: "
			f"largest within 1 % {self.peakMean:.3f} ± {self.peakError:.3f}, steady {self.steadyMean:.3f} ± {self.steadyError:.3f}"
		)


def _standardError(values):
	rows = values.reshape(len(values), -1).mean(axis=1) if len(values) > 1 else values.ravel()
	return _deviation(rows) / math.sqrt(len(rows))


def shearFriction(samples, pressures=(2e3, 4e3, 8e3, 16e3), shear=None):
	"""Friction of ice-free RveSamples in simple shear at constant normal stress, a ShearFriction. Thaw strain and bonds play no part: ground that loses
	its contacts to thaw strain settles until it has them again.

	samples    one, or a list of realisations of one size
	pressures  normal stresses [Pa], > 0
	shear      of each run in steady flow [-], above 0.15, from which on its mean is taken; default 0.3 to 1, the more the fewer grains are sheared in
			   all: a single run of 100 grains up to a shear of 1 has a scatter of 0.02

	>>> friction = talik.studies.calibrate.shearFriction(packed, pressures=(8e3,), shear=0.3)"""
	several = rve.listOf(samples)
	grains = len(several[0].arrays()["radius"])
	if shear is None:
		shear = min(1.0, max(0.3, 800 / grains / (2 * len(pressures) * len(several))))
	if not forgottenShear < shear < math.inf:
		raise ValueError(f"shear is {shear!r}; give more than {forgottenShear}, by which samples have forgotten how they were packed")
	peaks = np.array([_thawedShearStrengths(sample, 0.0, pressures) / pressures for sample in several])
	steady = [_steadyFrictions(several, pressure, shear) for pressure in pressures]
	return ShearFriction(grains, tuple(pressures), peaks, np.transpose(steady, (1, 0, 2)))


def _steadyFrictions(samples, pressure, shear, perCall=4e-5):
	"""(samples, 2): shear over normal stress at a pressure [Pa], means of a run in each direction."""
	pressed = []
	for sample in samples:
		tested = _withThawedStrength(sample, 0.0)
		tested.minSteps, tested.maxInertialNumber = 10, quasiStaticFlow
		if not tested.servo(*[-pressure] * tested.dimension):
			raise RuntimeError(f"calibrate: the sample does not reach an isotropic pressure of {pressure:g} Pa")
		pressed += [tested, tested]
	directions = [perCall, -perCall] * len(samples)
	first = round(forgottenShear / perCall)
	calls, across = round(shear / perCall), pressed[0].dimension - 1
	runs = talik._talik.shearTests([(tested, direction, pressure, calls, 0, across) for tested, direction in zip(pressed, directions)])
	for _, _, failure in runs:
		if failure:
			raise RuntimeError(f"simple shear at {pressure:g} Pa: a sample blew up: {failure}")
	return np.reshape([-shearStress[first:].sum() / normalStress[first:].sum() for shearStress, normalStress, _ in runs], (len(samples), 2))


def thawedFriction(samples, pressures=(2e3, 4e3, 8e3, 16e3)):
	"""Shear over normal stress [-] with which ice-free RveSamples flow on in simple shear without bonds, mean over realisations and `pressures` [Pa]:
	RveSkeleton.slipFriction, and sin(phi) of a law whose ground slides by metres. It is the steady value of shearFriction, which also has its scatter.

	>>> friction = talik.studies.calibrate.thawedFriction(packed, pressures=(8e3,))"""
	return shearFriction(samples, pressures).steadyMean


def thawedPeakFriction(samples, pressures=(2e3, 4e3, 8e3, 16e3)):
	"""Largest shear over normal stress [-] of ice-free RveSamples within 1 % of simple shear, mean over realisations and `pressures` [Pa]: with which
	they begin to fail.

	>>> friction = talik.studies.calibrate.thawedPeakFriction(packed, pressures=(8e3,))"""
	return float(np.mean([_thawedShearStrengths(sample, 0.0, pressures) / pressures for sample in rve.listOf(samples)]))


def _thawedShearStrengths(sample, strength, pressures):
	tested = _withThawedStrength(sample, strength)
	return np.array([thawedShearStrength(tested, pressure) for pressure in pressures])


def thawedStrength(samples, cohesion, pressures=(2e3, 4e3, 8e3, 16e3)):
	"""RveSample.thawedStrength [Pa] that gives thawed ground a cohesion [Pa], and the cohesion measured with it: (strength, measured).

	Read off the mean curve of thawedCohesion over the strength, made to rise.

	samples   ice-free RveSample, or a list of realisations, over which the mean is taken
	cohesion  of thawed ground, 0 or more

	>>> strength, measured = talik.studies.calibrate.thawedStrength(packed, cohesion=2e3, pressures=(10e3,))"""
	if not 0 <= cohesion < math.inf:
		raise ValueError(f"thawed cohesion is {cohesion!r}; give a cohesion in Pa, 0 or more")
	if cohesion == 0:
		return 0.0, 0.0
	samples = rve.listOf(samples)
	plain = [_thawedShearStrengths(sample, 0.0, pressures) for sample in samples]

	def measured(strength):
		return float(np.mean([np.mean(_thawedShearStrengths(sample, strength, pressures) - without) for sample, without in zip(samples, plain)]))

	strengths, cohesions = [0.0], [0.0]
	while cohesions[-1] < cohesion and len(strengths) < 9:
		strengths.append(2 * strengths[-1] or 50.0 * cohesion)
		cohesions.append(max(cohesions[-1], measured(strengths[-1])))
	if cohesions[-1] < cohesion:
		raise RuntimeError(f"calibrate: bonds of {strengths[-1]:g} Pa leave {cohesions[-1]:g} Pa of the cohesion {cohesion:g} Pa; choose a smaller one")
	first = next(k for k, reached in enumerate(cohesions) if reached >= cohesion)
	part = (cohesion - cohesions[first - 1]) / (cohesions[first] - cohesions[first - 1])
	strength = strengths[first - 1] + part * (strengths[first] - strengths[first - 1])
	return strength, measured(strength)


class NormalStressControl:
	"""Strain of each call that holds a normal stress, by its error now and the sum of the errors so far.

	pressure   to be held [Pa], compression positive
	perCall    strain of a call across; the control gives three times as much at most
	stiffness  order of magnitude of that of the sample [Pa]

	>>> control = talik.studies.calibrate.NormalStressControl(pressure=10e3, perCall=2e-5, stiffness=3e7)
	>>> control.strain(-9e3) < 0
	True"""

	def __init__(self, pressure, perCall, stiffness):
		self.pressure, self.limit, self.stiffness, self.integral = pressure, 3 * perCall, stiffness, 0.0

	def strain(self, stress):
		"""Of the next call; stress: the normal stress now [Pa], tension positive."""
		error = (-self.pressure - stress) / self.stiffness
		self.integral += 0.05 * error
		return max(-self.limit, min(self.limit, 0.4 * error + self.integral))


# ---- realisations ---------------------------------------------------------------------------------------------------------


@dataclasses.dataclass(frozen=True)
class Scatter:
	"""What realisations of one size measure, each an array over them.

	>>> scatter = talik.studies.calibrate.scatterOf([packed, packed], strain=5e-4)
	>>> bool(scatter.frictionAngle.std() == 0)
	True"""

	grains: int
	frictionAngle: np.ndarray  # without ice [deg]
	young: np.ndarray  # without ice [Pa]
	frozenStrength: np.ndarray  # largest deviator at full ice saturation and 100 kPa [Pa]
	frozenYoung: np.ndarray  # [Pa]
	shearFriction: np.ndarray  # without ice, the largest within 1 % of shear, see thawedPeakFriction [-]

	def row(self):
		"""Mean and standard deviation of one realisation, as text."""
		columns = [(self.frictionAngle, 1, 1), (self.young, 1e-6, 1), (self.frozenStrength, 1e-3, 0), (self.frozenYoung, 1e-6, 0), (self.shearFriction, 1, 2)]
		cells = [f"{scale * values.mean():.{digits}f} ± {scale * _deviation(values):.{digits}f}" for values, scale, digits in columns]
		return f"| {self.grains} | {len(self.young)} | {' | '.join(cells)} |"


scatterHead = "| grains | realisations | φ [°] | E [MPa] | frozen strength [kPa] | frozen E [MPa] | in simple shear [-] |\n|---|---|---|---|---|---|---|"


def _deviation(values):
	return float(np.std(values, ddof=1)) if len(values) > 1 else 0.0


def scatterOf(samples, pressures=(30e3, 100e3), strain=0.02):
	"""Friction angle, stiffness and frozen strength of packed, ice-free realisations (RveSample), each by biaxial tests of its own, and their friction in
	simple shear.

	The friction angle is that of a line through the origin, sin(phi) = t/s' at the peak, mean over `pressures` [Pa].

	>>> print(talik.studies.calibrate.scatterOf([packed], strain=5e-4).grains)
	30"""
	rows = []
	for sample in samples:
		thawed = [biaxialTest(sample, 0.0, pressure, strain) for pressure in pressures]
		frozen = biaxialTest(sample, 1.0, max(pressures), strain)
		sine = np.mean([test.peak[1] / test.peak[0] for test in thawed])
		young = np.mean([test.elasticity()[0] for test in thawed])
		rows.append((math.degrees(math.asin(sine)), young, frozen.deviator.max(), frozen.elasticity()[0], thawedPeakFriction(sample)))
	return Scatter(len(samples[0].arrays()["radius"]), *np.array(rows).T)


def scatter(grains=(60, 100, 200, 400), realisations=8, seed=1, strain=0.02, told=print, **prepared):
	"""Table of scatterOf over the number of grains, a list of Scatter; `told` is given each line as soon as it is known.

	>>> lines = []
	>>> table = talik.studies.calibrate.scatter(grains=(30,), realisations=1, strain=5e-4, told=lines.append, porosity=0.19)"""
	told(scatterHead)
	table = []
	for number in grains:
		table.append(scatterOf(rve.pack(rve.prepare(grains=number, realisations=realisations, seed=seed, ice=True, **prepared)), strain=strain))
		told(table[-1].row())
	return table


# ---- rolling friction -----------------------------------------------------------------------------------------------------

denseSand = (33.0, 40.0)  # [deg] friction angles of dense sand that samples are held against


@dataclasses.dataclass(frozen=True)
class RollingFriction:
	"""Friction angles of samples without ice, arrays (porosity, etaRoll): mean and standard deviation over realisations; NaN: no sample.

	>>> result = talik.studies.calibrate.rollingFriction(grains=30, porosities=(0.19,), coefficients=(0, 0.1), realisations=1, strain=5e-4, told=lambda line: None)
	>>> result.frictionAngle.shape
	(1, 2)"""

	grains: int
	porosities: tuple
	coefficients: tuple  # etaRoll [-]
	frictionAngle: np.ndarray  # at the peak [deg]
	deviation: np.ndarray  # of one realisation [deg]
	young: np.ndarray  # [Pa]

	def draw(self):
		"""Figure: friction angle over etaRoll, a line for each porosity, with the range of dense sand."""
		fig = plots.figure(6, 4.2)
		axes = fig.subplots()
		axes.axhspan(*denseSand, color="0.9", label="dense sand")
		for row, porosity in enumerate(self.porosities):
			axes.errorbar(self.coefficients, self.frictionAngle[row], self.deviation[row], marker="o", capsize=2, label=f"porosity {porosity:g}")
		axes.set(xlabel=r"coefficient of rolling friction $\eta_r$ [-]", ylabel=r"friction angle $\varphi$ at the peak [°]", ylim=(0, None))
		axes.legend(frameon=False)
		return fig


def rollingFriction(
	grains=200, porosities=(0.16, 0.18), coefficients=(0.0, 0.05, 0.1, 0.2), realisations=3, pressure=100e3, strain=0.06, told=print, **prepared
):
	"""Friction angle of thawed samples over porosity and coefficient of rolling friction, from biaxial tests at one pressure; each sample is
	prepared with its own coefficient. `told` is given each line of the table as soon as it is known.

	>>> lines = []
	>>> table = talik.studies.calibrate.rollingFriction(30, (0.19,), (0.1,), 1, strain=5e-4, told=lines.append)"""
	told("| porosity | etaRoll | φ [°] | E [MPa] |\n|---|---|---|---|")
	cells = np.full((3, len(porosities), len(coefficients)), np.nan)
	for row, porosity in enumerate(porosities):
		for column, coefficient in enumerate(coefficients):
			rolling = {"etaRoll": coefficient} if coefficient > 0 else {}
			try:
				samples = rve.prepare(grains=grains, porosity=porosity, pressure=pressure, ice=True, realisations=realisations, **rolling, **prepared)
			except packing.PackingError as problem:
				told(f"| {porosity:g} | {coefficient:g} | no sample: {problem} | |")
				continue
			tests = [biaxialTest(sample, 0.0, pressure, strain) for sample in rve.pack(samples)]
			angles = np.degrees([math.asin(test.peak[1] / test.peak[0]) for test in tests])
			young = np.mean([test.elasticity()[0] for test in tests])
			cells[:, row, column] = angles.mean(), _deviation(angles), young
			told(f"| {porosity:g} | {coefficient:g} | {angles.mean():.1f} ± {_deviation(angles):.1f} | {1e-6 * young:.0f} |")
	return RollingFriction(grains, tuple(porosities), tuple(coefficients), *cells)


# ---- rate and temperature -------------------------------------------------------------------------------------------------

rates = tuple(10.0**k for k in range(-7, 1))  # [1/s]
temperatures = (0.0, -2.0, -5.0, -10.0, -20.0, -30.0, -40.0, -56.7)  # [degC]


def frozenStrength(sample, law, temperature, rate, pressure=100e3, strain=0.03):
	"""(largest deviator in compression at a lateral pressure, largest tension) [Pa] of an ice-free RveSample that is frozen to full ice saturation, its
	bonds as strong as an IceStrength says at a temperature [degC] and a strain rate [1/s in physical time].

	>>> compression, tension = talik.studies.calibrate.frozenStrength(packed, IceStrength(), temperature=-5, rate=1e-3, strain=2e-4)"""
	tested = sample.copy()
	tested.tensileStrengthFactor, tested.shearStrengthFactor = law.factors(temperature, rate)
	return biaxialTest(tested, 1.0, pressure, strain).deviator.max(), tensileTest(tested, 1.0)


def strengthTable(sample, law=None, told=print, strain=0.03):
	"""Strengths [Pa] over `rates` at -10 degC, array (rate, 2), and over `temperatures` at 1e-4 1/s, array (temperature, 2); `told` is given
	each line of the table as soon as it is known.

	>>> lines = []
	>>> overRate, overTemperature = talik.studies.calibrate.strengthTable(packed, told=lines.append, strain=2e-4)"""
	law = law or wrapper.IceStrength()
	told("| temperature [°C] | rate [1/s] | compression [MPa] | tension [MPa] |\n|---|---|---|---|")
	tables = []
	for conditions in ([(-10.0, rate) for rate in rates], [(temperature, 1e-4) for temperature in temperatures]):
		tables.append([])
		for temperature, rate in conditions:
			tables[-1].append(frozenStrength(sample, law, temperature, rate, strain=strain))
			told(f"| {temperature:g} | {rate:.0e} | {' | '.join(f'{1e-6 * strength:.2f}' for strength in tables[-1][-1])} |")
	return tuple(np.array(table) for table in tables)


def drawStrength(overRate, overTemperature):
	"""Figure of strengthTable.

	>>> figure = talik.studies.calibrate.drawStrength(np.ones((8, 2)), np.ones((8, 2)))"""
	fig = plots.figure(9, 4)
	ofRate, ofTemperature = fig.subplots(1, 2, sharey=True)
	for axes, across, table in ((ofRate, rates, overRate), (ofTemperature, temperatures, overTemperature)):
		for column, label, mark in ((0, "compression at 100 kPa", "o-"), (1, "tension", "s--")):
			axes.plot(across, 1e-6 * table[:, column], mark, color=("black", "red")[column], label=label)
		axes.set_yscale("log")
	ofRate.set(xscale="log", xlabel="strain rate over calendar time [1/s]", ylabel="strength [MPa]", title="at -10 °C")
	ofTemperature.set(xlabel="temperature [°C]", title="at 1e-4 1/s")
	ofRate.legend(frameon=False)
	return fig


def drive(tested, iceSaturation, pressure, strain, perCall=2e-5):
	"""Compression (strain > 0) or extension (strain < 0) of an RveSample as it stands, under a constant lateral `pressure` [Pa]. The sample is
	changed. A BiaxialTest.

	>>> frozen.copy().iceSaturation
	1.0
	>>> test = talik.studies.calibrate.drive(frozen.copy(), iceSaturation=1, pressure=10e3, strain=2e-4)"""
	control = NormalStressControl(pressure, perCall, frozenStiffness if iceSaturation > 0 else thawedStiffness)
	across, rows = 0.0, []
	stress, bonds = tested.stress, tested.statistics()["bondsIntact"]
	for k in range(1, int(round(abs(strain) / perCall)) + 1):
		step = control.strain(stress[0])
		across += step
		down = math.copysign(perCall, -strain)
		result = tested.apply(Matrix3(step, 0, 0, 0, down, 0, 0, 0, 0), iceSaturation)
		if result["blewUp"]:
			raise RuntimeError(f"calibrate: the sample blew up at strain {k * perCall:g} (S_i = {iceSaturation:g}, {pressure:g} Pa): {result['reason']}")
		stress = result["stress"]
		rows.append((-k * down, -across, -stress[1], -stress[0]))
	return BiaxialTest(iceSaturation, pressure, *np.array(rows).T, bonds)


@dataclasses.dataclass(frozen=True)
class Calibration:
	"""Tests and what was fitted to them. Arrays go with iceSaturation; residuals are relative, (fit - measured)/measured of t at the peak.

	>>> result = talik.studies.calibrate.calibrate(packed, iceSaturations=(0.0, 1.0), pressures=(50e3, 100e3), strain=5e-4)
	>>> law = MohrCoulombSkeleton(**result.parameters())"""

	tests: list
	iceSaturation: np.ndarray
	cohesion: np.ndarray  # [Pa]
	frictionAngle: float  # [deg]
	young: np.ndarray  # [Pa]
	youngScatter: np.ndarray  # largest deviation from the mean over the pressures and realisations [-]
	poisson: float
	tensileStrength: np.ndarray  # [Pa]
	residuals: np.ndarray  # of each test [-]
	seconds: float  # processor time of the tests

	def parameters(self):
		"""Keyword arguments of MohrCoulombSkeleton."""
		return dict(
			poisson=self.poisson,
			frictionAngle=self.frictionAngle,
			iceSaturations=list(map(float, self.iceSaturation)),
			youngs=list(map(float, self.young)),
			cohesions=list(map(float, self.cohesion)),
			tensileStrengths=list(map(float, self.tensileStrength)),
		)

	def report(self):
		"""The fit as text."""
		lines = [f"{len(self.tests)} tests in {self.seconds:.0f} s; friction angle {self.frictionAngle:.1f} deg, Poisson's ratio {self.poisson:.2f}"]
		lines.append(
			f"{'S_i [-]':>8} {'c [kPa]':>9} {'E [MPa]':>9} {'+-':>5} {'tension [kPa]':>14} {'residuals of t at the pressures':>34} {'after peak/peak':>16}"
		)
		for k, saturation in enumerate(self.iceSaturation):
			chosen = [i for i, test in enumerate(self.tests) if test.iceSaturation == saturation]
			off = " ".join(f"{100 * self.residuals[i]:+6.1f} %" for i in chosen)
			after = np.mean([self.tests[i].residual for i in chosen])
			lines.append(
				f"{saturation:8.2f} {1e-3 * self.cohesion[k]:9.2f} {1e-6 * self.young[k]:9.1f} {100 * self.youngScatter[k]:4.0f}% "
				f"{1e-3 * self.tensileStrength[k]:14.1f} {off:>34} {after:16.2f}"
			)
		return "\n".join(lines)

	def draw(self):
		"""Figure: stress-strain curves, peaks with the fitted lines, c and E and tensile strength over ice saturation."""
		fig = plots.figure(11, 7)
		(curves, peaks), (strength, stiffness) = fig.subplots(2, 2)
		colours = {saturation: f"C{k}" for k, saturation in enumerate(self.iceSaturation)}
		for test in self.tests:
			colour, first = colours[test.iceSaturation], test.pressure == min(t.pressure for t in self.tests)
			curves.plot(
				100 * test.smooth(test.strain), 1e-3 * test.deviator, color=colour, linewidth=0.8, label=f"$S_i$ = {test.iceSaturation:g}" if first else None
			)
			peaks.plot(*(1e-3 * value for value in test.peak), "o", color=colour, markersize=4)
		largest = max(test.peak[0] for test in self.tests)
		mean, angle = np.array([0, largest]), math.radians(self.frictionAngle)
		for saturation, cohesion in zip(self.iceSaturation, self.cohesion):
			peaks.plot(1e-3 * mean, 1e-3 * (cohesion * math.cos(angle) + mean * math.sin(angle)), color=colours[saturation], linewidth=0.8)
		curves.set(xlabel="axial strain [%]", ylabel="axial less lateral stress [kPa]", yscale="symlog")
		curves.legend(fontsize=7, ncol=2, frameon=False)
		peaks.set(xlabel="mean pressure $s'$ [kPa]", ylabel="shear stress $t$ [kPa]", title=rf"peaks and fit, $\varphi$ = {self.frictionAngle:.1f}°")
		strength.plot(self.iceSaturation, 1e-3 * self.cohesion, "o-", color="black", label="cohesion c")
		strength.plot(self.iceSaturation, 1e-3 * self.tensileStrength, "s--", color="red", label="tensile strength")
		strength.set(xlabel="ice saturation $S_i$ [-]", ylabel="strength [kPa]", ylim=(0, None))
		strength.legend(frameon=False)
		stiffness.errorbar(self.iceSaturation, 1e-6 * self.young, 1e-6 * self.young * self.youngScatter, marker="o", color="black", capsize=2)
		stiffness.set(xlabel="ice saturation $S_i$ [-]", ylabel="Young's modulus E [MPa]", ylim=(0, None))
		return fig


def calibrate(sample, iceSaturations=iceSaturations, pressures=pressures, strain=0.02, friction=None):
	"""Calibration of a packed, ice-free sample (RveSample), or of a list of realisations, to all of whose tests one law is fitted.

	iceSaturations  in 0..1, both of them included; the law is linear between them
	pressures       [Pa], > 0, two or more
	strain          axial strain of each test [-]
	friction        shear over normal stress with which the law is to fail in simple shear, sin(phi) [-], as measured by thawedFriction; cohesions are
					fitted to the peaks with it. Default: fitted to the peaks, too. A slide of metres has the friction of a sample that
					has been sheared, not that of its peak: 0.30 and 0.44 for the sample of the slumps

	>>> result = talik.studies.calibrate.calibrate(packed, iceSaturations=(0.0, 1.0), pressures=(50e3, 100e3), strain=5e-4)"""
	if len(pressures) < 2:
		raise ValueError(f"pressures is {pressures!r}; cohesion and friction are told apart by two or more")
	samples = rve.listOf(sample)
	for sample in samples:
		if sample.iceSaturation > 0:
			raise ValueError(f"the sample holds ice (iceSaturation {sample.iceSaturation:g}); give an ice-free one, the tests freeze it")
	saturations = np.array(sorted(iceSaturations), dtype=float)
	if saturations[0] != 0 or saturations[-1] != 1:
		raise ValueError(f"iceSaturations is {iceSaturations!r}; the law needs 0 and 1 among them, and nothing outside")
	if friction is not None and not 0 < friction < 1:
		raise ValueError(f"friction is {friction!r}; give shear over normal stress in simple shear, above 0 and below 1")
	start = time.process_time()
	tests = [biaxialTest(sample, s, p, strain) for s in saturations for p in pressures for sample in samples]
	tension = np.array([np.mean([tensileTest(sample, s, min(pressures)) for sample in samples]) for s in saturations])
	seconds = time.process_time() - start
	cohesion, sine, residuals = _fitStrength(tests, saturations, friction)
	elastic = np.array([test.elasticity() for test in tests]).reshape(len(saturations), len(pressures) * len(samples), 2)
	young = elastic[:, :, 0].mean(axis=1)
	return Calibration(
		tests=tests,
		iceSaturation=saturations,
		cohesion=cohesion,
		frictionAngle=math.degrees(math.asin(sine)),
		young=young,
		youngScatter=np.abs(elastic[:, :, 0] / young[:, None] - 1).max(axis=1),
		poisson=float(np.clip(elastic[:, :, 1].mean(), 0.05, 0.45)),
		tensileStrength=tension,
		residuals=residuals,
		seconds=seconds,
	)


def _fitStrength(tests, saturations, sine=None):
	"""Cohesions, sin(phi) and relative residuals: t = a(S_i) + s' sin(phi), a = c cos(phi) >= 0, without bonds 0, each equation over its t. A
	sine that is given is kept."""
	from scipy.optimize import lsq_linear

	mean, shear = np.array([test.peak for test in tests]).T
	bonded = np.array([test.bonds > 0 for test in tests])
	matrix = np.zeros((len(tests), len(saturations) + 1))
	matrix[np.arange(len(tests)), np.searchsorted(saturations, [test.iceSaturation for test in tests])] = bonded / shear
	matrix[:, -1] = mean / shear
	scale = np.append(np.full(len(saturations), 1e5), 1.0)
	lowest, highest = (0.0, 0.95) if sine is None else (sine - 1e-12, sine + 1e-12)
	bounds = (np.append(np.zeros(len(saturations)), lowest) / scale, np.append(np.full(len(saturations), np.inf), highest) / scale)
	fitted = lsq_linear(matrix * scale, np.ones(len(tests)), bounds=bounds).x * scale
	cohesive = np.abs(matrix[:, :-1]).sum(axis=0) > 0
	sine = fitted[-1]
	return np.where(cohesive, fitted[:-1], 0.0) / math.sqrt(1 - sine**2), float(sine), matrix @ fitted - 1
