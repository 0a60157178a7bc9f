# SPDX-License-Identifier: GPL-2.0-or-later
"""A column of ice-rich ground thaws from its surface and settles, against the hand calculation.

	scripts/run thaw_settlement_column [--preset test|draft|standard] [--porosity 0.6] [--thawed-porosity 0.42] [--surface 5]

By hand: grains keep their volume, pores shrink from n_0 with the excess ice to n_1 of the thawed soil, so that a height H settles
by H (1 - (1 - n_0)/(1 - n_1)). Give your two porosities; change the law first.
"""

import argparse

from yade import O

import talik
from talik import output, plots
from talik.files import writableFolder

parser = argparse.ArgumentParser(description=__doc__.splitlines()[0])
parser.add_argument("--preset", default="draft", choices=("test", "draft", "standard"), help="size of the job")
parser.add_argument("--output", default="output/thaw_settlement_column", help="folder for the results")
parser.add_argument("--porosity", type=float, default=0.6, help="frozen, with its excess ice [-], below 0.9")
parser.add_argument("--thawed-porosity", type=float, default=0.42, help="of the thawed soil [-], above 0.1, at most --porosity")
parser.add_argument("--surface", type=float, default=5.0, help="temperature of the surface [degC], above 0")
options = parser.parse_args()
if not 0.1 < options.thawed_porosity < options.porosity < 0.9 or not options.surface > 0:
	raise SystemExit("give 0.1 < --thawed-porosity < --porosity < 0.9, and --surface above 0")
folder = writableFolder(options.output)

h = {"test": 0.1, "draft": 0.05, "standard": 0.025}[options.preset]  # grid spacing [m]
height, porosity, thawedPorosity = 1.0, options.porosity, options.thawed_porosity
iceRich = GroundMaterial(name="ice-rich silt", solidConductivity=2.0, thawStrain=talik.layers.thawStrain(porosity, thawedPorosity))
mpm = MpmEngine(
	gridSpacing=h,
	lower=(0, 0),
	upper=(2 * h, height + 2 * h),
	gravity=(0, -9.81),
	damping=0.3,
	heat=HeatTransfer(thermalTimeScale=1e6),
	freezing=FreezingCurve(),
	skeleton=MohrCoulombSkeleton(young=1e7, youngFrozen=1e8, frictionAngle=30, cohesion=0, cohesionFrozen=2e5),
	boundaries=[RollerBoundary(region=side) for side in ("left", "right", "bottom")] + [SurfaceTemperature(region="surface", temperature=options.surface)],
)
outline = talik.geometry.rectangle(0, 0, 2 * h, height)
talik.layers.fill(mpm, {"column": dict(polygon=outline, porosity=porosity, temperature=-1, material=iceRich)}, lateralRatio=0.5)
O.engines = [mpm]
O.step()

rows = [(0.0, 0.0)]
while mpm.field("iceSaturation").max() > 0:
	talik.runUntilDay(mpm, mpm.calendar["day"] + 5)
	rows.append((mpm.calendar["day"], height - mpm.field("volume").sum() / (2 * h)))
talik.runSerially(2000)  # the last cell comes to rest

settlement = height - mpm.field("volume").sum() / (2 * h)
byHand = height * (1 - (1 - porosity) / (1 - thawedPorosity))
print(f"{mpm.pointCount} points, {O.iter} steps; all ice has melted on day {rows[-1][0]:.0f}")
print(f"settlement {1e3 * settlement:.1f} mm, by hand {1e3 * byHand:.1f} mm; porosity {mpm.field('porosity').mean():.3f}, by hand {thawedPorosity}")

figure = plots.figure(7, 4)
axes = figure.subplots()
days, settlements = zip(*rows)
axes.plot(days, [1e3 * s for s in settlements], color="black", label="settlement of the surface")
axes.axhline(1e3 * byHand, color="crimson", linestyle="--", label="H (1 - (1 - n_0)/(1 - n_1))")
axes.set_xlabel("time [days]")
axes.set_ylabel("settlement [mm]")
axes.legend()
plots.save(figure, folder / "thaw_settlement_column.png", dpi=100)
output.writeSummary(folder / "summary.json", **{"settlement [m]": settlement, "by hand [m]": byHand, "thawed after [d]": days[-1]})
if abs(settlement / byHand - 1) > 0.04:
	output.unexpected("the settlement is more than 4 % off the calculation by hand")
print(f"picture and summary are in {folder}")
