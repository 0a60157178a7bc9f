# SPDX-License-Identifier: GPL-2.0-or-later
"""Growth of a frozen sample's strength with the strain rate, by what its contacts carry and by its bonds' shear over their tensile strength.

	scripts/calibrate --growth                # table and picture

Bonds follow IceStrength: shear strength grows with the rate, tensile strength does not. In a sample under compression bonds break in tension, too, so that
its strength grows less than that of its bonds in shear, until tension alone decides. How far it gets is the largest ratio of compression to
tension that the sample can have. Compression is unconfined, as in the tests of Haynes, Karalius & Kalafut (1975).
"""

import dataclasses

import numpy as np
from yade import wrapper

from talik import plots, rve
from talik.studies import calibrate

slow, fast, temperature = 1.2e-4, 2.9, -10.0  # [1/s], [1/s], [degC]: tests of Haynes, Karalius & Kalafut 1975
freezingPressure = 10e3  # [Pa]


@dataclasses.dataclass(frozen=True)
class Kind:
	"""A sample and its bonds.

	>>> talik.studies.growth.kinds["IceStrength's defaults"].shearOverTensile
	1.0"""

	prepared: dict  # what its contacts carry: keyword arguments of talik.rve.prepare
	shearOverTensile: float = 1.0  # strength of the bonds at the slow rate, over that of the material [-]
	exponent: float = 0.228  # IceStrength.shearRateExponent [-]


stiff = dict(bondRadiusFactor=2.0, momentContribution=0.0)
kinds = {
	"IceStrength's defaults": Kind({}),
	"shear 0.4 of tensile": Kind({}, 0.4),
	"0.4, rolling": Kind(dict(etaRoll=0.2), 0.4),
	"0.4, moments": Kind(stiff, 0.4),
	"0.4, moments and rolling": Kind(dict(stiff, etaRoll=0.2), 0.4),
	"0.4, moments and rolling, n 0.3": Kind(dict(stiff, etaRoll=0.2), 0.4, 0.3),
}


@dataclasses.dataclass(frozen=True)
class Growth:
	"""Strengths [Pa] of the realisations of a kind at the slow and the fast rate, arrays (rate, realisation).

	>>> growth = talik.studies.growth.Growth(np.array([[1e6], [8e6]]), np.array([[4e5], [5e5]]))
	>>> float(growth.ofCompression)
	8.0"""

	compression: np.ndarray
	tension: np.ndarray

	@property
	def ofCompression(self):
		"""Of the mean [-]."""
		return self.compression[1].mean() / self.compression[0].mean()

	@property
	def ofTension(self):
		return self.tension[1].mean() / self.tension[0].mean()

	def row(self, name):
		"""A line of a Markdown table: strengths [MPa] in compression and tension, and their ratios over the rates."""
		cells = [f"{1e-6 * values.mean():.2f} ± {1e-6 * values.std():.2f}" for values in self.compression] + [f"{self.ofCompression:.1f}"]
		cells += [f"{1e-6 * values.mean():.2f}" for values in self.tension] + [f"{self.ofTension:.2f}"]
		return f"| {name} | {' | '.join(cells)} |"


def strengths(sample, kind, rate, strain=0.08):
	"""(compression, tension) [Pa] of an ice-free RveSample frozen to full ice saturation, without confinement.

	>>> compression, tension = talik.studies.growth.strengths(packed, talik.studies.growth.kinds["shear 0.4 of tensile"], rate=1e-4, strain=4e-4)"""
	law, tested = wrapper.IceStrength(shearRateExponent=kind.exponent, referenceRate=slow), sample.copy()
	tensile, shear = law.factors(temperature, rate)
	tested.tensileStrengthFactor, tested.shearStrengthFactor = tensile, shear * kind.shearOverTensile
	compression = calibrate.biaxialTest(tested, 1.0, freezingPressure, strain, lateral=0.0)
	return compression.deviator.max(), calibrate.extensionTest(tested, 1.0, freezingPressure, strain / 8).tension


def table(grains=100, realisations=3, strain=0.08, which=tuple(kinds), told=print, porosity=0.18, **prepared):
	"""{kind: Growth} for every one of `which` of the `kinds`. `told` is given each line of the table as soon as it is known.

	>>> lines = []
	>>> found = talik.studies.growth.table(30, 1, strain=4e-3, which=("IceStrength's defaults",), told=lines.append, porosity=0.19)
	>>> len(lines)
	2"""
	told(
		f"| bonds and contacts | compression at 1.2e-4 1/s [MPa] | at {fast:g} 1/s [MPa] | fold | tension at 1.2e-4 1/s [MPa] | at {fast:g} 1/s [MPa] | fold |"
		"\n|---|---|---|---|---|---|---|"
	)
	found = {}
	for name in which:
		samples = rve.listOf(
			rve.pack(rve.prepare(grains=grains, porosity=porosity, pressure=100e3, ice=True, realisations=realisations, **kinds[name].prepared, **prepared))
		)
		measured = np.array([[strengths(sample, kinds[name], rate, strain) for sample in samples] for rate in (slow, fast)])
		found[name] = Growth(measured[:, :, 0], measured[:, :, 1])
		told(found[name].row(name))
	return found


def draw(found):
	"""Figure of a table: strengths at both rates, and tenfold growth.

	>>> figure = talik.studies.growth.draw({"one": talik.studies.growth.Growth(np.array([[1e6], [8e6]]), np.array([[4e5], [5e5]]))})"""
	fig = plots.figure(8, 4.6)
	axes = fig.subplots()
	for place, growth in enumerate(found.values()):
		for values, colour, label in ((growth.compression, "black", "compression, unconfined"), (growth.tension, "red", "tension")):
			axes.plot([place, place + 0.5], 1e-6 * values.mean(axis=1), "o-", color=colour, label=None if place else label)
		axes.plot([place, place + 0.5], 1e-6 * growth.compression[0].mean() * np.array([1, 10]), "--", color="crimson", label=None if place else "tenfold")
	axes.set_xticks(np.arange(len(found)) + 0.25, [name.replace(", ", ",\n").replace("'s ", "'s\n") for name in found], fontsize=8)
	axes.set(yscale="log", ylabel=f"strength at 1.2·10$^{{-4}}$ and {fast:g} 1/s [MPa]")
	axes.yaxis.set_major_formatter("{x:g}")
	axes.legend(frameon=False, loc="lower center", bbox_to_anchor=(0.5, 1), ncols=3)
	return fig
