# SPDX-License-Identifier: GPL-2.0-or-later
# Writes tests/unit/data/packed_spheres_reference.txt: a periodic sample of spheres compacted by stock YADE and what stock YADE's own
# engines make of it after 1, 100 and 500 steps of a general velocity gradient.
#
#   yade -n -x -j1 tests/yade/make_packed_spheres_reference.py [spheres [output file]]
import math, os, sys
from yade import pack

spheres = int(sys.argv[1]) if len(sys.argv) > 1 else 60
here = os.path.dirname(os.path.abspath(sys.argv[0]))
output = sys.argv[2] if len(sys.argv) > 2 else os.path.join(here, "..", "unit", "data", "packed_spheres_reference.txt")

density, young, stiffnessRatio, friction, damping, pressure = 2650.0, 6e8, 0.8, 0.5, 0.2, 1e5
gradient = Matrix3(0.02, 0.035, -0.01, -0.015, -0.03, 0.02, 0.01, 0.015, -0.02)
checkpoints = (1, 100, 500)

O.periodic = True
side = (spheres * 4 / 3 * math.pi * 5.2e-3**3 / 0.35) ** (1 / 3)
O.cell.hSize = Matrix3(side, 0, 0, 0, side, 0, 0, 0, side)
material = O.materials.append(FrictMat(young=young, poisson=stiffnessRatio, frictionAngle=math.atan(0.2), density=density))
cloud = pack.SpherePack()
cloud.makeCloud((0, 0, 0), (side, side, side), rMean=5e-3, rRelFuzz=0.3, num=spheres, periodic=True, seed=1)
cloud.toSimulation(material=material)
compaction = PeriTriaxController(
	goal=(-pressure, -pressure, -pressure),
	stressMask=7,
	dynCell=True,
	maxUnbalanced=1e-4,
	maxStrainRate=(1, 1, 1),
	mass=0.2,
	globUpdate=1,
	relStressTol=1e-3,
	doneHook="O.pause()",
)
O.engines = [
	ForceResetter(),
	InsertionSortCollider([Bo1_Sphere_Aabb()], allowBiggerThanPeriod=True),
	InteractionLoop([Ig2_Sphere_Sphere_ScGeom()], [Ip2_FrictMat_FrictMat_FrictPhys()], [Law2_ScGeom_FrictPhys_CundallStrack()]),
	compaction,
	NewtonIntegrator(damping=damping),
]
O.dt = dt = 0.3 * PWaveTimeStep()
O.run(200000, True)
O.cell.velGrad = Matrix3.Zero
O.engines = O.engines[:3] + [NewtonIntegrator(damping=damping)]
O.materials[material].frictionAngle = math.atan(friction)
for i in O.interactions:
	i.phys.tangensOfFrictionAngle = friction
O.run(3000, True)
print("compacted: steps", O.iter, "unbalanced", utils.unbalancedForce(), "stress", getStress())


def numbers(*values):
	return " ".join(repr(float(x)) for x in values)


def matrix(m):
	return numbers(*(m[a, b] for a in range(3) for b in range(3)))


def dump(out, title):
	contacts = sorted((i for i in O.interactions if i.isReal), key=lambda i: (i.id1, i.id2))
	out.write(
		"%s step %d\nhSize %s\ntrsf %s\nstress %s\ngrains %d\n" % (title, O.iter, matrix(O.cell.hSize), matrix(O.cell.trsf), matrix(getStress()), len(O.bodies))
	)
	for b in O.bodies:
		out.write(numbers(*b.state.pos, *b.state.vel, *b.state.angVel) + "\n")
	out.write("contacts %d\n" % len(contacts))
	for i in contacts:
		out.write("%d %d %d %d %d " % (i.id1, i.id2, i.cellDist[0], i.cellDist[1], i.cellDist[2]) + numbers(*i.geom.normal, *i.phys.shearForce) + "\n")


with open(output, "w") as out:
	out.write("stock YADE %s: periodic spheres, Cundall-Strack\n" % yade.config.version)
	out.write(
		"dt %s damping %s friction %s stiffnessRatio %s young %s density %s\n" % tuple(repr(x) for x in (dt, damping, friction, stiffnessRatio, young, density))
	)
	out.write("velGrad %s\n" % matrix(gradient))
	out.write("radii %d\n" % len(O.bodies))
	for b in O.bodies:
		out.write(numbers(b.shape.radius) + "\n")
	# the integrator's memory of an earlier velocity gradient must be empty at the start
	O.engines = O.engines[:3] + [NewtonIntegrator(damping=damping)]
	start = O.iter
	dump(out, "initial")
	O.cell.velGrad = gradient
	for n in checkpoints:
		while O.iter < start + n:
			O.step()
		dump(out, "checkpoint %d" % n)
print("written", output, os.path.getsize(output), "bytes; contacts", O.interactions.countReal())
