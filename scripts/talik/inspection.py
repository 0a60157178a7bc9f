# SPDX-License-Identifier: GPL-2.0-or-later
"""One sample of a paused slope as the current scene of O, and back.

	mpm.inspect(12)                    # O.bodies, O.interactions, O.cell, yade.utils and the 3-D view show the sample of point 12
	O.run(1000, True)                  # a copy: run it by hand, O.save() it as a plain YADE scene
	mpm.back()                         # the slope again, as it was

	with mpm.inspect(12, live=True):   # the slope's own: what is done to it stays, the next step of the slope asks it
		O.bodies[3].state.vel = (0, 0, 0)

	with mpm.inspect(12, live=True, form="open"):   # it goes on as this scene with any law of YADE's; the samples of all other points stay packed
		O.engines[2].lawDispatcher.functors[0].neverErase = True

Scenes are shown one above the other: back() and the end of a block return by one, closing what was opened inside.
"""

import atexit

from yade import O, wrapper

from talik import _talik
from talik.guards.runs import awaitEndOfStep, awaitRest

_shown = []  # views that are open, the innermost last
_left = []  # the scene left last stays alive: a long step of it may still be ending in YADE's thread


class View:
	"""A scene shown in O from its making until back() or the end of a `with` block, which gives the scene.

	scene  that is shown; point  whose sample it is, None for a scene of the user's; live  whether the slope takes over what was done;
	form  in which it goes on then, packed or open

	>>> view = mpm.inspect(5)
	>>> len(O.bodies)
	30
	>>> view.back()"""

	def __init__(self, scene, mpm=None, point=None, live=False, form="packed"):
		_talik.refuseFewerThreads(scene)
		self.scene, self.mpm, self.point, self.live, self.form = scene, mpm, point, live, form
		self._untouched = _talik.sceneBytes(scene) if live else None
		self._former = _talik.exchangeScene(scene)
		_shown.append(self)
		self._tell()

	def __enter__(self):
		return self.scene

	def __exit__(self, kind, error, trace):
		if self not in _shown:
			return
		try:
			if kind is None:
				self._takeOver()
		finally:
			self._leave()

	def back(self, keep=True, form=None):
		"""Returns to what was shown before. A live sample is taken over unless keep=False; ValueError if it cannot be a sample any
		more: it stays shown then. form="open": as this scene, with any law."""
		if self not in _shown:
			raise RuntimeError("back(): this view was left already")
		self.form = _checkedForm(form or self.form, self.live)
		if keep:
			try:
				self._takeOver()
			except ValueError as problem:
				remedy = "The sample stays shown: mend it and call back() again, or call back(keep=False), by which the ground keeps its own sample."
				if self.form == "packed":
					remedy += ' back(form="open") lets a scene of any law run behind this point alone, 20 to 30 times as slowly.'
				raise ValueError(f"{problem} {remedy}") from None
		self._leave()

	def _takeOver(self):
		_pause()
		if not self.live:
			return
		law = _skeletonOf(self.mpm, self.point)
		if self.form == "open" and law.cost()["form"] == "packed":
			from talik import refinement

			refinement.openSample(self.mpm, self.point, self.scene)
		elif _talik.sceneBytes(self.scene) != self._untouched:
			law.replaceScene(self.point, self.scene)

	def _leave(self):
		_pause()
		while _shown[-1] is not self:
			_shown[-1]._leave()
		_talik.exchangeScene(self._former)
		_shown.remove(self)
		_left[:] = [self.scene]
		self._tell()

	def _tell(self):
		if self.mpm is not None:
			self.mpm.inspected = any(_isOf(view, self.mpm) for view in _shown)

	def __repr__(self):
		what = "a scene" if self.point is None else f"the sample of point {self.point}, {'live' if self.live else 'a copy'}"
		where = "shown in O; back() returns" if self in _shown else "left"
		return f"<{what}, {where}>"


def inspect(scene):
	"""Shows a Scene in O: bodies, interactions, cell, engines and the 3-D view are its own; afterwards O is what it was.

	>>> with talik.inspect(mpm.skeleton.scene(12)):
	...     print(len(O.bodies))
	30

	RuntimeError while a simulation runs. Without `with`, talik.back() returns."""
	if not isinstance(scene, wrapper.Scene):
		raise TypeError(f"talik.inspect: got {type(scene).__name__}; give a Scene: packed.open(), talik.rve.openScene(sample) or mpm.skeleton.scene(id)")
	return View(scene)


