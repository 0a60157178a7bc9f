# SPDX-License-Identifier: GPL-2.0-or-later
"""Every test begins with an empty scene; one small sample serves all tests of a run."""

import pytest
from yade import O

import talik
from talik import rve


@pytest.fixture(autouse=True)
def emptyScene():
	O.reset()
	O.engines = []
	yield
	O.reset()


@pytest.fixture(scope="session")
def smallSample(tmp_path_factory):
	"""Thirty grains, packed."""
	return talik.slope.pack(rve.prepare(grains=30, porosity=0.19, cache=tmp_path_factory.mktemp("samples")))
