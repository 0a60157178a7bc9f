# SPDX-License-Identifier: GPL-2.0-or-later
"""Convergence of the thaw slumps: scripts/accuracy slump at reduced size, its rows, its page."""

import json
import os
import re
import shutil
import subprocess
from dataclasses import replace
from pathlib import Path

import matplotlib.image
import pytest

import talik
from talik.studies.accuracy import convergence, convergencecommand, convergencepage, study

root = Path(__file__).resolve().parents[2]
law = {"skeleton": "MohrCoulomb", "thawed cohesion": 2000.0, "grains": 60}
few = [
	convergence.Sweep("time-step", (1, 1 / 2), law, quick=2),
	convergence.Sweep("motion-tolerance", (0.05, 0.025), law, {"calendar": convergence.constantScale}),
]


@pytest.fixture
def smallStudy(monkeypatch):
	"""Two sweeps of four rows, two days long, on cells of 1 m."""
	monkeypatch.setitem(convergence.draft, "grid spacing", 1.0)
	monkeypatch.setattr(convergence, "sweeps", lambda: few)
	for name, case in convergence.cases.items():
		monkeypatch.setitem(convergence.cases, name, replace(case, days=2, tableDays=(1, 2)))


@pytest.fixture
def toyStudy(smallStudy, monkeypatch):
	"""The same without its runs; returns the list of settings that were run."""
	done = []

	def march(settings):
		done.append(settings)
		largest = 0.2 * settings["time-step fraction"] + settings["motion tolerance"]
		return {"history": [[0, 0.0, 0.0], [1, largest, 0.5], [2, 2 * largest, 1.5]], "firstEvent": None, "cpu": 1.0, "wall": 2.0, "points": 9, "steps": 7}

	monkeypatch.setattr(convergence, "march", march)
	return done


def pageIn(folder):
	page = folder / "accuracy.md"
	page.write_text(f"# Before\n\n{convergencepage.begin}\n{convergencepage.end}\n\nAfter\n")
	return page


# ---- measures -------------------------------------------------------------------------------------------------------------


def test_the_first_event_lies_where_a_steady_motion_passes_its_limit():
	steady = [(day, 0.03 * day, 0.0) for day in range(6)]  # passes 0.1 m on day 10/3
	found = convergence.firstEvent(None, steady, followsMotion=False)
	print(f"day {found:.6f}, exact {10 / 3:.6f}")
	assert found == pytest.approx(10 / 3, rel=1e-12)
	assert convergence.firstEvent(None, steady[:3], followsMotion=False) is None


def test_the_first_event_of_a_calendar_is_the_first_that_moved_ground_by_more_than_the_limit():
	class Ground:
		def events(self):
			return [{"day": 4.0, "largest": 0.05}, {"day": 9.0, "largest": 0.3}, {"day": 11.0, "largest": 2.0}]

	assert convergence.firstEvent(Ground(), [], followsMotion=True) == 9.0


def test_differences_are_relative_to_the_finest_row():
	found = ((3.0, 1.0, 9.0), (1.1, 0.0, 21.0), (1.0, 0.0, 20.0))
	rows = [{"history": [[day, size, volume] for day in (30, 60, 100, 150)], "firstEvent": event} for size, volume, event in found]
	apart = convergence.twoFinest("surface", rows)
	print({what: f"{100 * one:.1f} %" for what, one in apart.items()})
	assert apart == pytest.approx({"displacement": 0.1, "volume": 0.0, "first event": 0.05})
	assert convergence.twoFinest("surface", rows[:2])["volume"] is None  # something over nothing is no percentage


def test_a_row_that_ended_early_is_compared_until_its_last_day_and_the_others_with_the_finest_that_went_on():
	whole = [{"history": [[day, size, size] for day in (30, 60, 100, 150)], "firstEvent": 20.0, "cpu": 1.0} for size in (1.5, 1.2)]
	short = {"history": [[30, 1.0, 1.0]], "firstEvent": 10.0, "cpu": 1.0}
	assert convergence.twoFinest("surface", [*whole, short]) == pytest.approx({"displacement": 0.2, "volume": 0.2, "first event": 1.0})
	sweep = next(one for one in convergence.sweeps() if one.knob == "grid-spacing")
	there = [(sweep, sweep.values[-3:], (*whole, short))]
	coarse, middle, fine = convergencepage.tableOf("surface", there)[1:]
	assert coarse[3:5] == ["1.5 (+50 %)", "1.5 (+25 %)"] and middle[3:5] == ["1.2 (+20 %)", "1.2"] and fine[3:5] == ["1", "–"]
	assert convergencepage.verdictOf("surface", there)[1][2].endswith(", until day 30")


