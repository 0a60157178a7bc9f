# SPDX-License-Identifier: GPL-2.0-or-later
"""The thaw slumps of Yu & Zhao, section 3.2: what both cases share.

A frozen slope with a 45 degree face stands behind a bench. Every material point has a sample of grains with ice bonds; the samples
of each depth band are brought to the geostatic stress first and frozen then. The slope comes to rest, then heat comes in, and the
slope thaws, loses its bonds and fails. The examples say where the heat comes from and what they keep.
"""

import argparse
import base64
import json
import math
import time
from contextlib import contextmanager, nullcontext
from dataclasses import asdict, dataclass, field, replace
from pathlib import Path

import numpy as np

from yade import O, wrapper

import talik
from talik import calibrate, checkpoint, output, plots, rve, shearband, slope, slumppage
from talik.console import awaitEndOfStep
from talik.files import writableFolder
from talik.progress import Progress
from talik.slumppage import framesName, samplesName, summaryName

# Geometry [m]: ours, the paper prints none. A 45 degree face, 3 m high, above a 1 m bench.
outline = [(0, 0), (10, 0), (10, 1), (6, 1), (3, 4), (0, 4)]


seriesLength = 40  # states in the ParaView series
checkpointName, memoryTag = "slope.checkpoint", "thawSlump"
checkpointInterval = 60  # wall time [s]
remembered = (
	"name",
	"presetName",
	"skeletonName",
	"thaws",
	"frameDays",
	"restKineticEnergy",
	"calibrationSeconds",
	"thawed",
	"reached",
	"history",
)  # attributes of a run
frameParts = (0, 0.25, 0.5, 0.75, 1)  # of the thaw: days of the frames
never = 1e12  # [s of calendar time]
shownEvents = 12
bandStrain = 0.2  # displacement across a band over its width, from which on ground has failed [-]


def runUntil(instant, look=None, interval=0.2):
	"""Runs O until its time reaches `instant` [s], calling `look` every `interval` seconds of wall time.

	The engines run in YADE's background thread, so that Ctrl-C stops between two steps and leaves a usable scene."""
	if O.time >= instant:
		return
	O.stopAtTime, O.stopAtIter = instant, 0
	O.run()
	pause, nextLook = 0.002, time.monotonic() + interval
	try:
		while O.running:
			time.sleep(pause)
			pause = min(1.5 * pause, 0.05)
			if look is not None and time.monotonic() > nextLook:
				look()
				nextLook = time.monotonic() + interval
	except KeyboardInterrupt:
		O.pause()
		awaitEndOfStep(O)
		raise
	O.wait()


def runUntilDay(mpm, day, look=None, longest=math.inf):
	"""As runUntil, until the calendar of `mpm` reaches `day`, but at most until O.time is `longest` [s]."""
	if mpm.calendar["day"] >= day:
		return
	mpm.stopAtDay = day
	runUntil(longest, look)


@contextmanager
def atRest():
	"""O rests between two steps for the block; a run goes on afterwards."""
	running = O.running
	if running:
		O.pause()
		awaitEndOfStep(O)
	ended = O.stopAtIter < 0  # it stopped by itself in the meantime: YADE marks that so
	yield
	if running and O.time < O.stopAtTime and not ended:
		O.run()


@dataclass
class Preset:
	"""Size of a job."""

	gridSpacing: float  # [m]; the paper's is 0.2
	grains: int  # in each sample; the paper's is 400
	days: float  # of thaw
	strainTolerance: float = 2e-5
	bandThickness: float = 0.5  # of samples at the same initial stress [m]
	restTime: float = 0.6  # longest time to come to rest before the thaw [s]
	realisations: int = 1  # of the sample, dealt to the points by chance
	seed: int = 1  # of the samples and of that chance
	longestMotion: float = math.inf  # of the thaw [s]: a run whose ground never rests ends here
	calibration: dict = field(default_factory=dict)  # arguments of talik.calibrate.calibrate, for MohrCoulombSkeleton


