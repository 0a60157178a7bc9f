// SPDX-License-Identifier: GPL-2.0-or-later
#pragma once

namespace talik {

/// The kernels as PTX, which the driver makes into code of its card; nullptr where Talik was built without them.
const char* cardCode();
/// Why, and a remedy.
const char* cardCodeMissing();

} // namespace talik
