# SPDX-License-Identifier: GPL-2.0-or-later
"""Simulated ranks and networks: what is known in closed form comes out."""

import json
import subprocess
import sys
from pathlib import Path

import numpy as np
import pytest

root = Path(__file__).resolve().parents[2]
sys.path.insert(0, str(root / "scripts"))

from scaling import Network, Record, Replay, copiedLoads, dealtAgain, recordedLoads

free = Network("free", 0, np.inf, localLatency=0, localBandwidth=np.inf)
ground, call, demStep = 2e-3, 1e-5, 1e-6  # [s]


def write(file, points=96, steps=120, asked=0.4, even=False):
	"""A record whose costs are known."""
	random = np.random.default_rng(3)
	taken = np.where(random.random((steps, points)) < asked, random.integers(10, 60, (steps, points)), 0)
	if even:
		taken[:] = np.where(np.arange(steps) % 3, 20 + np.arange(steps) % 5, 0)[:, None]
	seconds = ground + ((taken > 0) * call + taken * demStep).sum(1)
	np.savez(file, seconds=seconds, taken=taken.astype(np.int32), dimension=2)
	return file


def test_costs_of_ground_call_and_step_are_found_in_a_record(tmp_path):
	record = Record(write(tmp_path / "record.npz"))
	print(f"ground {record.ground:.3e} of {ground:.3e}, call {record.call:.3e} of {call:.3e}, DEM step {record.demStep:.3e} of {demStep:.3e} s")
	assert (record.ground, record.call, record.demStep) == pytest.approx((ground, call, demStep), rel=1e-6)


@pytest.mark.parametrize("ranks", [1, 2, 4, 16])
def test_even_samples_on_a_free_network_are_as_much_faster_as_amdahl_says(ranks, tmp_path):
	record = Record(write(tmp_path / "record.npz", even=True))
	run = Replay(recordedLoads(record, ranks), free, 2)
	share = record.inSamples
	expected = 1 / (1 - share + share / ranks)  # Amdahl, 1967
	print(f"{ranks} ranks, {share:.3f} of the time in samples: {run.efficiency * ranks:.4f} times as fast, in closed form {expected:.4f}")
	assert run.efficiency * ranks == pytest.approx(expected, rel=1e-9)


def test_latency_grows_with_the_logarithm_of_machines_and_bytes_take_their_time():
	network = Network("ours", latency=1e-5, bandwidth=1e9, perMachine=1, localLatency=0, localBandwidth=np.inf)
	times = [network.allGather(8e6, ranks) for ranks in (2, 4, 1024)]
	expected = [1e-5 + 4e-3, 2e-5 + 6e-3, 10e-5 + 8e-3 * 1023 / 1024]  # of doubling steps: Thakur, Rabenseifner and Gropp, 2005
	print(f"8 MB among 2, 4 and 1024 machines: {times} s, in closed form {expected} s")
	assert times == pytest.approx(expected, rel=1e-12)


def test_a_deal_brings_ranks_within_two_percent_and_keeps_what_need_not_move():
	random = np.random.default_rng(5)
	cost, owner = random.uniform(1, 3, 400), np.arange(400) % 4
	cost[owner == 1] *= 2
	after = dealtAgain(cost, owner, 4)
	load = np.bincount(after, cost, 4)
	print(f"largest over mean cost: {load.max() / load.mean():.4f}; {np.count_nonzero(after != owner)} of 400 samples moved")
	assert load.max() <= 1.02 * load.mean()
	assert np.count_nonzero(after != owner) < 100 and not np.any((owner != 1) & (after != owner))


def test_copies_that_begin_at_other_steps_cost_what_so_many_grounds_cost(tmp_path):
	record = Record(write(tmp_path / "record.npz"))
	loads = copiedLoads(record, [1, 8], 96 * 400, ground / 96, 30)
	mean = record.cost(record.taken).sum() / record.steps * 400
	print(f"samples of 400 copies: {loads[8].samples.mean():.3f} s a step, 400 times the mean of one {mean:.3f} s; ground {loads[8].ground:.3f} s")
	assert loads[8].samples.mean() == pytest.approx(mean, rel=0.01) and loads[8].ground == pytest.approx(400 * ground)
	assert loads[8].largest.mean() < 1.05 * mean / 8


def test_the_script_compares_prints_and_draws(tmp_path):
	for scene in ("samples", "space"):
		write(tmp_path / f"record-{scene}.npz")
	record = Record(tmp_path / "record-samples.npz")
	measured = [
		{
			"scene": scene,
			"ranks": ranks,
			"threads": 1,
			"timed": 120,
			"points": 96,
			"balance": 1,
			"bytes": 0,
			"work": Replay(recordedLoads(record, ranks), free, 2).busiest,
		}
		for scene in ("samples", "space", "law", "spaceLaw")
		for ranks in (1, 2, 4)
	]
	(tmp_path / "ranks-measured.json").write_text(json.dumps(measured))
	program = "import sys, scaling; scaling.sizes.clear(); scaling.sizes.update({1e3: 4, 1e4: 2}); scaling.main(sys.argv[1])"
	run = subprocess.run([sys.executable, "-B", "-c", program, str(tmp_path)], cwd=root / "scripts", capture_output=True, text=True)
	print(run.stdout[:600])
	assert run.returncode == 0, run.stderr
	assert "largest deviation 0%" in run.stdout and "lost most to" in run.stdout
	assert all((tmp_path / name).stat().st_size > 5000 for name in ("scaling.png", "scaling_measured.png"))
