# SPDX-License-Identifier: GPL-2.0-or-later
"""Packed and open form of one sample: the same state to the last bit, and the same path under stock YADE's own engines."""


import numpy as np
import pytest
from fixtures import sixty, sixtyWithoutIce
from yade import Matrix3, O, Vector3, utils, wrapper

import talik
from talik import packing, rve

loading = Matrix3(0.2, 1, 0, -0.4, -0.5, 0, 0, 0, 0)  # stretch, shear and spin at once, times a strain


def relative(a, b):
	"""Largest difference of two arrays over the largest number in them."""
	a, b = np.asarray(a), np.asarray(b)
	return np.abs(a - b).max() / max(np.abs(a).max(), 1e-300)


@pytest.fixture(scope="module")
def frictional(sampleCache):
	return rve.pack(rve.prepare(**sixtyWithoutIce, cache=sampleCache))


@pytest.fixture(scope="module")
def icy(sampleCache):
	"""Grains that can carry ice, with bonds weak enough to break early; without ice yet."""
	strong = rve.pack(rve.prepare(**sixty, cache=sampleCache))
	with talik.inspect(strong.open()):
		O.materials[0].iceTensileStrength = O.materials[0].iceShearStrength = 2e6
		O.materials[0].tensileStrength = O.materials[0].shearStrength = 1e5
		return wrapper.RveSample.fromScene(O._sceneObj)


def states(frictional, icy):
	"""Samples in all kinds of states, by name."""
	moved = frictional.copy()
	moved.advance(0.3 * loading, 137)
	pending = moved.copy()
	pending.advance(-0.2 * loading, 0)
	flipped = frictional.copy()
	flipped.apply(Matrix3(0, 0.7, 0, 0, 0, 0, 0, 0, 0), 0)
	flipped.advance(Matrix3.Zero, 4000)  # in flow, contacts turn too fast for YADE's linearised rotation of shear forces
	bonded = icy.copy()
	bonded.freeze(1)
	bonded.advance(0.3 * loading, 137)
	broken = bonded.copy()
	broken.apply(1e-2 * loading, 0.8)
	melted = broken.copy()
	melted.apply(1e-4 * loading, 0)
	refrozen = melted.copy()
	refrozen.apply(1e-4 * loading, 0.6)
	for packed in (broken, melted, refrozen):
		packed.advance(Matrix3.Zero, 1000)
	return dict(prepared=frictional, moved=moved, pending=pending, flipped=flipped, iceFree=icy, bonded=bonded, broken=broken, melted=melted, refrozen=refrozen)


def bondSummary(packed):
	s = packed.statistics()
	return ", ".join(f"{s[name]} {name}" for name in ("contacts", "bondsIntact", "bondsBroken", "bondsBrokenInTension", "bondsBrokenInShear", "bondsMelted"))


def test_packed_to_open_to_packed_is_the_identity_bit_for_bit(frictional, icy):
	for name, packed in states(frictional, icy).items():
		before = packed.stateBytes
		again = packed.copy()
		again.repack(packed.open())
		print(f"\n{name}: {len(before)} bytes, {sum(a != b for a, b in zip(before, again.stateBytes))} differ; {bondSummary(packed)}", end="")
		assert again.stateBytes == before


def test_a_scene_saved_by_yade_packs_as_the_open_scene_does(icy, tmp_path):
	packed = states(icy, icy)["broken"]
	with talik.inspect(packed.open()):
		O.save(str(tmp_path / "sample.yade.gz"))
	with talik.scratchScene():
		rve.openFile(str(tmp_path / "sample.yade.gz"))
		again = packed.copy()
		again.repack(O._sceneObj)
	before = packed.copy()
	for s in (before, again):
		s.advance(loading, 1)  # YADE does not save the cell's size of the step before, which only the last step used
	assert again.stateBytes == before.stateBytes


