# SPDX-License-Identifier: GPL-2.0-or-later
"""A slope without end that freezes and thaws for three years: heave, settlement and path, beside those measured at Endalen, Svalbard.

	scripts/run field_slope [--preset test|draft] [--vary potential active excess supply …]

One column of cells (talik.slope.infiniteColumn) at 7 degrees: an active layer of 0.94 m over an ice-rich transient layer and permafrost. Measured by Harris
et al. (2011, Permafr. Periglac. 22, 239, abstract) in the years from 2005 to 2008: frost heave 4.2, 6.6, 3.2 cm; path of the surface downslope 2.3,
1.2, 1.0 cm; shear at the base of the active layer in the first and third; the surface 6.2 cm lower after three years. The same soil at 12, 18 and 24
degrees for a year stands beside the centrifuge tests of Harris, Rea & Davies (2001, doi 10.1002/ppp.373): 187 mm, 651 mm, mudflow.
The soil is that of examples/centrifuge_slopes.py; segregation potential, excess ice, summers and permeability are assumptions, and --vary shows what each does.
"""

import argparse
import math
from dataclasses import dataclass, replace

import numpy as np
from yade import O

import talik
from talik import output, plots
from talik.files import writableFolder, writeWhole

measured = dict(heave=(42, 66, 32), path=(23, 12, 10), sunk=62)  # [mm]
centrifuge = {12: "187", 18: "651", 24: "mudflow"}  # path in a cycle [mm]
flowing = 1.5  # path from which on a slope flows [m]
winter, summer = 110.0, 100.0  # [days]
gravity, density = 9.81, 0.55 * 2650 + 0.45 * 1000


@dataclass(frozen=True)
class Assumptions:
	angle: float = 7.0  # [degrees]
	potential: float = 5e-10  # SP_0 [m2/(s K)]: about what heave_test fits to Devon silt
	active: float = 0.9  # thickness of the active layer [m]
	excess: float = 0.2  # excess ice of the transient layer below it [-]
	conductivity: float = 2e-7  # [m/s]
	supply: float = 0.0  # 1: water at the pressure of a table at the surface seeps in at the base, too
	cohesion: float = 800.0  # of thawed ground [Pa]
	frictionAngle: float = 33.5  # [degrees]
	young: float = 2e6  # of thawed ground [Pa]
	cold: float = -8.0  # surface in winter [degC]
	summers: tuple = (10.5, 9.5, 12.0)  # surface in the three summers [degC]: thaw by 0.94 m, and at last 14 cm deeper
	gridSpacing: float = 0.1  # [m]


variations = {
	"potential": (0.0, 1e-9, 2e-9),
	"active": (0.8,),
	"excess": (0.4,),
	"conductivity": (5e-8,),
	"supply": (1.0,),
	"cohesion": (400.0, 2000.0),
	"young": (1e6,),
	"gridSpacing": (0.05,),
}


