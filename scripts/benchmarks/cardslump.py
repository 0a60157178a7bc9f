# SPDX-License-Identifier: GPL-2.0-or-later
"""Steps of thaw slumps with their samples on a graphics card and on the processor: seconds, share of the samples, bits.

	yade -n -x -j4 scripts/benchmarks/cardslump.py slump.json [--device gpu] [--runs surface:paper:3000 ...]

A run is case:preset:steps after the rest, with the samples asked as the preset asks them; case:preset:steps:all asks every sample in
every step. Where the bits differ nothing is compared."""

import argparse
import hashlib
import importlib
import sys
import tempfile
import time
from dataclasses import replace
from pathlib import Path

from yade import O

scripts = Path(sys.argv[0]).resolve().parents[1]
sys.path[:0] = [str(Path(sys.argv[0]).resolve().parent), str(scripts.parent / "examples")]
import figures
import thawslump
from figures import Figure

defaultRuns = ("base:test:2000", "surface:test:2000", "surface:draft:3000", "surface:paper:3000", "surface:paper:200:all")

restOfAll = 0.05  # [s]; the presets rest for 0.2 to 0.6 s, which takes minutes where every sample is asked in every step


class Slump:
	"""One slump after its rest. device: as RveSkeleton.device; each: every sample is asked in every step."""

	def __init__(self, case, preset, device, each):
		O.reset()
		size = thawslump.presets[preset]
		size = replace(size, restTime=restOfAll) if each else size
		self.slump = thawslump.ThawSlump(importlib.import_module(f"thaw_slump_{case}").case, size, tempfile.mkdtemp())
		skeleton = self.slump.skeleton
		if each:
			skeleton.strainTolerance = skeleton.saturationTolerance = 0
		skeleton.device = device
		self.slump.rest()
		self.mpm = self.slump.mpm
		O.engines = [self.mpm]

	def steps(self, number):
		"""(seconds of so many steps, seconds of the samples in them)."""
		samples, start = self.sampleSeconds(), time.perf_counter()
		O.run(number, True)
		return time.perf_counter() - start, self.sampleSeconds() - samples

	def sampleSeconds(self):
		return sum(seconds for part, seconds in self.mpm.cost().items() if part.startswith("RveSkeleton"))

	def bits(self):
		"""A hash of all fields."""
		digest = hashlib.sha256()
		for name in sorted(self.mpm.fieldNames()):
			digest.update(self.mpm.field(name).tobytes())
		return digest.hexdigest()


def measured(run, device):
	"""Figures of one run on the processor and on the device."""
	case, preset, number, *each = run.split(":")
	found = {}
	for place in ("cpu", device):
		slump = Slump(case, preset, place, bool(each))
		half, before = slump.steps(int(number) // 2), slump.mpm.skeleton.cost().get("onDevice")
		rest = slump.steps(int(number) - int(number) // 2)
		cost = slump.mpm.skeleton.cost()
		if place != "cpu" and not (cost.get("onDevice") and cost["onDevice"] > before):
			raise SystemExit("not measured: the card was lost, or there is none")
		found[place] = (half[0] + rest[0], half[1] + rest[1], slump.bits(), cost)
	(processor, samples, bits, cost), (card, away, same, costThere) = found["cpu"], found[device]
	name = f"{case}, {preset}, {number} steps" + (", every sample in every step" if each else "")
	if bits != same:
		return [Figure(f"{name}: bits differ, nothing is compared", float("nan"), floor=0)]
	terms = {
		"samples [s]": samples,
		"with the card [s]": card,
		"samples with the card [s]": away,
		"updates": cost["calls"],
		"on the card": costThere["onDevice"],
		"ended on the processor": costThere["endedOnProcessor"],
	}
	return [Figure(name, processor, "s", terms=terms), Figure(f"{name}: processor over card", processor / card, "x")]


def main():
	parser = argparse.ArgumentParser(description=__doc__.splitlines()[0])
	parser.add_argument("result", help="JSON file")
	parser.add_argument("--device", default="gpu", choices=("gpu", "twin"), help="beside the processor")
	parser.add_argument("--runs", nargs="+", default=defaultRuns, help="case:preset:steps[:all]")
	options = parser.parse_args()
	found = []
	for run in options.runs:
		found += measured(run, options.device)
		figures.write(options.result, found, [f"{O.numThreads if hasattr(O, 'numThreads') else '?'} threads"])
		print(*(f"{figure.name}: {figure.value:.4g} {figure.unit} {figure.terms or ''}" for figure in found[-2:]), sep="\n", flush=True)


main()
