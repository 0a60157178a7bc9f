# SPDX-License-Identifier: GPL-2.0-or-later
"""Ground in named layers, each with its material, its law and its state at the start."""

import math

import numpy as np
import pytest
from fixtures import forty
from scipy.optimize import brentq
from yade import O, wrapper

import talik
from talik.geometry import rectangle

Material = wrapper.GroundMaterial


def ground(**settings):
	return wrapper.MpmEngine(
		**{
			**dict(
				gridSpacing=0.1,
				lower=(0, 0),
				upper=(0.1, 1.2),
				gravity=(0, -9.81),
				damping=0.3,
				skeleton=wrapper.MohrCoulombSkeleton(young=1e7, youngFrozen=1e8, cohesion=0, cohesionFrozen=2e5),
				heat=wrapper.HeatTransfer(thermalTimeScale=1e7),
				freezing=wrapper.FreezingCurve(),
				boundaries=[
					*(wrapper.RollerBoundary(region=side) for side in ("left", "right", "bottom")),
					wrapper.SurfaceTemperature(region="surface", temperature=5),
				],
			),
			**settings,
		}
	)


def iceRichColumn():
	return {
		"silt": dict(polygon=rectangle(0, 0.7, 0.1, 1), temperature=-1),
		"ice-rich": dict(polygon=rectangle(0, 0.4, 0.1, 0.7), temperature=-1, porosity=0.7, material=Material(thawStrain=0.45)),
		"clay": dict(polygon=rectangle(0, 0, 0.1, 0.4), temperature=-1, material=Material(solidConductivity=2)),
	}


def run(mpm, duration):
	O.reset()
	O.engines = [mpm]
	O.step()
	while O.time < duration:
		talik.runSerially(200)


def test_the_surface_of_a_column_without_thaw_front_goes_down_by_thaw_strain_times_height():
	"""By the path of its points, not by their volumes."""
	mpm = ground(thawFront=None)
	talik.layers.fill(
		mpm, {"ice-rich": dict(polygon=rectangle(0, 0, 0.1, 1), temperature=-1, porosity=0.6, material=Material(thawStrain=0.1))}, lateralRatio=0.5
	)
	surface = mpm.field("position")[:, 1] > 0.94
	run(mpm, 3.0)
	settled = -mpm.field("displacement")[surface, 1].mean()
	print(f"path of the surface {settled:.4f} m, by hand {0.1 * 0.975:.4f} m; loss of volume {1 - mpm.field('volume').sum() / 0.1:.4f} m")
	assert mpm.field("iceSaturation").max() == 0
	assert settled == pytest.approx(0.1 * 0.975, rel=0.05)


def test_only_the_ice_rich_layer_settles_and_by_its_thaw_strain():
	mpm = ground()
	layers = talik.layers.fill(mpm, iceRichColumn(), lateralRatio=0.5)
	assert [m.name for m in mpm.materials] == ["", "ice-rich", "clay"]
	run(mpm, 3.0)
	expected, settled = 0.3 * 0.45, 1 - mpm.field("volume").sum() / 0.1
	print(f"settlement {settled:.4f} m, by hand {expected:.4f} m")
	assert mpm.field("iceSaturation").max() == 0
	assert abs(settled / expected - 1) < 0.02
	assert (mpm.field("thawStrainReleased")[layers["ice-rich"]] == 0.45).all()
	assert (mpm.field("thawStrainReleased")[layers["clay"]] == 0).all()


def test_ice_rich_ground_settles_with_samples_too(sampleCache):
	sample = talik.rve.pack(talik.rve.prepare(**forty, cache=sampleCache))
	mpm = ground(skeleton=wrapper.RveSkeleton(samples=[sample]), heat=wrapper.HeatTransfer(thermalTimeScale=4e6))
	outline = rectangle(0, 0, 0.1, 1)
	talik.layers.fill(mpm, {"ice-rich": dict(polygon=outline, temperature=-1, porosity=0.6, material=Material(thawStrain=0.35))})
	talik.slope.settle(mpm, outline)
	topRow = mpm.field("position")[:, 1] > 0.9  # its mean height is 0.95 m
	run(mpm, 6.0)
	path, lost = -mpm.field("displacement")[topRow, 1].mean(), 1 - mpm.field("volume").sum() / 0.1
	print(
		f"ice-rich ground on samples: path of the top row {path:.4f} m, by hand {0.95 * 0.35:.4f} m; loss of volume {lost:.4f} m, by hand 0.35 m; "
		f"ice left {mpm.field('iceSaturation').max():.2g}"
	)
	assert path == pytest.approx(0.95 * 0.35, rel=0.08)
	assert lost == pytest.approx(0.35, rel=0.12)


