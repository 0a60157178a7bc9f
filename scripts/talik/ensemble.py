# SPDX-License-Identifier: GPL-2.0-or-later
"""Results with their scatter: one slope run several times, with samples of other seeds and a shifted grid.

	scripts/run thaw_slump_base --ensemble 12                    # twelve runs, one on each core; started again it goes on
	several = talik.ensemble.read("output/thaw_slump_base")      # the runs that are done
	print(several.report())

Where ground fails depends in part on chance: on which sample is where, and on where the nodes of the grid are. Each member of an ensemble has its
own seed and its own shift of the grid; the first one has those of a single run. Each runs in its own yade on one core, in its own folder, with
checkpoints. Started again, stopped members go on, finished ones stay, and a larger number adds members.
`spread` gives each main result with mean, standard error and deciles. `cost` says how many runs would halve the standard error: three times as many
again, because it falls with the root of their number.

An example takes part if it has the options --output, --seed, --realisations, --grid-offset and --resume, and leaves summary.json, whose entry
"headlines" names its numbers, and frames.npz, as the slumps do. For scripts of your own see talik.batch.
"""

import argparse
import json
import os
import shutil
import signal
import subprocess
import time
from dataclasses import dataclass
from pathlib import Path

import numpy as np

from talik import output, plots
from talik.files import writableFolder, writeWhole
from talik.realisation import seedStride

planName, finishedName, logName = "ensemble.json", "finished.json", "log.txt"
slid = 0.1  # displacement from which on ground counts as slid [m]
broke = 0.1  # part of the bonds of a sample broken mechanically from which on it counts as broken [-]
failed = 0.2  # deviatoric strain from which on frozen ground counts as failed [-]
sunk = 0.5  # of the top of a slope, from which on it counts as failed [m]


# ---- members ---------------------------------------------------------------------------------------------------------------


def members(count, seed=1, realisations=1):
	"""[(seed, offset)] of an ensemble: seeds so far apart that realisations do not meet, offsets of the grid in cells that fill 0 to 1 evenly (van der
	Corput). The first one is that of a single run, and more members do not change those before.

	>>> talik.ensemble.members(4)
	[(1, 0.0), (1001, 0.5), (2001, 0.25), (3001, 0.75)]"""
	if count < 1:
		raise ValueError(f"ensemble: the number of members is {count}; give 1 or more")
	return [(seed + seedStride * realisations * k, _radicalInverse(k)) for k in range(count)]


def _radicalInverse(number):
	"""Its binary digits behind the point, in reverse."""
	inverse, part = 0.0, 1.0
	while number:
		part /= 2
		inverse += part * (number % 2)
		number //= 2
	return inverse


def run(script, folder, count, arguments=(), jobs=None, seed=1, realisations=1, told=print):
	"""Runs an example `count` times and returns the Ensemble of the runs that ended well.

	script     its file
	folder     for the ensemble; each member has a folder in it. What was done there by the same script with the same arguments stays and goes on
	arguments  further ones of the script, for all members
	jobs       members at the same time; default: one for each core
	told       is given each line of the progress

	ValueError where the folder holds an ensemble of another script or of other arguments; RuntimeError if no member ended well, with what the first
	one said.

	>>> talik.ensemble.run("missing.py", folder, 2)
	Traceback (most recent call last):
	ValueError: ensemble: there is no script missing.py"""
	if not Path(script).is_file():
		raise ValueError(f"ensemble: there is no script {script}")
	folder = writableFolder(folder)
	plan = {"script": Path(script).stem, "arguments": list(arguments), "seed": seed, "realisations": realisations}
	_keepPlan(folder / planName, plan)
	waiting = []
	for number, (ownSeed, offset) in enumerate(members(count, seed, realisations)):
		own = folder / f"member{number:03d}"
		if (own / finishedName).exists():
			continue
		command = ["yade", "-n", "-x", "-j1", str(script), *arguments, "--output", str(own)]
		command += ["--seed", str(ownSeed), "--realisations", str(realisations), f"--grid-offset={offset}"]
		waiting.append((number, own, command))
	_work(waiting, jobs or len(os.sched_getaffinity(0)), count, told)
	several = read(folder, count)
	if not several.summaries:
		log = folder / "member000" / logName
		said = log.read_text(errors="replace").splitlines()[-15:] if log.exists() else []
		raise RuntimeError("ensemble: no member ended well; the first one said:\n" + "\n".join(said))
	return several


