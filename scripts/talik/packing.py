# SPDX-License-Identifier: GPL-2.0-or-later
"""Periodic packings of discs or spheres in YADE's current scene: making them, bringing them to a stress, measuring them.

A disc is a YADE sphere in one layer with z and the rotations about x and y blocked; its mass is that of a disc as deep as the cell,
rho pi r^2 t_z, its moment of inertia m r^2/2. Stress of discs is force over length and thickness, which is the depth of the cell unless
O.tags["thickness"] [m] gives another. A sphere is free to move. Every function works on the scene that is current in `O`; `talik.rve`
calls them inside a scene of its own. Stresses are in Pa, tension positive.
"""

import math
import random
from dataclasses import dataclass

import numpy as np
from yade import Matrix3, O, Vector3, utils, wrapper
from yade import log as yadeLog
from yade import pack

import talik

cloudDensity = {2: 0.42, 3: 0.30}  # of the first cloud; random placement of discs comes to an end near 0.54, of spheres near 0.38
compactionRate = {2: 0.5, 3: 1.0}  # largest strain rate of the compaction [1/s]
stiffnessSafety = 0.3  # time step in units of sqrt(m/k_n) of the smallest grain
inertialLimit = 1e-3  # largest inertial number while a stress is servoed (careful value of the DEM literature)
chunkSteps = 200  # DEM steps between two looks at the convergence of the compaction
compactionSteps = 400_000  # DEM steps, fewest of those after which a compaction is given up; more where their time step is shorter
hertzPressure = 100e3  # that the time step of Hertz's grains is chosen for; it bears some hundred times as much [Pa]
servoMaxSteps = 600_000  # the same of the control of a stress
servoChunk = 20  # DEM steps between two corrections of the strain rate
servoSteps = 50  # steps in which the proportional part alone would remove an error
servoIntegralSteps = 300  # reset time of the integral part
componentNames = {2: "(xx, yy, xy)", 3: "(xx, yy, zz, yz, xz, xy)"}
leastRolling = 1e-6  # rolling friction of grains that are to roll freely and whose material refuses 0
restSteps = 2000  # steps with a cell at rest before the stress counts as reached


class PackingError(RuntimeError):
	"""A packing cannot be made or brought to the wanted state.

	>>> issubclass(talik.packing.PackingError, RuntimeError)
	True"""


