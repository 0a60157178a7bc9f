# SPDX-License-Identifier: GPL-2.0-or-later
"""Effects are objects that a scene has or has not: what is absent leaves no field, no time-step limit and no trace; what cannot
be is refused by one exception that names attribute, value and remedy, and the interpreter lives on."""

import numpy as np
import pytest
from yade import O, wrapper

import talik

square = talik.geometry.rectangle(0, 0, 1, 1)

pointsAlone = {"position", "volume"}
ofMotion = {"velocity", "displacement", "mass", "stress", "initialVolume", "gradient", "addedStress", "deformationGradient"}
ofContent = {"solidMass", "waterMass", "porosity"}
ofHeat = {"enthalpy", "temperature", "heatCapacity", "conductivity"}
ofFreezing = {"iceMass", "iceSaturation", "heatShare"}
ofOpenings = {"frozenSaturation", "thawStrainReleased", "thawStrainOpen", "volumeBefore", "widenedByIce", "dilationLately", "iceBefore"}
ofWater = {"liquidVelocity", "pressure", "liquidFraction", "drag"}
nodesOfMotion = {"massMomentumForce", "solvedVelocity"}
nodesOfHeat = {"heatCapacitySum", "nodalTemperature", "nodalHeat"}
nodesOfWater = {"liquidMassMomentumDrag", "liquidForce", "solvedLiquidVelocity", "seepageFlux", "nodalPressure", "seepageExchange"}

heat = {"motion": False, "heat": lambda: HeatTransfer()}
freezing = {**heat, "freezing": lambda: FreezingCurve()}
motion = {"skeleton": lambda: ElasticSkeleton()}
water = {**motion, "water": lambda: PoreWater()}
everything = {**water, "heat": lambda: HeatTransfer(), "freezing": lambda: FreezingCurve()}

scenes = {
	"heat only": (heat, pointsAlone | ofContent | ofHeat, nodesOfHeat, {"heat"}),
	"heat and freezing": (freezing, pointsAlone | ofContent | ofHeat | ofFreezing, nodesOfHeat, {"heat"}),
	"motion only": (motion, pointsAlone | ofMotion, nodesOfMotion, {"wave", "velocity"}),
	"motion and water": (water, pointsAlone | ofMotion | ofContent | ofWater, nodesOfMotion | nodesOfWater, {"wave", "velocity"}),
	"motion and water of implicit pressure": (
		{**motion, "bBar": True, "water": lambda: PoreWater(pressure="implicit")},
		pointsAlone | ofMotion | ofContent | ofWater | {"seepageVelocity", "groundAcceleration"},
		nodesOfMotion | nodesOfWater,
		{"wave", "velocity"},
	),
	"motion with affine transfer": ({**motion, "transfer": "apic"}, pointsAlone | ofMotion | {"affineVelocity"}, nodesOfMotion, {"wave", "velocity"}),
	"everything": (
		everything,
		pointsAlone | ofMotion | ofContent | ofHeat | ofFreezing | ofWater | ofOpenings,
		nodesOfMotion | nodesOfHeat | nodesOfWater,
		{"wave", "velocity", "heat", "heat advection"},
	),
}


def engine(points=True, pointValues=(), **settings):
	"""A square of ground; settings are made by calling them where they are functions."""
	made = {name: value() if callable(value) else value for name, value in settings.items()}
	mpm = MpmEngine(**{"gridSpacing": 0.25, "lower": (0, 0), "upper": (1, 1), **made})
	if points:
		positions, volumes = talik.geometry.fillPolygon(square, 0.25)
		mpm.addPoints(**{"position": positions, "volume": volumes, "temperature": -1.0, **dict(pointValues)})
	O.engines = [mpm]
	return mpm


@pytest.mark.parametrize("scene", scenes)
def test_a_scene_has_exactly_the_fields_and_limits_of_its_effects(scene):
	settings, onPoints, onNodes, limits = scenes[scene]
	mpm = engine(**settings)
	for _ in range(3):
		O.step()
	fields = mpm.fields()
	bytesOf = {place: sum(field["bytes"] for field in fields if field["place"] == place) for place in ("points", "nodes")}
	print(f"points {', '.join(sorted(onPoints))}; nodes {', '.join(sorted(onNodes))}")
	print(f"{bytesOf['points'] / mpm.pointCount:.0f} bytes a point, {bytesOf['nodes']} bytes of nodes, time step limited by {', '.join(sorted(limits))}")
	assert {field["name"] for field in fields if field["place"] == "points"} == onPoints
	assert {field["name"] for field in fields if field["place"] == "nodes"} == onNodes
	assert {field["place"] for field in fields} == {"points", "nodes"}
	assert set(mpm.timeStepLimits()) - {"governing"} == limits
	for name in mpm.fieldNames():
		assert np.isfinite(mpm.field(name)).all(), name


