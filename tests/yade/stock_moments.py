# SPDX-License-Identifier: GPL-2.0-or-later
"""Scenes in stock YADE's own law of moments."""

import talik
from yade import O, utils, wrapper


def openStock(scene, contactOf, moving=False, reach=1.0, cohesive=False, **material):
	"""Grains and contacts of a scene become the current scene, in Law2_ScGeom6D_CohFrictPhys_CohesionMoment. contactOf(interaction): what the contact has there,
	attributes of CohFrictPhys. moving: grains keep their velocities. reach: of contacts across gaps, in sums of radii. material: of CohFrictMat."""
	with talik.inspect(scene):
		grains = [(b.state.pos, b.state.vel, b.state.angVel, b.shape.radius, b.state.mass, b.state.inertia, b.state.blockedDOFs) for b in O.bodies]
		contacts = {(i.id1, i.id2): contactOf(i) for i in O.interactions if i.isReal}
		size, dt, damping = O.cell.hSize, O.dt, O.engines[-1].damping
	O.reset()
	O.periodic = True
	O.cell.hSize = size
	O.materials.append(wrapper.CohFrictMat(isCohesive=cohesive, momentRotationLaw=True, **material))
	for position, velocity, spin, radius, mass, inertia, blocked in grains:
		body = utils.sphere(position, radius, material=0)
		body.state.mass, body.state.inertia, body.state.blockedDOFs = mass, inertia, blocked
		if moving:
			body.state.vel, body.state.angVel = velocity, spin
		O.bodies.append(body)
	law = wrapper.Law2_ScGeom6D_CohFrictPhys_CohesionMoment(always_use_moment_law=True, useIncrementalForm=True)
	ip2 = wrapper.Ip2_CohFrictMat_CohFrictMat_CohFrictPhys(setCohesionNow=cohesive, setCohesionOnNewContacts=cohesive)
	collider = wrapper.InsertionSortCollider([wrapper.Bo1_Sphere_Aabb(aabbEnlargeFactor=reach)], allowBiggerThanPeriod=True)
	geometry = wrapper.Ig2_Sphere_Sphere_ScGeom6D(interactionDetectionFactor=reach)
	O.engines = [
		wrapper.ForceResetter(),
		collider,
		wrapper.InteractionLoop([geometry], [ip2], [law]),
		wrapper.NewtonIntegrator(damping=damping),
	]
	O.dt = 1e-30  # contacts come into being
	O.step()
	if reach > 1:
		for i in list(O.interactions):
			if i.isReal and (i.id1, i.id2) not in contacts:
				O.interactions.erase(i.id1, i.id2)
	geometry.interactionDetectionFactor = 1
	assert {(i.id1, i.id2) for i in O.interactions if i.isReal} == contacts.keys()
	for ids, values in contacts.items():
		for name, value in values.items():
			setattr(O.interactions[ids].phys, name, value)
	O.dt = dt
