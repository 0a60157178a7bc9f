# SPDX-License-Identifier: GPL-2.0-or-later
"""Command line of the two thaw slumps: its options, the runs that they ask for, and what these came to in a few lines."""

import argparse
import math
from contextlib import nullcontext
from dataclasses import replace
from pathlib import Path

import talik
from talik import output, plots
from thawslump import page
from thawslump.page import framesName
from thawslump.settings import Ground, calendars, flowingPicTimeFactor, fullThawStrain, oneGrainThick, porePressures, presets, skeletons, softened
from thawslump.slump import ThawSlump, bandStrain

shownEvents = 12


def arguments(description, defaultFolder, thawStrain=0.0):
	"""Command line of an example."""
	parser = argparse.ArgumentParser(description=description)
	parser.add_argument("--preset", default="draft", choices=sorted(presets), help="size of the job")
	parser.add_argument("--output", default=defaultFolder, help="folder for the results")
	parser.add_argument("--resume", action="store_true", help="go on with the run that was stopped, from its checkpoint in the folder of the results")
	parser.add_argument("--days", type=_days, help="of the thaw, in place of the case's; with --resume the run goes on until then")
	parser.add_argument("--redraw", action="store_true", help="draw the pictures anew from the files in the folder of the results, without a run")
	parser.add_argument("--film", action="store_true", help="also a film, film.gif, of the frames that the motion took; with --redraw of those in the folder")
	parser.add_argument("--no-thaw", action="store_true", help="the same slope kept frozen, for comparison")
	parser.add_argument(
		"--thaw-strain", default=thawStrain, type=_thawStrain, help="area strain that thawing grains of the samples release: 0, a fraction, or full (eq. 8)"
	)
	parser.add_argument("--skeleton", default="samples", choices=skeletons, help="a sample behind every point, or a law calibrated on the same sample")
	parser.add_argument("--grains", type=_count, help="in each sample, in place of the preset's")
	parser.add_argument("--realisations", type=_count, default=1, help="number of samples that differ by chance, assigned to the points")
	parser.add_argument("--seed", type=int, default=1, help="of the samples and of that chance")
	parser.add_argument("--grid-offset", type=_offset, default=0.0, help="shift of the nodes against the slope [cells], 0 to below 1; all are equally good")
	parser.add_argument(
		"--calendar",
		choices=calendars,
		help="ten days pass in a second of motion while the ground rests and real time while it moves, or always ten days (constant, as in the paper); default: "
		"follows-motion with the law alone, constant with samples, which take four times as long otherwise",
	)
	parser.add_argument(
		"--thawed-cohesion", type=_cohesion, help="cohesion that stays when the ice has gone [Pa]; default: 2000 with the law alone, 0 with samples"
	)
	parser.add_argument(
		"--thickness",
		type=_thickness,
		default=Ground.thickness,
		help="of the slice of ground that carries the forces of the discs [m]; stiffness and strength of the samples go with its inverse",
	)
	parser.add_argument(
		"--pore-pressure",
		choices=porePressures,
		default=Ground.porePressure,
		help="implicit: water of 2.2e9 Pa, its pressure solved for all cells at once; explicit: water a hundred times as soft, which limits the step",
	)
	parser.add_argument("--compare", choices=("skeleton", "thaw-strain", "both", "thickness"), help="also run the alternatives, side by side in one figure")
	return parser.parse_args()


def _days(text):
	if not 0 < float(text) < math.inf:
		raise argparse.ArgumentTypeError(f"{text} is no length of time: give days, above 0")
	return float(text)


def _count(text):
	if not text.isdigit() or int(text) < 1:
		raise argparse.ArgumentTypeError(f"{text} is no number of things: give a whole number, 1 or more")
	return int(text)


def _offset(text):
	if not 0 <= float(text) < 1:
		raise argparse.ArgumentTypeError(f"{text} is no part of a cell: give 0 to below 1")
	return float(text)


def _cohesion(text):
	if not 0 <= float(text) < math.inf:
		raise argparse.ArgumentTypeError(f"{text} is no cohesion: give Pa, 0 or more")
	return float(text)


def _thickness(text):
	if not 0 < float(text) <= 1:
		raise argparse.ArgumentTypeError(f"{text} is no thickness: give m, above 0 and up to 1")
	return float(text)


def _thawStrain(text):
	return text if text == fullThawStrain else float(text)


def runCase(case, options, ofCase=None):
	"""Runs a case as its command line says, and prints what it came to. Returns the (last) ThawSlump, a single one stays in O; None when drawn anew.

	ofCase  {name of a value of the preset: what the case has in its place}, or None"""
	if options.resume:
		slump = ThawSlump.resumed(options.output)
		if options.days is not None:
			slump.endAt(options.days)
		report(slump.run(), slump.folder)
		if options.film and talik.ranks.first:
			print(page.film(slump.folder))
		return slump
	settings = comparison(options)
	folders = {label: Path(options.output) / ("" if len(settings) == 1 else label.replace(" ", "-")) for label in settings}
	slump = None
	for label, setting in settings.items():
		if options.redraw:
			page.draw(folders[label], page.outlineOf(folders[label], case.outline), bandStrain)
		else:
			with nullcontext() if len(settings) == 1 else talik.scratchScene():
				slump = ThawSlump(
					case, presetOf(options, ofCase), folders[label], groundOf(options, setting), not options.no_thaw, skeleton=setting["skeleton"]
				)
				slump.presetName = options.preset
				slump.run()
		if options.film and talik.ranks.first:
			print(page.film(folders[label]))
		if talik.ranks.first:  # the files are its own
			report(page.summaryOf(folders[label]), folders[label])
	if len(folders) > 1 and talik.ranks.first:
		runs = {label: (output.loadFrames(folder / framesName), bill(page.summaryOf(folder))) for label, folder in folders.items()}
		figure = page.sideBySide(runs, case.outline)
		print(plots.save(figure, Path(options.output) / f"{options.compare}.png", dpi=80))
	return slump


