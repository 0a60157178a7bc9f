# SPDX-License-Identifier: GPL-2.0-or-later
"""Thaw of a column of saturated ground from its surface by finite volumes: what the slump's front is measured against.

Shares nothing with the code under test: cells of equal size, explicit steps of enthalpy, temperature from a table of H(T)."""

import numpy as np

solidDensity, iceDensity, liquidDensity = 2650.0, 910.0, 1000.0  # [kg/m3], Yu & Zhao section 3, as all that follows
solidHeat, iceHeat, liquidHeat = 800.0, 2060.0, 4200.0  # [J/(kg K)]
solidConductivity, iceConductivity, liquidConductivity = 1.0, 2.2, 0.6  # [W/(m K)], arithmetic mean
latentHeat = 334e3  # [J/kg]


class ThawColumn:
	"""depth [m], cells; surface is a function (time) -> temperature [degC]; the base is insulated. Water stays where it is.

	width, residual  of the gauss freezing curve S_l = S_r + (1-S_r) exp(-(T/W)^2)
	timeScale        f_T"""

	def __init__(self, depth, cells, surface, initial=-5.0, porosity=0.4, width=0.5, residual=0.05, timeScale=8.64e5):
		self.size, self.surface, self.timeScale, self.time = depth / cells, surface, timeScale, 0.0
		self.temperatures = np.unique(np.concatenate([np.linspace(-60, 60, 4001), np.linspace(-4 * width, 0, 20001)]))
		self.liquid = self._liquidSaturation(self.temperatures, width, residual)
		self.initialLiquid = self._liquidSaturation(initial, width, residual)
		water = porosity * (iceDensity * (1 - self.initialLiquid) + liquidDensity * self.initialLiquid)
		ice = porosity * iceDensity * (1 - self.liquid)
		grains = (1 - porosity) * solidDensity
		capacity = grains * solidHeat + ice * iceHeat + (water - ice) * liquidHeat
		self.enthalpies = capacity * self.temperatures + (water - ice) * latentHeat
		pores = self.liquid * liquidConductivity + (1 - self.liquid) * iceConductivity
		self.conductivities = (1 - porosity) * solidConductivity + porosity * pores
		self.enthalpy = np.full(cells, np.interp(initial, self.temperatures, self.enthalpies))
		self.longestStep = 0.4 * self.size**2 * capacity.min() / (self.conductivities.max() * timeScale)

	def march(self, time):
		"""Advances to an instant [s]."""
		steps = int(np.ceil((time - self.time) / self.longestStep))
		dt = (time - self.time) / max(steps, 1)
		for k in range(steps):
			temperature = np.interp(self.enthalpy, self.enthalpies, self.temperatures)
			kappa = np.interp(temperature, self.temperatures, self.conductivities)
			flux = np.zeros(len(temperature) + 1)  # downwards
			between = 2 * kappa[1:] * kappa[:-1] / (kappa[1:] + kappa[:-1])
			flux[1:-1] = between * (temperature[:-1] - temperature[1:]) / self.size
			flux[0] = kappa[0] * (self.surface(self.time + (k + 0.5) * dt) - temperature[0]) / (0.5 * self.size)
			self.enthalpy += dt * self.timeScale / self.size * (flux[:-1] - flux[1:])
		self.time = time

	def front(self):
		"""Thawed depth [m]: volume per area whose ice has become water."""
		temperature = np.interp(self.enthalpy, self.enthalpies, self.temperatures)
		liquid = np.interp(temperature, self.temperatures, self.liquid)
		return self.size * np.sum((liquid - self.initialLiquid) / (1 - self.initialLiquid))

	@staticmethod
	def _liquidSaturation(temperature, width, residual):
		return residual + (1 - residual) * np.exp(-((np.minimum(temperature, 0) / width) ** 2))
