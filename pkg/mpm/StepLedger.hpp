// SPDX-License-Identifier: GPL-2.0-or-later
#pragma once

#include <pkg/mpm/Balance.hpp>
#include <pkg/mpm/grid/Grid.hpp>
#include <pkg/mpm/points/MaterialPoints.hpp>

#include <algorithm>
#include <vector>

namespace talik {

/// What a step adds to the accounts, kept by pairs of rows of nodes. A strip of cells has the two pairs in its middle, and the sum runs over
/// the strips: so it has one order for any number of threads and ranks, and a rank knows all that belongs to its own strips.
template <int D> class StepLedger {
public:
	StepLedger() = default;
	explicit StepLedger(const Grid<D>& grid)
	        : nodesOfPair_(2 * grid.nodeStride(grid.slowAxis()))
	        , cellsOfStrip_(Strips::rows * grid.cellStride(grid.slowAxis()))
	        , strips_((grid.cellCount() + cellsOfStrip_ - 1) / cellsOfStrip_)
	        , pairs_(std::max((grid.nodeCount() + nodesOfPair_ - 1) / nodesOfPair_, 2 * strips_ + 1))
	        , ofImages_(grid.images().empty() ? 0 : pairs_.size())
	        , grid_(&grid)
	{}

	void clear() { std::fill(pairs_.begin(), pairs_.end(), StepAccount<D> {}); }

	/// May be called by several threads, for nodes of different pairs of rows.
	StepAccount<D>& ofNode(int node) { return (counts(node) ? pairs_ : ofImages_)[node / nodesOfPair_]; }
	/// False for a node that periodic sides repeat: what it does is booked with the node whose image it is.
	bool counts(int node) const { return ofImages_.empty() || grid_->original(node) == node; }
	/// Of the rows of a node.
	StepAccount<D>& ofRows(int node) { return pairs_[node / nodesOfPair_]; }
	StepAccount<D>& ofCell(int cell) { return ofStrip(cell / cellsOfStrip_); }
	/// May be called by several threads, for different strips.
	StepAccount<D>& ofStrip(int strip) { return pairs_[2 * strip + 1]; }

	/// Sum over all strips; slabs: collective.
	StepAccount<D> sum(SlabDecomposition* slabs)
	{
		byStrip_.assign(strips_, {});
		for (std::size_t k = 0; k < pairs_.size(); ++k)
			byStrip_[std::clamp((int(k) - 1) / 2, 0, strips_ - 1)] += pairs_[k];
		if (slabs) slabs->shareByStrip(byStrip_.data());
		StepAccount<D> all;
		for (const StepAccount<D>& strip : byStrip_)
			all += strip;
		return all;
	}

private:
	int                         nodesOfPair_ = 1, cellsOfStrip_ = 1, strips_ = 0;
	std::vector<StepAccount<D>> pairs_, byStrip_;
	std::vector<StepAccount<D>> ofImages_; ///< is never read; empty without periodic sides
	const Grid<D>*              grid_ = nullptr;
};

} // namespace talik
