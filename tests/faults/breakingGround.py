# SPDX-License-Identifier: GPL-2.0-or-later
"""A block of frozen, wet ground that is sheared and warmed from above so fast that bonds break and melt in every few steps."""

import numpy as np
from yade import O, wrapper

import talik


def breakingGround(sample, spacing=0.5, **ofSkeleton):
	mpm = wrapper.MpmEngine(
		gridSpacing=spacing,
		lower=(-1, 0),
		upper=(2, 2),
		gravity=(0, -9.81),
		damping=0.1,
		energyLedger=True,
		skeleton=wrapper.RveSkeleton(**{"samples": [sample], "strainTolerance": 2e-5, **ofSkeleton}),
		heat=wrapper.HeatTransfer(thermalTimeScale=1e6),
		freezing=wrapper.FreezingCurve(),
		water=wrapper.PoreWater(),
		boundaries=[wrapper.FixedBoundary(region="bottom"), wrapper.SurfaceTemperature(region="surface", times=[0, 5e3], values=[-1, 15])],
	)
	position, volume = talik.geometry.fillPolygon([(0, 0), (1, 0), (1, 1), (0, 1)], spacing)
	mpm.addPoints(position=position, volume=volume, porosity=0.4, temperature=-1.0, velocity=np.stack([3 * position[:, 1], 0 * position[:, 1]], axis=1))
	O.engines = [mpm]
	return mpm


def run(steps):
	talik._talik.runSerially(steps)


def stateOf(mpm):
	"""Everything that can be asked of a ground: fields, measures, balances, samples, time."""
	state = {name: np.array(mpm.field(name)) for name in mpm.fieldNames()}
	state.update({f"balance {name}": np.array(value) for name, value in mpm.balance().items()})
	if isinstance(mpm.skeleton, wrapper.RveSkeleton):
		counters = mpm.skeleton.cost()
		state.update({f"counter {name}": np.array(counters[name]) for name in ("calls", "steps", "distinctStates")})
		if counters["form"] == "packed":
			for point in range(mpm.pointCount):
				state[f"sample {point}"] = np.frombuffer(mpm.skeleton.sample(point).stateBytes, dtype=np.uint8).astype(float)
	state["scene"] = np.array([O.time, O.iter, O.dt])
	return state


def largestDifference(a, b):
	"""Largest difference over all entries; infinite if they have other shapes, or NaN in other places."""
	assert set(a) == set(b)
	largest = 0.0
	for name in a:
		if a[name].shape != b[name].shape or (np.isnan(a[name]) != np.isnan(b[name])).any():
			return np.inf
		here = np.abs(np.nan_to_num(a[name]) - np.nan_to_num(b[name])).max(initial=0)
		if here > 0:
			print(f"{name} differs by {here}")
		largest = max(largest, here)
	return largest
