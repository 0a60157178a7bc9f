#!/usr/bin/python3
# SPDX-License-Identifier: GPL-2.0-or-later
"""Style of the sources: clang-format for C++, black with tabs and flake8 (its F) for Python, at most 160 characters a line.

	scripts/style.py         # names what differs, ends with 1 if anything does
	scripts/style.py --fix   # formats
	scripts/style.py --known FILE  # leaves out Python that was found good before; FILE keeps what was
	scripts/style.py --recent 10   # of Python only what the last 10 commits or the work tree changed

Versions of clang-format lay out differently; the style is that of Debian 12 (version 14). With another one C++ is not checked.
"""

import argparse
import hashlib
import io
import re
import shutil
import subprocess
import sys
import tokenize
from pathlib import Path

import black

root = Path(__file__).resolve().parents[1]
folders = "plugin pkg scripts examples tests".split()
longestLine = 160
indent = "    "
clangFormatVersion = 14
consoleNames = "O utils yade getStress".split()  # what YADE's console knows beside its classes


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


class Known:
	"""What was found good before, by a digest of the file, of this script and of the programs that judge; black takes most of the time of a check."""

	def __init__(self, path):
		self.path = path and Path(path)
		self.kept = set(self.path.read_text().split()) if path and self.path.exists() else set()
		programs = [black.__version__, sys.version, Path(__file__).read_text()]
		if path:
			programs.append(subprocess.run([sys.executable, "-m", "flake8", "--version"], capture_output=True, text=True).stdout)
		self.judges = "\n".join(programs).encode()

	def digest(self, path):
		return hashlib.sha256(b"\0".join([self.judges, str(path.relative_to(root)).encode(), path.read_bytes()])).hexdigest()

	def unknown(self, paths):
		return [path for path in paths if self.digest(path) not in self.kept] if self.path else paths

	def keep(self, paths):
		if self.path:
			self.path.write_text("\n".join(sorted(self.kept | set(map(self.digest, paths)))))


def changedOf(paths, commits):
	"""Those that the last commits or the work tree changed; all of them where git does not know."""
	asked = (["log", f"-{commits}", "--name-only", "--format="], ["diff", "--name-only", "HEAD"], ["ls-files", "--others", "--exclude-standard"])
	try:
		told = [subprocess.run(["git", *words], capture_output=True, text=True, check=True, cwd=root).stdout for words in asked]
	except (OSError, subprocess.CalledProcessError):
		return paths
	names = set("".join(told).split())
	return [path for path in paths if str(path.relative_to(root)) in names]


def defects(python):
	"""What flake8 finds. Names of classes may be unknown to it: they are those of YADE's console."""
	command = [
		sys.executable,
		"-m",
		"flake8",
		"--isolated",
		"--select=F,E9",
		"--builtins=" + ",".join(consoleNames),
		"--per-file-ignores=__init__.py:F401,conftest.py:F811",
		*python,
	]
	found = subprocess.run(command, capture_output=True, text=True, cwd=root)
	if found.stderr:
		raise SystemExit(found.stderr)
	lines = [line for line in found.stdout.splitlines() if not re.search(r"F821 undefined name '[A-Z]", line)]
	for line in lines:
		print(line)
	return lines


def main():
	parser = argparse.ArgumentParser(description=__doc__.splitlines()[0])
	parser.add_argument("--fix", action="store_true", help="format the files")
	parser.add_argument("--known", metavar="FILE", help="leave out the files of Python that were found good before, and keep here which were")
	parser.add_argument("--recent", metavar="COMMITS", type=int, help="of Python only what so many last commits or the work tree changed")
	options = parser.parse_args()
	fix, known = options.fix, Known(options.known)
	python, cpp = sources(".py"), sources(".cpp", ".hpp", ".inc")
	changed = known.unknown(python if options.recent is None else changedOf(python, options.recent))
	program = clangFormat()
	if program is None:
		print(f"C++ is not checked: there is no clang-format {clangFormatVersion}")
	good = [holdsStyle(path, formattedPython(path), fix) for path in changed]
	if program and not allFormatted(program, cpp):
		good += [holdsStyle(path, formattedCpp(program, path), fix) for path in cpp]
	good += [not tooLong(path) for path in python + cpp]
	good.append(not changed or not defects(changed))
	print(f"{len(changed)} of {len(python)} files of Python and {len(cpp)} of C++ read")
	if all(good):
		known.keep(changed)
	return 0 if all(good) else 1


if __name__ == "__main__":
	sys.exit(main())
