# SPDX-License-Identifier: GPL-2.0-or-later
"""What problems of moving ground share: the knobs of its march, and a column one cell wide."""

import math

from yade import wrapper

standard = {"points per cell": 4, "time-step fraction": 0.4, "transfer": "flip", "PIC time over sqrt(h/g)": 1.0, "shape function": "quadraticBSpline"}
sweeps = {
	"points per cell": (1, 9),
	"time-step fraction": (0.1,),
	"transfer": ("apic", "tpic"),
	"PIC time over sqrt(h/g)": (0.1,),
	"shape function": ("gimp",),
}
quick = {**sweeps, "time-step fraction": (0.2, 0.55), "PIC time over sqrt(h/g)": (1e6, 10.0)}


def march(settings, h):
	"""Attributes of an MpmEngine."""
	attributes = {"courantNumber": settings["time-step fraction"], "shapeFunction": settings["shape function"], "transfer": settings["transfer"]}
	if settings["transfer"] == "flip":
		attributes["picTime"] = settings["PIC time over sqrt(h/g)"] * math.sqrt(h / 9.81)
	return attributes


def column(height, settings, boundaries=(), **attributes):
	"""MpmEngine for a column of a height [m] with room of two cells above it; it stands on its base between walls, all of them smooth."""
	h = height / settings["cells"]
	walls = [wrapper.RollerBoundary(region=side) for side in ("left", "right", "bottom")]
	return wrapper.MpmEngine(gridSpacing=h, lower=(0, 0), upper=(h, height + 2 * h), boundaries=walls + list(boundaries), **march(settings, h), **attributes)
