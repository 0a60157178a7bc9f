# SPDX-License-Identifier: GPL-2.0-or-later
"""Look inside a thawing slope: which points lose their bonds, and what the samples of grains behind two of them look like.

	scripts/run look_inside [--preset test|draft]

A frozen face of 45°, 1.5 m high, thaws from its surface. Afterwards point A is the frozen one whose sample has lost most bonds by
breaking, point B the thawed one that is strained most; their samples are shown in O, drawn and written for ParaView.
"""

import argparse
from pathlib import Path

import numpy as np

import talik
from talik import output, packing, plots
from talik.running import runUntil

presets = {"test": (40, 0.6), "draft": (150, 6.0)}  # grains of a sample, end time [s]

parser = argparse.ArgumentParser(description=__doc__.splitlines()[0])
parser.add_argument("--preset", default="draft", choices=sorted(presets), help="size of the job")
parser.add_argument("--output", default="output/look_inside", help="folder for the results")
options = parser.parse_args()
folder = Path(options.output)
grains, endTime = presets[options.preset]

mpm = MpmEngine(
	gridSpacing=0.125,
	lower=(0, 0),
	upper=(4, 3),
	gravity=(0, -9.81),
	damping=0.1,
	skeleton=RveSkeleton(samples=[talik.rve.pack(talik.rve.prepare(grains=grains))]),
	heat=HeatTransfer(thermalTimeScale=8.64e5),
	freezing=FreezingCurve(),
	boundaries=[
		RollerBoundary(region="left"),
		RollerBoundary(region="right"),
		FixedBoundary(region="bottom"),
		SurfaceTemperature(region="surface", times=[0, 5 * talik.day], values=[-2, 10]),
	],
)
talik.geometry.fill(mpm, [(0, 0), (4, 0), (4, 0.5), (3, 0.5), (1.5, 2), (0, 2)], temperature=-2)
mpm.watch(range(mpm.pointCount), interval=endTime / 200)
O.engines = [mpm]
runUntil(endTime)

frozen = mpm.field("iceSaturation") > 0.1
A = next((id for id in mpm.most("bondsBroken", mpm.pointCount) if frozen[id]), 0)
B = next((id for id in mpm.mostStrained(mpm.pointCount) if not frozen[id]), mpm.pick(2.25, 1.25))

fig = plots.figure(12, 8)
grid = fig.add_gridspec(2, 3, width_ratios=(1.4, 1, 1))
series = output.SampleSeries(folder, clock=lambda: mpm.time)
for row, (letter, id) in enumerate({"A": A, "B": B}.items()):
	with mpm.inspect(id):  # O is the sample of this point
		sample = packing.sampleArrays()
		series.write()
		O.save(str(folder / f"sample_{letter}.yade.gz"))
	plots.sampleForces(fig.add_subplot(grid[row, 1]), sample, widest=4).set_title(f"{letter}: sample of point {id}")
	plots.normalRose(fig.add_subplot(grid[row, 2], projection="polar"), sample["normal"])

positions = dict(zip("AB", mpm.field("position")[[A, B]]))
slope = plots.ground(
	fig.add_subplot(grid[0, 0]), output.allFields(mpm), "bondsBroken", label="bonds broken [-]", colourMap="YlOrRd", limits=(0, None), watched=positions
)
slope.set_title(f"day {mpm.calendar['day']:.0f}; dashed: start", fontsize=10)
past = mpm.history(A)
plots.bondHistory(fig.add_subplot(grid[1, 0]), past["deviatoricStrain"], past["bondsIntact"], past["bondsBroken"], past["bondsMelted"]).set_title("bonds of A")
picture = plots.save(fig, folder / "look_inside.png", dpi=80)

output.ParaViewSeries(mpm, folder).write()
output.writeSummary(
	folder / "summary.json", A=A, B=B, time=mpm.time, **{name: int(np.nansum(mpm.field(name))) for name in ("bondsIntact", "bondsBroken", "bondsMelted")}
)
print(f"A is point {A}, B point {B}; {picture}, ParaView files and both samples as YADE scenes are in {folder}")
