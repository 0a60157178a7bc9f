# SPDX-License-Identifier: GPL-2.0-or-later
"""Packed samples on a graphics card against the processor: nanoseconds a grain and step of whole calls, as the ground asks them.

usage  card.py <talik_card_bench> <tests/unit/data> <result.json> [<device>] [<samples>,...]
	   card.py <talik_card_bench> --replay <record> <result.json> [<device>] [<points>]

The second form replays what cardreplay.py has recorded of a scene, for any number of points.

Where the bits of card and processor differ nothing is compared. Without a card nothing is measured."""

import json
import subprocess
import sys

import figures
from figures import Figure


def ran(program, *arguments):
	run = subprocess.run([str(program), *map(str, arguments)], capture_output=True, text=True)
	sys.stderr.write(run.stderr)
	if run.returncode not in (0, 1):
		raise SystemExit(f"{program} ended with {run.returncode}")
	return json.loads(run.stdout)


def measured(result):
	"""Figures and notes of what the program printed."""
	if "missing" in result:
		return [], [f"not measured: {result['missing']}"]
	found = []
	for row in result["rows"]:
		name = f"{row['grains']} {row['kind']}, {row['samples']} samples, calls of {row['steps']} steps"
		if not row["same"]:
			found.append(Figure(f"{name}: bits differ, nothing is compared", float("nan"), floor=0))
			continue
		terms = {"one core [ns]": row["core"], "all cores [ns]": row["all"], "lists an update": row["lists"]}
		terms |= {f"of it {part} [ns]": row[part] for part in ("making", "sending", "waiting", "receiving", "taking")}
		found.append(Figure(name, row["device"], "ns a grain and step", terms=terms))
		found.append(Figure(f"{name}: all cores over the card", row["all"] / row["device"], "x"))
	return found, [f"{result['device']} beside {result['threads']} threads; calls are whole ones: gradients go in, stress and tangent come out"]


def replayMeasured(result):
	"""The same of a replay."""
	if "missing" in result:
		return [], [f"not measured: {result['missing']}"]
	row = result["replay"]
	name = f"thaw_slump_bowl for {row['points']} points, {row['ground']} steps of the ground: samples"
	if not row["same"]:
		return [Figure(f"{name}: bits differ, nothing is compared", float("nan"), floor=0)], []
	counted = {"updates": row["updates"], "on the card": row["done"], "ended on the processor": row["ended"], "left to it": row["left"]}
	terms = {"all cores [s]": row["all"], "of it waiting [s]": row["waiting"], **counted}
	found = [Figure(name, row["device"], "s", terms=terms), Figure(f"{name}, all cores over the card", row["all"] / row["device"], "x")]
	return found, [f"{result['device']} beside {result['threads']} threads; requests of a recorded run, replayed for more points"]


def mainOfReplay(program, record, target, device="gpu", points="100000"):
	figures.write(target, *replayMeasured(ran(program, device, points, "--replay", record)))


def main(program, data, target, device="gpu", samples="132,1000,10000"):
	figures.write(target, *measured(ran(program, device, samples, data)))


if __name__ == "__main__":
	if len(sys.argv) < 4:
		sys.exit(__doc__)
	if sys.argv[2] == "--replay":
		mainOfReplay(sys.argv[1], *sys.argv[3:])
	else:
		main(*sys.argv[1:])
