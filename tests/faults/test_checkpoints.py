# SPDX-License-Identifier: GPL-2.0-or-later
"""A run goes on from its last checkpoint as if it had never been stopped, whatever stopped it; a file that is no whole checkpoint is
refused by a sentence and changes nothing."""

import os
import random
import resource
import shutil
import signal
import subprocess
import sys
import time
from pathlib import Path

import numpy as np
import pytest
from yade import O, wrapper

import talik

sys.path.insert(0, str(Path(__file__).parent))
from breakingGround import breakingGround, largestDifference, run, stateOf


def dryGround():
	mpm = wrapper.MpmEngine(
		gridSpacing=0.25,
		lower=(0, 0),
		upper=(1, 1.5),
		gravity=(0, -9.81),
		skeleton=wrapper.ElasticSkeleton(young=5e6),
		boundaries=[wrapper.FixedBoundary(region="bottom")],
	)
	talik.geometry.fill(mpm, [(0, 0), (1, 0), (1, 1), (0, 1)])
	O.engines = [mpm]
	return mpm


# ---- when it is written ---------------------------------------------------------------------------------------------------


@pytest.mark.parametrize("number", [signal.SIGUSR1, signal.SIGUSR2])
def test_a_signal_writes_a_checkpoint_at_the_next_step_and_the_run_goes_on(number, tmp_path):
	dryGround()
	keeper = talik.checkpoint.keep(tmp_path / "ground.checkpoint", onSignal=number)
	run(3)
	before = keeper.written
	os.kill(os.getpid(), number)
	run(3)
	step = talik.checkpoint.describe(tmp_path / "ground.checkpoint")["step"]
	print(f"{before} checkpoints before the signal, {keeper.written} after it, of step {step}; O.iter {O.iter}")
	assert (before, keeper.written, step, O.iter) == (0, 1, 3, 6)


def test_a_signal_that_would_end_the_process_is_refused(tmp_path):
	dryGround()
	talik.checkpoint.keep(tmp_path / "ground.checkpoint", onSignal=signal.SIGKILL)
	with pytest.raises((ValueError, RuntimeError), match="Checkpoint.onSignal is 9: give signal.SIGUSR1"):
		run(1)


# ---- continued is uninterrupted -------------------------------------------------------------------------------------------


def test_packed_samples_in_mid_break_go_on_to_the_last_bit_with_another_number_of_threads(tmp_path, smallSample):
	file = tmp_path / "ground.checkpoint"
	mpm = breakingGround(smallSample)
	run(25)
	broken = np.nansum(mpm.field("bondsBroken"))
	talik.checkpoint.write(file)
	run(25)
	through, brokenThen = stateOf(mpm), np.nansum(mpm.field("bondsBroken"))
	O.reset()
	mpm = talik.resume(file)
	mpm.skeleton.threads = 2
	run(25)
	difference = largestDifference(through, stateOf(mpm))
	print(
		f"{mpm.pointCount} points, bonds broken {broken:.0f} at the checkpoint, {brokenThen:.0f} at the end; melted {np.nansum(mpm.field('bondsMelted')):.0f}"
	)
	print(f"largest difference over {len(through)} fields, balances and whole samples: {difference}")
	assert 0 < broken < brokenThen
	assert difference == 0


def test_ground_with_a_tolerance_goes_on_to_the_last_bit_with_another_number_of_threads(tmp_path, smallSample):
	file = tmp_path / "ground.checkpoint"
	mpm = breakingGround(smallSample)
	mpm.tolerance = 0.03
	run(25)
	talik.checkpoint.write(file)
	run(25)
	through, estimated = stateOf(mpm), mpm.estimatedError
	O.reset()
	mpm = talik.resume(file)
	mpm.skeleton.threads = 2
	run(25)
	difference = largestDifference(through, stateOf(mpm))
	print(
		f"largest difference over {len(through)} fields, balances and whole samples: {difference}; estimated error {estimated:.4f}, and {mpm.estimatedError:.4f}"
	)
	assert difference == 0 and mpm.estimatedError == estimated > 0


