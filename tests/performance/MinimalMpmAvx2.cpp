// SPDX-License-Identifier: GPL-2.0-or-later
#include "MinimalMpm.hpp"

#if defined(__x86_64__)
#pragma GCC target("avx2,fma")
#endif
#include "MinimalMpm.inc"

namespace minimal {
extern const Kernel avx2;
const Kernel        avx2 { "avx2", &step };
} // namespace minimal
