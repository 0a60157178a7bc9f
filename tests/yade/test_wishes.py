# SPDX-License-Identifier: GPL-2.0-or-later
"""Accuracy that can be bought with computing time, and stability at every conductivity: reduced runs of scripts/accuracy."""

import csv

import matplotlib.image
import numpy as np
import pytest
from yade import O

from talik import accuracy, plots


@pytest.fixture(scope="module")
def front():
	return accuracy.frontError((0.1, 0.05, 0.025, 0.0125))


@pytest.fixture(scope="module")
def stability():
	return accuracy.stability((1e-2, 1e-5, 1e-8, 1e-11, 1e-14), (0.3, 0.6, 0.99), steps=1000)


def test_neumann_front_is_the_published_one_of_the_papers_soil():
	rate = accuracy.neumannFront(10.0, -5.0)
	print(f"X/sqrt(t) = {rate:.6e} m/s^0.5, reference 3.154424e-4")
	assert rate == pytest.approx(3.154424e-4, rel=1e-6)


def test_error_of_the_thaw_front_falls_with_computing_time_and_is_below_one_per_cent_from_5_cm_on(front):
	accuracy.printTable(front)
	error = accuracy.column(front, "error [-]")
	order = np.log(error[1] / error[-1]) / np.log(front[1]["spacing [m]"] / front[-1]["spacing [m]"])
	print(f"observed order {order:.2f}")
	assert np.all(error[1:] < 0.01) and np.all(np.diff(error) < 0)
	assert order > 0.7
	assert np.all(np.diff(accuracy.column(front, "wall time [s]")) > 0)


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


def test_tables_and_pictures_are_written(front, stability, tmp_path):
	for name, rows, draw in (("front", front, accuracy.drawFrontError), ("map", stability, accuracy.drawStability)):
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
