// SPDX-License-Identifier: GPL-2.0-or-later
#include <pkg/mpm/front/FrontNodes.hpp>

#include <algorithm>

namespace talik {

namespace {
	constexpr unsigned char thawedBit = 1, frozenBit = 2, bothBits = 3;

	/// Offsets of the nodes first .. last away along each axis.
	template <int D> std::vector<int> offsetsOf(const Grid<D>& grid, int first, int last)
	{
		std::vector<int> all(1, 0);
		for (int a = 0; a < D; ++a) {
			std::vector<int> wider;
			for (const int from : all)
				for (int step = first; step <= last; ++step)
					wider.push_back(from + step * grid.nodeStride(a));
			all = wider;
		}
		return all;
	}
} // namespace

template <int D>
FrontNodes<D>::FrontNodes(const ThawFrontSettings& settings)
        : settings_(settings)
{}

template <int D> void FrontNodes<D>::bind(const Grid<D>& grid, const MaterialPoints<D>& points, double* side)
{
	grid_   = &grid;
	points_ = &points;
	side_   = side;
	reach_  = offsetsOf(grid, -2, 1);
	beside_ = offsetsOf(grid, -1, 1);
	margin_ = 0;
	for (int a = 0; a < D; ++a)
		margin_ += 2 * grid.nodeStride(a);
	cell_.reset(points.capacity());
	for (auto* marks : { &sides_, &sidesAt_, &near_ })
		marks->assign(grid.nodeCount() + 2 * margin_, 0);
	slot_.assign(grid.nodeCount(), -1);
	nodes_.clear();
}

template <int D> void FrontNodes<D>::start(int first, int end, const double* iceSaturation)
{
	for (int p = first; p < end; ++p)
		side_[p] = iceSaturation[p] > settings_.thawedBelow ? 1.0 : 0.0;
}

template <int D> void FrontNodes<D>::updateSides(int first, int last, const double* iceSaturation)
{
	for (int p = first; p < last; ++p)
		side_[p] = iceSaturation[p] >= settings_.frozenAbove ? 1.0 : iceSaturation[p] <= settings_.thawedBelow ? 0.0 : side_[p];
}

template <int D> void FrontNodes<D>::markCells(const Grid<D>& grid, int first, int last)
{
	for (int p = first; p < last; ++p) {
		int lower = margin_;
		for (int a = 0; a < D; ++a)
			lower += (grid.placeOf(a, points_->position(a)[p]) + 1) * grid.nodeStride(a);
		cell_[p] = lower;
		sides_[lower] |= frozen(p) ? frozenBit : thawedBit;
	}
}

template <int D> void FrontNodes<D>::spreadSides(const ActiveRange& range)
{
	const int first = range.firstNode + margin_, last = range.lastNode + margin_;
	std::fill(sidesAt_.begin(), sidesAt_.end(), 0);
	for (const int step : reach_) {
		const unsigned char* const from = sides_.data() + step;
		unsigned char* const       to   = sidesAt_.data();
		for (int i = first; i < last; ++i)
			to[i] |= from[i];
	}
}

template <int D> void FrontNodes<D>::joinMirrors(const Mirrors& mirrors)
{
	const auto join = [&](int first, int second) {
		unsigned char &one = sidesAt_[first + margin_], &other = sidesAt_[second + margin_];
		one = other = one | other;
	};
	const auto joinBoth = [&](const auto& m) { join(m.ghost, m.inner); };
	const auto repeat   = [&](const NodeImage& image) { join(image.node, image.original); };
	std::for_each(grid_->images().begin(), grid_->images().end(), repeat);
	std::for_each(mirrors.begin(), mirrors.end(), joinBoth);
	std::for_each(mirrors.rbegin(), mirrors.rend(), joinBoth);
	std::for_each(grid_->images().begin(), grid_->images().end(), repeat);
	// where the sides part in front of a wall that has left its nodes, each has a velocity of its own on them too
	for (const auto& m : mirrors)
		if (m.lead != 0.0 && sidesAt_[m.inner + margin_] == bothBits) sidesAt_[m.wall() + margin_] = bothBits;
}

template <int D> void FrontNodes<D>::listNodes(const ActiveRange& range)
{
	for (const int node : nodes_)
		slot_[node] = -1;
	nodes_.clear();
	for (int i = range.firstNode; i < range.lastNode; ++i)
		if (sidesAt_[i + margin_] == bothBits) {
			slot_[i] = int(nodes_.size());
			nodes_.push_back(i);
		}
}

template <int D> void FrontNodes<D>::markNear()
{
	std::fill(near_.begin(), near_.end(), 0);
	for (const int node : nodes_)
		for (const int step : reach_)
			near_[node + margin_ + step] = 1;
}

template <int D> void FrontNodes<D>::find(const StepContext<D>& step, const double* iceSaturation, const Mirrors& mirrors, const std::vector<int>& freeLiquid)
{
	std::fill(sides_.begin(), sides_.end(), 0);
	step.strips.scatter(
	        [&](int, int first, int last) {
		        updateSides(first, last, iceSaturation);
		        markCells(step.grid, first, last);
	        },
	        [&](HaloExchange& rows) {
		        rows.beyond = true;
		        rows.cellsByNode(sides_.data() + margin_);
	        });
	spreadSides(step.halo);
	joinMirrors(mirrors);
	// the liquid of a ghost that stays free of the wall belongs to no side of the node that its solid is folded into
	for (const int node : freeLiquid)
		sidesAt_[node + margin_] = 0;
	listNodes(step.halo);
	markNear();
}

template <int D> const std::vector<int>& FrontNodes<D>::rowStarts(const Grid<D>& grid)
{
	const int row = grid.nodeStride(grid.slowAxis()), count = grid.nodes(grid.slowAxis());
	rowStarts_.resize(count + 1);
	for (int r = 0; r <= count; ++r)
		rowStarts_[r] = int(std::lower_bound(nodes_.begin(), nodes_.end(), r * row) - nodes_.begin());
	return rowStarts_;
}

template <int D> const std::vector<int>& FrontNodes<D>::thawedNear(const std::vector<int>& places)
{
	chosen_.clear();
	for (const int p : places)
		if (near(p) && !frozen(p)) chosen_.push_back(p);
	return chosen_;
}

template <int D> void FrontNodes<D>::exceptFromMeans(CellMeans<D>& cells, int first, int last) const
{
	for (int p = first; p < last; ++p)
		cells.leaveOut(p, near(p));
}

TALIK_IN_PLANE_AND_SPACE(FrontNodes);

} // namespace talik
