# SPDX-License-Identifier: GPL-2.0-or-later
"""Wrong settings: each is answered by one exception that names what was set, its value and what would be right; the interpreter lives
on, and the next correct run works."""

import re

import numpy as np
import pytest
from yade import Matrix3, O, utils, wrapper

import talik
from talik import rve

nan, inf = float("nan"), float("inf")
remedy = re.compile(
	r"\b(give|move them|move it|turn|choose|must|has "
	r"to|add|leave|remove|use|put|enlarge|make|lower|set|fill|load|reduce|runs it|did you mean|there "
	r"(is|are)|call|needs|take|finite)\b",
	re.I,
)
table = []


def servoInSpace(goal):
	with talik.scratchScene():
		O.periodic = True
		O.cell.hSize = Matrix3(0.1, 0, 0, 0, 0.1, 0, 0, 0, 0.1)
		O.bodies.append([utils.sphere((0.03, 0.03, 0.03), 0.02), utils.sphere((0.07, 0.07, 0.07), 0.02)])
		talik.packing.servoStress(None, goal)


def ground(points=None, stepped=True, **settings):
	"""A square of ground with the settings in question, made to take a step."""
	mpm = wrapper.MpmEngine(**{"gridSpacing": 0.25, "lower": (0, 0), "upper": (1, 1), "skeleton": wrapper.ElasticSkeleton(), **settings})
	position, volume = talik.geometry.fillPolygon(talik.geometry.rectangle(0, 0, 1, 1), 0.25)
	mpm.addPoints(**{"position": position, "volume": volume, "temperature": -1.0, **(points or {})})
	O.engines = [mpm]
	if stepped:
		O.step()
	return mpm


def warm(**settings):
	return ground(**{"heat": wrapper.HeatTransfer(), "motion": False, **settings})


def drawing(**ofSegregation):
	return ground(heat=wrapper.HeatTransfer(), freezing=wrapper.FreezingCurve(), water=wrapper.PoreWater(), segregation=wrapper.IceSegregation(**ofSegregation))


def side(boundary, **settings):
	return warm(boundaries=[boundary], **settings)


def sampled(sample=None, **ofSkeleton):
	return ground(skeleton=wrapper.RveSkeleton(**{"samples": [sample] if sample else [], **ofSkeleton}))


def spheres(*centres, periodic=True, size=0.1):
	"""A YADE scene of equal grains, as somebody's script would leave it."""
	with talik.scratchScene():
		if periodic:
			O.periodic = True
			O.cell.hSize = Matrix3(size, 0, 0, 0, size, 0, 0, 0, 0.1)
		for centre in centres:
			O.bodies.append(utils.sphere(centre, 0.01))
			O.bodies[len(O.bodies) - 1].state.blockedDOFs = "zXY"
		O.engines = [
			wrapper.ForceResetter(),
			wrapper.InsertionSortCollider([wrapper.Bo1_Sphere_Aabb()]),
			wrapper.InteractionLoop(
				[wrapper.Ig2_Sphere_Sphere_ScGeom()], [wrapper.Ip2_FrictMat_FrictMat_FrictPhys()], [wrapper.Law2_ScGeom_FrictPhys_CundallStrack()]
			),
			wrapper.NewtonIntegrator(),
		]
		O.dt = 1e-6
		return O._sceneObj


def meeting(body, **ofContact):
	mpm = ground(stepped=False, upper=(1, 2), bodies=wrapper.BodyContact(**ofContact))
	O.bodies.append(body)
	O.engines = [wrapper.ForceResetter(), mpm, wrapper.NewtonIntegrator()]
	O.step()


def running(change):
	mpm = warm(boundaries=[wrapper.SurfaceTemperature(region="surface", temperature=1)], upper=(1, 2))
	change(mpm)


def timed(dt):
	mpm = ground(stepped=False, automaticTimeStep=False)
	O.dt = dt
	O.step()
	return mpm


def changed(name, value):
	mpm = ground()
	setattr(mpm, name, value)
	O.step()


def asked(function):
	function(ground())


