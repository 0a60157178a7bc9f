# SPDX-License-Identifier: GPL-2.0-or-later
"""A frozen block that thaws around a hot rod: temperature between the innermost and the outermost sensor, in the round and in the plane.

	scripts/run thawing_block [--data block.csv] [--porosity 0.42] [--preset test|draft]

The file has a row each 30 s and columns D90-W15, D90-W30 and so on: sensors at 90 mm of depth, 15 and 30 mm from the axis of the rod. For each depth the
innermost and the outermost sensor give the temperature of both ends of a column, its start is that of the first row, and the sensors in between are
predicted. Heat only. Nothing is fitted: conductivities are those of the ground before, 2.96 W/(m K) frozen and 1.64 thawed. The column is computed about
the axis (axisymmetric) and in the plane, as if the rod were a wall. Without a file a rod of 60 degC is made up and both are held against each other.
"""

import argparse
import csv
import re

import numpy as np
from yade import O, wrapper

import talik  # noqa: F401: loads the plugin
from talik import geometry, output, plots
from talik.files import writableFolder

parser = argparse.ArgumentParser(description=__doc__.splitlines()[0])
parser.add_argument("--preset", default="draft", choices=("test", "draft"), help="size of the job")
parser.add_argument("--data", help="CSV file: a first column, then D90-W15, D90-W30, …")
parser.add_argument("--porosity", type=float, default=0.42, help="of the block")
parser.add_argument("--output", default="output/thawing_block", help="folder for the results")
options = parser.parse_args()
folder = writableFolder(options.output)

cells = {"test": 21, "draft": 42}[options.preset]
interval, frozen, thawed, width = 30.0, 2.96, 1.64, 0.3  # between two rows [s]; [W/(m K)]; of the freezing curve [K]


def read(path):
	"""{depth [mm]: (distances from the axis [m], temperature (rows, sensors) [degC])}"""
	with open(path, newline="") as file:
		rows = list(csv.reader(file))
	named = {(int(m[1]), int(m[2])): k for k, name in enumerate(rows[0] if rows else []) if (m := re.fullmatch(r"D(\d+)-W(\d+)", name.strip()))}
	found = {}
	for depth in sorted({depth for depth, _ in named}):
		distances = sorted(distance for at, distance in named if at == depth)
		if len(distances) > 2:
			values = np.array([[float(row[named[depth, distance]]) for distance in distances] for row in rows[1:]])
			found[depth] = (np.array(distances) / 1000, values)
	if not found:
		raise SystemExit(f"{path} needs at least three columns of one depth, such as D90-W15, D90-W60 and D90-W120")
	return found


def madeUp():
	hours = np.arange(481) * interval / 3600
	distances = np.array([15, 30, 45, 60, 75, 90, 120]) / 1000
	values = np.full((len(hours), len(distances)), -5.0)
	values[:, 0] += 65 * (1 - np.exp(-hours / 0.25))
	values[:, -1] += np.minimum(5.5, 1.5 * hours)
	return {90: (distances, values)}


def computed(distances, values, around):
	"""Temperature at each sensor between the ends (rows, sensors) [degC]; around: about the axis."""
	O.reset()
	inner, outer = distances[0], distances[-1]
	h, n = (outer - inner) / cells, options.porosity
	times = list(np.arange(len(values)) * interval)
	mpm = wrapper.MpmEngine(
		gridSpacing=h,
		lower=(inner, 0),
		upper=(outer, h),
		axisymmetric=around,
		motion=False,
		heat=wrapper.HeatTransfer(),
		freezing=wrapper.FreezingCurve(width=width),
		# the phases conduct so that the arithmetic mean of full pores is what the ground conducts
		material=wrapper.GroundMaterial(solidConductivity=thawed, liquidConductivity=thawed, iceConductivity=(frozen - (1 - n) * thawed) / n),
		boundaries=[wrapper.WallTemperature(region=side, times=times, values=list(values[:, k])) for side, k in (("left", 0), ("right", -1))],
		automaticTimeStep=False,
	)
	start = lambda x, y: np.minimum(np.interp(x, distances, values[0]), -0.05)
	geometry.fill(mpm, geometry.rectangle(inner, 0, outer, h), porosity=n, temperature=start)
	O.engines = [mpm]
	O.dt = interval
	place = mpm.field("position")[:, 0]
	order = np.argsort(place)
	found = [values[0, 1:-1]]
	for _ in range(len(values) - 1):
		O.step()
		found.append(np.interp(distances[1:-1], place[order], mpm.field("temperature")[order]))
	return np.array(found)


series = read(options.data) if options.data else madeUp()
if options.preset == "test":
	series = {depth: (distances, values[:121]) for depth, (distances, values) in list(series.items())[:1]}
ways = {"round": True, "planar": False}
runs = {depth: {name: computed(distances, values, around) for name, around in ways.items()} for depth, (distances, values) in series.items()}
lines = ["| depth [mm] | distance [mm] | round, bias / rms [K] | planar, bias / rms [K] |", "|---|---|---|---|"]
every = {name: [] for name in ways}
for depth, (distances, values) in series.items():
	for k, distance in enumerate(distances[1:-1]):
		# without a file the round column stands for what was measured
		offs = {name: runs[depth][name][:, k] - (values[:, k + 1] if options.data else runs[depth]["round"][:, k]) for name in ways}
		for name, off in offs.items():
			every[name].append(off)
		said = " | ".join(f"{off.mean():+.2f} / {np.sqrt((off**2).mean()):.2f}" for off in offs.values())
		lines.append(f"| {depth} | {1000 * distance:.0f} | {said} |")
rms = {name: float(np.sqrt(np.mean(np.square(offs)))) for name, offs in every.items()}
lines.append("| all | | " + " | ".join(f"{value:.2f}" for value in rms.values()) + " |")
print(*lines, sep="\n")
if not options.data:
	print("made-up temperatures: the differences are those of a planar from a round column")

depth, (distances, values) = next(iter(series.items()))
figure = plots.figure(8, 4)
axes = figure.subplots()
hours = np.arange(len(values)) * interval / 3600
for k, distance in enumerate(distances[1:-1]):
	colour = f"C{k}"
	if options.data:
		axes.plot(hours, values[:, k + 1], color=colour, linewidth=3, alpha=0.35)
	axes.plot(hours, runs[depth]["round"][:, k], color=colour, label=f"{1000 * distance:.0f} mm")
	axes.plot(hours, runs[depth]["planar"][:, k], color=colour, linestyle=":")
axes.set(xlabel="hour", ylabel="temperature [°C]", title=f"{depth} mm deep; round: lines, planar: dotted" + (", measured: pale" if options.data else ""))
axes.legend(frameon=False, fontsize=8, ncols=2)
plots.save(figure, folder / "thawing_block.png", dpi=100)
output.writeSummary(folder / "summary.json", **{"rms [K]": rms})
if not all(np.all(run["planar"][-1] >= run["round"][-1] - 0.05) for run in runs.values()):
	output.unexpected("heat spreads in the round, and a sensor of the round column is warmer than that of the planar one")
print(f"picture and summary are in {folder}")