def _keepPlan(file, plan):
	former = json.loads(file.read_text()) if file.exists() else plan
	if former != plan:
		different = ", ".join(f"{name} {former.get(name)!r} and now {plan[name]!r}" for name in plan if former.get(name) != plan[name])
		raise ValueError(f"ensemble: {file.parent} holds runs with {different}; give another folder, or delete this one")
	writeWhole(file, json.dumps(plan, indent="\t") + "\n")


def _work(waiting, jobs, count, told):
	environment = {name: value for name, value in os.environ.items() if name != "DISPLAY"}
	environment.update(OMP_WAIT_POLICY="passive", MPLBACKEND="Agg")
	running = {}
	try:
		while waiting or running:
			while waiting and len(running) < jobs:
				number, own, command = waiting.pop(0)
				own.mkdir(exist_ok=True)
				goesOn = any(own.glob("*.checkpoint"))
				with open(own / logName, "a") as log:
					child = subprocess.Popen(
						command + ["--resume"] * goesOn, stdout=log, stderr=subprocess.STDOUT, stdin=subprocess.DEVNULL, env=environment, start_new_session=True
					)
				running[number] = (child, own, time.monotonic())
				told(f"member {number} of {count} {'goes on' if goesOn else 'begins'}")
			time.sleep(0.2)
			for number, (child, own, since) in list(running.items()):
				if child.poll() is None:
					continue
				del running[number]
				seconds = time.monotonic() - since
				if child.returncode == 0 and (own / "summary.json").exists():
					writeWhole(own / finishedName, json.dumps({"seconds": seconds}) + "\n")
					told(f"member {number} of {count} is done, {seconds:.0f} s")
				else:
					told(f"member {number} of {count} failed (status {child.returncode}): see {own / logName}")
	finally:  # members that are interrupted leave a checkpoint
		for child, _, _ in running.values():
			child.send_signal(signal.SIGINT)
		for child, _, _ in running.values():
			try:
				child.wait(60)
			except subprocess.TimeoutExpired:
				child.kill()


# ---- what they came to -----------------------------------------------------------------------------------------------------


@dataclass(frozen=True, repr=False)
class Spread:
	"""One number of several runs.

	>>> talik.ensemble.Spread("path", (1.0, 2.0, 3.0, None), 4)
	path: 2 ± 0.577, deciles 1.2, 2 and 2.8, in 3 of 4 runs"""

	name: str
	values: tuple  # of the runs that have it; None of the others
	runs: int

	@property
	def given(self):
		return np.array([value for value in self.values if value is not None], dtype=float)

	@property
	def mean(self):
		return float(self.given.mean())

	@property
	def error(self):
		"""Standard error of the mean; nan of a single run."""
		given = self.given
		return float(given.std(ddof=1) / np.sqrt(len(given))) if len(given) > 1 else float("nan")

	@property
	def deciles(self):
		"""(first, fifth, ninth): a tenth, a half and nine tenths of the runs lie below."""
		return tuple(float(value) for value in np.quantile(self.given, (0.1, 0.5, 0.9)))

	def __repr__(self):
		if not len(self.given):
			return f"{self.name}: in none of {self.runs} runs"
		low, middle, high = self.deciles
		return f"{self.name}: {self.mean:.3g} ± {self.error:.3g}, deciles {low:.3g}, {middle:.3g} and {high:.3g}, in {len(self.given)} of {self.runs} runs"

	def row(self):
		"""Of a table in Markdown, see spreadHead."""
		if not len(self.given):
			return f"| {self.name} | – | – | – | – | – | 0 of {self.runs} |"
		numbers = " | ".join(f"{value:.3g}" for value in (self.mean, self.error, *self.deciles))
		return f"| {self.name} | {numbers} | {len(self.given)} of {self.runs} |"


spreadHead = "| number | mean | standard error | first decile | median | ninth decile | in runs |\n|---|---|---|---|---|---|---|"


