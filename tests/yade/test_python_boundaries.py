# SPDX-License-Identifier: GPL-2.0-or-later
"""Boundaries and effects written in Python: held against closed forms, with closed accounts; a wrong one refuses the step by one sentence."""

import sys

import numpy as np
import pytest
from yade import O, wrapper

import talik


def slab(boundaries, n, height=1.0):
	"""One cell wide, rigid, with a conductivity of 2 W/(m K) in all of it."""
	h = height / n
	mpm = wrapper.MpmEngine(
		gridSpacing=h,
		lower=(0, 0),
		upper=(h, height),
		motion=False,
		heat=wrapper.HeatTransfer(),
		material=wrapper.GroundMaterial(solidConductivity=2, liquidConductivity=2),
		boundaries=boundaries,
	)
	talik.geometry.fill(mpm, talik.geometry.rectangle(0, 0, h, height), temperature=0)
	O.engines = [mpm]
	return mpm


def runFor(mpm, seconds):
	begin = mpm.time
	while mpm.time < begin + seconds:
		O.run(20, True)


def heatOff(mpm, before):
	"""Of the account of heat, relative to what came in."""
	balance = mpm.balance()
	return abs(balance["enthalpy"] - before - balance["heatIn"]) / abs(balance["enthalpy"] - before)


def test_heat_that_grows_with_temperature_has_the_profile_of_its_closed_form():
	"""k T'' = a T between walls of 1 degC: cosh(m (y - 1/2))/cosh(m/2), m^2 = a/k."""
	sink, errors = 2 * 3.0**2, []
	for n in (6, 12):
		walls = [wrapper.WallTemperature(region=side, temperature=1) for side in ("bottom", "top")]
		mpm = slab([*walls, wrapper.PythonBoundary(region="box", function=lambda nodes: -sink * nodes.temperature)], n)
		before = mpm.balance()["enthalpy"]
		runFor(mpm, 5e5)
		y = mpm.field("position")[:, 1]
		errors.append(abs(mpm.field("temperature") - np.cosh(3 * (y - 0.5)) / np.cosh(1.5)).max())
		lost = heatOff(mpm, before)
		print(f"{n} cells: profile off by {errors[-1]:.1e} of 1 degC after {O.iter} steps, account of heat by {lost:.1e}")
		assert lost < 1e-9
	assert errors[1] < 0.02 and errors[0] / errors[1] > 2.5


def test_a_surface_that_answers_to_its_temperature_reaches_the_balance_of_its_flux_with_conduction():
	"""h (10 - T) = k T/L at the top of a slab that is 0 degC below. Nodes have the mean of the ground around them, which is off by the grid."""
	byHand, errors = 10 / (1 + 2 / 3), []
	for n in (4, 8):
		bottom = wrapper.WallTemperature(region="bottom", temperature=0)
		mpm = slab([bottom, wrapper.PythonBoundary(region="top", function=lambda nodes: 3 * (10 - nodes.temperature))], n)
		before = mpm.balance()["enthalpy"]
		runFor(mpm, 1.2e6)
		surface = np.polyfit(mpm.field("position")[:, 1], mpm.field("temperature"), 1)[0]
		errors.append(abs(surface / byHand - 1))
		print(f"{n} cells: surface at {surface:.3f} degC, by hand {byHand:.3f}; account of heat off by {heatOff(mpm, before):.1e}")
		assert heatOff(mpm, before) < 1e-9
	assert errors[1] < 0.04 and errors[0] / errors[1] > 2.5


@pytest.mark.parametrize(
	"region", [dict(region="top"), dict(region="disc", lower=(0.1, 0.4), upper=(0.2, 0.7)), dict(region="box", lower=(0, 0.2), upper=(1, 0.5))]
)
def test_a_temperature_that_python_gives_heats_as_that_of_a_table_does(region):
	"""But for round-off: the class of the table is held against closed forms elsewhere."""
	times, values, states = [0, 4e4], [1, 7], []
	table = wrapper.SurfaceTemperature if region["region"] == "top" else wrapper.WallTemperature
	python = wrapper.PythonBoundary(gives="temperature", function=lambda nodes: np.full(len(nodes.position), np.interp(nodes.time, times, values)), **region)
	for given in (table(times=times, values=values, **region), python):
		O.reset()
		mpm = slab([wrapper.WallTemperature(region="bottom", temperature=-1), given], 6)
		before = mpm.balance()["enthalpy"]
		runFor(mpm, 1e5)
		states.append((mpm.field("temperature"), mpm.balance()["heatIn"]))
		assert heatOff(mpm, before) < 1e-9
	print(f"{region['region']}: {states[0][1]:.4g} J from the table, {states[1][1]:.4g} J from Python; up to {states[0][0].max():.2f} degC")
	np.testing.assert_allclose(states[1][0], states[0][0], rtol=1e-11)
	assert states[0][0].max() > 1


