# SPDX-License-Identifier: GPL-2.0-or-later
"""Debian's YADE is built with asserts and ends the whole process on them. Those within reach of a user of ours are answered by an
exception before the first step: each test here would end Python otherwise, and goes on with a correct run instead."""

import numpy as np
import pytest
from yade import Matrix3, O, utils, wrapper

import talik
from talik import rve


@pytest.fixture(scope="module")
def sample(sampleCache):
	return talik.rve.pack(rve.prepare(grains=30, porosity=0.19, cache=sampleCache))


def loop(parameters=None, laws=None):
	parameters = [wrapper.Ip2_IceBondMat_IceBondMat_IceBondPhys(bondNewContacts=True)] if parameters is None else parameters
	laws = [wrapper.Law2_ScGeom_IceBondPhys_IceBond()] if laws is None else laws
	return wrapper.InteractionLoop([wrapper.Ig2_Sphere_Sphere_ScGeom()], parameters, laws)


def pair(contacts=None):
	material = O.materials.append(wrapper.IceBondMat(young=1e7, density=1000, iceSaturation=1))
	O.bodies.append([utils.sphere((x, 1, 1), 1, material=material) for x in (1, 2.999)])
	O.engines = [wrapper.ForceResetter(), wrapper.InsertionSortCollider([wrapper.Bo1_Sphere_Aabb()]), contacts or loop(), wrapper.NewtonIntegrator()]
	O.dt = 1e-5


def periodic(side):
	O.periodic = True
	O.cell.hSize = Matrix3(side, 0, 0, 0, side, 0, 0, 0, side)


def refusedByAll(words):
	"""O.run, O.step and runSerially say the same, and no step is done."""
	sentences = set()
	for start in (lambda: O.run(3, True), O.step, lambda: talik._talik.runSerially(3)):
		with pytest.raises(RuntimeError, match=words) as refusal:
			start()
		sentences.add(str(refusal.value))
	(sentence,) = sentences
	print(sentence)
	assert O.iter == 0 and sentence.startswith("The scene cannot run: ")


def goesOn():
	O.run(3, True)
	assert O.iter == 3 and all(np.isfinite(body.state.pos).all() for body in O.bodies if body.shape)


@pytest.mark.parametrize("recorders", [["intr"], ["spheres", "intr"], ["all"]])
def test_contacts_of_a_periodic_scene_are_not_given_to_stock_yades_recorder(sample, recorders, tmp_path):
	"""Stock YADE ends with a segmentation fault."""
	with talik.inspect(sample.open()):
		before = O.iter
		O.engines = O.engines + [wrapper.VTKRecorder(fileName=str(tmp_path) + "/", recorders=recorders, iterPeriod=1)]
		for start in (lambda: O.run(3, True), O.step, lambda: talik.runSerially(3)):
			with pytest.raises(RuntimeError, match="by which stock YADE crashes in a periodic scene") as refusal:
				start()
		print(refusal.value)
		O.engines[-1].recorders = ["spheres", "velocity", "colors"]
		O.run(2, True)
		assert O.iter == before + 2
		files = talik.output.SampleSeries(tmp_path).write()
	assert list(tmp_path.glob("*spheres*")) and list(tmp_path.glob("sample_contacts*")), files


def test_a_prepared_sample_is_no_scene_and_the_remedy_is_named(sampleCache):
	with pytest.raises(TypeError, match=r"got Sample; give a Scene: packed.open\(\)"):
		talik.inspect(rve.prepare(grains=30, porosity=0.19, cache=sampleCache))


def test_a_body_without_material_is_named():
	pair()
	material, O.bodies[1].material = O.bodies[1].material, None
	refusedByAll(r"O.bodies\[1\] has no material")
	O.bodies[1].material = material
	goesOn()


def test_a_body_without_state_is_named():
	pair()
	state, O.bodies[1].state = O.bodies[1].state, None
	refusedByAll(r"O.bodies\[1\] has no state")
	O.bodies[1].state = state
	goesOn()