def test_a_checkpoint_goes_on_to_the_same_bits(tmp_path):
	def state(mpm):
		return np.concatenate([mpm.field(name).ravel() for name in ("position", "stress", "enthalpy", "thawStrainOpen")])

	mpm = ground()
	talik.layers.fill(mpm, iceRichColumn())
	run(mpm, 0.2)
	talik.checkpoint.write(str(tmp_path / "layers.checkpoint"))
	talik.runSerially(300)
	through, materials = state(mpm), mpm.materialOf
	again = talik.resume(str(tmp_path / "layers.checkpoint"))
	talik.runSerially(300)
	assert again.materialOf == materials and [m.name for m in again.materials] == ["", "ice-rich", "clay"]
	assert (state(again) == through).all()


def test_layers_start_with_the_stress_of_the_weight_above_them():
	mpm = ground(heat=None, freezing=None, boundaries=[], poreFill=0)
	talik.layers.fill(
		mpm,
		{"sand": dict(polygon=rectangle(0, 0.5, 0.1, 1), porosity=0.5), "rock": dict(polygon=rectangle(0, 0, 0.1, 0.5), porosity=0.1)},
		lateralRatio=0.4,
		load=1e3,
	)
	mpm.initialise()
	y, stress = mpm.field("position")[:, 1], mpm.field("stress")
	weight = 9.81 * 2650
	expected = -1e3 - weight * np.where(y > 0.5, 0.5 * (1 - y), 0.25 + 0.9 * (0.5 - y))
	assert np.allclose(stress[:, 1], expected) and np.allclose(stress[:, 0], 0.4 * expected)


def test_holes_are_left_out_and_what_remains_has_the_right_area():
	hole = [(0.5 + 0.21 * np.cos(a), 0.5 + 0.21 * np.sin(a)) for a in np.linspace(0, 2 * np.pi, 40, endpoint=False)]
	mpm = wrapper.MpmEngine(gridSpacing=0.1, lower=(0, 0), upper=(1, 1.2))
	talik.geometry.fill(mpm, rectangle(0, 0, 1, 1), holes=[hole])
	mpm.skeleton = wrapper.ElasticSkeleton()
	mpm.initialise()
	error = mpm.field("volume").sum() / (1 - talik.geometry.polygonArea(hole)[0]) - 1
	nearest = np.hypot(*(mpm.field("position") - 0.5).T).min()
	print(f"area less that of the outline without the hole, over it: {error:.1e}; nearest point {nearest:.3f} m from the middle of a hole of 0.21 m")
	assert abs(error) < 1e-12 and nearest > 0.2


refused = {
	"overlap": (dict(a=dict(polygon=rectangle(0, 0, 0.1, 0.6)), b=dict(polygon=rectangle(0, 0.5, 0.1, 1))), "layers 'a' and 'b' overlap in 0.01 m2"),
	"hole outside": (dict(a=dict(polygon=rectangle(0, 0, 0.1, 0.6), holes=[rectangle(0, 0.5, 0.1, 1)])), "layer 'a': holes\\[0\\] reaches out"),
	"no polygon": (dict(a=dict(porosity=0.4)), "layer 'a' has no polygon"),
	"no material": (dict(a=dict(polygon=rectangle(0, 0, 0.1, 0.6), material="ice")), "layer 'a': material is 'ice'"),
	"unknown attribute": (dict(a=dict(polygon=rectangle(0, 0, 0.1, 0.6), ice=1)), "layer 'a' has 'ice', which no layer has; choose among polygon, holes"),
}


@pytest.mark.parametrize("layers, sentence", refused.values(), ids=refused.keys())
def test_layers_that_cannot_be_are_refused_by_name(layers, sentence):
	with pytest.raises(ValueError, match=sentence):
		talik.layers.fill(ground(), layers)


