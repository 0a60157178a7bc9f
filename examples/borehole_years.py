# SPDX-License-Identifier: GPL-2.0-or-later
"""Years of ground temperature below a sensor at the surface or at a depth, predicted and held against the sensors below it.

	scripts/run borehole_years [--data station.csv] [--until 1999-12-31] [--preset test|draft]

The file has the form of the daily tables of Toolik, Alaska (USDA NRCS, station 301): a column date, and columns temp.soil.6mm.C, temp.soil.236mm.C
and so on. Heat only, in one column: peat over mineral ground, full of water. Two runs: one begins at the sensor of 6 mm, one at
that of 236 mm, which knows nothing of what lies above. Of the first run three numbers are fitted on the temperature at 236 mm until the date: the
thickness of moss and peat, and what they conduct thawed and frozen, which is less than full pores would. Later days are predicted. Beside both: the
temperature of the same day a year before, and for the depth of thaw Stefan's a sqrt(degree-days) with a from the days that were fitted.
Without a file two years of weather are made up and nothing is compared.
"""

import argparse
import csv
import datetime
import math
import re

import numpy as np
from yade import O, wrapper

import talik
from talik import dates, geometry, output, plots
from talik.files import writableFolder

parser = argparse.ArgumentParser(description=__doc__.splitlines()[0])
parser.add_argument("--preset", default="draft", choices=("test", "draft", "standard"), help="size of the job")
parser.add_argument("--data", help="CSV file: date, temp.soil.6mm.C, temp.soil.236mm.C, …")
parser.add_argument("--until", default="1999-12-31", help="last date that is fitted")
parser.add_argument("--output", default="output/borehole_years", help="folder for the results")
options = parser.parse_args()
folder = writableFolder(options.output)

spacing, spinUp = {"test": (0.2, 1), "draft": (0.05, 2), "standard": (0.025, 3)}[options.preset]  # [m], times the first year before the first day
bottom, startTemperature = 5.0, -3.0  # insulated there [m]; [degC]
# Of a published fit to this station: porosity, thermal conductivity of what is solid, heat capacity of it [J/(m3 K)], freezing curve
peat = dict(porosity=0.55, capacity=2.6e6, freezing=dict(airEntryPressure=772.0, exponent=0.5, residualSaturation=0.02))
mineral = dict(porosity=0.41, conductivity=1.62, capacity=2.0e6, freezing=dict(airEntryPressure=4905.0, exponent=0.29, residualSaturation=0.024))
surfaceSensor, buriedSensor = 0.006, 0.236  # [m]


def read(path):
	"""First date and {depth of a sensor [m]: temperature [degC] by day, NaN where there is none}."""
	with open(path, newline="") as file:
		rows = list(csv.DictReader(file))
	columns = {int(found.group(1)) / 1000: name for name in rows[0] if (found := re.fullmatch(r"temp\.soil\.(\d+)mm\.C", name))} if rows else {}
	for depth in (surfaceSensor, buriedSensor):
		if depth not in columns or "date" not in rows[0]:
			raise SystemExit(f"{path} needs the columns date, temp.soil.6mm.C and temp.soil.236mm.C")
	first = datetime.date.fromisoformat(rows[0]["date"])
	place = [(datetime.date.fromisoformat(row["date"]) - first).days for row in rows]
	sensors = {depth: np.full(place[-1] + 1, np.nan) for depth in sorted(columns)}
	for k, row in zip(place, rows):
		for depth, name in columns.items():
			try:
				sensors[depth][k] = float(row[name])
			except ValueError:  # a day without a reading
				pass
	return first, sensors


def madeUp():
	day = np.arange(730)
	return datetime.date(1999, 1, 1), {depth: -6 - 14 * np.exp(-depth) * np.cos(2 * np.pi * (day - 20 - 30 * depth) / 365) for depth in (0.006, 0.236)}


def material(name, soil, **conductivities):
	return wrapper.GroundMaterial(
		name=name, solidSpecificHeat=soil["capacity"] / 2650, freezing=wrapper.FreezingCurve(curve="vanGenuchten", **soil["freezing"]), **conductivities
	)


