# SPDX-License-Identifier: GPL-2.0-or-later
"""What moments of ice bonds make of a frozen sample: biaxial tests with and without them.

scripts/calibrate --moments               # table and picture
"""

import dataclasses

import numpy as np

from talik import plots, rve
from talik.studies import calibrate

kinds = {
	"neither": {},
	"moments": {"bondRadiusFactor": 1.0},
	"moments, R_b doubled": {"bondRadiusFactor": 2.0},
	"moments, none in the strength": {"bondRadiusFactor": 1.0, "momentContribution": 0.0},
	"rolling": {"etaRoll": 0.1},
	"moments and rolling": {"bondRadiusFactor": 1.0, "etaRoll": 0.1},
}  # what the contacts of the samples carry: attributes of MomentIceBondMat and RollingIceBondMat


@dataclasses.dataclass(frozen=True)
class MomentTests:
	"""Biaxial tests of frozen samples by what their contacts carry, a list of realisations for each kind.

	>>> talik.studies.moments.MomentTests(100e3, {}).pressure
	100000.0"""

	pressure: float  # [Pa]
	compression: dict  # kind: BiaxialTests

	def draw(self):
		"""Figure: mean deviator over axial strain, a line for each kind, with the range of its samples."""
		fig = plots.figure(7, 4.8)
		axes = fig.subplots()
		for kind, tests in self.compression.items():
			strain = 100 * tests[0].smooth(tests[0].strain)
			deviators = 1e-6 * np.array([test.deviator for test in tests])
			line = axes.plot(strain, deviators.mean(axis=0), label=kind)[0]
			axes.fill_between(strain, deviators.min(axis=0), deviators.max(axis=0), color=line.get_color(), alpha=0.08, lw=0)
		axes.set(xlabel="axial strain [%]", ylabel=f"deviator at {1e-3 * self.pressure:g} kPa [MPa]", ylim=(0, None))
		axes.legend(frameon=False, title="contacts carry", loc="lower center", bbox_to_anchor=(0.5, 1), ncols=3)
		return fig


def _pastPeak(test):
	"""Mean deviator over the second half of a test [Pa]."""
	return test.deviator[len(test.deviator) // 2 :].mean()


def _row(kind, tests):
	young, strain = np.mean([1e-9 * test.elasticity()[0] for test in tests]), np.mean([100 * test.peakStrain for test in tests])
	peaks, lefts = (1e-6 * np.array([value(test) for test in tests]) for value in (lambda test: test.deviator.max(), _pastPeak))
	return f"| {kind} | {young:.3f} | {peaks.mean():.2f} ± {peaks.std():.2f} | {strain:.2f} | {lefts.mean():.2f} ± {lefts.std():.2f} |"


def compare(grains=100, realisations=3, pressure=100e3, strain=0.05, porosity=0.18, which=tuple(kinds), told=print, **prepared):
	"""Biaxial compression of samples at full ice saturation under one pressure, for every one of `which` of the `kinds`. Samples are packed with what their
	contacts carry, those without rolling alike. `told` is given each line of the table as soon as it is known.

	>>> lines = []
	>>> found = talik.studies.moments.compare(30, 1, strain=5e-4, which=("moments",), told=lines.append)
	>>> len(lines)
	2"""
	told("| contacts carry | E [GPa] | peak [MPa] | at strain [%] | second half of the test [MPa] |\n|---|---|---|---|---|")
	compression = {}
	for kind in which:
		samples = rve.prepare(grains=grains, porosity=porosity, pressure=pressure, ice=True, realisations=realisations, **kinds[kind], **prepared)
		compression[kind] = [calibrate.biaxialTest(sample, 1.0, pressure, strain) for sample in rve.pack(samples)]
		told(_row(kind, compression[kind]))
	return MomentTests(pressure, compression)