def test_a_thermostat_holds_the_mean_temperature_of_its_ground():
	"""A pipe is as warm as it takes to keep the ground 3 degC on average, between walls of 0 degC."""
	walls = [wrapper.WallTemperature(region=side, temperature=0) for side in ("bottom", "top")]

	def thermostat(nodes):
		return np.full(len(nodes.position), np.clip(5 + 2 * (3 - mpm.field("temperature").mean()), -50, 50))

	mpm = slab([*walls, wrapper.PythonBoundary(region="box", lower=(0, 0.4), upper=(1, 0.6), gives="temperature", function=thermostat)], 10)
	runFor(mpm, 1e6)
	mean, pipe = mpm.field("temperature").mean(), mpm.field("temperature").max()
	byHand = 0.6 * pipe  # two triangles of 0.4 m and a plateau of 0.2 m
	print(f"mean {mean:.2f} degC with a pipe of {pipe:.2f} degC, by hand {byHand:.2f} degC; wanted 3 degC")
	assert mean == pytest.approx(3, abs=0.1) and mean == pytest.approx(byHand, rel=0.05)


def bar(boundaries, n, velocity=None, **settings):
	"""One cell high, along x from a roller, with Poisson's ratio 0, free at the other end."""
	h = 1 / n
	mpm = wrapper.MpmEngine(
		gridSpacing=h,
		lower=(0, 0),
		upper=(1 + 4 * h, h),
		energyLedger=True,
		skeleton=wrapper.ElasticSkeleton(young=1e7, poisson=0),
		boundaries=[wrapper.RollerBoundary(region=side) for side in ("left", "top", "bottom")] + boundaries,
		**settings,
	)
	positions, volumes = talik.geometry.fillPolygon(talik.geometry.rectangle(0, 0, 1, h), h)
	mpm.addPoints(position=positions, volume=volumes, **({} if velocity is None else {"velocity": velocity}))
	O.engines = [mpm]
	return mpm


def energyOff(mpm):
	"""Of the account of energy, relative to the work of the load."""
	b = mpm.balance()
	return (b["kineticEnergy"] + b["skeletonWork"] + b["dampingDissipation"] - b["loadWork"]) / b["loadWork"]


def test_a_bar_that_turns_has_the_tension_of_its_own_weight():
	"""Acceleration w^2 x: tension rho w^2 (L^2 - x^2)/2, and the work of the load is in the accounts."""
	n = 10
	mpm = bar([wrapper.PythonBoundary(region="box", gives="acceleration", function=lambda nodes: 9 * nodes.position * (1, 0))], n, damping=0.6)
	density = mpm.field("mass").sum() / mpm.field("volume").sum()
	x = mpm.field("position")[:, 0].copy()
	runFor(mpm, 0.25)
	excess = mpm.field("stress")[:, 0] - density * 9 * (1 - x**2) / 2
	error = abs(np.array([excess[(x * n).astype(int) == cell].mean() for cell in range(n)])).max() / (density * 9 / 2)
	print(f"tension of cells off by {error:.1e} of {density * 9 / 2:.0f} Pa; account of energy by {energyOff(mpm):.1e}")
	assert error < 0.02 and abs(energyOff(mpm)) < 0.01


def test_a_dashpot_at_its_end_takes_all_of_the_wave_in_a_bar():
	"""Traction -rho c v against a bar that moves along itself: after 2 L/c nothing is left of its energy. The load has done that work, but for what
	the grid takes from a wave, 10 % in that time with 30 cells, and half as much with twice as many."""
	taken, density = [], 1590
	impedance = np.sqrt(density * 1e7)

	def dashpot(nodes):
		return -impedance * nodes.velocity * (1, 0) * (nodes.normal[:, :1] > 0.5)

	for n in (16, 32):
		x, _ = talik.geometry.fillPolygon(talik.geometry.rectangle(0, 0, 1, 1 / n), 1 / n)
		velocity = np.stack([0.05 * np.cos(np.pi * x[:, 0] / 2), 0 * x[:, 0]], axis=1)
		mpm = bar([wrapper.PythonBoundary(region="surface", gives="traction", function=dashpot)], n, velocity, picTime=np.inf)
		assert mpm.field("mass").sum() == pytest.approx(density / n)
		before = mpm.balance()["kineticEnergy"]
		runFor(mpm, 3 / np.sqrt(1e7 / density))
		b = mpm.balance()
		left = (b["kineticEnergy"] + b["skeletonWork"]) / before
		taken.append(-b["loadWork"] / before)
		print(f"{n} cells: left of the energy {left:.1e}, taken by the dashpot {taken[-1]:.4f} of it")
		assert left < 1e-3
	assert 0.9 < taken[1] < 1 and (1 - taken[0]) / (1 - taken[1]) > 1.6