# what is wrong: (what is done, name in the sentence, value in the sentence)
wrong = {
	# types
	"text for a number": (lambda s: wrapper.MpmEngine(gridSpacing="small"), "MpmEngine.gridSpacing", "'small'"),
	"text for a number, assigned": (lambda s: setattr(wrapper.MpmEngine(), "damping", "much"), "MpmEngine.damping", "'much'"),
	"fraction for a whole number": (lambda s: wrapper.MpmEngine(dimension=2.5), "MpmEngine.dimension", "2.5"),
	"number for a text": (lambda s: wrapper.MpmEngine(shapeFunction=2), "MpmEngine.shapeFunction", "2"),
	"number for an object": (lambda s: wrapper.MpmEngine(heat=1), "MpmEngine.heat", "1"),
	"wrong object": (lambda s: wrapper.MpmEngine(heat=wrapper.FreezingCurve()), "MpmEngine.heat", "FreezingCurve"),
	"object for a list": (lambda s: wrapper.MpmEngine(boundaries=wrapper.FixedBoundary()), "MpmEngine.boundaries", "FixedBoundary"),
	"list of wrong objects": (lambda s: wrapper.MpmEngine(boundaries=[wrapper.HeatTransfer()]), "MpmEngine.boundaries", "HeatTransfer"),
	"None in a list": (lambda s: wrapper.MpmEngine(skeletons=[None]), "MpmEngine.skeletons", "None"),
	"number for a vector": (lambda s: wrapper.MpmEngine(gravity=-9.81), "MpmEngine.gravity", "-9.81"),
	"four numbers for a vector": (lambda s: wrapper.MpmEngine(gravity=(0, 0, -9.81, 0)), "MpmEngine.gravity", "(0, 0, -9.81, 0)"),
	"three numbers in the plane": (lambda s: ground(gravity=(0, -9.81, 0)), "MpmEngine.gravity", "(0, -9.81, 0)"),
	"three numbers for a corner in the plane": (lambda s: side(wrapper.WallTemperature(region="box", lower=(0, 0, 0))), "WallTemperature.lower", "(0, 0, 0)"),
	"a side that the plane has not": (lambda s: side(wrapper.WallTemperature(region="front")), "WallTemperature.region", "'front'"),
	"text in a table": (lambda s: wrapper.WallTemperature(times=["now"]), "WallTemperature.times", "'now'"),
	"sample outside a list": (lambda s: wrapper.RveSkeleton(samples=s), "RveSkeleton.samples", "RveSample"),
	"None for a number": (lambda s: wrapper.IceBondMat(iceYoung=None), "IceBondMat.iceYoung", "None"),
	# names
	"misspelt keyword": (lambda s: wrapper.MpmEngine(gridSpacin=0.2), "MpmEngine", "gridSpacin"),
	"misspelt attribute": (lambda s: setattr(wrapper.MpmEngine(), "dampin", 0.2), "MpmEngine", "dampin"),
	"misspelt attribute of an effect": (lambda s: wrapper.FreezingCurve(widht=1), "FreezingCurve", "widht"),
	"misspelt point value": (lambda s: ground(points={"porsity": 0.3}), "MpmEngine.addPoints", "porsity"),
	"unknown shape function": (lambda s: ground(shapeFunction="cubic"), "shapeFunction", "cubic"),
	"unknown region": (lambda s: ground(boundaries=[wrapper.FixedBoundary(region="ceiling")]), "FixedBoundary.region", "ceiling"),
	"region forgotten": (lambda s: ground(boundaries=[wrapper.FixedBoundary()]), "FixedBoundary.region", "''"),
	"unknown curve": (lambda s: warm(freezing=wrapper.FreezingCurve(curve="step")), "FreezingCurve.curve", "step"),
	"unknown mean": (lambda s: warm(material=wrapper.GroundMaterial(conductivityMean="median")), "GroundMaterial.conductivityMean", "median"),
	"unknown mass coefficient": (lambda s: ground(water=wrapper.PoreWater(massCoefficient="x")), "PoreWater.massCoefficient", "x"),
	"unknown field": (lambda s: asked(lambda mpm: mpm.field("temprature")), "field", "temprature"),
	"unknown form of samples": (lambda s: sampled(s, form="closed"), "RveSkeleton.form", "closed"),
	"unknown answer to blow-ups": (lambda s: sampled(s, onBlowUp="ignore"), "RveSkeleton.onBlowUp", "ignore"),
	"base class of boundaries": (lambda s: ground(boundaries=[wrapper.GroundBoundary(region="left")]), "GroundBoundary", "base class"),
	# signs, ranges, NaN, infinities
	"negative spacing": (lambda s: ground(gridSpacing=-0.25), "MpmEngine.gridSpacing", "-0.25"),
	"infinite spacing": (lambda s: ground(gridSpacing=inf), "gridSpacing", "inf"),
	"infinite gravity": (lambda s: ground(gravity=(0, -inf)), "MpmEngine.gravity", "-inf"),
	"damping of one": (lambda s: ground(damping=1), "MpmEngine.damping", "1"),
	"PIC time below zero": (lambda s: ground(picTime=-1), "MpmEngine.picTime", "-1"),
	"unknown thing to share out": (lambda s: ground(distribute="grains"), "MpmEngine.distribute", "grains"),
	"wave fraction above one": (lambda s: ground(courantNumber=1.5), "MpmEngine.courantNumber", "1.5"),
	"heat fraction of zero": (lambda s: warm(heatFraction=0), "MpmEngine.heatFraction", "0"),
	"pores more than full": (lambda s: warm(poreFill=1.2), "poreFill", "1.2"),
	"box upside down": (lambda s: ground(lower=(0, 1), upper=(1, 0)), "upper.y", "0"),
	"infinite box": (lambda s: ground(upper=(inf, 1)), "upper.x", "inf"),
	"grid too small for its points": (lambda s: ground(upper=(0.5, 0.5)), "position", "0.5625"),
	"grid of too many cells": (lambda s: ground(gridSpacing=1e-8), "gridSpacing", "1e-08"),
	"negative volume": (lambda s: ground(points={"volume": -0.01}), "volume", "-0.01"),
	"volume not a number": (lambda s: ground(points={"volume": nan}), "volume", "nan"),
	"no pores": (lambda s: warm(points={"porosity": 0}), "porosity", "0"),
	"temperature not a number": (lambda s: warm(points={"temperature": nan}), "temperature", "nan"),
	"velocity infinite": (lambda s: ground(points={"velocity": (inf, 0)}), "velocity", "inf"),
	"stress not a number": (lambda s: ground(points={"stress": (1, nan, 0, 0)}), "stress", "nan"),
	"stress not a number in its first component": (lambda s: ground(points={"stress": (nan, -1e4, -5e3, 0)}), "addPoints: stress", "nan"),
	"two water levels on one surface": (
		lambda s: ground(water=wrapper.PoreWater(), upper=(1, 2), boundaries=[wrapper.DrainedBoundary(region="surface", pressure=p) for p in (0, 2e4)]),
		"DrainedBoundary",
		"boundaries[1]",
	),
	"load not a number": (
		lambda s: ground(upper=(1, 2), boundaries=[wrapper.SurfaceLoad(region="surface", pressure=nan)]),
		"SurfaceLoad.pressure",
		"not finite",
	),
	"stress of three components": (lambda s: ground(points={"stress": (1, 2, 0)}), "stress", "xx, yy, zz, xy"),
	"text for positions": (lambda s: ground(points={"position": [["a", "b"]]}), "addPoints", "'a'"),
	"values for fewer points": (lambda s: ground(points={"porosity": [0.3, 0.4]}), "porosity", "2 numbers"),
	"points added to a running ground": (lambda s: asked(lambda mpm: mpm.addPoints(position=[[0.5, 0.5]], volume=0.01)), "addPoints", "has started"),
	"skeleton that is not there": (lambda s: ground(points={"skeleton": 1}), "skeleton", "1"),
	"density of zero": (lambda s: warm(material=wrapper.GroundMaterial(solidDensity=0)), "GroundMaterial.solidDensity", "0"),
	"latent heat not a number": (lambda s: warm(material=wrapper.GroundMaterial(latentHeat=nan)), "GroundMaterial.latentHeat", "nan"),
	"heat backwards in time": (lambda s: warm(heat=wrapper.HeatTransfer(thermalTimeScale=-1)), "thermalTimeScale", "-1"),
	"infinite source of heat": (lambda s: warm(heat=wrapper.HeatTransfer(source=inf)), "source", "inf"),
	"residual saturation above one": (lambda s: warm(freezing=wrapper.FreezingCurve(residualSaturation=1.1)), "FreezingCurve.residualSaturation", "1.1"),
	"negative impedance": (lambda s: ground(water=wrapper.PoreWater(impedance=-1)), "PoreWater.impedance", "-1"),
	"segregation potential in mm^2/(s K)": (lambda s: drawing(segregationPotential=1e-3), "IceSegregation.segregationPotential", "1 mm^2/(s K)"),
	"negative segregation potential": (lambda s: drawing(segregationPotential=-1e-9), "IceSegregation.segregationPotential", "-1e-09"),
	"decay of the segregation potential in 1/MPa": (lambda s: drawing(segregationPotential=1e-9, pressureDecay=5), "IceSegregation.pressureDecay", "1/MPa"),
	"decay without a segregation potential": (lambda s: drawing(pressureDecay=5e-6), "IceSegregation.pressureDecay", "not given"),
	"segregation without water": (
		lambda s: warm(motion=True, freezing=wrapper.FreezingCurve(), segregation=wrapper.IceSegregation()),
		"segregation",
		"without water",
	),
	"segregation without freezing": (
		lambda s: warm(motion=True, water=wrapper.PoreWater(), segregation=wrapper.IceSegregation()),
		"segregation",
		"without freezing",
	),
	"cavitation under pressure": (lambda s: ground(water=wrapper.PoreWater(cavitationPressure=1e5)), "PoreWater.cavitationPressure", "100000"),
	"negative conductivity": (lambda s: ground(water=wrapper.PoreWater(conductivity=-1e-4)), "PoreWater.conductivity", "-0.0001"),
	"stiffness not a number": (lambda s: ground(skeleton=wrapper.ElasticSkeleton(young=nan)), "ElasticSkeleton.young", "nan"),
	"friction of 90 degrees": (lambda s: ground(skeleton=wrapper.MohrCoulombSkeleton(frictionAngle=90)), "frictionAngle", "90"),
	"dilation above friction": (lambda s: ground(skeleton=wrapper.MohrCoulombSkeleton(dilationAngle=40)), "dilationAngle", "40"),
	"wall hotter than the model": (lambda s: side(wrapper.WallTemperature(region="left", temperature=500)), "WallTemperature.temperature", "500"),
	"flux not a number": (lambda s: side(wrapper.HeatFlux(region="left", flux=nan)), "HeatFlux.flux", "not finite"),
	"heat flux inside the ground": (lambda s: side(wrapper.HeatFlux(region="box", flux=5)), "HeatFlux.region", "HeatSource"),
	"source on a side": (lambda s: side(wrapper.HeatSource(region="left", power=5)), "HeatSource.region", "side left"),
	"source without room": (lambda s: side(wrapper.HeatSource(region="box", lower=(0.5, 0), upper=(0.5, 1), power=5)), "HeatSource.region", "room"),
	"power not a number": (lambda s: side(wrapper.HeatSource(region="box", power=nan)), "HeatSource.power", "not finite"),
	"table of unequal lengths": (lambda s: side(wrapper.WallTemperature(region="left", times=[0, 1], values=[5])), "WallTemperature", "1"),
	"table backwards": (lambda s: side(wrapper.WallTemperature(region="left", times=[1, 0], values=[5, 6])), "WallTemperature.times", "0"),
	"heat on ground without temperature": (lambda s: ground(boundaries=[wrapper.WallTemperature(region="left")]), "WallTemperature", "no heat"),
	"two walls in one place": (
		lambda s: ground(boundaries=[wrapper.FixedBoundary(region="left"), wrapper.RollerBoundary(region="left")]),
		"RollerBoundary",
		"boundaries[1]",
	),
	"moving surface": (lambda s: ground(boundaries=[wrapper.MovingBoundary(region="surface")]), "MovingBoundary.region", "free surface"),
	"moving box without direction": (
		lambda s: ground(boundaries=[wrapper.MovingBoundary(region="box", lower=(0, 0), upper=(0.2, 1), speed=1)]),
		"MovingBoundary.direction",
		"0",
	),
	"smooth wall along itself": (
		lambda s: ground(boundaries=[wrapper.MovingBoundary(region="left", speed=1, direction=(0, 1), rough=False)]),
		"MovingBoundary.rough",
		"False",
	),
	"moving wall far ahead": (lambda s: ground(boundaries=[wrapper.MovingBoundary(region="left", ahead=0.2)]), "MovingBoundary.ahead", "0.2"),
	"speed not a number": (lambda s: ground(boundaries=[wrapper.MovingBoundary(region="left", speed=nan)]), "MovingBoundary.speed", "not finite"),
	"moving wall that lets water pass": (
		lambda s: ground(water=wrapper.PoreWater(), boundaries=[wrapper.MovingBoundary(region="left"), wrapper.DrainedBoundary(region="left")]),
		"MovingBoundary",
		"DrainedBoundary",
	),
	"wall that leaves its nodes": (
		lambda s: (ground(boundaries=[wrapper.MovingBoundary(region="left", speed=1), wrapper.FixedBoundary(region="right")]), O.run(1000, True)),
		"MovingBoundary",
		"gridSpacing",
	),
	"surface without ground": (
		lambda s: side(wrapper.SurfaceTemperature(region="surface", lower=(0.2, 5), upper=(0.4, 6))),
		"SurfaceTemperature",
		"no ground there",
	),
	"ice without heat": (lambda s: ground(freezing=wrapper.FreezingCurve()), "MpmEngine.freezing", "heat is None"),
	"water in rigid ground": (lambda s: warm(water=wrapper.PoreWater()), "MpmEngine.water", "motion is False"),
	"no skeleton": (lambda s: ground(skeleton=None), "MpmEngine.skeleton", "None"),
	"no points": (lambda s: (setattr(O, "engines", [wrapper.MpmEngine(gridSpacing=1)]), O.step()), "MpmEngine", "no material points"),
	# time
	"time step of zero": (lambda s: timed(0), "O.dt", "0"),
	"time step not a number": (lambda s: timed(nan), "O.dt", "nan"),
	"time step of a year": (lambda s: timed(3e7), "O.dt", "30000000"),
	"damping not a number in mid-run": (lambda s: changed("damping", nan), "MpmEngine.damping", "nan"),
	"temperature of a star": (lambda s: warm().setTemperature(1e300), "setTemperature", "1e+300"),
	"temperature set to no number": (lambda s: warm().setTemperature(nan), "setTemperature", "nan"),
	"temperature where there is none": (lambda s: ground().setTemperature(1), "setTemperature", "no heat"),
	"temperature as a text": (lambda s: warm().setTemperature("warm"), "setTemperature", "warm"),
	# samples
	"no samples": (lambda s: sampled(), "RveSkeleton.samples", "empty"),
	"empty sample": (lambda s: sampled(wrapper.RveSample()), "RveSample", "empty"),
	"sample that is not there": (lambda s: sampled(s, sampleOf=[0] * 63 + [7]), "RveSkeleton.sampleOf", "7"),
	"samples for fewer points": (lambda s: sampled(s, sampleOf=[0, 0]), "RveSkeleton.sampleOf", "2 numbers"),
	"negative tolerance": (lambda s: sampled(s, strainTolerance=-1e-5), "RveSkeleton.strainTolerance", "-1"),
	"inertial number of zero": (lambda s: sampled(s, maxInertialNumber=0), "RveSkeleton.maxInertialNumber", "0"),
	"no DEM steps": (lambda s: sampled(s, minSteps=0), "RveSkeleton.minSteps", "0"),
	"negative friction of slip": (lambda s: sampled(s, slipFriction=-0.1), "RveSkeleton.slipFriction", "-0.1"),
	"negative cohesion of slip": (lambda s: sampled(s, slipFriction=0.3, slipCohesion=-5), "RveSkeleton.slipCohesion", "-5"),
	"negative threads": (lambda s: sampled(s, threads=-2), "RveSkeleton.threads", "-2"),
	"unknown measure": (lambda s: sampled(s).skeleton.values("bonds"), "RveSkeleton.values", "bonds"),
	"time step of a sample backwards": (lambda s: setattr(s, "dt", -1), "RveSample.dt", "-1"),
	"ice above one": (lambda s: s.freeze(2), "ice", "2"),
	"strain not a number": (lambda s: s.apply(Matrix3(nan, 0, 0, 0, 0, 0, 0, 0, 0), 0), "displacementGradient", "nan"),
	"pulled sample": (lambda s: s.servo(1e5, 1e5), "stressX", "100000"),
	"sample without cell": (lambda s: wrapper.RveSample.fromScene(spheres((0, 0, 0), periodic=False)), "periodic", "cell"),
	"sample without grains": (lambda s: wrapper.RveSample.fromScene(spheres()), "cannot be packed", "no bodies"),
	"current scene as a sample": (lambda s: sampled(scenes=[O._sceneObj]), "RveSkeleton.scenes", "current scene"),
	"too few grains": (lambda s: rve.prepare(grains=5), "grains", "5"),
	"radii in the wrong order": (lambda s: rve.prepare(radius=(7e-3, 3e-3)), "radius", "0.007"),
	"pressure of suction": (lambda s: rve.prepare(pressure=-1e5), "pressure", "-100000"),
	"impossible porosity": (lambda s: rve.prepare(porosity=0.6), "porosity", "0.6"),
	"thin sample": (lambda s: rve.prepare(thickness=0.001), "thickness", "0.001"),
	"stiffness of grains not a number": (lambda s: rve.prepare(young=nan), "young", "nan"),
	"ice saturation above one": (lambda s: setattr(wrapper.IceBondMat(), "iceSaturation", 1.5), "IceBondMat.iceSaturation", "1.5"),
	"two grains in one place": (lambda s: wrapper.RveSample.fromScene(spheres((0.02, 0.02, 0), (0.02, 0.02, 0))), "overlap", "2 of a radius"),
	# bodies
	"body inside the ground": (lambda s: meeting(utils.sphere((0.5, 1, 0), 0.2)), "O.bodies[0]", "m inside it"),
	"body that the ground cannot meet": (
		lambda s: meeting(utils.box((0.5, 1.5, 0), (0.1, 0.1, 0.1), orientation=utils.Quaternion((1, 0, 0), 0.3))),
		"O.bodies[0]",
		"about z only",
	),
	"slice without thickness": (lambda s: meeting(utils.sphere((0.5, 1.5, 0), 0.2), thickness=0), "BodyContact.thickness", "0"),
	"thickness of a slice lost in mid-run": (
		lambda s: (meeting(utils.sphere((0.5, 1.5, 0), 0.2)), setattr(O.engines[1].bodies, "thickness", nan), O.step()),
		"BodyContact.thickness",
		"nan",
	),
	# too late, too large, in vain
	"calendar of ground that cannot move": (lambda s: warm(heat=wrapper.HeatTransfer(followsMotion=True)), "followsMotion", "true"),
	"calendar that runs backwards in motion": (lambda s: ground(heat=wrapper.HeatTransfer(followsMotion=True, movingTimeScale=-1)), "movingTimeScale", "-1"),
	"calendar faster in motion than at rest": (lambda s: ground(heat=wrapper.HeatTransfer(followsMotion=True, movingTimeScale=2)), "movingTimeScale", "2"),
	"tolerance of the calendar of nothing": (lambda s: ground(heat=wrapper.HeatTransfer(followsMotion=True, motionTolerance=0)), "motionTolerance", "0"),
	"tolerance of the calendar faster than any slide": (
		lambda s: ground(heat=wrapper.HeatTransfer(followsMotion=True, motionTolerance=50)),
		"motionTolerance",
		"50",
	),
	"stop on no day": (lambda s: ground(stopAtDay=nan), "stopAtDay", "nan"),
	"heat produced from mid-run on": (lambda s: running(lambda mpm: setattr(mpm.heat, "source", 5)), "HeatTransfer.source", "5"),
	"air warmed in mid-run without a table": (
		lambda s: running(lambda mpm: setattr(mpm.boundaries[0], "temperature", 9)),
		"SurfaceTemperature.temperature",
		"9",
	),
	"effect exchanged in mid-run": (lambda s: running(lambda mpm: setattr(mpm, "heat", wrapper.HeatTransfer())), "MpmEngine.heat", "HeatTransfer"),
	"whole number that is none of the machine's": (lambda s: wrapper.MpmEngine(dimension=10**30), "MpmEngine.dimension", "1" + 30 * "0"),
	"freezing curve narrower than numbers": (lambda s: warm(freezing=wrapper.FreezingCurve(width=1e-300)), "FreezingCurve.width", "1e-300"),
	"water slowed to nothing": (lambda s: ground(water=wrapper.PoreWater(hydraulicTimeScale=1e-300)), "PoreWater.hydraulicTimeScale", "1e-300"),
	"times of a wall that does not change": (
		lambda s: ground(boundaries=[wrapper.FixedBoundary(region="left", times=[0, 1])]),
		"FixedBoundary.times",
		"2 numbers",
	),
	"one ground twice in a scene": (lambda s: (setattr(O, "engines", [ground(stepped=False)] * 2), O.step()), "O.engines", "more than once"),
	"table of days that run backwards": (
		lambda s: side(wrapper.SurfaceTemperature(region="surface", days=[10, 0], values=[-5, 10])),
		"SurfaceTemperature.days/values",
		"day 10",
	),
	"run until an instant in quotes": (lambda s: talik.runUntil("3"), "instant", "'3'"),
	"run until no day": (lambda s: talik.runUntilDay(ground(), nan), "day", "nan"),
	"check of what is no ground": (lambda s: talik.check(3), "talik.check", "3"),
	"friction of no sample": (lambda s: talik.studies.calibrate.thawedFriction([]), "samples", "empty"),
	# geometry and files
	"stress in space of three components": (lambda s: servoInSpace((-1e5, -1e5, -1e5)), "servoStress: goal", "6 components (xx, yy, zz, yz, xz, xy)"),
	"outline of two corners": (lambda s: talik.geometry.fillPolygon([(0, 0), (1, 1)], 0.1), "polygon", "2"),
	"outline not a number": (lambda s: talik.geometry.fillPolygon([(0, 0), (1, 0), (nan, 1)], 0.1), "polygon", "not finite"),
	"three points per cell": (lambda s: talik.geometry.fillPolygon([(0, 0), (1, 0), (0, 1)], 0.1, 3), "pointsPerCell", "3"),
	"outline without spacing": (lambda s: talik.geometry.fillPolygon([(0, 0), (1, 0), (0, 1)], 0), "gridSpacing", "0"),
	"missing sample file": (lambda s: rve.load("/nowhere/sample.yade.gz"), "/nowhere/sample.yade.gz", "does not exist"),
	"sample file that is none": (lambda s: rve.load(__file__), "test_bad_input.py", "not a YADE scene"),
	"missing checkpoint": (lambda s: talik.resume("/nowhere/x"), "/nowhere/x", "does not exist"),
	"checkpoint where none can be": (lambda s: talik.checkpoint.write("/proc/none/x"), "Checkpoint.file", "/proc/none/x"),
	"folder that cannot be": (lambda s: talik.files.writableFolder("/proc/none"), "/proc/none", "cannot be written"),
}


@pytest.fixture
def sample(smallSample):
	return smallSample.copy()


@pytest.mark.parametrize("case", wrong)
def test_is_answered_by_name_value_and_remedy(case, sample):
	do, name, value = wrong[case]
	with pytest.raises(Exception) as raised:
		do(sample)
	error = raised.value
	text = " ".join(str(error).split())
	table.append((case, type(error).__name__, text))
	print(f"{type(error).__name__}: {text}")
	assert isinstance(error, (ValueError, TypeError, AttributeError, RuntimeError, OSError))
	assert name in text, f"does not name {name}"
	assert value in text, f"does not name the value {value}"
	assert remedy.search(text), "names no remedy"
	O.reset()
	mpm = ground(gravity=(0, -10))
	assert mpm.time == O.time > 0 and np.isfinite(mpm.field("velocity")).all()


def test_at_least_sixty_wrong_settings_are_in_the_table():
	width = max(len(case) for case, *_ in table)
	for case, kind, text in table:
		print(f"{case:{width}}  {kind:14} {text[:150]}")
	print(f"{len(table)} of {len(wrong)} wrong settings answered by one exception each")
	assert len(table) == len(wrong) >= 60
