# SPDX-License-Identifier: GPL-2.0-or-later
"""Strength and stiffness of samples along a freezing curve: Haynes & Karalius 1977, abstract (frozen silt, 0 to -56.7 degC: compression up to tenfold,
tension by half an order of magnitude)."""

import math

import numpy as np
import pytest
from yade import wrapper

from talik.studies import cold


def test_ice_saturations_are_those_of_the_closed_form_of_the_freezing_curve():
	"""S_i = (1 - S_r) (1 - exp(-(T/W)^2))."""
	temperatures, width, residual = np.array([1, 0, -0.1, -0.5, -2, -20]), 0.7, 0.1
	found = cold.iceSaturations(temperatures, wrapper.FreezingCurve(curve="gauss", width=width, residualSaturation=residual))
	wanted = (1 - residual) * (1 - np.exp(-((np.minimum(temperatures, 0) / width) ** 2)))
	print("\n" + "; ".join(f"{t:g} degC: {s:.6f}, closed form {w:.6f}" for t, s, w in zip(temperatures, found, wanted)))
	assert found == pytest.approx(wanted, abs=1e-12)


def test_tension_grows_with_cold_as_measured_on_silt_and_stiffness_with_the_ice_alone(sampleCache):
	"""Tension grew by half an order of magnitude over 56.7 K: by 10^(0.5 * 46.7/56.7) from -10 degC. Polycrystalline ice stiffens by 0.14 % a kelvin."""
	print()
	found = cold.table((0, -0.5, -10, -56.7), grains=60, realisations=1, strain=0.02, cache=sampleCache)
	wanted, ice = 10 ** (0.5 * 46.7 / 56.7), math.exp(0.0014 * 46.7)
	grew, stiffened = found.growth(found.tension, -10), found.growth(found.young, -10)
	print(f"from -10 to -56.7 degC: tension {grew:.2f} fold, measured {wanted:.2f}; E {stiffened:.3f} fold, of ice {ice:.3f}")
	assert grew == pytest.approx(wanted, rel=0.1)
	assert 1 <= stiffened < ice * 1.02
	assert (np.diff(found.young.mean(axis=1)) > 0).all() and (np.diff(found.compression.mean(axis=1)) > 0).all()
	assert found.tension[0].max() == 0 and found.stiffening[0] == 1


def test_the_command_writes_table_and_picture_slow(calibrateCommand):
	assert len(calibrateCommand("temperature", "--grains", "40", "--realisations", "1")) == 2 + len(cold.temperatures)
