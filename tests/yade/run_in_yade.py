# SPDX-License-Identifier: GPL-2.0-or-later
"""Runs pytest inside the stock yade:  yade -n -x tests/yade/run_in_yade.py [pytest arguments]

Without arguments every test_*.py beside this file. The exit status is pytest's: yade itself would end with 0. Where every test was
skipped it is 77, which ctest reports as skipped and pytest would report as passed."""

import os
import sys
from pathlib import Path

import pytest

import talik  # before any engine exists  # noqa: F401: loads the plugin


class Outcomes:
	"""Counts the tests that were skipped, and the others."""

	def __init__(self):
		self.skipped = self.others = 0

	def pytest_runtest_logreport(self, report):
		if report.skipped:
			self.skipped += 1
		elif report.when == "call" or report.failed:
			self.others += 1


here = Path(sys.argv[0]).resolve().parent
sys.path.insert(0, str(here))
arguments = sys.argv[1:] or [str(here)]
outcomes = Outcomes()
status = int(pytest.main(arguments, plugins=[outcomes]))
if status == 0 and outcomes.skipped and not outcomes.others:
	status = 77
sys.stdout.flush()
sys.stderr.flush()
os._exit(status)  # a yade with threads and Python objects in flight may not end otherwise
