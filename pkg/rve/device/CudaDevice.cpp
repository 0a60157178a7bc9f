// SPDX-License-Identifier: GPL-2.0-or-later
// A card of NVIDIA's. Its driver is opened by dlopen when a card is asked for, so that nothing of NVIDIA's is needed to build or to run without.
#include <cstdlib>
#include <cstring>
#include <dlfcn.h>
#include <map>
#include <pkg/rve/device/CardCode.hpp>
#include <pkg/rve/device/SampleDevice.hpp>

namespace talik {

namespace {

	// What the driver's interface is made of (CUDA Driver API): numbers of attributes and errors are fixed.
	using Result                     = int;
	using Device                     = int;
	using Context                    = void*;
	using Module                     = void*;
	using Kernel                     = void*;
	using Address                    = unsigned long long;
	constexpr int mostThreadsOfBlock = 1, capabilityMajor = 75, capabilityMinor = 76, mostMemoryOfBlock = 97; // of a device
	constexpr int dynamicMemoryOfKernel = 8;
	constexpr int leastCapability       = 70; ///< 10 times major + minor: what the kernels are compiled for
	enum : Result { success = 0, outOfMemory = 2, noDevice = 100, unavailable = 46, insufficientDriver = 35, unsupportedPtx = 222, noImage = 209 };

	const char* const pageOfCards = "the manual's page 'Samples on a graphics card'";

	// X(what it is called here, its name, its arguments)
#define TALIK_CUDA_FUNCTIONS                                                                                                               \
	X(init, "cuInit", (unsigned))                                                                                                      \
	X(deviceCount, "cuDeviceGetCount", (int*))                                                                                         \
	X(deviceGet, "cuDeviceGet", (Device*, int))                                                                                        \
	X(deviceName, "cuDeviceGetName", (char*, int, Device))                                                                             \
	X(deviceAttribute, "cuDeviceGetAttribute", (int*, int, Device))                                                                    \
	X(retain, "cuDevicePrimaryCtxRetain", (Context*, Device))                                                                          \
	X(releaseContext, "cuDevicePrimaryCtxRelease_v2", (Device))                                                                        \
	X(setCurrent, "cuCtxSetCurrent", (Context))                                                                                        \
	X(memoryInfo, "cuMemGetInfo_v2", (std::size_t*, std::size_t*))                                                                     \
	X(allocate, "cuMemAlloc_v2", (Address*, std::size_t))                                                                              \
	X(release, "cuMemFree_v2", (Address))                                                                                              \
	X(allocateOnHost, "cuMemHostAlloc", (void**, std::size_t, unsigned))                                                               \
	X(releaseOnHost, "cuMemFreeHost", (void*))                                                                                         \
	X(copyIn, "cuMemcpyHtoD_v2", (Address, const void*, std::size_t))                                                                  \
	X(copyOut, "cuMemcpyDtoH_v2", (void*, Address, std::size_t))                                                                       \
	X(loadModule, "cuModuleLoadDataEx", (Module*, const void*, unsigned, int*, void**))                                                \
	X(unloadModule, "cuModuleUnload", (Module))                                                                                        \
	X(kernelNamed, "cuModuleGetFunction", (Kernel*, Module, const char*))                                                              \
	X(setKernelAttribute, "cuFuncSetAttribute", (Kernel, int, int))                                                                    \
	X(launch, "cuLaunchKernel", (Kernel, unsigned, unsigned, unsigned, unsigned, unsigned, unsigned, unsigned, void*, void**, void**)) \
	X(copyInLater, "cuMemcpyHtoDAsync_v2", (Address, const void*, std::size_t, void*))                                                 \
	X(copyOutLater, "cuMemcpyDtoHAsync_v2", (void*, Address, std::size_t, void*))                                                      \
	X(createStream, "cuStreamCreate", (void**, unsigned))                                                                              \
	X(destroyStream, "cuStreamDestroy_v2", (void*))                                                                                    \
	X(waitForStream, "cuStreamSynchronize", (void*))                                                                                   \
	X(errorName, "cuGetErrorName", (Result, const char**))

