# SPDX-License-Identifier: GPL-2.0-or-later
# Writes tests/unit/data/packed_reference.txt: a periodic sample of discs compacted by stock YADE and what stock YADE's own
# engines make of it after 1, 100 and 500 steps of combined shear, compression and spin.
#
#   yade -n -x -j1 tests/yade/make_packed_reference.py [discs [output file]]
#
# Discs are spheres in one layer (z and rotations about x and y blocked) with the mass and inertia of discs 0.1 m thick.
import math, os, sys
from yade import pack

discs = int(sys.argv[1]) if len(sys.argv) > 1 else 200
here = os.path.dirname(os.path.abspath(sys.argv[0]))
output = sys.argv[2] if len(sys.argv) > 2 else os.path.join(here, "..", "unit", "data", "packed_reference.txt")

thickness, density, young, stiffnessRatio = 0.1, 2650.0, 6e8, 0.8
compactionFriction, friction, damping, pressure, dt = 0.2, 0.5, 0.2, 1e5, 1.5e-5
gradient = Matrix3(0.02, 0.035, 0, -0.015, -0.03, 0, 0, 0, 0)
checkpoints = (1, 100, 500)

O.periodic = True
side = math.sqrt(discs * math.pi * 27.3e-6 / 0.5)
O.cell.hSize = Matrix3(side, 0, 0, 0, side, 0, 0, 0, thickness)
material = O.materials.append(FrictMat(young=young, poisson=stiffnessRatio, frictionAngle=math.atan(compactionFriction), density=density))
cloud = pack.SpherePack()
cloud.makeCloud((0, 0, thickness / 2), (side, side, thickness / 2), rMean=5e-3, rRelFuzz=0.4, num=discs, periodic=True, seed=1)
cloud.toSimulation(material=material)
for b in O.bodies:
	r = b.shape.radius
	b.state.blockedDOFs = "zXY"
	b.state.mass = density * thickness * math.pi * r * r
	b.state.inertia = Vector3(1, 1, 0.5) * b.state.mass * r * r

compaction = PeriTriaxController(
	label="compaction",
	goal=(-pressure, -pressure, 0),
	stressMask=3,
	dynCell=True,
	maxUnbalanced=1e-4,
	maxStrainRate=(0.5, 0.5, 0),
	mass=0.2,
	globUpdate=1,
	relStressTol=1e-3,
	doneHook="O.pause()",
)
newton = NewtonIntegrator(damping=damping)
O.engines = [
	ForceResetter(),
	InsertionSortCollider([Bo1_Sphere_Aabb()], allowBiggerThanPeriod=True),
	InteractionLoop([Ig2_Sphere_Sphere_ScGeom()], [Ip2_FrictMat_FrictMat_FrictPhys()], [Law2_ScGeom_FrictPhys_CundallStrack()]),
	compaction,
	newton,
]
O.dt = dt
O.run(1000000, True)
O.engines = [e for e in O.engines if e is not compaction and not isinstance(e, PeriTriaxController)]
O.cell.velGrad = Matrix3.Zero
O.materials[material].frictionAngle = math.atan(friction)
for i in O.interactions:
	i.phys.tangensOfFrictionAngle = friction
O.run(3000, True)
print("compacted: steps", O.iter, "unbalanced", utils.unbalancedForce(), "stress", getStress())


def number(x):
	return repr(float(x))


def tangential(i):
	n, f = i.geom.normal, i.phys.shearForce
	return -f[0] * n[1] + f[1] * n[0]


def matrix(m):
	return " ".join(number(m[a, b]) for a, b in ((0, 0), (0, 1), (1, 0), (1, 1)))


def dump(out, title):
	contacts = [i for i in O.interactions if i.isReal]
	contacts.sort(key=lambda i: (i.id1, i.id2))
	out.write("%s step %d\n" % (title, O.iter))
	out.write("hSize %s\ntrsf %s\n" % (matrix(O.cell.hSize), matrix(O.cell.trsf)))
	out.write("stress %s\n" % matrix(getStress()))
	out.write("grains %d\n" % len(O.bodies))
	for b in O.bodies:
		s = b.state
		out.write(" ".join(map(number, (s.pos[0], s.pos[1], s.vel[0], s.vel[1], s.angVel[2]))) + "\n")
	out.write("contacts %d\n" % len(contacts))
	for i in contacts:
		out.write("%d %d %d %d %s %s\n" % (i.id1, i.id2, i.cellDist[0], i.cellDist[1], number(tangential(i)), number(i.phys.normalForce.norm())))


with open(output, "w") as out:
	out.write("stock YADE %s: periodic discs, Cundall-Strack\n" % yade.config.version)
	out.write(
		"dt %s damping %s thickness %s friction %s stiffnessRatio %s young %s density %s\n"
		% tuple(map(number, (dt, damping, thickness, friction, stiffnessRatio, young, density)))
	)
	out.write("velGrad %s\n" % matrix(gradient))
	out.write("radii %d\n" % len(O.bodies))
	for b in O.bodies:
		out.write(number(b.shape.radius) + "\n")
	# the integrator's memory of an earlier velocity gradient must be empty at the start
	O.engines = O.engines[:-1] + [NewtonIntegrator(damping=damping)]
	start = O.iter
	# YADE turns shear forces with the contact but never projects them back: the compaction has left parts along the normal
	for i in O.interactions:
		if i.isReal:
			n = i.geom.normal
			i.phys.shearForce = tangential(i) * Vector3(-n[1], n[0], 0)
	dump(out, "initial")
	O.cell.velGrad = gradient
	for n in checkpoints:
		while O.iter < start + n:
			O.step()
		dump(out, "checkpoint %d" % n)
print("written", output, os.path.getsize(output), "bytes; contacts", O.interactions.countReal())