def test_every_sweep_goes_from_coarse_to_fine_and_names_rows_of_the_plan():
	planned = convergence.plan()
	for sweep in convergence.sweeps():
		if sweep.knob != "calendar":
			towards = 1 if sweep.knob in ("grains", "realisations", "pic-time", "stiffness") else -1
			assert list(sweep.values) == sorted(sweep.values, key=lambda value: towards * value)
		assert all(convergence.rowKey(case, sweep, value) in planned for case in convergence.cases for value in sweep.values)
	quick = convergence.plan(quick=True)
	print(f"{len(planned)} rows, {len(quick)} of them quick")
	assert 0 < len(quick) < len(planned) and set(quick) <= set(planned)


# ---- the command ----------------------------------------------------------------------------------------------------------


def test_the_command_runs_both_cases_and_writes_table_picture_and_rows(smallStudy, tmp_path, capsys):
	page = pageIn(tmp_path)
	assert convergencecommand.main(["--quick", "--output", str(tmp_path / "out"), "--write", str(page)]) == 0
	said = capsys.readouterr().out
	print(said)
	rows = json.loads((tmp_path / "out" / "rows.json").read_text())
	assert len(rows) == 4 and all(row["history"][-1][0] == 2 and row["steps"] > 100 and row["points"] > 20 and row["cpu"] > 0 for row in rows.values())
	coarse, fine = (rows[convergence.rowKey("surface", few[0], value)]["steps"] for value in few[0].values)
	assert fine == pytest.approx(2 * coarse, rel=0.05)  # half the time step
	for case in convergence.cases:
		assert convergence.cases[case].title in said
		assert matplotlib.image.imread(tmp_path / f"accuracy_slump_{case}.png")[..., :3].std() > 0.02
	assert (tmp_path / "out" / "table.md").read_text().strip() in page.read_text()


def test_a_study_that_was_stopped_goes_on_with_the_rows_that_it_lacks(toyStudy, tmp_path, monkeypatch, capsys):
	march, command = convergence.march, ["--case", "surface", "--output", str(tmp_path)]

	def stopping(settings):
		if len(toyStudy) == 2:
			raise KeyboardInterrupt
		return march(settings)

	monkeypatch.setattr(convergence, "march", stopping)
	assert convergencecommand.main(command) == convergencecommand.stopped
	assert "2 of 4 rows" in capsys.readouterr().err and len(json.loads((tmp_path / "rows.json").read_text())) == 2
	monkeypatch.setattr(convergence, "march", march)
	assert convergencecommand.main(command) == 0 and len(toyStudy) == 4
	assert convergencecommand.main(command) == 0 and len(toyStudy) == 4
	assert all(one not in toyStudy[:k] for k, one in enumerate(toyStudy))


def test_a_calendar_that_takes_too_long_ends_and_the_page_says_so_slow(smallStudy, tmp_path, monkeypatch):
	monkeypatch.setattr(convergence, "motionAllowed", 0.75)  # of the 0.2 s that two days take
	page = pageIn(tmp_path)
	assert convergencecommand.main(["--quick", "--case", "surface", "--output", str(tmp_path), "--write", str(page)]) == 0
	rows = json.loads((tmp_path / "rows.json").read_text()).values()
	assert all(row["history"][-1][0] == 1 for row in rows)
	assert "time-step fraction 0.2, skeleton MohrCoulomb, thawed cohesion 2000.0: day 1 of 2 after 0.15 s of motion" in page.read_text()


def test_rows_of_two_builds_are_told(toyStudy, tmp_path, monkeypatch, capsys):
	march, page = convergence.march, pageIn(tmp_path)
	command = ["--case", "surface", "--output", str(tmp_path), "--write", str(page)]
	monkeypatch.setattr(convergence, "march", lambda settings: {**march(settings), "build": "old" if settings["follows motion"] else "new"})
	assert convergencecommand.main(command) == 0
	assert "measured by 2 builds of Talik" in capsys.readouterr().out and "measured by 2 builds of Talik" in page.read_text()


def test_a_row_that_fails_is_a_miss_and_is_tried_again(toyStudy, tmp_path, monkeypatch, capsys):
	march, page = convergence.march, pageIn(tmp_path)

	def failing(settings):
		if settings["motion tolerance"] == 0.025:
			raise RuntimeError("it fell over")
		return march(settings)

	monkeypatch.setattr(convergence, "march", failing)
	command = ["--case", "base", "--output", str(tmp_path), "--write", str(page)]
	assert convergencecommand.main(command) == 1
	assert re.search(r"MISSED .*motion tolerance 0.025.*: it fell over", capsys.readouterr().out)
	assert re.search(r"Did not come to their end:\n\n- base.*motion tolerance 0.025.*: it fell over\n", page.read_text())
	monkeypatch.setattr(convergence, "march", march)
	assert convergencecommand.main(command) == 0 and "it fell over" not in page.read_text()


