# SPDX-License-Identifier: GPL-2.0-or-later
"""Thaw depth of tundra: one number is fitted on unburned ground in one year, and later years and burned ground are predicted.

	scripts/run burned_tundra [--data daily.csv --surveys surveys.csv] [--fit-year 2009] [--ice-rich 0.7] [--preset test|draft]

The files have the form of those of the Anaktuvuk River fire (Arctic LTER): daily soil temperatures at 4 cm (columns Date, fire with the name of the site,
Tsoil.C) and surveys of thaw depth (columns date and SITE_mean_cm, in lower case). Heat only, in a column below the sensor: 0.18 m of peat
over silt, as the source has them. What is fitted, on the surveys of the first site in the year, is the factor by which peat conducts less than full pores
would. Unburned ground tells nothing of the ground below its deepest thaw. Burned ground thaws into it, and there the permafrost of that tundra is rich
in ice (Jones et al. 2015, Scientific Reports 5, 15865): it is computed with the porosity of the silt and with that of --ice-rich, which loses its excess
ice as it thaws, so that what has thawed of it is thinner, and a probe finds less. Beside both Stefan's a sqrt(degree-days), fitted in the same way.
Without files two summers are made up and nothing is compared.
"""

import argparse
import csv
import datetime
import math

import numpy as np
from yade import O, wrapper

import talik
from talik import geometry, layers, output, plots
from talik.files import writableFolder

parser = argparse.ArgumentParser(description=__doc__.splitlines()[0])
parser.add_argument("--preset", default="draft", choices=("test", "draft", "standard"), help="size of the job")
parser.add_argument("--data", help="CSV file: Date, fire, Tsoil.C")
parser.add_argument("--surveys", help="CSV file: date, SITE_mean_cm")
parser.add_argument("--fit-year", type=int, default=2009, help="year of the first site that is fitted")
parser.add_argument("--factor", type=float, help="on what peat conducts; else it is fitted")
parser.add_argument("--ice-rich", type=float, default=0.7, help="porosity of the ground below the deepest thaw of that year, excess ice included")
parser.add_argument("--output", default="output/burned_tundra", help="folder for the results")
options = parser.parse_args()
folder = writableFolder(options.output)
if bool(options.data) != bool(options.surveys):
	raise SystemExit("give --data and --surveys together, or neither")

spacing, spinUp = {"test": (0.1, 1), "draft": (0.04, 2), "standard": (0.02, 3)}[options.preset]  # [m], times the first year before the first day
sensor, bottom, startTemperature, midwinter = 0.04, 4.0, -3.0, -8.0  # [m], insulated there [m], [degC], where a winter has no data
peatThickness = 0.18  # [m]
peat = dict(porosity=0.84, conductivity=0.25, capacity=2.6e6, freezing=dict(airEntryPressure=772.0, exponent=0.167, residualSaturation=0.05))
silt = dict(porosity=0.41, conductivity=1.62, capacity=2.0e6, freezing=dict(airEntryPressure=1308.0, exponent=0.47, residualSaturation=0.16))


def rows(path, names):
	with open(path, newline="") as file:
		found = list(csv.DictReader(file))
	if not found or any(name not in found[0] for name in names):
		raise SystemExit(f"{path} needs the columns {', '.join(names)}")
	return found


def filled(known):
	"""Temperature of each day [degC] from {day: temperature}: a winter without data falls to midwinter and rises again."""
	days = sorted(known)
	at, values = [], []
	for k, day in enumerate(days):
		at.append(day)
		values.append(known[day])
		if k + 1 < len(days) and days[k + 1] - day > 30:
			for part, share in ((0.25, 0.75), (0.5, 1.0), (0.75, 0.75)):
				at.append(day + part * (days[k + 1] - day))
				values.append(share * midwinter)
	return np.interp(np.arange(days[-1] + 1), at, values)


if options.data:
	table = [row for row in rows(options.data, ("Date", "fire", "Tsoil.C")) if row["Tsoil.C"] not in ("", "NA")]
	first = min(datetime.date.fromisoformat(row["Date"]) for row in table)
	known = {}
	for row in table:
		known.setdefault(row["fire"], {})[(datetime.date.fromisoformat(row["Date"]) - first).days] = float(row["Tsoil.C"])
	surveys = rows(options.surveys, ("date",))
	sites = sorted(known, key=lambda site: f"{site.lower()}_mean_cm" not in surveys[0])  # that with surveys first
	measured = {}
	for site in sites:
		readings = [(row["date"], row.get(f"{site.lower()}_mean_cm")) for row in surveys]
		measured[site] = {date: float(value) / 100 for date, value in readings if value not in (None, "", "NA")}