def test_a_body_on_the_ground_without_state_is_named():
	O.bodies.append(utils.sphere((0.5, 0.9, 0), 0.2))
	mpm = wrapper.MpmEngine(
		gridSpacing=0.25,
		lower=(0, 0),
		upper=(2, 2),
		gravity=(0, -9.81),
		skeleton=wrapper.ElasticSkeleton(),
		bodies=wrapper.BodyContact(),
		boundaries=[wrapper.FixedBoundary(region="bottom")],
	)
	talik.geometry.fill(mpm, talik.geometry.rectangle(0, 0, 1, 0.5))
	O.engines = [wrapper.ForceResetter(), mpm, wrapper.NewtonIntegrator()]
	state, O.bodies[0].state = O.bodies[0].state, None
	refusedByAll(r"O.bodies\[0\] has no state")
	O.bodies[0].state = state
	goesOn()


def test_a_position_in_a_periodic_cell_that_is_not_finite_is_named():
	periodic(10)
	pair()
	place, O.bodies[0].state.pos = O.bodies[0].state.pos, (float("nan"), 0, 0)
	refusedByAll(r"position of O.bodies\[0\] is not finite")
	O.bodies[0].state.pos = place
	goesOn()


def test_a_cell_shorter_than_its_bodies_is_refused_with_its_length():
	periodic(2.5)
	pair()
	refusedByAll("its cell is 2.5.* too short for spheres of radius 1")
	periodic(10)
	goesOn()


def test_contacts_that_no_ip2_functor_knows_are_refused():
	pair(loop(parameters=[]))
	refusedByAll("no Ip2 functor for contacts of IceBondMat")
	O.engines = O.engines[:2] + [loop()] + O.engines[3:]
	goesOn()


@pytest.mark.parametrize("parameters, laws", [(None, []), ("stock", None)])
def test_contacts_that_no_law_knows_are_refused(parameters, laws):
	pair(loop([wrapper.Ip2_FrictMat_FrictMat_FrictPhys()] if parameters else None, laws))
	refusedByAll("no Law2 functor for what Ip2_")
	O.engines = O.engines[:2] + [loop()] + O.engines[3:]
	goesOn()


def addFrictionalSphere(**place):
	O.bodies.append(utils.sphere((1, 1, 9), 0.1, material=O.materials.append(wrapper.FrictMat(young=1e7)), **place))


def know(parameters=(), laws=()):
	contacts = O.engines[2]
	contacts.physDispatcher.functors = contacts.physDispatcher.functors + list(parameters)
	contacts.lawDispatcher.functors = contacts.lawDispatcher.functors + list(laws)


def test_ice_bonded_grains_and_bodies_of_another_material_need_functors_for_their_contacts_before_they_meet():
	pair()
	addFrictionalSphere()
	refusedByAll(r"no Ip2 functor for contacts of O.bodies\[2\] \(FrictMat\) and O.bodies\[0\] \(IceBondMat\)")
	know([wrapper.Ip2_FrictMat_FrictMat_FrictPhys()])
	refusedByAll(r"no Law2 functor for contacts of O.bodies\[2\] \(FrictMat\)")
	know(laws=[wrapper.Law2_ScGeom_FrictPhys_CundallStrack()])
	O.bodies[2].state.pos = (2.999, 1, 1.999 + 0.1)
	goesOn()
	O.run(3, True)
	kinds = {type(i.phys).__name__ for i in O.interactions if i.isReal}
	print(f"contacts afterwards: {kinds}")
	assert kinds == {"IceBondPhys", "FrictPhys"}