skeletons = ("samples", "MohrCoulomb")
calendars = ("follows-motion", "constant")
fullThawStrain = "full"  # all of eq. (8): the porosity of the sample

presets = {
	"test": Preset(
		gridSpacing=0.5,
		grains=60,
		days=6.0,
		strainTolerance=5e-5,
		bandThickness=1.0,
		restTime=0.2,
		calibration=dict(iceSaturations=(0.0, 0.5, 1.0), pressures=(10e3, 50e3)),
	),
	"draft": Preset(gridSpacing=0.5, grains=100, days=150.0),
	"standard": Preset(gridSpacing=0.25, grains=200, days=150.0),
	"paper": Preset(gridSpacing=0.2, grains=400, days=150.0),
}


@dataclass
class Ground:
	"""Settings of the ground; (P) the paper's, (O) ours where it is silent."""

	temperature: float = -5.0  # initial [degC] (P)
	warm: float = 10.0  # [degC] (P)
	porosity: float = 0.4  # (P)
	conductivity: float = 1e-4  # k [m/s] (P)
	thermalTimeScale: float = 8.64e5  # f_T, one second is ten days of heat (P)
	followsMotion: bool = False  # the scale of slow time falls to movingTimeScale while the ground moves (O); False: constant (P)
	movingTimeScale: float = 1.0  # f_m, while it moves (O)
	motionTolerance: float = 0.05  # speed at which the scale lies half way [m/s] (O)
	bulkModulus: float = 2.2e7  # numerical K_w [Pa], lower than water's for the time step (O); see skemptonB in the summary
	freezingWidth: float = 0.5  # W of the gauss freezing curve [K] (O)
	residualSaturation: float = 0.05  # S_r (O)
	zetaActive: bool = True  # melting contracts; the gap behind the front keeps thawed ground drained (O)
	lateralRatio: float = 0.7  # horizontal over vertical stress at rest (O)
	thawStrain: float = 0.0  # area strain that thawing grains release [-], or fullThawStrain; 0: bookkeeping of grain size, eq. (8) (O)
	thawedCohesion: float = 0.0  # cohesion that stays when the ice has gone [Pa], C_0 of eq. (5); 0: none, and a slope without a length of its own (O)
	damping: float = 0.02  # local damping during failure (O)
	restDamping: float = 0.7  # local damping while the slope comes to rest (O)


