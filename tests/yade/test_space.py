# SPDX-License-Identifier: GPL-2.0-or-later
"""Ground in space from scripts: the same physics along each axis, as in the plane, and as closed forms have it."""

import math

import numpy as np
import pytest
from fixtures import spheres
from yade import O, Quaternion, Vector3, utils, wrapper

import talik

sides = [("left", "right"), ("front", "back"), ("bottom", "top")]
spacing = 0.25


@pytest.fixture(autouse=True)
def freshScene():
	O.reset()


def lattice(*lengths, side=spacing / 2):
	"""Middles of the squares or cubes that fill a box from the origin on, first coordinate fastest."""
	axes = [(np.arange(round(length / side)) + 0.5) * side for length in lengths]
	return np.stack(np.meshgrid(*axes[::-1], indexing="ij")[::-1], axis=-1).reshape(-1, len(lengths))


def across(axis, dimension):
	return [a for a in range(dimension) if a != axis]


def walls(axis, dimension, low=True):
	"""Rollers around a column along an axis, and a fixed foot."""
	names = sides if dimension == 3 else [sides[0], sides[2]]
	around = [wrapper.RollerBoundary(region=name) for a in across(axis, dimension) for name in names[a]]
	return around + ([wrapper.FixedBoundary(region=names[axis][0])] if low else [])


def along(axis, value, dimension=3):
	return tuple(value if a == axis else 0.0 for a in range(dimension))


def column(axis, dimension, height, headroom=0.0, points=None, **settings):
	"""Ground of two cells across, and `height` along an axis."""
	O.reset()
	box = [height + headroom if a == axis else 2 * spacing for a in range(dimension)]
	ground = [height if a == axis else 2 * spacing for a in range(dimension)]
	mpm = wrapper.MpmEngine(**{"gridSpacing": spacing, "lower": (0,) * dimension, "upper": tuple(box), **settings})
	mpm.addPoints(position=lattice(*ground), volume=(spacing / 2) ** dimension, **(points or {}))
	O.engines = [mpm]
	return mpm


def alongAxis(mpm, name, axis, dimension):
	"""A field by the height in a column: that of the component along the axis for vectors and stress."""
	values, position = mpm.field(name), mpm.field("position")
	component = values if values.ndim == 1 else values[:, axis]
	order = np.lexsort((np.round(position[:, axis], 9),))
	return position[order, axis], component[order]


# --- what a ground takes its dimension from --------------------------------------------------------------------------------


@pytest.mark.parametrize("given", ["lower", "gravity", "dimension", "points"])
def test_the_dimension_is_that_of_what_is_given(given):
	what = dict(lower=dict(lower=(0, 0, 0)), gravity=dict(gravity=(0, 0, -9.81)), dimension=dict(dimension=3), points={})[given]
	mpm = wrapper.MpmEngine(gridSpacing=0.5, skeleton=wrapper.ElasticSkeleton(), **what)
	talik.geometry.fill(mpm, talik.solids.box((0, 0, 0), (1, 1, 1)))
	O.engines = [mpm]
	O.run(2, True)
	shapes = {name: mpm.field(name).shape for name in ("position", "stress", "strain", "deformationGradient")}
	print(f"by {given}: dimension {mpm.dimension}, {shapes}, momentum {mpm.balance()['momentum']}")
	assert mpm.dimension == 3 and shapes == dict(position=(64, 3), stress=(64, 6), strain=(64, 6), deformationGradient=(64, 9))
	assert len(mpm.balance()["momentum"]) == 3


def contradiction(**settings):
	mpm = wrapper.MpmEngine(**{"gridSpacing": 0.5, "skeleton": wrapper.ElasticSkeleton(), **settings})
	talik.geometry.fill(mpm, talik.solids.box((0, 0, 0), (1, 1, 1)))
	O.engines = [mpm]
	O.step()


