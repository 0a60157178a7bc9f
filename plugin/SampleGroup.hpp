// SPDX-License-Identifier: GPL-2.0-or-later
#pragma once

namespace talik {

/// Registers the class SampleGroup in the Python module under construction.
void exposeSampleGroup();

} // namespace talik
