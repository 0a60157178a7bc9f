// SPDX-License-Identifier: GPL-2.0-or-later
// In place of NVIDIA's driver in tests: the functions that Talik calls, with the memory of the host and the twins of the kernels.
// TALIK_STUB_DRIVER says what goes wrong, in words: "none" (no card), "capability 52", "memory 1000000" (free bytes), and of a function "fail
// cuLaunchKernel 3 719": its third call gives error 719, and all later ones.
#include <cstdlib>
#include <cstring>
#include <pkg/rve/device/TwinKernels.hpp>
#include <sstream>
#include <string>
#include <vector>

namespace {

int         calls, failAt, failWith, capability, devices;
std::size_t memory;
std::string failing;
bool        broken;

/// What the environment asks for, from now on.
void readWishes()
{
	calls = failAt = failWith = 0;
	capability                = 90;
	devices                   = 1;
	memory                    = std::size_t(16) << 30;
	failing.clear();
	broken                    = false;
	const char* const  wishes = std::getenv("TALIK_STUB_DRIVER");
	std::istringstream words(wishes ? wishes : "");
	for (std::string word; words >> word;) {
		if (word == "none") devices = 0;
		if (word == "capability") words >> capability;
		if (word == "memory") words >> memory;
		if (word == "fail") words >> failing >> failAt >> failWith;
	}
}

int answer(const char* function)
{
	if (failing == function && ++calls >= failAt) broken = true;
	return broken ? failWith : 0;
}

} // namespace

extern "C" {

int cuInit(unsigned)
{
	readWishes();
	if (devices == 0) return 100;
	return answer("cuInit");
}
int cuDeviceGetCount(int* count)
{
	*count = devices;
	return answer("cuDeviceGetCount");
}
int cuDeviceGet(int* device, int number)
{
	*device = number;
	return answer("cuDeviceGet");
}
int cuDeviceGetName(char* name, int length, int)
{
	std::strncpy(name, "stub of a card", std::size_t(length) - 1);
	return answer("cuDeviceGetName");
}
int cuDeviceGetAttribute(int* value, int which, int)
{
	*value = which == 75 ? capability / 10 : which == 76 ? capability % 10 : which == 97 ? 227 * 1024 : 1024;
	return answer("cuDeviceGetAttribute");
}
int cuDevicePrimaryCtxRetain(void** context, int)
{
	*context = &memory;
	return answer("cuDevicePrimaryCtxRetain");
}
int cuDevicePrimaryCtxRelease_v2(int) { return answer("cuDevicePrimaryCtxRelease_v2"); }
int cuCtxSetCurrent(void*) { return answer("cuCtxSetCurrent"); }
int cuMemGetInfo_v2(std::size_t* free, std::size_t* all)
{
	*free = *all = memory;
	return answer("cuMemGetInfo_v2");
}
int cuMemAlloc_v2(unsigned long long* address, std::size_t bytes)
{
	if (bytes > memory) return 2;
	*address = reinterpret_cast<unsigned long long>(std::malloc(bytes));
	memory -= bytes;
	return answer("cuMemAlloc_v2");
}
int cuMemFree_v2(unsigned long long address)
{
	std::free(reinterpret_cast<void*>(address));
	return answer("cuMemFree_v2");
}
int cuMemHostAlloc(void** memoryOfHost, std::size_t bytes, unsigned)
{
	*memoryOfHost = std::malloc(bytes);
	return answer("cuMemHostAlloc");
}
int cuMemFreeHost(void* memoryOfHost)
{
	std::free(memoryOfHost);
	return answer("cuMemFreeHost");
}
int cuMemcpyHtoD_v2(unsigned long long to, const void* from, std::size_t bytes)
{
	std::memcpy(reinterpret_cast<void*>(to), from, bytes);
	return answer("cuMemcpyHtoD_v2");
}
int cuMemcpyDtoH_v2(void* to, unsigned long long from, std::size_t bytes)
{
	const int result = answer("cuMemcpyDtoH_v2");
	if (result == 0) std::memcpy(to, reinterpret_cast<const void*>(from), bytes);
	return result;
}
int cuModuleLoadDataEx(void** module, const void*, unsigned, int*, void**)
{
	*module = &memory;
	return answer("cuModuleLoadDataEx");
}
int cuModuleUnload(void*) { return answer("cuModuleUnload"); }
int cuModuleGetFunction(void** function, void*, const char* name)
{
	for (int k = 0; k < talik::twinKernelCount; ++k)
		if (std::strcmp(talik::twinKernels[k].shape.name, name) == 0) {
			*function = const_cast<talik::TwinKernel*>(talik::twinKernels + k);
			return answer("cuModuleGetFunction");
		}
	return 500;
}
int cuFuncSetAttribute(void*, int, int) { return answer("cuFuncSetAttribute"); }
int cuLaunchKernel(
        void* function, unsigned blocks, unsigned, unsigned, unsigned threads, unsigned, unsigned, unsigned memoryOfBlock, void*, void** arguments, void**)
{
	const int result = answer("cuLaunchKernel");
	if (result) return result;
	const auto&                   kernel = *static_cast<const talik::TwinKernel*>(function);
	const talik::KernelArguments& a      = *static_cast<const talik::KernelArguments*>(arguments[0]);
	if (int(threads) != kernel.shape.threads) return 1;
	std::vector<long double> space(memoryOfBlock / sizeof(long double) + 1); // aligned as the kernels want it
	for (unsigned k = 0; k < blocks; ++k)
		kernel.run(a, int(k), reinterpret_cast<unsigned char*>(space.data()));
	return 0;
}
int cuMemcpyHtoDAsync_v2(unsigned long long to, const void* from, std::size_t bytes, void*)
{
	std::memcpy(reinterpret_cast<void*>(to), from, bytes);
	return answer("cuMemcpyHtoDAsync_v2");
}
int cuMemcpyDtoHAsync_v2(void* to, unsigned long long from, std::size_t bytes, void*)
{
	const int result = answer("cuMemcpyDtoHAsync_v2");
	if (result == 0) std::memcpy(to, reinterpret_cast<const void*>(from), bytes);
	return result;
}
int cuStreamCreate(void** stream, unsigned)
{
	*stream = &memory;
	return answer("cuStreamCreate");
}
int cuStreamDestroy_v2(void*) { return answer("cuStreamDestroy_v2"); }
int cuStreamSynchronize(void*) { return answer("cuStreamSynchronize"); }
int cuGetErrorName(int error, const char** name)
{
	*name = error == 2     ? "CUDA_ERROR_OUT_OF_MEMORY"
	        : error == 100 ? "CUDA_ERROR_NO_DEVICE"
	        : error == 719 ? "CUDA_ERROR_LAUNCH_FAILED"
	                       : "CUDA_ERROR_UNKNOWN";
	return 0;
}
}
