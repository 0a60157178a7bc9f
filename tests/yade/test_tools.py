# SPDX-License-Identifier: GPL-2.0-or-later
"""YADE's own tools around our engine: recorders, PyRunner, plot, stopping, saving, timing, pictures, utils, labels, inspector, batches.

What needs a display, or would end the interpreter, runs in a yade of its own."""

import os
import re
import subprocess
from pathlib import Path

import numpy as np
import pytest
from yade import O, plot, timing, utils, wrapper

import talik

g = 9.81


@pytest.fixture
def scene():
	"""A block of ground sinks onto a footing of YADE that is held; gives the engine and the body's id."""
	material = O.materials.append(wrapper.FrictMat(frictionAngle=0.5, density=2500))
	footing = O.bodies.append(utils.box((0.3, -0.1, 0), (0.6, 0.1, 0.5), fixed=True, material=material))
	mpm = wrapper.MpmEngine(
		gridSpacing=0.1,
		lower=(-1, -1),
		upper=(2, 2),
		gravity=(0, -g),
		damping=0.3,
		bodies=wrapper.BodyContact(),
		skeleton=wrapper.ElasticSkeleton(young=1e6),
		label="ground",
	)
	talik.geometry.fill(mpm, talik.geometry.rectangle(0, 0.0, 0.6, 0.3))
	O.engines = [wrapper.ForceResetter(), mpm, wrapper.NewtonIntegrator(damping=0, gravity=(0, -g, 0), label="newton")]
	return mpm, footing


# --- engines beside ours -----------------------------------------------------------------------------------------------------


def test_force_and_torque_recorders_write_what_the_ground_does_to_a_body(scene, tmp_path):
	_, footing = scene
	forces = wrapper.ForceRecorder(ids=[footing], file=str(tmp_path / "force.txt"), iterPeriod=1)
	torques = wrapper.TorqueRecorder(ids=[footing], file=str(tmp_path / "torque.txt"), iterPeriod=1, rotationAxis=(0, 0, 1), zeroPoint=(0, 0, 0))
	O.engines = O.engines + [forces, torques]  # after the integrator, which has summed the forces up, as recorders stand in any scene of YADE
	byHand = []
	for _ in range(200):
		O.step()
		force, torque = np.array(O.forces.f(footing)), O.forces.t(footing)[2]
		arm = np.array(O.bodies[footing].state.pos)
		byHand.append([*force, torque - (arm[0] * force[1] - arm[1] * force[0])])  # YADE's arm axis x (axis x r) is -r
	forces.dead = torques.dead = True
	O.engines = O.engines[:3]
	recorded = np.column_stack([np.loadtxt(tmp_path / "force.txt")[:, 1:4], np.loadtxt(tmp_path / "torque.txt")[:, 1]])
	byHand = np.array(byHand)[-len(recorded) :]
	print(f"{len(recorded)} rows; vertical force {recorded[-1, 1]:.3f} N, torque {recorded[-1, 3]:.3f} N m")
	assert len(recorded) >= 199 and byHand[-1, 1] < 0
	np.testing.assert_allclose(recorded, byHand, rtol=1e-4, atol=1e-4 * np.abs(byHand).max())


def test_a_pyrunner_reads_fields_and_changes_settings_between_steps(scene):
	mpm, _ = scene
	seen = []

	def look():
		seen.append((O.iter, mpm.field("velocity")[:, 1].min()))
		mpm.damping = 0.6

	O.engines = O.engines + [talik.output.runner(look, iterPeriod=5)]
	O.run(21, True)
	print(f"{len(seen)} looks, at steps {[iter for iter, _ in seen]}")
	assert [iter for iter, _ in seen] == [5, 10, 15, 20] and mpm.damping == 0.6 and all(v < 0 for _, v in seen)


