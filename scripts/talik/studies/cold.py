# SPDX-License-Identifier: GPL-2.0-or-later
"""Strength and stiffness of samples that freeze along a soil's freezing curve, over temperature, beside what was measured.

	scripts/calibrate --temperature           # table and picture

At each temperature the freezing curve gives the ice saturation, IceStrength the strength of the bonds and the stiffness of their ice. Each sample freezes
at an isotropic pressure, is compressed under it, and stretched with the lateral stress removed.
"""

import dataclasses

import numpy as np
from yade import wrapper

from talik import plots, rve
from talik.studies import calibrate

temperatures = (0.0, -0.25, -0.5, -1.0, -2.0, -5.0, -10.0, -20.0, -40.0, -56.7)  # [degC]
rate = 1e-4  # [1/s in physical time]
stiffnessOfIce = 0.0014  # [1/K] Gammon, Kiefte & Clouter 1980; Gammon et al. 1983
# Haynes & Karalius 1977, abstract: frozen Fairbanks silt, 0 to -56.7 degC, compression up to an order of magnitude, tension half an order
measuredGrowth, measuredSpan = {"compression": 10.0, "tension": 10**0.5}, (0.0, -56.7)
# CRREL Special Report 96-19 (1996), conclusions: resilient modulus of base and subgrade soils at -2 degC and colder over that of the thawed soil
measuredStiffening, stiffenedBelow = (1e2, 1e3), -2.0


def iceSaturations(temperatures, curve=None):
	"""Ice saturation [-] at temperatures [degC] along a FreezingCurve; default its defaults.

	>>> saturations = talik.studies.cold.iceSaturations([0, -10])
	>>> [round(float(s), 2) for s in saturations]
	[0.0, 0.95]"""
	number = len(temperatures)
	ground = wrapper.MpmEngine(
		gridSpacing=1.0,
		lower=(0, 0),
		upper=(number, 1),
		heat=wrapper.HeatTransfer(),
		freezing=curve or wrapper.FreezingCurve(),
		skeleton=wrapper.ElasticSkeleton(),
	)
	places = np.column_stack([np.arange(number) + 0.5, np.full(number, 0.5)])
	ground.addPoints(position=places, volume=1.0, porosity=0.4, temperature=np.array(temperatures, dtype=float))
	ground.initialise()
	return np.array(ground.field("iceSaturation"))


@dataclasses.dataclass(frozen=True)
class Cold:
	"""What samples give over temperature: arrays, the last three (temperature, realisation) [Pa].

	>>> cold = talik.studies.cold.table(temperatures=(0, -10), grains=30, realisations=1, strain=5e-4, told=lambda line: None)
	>>> cold.young.shape
	(2, 1)"""

	temperature: np.ndarray  # [degC]
	iceSaturation: np.ndarray  # [-]
	young: np.ndarray
	compression: np.ndarray  # largest deviator
	tension: np.ndarray

	@property
	def stiffening(self):
		"""Young's modulus over that of the same samples thawed, mean over the realisations [-]; NaN without a thawed row."""
		thawed = self.iceSaturation == 0
		return self.young.mean(axis=1) / (self.young[thawed].mean() if thawed.any() else np.nan)

	def growth(self, strength, warm):
		"""Mean `strength` at the coldest temperature over that at `warm` [degC]."""
		means = strength.mean(axis=1)
		return float(means[np.argmin(self.temperature)] / means[list(self.temperature).index(warm)])

	def draw(self):
		"""Figure: strength over temperature with the growth that was measured, stiffness over that of thawed ground with the range that was measured."""
		fig = plots.figure(10, 4.2)
		ofStrength, ofStiffness = fig.subplots(1, 2)
		frozen, cold = self.iceSaturation > 0, np.linspace(*measuredSpan, 50)
		for name, values, colour, mark in (("compression", self.compression, "black", "o-"), ("tension", self.tension, "red", "s-")):
			means = 1e-6 * values.mean(axis=1)
			spread = 1e-6 * np.array([calibrate._deviation(row) for row in values])
			label = "compression at 100 kPa" if name == "compression" else name
			ofStrength.errorbar(self.temperature[frozen], means[frozen], spread[frozen], fmt=mark, color=colour, markersize=4, capsize=2, label=label)
			k = int(np.argmin(np.abs(self.temperature + 10)))
			through = means[k] * measuredGrowth[name] ** ((cold - self.temperature[k]) / (measuredSpan[1] - measuredSpan[0]))
			label = f"measured growth: {measuredGrowth[name]:.2g} fold (Haynes & Karalius 1977)"
			ofStrength.plot(cold, through, "--", color=colour, linewidth=0.9, label=label)
		ofStrength.set(xlabel="temperature [°C]", ylabel="strength [MPa]", yscale="log", title="dashed: through the sample at -10 °C")
		ofStrength.legend(fontsize=8, frameon=False)
		low, high = measuredStiffening
		span = [min(self.temperature.min(), stiffenedBelow), stiffenedBelow]
		ofStiffness.fill_between(span, low, high, color="0.88", label="measured, road soils at -2 °C and colder\n(CRREL SR 96-19, 1996)")
		ofStiffness.plot(self.temperature, self.stiffening, "o-", color="black", markersize=4, label="samples")
		ofStiffness.set(xlabel="temperature [°C]", ylabel="E over that of thawed ground [-]", yscale="log")
		ofStiffness.legend(fontsize=8, frameon=False, loc="center left")
		return fig


