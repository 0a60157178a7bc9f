// SPDX-License-Identifier: GPL-2.0-or-later
#if defined(__x86_64__)
#include <pkg/mpm/kernels/PlaneLoops.inc>

namespace talik {

extern const PlaneLoops planeLoopsAvx2;
constexpr PlaneLoops    planeLoopsAvx2 = loopsNamed("Avx2");

} // namespace talik
#endif
