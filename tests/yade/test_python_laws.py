# SPDX-License-Identifier: GPL-2.0-or-later
"""Skeleton laws written in Python: held against closed forms in the plane and in space, restarted to the last bit; a wrong one ends the run by
one sentence that names it."""

import sys

import numpy as np
import pytest
from yade import O, wrapper

import talik

young, poisson = 5e6, 0.3
bulk, shear = young / (3 - 6 * poisson), young / (2 + 2 * poisson)
oedometer = bulk + 4 * shear / 3

lawsInAModule = """
import numpy as np

bulk, shear, strength, hardening = {bulk!r}, {shear!r}, {strength!r}, {hardening!r}
unit = np.array([1, 1, 1, 0, 0, 0.])


def elastic(step):
	sphere, width = unit[:step.stress.shape[1]], step.stress.shape[1]
	volumetric = step.strain[:, :3].sum(axis=1)[:, None]
	step.stress += (bulk - 2 * shear / 3) * volumetric * sphere + 2 * shear * step.strain


def misesPlasticity(step):
	\"\"\"Radial return to sqrt(3 J2) = strength + hardening times the plastic strain.\"\"\"
	elastic(step)
	mean = step.stress[:, :3].mean(axis=1)[:, None] * unit[:step.stress.shape[1]]
	deviator = step.stress - mean
	size = np.sqrt(1.5 * (deviator[:, :3]**2).sum(axis=1) + 3 * (deviator[:, 3:]**2).sum(axis=1))
	flow = np.maximum(0, size - strength - hardening * step.state[:, 0]) / (3 * shear + hardening)
	step.state[:, 0] += flow
	return mean + deviator * (1 - 3 * shear * flow / np.maximum(size, 1e-9))[:, None]


def bingham(step):
	\"\"\"As BinghamSkeleton, with a yield stress of 800 Pa and a viscosity of 50 Pa s.\"\"\"
	elastic(step)
	mean = step.stress[:, :3].mean(axis=1)[:, None] * unit[:step.stress.shape[1]]
	deviator = step.stress - mean
	trial = np.sqrt((deviator[:, :3]**2).sum(axis=1) / 2 + (deviator[:, 3:]**2).sum(axis=1))
	ratio = shear * step.timeStep / 50
	tau = np.where(trial > 800, (trial + ratio * 800) / (1 + ratio), trial)
	step.state[:, 0] += (trial - tau) / shear
	return mean + deviator * (tau / np.maximum(trial, 1e-9))[:, None]


class Viscous:
	def __init__(self, relaxation):
		self.relaxation = relaxation

	def __call__(self, step):
		mean = step.stress[:, :3].mean(axis=1)[:, None] * unit[:step.stress.shape[1]]
		step.state = step.state + step.timeStep
		return mean + (step.stress - mean) / (1 + step.timeStep / self.relaxation)


tenth = Viscous(0.1)
"""


@pytest.fixture
def laws(tmp_path, monkeypatch):
	"""A module of laws, as a user has one beside the script."""
	(tmp_path / "ownlaws.py").write_text(lawsInAModule.format(bulk=bulk, shear=shear, strength=2e4, hardening=1e5))
	monkeypatch.syspath_prepend(tmp_path)
	yield __import__("ownlaws")
	sys.modules.pop("ownlaws", None)


def column(dimension, law, h=0.25, height=2.0, top=True, **settings):
	"""One cell wide, between rollers."""
	width, sides = (h,) * (dimension - 1), ("left", "right", "front", "back")[: 2 * (dimension - 1)]
	upper = (*width, height + (0.5 if top else 0))
	axes = [np.arange(h / 4, extent, h / 2) for extent in (*width, height)]
	position = np.stack([axis.ravel() for axis in np.meshgrid(*axes, indexing="ij")], axis=1)
	boundaries = [wrapper.RollerBoundary(region=side) for side in (*sides, "bottom", *([] if top else ["top"]))]
	mpm = wrapper.MpmEngine(gridSpacing=h, lower=(0,) * dimension, upper=upper, skeleton=law, **{"boundaries": boundaries, **settings})
	O.engines = [mpm]
	return mpm, position, (h / 2) ** dimension


