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


def test_python_of_the_readme_runs_in_a_yade_console(tmp_path):
	code = "\n".join(blocks("python")).replace("sample.yade.gz", str(tmp_path / "sample.yade.gz"))
	names = dict(vars(yade))
	names["O"] = yade.O
	yade.O.reset()
	exec(compile(code, "README.md", "exec"), names)
	temperature = names["mpm"].field("temperature")
	print(f"{len(temperature)} points after {yade.O.iter} steps, temperatures {temperature.min():.2f} to {temperature.max():.2f} °C")
	assert yade.O.iter == 220 and (tmp_path / "sample.yade.gz").exists() and len(temperature) == 128
	assert -5.01 < temperature.min() < temperature.max() < 10
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
