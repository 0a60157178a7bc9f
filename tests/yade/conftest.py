# SPDX-License-Identifier: GPL-2.0-or-later
import sys
from pathlib import Path

import pytest
from fixtures import calibrateCommand, emptyScene, ofMay, sampleCache  # noqa: F401: pytest finds them here

from talik import rve

sys.path.insert(0, str(Path(__file__).resolve().parents[2] / "examples"))  # scenes, and what they share


@pytest.fixture(scope="session")
def draftSample(sampleCache):
	"""100 grains, the paper's recipe."""
	return rve.prepare(grains=100, cache=sampleCache)


@pytest.fixture(scope="session")
def paperSample(sampleCache):
	"""400 grains, the paper's sample."""
	return rve.prepare(grains=400, cache=sampleCache)
