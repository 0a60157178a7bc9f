# SPDX-License-Identifier: GPL-2.0-or-later
"""Samples on a device give a scene the bits of the processor. The device is the twin of a graphics card, or a card behind a driver of the tests."""

import struct
from pathlib import Path

import pytest
from fixtures import thirty
from yade import O

import talik
from talik import rve
from yade.wrapper import FixedBoundary, FreezingCurve, HeatTransfer, MpmEngine, RollerBoundary, RveSkeleton, WallTemperature

fields = "position velocity stress temperature iceSaturation bondsIntact bondsFormed bondsBroken bondsMelted contacts coordinationNumber".split()
stub = Path(talik.__file__).parents[2] / "libtalik_stub_driver.so"


@pytest.fixture(scope="module")
def sample(sampleCache):
	return rve.pack(rve.prepare(**thirty, cache=sampleCache))


def column(sample, **settings):
	"""Frozen ground on a warm base, which thaws, breaks and moves: two by four points of a column."""
	h = 0.5
	mpm = MpmEngine(
		gridSpacing=h,
		lower=(0, 0),
		upper=(2 * h, 4 * h),
		gravity=(0, -9.81),
		skeleton=RveSkeleton(samples=[sample.copy()], strainTolerance=1e-6, saturationTolerance=0.005, slipFriction=0.3, **settings),
		heat=HeatTransfer(thermalTimeScale=8.64e5),
		freezing=FreezingCurve(width=0.5, residualSaturation=0.02),
		boundaries=[
			RollerBoundary(region="left"),
			RollerBoundary(region="right"),
			FixedBoundary(region="bottom"),
			WallTemperature(region="bottom", times=[0], values=[12]),
		],
	)
	talik.geometry.fill(mpm, talik.geometry.rectangle(0, 0, 2 * h, 2 * h), temperature=-0.2)
	O.engines = [mpm]
	return mpm


def state(mpm):
	return {name: mpm.field(name).tobytes() for name in fields}, mpm.balance()


def run(sample, steps, changes={}, **settings):
	"""The fields in the end; changes: attributes of the skeleton by the step from which on they hold."""
	O.reset()
	mpm = column(sample, **settings)
	for step in range(steps):
		for name, value in changes.get(step, {}).items():
			setattr(mpm.skeleton, name, value)
		O.step()
	return mpm


steps = 160


@pytest.fixture(scope="module")
def onProcessor(sample):
	mpm = run(sample, steps)
	assert "onDevice" not in mpm.skeleton.cost()
	thawed = mpm.field("iceSaturation").min(), mpm.field("bondsMelted").sum(), mpm.field("bondsIntact").sum()
	print(f"\nleast ice saturation {thawed[0]:.2f}, {thawed[1]:.0f} bonds melted, {thawed[2]:.0f} intact, {mpm.skeleton.cost()['calls']} calls")
	assert thawed[1] > 0 and thawed[2] > 0
	return state(mpm)


def expectSame(mpm, reference):
	now = state(mpm)
	cost = mpm.skeleton.cost()
	print(f"\n{cost['onDevice']} calls on the device, {cost['endedOnProcessor']} of them ended on the processor, {cost['leftToProcessor']} left to it")
	assert [name for name in fields if now[0][name] != reference[0][name]] == [] and now[1] == reference[1]
	return cost


def test_a_scene_without_a_device_opens_no_driver(sample, monkeypatch):
	monkeypatch.setenv("TALIK_CUDA_DRIVER", str(stub))
	run(sample, 2)
	assert not any(name in Path("/proc/self/maps").read_text() for name in ("stub_driver", "libcuda"))


def test_a_thawing_column_has_the_same_bits_with_the_twin_of_a_card(sample, onProcessor):
	cost = expectSame(run(sample, steps, device="twin"), onProcessor)
	assert cost["onDevice"] > 100 and cost["leftToProcessor"] == 0  # bonds melt there


