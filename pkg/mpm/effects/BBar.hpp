// SPDX-License-Identifier: GPL-2.0-or-later
#pragma once

#include <pkg/mpm/effects/PoreContent.hpp>
#include <pkg/mpm/effects/PoreWater.hpp>
#include <pkg/mpm/effects/SolidMotion.hpp>
#include <pkg/mpm/points/CellMeans.hpp>

namespace talik {

/// Volume and total stress of the points as the momentum balance sees them. Without B-bar (cells null) every point keeps its own strain, and its
/// stress is changed by its pore pressure alone. With B-bar all points of a cell have one volumetric strain and, transposed, one mean stress.
template <int D> class BBar {
public:
	/// The weight of a cell gives its mean stress a gradient, eq. (8.2a).
	void allocate(const Grid<D>& grid) { weights_.reset(grid.cellCount()); }
	void clear(const ActiveRange& range)
	{
		if (!weights_.empty()) std::fill(weights_.begin() + range.firstCell, weights_.begin() + range.lastCell, Weight {});
	}
	/// What addToCells() adds to, but for the sums of cells.
	void share(HaloExchange& rows)
	{
		if (!weights_.empty()) rows.cells(weights_.data());
	}

	/// Adds the mean stress of points to their cells, and their weight; water and content may be null.
	void addToCells(
	        CellMeans<D>& cells, const MaterialPoints<D>& points, const SolidMotion<D>& motion, const PoreWater<D>* water, const PoreContent<D>* content,
	        int first, int last);
	/// When the means of the cells are finished.
	void finish(const ActiveRange& range, const CellMeans<D>& cells);
	/// Leaves in motion.addedStress what the momentum balance adds to the normal stresses of points.
	void findAddedStress(
	        const CellMeans<D>* cells, const MaterialPoints<D>& points, SolidMotion<D>& motion, const PoreWater<D>* water, int first, int last) const;

	/// Adds the divergence of a block to its cells, volume by volume.
	static void addDivergence(CellMeans<D>& cells, const MaterialPoints<D>& points, const SolidMotion<D>& motion, const WeightBlock<D>& w);
	/// Gives the displacement gradient of points the mean trace of their cell, and the points their new volume.
	static void strain(const CellMeans<D>* cells, MaterialPoints<D>& points, SolidMotion<D>& motion, int first, int last);

private:
	/// Sums over the points of a cell: volume times gravity's part of the place, mass, volume times stress along gravity. Once finished, the mean of
	/// the place, and the density that the mean stress bears.
	struct Weight {
		double depth, mass, along;
	};
	TALIK_PROCESSOR_VERSIONS static void replaceTraces(const CellMeans<D>& cells, SolidMotion<D>& motion, int first, int last);
	static void                          strainAboutAxis(const CellMeans<D>* cells, MaterialPoints<D>& points, SolidMotion<D>& motion, int first, int last);
	/// V times det(1 + G), eq. (2.1).
	TALIK_PROCESSOR_VERSIONS static void stretchVolumes(MaterialPoints<D>& points, const SolidMotion<D>& motion, int first, int last);

	PagedArray<Weight> weights_; ///< by cell; empty without B-bar
};

} // namespace talik