def test_plot_records_our_fields_and_draws_them(scene, tmp_path):
	from matplotlib import pyplot

	mpm, footing = scene
	pyplot.switch_backend("Agg")
	plot.reset()
	plot.plots = {"t": ("load", None, "sink")}
	for _ in range(10):
		O.run(5, True)
		plot.addData(t=O.time, load=-O.forces.f(footing)[1], sink=-mpm.field("displacement")[:, 1].min())
	figure = plot.plot(noShow=True)
	figure.savefig(tmp_path / "plot.png")
	drawn = [line.get_ydata() for axes in figure.axes for line in axes.get_lines() if len(line.get_ydata()) == 10]
	print(
		f"{len(plot.data['t'])} rows; last load {plot.data['load'][-1]:.1f} N, sunk by {plot.data['sink'][-1]:.2e} m; "
		f"{(tmp_path / 'plot.png').stat().st_size} bytes of picture"
	)
	assert sorted(map(tuple, drawn)) == sorted([tuple(plot.data["load"]), tuple(plot.data["sink"])])
	assert plot.data["sink"][-1] > 0 and (tmp_path / "plot.png").stat().st_size > 5000
	plot.reset()
	pyplot.close("all")


# --- running ---------------------------------------------------------------------------------------------------------------


def test_stop_at_iter_stops_the_ground_there(scene):
	mpm, _ = scene
	O.stopAtIter = 17
	O.run()
	O.wait()
	reached = O.iter, mpm.time - O.time
	O.stopAtIter = 20
	O.run()
	O.wait()
	print(f"stopped at {reached[0]} and {O.iter}, the time of the ground is O.time within {abs(reached[1]):.0e} s")
	assert reached[0] == 17 and O.iter == 20 and abs(mpm.time - O.time) < 1e-12


def test_save_and_load_take_ground_bodies_recorders_and_labels_along(scene, tmp_path):
	mpm, footing = scene
	O.engines = O.engines + [wrapper.ForceRecorder(ids=[footing], file=str(tmp_path / "force.txt"), iterPeriod=10)]
	O.run(50, True)
	O.save(str(tmp_path / "scene.yade.gz"))
	O.run(50, True)
	through = mpm.field("position"), np.array(O.forces.f(footing))
	O.reset()
	O.load(str(tmp_path / "scene.yade.gz"))
	loaded = O.engines[1]
	O.run(50, True)
	difference = np.abs(loaded.field("position") - through[0]).max()
	print(f"50 steps after loading: positions differ by {difference}, the force on the body by {np.abs(np.array(O.forces.f(footing)) - through[1]).max()}")
	assert difference == 0 and (np.array(O.forces.f(footing)) == through[1]).all()
	assert loaded.label == "ground" and type(O.engines[3]) is wrapper.ForceRecorder


def test_timing_counts_our_engine_in_every_step(scene, capsys):
	O.timingEnabled = True
	timing.reset()
	try:
		O.run(30, True)
		count, nanoseconds = O.engines[1].execCount, O.engines[1].execTime
		timing.stats()
	finally:
		O.timingEnabled = False
	table = capsys.readouterr().out
	(row,) = [line for line in table.splitlines() if '"ground"' in line]
	print(row)
	assert count == 30 and nanoseconds > 0
	assert "30" in row and re.search(r"\d+(\.\d+)?%", row)


def test_labels_name_our_engine_our_functors_and_survive_loading(scene, tmp_path):
	import builtins

	mpm, _ = scene
	assert talik._talik.sameObject(builtins.ground, mpm)
	O.engines = O.engines + [
		wrapper.InteractionLoop(
			[wrapper.Ig2_Sphere_Sphere_ScGeom()],
			[wrapper.Ip2_IceBondMat_IceBondMat_IceBondPhys(label="iceContacts")],
			[wrapper.Law2_ScGeom_IceBondPhys_IceBond(label="iceLaw")],
		)
	]
	builtins.iceLaw.healBroken = True
	O.step()
	O.save(str(tmp_path / "scene.xml"))
	O.reset()
	O.load(str(tmp_path / "scene.xml"))
	print(
		f"after loading: ground is {type(builtins.ground).__name__}, iceLaw {type(builtins.iceLaw).__name__}, iceContacts {type(builtins.iceContacts).__name__}"
	)
	assert builtins.ground.pointCount == mpm.pointCount and talik._talik.sameObject(builtins.ground, O.engines[1])
	assert type(builtins.iceLaw) is wrapper.Law2_ScGeom_IceBondPhys_IceBond and builtins.iceLaw.healBroken


