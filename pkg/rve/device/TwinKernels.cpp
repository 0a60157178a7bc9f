// SPDX-License-Identifier: GPL-2.0-or-later
// The kernels of the card, compiled for a processor: thread after thread. Its header of Highway is that of this folder.
#include <pkg/rve/device/SampleKernels.hpp>
#include <pkg/rve/device/TwinKernels.hpp>

namespace talik {

namespace {
	template <int Dim, int Threads, int GrainsEach, int PairsEach, bool Bonded, bool Hertz> constexpr TwinKernel twinOf(const char* name)
	{
		using Kernel = typename N_ONE::KernelOf<Dim, Threads, GrainsEach, PairsEach, Bonded, Hertz>::Type;
		return { { name, Dim, Threads, GrainsEach, PairsEach, Bonded, Hertz },
			 [](const KernelArguments& arguments, int block, unsigned char* memory) { Kernel::block(arguments, block, memory); } };
	}
} // namespace

#define TALIK_KERNEL(name, ...) twinOf<__VA_ARGS__>(#name),
const TwinKernel twinKernels[] = {
#include <pkg/rve/device/KernelList.inc>
};
#undef TALIK_KERNEL
const int twinKernelCount = int(sizeof(twinKernels) / sizeof(twinKernels[0]));

long twinMemoryOfBlock(const PlaceLayout& l)
{
	return l.dimension == 2 ? N_ONE::Shared<2>::bytes(l.grains, l.pairs) : N_ONE::Shared<3>::bytes(l.grains, l.pairs);
}

} // namespace talik