def test_absent_effects_do_not_limit_the_time_step():
	steps = {name: engine(**scenes[name][0]).stableTimeStep() for name in scenes}
	for name, step in steps.items():
		print(f"{name}: {step:.3g} s")
	assert steps["heat only"] > 1e6 * steps["motion only"]  # no wave in rigid ground
	assert steps["motion only"] > steps["motion and water"]  # no stiff water in dry ground
	scaled = engine(**{**motion, "heat": lambda: HeatTransfer(thermalTimeScale=1e12)}).stableTimeStep()
	assert scaled < 1e-3 * steps["motion only"]


def test_layers_with_skeletons_of_their_own_give_way_each_by_its_own_stiffness():
	"""Three layers under one load, side walls on rollers: strain of each is load over its oedometer modulus (nu = 0: Young's)."""
	load, moduli = 1e4, (1e7, 4e7, 2e7)
	mpm = engine(
		points=False,
		gridSpacing=0.125,
		lower=(0, 0),
		upper=(0.125, 3.5),
		damping=0.5,
		skeletons=[
			ElasticSkeleton(young=moduli[0], poisson=0),
			ElasticSkeleton(young=moduli[1], poisson=0),
			MohrCoulombSkeleton(
				young=moduli[2], youngFrozen=moduli[2], poisson=0, cohesion=1e6, cohesionFrozen=1e6, tensileStrength=1e6, tensileStrengthFrozen=1e6
			),
		],
		boundaries=[*(RollerBoundary(region=side) for side in ("left", "right", "bottom")), SurfaceLoad(region="surface", times=[0, 0.1], values=[0, load])],
	)
	positions, volumes = talik.geometry.fillPolygon(talik.geometry.rectangle(0, 0, 0.125, 3), 0.125)
	mpm.addPoints(position=positions, volume=volumes, skeleton=positions[:, 1].astype(int))
	while mpm.time < 1:
		O.step()
	strain = 1 - mpm.field("deformationGradient")[:, 3]
	for layer, modulus in enumerate(moduli):
		inside = np.abs(positions[:, 1] - layer - 0.5) < 0.25  # half a layer, without what shares nodes with the next
		error = strain[inside].mean() * modulus / load - 1
		print(f"layer {layer}, {type(mpm.skeletons[layer]).__name__}, M = {modulus:.0e} Pa: strain {strain[inside].mean():.4e}, off load over M by {error:.1e}")
		assert abs(error) < 0.01
	assert {name for name in mpm.cost() if "Skeleton" in name} == {"ElasticSkeleton[0]", "ElasticSkeleton[1]", "MohrCoulombSkeleton[2]"}


def test_porosity_pore_fill_temperature_and_pressure_may_be_functions_of_place():
	given = {
		"porosity": lambda x, y: 0.3 + 0.1 * x,
		"temperature": lambda x, y: 1 + 4 * y,
		"pressure": lambda x, y: 9810 * (1 - y),
		"poreFill": lambda x, y: 0.2 + 0.5 * x,
	}
	saturated = {name: given[name] for name in ("porosity", "temperature", "pressure")}
	mpm = engine(points=False, **everything)
	talik.geometry.fill(mpm, square, **saturated)
	x, y = mpm.field("position").T
	for name, function in saturated.items():
		error = np.abs(mpm.field(name) - function(x, y)).max() / np.abs(function(x, y)).max()
		print(f"{name}: differs from the function by {error:.1e} of its largest value")
		assert error < (1e-12 if name != "pressure" else 1e-9)
	mpm = engine(points=False, **heat)
	talik.geometry.fill(mpm, square, **{name: given[name] for name in ("porosity", "temperature", "poreFill")})
	x, y = mpm.field("position").T
	water = given["poreFill"](x, y) * given["porosity"](x, y) * mpm.field("volume") * 1000
	print(f"water mass: differs from n S V rho_l by {np.abs(mpm.field('waterMass') / water - 1).max():.1e}")
	np.testing.assert_allclose(mpm.field("waterMass"), water, rtol=1e-12)
	before = mpm.field("waterMass")
	mpm.setTemperature(given["temperature"](x, y))
	np.testing.assert_allclose(mpm.field("waterMass"), before, rtol=1e-12)


