# SPDX-License-Identifier: GPL-2.0-or-later
"""Arguments of MpmEngine.addPoints, as columns of numbers; and strain from deformation gradients."""

import math

import numpy as np

names = ("position", "volume", "porosity", "temperature", "pressure", "skeleton", "stress", "velocity", "poreFill", "material")
defaults = {"volume": math.nan, "porosity": 0.4, "stress": math.nan, "poreFill": math.nan}
orders = {4: "xx, yy, zz, xy", 6: "xx, yy, zz, yz, xz, xy"}


def columns(positional, named, dimension, materials, said=0):
	"""(number of points, dimension, arrays): of each of `names` the numbers of all points, or of one where they are alike. ValueError says what is wrong.

	dimension  of the points that were added before, 0: none
	materials  their names
	said       MpmEngine.dimension, 0: what the points have

	>>> count, dimension, arrays = talik._points.columns(([(0.5, 0.5)], 0.01), {}, 0, [])"""
	given = {**named, **dict(zip(names, positional))}
	if "material" in given:
		given["material"] = _numbersOf(given["material"], materials)
	if "position" not in given:
		_refuse("position is missing; give an array (n,2) or (n,3) [m].")
	position = _array("addPoints: position", given["position"])
	if position.ndim != 2 or position.shape[1] not in (2, 3):
		_refuse("position is not an array (n,2) or, in space, (n,3).")
	count, width = position.shape
	if dimension and width != dimension:
		_refuse(f"position is an array (n,{width}), but points with {dimension} coordinates were added before: give all points the same number of them.")
	if count and said not in (0, width):
		_refuse(f"position is an array (n,{width}), but MpmEngine.dimension is {said}: give as many coordinates, or leave dimension out.")
	components, arrays = {"stress": 4 if width == 2 else 6, "velocity": width}, [position]
	for name in names[1:]:
		parts = components.get(name, 1)
		arrays.append(_column(name, given[name], parts, count) if name in given else np.full(parts, defaults.get(name, 0.0)))
		if name == "stress" and name in given and np.isnan(arrays[-1]).any():
			_refuse("stress is nan: give finite numbers in Pa, or leave stress out for none.")
		if name == "skeleton":
			_requireWholeNumbers(arrays[-1], name, "the number of a law in skeletons")
		if name == "material":
			_requireWholeNumbers(arrays[-1], name, "the name or number of a material in materials")
	unknown = [name for name in given if name not in names]
	if unknown:
		_refuse(f"there is no argument '{unknown[0]}': choose among {', '.join(names[:-1])} and material.")
	return count, width, arrays


def _refuse(why):
	raise ValueError(f"MpmEngine.addPoints: {why}")


def _array(name, values):
	try:
		return np.array(values, dtype=float, order="C")
	except (TypeError, ValueError):
		raise ValueError(f"MpmEngine.{name} is {values}: give a number or an array of numbers.") from None


def _column(name, values, components, count):
	"""Numbers once or for each point, from a scalar, a row of components, or an array with a row per point."""
	array = _array(f"addPoints: {name}", values)
	uniform = array.size == components and (components > 1 or array.ndim == 0 or count == 1)
	if not uniform and array.size != count * components:
		order = f", in the order of field('stress'): {orders[components]}" if name == "stress" else ""
		_refuse(f"{name} has {array.size} numbers for {count} points: give {components} or {count * components}{order}.")
	return array


def _requireWholeNumbers(array, name, what):
	"""skeleton is the number of a law, material that of a material: half a number is none."""
	wrong = array[~((array == np.floor(array)) & (abs(array) <= 1e9))]
	for number in wrong[:1]:
		_refuse(f"{name} is {number:.10g}: give {what}, a whole number.")


def _numbersOf(given, materials):
	"""Names of materials become their numbers; numbers stay."""
	if isinstance(given, str):
		return _numberOf(given, materials)
	if np.ndim(given) == 0:
		return given
	return [_numberOf(value, materials) if isinstance(value, str) else value for value in given]


def _numberOf(name, materials):
	if name in materials and name:
		return materials.index(name)
	known = ", ".join(filter(None, materials))
	known = f"only {known}." if known else f"no material with a name: set materials=[GroundMaterial(name='{name}', …)] first."
	_refuse(f"material is '{name}', and MpmEngine.materials has {known}")


def watched(ids, points):
	"""Numbers of the points that MpmEngine.watch is given, each once, a list."""
	numbers = _array("watch: ids", ids).ravel()
	for number in numbers[~((numbers >= 0) & (numbers < points) & (numbers == np.floor(numbers)))][:1]:
		raise ValueError(f"MpmEngine.watch: {number:.10g} is no point: give ids from 0 to {points - 1}.")
	return list(dict.fromkeys(int(number) for number in numbers))


