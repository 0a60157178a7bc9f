# SPDX-License-Identifier: GPL-2.0-or-later
"""Values on a grid of squares as files for a geographic information system: GeoTIFF, or ESRI ASCII grid.

	talik.geogrid.write("risk.tif", place, side=2.0, values={"probability": share}, crs="EPSG:32633")
"""

from pathlib import Path

import numpy as np

missing = -9999.0  # where there is no ground


def write(path, place, side, values, crs=None):
	"""Writes values on squares, north up.

	path    .tif: a band for each value, by Debian's python3-rasterio; .asc: the first value, without a package
	place   (n, 2) middles of the squares, x and y [m]
	side    their width [m]
	values  {name: (n,)}
	crs     of x and y, for .tif: such as "EPSG:32633" (UTM 33 north); None: not said

	>>> talik.geogrid.write(folder + "/risk.asc", np.array([[0.5, 0.5], [1.5, 0.5]]), 1.0, {"risk": np.array([0.0, 0.25])})
	>>> print(open(folder + "/risk.asc").read().split("\\n")[6])
	0 0.25"""
	corner = place.min(axis=0) - 0.5 * side
	column, row = np.floor((place - corner) / side).astype(int).T
	count = column.max() + 1, row.max() + 1
	grids = []
	for value in values.values():
		grids.append(np.full((count[1], count[0]), missing))
		grids[-1][count[1] - 1 - row, column] = value
	if Path(path).suffix == ".asc":
		head = f"ncols {count[0]}\nnrows {count[1]}\nxllcorner {corner[0]:.12g}\nyllcorner {corner[1]:.12g}\ncellsize {side:.12g}\nNODATA_value {missing:g}\n"
		Path(path).write_text(head + "".join(" ".join(f"{value:.6g}" for value in line) + "\n" for line in grids[0]))
		return
	try:
		import rasterio
	except ImportError:
		raise ImportError(f"'{path}' needs Debian's package python3-rasterio; install it, or give the file the ending .asc") from None
	shape = dict(height=count[1], width=count[0], count=len(grids), dtype="float32", nodata=missing)
	upper = rasterio.Affine(side, 0, corner[0], 0, -side, corner[1] + side * count[1])
	with rasterio.open(path, "w", driver="GTiff", transform=upper, crs=crs, compress="deflate", **shape) as file:
		for band, (name, grid) in enumerate(zip(values, grids), 1):
			file.write(grid.astype("float32"), band)
			file.set_band_description(band, name)
