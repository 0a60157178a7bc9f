# SPDX-License-Identifier: GPL-2.0-or-later
"""Two equal bonds of ice in one line, for closed forms of one bond."""

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
