# SPDX-License-Identifier: GPL-2.0-or-later
"""Convergence of the thaw slumps (Cases I and II of Yu & Zhao): what moves on which day, knob by knob. `scripts/accuracy slump` runs it.

	sweeps      one knob at a time, from coarse to fine, all else as the sweep says
	runRows     runs what is planned and not there yet, row by row into a file
	measures    what a row came to: largest displacement, volume moved, day of the first event

The calibrated law is cheap and carries the knobs of grid and time. Samples carry the knobs that only they have."""

import functools
import hashlib
import tempfile
from dataclasses import dataclass, field
from fractions import Fraction
from pathlib import Path

import numpy as np
from tqdm import tqdm
from yade import O

import talik
import thaw_slump_base
import thaw_slump_surface
import thawslump
from talik.studies.accuracy import slump
from talik.studies.accuracy.problem import Stopwatch, key

moved = 0.1  # displacement of ground that counts as moved [m]
historyLength = 30  # states of a run that are kept for the picture, beside those of the table
motionAllowed = 10  # times the motion of a run at constant scale; a calendar that still has not come to its end stops there


@dataclass(frozen=True)
class Case:
	title: str
	scene: object  # thawslump.Case
	days: int  # of the thaw
	tableDays: tuple
	thawStrain: float  # of the samples


cases = {
	"surface": Case("Case I, thaw from the surface", thaw_slump_surface.case, 150, (30, 60, 100, 150), 0.0),
	"base": Case("Case II, thaw from the base", thaw_slump_base.case, 600, (150, 300, 450, 600), 0.03),
}


constantScale, followsMotion = "is constant", "follows motion"  # values of the knob calendar
implicitWater = {"pore pressure": "implicit", "bulk modulus of water": 2.2e9}
draft = {**slump.standard, **slump.scene, **implicitWater, "follows motion": True}  # what the rows differ from
flowing = {"pic-time": thawslump.flowingPicTimeFactor}  # of sweeps of a slide


def fraction(value):
	return f"{Fraction(value)}"


def softened(factor=1):
	"""Settings with so many times the stiffness of frozen ground that the slumps have with the law alone."""
	return {"frozen modulus": factor * thawslump.softened["frozenModulus"]}


def water(porePressure):
	"""Settings of real water, or of water soft enough for explicit pressure."""
	return implicitWater if porePressure == "implicit" else {"pore pressure": "explicit", "bulk modulus of water": slump.standard["bulk modulus of water"]}


def followed(preset):
	"""Settings that follow samples as a preset of the slumps does: how often they are asked, and how fast they move."""
	chosen = thawslump.presets[preset]
	return {"sample tolerance": chosen.strainTolerance, "stress tolerance": chosen.stressTolerance, "inertial number": chosen.maxInertialNumber}


@dataclass(frozen=True)
class Knob:
	label: str  # with its unit
	settings: object  # function of a value -> settings of talik.studies.accuracy.slump
	text: object = "{:g}".format  # of a value
	phrase: str = "{}"  # of a value that a sweep of another knob keeps


knobs = {
	"grid-spacing": Knob("h [m]", lambda value: {"grid spacing": value}, "{:.3g}".format, phrase="h = {} m"),
	"f_max": Knob("f_max over 8.64e5", lambda value: {"thermal time scale": value * slump.standard["thermal time scale"]}, fraction, "f_max = {} × 8.64e5"),
	"time-step": Knob("time step over draft's", lambda value: {"time-step fraction": value * slump.standard["time-step fraction"]}, fraction),
	"calendar": Knob("scale of time", lambda value: {"follows motion": value == followsMotion}, str, "a scale that {}"),
	"motion-tolerance": Knob("motion tolerance [m/s]", lambda value: {"motion tolerance": value}),
	"pic-time": Knob("PIC time over sqrt(h/g)", lambda value: {"PIC time over sqrt(h/g)": value}, phrase="picTime = {} √(h/g)"),
	"pore-pressure": Knob("pore pressure", water, str),
	"stiffness": Knob("stiffness of frozen ground over draft's", softened),
	"inertial-number": Knob("inertial number", lambda value: {"inertial number": value}),
	"grains": Knob("grains", lambda value: {"grains": value}),
	"realisations": Knob("realisations", lambda value: {"realisations": value}, phrase="{} realisations"),
	"sampling": Knob("samples followed as in", followed, str, "samples followed as in {}"),
	"sample-tolerance": Knob("sample tolerance", lambda value: {"sample tolerance": value}),
}


