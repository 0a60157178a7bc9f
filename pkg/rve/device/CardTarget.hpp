// SPDX-License-Identifier: GPL-2.0-or-later
// What the kernels need of the machine that they are compiled for: a graphics card (clang's CUDA, without a file of the maker of
// cards), or a processor, where one thread does the work of all threads of a block in turn.
#pragma once
#include <cstddef>
#include <cstdint>

#if defined(__clang__) && defined(__CUDA__)
#define TALIK_ON_CARD 1
// what clang's own headers expect CUDA's to have said
#define __host__ __attribute__((host))
#define __device__ __attribute__((device))
#define __global__ __attribute__((global))
#define __shared__ __attribute__((shared))
#define TALIK_CARD __attribute__((device)) __attribute__((host))
#include <cstdlib> // clang's <algorithm> for cards wants it first

#include <algorithm>
#include <cmath>
#include <Eigen/Core>
#include <limits>
#include <type_traits>
// functions of the standard library that the laws call
static __attribute__((device)) inline double fabs(double x) { return __builtin_fabs(x); }
static __attribute__((device)) inline double sqrt(double x) { return __builtin_sqrt(x); }
namespace std {
using ::fabs;
using ::sqrt;
} // namespace std
#pragma clang force_cuda_host_device begin
#include <pkg/icebond/ContactForces.hpp>
#include <pkg/icebond/IceChange.hpp>
#pragma clang force_cuda_host_device end
#else
#define TALIK_ON_CARD 0
#define TALIK_CARD
#include <pkg/icebond/ContactForces.hpp>
#include <pkg/icebond/IceChange.hpp>
#endif

#define TALIK_INLINED __attribute__((always_inline))

namespace talik {
namespace N_ONE {

#if TALIK_ON_CARD
	TALIK_CARD inline int  threadNumber() { return __nvvm_read_ptx_sreg_tid_x(); }
	TALIK_CARD inline int  blockNumber() { return __nvvm_read_ptx_sreg_ctaid_x(); }
	TALIK_CARD inline void waitForBlock() { __syncthreads(); }
	/// Work that all threads of a block do before any of them goes on.
	template <class Work> TALIK_CARD inline TALIK_INLINED void together(int, Work work)
	{
		work(threadNumber());
		waitForBlock();
	}
	template <int Threads, class Work> TALIK_CARD inline TALIK_INLINED void together(Work work) { together(Threads, work); }
	/// What a thread keeps for itself from one piece of work to the next.
	template <class T, int Count, int Threads> struct Own {
		T                                  kept[Count > 0 ? Count : 1];
		TALIK_CARD inline TALIK_INLINED T& operator()(int, int k) { return kept[k]; }
	};
	/// The largest of what all threads bring, as bits of a positive number; `most` is in the memory of the block. Few threads bring more than
	/// those before them.
	TALIK_CARD inline void raise(std::uint64_t& most, std::uint64_t bits)
	{
		if (bits > static_cast<const volatile std::uint64_t&>(most)) __atomic_fetch_max(&most, bits, __ATOMIC_RELAXED);
	}
	TALIK_CARD inline void count(std::uint32_t& counter) { __atomic_fetch_add(&counter, 1u, __ATOMIC_RELAXED); }
	/// The number before it.
	TALIK_CARD inline std::uint32_t countUp(std::uint32_t& counter) { return __atomic_fetch_add(&counter, 1u, __ATOMIC_RELAXED); }
#define TALIK_UNROLL _Pragma("unroll")
#else
	template <class Work> inline TALIK_INLINED void together(int threads, Work work)
	{
		for (int thread = 0; thread < threads; ++thread)
			work(thread);
	}
	template <int Threads, class Work> inline TALIK_INLINED void together(Work work) { together(Threads, work); }
	template <class T, int Count, int Threads> struct Own {
		T         kept[Count > 0 ? Count* Threads : 1];
		inline T& operator()(int thread, int k) { return kept[thread * Count + k]; }
	};
	inline void          raise(std::uint64_t& most, std::uint64_t bits) { most = most < bits ? bits : most; }
	inline void          count(std::uint32_t& counter) { ++counter; }
	inline std::uint32_t countUp(std::uint32_t& counter) { return counter++; }
#define TALIK_UNROLL
#endif

	/// The number of a thread, with what the kernels of packed samples do with vectors; MulAdd and its kin round once, as the
	/// processors' do.
	struct One {
		double value;
	};
	HWY_INLINE One  splat(double value) { return { value }; }
	HWY_INLINE One  Add(One a, One b) { return { a.value + b.value }; }
	HWY_INLINE One  Sub(One a, One b) { return { a.value - b.value }; }
	HWY_INLINE One  Mul(One a, One b) { return { a.value * b.value }; }
	HWY_INLINE One  Div(One a, One b) { return { a.value / b.value }; }
	HWY_INLINE One  Neg(One a) { return { -a.value }; }
	HWY_INLINE One  Sqrt(One a) { return { __builtin_sqrt(a.value) }; }
	HWY_INLINE One  CopySignToAbs(One size, One sign) { return { __builtin_copysign(size.value, sign.value) }; }
	HWY_INLINE One  Min(One a, One b) { return { a.value < b.value ? a.value : b.value }; }
	HWY_INLINE One  Max(One a, One b) { return { a.value > b.value ? a.value : b.value }; }
	HWY_INLINE One  MulAdd(One a, One b, One c) { return { __builtin_fma(a.value, b.value, c.value) }; }
	HWY_INLINE One  MulSub(One a, One b, One c) { return { __builtin_fma(a.value, b.value, -c.value) }; }
	HWY_INLINE One  NegMulAdd(One a, One b, One c) { return { __builtin_fma(-a.value, b.value, c.value) }; }
	HWY_INLINE bool Lt(One a, One b) { return a.value < b.value; }
	HWY_INLINE bool Ne(One a, One b) { return a.value != b.value; }
	HWY_INLINE One  IfThenElse(bool condition, One yes, One no) { return condition ? yes : no; }
	HWY_INLINE One  zeroLike(One) { return { 0 }; }
	HWY_INLINE One  alike(One, double value) { return { value }; }
	HWY_INLINE bool holdsSomewhere(One, bool condition) { return condition; }

	/// Two neighbours in memory, read and written at once.
	struct alignas(16) Two {
		One x, y;
	};

} // namespace N_ONE
} // namespace talik
