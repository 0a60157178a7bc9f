# SPDX-License-Identifier: GPL-2.0-or-later
"""What accuracy costs: the study of scripts/accuracy at reduced size, its file, its table, and the presets of the examples in it."""

import csv
import json
import math
import subprocess
from pathlib import Path

import matplotlib.image
import numpy as np
import pytest

import talik
from talik import plots
from talik.studies import accuracy
from talik.studies.accuracy import biaxial, neumann, presets, problem, report, slump, study, terzaghi, wave

root = Path(__file__).resolve().parents[2]


def error(of, **settings):
	"""Error of a problem with a closed form."""
	settings = {name.replace("_", " "): value for name, value in settings.items()}
	with talik.scratchScene():
		return of.problem.error(of.problem.run({**of.problem.standard, **settings}).answer, np.array(of.problem.exact()))


# ---- problems against references that are not ours ------------------------------------------------------------------------


def test_neumann_front_is_the_published_one_of_the_papers_soil():
	rate = accuracy.neumannFront(10.0, -5.0, fullPores=True)
	print(f"X/sqrt(t) = {rate:.6e} m/s^0.5, reference 3.154424e-4")
	assert rate == pytest.approx(3.154424e-4, rel=1e-6)


def test_terzaghis_pressures_are_the_tabulated_ones():
	mean = terzaghi.exactPressure(np.linspace(0, 1, 2001), 0.197).mean()
	print(f"degree of consolidation at T_v = 0.197: {1 - mean:.4f}, reference 0.5")
	assert 1 - mean == pytest.approx(0.5, abs=1e-3)


def test_error_of_the_thaw_front_falls_with_its_cells_and_is_below_one_per_cent_from_four_on():
	errors = [error(neumann, cells=cells) for cells in (2, 4, 8)]
	print("error with 2, 4, 8 cells over the front: " + ", ".join(f"{100 * e:.2f} %" for e in errors))
	assert errors[0] > errors[1] > errors[2] and errors[1] < 0.01


def test_the_thermal_time_scale_costs_no_accuracy_in_rigid_ground():
	plain, hastened = error(neumann, cells=4), error(neumann, cells=4, thermal_time_scale=8.64e5)
	print(f"error {plain:.6f}, hastened {hastened:.6f}")
	assert hastened == pytest.approx(plain, rel=1e-6)


def test_errors_of_wave_and_consolidation_fall_with_the_grid():
	for of, few, many, limit in ((wave, 5, 20, 0.015), (terzaghi, 5, 10, 0.03)):
		coarse, fine = error(of, cells=few), error(of, cells=many)
		print(f"{of.problem.name}: {100 * coarse:.2f} % with {few} cells, {100 * fine:.2f} % with {many}")
		assert fine < coarse and fine < limit


def test_soft_water_is_paid_for_in_consolidation():
	soft, stiff = error(terzaghi, cells=5, bulk_modulus_of_water=5e6), error(terzaghi, cells=5)
	print(f"K_w = 5e6 Pa: {100 * soft:.1f} %, 2.2e8 Pa: {100 * stiff:.1f} %")
	assert soft > 2 * stiff


def test_a_sample_compressed_fast_answers_too_stiffly(monkeypatch):
	monkeypatch.setattr(biaxial, "packings", 2)
	monkeypatch.setattr(biaxial, "strain", 0.02)
	slow, fast = (biaxial.run({"grains": 60, "inertial number": number, "strain of a call": 1e-4}) for number in (1e-4, 2e-2))
	excess = fast.answer[0] - slow.answer[0]
	print(f"deviator over lateral pressure, mean of the first 0.3 %: {excess:+.3f} too high at I = 2e-2; steps {fast.steps} for {slow.steps}")
	assert excess > 0 and fast.steps < slow.steps


def test_the_slump_runs_at_reduced_size_and_reports_what_it_believes():
	run = slump.run({**slump.problem.standard, "grains": 60, "days of heat": 3, "tolerance": 0.1})
	print(f"largest displacement {run.answer[0]:.2e} m, thawed {run.answer[1]:.2f} m2, {run.memory / 1e6:.1f} MB, believed error {run.believed:.3f}")
	assert all(a > 0 for a in run.answer) and 0 < run.believed < 0.3 and run.memory > 1e5


# ---- the study ------------------------------------------------------------------------------------------------------------


def parabola(settings):
	if settings["n"] == 13:
		raise RuntimeError("thirteen is refused")
	return problem.Run([1 + 1 / settings["n"]], settings["n"] * 1e-3, settings["n"] * 1e-3, 1000, 1, 1)


def toy(**others):
	return problem.Problem(
		name="toy",
		title="Toy",
		norm="difference",
		reference="one",
		standard={"n": 4, "m": 1},
		sweeps={"n": (64,), "m": (2, 3)},
		quick={"n": (2, 8), "m": (2,)},
		run=parabola,
		error=problem.rootMeanSquare,
		exact=lambda: [1.0],
		pairs=(("n", "m"),),
		**others,
	)


def test_a_study_that_was_stopped_goes_on_where_it_was(tmp_path, monkeypatch):
	file, done = tmp_path / "results.json", []

	def measured(problem, settings, quick):
		if len(done) == 3:
			raise KeyboardInterrupt
		done.append(settings)
		return {"problem": problem.name, **vars(parabola(settings))}

	monkeypatch.setattr(study, "presetRows", lambda quick: [])
	monkeypatch.setattr(study, "measure", measured)
	with pytest.raises(KeyboardInterrupt):
		study.runStudy([toy()], study.Results(file), progress=False)
	assert len(json.loads(file.read_text())) == 3
	first, done[:] = list(done), []
	with pytest.raises(KeyboardInterrupt):
		study.runStudy([toy()], study.Results(file), progress=False)
	print(f"of {len(toy().plan())} runs three were done, then three others")
	assert len(json.loads(file.read_text())) == 6 and not any(settings in first for settings in done)


