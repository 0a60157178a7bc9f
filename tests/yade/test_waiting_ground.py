# SPDX-License-Identifier: GPL-2.0-or-later
"""Looking at a ground does not fix it: what is set before the first step takes effect, whatever was read before."""

import numpy as np
import pytest
from yade import Matrix3, O, wrapper

import talik
from talik import rve


@pytest.fixture(scope="module")
def packed(sampleCache):
	return rve.pack(rve.prepare(grains=30, porosity=0.19, cache=sampleCache))


def column(**settings):
	"""Ground of eight points between walls, with water and heat."""
	O.reset()
	defaults = dict(
		gridSpacing=0.5,
		lower=(0, 0),
		upper=(0.5, 1.5),
		gravity=(0, -9.81),
		material=wrapper.GroundMaterial(),
		heat=wrapper.HeatTransfer(thermalTimeScale=1e5),
		freezing=wrapper.FreezingCurve(),
		water=wrapper.PoreWater(),
		skeleton=wrapper.MohrCoulombSkeleton(),
		boundaries=[wrapper.RollerBoundary(region=side) for side in ("left", "right", "bottom")]
		+ [wrapper.SurfaceTemperature(region="surface", temperature=3)],
	)
	mpm = wrapper.MpmEngine(**{**defaults, **settings})
	talik.geometry.fill(mpm, talik.geometry.rectangle(0, 0, 0.5, 1), pointsPerCell=4, temperature=-1.0)
	O.engines = [mpm]
	return mpm


def after(mpm, steps=20):
	talik._talik.runSerially(steps)
	return {name: mpm.field(name) for name in ("position", "stress", "temperature" if mpm.heat else "velocity")}


def largestDifference(one, other):
	return max(np.abs(one[name] - other[name]).max() if name in other else np.inf for name in one)


changes = {
	"heat.volumetric conduction": lambda mpm: setattr(mpm.heat, "thermalTimeScale", 3e5),
	"heat gone": lambda mpm: mpm.updateAttrs(dict(heat=None, freezing=None, boundaries=mpm.boundaries[:3])),
	"freezing gone": lambda mpm: setattr(mpm, "freezing", None),
	"freezing curve": lambda mpm: setattr(mpm.freezing, "residualSaturation", 0.3),
	"water gone": lambda mpm: setattr(mpm, "water", None),
	"water": lambda mpm: setattr(mpm.water, "conductivity", 1e-9),
	"material": lambda mpm: setattr(mpm.material, "solidDensity", 2000),
	"law": lambda mpm: setattr(mpm.skeleton, "young", 3e6),
	"another law": lambda mpm: setattr(mpm, "skeleton", wrapper.ElasticSkeleton(young=5e6)),
	"fewer boundaries": lambda mpm: setattr(mpm, "boundaries", mpm.boundaries[1:]),
	"table of a boundary": lambda mpm: mpm.boundaries[3].updateAttrs(dict(temperature=10)),
	"larger box": lambda mpm: setattr(mpm, "upper", (1, 2)),
	"box changed in place": lambda mpm: mpm.upper.__setitem__(0, 1),
	"gravity": lambda mpm: setattr(mpm, "gravity", (0, -5)),
	"shape functions": lambda mpm: setattr(mpm, "shapeFunction", "gimp"),
	"transfer": lambda mpm: setattr(mpm, "transfer", "apic"),
	"pore fill": lambda mpm: mpm.updateAttrs(dict(water=None, poreFill=0.9)),
	"cell averages": lambda mpm: setattr(mpm, "bBar", False),
	"more points": lambda mpm: mpm.addPoints(position=[(0.25, 1.1)], volume=0.02, temperature=-1.0),
}


@pytest.mark.parametrize("change", changes)
def test_a_setting_changed_after_a_field_was_read_acts_as_if_nothing_had_been_read(change):
	looked = column()
	for name in ("stress", "position", "temperature"):
		looked.field(name)
	looked.balance()
	looked.stableTimeStep()
	changes[change](looked)
	seen = after(looked)
	unread = column()
	changes[change](unread)
	expected = after(unread)
	same = after(column())
	comparable = set(seen) == set(same) and seen["position"].shape == same["position"].shape
	effect = largestDifference(seen, same) if comparable else np.inf
	print(f"{change}: differs from the scene that was not looked at by {largestDifference(seen, expected):.1e}, from the one not changed by {effect:.1e}")
	assert largestDifference(seen, expected) == 0 and effect > 0


def layered(packed, **skeleton):
	loose = packed.copy()
	loose.servo(-10e3, -20e3)
	O.reset()
	mpm = wrapper.MpmEngine(
		gridSpacing=0.5, lower=(0, 0), upper=(0.5, 1.5), gravity=(0, -9.81), skeleton=wrapper.RveSkeleton(samples=[packed.copy(), loose], **skeleton)
	)
	talik.geometry.fill(mpm, talik.geometry.rectangle(0, 0, 0.5, 1))
	mpm.boundaries = [wrapper.RollerBoundary(region=side) for side in ("left", "right", "bottom")]
	O.engines = [mpm]
	return mpm


def test_samples_given_to_points_after_a_field_was_read_are_the_ones_that_the_points_have(packed):
	mpm = layered(packed, sampleOf=[0] * 8)
	read = mpm.field("stress")[:, 1]
	mpm.skeleton.sampleOf = [1] * 8
	given = mpm.field("stress")[:, 1]
	print(f"vertical stress {read.mean():.0f} Pa with sample 0, {given.mean():.0f} Pa with sample 1 of -20 kPa")
	assert np.allclose(given, -20e3, rtol=0.01) and np.allclose(read, -100e3, rtol=0.01)


