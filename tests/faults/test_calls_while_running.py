# SPDX-License-Identifier: GPL-2.0-or-later
"""Python asks and changes while O runs in another thread. Each case is a yade of its own: what fails here ends the process."""

import random
import subprocess
from pathlib import Path

import pytest

import talik

here = Path(__file__).parent

header = """
import os, random, sys, threading, time
sys.path.insert(0, {here!r})
import numpy as np
import talik
from yade import Matrix3, O, wrapper
from breakingGround import breakingGround

def ended():
	print("LIVES", flush=True)
	os._exit(0)

sample = wrapper.RveSample.fromScene(wrapper.Checkpoint.read({sample!r}))
"""


@pytest.fixture(scope="module")
def sampleFile(smallSample, tmp_path_factory):
	"""The sample for a yade of its own, which has none of this one's objects."""
	file = tmp_path_factory.mktemp("sample") / "sample.checkpoint"
	former = talik._talik.exchangeScene(smallSample.open())
	try:
		talik.checkpoint.write(file)
	finally:
		talik._talik.exchangeScene(former)
	return str(file)


def lives(folder, body, sample, threads=1):
	"""Runs a script in a yade of its own, which has to reach its end; returns what it printed."""
	script = folder / "script.py"
	script.write_text(header.format(here=str(here), sample=sample) + body + "\nended()\n")
	run = subprocess.run(["yade", "-n", "-x", f"-j{threads}", str(script)], capture_output=True, text=True, timeout=600, cwd=folder)
	assert run.returncode == 0 and "LIVES" in run.stdout, f"ended with {run.returncode}:\n{run.stdout[-2000:]}\n{run.stderr[-3000:]}"
	return run.stdout


def figures(output):
	return [line for line in output.splitlines() if line.startswith("FIGURES")]


dry = """
mpm = wrapper.MpmEngine(
	gridSpacing=0.25, lower=(0, 0), upper=(2, 2), gravity=(0, -9.81), damping=0.3, skeleton=wrapper.ElasticSkeleton(),
	boundaries=[wrapper.FixedBoundary(region="bottom")],
)
talik.geometry.fill(mpm, [(0, 0), (1, 0), (1, 1), (0, 1)])
O.engines = [mpm]
O.run(3, True)
"""


def test_watching_points_and_reading_their_histories_while_O_runs_does_not_end_yade(tmp_path, sampleFile):
	output = lives(
		tmp_path,
		dry
		+ """
O.run()
end, calls = time.monotonic() + 1, 0
while time.monotonic() < end:
	mpm.watch(list(range(random.randrange(1, 60))), fields=random.choice([[], ["stress"], ["position", "velocity"]]))
	histories = [mpm.history(0) for _ in range(20)]
	assert all(len(column) == len(h["time"]) for h in histories for column in h.values())
	mpm.watched and (mpm.watched.times, mpm.watched.fields)
	calls += 22
O.pause()
print("FIGURES", O.iter, "steps,", calls, "calls")
assert O.iter > 100
""",
		sampleFile,
	)
	print(*figures(output))


def test_watching_points_at_once_after_a_pause_does_not_end_yade(tmp_path, sampleFile):
	output = lives(
		tmp_path,
		dry
		+ """
for k in range(60):
	O.run()
	time.sleep(0.002)
	O.pause()
	mpm.watch(range(k % 60 + 1))
	mpm.history(0)
print("FIGURES", O.iter, "steps, 60 pauses")
""",
		sampleFile,
	)
	print(*figures(output))


@pytest.mark.parametrize("form", ["packed", "open"])
def test_samples_replaced_while_O_runs_do_not_end_yade(form, tmp_path, sampleFile):
	output = lives(
		tmp_path,
		f"""
mpm = breakingGround(sample, spacing={0.5 if form == 'packed' else 1.0}, form={form!r}, onBlowUp="isolate", blowUpFolder="")
mpm.damping = 0.5
O.run(3, True)
O.run()
law, end, calls = mpm.skeleton, time.monotonic() + 1, 0
while time.monotonic() < end:
	point = random.randrange(mpm.pointCount)
	law.replaceSample(point, law.sample(point))
	law.replaceScene(point, law.scene(point))
	law.values("bondsIntact"), mpm.field("bondsBroken")
	calls += 6
	assert not mpm.failure, mpm.failure
O.pause()
print("FIGURES", O.iter, "steps,", calls, "calls")
""",
		sampleFile,
	)
	print(*figures(output))


def test_a_checkpoint_or_a_look_at_once_after_a_pause_is_that_of_a_whole_step(tmp_path, sampleFile):
	output = lives(
		tmp_path,
		dry
		+ """
O.engines = [mpm, wrapper.PyRunner(command="time.sleep(0.01)", iterPeriod=1)]
for k in range(20):
	O.run()
	time.sleep(0.013)
	O.pause()
	talik.checkpoint.write("x")
	step = talik.checkpoint.describe("x")["step"]
	assert O.subStep == -1 and step == O.iter, (O.subStep, step, O.iter)
	assert abs(mpm.time - O.time) < 1e-9 * O.time, (mpm.time, O.time)
print("FIGURES", O.iter, "steps, 20 checkpoints")
""",
		sampleFile,
	)
	print(*figures(output))


