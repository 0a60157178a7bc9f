# SPDX-License-Identifier: GPL-2.0-or-later
"""Writing files and folders so that nothing is left half done."""

import bz2
import fcntl
import gzip
import hashlib
import os
import shutil
import sys
import tempfile
import zlib
from contextlib import contextmanager
from pathlib import Path


def writableFolder(path, remedy="choose another one"):
	"""Makes the folder if need be; one error that names it when it cannot be written."""
	folder = Path(path)
	try:
		folder.mkdir(parents=True, exist_ok=True)
		with tempfile.TemporaryFile(dir=folder):
			return folder
	except OSError as error:
		raise RuntimeError(f"folder '{folder}' cannot be written ({error.strerror}); {remedy}") from None


def writeWhole(path, content):
	"""Writes text or bytes so that a reader sees the old file or the complete new one, never a part. What is beside it has a name that
	cannot be foreseen: no file or link of the user's is written through or removed."""
	path = Path(path)
	name = None
	try:
		handle, name = tempfile.mkstemp(dir=path.parent, prefix=f".{path.name}.", suffix=".part")
		with os.fdopen(handle, "wb") as file:
			file.write(content.encode() if isinstance(content, str) else content)
			file.flush()
			os.fsync(file.fileno())
		os.chmod(name, 0o644)
		os.replace(name, path)
	except BaseException as failure:
		if name and os.path.exists(name):
			os.unlink(name)
		if isinstance(failure, OSError):
			raise RuntimeError(f"file '{path}' could not be written: {failure.strerror or failure}") from None
		raise


@contextmanager
def heldAlone(path, waitingFor):
	"""One process at a time passes here with this file, which it leaves behind empty; another waits, and says for what. On a file system without
	locks nobody waits."""
	with open(path, "a") as file:
		try:
			fcntl.flock(file, fcntl.LOCK_EX | fcntl.LOCK_NB)
		except BlockingIOError:
			print(f"talik: waiting for {waitingFor}, which another process makes", file=sys.stderr, flush=True)
			fcntl.flock(file, fcntl.LOCK_EX)
		except OSError:
			pass
		yield


# --- scenes of YADE --------------------------------------------------------------------------------------------------------
# An archive that is damaged ends YADE or is read as another scene: its bytes are checked before Boost sees them. Packed files have a
# checksum of their own; to others O.save adds a line, which YADE does not read.

_packed = {".gz": gzip.decompress, ".bz2": bz2.decompress}
_packers = {".gz": lambda content: gzip.compress(content, 6, mtime=0), ".bz2": bz2.compress}
_mark = b"\n<!-- Talik checksum "
_lineLength = len(_mark) + 64 + len(b" -->\n")


def sceneContent(path):
	"""The bytes of a scene that YADE saved, unpacked; ValueError for a file that is damaged or cut off."""
	content = Path(path).read_bytes()
	unpack = _packed.get(Path(path).suffix)
	if unpack is not None:
		try:
			return unpack(content)
		except (OSError, EOFError, ValueError, zlib.error) as problem:
			raise ValueError(f"'{path}' is damaged or cut off ({problem}): take an earlier file, or make it anew") from None
	line = content[-_lineLength:]
	if not line.startswith(_mark):
		if _mark in content:
			raise ValueError(f"'{path}' is damaged or cut off behind its checksum: take an earlier file, or make it anew")
		# Boost ends the process where the last tag is not whole: it finds that in a destructor
		if Path(path).suffix == ".xml" and not content.rstrip().endswith(b"</boost_serialization>"):
			raise ValueError(f"'{path}' is damaged or cut off, its last tag is missing: take an earlier file, or make it anew")
		return content
	if line != _checksumLine(content[:-_lineLength]):
		raise ValueError(f"'{path}' is damaged, its checksum does not fit: take an earlier file, or make it anew")
	return content[:-_lineLength]


def saveScene(path, saveWith):
	"""Has a scene saved by saveWith(file name), as YADE does, and puts it in its place with a checksum when all of it is there.

	YADE packs while it writes, and for ever where the disk is full: it writes a plain file here."""
	path = Path(path)
	kind = ".xml" if ".xml" in path.suffixes[-2:] else ".yade"
	try:
		with tempfile.TemporaryDirectory(dir=path.parent, prefix=".talik-") as folder:
			plain = Path(folder) / ("scene" + kind)
			saveWith(str(plain))
			content = plain.read_bytes()
	except (RuntimeError, OSError) as problem:
		why = problem.strerror if isinstance(problem, OSError) else f"{problem}, {_roomOf(path)}"
		raise RuntimeError(f"scene file '{path}' could not be written: {why}") from None
	pack = _packers.get(path.suffix)
	writeWhole(path, pack(content) if pack else content + _checksumLine(content))


def _roomOf(path):
	return f"{shutil.disk_usage(path.parent).free / 1e6:.1f} MB are free on its disk"


def _checksumLine(content):
	return _mark + hashlib.sha256(content).hexdigest().encode() + b" -->\n"