def spread(results, names=None):
	"""{name: Spread} of results of several runs, dictionaries such as talik.batch.run returns; None among them is left out.

	names  of the numbers; default: "headlines" of the first result, or all that are numbers in it. A run that lacks one does not count for it

	>>> talik.ensemble.spread([dict(path=1.0), dict(path=3.0)])["path"].mean
	2.0"""
	results = [result for result in results if result is not None]
	if not results:
		return {}
	names = names or results[0].get("headlines") or [name for name, value in results[0].items() if _isNumber(value)]
	return {name: Spread(name, tuple(result[name] if _isNumber(result.get(name)) else None for result in results), len(results)) for name in names}


def _isNumber(value):
	return isinstance(value, (int, float)) and not isinstance(value, bool) and np.isfinite(value)


def confidence(happened, runs, level=0.9):
	"""(lowest, highest) probability of an event that `happened` in so many of `runs`, between which it lies with a confidence of `level` (Clopper and
	Pearson 1934).

	>>> [round(float(p), 3) for p in talik.ensemble.confidence(3, 30)]
	[0.028, 0.239]"""
	from scipy import stats

	happened = np.asarray(happened, dtype=float)
	rest = (1 - level) / 2
	low = np.where(happened > 0, stats.beta.ppf(rest, np.maximum(happened, 1e-9), runs - happened + 1), 0.0)
	return low, np.where(happened < runs, stats.beta.ppf(1 - rest, happened + 1, np.maximum(runs - happened, 1e-9)), 1.0)


