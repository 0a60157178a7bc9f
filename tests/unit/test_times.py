# SPDX-License-Identifier: GPL-2.0-or-later
"""A test that has grown is seen, on a faster and on a slower machine."""

import subprocess
import sys
from pathlib import Path

import pytest

root = Path(__file__).resolve().parents[2]


@pytest.fixture
def compared(tmp_path):
	"""Runs scripts/test-times.py on times of a run [s], by name, beside those of a tree."""
	tests, build = tmp_path / "tests", tmp_path / "build"
	(build / "test-times").mkdir(parents=True)
	tests.mkdir()
	(tests / "everyday.txt").write_text("# a comment\npace\nfirst\nsecond\n")
	(tests / "times.txt").write_text("# a comment\n  1.00 pace\n 20.00 first\n  2.00 second\n")

	def run(now, *options):
		cases = "".join(f'<testcase name="{name}" status="run"/>' for name in now)
		(build / "report.xml").write_text(f"<testsuite>{cases}</testsuite>")
		for name, seconds in now.items():
			(build / "test-times" / name).write_text(f"{seconds:.2f} 0.00\n")
		command = [sys.executable, root / "scripts" / "test-times.py", build / "report.xml", build, tests, *options]
		return subprocess.run(list(map(str, command)), capture_output=True, text=True)

	run.build, run.tests = build, tests
	return run


@pytest.mark.parametrize("pace", [0.5, 1, 2])
def test_a_test_that_takes_half_as_long_again_is_named_at_any_pace_of_the_machine(pace, compared):
	run = compared({"pace": pace, "first": 30 * pace, "second": 2 * pace})
	assert run.returncode == 0 and f"GROWN: first takes {30 * pace:.1f} s; it took {20 * pace:.1f} s" in run.stdout and "GROWN: second" not in run.stdout
	assert "52 s" not in run.stdout and "33 s" in run.stdout


def test_less_than_a_second_or_a_third_is_no_growth(compared):
	assert "GROWN" not in compared({"pace": 1, "first": 25, "second": 2.9}).stdout


def test_times_of_a_run_are_written_to_one_file_and_into_the_tree_when_asked(compared):
	compared({"pace": 1, "second": 3}, "--record")
	assert (compared.build / "test-times.txt").read_text().splitlines()[1:] == ["    3.00 second", "    1.00 pace"]
	assert (compared.tests / "times.txt").read_text().splitlines()[1:] == ["   20.00 first", "    3.00 second", "    1.00 pace"]


def test_everyday_tests_over_their_ceiling_or_left_out_fail(compared):
	assert compared({"pace": 1, "first": 171, "second": 9}, "--ceiling").returncode == 1
	assert compared({"pace": 2, "first": 170, "second": 9}, "--ceiling").returncode == 0
	left = compared({"pace": 1, "first": 17}, "--ceiling")
	assert left.returncode == 1 and "did not run, or failed: second" in left.stdout
