# SPDX-License-Identifier: GPL-2.0-or-later
"""Studies of samples as commands, each with a table, a picture and files in a folder.

	scripts/calibrate --grains 400            # MohrCoulombSkeleton from biaxial tests, see talik.studies.calibrate: table, picture, JSON
	scripts/calibrate --scatter               # friction angle, stiffness and frozen strength over realisations, table
	scripts/calibrate --rolling               # friction angle over porosity and rolling friction, table and picture
	scripts/calibrate --strength              # frozen strength over strain rate and temperature, table and picture
	scripts/calibrate --temperature           # frozen strength and stiffness along a freezing curve, see talik.studies.cold
	scripts/calibrate --growth                # what lets frozen strength grow with the rate, see talik.studies.growth
	scripts/calibrate --creep                 # rate of creep over stress, table and picture: see talik.studies.creep
	scripts/calibrate --moments               # frozen samples whose bonds carry moments beside others, see talik.studies.moments
	scripts/calibrate --refrozen              # frozen strength after thaw and refreezing, see talik.studies.refrozen
	scripts/calibrate --target soil.csv       # a sample that gives what tests of a soil gave, see talik.studies.target
	scripts/calibrate --elements tests.csv    # triaxial tests of sand predicted by samples fitted on some of them, see talik.studies.elementtests
	scripts/calibrate --settlement tests.csv,steps.csv  # thaw settlement predicted for tests left out of the fit, see talik.studies.thawtests
"""

import argparse
import json

import talik
from yade import O

from talik import plots, rve
from talik.studies import calibrate, cold, creep, elementtests, growth, moments, refrozen, target, thawtests
from talik.files import writableFolder, writeWhole


def main():
	parser = argparse.ArgumentParser(prog="scripts/calibrate", description="MohrCoulombSkeleton calibrated on a sample by biaxial tests.")
	parser.add_argument("--grains", type=_numbers, default=None, help="in the sample; with --scatter a list, e.g. 60,100,200,400")
	parser.add_argument(
		"--scatter", action="store_true", help="print mean and scatter of friction angle, stiffness and frozen strength over realisations instead"
	)
	parser.add_argument("--rolling", action="store_true", help="friction angle over porosity and coefficient of rolling friction instead: table, picture")
	parser.add_argument("--strength", action="store_true", help="frozen strength over strain rate and temperature instead: table, picture")
	parser.add_argument(
		"--temperature", action="store_true", help="frozen strength and stiffness over temperature along a freezing curve instead: table, picture"
	)
	parser.add_argument("--growth", action="store_true", help="growth of frozen strength with the rate by bonds and contacts instead: table, picture")
	parser.add_argument("--creep", action="store_true", help="rate of creep of frozen samples over stress instead: table, picture")
	parser.add_argument(
		"--moments",
		action="store_true",
		help="frozen samples whose bonds carry moments beside others instead: table, picture; with --target: bonds carry moments",
	)
	parser.add_argument("--refrozen", action="store_true", help="strength of samples that thawed and froze again beside others instead: table, picture")
	parser.add_argument(
		"--realisations",
		type=int,
		default=None,
		help="of each sample, with --scatter or --refrozen (8), --rolling, --temperature, --growth, --creep or --moments (3), --elements (3)",
	)
	parser.add_argument("--target", metavar="FILE", help="CSV file of tests of a soil: a sample that gives them instead; table, picture, sample file")
	parser.add_argument(
		"--settlement", metavar="TESTS,STEPS", help="CSV files of thaw settlement tests: prediction against test, cross-validated, instead; table, picture"
	)
	parser.add_argument(
		"--elements", metavar="FILE", help="CSV file of drained triaxial tests of sand: samples of spheres fitted on some, prediction of all; table, picture"
	)
	parser.add_argument("--fit", metavar="TESTS", help="with --elements: names of the tests to fit on, with commas between; default those with results")
	parser.add_argument(
		"--hertz", metavar="E,NU", help="with --elements: Young's modulus [Pa] and Poisson's ratio of grains of Hertz and Mindlin; default linear springs"
	)
	parser.add_argument("--strain", type=float, default=0.04, help="with --target: axial strain of each test, within which strength is the largest stress")
	parser.add_argument(
		"--friction",
		choices=("peak", "simple-shear"),
		default="peak",
		help="friction angle of the law: fitted to the peaks, or that of the thawed sample in simple shear, for slides of metres",
	)
	parser.add_argument("--output", default="output/calibrate", help="folder for the results")
	options = parser.parse_args()
	folder = writableFolder(options.output)
	lines = []

	def told(line):
		lines.append(line)
		print(line, flush=True)

	if options.settlement:
		print(plots.save(_settlement(options.settlement, told), folder / "settlement.png", dpi=110))
		writeWhole(folder / "settlement.md", "\n".join(lines) + "\n")
		return
	if options.elements:
		print(plots.save(_elements(options, told), folder / "elements.png", dpi=100))
		writeWhole(folder / "elements.md", "\n".join(lines) + "\n")
		return
	if options.target:
		_toTarget(options.target, (options.grains or (100,))[0], folder, told, options.moments, options.strain)
		writeWhole(folder / "target.md", "\n".join(lines) + "\n")
		return
	for name, study in _studies(options, told).items():
		if not getattr(options, name):
			continue
		figure = study()
		writeWhole(folder / f"{name}.md", "\n".join(lines) + "\n")
		if figure:
			print(plots.save(figure, folder / f"{name}.png"))
		return
	sample = rve.pack(rve.prepare(grains=(options.grains or (400,))[0], ice=True))
	result = calibrate.calibrate(sample, friction=calibrate.thawedFriction(sample) if options.friction == "simple-shear" else None)
	print(result.report())
	writeWhole(folder / "calibration.json", json.dumps(result.parameters(), indent="\t") + "\n")
	print(f"{plots.save(result.draw(), folder / 'calibration.png')}, {folder / 'calibration.json'}: MohrCoulombSkeleton(**json.load(...))")


