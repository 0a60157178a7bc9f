# SPDX-License-Identifier: GPL-2.0-or-later
"""Retrogressive thaw slump, thawed from its surface: Case I of Yu & Zhao, section 3.2.

	scripts/run thaw_slump_surface [--preset draft|standard|paper] [--compare skeleton] [--resume] [--redraw]

From the paper: grid 0.2 m with four points a cell, initial temperature -5 °C, air at +10 °C, k = 1e-4 m/s, thermal time scale
8.64e5, samples of 400 discs (E_c 0.6 to 3.6 GPa, bond strength 1 to 51 MPa, friction 0.5, k_s/k_n 0.8) compacted at 100 kPa.

Ours, where the paper is silent: the outline of the slope (a 45° face, 3 m high, above a 1 m bench); rollers left and right, fixed
base; the air warms within ten days and acts on the moving surface; freezing curve gauss with W = 0.5 K and S_r = 0.05; sample thickness
0.1 m; a numerical bulk modulus of water of 2.2e7 Pa; ice in the samples as bonds only (bookkeeping of grain size); samples brought
to the geostatic stress in bands of 0.5 m before they freeze; lateral stress ratio 0.7; local damping 0.02 during failure.
See talik.thawslump for each of them. The page of figures is page.png; what to expect is described in examples/README.md.
--compare skeleton also runs a Mohr-Coulomb law calibrated on the same sample, side by side with both wall times.
"""

import talik
from talik import thawslump


def warmAir(start):
	"""Air at -5 °C, from `start` [s of the calendar] on warming to +10 °C within ten days."""
	return [SurfaceTemperature(region="surface", times=[start, start + 10 * talik.day], values=[-5, 10])]


options = thawslump.arguments(__doc__.splitlines()[0], "output/thaw_slump_surface")
slump = thawslump.runCase("Case I: thaw from the surface", warmAir, options)