@dataclass(frozen=True)
class Grains:
	"""What a packing is made of. Lengths in m, young in Pa, density in kg/m3.

	>>> grains = talik.packing.Grains(100, 3e-3, 7e-3, 0.1, 0.6e9, 0.8, 2650.0, 0.3, False, ())
	>>> grains.radiusMean
	0.005"""

	number: int
	radiusMin: float
	radiusMax: float
	thickness: float  # of the slice that carries the forces of discs: stress is divided by it
	young: float
	stiffnessRatio: float
	density: float
	damping: float
	ice: bool
	iceBond: tuple  # (name, value) pairs for IceBondMat
	dimension: int = 2  # 2: discs, 3: spheres, to which thickness means nothing
	depth: float = None  # of the cell of discs and of their masses; None: the thickness
	poisson: float = None  # Poisson's ratio of grains whose contacts follow Hertz and Mindlin, young is then theirs; None: linear springs

	@property
	def radiusMean(self):
		return 0.5 * (self.radiusMin + self.radiusMax)

	@property
	def cellDepth(self):
		"""t_z, size of cell and discs along z [m]."""
		return self.thickness if self.depth is None else self.depth

	@property
	def timeStep(self):
		"""Stable DEM time step [s] of the ice-free packing: k_n = E r, m = rho pi r^2 t_z, of spheres rho 4/3 pi r^3; of Hertz's grains at hertzPressure."""
		length = self.cellDepth if self.dimension == 2 else 4 / 3 * self.radiusMin
		return stiffnessSafety * math.sqrt(math.pi * self.density * self.radiusMin * length / self.contactModulus) / math.sqrt(self.rotationalStiffening)

	@property
	def contactModulus(self):
		"""Of the linear springs, or of such as are as stiff as the most loaded contacts of Hertz's grains under hertzPressure [Pa], as HertzMindlin::overLinear."""
		if self.poisson is None:
			return self.young
		modulus = 2 / 3 * self.young / (1 - self.poisson**2)
		return 1.5 * (5 * modulus**2 * hertzPressure * (self.thickness / self.radiusMin if self.dimension == 2 else 1)) ** (1 / 3)

	@property
	def rotationalStiffening(self):
		"""Stiffness of the rotation of the smallest grain on the largest one over that of grains that roll freely [-]."""
		return 1 + dict(self.iceBond).get("alphaKr", 2.0) * self.radiusMax / self.radiusMin if self.resistsRolling else 1.0

	@property
	def resistsRolling(self):
		return not {"alphaKr", "etaRoll"}.isdisjoint(dict(self.iceBond))

	@property
	def bondsCarryMoments(self):
		return not {"bondRadiusFactor", "momentContribution"}.isdisjoint(dict(self.iceBond))

	@property
	def stiffness(self):
		"""Modulus of the packing without ice, in order of magnitude [Pa]."""
		return self.contactModulus * (self.radiusMean / self.thickness if self.dimension == 2 else 0.5)

	@property
	def meanSolid(self):
		"""Area of a disc [m2] or volume of a sphere [m3], mean over radii distributed uniformly."""
		a, b = self.radiusMin, self.radiusMax
		return math.pi * (a * a + a * b + b * b) / 3 if self.dimension == 2 else math.pi * (a + b) * (a * a + b * b) / 3

	def material(self, friction):
		"""The material of the grains with a friction coefficient: IceBondMat, or FrictMat without ice."""
		common = dict(young=self.young, poisson=self.stiffnessRatio, frictionAngle=math.atan(friction), density=self.density, label="grain")
		if self.poisson is not None:
			common.update(poisson=self.poisson, hertzMindlin=True)
		if self.ice:
			rolling = wrapper.RollingIceBondMat if self.resistsRolling else wrapper.IceBondMat
			return (wrapper.MomentIceBondMat if self.bondsCarryMoments else rolling)(**common, **dict(self.iceBond))
		return wrapper.FrictMat(**common)

	def interactionLoop(self):
		"""YADE's InteractionLoop of grains of this material."""
		if self.ice:
			ip2, law = wrapper.Ip2_IceBondMat_IceBondMat_IceBondPhys(), wrapper.Law2_ScGeom_IceBondPhys_IceBond()
		else:
			ip2, law = wrapper.Ip2_FrictMat_FrictMat_FrictPhys(), wrapper.Law2_ScGeom_FrictPhys_CundallStrack()
		return wrapper.InteractionLoop([wrapper.Ig2_Sphere_Sphere_ScGeom()], [ip2], [law])

	def engines(self, *controllers):
		"""Engines of a scene of such grains, with controllers between contacts and motion."""
		return [
			wrapper.ForceResetter(),
			wrapper.InsertionSortCollider([wrapper.Bo1_Sphere_Aabb()]),
			self.interactionLoop(),
			*controllers,
			wrapper.NewtonIntegrator(damping=self.damping),
		]


def iceBondAvailable():
	"""True when the ice-bond classes of Talik are registered in the running YADE.

	>>> talik.packing.iceBondAvailable()
	True"""
	return all(hasattr(wrapper, name) for name in ("IceBondMat", "Ip2_IceBondMat_IceBondMat_IceBondPhys", "Law2_ScGeom_IceBondPhys_IceBond"))


# --- running -------------------------------------------------------------------------------------------------------------


def advance(steps):
	"""Advances the current scene; with one thread, so that a sample does not depend on how many yade was given.

	>>> with talik.inspect(packed.open()):
	...     talik.packing.advance(10)"""
	talik.runSerially(steps)


# --- measuring -----------------------------------------------------------------------------------------------------------