class ThawSlump:
	"""One run of a slump: build, bring to rest, thaw, draw.

	name        of the case, used in titles
	boundaries  function (start) -> list of thermal boundaries that begin to warm at `start` [s of calendar time]
	preset      a name in presets or a Preset
	folder      for the results
	frameDays   days of the thaw at which all fields are kept; default five
	skeleton    samples: one behind every point; MohrCoulomb: calibrated on the same sample by talik.calibrate"""

	def __init__(self, name, boundaries, preset="draft", folder="output", ground=None, thaw=True, frameDays=None, skeleton="samples"):
		if skeleton not in skeletons:
			raise ValueError(f"skeleton is {skeleton!r}; choose one of {', '.join(skeletons)}")
		self.skeletonName = skeleton
		self.name, self.thermalBoundaries, self.thaws = name, boundaries, thaw
		self.presetName = preset if isinstance(preset, str) else "own"
		self.preset = presets[preset] if isinstance(preset, str) else preset
		self.ground = ground or Ground()
		self.frameDays = [part * self.preset.days for part in frameParts] if frameDays is None else sorted(frameDays)
		self.folder = writableFolder(folder)
		self.wallStart, self.cpuStart = time.monotonic(), time.process_time()
		self.calibrationSeconds, self.thawed = None, {}
		self.mpm = self._build()
		self.frames = self._frames()
		self.series = output.ParaViewSeries(self.mpm, self.folder / "paraview", clock=self.day)
		self.reached = None  # last day of the thaw whose state was kept
		self.history = []  # [day, time of motion [s], largest displacement [m]]

	@classmethod
	def resumed(cls, folder):
		"""The run whose checkpoint lies in `folder`, as it was then; run() goes on with it, to the same last bit as if it had not been stopped."""
		run, folder = cls.__new__(cls), writableFolder(folder)
		run.folder, run.wallStart, run.cpuStart = folder, time.monotonic(), time.process_time()
		run.mpm = checkpoint.resume(folder / checkpointName)
		run.skeleton = run.mpm.skeleton
		run._recall(json.loads(base64.b64decode(O.tags[memoryTag])))
		return run

	def _recall(self, memory):
		try:
			self._remember(memory)
		except (KeyError, TypeError) as missing:
			raise ValueError(
				f"{self.folder / checkpointName}: another version of Talik wrote this slump ({missing}); go on with that version, or start anew without --resume"
			) from missing

	def _frames(self):
		return output.Frames(self.mpm, self.frameDays, clock=self.thawTime, days=True)

	def endAt(self, days):
		"""The thaw ends on day `days` in place of the preset's: for a run to be gone on with. Frames taken stay."""
		self.preset = replace(self.preset, days=days)
		taken, untaken = self.frameDays[: len(self.frames.frames)], self.frameDays[len(self.frames.frames) :]
		self.frameDays = self.frames.times = taken + [day for day in untaken if day < days] + [days]

	# ---- building

	def _build(self):
		p, g = self.preset, self.ground
		positions, volumes = talik.geometry.fillPolygon(outline, p.gridSpacing, 4, (0.0, 0.0))
		density = 0.6 * 2650 + 0.4 * (0.95 * 910 + 0.05 * 1000)
		several = slope.pack(rve.prepare(grains=p.grains, ice=True, realisations=p.realisations, seed=p.seed))
		stress = {}
		if self.skeletonName == "samples":
			self._keepCohesion(several)
			for sample in several:
				sample.thawStrain = g.thawStrain if g.thawStrain != fullThawStrain else sample.statistics()["porosity"]
			samples, sampleOf = slope.depthBands(positions, outline, several, density, p.bandThickness, g.lateralRatio, seed=p.seed)
			self.skeleton = wrapper.RveSkeleton(samples=samples, sampleOf=sampleOf, strainTolerance=p.strainTolerance)
		else:
			calibration = calibrate.calibrate(several, **p.calibration)
			self.calibrationSeconds = calibration.seconds
			law = calibration.parameters()
			law["cohesions"] = [max(cohesion, g.thawedCohesion) for cohesion in law["cohesions"]]
			self.skeleton = wrapper.MohrCoulombSkeleton(**law)
			depths = [slope.surfaceHeight(outline, x) - y for x, y in positions]
			across, down = np.transpose([slope.geostaticStress(depth, density, lateralRatio=g.lateralRatio) for depth in depths])
			stress = dict(stress=np.stack([across, down, 0.5 * (across + down), 0 * down], axis=-1))
		height = 4 + 4 * p.gridSpacing
		mpm = wrapper.MpmEngine(
			gridSpacing=p.gridSpacing,
			lower=(0, 0),
			upper=(10, p.gridSpacing * round(height / p.gridSpacing)),
			gravity=(0, -9.81),
			damping=g.restDamping,
			skeleton=self.skeleton,
			heat=wrapper.HeatTransfer(followsMotion=g.followsMotion, motionTolerance=g.motionTolerance),  # in nature's time until the slope rests
			freezing=wrapper.FreezingCurve(curve="gauss", width=g.freezingWidth, residualSaturation=g.residualSaturation),
			water=wrapper.PoreWater(
				conductivity=g.conductivity, bulkModulus=g.bulkModulus, zetaActive=g.zetaActive, hydraulicTimeScale=1
			),  # hastened seepage drains frozen pores beside a front until they cool
		)
		mpm.addPoints(position=positions, volume=volumes, porosity=g.porosity, temperature=g.temperature, **stress)
		mpm.boundaries = [
			wrapper.RollerBoundary(region="left"),
			wrapper.RollerBoundary(region="right"),
			wrapper.FixedBoundary(region="bottom"),
			wrapper.DrainedBoundary(region="surface", recharge=False),
		] + self.thermalBoundaries(0.0 if self.thaws else never)
		return mpm

	def _keepCohesion(self, samples):
		"""Bonds that outlast their ice, of the strength that gives the samples the thawed cohesion."""
		strength, self.thawed["cohesion measured [Pa]"] = calibrate.thawedStrength(samples, self.ground.thawedCohesion)
		self.thawed["strength of bonds [Pa]"] = strength
		for sample in samples:
			sample.thawedStrength = strength

	# ---- running

	def run(self):
		"""Rest, thaw, results. Returns the summary.

		A checkpoint is kept in the folder every minute, and when the run is interrupted by Ctrl-C: see resumed()."""
		if self.reached is None:
			self.rest()
		progress = Progress(endDay=self.preset.days, calendar=lambda: self.mpm.calendar, clock=self.thawTime, details=self._details)
		try:
			self._thaw(progress.update)
		except KeyboardInterrupt:
			self._keep()
			raise
		finally:
			progress.close()
			summary = self._results()
		return summary

	def rest(self):
		"""The slope comes to rest in nature's time; then the calendar begins on day 0 and follows the motion."""
		O.engines = [self.mpm]
		self.initialBalance = self.mpm.balance()
		self.mpm.setDay(-1)
		runUntil(self.preset.restTime)
		self.restKineticEnergy = self.mpm.balance()["kineticEnergy"]
		self.mpm.resetDisplacement()
		self.mpm.damping = self.ground.damping
		self.mpm.heat.thermalTimeScale, self.mpm.heat.movingTimeScale = self.ground.thermalTimeScale, self.ground.movingTimeScale
		self.mpm.setDay(0)
		self.reached = -1.0

	def _thaw(self, look):
		seriesDays, self._kept = np.linspace(0, self.preset.days, seriesLength + 1), time.monotonic()

		def lookAndKeep():
			look()
			self._keepWhenDue()

		longest = self.preset.restTime + self.preset.longestMotion
		for day in np.union1d(seriesDays, self.frameDays):
			if day <= self.reached:
				continue
			runUntilDay(self.mpm, day, lookAndKeep, longest=longest)
			self.history.append([self.day(), self.thawTime(), self._largestDisplacement()])
			if day in seriesDays:
				self.series.write()
			self.frames.take()
			self.reached = float(day)
			self._keepWhenDue()
			if O.time >= longest:
				self.frames.takeNow()
				break

	# ---- stopped and gone on with

	def _keepWhenDue(self):
		if time.monotonic() < self._kept + checkpointInterval:
			return
		with atRest():
			self._keep()
		self._kept = time.monotonic()

	def _keep(self):
		"""Frames first: a checkpoint never lacks one."""
		self.frames.save(self.folder / framesName)
		O.tags[memoryTag] = base64.b64encode(json.dumps(self._memory()).encode()).decode()
		checkpoint.write(self.folder / checkpointName)

	def _memory(self):
		"""What a run knows beside its scene."""
		return {
			**{name: getattr(self, name) for name in remembered},
			"preset": asdict(self.preset),
			"ground": asdict(self.ground),
			"initialBalance": output.plain(self.initialBalance),
			"series": self.series.entries,
			"seconds": time.monotonic() - self.wallStart,
			"cpuSeconds": time.process_time() - self.cpuStart,
		}

	def _remember(self, memory):
		for name in remembered:
			setattr(self, name, memory[name])
		self.preset, self.ground = Preset(**memory["preset"]), Ground(**memory["ground"])
		self.initialBalance = memory["initialBalance"]
		self.wallStart -= memory["seconds"]
		self.cpuStart -= memory["cpuSeconds"]
		self.frames = self._frames()
		self.frames.frames = [frame for frame in output.loadFrames(self.folder / framesName) if frame["time"] <= self.thawTime()]
		self.series = output.ParaViewSeries(self.mpm, self.folder / "paraview", clock=self.day)
		self.series.entries = [tuple(entry) for entry in memory["series"]]

	def thawTime(self):
		"""Time of motion since the start of the thaw [s]."""
		return self.mpm.time - self.preset.restTime

	def day(self):
		"""Day of the thaw."""
		return self.mpm.calendar["day"]

	def _largestDisplacement(self):
		return float(np.linalg.norm(self.mpm.field("displacement"), axis=1).max())

	def _details(self):
		return {**({"events": len(self.events())} if self.ground.followsMotion else {}), "sample calls": self.counters()["calls"]}

	def events(self):
		"""None where the scale does not follow the motion: nobody looks for them."""
		return self.mpm.events() if self.ground.followsMotion else []

	def counters(self):
		"""Calls, DEM steps, seconds and bytes of the samples; zeros where there are none."""
		return self.skeleton.counters if self.skeletonName == "samples" else {"calls": 0, "steps": 0, "seconds": 0.0, "bytes": 0}

	# ---- results

	def _results(self):
		summary = self.summary()
		output.writeSummary(self.folder / summaryName, **summary)
		if len(self.frames.frames) > 1:
			watched = self.watchedPoints()
			self.frames.save(self.folder / framesName)
			slumppage.saveSamples(self.folder / samplesName, {letter: slumppage.sampleOf(self.skeleton, point) for letter, point in watched.items()}, watched)
			slumppage.draw(self.folder, outline, bandStrain)
		return summary

	def watchedPoints(self):
		"""{"A": id, "B": id} at the end of the run; empty without samples."""
		return shearband.watchedPoints(self.frames.frames[-1], outline, bandStrain) if self.skeletonName == "samples" else {}

	def band(self):
		"""The shear band in frozen ground at the end (talik.shearband.ShearBand) or None."""
		return shearband.measure(self.frames.frames[-1], outline, bandStrain)

	def slipSurface(self):
		"""The shear band in frozen and thawed ground together at the end, or None."""
		return shearband.measure(self.frames.frames[-1], outline, bandStrain, among=True)

	def summary(self):
		"""Named results of the run so far."""
		mpm = self.mpm
		counters = self.counters()
		fields = ("bondsFormed", "bondsIntact", "bondsBroken", "bondsMelted") if self.skeletonName == "samples" else ()
		bonds = {name: int(np.nansum(mpm.field(name))) for name in fields}
		return {
			"case": self.name,
			"preset": self.presetName,
			"skeleton": self.skeletonName,
			**{f"preset.{k}": v for k, v in asdict(self.preset).items()},
			**{f"ground.{k}": v for k, v in asdict(self.ground).items()},
			"wallTime [s]": time.monotonic() - self.wallStart,
			"processor time [s]": time.process_time() - self.cpuStart,
			"threads": O.numThreads if hasattr(O, "numThreads") else None,
			"points": mpm.pointCount,
			"steps": O.iter,
			"time step [s]": O.dt,
			"thaw time [s]": self.thawTime(),
			"day": self.day(),
			"events": self.events(),
			"history": self.history,
			**{f"calendar.{k}": v for k, v in mpm.calendar.items()},
			"sample calls": counters["calls"],
			"sample DEM steps": counters["steps"],
			"sample wall time [s]": counters["seconds"],
			"sample memory [MB]": counters["bytes"] / 1e6,
			"calibration [s]": self.calibrationSeconds,
			**{f"thawed.{k}": v for k, v in self.thawed.items()},
			"largest displacement [m]": self._largestDisplacement(),
			"thawed part [-]": float(np.mean(mpm.field("iceSaturation") < 0.02)),
			**bonds,
			**self._bandSummary(),
			"SkemptonB [-]": mpm.skemptonB(),
			"kinetic energy after rest [J/m]": self.restKineticEnergy,
			**{f"closure.{k}": v for k, v in self.closures().items()},
			**{f"balance.{k}": v for k, v in mpm.balance().items()},
		}

	def _bandSummary(self):
		if not self.frames.frames:
			return {}
		bands, watched, summary = {"frozen": self.band(), "all": self.slipSurface()}, self.watchedPoints(), {}
		for ground, band in bands.items():
			summary[f"band in {ground} ground"] = shearband.describe(band, ground)
			if band is not None:
				measures = {name: value for name, value in vars(band).items() if name != "points"}
				summary.update({f"band in {ground} ground.{name}": value for name, value in measures.items()})
		last = self.frames.frames[-1]
		for letter, point in watched.items():
			formed, intact, broken, melted = (int(last[name][point]) for name in ("bondsFormed", "bondsIntact", "bondsBroken", "bondsMelted"))
			summary[f"point {letter}"] = {"id": point, "bonds formed": formed, "intact": intact, "broken": broken, "melted": melted}
		return summary

	def closures(self):
		"""What is missing in each balance since the start after all that crossed the boundary, over the size of its terms [-]."""
		now, start = self.mpm.balance(), self.initialBalance
		mass = now["solidMass"] + now["waterMass"]
		momentum = np.subtract(now["momentum"], now["impulse"]) - np.subtract(start["momentum"], start["impulse"])
		gained = now["enthalpy"] - start["enthalpy"]
		return {
			"solid": (now["solidMass"] - start["solidMass"]) / start["solidMass"],
			"water": (now["waterMass"] + now["waterOut"] - start["waterMass"]) / start["waterMass"],
			"heat": (gained + now["enthalpyOut"] - now["heatIn"]) / max(abs(start["enthalpy"]), abs(now["heatIn"])),
			"momentum": np.linalg.norm(momentum) / (mass * 9.81 * now["time"]),
		}


