# SPDX-License-Identifier: GPL-2.0-or-later
"""apply.py PAGE OUTPUT: copies of the files that the ```diff blocks of a how-to change, with the changes, under OUTPUT.

A block is a unified diff with paths from the root of the repository. Its lines of context have to stand in the file once."""

import re
import sys
from pathlib import Path

root = Path(__file__).resolve().parents[2]


def changed(text, hunk, where):
	"""The text with one hunk applied."""
	lines = [line for line in hunk if line]
	before = "\n".join(line[1:] for line in lines if line[0] in " -")
	after = "\n".join(line[1:] for line in lines if line[0] in " +")
	if text.count(before) != 1:
		raise SystemExit(f"{where}: these lines stand there {text.count(before)} times, not once:\n{before}")
	return text.replace(before, after)


def main(page, output):
	files = {}
	for block in re.findall(r"^```diff\n(.*?)^```", Path(page).read_text(), re.S | re.M):
		path, *hunks = re.split(r"^@@.*\n", block, flags=re.M)
		path = re.search(r"^\+\+\+ (\S+)", path, re.M).group(1)
		for hunk in hunks:
			files[path] = changed(files.get(path) or (root / path).read_text(), hunk.split("\n"), path)
	for path, text in files.items():
		target = Path(output) / path
		target.parent.mkdir(parents=True, exist_ok=True)
		if not target.exists() or target.read_text() != text:
			target.write_text(text)
	print(f"{len(files)} files changed by {page}")


main(*sys.argv[1:])
