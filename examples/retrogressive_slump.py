# SPDX-License-Identifier: GPL-2.0-or-later
"""A retrogressive thaw slump: an ice-rich head wall in a gentle slope thaws for two summers, retreats, and its mud flows away.

	scripts/run retrogressive_slump [--preset test|draft] [--vary excess angle air cohesion]

What the field calls so: of 1 832 measured slumps the mean slope is 4.2 to 14.4 degrees (first to ninth decile, median 8), the head wall is 2 to 6 m
high, the ground at it loses 1 to 8 cm of height a day in July and August, as a satellite sees it on cells of 12 m, and the mud flows away on a few degrees
(Bernhard et al. 2022; Zwieback et al. 2018; Kokelj et al.).
Here: a slope of 8 degrees with a head wall of 3 m, which a river or an earlier slide has cut, and below it a floor that falls as the slope does. The
ground is silt with excess ice; what melts leaves through the thawed mud, so that the mud bears little at first. Law: Mohr-Coulomb, one point a cell.
Day 0 is 1 June. Excess ice, strength and permeability of the mud are assumptions, and --vary shows what each does in the first summer.
"""

import argparse
import math
from dataclasses import dataclass, replace
from typing import NamedTuple

import numpy as np
from yade import O

import talik
from talik import output, plots
from talik.files import writableFolder, writeWhole

wall, upslope, floor, below = 3.0, 14.0, 18.0, 1.0  # height of the wall; lengths above and below it; ground under the lower end [m]
heightLoss, seen = (1.0, 8.0), 12.0  # measured loss of height in July and August [cm/day], on cells of this size [m]
summer = 92  # June to August [days]


@dataclass(frozen=True)
class Assumptions:
	angle: float = 8.0  # [degrees]
	excess: float = 0.4  # excess ice [-]
	air: float = 10.0  # surface in summer [degC]
	cohesion: float = 300.0  # of thawed ground [Pa]
	frictionAngle: float = 25.0  # [degrees]
	conductivity: float = 1e-7  # of thawed ground [m/s]
	gridSpacing: float = 0.5  # [m]


variations = {"excess": (0.2,), "angle": (4.0,), "air": (5.0,), "cohesion": (2000.0,), "gridSpacing": (0.25,)}


def outlineOf(ground):
	fall = math.tan(math.radians(ground.angle))
	foot = below + floor * fall
	length = upslope + floor
	return [(0, 0), (length, 0), (length, below), (upslope, foot), (upslope, foot + wall), (0, foot + wall + upslope * fall)]


def build(ground):
	outline = outlineOf(ground)
	h, top = ground.gridSpacing, max(y for _, y in outline)
	frost, warm = -8.0, ground.air
	days = [0, 5, summer, summer + 20, 355, 370, 365 + summer]
	mpm = MpmEngine(
		gridSpacing=h,
		lower=(0, 0),
		upper=(upslope + floor, h * math.ceil(top / h + 2)),
		**talik.settings.slump(
			water=PoreWater(pressure="implicit", conductivity=ground.conductivity, referencePorosity=0.45),
			heat=HeatTransfer(thermalTimeScale=8.64e5, followsMotion=True, motionTolerance=0.1),
		),
		skeleton=MohrCoulombSkeleton(
			young=2e6,
			youngFrozen=1e8,
			frictionAngle=ground.frictionAngle,
			cohesion=ground.cohesion,
			tensileStrength=0,
			cohesionFrozen=4e5,
			tensileStrengthFrozen=2e5,
		),
		boundaries=[
			RollerBoundary(region="left"),
			RollerBoundary(region="right"),
			FixedBoundary(region="bottom"),
			DrainedBoundary(region="surface", recharge=False),
			SurfaceTemperature(region="surface", days=days, values=[-2, warm, warm, frost, frost, warm, warm]),
		],
	)
	frozen = 1 - 0.55 * (1 - ground.excess)
	soil = GroundMaterial(name="ice-rich silt", solidConductivity=2, thawStrain=ground.excess)
	talik.layers.fill(mpm, {"silt": dict(polygon=outline, porosity=frozen, temperature=-2, material=soil)}, lateralRatio=1.0)
	return mpm


class Found(NamedTuple):
	retreat: float  # of the wall [m]
	runOut: float  # farthest, beyond its foot [m]
	moved: float  # area that has moved by more than a metre [m2 per m of width]
	lost: float  # height of the ground on the cell that a satellite sees [m]


def heightAtWall(mpm):
	"""Mean height of the ground on a cell that a satellite sees, which ends at the wall of the start [m]."""
	x, width = mpm.field("position")[:, 0], min(seen, upslope)
	return mpm.field("volume")[(x < upslope) & (x > upslope - width)].sum() / width