def arguments(description, defaultFolder, thawStrain=0.0):
	"""Command line of an example."""
	parser = argparse.ArgumentParser(description=description)
	parser.add_argument("--preset", default="draft", choices=sorted(presets), help="size of the job")
	parser.add_argument("--output", default=defaultFolder, help="folder for the results")
	parser.add_argument("--resume", action="store_true", help="go on with the run that was stopped, from its checkpoint in the folder of the results")
	parser.add_argument("--days", type=_days, help="of the thaw, in place of the case's; with --resume the run goes on until then")
	parser.add_argument("--duration", type=_oldDuration, help=argparse.SUPPRESS)
	parser.add_argument("--redraw", action="store_true", help="draw the pictures anew from the files in the folder of the results, without a run")
	parser.add_argument("--no-thaw", action="store_true", help="the same slope kept frozen, for comparison")
	parser.add_argument(
		"--thaw-strain", default=thawStrain, type=_thawStrain, help="area strain that thawing grains of the samples release: 0, a fraction, or full (eq. 8)"
	)
	parser.add_argument("--skeleton", default="samples", choices=skeletons, help="a sample behind every point, or a law calibrated on the same sample")
	parser.add_argument("--grains", type=_count, help="in each sample, in place of the preset's")
	parser.add_argument("--realisations", type=_count, default=1, help="samples that differ by chance, dealt to the points")
	parser.add_argument("--seed", type=int, default=1, help="of the samples and of that chance")
	parser.add_argument(
		"--calendar",
		choices=calendars,
		help="ten days pass in each second only while the ground rests, or always (constant, as in the paper); default: "
		"follows-motion with the law alone, constant with samples, which take four times as long otherwise",
	)
	parser.add_argument(
		"--thawed-cohesion", type=_cohesion, help="cohesion that stays when the ice has gone [Pa]; default: 2000 with the law alone, 0 with samples"
	)
	parser.add_argument("--compare", choices=("skeleton", "thaw-strain", "both"), help="also run the alternatives, side by side in one figure")
	return parser.parse_args()


