# SPDX-License-Identifier: GPL-2.0-or-later
"""A heave test of the laboratory as a prediction: silt freezes from above in a cell of 10 cm, beside what was measured.

	scripts/run heave_test [--readings ns5.csv] [--until 20] [--preset test|draft]

The test is NS-5 of Konrad & Morgenstern (1980, Can. Geotech. J. 17, 473): Devon silt, water free at the warm base, no load, +1.1 and -6.2 degC at the
ends. Three computations: with the segregation potentials that were published for Devon silt (6e-10 to 1.4e-9 m2/(s K)), nothing fitted; with a
potential fitted to the readings until an hour, which predicts later ones; and with segregation computed from the soil alone, IceSegregation(), which is
an upper bound. Suction at the front lowers the potentials as a load does (Konrad & Morgenstern 1982, Can. Geotech. J. 19, 494).
Beside them the usual hand calculation, fitted in the same way: a quasi-steady front that draws SP times the gradient behind it.
--readings names a CSV file of hours and heave [mm]; without it nothing is fitted.
"""

import argparse

import numpy as np
from yade import O

import talik
from talik import output, plots, tables
from talik.files import writableFolder

parser = argparse.ArgumentParser(description=__doc__.splitlines()[0])
parser.add_argument("--preset", default="draft", choices=("test", "draft", "standard"), help="size of the job")
parser.add_argument("--readings", help="CSV file: time [h], heave [mm]")
parser.add_argument("--until", type=float, default=20.0, help="hour up to which readings are fitted")
parser.add_argument("--output", default="output/heave_test", help="folder for the results")
options = parser.parse_args()
folder = writableFolder(options.output)

h, last = {"test": (0.01, 10), "draft": (0.01, 50), "standard": (0.005, 50)}[options.preset]  # grid spacing [m], hours
hours = [hour for hour in (5, 10, 15, 20, 25, 30, 40, 50) if hour <= last]
height, porosity, conductivity = 0.10, 0.38, 1e-9  # of the column [m]; k [m/s]
warm, cold = 1.1, -6.2  # ends [degC]
grains, liquid, ice, latent = 3.0, 0.56, 2.18, 334e3  # thermal conductivities [W/(m K)], latent heat [J/kg]
published = (6e-10, 1e-9, 1.4e-9)  # segregation potentials of Devon silt without load [m2/(s K)]


def heaveOf(segregation):
	"""Heave [mm] at the hours, by the volume of all points, and at the end the path of the surface, the excess ice and the thickness that has frozen [mm].

	Points beside a thick lens part from it or reach into it, which moves the surface and no volume."""
	O.reset()
	mpm = MpmEngine(
		gridSpacing=h,
		lower=(0, 0),
		upper=(h, height + 0.08),
		gravity=(0, -9.81),
		damping=0.3,
		material=GroundMaterial(
			solidConductivity=grains,
			liquidConductivity=liquid,
			iceConductivity=ice,
			conductivityMean="geometric",
			solidSpecificHeat=1.53e6 / (2650 * (1 - porosity)),
		),
		heat=HeatTransfer(thermalTimeScale=1e5),
		freezing=FreezingCurve(width=0.3),
		water=PoreWater(conductivity=conductivity, referencePorosity=porosity, cavitationPressure=-1e5),
		segregation=segregation,
		skeleton=MohrCoulombSkeleton(young=1e7, youngFrozen=5e7, frictionAngle=30, cohesion=0, cohesionFrozen=5e5),
		boundaries=[
			*(RollerBoundary(region=side) for side in ("left", "right", "bottom")),
			WallTemperature(region="bottom", temperature=warm),
			DrainedBoundary(region="bottom", pressure=0, recharge=True),
			SurfaceTemperature(region="surface", temperature=cold),
		],
	)
	column = dict(polygon=talik.geometry.rectangle(0, 0, h, height), porosity=porosity, temperature=warm, pressure=lambda x, y: -9810 * y)
	talik.layers.fill(mpm, {"silt": column}, lateralRatio=0.5)
	O.engines = [mpm]
	O.step()
	mpm.resetDisplacement()
	top, heave = int(np.argmax(mpm.field("position")[:, 1])), []
	for hour in hours:
		talik.runUntilDay(mpm, hour / 24)
		heave.append(1e3 * (mpm.field("volume").sum() / h - height))
	frozen = 1e3 * height * np.mean(mpm.field("iceSaturation") > 0.5)
	return np.array(heave), 1e3 * mpm.field("displacement")[top, 1], 1e3 * mpm.field("segregatedVolume").sum() / h, frozen


