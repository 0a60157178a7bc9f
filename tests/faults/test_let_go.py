# SPDX-License-Identifier: GPL-2.0-or-later
"""What a script made, put into a scene and let go of is freed by whatever drops it last: the thread of a step has Python's lock then.

The cases run in a yade of their own, which Python would end with "the GIL must be held"; PYTHONMALLOC=debug looks at every object that is freed."""

import re

import pytest
from fixtures import sixtySpheres
from test_calls_while_running import figures, lives, sampleFile  # noqa: F401: pytest finds it here

import talik
from talik import rve


@pytest.fixture(scope="module")
def sphereFile(sampleCache, tmp_path_factory):
	file = tmp_path_factory.mktemp("spheres") / "spheres.checkpoint"
	former = talik._talik.exchangeScene(rve.pack(rve.prepare(**sixtySpheres, cache=sampleCache)).open())
	try:
		talik.checkpoint.write(file)
	finally:
		talik._talik.exchangeScene(former)
	return str(file)


scenes = """
import gc, weakref
space = {space}
let = []  # weak references to what is let go of

def followed(*objects):
	let.extend(weakref.ref(thing) for thing in objects)
	return objects[0]

def block():
	return talik.solids.box((0, 0, 0), (1, 1, 1)) if space else talik.geometry.rectangle(0, 0, 1, 1)

def skeleton(**settings):
	return followed(wrapper.RveSkeleton(samples=[followed(sample.copy())], strainTolerance=1e-3, **settings))

def slowly(step):
	step.stress += 5e6 * step.strain

def ground(law, boundaries=()):
	up = (0, 0, -9.81) if space else (0, -9.81)
	mpm = wrapper.MpmEngine(
		gridSpacing=0.5, lower=(0, 0, 0) if space else (0, 0), upper=(1, 1, 2) if space else (1, 2), gravity=up, damping=0.3, skeleton=law,
		heat=followed(wrapper.HeatTransfer(thermalTimeScale=1e5)), freezing=followed(wrapper.FreezingCurve()), water=followed(wrapper.PoreWater()),
		boundaries=[
			*(followed(wrapper.RollerBoundary(region=side)) for side in ("left", "right", "bottom")),
			followed(wrapper.SurfaceTemperature(region="surface", days=[0, 0.01], values=[-5, 10])),
			*boundaries,
		],
	)
	talik.geometry.fill(mpm, block(), temperature=-5)
	O.engines = [followed(mpm)]
	return mpm

def run(steps=6):
	O.run(steps)  # in the thread of the steps, beside Python
	while O.running:
		gc.collect()
		time.sleep(0.002)
	assert not O.engines or not O.engines[-1].failure, O.engines[-1].failure
"""

