# SPDX-License-Identifier: GPL-2.0-or-later
"""Values between scattered places."""

import numpy as np
from scipy.interpolate import LinearNDInterpolator, NearestNDInterpolator


def linear(places, values):
	"""Function of the coordinates that is linear between places (n,d) and has the value of the nearest one outside of them.

	scipy.spatial.QhullError or ValueError where the places do not span a triangle or a tetrahedron."""
	between, nearest = LinearNDInterpolator(places, values), NearestNDInterpolator(places, values)

	def value(*place):
		inside = between(*place)
		return np.where(np.isnan(inside), nearest(*place), inside)

	return value
