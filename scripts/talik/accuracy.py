# SPDX-License-Identifier: GPL-2.0-or-later
"""How accuracy is paid for in computing time, and which time steps are stable: what scripts/accuracy measures.

	frontError   thaw front in rigid ground against Neumann's closed form, over the grid spacing
	stability    a loaded saturated column over hydraulic conductivity and time step

Both return rows (dictionaries of named numbers); saveTable writes them as CSV, drawFrontError and drawStability as pictures.
"""

import argparse
import csv
import math
import time
from pathlib import Path

import numpy as np
from matplotlib.colors import LogNorm
from matplotlib.ticker import LogLocator, NullFormatter

from yade import O, wrapper

import talik
from talik import plots
from talik.files import writableFolder

day = 86400.0
porosity = 0.4
solid = (2650.0, 800.0, 1.0)  # density [kg/m3], specific heat [J/(kg K)], conductivity [W/(m K)]: Yu & Zhao section 3
ice = (910.0, 2060.0, 2.2)
liquid = (1000.0, 4200.0, 0.6)
latentHeat = 334e3  # [J/kg]


# ---- thaw front against Neumann -------------------------------------------------------------------------------------------


def neumannFront(surface, initial, latentForm="capacityIntegral"):
	"""X/sqrt(t) [m/s^0.5] of ground at `initial` < 0 that thaws from a wall at `surface` > 0 [degC]; all pore water is ice first.

	latentForm  capacityIntegral: thawed pores are full of water, eq. (4) of Yu & Zhao; conserved: they hold the mass that the ice had"""
	density, heat, conduction = (np.array(values) for values in zip(solid, ice, liquid))
	thawedPart = np.array([1 - porosity, 0, porosity * (ice[0] / liquid[0] if latentForm == "conserved" else 1)])
	frozenPart = np.array([1 - porosity, porosity, 0])
	thawedCapacity, frozenCapacity = ((part * density * heat).sum() for part in (thawedPart, frozenPart))
	thawedConduction, frozenConduction = (1 - porosity) * solid[2] + porosity * liquid[2], (frozenPart * conduction).sum()
	thawed, frozen = thawedConduction / thawedCapacity, frozenConduction / frozenCapacity  # diffusivities [m2/s]
	latent = porosity * ice[0] * latentHeat

	def missing(front):
		"""Heat that arrives at the front less what leaves it and what melts; falls as the front runs faster."""
		a, b = front / (2 * math.sqrt(thawed)), front / (2 * math.sqrt(frozen))
		arriving = thawedConduction * surface * math.exp(-a * a) / (math.sqrt(math.pi * thawed) * math.erf(a))
		leaving = frozenConduction * -initial * math.exp(-b * b) / (math.sqrt(math.pi * frozen) * math.erfc(b))
		return arriving - leaving - latent * front / 2

	low, high = 1e-8, 20 * math.sqrt(frozen)
	for _ in range(200):
		middle = 0.5 * (low + high)
		low, high = (middle, high) if missing(middle) > 0 else (low, middle)
	return 0.5 * (low + high)


def frontError(spacings=(0.1, 0.05, 0.025, 0.0125), duration=5 * day, depth=2.0, surface=10.0, initial=-5.0, instants=40):
	"""Rows of spacing [m], points, steps, error [-] and wall time [s]: thaw of a rigid column from its base through MpmEngine.

	The error is the root mean square of X/X_Neumann - 1 over equal instants of the second half of the duration. The column is deep
	enough for its far end (2 m against a diffusion length of 1.1 m) not to be felt."""
	return [_frontRow(spacing, duration, depth, surface, initial, instants) for spacing in spacings]


def _frontRow(spacing, duration, depth, surface, initial, instants):
	O.reset()
	mpm = _thawingColumn(spacing, depth, surface, initial)
	O.engines = [mpm]
	mpm.initialise()
	rate, errors, wall = neumannFront(surface, initial), [], 0.0
	for instant in np.linspace(0.5, 1, instants) * duration:
		start = time.perf_counter()
		_marchTo(instant)
		wall += time.perf_counter() - start
		thawed = np.sum((1 - mpm.field("iceSaturation")) * mpm.field("volume")) / spacing
		errors.append(thawed / (rate * math.sqrt(mpm.time)) - 1)
	return {
		"spacing [m]": spacing,
		"points": mpm.pointCount,
		"steps": O.iter,
		"front [m]": thawed,
		"Neumann [m]": rate * math.sqrt(mpm.time),
		"error [-]": float(np.sqrt(np.mean(np.square(errors)))),
		"wall time [s]": wall,
	}