cases = {
	"a README scene in a function, samples without names": """
def scene():
	mpm = ground(skeleton())
	talik.slope.settle(mpm, block())
scene()
run()
""",
	"laws and boundaries in Python, closures that only the scene has": """
class Stiff:
	def __call__(self, step):
		step.stress += 5e6 * step.strain
def scene():
	law, warm = Stiff(), lambda nodes: 10 - nodes.temperature
	mpm = ground(
		followed(wrapper.PythonSkeleton(law=followed(law), modulus=1e7)), [followed(wrapper.PythonBoundary(region="surface", function=followed(warm)))]
	)
scene()
run()
def other():
	O.engines[0].exchangeSkeletons([wrapper.ElasticSkeleton()], [0] * O.engines[0].pointCount)
other()
run(1)
""",
	"skeletons exchanged, the former ones let go of": """
def scene():
	ground(skeleton())
def exchange(law):
	mpm = O.engines[0]
	mpm.exchangeSkeletons([law], [0] * mpm.pointCount)
scene()
run()
for k in range(4):
	exchange(followed(wrapper.PythonSkeleton(law=lambda step: step.stress + 5e6 * step.strain, modulus=1e7)) if k % 2 else skeleton())
	run()
""",
	"samples and scenes replaced by ones without names": """
def scene():
	ground(skeleton())
def replace():
	law = O.engines[0].skeleton
	law.replaceSample(0, followed(law.sample(1)))
	law.replaceScene(1, followed(law.scene(0)))
scene()
run()
for _ in range(3):
	replace()
	run()
""",
	"samples that run open, of scenes without names": """
def scene():
	ground(followed(wrapper.RveSkeleton(scenes=[followed(sample.open())], form="open", strainTolerance=1e-3)))
scene()
run(3)
O.engines[0].skeleton.replaceScene(0, followed(sample.open()))
run(3)
""",
	"settings and samples given anew before the first step, after a look": """
def scene():
	mpm = ground(skeleton())
	mpm.field("temperature")
	mpm.skeleton.samples = [followed(sample.copy())]
	mpm.heat, mpm.freezing = followed(wrapper.HeatTransfer(thermalTimeScale=2e5)), followed(wrapper.FreezingCurve())
	mpm.boundaries = mpm.boundaries[:3] + [followed(wrapper.SurfaceTemperature(region="surface", temperature=-1))]
	mpm.material = followed(wrapper.GroundMaterial(solidDensity=2600))
scene()
run()
""",
	"engines given anew by a step": """
def other():
	return [followed(wrapper.PyRunner(command="again()", iterPeriod=3)), O.engines[-1]]
def again():
	O.engines = other()
def scene():
	mpm = ground(skeleton())
	O.engines = [wrapper.PyRunner(command="again()", iterPeriod=3), mpm]
scene()
run(20)
""",
	"a ground in place of another one, by a step": """
def again():
	mpm = ground(skeleton())
	O.engines = [wrapper.PyRunner(command="again()", iterPeriod=3), mpm]
again()
run(12)
""",
	"a run that goes on from a checkpoint in a function": """
def scene():
	ground(skeleton())
def on():
	mpm = talik.resume("here.checkpoint")
	followed(mpm)
scene()
run()
talik.checkpoint.write("here.checkpoint")
for _ in range(2):
	on()
	run()
""",
}


@pytest.mark.parametrize("dimension", [2, 3])
def test_objects_that_a_script_let_go_of_are_freed_by_steps_without_an_end(dimension, tmp_path, request, monkeypatch):
	monkeypatch.setenv("PYTHONMALLOC", "debug")
	file = request.getfixturevalue("sampleFile" if dimension == 2 else "sphereFile")
	body = scenes.format(space=dimension == 3)
	for what, case in cases.items():
		body += f'\nlet.clear()\nprint("CASE {what}", flush=True)\n{case}'
		body += 'gc.collect()\nprint("FIGURES {what}:", len(let), "objects let go of,", sum(thing() is None for thing in let), "freed")\n'.replace(
			"{what}", what
		)
	told = figures(lives(tmp_path, body, file))
	print(*told, sep="\n")
	# engines stay, and what they hold: an assignment to O.engines of stock YADE keeps a reference to each for ever
	assert len(told) == len(cases) and sum(int(re.search(r"of, (\d+) freed", line)[1]) for line in told) >= 20


def test_a_script_gets_its_own_object_back_from_what_holds_it(smallSample):
	from yade import O, wrapper

	heat, law = wrapper.HeatTransfer(), wrapper.RveSkeleton(samples=[smallSample])
	mpm = wrapper.MpmEngine(heat=heat, skeleton=law, skeletons=[law])
	O.engines = [mpm]
	pairs = [(mpm.heat, heat), (mpm.skeleton, law), (mpm.skeletons[0], law), (law.samples[0], smallSample), (O.engines[0], mpm)]
	print(f"{sum(got is given for got, given in pairs)} of {len(pairs)} objects are those of the script")
	assert all(got is given for got, given in pairs)
	mpm.heat = None
	assert mpm.heat is None
