// SPDX-License-Identifier: GPL-2.0-or-later
#pragma once

#include <pkg/mpm/effects/DeformationRecord.hpp>
#include <pkg/mpm/points/ActiveRange.hpp>
#include <pkg/mpm/points/MaterialPoints.hpp>

#include <cmath>

namespace talik {

/// A point that a stretch or an ice lens has made longer than a cell leaves a cell beside it without points, which transmits no stress. There it
/// divides into two, eq. (30.1). Points have the edges of the ground that they stand for, a cube at the start.
template <int D> class DividingPoints final : public DeformationRecord<D> {
public:
	DividingPoints()
	        : DeformationRecord<D>("extent", "m")
	{}
	std::string name() const override { return "dividing points"; }
	void        start(PointFields& fields, int first, int last) override
	{
		DeformationRecord<D>::start(fields, first, last);
		most_ = room / 2 * fields.count();
		for (int p = first; p < last; ++p)
			for (int a = 0; a < D; ++a)
				this->f_[a * D + a][p] = std::pow(fields.find("volume")[p], 1.0 / D);
	}
	/// Over the points given, for which arrays have room: with half as many none divides any more.
	static constexpr int room = 8;

	/// Points of this rank that are to be divided, whose extents are those of their halves from now on. Collective, between two steps.
	std::vector<PointDivision> find(const Grid<D>& grid, const MaterialPoints<D>& points, const ActiveRange& range)
	{
		locate(grid, points, range);
		const Strips&              strips = points.strips();
		std::vector<PointDivision> list;
		if (points.count() >= most_) return list;
		for (int p = strips.firstPoint(); p < strips.endPoint(); ++p)
			for (int axis = 0; axis < D && points.volume()[p] >= smallest * grid.cellVolume(); ++axis) {
				const double length = lengthAlong(axis, p);
				if (length <= longest * grid.spacing() || !besideGap(grid, points.at(p), axis)) continue;
				const double room = std::min(points.position(axis)[p] - grid.lower()[axis], grid.upper()[axis] - points.position(axis)[p]);
				list.push_back({ p, axis, std::min(0.25 * length, 0.5 * room) });
				for (int j = 0; j < D; ++j)
					this->f_[axis * D + j][p] *= 0.5;
				break;
			}
		return list;
	}

private:
	/// Length over that of a cell from which on a point divides, and the smallest volume over that of a cell of one that does [-].
	static constexpr double longest = 1.25, smallest = 0.5;

	void locate(const Grid<D>& grid, const MaterialPoints<D>& points, const ActiveRange& range)
	{
		if (filled_.empty()) filled_.reset(grid.cellCount());
		std::fill(filled_.begin() + range.firstCell, filled_.begin() + range.lastCell, 0);
		points.strips().scatter(
		        [&](int, int first, int last) {
			        for (int p = first; p < last; ++p)
				        filled_[grid.cellOf(points.at(p))] = 1;
		        },
		        [&](HaloExchange& rows) {
			        rows.beyond = true;
			        rows.cells(filled_.data());
		        });
	}
	double lengthAlong(int axis, int p) const
	{
		double square = 0.0;
		for (int j = 0; j < D; ++j)
			square += this->f_[axis * D + j][p] * this->f_[axis * D + j][p];
		return std::sqrt(square);
	}
	/// A cell beside, along an axis, has no points, and that behind it has.
	bool besideGap(const Grid<D>& grid, const Vec<D>& x, int axis) const
	{
		const int cell = grid.cellOf(x), at = grid.place(cell, axis), stride = grid.cellStride(axis);
		return (at >= 2 && !filled_[cell - stride] && filled_[cell - 2 * stride])
		        || (at + 2 < grid.cells(axis) && !filled_[cell + stride] && filled_[cell + 2 * stride]);
	}

	PagedArray<unsigned char> filled_; ///< by cell: it has points
	int                       most_ = 0;
};

} // namespace talik