@dataclass(frozen=True)
class Sweep:
	"""Values of one knob from coarse to fine; the last one stands for the truth."""

	knob: str
	values: tuple
	ground: dict  # skeleton and thawed cohesion
	fixed: dict = field(default_factory=dict)  # {knob: value} that differ from draft
	quick: int = 0  # how many of the values a quick study has

	def settings(self, value):
		"""Settings of talik.studies.accuracy.slump that differ from its standard."""
		chosen = {**self.fixed, self.knob: value}
		return dict(self.ground, **{name: given for knob, one in chosen.items() for name, given in knobs[knob].settings(one).items()})


def sweeps():
	"""All sweeps of one case, in the order of the table."""
	return [sweep for cohesion in (2000.0, 0.0) for sweep in (*_lawSweeps(cohesion), *_sampleSweeps(cohesion))]


def _lawSweeps(cohesion):
	law = {"skeleton": "MohrCoulomb", "thawed cohesion": cohesion, **softened()}
	draft = {"grid-spacing": thawslump.presets["draft"].lawGridSpacing, **flowing}
	return (
		Sweep("grid-spacing", (0.5, 0.25, 1 / 6, 0.125, 0.0625), law, flowing, quick=2),
		Sweep("f_max", (1, 1 / 4, 1 / 16), law, draft),
		Sweep("f_max", (1, 1 / 4), law, flowing, quick=2),
		Sweep("pore-pressure", ("explicit", "implicit"), law, {"grid-spacing": 0.25, **flowing}),
		Sweep("time-step", (1, 1 / 2), law, draft),
		Sweep("stiffness", (1, 4), law, draft),
		Sweep("motion-tolerance", (0.05, 0.0125), law, draft),
		Sweep("pic-time", (1.0, 4.0, 16.0), law, {"grid-spacing": draft["grid-spacing"]}),
		Sweep("calendar", (constantScale, followsMotion), law, draft),
	)


def _sampleSweeps(cohesion):
	samples = {"skeleton": "samples", "thawed cohesion": cohesion}
	several = {"realisations": 8}
	return (
		Sweep("grid-spacing", (0.5, 0.25), samples),
		Sweep("grid-spacing", (0.5, 0.25), samples, flowing),
		Sweep("grid-spacing", (0.5, 1 / 3, 0.25, 1 / 6, 0.125), samples, {"sampling": "draft", "calendar": constantScale}),
		Sweep("grid-spacing", (0.5, 1 / 3, 0.25, 1 / 6, 0.125), samples, {"sampling": "draft", "calendar": constantScale, **flowing}),
		Sweep("grid-spacing", (0.5, 1 / 3, 0.25, 1 / 6, 0.125), samples, {"sampling": "draft", **flowing}),
		Sweep("pore-pressure", ("explicit", "implicit"), samples, {"sampling": "draft", "calendar": constantScale, "grid-spacing": 0.25}),
		Sweep("pic-time", (1.0, 4.0), samples),
		Sweep("inertial-number", (5e-3, 1e-3), samples, quick=2 if cohesion else 0),
		Sweep("sample-tolerance", (2e-5, 5e-6, 1.25e-6), samples),
		Sweep("realisations", (1, 8), samples),
		Sweep("grains", (100, 200, 400), samples, several),
	)


# ---- rows -----------------------------------------------------------------------------------------------------------------


def rowSettings(case, sweep, value):
	"""Everything that a row depends on, by name; numbers and words only, so that it names the row in a file."""
	plain = {name: given for name, given in draft.items() if name not in ("scene", "thaw strain")}
	return {**plain, **sweep.settings(value), "case": case, "days of heat": cases[case].days}


def rowKey(case, sweep, value):
	return key("slump", rowSettings(case, sweep, value))


def plan(caseNames=tuple(cases), knobNames=(), quick=False):
	"""Settings of the rows by key, each once, the cheapest first."""
	rows = {}
	for case in caseNames:
		for sweep in sweeps():
			if knobNames and sweep.knob not in knobNames:
				continue
			for value in sweep.values[: sweep.quick] if quick else sweep.values:
				rows[rowKey(case, sweep, value)] = rowSettings(case, sweep, value)
	return dict(sorted(rows.items(), key=lambda row: cost(row[1])))


def cost(settings):
	"""What a row takes, in units of the cheapest, roughly: points times steps, and grains."""
	refined = 0.5 / settings["grid spacing"]
	steps = refined * 8.64e5 / settings["thermal time scale"] * 0.4 / settings["time-step fraction"] * settings["days of heat"] / 150
	grains = 0.1 * settings["grains"] * 5e-3 / settings["inertial number"] if settings["skeleton"] == "samples" else 1
	return refined**2 * steps * grains * (10 if settings["follows motion"] else 1)


