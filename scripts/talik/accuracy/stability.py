# SPDX-License-Identifier: GPL-2.0-or-later
"""Which time steps are stable: a loaded saturated column over hydraulic conductivity and time step."""

import math

import numpy as np
from matplotlib.colors import LogNorm
from yade import O, wrapper

import talik
from talik import plots
from talik.accuracy.report import column

porosity = 0.4


def stability(conductivities=tuple(10.0**-power for power in range(2, 15)), fractions=(0.3, 0.5, 0.7, 0.9, 0.99), steps=2000):
	"""Rows of conductivity k [m/s], time step over h/(c+|v|) [-], kinetic energy over its bound (largest; in the last quarter), stable.

	A saturated elastic column, undamped and drained at its top, is loaded in one step. The load can bring no more kinetic energy
	than the drained column would have when it swings about its new equilibrium: that is the bound."""
	return [_stabilityRow(conductivity, fraction, steps) for conductivity in conductivities for fraction in fractions]


def _stabilityRow(conductivity, fraction, steps):
	O.reset()
	mpm, bound = loadedColumn(conductivity, fraction)
	O.engines = [mpm]
	energies, reason = [], ""
	try:
		for step in range(steps):
			O.step()
			energies.append(mpm.balance()["kineticEnergy"] / bound)
	except (RuntimeError, ValueError) as error:
		reason = str(error)
	stable = not reason and bool(np.all(np.isfinite(energies)) and max(energies) <= 1)
	return {
		"conductivity [m/s]": conductivity,
		"step over h/(c+|v|) [-]": fraction,
		"time step [s]": O.dt,
		"largest kinetic energy over bound [-]": max(energies, default=math.nan),
		"late kinetic energy over bound [-]": max(energies[-len(energies) // 4 :], default=math.nan),
		"stable": stable,
		"reason": reason,
	}


def loadedColumn(conductivity, fraction=0.4, spacing=0.1, height=1.0, load=10e3, modulus=10e6):
	"""MpmEngine of the column and the bound of its kinetic energy [J/m]."""
	mpm = wrapper.MpmEngine(
		gridSpacing=spacing,
		lower=(0, 0),
		upper=(2 * spacing, height + 2 * spacing),
		skeleton=wrapper.ElasticSkeleton(young=modulus, poisson=0),
		water=wrapper.PoreWater(conductivity=conductivity),
		waveFraction=fraction,
		boundaries=[wrapper.RollerBoundary(region=side) for side in ("left", "right", "bottom")]
		+ [wrapper.DrainedBoundary(region="surface"), wrapper.SurfaceLoad(region="surface", pressure=load)],
	)
	talik.geometry.fill(mpm, talik.geometry.rectangle(0, 0, 2 * spacing, height), porosity=porosity)
	return mpm, load**2 * height * 2 * spacing / (2 * modulus)


def drawStability(rows):
	"""Map of the kinetic energy left in the last quarter of the steps; unstable cells are crossed."""
	conductivity = np.unique(column(rows, "conductivity [m/s]"))
	fraction = np.unique(column(rows, "step over h/(c+|v|) [-]"))
	energy = np.full((len(fraction), len(conductivity)), np.nan)
	fig = plots.figure(9, 4)
	axes = fig.subplots()
	for row in rows:
		i = np.searchsorted(fraction, row["step over h/(c+|v|) [-]"])
		j = np.searchsorted(conductivity, row["conductivity [m/s]"])
		energy[i, j] = max(row["late kinetic energy over bound [-]"], 1e-12)
		if not row["stable"]:
			axes.plot(j, i, "x", color="crimson", markersize=12)
	scale = LogNorm(min(np.nanmin(energy), 1e-3), max(np.nanmax(energy), 1.0))
	image = axes.imshow(energy, origin="lower", aspect="auto", cmap="viridis", norm=scale)
	fig.colorbar(image, ax=axes, label="kinetic energy late in the run\nover what the load can bring [-]")
	axes.set_xticks(range(len(conductivity)), [f"$10^{{{round(math.log10(k))}}}$" for k in conductivity])
	axes.set_yticks(range(len(fraction)), [f"{value:g}" for value in fraction])
	axes.set_xlabel("hydraulic conductivity k [m/s]")
	axes.set_ylabel("time step over $h/(c+|v|)$ [-]")
	unstable = sum(not row["stable"] for row in rows)
	axes.set_title(f"Loaded saturated column: {unstable} of {len(rows)} unstable")
	return fig