def peatOf(thawed, frozen):
	"""Peat with these bulk conductivities [W/(m K)]: those of its phases are such that their arithmetic mean has them."""
	n = peat["porosity"]
	return material("peat", peat, solidConductivity=thawed, liquidConductivity=thawed, iceConductivity=(frozen - (1 - n) * thawed) / n)


def computed(sensor, thickness=0.0, thawed=0.18, frozen=0.4, last=None):
	"""Of ground with so much peat [m]: depths [m] and temperature [degC] of each day (days, depths) below the sensor, and the depth of thaw [m]."""
	O.reset()
	series = sensors[sensor]
	known = np.flatnonzero(np.isfinite(series))
	series = np.interp(np.arange(last or len(series)), known, series[known])
	before = spinUp * 365
	dates.start((first - datetime.timedelta(days=before)).isoformat())
	table = np.concatenate([np.tile(series[:365], spinUp), series])
	mpm = wrapper.MpmEngine(
		gridSpacing=spacing,
		lower=(0, -bottom),
		upper=(spacing, 0),
		motion=False,
		heat=wrapper.HeatTransfer(),
		freezing=wrapper.FreezingCurve(),
		materials=[peatOf(thawed, frozen), material("mineral", mineral, solidConductivity=mineral["conductivity"], conductivityMean="geometric")],
		boundaries=[
			wrapper.SurfaceTemperature(region="top", times=list(np.arange(len(table)) * talik.day), values=list(table)),
			wrapper.InsulatedBoundary(region="bottom"),
		],
		automaticTimeStep=False,
	)
	of = max(0.0, thickness - sensor)
	if of > 0:
		geometry.fill(mpm, geometry.rectangle(0, -of, spacing, 0), porosity=peat["porosity"], temperature=startTemperature, material="peat")
	ground = geometry.rectangle(0, -bottom, spacing, -of)
	geometry.fill(mpm, ground, porosity=mineral["porosity"], temperature=startTemperature, material="mineral")
	O.engines = [mpm]
	O.dt = talik.day
	depth = -mpm.field("position")[:, 1]
	order = np.argsort(depth)
	rows = []
	for day in range(len(table)):
		O.step()
		if day >= before:
			rows.append(mpm.field("temperature")[order])
	return sensor + depth[order], np.array(rows), dates.today(mpm)


def at(depths, temperature, depth):
	return np.array([np.interp(depth, depths, row) for row in temperature])


def thawDepth(depths, temperature):
	"""Depth of the deepest 0 degC of each day [m]."""
	found = []
	for row in temperature:
		warm = np.flatnonzero(row > 0)
		k = warm[-1] if len(warm) else None
		if k is None or k == len(row) - 1:
			found.append(0.0 if k is None else depths[-1])
		else:
			found.append(depths[k] + (depths[k + 1] - depths[k]) * row[k] / (row[k] - row[k + 1]))
	return np.array(found)


def rms(off):
	off = off[np.isfinite(off)]
	return math.sqrt(np.mean(off**2)) if len(off) else math.nan


first, sensors = read(options.data) if options.data else madeUp()
days = len(sensors[surfaceSensor])
until = max(0, min(days - 1, (datetime.date.fromisoformat(options.until) - first).days))
if options.data and not 180 < until < days - 30:
	raise SystemExit(f"--until {options.until}: give a date half a year after {first} and a month before the end of the file")

found = dict(thickness=0.21, thawed=0.18, frozen=0.4)


def offBy(**layer):
	depths, temperature, _ = computed(surfaceSensor, **layer, last=until + 1)
	value = rms(at(depths, temperature, buriedSensor) - sensors[buriedSensor][: until + 1])
	print(", ".join(f"{name} {number:g}" for name, number in layer.items()) + f": {value:.2f} K off at {buriedSensor} m until {options.until}", flush=True)
	return value


if options.data:
	for name, values in (("thawed", (0.12, 0.18, 0.25)), ("frozen", (0.32, 0.42, 0.55)), ("thickness", (0.16, 0.21, 0.26))):
		found[name] = min(values, key=lambda value: offBy(**{**found, name: value}))
runs = {"from the surface": (surfaceSensor, *computed(surfaceSensor, **found)), "from 236 mm": (buriedSensor, *computed(buriedSensor))}
print(f"computed until {runs['from the surface'][3]}; {found['thickness']:g} m of peat, {found['thawed']:g} and {found['frozen']:g} W/(m K)")