materials = {
	"number too high": (dict(materials=[Material(), Material()]), 2, "material = 2: must be an index into the list of materials, 0 to 1"),
	"half a number": (dict(materials=[Material(), Material()]), 0.5, "material is 0.5: give the name or number"),
	"unknown name": (dict(materials=[Material(name="silt")]), "clay", "material is 'clay', and MpmEngine.materials has only silt"),
	"other ice": (dict(materials=[Material(), Material(iceDensity=900)]), 1, "iceDensity = 900: must be that of materials"),
	"thaw strain above porosity": (dict(materials=[Material(thawStrain=0.5)]), 0, "porosity = 0.4: must exceed the thawStrain of its material, 0.5"),
	"thaw strain without ice": (dict(materials=[Material(thawStrain=0.3)], freezing=None), 0, "thawStrain = 0.3: ground that does not freeze"),
	"thaw strain without gravity": (dict(materials=[Material(thawStrain=0.3)], gravity=(0, 0)), 0, "thawStrain = 0.3: acts along gravity"),
	"curve without freezing": (dict(materials=[Material(freezing=wrapper.FreezingCurve())], freezing=None), 0, "MpmEngine.freezing is None"),
	"conductivity without water": (dict(materials=[Material(hydraulicConductivity=1e-6)]), 0, "MpmEngine.water is None"),
	"conductivity below zero": (
		dict(materials=[Material(hydraulicConductivity=-1)], water=wrapper.PoreWater()),
		0,
		"GroundMaterial.hydraulicConductivity = -1: must be positive",
	),
	"permeability index without water": (dict(materials=[Material(permeabilityIndex=1.3)]), 0, "permeabilityIndex or impedance is set but"),
	"permeability index below zero": (
		dict(materials=[Material(permeabilityIndex=-1)], water=wrapper.PoreWater()),
		0,
		"GroundMaterial.permeabilityIndex = -1: must be 0",
	),
	"one name twice": (dict(materials=[Material(name="a"), Material(name="a")]), 0, "two materials named 'a'"),
	"both lists": (dict(materials=[Material(), Material()], material=Material(solidDensity=2000)), 0, "are both set"),
}


@pytest.mark.parametrize("settings, material, sentence", materials.values(), ids=materials.keys())
def test_materials_that_cannot_be_are_refused_by_a_sentence(settings, material, sentence):
	mpm = ground(**settings)
	with pytest.raises(ValueError, match=sentence):
		talik.geometry.fill(mpm, rectangle(0, 0, 0.1, 1), material=material, temperature=-1)
		mpm.initialise()


def test_points_take_materials_by_name_and_a_ground_looked_at_follows_a_change_of_a_curve():
	mpm = ground(materials=[Material(name="silt"), Material(name="clay", freezing=wrapper.FreezingCurve(freezingTemperature=-2))], motion=False, boundaries=[])
	talik.geometry.fill(mpm, rectangle(0, 0, 0.1, 1), material=lambda x, y: np.where(y > 0.5, "clay", "silt"), temperature=-1)
	y, ice = mpm.field("position")[:, 1], mpm.field("iceSaturation")
	assert (ice[y > 0.5] == 0).all() and (ice[y < 0.5] > 0.9).all()
	mpm.materials[1].freezing.freezingTemperature = 0
	assert (mpm.field("iceSaturation") > 0.9).all()


def test_ground_below_a_water_table_begins_at_rest():
	mpm = ground(gridSpacing=0.25, upper=(0.5, 5), heat=None, freezing=None, water=wrapper.PoreWater(), skeleton=wrapper.ElasticSkeleton(young=2e7))
	mpm.boundaries = [*(wrapper.RollerBoundary(region=side) for side in ("left", "right", "bottom")), wrapper.DrainedBoundary(region="surface")]
	talik.layers.fill(mpm, {"sand": dict(polygon=rectangle(0, 0, 0.5, 4), porosity=0.4)}, lateralRatio=0.5, waterTable=4)
	y, pressure, vertical = mpm.field("position")[:, 1], mpm.field("pressure"), mpm.field("stress")[:, 1]
	np.testing.assert_allclose(pressure, 9810 * (4 - y), rtol=1e-9)
	np.testing.assert_allclose(vertical, -9.81 * 0.6 * 1650 * (4 - y), rtol=1e-9)
	run(mpm, 0.3)
	settles = 9.81 * 0.6 * 1650 * 4**2 / (2 * 2.69e7)  # of the same column that is filled without stress
	moved, changed = abs(mpm.field("displacement")).max(), abs(mpm.field("pressure") - 9810 * (4 - mpm.field("position")[:, 1])).max()
	print(f"moved by {1e3 * moved:.3f} mm, {moved / settles:.3f} of what it settles without stress; pressure changed by {changed / 39240:.3f} of the largest")
	assert moved < 0.05 * settles and changed < 0.05 * 39240