def dimension():
	"""2 if the current scene has discs, that is bodies that lie in one layer or are held there, 3 if it has spheres.

	>>> with talik.inspect(packed.open()):
	...     talik.packing.dimension()
	2"""
	if any(body.state.blockedDOFs for body in O.bodies):
		return 2
	heights = (float(body.state.pos[2]) for body in O.bodies)
	first = next(heights, None)
	return 2 if first is not None and all(height == first for height in heights) else 3


def cell():
	"""Matrix (d, d) [m] of the cell in d dimensions, its vectors the columns.

	>>> with talik.inspect(packed.open()):
	...     size = talik.packing.cell()"""
	d, h = dimension(), O.cell.hSize
	return np.array([[h[i, j] for j in range(d)] for i in range(d)])


def inPlaneCell():
	"""Matrix (2, 2) [m] of the in-plane cell, its vectors the columns.

	>>> with talik.inspect(packed.open()):
	...     size = talik.packing.inPlaneCell()"""
	h = O.cell.hSize
	return np.array([[h[0, 0], h[0, 1]], [h[1, 0], h[1, 1]]])


def porosity():
	"""Porosity of the current scene: 1 - area of discs / area of the cell, of spheres by volume.

	>>> with talik.inspect(packed.open()):
	...     n = talik.packing.porosity()"""
	radii = [body.shape.radius for body in O.bodies]
	solid = math.pi * sum(r**2 for r in radii) if dimension() == 2 else 4 / 3 * math.pi * sum(r**3 for r in radii)
	return 1 - solid / abs(np.linalg.det(cell()))


def stress():
	"""Love-Weber stress of the current scene [Pa], tension positive, symmetrised: (xx, yy, xy), of spheres (xx, yy, zz, yz, xz, xy).

	>>> with talik.inspect(packed.open()):
	...     xx, yy, xy = talik.packing.stress()"""
	s, d = utils.getStress(), dimension()
	return np.array([0.5 * (s[i, j] + s[j, i]) for i, j in _pairs[d]]) * (O.cell.hSize[2, 2] / thickness() if d == 2 else 1)


def thickness():
	"""Thickness [m] of the slice that carries the forces of the current scene's discs: O.tags["thickness"], or the depth of the cell.

	>>> with talik.inspect(packed.open()):
	...     thickness = talik.packing.thickness()"""
	if "thickness" not in O.tags.keys():
		return float(O.cell.hSize[2, 2])
	try:
		value = float(O.tags["thickness"])
	except ValueError:
		value = math.nan
	if not 0 < value < math.inf:
		raise ValueError(f'O.tags["thickness"] is {O.tags["thickness"]!r}; it must be the thickness of the discs in m, a number greater than 0')
	return value


def contactNormals():
	"""Unit normals of all contacts that exist, array (n, d) in d dimensions.

	>>> with talik.inspect(packed.open()):
	...     normals = talik.packing.contactNormals()"""
	return _rows(i.geom.normal for i in O.interactions if i.isReal)


def fabricTensor(normals):
	"""Contact fabric F = mean of n (x) n of normals (n, d), array (d, d); the zero matrix without contacts.

	>>> talik.packing.fabricTensor(np.array([(1.0, 0.0), (0.0, 1.0)])).tolist()
	[[0.5, 0.0], [0.0, 0.5]]"""
	normals = np.asarray(normals, dtype=float)
	return normals.T @ normals / max(len(normals), 1)


def fabricAnisotropy(fabric):
	"""Difference of the largest and the smallest principal value of a fabric tensor: 0 isotropic, 1 all contacts parallel.

	>>> float(talik.packing.fabricAnisotropy(np.array([[0.5, 0.0], [0.0, 0.5]])))
	0.0"""
	if len(fabric) == 3:
		return float(np.ptp(np.linalg.eigvalsh(fabric)))
	return float(math.hypot(fabric[0, 0] - fabric[1, 1], 2 * fabric[0, 1]))