@pytest.mark.parametrize(
	"given, sentence",
	(
		(["--case", "summit"], "argument --case: invalid choice: 'summit'"),
		(["--knob", "colour"], "argument --knob: invalid choice: 'colour'"),
		(["--quick", "--knob", "motion-tolerance"], "--quick has no rows of motion-tolerance; leave --quick out"),
		(["--write", "absent.md"], "absent.md cannot be read (No such file or directory)"),
		(["--check", "absent.md"], "absent.md cannot be read (No such file or directory)"),
		(["--output", "/proc/nowhere"], "folder '/proc/nowhere' cannot be written"),
	),
)
def test_a_bad_argument_is_refused_by_one_sentence(toyStudy, given, sentence):
	with pytest.raises((ValueError, RuntimeError), match=re.escape(sentence)) as refused:
		convergencecommand.main(given)
	print(refused.value)
	assert toyStudy == []


def test_the_shell_command_says_its_sentence_and_no_more():
	build = {**os.environ, "TALIK_BUILD": str(Path(talik.__file__).parents[2])}
	asked = [str(root / "scripts/accuracy"), "slump", "--knob", "colour"]
	done = subprocess.run(asked, env=build, capture_output=True, text=True, timeout=300, stdin=subprocess.DEVNULL)
	said = [line for line in done.stderr.splitlines() if not line.startswith(("Running script", "TCP python", "XMLRPC"))]  # what yade says by itself
	print(said)
	assert done.returncode == 1 and len(said) == 1 and "invalid choice: 'colour'" in said[0] and "Traceback" not in done.stderr


# ---- the page -------------------------------------------------------------------------------------------------------------


def test_the_page_is_stable_and_keeps_what_stands_around_its_tables(toyStudy, tmp_path):
	page, results = pageIn(tmp_path), study.Results(tmp_path / "rows.json")
	convergence.runRows(convergence.plan(), results, progress=False)
	convergencepage.write(page, results.rows)
	first = page.read_text()
	convergencepage.write(page, dict(reversed(study.Results(tmp_path / "rows.json").rows.items())))
	assert page.read_text() == first and first.startswith("# Before\n") and first.endswith("\nAfter\n")
	assert "| law, 2 kPa | time step over draft's | 1 | 0.13 (+44 %) | 0.26 (+44 %) | 0.5 (+0 %) | 1.5 (+0 %) | – | 1 |" in first
	assert "| 1/2 | 0.09 | 0.18 |" in first


def test_a_page_whose_tables_are_not_those_of_its_rows_is_told(toyStudy, tmp_path, capsys):
	page, results = pageIn(tmp_path), study.Results(tmp_path / "rows.json")
	convergence.runRows(convergence.plan(), results, progress=False)
	convergencepage.write(page, results.rows)
	assert convergencecommand.main(["--check", str(page)]) == 0
	page.write_text(page.read_text().replace("0.13 (+44 %)", "0.12 (+4 %)"))
	assert convergencecommand.main(["--check", str(page)]) == 1
	assert "are not those of" in capsys.readouterr().out
	page.write_text("# no markers\n")
	with pytest.raises(ValueError, match="lacks the two markers"):
		convergencecommand.main(["--check", str(page)])


def test_the_page_of_the_examples_is_what_its_rows_say():
	page = root / "examples" / "accuracy.md"
	assert convergencepage.agrees(page)
	pictures = re.findall(r"\]\((\w+\.png)\)", page.read_text())
	print(f"{len(json.loads(convergencepage.rowsBeside(page).read_text()))} rows; {', '.join(pictures)}")
	assert pictures and all((page.parent / picture).exists() for picture in pictures)


def command(line, folder):
	"""Runs a command of the page on a copy of the page."""
	page = shutil.copy(root / "examples" / "accuracy.md", folder)
	shutil.copy(root / "examples" / "accuracy_slump.json", folder)
	program, *options = line.replace("examples/accuracy.md", str(page)).split()
	build = {**os.environ, "TALIK_BUILD": str(Path(talik.__file__).parents[2])}
	return subprocess.run([str(root / program), *options], env=build, capture_output=True, text=True, timeout=1200, stdin=subprocess.DEVNULL)


def commandsOfThePage():
	return re.findall(r"^\t(scripts/accuracy slump .*)$", (root / "examples" / "accuracy.md").read_text(), re.M)


def test_the_page_is_checked_by_the_command_that_it_names(tmp_path):
	(line,) = [line for line in commandsOfThePage() if "--check" in line]
	done = command(line, tmp_path)
	print(done.stdout.splitlines()[-1])
	assert done.returncode == 0 and "are those of" in done.stdout, done.stderr


def test_the_page_is_written_by_the_command_that_it_names_slow(tmp_path):
	(line,) = [line for line in commandsOfThePage() if "--write" in line]
	done = command(f"{line} --quick --output {tmp_path / 'out'}", tmp_path)
	print(done.stdout)
	assert done.returncode == 0, done.stderr
	rows = json.loads((tmp_path / "accuracy_slump.json").read_text())
	assert len(rows) == 4 and convergencepage.agrees(tmp_path / "accuracy.md")
