# SPDX-License-Identifier: GPL-2.0-or-later
"""Retrogressive thaw slump, thawed from its surface: Case I of Yu & Zhao, section 3.2.

	scripts/run thaw_slump_surface [--preset draft|standard|paper] [--compare skeleton] [--resume] [--redraw]

From the paper: grid 0.2 m (--preset paper), initial temperature -5 °C, air at +10 °C, k = 1e-4 m/s, thermal time scale 8.64e5, samples of 400
discs (E_c 0.6 to 3.6 GPa, bond strength 1 to 51 MPa, friction 0.5, k_s/k_n 0.8) compacted at 100 kPa.

Not from the paper: one point a cell in place of its four. Rows of points that share a cell get one strain although the upper one has thawed and the
lower one has not. Their stresses part, and the thawed ground tears into lumps. One point a cell needs half the time.

Ours, where the paper is silent: the outline of the slope (a 45° face, 3 m high, above a 1 m bench); rollers left and right, fixed
base; the air warms within ten days and acts on the moving surface; freezing curve gauss with W = 0.5 K and S_r = 0.05; sample thickness
0.1 m; with the law alone a frozen modulus of at most 20 MPa, for the sake of the time step; ice in the samples as bonds only (bookkeeping
of grain size); samples brought to the geostatic stress in bands of 0.5 m before they freeze; lateral stress ratio 0.7; local damping 0.02
during failure.
This script is the scene. How it is run, drawn and compared is in the folder thawslump beside it, the values in thawslump/settings.py.
The page of figures is page.png; what to expect is described in examples/README.md.
--compare skeleton also runs a Mohr-Coulomb law calibrated on the same sample, side by side with both wall times.
"""

import math
import sys
from pathlib import Path

import talik

sys.path.insert(0, str(Path(sys.argv[0]).parent))
from thawslump import Case, commandline  # noqa: E402: the folder beside this script

outline = [(0, 0), (10, 0), (10, 1), (6, 1), (3, 4), (0, 4)]  # [m]


def frozenSlope(run):
	"""The slope as it comes to rest under its weight: frozen, its surface drained. `run` (thawslump.ThawSlump) has preset and ground."""
	h, ground = run.preset.gridSpacing, run.ground
	left, right = min(x for x, _ in run.outline), max(x for x, _ in run.outline)
	position, volume = talik.geometry.fillPolygon(run.outline, h, pointsPerCell=1, origin=(left, 0.0))
	skeleton, atRest = run.skeletonAtRest(position)
	mpm = MpmEngine(
		gridSpacing=h,
		lower=(left, 0),
		upper=(right, h * round(4 / h + 4)),
		gravity=(0, -9.81),
		damping=ground.restDamping,
		skeleton=skeleton,
		heat=HeatTransfer(followsMotion=ground.followsMotion, motionTolerance=ground.motionTolerance),  # in real time until the slope rests
		freezing=FreezingCurve(curve="gauss", width=ground.freezingWidth, residualSaturation=ground.residualSaturation),
		water=PoreWater(
			conductivity=ground.conductivity,
			pressure=ground.porePressure,
			bulkModulus=ground.bulkModulus,
			zetaActive=ground.zetaActive,
			# seepage runs by the calendar where that follows the motion; with the paper's constant scale it runs in seconds of motion
			hydraulicTimeScale=math.nan if ground.followsMotion else 1,
		),
	)
	mpm.addPoints(position=position, volume=volume, porosity=ground.porosity, temperature=ground.temperature, **atRest)
	mpm.boundaries = [
		RollerBoundary(region="left"),
		RollerBoundary(region="right"),
		FixedBoundary(region="bottom"),
		DrainedBoundary(region="surface", recharge=False),
	]
	return mpm


def warmSurface(run, start):
	"""The slope under air that warms within ten days from `start` [s of the calendar] on."""
	mpm, ground = frozenSlope(run), run.ground
	air = SurfaceTemperature(region="surface", times=[start, start + 10 * talik.day], values=[ground.temperature, ground.warm])
	mpm.boundaries = [*mpm.boundaries, air]
	return mpm


case = Case("Case I: thaw from the surface", outline, warmSurface)

if __name__ == "__main__":
	options = commandline.arguments(__doc__.splitlines()[0], "output/thaw_slump_surface")
	slump = commandline.runCase(case, options)