# ---- refusals -------------------------------------------------------------------------------------------------------------

nan = float("nan")
refused = {
	"freezing without heat": (dict(**motion, freezing=lambda: FreezingCurve()), "MpmEngine.freezing", "heat=HeatTransfer()"),
	"water without motion": (dict(motion=False, water=lambda: PoreWater()), "MpmEngine.water", "motion=True"),
	"motion without skeleton": (dict(), "MpmEngine.skeleton", "skeleton=ElasticSkeleton()"),
	"no effect at all": (dict(motion=False), "no effect", "at least one"),
	"wall temperature without heat": (
		dict(**motion, boundaries=lambda: [WallTemperature(region="left", temperature=10)]),
		"WallTemperature on side left",
		"add it or leave",
	),
	"drainage without water": (dict(**motion, boundaries=lambda: [DrainedBoundary(region="surface")]), "DrainedBoundary", "add it or leave"),
	"fed with water without water": (dict(**motion, boundaries=lambda: [WaterFlux(region="left", flux=1e-6)]), "WaterFlux on side left", "add it or leave"),
	"pressure and flux of water on one side": (
		dict(**water, boundaries=lambda: [DrainedBoundary(region="left"), WaterFlux(region="left", flux=1e-6)]),
		"WaterFlux",
		"remove it",
	),
	"flux into an impermeable side": (
		dict(**water, boundaries=lambda: [ImpermeableBoundary(region="left"), WaterFlux(region="left", flux=1e-6)]),
		"WaterFlux",
		"remove it",
	),
	"warm rain without heat": (
		dict(**water, boundaries=lambda: [WaterFlux(region="left", flux=1e-6, temperature=8)]),
		"WaterFlux.temperature is set",
		"add heat",
	),
	"ice that flows": (dict(**everything, boundaries=lambda: [WaterFlux(region="left", temperature=-8)]), "WaterFlux.temperature = -8", "leave it out"),
	"unknown transfer": (dict(**motion, transfer="pic"), "MpmEngine.transfer = 'pic'", "choose one of flip, apic, tpic"),
	"transfer in rigid ground": (dict(**heat, transfer="apic"), "MpmEngine.transfer is 'apic'", "leave it out"),
	"negative PIC time": (dict(**motion, picTime=-0.5), "MpmEngine.picTime is -0.5", "0 or more"),
	"negative PIC time of water": (dict(**motion, water=lambda: PoreWater(picTime=-1)), "PoreWater.picTime = -1", "must not be negative"),
	"unknown shape function": (dict(**motion, shapeFunction="cubic"), "MpmEngine.shapeFunction = 'cubic'", "choose one of quadraticBSpline, gimp"),
	"overfull pores": (dict(**heat, pointValues=[("poreFill", 1.2)]), "poreFill = 1.2", "must lie in [0, 1]"),
	"points without water beside flowing water": (dict(**water, pointValues=[("poreFill", 0)]), "poreFill = 0", "must lie in [0.01, 1] with water"),
	"roller without motion": (dict(**heat, boundaries=lambda: [RollerBoundary(region="left")]), "RollerBoundary", "add it or leave"),
	"no points": (dict(**motion, points=False), "no material points", "talik.geometry.fill"),
	"spacing not a number": (dict(**motion, gridSpacing=nan), "MpmEngine.gridSpacing is nan", "positive spacing in m"),
	"negative spacing": (dict(**motion, gridSpacing=-0.25), "MpmEngine.gridSpacing is -0.25", "positive spacing in m"),
	"tiny spacing": (dict(**motion, gridSpacing=1e-7), "gridSpacing = 1e-07", "larger spacing"),
	"box not of whole cells": (dict(**motion, upper=(1.1, 1)), "MpmEngine.upper.x = 1.1", "whole number"),
	"points outside the grid": (dict(**motion, pointValues=[("position", [[2, 0.5]]), ("volume", 0.01)]), "position[0] = 2", "enlarge the box"),
	"position not a number": (dict(**motion, pointValues=[("position", [[nan, 0.5]]), ("volume", 0.01)]), "position[0] = nan", "move the point"),
	"negative volume": (dict(**motion, pointValues=[("volume", -1)]), "volume = -1", "must be positive"),
	"porosity above one": (dict(**motion, pointValues=[("porosity", 1.5)]), "porosity = 1.5", "must lie in"),
	"boiling ground": (dict(**heat, pointValues=[("temperature", 500)]), "temperature = 500", "must lie between"),
	"values for other points": (dict(**heat, pointValues=[("temperature", [1, 2, 3])]), "temperature has 3 numbers", "give 1 or 64"),
	"misspelt point value": (dict(**heat, pointValues=[("temprature", 1)]), "temprature", "choose among position, volume, porosity, temperature"),
	"missing skeleton": (dict(**motion, pointValues=[("skeleton", 3)]), "skeleton = 3", "0 to 0"),
	"unknown region": (dict(**motion, boundaries=lambda: [FixedBoundary(region="lefft")]), "FixedBoundary.region is 'lefft'", "choose left, right"),
	"a wall on a periodic side": (
		dict(**motion, boundaries=lambda: [PeriodicBoundary(region="left"), RollerBoundary(region="right")]),
		"RollerBoundary on side right beside PeriodicBoundary",
		"remove one of them",
	),
	"two conditions on one side": (
		dict(**motion, boundaries=lambda: [FixedBoundary(region="left"), RollerBoundary(region="left")]),
		"RollerBoundary",
		"remove it",
	),
	"table out of order": (
		dict(**heat, boundaries=lambda: [WallTemperature(region="left", times=[1, 0], values=[1, 2])]),
		"WallTemperature.times",
		"must increase",
	),
	"table in days and in seconds": (
		dict(**heat, boundaries=lambda: [WallTemperature(region="left", times=[0, 1], days=[0, 1], values=[1, 2])]),
		"WallTemperature.times has 2 numbers, .days 2",
		"give one of the two",
	),
	"days that do not increase": (
		dict(**heat, boundaries=lambda: [WallTemperature(region="left", days=[1, 0], values=[1, 2])]),
		"WallTemperature.days/values",
		"must increase",
	),
	"days of a boundary that does not change": (dict(**motion, boundaries=lambda: [RollerBoundary(region="left", days=[0, 1])]), ".days 2", "leave them out"),
	"scale without sense": (
		dict(**motion, heat=lambda: HeatTransfer(followsMotion=True, motionTolerance=5)),
		"HeatTransfer.motionTolerance = 5",
		"must lie between",
	),
	"unknown curve": (dict(**heat, freezing=lambda: FreezingCurve(curve="gaus")), "FreezingCurve.curve = 'gaus'", "choose one of"),
	"negative width": (dict(**heat, freezing=lambda: FreezingCurve(width=-1)), "FreezingCurve.width = -1", "must be positive"),
	"negative width of linear": (dict(**heat, freezing=lambda: FreezingCurve(curve="linear", width=-1)), "FreezingCurve.width = -1", "must be positive"),
	"parameter of another curve": (
		dict(**heat, freezing=lambda: FreezingCurve(curve="gauss", airEntryPressure=1e4)),
		"FreezingCurve.airEntryPressure = 10000",
		"leave it out",
	),
	"bad lambda": (dict(**heat, freezing=lambda: FreezingCurve(curve="vanGenuchten", exponent=2)), "FreezingCurve.exponent = 2", "must lie in (0, 1)"),
	"time backwards for heat": (dict(motion=False, heat=lambda: HeatTransfer(thermalTimeScale=-1)), "HeatTransfer.thermalTimeScale = -1", "must be positive"),
	"impermeable water": (dict(**motion, water=lambda: PoreWater(conductivity=0)), "PoreWater.conductivity = 0", "must be positive, in m/s"),
	"negative bulk modulus": (dict(**motion, water=lambda: PoreWater(bulkModulus=-1)), "PoreWater.bulkModulus = -1", "must be positive, in Pa"),
	"ice heavier than water": (dict(**heat, material=lambda: GroundMaterial(iceDensity=1100)), "GroundMaterial.iceDensity = 1100", "must not exceed"),
	"negative stiffness": (dict(skeleton=lambda: ElasticSkeleton(young=-1)), "ElasticSkeleton.young = -1", "must be positive, in Pa"),
	"incompressible skeleton": (dict(skeleton=lambda: ElasticSkeleton(poisson=0.5)), "ElasticSkeleton.poisson = 0.5", "must lie in"),
	"softer when frozen": (
		dict(skeleton=lambda: MohrCoulombSkeleton(young=1e7, youngFrozen=1e6)),
		"MohrCoulombSkeleton.youngFrozen = 1000000",
		"must not be below",
	),
	"table of two lengths": (
		dict(skeleton=lambda: MohrCoulombSkeleton(iceSaturations=[0, 1], youngs=[1e7, 1e8], cohesions=[1e3], tensileStrengths=[0, 0])),
		"MohrCoulombSkeleton.cohesions length = 1",
		"must be that of",
	),
	"samples forgotten": (dict(skeleton=lambda: RveSkeleton()), "RveSkeleton.samples is empty", "talik.rve.pack"),
	"too much damping": (dict(**motion, damping=1.5), "MpmEngine.damping is 1.5", "from 0 to below 1"),
	"gravity not a number": (dict(**motion, gravity=(0, nan)), "MpmEngine.gravity is nan", "finite components"),
	"time step fraction above one": (dict(**motion, courantNumber=2), "MpmEngine.courantNumber is 2", "up to 1"),
}


