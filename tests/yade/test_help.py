# SPDX-License-Identifier: GPL-2.0-or-later
"""help() of every class and of the functions that users call: text, units, and an example, which is run as it stands."""

import doctest
import importlib
import inspect
import pydoc
import re
from pathlib import Path

import numpy as np
import pytest
import yade
from yade import O, utils, wrapper

import talik
from talik import plots, rve

ourClasses = sorted({cls for cls in vars(talik).values() if inspect.isclass(cls) and issubclass(cls, wrapper.Serializable)}, key=lambda cls: cls.__name__)
parts = {"files", "plausibility", "studies"}  # of other modules, not tools for scenes of one's own
tools = sorted({*talik._submodules} - parts | {"bodies", "inspection"} | {f"studies.{name}" for name in talik.studies.tools})
dimensional = re.compile(r"^(vector<)?(Real|Vector2r|Vector3r|Matrix3r)>?$")


def functions():
	for name, value in vars(talik).items():
		if inspect.isfunction(value) and value.__module__ == "talik" and not name.startswith("_"):
			yield pytest.param(value, id=f"talik.{name}")
	for name in tools:
		module = importlib.import_module("talik." + name)
		for key, value in vars(module).items():
			if (
				not key.startswith("_")
				and getattr(value, "__module__", None) == module.__name__
				and (inspect.isfunction(value) or inspect.isclass(value))
				and key != "main"
			):
				yield pytest.param(value, id=f"{name}.{key}")


def thawingGround(packed):
	mpm = wrapper.MpmEngine(
		gridSpacing=0.5,
		lower=(0, 0),
		upper=(1, 2),
		gravity=(0, -9.81),
		skeleton=wrapper.RveSkeleton(samples=[packed.copy()]),
		heat=wrapper.HeatTransfer(thermalTimeScale=1e8),
		freezing=wrapper.FreezingCurve(),
		boundaries=[
			wrapper.RollerBoundary(region="left"),
			wrapper.RollerBoundary(region="right"),
			wrapper.FixedBoundary(region="bottom"),
			wrapper.SurfaceTemperature(region="surface", times=[0, 1e5], values=[-1, 20]),
		],
	)
	talik.geometry.fill(mpm, talik.geometry.rectangle(0, 0, 1, 1), pointsPerCell=4, temperature=-1.0)
	return mpm


def compressedGround():
	"""Elastic ground whose stress grains can take over."""
	mpm = wrapper.MpmEngine(
		gridSpacing=0.5,
		lower=(0, 0),
		upper=(1, 2),
		skeleton=wrapper.ElasticSkeleton(),
		boundaries=[wrapper.FixedBoundary(region=side) for side in ("left", "right", "bottom", "top")],
	)
	talik.geometry.fill(mpm, talik.geometry.rectangle(0, 0, 1, 2), stress=(-80e3, -100e3, -90e3, 0))
	return mpm


@pytest.fixture(scope="module")
def sample(sampleCache):
	return rve.prepare(grains=30, porosity=0.19, cache=sampleCache)


@pytest.fixture
def names(sample, tmp_path, sampleCache, monkeypatch):
	"""What an example finds: a ground in mid-run in O, a sample in both forms, a picture to draw into, a folder."""
	monkeypatch.chdir(tmp_path)
	monkeypatch.delenv("TALIK_JUDGES", raising=False)
	monkeypatch.setenv("XDG_CACHE_HOME", str(sampleCache.parents[1]))
	packed = talik.rve.pack(sample)
	frozen = packed.copy()
	frozen.freeze(1)
	mpm, elastic = thawingGround(packed), compressedGround()
	elastic.initialise()
	O.reset()
	O.engines = [mpm]
	talik._talik.runSerially(3)
	return dict(
		vars(yade),
		O=O,
		talik=talik,
		np=np,
		utils=utils,
		mpm=mpm,
		elastic=elastic,
		sample=sample,
		packed=packed,
		frozen=frozen,
		axes=plots.figure(4, 4).subplots(),
		folder=str(tmp_path),
	)


