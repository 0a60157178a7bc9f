// SPDX-License-Identifier: GPL-2.0-or-later
#pragma once

#include <vector>

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
		const int n = count();
#pragma omp parallel if (parallel)
		for (int parity = 0; parity < 2; ++parity) {
#pragma omp for schedule(dynamic, 1)
			for (int s = parity; s < n; s += 2)
				work(s, first[s], first[s + 1]);
		}
	}

	/// work(strip, firstPoint, lastPoint) for all strips at once: for loops that write to their own points only.
	template <class Work> void gather(Work&& work) const
	{
		const int n = count();
#pragma omp parallel for schedule(dynamic, 1) if (parallel)
		for (int s = 0; s < n; ++s)
			work(s, first[s], first[s + 1]);
	}
};

} // namespace talik
