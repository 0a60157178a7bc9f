// SPDX-License-Identifier: GPL-2.0-or-later
#pragma once

#include <pkg/mpm/grid/Grid.hpp>
#include <pkg/mpm/points/ActiveRange.hpp>
#include <pkg/mpm/points/MaterialPoints.hpp>
#include <vector>

namespace talik {

/// Shares of the direct strains in what B-bar adds to their sum, one in all: equal ones, but none for the thickness of a slice of space.
/// Between two smooth walls it strains as the plane does, where that outside it has none either (de Souza Neto et al. 1996). Third in the plane:
/// that around an axis.
template <int D> Vec<3> traceShares(const Grid<D>& grid)
{
	if (grid.isTurned()) return { 1.0 / 3.0, 1.0 / 3.0, 1.0 / 3.0 };
	Vec<3> share {};
	for (int a = 0; a < D; ++a)
		share[a] = !grid.isSlice() ? 1.0 / D : grid.cells(a) > 1 ? 0.5 : 0.0;
	return share;
}

/// is(cell) of all cells, each found by the rank that has the points of the cell.
template <int D, class Is> void flagCells(const Grid<D>& grid, const Strips& strips, std::vector<unsigned char>& flags, Is&& is)
{
	const int strip = Strips::rows * grid.cellStride(grid.slowAxis()), all = grid.cellCount();
	const int end = strips.slabs ? std::min(strips.end() * strip, all) : all;
	for (int c = strips.begin() * strip; c < end; ++c)
		flags[c] = is(c);
	if (strips.slabs) strips.slabs->shareByCell(flags);
}

/// Volume-weighted means over the points of a grid cell: the projection that keeps low-order ground from locking.
/// As it is symmetric in the volume-weighted product, the mean of div v and the mean of pressure are transposes. Points that are left
/// out, all of a cell or none, keep their own values in both.
template <int D> class CellMeans {
public:
	void allocate(const Grid<D>& grid, int points)
	{
		cell_.reset(points);
		volume_.reset(grid.cellCount());
		sum_.reset(grid.cellCount());
		averaged_ = cell_.data();
	}
	/// From now on points may be left out.
	void allowExceptions()
	{
		exceptions_.reset(cell_.size());
		averaged_ = exceptions_.data();
	}
	/// Whether a located point keeps its own values; needs allowExceptions().
	void leaveOut(int place, bool leftOut) { exceptions_[place] = leftOut ? noCell : cell_[place]; }

	/// Finds the cells of points first .. last and adds up their volumes; call within MaterialPoints::strips().scatter.
	void locate(const Grid<D>& grid, const MaterialPoints<D>& points, int first, int last)
	{
		const double* volume = points.volume();
		for (int p = first; p < last; ++p)
			volume_[cell_[p] = grid.cellOf(points.at(p))] += volume[p];
	}
	/// What locate() and add() add to.
	void share(HaloExchange& rows)
	{
		rows.cells(volume_.data());
		shareSums(rows);
	}
	/// What add() adds to.
	void shareSums(HaloExchange& rows) { rows.cells(sum_.data()); }
	void clearVolumes(const ActiveRange& r) { std::fill(volume_.begin() + r.firstCell, volume_.begin() + r.lastCell, 0.0); }
	void clearSums(const ActiveRange& r) { std::fill(sum_.begin() + r.firstCell, sum_.begin() + r.lastCell, 0.0); }
	void clearAll()
	{
		for (auto* values : { &volume_, &sum_ })
			std::fill(values->begin(), values->end(), 0.0);
	}
	/// Only cells and points of this part are used from now on; all others are zero and take no memory.
	void keepOnly(const ActiveRange& r, int firstPoint, int endPoint)
	{
		volume_.keepOnly(r.firstCell, r.lastCell);
		sum_.keepOnly(r.firstCell, r.lastCell);
		cell_.keepOnly(firstPoint, endPoint);
		exceptions_.keepOnly(firstPoint, endPoint);
	}

	/// Cells of the grid.
	int count() const { return int(volume_.size()); }
	int cell(int place) const { return cell_[place]; }
	/// By place.
	const int* cells() const { return cell_.data(); }
	void       add(int place, double volumeTimesValue)
	{
		if (averaged_[place] != noCell) sum_[averaged_[place]] += volumeTimesValue;
	}
	/// Turns the sums into means; nothing can be added until they are cleared.
	void finish(const ActiveRange& r)
	{
		r.overCells([&](int first, int last) {
			for (int c = first; c < last; ++c)
				sum_[c] = volume_[c] > 0.0 ? sum_[c] / volume_[c] : 0.0;
		});
	}
	/// The mean that holds for a point whose own value is given.
	double mean(int place, double own) const { return averaged_[place] == noCell ? own : sum_[averaged_[place]]; }
	/// The mean of a cell, when finished; 0 where all points keep their own values.
	double cellMean(int cell) const { return sum_[cell]; }
	/// Volume of the points in a cell [m^D].
	double cellVolume(int cell) const { return volume_[cell]; }

private:
	static constexpr int noCell = -1;

	PagedArray<int>    cell_, exceptions_;
	const int*         averaged_ = nullptr; ///< by place: the mean that holds for the point, or noCell
	PagedArray<double> volume_;             ///< by cell, of its points [m^D]
	PagedArray<double> sum_;                ///< by cell; means once finished
};

} // namespace talik
