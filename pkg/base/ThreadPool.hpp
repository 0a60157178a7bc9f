// SPDX-License-Identifier: GPL-2.0-or-later
#pragma once

#include <algorithm>
#include <utility>

namespace talik {

/// The threads of all loops, in place of those of OpenMP, whose threads wait for each other for milliseconds at full speed: beside
/// another busy process a loop then takes as long as the slowest of them is kept from its processor. Here every thread that has a processor
/// takes pieces that are left. A thread that waits does so for some 30 us and then sleeps, which frees its processor for the others. Which
/// thread takes a piece has no influence on results as long as pieces write to places of their own.
class ThreadPool {
public:
	/// Threads that a loop may use: those of OpenMP (yade -j, OMP_NUM_THREADS); 1 inside of another parallel loop.
	static int threads();

	/// work(piece, member) for all pieces from 0 to count - 1, by up to so many threads, each of which has another member number from
	/// 0 to threads - 1. Neighbouring pieces go to one thread as far as possible, the same ones in every loop of equal length, so that
	/// they stay in its cache. The first exception of a piece is thrown here when all have ended.
	template <class Work> static void run(int count, int threads, Work&& work)
	{
		if (count <= 0) return;
		const int wanted = std::min(threads, count);
		if (wanted <= 1) {
			for (int i = 0; i < count; ++i)
				work(i, 0);
			return;
		}
		// pieces that the counters cannot hold go together
		const int together = (count + largestCount - 1) / largestCount;
		auto      several  = [&](int group, int member) {
                        for (int i = group * together; i < std::min(count, (group + 1) * together); ++i)
                                work(i, member);
		};
		share((count + together - 1) / together, wanted, [](void* w, int group, int member) { (*static_cast<decltype(several)*>(w))(group, member); },
		      &several);
	}

	template <class Work> static void run(int count, Work&& work) { run(count, threads(), std::forward<Work>(work)); }

private:
	using Function                    = void (*)(void*, int, int);
	static constexpr int largestCount = 65535;
	static void          share(int count, int threads, Function function, void* work);
};

} // namespace talik