else:
	first, sites = datetime.date(options.fit_year - 1, 6, 1), ["Unburned", "Severe"]
	wave = [-math.cos(2 * math.pi * (day + 120) / 365) for day in range(460)]
	known = {site: {day: warm * up if up > 0 else 8 * up for day, up in enumerate(wave)} for site, warm in zip(sites, (4, 9))}
	measured = {site: {} for site in sites}
series = {site: filled(known[site]) for site in sites}


def dayOf(date):
	return (datetime.date.fromisoformat(date) - first).days


def material(name, soil, factor=1.0):
	return wrapper.GroundMaterial(
		name=name,
		solidConductivity=factor * soil["conductivity"],
		liquidConductivity=factor * 0.6,
		iceConductivity=factor * 2.2,
		conductivityMean="geometric",
		solidSpecificHeat=soil["capacity"] / 2650,
		freezing=wrapper.FreezingCurve(curve="vanGenuchten", **soil["freezing"]),
	)


def computed(site, factor, richBelow=None, richPorosity=None, last=None):
	"""Thaw depth of each day below the surface of that day [m]. Ground below richBelow [m] has that porosity, and that of silt once it has thawed."""
	O.reset()
	temperature = series[site][:last]
	before = spinUp * 365
	table = np.concatenate([np.tile(temperature[:365], spinUp), temperature])
	mpm = wrapper.MpmEngine(
		gridSpacing=spacing,
		lower=(0, -bottom),
		upper=(spacing, 0),
		motion=False,
		heat=wrapper.HeatTransfer(),
		freezing=wrapper.FreezingCurve(),
		materials=[material("peat", peat, factor), material("silt", silt)],
		boundaries=[
			wrapper.SurfaceTemperature(region="top", times=list(np.arange(len(table)) * talik.day), values=list(table)),
			wrapper.InsulatedBoundary(region="bottom"),
		],
		automaticTimeStep=False,
	)
	peatBottom, rich = peatThickness - sensor, (richBelow or bottom) - sensor
	outlines = [("peat", 0.0, peatBottom, peat["porosity"]), ("silt", peatBottom, rich, silt["porosity"]), ("silt", rich, bottom, richPorosity)]
	for name, top, base, porosity in outlines[: 3 if richBelow else 2]:
		outline = geometry.rectangle(0, -min(base, bottom), spacing, -top)
		geometry.fill(mpm, outline, porosity=porosity, temperature=startTemperature, material=name)
	O.engines = [mpm]
	O.dt = talik.day
	depth = sensor - mpm.field("position")[:, 1]
	order, volume = np.argsort(depth), mpm.field("volume")
	depth, half = depth[order], 0.5 * volume[order] / spacing
	strain = layers.thawStrain(richPorosity, silt["porosity"]) if richBelow else 0.0
	found = []
	for day in range(len(table)):
		O.step()
		ice = mpm.field("iceSaturation")[order]
		frozen = np.flatnonzero(ice > 0.3)  # what a probe feels
		k = frozen[0] if len(frozen) else len(depth) - 1
		deepest = depth[k] - half[k] + 2 * half[k] * (1 - min(1.0, ice[k] / 0.8))
		if day >= before:
			found.append(deepest - strain * max(0.0, deepest - (richBelow or bottom)) if table[day] > 0 else 0.0)
	return np.array(found)


def offBy(thaw, site, years):
	"""Mean and root mean square of computed less measured [m]."""
	off = [thaw[dayOf(date)] - value for date, value in measured[site].items() if int(date[:4]) in years and 0 <= dayOf(date) < len(thaw)]
	return (np.mean(off), math.sqrt(np.mean(np.square(off)))) if off else (math.nan, math.nan)


