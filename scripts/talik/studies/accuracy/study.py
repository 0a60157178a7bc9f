# SPDX-License-Identifier: GPL-2.0-or-later
"""Runs of a study and the file they are kept in: a study that was stopped goes on where it was."""

import dataclasses
import json
import math
import time
from pathlib import Path
from statistics import median

import numpy as np
from tqdm import tqdm

import talik
from talik.studies.accuracy.presets import presetRows
from talik.studies.accuracy.problem import key, varied
from talik.files import writeWhole

repeats = 5  # of a run, as long as they take less than this altogether:
patience = {True: 3.0, False: 20.0}  # [s], in a quick study and in a full one


class Results:
	"""Rows of a study by key; every new row is on the disk before the next run begins."""

	def __init__(self, file):
		self.file = Path(file)
		self.rows = json.loads(self.file.read_text()) if self.file.exists() else {}

	def __contains__(self, name):
		"""What failed is tried again."""
		return name in self.rows and "failure" not in self.rows[name]

	def add(self, name, row):
		self.rows[name] = row
		writeWhole(self.file, json.dumps(self.rows, indent="\t"))


def measure(problem, settings, quick=False):
	"""One row: the answer of a run, medians of its times; what failed says why."""
	row = {"problem": problem.name, "settings": settings}
	runs, start = [], time.monotonic()
	try:
		while not runs or (len(runs) < repeats and time.monotonic() - start < patience[quick]):
			with talik.scratchScene():
				runs.append(problem.run(settings))
	except (RuntimeError, ValueError) as failure:
		return {**row, "failure": str(failure)}
	row.update(dataclasses.asdict(runs[0]))
	row.update(wall=median(r.wall for r in runs), cpu=median(r.cpu for r in runs), repeats=len(runs))
	if not np.all(np.isfinite(row["answer"])):
		row["failure"] = "the answer is not finite"
	return row


def runStudy(problems, results, quick=False, progress=True):
	"""Runs what is planned and not there yet."""
	presets = presetRows(quick)
	planned = [
		(problem, settings)
		for problem in problems
		for settings in problem.plan(quick, [row.settings for row in presets if row.problem == problem.name])
		if key(problem.name, settings) not in results
	]
	bar = tqdm(planned, disable=not progress, unit="run")
	for problem, settings in bar:
		bar.set_postfix_str(f"{problem.name}: {varied(settings, problem.standard)}")
		results.add(key(problem.name, settings), measure(problem, settings, quick))


def table(problem, results, quick=False):
	"""Rows of a problem that are there, with their errors, in the order of the plan."""
	reference = problem.referenceAnswer(results.rows, quick)
	own = problem.exact is None and key(problem.name, problem.referenceSettings(quick))
	presets = presetRows(quick)
	lines = []
	for settings in problem.plan(quick, [row.settings for row in presets if row.problem == problem.name]):
		row = results.rows.get(key(problem.name, settings))
		if row is None or key(problem.name, settings) == own:
			continue
		knobs = [name for name, value in settings.items() if value != problem.standard[name]]
		usable = not row.get("failure") and reference is not None
		names = [f"{r.example} {r.preset}" for r in presets if r.problem == problem.name and {**problem.standard, **r.settings} == settings]
		lines.append(
			{
				"problem": problem.name,
				"varied": varied(settings, problem.standard),
				"knob": "pair" if len(knobs) > 1 else knobs[0] if knobs else "standard",
				"error [-]": problem.error(row["answer"], reference) if usable else math.nan,
				"wall time [s]": row.get("wall", math.nan),
				"CPU time [s]": row.get("cpu", math.nan),
				"memory [MB]": row.get("memory", math.nan) / 1e6,
				"points": row.get("points"),
				"steps": row.get("steps"),
				"runs": row.get("repeats"),
				"presets": "; ".join(names),
				"failure": row.get("failure", ""),
			}
		)
	return lines