def _days(text):
	if not 0 < float(text) < math.inf:
		raise argparse.ArgumentTypeError(f"{text} is no length of time: give days, above 0")
	return float(text)


def _count(text):
	if not text.isdigit() or int(text) < 1:
		raise argparse.ArgumentTypeError(f"{text} is no number of things: give a whole number, 1 or more")
	return int(text)


def _cohesion(text):
	if not 0 <= float(text) < math.inf:
		raise argparse.ArgumentTypeError(f"{text} is no cohesion: give Pa, 0 or more")
	return float(text)


def _oldDuration(text):
	raise argparse.ArgumentTypeError("a thaw is given in days of the calendar now: --days, ten for each of the former seconds")


def _thawStrain(text):
	return text if text == fullThawStrain else float(text)


def runCase(name, boundaries, options, days=None):
	"""Runs a case as its command line says, and prints what it came to. Returns the (last) ThawSlump, a single one stays in O; None when drawn anew.

	days  of the thaw, in place of the preset's"""
	if options.resume:
		slump = ThawSlump.resumed(options.output)
		if options.days is not None:
			slump.endAt(options.days)
		report(slump.run(), slump.folder)
		return slump
	settings = comparison(options)
	folders = {label: Path(options.output) / ("" if len(settings) == 1 else label.replace(" ", "-")) for label in settings}
	slump = None
	for label, setting in settings.items():
		if options.redraw:
			slumppage.draw(folders[label], outline, bandStrain)
		else:
			with nullcontext() if len(settings) == 1 else talik.scratchScene():
				slump = ThawSlump(
					name, boundaries, _presetOf(options, days), folders[label], groundOf(options, setting), not options.no_thaw, skeleton=setting["skeleton"]
				)
				slump.presetName = options.preset
				slump.run()
		report(slumppage.summaryOf(folders[label]), folders[label])
	if len(folders) > 1:
		runs = {label: (output.loadFrames(folder / framesName), bill(slumppage.summaryOf(folder))) for label, folder in folders.items()}
		figure = slumppage.sideBySide(runs, outline)
		print(plots.save(figure, Path(options.output) / f"{options.compare}.png", dpi=80))
	return slump