def test_the_device_may_change_at_any_step(sample, onProcessor):
	changes = {k: dict(device=("twin", "cpu")[k // 40 % 2]) for k in range(0, steps, 40)}
	mpm = run(sample, steps, changes)
	assert mpm.skeleton.device == "cpu"
	now = state(mpm)
	assert now == onProcessor


@pytest.mark.parametrize("first, then", [("twin", "cpu"), ("cpu", "twin")])
def test_a_checkpoint_of_one_goes_on_on_the_other(first, then, sample, onProcessor, tmp_path):
	mpm = run(sample, steps // 2, device=first)
	O.save(str(tmp_path / "scene.yade"))
	O.reset()
	O.load(str(tmp_path / "scene.yade"))
	mpm = O.engines[0]
	mpm.skeleton.device = then
	for _ in range(steps - steps // 2):
		O.step()
	assert state(mpm) == onProcessor


def test_a_card_that_is_lost_in_mid_run_is_said_and_the_run_goes_on_with_the_same_bits(sample, onProcessor, monkeypatch, capfd):
	monkeypatch.setenv("TALIK_CUDA_DRIVER", str(stub))
	monkeypatch.setenv("TALIK_STUB_DRIVER", "fail cuStreamSynchronize 20 719")
	cost = expectSame(run(sample, steps, device="gpu"), onProcessor)
	said = [line for line in capfd.readouterr().err.splitlines() if line.startswith("RveSkeleton:")]
	print("\n".join(said))
	assert cost["onDevice"] > 0 and len(said) == 1 and "CUDA_ERROR_LAUNCH_FAILED" in said[0] and "goes on on the processor" in said[0]


def test_a_card_that_is_missing_is_said_with_a_remedy(sample, monkeypatch, capfd):
	monkeypatch.setenv("TALIK_CUDA_DRIVER", "/nowhere/libcuda.so.1")
	run(sample, 2, device="gpu")
	said = capfd.readouterr().err
	assert "There is no driver of NVIDIA's here" in said and "nvidia-driver" in said and "goes on on the processor" in said
	run(sample, 2, device="auto")
	assert "NVIDIA" not in capfd.readouterr().err


def test_another_name_of_a_device_is_refused(sample):
	with pytest.raises(ValueError, match="RveSkeleton.device is 'cuda': choose cpu, gpu, auto or twin"):
		column(sample, device="cuda").initialise()


def test_what_a_ground_asks_its_samples_is_recorded_for_a_replay(sample, tmp_path, monkeypatch):
	"""Each request that the skeleton counts is found, and the record says of which samples."""
	monkeypatch.syspath_prepend(str(Path(__file__).resolve().parents[2] / "scripts" / "benchmarks"))
	import cardreplay

	O.reset()
	mpm = column(sample)
	O.run(60, True)
	record, before = cardreplay.Record(mpm, tmp_path / "record.bin"), mpm.skeleton.cost()["calls"]
	for _ in range(30):
		record.step()  # ends the test where the requests found are not those counted
	record.file.close()
	calls = mpm.skeleton.cost()["calls"] - before
	held = (tmp_path / "record.bin").read_bytes()
	points, at = struct.unpack_from("<Q", held)[0], 16
	for _ in range(points):
		at += 8 + struct.unpack_from("<Q", held, at)[0]
	print(f"\n{calls} calls counted, {record.asked} recorded, states of {points} samples, {len(held) - at} bytes of requests")
	assert calls > 10 and record.asked == calls and points == mpm.pointCount and len(held) - at == 30 * 8 + calls * 8 * (1 + 4 + 1)


presets = {"base": dict(days=12.0), "surface": dict(days=12.0)}


@pytest.mark.parametrize("name", [f"{name}_slow" for name in presets])
def test_a_slump_has_the_same_bits_with_the_twin_of_a_card(name, tmp_path, monkeypatch):
	"""Both slumps, coarse: thaw, breakage and the first slides."""
	import importlib

	import thawslump
	from thawslump import page

	name = name.removesuffix("_slow")
	case = importlib.import_module(f"thaw_slump_{name}").case
	preset = thawslump.Preset(gridSpacing=0.5, grains=40, strainTolerance=1e-4, bandThickness=1.0, seed=3, **presets[name])
	monkeypatch.setattr(page, "draw", lambda *given: None)
	ends = {}
	for device in ("cpu", "twin"):
		O.reset()
		slump = thawslump.ThawSlump(case, preset, tmp_path / device)
		slump.skeleton.device = device
		slump.run()
		ends[device] = state(slump.mpm)
		cost = slump.mpm.skeleton.cost()
		melted, broken = (slump.mpm.field(field).sum() for field in ("bondsMelted", "bondsBroken"))
		print(f"\n{name}, {device}, {preset.days:.0f} days: {melted:.0f} bonds melted, {broken:.0f} broken, {cost}")
	assert cost["onDevice"] > 100 and cost["leftToProcessor"] == 0 and ends["twin"] == ends["cpu"]
