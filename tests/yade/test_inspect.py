# SPDX-License-Identifier: GPL-2.0-or-later
"""Looking inside a slope: any sample in O and back with nothing changed, points found by what they suffer, whatever happens meanwhile."""

import time

import numpy as np
import pytest
from yade import Matrix3, O, Vector3, utils, wrapper

import talik
from talik import packing, rve

forms = ("packed", "open")


def same(first, second):
	"""The same C++ object, which Python may hold by several names."""
	return repr(first) == repr(second)


@pytest.fixture(scope="module")
def sample(sampleCache):
	return talik.slope.pack(rve.prepare(grains=40, porosity=0.19, cache=sampleCache))


def thawingGround(sample, form="packed"):
	"""16 points: frozen ground that is sheared until bonds break, and thaws from its surface."""
	mpm = wrapper.MpmEngine(
		gridSpacing=0.5, lower=(0, 0), upper=(1, 2), gravity=(0, -9.81), automaticTimeStep=False,
		skeleton=wrapper.RveSkeleton(samples=[sample.copy()], form=form, strainTolerance=1e-5),
		heat=wrapper.HeatTransfer(thermalTimeScale=3e6), freezing=wrapper.FreezingCurve(),
		boundaries=[
			wrapper.RollerBoundary(region="left"), wrapper.RollerBoundary(region="right"), wrapper.FixedBoundary(region="bottom"),
			wrapper.SurfaceTemperature(region="surface", times=[0, 0.001], values=[-1, 20]),
		],
	)
	position, volume = talik.geometry.fillPolygon([(0, 0), (1, 0), (1, 1), (0, 1)], 0.5)
	shear = np.column_stack([2.0 * position[:, 1] ** 2, 0 * position[:, 1]])
	mpm.addPoints(position=position, volume=volume, porosity=0.4, temperature=-1.0, velocity=shear)
	O.reset()
	O.engines = [mpm]
	O.dt = 2e-4
	return mpm


def running(sample, form="packed", steps=12):
	mpm = thawingGround(sample, form)
	talik._talik.runSerially(steps)
	return mpm


def everything(mpm):
	"""All that a ground and its samples are, as bytes."""
	samples = []
	for id in range(mpm.pointCount):
		former = talik._talik.exchangeScene(mpm.skeleton.scene(id))
		samples.append(O.sceneToString())
		talik._talik.exchangeScene(former)
	return [np.array(mpm.field(name)).tobytes() for name in mpm.fieldNames()] + samples


def bonds(state):
	return sum(getattr(i.phys, "bondState", 0) == state for i in O.interactions if i.isReal)


def handle():
	"""What a curious user does to a sample: strains it, breaks bonds, throws grains out."""
	O.cell.velGrad = Matrix3(0, 0.5, 0, 0, 0, 0, 0, 0, 0)
	O.run(100, True)
	for i in list(O.interactions)[:20]:
		if i.isReal:
			i.phys.bondState = 2
	O.bodies[0].state.vel = Vector3(1, 2, 0)
	O.bodies.erase(3)
	O.run(20, True)


# --- there and back --------------------------------------------------------------------------------------------------------


@pytest.mark.parametrize("form", forms)
def test_the_sample_of_a_point_is_what_O_and_yades_utilities_act_on(form, sample):
	mpm = running(sample, form)
	ground, id = O._sceneObj, mpm.mostBroken(1)[0]
	with mpm.inspect(id) as scene:
		assert same(O._sceneObj, scene)
		stress = utils.getStress()
		shown = dict(bodies=len(O.bodies), intact=bonds(1), contacts=sum(1 for i in O.interactions if i.isReal), engines=[type(e).__name__ for e in O.engines])
		assert O.periodic
		O.step()
	point = mpm.field("skeleton0.sampleStress")[id]
	deviation = abs(stress[0, 0] - point[0]) / np.abs(point).max()
	print(f"\n{form}, point {id}: {shown}, stress xx {stress[0, 0]:.1f} Pa, at the point {point[0]:.1f} Pa")
	assert same(O._sceneObj, ground) and type(O.engines[0]).__name__ == "MpmEngine"
	assert shown["bodies"] == 40 and shown["intact"] == mpm.field("bondsIntact")[id] and shown["contacts"] == mpm.field("contacts")[id]
	assert "NewtonIntegrator" in shown["engines"]
	assert deviation < 1e-2  # an opened packed sample shows the forces at its present positions, one DEM step later