	/// The driver, once it is open.
	class Driver {
	public:
		explicit Driver(const char* file)
		        : library(dlopen(file, RTLD_NOW | RTLD_LOCAL))
		{
			if (!library)
				throw DeviceFailure(
				        "There is no driver of NVIDIA's here (" + std::string(dlerror())
				        + "). Install Debian's package nvidia-driver of non-free, see " + pageOfCards + ", or set device='cpu'.");
#define X(function, name, arguments) find(function, name);
			TALIK_CUDA_FUNCTIONS
#undef X
		}
		~Driver() { dlclose(library); }
		Driver(const Driver&)            = delete;
		Driver& operator=(const Driver&) = delete;

		/// Throws with what was tried and a remedy where the driver did not do it.
		void check(Result result, const std::string& what) const
		{
			if (result == success) return;
			const char* name = nullptr;
			errorName(result, &name);
			throw DeviceFailure(
			        "The graphics card failed " + what + " (" + (name ? name : "error " + std::to_string(result)) + "). " + remedy(result));
		}

#define X(function, name, arguments) Result(*function) arguments;
		TALIK_CUDA_FUNCTIONS
#undef X

	private:
		template <class Function> void find(Function& function, const char* name)
		{
			function = reinterpret_cast<Function>(dlsym(library, name));
			if (!function)
				throw DeviceFailure(
				        "The driver of NVIDIA's here is too old: it has no " + std::string(name) + ". Install a newer nvidia-driver, see "
				        + pageOfCards + ", or set device='cpu'.");
		}
		static std::string remedy(Result result)
		{
			switch (result) {
				case outOfMemory: return "Other programs have taken its memory: end them, or take fewer or smaller samples.";
				case noDevice:
					return "There is none: see with nvidia-smi, and with CUDA_VISIBLE_DEVICES whether it is hidden; or set device='cpu'.";
				case unavailable: return "Another program has it for itself: end that, or set the card to shared use (nvidia-smi -c 0).";
				case insufficientDriver:
				case unsupportedPtx: return "Its driver is too old: install a newer nvidia-driver.";
				case noImage: return "It is too old for the kernels, which need compute capability 7.0.";
				default:
					return "nvidia-smi and the kernel's log (dmesg, lines with Xid) say more; a restart of the machine helps where it "
					       "hangs.";
			}
		}
		void* library;
	};

	class Cuda final : public SampleDevice {
	public:
		/// stands: the driver is another one, which needs no code.
		Cuda(const char* file, int wished, bool stands)
		        : driver(file)
		{
			if (!cardCode() && !stands) throw DeviceFailure(std::string("Talik was built without kernels for cards: ") + cardCodeMissing());
			int count = 0;
			driver.check(driver.init(0), "to begin");
			driver.check(driver.deviceCount(&count), "to be counted");
			if (count < 1) driver.check(noDevice, "to be found");
			driver.check(driver.deviceGet(&device, wished % count), "to be found");
			char text[256] = "";
			driver.check(driver.deviceName(text, sizeof(text), device), "to say its name");
			const int capability = 10 * attribute(capabilityMajor) + attribute(capabilityMinor);
			title                = text;
			if (capability < leastCapability)
				throw DeviceFailure(
				        title + " has compute capability " + std::to_string(capability / 10) + "." + std::to_string(capability % 10)
				        + "; the kernels need 7.0 (Volta, 2017) or more. Set device='cpu', or take a later card.");
			driver.check(driver.retain(&context, device), "to be used");
			try {
				begin();
			} catch (...) {
				end();
				throw;
			}
		}
		~Cuda() override { end(); }

