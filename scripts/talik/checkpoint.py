# SPDX-License-Identifier: GPL-2.0-or-later
"""Checkpoints: nothing computed is lost when a run is killed, the power fails or the disk is full.

	talik.checkpoint.keep("output/slope.checkpoint", every=600)   # from now on, every ten minutes of wall time
	O.run()

	mpm = talik.resume("output/slope.checkpoint")                 # later, in another yade
	O.run()

A checkpoint holds the whole scene. It is written beside the former one and takes its place only when it is complete on the disk. A run
that goes on from a checkpoint gives the same results, to the last bit, as one that was never stopped, with packed samples and any number of threads; open
samples run in YADE's own engines, whose archives are exact to about 1e-12 only. Several ranks (talik.ranks) write into
one file, each what it has, the bytes that one rank would write; any number of ranks can go on with it.
"""

import os

from yade import O, wrapper

from talik import _talik, ranks
from talik.guards.runs import awaitRest
from talik.guards.scenefiles import checkedLabels


def keep(file, every=600.0, onSignal=0):
	"""Writes the scene into `file` every so many seconds of wall time [s], and upon a signal (see Checkpoint.onSignal); returns the engine, a
	Checkpoint, which is now the first of O.engines.

	>>> keeper = talik.checkpoint.keep(folder + "/slope.checkpoint", every=600)"""
	engine = wrapper.Checkpoint(file=os.path.abspath(os.fspath(file)), every=every, onSignal=int(onSignal))
	O.engines = [engine] + [other for other in O.engines if not isinstance(other, wrapper.Checkpoint)]
	return engine


def write(file):
	"""Writes the scene into `file` now.

	>>> talik.checkpoint.write(folder + "/slope.checkpoint")"""
	awaitRest(O)
	wrapper.Checkpoint.write(os.path.abspath(os.fspath(file)))


def describe(file):
	"""{format, written, step, time, bytes} of a checkpoint; ValueError tells what is wrong with a file that is none.

	>>> talik.checkpoint.write(folder + "/slope.checkpoint")
	>>> talik.checkpoint.describe(folder + "/slope.checkpoint")["step"] == O.iter
	True"""
	return wrapper.Checkpoint.describe(os.fspath(file))


def resume(file):
	"""Makes the scene in a checkpoint the current one of O and returns its ground, an MpmEngine (None if it has none).

	If the scene was keeping checkpoints it goes on doing so, in this file. Refused while O runs; an unreadable file leaves O as it is.

	>>> talik.checkpoint.write(folder + "/slope.checkpoint")
	>>> mpm = talik.checkpoint.resume(folder + "/slope.checkpoint")"""
	file = os.path.abspath(os.fspath(file))
	awaitRest(O)
	ranks.meet("reading a checkpoint")  # the first rank may just have written it
	former = _talik.exchangeScene(wrapper.Checkpoint.read(file))
	try:
		checkedLabels(O, file)
		for engine in O.engines:
			if isinstance(engine, wrapper.Checkpoint):
				engine.file = file
		grounds = [engine for engine in O.engines if isinstance(engine, wrapper.MpmEngine)]
		for ground in grounds:
			ground.initialise()
	except BaseException:
		_talik.exchangeScene(former)
		raise
	return grounds[0] if grounds else None
