# SPDX-License-Identifier: GPL-2.0-or-later
"""Samples: periodic packings of grains that stand behind the material points of a slope.

	sample = talik.rve.prepare(grains=400, pressure=100e3)       # the paper's sample, at 100 kPa isotropic
	several = talik.rve.prepare(grains=100, realisations=8)      # a list of samples that differ by chance
	band = talik.rve.servo(sample, stressX=-15e3, stressY=-30e3) # the same sample at another stress
	other = talik.rve.load("somebody.yade.gz")                   # any periodic YADE scene of spheres

A sample is a file, an ordinary saved YADE scene, with what was measured in it. Prepared samples are kept in a cache
($XDG_CACHE_HOME/talik/samples, usually ~/.cache) under a key made of everything that they depend on.
The scene that is current in `O` is left alone. Stresses are in Pa, tension positive; pressures are compression positive.
"""

import contextlib
import dataclasses
import functools
import gzip
import hashlib
import json
import math
import os
import re
import sys
import tempfile
from pathlib import Path

import numpy as np
from yade import O, wrapper

import talik
from talik import packing, ranks, realisation
from talik.guards.scenefiles import checkedLabels
from talik.files import heldAlone, sceneContent, writableFolder, writeWhole
from talik.packing import Grains, PackingError

recipeVersion = {2: 3, 3: 4}  # of discs and spheres, part of the cache key: raise it whenever the recipe gives other samples
porosityTolerance = 0.005
fabricTolerance = 0.05
shearTolerance = 0.01  # of the mean pressure
yadesCell = 2.1  # smallest periodic cell over largest body that YADE runs
seedsToTry = 40
frictionsToTry = 6
loosestRolling, loosestFriction = 0.6, 1.2  # of the compaction of spheres that resist rolling, and of those that do not


@dataclasses.dataclass(frozen=True)
class Sample:
	"""A saved periodic scene and what was measured in it.

	>>> sample = talik.rve.prepare(grains=30, porosity=0.19)
	>>> sample.grains
	30"""

	path: str  # the YADE scene file
	parameters: dict  # everything it was made from
	grains: int
	thickness: float  # of discs: of the slice that carries their forces, of spheres: size of the cell along z [m]
	size: tuple  # lengths of the cell vectors [m], of discs those in the plane
	porosity: float  # of discs two-dimensional
	stress: tuple  # (xx, yy, xy) [Pa], of spheres (xx, yy, zz, yz, xz, xy), tension positive
	fabric: float  # largest less smallest principal value of the fabric of contact normals
	coordinationNumber: float  # 2 contacts per grain
	contacts: int

	@property
	def dimension(self):
		"""2: discs, 3: spheres."""
		return len(self.size)

	@property
	def pressure(self):
		"""Mean pressure [Pa], of discs that in the plane, compression positive."""
		return -sum(self.stress[: self.dimension]) / self.dimension

	def __str__(self):
		if self.dimension == 3:
			return (
				f"{self.grains} spheres, {' x '.join(f'{length:.4f}' for length in self.size)} m, porosity {self.porosity:.4f}, "
				f"stress {packing.componentNames[3]} {', '.join(f'{s / 1e3:.3f}' for s in self.stress)} kPa, F1-F3 {self.fabric:.4f}, "
				f"coordination number {self.coordinationNumber:.3f}"
			)
		xx, yy, xy = (s / 1e3 for s in self.stress)
		return (
			f"{self.grains} grains, {self.size[0]:.4f} x {self.size[1]:.4f} x {self.thickness:g} m, porosity {self.porosity:.4f}, "
			f"stress xx {xx:.3f} yy {yy:.3f} xy {xy:.4f} kPa, F1-F2 {self.fabric:.4f}, "
			f"coordination number {self.coordinationNumber:.3f}"
		)