		std::string name() const override { return title; }
		std::size_t freeMemory() override
		{
			current();
			std::size_t free = 0, all = 0;
			driver.check(driver.memoryInfo(&free, &all), "to say how much memory is free");
			return free;
		}
		std::uint64_t allocate(std::size_t bytes) override
		{
			current();
			Address address = 0;
			driver.check(driver.allocate(&address, bytes), "to give " + std::to_string(bytes >> 20) + " MiB of memory");
			return address;
		}
		void release(std::uint64_t address) noexcept override
		{
			driver.setCurrent(context);
			driver.release(address);
		}
		void* allocateOnHost(std::size_t bytes) override
		{
			constexpr unsigned forAllContexts = 1;
			current();
			void* memory = nullptr;
			driver.check(
			        driver.allocateOnHost(&memory, bytes, forAllContexts), "to lock " + std::to_string(bytes >> 20) + " MiB of the host's memory");
			return memory;
		}
		void releaseOnHost(void* memory) noexcept override
		{
			driver.setCurrent(context);
			driver.releaseOnHost(memory);
		}
		void copyIn(std::uint64_t to, const void* from, std::size_t bytes) override
		{
			current();
			driver.check(driver.copyIn(to, from, bytes), "to take samples");
		}
		void copyOut(void* to, std::uint64_t from, std::size_t bytes) override
		{
			current();
			driver.check(driver.copyOut(to, from, bytes), "to give samples back");
		}
		void launch(const KernelShape& shape, const KernelArguments& given) override
		{
			current();
			const long memory = talik::memoryOfBlock(given.layout);
			Kernel     kernel = kernels[shape.name];
			if (!kernel) {
				driver.check(driver.kernelNamed(&kernel, module, shape.name), "to find its kernel");
				kernels[shape.name] = kernel;
			}
			driver.check(driver.setKernelAttribute(kernel, dynamicMemoryOfKernel, int(memory)), "to give a block its memory");
			KernelArguments arguments  = given;
			void*           pointers[] = { &arguments };
			driver.check(
			        driver.launch(kernel, unsigned(given.count), 1, 1, unsigned(shape.threads), 1, 1, unsigned(memory), queue, pointers, nullptr),
			        "to begin a step of the samples");
		}
		void copyInLater(std::uint64_t to, const void* from, std::size_t bytes) override
		{
			current();
			driver.check(driver.copyInLater(to, from, bytes, queue), "to take calls");
		}
		void copyOutLater(void* to, std::uint64_t from, std::size_t bytes) override
		{
			current();
			driver.check(driver.copyOutLater(to, from, bytes, queue), "to give answers");
		}
		void useQueue(std::size_t number) override
		{
			constexpr unsigned besideOthers = 1;
			current();
			while (queues.size() <= number) {
				void* made = nullptr;
				driver.check(driver.createStream(&made, besideOthers), "to make a queue for launches");
				queues.push_back(made);
			}
			queue = queues[number];
		}
		void waitFor(std::size_t number) override
		{
			current();
			driver.check(driver.waitForStream(queues[number]), "in a step of the samples");
		}
		long memoryOfBlock() const override { return blockMemory; }

	private:
		int attribute(int which) const
		{
			int value = 0;
			driver.check(driver.deviceAttribute(&value, which, device), "to say what it is");
			return value;
		}
		/// Steps come from threads that change.
		void current() { driver.check(driver.setCurrent(context), "to be used"); }
		void begin()
		{
			current();
			blockMemory = attribute(mostMemoryOfBlock);
			driver.check(driver.loadModule(&module, cardCode(), 0, nullptr, nullptr), "to take its kernels");
		}
		void end()
		{
			driver.setCurrent(context);
			for (void* const made : queues)
				driver.destroyStream(made);
			if (module) driver.unloadModule(module);
			driver.releaseContext(device);
		}

		Driver                        driver;
		Device                        device  = 0;
		Context                       context = nullptr;
		Module                        module  = nullptr;
		std::map<std::string, Kernel> kernels;
		std::vector<void*>            queues;
		void*                         queue = nullptr; ///< in use
		std::string                   title;
		long                          blockMemory = 0;
	};

} // namespace

std::shared_ptr<SampleDevice> openCard(int number)
{
	const char* const other = std::getenv("TALIK_CUDA_DRIVER");
	return std::make_shared<Cuda>(other ? other : "libcuda.so.1", number, other != nullptr);
}

std::shared_ptr<SampleDevice> deviceNamed(const std::string& name, const std::function<void(const std::string&)>& say)
{
	if (name == "cpu") return nullptr;
	if (name == "twin") return makeTwin();
	if (name != "gpu" && name != "auto") throw std::invalid_argument("'" + name + "' is no device: choose cpu, gpu, auto or twin");
	const char* const rank = std::getenv("OMPI_COMM_WORLD_LOCAL_RANK"); // ranks of one machine share out its cards
	try {
		return openCard(rank ? std::atoi(rank) : 0);
	} catch (const DeviceFailure& failure) {
		if (name == "gpu") say(std::string(failure.what()) + " The run goes on on the processor, with the same bits.");
		return nullptr;
	}
}

} // namespace talik
