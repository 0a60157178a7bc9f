// SPDX-License-Identifier: GPL-2.0-or-later
#pragma once

#include <pkg/mpm/boundary/Boundary.hpp>
#include <pkg/mpm/GroundSettings.hpp>
#include <pkg/mpm/points/ActiveRange.hpp>
#include <pkg/mpm/points/CellMeans.hpp>
#include <pkg/mpm/points/MaterialPoints.hpp>
#include <pkg/mpm/StepContext.hpp>

#include <algorithm>
#include <vector>

namespace talik {

/// Detection: which points ice holds (the frozen side), which it does not (the thawed side), and the front nodes, which points of both
/// sides may reach.
template <int D> class FrontNodes {
public:
	using Mirrors = std::vector<typename MotionConstraints<D>::Mirror>;

	/// Ice saturation at and below which a point becomes thawed ground, and at and above which it is frozen ground again [-]: there the bonds of samples
	/// are gone, and form.
	static constexpr double thawedBelow = 0.02, frozenAbove = 0.05;

	/// side: whole array by place, 1 for frozen and 0 for thawed points.
	void bind(const Grid<D>& grid, const MaterialPoints<D>& points, double* side)
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
	/// Sides of points first .. end at the start of a scene, from their ice saturation, by place [-].
	void start(int first, int end, const double* iceSaturation)
	{
		for (int p = first; p < end; ++p)
			side_[p] = iceSaturation[p] > thawedBelow ? 1.0 : 0.0;
	}
	/// Only points of this part are used from now on.
	void keepOnly(int firstPoint, int endPoint) { cell_.keepOnly(firstPoint, endPoint); }

	/// Sides of the points from their ice saturation, by place, and the front nodes of a step. mirrors, in the order in which they are folded: a node
	/// and its mirror image belong together. freeLiquid: nodes that have one velocity, because the liquid of a ghost is not folded there.
	void find(const StepContext<D>& step, const double* iceSaturation, const Mirrors& mirrors, const std::vector<int>& freeLiquid)
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

	bool empty() const { return nodes_.empty(); }
	int  count() const { return int(nodes_.size()); }
	int  node(int slot) const { return nodes_[slot]; }
	/// Place of a node among the front nodes, -1 for any other.
	int        slot(int node) const { return slot_[node]; }
	const int* slots() const { return slot_.data(); }
	/// First slot of each row of nodes along the slow axis, and the end.
	const std::vector<int>& rowStarts(const Grid<D>& grid)
	{
		const int row = grid.nodeStride(grid.slowAxis()), count = grid.nodes(grid.slowAxis());
		rowStarts_.resize(count + 1);
		for (int r = 0; r <= count; ++r)
			rowStarts_[r] = int(std::lower_bound(nodes_.begin(), nodes_.end(), r * row) - nodes_.begin());
		return rowStarts_;
	}

	bool frozen(int place) const { return side_[place] != 0.0; }
	/// Points that reach front nodes.
	bool near(int place) const { return near_[cell_[place]]; }
	/// Thawed ones among some places, ascending.
	const std::vector<int>& thawedNear(const std::vector<int>& places)
	{
		chosen_.clear();
		for (const int p : places)
			if (near(p) && !frozen(p)) chosen_.push_back(p);
		return chosen_;
	}
	/// Takes points first .. last near the front from the means of cells: what shears and dilates there would strain the rows beside it. Not in
	/// ground with water, whose pressure is that of cells.
	void exceptFromMeans(CellMeans<D>& cells, int first, int last) const
	{
		for (int p = first; p < last; ++p)
			cells.leaveOut(p, near(p));
	}

	/// work(slot) for the front nodes around a node, itself included.
	template <class Work> void overBeside(int node, Work&& work) const
	{
		const int from = grid_->original(node);
		for (const int step : beside_) {
			const int other = from + step;
			if (other >= 0 && other < int(slot_.size()) && slot_[other] >= 0) work(slot_[other]);
		}
	}

private:
	static constexpr unsigned char thawedBit = 1, frozenBit = 2, bothBits = 3;

	/// Offsets of the nodes first .. last away along each axis.
	static std::vector<int> offsetsOf(const Grid<D>& grid, int first, int last)
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
	void updateSides(int first, int last, const double* iceSaturation)
	{
		for (int p = first; p < last; ++p)
			side_[p] = iceSaturation[p] >= frozenAbove ? 1.0 : iceSaturation[p] <= thawedBelow ? 0.0 : side_[p];
	}
	void markCells(const Grid<D>& grid, int first, int last)
	{
		for (int p = first; p < last; ++p) {
			int lower = margin_;
			for (int a = 0; a < D; ++a)
				lower += (grid.placeOf(a, points_->position(a)[p]) + 1) * grid.nodeStride(a);
			cell_[p] = lower;
			sides_[lower] |= frozen(p) ? frozenBit : thawedBit;
		}
	}
	void spreadSides(const ActiveRange& range)
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
	void joinMirrors(const Mirrors& mirrors)
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
	void listNodes(const ActiveRange& range)
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
	void markNear()
	{
		std::fill(near_.begin(), near_.end(), 0);
		for (const int node : nodes_)
			for (const int step : reach_)
				near_[node + margin_ + step] = 1;
	}

	const Grid<D>*             grid_   = nullptr;
	const MaterialPoints<D>*   points_ = nullptr;
	double*                    side_   = nullptr;
	int                        margin_ = 0; ///< of the arrays by node below, so that a reach never leaves them
	PagedArray<int>            cell_;       ///< by place: node at the lower corner of the point's cell, counted with the margin
	std::vector<unsigned char> sides_;      ///< by that node: sides of the points in the cell
	std::vector<unsigned char> sidesAt_;    ///< by node: sides whose points may touch it
	std::vector<unsigned char> near_;       ///< by the lower node of a cell: its points reach front nodes
	std::vector<int>           reach_;      ///< from a node to the lower nodes of the cells whose points may touch it
	std::vector<int>           beside_;     ///< from a node to those around it and itself
	std::vector<int>           slot_;       ///< by node: place in the list of front nodes, or -1
	std::vector<int>           nodes_;      ///< front nodes, ascending
	std::vector<int>           rowStarts_;
	std::vector<int>           chosen_;
};

} // namespace talik
