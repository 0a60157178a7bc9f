// SPDX-License-Identifier: GPL-2.0-or-later
// Entries of the kernels for a graphics card: a block for each call.
#include <pkg/rve/device/SampleKernels.hpp>

namespace talik {
namespace N_ONE {
	extern __attribute__((shared)) Two blockMemory[];
	template <class Kernel> __attribute__((device)) inline TALIK_INLINED void runBlock(const KernelArguments& a)
	{
		if (blockNumber() < a.count) Kernel::block(a, blockNumber(), reinterpret_cast<unsigned char*>(blockMemory));
	}
} // namespace N_ONE
} // namespace talik

/// Blocks of a multiprocessor that the compiler counts on: large ones leave room for one, and take all registers that there are for it. 0: as it likes.
static constexpr int fewestBlocks(int threads) { return threads >= 448 ? 1 : 0; }

#define TALIK_KERNEL(name, dimension, threads, ...)                                                                                                       \
	extern "C" __attribute__((global)) void __attribute__((launch_bounds(threads, fewestBlocks(threads)))) name(const talik::KernelArguments arguments)                      \
	{                                                                                                                                                 \
		talik::N_ONE::runBlock<talik::N_ONE::KernelOf<dimension, threads, __VA_ARGS__>::Type>(arguments);                                         \
	}
#include <pkg/rve/device/KernelList.inc>