below = [depth for depth in sensors if depth > surfaceSensor]
lines = [
	"| depth [m] | " + " | ".join(f"{name}, bias / rms [K]" for name in runs) + " | the same day a year before, rms [K] |",
	"|---|" + "---|" * (len(runs) + 1),
]
later = slice(until + 1, days)
for depth in below:
	cells = []
	for sensor, depths, temperature, _ in runs.values():
		off = at(depths, temperature, depth)[later] - sensors[depth][later]
		cells.append(f"{np.nanmean(off):+.2f} / {rms(off):.2f}" if depth > sensor and options.data else "")
	year = sensors[depth][later] - sensors[depth][np.arange(until + 1, days) - 365] if until > 365 else np.array([np.nan])
	lines.append(f"| {depth:.3f} | {' | '.join(cells)} | {rms(year):.2f} |")
known = np.array([depth for depth in below if depth >= buriedSensor])
measured = thawDepth(known, np.nan_to_num(np.transpose([sensors[depth] for depth in known]), nan=-1.0)) if len(known) > 1 else np.zeros(days)
degreeDays = np.maximum(sensors[surfaceSensor], 0)
thaw = {}
for name, (sensor, depths, temperature, _) in runs.items():
	thaw[name] = thawDepth(np.concatenate([[sensor], depths]), np.column_stack([sensors[sensor], temperature]))
firstYears = sorted({(first + datetime.timedelta(days=k)).year for k in range(days)})
inYear = {year: np.array([(first + datetime.timedelta(days=k)).year == year for k in range(days)]) for year in firstYears}
whole = [year for year in firstYears if inYear[year].sum() >= 360]
if options.data and whole:
	ofFit = max((year for year in whole if datetime.date(year, 12, 31) <= first + datetime.timedelta(days=until)), default=whole[0])
	stefan = measured[inYear[ofFit]].max() / math.sqrt(np.nansum(degreeDays[inYear[ofFit]]))
	lines += ["", "| deepest thaw [m] | measured | " + " | ".join(runs) + " | Stefan |", "|---|---|" + "---|" * (len(runs) + 1)]
	for year in whole:
		of = inYear[year]
		byHand = stefan * math.sqrt(np.nansum(degreeDays[of]))
		said = f"{year}, fitted" if year <= ofFit else f"{year}"
		lines.append(f"| {said} | {measured[of].max():.2f} | {' | '.join(f'{thaw[name][of].max():.2f}' for name in runs)} | {byHand:.2f} |")
print(*lines, sep="\n")

figure = plots.figure(9, 6.5)
shown = [depth for depth in (0.236, 0.616, 0.978) if depth in sensors]
panels = figure.subplots(len(shown) + 1, 1, sharex=True)
day = np.array([first + datetime.timedelta(days=k) for k in range(days)])
for axes, depth in zip(panels, shown):
	axes.plot(day, sensors[depth], color="0.6", linewidth=2.5, label="measured" if options.data else "made up")
	for (name, (sensor, depths, temperature, _)), colour in zip(runs.items(), ("firebrick", "tab:blue")):
		if depth > sensor:
			axes.plot(day, at(depths, temperature, depth), color=colour, linewidth=0.9, label=name)
	axes.axvline(day[until], color="black", linewidth=0.7, linestyle="--")
	axes.set(ylabel=f"{depth:g} m [°C]")
	axes.legend(frameon=False, fontsize=7, loc="lower left", ncols=3)
if options.data:
	panels[-1].plot(day, measured, color="0.6", linewidth=2.5)
for name, colour in zip(runs, ("firebrick", "tab:blue")):
	panels[-1].plot(day, thaw[name], color=colour, linewidth=0.9)
panels[-1].set(ylabel="thaw [m]", xlim=(day[0], day[-1]))
panels[-1].invert_yaxis()
plots.save(figure, folder / "borehole_years.png", dpi=100)
deepest = {name: float(thaw[name].max()) for name in runs}
output.writeSummary(folder / "summary.json", **{"peat": found, "deepest thaw [m]": deepest})
if not all(0 < value < bottom for value in deepest.values()):
	output.unexpected("the ground never thaws, or thaws to its base")
print(f"picture and summary are in {folder}")