def _thawingColumn(spacing, depth, surface, initial):
	height = spacing * math.ceil(depth / spacing - 1e-9)
	mpm = wrapper.MpmEngine(
		gridSpacing=spacing,
		lower=(0, 0),
		upper=(spacing, height),
		motion=False,
		material=wrapper.GroundMaterial(solidExpansivity=0, iceExpansivity=0, liquidExpansivity=0),
		heat=wrapper.HeatTransfer(enthalpyForm="capacityIntegral"),
		freezing=wrapper.FreezingCurve(curve="sharp", residualSaturation=0),
		boundaries=[wrapper.WallTemperature(region="bottom", temperature=surface)],
	)
	talik.geometry.fill(mpm, talik.geometry.rectangle(0, 0, spacing, height), porosity=porosity, temperature=initial)
	return mpm


def _marchTo(instant):
	"""Runs to the first step that ends at or after an instant; YADE's background thread would add waiting to the computing time."""
	while O.time < instant:
		O.step()


def drawFrontError(rows):
	"""Error over grid spacing and over computing time."""
	fig = plots.figure(10, 4.2)
	left, right = fig.subplots(1, 2, sharey=True)
	error = 100 * column(rows, "error [-]")
	spacing = column(rows, "spacing [m]")
	left.loglog(spacing, error, "o-")
	left.loglog(spacing, error[-1] * spacing / spacing[-1], "--", color="0.6", label="first order")
	left.set_xlabel("grid spacing h [m]")
	left.set_ylabel("error of the thaw front (rms) [%]")
	left.legend(frameon=False)
	right.loglog(column(rows, "wall time [s]"), error, "o-")
	for row, percent in zip(rows, error):
		right.annotate(f"h = {row['spacing [m]']:g} m", (row["wall time [s]"], percent), textcoords="offset points", xytext=(-7, -10), ha="right", fontsize=8)
	right.set_xlabel("computing time [s]")
	right.margins(x=0.25)
	left.set_xticks(spacing, [f"{h:g}" for h in spacing])
	left.xaxis.set_minor_formatter(NullFormatter())
	left.yaxis.set_major_locator(LogLocator(subs=(1, 2, 5)))
	left.yaxis.set_major_formatter("{x:g}")
	left.yaxis.set_minor_formatter(NullFormatter())
	for axes in (left, right):
		axes.grid(color="0.9")
	fig.suptitle("Thaw from a wall, -5 °C to +10 °C, against Neumann's solution")
	return fig


# ---- stability over conductivity and time step ----------------------------------------------------------------------------


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


# ---- tables ---------------------------------------------------------------------------------------------------------------


def column(rows, name):
	"""One named number of all rows."""
	return np.array([row[name] for row in rows])


def saveTable(rows, path):
	"""CSV with one line per row."""
	writableFolder(Path(path).parent)
	with open(path, "w", newline="") as file:
		writer = csv.DictWriter(file, fieldnames=list(rows[0]))
		writer.writeheader()
		writer.writerows(rows)


def printTable(rows):
	"""Rows in columns as wide as their widest entry."""
	_printAligned([[str(name) for name in rows[0]]] + [[_short(value) for value in row.values()] for row in rows])


def printMap(rows, down, across, entry):
	"""Rows as a table with one named number down, one across and one in the cells."""
	text = [[f"{down} \\ {across}"] + [_short(value) for value in dict.fromkeys(row[across] for row in rows)]]
	for value in dict.fromkeys(row[down] for row in rows):
		text.append([_short(value)] + [_short(row[entry]) for row in rows if row[down] == value])
	_printAligned(text)


def _printAligned(text):
	widths = [max(len(line[c]) for line in text) for c in range(len(text[0]))]
	for line in text:
		print("  ".join(cell.rjust(width) for cell, width in zip(line, widths)))


def _short(value):
	return f"{value:.4g}" if isinstance(value, float) else str(value)


def main():
	parser = argparse.ArgumentParser(prog="scripts/accuracy", description="Error over computing time, and a map of stable time steps.")
	parser.add_argument("--quick", action="store_true", help="fewer and coarser runs")
	parser.add_argument("--output", default="output/accuracy", help="folder for tables and pictures")
	options = parser.parse_args()
	folder = writableFolder(options.output)
	rows = frontError((0.1, 0.05, 0.025, 0.0125) if options.quick else (0.1, 0.05, 0.025, 0.0125, 0.00625))
	printTable(rows)
	_keep(rows, drawFrontError, folder / "front-error")
	rows = stability(steps=1000 if options.quick else 5000)
	print("largest kinetic energy over what the load can bring (stable below 1)")
	printMap(rows, "conductivity [m/s]", "step over h/(c+|v|) [-]", "largest kinetic energy over bound [-]")
	for row in rows:
		if not row["stable"]:
			print(f"unstable: k = {row['conductivity [m/s]']:g} m/s, step {row['step over h/(c+|v|) [-]']:g}: {row['reason'] or 'energy above its bound'}")
	_keep(rows, drawStability, folder / "stability")


def _keep(rows, draw, path):
	saveTable(rows, f"{path}.csv")
	print(f"{plots.save(draw(rows), f'{path}.png')}, {path}.csv\n", flush=True)


if __name__ == "__main__":
	main()
