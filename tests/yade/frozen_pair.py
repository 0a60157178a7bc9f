# SPDX-License-Identifier: GPL-2.0-or-later
"""Two equal bonds of ice in one line, for closed forms of one bond; one cell of ground over frozen samples."""

import numpy as np
from yade import Matrix3, O, utils, wrapper


def frozenPair(radius, depth):
	"""Packed sample of two discs of a radius [m] side by side in a periodic cell of 4 by 10 radii and a depth [m], frozen to full ice saturation."""
	O.periodic = True
	O.cell.hSize = Matrix3(4 * radius, 0, 0, 0, 10 * radius, 0, 0, 0, depth)
	O.materials.append(wrapper.IceBondMat(young=0.6e9, poisson=0.8, frictionAngle=0.5, density=2650))
	for x in (radius, 3 * radius):
		O.bodies.append(utils.sphere((x, 5 * radius, 0.5 * depth), radius, material=0))
		O.bodies[-1].state.blockedDOFs = "zXY"
	loop = wrapper.InteractionLoop(
		[wrapper.Ig2_Sphere_Sphere_ScGeom()], [wrapper.Ip2_IceBondMat_IceBondMat_IceBondPhys()], [wrapper.Law2_ScGeom_IceBondPhys_IceBond()]
	)
	O.engines = [wrapper.ForceResetter(), wrapper.InsertionSortCollider([wrapper.Bo1_Sphere_Aabb()]), loop, wrapper.NewtonIntegrator(damping=0.3)]
	O.dt = 1e-6
	sample = wrapper.RveSample.fromScene(O._sceneObj)
	sample.freeze(1)
	assert sample.statistics()["bondsIntact"] == 2
	return sample


def block(packed, form="packed", scale=1e4, velocity=0.2, **skeleton):
	"""One cell of ground at -5 degC that is sheared and compressed, four samples behind its points; see test_samples.py."""
	mpm = wrapper.MpmEngine(gridSpacing=0.5, lower=(0, 0), upper=(1, 1), automaticTimeStep=False, heat=wrapper.HeatTransfer(thermalTimeScale=scale))
	mpm.skeleton = wrapper.RveSkeleton(samples=[packed], form=form, **{"strainTolerance": 0, "prediction": False, "minSteps": 10, **skeleton})
	position = np.array([(0.5 * x, 0.5 * y) for x in (0.25, 0.75) for y in (0.25, 0.75)])
	centred = position / 0.5 - 0.5
	motion = velocity * np.column_stack((centred[:, 1] - 0.5 * centred[:, 0], centred[:, 0]))
	mpm.addPoints(position=position, volume=0.0625, porosity=0.4, velocity=motion, temperature=-5)
	mpm.boundaries = [wrapper.RollerBoundary(region=side) for side in ("left", "right", "bottom", "top")]
	O.engines, O.dt = [mpm], 2e-4
	mpm.initialise()
	return mpm
