# SPDX-License-Identifier: GPL-2.0-or-later
"""Contacts for which an InteractionLoop has no functor: the first of them would end stock YADE, or throw out of a parallel loop."""

from yade import wrapper


def reason(kinds, loop, dense, avoided):
	"""Why, as the end of a sentence, with the remedy; empty if nothing of the kind is known.

	kinds    (body, how many) of bodies that the dispatchers and the collider cannot tell apart
	dense    every body is going to touch another
	avoided  mask of the collider: bodies of these groups do not meet among themselves"""
	return _whereNothingFits(kinds, loop, dense) or _ofIce(kinds, loop, avoided) if kinds else ""


def _materialOf(body):
	return type(body.material).__name__


def _madeBy(functor):
	"""Functors are named by what they take and, last, what they make: Ip2_FrictMat_FrictMat_FrictPhys. None if that is no class."""
	made = getattr(wrapper, type(functor).__name__.rpartition("_")[2], None)
	return made and made()


def _someLawFits(loop, parameters):
	"""True also where a functor does not say by its name what it makes."""
	made = [(_madeBy(geometry), _madeBy(functor)) for geometry in loop.geomDispatcher.functors for functor in parameters]
	return not loop.geomDispatcher.functors or any(
		geom is None or phys is None or loop.lawDispatcher.dispFunctor(geom, phys) is not None for geom, phys in made
	)


def _whereNothingFits(kinds, loop, dense):
	"""The first contact would be the end, whichever it is."""
	bodies, physics = [body for body, _ in kinds], loop.physDispatcher
	parameters = [physics.dispFunctor(first.material, second.material) for first in bodies for second in bodies]
	parameters = [functor for functor in parameters if functor is not None]
	if not parameters and not dense and physics.functors:
		return ""  # they may never touch
	if not parameters:
		names = ", ".join(sorted({_materialOf(body) for body in bodies}))
		return f"its InteractionLoop has no Ip2 functor for contacts of {names}: add one, e.g. Ip2_IceBondMat_IceBondMat_IceBondPhys()"
	if _someLawFits(loop, parameters):
		return ""
	return (
		f"its InteractionLoop has no Law2 functor for what {type(parameters[0]).__name__} makes of contacts: add one, " "e.g. Law2_ScGeom_IceBondPhys_IceBond()"
	)


def _mayMeet(first, second, count, avoided):
	"""As the collider decides it."""
	if first is second and count < 2:
		return False
	common = first.mask & second.mask
	return common != 0 and (first.mask != second.mask or first.mask & avoided == 0)


def _ofIce(kinds, loop, avoided):
	"""Contacts of ice-bonded grains that some Ig2 functor finds, and that no Ip2 or no Law2 functor knows."""
	geometries = loop.geomDispatcher
	for place, (a, count) in enumerate(kinds):
		for b, _ in kinds[place:]:
			if "IceBondMat" not in (_materialOf(a), _materialOf(b)) or not _mayMeet(a, b, count, avoided):
				continue
			if geometries.dispFunctor(a.shape, b.shape) is None and geometries.dispFunctor(b.shape, a.shape) is None:
				continue
			functor = loop.physDispatcher.dispFunctor(a.material, b.material)
			if functor is not None and _someLawFits(loop, [functor]):
				continue
			return (
				f"its InteractionLoop has no {'Ip2' if functor is None else 'Law2'} functor for contacts of O.bodies[{a.id}] ({_materialOf(a)}) and "
				f"O.bodies[{b.id}] ({_materialOf(b)}), the first of which would end YADE: add Ip2_FrictMat_FrictMat_FrictPhys() and "
				"Law2_ScGeom_FrictPhys_CundallStrack(), or keep them apart by Body.mask"
			)
	return ""
