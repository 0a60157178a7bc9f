# SPDX-License-Identifier: GPL-2.0-or-later
"""The folder of the examples, whose scenes and presets the study measures."""

import sys
from pathlib import Path

folder = Path(__file__).resolve().parents[4] / "examples"
if not (folder / "thaw_slump_surface.py").exists():
	raise ImportError("talik.studies.accuracy measures the examples of the repository: run scripts/accuracy in a clone of it")
if str(folder) not in sys.path:
	sys.path.insert(0, str(folder))
