// SPDX-License-Identifier: GPL-2.0-or-later
#pragma once

#include <pkg/base/PagedArray.hpp>
#include <pkg/mpm/grid/Grid.hpp>
#include <pkg/mpm/points/ActiveRange.hpp>
#include <pkg/mpm/StepContext.hpp>

#include <array>
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

	void allocate(const Grid<D>& grid);
	/// Only cells of this part are used from now on.
	void keepOnly(const ActiveRange& range);
	/// Of the matrix; to be set for all cells of the halo before build().
	Cell& operator[](int cell) { return matrix_[cell]; }
	/// The coarser grids, and the diagonal. Collective.
	void build(const StepContext<D>& step);
	/// z of the cells of this rank, from r of them; 0 where nothing is stored. Collective.
	void solve(const StepContext<D>& step, const PagedArray<double>& r, PagedArray<double>& z);

	double diagonal(int cell) const { return inverse_[cell] > 0.0 ? 1.0 / inverse_[cell] : 0.0; }

	/// Values of cells that each rank has for those that its points touch become known as far as forces and flows of these reach. Collective.
	static void share(const StepContext<D>& step, PagedArray<double>& values);

private:
	using Strides = std::array<int, D>;
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

	static double              flow(const Cell* matrix, const Strides& stride, const double* z, int cell);
	static double              inverseDiagonal(const Cell* matrix, const Strides& stride, int cell);
	void                       addLevel(const std::array<int, D>& finer);
	void                       coarsen(const Cell* matrix, const Strides& stride, const int* parent, int first, int last, Level& to) const;
	void                       gather(const StepContext<D>& step, void* values, std::size_t bytesOfCell) const;
	template <class Work> void overOwnStrips(const StepContext<D>& step, Work&& work) const;
	template <class Work> void overRows(const StepContext<D>& step, const Level& coarse, const Level& fine, Work&& work) const;
	template <class Work> void overCells(const StepContext<D>& step, const Level& level, Work&& work) const;
	void                       cycle(const StepContext<D>& step, std::size_t level);

	int                slowAxis_ = 0;
	Strides            stride_ {};
	PagedArray<Cell>   matrix_;
	PagedArray<int>    parent_;
	PagedArray<double> inverse_, smoothed_;
	std::vector<Level> levels_;
};

} // namespace talik
