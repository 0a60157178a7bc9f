# SPDX-License-Identifier: GPL-2.0-or-later
"""Thaw slump from a heated patch of the base: Case II of Yu & Zhao, section 3.2.

	scripts/run thaw_slump_base [--preset draft|standard|paper] [--thaw-strain 0|0.03|full] [--compare thaw-strain|skeleton|both] [--resume] [--redraw]

Everything as in thaw_slump_surface.py but the heat: the base between x = 2 and 6 m is held at +10 °C from the start of the thaw on,
all other sides and the surface are insulated. Thaw climbs from the base, support is lost, and the ground above sinks. The
surface is drained and free.

Ours, where the paper is silent: the extent of the patch; the duration, 600 days, because the
frozen roof must become thin before its weight passes its strength; and what thawing does to
the grains. Grains that keep their size (eq. 8 as bookkeeping, --thaw-strain 0) keep their contacts when the ice goes: the thawed ground
at depth carries the same load as before, and the ground above stays. Support is lost by thaw strain: ice-rich grains, prepared frozen, shrink as they
thaw. --thaw-strain gives the area strain that they release, `full` is all of eq. (8), the porosity of the sample. --compare thaw-strain
shows 0, this and full side by side, --compare skeleton the samples beside a Mohr-Coulomb law calibrated on the same sample, --compare both
all four, with what each costs.
The page of figures is page.png; what to expect is described in examples/README.md.
"""

import sys
from pathlib import Path

import talik

sys.path.insert(0, str(Path(sys.argv[0]).parent))
from thaw_slump_surface import frozenSlope, outline  # noqa: E402: beside this script
from thawslump import Case, commandline  # noqa: E402

# in place of the values of the presets: a thaw of four times as many days, at draft on the cells and with the samples that this leaves time for
ofCase = {
	"draft": dict(days=600.0, gridSpacing=0.5, strainTolerance=2e-5, stressTolerance=0.05, maxInertialNumber=5e-3),
	"standard": dict(days=600.0),
	"paper": dict(days=600.0),
}


def warmBase(run, start):
	"""The slope of Case I over a patch of the base that warms within ten days from `start` [s of the calendar] on."""
	mpm, ground = frozenSlope(run), run.ground
	times, values = [start, start + 10 * talik.day], [ground.temperature, ground.warm]
	mpm.boundaries = [*mpm.boundaries, WallTemperature(region="bottom", lower=(2, -1), upper=(6, 1), times=times, values=values)]
	return mpm


case = Case("Case II: thaw from the base", outline, warmBase)

if __name__ == "__main__":
	options = commandline.arguments(__doc__.splitlines()[0], "output/thaw_slump_base", thawStrain=0.03)
	slump = commandline.runCase(case, options, ofCase.get(options.preset))