def test_two_threads_that_ask_do_not_keep_the_run_out_nor_it_them(tmp_path, sampleFile):
	output = lives(
		tmp_path,
		dry
		+ """
begin = time.monotonic()
O.run(2000, True)
alone = time.monotonic() - begin
calls, stop = [0, 0], []
def ask(k):
	while not stop:
		mpm.balance()
		calls[k] += 1
threads = [threading.Thread(target=ask, args=(k,)) for k in (0, 1)]
for thread in threads:
	thread.start()
before, begin = O.iter, time.monotonic()
O.run(2000)
while O.running:
	time.sleep(0.01)
wall = time.monotonic() - begin
stop.append(1)
print("FIGURES", f"2000 steps in {alone:.2f} s alone, in {wall:.2f} s beside two threads that made {calls} calls")
assert min(calls) > 200
""",
		sampleFile,
	)
	print(*figures(output))


everyCall = """
sample.freeze(0)

def begin():
	# with every effect, and samples that are asked now and then; in place of the former one
	global mpm, keeper, inUse
	mpm = breakingGround(sample.copy(), spacing=1.0, strainTolerance=2e-3, onBlowUp="isolate", blowUpFolder="")
	mpm.damping, mpm.courantNumber = 0.5, 0.3
	mpm.watch([0, 1], interval=1e-3)
	keeper = wrapper.Checkpoint(file="kept", every=0.5)
	O.engines = [keeper, mpm]
	O.run(3, True)
	inUse = [mpm, keeper, mpm.skeleton, mpm.heat, mpm.freezing, mpm.water, mpm.material, mpm.watched, *mpm.boundaries]

begin()
scene = sample.open()
own = [cls for cls in vars(talik).values() if isinstance(cls, type) and issubclass(cls, wrapper.Serializable)]
loose = [cls() for cls in own] + [sample]
loose[own.index(wrapper.OpenRveSample)].source = scene
generator = random.Random({seed})
values = [
	None, True, 0, 1, -1, 2.5, 1e300, float("nan"), "", "text", [], [0, 1], (0, 1), [None], {{}}, mpm, sample, scene, object(),
	Matrix3(0, 1e-4, 0, 0, 0, 0, 0, 0, 0), "stress", "temperature", 3, (0.5, 0.5), np.zeros(3), lambda: 1,
]
asked, problems, refused, over = dict(), [], dict(), []

def once(thing):
	name = generator.choice([name for name in dir(type(thing)) if not name.startswith("__")])
	key = f"{{type(thing).__name__}}.{{name}}"
	asked[key] = asked.get(key, 0) + 1
	try:
		member = getattr(thing, name)
		if callable(member):
			arguments = [generator.choice(values) for _ in range(generator.choice([0, 0, 1, 1, 2, 2, 3]))]
			if name in ("servo", "advance"):  # some numbers make steps without end
				arguments = [value if not isinstance(value, (int, float)) else 2 for value in arguments]
			if name not in ("inspect", "back"):  # these exchange the scene of O
				member(*arguments)
		elif generator.random() < 0.3:
			try:
				setattr(thing, name, generator.choice(values))
			finally:
				setattr(thing, name, member)
	except Exception as error:
		if isinstance(error, (SystemError, MemoryError)):
			problems.append(f"{{key}}: {{error!r}}")

def ask():
	while not over:
		once(generator.choice(inUse if generator.random() < 0.7 else loose))

threading.Thread(target=ask, daemon=True).start()
done, deadline = 0, time.monotonic() + {limit}
while done < {steps} and time.monotonic() < deadline:
	before = O.iter
	O.run({steps} - done)
	while O.running:
		time.sleep(0.002)
	done += O.iter - before
	if mpm.failure:  # of what was called: a ground may be given settings that end it
		sentence = mpm.failure.split(":")[0]
		refused[sentence] = refused.get(sentence, 0) + 1
		if refused[sentence] % 3 == 0:
			begin()
over.append(1)
time.sleep(0.5)
calls = sum(asked.values())
print("FIGURES", done, "steps,", calls, "calls of", len(asked), "methods and attributes; steps that ended in an exception:", sum(refused.values()))
for sentence, times in refused.items():
	print("REFUSED", times, sentence)
print("PROBLEMS", problems)
assert not problems and done >= {steps}
"""


def test_all_methods_and_attributes_of_all_classes_called_at_random_during_ten_thousand_steps_do_not_end_yade_slow(tmp_path, sampleFile):
	seed = random.SystemRandom().randrange(10**6)
	output = lives(tmp_path, everyCall.format(seed=seed, steps=10000, limit=500), sampleFile, threads=2)
	print(f"seed {seed}", *figures(output))


def test_all_methods_and_attributes_of_all_classes_called_at_random_while_O_runs_do_not_end_yade(tmp_path, sampleFile):
	seed = random.SystemRandom().randrange(10**6)
	output = lives(tmp_path, everyCall.format(seed=seed, steps=300, limit=100), sampleFile)
	print(f"seed {seed}", *figures(output))


def test_a_sample_is_not_repacked_from_nothing(smallSample):
	with pytest.raises(ValueError, match="RveSample.repack: the scene is None"):
		smallSample.copy().repack(None)
