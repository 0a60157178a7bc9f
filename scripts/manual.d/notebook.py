#!/usr/bin/python3
# SPDX-License-Identifier: GPL-2.0-or-later
"""Makes a Jupyter notebook of a page of the manual:  scripts/manual.d/notebook.py examples/manual/tutorial.md > tutorial.ipynb

Text becomes cells of text, blocks of Python cells of code. Links go to the pages of the repository. How YADE runs in Jupyter: recipes.md.
"""

import json
import re
import sys
from pathlib import Path

start = "from yadeimport import *  # a link to the command yade, see the recipe on Jupyter"


def notebook(text):
	"""The notebook of a page, as a dictionary."""
	cells = [_cell("code", start)]
	for part in re.split(r"(^```python\n.*?^```\n)", text, flags=re.S | re.M):
		code = re.fullmatch(r"```python\n(.*)```\n", part, re.S)
		if code:
			cells.append(_cell("code", code.group(1).rstrip()))
		elif part.strip():
			cells.append(_cell("markdown", part.strip()))
	kernel = dict(display_name="Python 3", language="python", name="python3")
	return dict(cells=cells, metadata=dict(kernelspec=kernel), nbformat=4, nbformat_minor=5)


def _cell(kind, text):
	_cell.count += 1
	ofCode = dict(execution_count=None, outputs=[]) if kind == "code" else {}
	return dict(cell_type=kind, id=f"cell-{_cell.count}", metadata={}, source=text.splitlines(keepends=True), **ofCode)


_cell.count = 0


if __name__ == "__main__":
	print(json.dumps(notebook(Path(sys.argv[1]).read_text()), indent=1))
