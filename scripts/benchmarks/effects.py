#!/usr/bin/python3
# SPDX-License-Identifier: GPL-2.0-or-later
"""Cost of the effects of the ground from what Google Benchmark measured.

usage  effects.py <result.json> <agreement.json> <times.json>...
	   effects.py --space <result.json> <times.json>..."""

import json
import pathlib
import statistics
import sys
from collections import defaultdict

import figures
from figures import Figure

# effect, the combination that has it, the same without it
shares = (
	("Mohr-Coulomb instead of elastic", "dry, Mohr-Coulomb", "dry"),
	("stable step looked up every 10 steps", "dry, stable step looked up", "dry"),
	("cell averages", "dry, cell averages", "dry"),
	("deformation record", "dry, deformation record", "dry"),
	("energy ledger", "dry, energy ledger", "dry"),
	("heat, in ground at rest", "rigid: heat", None),
	("freezing, in ground at rest", "rigid: heat, freezing", "rigid: heat"),
	("heat", "dry, heat", "dry"),
	("freezing", "dry, heat, freezing", "dry, heat"),
	("thaw front, across the middle of the ground", "dry, heat, freezing, Mohr-Coulomb, thaw front", "dry, heat, freezing, Mohr-Coulomb"),
	("water", "water", "dry, cell averages"),
	("heat, with water", "water, heat", "water"),
	("freezing, with water", "water, heat, freezing", "water, heat"),
	("implicit pressure, K_w of water", "water, heat, freezing, implicit pressure", "water, heat, freezing"),
	("implicit pressure, level ground, one point a cell", "level ground, implicit pressure", "level ground"),
	("ice segregation", "water, heat, freezing, ice segregation", "water, heat, freezing"),
	("thaw settlement under load", "water, heat, freezing, thaw settlement", "water, heat, freezing"),
	("free surface, heated and drained", "water, heat, freezing, surface", "water, heat, freezing"),
	("Mohr-Coulomb, record, ledger, stable step", "everything", "water, heat, freezing, surface"),
)
threaded = ("dry", "dry, cell averages", "water, heat, freezing", "everything")
aims = {"dry": 30, "everything": 65}
aimsInSpace = {"dry": 90, "everything": 500}


phases = ("to grid", "nodes", "to points", "strain, pressure", "law")


def read(paths):
	"""Median ns per point and step by name, CPU time of the main thread; by (name, part) for parts of it and "median step", wall time."""
	times = defaultdict(list)
	for path in paths:
		for run in json.load(open(path))["benchmarks"]:
			name = run["run_name"].split("/iterations:")[0].removeprefix("effects/").removeprefix("space/")
			times[name].append(run["cpu_time"] / run["points"])
			for part in (*phases, "median step"):
				if part in run:
					times[name, part].append(run[part])
	return {name: statistics.median(values) for name, values in times.items()}


def minimum(times, law):
	"""The fastest of the minimal codes that the processor can run."""
	return min((time, name) for name, time in times.items() if name[:7] == "minimum" and ("Mohr" in name) == bool(law))


def overMinimum(times, rounds):
	for name, law in (("dry", ""), ("dry, Mohr-Coulomb", ", Mohr-Coulomb")):
		least, code = minimum(times, law)
		engine = name + "/1 thread"
		terms = {"engine [ns]": round(times[engine], 1), f"{code} [ns]": round(least, 1)}
		yield Figure(f"{name}: engine/minimum", ratio(rounds, engine, code), "x", ceiling=1.5, terms=terms)


def speedUps(times, rounds):
	for name in threaded:
		one, two = ((name + threads, "median step") for threads in ("/1 thread", "/2 threads"))
		terms = {"one [ns]": round(times[one], 1), "two [ns]": round(times[two], 1)}
		yield Figure(f"{name}: 2 threads against 1", ratio(rounds, one, two), "x", floor=1.75, terms=terms)


def ratio(rounds, above, below):
	"""Median of the ratios of each round: the speed of the machine at that moment drops out."""
	return statistics.median(times[above] / times[below] for times in rounds)


def combinations(times, aims=aims):
	for name, time in times.items():
		if not isinstance(name, str) or name.endswith("/2 threads"):
			continue
		spent = {phase: round(times[name, phase], 1) for phase in phases if times.get((name, phase), 0) > 0.05}
		name = name.removesuffix("/1 thread")
		yield Figure(name, time, "ns", aim=aims.get(name), terms=spent)


def effectShares(times):
	everything = times["everything/1 thread"]
	for effect, having, lacking in shares:
		cost = times[having + "/1 thread"] - (times[lacking + "/1 thread"] if lacking else 0.0)
		yield Figure(f"share: {effect}", cost, "ns", terms={"of everything": f"{100 * cost / everything:.0f} %"})


def switchedOff(folder):
	"""Dry ground whose effects are switched off against ground that was built without them: neighbours in time."""
	off, never = ([next(iter(read([path]).values())) for path in sorted(folder.glob(f"{name}-*.json"))] for name in ("off", "never"))
	terms = {"switched off [ns]": round(statistics.median(off), 1), "never had it [ns]": round(statistics.median(never), 1)}
	yield Figure("dry: effects switched off/never built in", figures.medianRatio(off, never), "x", ceiling=1.03, terms=terms)


def agreements(path):
	for run in json.load(open(path))["benchmarks"]:
		law = ", Mohr-Coulomb" if "Mohr" in run["run_name"] else ""
		difference = abs(run["engine"] - run["minimum"]) / abs(run["minimum"])
		yield Figure(f"dry{law}: settlement, engine against minimum", difference, "relative", ceiling=1e-9, terms={"settlement [m]": run["minimum"]})


def main(target, agreementPath, *timesPaths):
	times, rounds = read(timesPaths), [read([path]) for path in timesPaths]
	measured = [
		*overMinimum(times, rounds),
		*switchedOff(pathlib.Path(target).parent),
		*agreements(agreementPath),
		*speedUps(times, rounds),
		*combinations(times),
		*effectShares(times),
	]
	notes = [
		"ns per point and step: 40 000 points, quadratic B-splines, double precision, one thread (CPU time of it).",
		"The minimum has the same transfer, law and floor and nothing else: no checks, no sorting, no energies, no strips for threads.",
	]
	figures.write(target, measured, notes)


def mainInSpace(target, *timesPaths):
	times = read(timesPaths)
	notes = ["ns per point and step in space: 51 840 points, eight in a cell, quadratic B-splines (27 nodes), double precision, one thread (CPU time of it)."]
	figures.write(target, [*combinations(times, aimsInSpace), *effectShares(times)], notes)


if __name__ == "__main__":
	if sys.argv[1:2] == ["--space"] and len(sys.argv) > 3:
		mainInSpace(*sys.argv[2:])
		sys.exit()
	if len(sys.argv) < 4:
		sys.exit(__doc__)
	main(*sys.argv[1:])
