# SPDX-License-Identifier: GPL-2.0-or-later
"""Creep tests on frozen samples under constant stress: rate over strain, rate factor and exponent of the secondary creep.

	test = talik.studies.creep.creepTest(frozen, IceCreep(), "shear", stress=100e3)
	test.secondaryRate()
	scripts/calibrate --creep                 # rate over stress and over strain: table and picture

The stress is held by the strain of each call. A call lasts as long as the stress of the bonds takes to fall by a hundredth or so: the time of
the tests is thus as long as it has to be, and a test costs the same at every stress.
"""

import dataclasses

import numpy as np
from yade import Matrix3, wrapper

from talik import plots, rve

loads = {"tension": (0.0, 1.0, 0.0), "shear": (0.0, 0.0, 1.0), "compression": (0.0, -1.0, 0.0)}  # xx, yy, xy over the stress; None: the strain is held at zero
components = {2: ((0, 0), (1, 1), (0, 1)), 3: ((0, 0), (1, 1), (2, 2), (1, 2), (0, 2), (0, 1))}  # of the stress of a sample in the plane and in space
steady = ("tension", "shear")  # loads with a secondary creep
stresses = (25e3, 50e3, 100e3, 200e3)  # [Pa]
secondary = (0.02, 0.04)  # strain between which the rate is that of the secondary creep [-]
loadingCalls = 40
bondModulus = 3.6e9  # of a bond at full ice saturation, to order of magnitude [Pa]


@dataclasses.dataclass(frozen=True)
class CreepTest:
	"""Creep under one stress, arrays over the calls: time [s of physical time], strain [-] along the load (tensor component, positive).

	>>> test = talik.studies.creep.creepTest(frozen, IceCreep(), "tension", stress=100e3, strain=2e-3)
	>>> bool(np.all(np.diff(test.time) > 0))
	True"""

	load: str
	stress: float  # [Pa]
	time: np.ndarray
	strain: np.ndarray  # of a load with shear its shear strain
	error: float  # largest deviation of a component of the stress over the last half of the calls, over the stress [-]

	def rate(self, begin, end):
		"""Mean rate [1/s] between two strains."""
		first, last = np.searchsorted(self.strain, (begin, end))
		if last >= len(self.strain) or first == last:
			raise ValueError(f"creep: the test under {self.stress:g} Pa ends at a strain of {self.strain[-1]:.4f}; the rate is wanted up to {end:g}")
		return (self.strain[last] - self.strain[first]) / (self.time[last] - self.time[first])

	def secondaryRate(self):
		"""Mean rate [1/s] between the strains `secondary`."""
		return self.rate(*secondary)


