// SPDX-License-Identifier: GPL-2.0-or-later
#if defined(__x86_64__)
#include <pkg/mpm/kernels/PlaneLoops.inc>

namespace talik {

extern const PlaneLoops planeLoopsAvx512;
constexpr PlaneLoops    planeLoopsAvx512 = loopsNamed("Avx512");

} // namespace talik
#endif
