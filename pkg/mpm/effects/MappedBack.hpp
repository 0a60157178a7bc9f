// SPDX-License-Identifier: GPL-2.0-or-later
#pragma once

#include <pkg/mpm/effects/SolidMotion.hpp>
#include <pkg/mpm/points/CellMeans.hpp>

#include <vector>

namespace talik {

/// Velocities that points map back to the nodes within a step, from which their strain and path follow at nodes beside cells that are empty up to the
/// sky, eq. (8.3a) (modified update, Sulsky et al. 1995), where points fill a cell each. Some forces of nodes give accelerations that no point feels, sum
/// S a = 0. Within the ground their strain takes stress to the balance of the nodes, and closes gaps. At its surface no stress can balance them, and the
/// ground would creep for ever.
template <int D> class MappedBack {
public:
	void bind(const Grid<D>& grid, const Vec<D>& gravity);
	/// Finds the nodes beside cells without points, also above them, and the cells whose points reach these nodes; after CellMeans::locate.
	void find(const Grid<D>& grid, const CellMeans<D>& cells, const Strips& strips);
	/// Adds what the points of a block have more of momentum, at the end of the step, than the solved velocities of the nodes say.
	void map(const CellMeans<D>& cells, const SolidMotion<D>& motion, const WeightBlock<D>& w);
	/// True if a node has the velocity that points map back.
	bool isBeside(int node) const { return beside_[node]; }

	NodeField<D> missing; ///< momentum [kg m/s], cleared before each step

private:
	int                        upright_ = 0, up_ = 0; ///< axis nearest to gravity, side from which it comes; 0: none
	std::vector<unsigned char> empty_, emptyBefore_;  ///< by cell
	std::vector<unsigned char> open_;                 ///< by cell: empty up to the sky
	std::vector<unsigned char> beside_;               ///< by node
	std::vector<unsigned char> reaches_;              ///< by cell
};

} // namespace talik
