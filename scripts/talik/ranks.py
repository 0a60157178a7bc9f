# SPDX-License-Identifier: GPL-2.0-or-later
"""Ranks: the processes that mpirun starts for one scene.

	mpirun -n 2 --bind-to none yade -n -x -j1 scene.py

Every rank runs the whole script; each computes a part of the ground, with the samples of its points (see
MpmEngine.distribute). Rank 0 alone prints, draws and writes. A script needs no change; one that writes files of its own does so on rank 0:

	if talik.ranks.first:
		np.save("stress.npy", mpm.field("stress"))

What only one rank does may look at the ground: the others answer when they come to their next update. It may not step the ground.
"""

import atexit
import hashlib
import json
import math
import os
import platform
import struct
import sys
import time
from pathlib import Path

rank, count = 0, 1  # this process, counted from 0, and how many there are
first = True  # whether this rank prints, draws and writes; True without mpirun

_talik = None  # the compiled module, once the ranks have joined
_patience = 1.0  # [s] before another rank says why it failed: as a rule rank 0 fails by the same error, and says it
_state = {"ended": False, "failed": False, "said": None}


def join():
	"""Joins the other ranks of mpirun, if there are any; called by `import talik`, once.

	>>> talik.ranks.join()"""
	global rank, count, first, _talik
	if int(os.environ.get("OMPI_COMM_WORLD_SIZE", "1")) < 2 or count > 1:
		return
	from talik import _talik

	if not _talik.knowsRanks():
		raise ImportError("this Talik was built without Open MPI and cannot share a scene among ranks: install libopenmpi-dev and build it again")
	from yade import mpy  # starts MPI, as yade does at the end of a script

	rank, count = _talik.openRanks()
	first = rank == 0
	_endTogether(mpy)
	_compare()
	if not first:
		_fallSilent()


def meet(purpose):
	"""Waits until all ranks are here. Without mpirun it does nothing.

	>>> talik.ranks.meet("files are written")"""
	if count > 1:
		_talik.meetRanks(purpose)


def traffic():
	"""{"messages", "bytes", "waited", "polling"}: collective calls so far, bytes sent, wall time waited and processor time spent on that [s]
	by this rank; zeros without mpirun.

	>>> talik.ranks.traffic()["bytes"]
	0"""
	return _talik.rankTraffic() if count > 1 else {"messages": 0, "bytes": 0, "waited": 0.0, "polling": 0.0}


def alone(environment):
	"""An environment for a process that is no rank of this job, made of another one.

	>>> talik.ranks.alone({"HOME": "/", "OMPI_COMM_WORLD_RANK": "1"})
	{'HOME': '/'}"""
	return {name: value for name, value in environment.items() if not name.startswith(("OMPI_", "PMIX_", "PMI_", "ORTE_", "PRTE_"))}


class inTurn:
	"""For a block that every rank runs and that leaves files which shorten it: rank 0 goes first, the others follow together.

	>>> with talik.ranks.inTurn("preparing samples"):
	...     sample = talik.rve.prepare(grains=30, porosity=0.19)"""

	def __init__(self, purpose):
		self.purpose = purpose

	def __enter__(self):
		if not first:
			meet(self.purpose)

	def __exit__(self, *error):
		if first:
			meet(self.purpose)


# --- the start -------------------------------------------------------------------------------------------------------------


_sameOnAll = (
	("build", "runs another build of Talik", "install the same one for all ranks"),
	("arithmetic", "computes by other instructions", "give the job processors of one kind and one Debian, e.g. by  sbatch --constraint"),
	("script", "runs another script, or has other arguments,", "start the same script with the same arguments on all ranks"),
)


def _compare():
	"""Ranks whose numbers would differ are refused; threads without cores are told."""
	own = {
		"build": _digestOfBuild(),
		"arithmetic": _arithmetic(),
		"script": _script(sys.argv),
		"host": platform.node(),
		"processor": _processor(),
		"cores": len(os.sched_getaffinity(0)),
		"threads": int(os.environ.get("OMP_NUM_THREADS", "1")),
	}
	name = f"{own['host']}, {own['processor']}, {own['arithmetic']}, build {own['build']}"
	ranks = [json.loads(text) for text in _talik.describeRanks(json.dumps(own).encode(), name)]
	reason = _reasonAgainst(ranks)
	if reason:
		raise ImportError(reason)
	starved = next((k for k, its in enumerate(ranks) if its["threads"] > its["cores"]), None)
	if first and starved is not None:
		print(
			f"Talik warns: rank {starved} has {ranks[starved]['threads']} threads and may use {ranks[starved]['cores']} of the processor's cores, where they "
			"wait for each other: start with  mpirun --bind-to none ,  or give each rank its cores with  --map-by node:PE=<threads> .",
			file=sys.stderr,
			flush=True,
		)