def build(slope):
	days, values = [0.0, 2.0], [0.5, slope.cold]
	for year, warm in enumerate(slope.summers):
		thaw = year * (winter + summer) + winter
		days += [thaw, thaw + 2, thaw + summer, thaw + summer + 2]
		values += [slope.cold, warm, warm, slope.cold]
	# the strength of the law in simple shear without dilation is c cos phi + sigma sin phi
	sine, ratio = math.tan(math.radians(slope.frictionAngle)), math.tan(math.radians(slope.frictionAngle))
	angle = math.asin(sine)
	base = 1.4
	cold = lambda x, y: -0.3 - 2.7 * np.clip(0.5 - y, 0, 0.5) / 0.5
	below = [WallTemperature(region="bottom", temperature=-3)]
	if slope.supply:
		below.append(DrainedBoundary(region="bottom", pressure=1000 * gravity * math.cos(math.radians(slope.angle)) * base, recharge=True))
	mpm = MpmEngine(
		gridSpacing=slope.gridSpacing,
		damping=0.1,
		thawFront=None,  # with two velocities a row that has just thawed slides as if on water
		heat=HeatTransfer(thermalTimeScale=min(5e5, 0.05 / slope.conductivity), followsMotion=True, motionTolerance=0.1),
		freezing=FreezingCurve(width=0.3),
		water=PoreWater(conductivity=slope.conductivity, referencePorosity=0.45, impedance=2, cavitationPressure=-1e5),
		segregation=IceSegregation(segregationPotential=slope.potential, pressureDecay=8e-6),
		skeleton=MohrCoulombSkeleton(
			young=slope.young,
			youngFrozen=2e7,
			frictionAngle=math.degrees(angle),
			cohesion=slope.cohesion / math.cos(angle),
			tensileStrength=slope.cohesion / ratio,
			cohesionFrozen=5e5,
			tensileStrengthFrozen=3e5,
		),
		boundaries=[DrainedBoundary(region="surface"), *below, SurfaceTemperature(region="surface", days=days, values=values)],
	)
	silt = GroundMaterial(name="silt", solidConductivity=2)
	transient = GroundMaterial(name="transient", solidConductivity=2, thawStrain=slope.excess)
	rich = 1 - 0.55 * (1 - slope.excess)
	layers = {
		"active": dict(thickness=slope.active, porosity=0.45, temperature=0.3, material=silt),
		"transient": dict(thickness=1.2 - slope.active, porosity=rich, temperature=cold, material=transient),
		"permafrost": dict(thickness=0.2, porosity=0.45, temperature=cold, material=silt),
	}
	talik.slope.infiniteColumn(mpm, slope.angle, layers, waterDepth=0.0)
	return mpm


def years(slope, number):
	"""Of each year: heave, settlement, path of the surface and of the base of the active layer [mm], excess ice [mm], depth of thaw [m]."""
	O.reset()
	mpm = build(slope)
	O.engines = [mpm]
	O.step()
	mpm.resetDisplacement()
	start = mpm.field("position")[:, 1]
	order = np.argsort(start)
	depth = 1.4 - start[order]
	base = int(np.argmin(np.abs(depth - 0.95)))

	def moved():
		return mpm.field("displacement")[order]

	def runUntil(day):
		"""True when it has come to that day, False when the slope flows before."""
		while mpm.calendar["day"] < day - 1e-6:
			if moved()[-1, 0] > flowing:
				return False
			talik.runSerially(300)
		return True

	found, before, reached = [], moved(), 0.0
	for year in range(number):
		day = year * (winter + summer)
		runUntil(day + winter)
		frozen = moved()
		ice = 1e3 * mpm.field("segregatedVolume").sum() / slope.gridSpacing
		for part in np.arange(10, summer + 1, 10):
			flows = not runUntil(day + winter + part)
			warm = mpm.field("iceSaturation")[order] < 0.5
			reached = max(reached, depth[warm].max() + 0.5 * slope.gridSpacing if warm.any() else 0.0)
			if flows:
				break
		after = moved()
		found.append(
			dict(
				heave=1e3 * (frozen[-1, 1] - before[-1, 1]),
				settlement=1e3 * (frozen[-1, 1] - after[-1, 1]),
				path=1e3 * (after[-1, 0] - before[-1, 0]),
				basal=1e3 * (after[base, 0] - before[base, 0]),
				ice=ice,
				thaw=reached,
				profile=1e3 * (after[:, 0] - before[:, 0]),
				depth=depth,
				day=mpm.calendar["day"],
			)
		)
		before, reached = after, 0.0
		if after[-1, 0] > flowing:
			break
	return found


def said(values, digits=0):
	return ", ".join(f"{round(value, digits) + 0.0:.{digits}f}" for value in values)


def moved(year):
	"""Path, settlement and heave of a year, or when the slope flows."""
	if year["path"] > 1e3 * flowing:
		return f"flows on day {year['day']:.0f} ({year['heave']:.0f} of heave)"
	return f"{year['path']:.0f} ({year['settlement']:.0f}; {year['heave']:.0f})"


def row(name, found):
	sunk = sum(year["settlement"] - year["heave"] for year in found)
	cells = [said(year[key] for year in found) for key in ("heave", "settlement", "path", "basal", "ice")]
	return f"| {name} | {' | '.join(cells)} | {said((year['thaw'] for year in found), 2)} | {said([sunk])} |"


