# SPDX-License-Identifier: GPL-2.0-or-later
"""Writing files and folders so that nothing is left half done."""

import os
import tempfile
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
	"""Writes text or bytes so that a reader sees the old file or the complete new one, never a part."""
	path = Path(path)
	handle, name = tempfile.mkstemp(dir=path.parent, prefix=path.name)
	try:
		with os.fdopen(handle, "wb") as file:
			file.write(content.encode() if isinstance(content, str) else content)
		os.chmod(name, 0o644)
		os.replace(name, path)
	except BaseException:
		os.unlink(name)
		raise