def test_a_water_table_may_slope_and_leaves_ground_above_it_without_pressure():
	mpm = ground(gridSpacing=0.25, upper=(2, 3), heat=None, freezing=None, water=wrapper.PoreWater(), boundaries=[])
	talik.layers.fill(mpm, {"sand": dict(polygon=rectangle(0, 0, 2, 2))}, waterTable=lambda x: 1 + 0.25 * x)
	x, y = mpm.field("position").T
	np.testing.assert_allclose(mpm.field("pressure"), np.maximum(0, 9810 * (1 + 0.25 * x - y)), rtol=1e-9, atol=1e-6)


@pytest.mark.parametrize(
	"layer, settings, sentence",
	[
		(dict(temprature=-1), {}, "layer 'sand' has 'temprature', which no layer has; did you mean temperature?"),
		(dict(hole=[]), {}, "layer 'sand' has 'hole', which no layer has; did you mean holes?"),
		(dict(holes=rectangle(0, 0, 1, 1)), {}, r"layer 'sand': holes\[0\] is \(0, 0\); it must be a list of corners"),
		(dict(porosity="high"), {}, "layer 'sand': MpmEngine.addPoints: porosity is high: give a number"),
		({}, dict(lateralRatio=-1), "lateralRatio is -1; give the ratio of horizontal to vertical effective stress"),
		({}, dict(lateralRatio=0.5, gravity=(0, 0)), r"lateralRatio is 0.5, and MpmEngine.gravity is .*set gravity=\(0, -9.81\) before filling"),
		({}, dict(waterTable=1), r"waterTable is given, and the ground has no water; set water=PoreWater\(\)"),
		(dict(pressure=1), dict(waterTable=1, water=wrapper.PoreWater()), "layer 'sand' has a pressure of its own; leave one of the two out"),
	],
)
def test_what_a_layer_cannot_be_is_refused_by_a_sentence_with_its_name(layer, settings, sentence):
	ofFill = {name: settings[name] for name in ("lateralRatio", "waterTable") if name in settings}
	mpm = ground(**{name: value for name, value in settings.items() if name not in ofFill})
	with pytest.raises(ValueError, match=sentence):
		talik.layers.fill(mpm, {"sand": dict(polygon=rectangle(0, 0, 0.1, 1), **layer)}, **ofFill)


def test_layers_with_samples_of_their_own_are_settled_each(sampleCache):
	samples = [talik.rve.pack(talik.rve.prepare(**{**forty, "porosity": porosity}, cache=sampleCache)) for porosity in (0.18, 0.20)]
	laws = [wrapper.RveSkeleton(samples=[sample]) for sample in samples]
	mpm = ground(skeleton=None, upper=(0.1, 2.2), gridSpacing=0.1)
	layers = talik.layers.fill(
		mpm,
		{
			"upper": dict(polygon=rectangle(0, 1, 0.1, 2), temperature=-1, skeleton=laws[0]),
			"lower": dict(polygon=rectangle(0, 0, 0.1, 1), temperature=-1, skeleton=laws[1]),
		},
		lateralRatio=0.7,
	)
	talik.slope.settle(mpm, rectangle(0, 0, 0.1, 2), bandThickness=0.5)
	mpm.initialise()
	y, vertical, porosity = mpm.field("position")[:, 1], mpm.field("stress")[:, 1], mpm.field("samplePorosity")
	weight = 9.81 * (0.6 * 2650 + 0.4 * 910) * (2 - (np.floor(y / 0.5) + 0.5) * 0.5)
	means = [porosity[layers[name]].mean() for name in ("upper", "lower")]
	print(f"stress off by {abs(vertical / -weight - 1).max():.1e} of the weight; porosity {means[0]:.3f} and {means[1]:.3f}")
	np.testing.assert_allclose(vertical, -weight, rtol=0.03)
	assert means[0] < 0.19 < means[1]


