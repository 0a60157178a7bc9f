# SPDX-License-Identifier: GPL-2.0-or-later
"""One scene on several ranks: the same bits as alone, one voice, one file, and an end for all when one of them ends."""

import json
import os
import re
import shutil
import signal
import subprocess
import sys
import time
from pathlib import Path

import numpy as np
import pytest

import talik

here = Path(__file__).resolve().parent
scenes = here / "rankScenes.py"
job = re.compile(r"FIGURES (\w+) (\d+) ([\d.]+) (\d+)")

pytestmark = pytest.mark.skipif(
	not talik._talik.knowsRanks() or shutil.which("mpirun") is None, reason="Talik was built without Open MPI, or there is no mpirun here"
)


def command(ranks, *arguments, threads=1):
	start = ["mpirun", "-n", str(ranks), "--bind-to", "none", "--oversubscribe", *(["--allow-run-as-root"] if os.geteuid() == 0 else [])]
	return [*(start if ranks > 1 else []), "yade", "-n", "-x", f"-j{threads}", *map(str, arguments)]


def started(command, **settings):
	environment = talik.ranks.alone(os.environ)
	return subprocess.Popen(command, env=environment, stdout=subprocess.PIPE, stderr=subprocess.PIPE, text=True, start_new_session=True, **settings)


def ended(process, timeout=300):
	try:
		said, complained = process.communicate(timeout=timeout)
	except subprocess.TimeoutExpired:
		os.killpg(process.pid, signal.SIGKILL)
		raise AssertionError(f"still running after {timeout} s: {process.communicate()}") from None
	return process.returncode, said, complained


class Job:
	"""Scenes that are played by so many ranks, from its making on."""

	def __init__(self, folder, cache, names, ranks, threads=1):
		folder.mkdir(exist_ok=True)
		self.folder, self.names, self.ranks = folder, names, ranks
		self._process = started(command(ranks, scenes, folder, cache, *names, threads=threads))

	def end(self):
		"""Waits for it: states by scene, and what was said."""
		if self._process is None:
			return self
		status, self.said, self.complained = ended(self._process, timeout=900)
		assert status == 0, self.said + self.complained
		self._process, self.states = None, {}
		for name in self.names:
			with np.load(self.folder / f"{name}.npz") as file:
				self.states[name] = {key: file[key] for key in file.files}
		return self

	def of(self, names):
		return {name: self.states[name] for name in names}

	def sentences(self, name):
		"""With which a scene stopped, on each rank."""
		return [(self.folder / f"{name}.{rank}.txt").read_text() for rank in range(self.ranks)]

	def told(self, what):
		"""How often the job said what its ranks do."""
		return self.complained.count(f"Talik: {self.ranks} ranks {what}")


def played(folder, cache, names, ranks, threads=1):
	return Job(folder, cache, names, ranks, threads).end()


def differing(one, other):
	"""Numbers that differ in a bit, over all states."""
	assert set(one) == set(other)
	count = 0
	for name, state in one.items():
		assert set(state) == set(other[name]), name
		for key, values in state.items():
			a, b = np.ascontiguousarray(values), np.ascontiguousarray(other[name][key])
			assert a.shape == b.shape, f"{name} {key}"
			bad = int((a.view(np.uint8) != b.view(np.uint8)).sum())
			if bad:
				print(f"{name}: {key} differs")
			count += bad
	return count


def size(states):
	return sum(values.size for state in states.values() for values in state.values())


small = ["packed", "bodies"]  # too small for slabs: all ranks compute all of it
inBands = ["bands", "bandsInSpace", "bandsOfBodies", "bandsOfIceRichGround", "bandsCheckpoint", "bandsLeft", "bandsReplaced", "bandsHeated"]
inBands += ["bandsOfScripts", "bandsShaken", "bandsLawFails", "bandsThrough", "bandsUnderRoom"]
lookedAt = ["creeping", "stared", "asked"]
samplesInBands = ["bandsOfSamples", "bandsToTolerance", "bandsExchanged", "bandsBlowUp", "bandsOfSamplesCheckpoint", "bandsDividing"]
everything = [*small, *lookedAt, *inBands, *samplesInBands]