def creepTest(frozen, law, load, stress, temperature=-10.0, strain=0.045, relaxed=0.01, calls=20000):
	"""Creep of a frozen RveSample, of discs or of spheres, under a constant stress, the other components of stress zero.

	law          IceCreep
	load         "tension" or "compression" along y, "shear" in the plane xy, or (xx, yy, xy) as in `loads`; of spheres (xx, yy, zz, yz, xz, xy)
	stress       [Pa], > 0; what the sample carried before is taken off
	temperature  [degC]
	strain       at which the test ends [-]
	relaxed      part by which the stress of a bond falls in a call, to order of magnitude [-]; the rate comes out too small by a few times that
	calls        after which it ends in any case

	>>> test = talik.studies.creep.creepTest(frozen, IceCreep(), "shear", stress=50e3, strain=1e-3)"""
	sample, direction = frozen.copy(), _direction(load, frozen.dimension)
	held = np.array([part is None for part in direction])
	direction = np.array([part or 0.0 for part in direction])
	component = len(direction) - 1 if direction[-1] else int(np.argmax(np.abs(direction)))
	compliance = _compliance(sample, held)

	def lacking(part=1.0):
		return np.where(held, 0.0, part * stress * direction - sample.stress)

	for k in range(loadingCalls):
		_apply(sample, 0.7 * compliance @ lacking(min(1.0, 2 * (k + 1) / loadingCalls)))
	ofCall = law.over(temperature, 1.0)[0]
	duration = relaxed / (bondModulus * ofCall * (_concentration(sample) * stress) ** (law.exponent - 1))
	creep = law.over(temperature, duration)
	expected, reached, rows, errors = np.zeros(len(direction)), 0.0, [], []
	while reached < strain and len(rows) < calls:
		step = expected + 0.5 * compliance @ lacking()
		_apply(sample, step, creep)
		expected = 0.9 * expected + 0.1 * step
		reached += step[component] * np.sign(direction[component])
		rows.append(reached)
		errors.append(np.abs(lacking()).max() / stress)
	return CreepTest(load, stress, duration * np.arange(1, len(rows) + 1), np.array(rows), float(max(errors[len(errors) // 2 :])))


def _direction(load, dimension):
	"""Components of a load over the stress."""
	if not isinstance(load, str):
		return load
	xx, yy, xy = loads[load]
	return (xx, yy, xy) if dimension == 2 else (xx, yy, 0.0, 0.0, 0.0, xy)


def _apply(sample, strain, creep=None):
	gradient = np.zeros((3, 3))
	for part, (i, j) in zip(strain, components[sample.dimension]):
		gradient[i, j] = gradient[j, i] = part
	result = sample.apply(Matrix3(*gradient.ravel()), 1.0, creep)
	if result["blewUp"]:
		raise RuntimeError(f"creep: the sample blew up: {result['reason']}")


def _compliance(sample, held, size=2e-6):
	"""Strain over stress, a column for each component of the stress [1/Pa]; rows and columns of components whose strain is held are zero."""
	columns = []
	for strain in size * np.eye(len(held)):
		ends = [sample.copy() for _ in range(2)]
		for end, sign in zip(ends, (1, -1)):
			_apply(end, sign * strain)
		columns.append(np.subtract(ends[0].stress, ends[1].stress) / (2 * size))
	free = np.ix_(~held, ~held)
	compliance = np.zeros((len(held), len(held)))
	compliance[free] = np.linalg.inv(np.array(columns).T[free])
	return compliance


def _concentration(sample):
	"""Stress of a bond over that of the sample: the force on a width of two radii of a slice, or on a square of two radii, over the area R^2 [-]."""
	return 4.0 if sample.dimension == 3 else 2 * sample.thickness / float(np.mean(sample.arrays()["radius"]))


# ---- table and picture ----------------------------------------------------------------------------------------------------


@dataclasses.dataclass(frozen=True)
class CreepTable:
	"""Creep tests of several realisations: tests[load][k] is a list over the realisations under stresses[k], of compression under one stress.

	>>> table = talik.studies.creep.creepTable([frozen], stresses=(50e3, 100e3), relaxed=0.1, told=lambda line: None)
	>>> exponent = table.exponent("tension")"""

	law: object
	temperature: float  # [degC]
	stresses: tuple  # [Pa]
	tests: dict

	def rates(self, load):
		"""Rates of the secondary creep [1/s], array (stress, realisation)."""
		return np.array([[test.secondaryRate() for test in row] for row in self.tests[load]])

	def exponent(self, load):
		"""Slope of log rate over log stress, of the mean of the logarithms over the realisations [-]."""
		return float(np.polyfit(np.log(self.stresses), np.log(self.rates(load)).mean(axis=1), 1)[0])

	def rateFactor(self, load):
		"""Rate over stress to the power of the law's exponent, geometric mean [Pa^-n/s]."""
		return float(np.exp(np.mean(np.log(self.rates(load) / np.array(self.stresses)[:, None] ** self.law.exponent))))

	def draw(self):
		"""Figure: rate over stress with lines of Glen's law, and rate over strain under the largest stress but one."""
		fig = plots.figure(10, 4.4)
		ofStress, ofStrain = fig.subplots(1, 2)
		glen, stress = self.law.rateFactorAt(self.temperature), np.array(self.stresses)
		for load, colour in zip(steady, ("red", "black")):
			rates = self.rates(load)
			ofStress.plot(1e-3 * np.repeat(stress, rates.shape[1]), rates.ravel(), "o", color=colour, markersize=4, label=f"samples in {load}")
			line = self.rateFactor(load) * stress**self.law.exponent
			ofStress.plot(1e-3 * stress, line, "-", color=colour, linewidth=0.8, label=f"Glen's law, n = {self.law.exponent:g}, factor fitted to {load}")
		ofStress.set(
			xscale="log", yscale="log", xlabel="stress [kPa]", ylabel="rate of secondary creep [1/s of physical time]", title=f"at {self.temperature:g} °C"
		)
		ofStress.set_xticks(1e-3 * stress, [f"{1e-3 * s:g}" for s in stress])
		ofStress.minorticks_off()
		ofStress.legend(frameon=False, fontsize=8)
		shown = _shown(self.stresses)
		for load, colour in (("tension", "red"), ("shear", "black"), ("compression", "blue")):
			tests = self.tests[load][shown if load in steady else 0]
			for test in tests:
				ends = np.linspace(0.05 * test.strain[-1], test.strain[-1], 21)[:-1]
				rates = [test.rate(begin, end) / (glen * test.stress**self.law.exponent) for begin, end in zip(ends[:-1], ends[1:])]
				ofStrain.plot(100 * 0.5 * (ends[1:] + ends[:-1]), rates, color=colour, linewidth=0.9, label=load if test is tests[0] else None)
		ofStrain.axvspan(*(100 * end for end in secondary), color="0.88", label="taken as secondary")
		ofStrain.set(yscale="log", xlabel="strain [%]", ylabel=r"rate over $A(T)\,\sigma^n$ of a bond [-]", title=f"under {1e-3 * stress[shown]:g} kPa")
		ofStrain.legend(frameon=False, fontsize=8, loc="center", bbox_to_anchor=(0.36, 0.62))
		return fig


def _shown(stresses):
	"""Place of the stress whose rates are drawn over strain."""
	return max(0, len(stresses) - 2)


def creepTable(frozen, law=None, temperature=-10.0, stresses=stresses, relaxed=0.01, told=print):
	"""Creep tests on realisations of a frozen sample; `told` is given each line of the table as soon as it is known.

	>>> lines = []
	>>> table = talik.studies.creep.creepTable([frozen], stresses=(100e3,), relaxed=0.1, told=lines.append)"""
	law, tests = law or wrapper.IceCreep(), {}
	told("| load | stress [kPa] | rate, 2 to 4 % of strain [1/s] | over A σⁿ of a bond |\n|---|---|---|---|")
	for load in steady:
		tests[load] = []
		for stress in stresses:
			tests[load].append([creepTest(sample, law, load, stress, temperature, relaxed=relaxed) for sample in frozen])
			rates = np.array([test.secondaryRate() for test in tests[load][-1]])
			told(f"| {load} | {1e-3 * stress:g} | {rates.mean():.2e} | {rates.mean() / (law.rateFactorAt(temperature) * stress**law.exponent):.3g} |")
	pressed = [creepTest(sample, law, "compression", stresses[_shown(stresses)], temperature, relaxed=10 * relaxed) for sample in frozen]
	table = CreepTable(law, temperature, tuple(stresses), {**tests, "compression": [pressed]})
	if len(stresses) > 1:
		told("exponent: " + ", ".join(f"{load} {table.exponent(load):.3f}" for load in steady))
	return table


def frozenSamples(grains=100, realisations=3, pressure=10e3, **prepared):
	"""Realisations of a packed sample, of discs unless dimension=3 is given, that was frozen to full ice saturation at a pressure [Pa].

	>>> samples = talik.studies.creep.frozenSamples(grains=30, realisations=1, porosity=0.19)"""
	samples = rve.listOf(rve.pack(rve.prepare(grains=grains, realisations=realisations, ice=True, **prepared)))
	for sample in samples:
		if not sample.servo(*[-pressure] * sample.dimension):
			raise RuntimeError(f"creep: the sample does not reach an isotropic pressure of {pressure:g} Pa")
		sample.freeze(1)
	return samples
