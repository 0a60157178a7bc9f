# SPDX-License-Identifier: GPL-2.0-or-later
"""A thaw slump with an ice-rich layer between two others: each has its own sample of grains, thaw strain and ice content.

	scripts/run ice_rich_slump [--preset test|draft|standard]

By hand: the crest thaws to the depth d at which the integral of L(x) R(x) over the depth is the thawing index of the surface (degree seconds), with the latent
heat L of the layers and the thermal resistance R of what has thawed above (Stefan); what warms the frozen ground is left out, so the thaw stays
shallower. The crest settles by the thaw strain of each layer times its thawed thickness. Grains without cohesion do not stand at 45
degrees, so the thawed face slides; its area is no more than depth by hand times length of the face, since heat goes deeper only where the ground lies still.
Change the thaw strain of a layer, or its grains, first.
"""

import argparse

import numpy as np
from matplotlib.colors import ListedColormap
from matplotlib.patches import Patch
from yade import O

import talik
from talik import output, plots
from talik.files import writableFolder

parser = argparse.ArgumentParser(description=__doc__.splitlines()[0])
parser.add_argument("--preset", default="draft", choices=("test", "draft", "standard"), help="size of the job")
parser.add_argument("--output", default="output/ice_rich_slump", help="folder for the results")
options = parser.parse_args()
folder = writableFolder(options.output)

h, grains, lastDay, seeds = {
	"test": (0.5, 30, 20, (1, 5, 11)),  # seeds of samples that need no search
	"draft": (0.5, 100, 150, (1, 1, 1)),
	"standard": (0.25, 200, 150, (1, 1, 1)),
}[options.preset]
frozen, warm, warming = -2.0, 10.0, 10.0  # ground, summer [degC], and the days until it has warmed
outline = [(0, 0), (12, 0), (12, 1), (9, 1), (6, 4), (0, 4)]
upper, rest = talik.layers.split(outline, [(0, 3.0), (12, 3.0)])
middle, lower = talik.layers.split(rest, [(0, 2.0), (12, 2.0)])


def layer(name, polygon, frozenPorosity, thawedPorosity, **ofGrains):
	"""A soil as a laboratory tells it: porosity frozen and thawed, and the grains of its sample."""
	sample = talik.rve.pack(talik.rve.prepare(grains=grains, **ofGrains))
	sample.thawStrain = 0  # the thaw strain is that of the layer
	law = RveSkeleton(samples=[sample], strainTolerance=5e-5, slipFriction=talik.studies.calibrate.thawedFriction(sample))
	soil = GroundMaterial(name=name, solidConductivity=2.0, thawStrain=talik.layers.thawStrain(frozenPorosity, thawedPorosity))
	return dict(polygon=polygon, porosity=frozenPorosity, temperature=frozen, material=soil, skeleton=law)


soils = {
	"silt": layer("silt", upper, 0.42, 0.40, seed=seeds[0]),
	"ice-rich silt": layer("ice-rich silt", middle, 0.60, 0.45, porosity=0.20, seed=seeds[1]),
	"gravel": layer("gravel", lower, 0.35, 0.35, radius=(4e-3, 8e-3), etaRoll=0.2, seed=seeds[2]),
}
mpm = MpmEngine(
	gridSpacing=h,
	lower=(0, 0),
	upper=(12, 6),
	gravity=(0, -9.81),
	damping=0.05,
	heat=HeatTransfer(thermalTimeScale=8.64e5),
	freezing=FreezingCurve(width=0.2),
	boundaries=[
		RollerBoundary(region="left"),
		RollerBoundary(region="right"),
		FixedBoundary(region="bottom"),
		SurfaceTemperature(region="surface", times=[0, warming * talik.day], values=[frozen, warm]),
	],
)
layers = talik.layers.fill(mpm, soils)
talik.slope.settle(mpm, outline)  # samples at the weight above their points, before they freeze
O.engines = [mpm]
start, startVolume, startIce = mpm.field("position"), mpm.field("volume"), mpm.field("iceSaturation")
talik.runUntilDay(mpm, lastDay, progress=True)

ice, displacement = mpm.field("iceSaturation"), mpm.field("displacement")
thawed, moved = startVolume * (1 - ice / startIce), np.linalg.norm(displacement, axis=1)
crest = start[:, 0] < 1.0
depth, settled = thawed[crest].sum(), -displacement[crest & (start[:, 1] > 4 - h), 1].mean()  # of one metre of width
slid = startVolume[abs(displacement[:, 0]) > 0.1].sum()  # what has only settled goes straight down