def lawAlone(options):
	return options.skeleton == "MohrCoulomb" and options.compare is None


def groundOf(options, setting):
	"""Ground of a run. What slides converges with the calendar, a cohesion and little viscosity; samples are too slow for that as a
	default, and runs that are compared share one ground."""
	alone, thickness = lawAlone(options), setting.get("thickness", options.thickness)
	calendar = options.calendar or ("follows-motion" if alone else "constant")
	flowing = alone or calendar == "follows-motion"
	cohesion = options.thawed_cohesion if options.thawed_cohesion is not None else 2e3 if alone else 0.0
	return Ground(
		thawStrain=setting["thawStrain"],
		thickness=thickness,
		thawedCohesion=cohesion,
		followsMotion=calendar == "follows-motion",
		picTimeFactor=flowingPicTimeFactor if flowing else Ground.picTimeFactor,
		porePressure=options.pore_pressure,
		**(_softer(options.pore_pressure, thickness) if alone else {}),
	)


def _softer(porePressure, thickness):
	"""Moduli of a law alone; stiffness goes with 1/thickness."""
	moduli = {name: modulus * (Ground.thickness / thickness) for name, modulus in softened.items()}
	return moduli if porePressure == "explicit" else {name: modulus for name, modulus in moduli.items() if name != "bulkModulus"}


def presetOf(options, ofCase):
	preset = replace(presets[options.preset], **(ofCase or {}))
	return replace(
		preset,
		gridSpacing=preset.lawGridSpacing if lawAlone(options) and preset.lawGridSpacing else preset.gridSpacing,
		days=options.days or preset.days,
		grains=options.grains or preset.grains,
		realisations=options.realisations,
		seed=options.seed,
		gridOffset=options.grid_offset,
	)


def comparison(options):
	"""{label: thawStrain and skeleton} of the runs that a command line asks for. A law has no thaw strain: it belongs to the grains."""
	law = {"MohrCoulomb": dict(thawStrain=0.0, skeleton="MohrCoulomb")}
	strains = (0.0, options.thaw_strain if options.thaw_strain not in (0.0, fullThawStrain) else 0.03, fullThawStrain)
	sideBySide = {f"thaw strain {value}": dict(thawStrain=value, skeleton="samples") for value in strains}
	given = {"samples": dict(thawStrain=options.thaw_strain, skeleton="samples")}
	thick = {f"thickness {value:g} m": dict(given["samples"], thickness=value) for value in (Ground.thickness, oneGrainThick)}
	return {
		None: law if options.skeleton == "MohrCoulomb" else given,
		"thaw-strain": sideBySide,
		"skeleton": {**given, **law},
		"both": {**sideBySide, **law},
		"thickness": thick,
	}[options.compare]


def bill(summary):
	"""What a run cost, by processor time, which other work on the machine does not lengthen."""
	seconds = f"{summary['processor time [s]']:.0f} s of processor"
	if summary["skeleton"] == "samples":
		return f"{seconds}, {summary['sample calls']} sample calls, {summary['sample memory [MB]']:.0f} MB of samples"
	return f"{seconds}, {summary['calibration [s]']:.1f} s of them calibration, no samples"


def eventLines(events):
	"""What moved, in words: one line for each event, the largest first when there are many."""
	shown = sorted(events, key=lambda event: -event["volume"])[:shownEvents]
	for event in sorted(shown, key=lambda event: event["day"]):
		onward = ", and go on" if event["goesOn"] else ""
		moved = f"{event['volume']:.2f} m2 per metre move for {event['duration']:.2f} s, by up to {event['largest']:.2f} m"
		yield f"day {event['day']:.1f}: {moved}{onward}"
	if len(events) > shownEvents:
		yield f"and {len(events) - shownEvents} smaller ones"


def report(summary, folder):
	"""Prints what a run came to, in a few lines."""
	print(f"{summary['points']} points, {summary['steps']} steps, {summary['sample calls']} sample calls in {summary['wallTime [s]']:.0f} s")
	if summary.get("thawed.strength of bonds [Pa]"):
		print(
			f"thawed cohesion {summary['thawed.cohesion measured [Pa]'] / 1e3:.2f} kPa, measured on the samples, by bonds of "
			f"{summary['thawed.strength of bonds [Pa]'] / 1e3:.0f} kPa that outlast their ice"
			+ (f"; they carry {summary['thawed.tension measured [Pa]'] / 1e3:.2f} kPa of tension" if "thawed.tension measured [Pa]" in summary else "")
		)
	print(f"{summary['day']:.1f} days in {summary['thaw time [s]']:.1f} s of motion; largest displacement {summary['largest displacement [m]']:.3f} m", end="")
	if "bondsIntact" in summary:
		print(f"; bonds intact {summary['bondsIntact']}, broken {summary['bondsBroken']}, melted {summary['bondsMelted']}", end="")
	print()
	for line in eventLines(summary["events"]):
		print(line)
	for ground in ("frozen", "all"):
		print(summary.get(f"band in {ground} ground", ""))
	for letter in ("A", "B"):
		if f"point {letter}" in summary:
			print(f"point {letter}: " + ", ".join(f"{name} {value}" for name, value in summary[f"point {letter}"].items()))
	print(f"pictures, ParaView files and summary.json are in {folder}")
