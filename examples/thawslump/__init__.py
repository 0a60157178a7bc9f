# SPDX-License-Identifier: GPL-2.0-or-later
"""What the two thaw slumps of Yu & Zhao share, beside their scenes: how they are run, stopped, compared and drawn.

	settings     size of the job (presets) and values of the ground
	slump        one run: rest, thaw, checkpoint, results
	commandline  options of the two examples and the runs that they ask for
	page         the page of figures
	shearband    where the mass that moved borders on the ground that stayed

The scenes are thaw_slump_surface.py and thaw_slump_base.py beside this folder."""

from thawslump.settings import Ground, Preset, flowingPicTimeFactor, fullThawStrain, oneGrainThick, presets, skeletons, softened
from thawslump.slump import Case, ThawSlump
