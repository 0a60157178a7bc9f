# SPDX-License-Identifier: GPL-2.0-or-later
"""Rows and curves of the validation in the format of tests/validation/Report.hpp, from tests that need YADE."""

import csv
import os
from pathlib import Path


class Report:
	"""Of one test: prints rows "case: figure | measured | reference | error | tolerance | source" and asserts them; leaves rows and
	curves in the folder that TALIK_VALIDATION_OUTPUT names, if it names one. The files of a slow test end with _slow."""

	def __init__(self, test, source):
		isSlow = os.environ.get("PYTEST_CURRENT_TEST", "").split(" ")[0].split("[")[0].endswith("_slow")
		self.test, self.source, self.rows = test + ("_slow" if isSlow else ""), source, []

	def expectScaled(self, what, measured, reference, scale, tolerance):
		error = (measured - reference) / scale
		passed = abs(error) <= tolerance
		print(f"\n{what:80s} | {measured:13.7g} | {reference:13.7g} | {error:10.2e} | {tolerance:8.1e} | {self.source}{'' if passed else ' FAILED'}", end="")
		self.rows.append((what, f"{measured:.10g}", f"{reference:.7g}", f"{error:.3e}", f"{tolerance:.1e}", self.source, int(passed)))
		self._write("rows", self.test, [("name", "measured", "reference", "error", "tolerance", "source", "passed"), *self.rows])
		assert passed, what

	def expectRelative(self, what, measured, reference, tolerance):
		self.expectScaled(what, measured, reference, reference, tolerance)

	def draw(self, name, title, xLabel, yLabel, curves):
		"""curves: (series, "computed" or "reference", x, y)."""
		points = [(series, kind, f"{x:.8g}", f"{y:.8g}") for series, kind, xs, ys in curves for x, y in zip(xs, ys)]
		self._write("curves", name, [("series", "kind", "x", "y"), *points], f"# {title}\n# {xLabel}\n# {yLabel}\n")

	@staticmethod
	def _write(part, name, lines, head=""):
		if not os.environ.get("TALIK_VALIDATION_OUTPUT"):
			return
		folder = Path(os.environ["TALIK_VALIDATION_OUTPUT"], part)
		folder.mkdir(parents=True, exist_ok=True)
		with (folder / f"{name}.csv").open("w", newline="") as file:
			file.write(head)
			csv.writer(file, lineterminator="\n").writerows(lines)
