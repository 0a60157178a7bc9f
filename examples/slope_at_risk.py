# SPDX-License-Identifier: GPL-2.0-or-later
"""How safe is a slope of silt while it thaws, and how probable is it that it moves, with the little that is known of its soil?

	scripts/run slope_at_risk [--preset test|draft|standard] [--cohesion 2000] [--friction 32] [--conductivity 1e-7] [--thaw-strain 0.04] [--surface 6]

Two answers for the same slope of 27° and 2 m, frozen at -1 °C, whose surface stays at 6 °C for sixty days:

- the factor of safety by strength reduction on several days, for the soil that is most likely;
- the displacement on the last day for soils drawn by chance, as the probability that each place moves by more than 0.1 m, and as the probability
  that a displacement is exceeded anywhere, with the confidence that the number of runs allows.

The options are the soil that is most likely. Change what is believed of it (`believed`) and the outline first.
"""

import argparse

import numpy as np
from scipy import stats
from yade import O, wrapper

import talik
from talik import forecast, output, plots
from talik.files import writableFolder

parser = argparse.ArgumentParser(description=__doc__.splitlines()[0])
parser.add_argument("--preset", default="draft", choices=("test", "draft", "standard"), help="size of the job")
parser.add_argument("--output", default="output/slope_at_risk", help="folder for the results")
parser.add_argument("--runs", type=int, help="soils drawn by chance")
parser.add_argument("--cohesion", type=float, default=2e3, help="of thawed ground [Pa], above 0: median of the soils")
parser.add_argument("--friction", type=float, default=32.0, help="friction angle [degrees], 10 to 45: mean of the soils")
parser.add_argument("--conductivity", type=float, default=1e-7, help="hydraulic, of thawed ground [m/s], above 0: median of the soils")
parser.add_argument(
	"--thaw-strain", type=float, default=0.04, help="part of its volume that ground loses as it thaws [-], above 0, below 0.5: mean of the soils"
)
parser.add_argument("--surface", type=float, default=6.0, help="temperature of the surface [degC], above 0")
options = parser.parse_args()
folder = writableFolder(options.output)

spacing = {"test": 0.5, "draft": 0.25, "standard": 0.125}[options.preset]  # [m]
runs = options.runs or {"test": 4, "draft": 30, "standard": 100}[options.preset]
outline = [(0, 0), (10, 0), (10, 1), (8, 1), (4, 3), (0, 3)]  # [m]
days, moves = (15.0, 30.0, 60.0), 0.1  # of the calendar; displacement that counts as motion [m]
for name, lowest, highest in (("cohesion", 0, 1e6), ("friction", 10, 45), ("conductivity", 0, 1), ("thaw_strain", 0, 0.5), ("surface", 0, 40)):
	if not lowest < getattr(options, name) < highest:
		raise SystemExit(f"--{name.replace('_', '-')} {getattr(options, name):g}: give a number between {lowest:g} and {highest:g}")
likely = dict(friction=options.friction, cohesion=options.cohesion, conductivity=options.conductivity, thawStrain=options.thaw_strain)
believed = dict(
	friction=stats.norm(loc=options.friction, scale=2),
	cohesion=stats.lognorm(s=0.4, scale=options.cohesion),
	conductivity=stats.lognorm(s=1.0, scale=options.conductivity),
	thawStrain=stats.beta(4, 4 / options.thaw_strain - 4),
)


def ground(soil):
	O.reset()
	mpm = wrapper.MpmEngine(
		gridSpacing=spacing,
		lower=(0, 0),
		upper=(10, 4),
		gravity=(0, -9.81),
		damping=0.3,
		heat=wrapper.HeatTransfer(thermalTimeScale=2e6, followsMotion=True),
		freezing=wrapper.FreezingCurve(),
		water=wrapper.PoreWater(conductivity=soil["conductivity"], pressure="implicit"),
		skeleton=wrapper.MohrCoulombSkeleton(young=1e7, youngFrozen=4e7, frictionAngle=soil["friction"], cohesion=soil["cohesion"], cohesionFrozen=3e5),
		boundaries=[
			*(wrapper.RollerBoundary(region=side) for side in ("left", "right")),
			wrapper.FixedBoundary(region="bottom"),
			wrapper.SurfaceTemperature(region="surface", temperature=options.surface),
			wrapper.DrainedBoundary(region="surface"),
		],
	)
	silt = wrapper.GroundMaterial(name="silt", thawStrain=soil["thawStrain"])
	talik.layers.fill(mpm, {"silt": dict(polygon=outline, porosity=0.45, temperature=-1, material=silt)}, lateralRatio=0.5)
	O.engines = [mpm]
	return mpm


def safetyWhileItThaws():
	"""Of the most likely soil: factors over the days, and what was found on the day of the smallest one."""
	mpm, found = ground(likely), []
	for day in days:
		talik.runUntilDay(mpm, day)
		found.append(talik.slope.factorOfSafety(mpm, accuracy=0.05, between=(0.3, 5.0)))
		print(f"day {day:g}, thawed to {talik.thermal.thawDepth(mpm)['depth'].max():.2f} m: {found[-1]}", flush=True)
	return found


def motionOf(row):
	"""Fields of the ground on the last day; a slope that slides by a metre has gone, and its run ends there."""
	mpm = ground(row)
	talik.runUntilDay(mpm, days[-1], look=lambda: plots.magnitude(mpm.field("displacement")).max() > 1.0)
	return output.allFields(mpm)


safety = safetyWhileItThaws()
rows = forecast.draw(believed, runs=runs)
frames = []
for row in rows:
	frames.append(motionOf(row))
	print(f"soil {len(frames)} of {runs}: {plots.magnitude(frames[-1]['displacement']).max():.3f} m", flush=True)
largest = [plots.magnitude(frame["displacement"]).max() for frame in frames]
exceeded = forecast.Exceedance(largest, "largest displacement [m]")
print(exceeded)

figure = plots.figure(11, 7)
mechanism, ofDays, place, curve = figure.subplots(2, 2, width_ratios=(2, 1)).ravel()
weakest = min(range(len(days)), key=lambda k: safety[k].factor)
plots.ground(mechanism, safety[weakest].frame, "deviatoricStrain", arrows="displacement", start=False)
mechanism.set_title(f"mechanism on day {days[weakest]:g}, F = {safety[weakest].factor:.2f}", fontsize=10)
ofDays.plot(days, [one.factor for one in safety], "o-", color="black")
ofDays.axhline(1, color="crimson", linewidth=0.8)
ofDays.set(xlabel="day of thaw", ylabel="factor of safety", ylim=(0, None))
risk = forecast.probabilityMap([[frame] for frame in frames], above=moves)
size = np.full(len(risk.place), risk.side**2)
plots.slopeField(place, risk.place, 100 * risk.share, size, label=f"moves by more than {moves} m by day {days[-1]:g} [%]", colourMap="magma_r", limits=(0, 100))
exceeded.draw(curve)
plots.save(figure, folder / "slope_at_risk.png", dpi=100)
output.writeSummary(
	folder / "summary.json",
	**{
		"preset": options.preset,
		"days": list(days),
		"factors of safety [-]": [one.factor for one in safety],
		"runs": runs,
		"largest displacements [m]": [float(one) for one in largest],
		f"probability of more than {moves} m [-]": float(np.mean(np.array(largest) > moves)),
	},
)
print(f"picture and summary are in {folder}")
