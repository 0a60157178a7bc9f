// SPDX-License-Identifier: GPL-2.0-or-later
#pragma once

#include <pkg/mpm/grid/Vector.hpp>

#include <cstddef>

namespace talik {

/// Uniform grid of nodes over the box [lower, upper], extended by one ghost layer on every side.
/// Node coordinates count from the ghost layer: along each axis node 0 is the ghost, node 1 lies on the lower wall, node
/// cells+1 on the upper wall and node cells+2 is the upper ghost. Nodes and cells are numbered so that the longest axis varies
/// slowest, because the strips that threads work on are stacked along it.
template <int D> class Grid {
public:
	Grid() = default;
	/// spacing [m] > 0; upper - lower must be a whole number (>= 1) of spacings along each axis.
	/// Throws std::invalid_argument naming attribute, value and remedy.
	Grid(const Vec<D>& lower, const Vec<D>& upper, double spacing);

	double        spacing() const { return spacing_; }
	double        inverseSpacing() const { return inverseSpacing_; }
	const Vec<D>& lower() const { return lower_; }
	const Vec<D>& upper() const { return upper_; }

	int cells(int axis) const { return cells_[axis]; }
	int nodes(int axis) const { return cells_[axis] + 3; }
	int nodeStride(int axis) const { return nodeStride_[axis]; }
	int cellStride(int axis) const { return cellStride_[axis]; }
	int nodeCount() const { return nodeCount_; }
	int cellCount() const { return cellCount_; }
	int slowAxis() const { return slowAxis_; }

	/// Volume (area per metre of thickness in 2-D) of a cell [m^D].
	double cellVolume() const;
	/// Area (length per metre of thickness in 2-D) of a cell's face [m^(D-1)].
	double faceArea() const { return cellVolume() * inverseSpacing_; }

	/// Position in node coordinates: 1 on the lower wall, cells+1 on the upper wall.
	double nodeCoordinate(int axis, double x) const { return (x - lower_[axis]) * inverseSpacing_ + 1.0; }
	double nodePosition(int axis, int node) const { return lower_[axis] + (node - 1) * spacing_; }

	int                nodeIndex(const std::array<int, D>& node) const;
	int                cellIndex(const std::array<int, D>& cell) const;
	std::array<int, D> nodeOf(int index) const;

	bool contains(const Vec<D>& x) const;

private:
	Vec<D>             lower_ {}, upper_ {};
	double             spacing_ = 0.0, inverseSpacing_ = 0.0;
	std::array<int, D> cells_ {}, nodeStride_ {}, cellStride_ {};
	int                nodeCount_ = 0, cellCount_ = 0, slowAxis_ = D - 1;
};

} // namespace talik
