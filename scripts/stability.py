#!/usr/bin/python3
# SPDX-License-Identifier: GPL-2.0-or-later
"""Draws the maps that the stability tests left in a folder (maps/*.csv): one PNG each and all of them in stability_map.png."""

import sys
from pathlib import Path

import matplotlib

matplotlib.use("Agg")
import numpy as np
from matplotlib import pyplot
from matplotlib.colors import LogNorm


def readMap(file):
	"""Title, labels of x, y and value, and the columns x, y, value, held."""
	lines = file.read_text().splitlines()
	labels = [line[2:] for line in lines if line.startswith("# ")]
	return labels, np.loadtxt(lines[len(labels) + 1 :], delimiter=",", ndmin=2)


def cellEdges(values):
	"""Boundaries of cells around values, and whether the axis is logarithmic."""
	logarithmic = values[0] > 0 and values[-1] / values[0] > 50
	at = np.log10(values) if logarithmic else values
	if len(at) == 1:
		return values * [0.9, 1.1], logarithmic
	middle = 0.5 * (at[1:] + at[:-1])
	edges = np.concatenate([[2 * at[0] - middle[0]], middle, [2 * at[-1] - middle[-1]]])
	return 10.0**edges if logarithmic else edges, logarithmic


def drawMap(axes, file):
	(title, xLabel, yLabel, valueLabel), rows = readMap(file)
	x, y = np.unique(rows[:, 0]), np.unique(rows[:, 1])
	grid = np.full((len(y), len(x)), np.nan)
	grid[np.searchsorted(y, rows[:, 1]), np.searchsorted(x, rows[:, 0])] = np.where(rows[:, 3] == 1, rows[:, 2], np.nan)
	smallest = max(1e-16, np.nanmin(grid[grid > 0], initial=1.0))
	axes.set_facecolor("lightgrey")
	xEdges, xLog = cellEdges(x)
	yEdges, yLog = cellEdges(y)
	colours = axes.pcolormesh(xEdges, yEdges, np.maximum(grid, smallest), norm=LogNorm(smallest, max(2 * smallest, np.nanmax(grid))), cmap="viridis")
	axes.figure.colorbar(colours, ax=axes, label=valueLabel)
	lost = rows[rows[:, 3] == 0]
	axes.plot(lost[:, 0], lost[:, 1], "rx", markersize=8)
	axes.set(title=f"{title}: {len(rows) - len(lost)} of {len(rows)} held" + (", x: lost" if len(lost) else ""), xlabel=xLabel, ylabel=yLabel)
	axes.set_xscale("log" if xLog else "linear")
	axes.set_yscale("log" if yLog else "linear")


def main(folder):
	files = sorted(Path(folder, "maps").glob("*.csv"))
	for file in files:
		figure, axes = pyplot.subplots(figsize=(6.4, 4.2), layout="constrained")
		drawMap(axes, file)
		figure.savefig(Path(folder, file.stem + ".png"), dpi=90)
		pyplot.close(figure)
	if not files:
		return
	with pyplot.rc_context({"font.size": 9}):
		figure, allAxes = pyplot.subplots(1, len(files), figsize=(6 * len(files), 3.8), layout="constrained", squeeze=False)
		for axes, file in zip(allAxes[0], files):
			drawMap(axes, file)
		figure.savefig(Path(folder, "stability_map.png"), dpi=90)
	print(f"maps: {folder}/stability_map.png and {len(files)} pictures beside it")


if __name__ == "__main__":
	if len(sys.argv) != 2:
		sys.exit(__doc__)
	main(sys.argv[1])
