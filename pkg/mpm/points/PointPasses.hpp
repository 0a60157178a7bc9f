// SPDX-License-Identifier: GPL-2.0-or-later
#pragma once

#include <pkg/mpm/CostMeter.hpp>
#include <pkg/mpm/grid/ShapeFunctions.hpp>
#include <pkg/mpm/points/MaterialPoints.hpp>
#include <pkg/mpm/points/Prefetch.hpp>

#include <algorithm>
#include <array>
#include <functional>

namespace talik {

/// Passes over the points of this rank, with the weights of their nodes where work is done block by block. What each effect costs in a pass goes to
/// the meter.
template <int D> class PointPasses {
public:
	void bind(const Grid<D>& grid, MaterialPoints<D>& points, const ShapeFunction<D>& shape, CostMeter& cost)
	{
		grid_   = &grid;
		points_ = &points;
		shape_  = &shape;
		cost_   = &cost;
	}

	/// What the passes over blocks read of the points.
	Prefetch toGrid, flows, back, seepage, toPoints;

	/// work(block) for all points, with weights at their positions; never two neighbouring strips at once.
	/// share(rows): names the arrays to which work adds; ahead: those of the points that it reads.
	template <class Work, class Share> void scatter(const Prefetch& ahead, Work&& work, Share&& share)
	{
		points_->strips().scatter([&](int, int first, int last) { overBlocks(ahead, first, last, work); }, share);
	}
	/// The parts of a pass in turn for each block of points, with weights at their positions and an array for what one part leaves to a later one.
	/// finish(strip, firstPoint, lastPoint): when a strip's blocks are done.
	template <class Share, class Finish, class... Work> void inBlocks(const Prefetch& ahead, Share&& share, Finish&& finish, const PassPart<Work>&... parts)
	{
		points_->strips().scatter(
		        [&](int strip, int first, int last) {
			        CostMeter::Sample sample = cost_->sample(strip);
			        double            left[blockSize];
			        overBlocks(ahead, first, last, [&](const WeightBlock<D>& w) {
				        sample.beginBlock();
				        (parts.run(sample, w, left), ...);
			        });
			        finish(strip, first, last);
		        },
		        share);
		cost_->lapShared();
	}
	/// The parts of a pass in turn for each strip of points: work(strip, firstPoint, lastPoint, sample). share: empty where they add to no array that
	/// strips share.
	template <class... Work> void inStrips(const std::function<void(HaloExchange&)>& share, const PassPart<Work>&... parts)
	{
		const auto work = [&](int strip, int first, int last) {
			CostMeter::Sample sample = cost_->sample(strip);
			sample.begin();
			(parts.run(sample, strip, first, last, sample), ...);
		};
		if (share) points_->strips().scatter(work, share);
		else points_->strips().gather(work);
		cost_->lapShared();
	}
	/// work(block) for points first .. last.
	template <class Work> void overBlocks(const Prefetch& ahead, int first, int last, Work&& work)
	{
		WeightBlock<D>               w;
		std::array<const double*, D> x;
		for (int a = 0; a < D; ++a)
			x[a] = points_->position(a);
		for (int p = first; p < last; p += blockSize) {
			shape_->evaluate(*grid_, x, p, std::min(blockSize, last - p), w);
			ahead.fetch(p + blockSize);
			work(w);
		}
	}

private:
	const Grid<D>*          grid_   = nullptr;
	MaterialPoints<D>*      points_ = nullptr;
	const ShapeFunction<D>* shape_  = nullptr;
	CostMeter*              cost_   = nullptr;
};

} // namespace talik
