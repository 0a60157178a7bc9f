# SPDX-License-Identifier: GPL-2.0-or-later
"""What accuracy costs: error over computing time for every knob, on problems with a reference. scripts/accuracy runs it.

	study        runs what is planned, row by row into a file; table gives the rows with their errors
	problem      what a problem is; one file each: neumann, terzaghi, biaxial, wave, collapse, slump
	examples     folder of the examples, or the sentence that says where the study runs
	presets      presets of the examples as rows
	ground       knobs of the march and the column of those that move
	report       tables, Pareto front, advice, pictures, misses
	convergence  `scripts/accuracy slump`: both thaw slumps, knob by knob; convergencepage writes its tables and pictures

A new problem is one file and its entry in `problems`."""

from talik.studies.accuracy import examples  # first: those below import scenes from its folder
from talik.studies.accuracy import biaxial, collapse, neumann, slump, terzaghi, wave
from talik.studies.accuracy.neumann import neumannFront
from talik.studies.accuracy.presets import presetRows, presetsOf
from talik.studies.accuracy.report import column, drawStudy, printTable, saveTable
from talik.studies.accuracy.study import Results, runStudy, table

problems = tuple(module.problem for module in (neumann, terzaghi, biaxial, wave, collapse, slump))
