# SPDX-License-Identifier: GPL-2.0-or-later
"""Command line of the examples."""

import pytest

from talik import job

presets = dict(draft=dict(gridSpacing=0.5, grains=100, water=True), paper=dict(gridSpacing=0.2, grains=400, water=True))


def start(tmp_path, *options):
	return job.start(presets, arguments=["examples/slope.py", "--output", str(tmp_path / "run"), *options])


def test_the_preset_gives_the_settings_and_the_folder_is_made(tmp_path):
	found = start(tmp_path, "--preset", "paper")
	assert (found.preset, found.settings.gridSpacing, found.settings.grains) == ("paper", 0.2, 400)
	assert found.output.is_dir() and found.file("summary.json") == str(tmp_path / "run" / "summary.json")


def test_draft_is_the_default_and_single_settings_can_be_changed(tmp_path):
	found = start(tmp_path, "--set", "grains=50", "--set", "water=false")
	assert (found.preset, found.settings.grains, found.settings.water, found.settings.gridSpacing) == ("draft", 50, False, 0.5)


@pytest.mark.parametrize("options, message", [(["--preset", "huge"], "huge"), (["--set", "mass=3"], "no setting 'mass'"), (["--set", "grains=many"], "'many' is not a int")])
def test_unknown_presets_and_settings_are_named(tmp_path, capsys, options, message):
	with pytest.raises(SystemExit):
		start(tmp_path, *options)
	assert message in capsys.readouterr().err