@pytest.mark.parametrize("case", refused)
def test_is_refused_by_one_sentence_and_the_next_run_works(case):
	settings, what, remedy = refused[case]
	with pytest.raises(ValueError) as refusal:
		engine(**settings)
		O.step()
	print(refusal.value)
	assert what in str(refusal.value) and remedy in str(refusal.value)
	O.reset()
	mpm = engine(**motion, gravity=(0, -10))
	O.step()
	assert mpm.time == O.dt > 0


def test_an_unknown_field_is_refused_by_a_sentence_with_the_fields_of_the_scene():
	mpm = engine(**heat)
	with pytest.raises(ValueError) as refusal:
		mpm.field("porePressure")
	print(refusal.value)
	assert "MpmEngine.field: there is no field 'porePressure' in this scene: choose one of position, volume" in str(refusal.value)


def test_a_table_in_days_is_that_in_seconds_to_the_last_bit():
	states = []
	for instants in (dict(days=[0, 2, 5]), dict(times=[0, 2 * talik.day, 5 * talik.day])):
		O.reset()
		mpm = engine(**{**heat, "boundaries": [WallTemperature(region="left", values=[0, 10, -3], **instants)]})
		talik.runUntilDay(mpm, 4)
		states.append(mpm.field("temperature"))
	print(f"after 4 days {states[0].min():.3f} to {states[0].max():.3f} degC")
	assert np.array_equal(*states) and np.ptp(states[0]) > 1