def test_the_checkpoint_that_the_engine_keeps_is_the_state_between_two_steps(tmp_path, smallSample):
	file = tmp_path / "made" / "ground.checkpoint"
	breakingGround(smallSample)
	keeper = talik.checkpoint.keep(file, every=0)
	run(8)
	through = stateOf(O.engines[1])
	assert keeper.written == 8 and keeper.failures == 0 and not list(file.parent.glob("*.part"))
	O.reset()
	mpm = talik.resume(file)
	print(f"after 8 steps the file holds step {O.iter}, {talik.checkpoint.describe(file)['bytes'] / 1e3:.0f} kB")
	assert O.iter == 7 and mpm.time == O.time and O.subStep == -1
	assert type(O.engines[0]) is wrapper.Checkpoint and O.engines[0].file == str(file)
	run(1)
	assert largestDifference(through, stateOf(mpm)) == 0


def test_a_checkpoint_of_every_hour_is_not_written_in_a_second_and_one_of_every_instant_is_written_in_each_step(tmp_path):
	dryGround()
	keeper = talik.checkpoint.keep(tmp_path / "ground.checkpoint", every=3600)
	run(50)
	assert keeper.written == 0 and not list(tmp_path.iterdir())
	keeper.every = 1e-9
	run(50)
	print(f"{keeper.written} checkpoints in the 50 steps after the interval went from 3600 s to 1e-9 s")
	assert keeper.written == 50


def test_open_samples_go_on_within_the_accuracy_of_yades_own_archives(tmp_path, smallSample):
	file = tmp_path / "ground.checkpoint"
	mpm = breakingGround(smallSample, spacing=1.0, form="open")
	run(6)
	talik.checkpoint.write(file)
	run(6)
	stress, position = mpm.field("stress"), mpm.field("position")
	O.reset()
	mpm = talik.resume(file)
	run(6)
	error = np.abs(mpm.field("stress") - stress).max() / np.abs(stress).max()
	print(f"relative difference of stress after 6 more steps with open samples: {error:.1e}; tolerance 1e-6")
	assert mpm.skeleton.cost()["form"] == "open"
	assert error < 1e-6 and np.abs(mpm.field("position") - position).max() < 1e-9


def test_without_a_checkpoint_engine_nothing_is_written(tmp_path):
	os.chdir(tmp_path)
	dryGround()
	run(5)
	assert not list(tmp_path.iterdir()) and b"Checkpoint" not in O.sceneToString()


def test_a_saved_ground_does_not_hold_its_archive_in_memory():
	mpm = dryGround()
	run(3)
	first = len(O.sceneToString())
	assert len(O.sceneToString()) == first
	text = O.sceneToString()
	O.stringToScene(text)
	second = len(O.sceneToString())  # loaded and not yet begun: its archive is all it has
	print(f"archive {first} bytes, saved again before its first step {second} bytes")
	assert second == first
	run(1)
	assert O.engines[0].time > 0 and mpm is not O.engines[0]


# ---- files that are none --------------------------------------------------------------------------------------------------


@pytest.fixture
def checkpoint(tmp_path):
	dryGround()
	run(4)
	file = tmp_path / "ground.checkpoint"
	talik.checkpoint.write(file)
	return file


def refusal(file):
	"""The sentence by which resume() refuses a file; the scene before it must go on."""
	scene, step = O._sceneObj, O.iter
	with pytest.raises(ValueError) as refused:
		talik.resume(file)
	assert O._sceneObj is scene or O.iter == step
	run(1)
	assert O.iter == step + 1
	return str(refused.value)


