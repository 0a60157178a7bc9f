# SPDX-License-Identifier: GPL-2.0-or-later
"""Files of scenes: saved between two steps and with a checksum, refused before YADE reads them where they are damaged."""

import builtins
import keyword
import os

from talik import _talik, ranks
from talik.files import saveScene, sceneContent
from talik.guards.calls import betweenSteps


def makeFilesSafe(omegaClass):
	"""The scene is saved between two steps of our engines, also while O runs, with a checksum if there is something of ours in it; and a
	file that is damaged is refused before YADE reads it. Doing it twice changes nothing."""
	if hasattr(omegaClass, "_stockSave"):
		return
	for name in ("saveTmp", "sceneToString"):
		setattr(omegaClass, name, betweenSteps(getattr(omegaClass, name)))
	stockSave, stockLoad = omegaClass._stockSave, omegaClass._stockLoad = betweenSteps(omegaClass.save), omegaClass.load

	def save(self, file, quiet=False):
		inMemory = file.startswith(":memory:")
		if not ranks.first and not inMemory:
			return
		if inMemory or not _holdsOurs(self):
			return stockSave(self, file, quiet)
		saveScene(file, lambda plain: stockSave(self, plain, quiet))
		_talik.setSceneFile(file)

	def load(self, file, quiet=False):
		if os.path.isfile(file):
			sceneContent(file)
		try:
			stockLoad(self, file, quiet)
		except RuntimeError as problem:
			raise RuntimeError(
				f"'{file}' cannot be read ({problem}): it is damaged or cut off, or of another version of YADE or Talik; take an earlier file"
			) from None

	save.__doc__, load.__doc__ = stockSave.__doc__, stockLoad.__doc__
	omegaClass.save, omegaClass.load = save, load


def _holdsOurs(omega):
	ours = set(_talik.ownClasses())
	return any(type(part).__name__ in ours for part in [*omega.engines, *omega.materials])


def checkedLabels(omega, file):
	"""Makes the labels of engines and functors names, as YADE does when it loads a scene; ValueError if one is no name: YADE runs it as
	a program."""
	from yade import wrapper

	for part in _labelled(omega.engines):
		label = getattr(part, "label", "")
		if label and (
			not label.isidentifier() or keyword.iskeyword(label) or hasattr(builtins, label) and not isinstance(getattr(builtins, label), wrapper.Serializable)
		):
			raise ValueError(
				f"'{file}': the label of {type(part).__name__} is {label!r}, which is no name for it; YADE would run it as a "
				"program. Take scenes only from those whose programs you would run."
			)
	omega.engines = omega.engines


def _labelled(engines):
	for engine in engines:
		yield engine
		for holder in [engine, *(getattr(engine, name, None) for name in ("geomDispatcher", "physDispatcher", "lawDispatcher", "boundDispatcher"))]:
			yield from getattr(holder, "functors", ())
		yield from getattr(engine, "comb", ())
