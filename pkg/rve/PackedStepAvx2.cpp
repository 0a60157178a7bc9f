// SPDX-License-Identifier: GPL-2.0-or-later
#include <pkg/rve/PackedStepView.hpp>
namespace talik {
PackedKernel<2> avx2Kernel(bool) { return { nullptr, nullptr, "avx2" }; }
bool            avx2KernelBuilt() { return false; }
} // namespace talik