def _studies(options, told):
	"""Option: what it runs. Each gives its lines to `told` and returns a figure, or None."""

	def grains(usual):
		return (options.grains or (usual,))[0]

	many = options.realisations
	return {
		"scatter": lambda: calibrate.scatter(options.grains or (60, 100, 200, 400), many or 8, told=told) and None,
		"strength": lambda: calibrate.drawStrength(*calibrate.strengthTable(rve.pack(rve.prepare(grains=grains(400), ice=True)), told=told)),
		"creep": lambda: creep.creepTable(creep.frozenSamples(grains(100), many or 3), told=told).draw(),
		"temperature": lambda: cold.table(grains=grains(100), realisations=many or 3, told=told).draw(),
		"growth": lambda: growth.draw(growth.table(grains(100), many or 3, told=told)),
		"refrozen": lambda: refrozen.compare(grains(100), many or 8, told=told).draw(),
		"moments": lambda: moments.compare(grains(100), many or 3, told=told).draw(),
		"rolling": lambda: calibrate.rollingFriction(grains(200), realisations=many or 3, told=told).draw(),
	}


def _toTarget(path, grains, folder, told, moments, strain):
	"""Fits a sample to a target and tests it once more; picture, sample file, parameters for further realisations."""
	try:
		rows = target.read(path)
	except ValueError as fault:
		raise SystemExit(f"calibrate: {fault}") from None
	found = target.fit(rows, grains, moments=moments, strain=strain)
	told(found.report())
	sample = found.sample()
	alone = target.Candidate(found.best.parameters, [target.test(sample, row, strain=strain).values for row in rows])
	off = ", ".join(f"{name} {factor:.2f}" for name, factor in alone.misfits(rows).items())
	told(f"\nThe sample of the file is off by a factor of: {off}")
	with talik.inspect(sample.open()):
		O.save(str(folder / "sample.yade.gz"))
	writeWhole(folder / "sample.json", json.dumps(found.parameters(), indent="\t") + "\n")
	picture = plots.save(target.draw(found, sample, strain=strain), folder / "target.png", dpi=100)
	print(f"{picture}, {folder / 'sample.yade.gz'}, {folder / 'sample.json'}: talik.rve.prepare(**json.load(...))")


def _elements(options, told):
	"""Tells what samples fitted on some triaxial tests of a CSV file predict for all; returns the figure."""
	names = options.fit.split(",") if options.fit else None
	try:
		tests = elementtests.read(options.elements)
		seeds = [1 + k for k in range(options.realisations or 3)]
		grains = dict(zip(("young", "poisson"), map(float, options.hertz.split(",")))) if options.hertz else {}
		found = elementtests.fit(tests, names, (options.grains or (300,))[0], seeds, told=lambda line: print(line, flush=True), **grains)
	except (ValueError, OSError) as fault:
		raise SystemExit(f"calibrate: {fault}") from None
	told(found.report())
	return found.draw()


def _settlement(paths, told):
	"""Tells how far thaw settlement is predicted for tests in two CSV files; returns the figure."""
	if paths.count(",") != 1:
		raise SystemExit(f"calibrate: --settlement {paths}: give two files, tests and load steps, with a comma between them")
	try:
		return thawtests.draw(thawtests.report(thawtests.read(*paths.split(",")), told=told))
	except (ValueError, OSError) as fault:
		raise SystemExit(f"calibrate: {fault}") from None


def _numbers(text):
	return tuple(int(part) for part in text.split(","))


if __name__ == "__main__":
	main()
