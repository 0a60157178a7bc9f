# SPDX-License-Identifier: GPL-2.0-or-later
import pytest
from fixtures import emptyScene, sampleCache  # noqa: F401: pytest finds them here

import talik
from talik import rve


@pytest.fixture(scope="session")
def smallSample(sampleCache):
	"""Thirty grains, packed."""
	return talik.rve.pack(rve.prepare(grains=30, porosity=0.19, cache=sampleCache))