steps = np.linspace(0, 3, 3001)  # depths below the crest [m]
soilAt = [soils["silt" if x < 1 else "ice-rich silt" if x < 2 else "gravel"] for x in steps]
latent = np.array([soil["porosity"] * soil["material"].iceDensity * soil["material"].latentHeat for soil in soilAt])
k = np.array([(1 - n) * 2.0 + n * 0.6 for n in (soil["porosity"] for soil in soilAt)])
needed = np.cumsum(latent * np.cumsum(0.001 / k) * 0.001)  # index at which thaw reaches each depth [degree seconds]
hours = np.arange(0, lastDay * 24) / 24
index = 3600 * np.clip(np.interp(hours, [0, warming], [frozen, warm]), 0, None).sum()
depthByHand = np.interp(index, needed, steps)
settledByHand = 0.001 * sum(soil["material"].thawStrain for soil, x in zip(soilAt, steps) if x < depthByHand)
slidByHand = depthByHand * 3 * 2**0.5  # of the face of 45 degrees and 3 m
print(f"{mpm.pointCount} points, {O.iter} steps, {mpm.calendar['day']:.0f} days, {sum(law.cost()['calls'] for law in mpm.skeletons)} sample calls")
print(f"the crest has thawed by {depth:.2f} m, by hand {depthByHand:.2f} m, and settled by {1e3 * settled:.0f} mm, by hand {1e3 * settledByHand:.0f} mm")
print(f"{slid:.1f} m2 have slid sideways by more than 0.1 m, by hand at most {slidByHand:.1f} m2; the farthest point by {moved.max():.2f} m")
for name, ids in layers.items():
	print(f"{name}: {thawed[ids].sum():.2f} m2 of {startVolume[ids].sum():.2f} m2 have thawed; moved by up to {moved[ids].max():.2f} m")

figure = plots.figure(8, 8.4)
panels = figure.subplots(3, 1, sharex=True)
frame, number = output.allFields(mpm), np.zeros(mpm.pointCount, dtype=int)
for place, ids in enumerate(layers.values()):
	number[ids] = place
soilBands = plots.Bands("", np.arange(len(soils) + 1) - 0.5, ListedColormap(["#d9c08c", "#8fb3c9", "#9a8f86"]))
for axes, field, bands in ((panels[0], number, soilBands), (panels[1], "iceSaturation", None), (panels[2], "displacement", None)):
	plots.ground(axes, frame, field, bands, bar=False, arrows="displacement" if axes is panels[2] else None)
	for soil in soils.values():
		axes.plot(*zip(*soil["polygon"], soil["polygon"][0]), color="0.35", linewidth=0.6, linestyle=":")
	axes.set(xlim=(0, 12), ylim=(0, 4.3), xlabel="")
	if axes is not panels[0]:
		plots.colourBar(axes, plots.bandsOf(field, frame[field]))
panels[2].set_xlabel("x [m]")
handles = [Patch(color=soilBands.map(place), label=name) for place, name in enumerate(soils)]
panels[0].legend(handles=handles, loc="upper right", frameon=False)
panels[0].set_title(f"day {lastDay}; dotted: layers at the start; crimson: thaw front", loc="left", fontsize=10)
panels[2].set_title(f"largest {moved.max():.1f} m", loc="right", fontsize=9)
plots.save(figure, folder / "ice_rich_slump.png", dpi=100)
output.writeSummary(
	folder / "summary.json",
	**{"crest thawed [m]": depth, "by hand [m]": depthByHand, "crest settled [m]": settled, "settled by hand [m]": settledByHand},
	**{"slid [m2]": slid, "largest displacement [m]": moved.max()},
)
if not 0.8 < depth / depthByHand < 1.3 + h / 4 / depthByHand:  # and half a row of points, of which the front passes whole ones
	output.unexpected("the thaw of the crest is not between 80 and 130 % of the calculation by hand")
if options.preset != "test" and abs(settled / settledByHand - 1) > 0.3:
	output.unexpected("the settlement of the crest is more than 30 % off the calculation by hand")
if options.preset != "test" and not 0.5 * slidByHand < slid < 1.3 * slidByHand:
	output.unexpected("what has slid is not between 50 and 130 % of the calculation by hand")
print(f"picture and summary are in {folder}")
