# SPDX-License-Identifier: GPL-2.0-or-later
"""What the ground of a scene asks its samples, step by step, in a file from which talik_card_bench replays it for any number of points.

	yade -n -x -j4 scripts/benchmarks/cardreplay.py record.bin [--steps 200]

The scene is the hillside of thaw_slump_bowl at its preset `test`, each sample asked as the example asks it."""

import argparse
import base64
import re
import runpy
import struct
import tempfile
from pathlib import Path
from types import SimpleNamespace

import numpy as np
from yade import O

import talik
from talik import solids

restTime = 0.1  # [s], of the 0.4 s of the example


def decoded(text):
	"""Bytes of a text `checksum:length:base64`, as archives have it."""
	_, length, body = text.split(":")
	return base64.b64decode(body + "=" * (-len(body) % 4))[: int(length)]


def states(mpm):
	"""Bytes of the samples behind all points, by id."""
	engines = O.engines
	with tempfile.TemporaryDirectory() as folder:
		file = Path(folder) / "samples.xml"
		O.engines = [mpm.skeleton.sample(int(point)) for point in range(mpm.pointCount)]
		O.save(str(file))
		O.engines = engines
		return [decoded(text) for text in re.findall(r"<saved>([^<]+)</saved>", file.read_text())]


class Record:
	"""Requests of one step after the other. mpm: ground with packed samples behind all points, asked by strain and ice alone."""

	def __init__(self, mpm, path):
		self.mpm, self.asked = mpm, 0
		self.accumulated, self.iceOfSamples = "skeleton0.accumulatedGradient", "skeleton0.sampleIceSaturation"
		self.file = open(path, "wb")
		held = states(mpm)
		if len(held) != mpm.pointCount:
			raise SystemExit(f"{len(held)} samples for {mpm.pointCount} points")
		self.file.write(struct.pack("<Qd", len(held), mpm.skeleton.maxInertialNumber))
		for state in held:
			self.file.write(struct.pack("<Q", len(state)) + state)

	def step(self):
		mpm, size = self.mpm, self.mpm.dimension**2
		one = np.eye(mpm.dimension)
		before, calls = mpm.field(self.accumulated).reshape(-1, mpm.dimension, mpm.dimension).copy(), mpm.skeleton.cost()["calls"]
		iceBefore = mpm.field(self.iceOfSamples).copy()
		O.step()
		after, gradient = mpm.field(self.accumulated).reshape(before.shape), mpm.field("gradient").reshape(before.shape)
		asked = before + gradient @ (one + before)
		changed = (asked != 0).any(axis=(1, 2)) | (mpm.field(self.iceOfSamples) != iceBefore)
		due = np.flatnonzero((after == 0).all(axis=(1, 2)) & changed)
		if len(due) != mpm.skeleton.cost()["calls"] - calls:
			raise SystemExit(f"{len(due)} requests found, {mpm.skeleton.cost()['calls'] - calls} counted")
		ice = mpm.field("iceSaturation")
		self.file.write(struct.pack("<Q", len(due)))
		for point in due:
			self.file.write(struct.pack(f"<Q{size + 1}d", point, *asked[point].ravel(), ice[point]))
		self.asked += len(due)


def bowl():
	"""The hillside of the example at rest, at the beginning of its thaw."""
	path = Path(__file__).resolve().parents[2] / "examples" / "thaw_slump_bowl.py"
	example = SimpleNamespace(**runpy.run_path(str(path), init_globals=dict(globals())))
	hill = solids.terrain(solids.readHeights(path.parent / "thawbowl" / "hillside.asc"), base=0.0)
	mpm, _ = example.build(example.presets["test"], "samples", hill)
	mpm.setDay(-1)
	talik.runUntil(restTime)
	mpm.damping, mpm.heat.thermalTimeScale = example.damping, example.thermalTimeScale
	mpm.setDay(0)
	return mpm


def main():
	parser = argparse.ArgumentParser(description=__doc__.splitlines()[0])
	parser.add_argument("record", help="file to write")
	parser.add_argument("--steps", type=int, default=200, help="of the ground")
	options = parser.parse_args()
	mpm = bowl()
	record = Record(mpm, options.record)
	for _ in range(options.steps):
		record.step()
	record.file.close()
	print(f"{record.asked} requests of {mpm.pointCount} points in {options.steps} steps")


if __name__ == "__main__":
	main()
