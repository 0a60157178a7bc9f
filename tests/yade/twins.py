# SPDX-License-Identifier: GPL-2.0-or-later
"""Twins of packed samples: what round-off makes of a sample."""

import numpy as np
import talik
from yade import O, wrapper


def withAGrainBeside(sample):
	"""The sample, packed, with one grain moved by a unit in the last place."""
	scene = sample.open()
	with talik.inspect(scene):
		state = O.bodies[3].state
		state.pos = (np.nextafter(state.pos[0], 1), state.pos[1], state.pos[2])
		return wrapper.RveSample.fromScene(scene)