def prepare(
	grains=400,
	radius=(3e-3, 7e-3),
	pressure=100e3,
	porosity=None,
	thickness=None,
	seed=1,
	young=0.6e9,
	stiffnessRatio=0.8,
	friction=0.5,
	density=2650.0,
	damping=0.3,
	ice=None,
	cache=True,
	realisations=None,
	dimension=2,
	poisson=None,
	**iceBond,
):
	"""The sample of Yu & Zhao sect. 3.1: discs compacted to an isotropic pressure, in equilibrium, without ice; or spheres in the same way.

	grains          number of grains, 20 or more
	radius          (smallest, largest) [m], distributed uniformly
	pressure        [Pa], > 0, compression positive
	porosity        of discs two-dimensional, met to 0.005 by the friction used during compaction; default 0.18 for discs (friction about
					0.2), 0.39 for spheres. Spheres with the radii of the default stand from 0.36 on, those that roll freely to 0.44, with
					etaRoll=0.2 to 0.48
	thickness       of the slice of ground that carries the forces of the discs [m], from the smallest radius to 1 m, default 0.1, that of
					the discs of YADE's examples/FEMxDEM/prepareRVE.py (Guo and Zhao), which has the radii, E_c0 and number of
					grains of Yu & Zhao; stress is divided by it, so stiffness and strength go with its inverse. One mean diameter is that of a single layer of
					grains. Kept in the file, as O.tags["thickness"] where the cell is deeper: YADE's collider wants a cell of more than
					2.1 times two largest radii and a smallest one. Spheres have none
	seed            of the random positions; the next seeds are tried where fabric or porosity miss their tolerance
	young           contact modulus E_c0 without ice [Pa]
	stiffnessRatio  k_s/k_n (YADE's "poisson")
	friction        coefficient of the finished sample
	density         of the grains [kg/m3]
	damping         of YADE's NewtonIntegrator, saved with the sample
	ice             True: materials and laws that can carry ice bonds (ice saturation 0); False: YADE's FrictMat.
					Default: True where Talik's classes are loaded
	cache           True: the user's cache; a folder; False: make it anew
	realisations    a number: that many samples of other random positions, a list, for RveSkeleton(samples=[…]); they are made by as many
					yades at a time as there are cores. The first one is the sample of `seed` alone
	dimension       2: discs, for ground in the plane; 3: spheres, for ground in space
	poisson         Poisson's ratio of the grains, 0 to below 0.5: contacts follow Hertz and Mindlin (IceBondMat.hertzMindlin), young is Young's modulus of the
					grains, and stiffnessRatio follows. Such samples stiffen with pressure. Default: linear springs
	iceBond         further attributes of IceBondMat, e.g. iceYoung=3e9; with one of RollingIceBondMat, e.g. etaRoll=0.2, grains resist rolling;
					with one of MomentIceBondMat, e.g. bondRadiusFactor=1, ice bonds carry moments

	Guaranteed or refused: porosity within 0.005, difference of the principal values of fabric below 0.05, shear stress and stress deviation
	below 1 % of the pressure.

	>>> sample = talik.rve.prepare(grains=30, porosity=0.19, pressure=100e3)"""
	_require("dimension", dimension, dimension in (2, 3), "2 (discs) or 3 (spheres)")
	_require("thickness", thickness, thickness is None or dimension == 2, "left out for spheres")
	thickness = 0.1 if thickness is None and dimension == 2 else thickness
	porosity = {2: 0.18, 3: 0.39}[dimension] if porosity is None else porosity
	material = _checkedGrains(grains, radius, thickness, young, stiffnessRatio, density, damping, ice, iceBond, dimension, poisson)
	_require("pressure", pressure, pressure > 0, "a compression in Pa, greater than 0")
	low, high = {2: (0.10, 0.23), 3: (0.25, 0.65)}[dimension]
	_require("porosity", porosity, low <= porosity <= high, f"a porosity between {low:.2f} and {high:.2f} (dense and loose limits of {_kind[dimension]})")
	_require("friction", friction, friction >= 0, "a friction coefficient, at least 0")
	_require("seed", seed, _isWhole(seed) and seed >= 0, "a whole number, at least 0")

	def made(start, folder, make):
		parameters = dict(
			kind="prepare", recipe=recipeVersion[dimension], **_valuesOf(material), pressure=pressure, porosity=porosity, friction=friction, seed=start
		)
		return _cached(parameters, folder, make)

	def compacted(start):
		return lambda: (_compacted if dimension == 2 else _compactedSpheres)(material, pressure, porosity, friction, start)

	if realisations is None:
		with ranks.inTurn("preparing a sample"):
			return made(seed, cache, compacted(seed))
	_require("realisations", realisations, _isWhole(realisations) and realisations >= 1, "a whole number, at least 1")
	folder = str(_cacheFolder(cache))
	settings = dict(
		grains=grains,
		radius=tuple(radius),
		pressure=pressure,
		porosity=porosity,
		thickness=thickness,
		young=young,
		stiffnessRatio=stiffnessRatio,
		friction=friction,
		density=density,
		damping=damping,
		ice=material.ice,
		cache=folder,
		**({} if dimension == 2 else dict(dimension=3)),
		**({} if poisson is None else dict(poisson=poisson)),
		**iceBond,
	)
	with ranks.inTurn("preparing realisations"):
		return realisation.prepareAll(
			lambda call: _inCache(lambda make: made(call["seed"], folder, make)),
			lambda call: made(call["seed"], folder, compacted(call["seed"])),
			[dict(settings, seed=start) for start in realisation.seedsOf(seed, realisations)],
			f"{realisations} realisations of {grains} grains",
		)