def sampleArrays():
	"""The current scene as plain arrays, for pictures and files. With m grains and n contacts in d dimensions:

	centre (m, d) [m] inside the cell, radius (m,) [m]; start, end (n, d) [m] ends of the branch vectors, start inside the cell;
	normal (n, d); normalForce (n,) [N], compression positive; shearForce (n,) [N], its size; state (n,) 0 frictional, 1 bonded, 2 broken;
	cell (d, d) [m], whose rows are the sides of the periodic cell, which begins at the origin.

	>>> with mpm.inspect(5):
	...     forces = talik.packing.sampleArrays()["normalForce"]"""
	contacts = [i for i in O.interactions if i.isReal]
	bodies, h = O.bodies, O.cell.hSize
	first = [bodies[i.id1].state.pos for i in contacts]
	branch = [bodies[i.id2].state.pos + h * Vector3(*i.cellDist) - position for i, position in zip(contacts, first)]
	start = _rows(O.cell.wrap(position) for position in first)
	return dict(
		centre=_rows(O.cell.wrap(body.state.pos) for body in bodies),
		radius=np.array([body.shape.radius for body in bodies]),
		start=start,
		end=start + _rows(branch),
		normal=contactNormals(),
		normalForce=np.array([i.phys.normalForce.dot(i.geom.normal) for i in contacts]),
		shearForce=np.array([i.phys.shearForce.norm() for i in contacts]),
		state=np.array([getattr(i.phys, "bondState", 0) for i in contacts], dtype=int),
		cell=_rows(h.col(k) for k in range(dimension())),
	)


_pairs = {2: ((0, 0), (1, 1), (0, 1)), 3: ((0, 0), (1, 1), (2, 2), (1, 2), (0, 2), (0, 1))}  # components of a symmetric tensor


def _rows(vectors):
	d = dimension()
	return np.array([tuple(v)[:d] for v in vectors]).reshape(-1, d)


def _tensor(components):
	"""Matrix3 of the components of a symmetric tensor."""
	m = np.zeros((3, 3))
	for (i, j), component in zip(_pairs[2 if len(components) == 3 else 3], components):
		m[i, j] = m[j, i] = component
	return Matrix3(*map(float, m.ravel()))


# --- making --------------------------------------------------------------------------------------------------------------


def fillCloud(grains, friction, seed):
	"""Grains without contacts, placed at random in a square or cubic periodic cell, and engines to move them.

	>>> grains = talik.packing.Grains(30, 3e-3, 7e-3, 0.1, 0.6e9, 0.8, 2650.0, 0.3, False, ())
	>>> with talik.scratchScene():
	...     talik.packing.fillCloud(grains, friction=0.2, seed=1)"""
	side = (grains.number * grains.meanSolid / cloudDensity[grains.dimension]) ** (1 / grains.dimension)
	O.periodic = True
	O.cell.hSize = Matrix3(side, 0, 0, 0, side, 0, 0, 0, grains.cellDepth if grains.dimension == 2 else side)
	if grains.depth is not None:
		O.tags["thickness"] = repr(grains.thickness)
	O.materials.append(grains.material(friction))
	dice = random.Random(seed)  # YADE's own colours differ from run to run
	for centre, radius in _cloud(grains, side, seed):
		O.bodies.append(_grain(centre, radius, grains, colour=[dice.random() for _ in range(3)]))
	O.engines = grains.engines()
	O.dt = grains.timeStep


def fillPair(grains):
	"""Two grains that touch, the smallest scene in which everything of a sample occurs.

	>>> grains = talik.packing.Grains(30, 3e-3, 7e-3, 0.1, 0.6e9, 0.8, 2650.0, 0.3, False, ())
	>>> with talik.scratchScene():
	...     talik.packing.fillPair(grains)"""
	radius = grains.radiusMean
	depth = grains.cellDepth if grains.dimension == 2 else 10 * radius
	middle = 0.5 * depth
	O.periodic = True
	O.cell.hSize = Matrix3(10 * radius, 0, 0, 0, 10 * radius, 0, 0, 0, depth)
	O.materials.append(grains.material(0.5))
	for x in (4 * radius, 5.99 * radius):
		O.bodies.append(_grain((x, 5 * radius, middle), radius, grains))
	O.engines = grains.engines()
	O.dt = grains.timeStep


