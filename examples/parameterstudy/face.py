# SPDX-License-Identifier: GPL-2.0-or-later
"""One row of parameter_study: a steep face of thawed ground, which stands or fails. By itself: yade -n -x face.py"""

import talik
from yade import O

row = talik.batch.row(cohesion=4e3, frictionAngle=25.0, gridSpacing=0.25)
h, height, crest, toe = row.gridSpacing, 3.0, 4.0, 4.8  # [m]; a face of 75 degrees
mpm = MpmEngine(
	gridSpacing=h,
	lower=(0, 0),
	upper=(9, 4),
	gravity=(0, -9.81),
	damping=0.05,
	skeleton=MohrCoulombSkeleton(young=1e7, cohesion=row.cohesion, frictionAngle=row.frictionAngle),
	boundaries=[RollerBoundary(region="left"), RollerBoundary(region="right"), FixedBoundary(region="bottom")],
)
face = dict(polygon=[(0, 0), (9, 0), (9, 0.5), (toe, 0.5), (crest, height + 0.5), (0, height + 0.5)], porosity=0.4)
talik.layers.fill(mpm, {"face": face}, lateralRatio=0.5)
O.engines = [mpm]
talik.runUntil(1.5)
talik.batch.leave(displacement=abs(mpm.field("displacement")).max(), speed=abs(mpm.field("velocity")).max(), points=mpm.pointCount)