parser = argparse.ArgumentParser(description=__doc__.splitlines()[0])
parser.add_argument("--preset", default="draft", choices=("test", "draft"), help="size of the job")
parser.add_argument("--vary", nargs="*", default=(), choices=tuple(variations), metavar="ASSUMPTION", help=f"of {', '.join(variations)}: with other values")
parser.add_argument("--output", default="output/field_slope", help="folder for the results")
options = parser.parse_args()
folder = writableFolder(options.output)

number = {"test": 1, "draft": 3}[options.preset]
steeper = {"test": (24,), "draft": tuple(centrifuge)}[options.preset]
usual = Assumptions()
assumed = [("as assumed", {}), *((f"{name} {value:g}", {name: value}) for name in options.vary for value in variations[name])]
runs = {}  # by assumption and slope
for name, changes in assumed:
	for angle in (usual.angle, *steeper):
		runs[name, angle] = years(replace(usual, angle=float(angle), **changes), number if angle == usual.angle else 1)
		print(f"{name}, {angle:g}°: path {said(year['path'] for year in runs[name, angle])} mm", flush=True)

lines = [
	"| at 7°, of each year | heave [mm] | settlement [mm] | path [mm] | path at 0.95 m [mm] | excess ice [mm] | thaw [m] | lower after all [mm] |",
	"|---|---|---|---|---|---|---|---|",
	f"| **measured** | {said(measured['heave'])} | more than the heave | {said(measured['path'])} | in years 1 and 3 | | 0.94 to 1.08 | {measured['sunk']} |",
	*(row(name, runs[name, usual.angle]) for name, _ in assumed),
	"",
	"| of one soil in the first year, path (settlement; heave) [mm] | 7° | " + " | ".join(f"{angle}°" for angle in steeper) + " |",
	"|---|---|" + "---|" * len(steeper),
	f"| **measured** | {measured['path'][0]} (more than {measured['heave'][0]}; {measured['heave'][0]}) | "
	+ " | ".join(centrifuge[angle] for angle in steeper)
	+ " |",
	*(f"| {name} | " + " | ".join(moved(runs[name, angle][0]) for angle in (usual.angle, *steeper)) + " |" for name, _ in assumed),
]
print(*lines, sep="\n")
writeWhole(folder / "table.md", "\n".join(lines) + "\n")

here = runs["as assumed", usual.angle]
figure = plots.figure(9, 4)
bars, profile = figure.subplots(1, 2)
for k, (name, year) in enumerate((key, found) for key in ("heave", "path") for found in [here]):
	place = np.arange(len(year)) + 4 * k
	bars.bar(place - 0.2, measured[name][: len(year)], 0.4, color="firebrick", label="measured" if k == 0 else None)
	bars.bar(place + 0.2, [found[name] for found in year], 0.4, color="0.5", label="computed" if k == 0 else None)
bars.set(ylabel="[mm]", xticks=(1, 5), xticklabels=("frost heave, three years", "path downslope, three years"))
bars.legend(frameon=False)
for k, found in enumerate(here):
	profile.plot(found["profile"], found["depth"], "o-", markersize=3, label=f"year {k + 1}")
profile.invert_yaxis()
profile.set(xlabel="path downslope in the year [mm]", ylabel="depth [m]")
profile.legend(frameon=False)
plots.save(figure, folder / "field_slope.png", dpi=100)
output.writeSummary(
	folder / "summary.json",
	**{f"{key} [mm]": [float(found[key]) for found in here] for key in ("heave", "settlement", "path", "ice")},
)
if not (here[0]["heave"] > 0 and here[0]["path"] > 0):
	output.unexpected("the slope does not heave in winter, or does not move downslope")
if not all(runs[name, angle][0]["path"] > runs[name, usual.angle][0]["path"] for name, angle in runs if angle != usual.angle):
	output.unexpected("a steeper slope of the same soil moves less")
print(f"picture and table are in {folder}")