def exampleOf(cls):
	"""The code at the end of a class's text."""
	found = re.search(r"Example[^:]*: (.*?)\.?\s*$", (cls.__doc__ or "").split("\n")[0])
	return found and found.group(1)


@pytest.mark.parametrize("cls", ourClasses, ids=lambda cls: cls.__name__)
def test_a_class_explains_itself_with_units_and_an_example_that_runs(cls, names):
	page = pydoc.plain(pydoc.render_doc(cls))
	example = exampleOf(cls)
	assert len(cls.__doc__) > 60 and example and example in page
	lacking = []
	for name, member in vars(cls).items():
		declared = isinstance(member, property) and re.search(r":yattrtype:`([^`]*)`", member.__doc__ or "")
		text = re.sub(r":y\w+:`[^`]*`", "", (member.__doc__ or "") if declared else "")
		if declared and dimensional.match(declared.group(1)) and "|yhidden|" not in text and not re.search(r"\[[^\]]+\]", text):
			lacking.append(name)
	assert not lacking, f"attributes of {cls.__name__} without a unit: {lacking}"
	if "MpmEngine(" in example:
		O.reset()
	if "mpm." in example and "watch" not in example or "mpm]" in example:  # effects are chosen before the first step
		names["mpm"] = compressedGround()
	exec(example, names)
	print(example)


@pytest.mark.parametrize("function", functions())
def test_a_tool_explains_itself_with_an_example_that_runs(function, names):
	text = inspect.getdoc(function) or ""
	assert len(text) > 20 and ">>> " in text, "no text or no example"
	heard = []
	test = doctest.DocTestParser().get_doctest(text, names, function.__qualname__, None, None)
	doctest.DocTestRunner(optionflags=doctest.NORMALIZE_WHITESPACE, verbose=False).run(test, out=heard.append)
	assert not heard, "".join(heard)


def test_every_method_of_a_tool_says_what_it_does():
	public = [(cls.values[0], name, member) for cls in functions() if inspect.isclass(cls.values[0]) for name, member in vars(cls.values[0]).items()]
	methods = [(cls.__name__, name, member) for cls, name, member in public if inspect.isfunction(member) and not name.startswith("_")]
	silent = [f"{cls}.{name}" for cls, name, member in methods if not inspect.getdoc(member)]
	print(f"{len(methods)} methods, {len(silent)} without a text")
	assert len(methods) > 20 and not silent


def test_settings_that_the_page_of_units_and_limits_names_exist():
	page = (Path(__file__).resolve().parents[2] / "examples" / "units-and-limits.md").read_text()
	code = re.findall(r"`([^`]+)`", page)
	calls = [text for text in code if re.fullmatch(r"[A-Z]\w+\(.+\)", text)]
	members = [text for text in code if re.fullmatch(r"[A-Z]\w+\.\w+", text)]
	for text in calls:
		eval(text, dict(vars(wrapper)))
	for text in members:
		cls, member = text.split(".")
		assert hasattr(getattr(wrapper, cls), member), text
	print(f"{len(calls)} settings and {len(members)} attributes, among them {calls[0]} and {members[0]}")
	assert len(calls) > 3 and len(members) > 3


def test_the_list_of_examples_is_complete():
	folder = Path(__file__).resolve().parents[2] / "examples"
	page = (folder / "README.md").read_text()
	scripts = {file.stem for file in folder.glob("*.py")}
	listed = set(re.findall(r"^\| `(\w+)` \|", page, re.M))
	pictures = set(re.findall(r"\]\((\w+\.png)\)", page))
	print(f"{len(scripts)} examples, {len(pictures)} pictures")
	assert listed == scripts and all((folder / picture).exists() for picture in pictures)


def test_a_result_far_from_that_by_hand_is_a_remark_and_ends_an_example_in_tests_only(monkeypatch, capsys):
	monkeypatch.delenv("TALIK_JUDGES", raising=False)
	talik.output.unexpected("half of it")
	assert capsys.readouterr().out == "Remark: half of it\n"
	monkeypatch.setenv("TALIK_JUDGES", "1")
	with pytest.raises(SystemExit, match="half of it"):
		talik.output.unexpected("half of it")
