# SPDX-License-Identifier: GPL-2.0-or-later
"""Which scenes of YADE the packed form of a sample can stand for: those of which it knows every shape, law and parameter."""

import math

from yade import wrapper

from talik import _talik

inPlane = {"z", "X", "Y"}  # directions in which a disc is held
covered = {"ForceResetter", "InsertionSortCollider", "InteractionLoop", "NewtonIntegrator"}  # engines whose work the fused step does


def reason(cell, bodies, engines, contacts):
	"""Why a scene cannot be packed, as the end of a sentence; empty if it can. cell: None of a scene that is not periodic."""
	if cell is None:
		return "it has no periodic cell"
	if not bodies:
		return "it has no bodies"
	height = bodies[0].state.pos[2]
	discs = bool(bodies[0].state.blockedDOFs) or all(body.state.pos[2] == height for body in bodies)
	found = (discs and _ofCell(cell)) or _ofBodies(bodies, discs) or _ofEngines(engines)
	return found or _ofContactLaw(engines) or _ofIntegrator(engines, cell) or _ofContacts(contacts, bodies[0].material)


def thickness(tags, depth):
	"""Of the slice that carries the forces of discs [m]: what the tag says, else the depth of the cell; or a sentence where the tag is no thickness."""
	for tag in tags:
		if tag.startswith("thickness="):
			words = tag.partition("=")[2]
			try:
				found = float(words)
			except ValueError:
				found = math.nan
			if found > 0 and math.isfinite(found):
				return found
			return f"O.tags[\"thickness\"] is '{words}'; it must be the thickness of the discs in m, a number greater than 0"
	return depth


def againstSample(cell, engines, bodies, timeStep):
	"""Why a scene cannot be a sample that runs open, whatever its grains and laws; empty if nothing is known."""
	if cell is None:
		return "it has no periodic cell"
	if not timeStep > 0:
		return "its time step is not positive"
	if cell.homoDeform != 2:
		return f"its cell has homoDeform={cell.homoDeform} instead of 2"
	if not bodies:
		return "it has no bodies"
	refused = (
		(wrapper.PeriodicEngine, "would act in YADE's current scene (remove it)"),
		(wrapper.TimeStepper, "would change the time step while a strain is applied (remove it, set dt)"),
		(wrapper.BoundaryController, "would move the cell as well (remove it or set dead=True)"),
	)
	alive = [engine for engine in engines if not engine.dead]
	for engine in alive:
		for kind, does in refused:
			if isinstance(engine, kind):
				return f"its {type(engine).__name__} {does}"
	return "" if any(isinstance(engine, wrapper.NewtonIntegrator) for engine in alive) else "it has no NewtonIntegrator"


def _ofCell(cell):
	for matrix in (cell.hSize, cell.velGrad, cell.nextVelGrad, cell.trsf):
		if any(matrix[place] != 0 for place in ((0, 2), (1, 2), (2, 0), (2, 1))):
			return "its cell is skewed out of the plane"
	return "its cell is strained out of the plane" if cell.velGrad[2, 2] != 0 or cell.nextVelGrad[2, 2] != 0 else ""


def _ofBodies(bodies, discs):
	if len(bodies) > 65000:
		return "it has more than 65000 grains"
	first = bodies[0]
	for body in bodies:
		own = _ofBody(body, discs)
		if own:
			return f"body {body.id} {own}"
		if not _talik.sameObject(body.material, first.material):
			return "its grains have several materials"
		if discs and abs(body.state.pos[2] - first.state.pos[2]) > 1e-12 * body.shape.radius:
			return "its grains do not lie in one layer"
	return ""


def _ofBody(body, discs):
	motion = body.state
	if not isinstance(body.shape, wrapper.Sphere):
		return "is not a sphere"
	if body.clumpId >= 0:
		return "belongs to a clump"
	ofMotion = _ofMotion(motion, discs)
	if ofMotion:
		return ofMotion
	if not (motion.mass > 0 and motion.inertia[2] > 0):
		return "has no mass or no moment of inertia"
	if not motion.isDamped:
		return "is exempt from damping"
	if motion.densityScaling != wrapper.State().densityScaling:
		return "has a scaled density"
	return "" if isinstance(body.material, wrapper.FrictMat) else "has no frictional material"


def _ofMotion(motion, discs):
	held = set(motion.blockedDOFs)
	if not discs:
		if held:
			return "is held (blockedDOFs): free all directions for spheres, or hold all in one layer for discs"
		return "" if motion.inertia[0] == motion.inertia[1] == motion.inertia[2] else "has not the same moment of inertia about all axes"
	if not held >= inPlane:
		return "is free to move out of the plane (block z and the rotations X, Y)"
	if held != inPlane:
		return "is held in the plane"
	return "moves out of the plane" if motion.vel[2] != 0 or motion.angVel[0] != 0 or motion.angVel[1] != 0 else ""


def _ofEngines(engines):
	for engine in engines:
		name = type(engine).__name__
		if not (engine.dead or name in covered or (name == "GrainSwelling" and engine.radiusRule == "bookkeeping")):
			return f"it has a {name}"
	return ""


def _named(engines, name):
	return next((engine for engine in engines if type(engine).__name__ == name), None)


def _only(dispatcher):
	"""The functor of a dispatcher that has one, and the name of its class."""
	functors = dispatcher.functors
	return (functors[0], type(functors[0]).__name__) if len(functors) == 1 else (None, "")


