# SPDX-License-Identifier: GPL-2.0-or-later
"""What a problem of the study is: its knobs, a run with given settings, and what the answer is measured against."""

import itertools
import time
from dataclasses import dataclass

import numpy as np


@dataclass
class Run:
	"""What one run came to. The answer is what the problem's error is measured on."""

	answer: list
	wall: float  # of the steps, without building the scene [s]
	cpu: float  # of all threads [s]
	memory: int  # fields of points and nodes, and samples [bytes]
	points: int
	steps: int
	believed: float = None  # MpmEngine.estimatedError, where a tolerance is set


@dataclass(frozen=True, eq=False)
class Problem:
	"""A problem with knobs.

	norm       what the error is
	reference  what it is measured against; where that is a run, referenceName() says which
	standard   settings of a run where nothing else is said
	sweeps     {knob: values} varied one at a time; those of `quick` in a quick study
	pairs      (knob, knob) varied together, over the values of the sweeps
	together   further combinations of settings, also in a quick study; those of togetherInFull in a full one only
	run        function of settings -> Run
	exact      the answer in closed form, or None: `finest` are the settings of the run that stands for it
	error      function of answer and reference -> number"""

	name: str
	title: str
	norm: str
	reference: str
	standard: dict
	sweeps: dict
	quick: dict
	run: object
	error: object
	pairs: tuple = ()
	together: tuple = ()
	togetherInFull: tuple = ()
	exact: object = None
	finest: dict = None
	quickFinest: dict = None

	def plan(self, quick=False, further=()):
		"""Settings of all runs, each once, the reference run first; `further` settings differ from the standard by what they name."""
		sweeps = self.quick if quick else {knob: tuple(dict.fromkeys(self.quick.get(knob, ()) + values)) for knob, values in self.sweeps.items()}
		settings = [self.referenceSettings(quick)] if self.exact is None else []
		settings.append(dict(self.standard))
		settings += [{**self.standard, knob: value} for knob, values in sweeps.items() for value in values]
		for one, other in self.pairs if not quick else ():
			settings += [{**self.standard, one: a, other: b} for a, b in itertools.product(sweeps[one], sweeps[other])]
		settings += [{**self.standard, **other} for other in (*self.together, *(() if quick else self.togetherInFull), *further)]
		return list({key(self.name, s): s for s in settings}.values())

	def referenceSettings(self, quick=False):
		return {**self.standard, **(self.quickFinest if quick and self.quickFinest else self.finest)}

	def referenceName(self, quick=False):
		return self.reference if self.exact is not None else f"{self.reference}: {varied(self.referenceSettings(quick), self.standard)}"

	def referenceAnswer(self, rows, quick=False):
		"""The answer that errors are measured against; None before the reference run is there."""
		if self.exact is not None:
			return np.array(self.exact())
		row = rows.get(key(self.name, self.referenceSettings(quick)))
		return None if row is None or row.get("failure") else np.array(row["answer"])


def key(problem, settings):
	"""Names a run in the results file."""
	return f"{problem}: " + ", ".join(f"{name}={value}" for name, value in sorted(settings.items()))


def varied(settings, standard):
	"""What differs from the standard, in words."""
	differing = {name: value for name, value in settings.items() if value != standard[name]}
	return ", ".join(f"{name} {value:g}" if isinstance(value, (int, float)) else f"{name} {value}" for name, value in differing.items()) or "standard"


class Stopwatch:
	"""Wall and computing time of what it encloses, summed up over its uses."""

	def __init__(self):
		self.wall = self.cpu = 0.0

	def __enter__(self):
		self.start = time.perf_counter(), time.process_time()

	def __exit__(self, *_):
		self.wall += time.perf_counter() - self.start[0]
		self.cpu += time.process_time() - self.start[1]


def rootMeanSquare(answer, reference):
	"""Absolute, for answers that are scaled already."""
	return float(np.sqrt(np.mean((np.array(answer) - reference) ** 2)))


def relativeRootMeanSquare(answer, reference):
	return float(np.sqrt(np.mean((np.array(answer) - reference) ** 2) / np.mean(reference**2)))


def largestRelative(answer, reference):
	return float(np.max(np.abs(np.array(answer) / reference - 1)))


def groundRun(mpm, answer, watch, steps):
	"""Run of a ground that has been marched under a Stopwatch."""
	samples = mpm.skeleton.cost()["bytes"] if hasattr(mpm.skeleton, "cost") else 0
	memory = sum(info["bytes"] for info in mpm.fields()) + samples
	return Run([float(a) for a in answer], watch.wall, watch.cpu, int(memory), mpm.pointCount, steps, mpm.estimatedError)