@pytest.mark.parametrize("apart", ["masks", "avoided among themselves", "no geometry of theirs"])
def test_bodies_of_another_material_that_ice_bonded_grains_cannot_meet_need_no_functors(apart):
	pair()
	if apart == "no geometry of theirs":
		O.bodies.append(utils.wall(1, axis=2, material=O.materials.append(wrapper.FrictMat())))
	elif apart == "masks":
		addFrictionalSphere(mask=2)
	else:
		O.engines[1].avoidSelfInteractionMask = 1
		addFrictionalSphere(mask=1)
	goesOn()


def broken(change, sample):
	"""A scene of a sample that was spoilt while it was shown."""
	scene = sample.open()
	with talik.inspect(scene):
		change()
	return scene


@pytest.mark.parametrize(
	"change, words",
	[
		(lambda: setattr(O.bodies[3], "material", None), r"O.bodies\[3\] has no material"),
		(lambda: setattr(O.bodies[3], "shape", None), r"O.bodies\[3\] has lost its shape"),
		(lambda: setattr(O.bodies[3].state, "pos", (float("nan"), 0, 0)), r"position of O.bodies\[3\] is not finite"),
		(
			lambda: setattr(O, "engines", [loop([], []) if isinstance(e, wrapper.InteractionLoop) else e for e in O.engines]),
			"no Ip2 functor for contacts of IceBondMat",
		),
		(lambda: setattr(O.bodies[3], "material", wrapper.FrictMat()), r"no Ip2 functor for contacts of O.bodies\[3\] \(FrictMat\)"),
		(lambda: setattr(O.cell, "hSize", Matrix3(0.05, 0, 0, 0, 0.05, 0, 0, 0, 0.012)), "too short for spheres of radius"),
	],
)
def test_a_spoilt_scene_is_refused_as_a_sample(change, words, sample):
	with pytest.raises(ValueError, match=words) as refusal:
		wrapper.OpenRveSample(source=broken(change, sample)).apply(Matrix3(0, 1e-4, 0, 0, 0, 0, 0, 0, 0), 0)
	print(refusal.value)
	result = wrapper.OpenRveSample(source=sample.open()).apply(Matrix3(0, 1e-4, 0, 0, 0, 0, 0, 0, 0), 0)
	assert not result["blewUp"] and np.isfinite(np.array(result["stress"])).all()


def test_scenes_that_stock_yade_runs_are_not_refused(sample):
	"""Clumps (whose container has no material), bodies without shape, a wall of another material beyond reach, empty scenes."""
	talik._talik.refuseToAbort()
	pair()
	O.bodies.append(utils.wall(-5, axis=2, material=O.materials.append(wrapper.FrictMat())))
	O.bodies.appendClumped([utils.sphere((8 + x, 8, 8), 0.5, material=0) for x in (0, 0.5)])
	O.bodies.append(wrapper.Body())
	O.bodies.erase(1)
	goesOn()
	O.reset()
	O.bodies.append([utils.wall(side, axis=2) for side in (-1, 1)])
	O.engines = [wrapper.ForceResetter(), wrapper.InsertionSortCollider([wrapper.Bo1_Wall_Aabb()]), loop(), wrapper.NewtonIntegrator()]  # for grains to come
	goesOn()
	O.reset()
	with talik.inspect(sample.open()):
		at = O.iter
		O.run(3, True)
		assert O.iter == at + 3


# --- disorder that is survived ---------------------------------------------------------------------------------------------


def eraseAndAdd():
	O.run(3, True)
	O.bodies.erase(1)
	O.run(3, True)
	O.bodies.append(utils.sphere((2.999, 1, 1), 1, material=0))


def forgetContact(attribute):
	O.run(3, True)
	setattr(O.interactions[0, 1], attribute, None)


def changeCellWhileRunning():
	O.run()
	for _ in range(5):
		O.cell.velGrad = Matrix3(0, 5, 0, 0, 0, 0, 0, 0, 0)
		O.cell.hSize = Matrix3(11, 0, 0, 0, 11, 0, 0, 0, 11)
	O.pause()
	O.wait()