def temperatures(values, points):
	"""What MpmEngine.setTemperature gives each point [degC]."""
	array = _array("setTemperature: temperature", values)
	if array.ndim and len(array) != points:
		raise ValueError("MpmEngine.setTemperature: give a number or one per point.")
	for value in array.ravel()[~(abs(array.ravel()) < 100)][:1]:
		raise ValueError(f"MpmEngine.setTemperature: temperature is {value:.10g}: give -100 to 100 degC.")
	return np.array(np.broadcast_to(array, points))


def lawNumbers(skeletonOf, points, laws):
	"""Numbers of laws that MpmEngine.exchangeSkeletons gives to the points, a list."""
	prefix = "MpmEngine.exchangeSkeletons: skeletonOf "
	if len(skeletonOf) != points:
		raise ValueError(f"{prefix}has {len(skeletonOf)} numbers for {points} points: give one per point.")
	numbers = [int(number) for number in skeletonOf]
	for point, number in enumerate(numbers):
		if not 0 <= number < laws:
			raise ValueError(f"{prefix}[{point}] is {number}: give an index into skeletons, 0 to {laws - 1}.")
	return numbers


def field(mpm, name, measured):
	"""What MpmEngine.field returns. measured: what laws measure by this name, arrays, nan where a point has another law."""
	if name in ("strain", "deviatoricStrain"):
		if not mpm.motion:
			raise ValueError(f"MpmEngine.field: {name} needs motion.")
		gradients = mpm._storedField("deformationGradient")
		return strain(name, aboutAxis(gradients, mpm) if mpm.axisymmetric else gradients)
	if measured:
		result = measured[0]
		for other in measured[1:]:
			lacking = np.isnan(result if result.ndim == 1 else result[:, 0])
			result[lacking] = other[lacking]
		return result
	stored = mpm._storedField(name)
	if stored is None:
		raise ValueError(f"MpmEngine.field: there is no field '{name}' in this scene: choose one of {', '.join(mpm.fieldNames())}.")
	return stored


def aboutAxis(gradients, mpm):
	"""Deformation gradients (n, 9) from those in the plane (n, 4) and the change of the radius."""
	radius, moved = mpm.field("position")[:, 0], mpm.field("displacement")[:, 0]
	all9 = np.zeros((len(radius), 9))
	all9[:, [0, 1, 3, 4]], all9[:, 8] = gradients, radius / (radius - moved)
	return all9


def strain(name, gradients):
	"""Logarithmic strain 1/2 ln(F F^T) [-] of deformation gradients F (n, 4) or (n, 9), row by row: xx, yy, xy or xx, yy, zz, yz, xz, xy; or, by the name
	deviatoricStrain, sqrt(2/3 e:e) of its deviator, in the plane that of plane strain. nan where F is.

	>>> talik._points.strain("deviatoricStrain", np.array([[1.0, 0.0, 0.0, 1.0]]))
	array([0.])"""
	size = math.isqrt(gradients.shape[-1])
	gradient = gradients.reshape(-1, size, size)
	e = _ofPlane(gradient) if size == 2 else _ofSpace(gradient)
	if name == "strain":
		return e[:, [0, 1, 0], [0, 1, 1]] if size == 2 else e[:, [0, 1, 2, 1, 0, 0], [0, 1, 2, 2, 2, 1]]
	third = np.trace(e, axis1=1, axis2=2) / 3
	deviator = e - third[:, None, None] * np.eye(size)
	return np.sqrt(2 / 3 * (np.einsum("nij,nij->n", deviator, deviator) + (3 - size) * third**2))


def _ofSpace(gradient):
	known, e = np.isfinite(gradient).all(axis=(1, 2)), np.full(gradient.shape, math.nan)
	squares, axes = np.linalg.eigh(np.einsum("nij,nkj->nik", gradient[known], gradient[known]))
	e[known] = np.einsum("nij,nj,nkj->nik", axes, 0.5 * np.log(np.maximum(squares, 1e-300)), axes)
	return e


def _ofPlane(gradient):
	"""The same in closed form, which takes a tenth of the time."""
	(xx, xy), (yx, yy) = gradient.transpose(1, 2, 0)
	square, other, mixed = xx * xx + xy * xy, yx * yx + yy * yy, xx * yx + xy * yy
	mean = (square + other) / 2
	radius = np.sqrt(np.maximum(mean * mean - (square * other - mixed * mixed), 0))
	first, second = 0.5 * np.log(mean + radius), 0.5 * np.log(np.maximum(mean - radius, 1e-300))
	half = np.divide(first - second, 2 * radius, out=np.zeros_like(radius), where=radius > 0)
	e = np.empty(gradient.shape)
	e[:, 0, 0], e[:, 1, 1] = (first + second + half * (square - other)) / 2, (first + second - half * (square - other)) / 2
	e[:, 0, 1] = e[:, 1, 0] = half * mixed
	return e
