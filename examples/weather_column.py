# SPDX-License-Identifier: GPL-2.0-or-later
"""A column of permafrost under a year of weather: the active layer thaws from above and freezes back.

	scripts/run weather_column [--preset draft|standard|fine] [--weather station.csv]

Heat only: the ground is rigid, so that conduction alone limits the time step and years pass in seconds. The air of a CSV file (time
[s], air temperature [degC]; weather_column.csv beside this script is made up) exchanges heat with the surface, 15 W/(m2 K); the
base at 10 m is insulated. The ground starts at the year's mean temperature, the year is repeated until the depth of thaw no longer
remembers that. Compared with Stefan's estimate of the thaw depth, sqrt(2 kappa I/(rho_i n L_f)) with the thawing index I of the
air, which knows neither the resistance of the air nor the heat that warms the ground itself, and so must lie deeper.
"""

import argparse
import math
import sys
from dataclasses import dataclass
from pathlib import Path

import numpy as np
from yade import O, wrapper

import talik  # noqa: F401: loads the plugin
from talik import geometry, output, plots, weather
from talik.files import writableFolder


@dataclass
class Column:
	"""Size of the job."""

	spacing: float  # h [m]
	years: int


presets = {
	"test": Column(spacing=0.4, years=1),
	"draft": Column(spacing=0.2, years=2),
	"standard": Column(spacing=0.1, years=3),
	"fine": Column(spacing=0.05, years=5),
}

depth = 10.0  # [m]
porosity = 0.4
exchange = 15.0  # h_c of the surface [W/(m2 K)]
day = 86400.0
year = 365 * day


def repeated(times, values, years):
	"""The first year of a series, again and again."""
	times, values = np.array(times), np.array(values)
	first = times < year
	return np.concatenate([times[first] + k * year for k in range(years)]), np.tile(values[first], years)


def build(column, times, values):
	mean = float(np.mean(values))
	mpm = wrapper.MpmEngine(
		gridSpacing=column.spacing,
		lower=(0, -depth),
		upper=(column.spacing, 0),
		motion=False,
		heat=wrapper.HeatTransfer(),
		freezing=wrapper.FreezingCurve(curve="gauss", width=0.5, residualSaturation=0.05),
		boundaries=[
			wrapper.SurfaceTemperature(region="top", heatTransferCoefficient=exchange, times=list(times), values=list(values)),
			wrapper.InsulatedBoundary(region="bottom"),
		],
		automaticTimeStep=False,
	)
	geometry.fill(mpm, geometry.rectangle(0, -depth, column.spacing, 0), porosity=porosity, temperature=mean)
	O.engines = [mpm]
	O.dt = day
	return mpm


def run(mpm, column):
	"""Depths of the cells [m] and their temperature [degC] and ice saturation at the end of every day, (days, cells)."""
	cells = round(depth / column.spacing)
	cell = np.floor(-mpm.field("position")[:, 1] / column.spacing).astype(int)
	share = np.bincount(cell, minlength=cells)
	temperature, ice = [], []
	for _ in range(column.years * 365):
		O.step()  # one day: the engine takes as many steps as conduction needs
		for record, name in ((temperature, "temperature"), (ice, "iceSaturation")):
			record.append(np.bincount(cell, mpm.field(name), minlength=cells) / share)
	return (np.arange(cells) + 0.5) * column.spacing, np.array(temperature), np.array(ice)


def stefan(mpm, times, values):
	"""Thaw depth [m] from the degree seconds above zero of one year of air."""
	days = np.arange(365) * day
	index = day * np.clip(np.interp(days, times, values), 0, None).sum()
	m = mpm.material
	conductivity = (1 - porosity) * m.solidConductivity + porosity * m.liquidConductivity
	return math.sqrt(2 * conductivity * index / (m.iceDensity * porosity * m.latentHeat))


def draw(times, values, depths, temperature, thawed, path):
	days = np.arange(1, len(temperature) + 1)
	fig = plots.figure(9, 6.5)
	air, ground = fig.subplots(2, 1, sharex=True, height_ratios=(1, 2))
	air.plot(np.array(times) / day, values, color="0.6", linewidth=0.8, label="air")
	air.plot(days, temperature[:, 0], color="firebrick", linewidth=0.8, label=f"ground, {depths[0]:.2f} m deep")
	air.set_ylabel("temperature [°C]")
	air.legend(loc="lower right", ncols=2)
	largest = np.abs(temperature).max()
	field = ground.pcolormesh(days, depths, temperature.T, cmap="coolwarm", vmin=-largest, vmax=largest, shading="nearest")
	ground.plot(days, thawed, color="black", linewidth=1.2, label="depth of thaw (ice melted from above)")
	ground.set_ylim(depth, 0)
	ground.set_xlim(0, days[-1])
	ground.set_xlabel("time [d]")
	ground.set_ylabel("depth [m]")
	ground.legend(loc="lower right")
	fig.colorbar(field, ax=[air, ground], label="temperature of the ground [°C]")
	plots.save(fig, path, dpi=110)


parser = argparse.ArgumentParser(description=__doc__.splitlines()[0])
parser.add_argument("--preset", default="draft", choices=sorted(presets), help="size of the job")
parser.add_argument("--weather", default=str(Path(sys.argv[0]).with_suffix(".csv")), help="series of time [s] and air temperature [degC]")
parser.add_argument("--output", default="output/weather_column", help="folder for the results")
options = parser.parse_args()
folder = writableFolder(Path(options.output))
column = presets[options.preset]

times, values = repeated(*weather.airTemperature(options.weather), column.years)
mpm = build(column, times, values)
start = mpm.balance()["enthalpy"]
depths, temperature, ice = run(mpm, column)
balance = mpm.balance()
frozenSolid = 1 - 0.05  # ice saturation far below zero
thawed = column.spacing * np.cumprod(ice < 0.5 * frozenSolid, axis=1).sum(axis=1)
lastYear = slice(-365, None)
deepest, expected = thawed[lastYear].max(), stefan(mpm, times, values)
residual = (balance["enthalpy"] - start - balance["heatIn"]) / np.abs(balance["enthalpy"] - start)
print(f"{'day':>5} {'air [°C]':>9} {'surface [°C]':>13} {'1 m [°C]':>9} {'5 m [°C]':>9} {'thawed [m]':>11}")
for d in range(len(thawed) - 365, len(thawed), 30):
	shown = [np.interp(x, depths, temperature[d]) for x in (0.0, 1.0, 5.0)]
	print(f"{d + 1:5d} {np.interp((d + 1) * day, times, values):9.1f} {shown[0]:13.1f} {shown[1]:9.1f} {shown[2]:9.1f} {thawed[d]:11.2f}")
print(f"deepest thaw of the last year {deepest:.2f} m; Stefan's estimate {expected:.2f} m; heat closes to {residual:.1e}")
if not 0 < deepest <= expected + column.spacing:
	output.unexpected("thaw reaches deeper than all the heat of the air could bring it")
draw(times, values, depths, temperature, thawed, folder / "weather_column.png")
np.savez(folder / "record.npz", depth=depths, temperature=temperature, iceSaturation=ice, thawed=thawed)
output.writeSummary(folder / "summary.json", **{"deepest thaw [m]": deepest, "Stefan [m]": expected, "heat residual": residual})
print(f"picture, record and summary are in {folder}")