def skewAndFlip():
	O.cell.flipFlippable = True
	O.cell.velGrad = Matrix3(0, 2e3, 0, 0, 0, 0, 0, 0, 0)
	O.run(100, True)
	O.cell.velGrad = Matrix3.Zero


def order(*places):
	engines = O.engines
	O.engines = [engines[place] for place in places]


@pytest.mark.parametrize(
	"disorder, cell",
	[
		pytest.param(lambda: order(3, 0, 1, 2), None, id="integrator first"),
		pytest.param(lambda: order(0, 2, 1, 3), None, id="contacts before collider"),
		pytest.param(lambda: order(0, 2, 3), None, id="no collider"),
		pytest.param(lambda: order(1, 2, 3), None, id="no resetter"),
		pytest.param(eraseAndAdd, None, id="bodies erased and added"),
		pytest.param(lambda: [O.bodies.erase(id) for id in (0, 1)], None, id="all bodies erased"),
		pytest.param(lambda: forgetContact("phys"), None, id="contact without phys"),
		pytest.param(lambda: forgetContact("geom"), None, id="contact without geom"),
		pytest.param(lambda: periodic(10), None, id="periodic in mid-run"),
		pytest.param(lambda: setattr(O, "periodic", False), 10, id="periodic no more"),
		pytest.param(changeCellWhileRunning, 10, id="cell changed while running"),
		pytest.param(skewAndFlip, 10, id="cell flipped with bonded grains"),
	],
)
def test_ice_bonds_survive_disorder_that_stock_yade_survives(disorder, cell):
	if cell:
		periodic(cell)
	pair()
	O.run(3, True)
	disorder()
	before = O.iter
	O.run(20, True)
	print(f"{O.iter - before} steps afterwards, {len(O.bodies)} bodies, {sum(i.isReal for i in O.interactions)} contacts")
	assert O.iter - before in (20, 21)  # after O.pause() of YADE a step may still be on its way


def test_bodies_on_the_ground_may_be_erased_and_added_between_runs():
	barrier = O.bodies.append(utils.box((0.5, -0.1, 0), (1, 0.1, 1), fixed=True))
	mpm = wrapper.MpmEngine(
		gridSpacing=0.25, lower=(-1, -1), upper=(2, 2), gravity=(0, -9.81), skeleton=wrapper.ElasticSkeleton(), bodies=wrapper.BodyContact()
	)
	talik.geometry.fill(mpm, talik.geometry.rectangle(0, 0, 1, 0.5))
	O.engines = [wrapper.ForceResetter(), mpm, wrapper.NewtonIntegrator(gravity=(0, -9.81, 0))]
	O.run(20, True)
	held = O.forces.f(barrier)[1]
	O.bodies.erase(barrier)
	O.run(20, True)
	O.bodies.append(utils.sphere((0.5, 0.95, 0), 0.2))
	O.run(20, True)
	print(f"force on the barrier {held:.1f} N; {O.iter} steps, ground now at {mpm.field('velocity')[:, 1].mean():.3f} m/s")
	assert O.iter == 60 and held < 0 and np.isfinite(mpm.field("velocity")).all()


def test_a_sample_strained_until_its_cell_is_too_small_for_yade_keeps_its_last_good_state(sample):
	opened = wrapper.OpenRveSample(source=sample.open(), maxStrainPerStep=1e-4, maxInertialNumber=1e9)
	results = [opened.apply(Matrix3(0, 0, 0, 0, 0, 0, 0, 0, -0.2), 0) for _ in range(9)]
	print(f"call {[r['blewUp'] for r in results].index(True)}: {next(r['reason'] for r in results if r['blewUp'])}")
	assert "Body larger than half of the cell size" in results[-1]["reason"] and not results[0]["blewUp"]
	assert np.isfinite(np.array(opened.stress)).all() and not opened.apply(Matrix3.Zero, 0)["blewUp"]