def test_a_bad_value_given_to_a_running_ground_is_refused_before_the_step():
	mpm = engine(**motion, gravity=(0, -10))
	O.step()
	for name, bad, good in (("damping", 5, 0.1), ("picTime", -1, 0.9), ("courantNumber", 0, 0.3), ("gravity", (0, nan), (0, -9))):
		before = mpm.time, mpm.field("velocity")
		setattr(mpm, name, bad)
		with pytest.raises(ValueError) as refusal:
			O.step()
		print(refusal.value)
		assert f"MpmEngine.{name} is" in str(refusal.value)
		assert mpm.time == before[0] and np.array_equal(mpm.field("velocity"), before[1])
		setattr(mpm, name, good)
		O.step()
		assert mpm.time > before[0]


def test_attributes_of_a_freezing_curve_mean_what_they_say():
	theta = 0.8
	expected = {
		("gauss", "width", 0.5): np.exp(-((theta / 0.5) ** 2)),
		("exponential", "width", 0.5): np.exp(-theta / 0.5),
		("power", "width", 0.7): (1 + theta / 0.7) ** -5,
		("power", "exponent", 3): (1 + theta / 1.0) ** -3,
		("linear", "width", 1.6): 1 - theta / 1.6,
		("vanGenuchten", "exponent", 0.5): None,
		("vanGenuchten", "airEntryPressure", 2e5): None,
	}
	for (curve, attribute, value), fraction in expected.items():
		O.reset()
		mpm = engine(**{**heat, "freezing": FreezingCurve(curve=curve, residualSaturation=0.1, **{attribute: value})}, pointValues=[("temperature", -theta)])
		mpm.initialise()
		liquid = 1 - mpm.field("iceSaturation")[0]
		if fraction is None:
			suction = -910 * 334e3 * np.log((273.15 - theta) / 273.15)
			lamb, entry = (value, 1e5) if attribute == "exponent" else (0.4, value)
			fraction = (1 + (suction / entry) ** (1 / (1 - lamb))) ** -lamb
		exact = 0.1 + 0.9 * fraction
		print(f"{curve}, {attribute} = {value:g}: S_l({-theta} degC) = {liquid:.6f}, closed form {exact:.6f}")
		assert liquid == pytest.approx(exact, rel=2e-3)