def test_a_sample_that_is_strained_or_brought_to_another_stress_after_a_field_was_read_counts_as_it_is_then(packed):
	mpm = layered(packed, sampleOf=[0] * 8)
	mpm.field("stress")
	mpm.skeleton.samples[0].servo(-30e3, -50e3)
	stress = mpm.field("stress")[:, 1]
	print(f"{stress.mean():.0f} Pa where the sample was brought to -50 kPa")
	assert np.allclose(stress, -50e3, rtol=0.01)


def test_a_scene_of_ones_own_that_is_changed_after_a_field_was_read_counts_as_it_is_then(packed):
	O.reset()
	scene = packed.open()
	mpm = wrapper.MpmEngine(gridSpacing=0.5, lower=(0, 0), upper=(0.5, 0.5), skeleton=wrapper.RveSkeleton(scenes=[scene]))
	mpm.addPoints(position=[(0.25, 0.25)], volume=[0.25])
	first = mpm.field("stress")[0]
	same = mpm.skeleton.sample(0).stateBytes
	mpm.field("stress")
	assert mpm.skeleton.sample(0).stateBytes == same
	with talik.inspect(scene):
		O.cell.velGrad = Matrix3(-0.05, 0, 0, 0, -0.1, 0, 0, 0, 0)
		talik.packing.advance(500)
		O.cell.velGrad = Matrix3.Zero
		talik.packing.advance(1)
	changed = mpm.field("stress")[0]
	print(f"vertical stress {first[1]:.0f} Pa, {changed[1]:.0f} Pa after the scene was compressed")
	assert changed[1] < first[1] - 1e3


def test_an_engine_that_is_not_in_O_yet_follows_its_settings_too(packed):
	mpm = layered(packed, sampleOf=[0] * 8)
	O.engines = []
	mpm.field("stress")
	mpm.skeleton.sampleOf = [1] * 8
	assert np.allclose(mpm.field("stress")[:, 1], -20e3, rtol=0.01)


def test_histories_of_watched_points_begin_with_the_ground_that_runs():
	mpm = column(freezing=None)
	mpm.watch([0])
	mpm.field("stress")
	mpm.freezing = wrapper.FreezingCurve()
	after(mpm, 3)
	history = mpm.history(0)
	print(f"times {history['time']}, ice saturation {history['iceSaturation']}")
	assert len(history["time"]) == 4 and (np.diff(history["time"]) > 0).all()


@pytest.mark.parametrize("by", ("a step", "setTemperature", "setDay", "replaceSample"))
def test_what_comes_after_the_first_step_or_a_change_by_hand_is_refused_and_set_back(packed, by):
	mpm = layered(packed, sampleOf=[0] * 8) if by == "replaceSample" else column()
	mpm.field("stress")
	if by == "a step":
		after(mpm, 1)
	elif by == "setTemperature":
		mpm.setTemperature(-3)
	elif by == "setDay":
		mpm.setDay(30)
	else:
		mpm.skeleton.replaceSample(0, mpm.skeleton.samples[1])
	part, name, value = (mpm.skeleton, "sampleOf", [1] * 8) if by == "replaceSample" else (mpm.heat, "followsMotion", True)
	before = getattr(part, name)
	with pytest.raises(ValueError, match=f"{name} .* too late") as refusal:
		setattr(part, name, value)
	print(refusal.value)
	with pytest.raises(ValueError, match=f"{name} .* too late"):
		part.updateAttrs({name: value})
	assert getattr(part, name) == before
	with pytest.raises(RuntimeError, match="before the first step"):
		mpm.addPoints(position=[(0.25, 0.25)], volume=0.1)


def test_a_day_set_before_the_first_step_is_saved_with_the_scene(tmp_path):
	mpm = column()
	mpm.setDay(30)
	O.save(str(tmp_path / "scene.yade.gz"))
	O.reset()
	O.load(str(tmp_path / "scene.yade.gz"))
	print(f"day {O.engines[0].calendar['day']:.1f} after loading, 30 was set")
	assert O.engines[0].calendar["day"] == 30


def test_a_setting_that_is_refused_leaves_a_ground_that_can_be_mended():
	mpm = column()
	mpm.field("stress")
	mpm.heat = None
	with pytest.raises(ValueError, match="heat"):
		mpm.field("stress")
	mpm.heat = wrapper.HeatTransfer()
	assert len(mpm.field("stress")) == 8


def test_a_change_that_is_too_late_is_refused_with_a_remedy_that_the_object_has():
	mpm = column()
	after(mpm, 1)
	with pytest.raises(ValueError, match=r"HeatTransfer.source .* too late: .* is a boundary, HeatSource\(region='box', days=") as ofSource:
		mpm.heat.source = 3
	with pytest.raises(ValueError, match="SurfaceTemperature.temperature .* too late: .* by times, or days, and values") as ofTable:
		mpm.boundaries[3].temperature = 8
	with pytest.raises(ValueError, match="solidDensity .* begin anew[.]$") as ofDensity:
		mpm.material.solidDensity = 2000
	print(ofSource.value, ofTable.value, ofDensity.value, sep="\n")
