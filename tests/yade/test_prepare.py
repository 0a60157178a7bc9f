# SPDX-License-Identifier: GPL-2.0-or-later
"""Preparation of samples, measured again with stock YADE's own functions."""

import json
import math
import shutil
import subprocess
from pathlib import Path

import numpy as np
import pytest
from fixtures import sixty, sixtyWithoutIce, thirty
from yade import Matrix3, O, utils, wrapper

from talik import output, packing, plots, rve


def measuredByYade(path):
	"""Porosity, stress and fabric of a saved scene from YADE's own functions."""
	O.load(path)
	area = O.cell.volume / O.cell.hSize[2, 2]
	solid = sum(math.pi * body.shape.radius**2 for body in O.bodies)
	stress = utils.getStress()
	fabric = utils.fabricTensor()[0]
	inPlane = np.array([[fabric[0, 0], fabric[0, 1]], [fabric[1, 0], fabric[1, 1]]])
	principal = np.linalg.eigvalsh(inPlane)
	return 1 - solid / area, stress, principal[1] - principal[0]


def checkPrepared(sample):
	porosity, stress, anisotropy = measuredByYade(sample.path)
	pressure = -0.5 * (stress[0, 0] + stress[1, 1])
	shear = 0.5 * (stress[0, 1] + stress[1, 0])
	print(
		f"\n{sample.grains} grains (seed {sample.parameters['seedUsed']}, compaction friction {sample.parameters['compactionFriction']:.4g}): "
		f"porosity {porosity:.4f} (0.18 +- 0.005), F1-F2 {anisotropy:.4f} (< 0.05), xx {stress[0, 0] / 1e3:.3f}, yy {stress[1, 1] / 1e3:.3f}, "
		f"xy {shear / 1e3:.4f} kPa (|xy| < 1 %), coordination number {sample.coordinationNumber:.3f}"
	)
	assert abs(porosity - 0.18) < 0.005
	assert anisotropy < 0.05
	assert abs(shear) < 0.01 * pressure
	assert abs(stress[0, 0] + 100e3) < 1e3 and abs(stress[1, 1] + 100e3) < 1e3
	np.testing.assert_allclose(sample.stress, (stress[0, 0], stress[1, 1], shear), rtol=1e-9)
	assert abs(sample.porosity - porosity) < 1e-12 and abs(sample.fabric - anisotropy) < 1e-9


def test_prepared_sample_has_the_papers_porosity_isotropic_fabric_and_no_shear_stress(draftSample):
	checkPrepared(draftSample)


def test_the_papers_sample_has_its_porosity_isotropic_fabric_and_no_shear_stress_slow(paperSample):
	checkPrepared(paperSample)


def test_grains_of_the_papers_sample_are_discs_in_a_layer_with_its_radii_slow(paperSample):
	O.load(paperSample.path)
	radii = np.array([body.shape.radius for body in O.bodies])
	assert len(radii) == 400 and radii.min() >= 3e-3 and radii.max() <= 7e-3
	print(f"\nradii {radii.min() * 1e3:.2f} to {radii.max() * 1e3:.2f} mm, mean {radii.mean() * 1e3:.2f} mm (uniform: 5.00 +- {4 / math.sqrt(12 * 400):.2f})")
	assert abs(radii.mean() - 5e-3) < 3 * 4e-3 / math.sqrt(12 * 400)
	for body in O.bodies:
		mass = 2650 * math.pi * body.shape.radius**2 * 0.1
		assert body.state.mass == pytest.approx(mass, rel=1e-12)
		assert body.state.inertia[2] == pytest.approx(0.5 * mass * body.shape.radius**2, rel=1e-12)
		assert set(body.state.blockedDOFs) == set("zXY")
	assert O.cell.hSize[2, 2] == 0.1
	friction = [i.phys.tangensOfFrictionAngle for i in O.interactions if i.isReal]
	np.testing.assert_allclose([*friction, math.tan(O.materials[0].frictionAngle)], 0.5, rtol=1e-14)
	stiffness = [
		(i.phys.ks / i.phys.kn, i.phys.kn / (2 * 0.6e9 * i.geom.refR1 * i.geom.refR2 / (i.geom.refR1 + i.geom.refR2))) for i in O.interactions if i.isReal
	]
	np.testing.assert_allclose(stiffness, np.tile([0.8, 1.0], (len(stiffness), 1)), rtol=1e-12)