def mechanics(scene):
	"""Positions, velocities, spins, contact forces (by pair), stress of a scene, from YADE's own objects."""
	with talik.inspect(scene):
		forces = {(i.id1, i.id2): np.array(i.phys.normalForce + i.phys.shearForce) for i in O.interactions if i.isReal}
		lightest = min(O.bodies, key=lambda b: b.state.mass)
		kick = max(np.linalg.norm(f) for f in forces.values()) * O.dt / lightest.state.mass
		return dict(
			position=np.array([b.state.pos for b in O.bodies]),
			velocity=np.array([b.state.vel for b in O.bodies]),
			spin=np.array([b.state.angVel[2] for b in O.bodies]),
			force=np.array([forces[pair] for pair in sorted(forces)]),
			stress=np.array(utils.getStress()),
			kick=kick,  # what the largest contact force gives the lightest grain in one step [m/s]
			turn=2 * kick / lightest.shape.radius,
		)


def differences(a, b):
	"""Of two mechanical states, in units of the largest position, force and stress; velocities in units of what forces give in a step
	where grains move slower than that."""
	scale = dict(velocity=max(np.abs(a["velocity"]).max(), a["kick"]), spin=max(np.abs(a["spin"]).max(), a["turn"]))
	return {key: np.abs(a[key] - b[key]).max() / scale.get(key, np.abs(a[key]).max()) for key in ("position", "velocity", "spin", "force", "stress")}


def runByYade(scene, velGrad, steps):
	with talik.inspect(scene):
		O.cell.velGrad = velGrad
		packing.advance(steps)
	return scene


def listed(errors):
	return ", ".join(f"{key} {error:.1e}" for key, error in errors.items())


def test_open_to_packed_to_open_keeps_the_mechanical_state(frictional, icy):
	for name, packed in states(frictional, icy).items():
		scene = runByYade(packed.open(), 0.03 * loading, 50)  # stock YADE leaves parts of shear forces along the normal
		again = wrapper.RveSample.fromScene(scene).open()
		motion = {key: error for key, error in differences(mechanics(scene), mechanics(again)).items() if key in ("position", "velocity", "spin")}
		for s in (scene, again):
			runByYade(s, 0.03 * loading, 1)
		errors = differences(mechanics(scene), mechanics(again))
		print(f"\n{name}: {listed(motion)}; a step later {listed(errors)}", end="")
		assert max(motion.values()) == 0
		assert max(errors.values()) < 1e-11


@pytest.mark.parametrize("steps, tolerance", [(1, 1e-11), (500, 1e-8)])
def test_opened_mid_run_stock_engines_reproduce_the_packed_step(frictional, icy, steps, tolerance):
	for name, packed in states(frictional, icy).items():
		velGrad = 0.05 * loading
		packed = packed.copy()
		packed.advance(velGrad, 2)  # now in force
		scene = packed.open()
		packed.advance(velGrad, steps)
		runByYade(scene, velGrad, steps)
		yade, arrays, stress = mechanics(scene), packed.arrays(), packed.stress
		errors = dict(
			position=relative(yade["position"][:, :2], arrays["position"]),
			stress=relative((yade["stress"][0, 0], yade["stress"][1, 1], 0.5 * (yade["stress"][0, 1] + yade["stress"][1, 0])), stress),
		)
		# forces are those of the step to come: both forms take it under stock engines, from where they are
		further = differences(*(mechanics(runByYade(s, velGrad, 1)) for s in (scene, packed.open())))
		print(f"\n{name} after {steps}: {listed(errors)}; a step later {listed(further)}; {bondSummary(packed)}", end="")
		assert max([*errors.values(), *further.values()]) < tolerance


