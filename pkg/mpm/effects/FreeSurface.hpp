// SPDX-License-Identifier: GPL-2.0-or-later
#pragma once

#include <pkg/mpm/boundary/Boundary.hpp>
#include <pkg/mpm/grid/Grid.hpp>
#include <pkg/mpm/grid/NodeColumns.hpp>
#include <pkg/mpm/grid/ShapeFunctions.hpp>
#include <pkg/mpm/points/CellMeans.hpp>

#include <vector>

namespace talik {

/// Nodes of a boundary's region with their share of the surface in this step.
template <int D> struct SurfacePatch {
	std::vector<SurfaceNode<D>> nodes;
};

/// The surface of the ground as nodes see it: outward area vector A_I = sum V grad S, which is the integral of S_I n over the
/// surface, at nodes near an empty cell.
template <int D> class FreeSurface {
public:
	using Record = typename NodeColumns<D>::Surface;

	void bind(MaterialPoints<D>& points, const Grid<D>& grid, const double* conductivity);
	/// Ground that touches the grid's box rests against a wall there; the rest of its surface is free. Air comes in from the top, and in
	/// ground that moves through sides that no boundary closes.
	void setBoundaries(const std::vector<std::shared_ptr<Boundary<D>>>& boundaries, const Grid<D>& grid, bool moves = true);

	/// Marks the cells whose points reach a node that boundaries may ask for; without it all points are mapped.
	void findNeeded(const Grid<D>& grid, const CellMeans<D>& cells);
	void map(const WeightBlock<D>& w);
	/// Lists the nodes of every boundary that uses the surface, as far as they lie in the range, but for those that face bodies.
	void collect(const Grid<D>& grid, const CellMeans<D>& cells, const ActiveRange& range);

	/// Patch of a boundary, by its index in the scene.
	const SurfacePatch<D>& patch(int boundary) const { return patches_[boundary]; }
	SurfacePatch<D>&       patch(int boundary) { return patches_[boundary]; }
	/// Mean conductivity around a node [W/(m K)].
	double conductivity(int node) const { return nodes[node][D + 1] / nodes[node][D]; }

	NodeField<Record::size> nodes;

private:
	/// True if the ground near a node rests against the box along axis: that part of its area belongs to the wall.
	bool atWall(const Grid<D>& grid, const CellMeans<D>& cells, const std::array<int, D>& node, int axis) const;
	/// What lies before the surface at a node with the outward area: the nearest empty cell there.
	enum Emptiness : unsigned char { filled, cavity, openAir };
	Emptiness emptinessAt(const Grid<D>& grid, const std::array<int, D>& node, const double* area) const;
	/// Sorts empty cells into those that air from outside reaches, by way of the faces of empty cells, and the rest.
	void findOpenAir(const Grid<D>& grid, const CellMeans<D>& cells);
	void letAirIn(int cell);
	void collectSide(const Grid<D>& grid, const CellMeans<D>& cells, const ActiveRange& range, int boundary);
	void collectBox(const Grid<D>& grid, const ActiveRange& range, int boundary);

	/// Cells of the box with three more around it on all sides, as far as a shape function and the search for empty cells reach.
	static constexpr int       reach = 3;
	int                        paddedIndex(const Grid<D>& grid, int cell) const;
	void                       widen(int stride);
	std::vector<unsigned char> needed_, widened_;
	std::vector<int>           place_; ///< of each cell of the box among them
	std::array<int, D>         stride_ {};
	const CellMeans<D>*        cells_    = nullptr;
	bool                       needsAll_ = false, needsSides_ = false;

	const double*                             volume_       = nullptr;
	const double*                             conductivity_ = nullptr;
	std::vector<std::shared_ptr<Boundary<D>>> boundaries_;
	std::vector<SurfacePatch<D>>              patches_;
	std::vector<std::vector<int>>             sideNodes_;
	std::vector<SurfaceNode<D>>               surface_;
	std::vector<Emptiness>                    ofSurface_; ///< what lies before each of them
	std::vector<Emptiness>                    emptiness_; ///< of each cell
	std::vector<unsigned char>                empty_;     ///< the same without distinction
	const Strips*                             strips_ = nullptr;
	std::vector<int>                          reached_;
	bool                                      openSides_[D][2] = {};
};

} // namespace talik
