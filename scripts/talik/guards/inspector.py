# SPDX-License-Identifier: GPL-2.0-or-later
"""YADE's inspector shows lists of Talik's classes."""

import re
import sys


ownList = re.compile(r":yattrtype:`vector<shared_ptr<(\w+)>>`")


def _ownListClass(cls, attribute):
	"""Name of the class of which an attribute is a list, None for anything else."""
	found = ownList.search(getattr(cls, attribute).__doc__ or "")
	return found and found.group(1)


class _Learning:
	"""qtHide of a class of ours: the names of attributes that the inspector is to pass over, which it asks for before it shows the first.

	There are none; but an inspector that came after us learns here."""

	def __get__(self, shown, cls):
		editor = getattr(sys.modules.get("yade.qt"), "SerializableEditor", None)
		if editor is not None:
			_teach(editor)
		return ""


def teachInspector(classes):
	"""YADE's inspector knows lists of YADE's own classes only, and an empty list of another ends it with an error: it learns ours.

	Also where yade.qt is imported later."""
	for cls in classes:
		cls.qtHide = _Learning()


def _teach(editor):
	if hasattr(editor, "_stockGuess"):
		return
	from yade import wrapper

	stockGuess = editor._stockGuess = editor.getListTypeFromDocstring

	def guess(self, attribute):
		element = getattr(wrapper, _ownListClass(type(self.ser), attribute) or "", None)
		return (element,) if element else stockGuess(self, attribute)

	editor.getListTypeFromDocstring = guess
