# SPDX-License-Identifier: GPL-2.0-or-later
"""The shear band of a slump: which points belong to it, where it lies, and what became of the bonds in it.

	band = shearband.measure(frame, outline)       # frame of talik.output.Frames
	print(shearband.describe(band))

A band is where a mass that moved borders on ground that stayed. Displacement tells the two apart, by Otsu's threshold; the band is the
line across which it passes half way between their means, in the position of the points before they moved. Strain alone does not tell:
which points pass a strain depends on that strain, and the mass is strained itself where it slides over thawed ground.
"""

import math
from dataclasses import dataclass

import numpy as np

from yade import wrapper

from talik import slope

meltSaturation = wrapper.IceBondMat().meltSaturation  # at or below it every bond is gone
torn = 0.25  # deviatoric strain beyond which a frozen sample has opened along a crack and hangs together no more
levels = (0.25, 0.5, 0.75)  # of the way from the ground that stayed to the mass that moved; the middle one counts, the others tell how sure it is


@dataclass(frozen=True)
class ShearBand:
	"""Geometry in the position of the points before they moved, so that what slid away still lies in the band."""

	points: np.ndarray  # ids, ascending, of the points on both sides
	threshold: float  # that the displacement across the band over its width passes [-]
	inclination: float  # of the line of best fit against the horizontal [deg], 0 to 90
	inclinations: tuple  # smallest and largest over the levels [deg]
	descendsTowards: str  # the face: right or left
	length: float  # along the line [m]
	width: float  # over which the displacement changes [m]; not below the distance of the points
	opening: float  # direction of the displacement across it [deg]: 0 slip along the line, 90 opening, below 0 closing
	roughness: float  # root mean square distance of the band from the line [m]
	top: float  # depth of its highest place below the surface [m]
	depth: float  # depth of its deepest place below the surface [m]
	brokenBonds: float  # bonds broken mechanically over those formed, in the band [-]; nan without samples


def frozen(frame):
	"""Points whose samples still hold ice enough for bonds (ground without samples: by its own ice saturation)."""
	return frame[next((name for name in frame if name.endswith("sampleIceSaturation")), "iceSaturation")] > meltSaturation


def initialPosition(frame):
	return frame["position"] - frame["displacement"]