@pytest.mark.parametrize("form", ["packed"])
def test_after_a_look_the_ground_is_the_same_and_goes_on_bit_for_bit(form, sample):
	mpm = running(sample, form)
	talik._talik.runSerially(8)
	unseen = everything(mpm)
	mpm = running(sample, form)
	before, saved, clock = everything(mpm), O.sceneToString(), (O.iter, O.time, O.dt)
	with mpm.inspect(5):
		handle()
	mpm.inspect(6)
	handle()
	mpm.back()
	assert everything(mpm) == before and O.sceneToString() == saved and (O.iter, O.time, O.dt) == clock
	talik._talik.runSerially(8)
	print(f"\n{form}: {len(saved)} bytes of scene equal after two looks, {sum(map(len, unseen))} bytes of state equal 8 steps later")
	assert everything(mpm) == unseen


@pytest.mark.parametrize("form", ["packed"])
def test_a_live_look_that_does_nothing_changes_nothing(form, sample):
	mpm = running(sample, form)
	talik._talik.runSerially(4)
	unseen = everything(mpm)
	mpm = running(sample, form)
	saved = O.sceneToString()
	with mpm.inspect(5, live=True):
		bonds(1), utils.getStress(), packing.sampleArrays()
	assert O.sceneToString() == saved
	talik._talik.runSerially(4)
	assert everything(mpm) == unseen


def test_a_live_sample_that_can_be_one_no_more_stays_shown_until_it_is_given_up(sample):
	mpm = running(sample)
	before = everything(mpm)
	ground = O._sceneObj
	mpm.inspect(5, live=True)
	O.engines = O.engines + [wrapper.PyRunner(command="pass", iterPeriod=10)]
	with pytest.raises(ValueError, match="it has a PyRunner"):
		mpm.back()
	assert not same(O._sceneObj, ground)
	mpm.back(keep=False)
	assert same(O._sceneObj, ground) and everything(mpm) == before
	with pytest.raises(ValueError, match="out of the plane"):
		with mpm.inspect(5, live=True):
			O.bodies[0].state.blockedDOFs = ""
	assert same(O._sceneObj, ground) and everything(mpm) == before


def test_a_block_that_fails_leaves_a_live_sample_as_it_was(sample):
	mpm = running(sample)
	before = everything(mpm)
	with pytest.raises(ZeroDivisionError):
		with mpm.inspect(5, live=True):
			handle()
			1 / 0
	assert everything(mpm) == before


# --- whatever happens meanwhile --------------------------------------------------------------------------------------------


def test_views_nest_and_closing_one_closes_those_inside(sample):
	mpm = running(sample)
	before, ground = everything(mpm), O._sceneObj
	outer = mpm.inspect(1)
	first = O._sceneObj
	with mpm.inspect(2):
		assert not same(O._sceneObj, first)
		with talik.scratchScene():
			assert len(O.bodies) == 0
	assert same(O._sceneObj, first)
	inner = mpm.inspect(3, live=True)
	with pytest.raises(RuntimeError, match="point 3 is shown live already"):
		mpm.inspect(3, live=True)
	outer.back()
	assert same(O._sceneObj, ground) and "left" in repr(inner)
	with pytest.raises(RuntimeError, match="shows no sample"):
		mpm.back()
	with pytest.raises(RuntimeError, match="left already"):
		inner.back()
	assert everything(mpm) == before


def test_a_look_while_O_runs_is_refused_and_the_run_goes_on(sample):
	mpm = thawingGround(sample)
	O.run()
	with pytest.raises(RuntimeError, match=r"O.pause\(\)"):
		mpm.inspect(3)
	at = O.iter
	while O.iter < at + 3:
		time.sleep(0.001)
	O.pause()
	O.wait()
	with mpm.inspect(3):
		assert len(O.bodies) == 40
	print(f"\nrefused at step {at}, {O.iter} steps done")


