# SPDX-License-Identifier: GPL-2.0-or-later
"""Times of packed samples against stock YADE's engines, side by side: run by scripts/bench samples, inside the stock yade -j1.

usage  samples.py <result.json> [peers]   peers: only discs and spheres beside stock YADE and LAMMPS

Both sides run in the calling thread; times are CPU times of that thread, except on two threads (wall). Stock YADE is stepped
without O.run's sleeping wait. A ratio is the median of the ratios of neighbours in time."""

import math
import statistics
import sys
import time

from yade import Matrix3, O

import figures
import lammps
import talik
import twins
from figures import Figure, interleaved, medianRatio
from talik_bench import SampleGroup
from twins import Twin, pureShear, seconds

slowRate = 0.01  # [1/s] of pure shear: few changes of contacts
rounds = 9


def nanoseconds(**columns):
	return {f"{name} [ns]": round(statistics.median(column), 2) for name, column in columns.items()}


def pressures(twin):
	"""That both sides did the same work."""
	return dict(zip(("pressure in stock [kPa]", "packed [kPa]"), (round(p, 1) for p in twin.meanPressures())))


def ratioOfSteps(name, twin, stock, packed, more=None, **limits):
	return Figure(
		f"{name}: stock/packed", medianRatio(stock, packed), "x", **limits, terms={**nanoseconds(stock=stock, packed=packed), **(more or {}), **pressures(twin)}
	)


def besideOthers(name, sample, parameters, window, portableFloor=None, **limits):
	"""Beside stock YADE and, where it is installed, LAMMPS."""
	twin, kind = Twin(sample, slowRate, window), name.removesuffix(f", {sample.path}")
	others = [lambda: lammps.nanosecondsPerGrainStep(sample, parameters)] if lammps.program() else []
	stock, packed, portable, *other = interleaved(rounds, twin.stock, twin.fused, twin.fusedPortable, *others)
	contacts = {"contacts per grain": sample.statistics()["coordinationNumber"] / 2}
	yield ratioOfSteps(name, twin, stock, packed, contacts, **limits)
	yield ratioOfSteps(f"{kind}, portable", twin, stock, portable, floor=portableFloor)
	missing = {"LAMMPS": "is not installed (Debian's package lammps)"}
	ratio, terms = (medianRatio(other[0], packed), nanoseconds(LAMMPS=other[0], packed=packed)) if other else (math.nan, missing)
	yield Figure(f"{kind}: LAMMPS/packed", ratio, "x", terms=terms)


def fastSteps(sample):
	"""At the largest strain per step that a slope asks for: neighbour lists live short."""
	twin = Twin(sample, sample.maxStrainPerStep / sample.dt, window=1000)
	stock, packed = interleaved(5, twin.stock, twin.fused)
	yield ratioOfSteps(f"frictional, strain {sample.maxStrainPerStep:g} per step", twin, stock, packed)


def bondedSteps(sample, frictionalSample):
	rate = 0.3
	twin = Twin(twins.strainedUntilBonds(sample, 0.01, rate), rate, window=1000)
	frictionalTwin = Twin(frictionalSample, slowRate, window=1000)
	before = twin.packed.statistics()["bondsIntact"]
	stock, packed, stockFrictional = interleaved(rounds, twin.stock, twin.fused, frictionalTwin.stock)
	bonds = {"bonds": before, "broken in the run": before - twin.packed.statistics()["bondsIntact"]}
	yield ratioOfSteps(f"bonded, bonds breaking, {sample.path}", twin, stock, packed, bonds, floor=25, aim=35)
	yield Figure("bonded packed against frictional stock", medianRatio(stockFrictional, packed), "x", terms=nanoseconds(stock=stockFrictional, packed=packed))


def unbrokenSteps(sample):
	twin = Twin(sample, slowRate, window=1000)
	stock, packed, portable = interleaved(5, twin.stock, twin.fused, twin.fusedPortable)
	yield ratioOfSteps("bonded, no bond breaking", twin, stock, packed)
	yield ratioOfSteps("bonded, no bond breaking, portable", twin, stock, portable)


def bondedSpheres(sample):
	twin = Twin(sample, slowRate, window=500)
	stock, packed, portable = interleaved(5, twin.stock, twin.fused, twin.fusedPortable)
	bonds = {"bonds per grain": sample.statistics()["bondsIntact"] / len(sample.arrays()["radius"])}
	yield ratioOfSteps("spheres, bonded", twin, stock, packed, bonds, floor=25, aim=40)
	yield ratioOfSteps("spheres, bonded, portable", twin, stock, portable)


class StockCalls:
	"""The call of YADE's FEMxDEM coupling: scene from its string, DEM steps, scene to its string; samples in turn."""

	def __init__(self, sample, strain, number=4):
		self.strain, self.steps = strain, int(max(1e5 * strain, 2))
		talik._talik.exchangeScene(sample.open())
		talik.runSerially(2)  # the collider has its pairs
		self.texts, self.calls = [O.sceneToString()] * number, 0

	def __call__(self, run=talik.runSerially):
		k = self.calls % len(self.texts)
		self.calls += 1
		O.stringToScene(self.texts[k])
		O.cell.velGrad = pureShear(self.strain / (self.steps * O.dt))
		run(self.steps)
		O.cell.velGrad = Matrix3.Zero
		self.texts[k] = O.sceneToString()

	def waiting(self):
		"""As published, with O.run's wait: wall time [s]."""
		start = time.perf_counter()
		self(lambda steps: O.run(steps, True))
		return time.perf_counter() - start


