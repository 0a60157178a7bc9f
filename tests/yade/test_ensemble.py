# SPDX-License-Identifier: GPL-2.0-or-later
"""Runs of one scene with other seeds and offsets of the grid: their spread, pictures, and how they go on."""

import json
import math
import subprocess
from pathlib import Path

import numpy as np
import pytest
from scipy import stats

from talik import batch, ensemble

root = Path(__file__).parents[2]
# What an example does, without a ground: the path is 1 m and a tenth for each thousand of the seed; a third of the runs stops in the middle once
example = """
import argparse, json, sys
from pathlib import Path
import numpy as np
parser = argparse.ArgumentParser()
for name in ("--output", "--seed", "--realisations", "--grid-offset", "--preset"):
	parser.add_argument(name)
parser.add_argument("--resume", action="store_true")
options = parser.parse_args(sys.argv[1:])
folder = Path(options.output)
folder.mkdir(exist_ok=True)
if options.seed == "1001" and not options.resume:
	(folder / "slope.checkpoint").write_text("half way")
	sys.exit(1)
path = 1 + (int(options.seed) - 1) / 1e4
history = [[0, 0, 0], [10, 1, path / 2], [20, 2, path]]
summary = {"headlines": ["path [m]"], "path [m]": path, "offset": float(options.grid_offset), "history": history}
(folder / "summary.json").write_text(json.dumps(summary))
position = np.array([[x + 0.5, y + 0.5] for x in range(3) for y in range(2)])
moved = np.zeros((6, 2))
moved[: 2 if options.seed == "1" else 4, 0] = 0.5
moved[1, 1] = 0 if options.seed == "1" else -1
frame = dict(time=np.array(2.0), day=np.array(20.0), position=position + moved, displacement=moved, volume=np.ones(6))
frame.update(iceSaturation=np.ones(6), deviatoricStrain=moved[:, 0])
np.savez(folder / "frames.npz", **{f"0/{name}": values for name, values in frame.items()})
"""


def test_members_have_seeds_apart_and_offsets_that_fill_a_cell_and_more_of_them_keep_those_before():
	eight = ensemble.members(8, seed=5, realisations=2)
	offsets = sorted(offset for _, offset in eight)
	print(f"seeds {[seed for seed, _ in eight]}, offsets {offsets}")
	assert eight[:3] == ensemble.members(3, seed=5, realisations=2) and eight[0] == (5, 0.0)
	assert offsets == [k / 8 for k in range(8)] and min(np.diff([seed for seed, _ in eight])) >= 2000
	with pytest.raises(ValueError, match="members is 0; give 1 or more"):
		ensemble.members(0)


def test_a_spread_is_mean_standard_error_and_deciles_of_the_runs_that_have_a_number():
	values = [3.0, 1.0, 4.0, 1.5, 5.0, 9.0]
	results = [dict(path=value, name="x", done=True) for value in values] + [dict(path=math.nan), dict(), None]
	found = ensemble.spread(results)
	assert list(found) == ["path"]
	path = found["path"]
	print(path.row())
	assert path.runs == 8 and path.mean == pytest.approx(np.mean(values))
	assert path.error == pytest.approx(np.std(values, ddof=1) / math.sqrt(6))
	assert path.deciles == pytest.approx(tuple(np.percentile(values, (10, 50, 90))))
	assert path.row().endswith("6 of 8 |") and ensemble.spread([dict(other="x")], ["path"])["path"].row().endswith("0 of 1 |")


@pytest.fixture
def script(tmp_path):
	file = tmp_path / "example.py"
	file.write_text(example)
	return file


def test_an_ensemble_goes_on_where_it_was_stopped_adds_members_and_tells_when_and_how_often_the_top_of_the_slope_failed(script, tmp_path):
	said, folder = [], tmp_path / "several"
	first = ensemble.run(script, folder, 2, ["--preset", "test"], jobs=2, told=said.append)
	assert len(first.summaries) == 1 and any("member 1 of 2 failed" in line for line in said)
	done = (folder / "member000" / ensemble.finishedName).stat().st_mtime_ns
	said.clear()
	three = ensemble.run(script, folder, 3, ["--preset", "test"], jobs=2, told=said.append)
	print("\n".join(said), three.report(), sep="\n")
	assert len(three.summaries) == 3 and (folder / "member000" / ensemble.finishedName).stat().st_mtime_ns == done
	assert "member 1 of 3 goes on" in said and "member 2 of 3 begins" in said and not any("member 0" in line for line in said)
	assert [summary["offset"] for summary in three.summaries] == [0, 0.5, 0.25]
	path = three.spread()["path [m]"]
	assert path.mean == pytest.approx(1.1) and path.error == pytest.approx(0.1 / math.sqrt(3))
	assert "sinks by 0.5 m in 2 of 3 runs (67 %, with 90 % confidence 14 to 98 %), on day 10, 10" in three.report()
	runs, seconds = three.cost(jobs=3)
	assert runs == 9 and seconds == pytest.approx(3 * np.mean([json.loads(f.read_text())["seconds"] for f in folder.glob("*/finished.json")]))
	assert [Path(picture).name for picture in three.draw()] == ["paths.png", "map.png", "failure.png"]
	with pytest.raises(ValueError, match="arguments .*'test'.* and now .*'draft'.*give another folder"):
		ensemble.run(script, folder, 3, ["--preset", "draft"])