def test_utilities_measure_ice_bonds_and_bodies_among_the_ground(scene):
	mpm, footing = scene
	ice = O.materials.append(wrapper.IceBondMat(young=1e7, poisson=0.5, density=1000, iceSaturation=1))
	first = O.bodies.append([utils.sphere((x, 1.5, 0), 0.1, material=ice) for x in (0.0, 0.1999, 0.3998)])
	O.bodies[first[0]].state.vel = (0.3, 0, 0)
	loop = wrapper.InteractionLoop(
		[wrapper.Ig2_Sphere_Sphere_ScGeom()], [wrapper.Ip2_IceBondMat_IceBondMat_IceBondPhys(bondNewContacts=True)], [wrapper.Law2_ScGeom_IceBondPhys_IceBond()]
	)
	O.engines = [O.engines[0], wrapper.InsertionSortCollider([wrapper.Bo1_Sphere_Aabb(), wrapper.Bo1_Box_Aabb()]), loop] + O.engines[1:]
	mpm.automaticTimeStep, O.dt = False, 2e-5  # that of the grains
	O.run(300, True)
	bodies = [O.bodies[id] for id in first]
	energy = sum(0.5 * b.state.mass * b.state.vel.squaredNorm() + 0.5 * np.dot(b.state.inertia, np.square(b.state.angVel)) for b in bodies)
	bonded = [i for i in O.interactions if i.isReal]
	springs = sum(0.5 * (i.phys.normalForce.squaredNorm() / i.phys.kn + i.phys.shearForce.squaredNorm() / i.phys.ks) for i in bonded)
	print(
		f"kineticEnergy {utils.kineticEnergy():.6f} J, by hand {energy:.6f} J; avgNumInteractions {utils.avgNumInteractions():.3f}; "
		f"sumForces on the footing {utils.sumForces([footing], (0, 1, 0)):.3f} N; energy in {len(bonded)} bonds "
		f"{springs:.2e} J; unbalanced force {utils.unbalancedForce():.3f}"
	)
	assert utils.kineticEnergy() == pytest.approx(energy, rel=1e-12)
	assert len(bonded) == 2 and all(i.phys.bondState == 1 for i in bonded)
	assert utils.avgNumInteractions() == pytest.approx(2 * len(bonded) / len(O.bodies), rel=1e-12)
	assert utils.sumForces([footing], (0, 1, 0)) == pytest.approx(O.forces.f(footing)[1], rel=1e-12) and O.forces.f(footing)[1] < 0
	assert 0 <= utils.unbalancedForce() < 10 and utils.getSpheresMass() == pytest.approx(sum(b.state.mass for b in bodies))


# --- in a yade of its own --------------------------------------------------------------------------------------------------

withDisplay = """
import os, sys, time
from PyQt5.QtWidgets import QApplication
import talik
from yade import O, qt, utils, wrapper

material = O.materials.append(wrapper.FrictMat(density=2500))
O.bodies.append(utils.sphere((0.3, 0.6, 0), 0.2, material=material, color=(0, 0, 1)))
mpm = wrapper.MpmEngine(gridSpacing=0.1, lower=(-1, -1), upper=(2, 2), gravity=(0, -9.81), bodies=wrapper.BodyContact(),
	skeleton=wrapper.ElasticSkeleton(young=1e6), boundaries=[wrapper.FixedBoundary(region="bottom")], heat=wrapper.HeatTransfer(),
	freezing=wrapper.FreezingCurve(), label="ground")
talik.geometry.fill(mpm, talik.geometry.rectangle(0, 0.0, 0.6, 0.3))
O.engines = [wrapper.ForceResetter(), mpm, wrapper.NewtonIntegrator(gravity=(0, -9.81, 0))]
O.run(3, True)

def draw(seconds):
	end = time.monotonic() + seconds
	while time.monotonic() < end:
		QApplication.instance().processEvents()
		time.sleep(0.005)
{body}
print("SCRIPT ENDED")
sys.stdout.flush()
os._exit(0)
"""


def withXvfb(folder, body):
	script = Path(folder) / "script.py"
	script.write_text(withDisplay.format(body=body))
	command = ["xvfb-run", "-a", "-s", "-screen 0 1024x768x24", "yade", "-x", str(script), str(folder)]
	run = subprocess.run(command, capture_output=True, text=True, timeout=150, env=dict(os.environ))
	assert "SCRIPT ENDED" in run.stdout, run.stdout + run.stderr
	return run.stdout


