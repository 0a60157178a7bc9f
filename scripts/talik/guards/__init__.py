# SPDX-License-Identifier: GPL-2.0-or-later
"""What Talik adds to the YADE that is running, so that a mistake becomes an exception where stock YADE would end the process.

	runs        Ctrl-C pauses a run; errors of engines are raised
	calls       what a script reads or changes while O runs waits for the end of a step
	scenefiles  files of scenes that are damaged are refused; labels that are programs, too
	attributes  mistyped names, wrong types and changes that come too late
	copying     copies and pickles that are whole
	inspector   lists of Talik's classes in YADE's inspector

These modules know nothing of the tools for scenes; talik/__init__.py sets them up."""
