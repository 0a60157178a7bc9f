# SPDX-License-Identifier: GPL-2.0-or-later
"""The README is run, not believed."""

import os
import re
import subprocess
from pathlib import Path

import talik

import yade

root = Path(__file__).resolve().parents[2]


def blocks(language):
	return re.findall(rf"```{language}\n(.*?)```", (root / "README.md").read_text(), re.S)


def test_python_of_the_readme_runs_in_a_yade_console_and_shows_what_its_comments_say(tmp_path, monkeypatch):
	monkeypatch.chdir(tmp_path)
	names = dict(vars(yade))
	names["O"] = yade.O
	yade.O.reset()
	exec(compile("\n".join(blocks("python")), "README.md", "exec"), names)
	mpm, worst = names["mpm"], names["worst"]
	event = max(mpm.events(), key=lambda event: event["largest"])
	broken = [mpm.field("bondsBroken")[id] for id in worst]
	print(f"{mpm.pointCount} points, day {mpm.calendar['day']:.2f}: on day {event['day']:.2f} {event['volume']:.2f} m2 slid, by up to {event['largest']:.2f} m")
	print(f"(page: more than a metre); bonds broken at the points that lost most: {', '.join(f'{n:.0f}' for n in broken)}")
	assert event["largest"] > 1 and broken[0] >= broken[1] and broken[0] > 0 and mpm.field("iceSaturation").min() == 0
	assert all((tmp_path / file).stat().st_size > 1000 for file in ("slope.png", "sample.yade.gz"))
	yade.O.reset()


def test_commands_of_the_readme_exist_and_explain_themselves():
	commands = sorted(set(re.findall(r"scripts/\w+", (root / "README.md").read_text())))
	for command in commands:
		done = subprocess.run([str(root / command), "--help"], capture_output=True, text=True, timeout=60)
		assert done.returncode == 0 and "usage" in done.stdout.lower(), (command, done.stderr)
	print(", ".join(commands))


def test_commands_of_the_readme_run(tmp_path):
	"""An example at reduced size, and a case of the validation drawn against its reference, as a user would type them."""
	build = {**os.environ, "TALIK_BUILD": str(Path(talik.__file__).parents[2])}
	for command, left in (
		("scripts/run weather_column --preset test --output run", "run"),
		("scripts/validate FreeElement --output drawn", "drawn/nine_per_cent.png"),
	):
		folder = tmp_path / command.split()[-1]
		done = subprocess.run([str(root / command.split()[0]), *command.split()[1:-1], str(folder)], env=build, capture_output=True, text=True, timeout=300)
		assert done.returncode == 0, (command, done.stdout, done.stderr)
		found = sorted(file.name for file in folder.iterdir())
		print(f"{command}: {', '.join(found)}")
		assert (tmp_path / left).exists() and found