@dataclass(frozen=True)
class Ensemble:
	"""Runs of an ensemble that ended well, see read.

	>>> several = talik.ensemble.read(folder)
	>>> len(several.summaries)
	0"""

	folder: Path
	folders: list
	summaries: list  # of each run what summary.json holds

	def spread(self, names=None):
		"""{name: Spread} of the headline numbers."""
		return spread(self.summaries, names)

	def cost(self, jobs=None):
		"""(runs, seconds) that halve the standard error of every number: runs besides those there are, and the time they take on `jobs` cores."""
		jobs = jobs or len(os.sched_getaffinity(0))
		more = 3 * len(self.summaries)
		seconds = [json.loads((folder / finishedName).read_text())["seconds"] for folder in self.folders]
		return more, float(np.mean(seconds)) * -(-more // jobs)

	def frames(self):
		"""Of each run the states that talik.output.Frames kept."""
		return [output.loadFrames(folder / "frames.npz") for folder in self.folders if (folder / "frames.npz").exists()]

	def report(self):
		"""Table of the headline numbers, how often the top of the slope failed, and what halving the spread would cost, as Markdown."""
		lines = [spreadHead, *(each.row() for each in self.spread().values()), ""]
		days = [dayOfFailure(frames) for frames in self.frames()]
		if days:
			happened = sorted(day for day in days if day is not None)
			low, high = confidence(len(happened), len(days))
			text = f"The top of the slope sinks by {sunk:g} m in {len(happened)} of {len(days)} runs ({100 * len(happened) / len(days):.0f} %, with 90 % "
			text += f"confidence {100 * low:.0f} to {100 * high:.0f} %)"
			if happened:
				text += f", on day {', '.join(f'{day:.0f}' for day in happened)}"
			lines += [text + ".", ""]
		runs, seconds = self.cost()
		lines.append(f"Halving the standard errors takes {runs} runs more, {_words(seconds)} on {len(os.sched_getaffinity(0))} cores.")
		return "\n".join(lines)

	def draw(self):
		"""Writes paths.png, map.png and failure.png into the folder and returns their paths."""
		frames = self.frames()
		pictures = [plots.save(drawPaths([summary["history"] for summary in self.summaries if summary.get("history")]), self.folder / "paths.png", dpi=100)]
		if frames:
			pictures.append(plots.save(drawMap([each[-1] for each in frames]), self.folder / "map.png", dpi=100))
			figure = drawFailure([dayOfFailure(each) for each in frames], min(each[-1]["day"] for each in frames))
			pictures.append(plots.save(figure, self.folder / "failure.png", dpi=100))
		return pictures


def _words(seconds):
	for size, unit in ((3600, "hours"), (60, "minutes")):
		if seconds >= 2 * size:
			return f"{seconds / size:.1f} {unit}"
	return f"{seconds:.0f} seconds"


def read(folder, count=None):
	"""The Ensemble in a folder: members that ended well, of the first `count` ones or of all.

	>>> talik.ensemble.read(folder).summaries
	[]"""
	folder = Path(folder)
	done = [own for own in sorted(folder.glob("member*"))[:count] if (own / finishedName).exists()]
	return Ensemble(folder, done, [json.loads((own / "summary.json").read_text()) for own in done])


# ---- pictures --------------------------------------------------------------------------------------------------------------


def drawPaths(histories, label="largest displacement [m]"):
	"""Figure: each run as a thin line, the median, and the band between first and ninth decile.

	histories  of each run rows of day, time of motion and displacement [m]

	>>> figure = talik.ensemble.drawPaths([[(0, 0, 0), (10, 1, 1)], [(0, 0, 0), (10, 1, 3)]])"""
	days = np.unique(np.concatenate([np.array(history)[:, 0] for history in histories]))
	days = days[days <= min(history[-1][0] for history in histories)]
	paths = np.array([np.interp(days, *np.array(history)[:, [0, 2]].T) for history in histories])
	low, middle, high = np.quantile(paths, (0.1, 0.5, 0.9), axis=0)
	fig = plots.figure(7, 4)
	axes = fig.subplots()
	axes.fill_between(days, low, high, color="steelblue", alpha=0.3, linewidth=0, label="first to ninth decile")
	lines = axes.plot(days, paths.T, color="0.5", linewidth=0.5)
	lines[0].set_label("single runs")
	axes.plot(days, middle, color="navy", label=f"median of {len(paths)} runs")
	axes.set(xlabel="day", ylabel=label, xlim=(days[0], days[-1]), ylim=(0, None))
	axes.legend(frameon=False, loc="best")
	return fig


def dayOfFailure(frames, least=sunk):
	"""Day on which the top of a slope has first sunk by `least` [m], on a straight line between two frames; None if it never has. The top is the uppermost
	layer of points; before it moved it lay within one width of a point below the highest one.

	>>> def frame(day, sinks):
	...     return dict(day=day, position=np.array([(0.5, 1.5 - sinks)]), displacement=np.array([(0.0, -sinks)]), volume=np.ones(1))
	>>> talik.ensemble.dayOfFailure([frame(0, 0), frame(10, 0.2), frame(20, 0.8)])
	15.0"""
	height = (frames[0]["position"] - frames[0]["displacement"])[:, -1]
	top = height > height.max() - sideOf(frames[0])
	looks = [(frame["day"], -frame["displacement"][top, -1].min()) for frame in frames]
	for (before, less), (day, more) in zip([(0.0, 0.0), *looks], looks):
		if more >= least:
			return float(before + (day - before) * (least - less) / (more - less))
	return None


def drawFailure(days, end, what=f"the top of the slope has sunk by {sunk:g} m"):
	"""Figure: probability that it has happened until a day, with its band of confidence of 90 %.

	days  on which it happened in each run, None where it did not; end: day on which the runs ended

	>>> figure = talik.ensemble.drawFailure([500, None, 520], end=600)"""
	happened = np.sort([day for day in days if day is not None])
	edges, count = [0, *np.repeat(happened, 2), end], np.repeat(np.arange(len(happened) + 1), 2)
	low, high = confidence(count, len(days))
	axes = plots.figure(6, 3.5).subplots()
	axes.fill_between(edges, 100 * low, 100 * high, color="steelblue", alpha=0.3, linewidth=0, label="90 % confidence")
	axes.plot(edges, 100 * count / len(days), color="navy", label=f"{len(happened)} of {len(days)} runs")
	axes.set(xlabel="day", ylabel="probability [%]", title=what, xlim=(0, end), ylim=(0, 100))
	axes.legend(frameon=False, loc="upper left")
	return axes.figure


def shares(frames, happened=None):
	"""(place, side, {name: share}) of ground as it lay before it moved: in how many of the runs, 0 to 1, it has slid by 0.1 m ("has slid"), a tenth of
	its bonds has broken ("bonds broken"), and it has failed while frozen, to a strain of 0.2 ("failed frozen").

	frames    fields of the last state of each run, as talik.output.Frames keeps them
	happened  function of a frame that gives {name: booleans (n,)}, in place of these three
	place     (n, 2) middles of cells [m], in space (n, 3); side their width [m]

	>>> still = dict(position=np.zeros((1, 2)), displacement=np.zeros((1, 2)), volume=np.ones(1), deviatoricStrain=np.zeros(1), iceSaturation=np.ones(1))
	>>> talik.ensemble.shares([still])[2]["has slid"]
	array([0.])"""
	from scipy.spatial import cKDTree

	side = sideOf(frames[0])
	starts = [frame["position"] - frame["displacement"] for frame in frames]
	cells = [set(map(tuple, np.floor(start / side + 1e-6).astype(int))) for start in starts]
	place = (np.array(sorted(set.union(*cells))) + 0.5) * side
	sums, seen = {}, np.zeros(len(place))
	for frame, start in zip(frames, starts):
		distance, nearest = cKDTree(start).query(place)
		there = distance < side
		seen += there
		for name, so in (happened or _happened)(frame).items():
			sums[name] = sums.get(name, 0) + np.where(there, so[nearest], 0)
	return place, side, {name: values / np.maximum(seen, 1) for name, values in sums.items()}


def sideOf(frame):
	"""Width of a point [m], from the median of the volumes.

	>>> talik.ensemble.sideOf(dict(position=np.zeros((1, 2)), volume=np.full(1, 0.25)))
	0.5"""
	return float(np.median(frame["volume"]) ** (1 / frame["position"].shape[1]))


def _happened(frame):
	frozen = frame[next((name for name in frame if name.endswith("sampleIceSaturation")), "iceSaturation")] > 0.05
	happened = {"has slid": np.linalg.norm(frame["displacement"], axis=1) > slid}
	if "bondsBroken" in frame:
		happened["bonds broken"] = frame["bondsBroken"] > broke * np.maximum(frame["bondsFormed"], 1)
	happened["failed frozen"] = frozen & (frame["deviatoricStrain"] > failed)
	return happened


def drawMap(frames):
	"""Figure: in how many of the runs ground slid, its bonds broke, and it failed while frozen, on the ground as it lay before; see shares.

	>>> still = dict(position=np.zeros((1, 2)), displacement=np.zeros((1, 2)), volume=np.ones(1), deviatoricStrain=np.zeros(1), iceSaturation=np.ones(1))
	>>> figure = talik.ensemble.drawMap([still])"""
	place, side, parts = shares(frames)
	fig = plots.figure(5 * len(parts), 2.8)
	for axes, (name, share) in zip(np.atleast_1d(fig.subplots(1, len(parts))), parts.items()):
		plots.slopeField(
			axes, place, 100 * share, np.full(len(place), side**2), label=f"{name} [% of {len(frames)} runs]", colourMap="magma_r", limits=(0, 100)
		)
	return fig


# ---- the command -----------------------------------------------------------------------------------------------------------


def main():
	parser = argparse.ArgumentParser(prog="scripts/run … --ensemble", description="An example run several times: headline numbers with their spread.")
	parser.add_argument("--ensemble", type=int, required=True, help="number of runs")
	parser.add_argument("--script", required=True)
	parser.add_argument("--output", required=True, help="folder for the ensemble")
	parser.add_argument("--jobs", type=int, help="runs at the same time; default: one for each core")
	parser.add_argument("--seed", type=int, default=1, help="of the first run")
	parser.add_argument("--realisations", type=int, default=1, help="samples of each run")
	options, rest = parser.parse_known_args()

	if not shutil.which("yade"):
		raise SystemExit("run: there is no yade to start")

	def say(line):
		print(line, flush=True)

	try:
		several = run(options.script, options.output, options.ensemble, rest, options.jobs, options.seed, options.realisations, say)
	except (ValueError, RuntimeError) as problem:
		raise SystemExit(f"run: {problem}") from None
	report = several.report()
	print(report)
	writeWhole(several.folder / "ensemble.md", report + "\n")
	print("\n".join(map(str, several.draw())))


if __name__ == "__main__":
	main()