def inspectPoint(mpm, id, live=False, form="packed"):
	"""inspect(id, live=False, form="packed"): the sample of a material point becomes the current scene of O, until back() or the end of a `with` block.

	A copy unless live=True: then the slope takes over what was done to it, and its next step asks the sample. With form="open" it goes on as this
	scene, with any law of YADE's, 20 to 30 times as slowly; the samples of other points stay packed. Works for samples of either form,
	and also in a scene that was just loaded. RuntimeError while a simulation runs or from inside of a step; ValueError for a point without sample.

	>>> with mpm.inspect(5):
	...     stress = utils.getStress()"""
	point = int(id)
	if O.running or _talik.stepUnderWay():
		raise RuntimeError("MpmEngine.inspect needs a simulation that rests between two steps: call O.pause() first, and look from outside of its engines.")
	awaitRest(O)
	mpm.initialise()
	skeleton = _skeletonOf(mpm, point)
	if live and any(view.live and _isOf(view, mpm) and view.point == point for view in _shown):
		raise RuntimeError(f"MpmEngine.inspect: the sample of point {point} is shown live already; go back() first.")
	return View(skeleton.scene(point), mpm, point, live, _checkedForm(form, live))


def backToGround(mpm, keep=True, form=None):
	"""back(keep=True, form=None): return from the sample shown last by inspect() to what was shown before.

	A sample shown with live=True is taken over unless keep=False; ValueError if it cannot be a sample any more: it stays shown then.
	form="open": it goes on as the scene that is shown, see inspect(). A run of the sample in the background is paused. RuntimeError if no
	sample of this ground is shown.

	>>> view = mpm.inspect(5)
	>>> mpm.back()"""
	own = [view for view in _shown if _isOf(view, mpm)]
	if not own:
		raise RuntimeError("MpmEngine.back: O shows no sample of this ground; see inspect().")
	own[-1].back(keep, form)


def back(keep=True):
	"""Returns from the scene shown last, see inspect().

	>>> view = talik.inspect(packed.open())
	>>> talik.back()"""
	if not _shown:
		raise RuntimeError("talik.back: O shows nothing but its own scene.")
	_shown[-1].back(keep)


def _checkedForm(form, live):
	if form not in ("packed", "open"):
		raise ValueError(f"MpmEngine.inspect: form is {form!r}: give 'packed' or 'open'.")
	if form == "open" and not live:
		raise ValueError("MpmEngine.inspect: form='open' is for a sample that the ground takes over, and this is a copy: give live=True, too.")
	return form


def _skeletonOf(mpm, point):
	for law in mpm.skeletons or [mpm.skeleton]:
		if isinstance(law, wrapper.RveSkeleton) and law.hasSample(point):
			return law
	if not 0 <= point < mpm.pointCount:
		raise ValueError(f"MpmEngine.inspect: there is no point {point}; ids run from 0 to {mpm.pointCount - 1}.")
	raise ValueError(f"MpmEngine.inspect: point {point} has no sample behind it: its skeleton is no RveSkeleton.")


def _isOf(view, mpm):
	return view.mpm is not None and _talik.sameObject(view.mpm, mpm)


def _pause():
	if _talik.stepUnderWay() or not (O.running or O.subStep >= 0):
		return
	O.pause()
	awaitEndOfStep(O)


@atexit.register
def _backToTheFirst():
	"""YADE ends with the scene that it began with."""
	if _shown:
		_shown[0]._leave()


# ---- points by what they suffer --------------------------------------------------------------------------------------------


def pick(mpm, x, y, z=None):
	"""Id of the point nearest to (x, y), in space (x, y, z) [m], in its present position.

	>>> id = mpm.pick(0.5, 0.5)"""
	import numpy as np

	position, place = mpm.field("position"), [x, y] if z is None else [x, y, z]
	if len(place) != position.shape[1]:
		raise ValueError("MpmEngine.pick: " + ("the ground is in space: give x, y and z." if z is None else "the ground lies in the plane: give x and y only."))
	distance = np.linalg.norm(position - np.array(place, float), axis=1)
	if not np.isfinite(distance).any():
		raise ValueError(f"MpmEngine.pick: ({', '.join(map(str, place))}) is no place.")
	return int(np.nanargmin(distance))


def most(mpm, field, n=10):
	"""Ids of the n points with the largest values of a field, largest first, the lower id first among equals; vectors and tensors by their
	length, points without a value left out.

	>>> len(mpm.most("temperature", n=3))
	3"""
	import numpy as np

	if n < 0:
		raise ValueError(f"MpmEngine.most: n is {n}: give 0 or more.")
	values = mpm.field(field)
	size = values if values.ndim == 1 else np.linalg.norm(values, axis=1)
	return [int(id) for id in np.argsort(-size, kind="stable") if not np.isnan(size[id])][:n]


def mostBroken(mpm, n=10):
	"""Ids of the n points whose samples have lost most bonds mechanically.

	>>> ids = mpm.mostBroken(n=3)"""
	return most(mpm, "bondsBroken", n)


def mostStrained(mpm, n=10):
	"""Ids of the n points with the largest deviatoric strain.

	>>> ids = mpm.mostStrained(n=3)"""
	return most(mpm, "deviatoricStrain", n)
