// SPDX-License-Identifier: GPL-2.0-or-later
#include <cstring>
#include <pkg/rve/device/SampleDevice.hpp>
#include <pkg/rve/device/TwinKernels.hpp>

namespace talik {

namespace {
	const TwinKernel& kernelNamed(const char* name)
	{
		for (int k = 0; k < twinKernelCount; ++k)
			if (std::strcmp(twinKernels[k].shape.name, name) == 0) return twinKernels[k];
		throw DeviceFailure(std::string("the twin of the card has no kernel ") + name + "; build Talik anew");
	}

	class Twin final : public SampleDevice {
	public:
		std::string name() const override { return "twin of a card on the processor"; }
		std::size_t freeMemory() override { return std::size_t(1) << 40; }
		/// The memory of a card holds anything: numbers that were never set shall be found out.
		std::uint64_t allocate(std::size_t bytes) override { return reinterpret_cast<std::uint64_t>(std::memset(::operator new(bytes), 0xff, bytes)); }
		void          release(std::uint64_t address) noexcept override { ::operator delete(reinterpret_cast<void*>(address)); }
		void*         allocateOnHost(std::size_t bytes) override { return ::operator new(bytes); }
		void          releaseOnHost(void* memory) noexcept override { ::operator delete(memory); }
		void          copyIn(std::uint64_t to, const void* from, std::size_t bytes) override { std::memcpy(reinterpret_cast<void*>(to), from, bytes); }
		void          copyOut(void* to, std::uint64_t from, std::size_t bytes) override { std::memcpy(to, reinterpret_cast<const void*>(from), bytes); }
		void          launch(const KernelShape& kernel, const KernelArguments& a) override
		{
			const TwinKernel& twin = kernelNamed(kernel.name);
			struct alignas(16) Sixteen {
				unsigned char bytes[16];
			};
			std::vector<Sixteen> memory(std::size_t(twinMemoryOfBlock(a.layout)) / 16 + 1);
			std::memset(memory.data(), 0xff, memory.size() * sizeof(Sixteen));
			for (int block = 0; block < a.count; ++block)
				twin.run(a, block, memory.data()->bytes);
		}
		void copyInLater(std::uint64_t to, const void* from, std::size_t bytes) override { copyIn(to, from, bytes); }
		void copyOutLater(void* to, std::uint64_t from, std::size_t bytes) override { copyOut(to, from, bytes); }
		void useQueue(std::size_t) override {}
		void waitFor(std::size_t) override {}
		long memoryOfBlock() const override { return 227 * 1024; }
	};
} // namespace

std::shared_ptr<SampleDevice> makeTwin() { return std::make_shared<Twin>(); }

const std::vector<KernelShape>& sampleKernels()
{
	static const std::vector<KernelShape> shapes = [] {
		std::vector<KernelShape> all;
		for (int k = 0; k < twinKernelCount; ++k)
			all.push_back(twinKernels[k].shape);
		return all;
	}();
	return shapes;
}

long memoryOfBlock(const PlaceLayout& layout) { return twinMemoryOfBlock(layout); }

} // namespace talik
