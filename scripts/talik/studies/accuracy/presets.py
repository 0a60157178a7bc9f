# SPDX-License-Identifier: GPL-2.0-or-later
"""Presets of the examples as rows of the table: which problem stands for an example, and its settings.

Grid spacings count in cells over the length that the problem has too: depth of the front, height of the ground."""

import ast
from dataclasses import dataclass
from pathlib import Path

import thawslump
from talik.studies.accuracy.examples import folder as examples


@dataclass(frozen=True)
class PresetRow:
	example: str
	preset: str
	problem: str
	settings: dict  # what differs from the problem's standard
	quick: bool = True  # also in a quick study


def slumpRow(preset):
	return "thaw slump", {"grid spacing": preset.gridSpacing, "grains": preset.grains, "sample tolerance": preset.strainTolerance}


def cellsOver(length, problem):
	"""Of examples whose presets have a gridSpacing (or spacing) over a length [m]."""

	def row(preset):
		return problem, {"cells": round(length / (preset.gridSpacing if hasattr(preset, "gridSpacing") else preset.spacing))}

	return row


rowOf = {
	"thaw_slump_surface": slumpRow,
	"thaw_slump_base": slumpRow,
	"weather_column": cellsOver(1.6, "Neumann thaw"),  # m that thaw in a summer
	"barrier": cellsOver(0.6, "column collapse"),  # height of the mass at the start [m]
	"footing_on_thawing_ground": cellsOver(3.0, "column collapse"),  # depth of the ground [m]
	"boulder_on_thawing_slope": cellsOver(2.5, "column collapse"),  # height of the face [m]
	"own_sample": lambda preset: ("column collapse", {"cells": round(1.0 / preset[1])}),  # a bank of 1 m
	"look_inside": lambda preset: ("biaxial sample", {"grains": preset[0]}),
}
# presets of melting_column are columns of other sizes; twelve examples compare themselves with a calculation by hand; no problem here is in space;
# centrifuge_slopes varies its spacing itself
comparedByHand = (
	"thaw_settlement_column",
	"ice_rich_layer",
	"ice_rich_slump",
	"warm_pipeline",
	"retaining_wall",
	"surveyed_profile",
	"parameter_study",
	"creeping_slope",
	"creeping_footing",
	"road_embankment",
	"frost_heave_column",
	"chilled_pipeline",
)
measured = ("heave_test", "borehole_years", "burned_tundra", "field_slope", "retrogressive_slump", "thawing_block")  # held against the ground
withoutKnob = ("melting_column", *comparedByHand, "thaw_slump_bowl", "centrifuge_slopes", "slope_at_risk", *measured)


def presetsOf(file):
	"""The dictionary `presets` of an example, read without running it; None if it has none of its own."""
	wanted = [
		node
		for node in ast.parse(Path(file).read_text()).body
		if (isinstance(node, ast.ImportFrom) and node.module == "dataclasses")
		or (isinstance(node, ast.ClassDef) and any(getattr(mark, "id", "") == "dataclass" for mark in node.decorator_list))
		or (isinstance(node, ast.Assign) and getattr(node.targets[0], "id", "") == "presets")
	]
	names = {}
	exec(compile(ast.Module(wanted, type_ignores=[]), str(file), "exec"), names)
	return names.get("presets")


def presetRows(quick=False, folder=examples):
	"""Rows of all presets of all examples in a folder."""
	rows = []
	for name, row in rowOf.items():
		file = Path(folder) / f"{name}.py"
		if not file.exists():
			continue
		for label, preset in (presetsOf(file) or thawslump.presets).items():
			problem, settings = row(preset)
			rows.append(PresetRow(name, label, problem, settings, quick=problem != "thaw slump" or label == "draft"))
	return [row for row in rows if row.quick or not quick]