def runFor(mpm, seconds):
	begin = mpm.time
	while mpm.time < begin + seconds:
		O.step()


@pytest.mark.parametrize("dimension", (2, 3))
def test_an_elastic_law_in_python_has_the_stress_and_settlement_of_a_column_under_its_weight(dimension, laws):
	"""Confined: vertical stress is the weight above, horizontal nu/(1-nu) of it, settlement W (H y - y^2/2)/M."""
	up, height = dimension - 1, 2.0
	law = wrapper.PythonSkeleton(law=laws.elastic, modulus=oedometer, canFail=False)
	h = 0.125
	mpm, position, volume = column(dimension, law, h=h, height=height, gravity=(0,) * (dimension - 1) + (-9.81,), damping=0.5)
	mpm.addPoints(position=position, volume=volume)
	runFor(mpm, 1.5)
	unitWeight = 9.81 * mpm.field("mass").sum() / (volume * len(position))
	y, stress = position[:, up], mpm.field("stress")
	settlement = y - mpm.field("position")[:, up]
	byHand = unitWeight * (height * y - y**2 / 2) / oedometer
	# B-bar makes the mean of a cell of what is linear in it
	cells = (y // h).astype(int)
	mean = np.array([stress[cells == c].mean(axis=0) for c in range(cells.max() + 1)])
	vertical = -unitWeight * (height - h * (0.5 + np.arange(len(mean))))
	errors = {
		"vertical": abs(mean[:, up] - vertical).max() / (unitWeight * height),
		"horizontal": abs(mean[:, 0] - poisson / (1 - poisson) * vertical).max() / (unitWeight * height),
		"settlement": abs(settlement - byHand).max() / byHand.max(),
	}
	print(f"{dimension} dimensions: errors {', '.join(f'{name} {error:.1e}' for name, error in errors.items())}; settled {settlement.max():.2e} m")
	assert max(errors.values()) < 0.01


@pytest.mark.parametrize("dimension", (2, 3))
def test_von_mises_plasticity_in_python_hardens_in_confined_compression_as_its_closed_form_does(dimension, laws):
	"""Axial stress -(K e + 2/3 q) with q = (Y + H 2e/3)/(1 + H/(3 G)) beyond yield, from q = 2 G e - 3 G f = Y + H f with the plastic strain f."""
	law = wrapper.PythonSkeleton(law=laws.misesPlasticity, modulus=oedometer, states=["plasticStrain"])
	mpm, position, volume = column(dimension, law, height=1.0, top=False, damping=0.3)
	mpm.boundaries = mpm.boundaries[:-1] + [wrapper.MovingBoundary(region="top", rough=False, times=[0, 1, 1.0001], values=[0.01, 0.01, 0])]
	mpm.addPoints(position=position, volume=volume)
	runFor(mpm, 1.5)
	strain = -np.log(1 - 0.01)
	q = (2e4 + 1e5 * 2 / 3 * strain) / (1 + 1e5 / (3 * shear))
	axial, lateral = -(bulk * strain + 2 / 3 * q), -(bulk * strain - q / 3)
	stress, flow = mpm.field("stress"), mpm.field("skeleton0.plasticStrain")
	errors = {
		"axial": abs(stress[:, dimension - 1] / axial - 1).max(),
		"lateral": abs(stress[:, 0] / lateral - 1).max(),
		"plastic strain": abs(flow / ((q - 2e4) / 1e5) - 1).max(),
	}
	print(f"{dimension} dimensions: axial {axial:.0f} Pa, errors {', '.join(f'{name} {error:.1e}' for name, error in errors.items())}")
	assert 2 * shear * strain > 1.8 * q  # far beyond yield
	assert max(errors.values()) < 0.02


def test_a_viscous_object_given_by_its_name_relaxes_by_the_time_that_passes(laws):
	"""Held ground: the deviator falls to exp(-t/T), its mean stays."""
	law = wrapper.PythonSkeleton(law="ownlaws:tenth", modulus=oedometer, states=["age"], statesAtStart=[5])
	mpm, position, volume = column(3, law, height=0.5, top=False)
	mpm.addPoints(position=position, volume=volume, stress=(-2e3, -2e3, -8e3, 0, 0, 0))
	runFor(mpm, 0.2)
	stress, passed = mpm.field("stress"), mpm.time
	deviator, mean = stress[:, 0] - stress[:, 2], stress[:, :3].mean(axis=1)
	left = deviator / 6e3 / np.exp(-passed / 0.1) - 1
	print(
		f"after {passed:.3f} s deviator {deviator.mean():.1f} Pa, off exp(-t/T) by {abs(left).max():.1e} with {O.iter} steps; "
		f"mean off by {abs(mean / -4e3 - 1).max():.1e}"
	)
	assert abs(left).max() < 0.02 and abs(mean / -4e3 - 1).max() < 1e-12
	assert mpm.field("skeleton0.age") == pytest.approx(5 + passed, abs=1e-9)


@pytest.mark.parametrize("dimension", (2, 3))
def test_bingham_in_python_flows_as_the_law_of_the_core_does(dimension, laws):
	"""A block on a rough base that tips over and flows: the same path with both laws, to the round-off of a sum in another order."""
	paths = []
	for law in (
		wrapper.PythonSkeleton(law=laws.bingham, modulus=oedometer, states=["flowStrain"]),
		wrapper.BinghamSkeleton(young=young, poisson=poisson, yieldStress=800, viscosity=50),
	):
		O.reset()
		h, axes = 0.25, [np.arange(0.5625, 1.5, 0.125)] * (dimension - 1) + [np.arange(0.0625, 0.5, 0.125)]
		position = np.stack([axis.ravel() for axis in np.meshgrid(*axes, indexing="ij")], axis=1)
		mpm = wrapper.MpmEngine(
			gridSpacing=h,
			lower=(0,) * dimension,
			upper=(3.5,) + (2,) * (dimension - 2) + (1.5,),
			gravity=(4,) + (0,) * (dimension - 2) + (-9,),
			skeleton=law,
			boundaries=[wrapper.FixedBoundary(region="bottom")],
		)
		O.engines = [mpm]
		mpm.addPoints(position=position, volume=0.125**dimension)
		runFor(mpm, 0.25)
		paths.append((mpm.field("position") - position, mpm.field("skeleton0.flowStrain")))
	(path, flow), (pathOfCore, flowOfCore) = paths
	print(f"{dimension} dimensions: moved by {abs(path).max():.3f} m, flow strain {flow.max():.2f}; laws differ by {abs(path - pathOfCore).max():.1e} m (1e-9)")
	assert flow.max() > 0.3 and abs(path).max() > 0.05
	assert abs(path - pathOfCore).max() < 1e-9 and abs(flow - flowOfCore).max() < 1e-8


def test_a_law_sees_the_times_of_motion_and_of_the_calendar():
	seen = []
	law = wrapper.PythonSkeleton(law=lambda step: seen.append((step.timeStep, step.calendarTimeStep)), modulus=oedometer)
	mpm, position, volume = column(2, law, heat=wrapper.HeatTransfer(thermalTimeScale=5e4))
	mpm.addPoints(position=position, volume=volume)
	O.run(3, True)
	assert len(seen) == 3 and sum(motion for motion, _ in seen) == pytest.approx(mpm.time, rel=1e-12)
	assert all(calendar == pytest.approx(5e4 * motion, rel=1e-12) for motion, calendar in seen)


def pressed(dimension, law, **settings):
	mpm, position, volume = column(dimension, wrapper.PythonSkeleton(law=law, modulus=oedometer, states=["plasticStrain"]), height=1.0, **settings)
	mpm.gravity = (0,) * (dimension - 1) + (-300,)
	mpm.addPoints(position=position, volume=volume)
	return mpm


def everything(mpm):
	return {name: mpm.field(name) for name in ("position", "velocity", "stress", "skeleton0.plasticStrain")}


@pytest.mark.parametrize("dimension", (2, 3))
def test_a_law_in_python_goes_on_from_a_file_to_the_last_bit(dimension, laws, tmp_path):
	mpm = pressed(dimension, laws.misesPlasticity)
	O.run(30, True)
	O.save(str(tmp_path / "half.yade.gz"))
	O.run(30, True)
	through = everything(mpm)
	assert through["skeleton0.plasticStrain"].max() > 1e-4
	O.reset()
	O.load(str(tmp_path / "half.yade.gz"))
	assert O.engines[0].skeleton.law == "ownlaws:misesPlasticity"
	O.run(30, True)
	for name, value in everything(O.engines[0]).items():
		assert np.array_equal(value, through[name]), name


def test_a_function_that_no_import_gives_back_is_set_again_or_refused_by_a_sentence(laws, tmp_path, capfd):
	mpm = pressed(2, lambda step: laws.misesPlasticity(step))
	O.run(10, True)
	assert "cannot be imported again" in capfd.readouterr().err
	O.save(str(tmp_path / "half.yade"))
	O.run(10, True)
	through = everything(mpm)
	O.reset()
	O.load(str(tmp_path / "half.yade"))
	with pytest.raises(
		RuntimeError, match=r"^PythonSkeleton\.law was test_python_laws:.*<lambda> when the file was written, .*: set PythonSkeleton\.law again"
	):
		O.run(10, True)
	O.engines[0].skeleton.law = laws.misesPlasticity
	O.run(10, True)
	for name, value in everything(O.engines[0]).items():
		assert np.array_equal(value, through[name]), name


def test_a_checkpoint_finds_the_law_by_its_name(laws, tmp_path):
	mpm = pressed(2, laws.misesPlasticity)
	O.run(10, True)
	talik.checkpoint.write(tmp_path / "half.checkpoint")
	O.run(10, True)
	through = everything(mpm)
	talik.resume(tmp_path / "half.checkpoint")
	O.run(10, True)
	for name, value in everything(O.engines[0]).items():
		assert np.array_equal(value, through[name]), name


def test_a_module_that_is_not_there_any_more_is_named(laws, tmp_path, monkeypatch):
	pressed(2, laws.misesPlasticity)
	O.run(2, True)
	O.save(str(tmp_path / "half.yade"))
	O.reset()
	monkeypatch.delitem(sys.modules, "ownlaws")
	(tmp_path / "ownlaws.py").unlink()
	sys.path_importer_cache.clear()
	O.load(str(tmp_path / "half.yade"))
	with pytest.raises(RuntimeError, match=r"^PythonSkeleton\.law is 'ownlaws:misesPlasticity', which cannot be imported \(ModuleNotFoundError.*PYTHONPATH"):
		O.run(2, True)


def raises(step):
	raise ArithmeticError("no strength\nleft")


def nanFor3(step):
	step.stress[step.id == 3, 1] = np.nan


def badState(step):
	step.state = step.state[:, :0]


def exchanges(step):
	O.engines[0].exchangeSkeletons([wrapper.ElasticSkeleton()], np.zeros(O.engines[0].pointCount))


def stepsAgain(step):
	O.engines[0]()


@pytest.mark.parametrize(
	"law, sentence",
	{
		raises: r"raises raised ArithmeticError in .*test_python_laws.py, line \d+: no strength left",
		nanFor3: "nanFor3 gave point 3 a stress that is not finite",
		(lambda step: step.stress[:, :3]): r"<lambda> gave a stress of shape \(16, 3\), not \(16, 4\)",
		(lambda step: 1.0): r"<lambda> gave a stress of shape \(\), not \(16, 4\)",
		(lambda step: "stiff"): "<lambda> gave a stress of type str, not an array of numbers",
		(lambda step: 1j * step.stress): "<lambda> gave a stress of type ndarray, not an array of numbers",
		badState: r"badState gave a state of shape \(16, 0\), not \(16, 1\)",
		(lambda: None): "<lambda> raised TypeError: .*takes 0 positional arguments",
		(lambda step: sys.exit(3)): "<lambda> raised SystemExit in .*: 3",
		exchanges: r"exchanges raised RuntimeError .*MpmEngine\.exchangeSkeletons: a law cannot be exchanged while it works",
		stepsAgain: "stepsAgain raised RuntimeError .*cannot step it again",
	}.items(),
	ids=lambda value: getattr(value, "__name__", "sentence"),
)
def test_a_law_that_fails_ends_the_run_by_a_sentence_that_names_it(law, sentence):
	mpm = pressed(2, law)
	with pytest.raises(
		RuntimeError, match=rf"^PythonSkeleton\.law test_python_laws:.*{sentence}.*; the step has ended half way: go on from a checkpoint"
	) as refusal:
		O.run(3, True)
	assert "\n" not in str(refusal.value)
	assert np.isfinite(mpm.field("stress")).all()  # the ground can still be looked at
	with pytest.raises(RuntimeError, match="half"):
		O.run(1, True)


@pytest.mark.parametrize(
	"settings, sentence",
	[
		(dict(law=None), "PythonSkeleton.law is None: give a function"),
		(dict(law=5), "PythonSkeleton.law is 5, which cannot be called"),
		(dict(law="elastic"), "PythonSkeleton.law is 'elastic': give a function, or its name as 'module:name'"),
		(dict(law="sys:nothing"), r"PythonSkeleton.law is 'sys:nothing', which cannot be imported \(AttributeError"),
		(dict(modulus=0), "PythonSkeleton.modulus is 0: give the largest modulus"),
		(dict(modulus=float("nan")), "PythonSkeleton.modulus is nan: give the largest modulus"),
		(dict(states=["a", "a"]), "PythonSkeleton.states has 'a' twice"),
		(dict(states=["a"], statesAtStart=[1, 2]), "PythonSkeleton.statesAtStart has 2 values for 1 states"),
		(dict(states=["a"], statesAtStart=[float("inf")]), "PythonSkeleton.statesAtStart is inf"),
	],
)
def test_what_a_law_in_python_cannot_be_is_refused_before_the_first_step(settings, sentence):
	mpm, position, volume = column(2, wrapper.PythonSkeleton(**{"law": raises, "modulus": oedometer, **settings}))
	mpm.addPoints(position=position, volume=volume)
	with pytest.raises(ValueError, match=sentence):
		mpm.initialise()


def test_arrays_of_a_law_are_contiguous_and_its_stress_turns_with_the_ground():
	"""A square that turns: the law is shown the stress turned by the angle. Without stress it flies apart at a tenth of its spin."""
	seen = []

	def look(step):
		assert all(array.flags["C_CONTIGUOUS"] for array in (step.gradient, step.strain, step.stress, step.state, step.iceSaturation, step.volume))
		assert step.gradient.shape == (len(step.id), 2, 2) and step.temperature is None and not step.iceSaturation.any()
		inside = np.isin(step.id, inner)
		seen.append((step.stress[inside].mean(axis=0), abs(step.strain[inside]).max(), abs(step.gradient[inside]).max()))

	mpm = wrapper.MpmEngine(gridSpacing=0.25, lower=(-1.5, -1.5), upper=(1.5, 1.5), picTime=np.inf, skeleton=wrapper.PythonSkeleton(law=look, modulus=1e4))
	position, volume = talik.geometry.fillPolygon(talik.geometry.rectangle(-1, -1, 1, 1), 0.25)
	inner = np.flatnonzero((abs(position) < 0.5).all(axis=1))
	mpm.addPoints(position=position, volume=volume, velocity=0.1 * position[:, ::-1] * (-1, 1), stress=(-1e-3, 0, 0, 0))
	O.engines = [mpm]
	while mpm.time < 1:
		O.step()
	angle = 0.1 * mpm.time
	expected = 1e-3 * np.array([-np.cos(angle) ** 2, -np.sin(angle) ** 2, 0, -np.cos(angle) * np.sin(angle)])
	error = abs(seen[-1][0] - expected).max() / 1e-3
	print(f"turned by {angle:.4f}: stress off by {error:.1e}; strain of a step {seen[-1][1]:.1e} of a gradient of {seen[-1][2]:.1e}")
	assert error < 0.01 and seen[-1][1] < 0.12 * seen[-1][2]