def _reasonAgainst(ranks):
	"""Why these ranks would not compute the same numbers; empty if they do."""
	one = ranks[0]
	for what, differs, remedy in _sameOnAll:
		for k, other in enumerate(ranks):
			if other[what] != one[what]:
				return f"rank {k} on {other['host']} {differs} ({other[what]}) than rank 0 on {one['host']} ({one[what]}): {remedy}"
	return ""


def _digestOfBuild():
	digest, folder = hashlib.sha256(), Path(__file__).parent
	for file in [Path(_talik.__file__), *sorted(folder.rglob("*.py"))]:
		digest.update(file.read_bytes())
	return digest.hexdigest()[:12]


def _arithmetic():
	"""The vectors of samples, and a digest of mathematical functions, whose last bits depend on the instructions that libm chose."""
	functions = (math.exp, math.expm1, math.sin, math.cos, math.tan, math.atan, math.sinh, math.tanh, math.log1p, lambda x: math.pow(x, 0.37))
	digest = hashlib.sha256()
	for k in range(1, 2000):  # two kinds of processors agree in most of them
		digest.update(struct.pack(f"{len(functions)}d", *(function(0.0137 * k) for function in functions)))
	return f"{_talik.vectors()}, libm {digest.hexdigest()[:6]}"


def _script(arguments):
	"""Name of the script, and a digest of what it says and of its arguments."""
	if not arguments:
		return "none"
	digest, file = hashlib.sha256(json.dumps(arguments[1:]).encode()), Path(arguments[0])
	if file.is_file():
		digest.update(file.read_bytes())
	return f"{file.name} {digest.hexdigest()[:12]}"


def _processor():
	try:
		lines = Path("/proc/cpuinfo").read_text().splitlines()
	except OSError:
		lines = []
	return next((line.partition(":")[2].strip() for line in lines if line.startswith("model name")), platform.machine())


class _Kept:
	"""What Python says on sys.stderr of a rank that is not the first: kept, and said if the rank fails."""

	limit = 20000  # characters

	def __init__(self):
		self.text = ""

	def write(self, text):
		self.text = (self.text + text)[-self.limit :]
		return len(text)

	def say(self):
		_complain("".join(f"rank {rank}: {line}\n" for line in self.text.splitlines()))

	def isatty(self):
		return False

	def __getattr__(self, name):
		return getattr(sys.__stderr__, name)


def _complain(text):
	"""Past sys.stderr, which yade turns to sys.stdout on all ranks but the first."""
	os.write(2, text.encode())


def _fallSilent():
	sys.stdout.flush()
	void = os.open(os.devnull, os.O_WRONLY)
	os.dup2(void, 1)
	os.close(void)
	sys.stderr = _state["said"] = _Kept()


# --- the end ---------------------------------------------------------------------------------------------------------------


def _endTogether(mpy):
	"""yade in a job ends by telling ranks to leave: before that all answer the last questions. A rank that fails ends the job."""

	def before(stock):
		def ending(*positional, **named):
			_end()
			mpy.NO_OUTPUT = True  # of workers that there never were
			return stock(*positional, **named)

		return ending

	mpy.disconnect, mpy.spawnedProcessWaitCommand = before(mpy.disconnect), before(mpy.spawnedProcessWaitCommand)
	stockExit, stockHook = sys.exit, sys.excepthook

	def exit(status=None):
		_state["failed"] = status not in (None, 0)
		stockExit(status)

	def hook(kind, error, trace):
		_state["failed"] = True
		stockHook(kind, error, trace)

	sys.exit, sys.excepthook = exit, hook
	atexit.register(_atExit)


def _end():
	if _state["ended"]:
		return
	_state["ended"] = True
	try:
		meet("the end of the script")
	except RuntimeError as problem:
		print(problem, file=sys.stderr)
		_fail()


def _atExit():
	if _state["failed"]:
		_fail()
	_end()


def _fail():
	if _state["said"] is not None:
		time.sleep(_patience)
		_state["said"].say()
	_complain(f"Talik: rank {rank} failed; all {count} ranks end.\n")
	_talik.endJob(1)
