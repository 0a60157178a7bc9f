# SPDX-License-Identifier: GPL-2.0-or-later
"""The shear band of a slump: which points belong to it, where it lies, and what became of the bonds in it.

	band = talik.shearband.measure(frame, outline)       # frame of talik.output.Frames
	print(talik.shearband.describe(band))
"""

import math
from dataclasses import dataclass

import numpy as np

from talik import slope

meltSaturation = 0.02  # of IceBondMat: at or below it every bond is gone


@dataclass(frozen=True)
class ShearBand:
	"""Geometry in the position of the points before they moved, so that what slid away still lies in the band."""

	points: np.ndarray  # ids, ascending
	threshold: float  # of the deviatoric strain [-]
	inclination: float  # of the principal axis against the horizontal [deg], 0 to 90
	descendsTowards: str  # the face: right or left
	length: float  # along the axis [m], of a bar of the same second moments
	width: float  # across it [m]
	top: float  # depth of its highest point below the surface [m]
	depth: float  # depth of its deepest point below the surface [m]
	brokenBonds: float  # bonds broken mechanically over those formed, in the band [-]; nan without samples


def frozen(frame):
	"""Points whose samples still hold ice enough for bonds (ground without samples: by its own ice saturation)."""
	return frame[next((name for name in frame if name.endswith("sampleIceSaturation")), "iceSaturation")] > meltSaturation


def initialPosition(frame):
	return frame["position"] - frame["displacement"]


def measure(frame, outline, threshold=0.05, among=None):
	"""The largest coherent set of points with a deviatoric strain above `threshold`, or None if there are fewer than three.

	frame    fields of talik.output.Frames (position, displacement, volume, deviatoricStrain, …)
	outline  polygon of the ground before it moved, for depths
	among    (n,) bool, points that may belong to it; default: those that are frozen"""
	start = initialPosition(frame)
	strained = frame["deviatoricStrain"] > threshold
	points = _largestCluster(np.flatnonzero(strained & (frozen(frame) if among is None else among)), start, reach=1.6 * _spacing(start))
	if len(points) < 3:
		return None
	place, weight = start[points], frame["deviatoricStrain"][points]
	centred = place - np.average(place, axis=0, weights=weight)
	moments, axes = np.linalg.eigh((centred * weight[:, None]).T @ centred / weight.sum())
	axis = axes[:, 1]
	depth = np.array([slope.surfaceHeight(outline, x) - y for x, y in place])
	return ShearBand(
		points=points, threshold=threshold, inclination=math.degrees(math.atan2(abs(axis[1]), abs(axis[0]))),
		descendsTowards="right" if axis[0] * axis[1] < 0 else "left", length=math.sqrt(12 * moments[1]), width=math.sqrt(12 * max(moments[0], 0)),
		top=float(depth.min()), depth=float(depth.max()), brokenBonds=brokenShare(frame, points),
	)


def brokenShare(frame, points):
	"""Bonds of the points broken mechanically, over those ever formed [-]; nan in ground without samples."""
	if "bondsFormed" not in frame:
		return math.nan
	return float(np.nansum(frame["bondsBroken"][points]) / max(np.nansum(frame["bondsFormed"][points]), 1))


def describe(band):
	"""One sentence."""
	if band is None:
		return "no shear band in frozen ground"
	return (
		f"{len(band.points)} frozen points with a deviatoric strain above {band.threshold:g}: band inclined {band.inclination:.0f} deg, down to the "
		f"{band.descendsTowards}, from {band.top:.2f} to {band.depth:.2f} m below the surface, {band.length:.1f} x {band.width:.1f} m; "
		f"{100 * band.brokenBonds:.1f} % of its bonds broke mechanically"
	)


def watchedPoints(frame, outline, threshold=0.05):
	"""{"A": id, "B": id}: A the frozen point, in the band where there is one, that lost most bonds mechanically and still has contacts,
	B the thawed point with contacts that is strained most. A letter is left out where there is no such point."""
	solid = frame["coordinationNumber"] > 2
	band = measure(frame, outline, threshold)
	inBand = np.isin(np.arange(len(solid)), band.points) if band else np.ones(len(solid), bool)
	choices = {"A": (solid & frozen(frame) & inBand, frame["bondsBroken"]), "B": (solid & ~frozen(frame), frame["deviatoricStrain"])}
	return {letter: int(np.argmax(np.where(possible, rank, -1))) for letter, (possible, rank) in choices.items() if possible.any()}


def _spacing(position):
	"""Distance of neighbours in the undisturbed grid [m]."""
	from scipy.spatial import cKDTree

	return float(np.median(cKDTree(position).query(position, k=2)[0][:, 1]))


def _largestCluster(points, position, reach):
	"""Those of `points` that belong to the largest group of neighbours within `reach` [m]."""
	from scipy.sparse import coo_matrix
	from scipy.sparse.csgraph import connected_components
	from scipy.spatial import cKDTree

	if len(points) == 0:
		return points
	pairs = cKDTree(position[points]).query_pairs(reach, output_type="ndarray")
	links = coo_matrix((np.ones(len(pairs)), pairs.T), shape=(len(points), len(points)))
	group = connected_components(links, directed=False)[1]
	return points[group == np.argmax(np.bincount(group))]
