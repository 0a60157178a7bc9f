# SPDX-License-Identifier: GPL-2.0-or-later
"""Files that are damaged, exchanged, in a folder that cannot be written, on a full disk, or programs in disguise."""

import builtins
import os
import random
import re
import resource
import shutil
import sys
from pathlib import Path

import numpy as np
import pytest
from fixtures import thirty
from yade import O, utils, wrapper

import talik
from talik import rve

sys.path.insert(0, str(Path(__file__).parent))
from breakingGround import breakingGround, run, stateOf

seed = random.SystemRandom().randrange(10**6)


def damaged(content, generator):
	"""One bit turned, one byte replaced, some cut off the end, or a stretch of it taken out."""
	content, place = bytearray(content), generator.randrange(len(content))
	kind = generator.randrange(4)
	if kind == 0:
		content[place] ^= 1 << generator.randrange(8)
	elif kind == 1:
		content[place] = (content[place] + generator.randrange(1, 256)) % 256
	elif kind == 2:
		del content[place:]
	else:
		del content[place : place + generator.randrange(1, 50)]
	return bytes(content)


@pytest.fixture
def cache(tmp_path, sampleCache):
	"""A folder of its own with one sample in it."""
	sample = rve.prepare(**thirty, cache=sampleCache)
	folder = tmp_path / "cache"
	folder.mkdir()
	for file in (sample.path, sample.path.replace(".yade.gz", ".json")):
		shutil.copy(file, folder)
	return folder


def found(folder):
	return rve.prepare(**thirty, cache=folder)


# ---- cached samples --------------------------------------------------------------------------------------------------------


def test_of_150_damaged_states_of_a_cached_sample_every_one_is_noticed(cache, capsys, monkeypatch):
	generator, made = random.Random(seed), []
	monkeypatch.setattr(rve, "_compacted", lambda *arguments: made.append(1) or (_ for _ in ()).throw(rve.PackingError("not here")))
	files = sorted(cache.iterdir())
	whole, harmless = found(cache), 0
	assert len(files) == 2 and not made
	for trial in range(150):
		file = files[trial % 5 == 0]  # the scene is the second
		file = files[1] if trial % 5 else files[0]
		content = file.read_bytes()
		harmed = damaged(content, generator)
		file.write_bytes(harmed)
		try:
			assert found(cache) == whole, f"seed {seed}, trial {trial}: the damage was not noticed"
			assert file is files[0] or harmed == content
			harmless += 1  # a blank of the sheet, or the folder in which it was written
		except rve.PackingError:
			pass
		file.write_bytes(content)
	said = capsys.readouterr().err
	print(f"seed {seed}: {len(made)} damaged sheets and scenes to be made anew, {harmless} that say the same; {said.splitlines()[0]}")
	assert said.count("is made anew") == len(made) == 150 - harmless >= 120


def test_a_damaged_cached_scene_is_made_anew_with_a_word_and_found_from_then_on(cache, capsys):
	scene = next(cache.glob("*.yade.gz"))
	scene.write_bytes(damaged(scene.read_bytes(), random.Random(1)))
	made = found(cache)
	said = capsys.readouterr().err
	print(said.strip())
	assert "is made anew" in said and str(scene) in said and abs(made.porosity - 0.19) < 0.005
	assert found(cache) == made and capsys.readouterr().err == ""
	assert talik.rve.pack(made).statistics()["contacts"] > 30


def test_a_scene_of_another_stress_under_the_key_of_this_one_is_not_taken(cache, sampleCache, capsys):
	other = rve.prepare(**thirty, pressure=110e3, cache=sampleCache)
	scene = next(cache.glob("*.yade.gz"))
	shutil.copy(other.path, scene)
	assert found(cache).pressure == pytest.approx(100e3, rel=0.01)
	assert "do not fit together" in capsys.readouterr().err
	shutil.copy(other.path, scene)  # with its sheet
	shutil.copy(other.path.replace(".yade.gz", ".json"), str(scene).replace(".yade.gz", ".json"))
	made = found(cache)
	with talik.scratchScene():
		rve.openFile(made.path)
		assert utils.getStress()[0, 0] == pytest.approx(-100e3, rel=0.02)
	assert "other parameters" in capsys.readouterr().err


unprivileged = 65534


def asNobody(work):
	"""What a user does who may not write here; root may, everywhere."""
	child = os.fork()
	if child == 0:
		code = 1
		try:
			os.setgid(unprivileged)
			os.setuid(unprivileged)
			code = work()
		except BaseException as failure:
			print(repr(failure), file=sys.stderr)
		finally:
			sys.stderr.flush()
			os._exit(code)
	return os.waitstatus_to_exitcode(os.waitpid(child, 0)[1])