@pytest.fixture(scope="module", autouse=True)
def background(tmp_path_factory, sampleCache):
	"""All scenes on one rank and on two, which begin beside the tests that do not need them."""
	return [Job(tmp_path_factory.mktemp(f"of{ranks}"), sampleCache, everything, ranks) for ranks in (1, 2)]


@pytest.fixture(scope="module")
def alone(background):
	return background[0].end()


@pytest.fixture(scope="module")
def pair(background):
	return background[1].end()


# ---- one voice ------------------------------------------------------------------------------------------------------------


writing = """
import sys, talik
from pathlib import Path
sys.path.insert(0, {faults!r})
from breakingGround import breakingGround
from talik import output, plots, progress, rve
from yade import O
folder = Path({folder!r})
real = Path.write_text
mpm = breakingGround(rve.pack(rve.prepare(grains=30, porosity=0.19, cache={cache!r})))
talik.checkpoint.keep(folder / "kept.checkpoint", every=0)
bar = progress.Progress(endStep=10, interval=0, details=lambda: {{"broken": mpm.field("bondsBroken").sum()}})
O.engines = O.engines + [bar.runner(realPeriod=0)]
talik.running.runUntil(10 * mpm.stableTimeStep(), look=lambda: (folder / f"looked{{talik.ranks.rank}}").write_text("here"), interval=0)
bar.close()
series = output.ParaViewSeries(mpm, folder)
series.write()
output.writeSummary(folder / f"summary{{talik.ranks.rank}}.json", broken=mpm.field("bondsBroken").sum(), ranks=talik.ranks.count)
plots.save(plots.figure(1, 1), folder / f"picture{{talik.ranks.rank}}.png")
O.save(str(folder / f"scene{{talik.ranks.rank}}.yade"))
print("the script printed this", flush=True)
"""


@pytest.mark.parametrize("which", [0, pytest.param(1, id="1_slow")])
def test_the_commands_of_the_pages_run(which, tmp_path):
	root = here.parents[1]
	pages = [root / "README.md", root / "CHANGELOG.md", root / "pkg" / "ranks" / "README.md", Path(talik.ranks.__file__)]
	found = {command for page in pages for command in re.findall(r"mpirun -n \d .* scene\.py", page.read_text())}
	(tmp_path / "scene.py").write_text("import talik\nprint('RANKS', talik.ranks.count, flush=True)\n")
	options = ["--oversubscribe", *(["--allow-run-as-root"] if os.geteuid() == 0 else [])]
	assert len(found) == 2
	line = sorted(found)[which]
	name, *words = line.split()
	status, said, complained = ended(started([name, *options, *words], cwd=tmp_path))
	print(f"{line}: {re.findall('RANKS.*', said)}")
	assert status == 0 and re.findall(r"RANKS (\d+)", said) == ["2"], complained


def test_rank_0_alone_prints_draws_looks_and_writes(tmp_path, sampleCache):
	script, folder = tmp_path / "scene.py", tmp_path / "left"
	folder.mkdir()
	script.write_text(writing.format(faults=str(here.parent / "faults"), folder=str(folder), cache=str(sampleCache)))
	status, said, complained = ended(started(command(2, script)))
	names = sorted(path.name for path in folder.iterdir())
	print(names, re.findall("step .*ranks.*", complained)[-1:])
	assert status == 0, said + complained
	series = ["points.pvd", "points_00000.vtu", "surface.pvd", "surface_00000.vtu"]
	assert names == sorted(["kept.checkpoint", "looked0", "picture0.png", *series, "scene0.yade", "summary0.json"])
	assert said.count("the script printed this") == 1
	assert re.search(r"steps/s, 2 ranks, broken \d+", complained)
	assert json.loads((folder / "summary0.json").read_text())["ranks"] == 2


# ---- one end --------------------------------------------------------------------------------------------------------------

endless = """
import os, sys, time, talik
from pathlib import Path
sys.path.insert(0, {faults!r})
from breakingGround import breakingGround
from talik import rve
from yade import O
mpm = breakingGround(rve.pack(rve.prepare(grains=30, porosity=0.19, cache={cache!r})), onBlowUp="isolate", blowUpFolder="")
mpm.damping = 0.9
{before}
O.run(5, True)
(Path({folder!r}) / f"pid{{talik.ranks.rank}}").write_text(str(os.getpid()))
{after}
O.run(10**9, True)
"""


