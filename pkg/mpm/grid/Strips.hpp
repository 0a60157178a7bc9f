// SPDX-License-Identifier: GPL-2.0-or-later
#pragma once

#include <pkg/mpm/ThreadTeam.hpp>

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
		const int even = (count() + 1) / 2, odd = count() / 2;
		ThreadTeam::run(even, threads(), [&](int s, int) { work(2 * s, first[2 * s], first[2 * s + 1]); });
		ThreadTeam::run(odd, threads(), [&](int s, int) { work(2 * s + 1, first[2 * s + 1], first[2 * s + 2]); });
	}

	/// work(strip, firstPoint, lastPoint) for all strips at once: for loops that write to their own points only.
	template <class Work> void gather(Work&& work) const
	{
		ThreadTeam::run(count(), threads(), [&](int s, int) { work(s, first[s], first[s + 1]); });
	}

private:
	int threads() const { return parallel ? ThreadTeam::threads() : 1; }
};

} // namespace talik