def servo(sample, stressX, stressY, stressXY=0.0, tolerance=2e-3, cache=True, stressZ=None):
	"""The same sample brought to another stress [Pa, tension positive, so both are negative], drained and ice-free.

	For the depth bands of a slope: servo to the geostatic stress first, freeze afterwards. `tolerance` is in units of the mean
	pressure. stressZ is that of spheres.

	sample  of prepare, servo or load; or a YADE Scene of any grains and law that runs as a sample: then a Scene is returned, the given one stays as it is, and
			nothing is cached. talik.rve.pack(file).servo(...) does the same for the packed form, and faster

	>>> deep = talik.rve.servo(sample, stressX=-80e3, stressY=-110e3)"""
	isScene = isinstance(sample, wrapper.Scene)
	material = None if isScene else _grainsOf(sample)
	dimension = dimensionOf(sample) if isScene else sample.dimension
	_require("stressZ", stressZ, (stressZ is None) == (dimension == 2), "given for spheres, and for them only")
	normal = dict(stressX=stressX, stressY=stressY, **({} if stressZ is None else dict(stressZ=stressZ)))
	for name, value in normal.items():
		_require(name, value, value < 0, "compressive, that is negative: grains without ice carry no tension")
	goal = (*map(float, normal.values()), *([] if stressZ is None else [0.0, 0.0]), float(stressXY))
	if isScene:
		return _servoedScene(sample, goal, tolerance)
	grains = dict(ice=False) if material is None else _valuesOf(material)
	parameters = dict(kind="servo", recipe=recipeVersion[2], **grains, goal=goal, tolerance=tolerance, parent=_digest(sample.path))

	def make():
		openFile(sample.path)
		packing.servoStress(material, goal, tolerance)
		return {}

	with ranks.inTurn("preparing a sample"):
		return _cached(parameters, cache, make)


def dimensionOf(scene):
	"""2 if a YADE Scene has discs, 3 if it has spheres.

	>>> talik.rve.dimensionOf(packed.open())
	2"""
	with _sceneInPlace(scene):
		return packing.dimension()


@contextlib.contextmanager
def _sceneInPlace(scene):
	"""The scene is that of `O` for the block."""
	with talik.scratchScene():
		talik._talik.exchangeScene(scene)
		yield


def _servoedScene(scene, goal, tolerance):
	wrapper.OpenRveSample(source=scene).statistics()  # refuses what is no sample
	copied = talik._talik.objectFromBytes(talik._talik.objectToBytes(scene))
	with _sceneInPlace(copied):
		packing.servoStress(None, goal, tolerance)
	return copied


def load(path):
	"""A sample from any saved YADE scene with a periodic cell and spheres only, also one made by somebody else's script.

	>>> other = talik.rve.load(sample.path)"""
	path = os.path.abspath(os.fspath(path))
	with talik.scratchScene():
		openFile(path)
		_checkScene(path)
		return _measured(path, dict(kind="load", path=path))