@pytest.mark.parametrize(
	"settings, message",
	[
		(dict(gravity=(0, -9.81)), "MpmEngine.gravity is .0, -9.81., of two components, but the ground is in space"),
		(dict(lower=(0, 0)), "MpmEngine.lower is .0, 0., of two components"),
		(dict(dimension=2), "MpmEngine.dimension is 2"),
		(dict(boundaries=[wrapper.RollerBoundary(region="disc")]), "RollerBoundary.region is 'disc': choose left, right, front, back, bottom, top, surface"),
		(dict(boundaries=[wrapper.FixedBoundary(region="box", lower=(0, 0), upper=(1, 1))]), "FixedBoundary.lower is .0, 0., of two components"),
		(dict(boundaries=[wrapper.SurfaceLoad(region="surface", traction=(1, 0))]), "SurfaceLoad.traction is .1, 0., of two components"),
		(dict(bodies=wrapper.BodyContact(thickness=2)), "BodyContact.thickness = 2: must be 1 in space"),
	],
)
def test_what_does_not_fit_into_space_is_refused_by_a_sentence(settings, message):
	with pytest.raises((ValueError, RuntimeError), match=message) as refusal:
		contradiction(**settings)
	print(refusal.value)


# --- columns ---------------------------------------------------------------------------------------------------------------


def settled(axis, dimension):
	"""Elastic column under its weight at rest: heights, stress and displacement along it."""
	law = wrapper.ElasticSkeleton(young=5e6, poisson=0.25)
	mpm = column(
		axis, dimension, 2.0, 0.5, gravity=along(axis, -9.81, dimension), skeleton=law, damping=0.7, boundaries=walls(axis, dimension), automaticTimeStep=False
	)
	O.dt = 5e-4
	O.run(4000, True)
	height, stress = alongAxis(mpm, "stress", axis, dimension)
	return height, stress, mpm.field("displacement")[:, axis]


def test_an_elastic_column_settles_along_each_axis_as_in_the_plane_and_in_closed_form():
	weight, modulus = 0.6 * 2650 * 9.81, 5e6 * 0.75 / (1.25 * 0.5)
	results = {name: settled(axis, dimension) for name, axis, dimension in (("plane", 1, 2), ("x", 0, 3), ("y", 1, 3), ("z", 2, 3))}
	exact = -weight * 4 / (2 * modulus)
	for name, (height, stress, displacement) in results.items():
		error, off = displacement.min() / exact - 1, np.abs(stress + weight * (2.0 - height)).max() / (2 * weight)
		print(f"{name}: top settles by {-displacement.min() * 1e3:.4f} mm, closed form {-exact * 1e3:.4f}; stress off by {off:.2%} of the largest")
		assert off < 0.04 and abs(error) < 0.02
	spread = max(np.abs(np.sort(results[axis][2]) - np.sort(results["z"][2])).max() for axis in "xy") / abs(exact)
	print(f"the three axes differ by {spread:.1e}")
	assert spread < 1e-10


def conducted(axis, dimension):
	"""Half space of 0 degC whose end is put to 1 degC, after 1e6 s of heat; only heat."""
	heat = wrapper.HeatTransfer(thermalTimeScale=1)
	names = sides if dimension == 3 else [sides[0], sides[2]]
	hot = wrapper.WallTemperature(region=names[axis][0], temperature=6)
	mpm = column(axis, dimension, 3.0, motion=False, heat=heat, boundaries=[hot], points=dict(temperature=5.0), automaticTimeStep=False)
	O.dt = 5000
	O.run(200, True)
	return mpm, alongAxis(mpm, "temperature", axis, dimension)


def test_heat_goes_along_each_axis_as_in_the_plane_and_as_the_error_function_has_it():
	from scipy.special import erfc

	conductivity = 0.6 * 1.0 + 0.4 * 0.6
	capacity = 0.6 * 2650 * 800 + 0.4 * 1000 * 4200
	results = {name: conducted(axis, dimension)[1] for name, axis, dimension in (("plane", 1, 2), ("x", 0, 3), ("y", 1, 3), ("z", 2, 3))}
	plane = results["plane"][1].reshape(-1, 4)[:, 0]
	for name, (height, temperature) in results.items():
		error = np.abs(temperature - 5 - erfc(height / (2 * math.sqrt(conductivity / capacity * 1e6)))).max()
		layers = temperature.reshape(24, -1)
		differs = np.abs(layers - plane[:, None]).max()
		print(f"{name}: error {error:.4f} of a jump of 1, {differs:.1e} from the plane")
		assert error < 0.02 and differs < 1e-9


