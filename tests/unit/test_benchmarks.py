# SPDX-License-Identifier: GPL-2.0-or-later
"""A benchmark that misses its limit must be seen to miss it."""

import json
import subprocess
import sys
from pathlib import Path

import pytest

benchmarks = Path(__file__).resolve().parents[2] / "scripts" / "benchmarks"
sys.path.insert(0, str(benchmarks))

import card
import figures
import kernels
import watch
from figures import Figure


@pytest.fixture
def build(tmp_path):
	(tmp_path / "CMakeCache.txt").write_text("CMAKE_CXX_COMPILER:FILEPATH=/usr/bin/c++\nCMAKE_BUILD_TYPE:STRING=Release\n")
	return tmp_path


def report(build, *measured):
	figures.write(build / "part.json", measured, ["a note"])
	command = [sys.executable, benchmarks / "report.py", "Title", build, build / "result.json", build / "part.json"]
	return subprocess.run(list(map(str, command)), capture_output=True, text=True)


def test_figure_below_its_floor_or_above_its_ceiling_is_named_and_fails(build):
	run = report(build, Figure("slow", 29.9, "x", floor=30), Figure("large", 31.0, "kB", ceiling=30), Figure("fine", 40.0, "x", floor=30))
	assert run.returncode == 1
	assert run.stderr.splitlines() == ["MISSED: slow: 29.9 x, to reach >= 30", "MISSED: large: 31 kB, to reach <= 30"]
	assert [f["reached"] for f in json.loads((build / "result.json").read_text())["figures"]] == [False, False, True]


def test_figures_within_their_limits_and_missed_aims_do_not_fail(build):
	run = report(build, Figure("ratio", 30.0, "x", floor=30, aim=40, terms={"stock [ns]": 240.0}), Figure("free", 1.0))
	assert run.returncode == 0 and run.stderr == ""
	machine = json.loads((build / "result.json").read_text())["machine"]
	assert machine["CPU"] and machine["machine"] and "Release" in machine["compiler"]
	for said in ("Title", "30 x", ">= 30", "stock [ns] 240", "- a note"):
		assert said in run.stdout


def test_a_figure_that_is_not_a_number_is_missed():
	assert not Figure("nothing", float("nan"), floor=1).reached and not Figure("nothing", float("nan"), ceiling=1).reached


def test_ratios_are_taken_between_neighbours_in_time():
	"""A machine that becomes twice as slow half-way changes no ratio."""
	above, below = figures.interleaved(6, iter([30, 60, 30, 60, 30, 60]).__next__, iter([1, 2, 1, 2, 1, 2]).__next__)
	assert figures.medianRatio(above, below) == 30


def test_kernels_that_take_two_per_cent_more_time_than_those_of_a_revision_or_give_other_bits_are_missed_kind_by_kind(tmp_path):
	"""The program that compares two versions is played by one that prints its rows."""
	values = (("discs", 1.019, 1e5), ("frozen discs", 1.021, 1e5), ("spheres", 1.0, 1e5 + 1e-10))
	rows = [dict(kind=kind, steps=400, ratio=ratio, quartiles=[0.99, 1.04], pressure=[1e5, pressure]) for kind, ratio, pressure in values]
	compare = tmp_path / "compare"
	compare.write_text(f"#!/bin/sh\ncat <<'END'\n{json.dumps(rows)}\nEND\n")
	compare.chmod(0o755)
	found = list(kernels.measured(compare, tmp_path, counted=False))
	print("\n".join(figures.table(found)))
	assert [figure.reached for figure in found] == [True, True, False, True, True, False]


def test_a_card_is_compared_where_the_bits_agree_and_only_there(tmp_path):
	"""The program that measures is played by one that prints its rows."""
	parts = dict(making=0.01, sending=0.01, waiting=0.02, receiving=0.0, taking=0.01, lists=0.1)
	row = dict(kind="discs", samples=132, grains=200, steps=40, core=5.0, all=2.5, device=0.05, **parts)
	program = tmp_path / "bench"
	program.write_text(f"#!/bin/sh\ncat <<'END'\n{json.dumps(dict(device='a card', threads=2, rows=[dict(row, same=True), dict(row, same=False)]))}\nEND\n")
	program.chmod(0o755)
	found, notes = card.measured(card.ran(program, tmp_path))
	print("\n".join(figures.table(found)))
	assert [figure.reached for figure in found] == [True, True, False] and found[1].value == pytest.approx(50) and "a card" in notes[0]


def test_a_replay_is_compared_where_the_bits_agree_and_only_there():
	row = dict(points=100000, ground=200, updates=215600, steps=2600000, all=12.0, device=1.5, done=215600, ended=0, left=0, waiting=0.5)
	for same in (True, False):
		found, _ = card.replayMeasured(dict(device="a card", threads=2, replay=dict(row, same=same)))
		print("\n".join(figures.table(found)))
		assert [figure.reached for figure in found] == ([True, True] if same else [False])
	assert card.replayMeasured({"missing": "no driver"}) == ([], ["not measured: no driver"])


def test_without_a_card_nothing_is_measured_and_that_is_said(build):
	found, notes = card.measured({"missing": "There is no driver of NVIDIA's here."})
	figures.write(build / "part.json", found, notes)
	command = [sys.executable, benchmarks / "report.py", "Title", build, build / "result.json", build / "part.json"]
	run = subprocess.run(list(map(str, command)), capture_output=True, text=True)
	print(notes)
	assert found == [] and run.returncode == 0 and "not measured: There is no driver" in run.stdout


def test_a_watch_marks_what_takes_a_twentieth_more_than_in_the_last_line_of_the_same_machine(tmp_path, capsys):
	result, table = tmp_path / "result.json", tmp_path / "watch.csv"

	def run(commit, machine, packed, implicit):
		rows = {
			"frictional, avx2: stock/packed": packed,
			"frictional, portable: stock/packed": 1.0,
			"level ground, implicit pressure": implicit,
			"level ground": 400.0,
		}
		result.write_text(json.dumps(dict(machine={"CPU": machine}, figures=[dict(name=name, value=value) for name, value in rows.items()])))
		status = watch.main(table, commit, result)
		return status, capsys.readouterr().out

	status, said = run("a", "one", 50.0, 1200.0)
	assert status == 0 and "0.02  discs over stock YADE" in said and "3  implicit over explicit pressure" in said
	assert run("b", "another", 10.0, 2000.0)[0] == 0
	status, said = run("c", "one", 48.0, 1300.0)
	red = [line for line in said.splitlines() if line.startswith("\033[31m")]
	print(red)
	assert status == 1 and len(red) == 1 and "implicit over explicit pressure" in red[0]
	assert len(table.read_text().splitlines()) == 4