def endlessRun(folder, cache, before="", after=""):
	script = folder / "scene.py"
	script.write_text(endless.format(faults=str(here.parent / "faults"), cache=str(cache), folder=str(folder), before=before, after=after))
	return started(command(2, script))


def pids(folder, process, patience=120):
	files = [folder / f"pid{rank}" for rank in (0, 1)]
	until = time.monotonic() + patience
	while not all(file.exists() and file.read_text() for file in files):
		assert time.monotonic() < until and process.poll() is None, process.communicate()
		time.sleep(0.05)
	return [int(file.read_text()) for file in files]


def alive(pid):
	try:
		return Path(f"/proc/{pid}/stat").read_text().rpartition(")")[2].split()[0] != "Z"
	except OSError:
		return False


def secondsToTheEnd(process, ranks, begin):
	status, said, complained = ended(process, timeout=60)
	while any(map(alive, ranks)):
		assert time.monotonic() < begin + 60
		time.sleep(0.02)
	return time.monotonic() - begin, status, said + complained


def test_an_exception_on_one_rank_ends_all_with_its_message(tmp_path, sampleCache):
	process = endlessRun(tmp_path, sampleCache, after="if talik.ranks.rank == 1:\n\traise ValueError('there is no such slope')")
	ranks = pids(tmp_path, process)
	seconds, status, said = secondsToTheEnd(process, ranks, time.monotonic())
	print(f"all ranks had ended {seconds:.1f} s after the exception on rank 1; limit 10 s")
	assert seconds < 10 and status != 0
	assert "rank 1: ValueError: there is no such slope" in said and "Talik: rank 1 failed; all 2 ranks end." in said


@pytest.mark.parametrize("rank", [pytest.param(0, id="0_slow"), 1])
def test_a_rank_that_is_killed_ends_the_job(rank, tmp_path, sampleCache):
	process = endlessRun(tmp_path, sampleCache)
	ranks = pids(tmp_path, process)
	time.sleep(0.5)
	begin = time.monotonic()
	os.kill(ranks[rank], signal.SIGKILL)
	seconds, status, said = secondsToTheEnd(process, ranks, begin)
	print(f"all ranks had ended {seconds:.1f} s after rank {rank} was killed; limit 10 s")
	assert seconds < 10 and status != 0


def test_ctrl_c_ends_the_job_slow(tmp_path, sampleCache):
	process = endlessRun(tmp_path, sampleCache)
	ranks = pids(tmp_path, process)
	time.sleep(0.5)
	begin = time.monotonic()
	os.kill(process.pid, signal.SIGINT)
	seconds, status, _ = secondsToTheEnd(process, ranks, begin)
	print(f"all ranks had ended {seconds:.1f} s after Ctrl-C; limit 10 s")
	assert seconds < 10 and status != 0


@pytest.mark.parametrize(
	"how, part",
	[
		("mpm.damping = 0.9 + 1e-12 * talik.ranks.rank", "The ground of rank 1"),
		("O.run(1 + talik.ranks.rank, True); raise SystemExit", "The ranks of this job do different things: rank 0"),
	],
	ids=["another setting_slow", "another number of steps"],
)
def test_ranks_whose_scripts_differ_are_refused_by_name(how, part, tmp_path, sampleCache):
	inSlabs = "mpm.upper = (7, 2)" if "O.run(1 " in how else ""  # ranks of slabs meet in every step, others every hundred
	process = endlessRun(tmp_path, sampleCache, before=inSlabs, after=how)
	status, said, complained = ended(process, timeout=60)
	sentence = next((line for line in complained.splitlines() if part in line), "nothing")
	print(sentence)
	assert status != 0 and "rank 1 (" in sentence


def twoPrograms(script, other=None, **environment):
	"""mpirun with a program for each of two ranks: the second may have another script, or another environment."""
	whole = command(2, script)
	options, yade = whole[3 : whole.index("yade")], whole[whole.index("yade") :]
	settings = [word for name, value in environment.items() for word in ("-x", f"{name}={value}")]
	return ["mpirun", *options, "-n", "1", *yade, ":", "-n", "1", *settings, *yade[:-1], str(other or script)]