def consolidated(axis, dimension):
	"""Terzaghi: a load of 10 kPa that the water bears at first, drained at the top, after 1 s: pressure by height."""
	boundaries = walls(axis, dimension) + [wrapper.DrainedBoundary(region="surface"), wrapper.SurfaceLoad(region="surface", pressure=10e3)]
	ground = dict(skeleton=wrapper.ElasticSkeleton(young=10e6, poisson=0.2), water=wrapper.PoreWater(conductivity=1e-3))
	mpm = column(axis, dimension, 2.0, spacing, boundaries=boundaries, points=dict(pressure=10e3), automaticTimeStep=False, **ground)
	O.dt = 2e-4
	O.run(5000, True)
	return alongAxis(mpm, "pressure", axis, dimension)


def terzaghi(height, length, pressure, factor):
	depth = (length - height) / length
	odd = (2 * np.arange(200) + 1) * math.pi / 2
	return pressure * sum(2 / m * np.sin(m * depth) * math.exp(-m * m * factor) for m in odd)


def test_water_is_squeezed_out_along_each_axis_as_in_the_plane_and_as_terzaghi_has_it():
	results = {name: consolidated(axis, dimension) for name, axis, dimension in (("plane", 1, 2), ("x", 0, 3), ("y", 1, 3), ("z", 2, 3))}
	modulus, storage = 10e6 * 0.8 / (1.2 * 0.6), 0.4 / 2.2e7  # K_w of the explicit pressure, when it is not given
	for name, (height, pressure) in results.items():
		exact = terzaghi(height, 2.0, 10e3, 1e-3 / (9810 * (1 / modulus + storage)) / 4)
		error = np.sqrt(np.mean((pressure - exact) ** 2)) / 10e3
		differs = np.abs(pressure.reshape(16, -1) - results["z"][1].reshape(16, -1)[:, :1]).max() / 10e3
		print(f"{name}: error {error:.2%} of the load, {differs:.1e} from the column along z; pressure at the foot {pressure[0]:.0f}, exact {exact[0]:.0f} Pa")
		assert error < 0.05 and differs < (0.01 if name == "plane" else 1e-9)


# --- turned scenes, slices -------------------------------------------------------------------------------------------------

tensor = [(0, 0), (1, 1), (2, 2), (1, 2), (0, 2), (0, 1)]


def thawingHeap(turned, steps=200):
	"""Freezing, wet Mohr-Coulomb ground that slides over its floor, with all axes turned on by so many: what pointed along x points along y."""
	moved = lambda vector: np.roll(vector, turned, axis=-1)
	side = lambda axis, upper: sides[(axis + turned) % 3][upper]
	boundaries = [wrapper.FixedBoundary(region=side(2, 0)), wrapper.RollerBoundary(region=side(1, 0)), wrapper.RollerBoundary(region=side(0, 0))]
	boundaries += [wrapper.SurfaceTemperature(region="surface", temperature=8), wrapper.DrainedBoundary(region="surface", recharge=False)]
	mpm = wrapper.MpmEngine(
		gridSpacing=spacing,
		lower=(0, 0, 0),
		upper=tuple(moved(np.array([2.0, 1.0, 1.5]))),
		gravity=tuple(moved(np.array([5.0, 2.0, -9.0]))),
		skeleton=wrapper.MohrCoulombSkeleton(young=2e6, youngFrozen=2e7, cohesion=500, frictionAngle=20),
		heat=wrapper.HeatTransfer(thermalTimeScale=1e6),
		freezing=wrapper.FreezingCurve(),
		water=wrapper.PoreWater(conductivity=1e-4),
		boundaries=boundaries,
		automaticTimeStep=False,
	)
	position = lattice(1.0, 0.75, 1.0)
	position = position[position[:, 0] + position[:, 2] < 1.5]
	mpm.addPoints(position=moved(position), volume=(spacing / 2) ** 3, temperature=0.5 - 4 * position[:, 2])
	O.engines, O.dt = [mpm], 2e-4
	O.run(steps, True)
	stress = np.array([[mpm.field("stress")[:, tensor.index(tuple(sorted(((i + turned) % 3, (j + turned) % 3))))] for j in range(3)] for i in range(3)])
	return {name: np.roll(mpm.field(name), -turned, axis=-1) for name in ("displacement", "velocity")} | {
		"stress": stress,
		"temperature": mpm.field("temperature"),
		"pressure": mpm.field("pressure"),
		"iceSaturation": mpm.field("iceSaturation"),
	}


