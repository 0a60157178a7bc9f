// SPDX-License-Identifier: GPL-2.0-or-later
#pragma once

#include <pkg/base/ThreadPool.hpp>
#include <pkg/mpm/points/MaterialPoints.hpp>
#include <vector>

#include <algorithm>
#include <array>
#include <limits>

namespace talik {

/// The slabs of the grid that points can reach until they are sorted again; loops over nodes and cells keep to it.
struct ActiveRange {
	int firstNode = 0, lastNode = 0; ///< node indices [first, last)
	int firstCell = 0, lastCell = 0; ///< cell indices [first, last)
	int parallel = 1;                ///< 0: one thread does all
	int chunk    = 1;                ///< nodes of one piece of work: two rows, from an even one on, so that sums have one order for any number of threads

	template <int D> static ActiveRange of(const Grid<D>& grid, const MaterialPoints<D>& points)
	{
		const int     axis = grid.slowAxis();
		const double* x    = points.position(axis);
		double        low = std::numeric_limits<double>::infinity(), high = -low;
		if (!grid.images().empty()) low = grid.lower()[axis], high = grid.upper()[axis];
		for (int p = points.strips().firstPoint(); p < points.strips().endPoint(); ++p) {
			low  = std::min(low, x[p]);
			high = std::max(high, x[p]);
		}
		if (points.strips().slabs)
			for (const auto& [lowest, highest] : points.strips().slabs->byRank(std::array<double, 2> { low, high })) {
				low  = std::min(low, lowest);
				high = std::max(high, highest);
			}
		// one row more on both sides for points that stray until the next sorting
		const int   firstRow = std::max(0, int((low - grid.lower()[axis]) * grid.inverseSpacing()) - 1);
		const int   lastRow  = std::min(grid.cells(axis) - 1, int((high - grid.lower()[axis]) * grid.inverseSpacing()) + 1);
		ActiveRange r;
		r.firstCell = firstRow * grid.cellStride(axis);
		r.lastCell  = (lastRow + 1) * grid.cellStride(axis);
		r.firstNode = firstRow / 2 * 2 * grid.nodeStride(axis);
		r.lastNode  = (lastRow + 4) * grid.nodeStride(axis);
		r.chunk     = 2 * grid.nodeStride(axis);
		r.parallel  = points.strips().parallel;
		return r;
	}

	int  chunks() const { return lastNode > firstNode ? (lastNode + chunk - 1) / chunk - firstNode / chunk : 0; }
	bool holds(int node) const { return node >= firstNode && node < lastNode; }

	/// work(firstCell, lastCell) over all cells of the range, in pieces.
	template <class Work> void overCells(Work&& work) const
	{
		constexpr int piece = 512;
		const int     n     = (lastCell - firstCell + piece - 1) / piece;
		ThreadPool::run(n, threads(), [&](int c, int) { work(firstCell + c * piece, std::min(lastCell, firstCell + (c + 1) * piece)); });
	}

	/// work(piece, firstNode, lastNode) over all nodes of the range.
	template <class Work> void overNodes(Work&& work) const
	{
		const int first = firstNode / chunk;
		ThreadPool::run(chunks(), threads(), [&](int c, int) {
			const int begin = (first + c) * chunk;
			work(c, std::max(firstNode, begin), std::min(lastNode, begin + chunk));
		});
	}

	/// work(cell) for all cells of the range.
	template <class Work> void eachCell(Work&& work) const
	{
		overCells([&](int first, int last) {
			for (int c = first; c < last; ++c)
				work(c);
		});
	}

	/// work(node) for all nodes of the range.
	template <class Work> void eachNode(Work&& work) const
	{
		overNodes([&](int, int first, int last) {
			for (int i = first; i < last; ++i)
				work(i);
		});
	}

private:
	int threads() const { return parallel ? ThreadPool::threads() : 1; }
};

} // namespace talik
