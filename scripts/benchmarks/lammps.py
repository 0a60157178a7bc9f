# SPDX-License-Identifier: GPL-2.0-or-later
"""A sample of discs or spheres in LAMMPS' granular pair style, for comparison: the same grains at rest in the same cell, with YADE's masses,
stiffness, friction and time step, on one processor."""

import math
import re
import shutil
import subprocess
import tempfile
from pathlib import Path

import numpy as np

commands = """units si
dimension {dimension}
atom_style sphere
boundary p p p
newton off
comm_modify vel yes
read_data sample.data
pair_style gran/hooke/history {kn} {kt} 0 0 {friction} 0
pair_coeff * *
neighbor {skin} bin
neigh_modify delay 0 every 1 check yes
fix motion all nve/sphere {inertia}
timestep {dt}
thermo {steps}
run 500
run {steps}
"""


def program():
	"""Path of LAMMPS' program, None where it is not installed."""
	return shutil.which("lmp") or shutil.which("lammps")


def upperTriangular(cell):
	"""A cell (3, 3) [m] of the same lengths and angles whose vectors, the columns, LAMMPS takes."""
	r = np.linalg.qr(cell, mode="r")
	return r * np.sign(np.diag(r))[:, None]


def writeData(path, position, radius, cell, density):
	"""Density [kg/m3] of spheres, an array; discs lie in the plane z = 0."""
	flat = len(cell) == 2
	if flat:
		position, cell = np.column_stack([position, np.zeros(len(radius))]), np.block([[cell, np.zeros((2, 1))], [0, 0, 2 * radius.max()]])
	reduced = np.linalg.solve(cell, position.T)
	h = upperTriangular(cell)
	inside = (h @ (reduced - np.floor(reduced))).T
	low = [0.0, 0.0, -0.5 * float(h[2, 2]) if flat else 0.0]
	bounds = "".join(f"{low[d]!r} {low[d] + float(h[d, d])!r} {axis}lo {axis}hi\n" for d, axis in enumerate("xyz"))
	rows = "".join(
		f"{k + 1} 1 {2 * r!r} {rho!r} {x!r} {y!r} {z!r}\n" for k, (r, rho, (x, y, z)) in enumerate(zip(radius.tolist(), density.tolist(), inside.tolist()))
	)
	tilt = " ".join(repr(float(h[i, j])) for i, j in ((0, 1), (0, 2), (1, 2)))
	path.write_text(f"spheres\n\n{len(radius)} atoms\n1 atom types\n\n{bounds}{tilt} xy xz yz\n\nAtoms # sphere\n\n{rows}")


def nanosecondsPerGrainStep(sample, parameters, steps=4000):
	"""CPU time of LAMMPS per grain and step [ns]."""
	arrays = sample.arrays()
	kn = parameters["young"] * 0.5 * (parameters["radiusMin"] + parameters["radiusMax"])
	flat, radius = sample.dimension == 2, arrays["radius"]
	# LAMMPS gives a disc the mass of a sphere
	density = parameters["density"] * (0.75 * parameters["thickness"] / radius if flat else np.ones(len(radius)))
	values = dict(dimension=sample.dimension, inertia="disc\nfix plane all enforce2d" if flat else "")
	values.update(kn=kn, kt=parameters["stiffnessRatio"] * kn, friction=parameters["friction"], dt=sample.dt, steps=steps)
	with tempfile.TemporaryDirectory() as folder:
		writeData(Path(folder) / "sample.data", arrays["position"], radius, arrays["hSize"], density)
		(Path(folder) / "in.sample").write_text(commands.format(skin=0.04 * float(np.mean(radius)), **values))
		run = subprocess.run([program(), "-in", "in.sample", "-log", "none"], cwd=folder, capture_output=True, text=True, timeout=300)
	loops = re.findall(r"Loop time of (\S+) on 1 procs", run.stdout)
	used = re.findall(r"(\S+)% CPU use", run.stdout)
	if len(loops) != 2 or len(used) != 2:
		raise RuntimeError(f"LAMMPS did not run the sample: {run.stdout[-500:]}{run.stderr[-500:]}")
	time = float(loops[1]) * min(1.0, float(used[1]) / 100)
	if not math.isfinite(time):
		raise RuntimeError("LAMMPS gave no time")
	return time / (len(radius) * steps) * 1e9
