# SPDX-License-Identifier: GPL-2.0-or-later
"""One run of a thaw slump: rest, thaw, checkpoint, results.

A frozen slope with a 45 degree face stands behind a bench. Every material point has a sample of grains with ice bonds; the samples
of each depth band are brought to the geostatic stress first and frozen then. The slope comes to rest, then heat comes in, and the
slope thaws, loses its bonds and fails.
"""

import base64
import json
import time
from dataclasses import asdict, dataclass, replace

import numpy as np
import talik
from talik import checkpoint, output, rve, slope
from talik.studies import calibrate
from talik.files import writableFolder
from talik.progress import Progress
from thawslump import page, shearband
from thawslump.page import framesName, samplesName, summaryName
from thawslump.settings import Ground, Preset, fullThawStrain, presets, skeletons, widened
from yade import O, wrapper

seriesLength = 40  # states in the ParaView series
checkpointName, memoryTag = "slope.checkpoint", "thawSlump"
checkpointInterval = 60  # wall time [s]
remembered = (
	"name",
	"outline",
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
frameParts = (0, 0.025, 0.05, 0.075, 0.1, 0.25, 0.5, 0.75, 1)  # of the thaw: days of the frames, with some before anything moves
framesByMotion, stepsPerLook = 48, 20  # frames between them, at most, and after so many steps it is looked whether the ground has moved
never = 1e12  # [s of calendar time]
headlines = (
	"largest displacement [m]",
	"first day with 0.1 m",
	"thawed part [-]",
	"bondsBroken",
	"band in all ground.inclination",
	"band in all ground.depth",
	"band in frozen ground.inclination",
	"band in frozen ground.top",
)  # numbers of a summary that stand for a run in an ensemble
bandStrain = 0.2  # displacement across a band over its width, from which on ground has failed [-]
frozenDensity = 0.6 * 2650 + 0.4 * (0.95 * 910 + 0.05 * 1000)  # [kg/m3]


@dataclass(frozen=True)
class Case:
	"""A slope and where its heat comes from."""

	name: str  # used in titles
	outline: list  # corners of the slope [m]
	scene: object  # function (run, start) -> MpmEngine whose boundaries begin to warm at `start` [s of calendar time]


class ThawSlump:
	"""One run of a slump: build, bring to rest, thaw, draw.

	case        the scene
	preset      a name in presets or a Preset
	folder      for the results
	frameDays   days of the thaw at which all fields are kept; default nine, four of them in the first tenth
	skeleton    samples: one behind every point; MohrCoulomb: calibrated on the same sample by talik.studies.calibrate"""

	def __init__(self, case, preset="draft", folder="output", ground=None, thaw=True, frameDays=None, skeleton="samples"):
		ground = ground or Ground()
		if skeleton not in skeletons:
			raise ValueError(f"skeleton is {skeleton!r}; choose one of {', '.join(skeletons)}")
		self.skeletonName = skeleton
		self.presetName = preset if isinstance(preset, str) else "own"
		self.preset = presets[preset] if isinstance(preset, str) else preset
		self.name, self.thaws = case.name, thaw
		self.outline = widened(case.outline, self.preset.gridSpacing, self.preset.gridOffset)
		self.ground = ground
		self.frameDays = [part * self.preset.days for part in frameParts] if frameDays is None else sorted(frameDays)
		self.folder = writableFolder(folder)
		self.wallStart, self.cpuStart = time.monotonic(), time.process_time()
		self.calibrationSeconds, self.thawed = None, {}
		self.mpm = case.scene(self, 0.0 if thaw else never)
		self.skeleton = self.mpm.skeleton
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
		return output.Frames(self.mpm, self.frameDays, clock=self.thawTime, days=True, byMotion=framesByMotion)

	def endAt(self, days):
		"""The thaw ends on day `days` in place of the preset's: for a run to be gone on with. Frames taken stay."""
		self.preset = replace(self.preset, days=days)
		count = len(self.frames.timed())
		taken, untaken = self.frameDays[:count], self.frameDays[count:]
		self.frameDays = self.frames.times = taken + [day for day in untaken if day < days] + [days]

	# ---- building

	def skeletonAtRest(self, position):
		"""(skeleton, further columns of addPoints) at the geostatic stress of points at `position` [m]: samples keep their stress
		themselves, a law takes that of the points."""
		p, g = self.preset, self.ground
		several = rve.pack(rve.prepare(grains=p.grains, thickness=g.thickness, ice=True, realisations=p.realisations, seed=p.seed))
		if self.skeletonName == "samples":
			strength, cohesion = self._strengthOfThawedBonds(several)
			for sample in several:
				sample.thawedStrength = strength
				sample.thawStrain = g.thawStrain if g.thawStrain != fullThawStrain else sample.statistics()["porosity"]
			samples, sampleOf = slope.depthBands(position, self.outline, several, frozenDensity, p.bandThickness, g.lateralRatio, seed=p.seed)
			asked = {name: getattr(p, name) for name in ("strainTolerance", "stressTolerance", "maxInertialNumber")}
			return wrapper.RveSkeleton(samples=samples, sampleOf=sampleOf, **asked, **self._slipOf(several, cohesion)), {}
		self.thawed["friction measured [-]"] = calibrate.thawedFriction(several)
		calibration = calibrate.calibrate(several, friction=self.thawed["friction measured [-]"], **p.calibration)
		self.calibrationSeconds = calibration.seconds
		law = calibration.parameters()
		law["youngs"] = [min(modulus, g.frozenModulus) for modulus in law["youngs"]]
		self._keepCohesion(law, several)
		depths = [slope.surfaceHeight(self.outline, x) - y for x, y in position]
		across, down = np.transpose([slope.geostaticStress(depth, frozenDensity, lateralRatio=g.lateralRatio) for depth in depths])
		return wrapper.MohrCoulombSkeleton(**law), {"stress": np.stack([across, down, 0.5 * (across + down), 0 * down], axis=-1)}

	def _slipOf(self, samples, cohesion):
		"""Attributes of RveSkeleton for the slip at the thaw front of samples with a thawed cohesion [Pa]."""
		self.thawed["friction measured [-]"] = calibrate.thawedFriction(samples)
		return {"slipFriction": self.thawed["friction measured [-]"], "slipCohesion": cohesion}

	def _strengthOfThawedBonds(self, samples):
		"""Strength [Pa] of bonds that outlast their ice, such that they give the samples the thawed cohesion, and the cohesion measured with it [Pa]."""
		strength, cohesion = calibrate.thawedStrength(samples, self.ground.thawedCohesion)
		self.thawed.update({"strength of bonds [Pa]": strength, "cohesion measured [Pa]": cohesion})
		return strength, cohesion

	def _keepCohesion(self, law, samples):
		"""Gives a law the thawed cohesion and the tensile strength that samples have with it: by its cohesion alone a face of 45 degrees is on the
		verge of failure at any small depth, where no shear stress can be larger than the normal stress."""
		cohesion = self.ground.thawedCohesion
		if cohesion == 0:
			return
		strength, _ = self._strengthOfThawedBonds(samples)
		tension = calibrate.thawedTension(samples, strength)
		self.thawed["tension measured [Pa]"] = tension
		law["cohesions"] = [max(c, cohesion) for c in law["cohesions"]]
		law["tensileStrengths"] = [max(t, tension) for t in law["tensileStrengths"]]

	# ---- running

	def run(self):
		"""Rest, thaw, results. Returns the summary.

		A checkpoint is kept in the folder every minute, and when the run is interrupted by Ctrl-C: see resumed()."""
		if self.reached is None:
			self.rest()
		progress = Progress(endDay=self.preset.days, calendar=lambda: self.mpm.calendar, clock=self.thawTime, details=self._details, ground=self.mpm)
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
		"""The slope comes to rest in real time; then the calendar begins on day 0 and follows the motion."""
		O.engines = [self.mpm]
		self.initialBalance = self.mpm.balance()
		self.mpm.setDay(-1)
		talik.runUntil(self.preset.restTime)
		self.restKineticEnergy = self.mpm.balance()["kineticEnergy"]
		self.mpm.resetDisplacement()
		self.mpm.damping, self.mpm.picTime = self.ground.damping, self.ground.picTime(self.preset.gridSpacing)
		self.mpm.heat.thermalTimeScale, self.mpm.heat.movingTimeScale = self.ground.thermalTimeScale, self.ground.movingTimeScale
		self.mpm.setDay(0)
		self.reached = -1.0
		O.engines = [self.mpm, self.frames.runner(iterPeriod=stepsPerLook)]

	def _thaw(self, look):
		seriesDays, self._kept = np.linspace(0, self.preset.days, seriesLength + 1), time.monotonic()

		def lookAndKeep():
			look()
			self._keepWhenDue()

		longest = self.preset.restTime + self.preset.longestMotion
		for day in np.union1d(seriesDays, self.frameDays):
			if day <= self.reached:
				continue
			talik.runUntilDay(self.mpm, day, lookAndKeep, longest=longest)
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
		with talik.atRest():
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
			"motion": [self.frames.moved, self.frames.change],
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
		self.frames.moved, self.frames.change = memory["motion"]
		O.engines[-1].command = self.frames.runner().command  # calls of the process that was stopped are gone
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
		return self.skeleton.cost() if self.skeletonName == "samples" else {"calls": 0, "steps": 0, "seconds": 0.0, "bytes": 0}

	# ---- results

	def _results(self):
		summary = self.summary()
		output.writeSummary(self.folder / summaryName, **summary)
		if len(self.frames.frames) > 1 and talik.ranks.first:
			watched = self.watchedPoints()
			self.frames.save(self.folder / framesName)
			page.saveSamples(self.folder / samplesName, {letter: page.sampleOf(self.skeleton, point) for letter, point in watched.items()}, watched)
			page.draw(self.folder, self.outline, bandStrain)
		return summary

	def watchedPoints(self):
		"""{"A": id, "B": id} at the end of the run; empty without samples."""
		return shearband.watchedPoints(self.frames.frames[-1], self.outline, bandStrain) if self.skeletonName == "samples" else {}

	def band(self):
		"""The shear band in frozen ground at the end (shearband.ShearBand) or None."""
		return shearband.measure(self.frames.frames[-1], self.outline, bandStrain)

	def slipSurface(self):
		"""The shear band in frozen and thawed ground together at the end, or None."""
		return shearband.measure(self.frames.frames[-1], self.outline, bandStrain, among=True)

	def summary(self):
		"""Named results of the run so far."""
		mpm = self.mpm
		counters = self.counters()
		fields = ("bondsFormed", "bondsIntact", "bondsBroken", "bondsMelted", "cellSlips") if self.skeletonName == "samples" else ()
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
			"headlines": list(headlines),
			"largest displacement [m]": self._largestDisplacement(),
			"first day with 0.1 m": self._firstDayWith(0.1),
			"thawed part [-]": float(np.mean(mpm.field("iceSaturation") < 0.02)),
			**bonds,
			**self._bandSummary(),
			"SkemptonB [-]": mpm.skemptonB(),
			"kinetic energy after rest [J/m]": self.restKineticEnergy,
			**{f"closure.{k}": v for k, v in self.closures().items()},
			**{f"balance.{k}": v for k, v in mpm.balance().items()},
		}

	def _firstDayWith(self, path):
		"""Day on which a point has first moved so far [m], on a straight line between two looks; None if none has."""
		looked = [(frame["day"], float(np.linalg.norm(frame["displacement"], axis=1).max())) for frame in self.frames.frames]
		looks = sorted([(0.0, 0.0), *((day, moved) for day, _, moved in self.history), *looked])
		for (before, least), (day, moved) in zip(looks, looks[1:]):
			if moved >= path:
				return before + (day - before) * (path - least) / (moved - least)
		return None

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
