#!/usr/bin/python3
# SPDX-License-Identifier: GPL-2.0-or-later
"""mpmxdem (mpm/2D) on the dry column of scripts/talik/studies/accuracy/collapse.py: difference to Talik's finest run, and processor time.

usage  collapse.py <mpmbox> <results.json of scripts/accuracy> <rows.json>

The same law (Mohr-Coulomb in plane strain, no dilatancy), elasticity, strength and time; B-splines, four points in a cell. Its walls are nodes
that are held, two cells deep. With its two other schemes the time step falls without end."""

import json
import os
import re
import subprocess
import sys
import tempfile
from pathlib import Path

import numpy as np

density, end = 1590.0, 1.2
scene = """planeStrain
oneStepType {step}
result_folder .
tolmass 1e-9
gravity 0.0 -9.81
finalTime {end}
confPeriod 20
proxPeriod 10
dt {dt}
t 0.0
ShapeFunction BSpline
splitting 0
enablePIC {pic}
model MohrCoulomb MC 2e6 0.25 0.5235987755982988 50 0
set_node_grid Nx.Ny.lx.ly {columns} {rows} {h} {h}
set_MP_grid 0 MC {density} {wall} {wall} {top} {top} {half}
{walls}
"""


def collapse(program, cells, step="ModifiedLagrangian"):
	h = 1.0 / cells
	dt = 0.4 * h / (2.4e6 / density) ** 0.5
	columns, rows, wall = 4 * cells + 2, cells + 6, 2 * h
	walls = [f"set_BC_column {k} 0 {rows} 1 0" for k in range(3)] + [f"set_BC_line {k} 0 {columns} 1 1" for k in range(3)]
	values = dict(step=step, end=end, dt=dt, pic=dt / (h / 9.81) ** 0.5, columns=columns, rows=rows, h=h, wall=wall, top=wall + 1)
	with tempfile.TemporaryDirectory() as folder:
		Path(folder, "input.txt").write_text(scene.format(density=density, half=h / 2, walls="\n".join(walls), **values))
		before = os.times()
		done = subprocess.run([program, "input.txt", "-j", "1"], cwd=folder, capture_output=True, text=True, check=False)
		after = os.times()
		saved = sorted(Path(folder).glob("conf*.txt"), key=lambda file: int(re.search(r"\d+", file.name).group()))
		if done.returncode or len(saved) < 2:
			sys.exit(f"mpmbox failed with {cells} cells: {done.stdout[-800:]}{done.stderr[-800:]}")
		lines = saved[-1].read_text().splitlines()
	steps = int(re.search(r"convergenceConditions\W+(\d+)", done.stdout).group(1))  # it makes steps shorter by itself
	start = next(k for k, text in enumerate(lines) if text.startswith("MPs "))
	number = int(lines[start].split()[1])
	fields = np.array([text.split()[1:8] for text in lines[start + 1 : start + 1 + number]], float)
	weight, (x, y) = fields[:, 3] / fields[:, 3].sum(), fields[:, 5:7].T - wall
	seconds = after.children_user + after.children_system - before.children_user - before.children_system
	return (quantile(x, weight), quantile(y, weight), weight @ x, weight @ y), seconds, seconds / (number * steps) * 1e9


def quantile(values, weight, part=0.98):
	order = np.argsort(values)
	return np.interp(part, np.cumsum(weight[order]), values[order])


def main(program, results, file):
	study = json.loads(Path(results).read_text(encoding="utf-8"))
	finest = [row for row in study.values() if row["problem"] == "column collapse"]
	reference = np.array(max(finest, key=lambda row: row["settings"]["cells"] * (1 + (row["settings"]["transfer"] == "tpic")))["answer"])
	rows = []
	for cells in (10, 20):
		answer, seconds, each = collapse(program, cells)
		error = float(np.max(np.abs(np.array(answer) / reference - 1)))
		said = f"{cells} cells, {each:.0f} ns a point and step, front {answer[0]:.3f} m for {reference[0]:.3f} m"
		rows.append({"problem": "column collapse", "code": "mpmxdem", "settings": said, "error": error, "seconds": seconds})
		print(rows[-1], flush=True)
	Path(file).write_text(json.dumps(rows, indent="\t"), encoding="utf-8")


if __name__ == "__main__":
	main(*sys.argv[1:])