def sampleCalls(sample, strain, floor):
	call = StockCalls(sample, strain)
	group = SampleGroup(sample.stateBytes, 1000)  # asked in turn: none is in cache when its turn comes
	packedCalls = lambda tangent: lambda: seconds(lambda: group.apply(pureShear(strain), call.steps, tangent)) / len(group)
	group.apply(pureShear(strain), call.steps)
	stock, packed, withTangent = interleaved(rounds, lambda: seconds(call), packedCalls(False), packedCalls(True))
	microseconds = {
		f"{name} [us]": round(statistics.median(c) * 1e6, 1) for name, c in (("stock", stock), ("packed", packed), ("packed with tangent", withTangent))
	}
	waiting = round(1e6 * statistics.median(call.waiting() for _ in range(3)))
	steps = {"steps of stock": call.steps, "steps of packed": group.apply(pureShear(strain), call.steps) // len(group)}
	yield Figure(
		f"one FEMxDEM call, strain {strain:g}: stock/packed",
		medianRatio(stock, packed),
		"x",
		floor=floor,
		terms={**microseconds, "stock with its 40 ms wait [us]": waiting, **steps},
	)


def twoThreads(sample, kind, number=240, steps=30):
	group = SampleGroup(sample.stateBytes, number)
	motion = pureShear(1e-7 * steps)

	def wall(threads, attempts=20):
		"""Wall time [s] of a run that had its processors for itself, or the shortest of all attempts; and whether it had them."""
		shortest = None
		for _ in range(attempts):
			start, startWork = time.perf_counter(), time.process_time()
			group.apply(motion, steps, threads=threads)
			duration, work = time.perf_counter() - start, time.process_time() - startWork
			if work > 0.98 * threads * duration:
				return duration, True
			shortest = min(duration, shortest or duration)
		return shortest, False

	wall(2)
	one, two = interleaved(rounds, lambda: wall(1), lambda: wall(2))
	(durationOne, aloneOne), (durationTwo, aloneTwo) = zip(*one), zip(*two)
	milliseconds = {f"{name} [ms]": round(1e3 * statistics.median(d), 2) for name, d in (("one", durationOne), ("two", durationTwo))}
	undisturbed = f"{sum(aloneOne) + sum(aloneTwo)} of {2 * rounds}"
	yield Figure(
		f"efficiency of 2 threads, {number} samples, {kind}",
		medianRatio(durationOne, durationTwo) / 2,
		floor=0.95,
		terms={**milliseconds, "runs with the processors to themselves": undisturbed},
	)


def opening(sample, kind):
	latest = [sample.open()]

	def openAnew():
		latest[0] = sample.open()

	opened, repacked = interleaved(rounds, lambda: seconds(openAnew), lambda: seconds(lambda: sample.repack(latest[0])))
	yield Figure(f"opening a sample, {kind}", 1e3 * statistics.median(opened), "ms", ceiling=10)
	yield Figure(f"packing it again, {kind}", 1e3 * statistics.median(repacked), "ms", ceiling=10)


def sizes():
	for grains, make in ((100, lambda: twins.frictional(100)), (1000, lambda: twins.tiled(250, 2)), (4000, lambda: twins.tiled(250, 4))):
		twin = Twin(make(), slowRate, window=max(200, 200_000 // grains))
		stock, packed = interleaved(5, twin.stock, twin.fused)
		yield ratioOfSteps(f"frictional, {grains} grains", twin, stock, packed)


def stockIsFair(sample):
	"""O.run in its background thread against the calling thread, both without waiting asleep."""
	twin = Twin(sample, slowRate, window=2000)

	def background():
		talik._talik.exchangeScene(twin.scene)
		start, last = time.process_time(), O.iter + twin.window
		O.run(twin.window, False)
		while O.iter < last:
			time.sleep(0.002)
		O.wait()
		return time.process_time() - start

	run, direct = interleaved(5, background, lambda: seconds(twin.runStock))
	return f"stock YADE: O.run takes {medianRatio(run, direct):.3f} of the CPU time of the steps in the calling thread that are compared here"


def main(path, only=""):
	frictional, measured = twins.frictional(400), []

	def take(part):
		for figure in part:
			print(f"{figure.name}: {figure.value:.4g} {figure.unit}", flush=True)
			measured.append(figure)

	parametersOf = lambda dimension: talik.rve.prepare(grains=400, ice=False, dimension=dimension).parameters
	take(besideOthers(f"frictional, {frictional.path}", frictional, parametersOf(2), 2000, portableFloor=10, floor=30, aim=40))
	take(besideOthers("spheres, frictional", twins.frictional(400, dimension=3), parametersOf(3), 500, floor=25, aim=40))
	if only:
		return figures.write(path, measured, [stockIsFair(frictional)])
	bonded = twins.bonded(400)
	take(bondedSteps(bonded, frictional))
	take(sampleCalls(frictional, 1e-6, 300))
	take(sampleCalls(frictional, 1e-4, 150))
	take(twoThreads(frictional, "frictional"))
	take(twoThreads(bonded, "bonded"))
	take(opening(frictional, "frictional"))
	take(opening(bonded, "bonded"))
	take(fastSteps(frictional))
	take(unbrokenSteps(bonded))
	take(sizes())
	take(bondedSpheres(twins.bonded(400, dimension=3)))
	figures.write(path, measured, [stockIsFair(frictional)])


main(*sys.argv[1:])
