# SPDX-License-Identifier: GPL-2.0-or-later
"""How much cohesion does thawed ground need to stand in a steep face? A parameter study by yade-batch, in one figure.

	scripts/run parameter_study [--preset test|draft|standard]

Each row of the table is a run of parameterstudy/face.py with its own cohesion and friction angle. By hand, Culmann's plane wedge: a face of the
angle beta and the height H stands with c = gamma H (1 - cos(beta - phi))/(4 sin beta cos phi). Its plane is not the worst surface, and ground
with a dilation angle of 0 is a little weaker, so that the ground needs somewhat more. Change the lists of cohesions and angles first.
"""

import argparse
import math
import sys
from pathlib import Path

import talik
from talik import output, plots
from talik.files import writableFolder

parser = argparse.ArgumentParser(description=__doc__.splitlines()[0])
parser.add_argument("--preset", default="draft", choices=("test", "draft", "standard"), help="size of the job")
parser.add_argument("--output", default="output/parameter_study", help="folder for the results")
options = parser.parse_args()
folder = writableFolder(options.output)

h, angles, cohesions = {
	"test": (0.5, (25.0,), (2e3, 16e3)),
	"draft": (0.25, (20.0, 30.0), (2e3, 3e3, 4e3, 5e3, 6e3, 8e3, 10e3)),
	"standard": (0.125, (20.0, 25.0, 30.0), (2e3, 3e3, 4e3, 5e3, 6e3, 7e3, 8e3, 10e3, 12e3)),
}[options.preset]
height, beta, weight = 3.0, math.atan2(3.0, 0.8), 0.6 * 2650 * 9.81  # H [m], angle of the face, gamma [N/m3]
stands = 0.1  # largest displacement [m] of a face that stands

rows = [dict(cohesion=c, frictionAngle=phi, gridSpacing=h) for phi in angles for c in cohesions]
results = talik.batch.run(Path(sys.argv[0]).parent / "parameterstudy" / "face.py", rows, folder / "rows")

figure = plots.figure(7, 4.5)
axes = figure.subplots()
found = {}
for phi, colour in zip(angles, ("black", "steelblue", "darkorange")):
	pairs = [(row["cohesion"], result["displacement"]) for row, result in zip(rows, results) if row["frictionAngle"] == phi and result]
	p = math.radians(phi)
	byHand = weight * height * (1 - math.cos(beta - p)) / (4 * math.sin(beta) * math.cos(p))
	failed, stood = [c for c, moved in pairs if moved > stands], [c for c, moved in pairs if moved <= stands]
	found[phi] = max(failed, default=0.0), min(stood, default=math.inf), byHand
	axes.plot([c / 1e3 for c, _ in pairs], [moved for _, moved in pairs], "o-", color=colour, label=f"friction angle {phi:.0f}°")
	axes.axvline(byHand / 1e3, color=colour, linestyle="--", label=f"{phi:.0f}°, Culmann's wedge")
	print(f"friction angle {phi:.0f}: fails with {found[phi][0] / 1e3:.0f} kPa, stands with {found[phi][1] / 1e3:.0f} kPa, by hand {byHand / 1e3:.1f} kPa")
axes.axhline(stands, color="0.6", linewidth=0.6)
axes.set_yscale("log")
axes.set_xlabel("cohesion of thawed ground [kPa]")
axes.set_ylabel("largest displacement after 1.5 s [m]")
axes.legend()
plots.save(figure, folder / "parameter_study.png", dpi=100)
output.writeSummary(folder / "summary.json", rows=rows, results=results, **{f"fails, stands, by hand at {phi:.0f} degrees [Pa]": f for phi, f in found.items()})
if None in results:
	raise SystemExit("some rows left no result; what they said is in the files rows/*.log")
if any(stood < 0.8 * byHand or failed > 2 * byHand for failed, stood, byHand in found.values()):
	output.unexpected("a face stands with less than 80 % of the cohesion by hand, or fails with more than twice that")
print(f"picture, rows and summary are in {folder}")
