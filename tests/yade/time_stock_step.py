# SPDX-License-Identifier: GPL-2.0-or-later
# Time of one step of stock YADE on the sample of tests/unit/data/packed_reference.txt, for comparison with
# tests/performance/bench_packed_step.cpp:
#   yade -n -x -j1 tests/yade/time_stock_step.py [reference file]
import math, os, sys, time

here = os.path.dirname(os.path.abspath(sys.argv[0]))
lines = iter(open(sys.argv[1] if len(sys.argv) > 1 else os.path.join(here, "..", "unit", "data", "packed_reference.txt")).read().split("\n"))
next(lines)
header = next(lines).split()
p = dict(zip(header[0::2], map(float, header[1::2])))
next(lines)
radii = [float(next(lines)) for _ in range(int(next(lines).split()[1]))]
next(lines)
h = list(map(float, next(lines).split()[1:]))
for _ in range(3):
	next(lines)

O.periodic = True
O.cell.hSize = Matrix3(h[0], h[1], 0, h[2], h[3], 0, 0, 0, p["thickness"])
material = O.materials.append(FrictMat(young=p["young"], poisson=p["stiffnessRatio"], frictionAngle=math.atan(p["friction"]), density=p["density"]))
for r in radii:
	x, y = list(map(float, next(lines).split()))[:2]
	b = utils.sphere((x, y, p["thickness"] / 2), r, material=material)
	b.state.blockedDOFs = "zXY"
	b.state.mass = p["density"] * p["thickness"] * math.pi * r * r
	b.state.inertia = Vector3(1, 1, 0.5) * b.state.mass * r * r
	O.bodies.append(b)
O.engines = [
	ForceResetter(),
	InsertionSortCollider([Bo1_Sphere_Aabb()], allowBiggerThanPeriod=True),
	InteractionLoop([Ig2_Sphere_Sphere_ScGeom()], [Ip2_FrictMat_FrictMat_FrictPhys()], [Law2_ScGeom_FrictPhys_CundallStrack()]),
	NewtonIntegrator(damping=p["damping"]),
]
O.dt = p["dt"]
O.run(500, True)
O.cell.velGrad = Matrix3(0.01, 0, 0, 0, -0.01, 0, 0, 0, 0)
O.run(500, True)
best = float("inf")
for window in range(8):
	steps = 2000
	start = time.process_time()  # of all threads, so that neither waiting nor a busy machine counts
	O.run(steps, True)
	best = min(best, (time.process_time() - start) / steps)
print("stock YADE: %.2f us per step, %.1f ns per grain and step, %d contacts" % (best * 1e6, best * 1e9 / len(radii), O.interactions.countReal()))