def test_a_table_of_measured_points_is_the_freezing_curve():
	temperatures, saturations = [-4, -1.5, -0.5, -0.1, 0.5], [0.08, 0.15, 0.4, 1, 1]
	for temperature in (-9.0, -2.0, -0.9, -0.3, -0.05):
		O.reset()
		table = FreezingCurve(curve="table", temperatures=temperatures, liquidSaturations=saturations)
		mpm = engine(**{**heat, "freezing": table}, pointValues=[("temperature", temperature)])
		mpm.initialise()
		liquid, exact = 1 - mpm.field("iceSaturation")[0], np.interp(temperature, temperatures, saturations)
		print(f"S_l({temperature} degC) = {liquid:.6f}, interpolated {exact:.6f}")
		assert liquid == pytest.approx(exact, rel=2e-3)


@pytest.mark.parametrize(
	"attributes, sentence",
	(
		(dict(), "FreezingCurve.temperatures: number of points = 0: must be 2 or more"),
		(
			dict(temperatures=[-1, 0], liquidSaturations=[1]),
			"FreezingCurve.temperatures has 2 values and FreezingCurve.liquidSaturations 1: give as many of each",
		),
		(dict(temperatures=[0, -1], liquidSaturations=[0.1, 1]), r"FreezingCurve.temperatures\[1\] = -1: must exceed the one before"),
		(dict(temperatures=[-1, 0], liquidSaturations=[0.1, 0.9]), "FreezingCurve.liquidSaturations: last value = 0.9: must be 1"),
		(dict(temperatures=[-1, 0], liquidSaturations=[0.1, 1], width=2), "FreezingCurve.width = 2: the points of the curve table say it; leave it out"),
		(
			dict(temperatures=[-1, 0], liquidSaturations=[0.1, 1], freezingTemperature=-1),
			"FreezingCurve.freezingTemperature = -1: the points of the curve table",
		),
		(dict(curve="gauss", temperatures=[-1, 0]), "FreezingCurve.curve = 'gauss': write curve='table', or leave them out"),
	),
)
def test_a_table_that_is_no_freezing_curve_is_refused_by_a_sentence(attributes, sentence):
	mpm = engine(**{**heat, "freezing": FreezingCurve(**{"curve": "table", **attributes})})
	with pytest.raises(ValueError, match=sentence) as refusal:
		mpm.initialise()
	print(refusal.value)


def test_an_error_in_the_background_thread_reaches_python():
	for attempt in ("O.run and O.wait", "O.run(wait=True)", "O.step"):
		O.reset()
		mpm = engine(**motion, pointValues=[("velocity", (100, 0))])
		with pytest.raises(RuntimeError) as failure:
			if attempt == "O.step":
				for _ in range(2000):
					O.step()
			elif attempt == "O.run and O.wait":
				O.run(2000)
				O.wait()
			else:
				O.run(2000, True)
		print(f"{attempt}: {failure.value}")
		assert "left the grid's box" in str(failure.value) and "enlarge the box" in str(failure.value)
		assert not O.running
	O.reset()
	mpm = engine(**motion)
	O.run(50, True)
	assert O.iter == 50 and mpm.time > 0


def test_a_refusal_in_the_background_thread_reaches_python():
	engine(**motion, gridSpacing=0.3)
	with pytest.raises(RuntimeError) as failure:
		O.run(10, True)
	print(failure.value)
	assert "upper.x" in str(failure.value) and not O.running


# ---- cost -----------------------------------------------------------------------------------------------------------------

costs = {
	"heat only": {"heat"},
	"heat and freezing": {"heat", "freezing"},
	"motion only": {"motion", "cell averages", "deformation record", "ElasticSkeleton[0]"},
	"motion and water": {"motion", "cell averages", "deformation record", "ElasticSkeleton[0]", "water"},
	"motion with affine transfer": {"motion", "cell averages", "deformation record", "ElasticSkeleton[0]", "transfer"},
	"everything": {
		"motion",
		"cell averages",
		"deformation record",
		"ElasticSkeleton[0]",
		"water",
		"heat",
		"freezing",
		"conduction and pore pressure",
		"thaw strain",
	},
}


