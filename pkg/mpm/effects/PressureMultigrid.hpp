// SPDX-License-Identifier: GPL-2.0-or-later
#pragma once

#include <pkg/base/PagedArray.hpp>
#include <pkg/mpm/grid/Grid.hpp>
#include <pkg/mpm/points/ActiveRange.hpp>
#include <pkg/mpm/StepContext.hpp>

#include <algorithm>
#include <array>
#include <numeric>
#include <vector>

namespace talik {

/// Preconditioner of the conjugate gradients of ImplicitPressure, eq. (7.10): one V-cycle of multigrid for a matrix M in which a cell gives to its next
/// neighbours only,
///   (M z)_c = storage_c z_c + sum over its faces of conductance (z_c - z_n) = r_c.
/// Each coarser grid joins 2^D cells: storages add up, conductances are those of a face as large and a way as long as there. One damped Jacobi step
/// before and after the coarser grid keeps the matrix of a cycle symmetric, whatever the conductances; constant interpolation lets them jump between cells.
/// The coarser grids are the same on all ranks, and each rank has them whole: they have at most a quarter (an eighth in space) of the cells.
template <int D> class PressureMultigrid {
public:
	/// A cell, and its faces to the next cell along each axis.
	struct Cell {
		double storage;        ///< what it takes where all pressures change alike [m^D/Pa]; 0: it is not solved for
		double conductance[D]; ///< [m^D/Pa]
	};

	void allocate(const Grid<D>& grid)
	{
		const int n = grid.cellCount();
		slowAxis_   = grid.slowAxis();
		matrix_.reset(n);
		parent_.reset(n);
		inverse_.reset(n);
		smoothed_.reset(n);
		levels_.clear();
		std::array<int, D> cells {};
		for (int a = 0; a < D; ++a) {
			cells[a]   = grid.cells(a);
			stride_[a] = grid.cellStride(a);
		}
		// whole strips, so that each of them has as many rows of the next level
		cells[slowAxis_] = (cells[slowAxis_] + Strips::rows - 1) / Strips::rows * Strips::rows;
		addLevel(cells);
		for (int c = 0; c < n; ++c) {
			parent_[c] = 0;
			for (int a = 0; a < D; ++a)
				parent_[c] += c / stride_[a] % grid.cells(a) / 2 * levels_[0].stride[a];
		}
		while (levels_.back().count() > 1)
			addLevel(std::array<int, D>(levels_.back().cells));
	}
	/// Only cells of this part are used from now on.
	void keepOnly(const ActiveRange& range)
	{
		const std::size_t first = range.firstCell, last = range.lastCell;
		matrix_.keepOnly(first, last);
		inverse_.keepOnly(first, last);
		smoothed_.keepOnly(first, last);
	}
	/// Of the matrix; to be set for all cells of the halo before build().
	Cell& operator[](int cell) { return matrix_[cell]; }
	/// The coarser grids, and the diagonal. Collective.
	void build(const StepContext<D>& step)
	{
		step.owned.eachCell([&](int c) { inverse_[c] = inverseDiagonal(matrix_.data(), stride_, c); });
		Level&    coarse  = levels_[0];
		const int ofStrip = Strips::rows / 2 * coarse.stride[slowAxis_];
		overOwnStrips(step, [&](int strip, int first, int last) {
			std::fill_n(coarse.matrix.begin() + strip * ofStrip, ofStrip, Cell {});
			coarsen(matrix_.data(), stride_, parent_.data(), first, last, coarse);
		});
		gather(step, coarse.matrix.data(), sizeof(Cell));
		for (std::size_t k = 0; k < levels_.size(); ++k) {
			Level& level = levels_[k];
			overCells(step, level, [&](int c) { level.inverse[c] = inverseDiagonal(level.matrix.data(), level.stride, c); });
			if (k + 1 == levels_.size()) break;
			Level& next = levels_[k + 1];
			overRows(step, next, level, [&](int first, int last, int firstFine, int lastFine) {
				std::fill(next.matrix.begin() + first, next.matrix.begin() + last, Cell {});
				coarsen(level.matrix.data(), level.stride, level.parent.data(), firstFine, lastFine, next);
			});
		}
	}
	/// z of the cells of this rank, from r of them; 0 where nothing is stored. Collective.
	void solve(const StepContext<D>& step, const PagedArray<double>& r, PagedArray<double>& z)
	{
		const auto left = [&](int c) { return r[c] - matrix_[c].storage * smoothed_[c] - flow(matrix_.data(), stride_, smoothed_.data(), c); };
		step.owned.eachCell([&](int c) { smoothed_[c] = damping * inverse_[c] * r[c]; });
		share(step, smoothed_);
		Level&    coarse  = levels_[0];
		const int ofStrip = Strips::rows / 2 * coarse.stride[slowAxis_];
		overOwnStrips(step, [&](int strip, int first, int last) {
			std::fill_n(coarse.r.begin() + strip * ofStrip, ofStrip, 0.0);
			for (int c = first; c < last; ++c)
				if (inverse_[c] > 0.0) coarse.r[parent_[c]] += left(c);
		});
		gather(step, coarse.r.data(), sizeof(double));
		cycle(step, 0);
		step.halo.eachCell([&](int c) {
			if (matrix_[c].storage > 0.0) smoothed_[c] += coarse.z[parent_[c]];
		});
		step.owned.eachCell([&](int c) { z[c] = inverse_[c] > 0.0 ? smoothed_[c] + damping * inverse_[c] * left(c) : 0.0; });
	}

	double diagonal(int cell) const { return inverse_[cell] > 0.0 ? 1.0 / inverse_[cell] : 0.0; }

	/// Values of cells that each rank has for those that its points touch become known as far as forces and flows of these reach. Collective.
	static void share(const StepContext<D>& step, PagedArray<double>& values)
	{
		if (!step.slabs) return;
		step.slabs->shared().beyond = true;
		step.slabs->shared().cells(values.data());
		step.slabs->complete();
	}

private:
	/// Share of a step of Jacobi that is taken. Below 1 a step reduces every error, because no eigenvalue of D^-1 M is larger than 2.
	static constexpr double damping = 0.8;
	/// Cells of a piece of work for a thread.
	static constexpr int piece = 1024;
	using Strides              = std::array<int, D>;
	/// A coarser grid. Cells are numbered as those of the grid are: the slowest axis is the same.
	struct Level {
		std::array<int, D>  cells {};
		Strides             stride {};
		std::vector<int>    parent; ///< of each cell, on the next level
		std::vector<Cell>   matrix;
		std::vector<double> inverse; ///< of the diagonal; 0: not solved for
		std::vector<double> r, z, smoothed;

		int count() const { return int(matrix.size()); }
	};

	/// Flow out of a cell through its faces.
	static double flow(const Cell* matrix, const Strides& stride, const double* z, int c)
	{
		double out = 0.0;
		for (int a = 0; a < D; ++a) {
			const int s = stride[a];
			if (const double ahead = matrix[c].conductance[a]; ahead > 0.0) out += ahead * (z[c] - z[c + s]);
			if (const double behind = c >= s ? matrix[c - s].conductance[a] : 0.0; behind > 0.0) out += behind * (z[c] - z[c - s]);
		}
		return out;
	}
	static double inverseDiagonal(const Cell* matrix, const Strides& stride, int c)
	{
		double sum = matrix[c].storage;
		if (!(sum > 0.0)) return 0.0;
		for (int a = 0; a < D; ++a)
			sum += matrix[c].conductance[a] + (c >= stride[a] ? matrix[c - stride[a]].conductance[a] : 0.0);
		return 1.0 / sum;
	}
	void addLevel(const std::array<int, D>& finer)
	{
		Level l;
		int   n = 1;
		// faster axes have the smaller strides, as on the grid
		std::array<int, D> axes {};
		std::iota(axes.begin(), axes.end(), 0);
		std::sort(axes.begin(), axes.end(), [&](int a, int b) { return stride_[a] < stride_[b]; });
		for (const int a : axes) {
			l.cells[a]  = (finer[a] + 1) / 2;
			l.stride[a] = n;
			n *= l.cells[a];
		}
		l.matrix.resize(n);
		for (auto* values : { &l.inverse, &l.r, &l.z, &l.smoothed })
			values->resize(n);
		if (!levels_.empty()) {
			Level& above = levels_.back();
			above.parent.resize(above.matrix.size());
			for (int c = 0; c < above.count(); ++c)
				for (int a = 0; a < D; ++a)
					above.parent[c] += c / above.stride[a] % above.cells[a] / 2 * l.stride[a];
		}
		levels_.push_back(std::move(l));
	}
	/// Adds cells to those of the next level. A face there is as large as 2^(D-1) of these, and the way through it twice as long.
	void coarsen(const Cell* matrix, const Strides& stride, const int* parent, int first, int last, Level& to) const
	{
		for (int c = first; c < last; ++c) {
			Cell& cell = to.matrix[parent[c]];
			cell.storage += matrix[c].storage;
			for (int a = 0; a < D; ++a)
				if (matrix[c].conductance[a] > 0.0 && parent[c + stride[a]] != parent[c]) cell.conductance[a] += 0.5 * matrix[c].conductance[a];
		}
	}
	/// Values of the first coarser grid, of which each rank has those in its strips, become known to all.
	void gather(const StepContext<D>& step, void* values, std::size_t bytesOfCell) const
	{
		if (!step.slabs) return;
		const std::size_t        ofStrip = Strips::rows / 2 * levels_[0].stride[slowAxis_] * bytesOfCell;
		std::vector<std::size_t> lengths(step.slabs->count());
		for (int strip = 0; strip < step.strips.count(); ++strip)
			lengths[step.slabs->rankOf(strip)] += ofStrip;
		step.slabs->ranks().allGather(static_cast<char*>(values) + step.strips.begin() * ofStrip, lengths, values);
	}
	/// work(strip, first cell, last cell) for the strips of this rank and their cells.
	template <class Work> void overOwnStrips(const StepContext<D>& step, Work&& work) const
	{
		const Strips& strips = step.strips;
		const int     cells  = Strips::rows * stride_[slowAxis_];
		ThreadPool::run(strips.end() - strips.begin(), strips.parallel ? ThreadPool::threads() : 1, [&](int k, int) {
			const int strip = strips.begin() + k, first = std::max(step.owned.firstCell, strip * cells);
			work(strip, first, std::max(first, std::min(step.owned.lastCell, (strip + 1) * cells)));
		});
	}
	/// work(first and last cell of a row of the coarser grid, of the rows of the finer one in it).
	template <class Work> void overRows(const StepContext<D>& step, const Level& coarse, const Level& fine, Work&& work) const
	{
		const int to = coarse.stride[slowAxis_], from = fine.stride[slowAxis_], rows = coarse.cells[slowAxis_];
		ThreadPool::run(rows, step.strips.parallel && fine.count() > piece ? ThreadPool::threads() : 1, [&](int row, int) {
			work(row * to, (row + 1) * to, 2 * row * from, std::min(2 * row + 2, fine.cells[slowAxis_]) * from);
		});
	}
	template <class Work> void overCells(const StepContext<D>& step, const Level& level, Work&& work) const
	{
		const int n = level.count();
		ThreadPool::run((n + piece - 1) / piece, step.strips.parallel ? ThreadPool::threads() : 1, [&](int k, int) {
			for (int c = k * piece; c < std::min(n, (k + 1) * piece); ++c)
				work(c);
		});
	}
	/// z of a coarser grid from its r.
	void cycle(const StepContext<D>& step, std::size_t k)
	{
		Level& level = levels_[k];
		if (k + 1 == levels_.size()) {
			overCells(step, level, [&](int c) { level.z[c] = level.inverse[c] * level.r[c]; });
			return;
		}
		const auto left = [&](int c) {
			return level.r[c] - level.matrix[c].storage * level.z[c] - flow(level.matrix.data(), level.stride, level.z.data(), c);
		};
		Level& next = levels_[k + 1];
		overCells(step, level, [&](int c) { level.z[c] = damping * level.inverse[c] * level.r[c]; });
		overRows(step, next, level, [&](int first, int last, int firstFine, int lastFine) {
			std::fill(next.r.begin() + first, next.r.begin() + last, 0.0);
			for (int c = firstFine; c < lastFine; ++c)
				if (level.inverse[c] > 0.0) next.r[level.parent[c]] += left(c);
		});
		cycle(step, k + 1);
		overCells(step, level, [&](int c) {
			if (level.inverse[c] > 0.0) level.z[c] += next.z[level.parent[c]];
		});
		overCells(step, level, [&](int c) { level.smoothed[c] = level.inverse[c] > 0.0 ? level.z[c] + damping * level.inverse[c] * left(c) : 0.0; });
		level.z.swap(level.smoothed);
	}

	int                slowAxis_ = 0;
	Strides            stride_ {};
	PagedArray<Cell>   matrix_;
	PagedArray<int>    parent_;
	PagedArray<double> inverse_, smoothed_;
	std::vector<Level> levels_;
};

} // namespace talik