def openFile(path):
	"""A saved scene becomes the current one of `O`; one exception that says what is wrong with the file. Labels of engines become names,
	as with O.load, if they are names; a scene is a program all the same: its PyRunners run with its first step.

	>>> with talik.scratchScene():
	...     talik.rve.openFile(sample.path)"""
	if not os.path.isfile(path):
		raise FileNotFoundError(f"sample file '{path}' does not exist; give the path of a scene saved by O.save")
	content = sceneContent(path)
	try:
		scene = talik._talik.readScene(content, path.removesuffix(".gz").removesuffix(".bz2").endswith(".xml"))
	except Exception as error:
		raise ValueError(f"'{path}' is not a YADE scene that can be read ({error}); it must be saved by O.save of this YADE, and be complete") from None
	former = talik._talik.exchangeScene(scene)
	try:
		checkedLabels(O, path)
	except BaseException:
		talik._talik.exchangeScene(former)
		raise


# --- making --------------------------------------------------------------------------------------------------------------


def _compacted(material, pressure, porosity, friction, seed):
	"""Leaves a sample that meets every tolerance in the current scene; returns what was needed to get it."""
	closest = math.inf
	for trial in range(seed, seed + seedsToTry):
		compactionFriction, reached = _calibrated(material, pressure, porosity, trial)
		closest = min(closest, abs(reached - porosity))
		if compactionFriction is None or not _isotropic():
			continue
		packing.setFriction(friction)
		packing.servoStress(material, (-pressure,) * material.dimension + (0.0,) * (1 if material.dimension == 2 else 3))
		if _isotropic() and abs(packing.porosity() - porosity) < porosityTolerance:
			return dict(seedUsed=trial, compactionFriction=compactionFriction)
	raise PackingError(
		f"no sample of {material.number} grains with porosity {porosity:g} and isotropic fabric in {seedsToTry} trials "
		f"(closest porosity off by {closest:.4f}); use more grains or another porosity"
	)


def _compactedSpheres(material, pressure, porosity, friction, seed):
	"""As _compacted, in packed form: YADE takes minutes for a few hundred spheres. Friction and rolling friction of the compaction are bisected together,
	until the sample with its own friction has the porosity."""
	with _bar() as bar:
		for trial in range(seed, seed + seedsToTry):
			low, high, part = 0.0, 1.0, 0.3
			for _ in range(frictionsToTry + 1):
				compaction = (part * loosestFriction, 0.0)
				if material.resistsRolling:
					compaction = (min(1.0, 2 * part) * friction, max(0.0, 2 * part - 1) * loosestRolling)
				reached = _spheres(material, pressure, friction, trial, *compaction)
				bar.update()
				bar.set_postfix(seed=trial, porosity=f"{reached:.3f}")
				if abs(reached - porosity) < 0.8 * porosityTolerance:
					break
				low, high = (part, high) if reached < porosity else (low, part)
				part = 0.5 * (low + high)
			if abs(reached - porosity) < porosityTolerance and _isotropic():
				return dict(seedUsed=trial, compactionFriction=compaction[0], compactionRolling=compaction[1])
			if (low == 0.0 or high == 1.0) and abs(reached - porosity) > 2 * porosityTolerance:
				kind, remedy = ("densest", "a larger porosity") if low == 0.0 else ("loosest", "a smaller porosity, more friction, or etaRoll")
				raise PackingError(f"the {kind} packing of these spheres at {pressure:g} Pa has porosity {reached:.3f}, not {porosity:g}; take {remedy}")
	raise PackingError(f"no sample of {material.number} spheres with porosity {porosity:g} and isotropic fabric in {seedsToTry} trials; use more grains")


def _spheres(material, pressure, friction, seed, compactionFriction, compactionRolling):
	"""Leaves compacted spheres with their own friction at the pressure in the current scene; returns their porosity."""
	sample = packing.compactPacked(material, pressure, compactionFriction, seed, compactionRolling)
	with _sceneInPlace(sample.open()):
		packing.setFriction(friction)
		if material.resistsRolling:
			packing.setRolling(dict(material.iceBond).get("etaRoll", wrapper.RollingIceBondMat().etaRoll))
		sample = wrapper.RveSample.fromScene(O._sceneObj)
	if not sample.servo(-pressure, -pressure, -pressure):
		raise PackingError(f"the spheres find no equilibrium at {pressure:g} Pa with a friction of {friction:g}; use more grains or another seed")
	talik._talik.exchangeScene(sample.open())
	O.dt = material.timeStep
	return packing.porosity()


