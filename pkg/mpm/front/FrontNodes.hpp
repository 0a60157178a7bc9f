// SPDX-License-Identifier: GPL-2.0-or-later
#pragma once

#include <pkg/mpm/boundary/Boundary.hpp>
#include <pkg/mpm/GroundSettings.hpp>
#include <pkg/mpm/points/ActiveRange.hpp>
#include <pkg/mpm/points/CellMeans.hpp>
#include <pkg/mpm/points/MaterialPoints.hpp>
#include <pkg/mpm/StepContext.hpp>

#include <vector>

namespace talik {

/// Detection: which points ice holds (the frozen side), which it does not (the thawed side), and the front nodes, which points of both
/// sides may reach.
template <int D> class FrontNodes {
public:
	using Mirrors = std::vector<typename MotionConstraints<D>::Mirror>;

	explicit FrontNodes(const ThawFrontSettings& settings);
	/// side: whole array by place, 1 for frozen and 0 for thawed points.
	void bind(const Grid<D>& grid, const MaterialPoints<D>& points, double* side);
	/// Sides of points first .. end at the start of a scene, from their ice saturation, by place [-].
	void start(int first, int end, const double* iceSaturation);
	/// Only points of this part are used from now on.
	void keepOnly(int firstPoint, int endPoint) { cell_.keepOnly(firstPoint, endPoint); }

	/// Sides of the points from their ice saturation, by place, and the front nodes of a step. mirrors, in the order in which they are folded: a node
	/// and its mirror image belong together. freeLiquid: nodes that have one velocity, because the liquid of a ghost is not folded there.
	void find(const StepContext<D>& step, const double* iceSaturation, const Mirrors& mirrors, const std::vector<int>& freeLiquid);

	bool empty() const { return nodes_.empty(); }
	int  count() const { return int(nodes_.size()); }
	int  node(int slot) const { return nodes_[slot]; }
	/// Place of a node among the front nodes, -1 for any other.
	int        slot(int node) const { return slot_[node]; }
	const int* slots() const { return slot_.data(); }
	/// First slot of each row of nodes along the slow axis, and the end.
	const std::vector<int>& rowStarts(const Grid<D>& grid);

	bool frozen(int place) const { return side_[place] != 0.0; }
	/// Points that reach front nodes.
	bool near(int place) const { return near_[cell_[place]]; }
	/// Thawed ones among some places, ascending.
	const std::vector<int>& thawedNear(const std::vector<int>& places);
	/// Takes points first .. last near the front from the means of cells: what shears and dilates there would strain the rows beside it. Not in
	/// ground with water, whose pressure is that of cells.
	void exceptFromMeans(CellMeans<D>& cells, int first, int last) const;

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
	void updateSides(int first, int last, const double* iceSaturation);
	void markCells(const Grid<D>& grid, int first, int last);
	void spreadSides(const ActiveRange& range);
	void joinMirrors(const Mirrors& mirrors);
	void listNodes(const ActiveRange& range);
	void markNear();

	ThawFrontSettings          settings_;
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