def test_a_map_tells_in_which_share_of_the_runs_ground_slid_on_the_ground_as_it_lay_before():
	def frame(moved, broken):
		position = np.array([(0.5, 0.5), (1.5, 0.5), (2.5, 0.5)])
		displacement = np.array([(path, 0.0) for path in moved])
		return dict(
			position=position + displacement,
			displacement=displacement,
			volume=np.ones(3),
			iceSaturation=np.array([0.0, 1.0, 1.0]),
			deviatoricStrain=np.array([1.0, 0.3, 0.1]),
			bondsFormed=np.full(3, 100),
			bondsBroken=np.array(broken),
		)

	place, side, parts = ensemble.shares([frame((0.5, 0.2, 0), (5, 50, 0)), frame((0.5, 0.05, 0), (5, 5, 0))])
	print({name: list(values) for name, values in parts.items()})
	assert side == 1 and place[:, 0].tolist() == [0.5, 1.5, 2.5]
	assert parts["has slid"].tolist() == [1, 0.5, 0] and parts["bonds broken"].tolist() == [0, 0.5, 0] and parts["failed frozen"].tolist() == [0, 1, 0]


def test_the_probability_over_time_is_the_share_of_the_runs_and_its_band_that_of_clopper_and_pearson():
	"""Three of thirty: 2.8 to 23.9 %, by the quantiles of the beta distribution."""
	axes = ensemble.drawFailure([500.0, None, 520.0, 510.0, *[None] * 26], end=600).axes[0]
	days, probability = axes.lines[0].get_data()
	band = axes.collections[0].get_paths()[0].vertices
	edges = [(edge.min(), edge.max()) for day in (0, 600) for edge in [band[np.isclose(band[:, 0], day), 1]]]
	due = [(0, 100 * (1 - 0.05 ** (1 / 30))), tuple(100 * stats.beta.ppf((0.05, 0.95), (3, 4), (28, 27)))]
	print(f"day 0: {edges[0][0]:.1f} to {edges[0][1]:.1f} %, day 600: {edges[1][0]:.1f} to {edges[1][1]:.1f} %, due {due}")
	assert days.tolist() == [0, 500, 500, 510, 510, 520, 520, 600] and probability[-1] == pytest.approx(10) and np.allclose(edges, due)


def test_bands_of_paths_are_the_deciles_of_the_runs_on_every_day():
	histories = [[(0, 0, 0), (10, 1, path), (20, 2, 2 * path)] for path in np.linspace(0, 1, 11)]
	axes = ensemble.drawPaths(histories).axes[0]
	band = axes.collections[0].get_paths()[0].vertices
	edges = band[np.isclose(band[:, 0], 20)][:, 1]
	print(f"band on day 20: {edges.min():.2f} to {edges.max():.2f}, due 0.20 to 1.80")
	assert edges.min() == pytest.approx(0.2) and edges.max() == pytest.approx(1.8)


def test_rows_of_a_batch_that_left_their_results_stay_when_it_is_run_again(tmp_path):
	script = tmp_path / "row.py"
	script.write_text("import talik, os, time\nrow = talik.batch.row(x=1)\ntalik.batch.leave(y=2 * row.x, at=time.time())\n")
	first = batch.run(script, [dict(x=1)], tmp_path / "study")
	again = batch.run(script, [dict(x=1), dict(x=3)], tmp_path / "study", resume=True)
	assert again[0] == first[0] and [result["y"] for result in again] == [2, 6]
	changed = batch.run(script, [dict(x=5), dict(x=3)], tmp_path / "study", resume=True)
	assert [result["y"] for result in changed] == [10, 6] and changed[1] == again[1]


def test_a_batch_keeps_the_results_of_the_one_before_and_refuses_a_folder_of_other_files(tmp_path, capsys, monkeypatch):
	monkeypatch.setattr(batch.subprocess, "run", lambda *command, cwd, **more: (cwd / "row000.json").write_text('{"y": 2}'))
	script, former = tmp_path / "row.py", tmp_path / "study"
	script.write_text("import talik\nrow = talik.batch.row(x=1)\ntalik.batch.leave(y=2 * row.x)\n")
	former.mkdir()
	for name in (batch.allRows, "row000.json", "frames-1.npz"):
		(former / name).write_text("former")
	assert batch.run(script, [dict(x=1)], former) == [{"y": 2}]
	print(capsys.readouterr().out)
	assert (tmp_path / "study-1/frames-1.npz").read_text() == "former" and not (former / "frames-1.npz").exists()
	with pytest.raises(ValueError, match="holds files of no batch"):
		batch.run(script, [dict(x=1)], tmp_path)
	assert script.exists()


def test_the_command_refuses_examples_without_seeds_and_numbers_that_are_none(tmp_path):
	for arguments, reason in ((["melting_column", "--ensemble", "2"], "--ensemble is for the slumps"), (["--ensemble", "many"], "must be a number of runs")):
		done = subprocess.run([root / "scripts/run", *arguments, "--output", tmp_path / "none"], capture_output=True, text=True)
		print(done.stderr.strip().splitlines()[-1])
		assert done.returncode != 0 and reason in done.stderr


def test_an_ensemble_of_a_slump_runs_from_its_command_and_a_grid_that_lies_otherwise_carries_the_same_slope_slow(tmp_path):
	done = subprocess.run(
		[root / "scripts/run", "thaw_slump_surface", "--preset", "test", "--ensemble", "2", "--output", tmp_path / "two"], capture_output=True, text=True
	)
	print(done.stdout)
	several = ensemble.read(tmp_path / "two")
	assert done.returncode == 0 and len(several.summaries) == 2 and "Halving the standard errors takes 6 runs more" in done.stdout
	assert [summary["preset.gridOffset"] for summary in several.summaries] == [0, 0.5]
	points = [summary["points"] for summary in several.summaries]
	assert points[0] < points[1] < 1.2 * points[0]
	for name in ("paths.png", "map.png", "failure.png", "ensemble.md"):
		assert (tmp_path / "two" / name).stat().st_size > 500
