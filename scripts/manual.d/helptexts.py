# SPDX-License-Identifier: GPL-2.0-or-later
"""Help texts of classes and functions as reStructuredText for Sphinx.

Texts of the classes come from Boost.Python: one paragraph with marks of YADE (:ydefault: and the like) and an example at its end. Texts of
functions are docstrings in which arguments stand in columns. Sphinx gets neither as it is: stars, bars and underscores are text.
"""

import inspect
import os
import re
import sys

# YADE lets libraries share their symbols, and black has names that another compiled package, charset_normalizer, has as well.
shared = sys.getdlopenflags()
sys.setdlopenflags(os.RTLD_NOW | os.RTLD_LOCAL)
import black  # noqa: E402

sys.setdlopenflags(shared)

marks = re.compile(r"\s*:y(?:default|attrtype|attrflags):`[^`]*`")
references = re.compile(r":yref:`(?:([^`<]*)<([^`>]*)>|([^`]*))`")
exampleOfClass = re.compile(r"\s*Example[^:]*: (.*?)\.?\s*$", re.S)
staticAttribute = re.compile(r"^(\w+): (.*?:ydefault:.*)$", re.S)
linkedClasses = []  # names of classes that have a place in the manual; reference.py fills it
writtenSignature = re.compile(r"^\s*\w+(\(.*?\)): ")
row = re.compile(r"^([\w.][\w,. ]*?)\s{2,}(\S.*)$")


def plain(text):
	"""Text as text: nothing in it is markup, but code between backquotes, and names of classes are links."""
	parts = re.split(r"`([^`]+)`", text)
	escaped = [re.sub(r"([\\*|_])", r"\\\1", part) for part in parts[::2]]
	if linkedClasses:
		names = re.compile(rf"(?<![\w.`])((?:{'|'.join(linkedClasses)})(?:\.[a-z]\w+)?)(?![\w(=\[{{\\])")
		escaped = [names.sub(r":py:obj:`\1 <talik.\1>`", part) for part in escaped]
	return "".join(part + (f"``{code}``" if code else "") for part, code in zip(escaped, [*parts[1::2], ""]))


def withoutMarks(text):
	"""Text of Boost.Python without marks of YADE, with code between backquotes."""
	text = re.sub(r"\|y\w+\|", "", marks.sub("", text.strip()))
	return references.sub(lambda found: f"`{found[2] or found[3]}`", text).strip()


def laidOut(code):
	"""Code of one line laid out as black does it."""
	return black.format_str(code, mode=black.Mode(line_length=88)).rstrip().splitlines()


def codeBlock(lines):
	return [".. code-block:: python", "", *("    " + line for line in lines), ""]


def ofClass(text):
	"""Lines for the text of a class: its first paragraph, and its example as code."""
	first = withoutMarks(text.strip().split("\n\n")[0])
	example = exampleOfClass.search(first)
	lines = [plain(exampleOfClass.sub("", first)), ""]
	return lines + (["Example:", "", *codeBlock(laidOut(example[1]))] if example else [])


def ofStaticAttributes(text):
	"""{name: text} of attributes that belong to the class as a whole; their texts stand in that of the class."""
	found = (staticAttribute.match(paragraph) for paragraph in text.split("\n\n"))
	return {match[1]: match[2] for match in found if match}


def ofMember(text, default=None):
	"""Lines for an attribute or a method of a class."""
	text = writtenSignature.sub("", withoutMarks(text))
	return [plain(text) + (f" Default: ``{default}``." if default else ""), ""]


def _ofTable(lines):
	"""A column of names and one of texts as a list. A line that begins with blanks goes on with the text before it, another one is text."""
	result, inList = [], False
	for line in lines:
		found = row.match(line)
		if found:
			result += [f"* **{plain(found[1])}**: {plain(found[2])}"]
		elif line[0].isspace():
			result += [("  " if inList else "") + plain(line.strip())]
		else:
			result += ["", plain(line)] if inList else [plain(line)]
		inList = bool(found) or inList and line[0].isspace()
	return result


def _ofBlock(lines):
	dialogue = next((k for k, line in enumerate(lines) if line.startswith(">>> ")), None)
	if dialogue is not None:
		return [*(_ofBlock(lines[:dialogue]) if dialogue else []), *lines[dialogue:], ""]
	if all(line[:1].isspace() for line in lines):
		return codeBlock(inspect.cleandoc("\n".join(["", *lines])).splitlines())
	table = next((k for k, line in enumerate(lines) if row.match(line)), None)
	if table is None:
		return [*map(plain, lines), ""]
	return [*map(plain, lines[:table]), "", *_ofTable(lines[table:]), ""]


def ofFunction(lines):
	"""Lines for a docstring of a function or a module."""
	result, block = [], []
	for line in [*(text.expandtabs(4) for text in lines), ""]:
		if line.strip():
			block.append(line)
		elif block:
			result += _ofBlock(block)
			block = []
	return result


def signature(function):
	"""Names and defaults of the arguments of a Boost.Python method, which tells them only when it is called with too many of them."""
	function = getattr(function, "__func__", function)
	function = getattr(function, "__wrapped__", function)
	function = getattr(function, "__func__", function)
	written = writtenSignature.match(function.__doc__ or "")
	if written:
		return written[1]
	if hasattr(function, "__code__"):
		arguments = list(inspect.signature(function).parameters.values())
		return "(" + ", ".join(str(one) for one in arguments if one.name not in ("self", "mpm")) + ")"  # mpm: of a tool that is a method, too
	try:
		function(*[object()] * 30)
	except TypeError as refusal:
		declared = str(refusal).split("C++ signature:")[-1]
		inside = re.sub(r"<[^()]*>", "", declared[declared.index("(") + 1 : declared.rindex(")")])
		arguments = [argument.split()[-1] for argument in inside.split(", ") if argument and "{lvalue}" not in argument]
		return "(" + ", ".join(arguments) + ")"
	raise ValueError(f"{function} takes any number of arguments: let its text begin with its name and arguments")
