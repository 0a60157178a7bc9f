// SPDX-License-Identifier: GPL-2.0-or-later
#pragma once
#include <pkg/rve/device/SampleCall.hpp>

namespace talik {

/// A kernel as plain C++.
struct TwinKernel {
	KernelShape shape;
	void (*run)(const KernelArguments&, int block, unsigned char* memoryOfBlock);
};
extern const TwinKernel twinKernels[];
extern const int        twinKernelCount;

/// Memory of a block for samples of this layout [bytes].
long twinMemoryOfBlock(const PlaceLayout&);

} // namespace talik
