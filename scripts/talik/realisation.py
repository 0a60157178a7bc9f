# SPDX-License-Identifier: GPL-2.0-or-later
"""Several realisations of one sample: the same grains placed anew, prepared by as many yades at a time as there are cores.

	samples = talik.rve.prepare(grains=100, realisations=8, seed=1)    # a list; those in the cache are not made again

YADE has one current scene, so that a process prepares one sample at a time. Each realisation is therefore made by a yade of its own,
which runs _onerealisation.py and leaves the sample in the cache.
"""

import json
import os
import shutil
import subprocess
import sys
import tempfile
import time
from pathlib import Path

from talik import ranks

seedStride = 1000  # a preparation tries the seeds that follow its own: realisations must not meet


def seedsOf(seed, realisations):
	"""Seeds of the realisations; the first one is that of a single sample.

	>>> talik.realisation.seedsOf(1, realisations=3)
	[1, 1001, 2001]"""
	return [seed + seedStride * k for k in range(realisations)]


def prepareAll(find, make, calls, told):
	"""Samples of several calls of talik.rve.prepare, a list in their order.

	find   function of a call (dictionary of arguments): the sample in the cache, or None
	make   function of a call: the sample made here
	calls  each with a folder as cache
	told   what is prepared, for the progress

	>>> found = talik.realisation.prepareAll(lambda call: sample, None, [dict(seed=1), dict(seed=1001)], "two samples")"""
	samples = [find(call) for call in calls]
	missing = [k for k, sample in enumerate(samples) if sample is None]
	yade, workers = shutil.which("yade"), min(len(os.sched_getaffinity(0)), len(missing))
	progress = _Progress(len(missing), told)
	if workers > 1 and yade:
		_byProcesses(yade, workers, [calls[k] for k in missing], progress)
	for k in missing:
		samples[k] = find(calls[k])
		if samples[k] is None:  # one processor, or no yade to start
			samples[k] = make(calls[k])
			progress.advance()
	progress.close()
	return samples


def _byProcesses(yade, workers, calls, progress):
	waiting, running = list(calls), []
	try:
		while waiting or running:
			while waiting and len(running) < workers:
				running.append(_Worker(yade, waiting.pop(0)))
			time.sleep(0.05)
			for worker in [worker for worker in running if worker.process.poll() is not None]:
				running.remove(worker)
				worker.check()
				progress.advance()
	finally:
		for worker in running:
			worker.end()


class _Worker:
	"""A yade that prepares one sample."""

	def __init__(self, yade, call):
		environment = {**ranks.alone(os.environ), "OMP_NUM_THREADS": "1", "TALIK_PREPARE": json.dumps(call)}
		environment["PYTHONPATH"] = os.pathsep.join(filter(None, [_moduleFolder(), os.environ.get("PYTHONPATH")]))
		self.call, self.said = call, tempfile.TemporaryFile()
		self.process = subprocess.Popen(
			[yade, "-n", "-j1", "-x", str(Path(__file__).with_name("_onerealisation.py"))],
			env=environment,
			stdin=subprocess.DEVNULL,
			stdout=self.said,
			stderr=self.said,
		)

	def check(self):
		from talik.packing import PackingError

		self.said.seek(0)
		lines = self.said.read().decode(errors="replace").splitlines()
		self.said.close()
		refusals = [line.removeprefix(refusalMark) for line in lines if line.startswith(refusalMark)]
		if refusals:
			raise PackingError(f"realisation with seed {self.call['seed']}: {refusals[0]}")
		if doneMark not in lines:
			raise RuntimeError(
				f"the yade that prepared the realisation with seed {self.call['seed']} ended early: {' / '.join(lines[-3:]) or 'it said nothing'}"
			)

	def end(self):
		self.process.terminate()
		self.process.wait()
		self.said.close()


doneMark, refusalMark = "talik: prepared", "talik: cannot prepare: "


def _moduleFolder():
	"""Where this yade found the compiled module: other builds of it stay out."""
	from talik import _talik

	return str(Path(_talik.__file__).resolve().parents[1])


class _Progress:
	"""A bar on a terminal, lines elsewhere; nothing where nothing is to be made."""

	def __init__(self, number, told, interval=10.0):
		from tqdm import tqdm

		self.number, self.told, self.done, self.interval = number, told, 0, interval
		self.start = self.last = time.monotonic()
		terminal = sys.stderr.isatty()
		self.bar = tqdm(total=number, desc=told, file=sys.stderr, unit="sample") if number > 1 and terminal else None

	def advance(self):
		self.done += 1
		if self.bar is not None:
			self.bar.update()
		elif self.number > 1 and (time.monotonic() - self.last >= self.interval or self.done == self.number):
			self.last = time.monotonic()
			print(f"{self.told}: {self.done} of {self.number} prepared, {self.last - self.start:.0f} s so far", file=sys.stderr, flush=True)

	def close(self):
		if self.bar is not None:
			self.bar.close()
