# SPDX-License-Identifier: GPL-2.0-or-later
"""Fixtures of the tests that run inside the stock yade."""

import os
from pathlib import Path

import pytest
from yade import O


@pytest.fixture(autouse=True)
def emptyScene():
	"""Every test begins with an empty scene."""
	O.reset()
	O.engines = []
	yield
	O.reset()


@pytest.fixture(scope="session")
def sampleCache(tmp_path_factory):
	"""Folder of prepared samples: that of the build, so that each is prepared once for all test files, or one of this run."""
	shared = os.environ.get("TALIK_TEST_SAMPLES")
	if not shared:
		return tmp_path_factory.mktemp("samples")
	Path(shared).mkdir(parents=True, exist_ok=True)
	return Path(shared)