def _cloud(grains, side, seed):
	low, high = (0, side) if grains.dimension == 3 else (0.5 * grains.cellDepth, 0.5 * grains.cellDepth)
	spheres = pack.SpherePack()
	fuzz = (grains.radiusMax - grains.radiusMin) / (grains.radiusMax + grains.radiusMin)
	yadeLog.setLevel("SpherePack", 1)  # it warns that the cloud is flat, which is what we want
	try:
		placed = spheres.makeCloud((0, 0, low), (side, side, high), rMean=grains.radiusMean, rRelFuzz=fuzz, num=grains.number, periodic=True, seed=seed)
	finally:
		yadeLog.unsetLevel("SpherePack")
	if placed != grains.number:
		raise PackingError(f"only {placed} of {grains.number} grains could be placed at random; use another seed than {seed}")
	return list(spheres)


def _grain(centre, radius, grains, colour=None):
	body = utils.sphere(centre, radius, material="grain", color=colour)
	if grains.dimension == 3:
		return body
	body.state.mass = grains.density * math.pi * radius**2 * grains.cellDepth
	body.state.inertia = 0.5 * body.state.mass * radius**2 * Vector3(1, 1, 1)
	body.state.blockedDOFs = "zXY"
	return body


def compact(grains, pressure, maxSteps=None):
	"""Isotropic compression of a cloud to `pressure` [Pa, > 0] with YADE's PeriTriaxController.

	>>> grains = talik.packing.Grains(30, 3e-3, 7e-3, 0.1, 0.6e9, 0.8, 2650.0, 0.3, False, ())
	>>> with talik.scratchScene():
	...     talik.packing.fillCloud(grains, friction=0.2, seed=1)
	...     talik.packing.compact(grains, pressure=100e3)"""
	d, rate = grains.dimension, compactionRate[grains.dimension]
	maxSteps = maxSteps or round(compactionSteps * math.sqrt(grains.rotationalStiffening))
	inYade = pressure if grains.depth is None else pressure * grains.thickness / grains.depth  # YADE divides by the depth of the cell
	triax = wrapper.PeriTriaxController(
		goal=(-inYade, -inYade, -inYade if d == 3 else 0),
		stressMask=7 if d == 3 else 3,
		dynCell=True,
		maxStrainRate=(rate, rate, rate if d == 3 else 0),
		relStressTol=2e-3,
		maxUnbalanced=1e-3,
	)
	O.engines = grains.engines(triax)
	for _ in range(0, maxSteps, chunkSteps):
		advance(chunkSteps)
		if np.abs(stress()[:d] + pressure).max() < 5e-3 * pressure and utils.unbalancedForce() < 2e-3:
			break
	else:
		raise PackingError(f"no equilibrium at {pressure:g} Pa within {maxSteps} steps; use another seed or more grains")
	O.engines = grains.engines()
	stopCell()


def compactPacked(grains, pressure, friction, seed, etaRoll=0.0):
	"""A cloud of grains compacted to an isotropic `pressure` [Pa] in packed form, an RveSample: several times faster than compact. Friction and rolling friction
	of the compaction decide how dense it gets; it keeps them.

	etaRoll  as CohFrictMat.etaRoll; it counts only for grains that resist rolling

	>>> grains = talik.packing.Grains(30, 3e-3, 7e-3, None, 0.6e9, 0.8, 2650.0, 0.3, True, (), 3)
	>>> sample = talik.packing.compactPacked(grains, 100e3, friction=0.2, seed=1)"""
	step, near, most = 2e-4, 0.3, 5000  # strain of a call; part of the pressure at which the control of stress takes over; calls
	with talik.scratchScene():
		fillCloud(grains, friction, seed)
		if grains.resistsRolling:
			setRolling(etaRoll)
		sample = wrapper.RveSample.fromScene(O._sceneObj)
	sample.maxInertialNumber, sample.minSteps = 5e-3, 10
	inPlane = Matrix3(-step, 0, 0, 0, -step, 0, 0, 0, -step if grains.dimension == 3 else 0)
	for _ in range(most):
		result = sample.apply(inPlane, 0)
		if result["blewUp"]:
			raise PackingError(f"the compaction blew up: {result['reason']}; use another seed than {seed}")
		if -np.mean(result["stress"][: grains.dimension]) > near * pressure:
			break
	if not sample.servo(*[-pressure] * grains.dimension):
		raise PackingError(f"no equilibrium at {pressure:g} Pa; use another seed than {seed} or more grains")
	return sample


