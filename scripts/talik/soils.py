# SPDX-License-Identifier: GPL-2.0-or-later
"""How much frozen soils settle when they thaw, with the spread of the tests that say so.

	silt = talik.soils.thaw("fine", frozenDensity=1600, waterContent=0.5)
	print(silt)                                                          # strain over stress, its spread, and where the numbers come from
	ground = GroundMaterial(name="silt", **silt.material())              # thawStrain, compressionIndex and referenceStress
	others = [silt.draw(seed) for seed in range(8)]                      # soils of the same description, as different as tests are

A soil that is known by name, frozen density and water content has no single settlement: tests of such soils differ by some 10 % of strain. So
every number comes with its spread, and `draw` gives soils that differ as much.

"fitted" are 276 tests of the Permafrost Thaw Settlement Dataset (Mohammadi & Hayley, Zenodo 14538524; Earth Syst. Sci. Data 17, 3921, 2025, CC BY 4.0),
by scripts/calibrate --settlement. The spread is that of tests of boreholes that were left out of the fit. "table 4" are means, deciles and standard
deviations by soil group and ice content in that paper, for soils of which no density is known.
"""

import dataclasses
import math

import numpy as np

ofIce = 917.0  # density [kg/m^3]
reference = 1e3  # stress at which the fitted strains begin [Pa]
leastPorosity = 0.02  # that a thawed soil keeps: more strain has no room


@dataclasses.dataclass(frozen=True)
class _Fit:
	"""Strain = constant + ofIndex * index + perDecade * log10(stress/1 kPa) [-], see talik.studies.thawtests.Fitted; spread of held-out tests about it."""

	constant: float
	ofIndex: float
	perDecade: float
	scatter: float  # standard deviation at 1 kPa [-]
	scatterOfDecade: float
	correlation: float  # of both
	tests: int
	grainDensity: float  # mean of the tests [kg/m^3]
	indexes: tuple  # least and largest of the tests
	mostWater: float  # water content of the tests [-]


# As scripts/calibrate --settlement prints them.
_fits = {
	"coarse": _Fit(1.2730, -0.7120, 0.1051, 0.1053, 0.0228, -0.08, 60, 2670.0, (1.23, 1.97), 1.2),
	"fine": _Fit(1.0928, -0.5888, 0.0801, 0.1038, 0.0352, -0.40, 156, 2680.0, (0.86, 2.09), 5.2),
	"peat": _Fit(-0.0537, 0.1248, 0.1998, 0.2073, 0.0864, -0.86, 60, 1515.0, (0.16, 3.15), 24.0),
}
# (group, ice-rich): mean and standard deviation of A_0 [-] and of a_0 [1/Pa]
_table4 = {
	("coarse", True): (0.276, 0.144, 4.2e-7, 1.9e-7),
	("coarse", False): (0.078, 0.052, 5.7e-7, 3.1e-7),
	("fine", True): (0.326, 0.150, 7.6e-7, 4.6e-7),
	("fine", False): (0.046, 0.061, 7.6e-7, 3.3e-7),
	("peat", True): (0.457, 0.109, 3.12e-6, 1.75e-6),
	("peat", False): (0.255, 0.162, 3.88e-6, 1.54e-6),
}


@dataclasses.dataclass(frozen=True)
class ThawSettlement:
	"""Thaw strain of a soil over the vertical effective stress, of the volume frozen, shortening positive [-].

	With a density or a water content strain grows with the logarithm of stress, beyond 1 kPa; without, linearly from no stress on.

	>>> soil = talik.soils.thaw("fine", frozenDensity=1600)
	>>> soil.group
	'fine'"""

	group: str  # coarse, fine or peat
	porosity: float  # frozen, ice included [-]; nan: not known
	start: float  # strain without load (linear) or at 1 kPa, A_0 [-]
	slope: float  # a_0 [1/Pa], or strain a decade of stress [-]
	linear: bool
	scatter: float  # standard deviation of start
	scatterOfSlope: float
	correlation: float
	tests: int
	source: str

	def strain(self, stress):
		"""At a stress, or an array of them [Pa].

		>>> round(talik.soils.thaw("fine", frozenDensity=1600).strain(10e3), 3)
		0.231"""
		stress = np.asarray(stress, dtype=float)
		grown = stress if self.linear else np.log10(np.maximum(stress, reference) / reference)
		strain = np.maximum(0.0, self.start + self.slope * grown)
		return float(strain) if strain.ndim == 0 else strain

	def spread(self, stress):
		"""Standard deviation of the strain of soils of this description at a stress [Pa].

		>>> round(talik.soils.thaw("fine", frozenDensity=1600).spread(10e3), 3)
		0.095"""
		grown = stress if self.linear else math.log10(max(stress, reference) / reference)
		both = 2 * self.correlation * self.scatter * self.scatterOfSlope * grown
		return math.sqrt(max(0.0, self.scatter**2 + (self.scatterOfSlope * grown) ** 2 + both))

	def material(self, porosity=None):
		"""Attributes of GroundMaterial that give this strain: dict.

		porosity  of the frozen ground [-]; None: that of the soil. Needed where the soil has none

		ValueError where the strain at 100 kPa does not leave pores.

		>>> soil = talik.soils.thaw("fine", frozenDensity=1600, waterContent=0.5)
		>>> GroundMaterial(name="silt", **soil.material()).thawStrain > 0.1
		True"""
		porosity = self.porosity if porosity is None else porosity
		if not 0 < porosity < 1:
			raise ValueError(f"soils: the frozen porosity is {porosity}; give porosity=, 0 to 1, or frozenDensity and waterContent to thaw()")
		start = max(0.0, self.start)
		if self.strain(1e5) > porosity - leastPorosity:
			raise ValueError(f"soils: thaw strain at 100 kPa is {self.strain(1e5):.2f}, and the frozen porosity is {porosity:.2f}: ground has no room for it")
		if self.linear:
			return {"thawStrain": start, "compressibility": self.slope}
		begins = reference if self.start >= 0 else reference * 10 ** (-self.start / self.slope)  # below it the soil swells, as tests show: left out
		return {"thawStrain": start, "compressionIndex": self.slope / (1 - porosity), "referenceStress": begins}

	def draw(self, seed):
		"""A soil of this description, by chance: ThawSettlement. Strain and slope have the means, spreads and correlation of the tests, where both are
		positive and leave pores; seed None: the soil itself.

		>>> talik.soils.thaw("fine", frozenDensity=1600).draw(1).slope > 0
		True"""
		if seed is None:
			return self
		random = np.random.default_rng(seed)
		most = (1 if math.isnan(self.porosity) else self.porosity) - leastPorosity
		for _ in range(1000):
			first, second = random.standard_normal(2)
			second = self.correlation * first + math.sqrt(1 - self.correlation**2) * second
			soil = dataclasses.replace(self, start=self.start + self.scatter * first, slope=self.slope + self.scatterOfSlope * second)
			if soil.slope > 0 and soil.strain(1e5) > 0 and soil.strain(1e5) < most:
				return soil
		raise ValueError("soils: no soil of this description leaves pores on thaw; look at its density and water content")

	def __str__(self):
		stresses = (1e3, 1e4, 1e5)
		strains = ", ".join(f"{100 * self.strain(s):.1f} ± {100 * self.spread(s):.1f} % at {s / 1e3:g} kPa" for s in stresses)
		return f"{self.group} soil, thaw strain {strains} ({self.tests or 'number not given'} tests; {self.source})"