def test_bonds_form_break_melt_and_form_again_alike_in_both_forms(icy):
	packed = icy.copy()
	settings = dict(minSteps=300, maxStrainPerStep=1.0, maxInertialNumber=1e9, timeStepFollowsIce=False)  # the same steps in both
	for name, value in settings.items():
		setattr(packed, name, value)
	seen = dict(bondsBroken=0, bondsMelted=0, bondsFormed=0)
	for strain, saturation in ((0, 1), (2e-3, 1), (6e-3, 1), (1e-3, 0.5), (1e-3, 0.03), (1e-3, 0), (1e-3, 0.04), (1e-3, 0.06), (2e-3, 0.9)):
		opened = wrapper.OpenRveSample(source=packed.open(), **settings)
		before = packed.statistics()
		byPacked, byYade = packed.apply(strain * loading, saturation), opened.apply(strain * loading, saturation)
		stress = byYade["stress"]
		error = relative(byPacked["stress"], (stress[0, 0], stress[1, 1], stress[0, 1]))
		one, other = packed.statistics(), opened.statistics()
		lost = one["bondsBrokenInTension"] + one["bondsBrokenInShear"] - before["bondsBrokenInTension"] - before["bondsBrokenInShear"]
		melted = one["bondsMelted"] - before["bondsMelted"]
		print(
			f"\nstrain {strain:g} at S_i {saturation:g}: {byPacked['steps']} steps, {lost} / {other['bondsBroken']} broken, {melted} / {other['bondsMelted']} melted, "
			f"{one['bondsIntact']} / {other['bondsIntact']} intact, {one['contacts']} / {other['contacts']} contacts, stress differs by {error:.1e}",
			end="",
		)
		assert byPacked["steps"] == byYade["steps"] and not byPacked["blewUp"] and not byYade["blewUp"]
		assert (lost, melted, one["bondsIntact"], one["contacts"]) == (other["bondsBroken"], other["bondsMelted"], other["bondsIntact"], other["contacts"])
		assert error < 1e-8
		assert np.abs(np.array(packed.trsf) - np.array(opened.trsf)).max() < 1e-14
		for key in seen:
			seen[key] += other[key] if key != "bondsFormed" else other[key] - before["bondsIntact"]
	print(f"\nin all {seen}")
	assert min(seen.values()) > 20  # enough happened


def test_freezing_by_hand_in_yade_bonds_the_same_pairs_as_the_packed_form(icy):
	packed, scene = icy.copy(), icy.open()
	packed.freeze(0.06)
	with talik.inspect(scene):
		loop = next(e for e in O.engines if isinstance(e, wrapper.InteractionLoop))
		collider = next(e for e in O.engines if isinstance(e, wrapper.InsertionSortCollider))
		ig2, ip2, bo1 = loop.geomDispatcher.functors[0], loop.physDispatcher.functors[0], collider.boundDispatcher.functors[0]
		reach = 1 + 0.5 * O.materials[0].bondRange + 1e-6
		ig2.interactionDetectionFactor = bo1.aabbEnlargeFactor = reach
		ip2.bondNewContacts = True
		O.materials[0].iceSaturation = 0.06
		packing.advance(1)
		ig2.interactionDetectionFactor = bo1.aabbEnlargeFactor = 1
		ip2.bondNewContacts = False
		bonds = {(i.id1, i.id2) for i in O.interactions if i.isReal and i.phys.bondState == 1}
	arrays = packed.arrays()
	byPacked = {(int(a), int(b)) for (a, b), bond in zip(arrays["contact"], arrays["bond"]) if bond == 1}
	print(f"\n{len(byPacked)} bonds of the packed form, {len(bonds)} by hand, {len(byPacked ^ bonds)} differ")
	assert byPacked == bonds and len(bonds) > icy.statistics()["contacts"]


def otherLaw():
	O.engines[2].lawDispatcher.functors = [wrapper.Law2_ScGeom_FrictPhys_CundallStrack(), wrapper.Law2_ScGeom_IceBondPhys_IceBond()]


def set_(object, **attributes):
	for name, value in attributes.items():
		setattr(object, name, value)


