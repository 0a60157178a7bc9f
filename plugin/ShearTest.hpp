// SPDX-License-Identifier: GPL-2.0-or-later
#pragma once

namespace talik {

/// Registers the function shearTests in the Python module under construction.
void exposeShearTests();

} // namespace talik
