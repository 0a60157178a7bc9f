# SPDX-License-Identifier: GPL-2.0-or-later
"""The jobs of examples/cluster under Debian's Slurm, a cluster of one node in a temporary folder: at the time limit they write their
checkpoints and queue again, and end with the results of runs that were never stopped."""

import getpass
import json
import os
import re
import shutil
import socket
import subprocess
import time
from pathlib import Path

import pytest

import talik

example = Path(__file__).resolve().parents[2] / "examples" / "cluster"
needed = ["munged", "slurmctld", "slurmd", "sbatch", "mpirun", "yade-batch"]
missing = [program for program in needed if shutil.which(program, path=os.environ["PATH"] + ":/usr/sbin") is None]

pytestmark = pytest.mark.skipif(bool(missing), reason=f"no {' and '.join(missing)} here: apt install slurm-wlm munge openmpi-bin")

settings = """
ClusterName=test
SlurmctldHost={node}(127.0.0.1)
SlurmctldPort={ports[0]}
SlurmdPort={ports[1]}
SlurmUser={user}
SlurmdUser={user}
AuthType=auth/munge
AuthInfo=socket={folder}/munge.socket
CredType=cred/munge
StateSaveLocation={folder}/state
SlurmdSpoolDir={folder}/spool
SlurmctldPidFile={folder}/slurmctld.pid
SlurmdPidFile={folder}/slurmd.pid
SlurmctldLogFile={folder}/slurmctld.log
SlurmdLogFile={folder}/slurmd.log
ProctrackType=proctrack/linuxproc
TaskPlugin=task/none
SelectType=select/cons_tres
SelectTypeParameters=CR_Core
MpiDefault=none
ReturnToService=2
KillWait=5
SchedulerParameters=sched_interval=1,batch_sched_delay=0
NodeName={node} NodeAddr=127.0.0.1 CPUs={cores} RealMemory=500
PartitionName=all Nodes=ALL Default=YES MaxTime=INFINITE
"""


def freePorts(count):
	sockets = [socket.socket() for _ in range(count)]
	for one in sockets:
		one.bind(("127.0.0.1", 0))
	ports = [one.getsockname()[1] for one in sockets]
	for one in sockets:
		one.close()
	return ports


class Cluster:
	"""Slurm with this machine as its only node, all of whose files are in a folder."""

	def __init__(self, folder):
		self.folder, self.node, self.daemons = folder, socket.gethostname().split(".")[0], []
		self.cores = max(2, len(os.sched_getaffinity(0)))
		self.environment = {
			**talik.ranks.alone(os.environ),
			"PATH": os.environ["PATH"] + ":/usr/sbin",
			"SLURM_CONF": str(folder / "slurm.conf"),
			"OMPI_ALLOW_RUN_AS_ROOT": "1",
			"OMPI_ALLOW_RUN_AS_ROOT_CONFIRM": "1",
		}
		for part in ("state", "spool"):
			(folder / part).mkdir()
		(folder / "munge.key").write_bytes(os.urandom(64))
		(folder / "munge.key").chmod(0o600)
		(folder / "slurm.conf").write_text(settings.format(node=self.node, ports=freePorts(2), user=getpass.getuser(), folder=folder, cores=self.cores))

	def start(self):
		munge = {"key-file": "munge.key", "socket": "munge.socket", "pid-file": "munged.pid", "log-file": "munged.log", "seed-file": "munge.seed"}
		self.launch("munged", "--foreground", "--force", *(f"--{name}={self.folder / file}" for name, file in munge.items()))
		self.until(lambda: (self.folder / "munge.socket").exists())
		self.launch("slurmctld", "-D", "-i")
		self.launch("slurmd", "-D", "-N", self.node)
		self.until(lambda: self.ask("sinfo", "-h", "-o", "%T").strip() == "idle")

	def launch(self, *command):
		with open(self.folder / f"{command[0]}.out", "w") as out:
			self.daemons.append(subprocess.Popen(command, env=self.environment, stdout=out, stderr=out))

	def until(self, done, patience=30):
		end = time.monotonic() + patience
		while not done():
			assert time.monotonic() < end, self.logs()
			time.sleep(0.2)

	def stop(self):
		self.ask("scancel", "--user", getpass.getuser())
		for daemon in reversed(self.daemons):
			daemon.terminate()
			daemon.wait(timeout=30)

	def logs(self):
		return "\n".join(path.read_text()[-1500:] for path in self.folder.glob("*.log"))

	def ask(self, *command):
		return subprocess.run(command, env=self.environment, capture_output=True, text=True, timeout=60).stdout

	def submit(self, folder, *arguments, **environment):
		said = subprocess.run(
			["sbatch", *arguments], cwd=folder, env={**self.environment, **environment}, capture_output=True, text=True, timeout=60, check=True
		).stdout
		return int(re.search(r"Submitted batch job (\d+)", said).group(1))

	def job(self, number):
		"""What Slurm knows of a job."""
		return dict(re.findall(r"(\S+?)=(\S*)", self.ask("scontrol", "show", "job", str(number))))

	def follow(self, number, patience=900):
		"""Until the job has ended. Slurm lets a job that queues again wait for two minutes; here it need not."""
		end = time.monotonic() + patience
		going = ("PENDING", "CONFIGURING", "RUNNING", "SIGNALING", "COMPLETING", "REQUEUED")
		while (job := self.job(number))["JobState"] in going:
			assert time.monotonic() < end, (job, self.logs())
			if job["JobState"] == "PENDING" and job["Restarts"] != "0":
				self.ask("scontrol", "update", f"JobId={number}", "StartTime=now", "TimeLimit=60")
			time.sleep(0.5)
		return job