def test_a_scene_with_all_effects_whose_axes_are_turned_gives_the_turned_answer():
	straight = thawingHeap(0)
	print(f"displaced by up to {np.abs(straight['displacement']).max():.3f} m, {np.ptp(straight['iceSaturation']):.2f} of ice saturation between the points")
	assert np.abs(straight["displacement"]).max() > 5e-4 and np.ptp(straight["iceSaturation"]) > 0.5
	for turned in (1, 2):
		for name, values in thawingHeap(turned).items():
			differs = np.abs(values - straight[name]).max() / np.abs(straight[name]).max()
			print(f"turned by {turned}: {name} differs by {differs:.1e} of the largest")
			assert differs < 1e-10


def slump(dimension):
	"""Dry Mohr-Coulomb ground whose support is taken away; in space two cells of it between smooth walls."""
	O.reset()
	outline = [(0, 0), (4, 0), (4, 0.5), (2, 0.5), (1.5, 2), (0, 2)]
	box = [6.0, 2.5]
	boundaries = [wrapper.RollerBoundary(region="left"), wrapper.FixedBoundary(region="bottom")]
	if dimension == 3:
		box.insert(1, 2 * spacing)
		boundaries += [wrapper.RollerBoundary(region="front"), wrapper.RollerBoundary(region="back")]
	mpm = wrapper.MpmEngine(
		gridSpacing=spacing,
		lower=(0,) * dimension,
		upper=tuple(box),
		gravity=along(dimension - 1, -9.81, dimension),
		skeleton=wrapper.MohrCoulombSkeleton(young=2e6, cohesion=0, frictionAngle=25, tensileStrength=0),
		boundaries=boundaries,
	)
	talik.geometry.fill(mpm, outline if dimension == 2 else talik.solids.extruded(outline, 0, 2 * spacing))
	O.engines, O.stopAtTime = [mpm], 1.0
	O.run(wait=True)
	moved = mpm.field("displacement")[:, [0, dimension - 1]]
	weight = mpm.field("volume") / mpm.field("volume").sum()
	return dict(
		front=np.sort(mpm.field("position")[:, 0])[-1],
		runout=weight @ np.abs(moved[:, 0]),
		drop=weight @ np.abs(moved[:, 1]),
		largest=np.linalg.norm(moved, axis=1).max(),
	)


def test_a_slice_of_a_slump_in_space_moves_as_the_slump_in_the_plane():
	plane, space = slump(2), slump(3)
	for name in plane:
		print(f"{name}: plane {plane[name]:.4f} m, slice of space {space[name]:.4f} m, {space[name] / plane[name] - 1:+.2%}")
		assert abs(space[name] / plane[name] - 1) < 0.02


# --- closed forms in three directions --------------------------------------------------------------------------------------


def test_a_ball_warms_from_its_surface_as_the_series_has_it():
	radius, h = 1.0, 0.125
	mpm = wrapper.MpmEngine(
		gridSpacing=h,
		lower=(0, 0, 0),
		upper=(3, 3, 3),
		motion=False,
		heat=wrapper.HeatTransfer(),
		boundaries=[wrapper.SurfaceTemperature(region="surface", temperature=2.0)],
	)
	# cubes whose middles lie inside, with the volume of the ball
	position = lattice(3, 3, 3, side=h / 2)
	position = position[np.linalg.norm(position - 1.5, axis=1) < radius]
	volume = 4 / 3 * math.pi * radius**3 / len(position)
	mpm.addPoints(position=position, volume=volume, temperature=1.0)
	O.engines = [mpm]
	diffusivity = (0.6 * 1.0 + 0.4 * 0.6) / (0.6 * 2650 * 800 + 0.4 * 1000 * 4200)
	for factor in (0.05, 0.1, 0.2):
		O.stopAtTime = factor * radius**2 / diffusivity
		O.run(wait=True)
		r, reached = np.linalg.norm(mpm.field("position") - 1.5, axis=1), O.time * diffusivity / radius**2
		n = np.arange(1, 60)
		exact = 2 + 2 / math.pi * ((-1.0) ** n / n * np.exp(-n * n * math.pi**2 * reached) * np.sin(np.outer(r, n) * math.pi)).sum(axis=1) / r
		error = mpm.field("temperature") - exact
		print(f"at Fourier number {reached:.3f}: rms error {np.sqrt(np.mean(error**2)):.3f} of a jump of 1, at the middle {error[r < 0.2].mean():+.3f}")
		assert np.sqrt(np.mean(error**2)) < 0.05


