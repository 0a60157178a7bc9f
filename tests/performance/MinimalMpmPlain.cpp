// SPDX-License-Identifier: GPL-2.0-or-later
#include "MinimalMpm.hpp"

#include "MinimalMpm.inc"

namespace minimal {
extern const Kernel plain;
const Kernel        plain { "plain", &step };
} // namespace minimal