def _bar():
	from tqdm import tqdm

	return tqdm(desc="preparing spheres", unit="packing", file=sys.stderr, disable=not sys.stderr.isatty())


def _calibrated(material, pressure, porosity, seed):
	"""Bisects the compaction friction until the porosity is met: (friction or None, porosity reached)."""
	low, high, friction = 0.0, 0.6, 0.2
	for _ in range(frictionsToTry):
		O.resetThisScene()
		packing.fillCloud(material, friction, seed)
		packing.compact(material, pressure)
		reached = packing.porosity()
		if abs(reached - porosity) < 0.8 * porosityTolerance:  # relaxation still moves it a little
			return friction, reached
		low, high = (friction, high) if reached < porosity else (low, friction)
		friction = 0.5 * (low + high)
	return None, reached


def _isotropic():
	normals = packing.contactNormals()
	return packing.fabricAnisotropy(packing.fabricTensor(normals)) < fabricTolerance


# --- keeping -------------------------------------------------------------------------------------------------------------


def _cached(parameters, cache, make):
	folder = _cacheFolder(cache)
	key = hashlib.sha256(json.dumps({**parameters, "layout": _classLayout(parameters["ice"]), "sheet": 2}, sort_keys=True).encode()).hexdigest()[:20]
	scene, sheet = folder / f"{key}.yade.gz", folder / f"{key}.json"
	if cache is not False:
		found = _found(sheet, scene, parameters)
		if found:
			return found
	writableFolder(folder, "give a folder of yours as cache=, or set XDG_CACHE_HOME")
	with heldAlone(folder / f".{key}.lock", f"the sample {scene}"):
		# made while this process waited; what is not whole now is damaged, not half written
		found = cache is not False and _found(sheet, scene, parameters, told=True)
		return found or _makeAndKeep(sheet, scene, key, parameters, make)


def _found(sheet, scene, parameters, told=False):
	"""The sample of these files; None if there is none, or one that is damaged or another, which is said if told."""
	if not (scene.exists() or sheet.exists()):
		return None
	try:
		return _fromSheet(sheet, scene, parameters)
	except (OSError, ValueError, TypeError, KeyError) as problem:
		if told:
			print(f"talik.rve: the cached sample {scene} is {_said(problem)}; it is made anew.", file=sys.stderr)
		return None


def _makeAndKeep(sheet, scene, key, parameters, make):
	with talik.scratchScene():
		extra = make()
		sample = _measured(str(scene), {**parameters, **extra})
		_forgetWhenItWasMade(key)
		content = gzip.compress(O.sceneToString(), 6, mtime=0)
		writeWhole(scene, content)
	values = dataclasses.asdict(sample)
	writeWhole(sheet, json.dumps({**values, "seal": _seal(values, content)}, indent="\t"))
	return _fromSheet(sheet, scene, parameters)  # the same whether it was made or found


def _forgetWhenItWasMade(name):
	"""What a ground keeps of the scene depends on the sample alone, whoever made it."""
	for tag in ("isoTime", "id", "d.id", "id.d"):
		O.tags[tag] = name


def _seal(values, content):
	"""Ties sheet and scene to each other, wherever they lie."""
	sheet = json.dumps({name: value for name, value in values.items() if name != "path"}, sort_keys=True)
	return hashlib.sha256(sheet.encode() + content).hexdigest()


def _said(problem):
	if isinstance(problem, OSError):
		return f"not readable ({problem.strerror})"
	return str(problem) if type(problem) is ValueError else "damaged, its sheet cannot be read"


class _NotThere(Exception):
	pass


def _inCache(made):
	"""The sample that a call of _cached finds, without making one; None if there is none."""

	def refuse():
		raise _NotThere

	try:
		return made(refuse)
	except _NotThere:
		return None