def stepped(function, gives="heat", region="box", **settings):
	mpm = wrapper.MpmEngine(gridSpacing=0.25, lower=(0, 0), upper=(1, 1.5), skeleton=wrapper.ElasticSkeleton(), heat=wrapper.HeatTransfer(), **settings)
	mpm.boundaries = [wrapper.FixedBoundary(region="bottom"), wrapper.PythonBoundary(region=region, gives=gives, function=function)]
	talik.geometry.fill(mpm, talik.geometry.rectangle(0, 0, 1, 1), temperature=2)
	O.engines = [mpm]
	return mpm


def everything(mpm):
	return {name: mpm.field(name) for name in ("position", "velocity", "stress", "temperature")} | {
		name: np.array(value) for name, value in mpm.balance().items()
	}


def same(first, second):
	return [name for name in first if not np.array_equal(first[name], second[name])] == []


def test_the_state_that_a_boundary_sees_is_that_of_nodes_that_have_ground():
	seen = {}

	def look(nodes):
		seen.update(vars(nodes))
		return np.zeros((len(nodes.position), 2))

	stepped(look, gives="traction", region="surface")
	O.run(3, True)
	assert set(seen) == {"position", "normal", "velocity", "temperature", "pressure", "time"} and seen["pressure"] is None
	assert seen["position"].shape == seen["normal"].shape == seen["velocity"].shape and seen["temperature"] == pytest.approx(2)
	assert np.linalg.norm(seen["normal"], axis=1) == pytest.approx(1)


@pytest.mark.parametrize(
	"function, sentence",
	{
		(lambda nodes: 1 / 0): "raised ZeroDivisionError in .*test_python_boundaries.py, line .*: division by zero",
		(lambda nodes: None): "gave a heat of type NoneType, not an array of numbers",
		(lambda nodes: nodes.position): r"gave a heat of shape \(\d+, 2\), not \(\d+,\)",
		(lambda nodes: np.nan * nodes.temperature): "gave a heat that is not finite",
	}.items(),
)
def test_a_boundary_that_fails_refuses_the_step_and_the_run_goes_on_without_a_trace_of_it(function, sentence):
	fails = []

	def warmer(nodes):
		return function(nodes) if fails else 50 * nodes.position[:, 0]

	mpm = stepped(warmer)
	O.run(10, True)
	fails.append(True)
	with pytest.raises(RuntimeError, match=rf"^PythonBoundary\.function test_python_boundaries:.*warmer {sentence}; this step was not made\.$"):
		O.run(3, True)
	fails.clear()
	O.run(10, True)
	afterwards = everything(mpm)
	O.reset()
	mpm = stepped(warmer)
	O.run(20, True)
	assert same(everything(mpm), afterwards)


def test_a_boundary_in_python_goes_on_from_a_file_to_the_last_bit(tmp_path, monkeypatch):
	(tmp_path / "ownwinds.py").write_text("def wind(nodes):\n\treturn 100 * nodes.normal * (0.1 - nodes.velocity)\n")
	monkeypatch.syspath_prepend(tmp_path)
	mpm = stepped("ownwinds:wind", gives="traction", region="surface", gravity=(0, -9.81))
	O.run(20, True)
	O.save(str(tmp_path / "half.yade.gz"))
	O.run(20, True)
	through = everything(mpm)
	O.reset()
	O.load(str(tmp_path / "half.yade.gz"))
	O.run(20, True)
	assert same(everything(O.engines[0]), through)
	sys.modules.pop("ownwinds")


@pytest.mark.parametrize(
	"settings, sentence",
	[
		(dict(function=None), "PythonBoundary.function is None: give a function"),
		(dict(gives="warmth"), "PythonBoundary.gives is 'warmth': choose heat, temperature, traction or acceleration"),
		(dict(gives="traction"), "PythonBoundary.region .*traction acts on a surface"),
		(dict(gives="acceleration", region="surface"), "PythonBoundary.region .*acceleration acts in a volume"),
		(dict(gives="temperature", lower=(0, 0.5), upper=(1, 0.5)), "PythonBoundary.region .*with room in it"),
		(dict(times=[0, 1], values=[0, 1]), "PythonBoundary.times has 2 numbers"),
		(dict(gives="acceleration", water=wrapper.PoreWater()), r"boundaries\[1\] = PythonBoundary accelerates grains and ice, and this ground has pore water"),
	],
)
def test_what_a_boundary_in_python_cannot_be_is_refused_before_the_first_step(settings, sentence):
	mpm = stepped(lambda nodes: nodes.temperature)
	mpm.water = settings.pop("water", None)
	mpm.boundaries = mpm.boundaries[:1] + [wrapper.PythonBoundary(**{"region": "box", "function": same, **settings})]
	with pytest.raises(ValueError, match=sentence):
		mpm.initialise()