def refusal(command, part):
	"""The sentence with which a job was refused."""
	status, said, complained = ended(started(command), timeout=60)
	sentence = next((line for line in complained.splitlines() if part in line), complained)
	print(sentence)
	assert status != 0 and "Talik: rank 0 failed" in complained
	return sentence


def test_ranks_with_different_scripts_are_refused_by_name_at_the_start(tmp_path):
	one, other = tmp_path / "slope.py", tmp_path / "flat.py"
	one.write_text("import talik\n")
	other.write_text("import talik  # another\n")
	sentence = refusal(twoPrograms(one, other), "another script")
	assert re.search(r"rank 1 on .* runs another script, or has other arguments, \(flat.py \w{12}\) than rank 0 on .* \(slope.py \w{12}\)", sentence)


def test_ranks_with_different_arguments_are_refused_by_name_at_the_start_slow(tmp_path):
	script = tmp_path / "slope.py"
	script.write_text("import talik\n")
	assert "rank 1 on" in refusal([*twoPrograms(script), "--steeper"], "another script")


def test_ranks_whose_mathematical_functions_differ_are_refused_by_name_at_the_start(tmp_path):
	script = tmp_path / "scene.py"
	script.write_text("import talik\n")
	without = {"GLIBC_TUNABLES": "glibc.cpu.hwcaps=-AVX2,-FMA,-FMA4,-AVX2_Usable,-FMA_Usable,-FMA4_Usable"}
	probe = [sys.executable, "-c", "import math; print([math.exp(0.0137 * k) for k in range(1, 2000)])"]
	if subprocess.check_output(probe) == subprocess.check_output(probe, env={**os.environ, **without}):
		pytest.skip("libm computes the same with and without FMA on this machine: two kinds of processors cannot be had")
	sentence = refusal(twoPrograms(script, **without), "other instructions")
	assert re.search(r"rank 1 on .* computes by other instructions \(.*libm \w{6}\) than rank 0 on .*--constraint", sentence)


def test_ranks_with_other_vectors_are_named():
	ranks = [{"host": f"n{k}", "build": "b", "arithmetic": "AVX3, libm 1" if k < 2 else "AVX2, libm 1", "script": "s"} for k in range(3)]
	print(talik.ranks._reasonAgainst(ranks))
	assert talik.ranks._reasonAgainst(ranks).startswith("rank 2 on n2 computes by other instructions (AVX2, libm 1) than rank 0 on n0 (AVX3, libm 1)")
	assert talik.ranks._reasonAgainst(ranks[:2]) == ""


withoutSamples = """
import sys, talik
from yade import O, wrapper
mpm = wrapper.MpmEngine(gridSpacing=0.5, lower=(0, 0), upper=(2, 2), gravity=(0, -9.81), damping=0.1 + 1e-12 * talik.ranks.rank,
	skeleton=wrapper.ElasticSkeleton(young=5e6), boundaries=[wrapper.FixedBoundary(region="bottom")])
talik.geometry.fill(mpm, [(0, 0), (1, 0), (1, 1), (0, 1)])
O.engines = [mpm]
O.run(1000, True)
"""


def test_ranks_that_share_nothing_compare_their_ground_every_hundred_steps(tmp_path):
	script = tmp_path / "scene.py"
	script.write_text(withoutSamples)
	sentence = refusal(command(2, script), "The ground of rank 1")
	assert re.search(r"noticed at 'step (\d+) of the ground'", sentence).group(1) == "101"


def test_ranks_with_different_builds_are_refused_by_name(tmp_path):
	module = Path(talik._talik.__file__).resolve()
	other = tmp_path / "python" / "talik"
	shutil.copytree(Path(talik.__file__).parent, other, ignore=shutil.ignore_patterns("__pycache__"))
	(other / module.name).write_bytes(module.read_bytes() + b"\0")
	script = tmp_path / "scene.py"
	script.write_text("import talik\n")
	sentence = refusal(twoPrograms(script, PYTHONPATH=other.parent), "another build")
	assert re.search(r"rank 1 on .* runs another build of Talik \(\w{12}\) than rank 0 on", sentence)


