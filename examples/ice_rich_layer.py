# SPDX-License-Identifier: GPL-2.0-or-later
"""A lens of ice-rich ground in silt thaws from the surface; the ground settles where the lens was.

	scripts/run ice_rich_layer [--preset test|draft|standard] [--silt-porosity 0.4] [--porosity 0.7] [--thawed-porosity 0.5] [--surface 5]

By hand: the settled area of the profile is the thaw strain times the area of the lens, and the thaw reaches the highest point of the lens after the
days of Stefan's formula, L d^2/(2 k T) with the latent heat L = n rho_i L_f and the conductivity k of thawed silt. Give your
porosities; change the outline of the lens first.
"""

import argparse

import numpy as np
from yade import O

import talik
from talik import output, plots
from talik.files import writableFolder

parser = argparse.ArgumentParser(description=__doc__.splitlines()[0])
parser.add_argument("--preset", default="draft", choices=("test", "draft", "standard"), help="size of the job")
parser.add_argument("--output", default="output/ice_rich_layer", help="folder for the results")
parser.add_argument("--silt-porosity", type=float, default=0.4, help="of the silt around the lens [-], 0.1 to 0.9")
parser.add_argument("--porosity", type=float, default=0.7, help="of the lens, frozen, with its excess ice [-], below 0.9")
parser.add_argument("--thawed-porosity", type=float, default=0.5, help="of the thawed lens [-], above 0.1, at most --porosity")
parser.add_argument("--surface", type=float, default=5.0, help="temperature of the surface [degC], 1 to 40")
options = parser.parse_args()
if not 0.1 < options.thawed_porosity < options.porosity < 0.9:
	raise SystemExit("give 0.1 < --thawed-porosity < --porosity < 0.9")
for name, lowest, highest in (("silt_porosity", 0.1, 0.9), ("surface", 1, 40)):
	if not lowest < getattr(options, name) < highest:
		raise SystemExit(f"--{name.replace('_', '-')} {getattr(options, name):g}: give a number between {lowest:g} and {highest:g}")
folder = writableFolder(options.output)

h, scale = {"test": (0.25, 1e7), "draft": (0.125, 4e6), "standard": (0.0625, 4e6)}[options.preset]  # grid spacing [m], calendar over motion [-]
width, depth, warm, siltPorosity = 8.0, 2.5, options.surface, options.silt_porosity  # [m, degC, -]
lens = [(2.5, 1.25), (3.25, 1.0), (4.75, 1.0), (5.5, 1.25), (4.75, 1.75), (3.25, 1.75)]
strain = talik.layers.thawStrain(options.porosity, options.thawed_porosity)
mpm = MpmEngine(
	gridSpacing=h,
	lower=(0, 0),
	upper=(width, depth + 2 * h),
	gravity=(0, -9.81),
	damping=0.3,
	heat=HeatTransfer(thermalTimeScale=scale),
	freezing=FreezingCurve(width=0.2),
	skeleton=MohrCoulombSkeleton(young=1e7, youngFrozen=5e7, frictionAngle=28, cohesion=500, cohesionFrozen=2e5),
	boundaries=[RollerBoundary(region=side) for side in ("left", "right", "bottom")] + [SurfaceTemperature(region="surface", temperature=warm)],
)
silt = dict(polygon=talik.geometry.rectangle(0, 0, width, depth), holes=[lens], porosity=siltPorosity, temperature=-0.5)
iceRich = dict(polygon=lens, porosity=options.porosity, temperature=-0.5, material=GroundMaterial(name="ice-rich", thawStrain=strain))
layers = talik.layers.fill(mpm, {"silt": silt, "ice-rich": iceRich}, lateralRatio=0.5)
O.engines = [mpm]
O.step()

rows, states = [], [(0.0, output.allFields(mpm))]
while mpm.field("iceSaturation")[layers["ice-rich"]].max() > 0:
	talik.runUntilDay(mpm, mpm.calendar["day"] + 5)
	ice = mpm.field("iceSaturation")[layers["ice-rich"]]
	rows.append((mpm.calendar["day"], width * depth - mpm.field("volume").sum(), ice.min()))
states.append((rows[-1][0], output.allFields(mpm)))

area, cover = talik.geometry.polygonArea(lens)[0], depth - states[0][1]["position"][layers["ice-rich"], 1].max()  # cover of the highest point of the lens
latent, conductivity = siltPorosity * 910 * 334e3, (1 - siltPorosity) * 1.0 + siltPorosity * 0.6  # of the silt [J/m3, W/(m K)]
day, settled = np.interp(-0.5, [-ice for _, _, ice in rows], [day for day, _, _ in rows]), rows[-1][1]
dayByHand, settledByHand = latent * cover**2 / (2 * conductivity * warm) / talik.day, strain * area
print(f"{mpm.pointCount} points, {O.iter} steps")
print(f"the lens begins to thaw on day {day:.0f}, by hand on day {dayByHand:.0f}")
print(f"settled area {settled:.4f} m2, by hand {settledByHand:.4f} m2")

figure = plots.figure(8, 5.8)
panels = figure.subplots(2, 1, sharex=True)
ice = plots.bandsOf("iceSaturation", [frame["iceSaturation"] for _, frame in states])
for axes, (time, frame) in zip(panels, states):
	plots.ground(axes, frame, "iceSaturation", ice, bar=False)
	axes.plot(*zip(*lens, lens[0]), color="white" if time == 0 else "black", linestyle=":", linewidth=1.4)
	axes.set_title(f"day {time:.0f}", loc="left", fontsize=10)
	axes.set(xlim=(0, width), ylim=(0, depth + 0.2))
panels[0].set(xlabel="")
panels[1].set_title("dotted: outline of the lens at the start; dashed: ground at the start; crimson: thaw front", loc="right", fontsize=9)
plots.colourBar(panels, ice)
plots.save(figure, folder / "ice_rich_layer.png", dpi=100)
output.writeSummary(
	folder / "summary.json",
	**{"settled area [m2]": settled, "by hand [m2]": settledByHand, "lens begins to thaw [d]": day, "begins by hand [d]": dayByHand},
)
if abs(settled / settledByHand - 1) > 0.1 or abs(day / dayByHand - 1) > 0.15:
	output.unexpected("settlement or thaw is more than 10 or 15 % off the calculation by hand")
print(f"picture and summary are in {folder}")
