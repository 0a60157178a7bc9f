# SPDX-License-Identifier: GPL-2.0-or-later
"""Runs pytest inside the stock yade:  yade -n -x tests/yade/run_in_yade.py [pytest arguments]

Without arguments every test_*.py beside this file. The exit status is pytest's: yade itself would end with 0."""

import os
import sys
from pathlib import Path

import pytest

import talik  # before any engine exists  # noqa: F401: loads the plugin

here = Path(sys.argv[0]).resolve().parent
sys.path.insert(0, str(here))
arguments = sys.argv[1:] or [str(here)]
status = pytest.main(arguments)
sys.stdout.flush()
sys.stderr.flush()
os._exit(int(status))  # a yade with threads and Python objects in flight may not end otherwise
