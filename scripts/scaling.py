#!/usr/bin/python3
# SPDX-License-Identifier: GPL-2.0-or-later
"""Ranks and a network, simulated: a recorded run is replayed on any number of ranks.

	/usr/bin/python3 scripts/scaling.py FOLDER

FOLDER holds recorded runs of one rank (record-samples.npz, record-space.npz) and ranks-measured.json, both of scripts/benchmarks/ranks.py. The
replay of the recorded ground on 1, 2 and 4 ranks is compared with what those took; then copies of it, each begun at another step, make up
grounds of 1e5 and 1e7 points. Prints tables and draws scaling.png and scaling_measured.png in FOLDER. pkg/ranks/README.md tells the model."""

import json
import sys
from dataclasses import dataclass, replace
from pathlib import Path

import matplotlib

matplotlib.use("Agg")
import numpy as np
from matplotlib import pyplot
from scipy.optimize import nnls

dealInterval, keptCost, enough = 32, 0.5, 1.02  # of samples that are dealt to ranks by their cost, as Talik did in 0.1
meetingBytes, compareInterval = 128, 100
answerBytes = {2: 192, 3: 752}  # of an answer, with its tangent
pointBytes = 600  # of the arrays of a point, which every rank holds


@dataclass
class Network:
	"""Between machines of `perMachine` ranks; within one ranks talk by memory."""

	name: str
	latency: float  # [s]
	bandwidth: float  # of a machine, each way [B/s]
	perMachine: int = 64
	localLatency: float = 1.5e-6  # measured between two ranks of one machine
	localBandwidth: float = 6e9  # of a rank that copies [B/s]

	def allGather(self, totalBytes, ranks):
		"""Seconds until each rank has all parts, eq. (16.2): doubling steps among machines, then among the ranks of one."""
		machines, local = -(-ranks // self.perMachine), min(ranks, self.perMachine)
		seconds = np.ceil(np.log2(local)) * self.localLatency + totalBytes * (local - 1) / local / self.localBandwidth
		if machines > 1:
			seconds += np.ceil(np.log2(machines)) * self.latency + totalBytes * (machines - 1) / machines / self.bandwidth
		return seconds


# latency and bandwidth of the two networks are those of data sheets, not measured
networks = [Network("25 GbE", 25e-6, 2.9e9), Network("InfiniBand", 1.5e-6, 12e9)]
here = Network("this machine", 1.5e-6, 6e9)


class Record:
	"""What one rank took for each step [s], and the DEM steps of each sample in it."""

	def __init__(self, file):
		with np.load(file) as data:
			self.seconds, self.taken, self.dimension = data["seconds"], data["taken"], int(data["dimension"])
		self.steps, self.points = self.taken.shape
		calls, demSteps = (self.taken > 0).sum(1), self.taken.sum(1)
		(self.ground, self.call, self.demStep), residual = nnls(np.stack([np.ones(self.steps), calls, demSteps], axis=1).astype(float), self.seconds)
		self.deviation = residual / np.sqrt(self.steps) / self.seconds.mean()
		self.callsOfStep, self.demStepsOfStep = calls, demSteps

	def cost(self, demSteps):
		"""Of calls that take so many DEM steps [s]; 0 where there is no call."""
		return np.where(demSteps > 0, self.call + self.demStep * demSteps, 0.0)

	@property
	def inSamples(self):
		return self.cost(self.taken).sum() / (self.cost(self.taken).sum() + self.steps * self.ground)


# --- dealing ---------------------------------------------------------------------------------------------------------------


def dealtAgain(cost, owner, ranks):
	"""As in SampleStore.cpp: from the rank with most cost to that with least, until the largest is within 2 % of the mean."""
	owner, load = owner.copy(), np.bincount(owner, cost, ranks)
	for _ in range(len(cost)):
		most, least = load.argmax(), load.argmin()
		gap = load[most] - load[least]
		if load[most] <= enough * load.mean():
			break
		may = np.flatnonzero((owner == most) & (cost > 0) & (cost < gap))
		if not len(may):
			break
		best = may[np.abs(gap - 2 * cost[may]).argmin()]
		load[most] -= cost[best]
		load[least] += cost[best]
		owner[best] = least
	return owner


def dealtInTurn(count, ranks):
	"""The same aim for very many samples, given by falling cost: to the ranks in turn, there and back."""
	turn = np.arange(count, dtype=np.int32) % (2 * ranks)
	return np.where(turn < ranks, turn, 2 * ranks - 1 - turn)


# --- replay ----------------------------------------------------------------------------------------------------------------


@dataclass
class Loads:
	"""Of a ground on some ranks, step by step."""

	ranks: int
	ground: float  # of one rank that computes all of it [s]
	calls: np.ndarray  # of all ranks
	samples: np.ndarray  # cost of these calls [s]
	largest: np.ndarray  # the part of the rank with most of it [s]
	work: np.ndarray  # of each rank in samples, summed over the steps [s]


def recordedLoads(record, ranks):
	"""The recorded ground, dealt to ranks and dealt again, as Talik did in 0.1."""
	owner, sinceDeal, updates = np.arange(record.points) % ranks, np.zeros(record.points), 0
	loads = []
	for demSteps in record.taken:
		loads.append(np.bincount(owner, record.cost(demSteps), ranks))
		sinceDeal += demSteps
		updates += demSteps.any()
		if ranks > 1 and demSteps.any() and updates % dealInterval == 0:
			owner = dealtAgain(sinceDeal, owner, ranks)
			sinceDeal *= keptCost
	loads = np.array(loads)
	return Loads(ranks, record.ground, record.callsOfStep, loads.sum(1), loads.max(1), loads.sum(0))


def copiedLoads(record, rankCounts, points, groundOfPoint, steps):
	"""{ranks: Loads} of so many points: copies of the recorded ground, each begun at another step, dealt by their cost in the whole record."""
	copies = max(1, round(points / record.points))
	begin = np.repeat(np.random.default_rng(1).integers(record.steps, size=copies).astype(np.int32), record.points)
	column = np.tile(np.arange(record.points, dtype=np.int32), copies)
	order = np.argsort(-record.cost(record.taken).sum(0)[column], kind="stable")
	begin, column = begin[order], column[order]
	found = {ranks: [] for ranks in rankCounts}
	calls, samples = [], []
	for step in range(steps):
		demSteps = record.taken[(step + begin) % record.steps, column]
		cost = record.cost(demSteps)
		calls.append(int(np.count_nonzero(demSteps)))
		samples.append(cost.sum())
		for ranks in rankCounts:
			found[ranks].append(np.bincount(dealtInTurn(len(cost), ranks), cost, ranks))
	ground = groundOfPoint * copies * record.points
	return {ranks: Loads(ranks, ground, np.array(calls), np.array(samples), np.max(loads, axis=1), np.sum(loads, axis=0)) for ranks, loads in found.items()}


class Replay:
	"""Eq. (16.1): time of loads on ranks and a network, summed over the steps [s]."""

	def __init__(self, loads, network, dimension, threads=1, inBands=False):
		"""threads: of each rank, assumed to work without loss. inBands: as if the ground were cut into bands of equal cost, each of whose ranks
		owns the samples of its points; halos cost nothing here."""
		ranks, steps = loads.ranks, len(loads.calls)
		self.ranks, self.cores = ranks, ranks * threads
		self.alone = steps * loads.ground + loads.samples.sum()
		self.ground = steps * loads.ground / threads / (ranks if inBands else 1)
		self.samples = loads.samples.sum() / self.cores
		self.waiting = loads.largest.sum() / threads - self.samples  # for the rank with most to do in a step
		self.busiest = self.ground + loads.work.max()  # over all steps
		self.messages, self.bytes = 0.0, 0.0  # sent by a rank, once for each that receives them
		if ranks > 1 and not inBands:
			updates = loads.calls > 0
			answers = loads.calls[updates] * answerBytes[dimension] + 8 * ranks
			meetings = updates.sum() + steps / compareInterval
			self.messages = meetings * network.allGather(meetingBytes * ranks, ranks) + network.allGather(answers, ranks).sum()
			self.bytes = (meetings * meetingBytes + answers.sum() / ranks) * (ranks - 1)
		self.seconds = self.ground + self.samples + self.waiting + self.messages
		self.balance = loads.samples.sum() / ranks / loads.largest.sum()
		self.efficiency = self.alone / self.seconds / self.cores

	@property
	def mostLost(self):
		"""What takes most of the time that is not spent in samples."""
		if self.cores == 1:
			return ""
		parts = {
			"the ground, which every rank computes": self.ground * (1 - 1 / self.ranks) if self.ranks > 1 else 0,
			"answers on the network": self.messages,
			"balance within a step": self.waiting,
		}
		most = max(parts, key=parts.get)
		return f"{most}: {parts[most] / self.seconds:.0%} of the time"


# --- against measured runs ---------------------------------------------------------------------------------------------------


def compared(records, measured):
	"""Rows: scene, ranks, work of the busiest rank per step measured and replayed [ms], balance and kB a step of both."""
	rows = []
	for its in measured:
		if its["scene"] not in records or its["threads"] != 1:
			continue
		record = records[its["scene"]]
		run = Replay(recordedLoads(record, its["ranks"]), here, record.dimension)
		rows.append(
			{
				"scene": its["scene"],
				"ranks": its["ranks"],
				"work": (1e3 * its["work"] / its["timed"], 1e3 * run.busiest / record.steps),
				"balance": (its["balance"], run.balance),
				"bytes": (its["bytes"] / its["timed"] / 1e3, run.bytes / record.steps / 1e3),
			}
		)
	return rows


def printComparison(rows):
	print("\nReplayed and measured: work of the busiest rank, which does not depend on what else the machine does")
	print(f"{'scene':<9}{'ranks':>6}{'measured [ms/step]':>20}{'replayed':>10}{'off':>8}{'balance':>16}{'kB a step':>18}")
	for row in rows:
		work, balance, sent = row["work"], row["balance"], row["bytes"]
		off = work[1] / work[0] - 1
		print(
			f"{row['scene']:<9}{row['ranks']:>6}{work[0]:>20.3f}{work[1]:>10.3f}{off:>+8.0%}{balance[0]:>8.2f} {balance[1]:>7.2f}{sent[0]:>9.1f} {sent[1]:>8.1f}"
		)
	worst = max(abs(row["work"][1] / row["work"][0] - 1) for row in rows)
	print(f"largest deviation {worst:.0%} (10 % is asked)")
	return worst


# --- far beyond ------------------------------------------------------------------------------------------------------------

rankCounts = [1, 2, 4, 8, 16, 32, 64, 128, 256, 512, 1024, 2048, 4096]
sizes = {1e5: 40, 1e7: 8}  # points and steps that are replayed
manyThreads = 64  # of a rank that has a machine for itself
inThreads, inBands = f"one rank of {manyThreads} threads a machine, 25 GbE", "ground in bands"


def study(record, groundOfPoint):
	"""{(points, network or what if): replays by number of ranks}"""
	found = {}
	for points, steps in sizes.items():
		loads = copiedLoads(record, rankCounts, points, groundOfPoint, steps)
		for network in networks:
			found[points, network.name] = [Replay(own, network, record.dimension) for own in loads.values()]
		found[points, inThreads] = [
			Replay(loads[ranks], replace(networks[0], perMachine=1), record.dimension, manyThreads)
			for ranks in rankCounts
			if ranks * manyThreads <= rankCounts[-1]
		]
		found[points, inBands] = [Replay(own, networks[0], record.dimension, inBands=True) for own in loads.values()]
	return found


def printStudy(found, name):
	for (points, network), runs in found.items():
		memory = f"; the ground takes {points * pointBytes / 1e9:.2g} GB on each rank" if network != inBands else ""
		print(f"\n{name}, {points:.0e} points, {network}{memory}")
		print(f"{'cores':>6}{'efficiency':>12}{'faster':>9}{'ms/step':>10}  lost most to")
		for run in runs[::2]:
			print(f"{run.cores:>6}{run.efficiency:>12.3f}{run.efficiency * run.cores:>9.1f}{1e3 * run.seconds / sizes[points]:>10.3g}  {run.mostLost}")


def drawStudies(studies, file):
	"""studies: {kind of samples: what study() found}"""
	figure, grid = pyplot.subplots(len(studies), 2, figsize=(9, 0.5 + 2.8 * len(studies)), layout="constrained", sharex=True, sharey=True)
	styles = {**{network.name: style for network, style in zip(networks, ("C0o-", "C1s--"))}, inThreads: "C3d-.", inBands: "C2^:"}
	labels = {network.name: f"a rank on each core, {network.name}" for network in networks}
	for panels, (name, found) in zip(grid, studies.items()):
		for axes, points in zip(panels, sizes):
			for network, style in styles.items():
				runs = found[points, network]
				axes.plot([run.cores for run in runs], [run.efficiency for run in runs], style, markersize=4, label=labels.get(network, network))
			axes.set(xscale="log", yscale="log", ylim=(1e-3, 1.3), title=f"$10^{{{round(np.log10(points))}}}$ points with {name}")
			axes.grid(alpha=0.3)
		panels[0].set_ylabel("efficiency, simulated")
	for axes in grid[-1]:
		axes.set_xlabel("cores")
	grid[0][0].legend(loc="lower left", fontsize="small")
	figure.savefig(file, dpi=110)
	pyplot.close(figure)


def drawMeasured(measured, rows, file):
	figure, (left, right) = pyplot.subplots(1, 2, figsize=(9, 3.6), layout="constrained")
	names = {"samples": "Case I, samples of discs", "space": "slope in space, spheres", "law": "Case I, a law"}
	for k, (scene, label) in enumerate(names.items()):
		own = sorted((its for its in measured if its["scene"] == scene and its["threads"] == 1), key=lambda its: its["ranks"])
		left.plot([its["ranks"] for its in own], [own[0]["work"] / its["work"] / its["ranks"] for its in own], f"C{k}o-", label=label)
		of = [row for row in rows if row["scene"] == scene]
		if of:
			alone = of[0]["work"][1]
			left.plot([row["ranks"] for row in of], [alone / row["work"][1] / row["ranks"] for row in of], f"C{k}x:", label="  replayed")
	left.set(xlabel="ranks", ylabel="strong efficiency by work", ylim=(0, 1.05), xticks=[1, 2, 4])
	left.legend()
	width = 0.35
	at = np.arange(len(rows))
	right.bar(at - width / 2, [row["work"][0] for row in rows], width, label="measured")
	right.bar(at + width / 2, [row["work"][1] for row in rows], width, label="replayed")
	right.set_xticks(at, [f"{row['scene']}\n{row['ranks']}" for row in rows])
	right.set(ylabel="work of the busiest rank [ms a step]", xlabel="scene and ranks")
	right.legend()
	figure.savefig(file, dpi=110)
	pyplot.close(figure)


def main(folder):
	folder = Path(folder)
	records = {name: Record(folder / f"record-{name}.npz") for name in ("samples", "space")}
	measured = json.loads((folder / "ranks-measured.json").read_text())
	laws = {name: next(its for its in measured if its["scene"] == law) for name, law in (("samples", "law"), ("space", "spaceLaw"))}
	groundOfPoint = {name: its["work"] / its["timed"] / its["points"] for name, its in laws.items()}
	for name, record in records.items():
		print(
			f"{name}: {record.points} points, {record.steps} steps of {1e3 * record.seconds.mean():.2f} ms, {record.callsOfStep.mean():.0f} calls and "
			f"{record.demStepsOfStep.mean():.0f} DEM steps in each. Fitted within {record.deviation:.0%}: ground {1e3 * record.ground:.2f} ms, a call "
			f"{1e6 * record.call:.1f} us, a DEM step {1e6 * record.demStep:.2f} us; {record.inSamples:.0%} of the time in samples."
		)
		print(f"  ground of {laws[name]['points']} points with a law: {1e9 * groundOfPoint[name]:.0f} ns a point and step")
	rows = compared(records, measured)
	printComparison(rows)
	drawMeasured(measured, rows, folder / "scaling_measured.png")
	kinds = {"samples": "samples of 100 discs", "space": "samples of 100 spheres"}
	studies = {title: study(records[name], groundOfPoint[name]) for name, title in kinds.items()}
	for title, found in studies.items():
		printStudy(found, title)
	drawStudies(studies, folder / "scaling.png")
	print(f"\ndrawn: {folder}/scaling.png and scaling_measured.png")


if __name__ == "__main__":
	if len(sys.argv) != 2:
		sys.exit(__doc__)
	main(sys.argv[1])