def block(**settings):
	mpm = wrapper.MpmEngine(**{"gridSpacing": 0.25, "lower": (0, 0, 0), "upper": (3, 3, 3), "skeleton": wrapper.ElasticSkeleton(young=1e6), **settings})
	O.engines = [mpm]
	return mpm


def test_a_block_falls_freely():
	mpm = block(gravity=(0, 0, -9.81))
	mpm.addPoints(position=lattice(1, 1, 1) + (1, 1, 1.5), volume=0.125**3)
	start = mpm.field("position")
	O.stopAtTime = 0.3
	O.run(wait=True)
	fallen, time = (mpm.field("position") - start), O.time
	steps = mpm.cost()["steps"]
	exact = -0.5 * 9.81 * time * (time + time / steps)  # symplectic steps of equal length
	off = np.abs(fallen - (0, 0, exact)).max()
	print(
		f"fallen by {-fallen[:, 2].mean():.9f} m in {steps} steps, exact {-exact:.9f} m, off by up to {off:.1e} m; stress {np.abs(mpm.field('stress')).max():.1e} Pa"
	)
	assert off < 2e-3 * abs(exact) and np.abs(mpm.field("velocity") - (0, 0, -9.81 * time)).max() < 1e-9


def test_a_turning_block_keeps_its_momenta_and_its_shape():
	h = 0.25
	mpm = block(transfer="apic")
	position = lattice(0.75, 0.75, 0.75) + 1.125
	axis = np.array([1.0, 2.0, 2.0]) / 3
	mpm.addPoints(position=position, volume=0.125**3, velocity=np.cross(4 * axis, position - position.mean(axis=0)))

	def angularMomentum():
		x, v = mpm.field("position"), mpm.field("velocity")
		c = mpm.field("affineVelocity").reshape(-1, 3, 3).sum(axis=0)
		own = h * h / 4 * np.array([c[2, 1] - c[1, 2], c[0, 2] - c[2, 0], c[1, 0] - c[0, 1]])  # with the second moment of the spline, h^2/4
		return 0.6 * 2650 * 0.125**3 * (np.cross(x - x.mean(axis=0), v).sum(axis=0) + own)

	before = angularMomentum()
	O.stopAtTime = 2 * math.pi / 4  # one turn
	O.run(wait=True)
	after, linear = angularMomentum(), np.abs(mpm.balance()["momentum"]).max()
	size = np.linalg.norm(mpm.field("position") - mpm.field("position").mean(axis=0), axis=1).max() / (math.sqrt(3) * 0.3125)
	lost = np.abs(after - before).max() / np.linalg.norm(before)
	print(f"after one turn momentum {linear:.1e} kg m/s, angular momentum off by {lost:.1e}; size {size:.4f} of that at the start")
	assert linear < 1e-9 and lost < 1e-10 and abs(size - 1) < 0.01


# --- bodies ----------------------------------------------------------------------------------------------------------------


def bed(**settings):
	"""A box of ground, 1 m by 1 m and 0.5 m high, in smooth walls."""
	boundaries = [wrapper.RollerBoundary(region=name) for pair in sides[:2] for name in pair] + [wrapper.FixedBoundary(region="bottom")]
	mpm = wrapper.MpmEngine(
		**{
			"gridSpacing": 0.125,
			"lower": (0, 0, 0),
			"upper": (1, 1, 1),
			"skeleton": wrapper.ElasticSkeleton(young=2e6, poisson=0.2),
			"bodies": wrapper.BodyContact(frictionAngle=30),
			"boundaries": boundaries,
			"damping": 0.3,
			**settings,
		}
	)
	talik.geometry.fill(mpm, talik.solids.box((0, 0, 0), (1, 1, 0.5)))
	O.engines = [wrapper.ForceResetter(), mpm, wrapper.NewtonIntegrator(gravity=(0, 0, -9.81), damping=0.3)]
	return mpm


def plate(z, half, **state):
	"""Two facets that make a square across z."""
	corners = [(0.5 - half, 0.5 - half, z), (0.5 + half, 0.5 - half, z), (0.5 + half, 0.5 + half, z), (0.5 - half, 0.5 + half, z)]
	return [utils.facet([corners[0], corners[1], corners[2]], **state), utils.facet([corners[0], corners[2], corners[3]], **state)]


