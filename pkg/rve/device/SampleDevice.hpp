// SPDX-License-Identifier: GPL-2.0-or-later
#pragma once
#include <functional>
#include <memory>
#include <pkg/rve/device/SampleCall.hpp>
#include <stdexcept>
#include <string>
#include <vector>

namespace talik {

/// A device that cannot be had, or that does not answer any more: what happened, and a remedy.
struct DeviceFailure : std::runtime_error {
	using std::runtime_error::runtime_error;
};

/// Where packed samples may be advanced beside the processor: its memory, and kernels that advance one sample in each block of threads.
/// One thread at a time. All functions throw DeviceFailure.
class SampleDevice {
public:
	virtual ~SampleDevice() = default;

	virtual std::string   name() const                                                  = 0;
	virtual std::size_t   freeMemory()                                                  = 0; ///< [bytes]
	virtual std::uint64_t allocate(std::size_t bytes)                                   = 0;
	virtual void          release(std::uint64_t address) noexcept                       = 0;
	virtual void*         allocateOnHost(std::size_t bytes)                             = 0; ///< what is copied fast
	virtual void          releaseOnHost(void* memory) noexcept                          = 0;
	virtual void          copyIn(std::uint64_t to, const void* from, std::size_t bytes) = 0;
	virtual void          copyOut(void* to, std::uint64_t from, std::size_t bytes)      = 0;
	/// Launches and the copies below go into the queue with this number from now on: in their order, beside those of other queues.
	virtual void useQueue(std::size_t number) = 0;
	/// The memory of the host is from allocateOnHost().
	virtual void copyInLater(std::uint64_t to, const void* from, std::size_t bytes)  = 0;
	virtual void copyOutLater(void* to, std::uint64_t from, std::size_t bytes)       = 0;
	virtual void launch(const KernelShape& kernel, const KernelArguments& arguments) = 0; ///< a block for each call
	virtual void waitFor(std::size_t queue)                                          = 0; ///< until all in it is done
	virtual long memoryOfBlock() const                                               = 0; ///< largest [bytes]
};

/// The kernels, the smaller ones first, and the memory of a block of theirs [bytes].
const std::vector<KernelShape>& sampleKernels();
long                            memoryOfBlock(const PlaceLayout& layout);

/// The twin of a card: the same kernels compiled as plain C++, run on the processor. For tests.
std::shared_ptr<SampleDevice> makeTwin();

/// The card with a number (of those that CUDA sees, and round again). Its driver is opened here, by dlopen. Throws DeviceFailure.
std::shared_ptr<SampleDevice> openCard(int number = 0);

/// What RveSkeleton.device names: "cpu" (none), "gpu", "auto" (a card where there is one), "twin". Where "gpu" cannot be had, say gets a sentence
/// and there is none. Throws std::invalid_argument on another name.
std::shared_ptr<SampleDevice> deviceNamed(const std::string& name, const std::function<void(const std::string&)>& say);

} // namespace talik