@functools.lru_cache(maxsize=None)
def _classLayout(ice):
	"""Digest of the names of all that a saved pair of touching grains consists of, in their order.

	A saved scene can be read only by classes that have the same attributes as those that wrote it."""
	grains = _checkedGrains(20, (3e-3, 7e-3), 0.1, 0.6e9, 0.8, 2650.0, 0.3, ice, {}, 2)
	with talik.scratchScene(), tempfile.TemporaryDirectory() as folder:
		packing.fillPair(grains)
		packing.advance(2)
		file = os.path.join(folder, "pair.xml")
		O._stockSave(file, True)  # on every rank
		names = re.findall(rb"<(\w+)", Path(file).read_bytes())
	return hashlib.sha256(b" ".join(names)).hexdigest()[:20]


def _cacheFolder(cache):
	if cache is True:
		base = os.environ.get("XDG_CACHE_HOME") or os.path.join(os.path.expanduser("~"), ".cache")
		folder = Path(base) / "talik" / "samples"
	elif cache is False:
		return Path(tempfile.mkdtemp(prefix="talik-sample-"))
	else:
		folder = Path(cache)
	return folder


def _fromSheet(sheet, scene, parameters):
	"""The sample of a sheet; ValueError unless the sheet is whole and of these parameters, and the scene the one that it was written for."""
	try:
		values = json.loads(sheet.read_text())
	except ValueError:
		raise TypeError("no sheet") from None
	if values.pop("seal") != _seal(values, scene.read_bytes()):
		raise ValueError("damaged: sheet and scene do not fit together")
	wanted = json.loads(json.dumps(parameters))
	if any(values["parameters"].get(name) != value for name, value in wanted.items()):
		raise ValueError("another one, its sheet has other parameters")
	values.update(path=str(scene), size=tuple(values["size"]), stress=tuple(values["stress"]))
	return Sample(**values)


def _digest(path):
	try:
		return hashlib.sha256(Path(path).read_bytes()).hexdigest()[:20]
	except OSError as error:
		raise FileNotFoundError(f"sample file '{path}' cannot be read ({error.strerror}); prepare the sample again") from None


# --- measuring and checking ----------------------------------------------------------------------------------------------


def _measured(path, parameters):
	normals = packing.contactNormals()
	cell, h = packing.cell(), O.cell.hSize
	number = len(O.bodies)
	return Sample(
		path=path,
		parameters=parameters,
		grains=number,
		thickness=packing.thickness() if packing.dimension() == 2 else float(h[2, 2]),
		size=tuple(float(length) for length in np.linalg.norm(cell, axis=0)),
		porosity=float(packing.porosity()),
		stress=tuple(float(component) for component in packing.stress()),
		fabric=packing.fabricAnisotropy(packing.fabricTensor(normals)),
		coordinationNumber=2 * len(normals) / number,
		contacts=len(normals),
	)


def _checkScene(path):
	if not O.periodic:
		raise ValueError(f"'{path}' has no periodic cell; a sample needs O.periodic=True")
	if len(O.bodies) == 0:
		raise ValueError(f"'{path}' has no bodies; a sample needs grains")
	others = {type(body.shape).__name__ for body in O.bodies if body is not None} - {"Sphere"}
	if others:
		raise ValueError(f"'{path}' has bodies of shape {', '.join(sorted(others))}; a sample may have spheres only")
	h = O.cell.hSize
	if packing.dimension() == 3:
		return
	if max(abs(h[0, 2]), abs(h[1, 2]), abs(h[2, 0]), abs(h[2, 1])) > 1e-12 * abs(h[2, 2]):
		raise ValueError(f"'{path}': the cell is inclined in z (hSize = {h}); for plane strain its third vector must be (0, 0, thickness)")


def _isWhole(value):
	return isinstance(value, (int, np.integer)) and not isinstance(value, bool)


def _require(name, value, condition, remedy):
	if not condition:
		raise ValueError(f"{name} is {value!r}; it must be {remedy}")


_kind = {2: "discs", 3: "spheres"}


def _valuesOf(material):
	"""Parameters of grains, for sheets and keys: those of discs are what they were when there were only discs."""
	values = dataclasses.asdict(material)
	if values["dimension"] == 2:
		del values["dimension"]
	for name in ("depth", "poisson"):
		if values[name] is None:
			del values[name]
	return values