def setFriction(friction):
	"""Sets the friction coefficient of the material and of every contact that exists.

	>>> with talik.inspect(packed.open()):
	...     talik.packing.setFriction(0.3)"""
	for material in O.materials:
		material.frictionAngle = math.atan(friction)
	for interaction in O.interactions:
		if interaction.isReal:
			interaction.phys.tangensOfFrictionAngle = friction


def setRolling(etaRoll):
	"""Sets the rolling friction of materials that resist rolling and of every contact that exists; next to none for 0, which such materials refuse.

	>>> rolling = talik.rve.pack(talik.rve.prepare(grains=30, porosity=0.19, ice=True, etaRoll=0.1))
	>>> with talik.inspect(rolling.open()):
	...     talik.packing.setRolling(0.2)"""
	for material in O.materials:
		material.etaRoll = max(etaRoll, leastRolling)
	for contact in O.interactions:
		if contact.isReal:
			contact.phys.maxRollPl = etaRoll * min(O.bodies[grain].shape.radius for grain in (contact.id1, contact.id2))


def stopCell():
	"""No motion of the cell; the present shape becomes the reference.

	>>> with talik.inspect(packed.open()):
	...     talik.packing.stopCell()"""
	O.cell.velGrad = Matrix3.Zero
	O.cell.trsf = Matrix3.Identity


def strainLimit(grains, pressure):
	"""Largest strain of one DEM step [-] that keeps the motion quasi-static at `pressure` [Pa].

	>>> grains = talik.packing.Grains(30, 3e-3, 7e-3, 0.1, 0.6e9, 0.8, 2650.0, 0.3, False, ())
	>>> limit = talik.packing.strainLimit(grains, pressure=100e3)"""
	pressure = max(pressure, 1e3)
	if grains.dimension == 3:
		return inertialLimit * grains.timeStep / (2 * grains.radiusMean) * math.sqrt(pressure / grains.density)
	slowness = math.sqrt(grains.rotationalStiffening)  # of the time step
	return 0.5 * inertialLimit * stiffnessSafety * math.sqrt(math.pi * pressure * grains.thickness / (grains.contactModulus * grains.radiusMean)) / slowness


def contactStiffness():
	"""Elastic stiffness M of the current scene in compression [Pa], whatever its law: sum of k_n l^2 over its contacts, times 3/8 per volume for discs, 1/5
	for spheres; without contacts that of its materials.

	>>> with talik.inspect(packed.open()):
	...     modulus = talik.packing.contactStiffness()"""
	d = dimension()
	volume = abs(np.linalg.det(cell())) * (thickness() if d == 2 else 1)
	bodies, h = O.bodies, O.cell.hSize
	total = 0.0
	for contact in O.interactions:
		if contact.isReal:
			branch = bodies[contact.id2].state.pos - bodies[contact.id1].state.pos + h * Vector3(*contact.cellDist)
			total += getattr(contact.phys, "kn", 0.0) * branch.squaredNorm()
	if total > 0:
		return float(total / volume * (3 / 8 if d == 2 else 1 / 5))
	young, radius = max(getattr(body.mat, "young", 0.0) for body in bodies), np.mean([body.shape.radius for body in bodies if hasattr(body.shape, "radius")])
	if not young > 0:
		raise PackingError("the scene has no contacts and no material with young, so that its stiffness is unknown; compact it in its own script first")
	return float(young * (radius / thickness() if d == 2 else 0.5))