def _ofContactLaw(engines):
	loop = _named(engines, "InteractionLoop")
	if loop is None:
		return "it has no InteractionLoop"
	geometry, ofGeometry = _only(loop.geomDispatcher)
	if ofGeometry != "Ig2_Sphere_Sphere_ScGeom":
		return "its contact geometry is not Ig2_Sphere_Sphere_ScGeom alone"
	if geometry.interactionDetectionFactor != 1:
		return "its contacts are detected at a distance (interactionDetectionFactor)"
	if not geometry.avoidGranularRatcheting:
		return "its contact geometry has avoidGranularRatcheting=False"
	(parameters, ofParameters), (law, ofLaw) = _only(loop.physDispatcher), _only(loop.lawDispatcher)
	laws = {
		"Law2_ScGeom_FrictPhys_CundallStrack": "Ip2_FrictMat_FrictMat_FrictPhys",
		"Law2_ScGeom_IceBondPhys_IceBond": "Ip2_IceBondMat_IceBondMat_IceBondPhys",
	}
	if ofLaw not in laws:
		return f"its contact law is {ofLaw or 'not a single one'}"
	if ofParameters != laws[ofLaw]:
		return f"its contact parameters do not come from {laws[ofLaw]} alone"
	if ofLaw == "Law2_ScGeom_FrictPhys_CundallStrack":
		return "its law never erases a contact" if law.neverErase else ""
	if parameters.bondNewContacts:
		return "its new contacts are bonded (bondNewContacts)"
	return "its law heals broken bonds (healBroken)" if law.healBroken else ""


def _ofIntegrator(engines, cell):
	newton = _named(engines, "NewtonIntegrator")
	if newton is None:
		return "it has no NewtonIntegrator"
	if newton.gravity.norm() != 0:
		return "its NewtonIntegrator has gravity"
	if newton.mask > 0:
		return "its NewtonIntegrator moves a part of the bodies only"
	return f"its cell has homoDeform={cell.homoDeform} instead of 2" if cell.homoDeform != 2 else ""


def _ofContacts(contacts, material):
	for contact in contacts:
		own = _ofContact(contact, material)
		if own:
			return f"contact {contact.id1}-{contact.id2} {own}"
	return ""


def _differs(a, b):
	return not abs(a - b) <= 1e-9 * abs(b)


def _ofContact(contact, material):
	"""Stiffness and friction may have been set contact by contact: the packed form has those of the material."""
	geom, phys = contact.geom, contact.phys
	if not (isinstance(geom, wrapper.ScGeom) and isinstance(phys, wrapper.FrictPhys)):
		return "is not made by its contact law"
	if max(map(abs, contact.cellDist)) > 127:
		return "reaches across more than 127 cells"
	grain, friction = 2 * material.young * geom.refR1 * geom.refR2 / (geom.refR1 + geom.refR2), math.tan(material.frictionAngle)
	if _differs(phys.tangensOfFrictionAngle, friction):
		return f"has the friction {phys.tangensOfFrictionAngle:f} and its material {friction:f}"
	bonded = isinstance(phys, wrapper.IceBondPhys)
	normal, ratio = (phys.grainStiffness, phys.stiffnessRatio) if bonded else (phys.kn, phys.ks / phys.kn if phys.kn else math.nan)
	hertz, wanted = _ofHertz(geom, material) if bonded and material.hertzMindlin else (0.0, material.poisson)
	if _differs(normal, grain) or _differs(ratio, wanted) or (bonded and _differs(phys.kno, hertz)):
		return "has another stiffness than its material gives"
	return (_ofRolling(phys, geom, material) or _ofMoments(phys, material) or _ofBond(phys, material)) if bonded else ""


def _ofHertz(geom, material):
	"""kno and k_s/k_n of spheres of one material."""
	modulus = 2 / 3 * material.young / (1 - material.poisson**2)
	return modulus * math.sqrt(geom.refR1 * geom.refR2 / (geom.refR1 + geom.refR2)), 2 * (1 - material.poisson) / (2 - material.poisson)


def _ofRolling(phys, geom, material):
	if not (isinstance(material, wrapper.RollingIceBondMat) and material.etaRoll > 0 and material.alphaKr > 0):
		return ""
	if not isinstance(phys, wrapper.RollingIceBondPhys):
		return "is not made by its material, which resists rolling"
	stiffness = material.alphaKr * phys.stiffnessRatio * (phys.kno or phys.grainStiffness) * geom.refR1 * geom.refR2
	if _differs(phys.kr, stiffness) or _differs(phys.maxRollPl, material.etaRoll * min(geom.refR1, geom.refR2)):
		return "resists rolling in another way than its material gives"
	return ""


def _ofMoments(phys, material):
	if not (isinstance(material, wrapper.MomentIceBondMat) and material.bondRadiusFactor > 0):
		return ""
	if not isinstance(phys, wrapper.MomentIceBondPhys):
		return "is not made by its material, whose bonds carry moments"
	same = (phys.bondRadiusFactor, phys.momentContribution) == (material.bondRadiusFactor, material.momentContribution)
	return "" if same else "carries moments in another way than its material gives"


def _ofBond(bond, material):
	if bond.uRef != 0:
		return "has a reference overlap"
	if bond.iceSaturation != material.iceSaturation or bond.bondNow:
		return "has not taken up the ice saturation of the material yet (do a step first)"
	return ""