def test_threads_without_cores_are_told_with_the_remedy(tmp_path):
	script = tmp_path / "scene.py"
	script.write_text("import os\ncores = sorted(os.sched_getaffinity(0))\nos.sched_setaffinity(0, cores[:1])\nimport talik\n")
	status, said, complained = ended(started(command(2, script, threads=2)), timeout=60)
	told = [line for line in complained.splitlines() if line.startswith("Talik warns:")]
	print(told)
	assert status == 0 and len(told) == 1
	assert "rank 0 has 2 threads and may use 1 of the processor's cores" in told[0] and "mpirun --bind-to none" in told[0]


def test_a_yade_that_is_alone_makes_no_call_of_mpi(tmp_path, sampleCache):
	script = tmp_path / "scene.py"
	script.write_text(
		"import sys, talik\n"
		f"sys.path.insert(0, {str(here.parent / 'faults')!r})\n"
		"from breakingGround import breakingGround, run\n"
		"from talik import rve\n"
		f"mpm = breakingGround(rve.pack(rve.prepare(grains=30, porosity=0.19, cache={str(sampleCache)!r})))\n"
		"run(10)\n"
		"from mpi4py import rc\n"
		"rc.initialize = rc.finalize = False\n"
		"from mpi4py import MPI\n"
		"print('STARTED', MPI.Is_initialized(), talik.ranks.count, 'owned' in mpm.skeleton.cost(), flush=True)\n"
	)
	status, said, complained = ended(started(command(1, script)))
	print(re.search("STARTED.*", said).group(0))
	assert status == 0 and "STARTED False 1 False" in said


# ---- where a ground is shared out ------------------------------------------------------------------------------------------


def test_what_bands_do_not_serve_is_refused_with_the_remedy(tmp_path):
	(tmp_path / "scene.py").write_text(refusing)
	_, said, complained = ended(started(command(2, tmp_path / "scene.py")))
	print(said, complained)
	assert "this ground has samples that run open, which slab decomposition does not support: choose automatic or none" in said
	assert "PythonBoundary gives other values on rank 1 than on rank 0: let its function follow from its argument alone" in said
	assert "choose automatic, ground (with the samples of its points) or none" in said


@pytest.mark.parametrize("rounds", [[0, 1], pytest.param([2, 3, 4], id="of bodies, of ice, of a script_slow")])
def test_ranks_take_bands_of_a_large_ground_of_a_law_by_themselves_and_of_no_other(rounds, tmp_path):
	(tmp_path / "scene.py").write_text(large + "".join(f"rounds[{k}]()\n" for k in rounds))
	_, said, complained = ended(started(command(2, tmp_path / "scene.py")))
	told = [line for line in complained.splitlines() if line.startswith("Talik:")]
	print(told, said)
	strips, whole = "Talik: 2 ranks share out the strips of this ground", "Talik: 2 ranks each compute all of this ground"
	wanted = [strips, whole, strips, strips, whole]
	assert [line.split(" (")[0].split(",")[0] for line in told] == [wanted[k] for k in rounds]


large = """
import numpy as np
import talik
from yade import O, wrapper
def run(size, **attributes):
	mpm = wrapper.MpmEngine(**{"gridSpacing": 0.5, "lower": (0, 0), "upper": (160, 160), "skeleton": wrapper.ElasticSkeleton(), **attributes})
	position = np.stack(np.meshgrid(*[np.arange(0.125, size, 0.25)] * 2), axis=-1).reshape(-1, 2)
	mpm.addPoints(position=position + 1, volume=0.0625, porosity=0.4, temperature=-1.0)
	O.engines = [wrapper.ForceResetter(), mpm]
	O.run(1, True)
ice = {"heat": wrapper.HeatTransfer(), "freezing": wrapper.FreezingCurve(), "materials": [wrapper.GroundMaterial(thawStrain=0.1)]}
rounds = [
	lambda: run(80),
	lambda: run(20),
	lambda: run(80, bodies=wrapper.BodyContact()),
	lambda: run(80, gravity=(0, -1), **ice),
	lambda: run(80, skeleton=wrapper.PythonSkeleton(law=lambda step: None, modulus=1e7)),
]
"""


