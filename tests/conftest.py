# SPDX-License-Identifier: GPL-2.0-or-later
"""Each test that measured something says so: its requirement (the name of the test) and the figures that it printed."""

import re


def pytest_configure(config):
	config.pluginmanager.register(Table(config), "table")


def requirement(nodeid):
	"""Name of a test as a sentence: test_area_is_exact[0.5-4] -> area is exact [0.5-4]."""
	name, _, parameters = nodeid.split("::")[-1].removeprefix("test_").partition("[")
	return name.replace("_", " ") + (f" [{parameters}" if parameters else "")


class Table:
	def __init__(self, config):
		self.config = config

	def pytest_report_teststatus(self, report):
		if report.passed and report.when == "call":
			return "passed", "", "PASSED"

	def pytest_runtest_logreport(self, report):
		if report.when != "call" or not report.passed:
			return
		terminal = self.config.pluginmanager.get_plugin("terminalreporter")
		measured = [line for line in re.split(r"\r?\n", report.capstdout) if line.strip()]
		terminal.write_line(requirement(report.nodeid))
		for line in measured:
			terminal.write_line("    " + line.strip())