def test_the_saved_scene_stays_in_equilibrium_under_yades_own_engines(draftSample):
	O.load(draftSample.path)
	O.run(5000, True)
	change = packing.stress() - np.array(draftSample.stress)
	print(f"\nstress changes by {np.abs(change).max():.3g} Pa of {draftSample.pressure:.6g} Pa in 5000 steps, unbalanced force {utils.unbalancedForce():.1e}")
	assert np.abs(change).max() < 1e-3 * draftSample.pressure
	assert utils.unbalancedForce() < 1e-3


def test_the_users_scene_is_left_alone(tmp_path):
	O.bodies.append(utils.sphere((0, 0, 0), 1))
	O.engines = [wrapper.ForceResetter(), wrapper.NewtonIntegrator(gravity=(0, 0, -10))]
	O.dt = 0.125
	O.run(3, True)
	before = (O.sceneToString(), O.iter, O.time, O.dt)
	rve.prepare(**thirty, cache=tmp_path)  # made, not found
	assert (O.sceneToString(), O.iter, O.time, O.dt) == before
	O.step()
	assert O.iter == 4


def test_a_prepared_sample_is_kept_and_found_again(sampleCache, draftSample, monkeypatch):
	monkeypatch.setattr(rve, "_compacted", lambda *arguments: pytest.fail("made again"))
	assert rve.prepare(grains=100, cache=sampleCache) == draftSample


def test_a_damaged_cache_entry_is_made_anew(sampleCache, tmp_path):
	scene = Path(rve.prepare(**thirty, cache=sampleCache).path)
	shutil.copy(scene, tmp_path)
	sheet = tmp_path / scene.name.replace(".yade.gz", ".json")
	sheet.write_text('{"path": "cut off')
	made = rve.prepare(**thirty, cache=tmp_path)
	assert made.path == str(tmp_path / scene.name) and abs(made.porosity - 0.19) < 0.005
	assert json.loads(sheet.read_text())["path"] == made.path


@pytest.mark.parametrize("stressX, stressY", [(-10e3, -10e3), (-30e3, -45e3), (-1e3, -1.5e3)])
def test_servo_reaches_the_stress_of_a_depth_band(draftSample, sampleCache, stressX, stressY):
	band = rve.servo(draftSample, stressX, stressY, cache=sampleCache)
	porosity, stress, _ = measuredByYade(band.path)
	pressure = -0.5 * (stressX + stressY)
	error = max(abs(stress[0, 0] - stressX), abs(stress[1, 1] - stressY), abs(stress[0, 1])) / pressure
	print(f"\nwanted ({stressX / 1e3:g}, {stressY / 1e3:g}, 0) kPa: error {error:.1e} of the pressure, porosity {porosity:.4f}")
	assert error < 2.5e-3


def test_a_stress_beyond_the_strength_is_refused_with_what_was_reached(draftSample, sampleCache):
	with pytest.raises(packing.PackingError, match="within the strength"):
		rve.servo(draftSample, -10e3, -50e3, cache=sampleCache)


def test_any_periodic_scene_of_spheres_serves(tmp_path):
	O.periodic = True
	O.cell.hSize = Matrix3(0.04, 0, 0, 0, 0.04, 0, 0, 0, 0.1)
	places = (0.005, 0.015, 0.025, 0.035)
	O.bodies.append([utils.sphere((x, y, 0.05), 5.01e-3) for x in places for y in places])
	O.engines = packing.Grains(16, 5e-3, 5e-3, 0.1, 0.6e9, 0.8, 2650.0, 0.2, False, ()).engines()
	O.dt = 1e-6
	O.step()
	path = str(tmp_path / "theirs.yade.bz2")
	O.save(path)
	sample = rve.load(path)
	print(f"\n{sample}")
	assert sample.grains == 16 and sample.thickness == 0.1
	assert sample.porosity == pytest.approx(1 - math.pi * 5.01e-3**2 * 16 / 0.04**2, abs=1e-12)
	assert sample.coordinationNumber == 4


def saved(path):
	O.save(path)
	return path