def _strainLimitOfScene(pressure):
	"""As strainLimit, of the masses and the time step that the current scene has."""
	heavy = [body for body in O.bodies if body.state.mass > 0]
	mass, size = np.mean([body.state.mass for body in heavy]), 2 * np.mean([body.shape.radius for body in heavy if hasattr(body.shape, "radius")])
	return float(inertialLimit * O.dt * math.sqrt(max(pressure, 1e3) * (thickness() if dimension() == 2 else size) / mass))


def strainSince(former):
	"""Largest strain component between an earlier cell matrix and the present one [-].

	>>> with talik.inspect(packed.open()):
	...     strain = talik.packing.strainSince(talik.packing.cell())"""
	gradient = cell() @ np.linalg.inv(former) - np.eye(len(former))
	return float(np.abs(0.5 * (gradient + gradient.T)).max())


def servoStress(grains, goal, tolerance=2e-3, maxSteps=None, maxStrain=0.1):
	"""Brings the current scene to the stress `goal` [Pa], components as of stress(), by straining the cell, and to rest there.

	Proportional-integral control of all components (of discs those in the plane): the strain of one step is (error + integral)/(50 M) with M the
	stiffness of the packing (of discs E r/t_z), limited so that the motion stays quasi-static. The integral part is needed near yield, where
	a proportional control creeps. `tolerance` is in units of the mean pressure. A stress beyond the strength of the packing is
	refused when the strain passes `maxStrain`.

	grains  Grains of the scene; None: a scene of any law, whose stiffness and masses are measured as it stands

	>>> grains = talik.packing.Grains(30, 3e-3, 7e-3, 0.1, 0.6e9, 0.8, 2650.0, 0.3, False, ())
	>>> with talik.inspect(talik.rve.openScene(sample)):
	...     talik.packing.servoStress(grains, (-95e3, -100e3, 0), tolerance=0.02)"""
	maxSteps = maxSteps or round(servoMaxSteps * math.sqrt(grains.rotationalStiffening if grains else 1))
	goal = np.asarray(goal, dtype=float)
	if goal.shape != (components := 3 if dimension() == 2 else 6,):
		raise ValueError(f"servoStress: goal is {goal.tolist()}; give {components} components {componentNames[dimension()]} in Pa")
	pressure = max(-float(np.mean(goal[: dimension()])), 1.0)
	gain = 1 / (servoSteps * (grains.stiffness if grains else contactStiffness()))
	limit = strainLimit(grains, pressure) if grains else _strainLimitOfScene(pressure)
	integral = np.zeros(len(goal))
	start, first = O.iter, cell()
	while O.iter - start < maxSteps and strainSince(first) < maxStrain:
		error = goal - stress()
		if np.abs(error).max() < 0.5 * tolerance * pressure and utils.unbalancedForce() < 1e-3:
			_rest()
			if np.abs(goal - stress()).max() < tolerance * pressure:
				stopCell()
				return
			integral[:] = 0
		integral = np.clip(integral + gain * error * servoChunk / servoIntegralSteps, -limit, limit)
		rate = np.clip(gain * error + integral, -limit, limit) / O.dt
		O.cell.velGrad = _tensor(rate)
		advance(servoChunk)
	reached = ", ".join(f"{s:.4g}" for s in stress())
	raise PackingError(
		f"stress {componentNames[dimension()]} = ({', '.join(f'{g:g}' for g in goal)}) Pa is not reached: at strain {strainSince(first):.3f}, "
		f"after {O.iter - start} steps, it is ({reached}); "
		"it must lie within the strength of grains without ice (friction angle near 20 degrees)"
	)


def _rest():
	O.cell.velGrad = Matrix3.Zero
	advance(restSteps)
