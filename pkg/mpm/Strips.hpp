// SPDX-License-Identifier: GPL-2.0-or-later
#pragma once

#include <vector>

#ifdef _OPENMP
#include <omp.h>
#endif

namespace talik {

/// The points cut into strips of whole cell rows along the grid's slowest axis. Points of a strip write only to nodes of its own
/// rows and a margin, so that all even strips may run at the same time, then all odd ones; each sum then has one order,
/// whatever the number of threads. The height of a strip is fixed.
struct Strips {
	/// With four rows, quadratic support (one node behind, two ahead of the cell) and points strayed by up to half a cell,
	/// strips of one parity share no node.
	static constexpr int    rows  = 4;
	static constexpr double stray = 0.5; ///< how far points may leave their strip before they are sorted anew [cells]

	int              axis     = 0;
	bool             parallel = true; ///< false: one thread does all, which is faster for few points
	std::vector<int> first; ///< place of the first point of each strip; one more entry for the end

	int count() const { return static_cast<int>(first.size()) - 1; }

	/// work(strip, firstPoint, lastPoint) for all strips, never two neighbours at the same time.
	template <class Work> void scatter(Work&& work) const
	{
#pragma omp parallel if (parallel)
		{
			const Share mine(*this);
			for (int s = mine.first + mine.first % 2; s < mine.last; s += 2)
				work(s, first[s], first[s + 1]);
#pragma omp barrier
			for (int s = mine.first + 1 - mine.first % 2; s < mine.last; s += 2)
				work(s, first[s], first[s + 1]);
		}
	}

	/// work(strip, firstPoint, lastPoint) for all strips at once: for loops that write to their own points only.
	template <class Work> void gather(Work&& work) const
	{
#pragma omp parallel if (parallel)
		{
			const Share mine(*this);
			for (int s = mine.first; s < mine.last; ++s)
				work(s, first[s], first[s + 1]);
		}
	}

private:
	/// Strips of the thread that asks: as many points for each thread as whole strips allow, and the same ones in every loop, so
	/// that they stay in its cache.
	struct Share {
		int first, last;
		explicit Share(const Strips& strips)
		{
#ifdef _OPENMP
			first = strips.beginOf(omp_get_thread_num(), omp_get_num_threads());
			last  = strips.beginOf(omp_get_thread_num() + 1, omp_get_num_threads());
#else
			first = 0;
			last  = strips.count();
#endif
		}
	};

	/// First strip whose middle point belongs to the given part of the points.
	int beginOf(int part, int parts) const
	{
		const long points = first.back();
		int        s      = 0;
		while (s < count() && (static_cast<long>(first[s]) + first[s + 1]) * parts < 2 * points * part)
			++s;
		return part == parts ? count() : s;
	}
};

} // namespace talik
