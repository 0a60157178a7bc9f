#!/usr/bin/python3
# SPDX-License-Identifier: GPL-2.0-or-later
"""Style of the sources: clang-format for C++, black with tabs and pyflakes for Python, at most 160 characters a line.

	scripts/style.py         # names what differs, ends with 1 if anything does
	scripts/style.py --fix   # formats

Versions of clang-format lay out differently; the style is that of Debian 12 (version 14). With another one C++ is not checked.
"""

import argparse
import ast
import gc
import io
import re
import shutil
import subprocess
import sys
import tokenize
from pathlib import Path

import black
from pyflakes import checker, messages

root = Path(__file__).resolve().parents[1]
folders = "plugin pkg scripts examples tests".split()
longestLine = 160
indent = "    "
clangFormatVersion = 14
consoleNames = "O utils yade getStress".split()  # what YADE's console knows beside its classes
passedOver = {"__init__.py": messages.UnusedImport, "conftest.py": messages.RedefinedWhileUnused}  # what such files are made for


def sources(*endings):
	return sorted(path for folder in folders for path in (root / folder).rglob("*") if path.suffix in endings)


def insideStrings(text):
	"""Numbers of the lines that begin inside a string, whose blanks are content and not layout; docstrings are layout."""
	lines, statementBegins = set(), True
	for token in tokenize.generate_tokens(io.StringIO(text).readline):
		if token.type == tokenize.STRING and not statementBegins:
			lines.update(range(token.start[0] + 1, token.end[0] + 1))
		if token.type not in (tokenize.COMMENT, tokenize.NL):
			statementBegins = token.type in (tokenize.NEWLINE, tokenize.INDENT, tokenize.DEDENT)
	return lines


def reindented(text, old, new):
	"""The text with every leading `old` of a line replaced by `new`."""
	kept = insideStrings(text)
	leading = re.compile(f"(?:{old})+")
	return "".join(
		line if number in kept else leading.sub(lambda found: new * (len(found[0]) // len(old)), line, count=1) if line.startswith(old) else line
		for number, line in enumerate(text.splitlines(keepends=True), 1)
	)


def formattedPython(path):
	text = path.read_text()
	mode = black.Mode(line_length=longestLine, target_versions={black.TargetVersion.PY310})
	return reindented(black.format_str(reindented(text, "\t", indent), mode=mode), indent, "\t")


def clangFormat():
	"""Name of the formatter of the right version, or None."""
	for name in (f"clang-format-{clangFormatVersion}", "clang-format"):
		if shutil.which(name):
			version = subprocess.run([name, "--version"], capture_output=True, text=True).stdout
			if re.search(rf"version {clangFormatVersion}\.", version):
				return name
	return None


def formattedCpp(program, path):
	return subprocess.run([program, "--style=file", path], capture_output=True, text=True, check=True, cwd=root).stdout


def allFormatted(program, cpp):
	"""Whether all files of C++ are formatted, asked at once: a process for each file takes ten times as long."""
	return subprocess.run([program, "--style=file", "--dry-run", "--Werror", *cpp], capture_output=True, cwd=root).returncode == 0


def holdsStyle(path, text, fix):
	"""Whether the file is as `text` says, or is so now."""
	if path.read_text() == text:
		return True
	if fix:
		path.write_text(text)
		return True
	print(f"{path.relative_to(root)}: not formatted; run scripts/style.py --fix")
	return False


def tooLong(path):
	lines = [number for number, line in enumerate(path.read_text().splitlines(), 1) if len(line) > longestLine]
	for number in lines:
		print(f"{path.relative_to(root)}:{number}: longer than {longestLine} characters")
	return lines


def defects(path):
	"""What pyflakes finds in a file. Names of classes may be unknown to it: they are those of YADE's console."""
	text = path.read_text()
	lines = text.splitlines()
	found = [
		message
		for message in checker.Checker(ast.parse(text, str(path)), filename=str(path.relative_to(root)), builtins=consoleNames).messages
		if "# noqa" not in lines[message.lineno - 1]
		and not isinstance(message, passedOver.get(path.name, ()))
		and not (isinstance(message, messages.UndefinedName) and message.message_args[0][0].isupper())
	]
	for message in found:
		print(message)
	return found


def main():
	gc.disable()  # black's trees point both ways; to look for what can be thrown away takes a fifth of the time
	parser = argparse.ArgumentParser(description=__doc__.splitlines()[0])
	parser.add_argument("--fix", action="store_true", help="format the files")
	fix = parser.parse_args().fix
	python, cpp = sources(".py"), sources(".cpp", ".hpp", ".inc")
	program = clangFormat()
	if program is None:
		print(f"C++ is not checked: there is no clang-format {clangFormatVersion}")
	good = [holdsStyle(path, formattedPython(path), fix) for path in python]
	if program and not allFormatted(program, cpp):
		good += [holdsStyle(path, formattedCpp(program, path), fix) for path in cpp]
	good += [not tooLong(path) for path in python + cpp]
	good += [not defects(path) for path in python]
	print(f"{len(python)} files of Python and {len(cpp)} of C++ read")
	return 0 if all(good) else 1


if __name__ == "__main__":
	sys.exit(main())