def test_the_recipe_of_a_picture_without_a_window_leaves_one(tmp_path):
	from matplotlib import image

	page = (Path(__file__).resolve().parents[2] / "examples" / "manual" / "recipes.md").read_text()
	(tmp_path / "picture.py").write_text(re.search(r"^```py\n(.*?)^```", page, re.S | re.M).group(1))
	command = ["xvfb-run", "-a", "-s", "-screen 0 1024x768x24", "yade", "-x", "picture.py"]
	run = subprocess.run(command, cwd=tmp_path, capture_output=True, text=True, timeout=150, env=dict(os.environ))
	files = sorted(tmp_path.glob("picture-*.png"))
	assert files, run.stdout + run.stderr
	picture = image.imread(files[-1])[..., :3]
	drawn = float((picture.min(axis=-1) < 0.9).mean())
	print(f"{len(files)} pictures of {picture.shape[1]} x {picture.shape[0]} pixels, {100 * drawn:.0f} % of them not white")
	assert 0.05 < drawn < 0.9


def test_the_snapshot_engine_takes_pictures_of_bodies_on_the_ground(tmp_path):
	from matplotlib import image

	output = withXvfb(
		tmp_path,
		"""
qt.Renderer().bgColor = (1, 1, 1)
view = qt.View()
draw(0.3)
view.axes, view.viewDir, view.upVector = False, (0, 0, -1), (0, 1, 0)
view.fitAABB((-0.1, 0, 0), (0.7, 1, 0))
draw(0.3)
O.engines = O.engines + [qt.SnapshotEngine(fileBase=sys.argv[1] + "/slope-", iterPeriod=2)]
at = O.iter
O.run(6)
end = time.monotonic() + 60
while O.running and time.monotonic() < end:
	draw(0.02)
print("STEPS", O.iter - at)
""",
	)
	files = sorted(tmp_path.glob("slope-*.png"))
	picture = image.imread(files[-1])[..., :3]
	blue = int(((picture[..., 2] > 0.3) & (picture[..., 0] < 0.3) & (picture[..., 1] < 0.3)).sum())
	print(
		f"{len(files)} pictures in the steps of the ground ({re.search('STEPS .*', output).group()}); {blue} blue pixels "
		f"of the sphere of {picture.shape[0] * picture.shape[1]}"
	)
	assert "STEPS 6" in output and len(files) == 3 and 1000 < blue < 0.5 * picture.shape[0] * picture.shape[1]


def test_the_inspector_shows_and_edits_our_engine_and_its_parts(tmp_path):
	output = withXvfb(
		tmp_path,
		"""
from yade.qt.Inspector import SimulationInspector
from yade.qt.SerializableEditor import SerializableEditor
window = SimulationInspector()
window.show()
draw(0.5)
parts = [mpm, mpm.skeleton, mpm.heat, mpm.freezing, mpm.boundaries[0], mpm.bodies, wrapper.RveSkeleton(), wrapper.PoreWater(), wrapper.IceBondMat(),
	wrapper.MohrCoulombSkeleton(), wrapper.Law2_ScGeom_IceBondPhys_IceBond(), wrapper.GrainSwelling()]
for part in parts:
	editor = SerializableEditor(part, showType=True)
	editor.show()
	draw(0.1)
	editor.refreshEvent()
	shown = {entry.name for entry in editor.entries}
	print("EDITOR", type(part).__name__, len(shown))
	assert shown, type(part)
	if part is mpm:
		assert {"gridSpacing", "gravity", "damping", "picTime", "boundaries", "skeletons"} <= shown, shown
		entry = next(entry for entry in editor.entries if entry.name == "damping")
		entry.widget.setText("0.25")
		entry.widget.update()
		draw(0.1)
		print("DAMPING", mpm.damping)
	editor.close()
O.run(2, True)
draw(0.2)
""",
	)
	shown = re.findall(r"EDITOR (\w+) (\d+)", output)
	print(", ".join(f"{name} {count}" for name, count in shown), "attributes shown")
	assert len(shown) == 12 and "DAMPING 0.25" in output


