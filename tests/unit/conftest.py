# SPDX-License-Identifier: GPL-2.0-or-later
"""The modules of the package that need no YADE, importable without the plugin: `talik` here is the source folder as a bare package."""

import sys
import types
from pathlib import Path

package = types.ModuleType("talik")
package.__path__ = [str(Path(__file__).parents[2] / "scripts" / "talik")]
sys.modules.setdefault("talik", package)
