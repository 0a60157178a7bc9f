# SPDX-License-Identifier: GPL-2.0-or-later
"""Strength of frozen samples against the trends of the laboratory: rate, temperature, confinement, ice saturation."""

import math

import numpy as np

from talik import rve
from talik.studies import calibrate


def test_a_frozen_sample_grows_stronger_with_rate_and_with_cold_and_its_tension_not_with_rate_slow(sampleCache):
	packed = rve.pack(rve.prepare(grains=100, ice=True, cache=sampleCache))
	byRate, byCold = calibrate.strengthTable(packed)
	rates, fast = np.array(calibrate.rates), np.array(calibrate.rates) >= 1e-4
	exponent = np.polyfit(np.log(rates[~fast]), np.log(byRate[~fast]), 1)[0]
	growth, span = byCold[-1] / byCold[0], byRate[-1] / byRate[fast][0]
	print(
		f"\n1e-4 to 1 1/s: compression {span[0]:.2f} fold, tension {span[1]:.2f} fold (Haynes et al. 1975: tenfold, hardly); below, exponents "
		f"{exponent[0]:.3f} and {exponent[1]:.3f} of 0.228 of the bonds; 0 to -56.7 degC: {growth[0]:.2f} and {growth[1]:.2f} fold (tenfold, half an order)"
	)
	assert (np.diff(byRate[:, 0]) > -0.02 * byRate[1:, 0]).all() and (np.diff(byCold[:, 0]) > -0.02 * byCold[1:, 0]).all()
	assert span[0] > 1.5 and span[1] < 1.02 and 0.05 < exponent[0] < 0.228
	assert growth[0] > 2 and 2 < growth[1] < 4


def test_confinement_strengthens_frozen_samples_and_cohesion_follows_the_ice_while_friction_stays_slow(sampleCache):
	"""Alkire & Andersland on frozen sand: cohesion follows ice saturation (97 and 55 %), friction is that of the unfrozen sand."""
	samples = rve.pack(rve.prepare(grains=100, realisations=3, ice=True, cache=sampleCache))
	pressures, lines = np.array((50e3, 200e3, 800e3)), {}
	for ice in (0.0, 0.55, 0.97):
		tests = [[calibrate.biaxialTest(sample, ice, pressure, 0.03) for pressure in pressures] for sample in samples]
		mean, shear = np.array([[test.peak for test in row] for row in tests]).mean(axis=0).T
		assert (np.diff(shear) > 0).all(), "strength rises with confinement"
		sine, intercept = np.polyfit(mean, shear, 1)
		lines[ice] = math.degrees(math.asin(sine)), intercept / math.cos(math.asin(sine))
		print(f"\nS_i {ice:g}: friction angle {lines[ice][0]:.1f} deg, cohesion {1e-3 * lines[ice][1]:.0f} kPa", end="")
		if ice == 0:
			# contacts are soft, so that the envelope of thawed samples is curved: their friction is that at the least pressure
			thawed = math.degrees(math.asin(shear[0] / mean[0]))
	print(f"\nfriction angle of thawed samples at {1e-3 * pressures[0]:g} kPa {thawed:.1f} deg")
	assert lines[0.97][1] > 1.5 * lines[0.55][1] > 3 * lines[0.0][1]
	assert abs(lines[0.97][0] - lines[0.55][0]) < 5
	assert max(abs(lines[ice][0] - thawed) for ice in (0.55, 0.97)) < 5