@pytest.mark.parametrize("scene", costs)
def test_cost_names_exactly_the_effects_of_the_scene_and_adds_up_to_the_time_of_the_engine(scene):
	mpm = engine(points=False, **{**scenes[scene][0], "gridSpacing": 0.02})
	positions, volumes = talik.geometry.fillPolygon(square, 0.02)
	mpm.addPoints(position=positions, volume=volumes, temperature=np.linspace(-2, 2, len(volumes)))
	O.step()  # what happens once is not of the steps
	assert set(mpm.cost()) - {"sorting", "time step limits", "steps"} == costs[scene]
	parts = []
	for attempt in range(1, 6):  # what other programs do to the machine between two stamps is not the engine's
		before, O.timingEnabled, mpm.execTime = mpm.cost(), True, 0
		for _ in range(20):
			O.step()
		O.timingEnabled = False
		cost = mpm.cost()
		assert cost.pop("steps") == 1 + 20 * attempt and before.pop("steps") == 1 + 20 * (attempt - 1)
		spent = {name: cost[name] - before[name] for name in cost}
		parts.append(sum(spent.values()) / (1e-9 * mpm.execTime))
		if parts[-1] > 0.9:
			break
	print(
		f"{mpm.pointCount} points: "
		+ ", ".join(f"{name} {1e3 * value / 20:.3f}" for name, value in spent.items())
		+ f" ms a step; sum {parts[-1]:.1%} of the engine's time"
	)
	assert all(value >= 0 for value in spent.values())
	assert 0.9 < parts[-1] <= 1.0


def test_skemptons_b_is_that_of_the_softest_point_with_its_own_porosity():
	O.reset()
	mpm = wrapper.MpmEngine(
		gridSpacing=0.5,
		lower=(0, 0),
		upper=(1, 2),
		skeletons=[wrapper.ElasticSkeleton(young=1e9, poisson=0), wrapper.ElasticSkeleton(young=1e8, poisson=0)],
		water=wrapper.PoreWater(bulkModulus=2.2e9),
	)
	mpm.addPoints(position=[(0.25, 0.25), (0.75, 0.25)], volume=[0.25, 0.25], porosity=[0.2, 0.5], skeleton=[0, 1])
	O.engines = [mpm]
	expected = 1 / (1 + 1e8 * 0.5 / 2.2e9)
	print(f"Skempton's B {mpm.skemptonB():.6f}, 1/(1 + M n/K_w) of the softest point {expected:.6f}")
	assert mpm.skemptonB() == pytest.approx(expected, rel=1e-6)


def test_ground_about_an_axis_is_filled_with_the_mass_of_a_cylinder():
	"""Per radian; strain has the part around the axis, and what has no radius is refused by name."""
	mpm = MpmEngine(gridSpacing=0.1, axisymmetric=True, lower=(0, 0), upper=(0.6, 1), gravity=(0, -9.81), damping=0.5, skeleton=ElasticSkeleton(young=1e6))
	mpm.boundaries = [RollerBoundary(region="bottom")]
	talik.geometry.fill(mpm, talik.geometry.rectangle(0, 0, 0.5, 1), porosity=0.4)
	O.engines = [mpm]
	O.run(5, True)
	mass, exact = mpm.balance()["solidMass"], 0.5**2 / 2 * 1 * 0.6 * mpm.material.solidDensity
	strain, volume = mpm.field("strain"), mpm.field("volume")
	radial = np.log(mpm.field("position")[:, 0] / (mpm.field("position") - mpm.field("displacement"))[:, 0])
	print(f"mass of a radian {mass:.6g} kg (exact {exact:.6g}), volumes in the plane {volume.sum():.6g} m2 (exact 0.5)")
	assert abs(mass / exact - 1) < 1e-9 and abs(volume.sum() / 0.5 - 1) < 1e-3
	assert strain.shape == (len(volume), 6) and np.allclose(strain[:, 2], radial, atol=1e-12)
	mpm = MpmEngine(gridSpacing=0.1, axisymmetric=True, lower=(0, 0), upper=(1, 1), skeleton=ElasticSkeleton(), bodies=BodyContact())
	talik.geometry.fill(mpm, talik.geometry.rectangle(0, 0, 0.5, 0.5))
	with pytest.raises(ValueError, match="axisymmetric = true with bodies"):
		mpm.initialise()