@pytest.mark.parametrize(
	"change, reason",
	[
		(lambda: set_(O, periodic=False), "no periodic cell"),
		(lambda: set_(O.bodies[3].state, blockedDOFs="xyzXYZ"), "body 3 is held in the plane"),
		(lambda: set_(O.bodies[3].state, blockedDOFs=""), "body 3 is free to move out of the plane"),
		(lambda: set_(O.bodies[3].state, isDamped=False), "body 3 is exempt from damping"),
		(lambda: set_(O.bodies[3].state, pos=O.bodies[3].state.pos + Vector3(0, 0, 1e-3)), "one layer"),
		(lambda: set_(O.bodies[3], material=wrapper.FrictMat()), "several materials"),
		(otherLaw, "law is not a single one"),
		(lambda: set_(O.engines[2].geomDispatcher.functors[0], avoidGranularRatcheting=False), "avoidGranularRatcheting"),
		(lambda: set_(O.engines[3], gravity=(0, -9.81, 0)), "gravity"),
		(lambda: set_(O, engines=O.engines + [wrapper.PeriTriaxController()]), "PeriTriaxController"),
		(lambda: set_(O.cell, homoDeform=1), "homoDeform"),
		(lambda: set_(next(iter(O.interactions)).phys, tangensOfFrictionAngle=0.1), "friction 0.1"),
		(lambda: set_(next(iter(O.interactions)).phys, kn=1e6), "stiffness"),
	],
)
def test_a_scene_that_the_packed_form_does_not_cover_is_refused_with_the_reason(frictional, change, reason):
	with talik.inspect(frictional.open()):
		wrapper.RveSample.fromScene(O._sceneObj)
		change()
		with pytest.raises(ValueError, match=reason) as refusal:
			wrapper.RveSample.fromScene(O._sceneObj)
		print(f"\n{refusal.value}")


def otherRadii(rule):
	O.engines = O.engines[:1] + [wrapper.GrainSwelling(porosity=0.19, radiusRule=rule)] + O.engines[1:]


openOptions = {
	"heals broken bonds": lambda: set_(lawOfBonds(), healBroken=True),
	"it has a GrainSwelling": lambda: otherRadii("referenceOverlap"),
	"has a GrainSwelling": lambda: otherRadii("mechanical"),
	"bondNewContacts": lambda: set_(O.engines[2].physDispatcher.functors[0], bondNewContacts=True),
}


def lawOfBonds():
	return O.engines[2].lawDispatcher.functors[0]


@pytest.mark.parametrize("reason", openOptions)
def test_options_of_the_ice_bond_that_only_open_samples_have_keep_the_sample_open_and_the_user_is_told_once(icy, reason, capfd):
	scene = icy.open()
	with talik.inspect(scene):
		openOptions[reason]()
	with pytest.raises(ValueError, match=reason):
		wrapper.RveSample.fromScene(scene)
	skeleton = wrapper.RveSkeleton(scenes=[scene], strainTolerance=0)
	mpm = wrapper.MpmEngine(gridSpacing=0.5, lower=(0, 0), upper=(0.5, 0.5), skeleton=skeleton, automaticTimeStep=False)
	mpm.addPoints(position=[(0.25, 0.25)], volume=[0.25], porosity=0.4, velocity=[(0.01, 0)])
	mpm.boundaries = [wrapper.RollerBoundary(region=side) for side in ("left", "right", "bottom", "top")]
	O.engines = [mpm]
	O.dt = 1e-4
	for _ in range(3):
		O.step()
	told = [line for line in capfd.readouterr().err.splitlines() if line.startswith("RveSkeleton:")]
	print(f"\n{told}; {skeleton.cost()['steps']} steps")
	assert len(told) == 1 and reason in told[0] and "run open" in told[0]
	assert skeleton.cost()["form"] == "open" and np.abs(mpm.field("stress")).max() > 0
