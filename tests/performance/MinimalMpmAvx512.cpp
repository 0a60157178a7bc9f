// SPDX-License-Identifier: GPL-2.0-or-later
#include "MinimalMpm.hpp"

#if defined(__x86_64__)
#pragma GCC target("avx512f,avx512dq,avx512vl,avx2,fma,prefer-vector-width=512")
#endif
#include "MinimalMpm.inc"

namespace minimal {
extern const Kernel avx512;
const Kernel        avx512 { "avx512", &step };
} // namespace minimal
