# SPDX-License-Identifier: GPL-2.0-or-later
"""Sphinx reads this file when build.py makes the manual."""

import inspect
import re
from pathlib import Path

import helptexts
import reference
from yade import wrapper

root = Path(__file__).resolve().parents[2]
project = "Talik"
author = copyright = "the Talik developers"
version = release = re.search(r"project\(talik VERSION (\S+)", (root / "CMakeLists.txt").read_text())[1]

extensions = ["sphinx.ext.autodoc", "myst_parser"]
root_doc = "index"
exclude_patterns = ["examples/thawslump", "examples/thawbowl"]
myst_heading_anchors = 3
html_theme = "furo"
html_title = f"Talik {version}"
html_static_path = ["manual.css"]
html_css_files = ["manual.css"]
html_copy_source = False
highlight_language = "none"  # indented blocks are equations
add_module_names = False
autodoc_member_order = "bysource"
autodoc_typehints = "none"


def ownerOf(name):
	"""Class of Boost.Python that a full name such as talik.MpmEngine.field belongs to, or None."""
	cls = getattr(wrapper, name.split(".")[1], None) if name.count(".") else None
	return cls if cls in reference.classes() else None


def cleanText(app, what, name, obj, options, lines):
	cls = ownerOf(name)
	if what == "class" and cls:
		lines[:] = helptexts.ofClass(cls.__doc__)
	elif cls and not (inspect.isfunction(obj) and hasattr(getattr(obj, "__wrapped__", obj), "__code__")):
		member = name.split(".")[-1]
		text = helptexts.ofStaticAttributes(cls.__doc__).get(member) or obj.__doc__
		declared = what == "attribute" and ":yattrtype:" in text
		lines[:] = helptexts.ofMember(text, reference.default(cls, member) if declared else None)
	else:
		lines[:] = helptexts.ofFunction(inspect.getdoc(obj).splitlines() if obj.__doc__ else [])


def cleanSignature(app, what, name, obj, options, signature, returned):
	"""Objects of Boost.Python are made from attributes by name; __init__(*args) says nothing."""
	return ("", None) if what == "class" and ownerOf(name) else None


def setup(app):
	app.connect("autodoc-process-docstring", cleanText)
	app.connect("autodoc-process-signature", cleanSignature)