def test_a_run_meanwhile_is_the_samples_and_not_the_grounds(sample):
	mpm = running(sample)
	before, clock = everything(mpm), (O.iter, O.time, mpm.time)
	with mpm.inspect(3):
		at, dt = O.iter, O.dt
		O.run(50, True)
		assert O.iter == at + 50
		assert O.dt == dt
		O.run()  # in the background, still running when the block ends
		time.sleep(0.05)
	assert not O.running and (O.iter, O.time, mpm.time) == clock and everything(mpm) == before
	O.step()
	assert mpm.time > clock[2]


def test_reset_meanwhile_takes_the_sample_only(sample):
	mpm = running(sample)
	before = everything(mpm)
	mpm.inspect(3)
	O.reset()
	assert len(O.bodies) == 0
	mpm.back()
	assert everything(mpm) == before and O.iter == 12
	O.step()


@pytest.mark.parametrize("live", [False, True])
def test_a_scene_loaded_meanwhile_takes_the_samples_place_only(live, sample, tmp_path):
	mpm = running(sample)
	before = everything(mpm)
	with mpm.inspect(3, live=live):
		O.save(str(tmp_path / "sample.yade.gz"))
		O.load(str(tmp_path / "sample.yade.gz"))
		assert len(O.bodies) == 40
		O.run(5, True)
		O.saveTmp()
		O.loadTmp()
	assert everything(mpm) == before and O.iter == 12
	O.step()


def test_other_scenes_of_O_meanwhile_do_no_harm(sample):
	mpm = running(sample)
	before = everything(mpm)
	mpm.inspect(3)
	O.switchToScene(O.addScene())
	assert len(O.bodies) == 0
	mpm.back()
	assert same(O.engines[0], mpm) and everything(mpm) == before
	O.step()


@pytest.mark.parametrize("form, how", [("packed", ".xml"), ("packed", ".yade.gz"), ("open", ".yade.gz")])
def test_samples_of_a_loaded_ground_are_shown_as_well(form, how, sample, tmp_path):
	mpm = running(sample, form)
	intact = mpm.field("bondsIntact")
	O.save(str(tmp_path / ("ground" + how)))
	O.reset()
	O.load(str(tmp_path / ("ground" + how)))
	loaded = O.engines[0]
	with loaded.inspect(5):
		assert len(O.bodies) == 40 and bonds(1) == intact[5]
	assert same(O.engines[0], loaded)
	O.step()


def test_points_without_a_sample_are_refused_by_name(sample):
	mpm = running(sample)
	with pytest.raises(ValueError, match="no point 16; ids run from 0 to 15"):
		mpm.inspect(16)
	elastic = wrapper.MpmEngine(gridSpacing=0.5, skeletons=[wrapper.ElasticSkeleton(), wrapper.RveSkeleton(samples=[sample.copy()])])
	elastic.addPoints(position=[(0.25, 0.25), (0.75, 0.25)], volume=0.25, skeleton=[0, 1])
	O.reset()
	O.engines = [elastic]
	with pytest.raises(ValueError, match="point 0 has no sample"):
		elastic.inspect(0)
	with elastic.inspect(1):
		assert len(O.bodies) == 40


# --- points by what they suffer --------------------------------------------------------------------------------------------


def test_points_are_found_by_place_and_by_what_they_suffer(sample):
	mpm = running(sample)
	position, broken, strain = mpm.field("position"), mpm.field("bondsBroken"), mpm.field("deviatoricStrain")
	for id in range(mpm.pointCount):
		assert mpm.pick(*position[id]) == id
	assert mpm.pick(100, 100) == np.argmin(np.linalg.norm(position - 100, axis=1))
	found = mpm.mostBroken(4)
	print(f"\nmost broken {found} with {broken[found]}, most strained {mpm.mostStrained(3)} with {strain[mpm.mostStrained(3)].round(5)}")
	assert found == sorted(range(16), key=lambda id: (-broken[id], id))[:4]
	assert mpm.mostStrained(16) == list(np.argsort(-strain, kind="stable"))
	speeds = np.linalg.norm(mpm.field("velocity"), axis=1)
	assert mpm.most("velocity", 1) == [np.argmax(speeds)] and len(mpm.most("velocity", 99)) == 16 and mpm.mostBroken(0) == []
	with pytest.raises(ValueError, match="n is -1"):
		mpm.mostBroken(-1)
	with pytest.raises(ValueError):
		mpm.pick(float("nan"), 0)
