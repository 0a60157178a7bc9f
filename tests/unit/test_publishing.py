# SPDX-License-Identifier: GPL-2.0-or-later
"""What is for those who publish: the container file, the descriptions for archives, the tutorial as a notebook."""

import json
import re
import subprocess
import sys
from pathlib import Path

root = Path(__file__).resolve().parents[2]


def test_the_container_file_names_files_that_there_are_and_commands_that_the_shell_can_read():
	text = (root / ".ci" / "Dockerfile").read_text()
	lines = re.sub(r"\\\n", " ", re.sub(r"^#.*\n", "", text, flags=re.M)).splitlines()
	copied = [line.split()[1] for line in lines if line.startswith("COPY")]
	commands = [line[4:] for line in lines if line.startswith("RUN")]
	named = re.findall(r"scripts/[\w.]+", text)
	print(f"{len(lines)} lines, copies {copied}, names {sorted(set(named))}")
	assert all((root / name).exists() for name in [*copied, *named]) and lines[1].startswith("FROM debian:") and {"scripts/run", "scripts/test"} <= set(named)
	for command in commands:
		subprocess.run(["bash", "-n", "-c", command], check=True)
	assert "build" in (root / ".dockerignore").read_text().split()


def test_descriptions_for_archives_have_one_name_and_one_version():
	cff = dict(re.findall(r'^(\w[\w-]*): "?(.*?)"?$', (root / "CITATION.cff").read_text(), re.M))
	meta = json.loads((root / ".codemeta.json").read_text())
	version = re.search(r"project\(\w+ VERSION ([\d.]+)", (root / "CMakeLists.txt").read_text()).group(1)
	print(meta["name"], meta["version"], cff["version"], version)
	assert meta["version"] == cff["version"] == version and meta["license"].endswith(cff["license"]) and cff["title"].startswith(meta["name"])


def test_the_notebook_of_the_tutorial_has_its_code_and_its_text_in_their_order():
	page = root / "examples" / "manual" / "tutorial.md"
	made = subprocess.run([sys.executable, root / "scripts/manual.d/notebook.py", page], capture_output=True, text=True, check=True)
	cells = json.loads(made.stdout)["cells"]
	code = ["".join(cell["source"]) for cell in cells if cell["cell_type"] == "code"]
	wanted = [block.rstrip() for block in re.findall(r"^```python\n(.*?)^```", page.read_text(), re.S | re.M)]
	print(f"{len(code)} cells of code, {len(cells) - len(code)} of text")
	assert code[1:] == wanted and code[0].startswith("from yadeimport import *") and "".join(cells[1]["source"]).startswith("# Tutorial")
	assert len({cell["id"] for cell in cells}) == len(cells)