@pytest.mark.parametrize(
	"kind", [pytest.param("sphere", id="sphere_slow"), pytest.param("box", id="box_slow"), "turned box", pytest.param("clump", id="clump_slow")]
)
def test_a_body_comes_to_rest_on_the_ground_that_bears_its_weight(kind):
	bed()
	if kind == "clump":
		O.bodies.appendClumped([utils.sphere((0.4, 0.5, 0.62), 0.12), utils.sphere((0.6, 0.5, 0.62), 0.12)])
	elif kind == "sphere":
		O.bodies.append(utils.sphere((0.5, 0.5, 0.71), 0.2))
	else:
		turned = Quaternion((0, 0, 1), 0.5) if kind == "turned box" else Quaternion.Identity
		O.bodies.append(utils.box((0.5, 0.5, 0.61), (0.2, 0.2, 0.1), orientation=turned))
	body = next(b for b in O.bodies if not b.isClumpMember)
	body.state.vel = (0, 0, 0)
	O.run(6000, True)
	force = sum((O.forces.f(b.id) for b in O.bodies if b.isClumpMember or not b.isClump), Vector3.Zero)
	weight = body.state.mass * 9.81
	print(
		f"{kind}: pushed by {tuple(round(f / weight, 4) for f in force)} of its weight, sunk to {body.state.pos[2]:.4f} m, speed {body.state.vel.norm():.1e} m/s"
	)
	assert abs(force[2] / weight - 1) < 0.02 and max(abs(force[0]), abs(force[1])) < 0.02 * weight


def test_a_plate_of_facets_pressed_into_the_ground_meets_the_force_of_a_box_of_its_size():
	forces = {}
	for kind in ("facets", "box"):
		O.reset()
		bed()
		if kind == "box":
			O.bodies.append(utils.box((0.5, 0.5, 0.6), (0.25, 0.25, 0.1), fixed=True))
		else:
			O.bodies.append(plate(0.5, 0.25, fixed=True))
		for body in O.bodies:
			body.state.vel = (0, 0, -0.05)
		O.stopAtTime = 0.2
		O.run(wait=True)
		forces[kind] = sum((O.forces.f(b.id) for b in O.bodies), Vector3.Zero)
	mean = 2e6 * 0.8 / (1.2 * 0.6) * 0.01 / 0.5 * 0.25
	print(f"at 1 cm: facets {forces['facets'][2]:.0f} N, box {forces['box'][2]:.0f} N; under a plate as wide as the bed it would be {mean / 0.25:.0f} N")
	assert abs(forces["facets"][2] / forces["box"][2] - 1) < 0.1 and 0.3 * mean < forces["box"][2] < 4 * mean


def test_ground_and_bodies_keep_their_momentum_together():
	mpm = block(bodies=wrapper.BodyContact(frictionAngle=20))
	mpm.addPoints(position=lattice(1, 1, 1) + (1, 1, 0.5), volume=0.125**3)
	O.bodies.append(utils.sphere((1.4, 1.6, 2.0), 0.3))
	O.bodies.append(utils.box((2.5, 1.5, 1.1), (0.2, 0.3, 0.4), orientation=Quaternion((1, 1, 0), 0.7)))
	O.bodies[0].state.vel, O.bodies[1].state.vel, O.bodies[0].state.angVel = (0.3, 0, -1), (-1, 0, 0), (1, 2, 3)
	O.engines = [wrapper.ForceResetter(), mpm, wrapper.NewtonIntegrator(damping=0)]
	start = sum((b.state.mass * b.state.vel for b in O.bodies), Vector3.Zero)
	O.run(400, True)
	bodies = sum((b.state.mass * b.state.vel for b in O.bodies), Vector3.Zero)
	ground = np.array(mpm.balance()["momentum"])
	lost = np.abs(ground + np.array(bodies) - np.array(start)).max() / start.norm()
	print(f"ground took {np.round(ground, 2)} kg m/s; {lost:.1e} of the momentum was lost")
	assert np.abs(ground).max() > 10 and lost < 1e-12


# --- looking, saving -------------------------------------------------------------------------------------------------------


