# SPDX-License-Identifier: GPL-2.0-or-later
"""Makes the height grid of thaw_slump_bowl: a hollow with a steep back wall in a hillside.

	/usr/bin/python3 examples/thawbowl/hillside.py > examples/thawbowl/hillside.asc
"""

import numpy as np

length, width, cell = 12.6, 10.8, 0.3  # [m]
rounding = 0.25  # of the edges [m]


def height(x, y):
	"""Height of the surface [m] at x down the slope and y across [m].

	The hillside falls by 16 %, the floor of the hollow by 12 %. Between them stands a face of 54 degrees, around a half circle that opens
	into a channel, whose axis winds a little."""
	hillside = 5.2 - 0.16 * x
	axis = 0.5 * width + 0.3 * np.sin(0.5 * x)
	fromAxis = np.where(x < 5.5, np.hypot(x - 5.5, y - axis), np.abs(y - axis))
	floor = 1.6 - 0.12 * (x - 4) + 0.05 * np.minimum(fromAxis, 2.0) ** 2
	face = floor + 1.4 * (fromAxis - 1.8)
	return -_upper(-_upper(floor, face), -hillside)


def _upper(a, b):
	"""The larger one, rounded where they meet."""
	return 0.5 * (a + b + np.sqrt((a - b) ** 2 + rounding**2))


def lines():
	"""Lines of the ESRI ASCII grid: heights of the middles of the cells, rows from north to south."""
	x, y = (cell * np.arange(round(side / cell) + 1) for side in (length, width))
	yield from (f"ncols {len(x)}", f"nrows {len(y)}", "xllcenter 0", "yllcenter 0", f"cellsize {cell}", "NODATA_value -9999")
	for north in y[::-1]:
		yield " ".join(f"{z:.2f}" for z in height(x, north))


if __name__ == "__main__":
	print("\n".join(lines()))
