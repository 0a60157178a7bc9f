# SPDX-License-Identifier: GPL-2.0-or-later
"""A road embankment on permafrost settles over 30 years of warming, on two soils, with the spread of the tests that their settlement comes from.

	scripts/run road_embankment [--preset test|draft|standard] [--weather air.csv]

A column under the centre line: 2 m of gravel on 8 m of frozen ground, fine or coarse. The air comes from a CSV file (time [s], air
temperature [degC]; road_embankment.csv beside this script is made up: -4 degC +- 18 K and 0.05 K of warming a year), n-factors make the
temperature of the surface from it. talik.soils gives the settlement of both soils by their frozen density, with its spread. By hand: strain of the
soil under the weight above it, summed over the ground that has thawed. Its thickness is that of the column; 400 soils of the same description
give the deciles. Ground has no water pressure here: what it thaws to has drained.

Frost heave is not in it: freezing ground draws no water. Change densities and n-factors first.
"""

import argparse
import sys
from pathlib import Path

import numpy as np
from yade import O

import talik
from talik import output, plots, weather
from talik.files import writableFolder

parser = argparse.ArgumentParser(description=__doc__.splitlines()[0])
parser.add_argument("--preset", default="draft", choices=("test", "draft", "standard"), help="size of the job")
parser.add_argument("--weather", default=str(Path(sys.argv[0]).with_name("road_embankment.csv")), help="CSV file of time [s] and air temperature [degC]")
parser.add_argument("--output", default="output/road_embankment", help="folder for the results")
parser.add_argument("--fine", type=float, default=1600, help="frozen density of the fine soil [kg/m^3]")
parser.add_argument("--coarse", type=float, default=1800, help="frozen density of the coarse soil [kg/m^3]")
parser.add_argument("--fill", type=float, default=0.3, help="part of the pores of the gravel that holds water [-]")
parser.add_argument("--n-factors", type=float, nargs=2, default=(1.3, 0.6), metavar=("THAWING", "FREEZING"), help="of the surface of the road")
options = parser.parse_args()
folder = writableFolder(options.output)

h, years = {"test": (0.25, 6), "draft": (0.25, 30), "standard": (0.125, 30)}[options.preset]  # grid spacing [m]
gravity, embankment, depth = 9.81, 2.0, 8.0  # [m/s^2], [m], [m]
gravelPorosity, gravelFill = 0.3, options.fill
soils = {
	f"{kind} soil, {density:g} kg/m³": talik.soils.thaw(kind, frozenDensity=density) for kind, density in (("fine", options.fine), ("coarse", options.coarse))
}
colors = ("#1f77b4", "#d95f02")
times, air = weather.airTemperature(options.weather)
surface = weather.surfaceTemperature(air, *options.n_factors)
gravelDensity = (1 - gravelPorosity) * 2650 + gravelPorosity * gravelFill * 1000


def column(soil):
	"""The column on a soil, as an engine that has not begun."""
	mpm = MpmEngine(
		gridSpacing=h,
		lower=(0, -depth),
		upper=(h, embankment + 2 * h),
		gravity=(0, -gravity),
		damping=0.3,
		heat=HeatTransfer(thermalTimeScale=1e7),
		freezing=FreezingCurve(),
		skeleton=ElasticSkeleton(young=1e7),
		boundaries=[RollerBoundary(region=side) for side in ("left", "right", "bottom")]
		+ [SurfaceTemperature(region="surface", times=times, values=surface), HeatFlux(region="bottom", flux=0.05)],
	)
	layers = {
		"ground": dict(polygon=talik.geometry.rectangle(0, -depth, h, 0), porosity=soil.porosity, temperature=-1.0),
		"embankment": dict(polygon=talik.geometry.rectangle(0, 0, h, embankment), porosity=gravelPorosity, poreFill=gravelFill, temperature=-1.0),
	}
	layers["ground"]["material"] = GroundMaterial(solidConductivity=2.0, **soil.material())
	layers["embankment"]["material"] = GroundMaterial(solidConductivity=3.0)
	return mpm, talik.layers.fill(mpm, layers, lateralRatio=0.5)["ground"]


def settle(soil):
	"""Rows of year, settlement [m] and thickness of ground that has thawed at least once [m], twelve a year."""
	mpm, ground = column(soil)
	O.engines = [mpm]
	O.step()
	first = mpm.field("initialVolume")[ground]
	frozen, melted = mpm.field("iceSaturation")[ground], np.zeros(len(ground))
	rows = [(0.0, 0.0, 0.0)]
	for month in range(1, 12 * years + 1):
		talik.runUntilDay(mpm, 365 * month / 12)
		melted = np.maximum(melted, 1 - mpm.field("iceSaturation")[ground] / frozen)
		rows.append((month / 12, (first - mpm.field("volume")[ground]).sum() / h, (first * melted).sum() / h))
	return np.array(rows), mpm.pointCount, O.iter


def byHand(soil, thickness):
	"""Settlement [m] of ground that has thawed to thicknesses [m] under the embankment."""
	depths = np.linspace(0, depth, 801)
	density = (1 - soil.porosity) * 2650 + soil.porosity * 910
	strain = soil.strain(gravity * (gravelDensity * embankment + density * depths))
	below = np.concatenate([[0], np.cumsum(0.5 * (strain[1:] + strain[:-1]) * np.diff(depths))])
	return np.interp(thickness, depths, below)


figure = plots.figure(8, 6)
upper, lower = figure.subplots(2, 1, sharex=True)
summary, offs = {}, []
for (name, soil), color in zip(soils.items(), colors):
	rows, points, steps = settle(soil)
	year, settlement, thickness = rows.T
	hand = byHand(soil, thickness)
	low, high = np.quantile([byHand(soil.draw(seed), thickness) for seed in range(400)], [0.1, 0.9], axis=0)
	offs.append(abs(settlement[-1] / hand[-1] - 1))
	print(f"{name}: {soil}")
	print(
		f"  after {years} years {thickness[-1]:.2f} m have thawed; settlement {settlement[-1]:.3f} m, by hand {hand[-1]:.3f} m, deciles of such soils "
		f"{low[-1]:.2f} to {high[-1]:.2f} m ({points} points, {steps} steps)"
	)
	summary[name] = {"settlement [m]": settlement[-1], "by hand [m]": hand[-1], "deciles [m]": [low[-1], high[-1]], "thawed [m]": thickness[-1]}
	upper.plot(year, settlement, color=color, label=name)
	upper.plot(year, hand, color=color, linestyle="--", label="by hand from the thickness thawed")
	upper.fill_between(year, low, high, color=color, alpha=0.15, linewidth=0, label="first to ninth decile of such soils")
	lower.plot(year, thickness, color=color)
upper.invert_yaxis()
upper.set_ylabel("settlement [m]")
upper.legend(fontsize=8)
lower.invert_yaxis()
lower.set_ylabel("ground thawed\nsince the start [m]")
lower.set_xlabel("year")
plots.save(figure, folder / "road_embankment.png", dpi=100)
output.writeSummary(folder / "summary.json", **summary)
if max(offs) > 0.1:
	output.unexpected("a settlement is more than 10 % off the calculation by hand")
print(f"picture and summary are in {folder}")