def thaw(group, frozenDensity=None, waterContent=None, iceRich=None, grainDensity=None):
	"""Settlement of a soil on thaw by what is known of it: ThawSettlement.

	group          coarse, fine or peat
	frozenDensity  bulk density of the frozen ground, excess ice included [kg/m^3]
	waterContent   mass of ice and water over that of the grains [-]: 0.3 is 30 %. Where one of both is missing it follows from the other: pores
				   full of ice
	iceRich        True or False, for a soil of which neither is known: ice beyond what the thawed soil holds, or not
	grainDensity   [kg/m^3]; None: mean of the tests of the group

	ValueError where nothing is known but the group, or where the description lies outside of the tests.

	>>> print(talik.soils.thaw("coarse", iceRich=True))
	coarse soil, thaw strain 27.6 ± 14.4 % at 1 kPa, 28.0 ± 14.4 % at 10 kPa, 31.8 ± 14.5 % at 100 kPa (number not given tests; table 4)"""
	if group not in _fits:
		raise ValueError(f"soils: the group is {group!r}; choose {', '.join(_fits)}")
	fit = _fits[group]
	grains = grainDensity or fit.grainDensity
	if frozenDensity is None and waterContent is None:
		if iceRich is None:
			raise ValueError("soils: give frozenDensity or waterContent, or, where neither is known, iceRich=True or False")
		start, scatter, slope, scatterOfSlope = _table4[group, bool(iceRich)]
		return ThawSettlement(group, math.nan, start, slope, True, scatter, scatterOfSlope, 0.0, 0, "table 4")
	if frozenDensity is None:
		frozenDensity = grains * (1 + waterContent) / (1 + waterContent * grains / ofIce)
	if waterContent is None:
		if not ofIce < frozenDensity < grains:
			raise ValueError(
				f"soils: the frozen density is {frozenDensity:g} kg/m^3; pores full of ice give one between that of ice, {ofIce:g}, and of the grains, {grains:g}"
			)
		waterContent = (grains - frozenDensity) / (grains * (frozenDensity / ofIce - 1))
	if not 0 < waterContent <= fit.mostWater:
		most = f"up to {fit.mostWater:g} in the tests of {group} soils"
		raise ValueError(f"soils: the water content is {waterContent:g}; it is a ratio of masses, 0.3 for 30 %, {most}")
	porosity = 1 - frozenDensity / ((1 + waterContent) * grains)
	if not 0 < porosity < 1:
		raise ValueError(f"soils: a frozen density of {frozenDensity:g} kg/m^3 and a water content of {waterContent:g} leave no pores; look at the units")
	index = math.log(waterContent) if group == "peat" else 1e-3 * frozenDensity
	low, high = fit.indexes
	if not low <= index <= high:
		raise ValueError(
			f"soils: {_nameOfIndex(group)} is {_ofIndex(group, index):.3g}; the tests of {group} soils have {_ofIndex(group, low):.3g} to {_ofIndex(group, high):.3g}"
		)
	start = fit.constant + fit.ofIndex * index
	return ThawSettlement(group, porosity, start, fit.perDecade, False, fit.scatter, fit.scatterOfDecade, fit.correlation, fit.tests, "fitted")


def _nameOfIndex(group):
	return "the water content" if group == "peat" else "the frozen density"


def _ofIndex(group, index):
	return math.exp(index) if group == "peat" else 1e3 * index
