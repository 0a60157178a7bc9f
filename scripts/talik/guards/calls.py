# SPDX-License-Identifier: GPL-2.0-or-later
"""Calls while O runs: methods and attributes of Talik wait for the end of the step that is under way."""

import functools
import inspect
import types

from talik import _talik


def betweenSteps(function):
	def call(*positional, **named):
		return _talik.callBetweenSteps(function, positional, named)

	return functools.update_wrapper(call, function, assigned=("__name__", "__doc__"), updated=())


def letCallsWait(cls):
	"""Every method and attribute of a class waits for the end of the step that is under way, and the next step waits for it: nothing is
	read or changed while an engine works on it. What Python adds to a class afterwards is made of these."""
	for name in dir(cls):
		member = inspect.getattr_static(cls, name)
		if name.startswith("__") or isinstance(member, types.FunctionType):
			continue
		if type(member) is property:
			if name not in vars(cls):
				continue  # of stock YADE; none of our steps changes it
			setter = member.fset and betweenSteps(member.fset)
			setattr(cls, name, property(betweenSteps(member.fget), setter, member.fdel, member.__doc__))
		elif isinstance(member, staticmethod):
			setattr(cls, name, staticmethod(betweenSteps(member.__func__)))
		elif type(member).__name__ == "function":  # of Boost.Python
			setattr(cls, name, betweenSteps(member))