def byHand(potential):
	"""Heave [mm] at the hours of a front at the depth Z: k_f (-T_c)/Z - k_u T_w/(L - Z) = L (n rho_i Z' + rho_w SP G)."""
	frozenConductivity = grains ** (1 - porosity) * ice**porosity
	thawedConductivity = grains ** (1 - porosity) * liquid**porosity
	depth, heave, found, step = 1e-3, 0.0, [], 10.0
	for second in np.arange(0, last * 3600 + step, step):
		if any(abs(second - 3600 * hour) < 0.5 * step for hour in hours):
			found.append(1e3 * heave)
		gradient = -cold / (depth + heave)
		drawn = potential * gradient
		heat = frozenConductivity * gradient - thawedConductivity * warm / (height - depth)
		depth += step * (heat - 1000 * latent * drawn) / (917 * latent * porosity)
		heave += step * drawn / 0.917
	return np.array(found[: len(hours)])


def fitted(heave, readings):
	"""Potential whose heave has the least squares of differences from the readings; the heave is nearly proportional to it."""
	when, wanted = np.transpose([row for row in readings if row[0] <= options.until])
	at, step = 0.8e-9, 1.0
	while abs(step - 1) > 0.005 or step == 1.0:
		found = np.interp(when, [0, *hours], [0, *heave(at)])
		step = (found @ wanted) / (found @ found)
		at *= step
	return at


law = dict(pressureDecay=5e-6)  # the middle of 1e-6 to 1e-5 of soils: no load, but the front that draws water makes suction, which counts as load
curves = {f"SP {potential:g}": heaveOf(IceSegregation(segregationPotential=potential, **law)) for potential in published}
curves["computed"] = heaveOf(IceSegregation())
readings = tables.read(options.readings, ("time", "heave")) if options.readings else []
if readings and not any(row[0] <= options.until for row in readings):
	raise SystemExit(f"{options.readings} has no reading until hour {options.until:g}; give --until a later one")
if readings:
	potential = fitted(lambda at: heaveOf(IceSegregation(segregationPotential=at, **law))[0], readings)
	curves[f"fitted, SP {potential:.3g}"] = heaveOf(IceSegregation(segregationPotential=potential, **law))
	alone = fitted(byHand, readings)
	curves[f"by hand, fitted, SP {alone:.3g}"] = byHand(alone), np.nan, np.nan, np.nan
names = list(curves)
lines = ["| hour | measured | " + " | ".join(names) + " |", "|---|" + "---|" * (1 + len(names))]
for k, hour in enumerate(hours):
	known = [f"{row[1]:.1f}" for row in readings if row[0] == hour]
	lines.append(f"| {hour} | {(known or [''])[0]} | " + " | ".join(f"{curves[name][0][k]:.1f}" for name in names) + " |")
print("heave [mm]", *lines, sep="\n")
for name, (heave, surface, excess, frozen) in curves.items():
	print(f"{name}: heave {heave[-1]:.1f} mm, of the surface {surface:.1f} mm, excess ice {excess:.1f} mm, frozen {frozen:.0f} mm")

figure = plots.figure(7.5, 5)
axes = figure.subplots()
low, middle, high = (curves[f"SP {potential:g}"][0] for potential in published)
start = [0, *hours]
axes.fill_between(start, [0, *low], [0, *high], color="tab:blue", alpha=0.15, label="nothing fitted: SP 6e-10 to 1.4e-9")
axes.plot(start, [0, *middle], color="tab:blue", label="SP 1e-9")
for name, style in zip(names[3:], ("tab:green", "black", "0.6")):
	axes.plot(start, [0, *curves[name][0]], "--" if name.startswith("by") else "-", color=style, label=name)
if readings:
	axes.plot(*np.transpose(readings), "o", color="firebrick", label="measured")
axes.set(xlabel="time [h]", ylabel="heave [mm]", xlim=(0, last), ylim=(0, None))
axes.legend(frameon=False, fontsize=8)
plots.save(figure, folder / "heave_test.png", dpi=100)
output.writeSummary(folder / "summary.json", **{"hours": hours, "heave [mm]": {name: list(map(float, curve[0])) for name, curve in curves.items()}})
if not (low < middle).all() or not (middle < high).all():
	output.unexpected("more segregation potential does not heave more")
print(f"picture and summary are in {folder}")
