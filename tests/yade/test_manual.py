# SPDX-License-Identifier: GPL-2.0-or-later
"""The manual: its code runs, it builds without a warning, and everything public is in it."""

import os
import re
import subprocess
import sys
from pathlib import Path

import pytest
import yade
from sphinx.util.inventory import InventoryFile

import talik

root = Path(__file__).resolve().parents[2]
sys.path.insert(0, str(root / "scripts" / "manual.d"))
import helptexts  # noqa: E402: what the manual is built with
import reference  # noqa: E402

pages = root / "examples" / "manual"
reduced = {"range(2, 41, 2)": "(1,)", "grains=60": "grains=30", "strain=0.02": "strain=0.002"}


def codeOf(text):
	return "\n".join(re.findall(r"^```python\n(.*?)^```", text, re.S | re.M))


def recipes(batches=False):
	for page in sorted(pages.glob("*.md")):
		for title, section in re.findall(r"^## (.*?)\n(.*?)(?=^## |\Z)", page.read_text(), re.S | re.M):
			if page.stem != "tutorial" and codeOf(section) and ("batch.run" in codeOf(section)) == batches:
				yield pytest.param(codeOf(section), id=f"{page.stem}: {title}")


def run(code, folder, monkeypatch):
	monkeypatch.chdir(folder)
	yade.O.reset()
	names = dict(vars(yade), O=yade.O, utils=yade.utils)
	exec(compile(code, "manual", "exec"), names)
	yade.O.reset()
	return names


@pytest.mark.parametrize("code", recipes())
def test_every_recipe_of_the_manual_runs_as_it_stands(code, tmp_path, monkeypatch):
	run(code, tmp_path, monkeypatch)


@pytest.mark.parametrize("code", recipes(batches=True))
def test_the_batch_of_the_manual_runs_as_it_stands_slow(code, tmp_path, monkeypatch):
	assert None not in run(code, tmp_path, monkeypatch)["results"]


def test_the_tutorial_runs_and_says_what_it_prints(tmp_path, monkeypatch):
	code = codeOf((pages / "tutorial.md").read_text())
	for full, less in reduced.items():
		assert full in code
		code = code.replace(full, less)
	names = run(code, tmp_path, monkeypatch)
	print(f"settled {1e3 * names['settled']:.2f} mm, thawed {names['thawed']:.2f} m, {(tmp_path / 'slope.png').stat().st_size} bytes of picture")
	assert f"{1e3 * names['settled']:.2f} mm beside {1e3 * names['byHand']:.2f} mm" in (pages / "tutorial.md").read_text()
	assert names["thawed"] == pytest.approx(names["stefan"], rel=0.02)
	assert names["tests"][1].deviator.max() > 2 * names["tests"][0].deviator.max()


def test_help_texts_lose_the_marks_of_boost_and_keep_their_units():
	lines = {
		f"{cls.__name__}.{name}": " ".join(helptexts.ofMember(member.__doc__ or "")) for cls in reference.classes() for name, member in reference.members(cls)
	}
	marked = [name for name, text in lines.items() if ":y" in text or "arg1" in text or "C++" in text]
	united = [name for name, text in lines.items() if "[" in text]
	signatures = {name: helptexts.signature(vars(talik.MpmEngine)[name]) for name in ("field", "most")}
	print(f"{len(lines)} members, {len(united)} with a unit; {signatures}")
	assert not marked and len(united) > 120
	assert signatures == {"field": "(name)", "most": "(field, n=10)"}


def test_every_class_has_a_place_in_the_reference():
	text = "".join(reference.pages().values())
	lacking = [cls.__name__ for cls in reference.classes() if f"class:: talik.{cls.__name__}" not in text]
	print(f"{len(reference.classes())} classes, {len(lacking)} without a place")
	assert not lacking


def test_the_manual_builds_without_a_warning_is_installed_and_has_everything_public_in_its_index_slow(tmp_path):
	build = Path(talik.__file__).parents[2]
	environment = {**os.environ, "TALIK_BUILD": str(build)}
	done = subprocess.run([str(root / "scripts" / "manual"), "--pdf"], env=environment, capture_output=True, text=True, timeout=600)
	assert done.returncode == 0, done.stderr + (build / "manual" / "build.log").read_text()
	subprocess.run(["cmake", "--install", str(build), "--prefix", str(tmp_path)], check=True, capture_output=True)
	manual = tmp_path / "share" / "doc" / "talik" / "html"
	with open(manual / "objects.inv", "rb") as file:
		inventory = InventoryFile.load(file, "", lambda base, place: place)
	listed = {name for kind, names in inventory.items() if kind.startswith("py:") for name in names}
	public = set(reference.names())
	words = (manual / "searchindex.js").read_text()
	print(f"{len(public)} classes, attributes and functions, {len(inventory['std:doc'])} pages")
	assert public <= listed, sorted(public - listed)
	assert all(word in words for word in ("thawstrain", "geostat", "courant")) and len(public) > 300
	assert (build / "manual" / "manual.pdf").read_bytes().startswith(b"%PDF")
	assert "yattr" not in "".join(page.read_text() for page in (manual / "reference").glob("*.html"))