refusing = """
import talik
from yade import O, wrapper
byRank = wrapper.PythonBoundary(region="surface", function=lambda nodes: 0 * nodes.temperature + talik.ranks.rank)
openSamples = wrapper.RveSkeleton(form="open")
for attributes in (
	{"distribute": "halves"},
	{"distribute": "ground", "skeleton": openSamples},
	{"distribute": "ground", "heat": wrapper.HeatTransfer(), "boundaries": [byRank]},
):
	mpm = wrapper.MpmEngine(gridSpacing=0.5, lower=(0, 0), upper=(8, 16), **{"skeleton": wrapper.ElasticSkeleton(), **attributes})
	mpm.addPoints(position=[[1.1, 1.1], [1.4, 1.1]], volume=0.1, porosity=0.4)
	O.engines = [mpm]
	try:
		O.run(1, True)
	except Exception as problem:
		print(problem, flush=True)
"""


wide = """
import numpy as np
import talik
from pathlib import Path
from yade import O, wrapper
def resident(entry):
	line = next(line for line in Path("/proc/self/status").read_text().splitlines() if line.startswith(entry))
	return int(line.split()[1]) / 1024
position = np.stack(np.meshgrid(np.arange(0.0625, 155, 0.125), np.arange(0.0625, 20, 0.125)), axis=-1).reshape(-1, 2)
temperature = np.where(position[:, 1] > 15, 0.5, -1.0)
mpm = wrapper.MpmEngine(
	gridSpacing=0.25, lower=(-1, 0), upper=(160, 24), gravity=(0, -9.81), distribute="ground",
	skeleton=wrapper.MohrCoulombSkeleton(young=2e6, youngFrozen=2e8, cohesion=1e3, cohesionFrozen=1e5),
	heat=wrapper.HeatTransfer(thermalTimeScale=1e5), freezing=wrapper.FreezingCurve(), water=wrapper.PoreWater(),
	boundaries=[wrapper.FixedBoundary(region="bottom"), wrapper.SurfaceTemperature(region="surface", temperature=5), wrapper.DrainedBoundary(region="surface")],
)
before = resident("VmRSS")
mpm.addPoints(position=position, volume=0.125**2, porosity=0.4, temperature=temperature)
O.engines = [mpm]
mpm.initialise()
highest = resident("VmHWM") - before
O.run(3, True)
Path({file!r} + str(talik.ranks.rank)).write_text(f"{{highest}} {{resident('VmHWM') - before}} {{resident('VmRSS') - before}} {{len(position)}}")
"""


def test_no_rank_holds_the_whole_ground_from_its_beginning_on_slow(tmp_path):
	highest = {}
	for ranks in (1, 2, 4):
		script = tmp_path / f"of{ranks}.py"
		script.write_text(wide.format(file=str(tmp_path / f"{ranks}.")))
		status, said, complained = ended(started(command(ranks, script)))
		assert status == 0, said + complained
		found = np.array([np.loadtxt(tmp_path / f"{ranks}.{rank}") for rank in range(ranks)])
		setup, steps, rest, points = found.max(axis=0)
		print(
			f"{points:.0f} points, memory of the largest of {ranks} ranks: {setup:.0f} MB at most until it is set up, {steps:.0f} in the steps, {rest:.0f} then"
		)
		assert setup < 1.1 * steps
		highest[ranks] = steps
	assert highest[2] < 0.75 * highest[1] and highest[4] < 0.6 * highest[1]


# ---- the same bits --------------------------------------------------------------------------------------------------------


def checkBits(alone, other, names, what):
	count = differing(alone.of(names), other.of(names))
	print(f"ranks: {what}, {other.ranks} against 1, {size(alone.of(names))} numbers | {count} | 0 | {count} | 0 | exact")
	assert count == 0
	broken, melted = np.nansum(alone.states[names[0]].get("bondsBroken", 0)), sum(np.nansum(its.get("bondsMelted", 0)) for its in alone.of(names).values())
	print(f"bonds broken {broken:.0f} in one scene, melted {melted:.0f} in all")
	return broken > 0 and melted > 0