unburned, fitYear, factor = sites[0], options.fit_year, options.factor or 1.0
if options.data and not options.factor:
	if not math.isfinite(offBy(np.zeros(len(series[unburned])), unburned, [fitYear])[0]):
		raise SystemExit(f"--fit-year {fitYear}: {options.surveys} has no survey of {unburned} in that year")
	last = (datetime.date(fitYear, 12, 31) - first).days + 1
	low, high = 0.2, 1.6
	for _ in range(6):  # the depth grows with what peat conducts
		factor = 0.5 * (low + high)
		bias, rms = offBy(computed(unburned, factor, last=last), unburned, [fitYear])
		print(f"peat conducts {factor:.3f} times what full pores would: {100 * bias:+.1f} cm, rms {100 * rms:.1f} cm in {fitYear}", flush=True)
		low, high = (low, factor) if bias > 0 else (factor, high)
richBelow = max([value for date, value in measured[unburned].items() if int(date[:4]) == fitYear], default=0.5)
runs = {site: {"silt below": computed(site, factor)} for site in sites}
for site in sites[1:]:
	runs[site]["ice-rich below"] = computed(site, factor, richBelow, options.ice_rich)

sums = {}
for site in sites:
	sums[site] = np.zeros(len(series[site]))
	for day, value in enumerate(series[site]):
		begins = (first + datetime.timedelta(days=day)).timetuple().tm_yday == 1
		sums[site][day] = max(0.0, value) + (0.0 if begins or day == 0 else sums[site][day - 1])
fitted = [(math.sqrt(sums[unburned][dayOf(date)]), value - sensor) for date, value in measured[unburned].items() if int(date[:4]) == fitYear]
slope = sum(x * y for x, y in fitted) / sum(x * x for x, _ in fitted) if fitted else 0.02
for site in sites:
	runs[site]["Stefan"] = np.where(series[site] > 0, sensor + slope * np.sqrt(sums[site]), 0.0)

dates = sorted(date for date in measured[unburned] if int(date[:4]) >= fitYear and dayOf(date) < max(map(len, series.values())))
columns = [(site, name) for site in sites for name in runs[site]]
print(
	"| date | measured, " + unburned + " | " + " | ".join(f"{site}, {name}" for site, name in columns) + " |", "|---|" + "---|" * (1 + len(columns)), sep="\n"
)
for date in dates:
	cells = [f"{100 * runs[site][name][dayOf(date)]:.0f}" if dayOf(date) < len(runs[site][name]) else "" for site, name in columns]
	print(f"| {date} | {100 * measured[unburned][date]:.0f} | " + " | ".join(cells) + " |")
for site in sites:
	for name, thaw in runs[site].items():
		for years in ([fitYear], range(fitYear + 1, 2100)):
			bias, rms = offBy(thaw, site, years)
			if math.isfinite(bias):
				print(f"{site}, {name}, {years[0]}{' and later' if len(years) > 1 else ''}: {100 * bias:+.1f} cm, rms {100 * rms:.1f} cm")

figure = plots.figure(9, 5)
axes = figure.subplots()
styles = {"silt below": "-", "ice-rich below": "--", "Stefan": ":"}
for site, colour in zip(sites, ("tab:blue", "tab:red", "tab:orange", "tab:green")):
	for name, thaw in runs[site].items():
		when = [first + datetime.timedelta(days=day) for day in range(len(thaw))]
		axes.plot(when, np.where(thaw > 0, 100 * thaw, np.nan), styles[name], color=colour, linewidth=1, label=f"{site}, {name}")
	axes.plot([datetime.date.fromisoformat(date) for date in measured[site]], [100 * value for value in measured[site].values()], "o", color=colour, ms=4)
axes.set(ylabel="thaw depth [cm]", ylim=(0, None), xlim=(first, first + datetime.timedelta(days=max(map(len, series.values())))))
axes.set_ylim(1.15 * axes.get_ylim()[1], 0)  # downwards, with room for the legend
axes.legend(frameon=False, fontsize=7, ncols=len(sites))
plots.save(figure, folder / "burned_tundra.png", dpi=100)
deepest = {f"{site}, {name} [m]": float(thaw.max()) for site in sites for name, thaw in runs[site].items()}
output.writeSummary(folder / "summary.json", **{"factor on the conductivity of peat": factor, "deepest thaw": deepest})
if not all(sensor < value < bottom for value in deepest.values()):
	output.unexpected("the ground never thaws, or thaws to its base")
print(f"picture and summary are in {folder}")