def measure(frame, outline, threshold=0.05, among=None):
	"""The longest coherent border between moved and unmoved ground across which the displacement over the width is above `threshold`;
	None if there is none of three places or more.

	frame    fields of talik.output.Frames (position, displacement, …)
	outline  polygon of the ground before it moved, for depths
	among    (n,) bool, points that may belong to it, or True for all; default: those that are frozen"""
	start, moved = initialPosition(frame), np.linalg.norm(frame["displacement"], axis=1)
	ground = np.flatnonzero(frozen(frame) if among is None else np.broadcast_to(among, len(moved)))
	if len(ground) < 3 or np.ptp(moved[ground]) == 0:
		return None
	stayed, gone = _twoClasses(moved[ground])
	borders = [_border(ground, start, moved, stayed + level * (gone - stayed)) for level in levels]
	if any(len(places) < 3 for _, places in borders):
		return None
	lines = [_line(places) for _, places in borders]
	(pairs, places), (axis, roughness) = borders[len(levels) // 2], lines[len(levels) // 2]
	stays, goes = np.take_along_axis(pairs, np.argsort(moved[pairs], axis=1), axis=1).T
	normal = np.array([-axis[1], axis[0]])
	across = (start[goes] - start[stays]) @ normal
	gradient = (moved[goes] - moved[stays]).sum() / np.abs(across).sum()
	if gradient < threshold:
		return None
	jump = (frame["displacement"][goes] - frame["displacement"][stays]).sum(axis=0)
	opening = math.degrees(math.atan2(math.copysign(1, across.sum()) * (jump @ normal), abs(jump @ axis)))
	inclinations = [math.degrees(math.atan2(-line[1], line[0])) for line, _ in lines]
	points = np.unique(np.concatenate([pairs.ravel() for pairs, _ in borders]))
	depth = np.array([slope.surfaceHeight(outline, x) - y for x, y in places])
	return ShearBand(
		points=points,
		threshold=threshold,
		inclination=abs(inclinations[len(levels) // 2]),
		inclinations=_between(inclinations),
		descendsTowards="right" if axis[1] < 0 else "left",
		length=float(np.ptp(places @ axis)),
		width=float((gone - stayed) / gradient),
		opening=opening,
		roughness=roughness,
		top=float(depth.min()),
		depth=float(depth.max()),
		brokenBonds=brokenShare(frame, points),
	)


def _twoClasses(values):
	"""Means of the two classes of values that Otsu's threshold parts (largest variance between them)."""
	ordered = np.sort(values)
	count = np.arange(1, len(ordered))
	sums = np.cumsum(ordered)[:-1]
	low, high = sums / count, (ordered.sum() - sums) / (len(ordered) - count)
	best = np.argmax(count * (len(ordered) - count) * (high - low) ** 2)
	return low[best], high[best]


def _border(ground, position, value, level):
	"""Where `value` passes `level` between neighbours of the ground: (pairs of ids, places) of the largest coherent group."""
	from scipy.spatial import cKDTree

	spacing = _spacing(position)
	pairs = ground[cKDTree(position[ground]).query_pairs(1.2 * spacing, output_type="ndarray")]
	pairs = pairs[(value[pairs] > level).sum(axis=1) == 1]
	first, second = pairs.T
	share = (level - value[first]) / (value[second] - value[first])
	places = position[first] + share[:, None] * (position[second] - position[first])
	chosen = _largestCluster(places, reach=1.6 * spacing)
	return pairs[chosen], places[chosen]


def _line(places):
	"""Line of best fit: (unit vector along it, to the right; root mean square distance from it [m])."""
	centred = places - places.mean(axis=0)
	moments, axes = np.linalg.eigh(centred.T @ centred / len(places))
	axis = axes[:, 1] * (1 if axes[0, 1] >= 0 else -1)
	return axis, math.sqrt(max(moments[0], 0))


def _between(inclinations):
	"""Smallest and largest angle [deg] of lines that fall (> 0) or rise (< 0) to the right, all seen from the side of the first."""
	middle = inclinations[len(inclinations) // 2]
	seen = [math.copysign(1, middle) * angle for angle in inclinations]
	seen = [angle if angle > -45 else angle + 180 for angle in seen]  # a line just past the vertical
	return min(seen), max(seen)


def brokenShare(frame, points):
	"""Bonds of the points broken mechanically, over those ever formed [-]; nan in ground without samples."""
	if "bondsFormed" not in frame:
		return math.nan
	return float(np.nansum(frame["bondsBroken"][points]) / max(np.nansum(frame["bondsFormed"][points]), 1))


def describe(band, ground="frozen"):
	"""One sentence; ground: frozen or all."""
	if band is None:
		return f"no shear band in {ground} ground"
	broken = f"; {100 * band.brokenBonds:.1f} % of the bonds of its {len(band.points)} points broke mechanically" if np.isfinite(band.brokenBonds) else ""
	return (
		f"shear band in {ground} ground inclined {band.inclination:.0f} deg ({band.inclinations[0]:.0f} to {band.inclinations[1]:.0f} by the share of the "
		f"displacement), down to the {band.descendsTowards}, from {band.top:.2f} to {band.depth:.2f} m below the surface, {band.length:.1f} m long, "
		f"displacement at {band.opening:.0f} deg to it{broken}"
	)


def watchedPoints(frame, outline, threshold=0.05):
	"""{"A": id, "B": id}: A the frozen point, in the band where there is one, that lost most bonds mechanically, of equals the one with least
	ice, B the thawed point that is strained most; each among those that still have contacts, and A among those whose samples are in one piece, strained
	by no more than `torn`, if there are any. A letter is left out where there is no such point."""
	solid, icy = frame["coordinationNumber"] > 2, frozen(frame)
	band = measure(frame, outline, threshold)
	inBand = np.isin(np.arange(len(solid)), band.points) if band else np.ones(len(solid), bool)
	whole = solid & (frame["deviatoricStrain"] < torn)
	choices = {
		"A": (icy & inBand, [whole & (frame["bondsBroken"] > 0), whole, solid], frame["bondsBroken"] + 1 - frame["iceSaturation"]),
		"B": (~icy, [solid], frame["deviatoricStrain"]),
	}
	return {letter: _highest(rank, _first(possible, better)) for letter, (possible, better, rank) in choices.items() if possible.any()}


def _first(possible, better):
	"""The possible ones that meet the first of the wishes that any meets."""
	return next((possible & wish for wish in better if (possible & wish).any()), possible)


def _highest(rank, possible):
	return int(np.argmax(np.where(possible, rank, -1)))


def _spacing(position):
	"""Distance of neighbours in the undisturbed grid [m]."""
	from scipy.spatial import cKDTree

	return float(np.median(cKDTree(position).query(position, k=2)[0][:, 1]))


def _largestCluster(places, reach):
	"""Indices of the largest group of neighbours within `reach` [m]."""
	from scipy.sparse import coo_matrix
	from scipy.sparse.csgraph import connected_components
	from scipy.spatial import cKDTree

	if len(places) == 0:
		return np.array([], dtype=int)
	pairs = cKDTree(places).query_pairs(reach, output_type="ndarray")
	links = coo_matrix((np.ones(len(pairs)), pairs.T), shape=(len(places), len(places)))
	group = connected_components(links, directed=False)[1]
	return np.flatnonzero(group == np.argmax(np.bincount(group)))