def test_a_cache_that_cannot_be_written_but_holds_the_sample_is_used_and_one_that_does_not_is_named(cache, capfd):
	for folder in (cache, *list(cache.parents)[:-2]):
		folder.chmod(0o755)
	cache.chmod(0o555)

	def look():
		assert found(cache).grains == 30
		try:
			rve.prepare(grains=31, porosity=0.19, cache=cache)
		except RuntimeError as refusal:
			print(refusal, file=sys.stderr)
			return 7
		return 3

	if os.getuid() == 0:
		assert asNobody(look) == 7
	else:
		assert look() == 7
	assert f"'{cache}' cannot be written" in capfd.readouterr().err


# ---- files of O.save -------------------------------------------------------------------------------------------------------


def savedGround(sample, file):
	mpm = breakingGround(sample, spacing=1.0)
	run(5)
	O.save(str(file), quiet=True)
	return stateOf(mpm)


@pytest.mark.parametrize("kind", ["yade", "xml", "yade.gz", "xml.bz2"])
def test_damaged_states_of_a_saved_ground_are_refused_before_boost_or_hold_the_same_numbers(kind, tmp_path, smallSample):
	file = tmp_path / f"ground.{kind}"
	whole = savedGround(smallSample, file)
	content, generator, refused, same = file.read_bytes(), random.Random(seed), [], 0
	for trial in range(100):
		harmed = damaged(content, generator)
		if harmed == content:
			continue
		file.write_bytes(harmed)
		try:
			O.load(str(file), quiet=True)
		except (ValueError, RuntimeError) as refusal:
			refused.append(str(refusal))
			continue
		same += 1
		loaded = stateOf(O.engines[0])
		assert all(
			np.array_equal(whole[name], loaded[name], equal_nan=True) for name in ("position", "stress", "enthalpy", "pressure")
		), f"seed {seed}, trial {trial}"
	print(f"{kind}, seed {seed}: {len(refused)} refused, {same} with the same numbers (damage to a name or a date in the packed file's head)")
	assert len(refused) >= 97 and all(str(file) in sentence and "is damaged" in sentence for sentence in refused)


def test_a_saved_ground_that_is_cut_off_within_its_last_tags_is_refused_and_without_its_checksum_it_is_read(tmp_path, smallSample):
	file = tmp_path / "ground.xml"
	whole = savedGround(smallSample, file)
	content = file.read_bytes()
	scene = content[: content.rindex(b"</boost_serialization>") + len(b"</boost_serialization>")]
	for cut in range(1, 50):
		file.write_bytes(scene[:-cut])
		with pytest.raises(ValueError, match="is damaged or cut off"):
			O.load(str(file), quiet=True)
	file.write_bytes(scene + b"\n")
	O.load(str(file), quiet=True)
	loaded = stateOf(O.engines[0])
	assert all(np.array_equal(whole[name], loaded[name], equal_nan=True) for name in ("position", "stress", "enthalpy", "pressure"))


@pytest.mark.parametrize("kind", ["yade", "xml", "yade.gz"])
def test_a_saved_ground_is_a_plain_file_of_yade_and_goes_on(kind, tmp_path, smallSample):
	file = tmp_path / f"ground.{kind}"
	whole = savedGround(smallSample, file)
	for load in (O.load, O._stockLoad):  # the second is how a yade that knows no checksum reads it
		O.reset()
		(O.load if load is O.load else lambda name, quiet: type(O)._stockLoad(O, name, quiet))(str(file), quiet=True)
		O.engines[0].initialise()
		assert np.array_equal(O.engines[0].field("stress"), whole["stress"])


def test_a_state_within_a_file_of_text_is_refused_if_it_or_its_points_were_changed_by_hand(tmp_path, smallSample):
	file = tmp_path / "ground.xml"
	savedGround(smallSample, file)
	text = talik.files.sceneContent(file).decode()
	state = text.index("<saved>", text.index("<MpmEngine") if "<MpmEngine" in text else text.index("MpmEngine")) + 200
	points = re.compile(r"<item>(?=[-\d])").search(text, text.index("<columns")).end()
	for place in (state, points):
		changed = text[:place] + ("7" if text[place] != "7" else "8") + text[place + 1 :]
		file.write_text(changed)
		with pytest.raises(RuntimeError, match="damaged"):
			O.load(str(file), quiet=True)
			O.engines[0].initialise()


def test_a_scene_without_anything_of_ours_is_saved_as_yade_saves_it(tmp_path):
	O.bodies.append(utils.sphere((0, 0, 0), 1))
	O.save(str(tmp_path / "a.xml"), quiet=True)
	type(O)._stockSave(O, str(tmp_path / "b.xml"), True)
	assert (tmp_path / "a.xml").read_bytes() == (tmp_path / "b.xml").read_bytes()


# ---- names, links, disks ---------------------------------------------------------------------------------------------------