def test_scenes_that_cannot_serve_are_refused_with_the_reason(tmp_path):
	O.bodies.append(utils.sphere((0, 0, 0), 1))
	with pytest.raises(ValueError, match="no periodic cell"):
		rve.load(saved(str(tmp_path / "open.yade.gz")))
	O.periodic = True
	O.cell.setBox(10, 10, 10)
	O.bodies.append(utils.box((5, 5, 5), (1, 1, 1)))
	with pytest.raises(ValueError, match="shape Box"):
		rve.load(saved(str(tmp_path / "box.yade.gz")))
	O.reset()
	O.periodic = True
	with pytest.raises(ValueError, match="no bodies"):
		rve.load(saved(str(tmp_path / "empty.yade.gz")))
	with pytest.raises(FileNotFoundError, match="does not exist"):
		rve.load(str(tmp_path / "missing.yade.gz"))
	whole = (tmp_path / "empty.yade.gz").read_bytes()
	(tmp_path / "cut.yade.gz").write_bytes(whole[: len(whole) // 2])
	with pytest.raises(ValueError, match="damaged or cut off"):
		rve.load(str(tmp_path / "cut.yade.gz"))


@pytest.mark.parametrize(
	"wrong, name",
	[
		(dict(grains=3), "grains"),
		(dict(grains=100.5), "grains"),
		(dict(radius=(7e-3, 3e-3)), "radius"),
		(dict(radius=5e-3), "radius"),
		(dict(pressure=-1e5), "pressure"),
		(dict(pressure=float("nan")), "pressure"),
		(dict(porosity=0.4), "porosity"),
		(dict(thickness=0.002), "thickness"),  # the smallest radius is 0.003 m
		(dict(young=0), "young"),
		(dict(friction=-0.1), "friction"),
		(dict(seed=-1), "seed"),
		(dict(damping=1.5), "damping"),
		(dict(ice=False, iceYoung=3e9), "ice"),
	],
)
def test_a_wrong_parameter_is_named_before_anything_runs(wrong, name, sampleCache):
	with pytest.raises(ValueError, match=f"^{name} is"):
		rve.prepare(**wrong, cache=sampleCache)


def test_an_unwritable_cache_is_named_with_a_remedy():
	with pytest.raises(RuntimeError, match="XDG_CACHE_HOME"):
		rve.prepare(grains=30, cache="/proc/nowhere")


@pytest.mark.parametrize(
	"ice, material, contact, law",
	[
		(False, "FrictMat", "FrictPhys", "Law2_ScGeom_FrictPhys_CundallStrack"),
		(True, "IceBondMat", "IceBondPhys", "Law2_ScGeom_IceBondPhys_IceBond"),
	],
)
def test_the_saved_scene_holds_the_materials_and_laws_asked_for_without_ice(sampleCache, ice, material, contact, law):
	sample = rve.prepare(**(sixty if ice else sixtyWithoutIce), cache=sampleCache)
	print(f"\nice={ice}: {sample}")
	O.load(sample.path)
	assert type(O.materials[0]).__name__ == material
	assert {type(i.phys).__name__ for i in O.interactions if i.isReal} == {contact}
	assert [type(functor).__name__ for functor in O.engines[2].lawDispatcher.functors] == [law]
	assert abs(sample.porosity - 0.19) < 0.005 and getattr(O.materials[0], "iceSaturation", 0) == 0


def test_attributes_of_the_ice_bond_reach_the_material(sampleCache):
	sample = rve.prepare(**thirty, cache=sampleCache, iceYoung=2e9, iceTensileStrength=30e6)
	O.load(sample.path)
	assert O.materials[0].iceYoung == 2e9 and O.materials[0].iceTensileStrength == 30e6
	with pytest.raises(AttributeError, match="iceYuong"):
		rve.prepare(grains=30, porosity=0.19, cache=sampleCache, iceYuong=2e9)


def test_sample_arrays_give_back_the_stress_and_serve_pictures_and_files(draftSample, tmp_path):
	O.load(draftSample.path)
	arrays = packing.sampleArrays()
	branch = arrays["end"] - arrays["start"]
	normalPart = -(arrays["normalForce"][:, None, None] * arrays["normal"][:, :, None] * branch[:, None, :]).sum(axis=0)
	pressure = -0.5 * np.trace(normalPart) / O.cell.volume
	yade = -0.5 * (utils.getStress()[0, 0] + utils.getStress()[1, 1])
	print(f"\npressure from normal forces and branches {pressure:.6f} Pa, YADE's getStress {yade:.6f} Pa")
	assert pressure == pytest.approx(yade, rel=1e-9)  # shear forces are normal to the branch and add nothing to the trace
	fig = plots.figure(5, 5)
	plots.forceChains(fig.subplots(), arrays["start"], arrays["end"], arrays["normalForce"], arrays["state"], arrays["centre"], arrays["radius"])
	plots.save(fig, tmp_path / "chains.png")
	series = output.SampleSeries(tmp_path)
	series.write()
	assert {p.name for p in tmp_path.iterdir()} >= {"sample.pvd", "sample_grains_00000.vtu", "sample_contacts_00000.vtu"}


def test_progress_and_output_run_as_engines(tmp_path, capsys):
	from talik.progress import Progress

	calls = []
	progress = Progress(endStep=20, interval=0.0)
	O.engines = [output.runner(lambda: calls.append(O.iter), iterPeriod=5), progress.runner(realPeriod=0.0)]
	O.dt = 1e-3
	O.run(20, True)
	progress.close()
	assert calls == [5, 10, 15]
	assert "step 20" in capsys.readouterr().err


def preparedBy(threads, cache):
	"""Numbers of a sample made by another yade with so many threads."""
	script = cache / "prepare.py"
	script.write_text(
		"import sys, json, talik\nfrom talik import rve\n"
		"sample = rve.servo(rve.prepare(grains=40, porosity=0.19, cache=sys.argv[1]), -20e3, -25e3, cache=sys.argv[1])\n"
		"print('MADE', json.dumps([sample.stress, sample.porosity, sample.fabric, sample.size]))\n"
	)
	run = subprocess.run(["yade", "-n", "-x", "-j", str(threads), str(script), str(cache)], capture_output=True, text=True, timeout=300)
	return next(line for line in run.stdout.splitlines() if line.startswith("MADE"))


def test_a_sample_is_the_same_to_the_last_bit_however_many_threads_yade_has_slow(tmp_path):
	caches = [tmp_path / "one", tmp_path / "three"]
	for cache in caches:
		cache.mkdir()
	one, three = preparedBy(1, caches[0]), preparedBy(3, caches[1])
	print(f"\n-j1 {one}\n-j3 {three}")
	assert one == three


def test_two_yades_that_prepare_one_sample_in_one_cache_get_the_same_one(tmp_path):
	script = tmp_path / "prepare.py"
	script.write_text(
		"import sys, time, talik\nfrom talik import rve\n"
		"write = rve.writeWhole\n"
		"def slowly(path, content):\n"
		"\ttime.sleep(0.6)\n"
		"\twrite(path, content)\n"
		"rve.writeWhole = slowly\n"  # the other one meanwhile looks, makes or writes
		"sample = rve.prepare(grains=30, cache=sys.argv[1])\n"
		"print('MADE', sample.porosity, rve._digest(sample.path))\n"
	)
	command = ["yade", "-n", "-x", "-j1", str(script), str(tmp_path / "cache")]
	both = [subprocess.Popen(command, stdout=subprocess.PIPE, stderr=subprocess.STDOUT, text=True) for _ in range(2)]
	said = [one.communicate(timeout=300)[0] for one in both]
	made = [[line for line in text.splitlines() if line.startswith("MADE")] for text in said]
	waited = sum("waiting for the sample" in text for text in said)
	print(f"\n{made}; {waited} of the two waited for the other")
	assert len(made[0]) == 1 and made[0] == made[1], "\n".join(said)


def test_a_serial_run_follows_yades_own_run_to_the_last_bit(draftSample):
	states = []
	for advance in (packing.advance, lambda steps: O.run(steps, True)):
		O.load(draftSample.path)
		O.cell.velGrad = Matrix3(1e-2, 0, 0, 0, -1e-2, 0, 0, 0, 0)
		advance(500)
		states.append(np.array([body.state.pos for body in O.bodies]))
		assert O.iter >= 500
	difference = np.abs(states[0] - states[1]).max()
	print(f"\nlargest difference of positions after 500 steps {difference}")
	assert difference == 0
