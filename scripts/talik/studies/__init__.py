# SPDX-License-Identifier: GPL-2.0-or-later
"""Studies: tests of samples and of whole scenes that give numbers, tables and pictures. The tools for scenes do not know them.

	calibrate   MohrCoulombSkeleton, friction, strength and tension of a sample by tests
	cold        frozen strength and stiffness along a freezing curve
	creep       rate of creep over stress
	elementtests  triaxial, undrained, oedometer, isotropic and shear tests of samples; predictions of tests in a CSV file
	growth      what lets frozen strength grow with the strain rate
	moments     frozen samples whose bonds carry moments
	refrozen    strength after thaw and refreezing
	target      a sample that gives what tests of a soil gave
	thawtests   thaw settlement predicted for tests left out of the fit
	accuracy    what accuracy costs: scripts/accuracy
	command     scripts/calibrate

They are loaded when they are first used."""

import importlib

tools = ("calibrate", "cold", "creep", "elementtests", "growth", "moments", "refrozen", "target", "thawtests")  # for scripts of one's own
programs = ("accuracy", "command")  # of the repository


def __getattr__(name):
	if name in tools + programs:
		return importlib.import_module(f"talik.studies.{name}")
	raise AttributeError(f"module 'talik.studies' has no attribute '{name}'")