def neumann(conductivity, capacity, latent, colder, time):
	"""Depth of the front [m] of ground at its freezing point whose surface is colder by so many K."""
	stefan = capacity * colder / latent
	root = brentq(lambda x: x * math.exp(x * x) * math.erf(x) - stefan / math.sqrt(math.pi), 1e-6, 5)
	return 2 * root * math.sqrt(conductivity / capacity * time)


@pytest.mark.parametrize("wet", [False, True])
def test_frost_goes_through_partly_filled_gravel_as_fast_as_its_water_lets_it_and_the_silt_below_it_stays_full(wet):
	fill, n, colder, days = 0.1, 0.4, 5.0, 12
	gravel = Material(hydraulicConductivity=1e-8) if wet else Material()
	mpm = ground(
		gridSpacing=0.05,
		lower=(0, 0),
		upper=(0.05, 1.6),
		freezing=wrapper.FreezingCurve(width=0.02),
		heat=wrapper.HeatTransfer(thermalTimeScale=1e6),
		skeleton=wrapper.ElasticSkeleton(young=2e7),
		thawFront=None,
		**(dict(water=wrapper.PoreWater(conductivity=1e-8, hydraulicTimeScale=1e6)) if wet else {}),
	)
	mpm.boundaries = [
		*(wrapper.RollerBoundary(region=side) for side in ("left", "right", "bottom")),
		wrapper.SurfaceTemperature(region="surface", temperature=-colder),
		*([wrapper.DrainedBoundary(region="surface", recharge=False)] if wet else []),
	]
	layers = {
		"gravel": dict(polygon=rectangle(0, 0.5, 0.05, 1.5), porosity=n, poreFill=fill, material=gravel),
		"silt": dict(polygon=rectangle(0, 0, 0.05, 0.5), porosity=n, material=Material()),
	}
	ids = talik.layers.fill(mpm, layers, lateralRatio=0.5, **(dict(waterTable=0.5) if wet else {}))
	dry, full = 0.6 * 2650 + fill * n * 1000, 0.6 * 2650 + n * 1000
	y, vertical = mpm.field("position")[:, 1], mpm.field("stress")[:, 1]
	weight = -9.81 * (dry * np.minimum(1.5 - y, 1.0) + (full - 1000 * wet) * np.maximum(0.5 - y, 0.0))
	np.testing.assert_allclose(vertical, weight, rtol=2e-3)
	water = mpm.field("waterMass").sum()
	O.engines = [mpm]
	talik.runUntilDay(mpm, days)
	ice = 0.95 * 910 / (0.95 * 910 + 0.05 * 1000) if wet else 1.0  # of the water; without flow all of it fits into the pores that the curve leaves to ice
	frozen = mpm.field("iceMass").sum() / (ice * fill * n * 1000 * 0.05)
	kappa = (1 - n) * 1.0 + fill * n * (2.2 * ice + 0.6 * (1 - ice))
	capacity = (1 - n) * 2650 * 800 + fill * n * 1000 * (2060 * ice + 4200 * (1 - ice))
	reference = neumann(kappa, capacity, ice * fill * n * 1000 * 334e3, colder, days * talik.day)
	moved = 1e3 * abs(mpm.field("displacement")[:, 1]).max()
	print(
		f"frozen to {frozen:.3f} m, Neumann {reference:.3f} m; water {mpm.field('waterMass').sum() / water:.4f} of that at the start; moved by {moved:.1f} mm"
	)
	assert frozen == pytest.approx(reference, rel=0.03) and moved < 3
	silt = ids["silt"]
	held = mpm.field("waterMass")[silt] / (n * mpm.field("initialVolume")[silt] * 1000)
	print(f"fill of the silt {held.min():.3f} to {held.max():.3f}; of the gravel at the start {fill}")
	assert 0.97 < held.min() and held.max() < 1.03