def checkStop(alone, other, name, part):
	sentences = {*alone.sentences(name), *other.sentences(name)}
	print(sentences)
	assert len(sentences) == 1 and part in sentences.pop()


def checkFile(alone, other, name):
	"""The same bytes behind the header, which has a date."""
	files = [(job.folder / name).read_bytes()[4096:] for job in (alone, other)]
	print(f"{name}: {len(files[0])} and {len(files[1])} bytes; {sum(a != b for a, b in zip(*files))} differ")
	assert files[0] == files[1]


def checkKeptSample(alone, other, file):
	"""The sample that blew up, as rank 0 has kept it."""
	sizes = [(job.folder / file).stat().st_size for job in (alone, other)]
	assert sizes[0] == pytest.approx(sizes[1], abs=200)


def checkSamples(alone, other):
	checkBits(alone, other, small, "ground that every rank computes")
	checkBits(alone, other, lookedAt, "samples that are looked at")


def checkBands(alone, other):
	checkBits(alone, other, inBands, "ground in bands")
	checkStop(alone, other, "bandsLawFails", "there is no such soil; the step has ended half way")
	checkStop(alone, other, "bandsLeft", "left the grid's box")
	checkFile(alone, other, "bands.checkpoint")


def checkSamplesOfBands(alone, other):
	assert checkBits(alone, other, samplesInBands, "samples in bands")
	checkStop(alone, other, "bandsBlowUp", "[170] The sample of point 170 blew up")
	checkKeptSample(alone, other, "blownInBands/point170.yade")
	checkFile(alone, other, "samplesOfBands.checkpoint")
	checkFile(alone, other, "dividing.checkpoint")
	moved = {name: int(number) for name, number, *_ in job.findall(other.said) if name in samplesInBands}
	print(f"samples that went to another rank: {moved}")
	assert other.ranks == 1 or all(moved[name] > 0 for name in samplesInBands)


def test_two_ranks_have_the_bits_of_one_in_every_field_sample_and_history(alone, pair):
	checkSamples(alone, pair)
	assert len(job.findall(pair.said)) == len(everything)


def test_one_rank_speaks_and_says_how_the_work_is_shared(pair):
	again = everything.count("bandsLawFails")  # that scene has two grounds
	print([line for line in pair.complained.splitlines() if line.startswith("Talik:")])
	assert [match[0] for match in job.findall(pair.said)] == everything
	shared = len(lookedAt) + len(inBands) + again + len(samplesInBands)
	assert (pair.told("each compute all of this ground"), pair.told("share out the strips of this ground")) == (len(small), shared)


def test_a_ground_in_bands_has_the_bits_of_one_rank_and_its_errors_and_checkpoints(alone, pair):
	checkBands(alone, pair)


def test_samples_in_bands_go_with_their_points_and_have_the_bits_of_one_rank(alone, pair):
	checkSamplesOfBands(alone, pair)


resumed = {"bandsResumed": "bandsCheckpoint", "bandsOfSamplesResumed": "bandsOfSamplesCheckpoint", "bandsKeptResumed": "bandsThrough"}
resumed["bandsDividingResumed"] = "bandsDividing"
files = ["bands.checkpoint", "samplesOfBands.checkpoint", "kept.checkpoint", "dividing.checkpoint"]


def checkResumed(alone, cache, folder, written, ranks):
	"""So many ranks go on with the checkpoints in a folder; they end as the run that went through."""
	folder.mkdir()
	for file in files:
		shutil.copy(written / file, folder)
	states = played(folder, cache, list(resumed), ranks).states
	for name, through in resumed.items():
		count = differing({name: alone.states[through]}, {name: states[name]})
		print(f"{name}, by {ranks} ranks: {count} bytes differ")
		assert count == 0


def keep(cache, folder, ranks):
	"""A job whose last rank dies while all write leaves the checkpoint before, whole."""
	status, said, complained = ended(started(command(ranks, scenes, folder, cache, "bandsKept")))
	assert status != 0
	failures, _, problem = (folder / "kept.txt").read_text().partition(" ")
	found = talik.checkpoint.describe(folder / "kept.checkpoint")
	print(f"{ranks} ranks: {failures} failed ({problem}); after the death of a rank the file has {found['bytes']} bytes of step {found['step']}")
	assert int(failures) == 3 and f"on rank {ranks - 1}" in problem and found["step"] == 59