def test_points_are_found_watched_and_written_in_space(tmp_path):
	mpm = bed(bodies=None, gravity=(0, 0, -9.81))
	O.engines = [mpm]
	ids = [mpm.pick(0.1, 0.2, 0.3), mpm.pick(0.9, 0.9, 0.5)]
	position = mpm.field("position")
	for id, place in zip(ids, ((0.1, 0.2, 0.3), (0.9, 0.9, 0.5))):
		assert np.linalg.norm(position - place, axis=1).argmin() == id
	with pytest.raises(ValueError, match="the ground is in space: give x, y and z"):
		mpm.pick(0.1, 0.2)
	mpm.watch(ids)
	O.run(5, True)
	history = mpm.history(ids[0])
	print({name: values.shape for name, values in history.items()})
	assert history["stress"].shape == (6, 6) and history["strain"].shape == (6, 6) and history["position"].shape == (6, 3)
	np.testing.assert_array_equal(history["stress"][-1], mpm.field("stress")[ids[0]])
	file = talik.output.ParaViewSeries(mpm, tmp_path).write()
	text = open(file, "rb").read()
	assert b'ComponentName4="xz"' in text
	assert len(mpm.mostStrained(3)) == 3


def test_logarithmic_strain_is_that_of_the_stretches():
	mpm = wrapper.MpmEngine(
		gridSpacing=0.25, lower=(-1, -1, -1), upper=(2, 2, 2), skeleton=wrapper.ElasticSkeleton(young=1, poisson=0), automaticTimeStep=False
	)
	rate = np.array([[0.3, 0.2, 0.1], [0.2, -0.1, 0.0], [0.1, 0.0, 0.2]])
	inner = lattice(1, 1, 1)
	mpm.addPoints(position=inner, volume=0.125**3, velocity=inner @ rate)
	O.engines, O.dt = [mpm], 1e-3
	O.run(20, True)
	middle = mpm.pick(0.5, 0.5, 0.5)
	f = mpm.field("deformationGradient")[middle].reshape(3, 3)
	values, vectors = np.linalg.eigh(f @ f.T)
	exact = vectors @ np.diag(0.5 * np.log(values)) @ vectors.T
	strain = mpm.field("strain")[middle]
	print(f"strain {np.round(strain, 6)}, of the rate over time {np.round([rate[i, j] * 0.02 for i, j in tensor], 6)}")
	np.testing.assert_allclose(strain, [exact[i, j] for i, j in tensor], rtol=1e-10, atol=1e-15)
	deviator = exact - np.eye(3) * np.trace(exact) / 3
	np.testing.assert_allclose(mpm.field("deviatoricStrain")[middle], math.sqrt(2 / 3 * (deviator**2).sum()), rtol=1e-10)


def test_a_run_in_space_goes_on_from_a_checkpoint_to_the_same_bits(tmp_path):
	def scene():
		O.reset()
		mpm = bed(gravity=(0, 0, -9.81), heat=wrapper.HeatTransfer(thermalTimeScale=1e5), freezing=wrapper.FreezingCurve(), water=wrapper.PoreWater())
		mpm.setTemperature(-0.3)
		O.bodies.append(utils.sphere((0.5, 0.5, 0.75), 0.2))
		O.bodies.append(plate(0.8, 0.1, fixed=True))
		return mpm

	whole = scene()
	O.run(60, True)
	expected = {name: whole.field(name) for name in whole.fieldNames()}
	scene()
	O.run(25, True)
	talik.checkpoint.write(str(tmp_path / "space.checkpoint"))
	O.reset()
	mpm = talik.resume(str(tmp_path / "space.checkpoint"))
	O.run(35, True)
	differ = [name for name, values in expected.items() if not np.array_equal(values, mpm.field(name), equal_nan=True)]
	print(f"{len(expected)} fields, {mpm.dimension} dimensions; differing: {differ}")
	assert not differ


def test_settings_without_sense_and_points_outside_are_named():
	mpm = wrapper.MpmEngine(gridSpacing=0.5, lower=(0, 0, 0), upper=(1, 1, 1), skeleton=wrapper.ElasticSkeleton())
	mpm.addPoints(position=[(0.5, 0.5, 1.5)], volume=0.1)
	with pytest.raises(ValueError, match=r"position\[2\]"):
		mpm.initialise()
	with pytest.raises(ValueError, match=r"\(n,2\), but points with 3 coordinates"):
		mpm.addPoints(position=[(0.5, 0.5)], volume=0.1)
	with pytest.raises(ValueError, match="xx, yy, zz, yz, xz, xy"):
		mpm.addPoints(position=[(0.5, 0.5, 0.5)], volume=0.1, stress=(1, 2, 3, 4))
	sideways = wrapper.MpmEngine(gridSpacing=0.5, gravity=(0, -9.81, 0), skeleton=wrapper.ElasticSkeleton())
	talik.geometry.fill(sideways, talik.solids.box((0, 0, 0), (1, 1, 1)))
	print(sideways.doubts())
	assert any("z points upwards" in doubt for doubt in sideways.doubts())


