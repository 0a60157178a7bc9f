# SPDX-License-Identifier: GPL-2.0-or-later
"""Thaw slump from a heated patch of the base: Case II of Yu & Zhao, section 3.2.

	scripts/run thaw_slump_base [--preset draft|standard|paper]

Everything as in thaw_slump_surface.py but the heat: the base between x = 2 and 6 m is held at +10 °C from the start of the thaw on,
all other sides and the surface are insulated (the extent of the patch is ours, the paper prints none). Thaw climbs from the base,
support is lost, and the ground above comes after. The surface is drained and free.
"""

import talik
from talik import thawslump


def warmBase(start):
	"""Base patch at -5 °C, from `start` on at +10 °C within one second."""
	return [WallTemperature(region="bottom", lower=(2, -1), upper=(6, 1), times=[0, start, start + 1], values=[-5, -5, 10])]


options = thawslump.arguments(__doc__.splitlines()[0], "output/thaw_slump_base")
slump = thawslump.ThawSlump("Case II: thaw from the base", warmBase, options.preset, options.output, thaw=not options.no_thaw)
thawslump.report(slump.run(), options.output)