lateInspector = """
import os, sys, talik
import yade.runtime
from PyQt5.QtWidgets import QApplication
from yade import wrapper

assert "yade.qt" not in sys.modules
yade.runtime.hasDisplay = True
application = QApplication.instance() or QApplication(sys.argv)
from yade.qt.SerializableEditor import SerializableEditor
editor = SerializableEditor(wrapper.MpmEngine(boundaries=[wrapper.FixedBoundary()]))
editor.show()
editor.refreshEvent()
print("SHOWN", *(entry.name for entry in editor.entries), "END")
sys.stdout.flush()
os._exit(0)
"""


def test_an_inspector_that_is_imported_after_us_shows_our_lists_as_well(tmp_path):
	script = tmp_path / "script.py"
	script.write_text(lateInspector)
	run = subprocess.run(["xvfb-run", "-a", "yade", "-n", "-x", str(script)], capture_output=True, text=True, timeout=60, env=dict(os.environ))
	shown = re.search("SHOWN (.*) END", run.stdout)
	assert shown, run.stdout + run.stderr
	print(f"{len(shown.group(1).split())} attributes shown")
	assert {"gridSpacing", "boundaries", "skeletons"} <= set(shown.group(1).split())


batchScript = """
import json, math, talik
from yade import O, utils, wrapper
utils.readParamsFromTable(iceTensileStrength=50e6, tensileStrength=1e6, noTableOk=False)
from yade.params import table
strengths = dict(tensileStrength=table.tensileStrength, iceTensileStrength=table.iceTensileStrength)
material = wrapper.IceBondMat(young=0.6e9, poisson=0.8, density=2650, iceSaturation=1, **strengths)
O.materials.append(material)
R = 5e-3
O.bodies.append([utils.sphere((0, 0, 0), R, fixed=True), utils.sphere((2 * R, 0, 0), R, fixed=True)])
O.engines = [
	wrapper.ForceResetter(), wrapper.InsertionSortCollider([wrapper.Bo1_Sphere_Aabb(aabbEnlargeFactor=1.05)]),
	wrapper.InteractionLoop([wrapper.Ig2_Sphere_Sphere_ScGeom(interactionDetectionFactor=1.05)],
		[wrapper.Ip2_IceBondMat_IceBondMat_IceBondPhys(bondNewContacts=True)], [wrapper.Law2_ScGeom_IceBondPhys_IceBond()]),
	wrapper.NewtonIntegrator(),
]
O.dt = 1e-6
O.step()
O.bodies[1].state.vel = (0.05, 0, 0)
strongest = 0
while O.interactions.has(0, 1, True) and O.interactions[0, 1].phys.bondState == 1 and O.iter < 5000:
	strongest = max(strongest, -O.interactions[0, 1].phys.normalForce.dot(O.interactions[0, 1].geom.normal))
	talik._talik.runSerially(1)
with open({folder!r} + "/" + O.tags["description"] + ".json", "w") as file:
	json.dump(dict(strength=table.tensileStrength + table.iceTensileStrength, force=strongest, radius=R), file)
"""


def test_yade_batch_runs_a_table_of_bond_strengths(tmp_path):
	import json

	(tmp_path / "pull.py").write_text(batchScript.replace("{folder!r}", repr(str(tmp_path))))
	(tmp_path / "strengths.table").write_text("description tensileStrength iceTensileStrength\nweak 1e6 10e6\nmiddle 1e6 25e6\nstrong 2e6 50e6\n")
	run = subprocess.run(
		["yade-batch", "-j2", "--job-threads=1", "strengths.table", "pull.py"],
		cwd=tmp_path,
		capture_output=True,
		text=True,
		timeout=150,
		stdin=subprocess.DEVNULL,
		env={k: v for k, v in os.environ.items() if k != "DISPLAY"},
	)
	results = {file.stem: json.loads(file.read_text()) for file in tmp_path.glob("*.json")}
	logs = "".join(file.read_text() for file in tmp_path.glob("*.log"))
	assert set(results) == {"weak", "middle", "strong"}, run.stdout + run.stderr + logs
	for name, row in results.items():
		expected = row["strength"] * row["radius"] ** 2
		print(f"{name}: C = {row['strength'] / 1e6:g} MPa breaks at {row['force']:.1f} N, C R^2 = {expected:.1f} N")
		assert row["force"] == pytest.approx(expected, rel=0.02)