# --- samples of spheres ----------------------------------------------------------------------------------------------------


def test_samples_of_spheres_stand_behind_the_points_and_give_six_stresses(sampleCache, tmp_path):
	sample = talik.rve.pack(talik.rve.prepare(**spheres, cache=sampleCache))

	def scene():
		O.reset()
		mpm = bed(
			bodies=None,
			gravity=(0, 0, -9.81),
			skeleton=wrapper.RveSkeleton(samples=[sample]),
			heat=wrapper.HeatTransfer(thermalTimeScale=1e5),
			freezing=wrapper.FreezingCurve(),
			gridSpacing=0.5,
		)
		O.engines = [mpm]
		mpm.setTemperature(-2.0)
		return mpm

	mpm = scene()
	start = mpm.field("stress")
	frozen = np.abs(start).max()
	O.run(10, True)
	counters = mpm.skeleton.cost()
	one = mpm.skeleton.sample(3)
	print(
		f"{len(start)} points, stress at the start up to {frozen:.1f} Pa; after 10 steps {counters['calls']} calls, bonds {mpm.field('bondsIntact').min():.0f}"
	)
	print(f"stress of point 3 {np.round(mpm.field('stress')[3])}, of its sample {np.round(one.stress)} Pa; fabric {mpm.field('fabric').shape}")
	assert start.shape == (len(start), 6) and len(one.stress) == 6 and counters["calls"] > 0 and mpm.field("bondsIntact").min() > 50
	assert np.isfinite(mpm.field("stress")).all() and mpm.field("fabric").shape == (len(start), 6)
	expected = mpm.field("stress")
	scene()
	O.run(4, True)
	talik.checkpoint.write(str(tmp_path / "spheres.checkpoint"))
	O.reset()
	mpm = talik.resume(str(tmp_path / "spheres.checkpoint"))
	O.run(6, True)
	np.testing.assert_array_equal(mpm.field("stress"), expected)
	with mpm.inspect(3):
		assert len(O.bodies) == 100


@pytest.mark.parametrize("solid", ["terrain", pytest.param("extruded", id="extruded_slow")])
def test_samples_of_spheres_are_brought_to_the_weight_above_their_points(solid, sampleCache):
	sample = talik.rve.pack(talik.rve.prepare(**spheres, cache=sampleCache))
	outline = [(0, 0), (2, 0), (2, 1), (0, 3)]
	hill = {
		"terrain": talik.solids.terrain(lambda x, y: 3 - x, base=0.0, lower=(0, 0), upper=(2, 1)),
		"extruded": talik.solids.extruded(outline, 0, 1),
	}[solid]
	mpm = wrapper.MpmEngine(gridSpacing=0.5, lower=(0, 0, 0), upper=(2, 1, 4), gravity=(0, 0, -9.81), skeleton=wrapper.RveSkeleton(samples=[sample]))
	talik.geometry.fill(mpm, hill, porosity=0.4)
	with pytest.raises(ValueError, match="the ground has 3 dimensions; give a solid of talik.solids"):
		talik.slope.settle(mpm, outline)
	talik.slope.settle(mpm, hill, bandThickness=0.25, lateralRatio=0.6)
	O.engines = [mpm]
	mpm.initialise()
	x, y, z = mpm.field("position").T
	weight, stress = 0.6 * 2650 * 9.81 * (3 - x - z), mpm.field("stress")
	off = np.abs(stress[:, 2] + weight).max() / weight.max()
	sideways = np.abs(stress[:, :2] / stress[:, 2:3] - 0.6).max()
	print(f"{solid}: vertical stress off by up to {off:.1%} of the largest weight, lateral ratio by {sideways:.3f}")
	assert off < 0.1 and sideways < 0.05


def test_samples_of_discs_behind_points_in_space_are_refused(sampleCache):
	sample = talik.rve.pack(talik.rve.prepare(grains=30, cache=sampleCache))
	with pytest.raises((ValueError, RuntimeError), match="disc|plane|dimension") as refusal:
		contradiction(skeleton=wrapper.RveSkeleton(samples=[sample]))
	print(refusal.value)
