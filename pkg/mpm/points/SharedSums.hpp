// SPDX-License-Identifier: GPL-2.0-or-later
#pragma once

#include <pkg/base/PagedArray.hpp>
#include <pkg/mpm/points/CellMeans.hpp>
#include <pkg/mpm/StepContext.hpp>

namespace talik {

/// Sums that the points of a cell have in common, as with B-bar they have their volumetric strain; without B-bar each point has its own.
template <int D, class Sums> class SharedSums {
public:
	/// byCell: with B-bar.
	void bind(bool byCell, int cells, int points)
	{
		byCell_ = byCell;
		sums_.reset(byCell ? cells : points);
	}
	void keepOnly(const ActiveRange& range, int firstPoint, int endPoint)
	{
		if (byCell_) sums_.keepOnly(range.firstCell, range.lastCell);
		else sums_.keepOnly(firstPoint, endPoint);
	}
	/// All sums are zero; cells: of this step, null without B-bar.
	void clear(const StepContext<D>& step, const CellMeans<D>* cells)
	{
		cells_ = cells;
		if (cells) std::fill(sums_.begin() + step.halo.firstCell, sums_.begin() + step.halo.lastCell, Sums {});
		else std::fill(sums_.begin() + step.strips.firstPoint(), sums_.begin() + step.strips.endPoint(), Sums {});
	}
	/// add(place, sums) for all points.
	template <class Add> void add(const StepContext<D>& step, Add&& add)
	{
		step.strips.scatter(
		        [&](int, int first, int last) {
			        for (int p = first; p < last; ++p)
				        add(p, (*this)[p]);
		        },
		        [&](HaloExchange& rows) {
			        if (cells_) rows.cells(sums_.data());
		        });
	}
	Sums&       operator[](int place) { return sums_[cells_ ? cells_->cell(place) : place]; }
	const Sums& operator[](int place) const { return sums_[cells_ ? cells_->cell(place) : place]; }

private:
	bool                byCell_ = false;
	const CellMeans<D>* cells_  = nullptr;
	PagedArray<Sums>    sums_;
};

} // namespace talik
