# SPDX-License-Identifier: GPL-2.0-or-later
"""Options that scripts/run hands to an example: the preset and the folder for results.

	job = talik.job.start(
		presets=dict(draft=dict(gridSpacing=0.5, grains=100), standard=dict(gridSpacing=0.3, grains=200), paper=dict(gridSpacing=0.2, grains=400)),
	)
	job.settings.gridSpacing, job.output, job.preset

An example also runs by itself:  yade -n -x examples/<name>.py --preset standard --output FOLDER
"""

import argparse
import sys
import time
from pathlib import Path
from types import SimpleNamespace

from talik.files import writableFolder


class Job:
	"""preset: its name; settings: its values as attributes; output: folder (Path); wallTime(): seconds since the start."""

	def __init__(self, preset, settings, output):
		self.preset, self.settings = preset, SimpleNamespace(**settings)
		self.output = writableFolder(output)
		self._began = time.monotonic()

	def wallTime(self):
		return time.monotonic() - self._began

	def file(self, name):
		"""Path of a result file as text, for YADE functions."""
		return str(self.output / name)


def start(presets, default="draft", arguments=None):
	"""Reads --preset, --output and --set name=value (any setting of the preset) from the command line of the script."""
	arguments = sys.argv if arguments is None else arguments
	name = Path(arguments[0]).stem
	parser = argparse.ArgumentParser(prog=name)
	parser.add_argument("--preset", choices=list(presets), default=default)
	parser.add_argument("--output", default=f"output/{name}")
	parser.add_argument("--set", metavar="NAME=VALUE", action="append", default=[])
	options = parser.parse_args(arguments[1:])
	settings = dict(presets[options.preset])
	for change in options.set:
		setting, _, value = change.partition("=")
		if setting not in settings:
			parser.error(f"--set {change}: there is no setting '{setting}'; there are {', '.join(settings)}")
		settings[setting] = _converted(parser, change, value, type(settings[setting]))
	return Job(options.preset, settings, options.output)


def _converted(parser, change, value, kind):
	try:
		if kind is bool:
			return {"true": True, "false": False}[value.lower()]
		return kind(value)
	except (ValueError, KeyError, TypeError):
		parser.error(f"--set {change}: '{value}' is not a {kind.__name__}")
