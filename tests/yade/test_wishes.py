# SPDX-License-Identifier: GPL-2.0-or-later
"""Stability of a loaded saturated column at every conductivity, and its map."""

import csv

import matplotlib.image
import numpy as np
import pytest
from yade import O

from talik import accuracy, plots


@pytest.fixture(scope="module")
def stability():
	return accuracy.stability((1e-2, 1e-5, 1e-8, 1e-11, 1e-14), (0.3, 0.6, 0.99), steps=1000)


def test_a_loaded_saturated_column_is_stable_at_every_conductivity_and_time_step(stability):
	accuracy.printTable([{name: value for name, value in row.items() if name != "reason"} for row in stability])
	assert len(stability) == 15
	for row in stability:
		assert row["stable"], row
		assert 0 < row["largest kinetic energy over bound [-]"] <= 1
	steps = accuracy.column(stability, "time step [s]").reshape(5, 3)
	assert np.ptp(steps, axis=0).max() < 0.01 * steps.min(), "conductivity must not limit the time step"


def test_a_time_step_far_beyond_the_limit_is_cut_into_stable_ones():
	mpm, bound = accuracy.loadedColumn(1e-8)
	mpm.automaticTimeStep = False
	O.engines = [mpm]
	limit = mpm.stableTimeStep()
	O.dt = 50 * limit
	energies = []
	for _ in range(40):
		O.step()
		energies.append(mpm.balance()["kineticEnergy"] / bound)
	print(f"O.dt = 50 x {limit:.3g} s: largest kinetic energy {max(energies):.3g} of the bound after {mpm.time / limit:.0f} limits of time")
	assert mpm.time == pytest.approx(2000 * limit)
	assert 0 < max(energies) <= 1


def test_table_and_picture_are_written(stability, tmp_path):
	for name, rows, draw in (("map", stability, accuracy.drawStability),):
		accuracy.saveTable(rows, tmp_path / f"{name}.csv")
		with open(tmp_path / f"{name}.csv", newline="") as file:
			read = list(csv.DictReader(file))
		assert list(read[0]) == list(rows[0]) and len(read) == len(rows)
		figure = draw(rows)
		for axes in figure.axes:
			assert "[" in axes.get_xlabel() + axes.get_ylabel(), "axes carry their units"
		picture = matplotlib.image.imread(plots.save(figure, tmp_path / f"{name}.png"))
		print(f"{name}: {len(read)} rows, picture of {picture.shape[1]} x {picture.shape[0]} pixels")
		assert picture[..., :3].std() > 0.02