def test_a_rank_that_dies_while_all_write_leaves_the_former_checkpoint_and_one_rank_goes_on(alone, pair, sampleCache, tmp_path):
	keep(sampleCache, pair.folder, 2)
	checkResumed(alone, sampleCache, tmp_path / "later", pair.folder, 1)


def test_a_rank_without_points_has_the_bits_of_one_and_three_ranks_go_on_with_the_checkpoint_of_two(alone, pair, sampleCache, tmp_path):
	shutil.copy(pair.folder / "room.checkpoint", tmp_path)
	states = played(tmp_path, sampleCache, ["bandsUnderRoomResumed", "bandsUnderRoom"], 3).states
	for name, its in states.items():
		count = differing({name: alone.states["bandsUnderRoom"]}, {name: its})
		print(f"ranks: {name}, 3 against 1, {size({name: its})} numbers | {count} | 0 | {count} | 0 | exact")
		assert count == 0


@pytest.mark.parametrize("ranks, threads, later", [(1, 2, 0), (2, 2, 3), (3, 1, 1), (4, 2, 2)])
def test_any_number_of_ranks_and_threads_has_the_same_bits_slow(ranks, threads, later, alone, sampleCache, tmp_path):
	other = played(tmp_path / "run", sampleCache, everything, ranks, threads)
	checkSamples(alone, other)
	checkBands(alone, other)
	checkSamplesOfBands(alone, other)
	if ranks > 1:
		keep(sampleCache, other.folder, ranks)
		checkResumed(alone, sampleCache, tmp_path / "later", other.folder, later)


def test_several_ranks_go_on_with_the_checkpoints_of_one_slow(alone, pair, sampleCache, tmp_path):
	if not (pair.folder / "kept.checkpoint").exists():
		keep(sampleCache, pair.folder, 2)
	shutil.copy(pair.folder / "kept.checkpoint", alone.folder)
	for ranks in (2, 3):
		checkResumed(alone, sampleCache, tmp_path / str(ranks), alone.folder, ranks)


def test_samples_of_spheres_in_bands_have_the_bits_of_one_rank_slow(sampleCache, tmp_path):
	alone, *others = (played(tmp_path / str(ranks), sampleCache, ["bandsOfSpheres"], ranks).states for ranks in (1, 2, 4))
	for ranks, states in zip((2, 4), others):
		count = differing(alone, states)
		print(f"ranks: samples of spheres in bands, {ranks} against 1, {size(alone)} numbers | {count} | 0 | {count} | 0 | exact")
		assert count == 0


def test_the_benchmark_measures_equal_bits_and_its_record_is_replayed_slow(tmp_path):
	scripts = here.parents[1] / "scripts"
	environment = {**talik.ranks.alone(os.environ), "PYTHONPATH": f"{scripts / 'benchmarks'}:{os.environ['PYTHONPATH']}"}
	benchmark = scripts / "benchmarks" / "ranks.py"
	subprocess.run(["/usr/bin/python3", "-B", benchmark, tmp_path / "ranks.json", "--rounds", "1", "--steps", "30"], env=environment, check=True, timeout=1200)
	for scene in ("samples", "space"):
		file = tmp_path / f"record-{scene}.npz"
		subprocess.run(["yade", "-n", "-x", "-j1", benchmark, "--record", scene, "30", file], env=environment, check=True, timeout=600)
	said = subprocess.check_output(["/usr/bin/python3", "-B", scripts / "scaling.py", tmp_path], text=True, timeout=1200)
	measured = {(its["scene"], its["ranks"], its["threads"]): its for its in json.loads((tmp_path / "ranks-measured.json").read_text())}
	bits = {scene: len({its["state"] for kind, its in measured.items() if kind[0] == scene}) for scene in ("samples", "law", "space")}
	gain = measured["samples", 1, 1]["work"] / measured["samples", 2, 1]["work"]
	print(f"states at the end of each scene: {bits}; two ranks, work of one over that of the busier: {gain:.2f}")
	print(re.search("largest deviation.*", said).group(0))
	assert set(bits.values()) == {1} and gain > 1.5