def _checkedGrains(number, radius, thickness, young, stiffnessRatio, density, damping, ice, iceBond, dimension, poisson=None):
	_require("grains", number, _isWhole(number) and number >= 20, "a whole number, at least 20")
	try:
		smallest, largest = (float(r) for r in radius)
	except (TypeError, ValueError):
		raise ValueError(f"radius is {radius!r}; it must be a pair (smallest, largest) in m") from None
	_require("radius", radius, 0 < smallest <= largest < math.inf, "a pair (smallest, largest) in m with 0 < smallest <= largest")
	if dimension == 2:
		_require("thickness", thickness, smallest <= thickness <= 1, f"between the smallest radius, {smallest:g} m, and 1 m")
	thinnest = yadesCell * (2 * largest + smallest)  # a disc with the collider's margin, half a smallest radius on either side
	for name, value in (("young", young), ("stiffnessRatio", stiffnessRatio), ("density", density)):
		_require(name, value, 0 < value < math.inf, "greater than 0 and finite")
	_require("damping", damping, 0 < damping < 1, "between 0 and 1")
	available = packing.iceBondAvailable()
	_require("ice", ice, not ice or available, "False: the ice-bond classes of Talik are not loaded")
	withIce = available if ice is None else bool(ice)
	_require("poisson", poisson, poisson is None or 0 <= poisson < 0.5, "Poisson's ratio of the grains, from 0 to below 0.5")
	_require("ice", ice, withIce or poisson is None, "True for grains of Hertz and Mindlin (poisson): FrictMat has linear springs")
	_require("ice", ice, withIce or not iceBond, f"True when attributes of IceBondMat are given ({', '.join(iceBond)})")
	return Grains(
		number=number,
		radiusMin=smallest,
		radiusMax=largest,
		thickness=float(thickness) if dimension == 2 else None,
		young=float(young),
		stiffnessRatio=float(stiffnessRatio),
		density=float(density),
		damping=float(damping),
		ice=withIce,
		iceBond=tuple(sorted(iceBond.items())),
		dimension=dimension,
		depth=None if dimension == 3 or thickness > thinnest else max(0.1, 1.05 * thinnest),
		poisson=None if poisson is None else float(poisson),
	)


def _grainsOf(sample):
	"""What the sample was prepared from; None for a scene of another script."""
	names = [field.name for field in dataclasses.fields(Grains) if field.name in sample.parameters]
	if any(field.name not in names for field in dataclasses.fields(Grains) if field.default is dataclasses.MISSING):
		return None
	values = {name: sample.parameters[name] for name in names}
	return Grains(**{**values, "iceBond": tuple(tuple(pair) for pair in values["iceBond"])})


def listOf(samples):
	"""One sample or several, as a list.

	>>> talik.rve.listOf(sample) == [sample]
	True"""
	several = list(samples) if isinstance(samples, (list, tuple)) else [samples]
	if not several:
		raise ValueError("samples is an empty list; give at least one sample, e.g. talik.rve.pack(talik.rve.prepare())")
	return several


def pack(sample):
	"""Packed form (RveSample) of a prepared sample (talik.rve.Sample), of a scene file or of a YADE Scene object; of a list of them a list.

	The time step is lowered to what the contacts need when they are stiffened by full ice saturation, and the work of the
	neighbour search is left to the packed form. ValueError tells why a scene cannot be packed.

	>>> packed = talik.rve.pack(sample)"""
	if isinstance(sample, (list, tuple)):
		return [pack(one) for one in sample]
	if isinstance(sample, wrapper.Scene):
		return wrapper.RveSample.fromScene(sample)
	path = getattr(sample, "path", sample)
	with talik.scratchScene():
		openFile(str(path))
		return wrapper.RveSample.fromScene(O._sceneObj)


def openScene(sample):
	"""YADE Scene of a prepared sample or a scene file, for RveSkeleton(scenes=[…]) and OpenRveSample: samples of any grains and law.

	The time step is lowered as pack() does it.

	>>> skeleton = RveSkeleton(scenes=[talik.rve.openScene(sample)], form="open")"""
	path = getattr(sample, "path", sample)
	with talik.scratchScene():
		openFile(str(path))
		O.dt = talik._talik.timeStepForIce(O._sceneObj)
		return O._sceneObj