def test_quick_studies_are_part_of_full_ones():
	for each in accuracy.problems:
		quick, full = each.plan(True), each.plan()
		print(f"{each.name}: {len(quick)} runs, {len(full)} in full")
		assert len(quick) < len(full)
		assert all(settings in full for settings in quick if settings != (each.referenceSettings(True) if each.exact is None else None))


def test_what_failed_is_a_miss_and_is_tried_again(tmp_path):
	results = study.Results(tmp_path / "results.json")
	settings = {"n": 13, "m": 1}
	results.add(problem.key("toy", settings), study.measure(toy(), settings))
	assert "thirteen" in results.rows[problem.key("toy", settings)]["failure"] and problem.key("toy", settings) not in results


def rowsOf(*errorsAndTimes):
	return [
		{"varied": f"row {k}", "knob": "n", "error [-]": e, "wall time [s]": 2 * t, "CPU time [s]": t, "memory [MB]": 1.0, "failure": ""}
		for k, (e, t) in enumerate(errorsAndTimes)
	]


def test_the_front_the_advice_and_the_misses_are_those_of_the_rows():
	rows = rowsOf((0.2, 1), (0.05, 2), (0.08, 3), (0.02, 9), (math.nan, 1))
	assert [row["varied"] for row in report.paretoFront(rows)] == ["row 0", "row 1", "row 3"]
	sentence = report.advice(toy(), rows)
	print(sentence)
	assert (
		"1% is not reached (best 2.0%)" in sentence
		and "3% take row 3: 9 s of computing (18 s of wall time)" in sentence
		and "10% take row 1: 2 s of computing" in sentence
	)
	assert report.misses(toy(), rows) == []
	assert report.misses(toy(), rows[:2]) == ["toy: no setting has an error of 3% or less"]
	assert [row["on the front"] for row in report.marked(rows)] == ["yes", "yes", "", "yes", ""]
	rows[0]["failure"] = "it fell over"
	assert report.misses(toy(), rows) == ["toy, row 0: it fell over"]


def test_a_run_that_stands_for_the_truth_is_no_coarser_than_any_other():
	for each in accuracy.problems:
		if each.exact is not None:
			continue
		finest = each.referenceSettings()
		presets = [row.settings for row in accuracy.presetRows() if row.problem == each.name]
		for knob, finer in (("cells", max), ("grid spacing", min), ("grains", max), ("inertial number", min)):
			if knob in each.finest:
				values = [settings[knob] for settings in each.plan(further=presets)]
				print(f"{each.referenceName()}; {knob} from {min(values):g} to {max(values):g}")
				assert finest[knob] == finer(values)


def test_tables_and_pictures_are_written_by_the_command(tmp_path):
	command = [
		"yade",
		"-n",
		"-x",
		"-j1",
		str(root / "scripts/talik/studies/accuracy/command.py"),
		"--quick",
		"--problem",
		"elastic wave",
		"--output",
		str(tmp_path),
	]
	done = subprocess.run(command, capture_output=True, text=True, timeout=120, stdin=subprocess.DEVNULL)
	print(done.stdout[done.stdout.index("Two periods") :])
	assert done.returncode == 0, done.stderr
	assert "elastic wave: for 1% take" in done.stdout
	with open(tmp_path / "accuracy.csv", newline="") as file:
		read = list(csv.DictReader(file))
	assert len(read) == len(wave.problem.plan(True)) and all(float(row["error [-]"]) > 0 and float(row["memory [MB]"]) > 0 for row in read)
	study = json.loads((tmp_path / "accuracy.json").read_text())["elastic wave"]
	assert [row["varied"] for row in study["rows"]] == [row["varied"] for row in read] and study["advice"] in done.stdout and study["norm"]
	assert 2 <= sum(row["on the front"] == "yes" for row in read) < len(read)
	picture = matplotlib.image.imread(tmp_path / "accuracy.png")
	assert picture[..., :3].std() > 0.02


def test_axes_of_the_curves_carry_their_units():
	fig = accuracy.drawStudy({toy(): rowsOf((0.2, 1), (0.05, 2))})
	for axes in fig.axes:
		assert "[s]" in axes.get_xlabel() and "[%]" in axes.get_ylabel()
	assert isinstance(fig, type(plots.figure(1, 1)))


# ---- presets --------------------------------------------------------------------------------------------------------------


def test_every_preset_of_every_example_is_a_row_of_the_table():
	names = {file.stem for file in (root / "examples").glob("*.py")}
	without = names - set(presets.rowOf) - set(presets.withoutKnob)
	assert not without, f"say in talik/studies/accuracy/presets.py which problem stands for {', '.join(sorted(without))}"
	rows = accuracy.presetRows()
	for each in accuracy.problems:
		own = [row for row in rows if row.problem == each.name]
		planned = each.plan(further=[row.settings for row in own])
		for row in own:
			print(f"{row.example} {row.preset}: {each.name}, {row.settings}")
			assert set(row.settings) <= set(each.standard) and {**each.standard, **row.settings} in planned
	assert {row.example for row in rows} == set(presets.rowOf)
	assert {row.problem for row in rows} <= {each.name for each in accuracy.problems}