def groundOf(options, setting):
	"""Ground of a run. What slides converges with the calendar and a cohesion; samples are too slow for that as a
	default, and runs that are compared share one ground."""
	lawAlone = setting["skeleton"] == "MohrCoulomb" and options.compare is None
	calendar = options.calendar or ("follows-motion" if lawAlone else "constant")
	cohesion = options.thawed_cohesion if options.thawed_cohesion is not None else 2e3 if lawAlone else 0.0
	return Ground(thawStrain=setting["thawStrain"], thawedCohesion=cohesion, followsMotion=calendar == "follows-motion")


def _presetOf(options, days):
	preset = presets[options.preset]
	return replace(
		preset,
		days=options.days or days or preset.days,
		grains=options.grains or preset.grains,
		realisations=options.realisations,
		seed=options.seed,
	)


def comparison(options):
	"""{label: thawStrain and skeleton} of the runs that a command line asks for. A law has no thaw strain: it belongs to the grains."""
	law = {"MohrCoulomb": dict(thawStrain=0.0, skeleton="MohrCoulomb")}
	strains = (0.0, options.thaw_strain if options.thaw_strain not in (0.0, fullThawStrain) else 0.03, fullThawStrain)
	sideBySide = {f"thaw strain {value}": dict(thawStrain=value, skeleton="samples") for value in strains}
	given = {"samples": dict(thawStrain=options.thaw_strain, skeleton="samples")}
	return {None: law if options.skeleton == "MohrCoulomb" else given, "thaw-strain": sideBySide, "skeleton": {**given, **law}, "both": {**sideBySide, **law}}[
		options.compare
	]


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
