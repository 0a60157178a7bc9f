# SPDX-License-Identifier: GPL-2.0-or-later
"""Files that Checkpoint has written: a header of plain text, the scene in YADE's binary archive, and the numbers of points and samples behind it."""

import mmap
import os

from talik import _talik

headerLength, currentFormat = 4096, 3


def read(file):
	"""The Scene in a checkpoint. One written by an older version is read if the classes that it holds have kept their attributes."""
	header = inspect(file)
	layouts = _talik.checkpointLayouts()
	changed = [name for name, layout in header["classes"].items() if layouts.get(name) != layout]
	if changed:
		with open(file, "rb") as stream, mmap.mmap(stream.fileno(), 0, access=mmap.ACCESS_READ) as content:
			end = headerLength + header["parts"]
			changed = [name for name in changed if content.find(b"yade::" + name.encode(), headerLength, end) >= 0]  # archives name what they hold
	if changed:
		_refuse(
			file,
			f"was written {header['written']} by a Talik in which {', '.join(changed)} had other attributes: resume it with that version, or start anew",
		)
	return _talik.readCheckpoint(file, header["parts"])


def describe(file):
	"""What Checkpoint.describe returns."""
	header = inspect(file)
	return {key: header[key] for key in ("format", "written", "step", "time", "bytes")}


def inspect(file):
	"""The header of a checkpoint that is whole, a dictionary. ValueError for a missing, foreign, truncated or damaged file and one of another format."""
	if not os.path.exists(file):
		_refuse(file, "does not exist: give a file that talik.checkpoint wrote")
	if not os.path.isfile(file):
		_refuse(file, "is not a file: give one that talik.checkpoint wrote")
	try:
		with open(file, "rb") as stream:
			head = stream.read(headerLength)
	except OSError as problem:
		_refuse(file, f"cannot be read ({problem.strerror}): give a file of yours")
	header = _parsed(file, head)
	length, whole = os.path.getsize(file), headerLength + header["bytes"]
	if length < whole:
		_refuse(file, f"is truncated, {length} of {whole} bytes are there: take an earlier one")
	if length > whole:
		_refuse(file, "is longer than what was written: take an earlier one")
	if _talik.checksumOfFile(file, headerLength, header["bytes"]) != header["checksum"]:
		_refuse(file, "is damaged, its checksum does not fit: take an earlier one")
	return header


def _refuse(file, why):
	raise ValueError(f"checkpoint '{file}' {why}")


def _parsed(file, head):
	first, *lines = head.decode("latin1").split("\n")
	if first != "Talik checkpoint":
		_refuse(file, "is not a checkpoint: give a file that talik.checkpoint wrote; other scenes are loaded by O.load")
	if len(head) < headerLength:
		_refuse(file, "is truncated: take an earlier one")
	given = [line.split(" ", 1) for line in lines if " " in line]
	header = {"written": "", **{key: value for key, value in given if key != "class"}}
	header["classes"] = dict(value.split(" ", 1) for key, value in given if key == "class" and " " in value)
	numbers = {"format": int, "step": int, "time": float, "bytes": int, "parts": int, "checksum": lambda text: int(text, 16)}
	damaged = "end" not in lines
	for key, kind in numbers.items():
		try:
			header[key] = kind(header[key])
		except (KeyError, ValueError):
			header[key], damaged = 0, True
	if header["format"] != currentFormat:
		_refuse(
			file,
			f"has format {header['format']}, written {header['written']}; this Talik reads format {currentFormat}: resume it with the version that wrote it",
		)
	if damaged or header["bytes"] < 0:
		_refuse(file, "is damaged in its first lines: take an earlier one")
	return header