def table(temperatures=temperatures, grains=100, realisations=3, curve=None, law=None, pressure=100e3, strain=0.03, told=print, **prepared):
	"""Cold of samples of discs; `told` is given each line of the table as soon as it is known.

	curve  FreezingCurve; default its defaults
	law    IceStrength; default its defaults, with the stiffness of ice over temperature

	>>> lines = []
	>>> cold = talik.studies.cold.table((0, -10), grains=30, realisations=1, strain=5e-4, told=lines.append)
	>>> len(lines)
	3"""
	law = law or wrapper.IceStrength(stiffnessCold=stiffnessOfIce)
	samples = rve.pack(rve.prepare(grains=grains, realisations=realisations, ice=True, **prepared))
	saturations = iceSaturations(temperatures, curve)
	told("| temperature [°C] | ice saturation | E [MPa] | E over thawed | compression [MPa] | tension [MPa] |\n|---|---|---|---|---|---|")
	rows, thawed = [], None
	for temperature, saturation in zip(temperatures, saturations):
		rows.append([_tested(sample, law, temperature, saturation, pressure, strain) for sample in rve.listOf(samples)])
		means = np.mean(rows[-1], axis=0)
		spread = [calibrate._deviation(values) for values in np.transpose(rows[-1])]
		thawed = means[0] if saturation == 0 else thawed
		cells = [f"{1e-6 * mean:.2f} ± {1e-6 * one:.2f}" for mean, one in zip(means[1:], spread[1:])]
		over = f"{means[0] / thawed:.1f}" if thawed else "–"
		told(f"| {temperature:g} | {saturation:.2f} | {1e-6 * means[0]:.0f} ± {1e-6 * spread[0]:.0f} | {over} | {' | '.join(cells)} |")
	values = np.moveaxis(np.array(rows), 2, 0)
	return Cold(np.array(temperatures, dtype=float), saturations, *values)


def _tested(sample, law, temperature, saturation, pressure, strain):
	"""(E, largest deviator in compression, tension) [Pa]."""
	tested = sample.copy()
	tested.tensileStrengthFactor, tested.shearStrengthFactor = law.factors(temperature, rate)
	tested.iceStiffnessFactor = law.stiffnessFactor(temperature)
	compression = calibrate.biaxialTest(tested, saturation, pressure, strain)
	return compression.elasticity()[0], compression.deviator.max(), calibrate.tensileTest(tested, saturation)