def test_files_written_beside_others_have_no_foreseeable_name_follow_no_link_and_remove_nothing_of_the_users(tmp_path, smallSample):
	mpm = breakingGround(smallSample, spacing=1.0)
	run(2)
	precious = tmp_path / "precious"
	precious.write_text("mine")
	frames = talik.output.Frames(mpm, times=[0])
	frames.take()
	writers = {
		"x.checkpoint": talik.checkpoint.write,
		"x.npz": frames.save,
		"x.json": lambda file: talik.output.writeSummary(file, a=1),
		"x.txt": lambda file: talik.files.writeWhole(file, "text"),
	}
	for name, write in writers.items():
		file = tmp_path / name
		traps = [tmp_path / (name + ".part"), file.with_suffix(".part.npz"), file.with_suffix(".part")]
		for number, trap in enumerate(traps):
			if trap.exists() or trap.is_symlink():
				continue
			trap.symlink_to(precious) if number % 2 == 0 else trap.write_text("mine")
		write(file)
		assert file.stat().st_size > 3 and not file.is_symlink()
		assert precious.read_text() == "mine" and all(trap.read_text() == "mine" for trap in traps)
		for trap in traps:
			trap.unlink(missing_ok=True)
		file.unlink()
		file.symlink_to(precious)  # the file itself: replaced, not written through
		write(file)
		assert precious.read_text() == "mine" and not file.is_symlink()
	left = sorted(path.name for path in tmp_path.iterdir())
	print("left in the folder:", left)
	assert left == sorted([*writers, "precious"])


def test_the_folder_of_blown_up_samples_is_not_written_through_a_link(tmp_path, smallSample):
	precious, folder = tmp_path / "precious", tmp_path / "blown"
	precious.write_text("mine")
	folder.mkdir()
	(folder / "point5.yade").symlink_to(precious)
	mpm = breakingGround(smallSample, blowUpFolder=str(folder))
	run(5)
	bad = mpm.skeleton.sample(5)
	bad.dt *= 60
	mpm.skeleton.replaceSample(5, bad)
	with pytest.raises(RuntimeError, match="blew up"):
		run(40)
	assert precious.read_text() == "mine" and (folder / "point5.yade").stat().st_size > 1000


def test_a_full_disk_says_so_whatever_is_written(tmp_path, smallSample):
	mpm = breakingGround(smallSample)
	run(2)
	frames = talik.output.Frames(mpm, times=[0])
	frames.take()
	writers = {
		"checkpoint": talik.checkpoint.write,
		"frames.npz": frames.save,
		"summary.json": lambda file: talik.output.writeSummary(file, text="x" * 9000),
		"scene.yade": lambda file: O.save(str(file), quiet=True),
		"scene.yade.gz": lambda file: O.save(str(file), quiet=True),
	}
	soft, hard = resource.getrlimit(resource.RLIMIT_FSIZE)
	for name, write in writers.items():
		with pytest.raises(RuntimeError) as full:
			resource.setrlimit(resource.RLIMIT_FSIZE, (6000, hard))
			try:
				write(tmp_path / name)
			finally:
				resource.setrlimit(resource.RLIMIT_FSIZE, (soft, hard))
		print(full.value)
		assert name in str(full.value) and "written" in str(full.value)
	assert not [path for path in tmp_path.iterdir() if path.suffix == ".part"]


# ---- programs in disguise --------------------------------------------------------------------------------------------------

poison = "broken=1; import builtins; builtins.poisoned = True; broken"


@pytest.fixture
def unpoisoned():
	yield
	poisonedBy = hasattr(builtins, "poisoned")
	if poisonedBy:
		del builtins.poisoned
	assert not poisonedBy, "the label ran as a program"


def withLabel(label):
	functor = wrapper.Ip2_FrictMat_FrictMat_FrictPhys()
	engine = wrapper.InteractionLoop([wrapper.Ig2_Sphere_Sphere_ScGeom()], [functor], [wrapper.Law2_ScGeom_FrictPhys_CundallStrack()])
	return engine, functor


@pytest.mark.parametrize("holder", ["engine", "functor"])
@pytest.mark.parametrize("label", [poison, "class", "print", "a.b", "a b"])
def test_a_label_that_is_no_name_is_refused_and_not_run(label, holder, tmp_path, smallSample, unpoisoned):
	with talik.scratchScene():
		O.periodic = True
		O.bodies.append(utils.sphere((0, 0, 0), 0.1))
		engine, functor = withLabel(label)
		O.engines = [engine]
		(engine if holder == "engine" else functor).label = label
		type(O)._stockSave(O, str(tmp_path / "scene.yade.gz"), True)
		wrapper.Checkpoint.write(str(tmp_path / "scene.checkpoint"))
	before = talik._talik.currentScene()
	for take in (lambda: rve.load(tmp_path / "scene.yade.gz"), lambda: talik.resume(tmp_path / "scene.checkpoint")):
		with pytest.raises(ValueError, match="which is no name") as refusal:
			take()
	print(refusal.value)
	assert talik._talik.sameObject(before, talik._talik.currentScene())


def test_a_label_that_is_a_name_becomes_one(tmp_path):
	O.engines = [wrapper.PyRunner(command="pass", iterPeriod=1, label="myRunner")]
	talik.checkpoint.write(tmp_path / "x")
	O.reset()
	talik.resume(tmp_path / "x")
	assert builtins.myRunner.command == "pass"