@pytest.fixture(scope="module")
def cluster(tmp_path_factory):
	found = Cluster(tmp_path_factory.mktemp("slurm"))
	try:
		found.start()
		yield found
	finally:
		found.stop()


def copied(folder, table=""):
	"""The example in a folder of its own, with other rows in its table."""
	shutil.copytree(example, folder)
	if table:
		(folder / "runs.table").write_text(table)
	return folder


def results(folder):
	return {path.stem: json.loads(path.read_text()) for path in (folder / "output").glob("*.json")}


def runAlone(folder, cluster):
	"""Line 2 of the table, on one rank and without Slurm."""
	command = ["yade", "-n", "-x", "-j1", "slope.py"]
	subprocess.run(command, cwd=folder, env={**cluster.environment, "YADE_BATCH": "runs.table:2"}, check=True, capture_output=True, timeout=900)
	return folder


def motionOf(seconds, cluster, folder):
	"""Seconds of motion that one rank computes in so many seconds here and now."""
	begin = time.monotonic()
	runAlone(copied(folder / "speed", "warming seconds\n8 1\n"), cluster)
	return max(2, round(seconds / (time.monotonic() - begin)))


def said(folder):
	return "".join(path.read_text() for path in folder.glob("slope*.txt"))


def test_a_job_on_ranks_that_its_time_limit_stopped_ends_as_one_that_was_never_stopped_slow(cluster, tmp_path):
	table = f"warming seconds\n8 {motionOf(75, cluster, tmp_path)}\n"
	folder = copied(tmp_path / "job", table)
	job = cluster.follow(cluster.submit(folder, "--time=1", "--signal=B:USR1@20", "ranks.sbatch", YADE_BATCH="runs.table:2"))
	found, expected = results(folder), results(runAlone(copied(tmp_path / "alone", table), cluster))
	print(f"job {job['JobState']} after {job['Restarts']} time limit(s): {found}; never stopped, on one rank: {expected}")
	assert job["JobState"] == "COMPLETED" and int(job["Restarts"]) >= 1, said(folder)
	assert "queues again" in said(folder)
	(name,) = expected
	assert found[name].pop("ranks") == 2 and expected[name].pop("ranks") == 1
	assert found == expected


def test_a_table_of_runs_goes_on_after_its_time_limit_slow(cluster, tmp_path):
	folder = copied(tmp_path / "runs", "warming seconds\n2 3\n15 3\n")
	number = cluster.submit(folder, "runs.sbatch")
	cluster.until(lambda: len(list(folder.glob("slopes.*.log"))) == 2 and all("Running script" in log.read_text() for log in folder.glob("slopes.*.log")), 120)
	time.sleep(5)  # both have begun to step
	cluster.ask("scancel", "--batch", "--signal=USR1", str(number))
	job = cluster.follow(number)
	checkpoints = len(list((folder / "output").glob("*.checkpoint")))
	found = results(folder)
	print(f"job {job['JobState']} after {job['Restarts']} stop(s), {checkpoints} checkpoints: {found}")
	assert job["JobState"] == "COMPLETED" and job["Restarts"] == "1" and checkpoints == 2, said(folder)
	cool, hot = (found[f"warming{warming}_grains50_spacing0.5_seconds3"] for warming in (2, 15))
	assert hot["bondsMelted"] > cool["bondsMelted"] > 0


def test_the_jobs_of_the_page_run_as_they_are_slow(cluster, tmp_path):
	page = (example / "README.md").read_text()
	lines = sorted(set(re.findall(r"^(?:\w+=\S+ )?sbatch .*$", page, re.M)))
	for line in lines:
		folder = copied(tmp_path / re.sub(r"\W", "-", line))
		*before, command = re.fullmatch(r"(?:(\w+=\S+) )?sbatch (.*)", line).groups()
		job = cluster.follow(cluster.submit(folder, *command.split(), **dict(word.split("=") for word in before if word)))
		print(f"{line}: {job['JobState']}, {len(results(folder))} result(s)")
		assert job["JobState"] == "COMPLETED" and results(folder), said(folder)
	assert len(lines) == 4
