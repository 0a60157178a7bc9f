# SPDX-License-Identifier: GPL-2.0-or-later
"""Samples as benchmarks drive them: steps under a velocity gradient, and the portable path."""

import pytest
from fixtures import sixtyWithoutIce
from yade import Matrix3

import talik
from talik import rve

shear = Matrix3(2e-5, 1e-5, 0, 0, -2e-5, 0, 0, 0, 0)


@pytest.fixture(scope="module")
def sample(sampleCache):
	return rve.pack(rve.prepare(**sixtyWithoutIce, cache=sampleCache))


def test_steps_under_a_velocity_gradient_move_the_cell_one_step_late_as_in_yade(sample):
	moved = sample.copy()
	moved.advance(shear * (1 / moved.dt), 11)
	expected = Matrix3.Identity
	for _ in range(10):
		expected = expected + shear * expected
	error = max(abs(moved.trsf[i, j] - expected[i, j]) for i in range(2) for j in range(2))
	print(f"deformation after 11 steps against 10 steps of the gradient: {error:.1e}")
	assert error < 1e-15


def test_portable_path_walks_the_same_path(sample):
	fast, portable = sample.copy(), sample.copy()
	fast.advance(shear * (1 / fast.dt), 100)
	talik.RveSample.usePortablePath(True)
	try:
		assert portable.path == "portable"
		portable.advance(shear * (1 / portable.dt), 100)
	finally:
		talik.RveSample.usePortablePath(False)
	difference = max(abs(a - b) for a, b in zip(fast.stress, portable.stress)) / abs(fast.stress[0])
	print(f"stress on the path {fast.path} against the portable one after 100 steps: {difference:.1e} of the mean stress")
	assert difference < 1e-9
