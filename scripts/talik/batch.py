# SPDX-License-Identifier: GPL-2.0-or-later
"""Parameter studies: a script for each row of a table, several at a time, by yade-batch.

	rows = [dict(cohesion=c) for c in (1e3, 2e3, 4e3)]
	results = talik.batch.run("face.py", rows, "output/study")
	[result["displacement"] for result in results]
	talik.ensemble.spread(results)["displacement"].mean          # of rows that differ by a seed: mean, standard error, deciles

The script takes its row and leaves its results:

	row = talik.batch.row(cohesion=2e3)                          # of the table; by itself the script runs with these defaults
	...
	talik.batch.leave(displacement=...)
"""

import itertools
import json
import os
import subprocess
from pathlib import Path

from yade import O, utils

from talik import output
from talik.files import writableFolder

allRows = "all-rows.table"  # of the last call, those with results among them


def row(**defaults):
	"""Values of the script's row of the table, as an object with an attribute each; the defaults where no batch runs.

	>>> talik.batch.row(cohesion=2e3).cohesion
	2000.0"""
	try:
		utils.readParamsFromTable(noTableOk=True, **defaults)
	except NameError as problem:
		raise ValueError(f"batch.row: {problem}; give row() a default for every name in the rows") from None
	from yade.params import table

	return table


def leave(**results):
	"""Leaves results of a row, by name, for run(); without a batch it does nothing.

	>>> talik.batch.leave(displacement=0.1)"""
	folder = os.environ.get("TALIK_BATCH")
	if folder:
		output.writeSummary(Path(folder) / f"{O.tags['description']}.json", **results)


def _rowsDone(folder, heading, lines):
	"""Names of the rows that an earlier batch in the folder ran with the same values and results."""
	file = folder / allRows
	former = file.read_text().splitlines() if file.exists() else [""]
	if former[0] != heading:
		return []
	return [name for name, line in lines.items() if line in former[1:] and (folder / f"{name}.json").exists()]


def _setAside(folder):
	"""Gives the folder of an earlier batch another name, and says so."""
	if not folder.exists() or not any(folder.iterdir()):
		return
	if not (folder / allRows).exists():
		raise ValueError(f"batch.run: the folder {folder} holds files of no batch; give one of its own, such as {folder.name}/study")
	number = next(k for k in itertools.count(1) if not folder.with_name(f"{folder.name}-{k}").exists())
	folder.rename(folder.with_name(f"{folder.name}-{number}"))
	print(f"batch.run: the earlier batch in {folder} is now in {folder.name}-{number}")


def run(script, rows, folder, jobs=None, threads=1, resume=False):
	"""Runs a script once for each row and returns what it left, in the order of the rows; None for a row that left nothing.

	script   a Python file that takes its values by row() and gives its results by leave()
	rows     dictionaries of numbers or texts with the same names
	folder   for table, results and what each row said. That of an earlier batch is kept under a name with a number: study-1, study-2
	resume   rows that left their results in the folder before, with the same values, stay and are not run again
	jobs     rows at the same time; default: one for each processor
	threads  of each row

	ValueError for rows with different names, and for a folder with files of no batch; RuntimeError if no row left anything, with what the first one said.

	>>> script = folder + "/double.py"
	>>> text = "import talik\\nrow = talik.batch.row(x=1)\\ntalik.batch.leave(y=2 * row.x)\\n"
	>>> written = open(script, "w").write(text)
	>>> talik.batch.run(script, [dict(x=4)], folder + "/study")
	[{'y': 8}]"""
	rows, script = [dict(values) for values in rows], Path(script).resolve()
	if not rows or any(set(values) != set(rows[0]) for values in rows):
		raise ValueError("batch.run: rows are dictionaries with the same names, at least one; give every row a value for every name")
	if not script.is_file():
		raise ValueError(f"batch.run: there is no script {script}")
	folder = Path(folder).resolve()
	names = [f"row{number:03d}" for number in range(len(rows))]
	lines = {name: " ".join([name, *(repr(values[key]) for key in rows[0])]) for name, values in zip(names, rows)}
	heading = "description " + " ".join(rows[0])
	left = [folder / f"{name}.json" for name in names]
	done = _rowsDone(folder, heading, lines) if resume else []
	if not done:
		_setAside(folder)
	writableFolder(folder)
	for name, file in zip(names, left):
		if name not in done:
			file.unlink(missing_ok=True)
	(folder / allRows).write_text("\n".join([heading, *lines.values()]) + "\n")
	if len(done) == len(rows):
		return [json.loads(file.read_text()) for file in left]
	(folder / "rows.table").write_text("\n".join([heading, *(line for name, line in lines.items() if name not in done)]) + "\n")
	environment = {name: value for name, value in os.environ.items() if name != "DISPLAY"}
	environment.update(TALIK_BATCH=str(folder), OMP_WAIT_POLICY="passive")
	jobs = jobs or len(os.sched_getaffinity(0))
	command = ["yade-batch", f"-j{jobs * threads}", f"--job-threads={threads}", "--log=@.log", "rows.table", str(script)]
	batch = subprocess.run(command, cwd=folder, env=environment, capture_output=True, text=True, stdin=subprocess.DEVNULL)
	if not any(file.exists() for file in left):
		logs = [file.read_text(errors="replace") for file in sorted(folder.glob("*.log"))]
		said = (logs or [batch.stdout + batch.stderr])[0].partition("=================== JOB SUMMARY")[0].rstrip()
		raise RuntimeError("batch.run: no row left a result; the first one said:\n" + "\n".join(said.splitlines()[-15:]))
	return [json.loads(file.read_text()) if file.exists() else None for file in left]
