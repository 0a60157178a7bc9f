# SPDX-License-Identifier: GPL-2.0-or-later
"""The README is run, not believed."""

import re
import subprocess
from pathlib import Path

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