def runRows(rows, results, progress=True):
	"""Runs the rows that `results` lacks; each is on the disk before the next one begins."""
	missing = {name: settings for name, settings in rows.items() if name not in results}
	bar = tqdm(missing.items(), disable=not progress, unit="row")
	for name, settings in bar:
		bar.set_postfix_str(describe(settings))
		results.add(name, measured(settings))


def describe(settings):
	"""Case and what differs from draft, in words."""
	differing = [f"{name} {value}" for name, value in settings.items() if name in draft and name != "days of heat" and value != draft[name]]
	return ", ".join([settings["case"], *differing])


def measured(settings):
	"""A row; what failed says why."""
	try:
		with talik.scratchScene():
			return {"settings": settings, **march(settings)}
	except (RuntimeError, ValueError) as failure:
		return {"settings": settings, "failure": str(failure)}


def march(settings):
	"""Thaws a slump and looks at it every day."""
	case, watch, looks, days = cases[settings["case"]], Stopwatch(), [(0, 0.0, 0.0)], settings["days of heat"]
	allowed = motionAllowed * days * talik.day / settings["thermal time scale"]
	with tempfile.TemporaryDirectory() as folder:
		slope = slump.slump({**settings, "scene": case.scene, "thaw strain": case.thawStrain}, folder)
	mpm = slope.mpm
	with watch:
		slope.rest()
		for day in range(1, days + 1):
			talik.runUntilDay(mpm, day, longest=slope.preset.restTime + allowed)
			if mpm.calendar["day"] < day:
				break
			looks.append((day, *motion(mpm)))
	every = max(1, days // historyLength)
	return {
		"history": [[_rounded(value) for value in look] for look in looks if look[0] % every == 0 or look[0] in (*case.tableDays, days)],
		"firstEvent": _rounded(firstEvent(mpm, looks, settings["follows motion"])),
		"cpu": watch.cpu,
		"wall": watch.wall,
		"points": mpm.pointCount,
		"steps": O.iter,
		"friction": _rounded(slope.thawed.get("friction measured [-]")),
		"build": build(),
		**({"shortfall": f"day {looks[-1][0]} of {days} after {allowed:.3g} s of motion"} if looks[-1][0] < days else {}),
	}


@functools.cache
def build():
	"""Names the build of Talik that measured a row."""
	return hashlib.sha256(Path(talik._talik.__file__).read_bytes()).hexdigest()[:12]


def motion(mpm):
	"""Largest displacement [m] and volume of the points displaced by more than `moved` [m3 per m]."""
	size = np.linalg.norm(mpm.field("displacement"), axis=1)
	return float(size.max()), float(mpm.field("volume")[size > moved].sum())


def firstEvent(mpm, looks, followsMotion):
	"""Day on which the ground first moves; None if it does not. Where the scale is constant: when the largest displacement passes `moved`."""
	if followsMotion:
		return min((event["day"] for event in mpm.events() if event["largest"] > moved), default=None)
	for (before, least, _), (day, largest, _) in zip(looks, looks[1:]):
		if largest > moved:
			return before + (day - before) * (moved - least) / (largest - least)
	return None


def _rounded(value):
	return None if value is None else float(f"{value:.5g}")


# ---- what a row came to ---------------------------------------------------------------------------------------------------


def measures(case, row):
	"""{(what, day): value} of a row, None where its calendar did not come so far or nothing moved."""
	at = {day: (largest, volume) for day, largest, volume in row["history"]}
	found = {("displacement", day): at.get(day, (None, None))[0] for day in cases[case].tableDays}
	found.update({("volume", day): at.get(day, (None, None))[1] for day in cases[case].tableDays})
	return {**found, ("first event", None): row["firstEvent"]}


def difference(value, finest):
	"""Relative to the finest [-]; None where there is nothing to compare with."""
	return None if value is None or not finest else value / finest - 1


def reached(row):
	"""Last day of a row."""
	return row["history"][-1][0]


def twoFinest(case, rows):
	"""Largest relative difference between the two finest rows of a sweep, over the days that both came to: {displacement, volume, first event};
	None unknown."""
	last = min(reached(row) for row in rows[-2:])
	coarse, fine = (measures(case, row) for row in rows[-2:])
	worst = {}
	for (what, day), value in fine.items():
		differences = worst.setdefault(what, [])
		if day is not None and day > last:
			continue
		apart = 0.0 if coarse[what, day] == value else difference(coarse[what, day], value)
		differences.append(None if apart is None else abs(apart))
	return {what: None if not differences or None in differences else max(differences) for what, differences in worst.items()}


def finestThatReached(case, rows):
	"""{(what, day): value} of the last row that came to that day."""
	finest = {}
	for row in rows:
		finest.update({name: value for name, value in measures(case, row).items() if name not in finest or value is not None})
	return finest