def test_truncated_and_damaged_files_are_refused_by_a_sentence(checkpoint):
	whole = checkpoint.read_bytes()
	damaged = checkpoint.with_name("damaged")
	generator = random.Random(1)
	for length in (0, 1, 100, 4095, 4096, 4097, len(whole) // 2, len(whole) - 1):
		damaged.write_bytes(whole[:length])
		sentence = refusal(damaged)
		assert "truncated" in sentence or ("not a checkpoint" in sentence and length < 16), sentence
	for place in (4096, len(whole) - 1, *(generator.randrange(4096, len(whole)) for _ in range(20))):
		damaged.write_bytes(whole[:place] + bytes([whole[place] ^ (1 << generator.randrange(8))]) + whole[place + 1 :])
		assert "checksum does not fit" in refusal(damaged)
	damaged.write_bytes(whole + b"x")
	print(refusal(damaged))
	damaged.write_bytes(whole[: len(whole) // 2])
	print(refusal(damaged))


def test_foreign_and_missing_files_are_refused_by_a_sentence(checkpoint, tmp_path):
	foreign = tmp_path / "foreign"
	for content in (b"", b"\0" * 10000, b"some text\n" * 1000, os.urandom(9000)):
		foreign.write_bytes(content)
		assert "not a checkpoint" in refusal(foreign)
	O.save(str(tmp_path / "scene.yade"), quiet=True)
	for path in (tmp_path / "scene.yade", tmp_path, tmp_path / "missing"):
		print(refusal(path))


def test_another_version_is_read_where_it_can_be_and_named_where_it_cannot(checkpoint):
	whole = checkpoint.read_bytes()
	other = checkpoint.with_name("other")

	def changed(old, new):
		assert whole.count(old, 0, 4096) == 1
		head = whole[:4096].replace(old, new)
		other.write_bytes(head[:4096].ljust(4096) + whole[4096:])

	def digestOf(name):
		line = next(line for line in whole[:4096].splitlines() if line.startswith(b"class " + name + b" "))
		return line

	changed(b"format 3", b"format 0")
	print(refusal(other))
	changed(digestOf(b"MpmEngine"), b"class MpmEngine 00000000")
	sentence = refusal(other)
	print(sentence)
	assert "MpmEngine" in sentence and "other attributes" in sentence
	changed(digestOf(b"GrainSwelling"), b"class GrainSwelling 00000000")  # not in this scene
	assert talik.resume(other).time > 0


@pytest.mark.parametrize(
	"settings, what",
	[
		(dict(file=""), "Checkpoint.file is empty"),
		(dict(file="/proc/none/x"), "Checkpoint.file is '/proc/none/x'"),
		(dict(file="/tmp"), "Checkpoint.file is '/tmp', a folder"),
		(dict(file="talik.checkpoint", every=-1), "Checkpoint.every is -1"),
		(dict(file="talik.checkpoint", every=float("nan")), "Checkpoint.every is nan"),
	],
)
def test_what_a_checkpoint_cannot_do_is_said_before_the_run(settings, what):
	mpm = dryGround()
	O.engines = [wrapper.Checkpoint(**settings), mpm]
	with pytest.raises(ValueError) as refused:
		O.step()
	print(refused.value)
	assert what in str(refused.value)


def test_a_checkpoint_in_the_midst_of_a_step_is_refused(tmp_path):
	mpm = dryGround()
	O.engines = [mpm, wrapper.Checkpoint(file=str(tmp_path / "x"))]
	with pytest.raises(ValueError, match="not the first of O.engines"):
		O.step()


# ---- disk and folder ------------------------------------------------------------------------------------------------------


def keepThrough(file, harm, repair):
	"""Ten steps with a checkpoint in each, the middle ones under harm; returns the engine as it was under harm."""
	dryGround()
	run(9)
	alone = stateOf(O.engines[0])
	O.reset()
	dryGround()
	keeper = talik.checkpoint.keep(file, every=0)
	run(3)
	harm()
	run(3)
	under = keeper.failures, keeper.problem
	repair()
	run(3)
	assert largestDifference(alone, stateOf(O.engines[1])) == 0
	assert keeper.problem == "" and not list(Path(file).parent.glob("*.part"))
	O.reset()
	assert talik.resume(file).time == O.time > 0 and O.iter == 8
	return under


def test_a_disk_that_is_full_while_writing_leaves_the_last_checkpoint_and_the_run(tmp_path):
	file = tmp_path / "ground.checkpoint"
	soft, hard = resource.getrlimit(resource.RLIMIT_FSIZE)
	steps = []

	def fill():
		resource.setrlimit(resource.RLIMIT_FSIZE, (6000, hard))

	def free():
		steps.append(talik.checkpoint.describe(file)["step"])
		resource.setrlimit(resource.RLIMIT_FSIZE, (soft, hard))

	try:
		failures, problem = keepThrough(file, fill, free)
	finally:
		resource.setrlimit(resource.RLIMIT_FSIZE, (soft, hard))
	print(f"{problem}; {failures} attempts failed, the file held step {steps[0]} all the while")
	assert failures == 3 and steps[0] == 2 and "could not be written" in problem


def test_a_full_file_system_leaves_the_last_checkpoint_and_the_run(tmp_path):
	if subprocess.run(["mount", "-t", "tmpfs", "-o", "size=128k", "none", str(tmp_path)], capture_output=True).returncode:
		pytest.skip("no right to mount a small file system here; the limit of file size above stands for it")
	ballast = tmp_path / "ballast"

	def fill():
		with pytest.raises(OSError), open(ballast, "wb", buffering=0) as handle:
			while handle.write(b"x" * 1024):
				pass

	try:
		failures, problem = keepThrough(tmp_path / "ground.checkpoint", fill, ballast.unlink)
	finally:
		subprocess.run(["umount", "-l", str(tmp_path)], check=True)
	print(problem)
	assert failures == 3 and "No space left" in problem


def test_a_folder_that_is_removed_is_made_anew(tmp_path):
	folder = tmp_path / "output"
	failures, _ = keepThrough(folder / "ground.checkpoint", lambda: shutil.rmtree(folder), lambda: None)
	assert failures == 0


def test_a_folder_that_cannot_be_made_anew_does_not_stop_the_run(tmp_path):
	folder, aside = tmp_path / "output", tmp_path / "aside"

	def harm():
		folder.rename(aside)
		folder.write_text("in the way")

	def repair():
		assert talik.checkpoint.describe(aside / "ground.checkpoint")["step"] == 2
		folder.unlink()

	failures, problem = keepThrough(folder / "ground.checkpoint", harm, repair)
	print(problem)
	assert failures == 3


# ---- killed ---------------------------------------------------------------------------------------------------------------

kills = 20


def goOn(file, steps, sample, ready, result):
	"""What a process does that will be killed: go on from the last checkpoint, or begin."""
	mpm = talik.resume(file) if file.exists() else breakingGround(sample)
	if not any(isinstance(engine, wrapper.Checkpoint) for engine in O.engines):
		talik.checkpoint.keep(file, every=0)
	os.write(ready, b"!")
	run(steps - O.iter)
	np.savez(result, **stateOf(mpm))


def test_a_run_killed_at_twenty_random_moments_ends_as_if_it_had_not_been(tmp_path, smallSample):
	seed = random.SystemRandom().randrange(10**6)
	generator = random.Random(seed)
	file, result = tmp_path / "ground.checkpoint", tmp_path / "result.npz"
	steps = 1000  # the kills leave time for far fewer, also where this process is woken late beside others
	mpm = breakingGround(smallSample)
	run(steps)
	through = stateOf(mpm)
	talik.checkpoint.keep(tmp_path / "timing", every=0)
	run(1)
	times = []
	for _ in range(10):
		begin = time.monotonic()
		run(1)
		times.append(time.monotonic() - begin)
	perStep = sorted(times)[2]  # other tests begin beside this one
	O.reset()
	O.engines = []
	stepsFound, torn = [], 0
	while True:
		reader, writer = os.pipe()
		child = os.fork()
		if child == 0:
			try:
				goOn(file, steps, smallSample, writer, result)
			finally:
				os._exit(0)
		os.close(writer)
		os.read(reader, 1)
		os.close(reader)
		if len(stepsFound) < kills:
			time.sleep(generator.uniform(0, 24 * perStep))
			os.kill(child, signal.SIGKILL)
		_, status = os.waitpid(child, 0)
		if len(stepsFound) == kills:
			break
		assert os.WIFSIGNALED(status), "the run ended before it was killed"
		torn += bool(list(tmp_path.glob("*.part")))
		stepsFound.append(talik.checkpoint.describe(file)["step"] if file.exists() else -1)
	found = dict(np.load(result))
	print(f"seed {seed}; killed {kills} times, {torn} times while writing; the checkpoints held the steps {stepsFound}")
	difference = largestDifference(through, found)
	print(f"largest difference to the uninterrupted run of {steps} steps: {difference}")
	assert stepsFound == sorted(stepsFound) and stepsFound[-1] > stepsFound[0]
	assert difference == 0


wholeYade = """
import sys
sys.path.insert(0, {folder!r})
import os, numpy as np, talik
from pathlib import Path
from yade import O, wrapper
from breakingGround import breakingGround, stateOf
file, steps = Path({file!r}), {steps}
if file.exists():
	mpm = talik.resume(file)
else:
	mpm = breakingGround(wrapper.RveSample.fromScene(wrapper.Checkpoint.read({sample!r})))
	if {every} is not None:
		talik.checkpoint.keep(file, every={every})
print("READY", O.iter, flush=True)
if O.iter < steps:
	O.run(steps - O.iter, True)
np.savez({result!r}, **stateOf(mpm))
print("DONE", flush=True)
os._exit(0)
"""


def test_whole_yades_with_two_threads_killed_at_twenty_random_moments_end_as_one_that_was_not_slow(tmp_path, smallSample):
	seed = random.SystemRandom().randrange(10**6)
	generator = random.Random(seed)
	steps, sample = 3000, str(tmp_path / "sample.checkpoint")
	with talik.inspect(smallSample.open()):
		talik.checkpoint.write(sample)

	def start(name, threads, every):
		script = tmp_path / f"{name}.py"
		values = dict(
			folder=str(Path(__file__).parent),
			file=str(tmp_path / f"{name}.checkpoint"),
			steps=steps,
			sample=sample,
			every=every,
			result=str(tmp_path / f"{name}.npz"),
		)
		script.write_text(wholeYade.format(**values))
		return subprocess.Popen(["yade", "-n", "-x", f"-j{threads}", str(script)], stdout=subprocess.PIPE, stderr=subprocess.DEVNULL, text=True)

	def await_(process, word):
		for line in process.stdout:
			if line.startswith(word):
				return line
		raise AssertionError(f"a yade ended before it said {word}")

	single = start("single", 1, None)
	await_(single, "READY")
	begin = time.monotonic()
	await_(single, "DONE")
	runTime = time.monotonic() - begin
	found = []
	for _ in range(kills):
		process = start("killed", 2, 0.02)
		found.append(int(await_(process, "READY").split()[1]))
		time.sleep(generator.uniform(0, 1.5 * runTime / kills))
		process.send_signal(signal.SIGKILL)
		process.wait()
	await_(start("killed", 2, 0.02), "DONE")
	print(f"seed {seed}; killed {kills} times, runs went on from the steps {found}")
	difference = largestDifference(dict(np.load(tmp_path / "single.npz")), dict(np.load(tmp_path / "killed.npz")))
	print(f"largest difference between two threads killed and one thread uninterrupted after {steps} steps: {difference}")
	assert difference == 0 and found[-1] > 0


# ---- Ctrl-C ---------------------------------------------------------------------------------------------------------------

interruptible = """
import os, signal, talik
from yade import O, wrapper
signal.signal(signal.SIGINT, signal.default_int_handler)  # ignored where the tests run in the background of a shell
mpm = wrapper.MpmEngine(gridSpacing=0.25, lower=(0, 0), upper=(1, 1.5), gravity=(0, -9.81), skeleton=wrapper.ElasticSkeleton(young=5e6),
	boundaries=[wrapper.FixedBoundary(region="bottom")])
talik.geometry.fill(mpm, [(0, 0), (1, 0), (1, 1), (0, 1)])
O.engines = [mpm]
O.step()
def byRun(): O.run(10**9, True)
def byWait(): O.run(); O.wait()
for how in (byRun, byWait):
	try:
		print("READY", flush=True)
		how()
		print("NOT STOPPED", flush=True)
	except KeyboardInterrupt:
		before = O.iter
		between = not O.running and O.subStep == -1 and abs(mpm.time - O.time) <= 1e-9 * O.time
		talik.checkpoint.write({file!r})
		O.run(10, True)
		print("STOPPED", between, before > 1, O.iter - before, flush=True)
print("END", flush=True)
os._exit(0)
"""


def test_ctrl_c_stops_between_two_steps_and_leaves_a_usable_scene(tmp_path):
	script = tmp_path / "script.py"
	script.write_text(interruptible.format(file=str(tmp_path / "x.checkpoint")))
	process = subprocess.Popen(["yade", "-n", "-x", str(script)], stdout=subprocess.PIPE, stderr=subprocess.DEVNULL, text=True)
	stopped, waits = [], []
	for line in process.stdout:
		if line.startswith("READY"):
			time.sleep(0.3)
			process.send_signal(signal.SIGINT)
			begin = time.monotonic()
		if line.startswith(("STOPPED", "NOT STOPPED")):
			waits.append(time.monotonic() - begin)
			stopped.append(line.split())
	print(f"O.run(n, True) and O.wait() came back {waits[0]:.2f} s and {waits[1]:.2f} s after Ctrl-C, ten more steps included")
	assert stopped == 2 * [["STOPPED", "True", "True", "10"]]
	assert talik.checkpoint.describe(tmp_path / "x.checkpoint")["step"] > 0