def run(ground, marks):
	"""{day: Found} and the ground at the end."""
	O.reset()
	mpm = build(ground)
	O.engines = [mpm]
	O.step()
	mpm.resetDisplacement()
	start, volume = mpm.field("position"), mpm.field("volume")
	foot = below + floor * math.tan(math.radians(ground.angle))
	before = heightAtWall(mpm)
	middle = (start[:, 0] < upslope) & (np.abs(start[:, 1] - foot - 0.5 * wall) < 0.3 * wall)  # rows of the wall, without its edge and its foot
	levels = np.unique(start[middle, 1].round(6))
	found = {}
	for day in marks:
		talik.runUntilDay(mpm, day, progress=True)
		stands = middle & (mpm.field("iceSaturation") > 0.5) & (np.linalg.norm(mpm.field("displacement"), axis=1) < 0.3)
		reach = [start[stands & (np.abs(start[:, 1] - level) < 1e-3), 0].max(initial=0.0) + 0.5 * ground.gridSpacing for level in levels]
		position, moved = mpm.field("position"), np.linalg.norm(mpm.field("displacement"), axis=1)
		runOut = (position[moved > 0.3, 0] - upslope).max(initial=0.0)
		found[day] = Found(upslope - np.mean(reach), runOut, volume[moved > 1].sum(), before - heightAtWall(mpm))
		print(
			f"day {day:.0f}: retreat {found[day].retreat:.2f} m, run-out {runOut:.1f} m, {found[day].moved:.1f} m2 moved by a metre, {O.iter} steps", flush=True
		)
	return found, mpm


def rates(found, what="retreat"):
	"""Change in July and August [cm/day] of each summer that was computed."""
	marked = [(first, last) for first, last in ((30, summer), (395, 365 + summer)) if first in found and last in found]
	return [100 * (getattr(found[last], what) - getattr(found[first], what)) / (last - first) for first, last in marked]


def row(name, found):
	at, wall, height = found[summer], rates(found)[0], rates(found, "lost")[0]
	return f"| {name} | {at.retreat:.2f} | {wall:.1f} | {height:.1f} | {at.runOut:.1f} | {at.moved:.1f} |"


parser = argparse.ArgumentParser(description=__doc__.splitlines()[0])
parser.add_argument("--preset", default="draft", choices=("test", "draft", "standard"), help="size of the job")
parser.add_argument("--vary", nargs="*", default=(), choices=tuple(variations), metavar="ASSUMPTION", help=f"of {', '.join(variations)}: with other values")
parser.add_argument("--output", default="output/retrogressive_slump", help="folder for the results")
options = parser.parse_args()
folder = writableFolder(options.output)

if options.preset == "test":
	upslope, floor = 5.0, 7.0
usual = Assumptions(gridSpacing=0.25 if options.preset == "standard" else 0.5)
marks = (12,) if options.preset == "test" else (30, 61, summer, 365, 395, 426, 365 + summer)
lines = [
	"| first summer | retreat [m] | in July and August [cm/day] | loss of height in July and August [cm/day] | run-out [m] | moved by a metre [m²/m] |",
	"|---|---|---|---|---|---|",
]
found, mpm = run(usual, marks)
if summer in found:
	lines.append(f"| measured | | | {heightLoss[0]:g} to {heightLoss[1]:g} | flows away | |")
	lines.append(row("as assumed", found))
last = max(found)
print(*lines, sep="\n")

figure = plots.figure(9, 7.5)
panels = figure.subplots(3, 1, height_ratios=(1, 1, 0.7))
frame = output.allFields(mpm)
for axes, field in zip(panels, ("iceSaturation", "displacement")):
	plots.ground(axes, frame, field, arrows="displacement" if field == "displacement" else None)
	outline = outlineOf(usual)
	axes.plot(*zip(*outline, outline[0]), color="0.35", linewidth=0.7, linestyle="--")
	axes.set(xlim=(0, upslope + floor), ylim=(0, 1.05 * max(y for _, y in outline)))
panels[0].set_title(f"day {last:.0f}; dashed: ground at the start", loc="left", fontsize=10)
panels[2].plot(sorted(found), [found[day].retreat for day in sorted(found)], "o-", color="black", label="retreat of the wall")
panels[2].plot(sorted(found), [found[day].runOut for day in sorted(found)], "s--", color="tab:brown", label="run-out beyond its foot")
for first in (30, 395):
	if first < last:
		panels[2].axvspan(first, min(last, first + 62), color="0.9")
panels[2].set(xlabel="day from 1 June; grey: July and August", ylabel="[m]", xlim=(0, last))
panels[2].legend(frameon=False, fontsize=8)
plots.save(figure, folder / "retrogressive_slump.png", dpi=100)
output.writeSummary(
	folder / "summary.json", **{"retreat [m]": found[last].retreat, "run-out [m]": found[last].runOut, "July and August [cm/day]": rates(found)}
)
if not found[last].retreat > 0:
	output.unexpected("the head wall does not retreat")
for name in options.vary:
	for value in variations[name]:
		other, _ = run(replace(usual, **{name: value}), (30, summer))
		lines.append(row(f"{name} {value:g}", other))
		print(lines[-1], flush=True)
if len(found) > 1:
	wall, height = (" and ".join(f"{rate:.1f}" for rate in rates(found, what)) for what in ("retreat", "lost"))
	lines.append("")
	lines.append(
		f"two summers: the wall retreats by {found[last].retreat:.2f} m, in July and August by {wall} cm a day, and the ground at it loses {height} cm"
	)
	lines[-1] += f" of height a day; mud runs out by {found[last].runOut:.1f} m"
	print(lines[-1])
writeWhole(folder / "table.md", "\n".join(lines) + "\n")
print(f"picture and table are in {folder}")