def moist(pressure, **drained):
	"""Gravel that holds a little water over full silt."""
	mpm = ground(gridSpacing=0.1, upper=(0.4, 1.8), skeleton=wrapper.ElasticSkeleton(young=2e7), water=wrapper.PoreWater(conductivity=1e-2, pressure=pressure))
	mpm.boundaries = [
		*(wrapper.RollerBoundary(region=side) for side in ("left", "right", "bottom")),
		wrapper.SurfaceTemperature(region="surface", temperature=-5),
		wrapper.DrainedBoundary(region="surface", **drained),
	]
	gravel, silt = (dict(polygon=rectangle(0, low, 0.4, high), temperature=1, material=Material()) for low, high in ((0.8, 1.6), (0, 0.8)))
	talik.layers.fill(mpm, {"gravel": dict(poreFill=0.3, **gravel), "silt": silt}, lateralRatio=0.5, waterTable=0.8)
	return mpm


@pytest.mark.parametrize("pressure", ["explicit", "implicit"])
def test_water_of_partly_filled_gravel_runs_down_as_its_fill_lets_it_and_none_is_lost(pressure):
	"""By the cube of its fill (Corey): k s^3 is the flux, k s^3/(n s) the velocity."""
	mpm = moist(pressure, recharge=False)
	mpm.heat = mpm.freezing = None
	mpm.boundaries = [one for one in mpm.boundaries if not isinstance(one, wrapper.SurfaceTemperature)]
	water = mpm.field("waterMass").sum()
	run(mpm, 1.0)
	middle = abs(mpm.field("position")[:, 1] - 1.2) < 0.2
	speed = -(mpm.field("liquidVelocity") - mpm.field("velocity") if pressure == "explicit" else mpm.field("seepageVelocity"))[middle, 1].mean()
	closed = 1e-2 * 0.3**3 / (0.4 * 0.3)
	kept = mpm.field("waterMass").sum() / water
	print(f"{pressure}: {speed:.2e} m/s, closed form {closed:.2e} m/s; water {kept:.4f} of that at the start")
	assert speed == pytest.approx(closed, rel=0.05) and kept == pytest.approx(1, abs=2e-3)


def test_partly_filled_ground_goes_on_from_a_checkpoint_with_the_same_bits(tmp_path):
	O.reset()
	O.engines = [mpm := moist("implicit", recharge=False)]
	O.run(40, True)
	talik.checkpoint.write(tmp_path / "gravel")
	O.run(40, True)
	through = [mpm.field(name).tobytes() for name in ("position", "temperature", "conductivity", "waterMass")]
	mpm = talik.resume(tmp_path / "gravel")
	O.run(40, True)
	assert [mpm.field(name).tobytes() for name in ("position", "temperature", "conductivity", "waterMass")] == through


def test_a_drained_surface_that_wets_dry_ground_is_doubted():
	assert any("was recharge=False meant" in doubt for doubt in talik.check(moist("explicit")))
	assert not any("recharge" in doubt for doubt in talik.check(moist("explicit", recharge=False)))


def test_a_fill_of_pores_that_cannot_be_is_refused_by_the_name_of_its_layer():
	mpm = wrapper.MpmEngine(gridSpacing=0.5, gravity=(0, -9.81), skeleton=wrapper.ElasticSkeleton(), water=wrapper.PoreWater())
	gravel, silt = dict(polygon=talik.geometry.rectangle(0, 1, 2, 2), poreFill=0), dict(polygon=talik.geometry.rectangle(0, 0, 2, 1))
	with pytest.raises(ValueError, match="layer 'gravel' has poreFill 0 to 0; give 0.01 to 1"):
		talik.layers.fill(mpm, {"gravel": gravel, "silt": silt})


def test_a_name_in_place_of_a_material_is_refused_by_its_layer():
	for filled in (
		lambda mpm: talik.layers.fill(mpm, {"sand": dict(polygon=rectangle(0, 0, 0.1, 1), material="silt")}),
		lambda mpm: talik.slope.infiniteColumn(mpm, 10, {"sand": dict(thickness=1, material="silt")}),
	):
		with pytest.raises(ValueError, match="layer 'sand': material is 'silt'; give a GroundMaterial"):
			filled(ground())
