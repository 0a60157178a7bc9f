# SPDX-License-Identifier: GPL-2.0-or-later
"""Every test begins with an empty scene; samples are prepared once for all tests of a run, in a cache of its own."""

import pytest
from yade import O

from talik import rve


@pytest.fixture(autouse=True)
def emptyScene():
	O.reset()
	O.engines = []
	yield
	O.reset()


@pytest.fixture(scope="session")
def sampleCache(tmp_path_factory):
	return tmp_path_factory.mktemp("samples")


@pytest.fixture(scope="session")
def draftSample(sampleCache):
	"""100 grains, the paper's recipe."""
	return rve.prepare(grains=100, cache=sampleCache)


@pytest.fixture(scope="session")
def paperSample(sampleCache):
	"""400 grains, the paper's sample."""
	return rve.prepare(grains=400, cache=sampleCache)
