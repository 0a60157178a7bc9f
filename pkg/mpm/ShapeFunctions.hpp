// SPDX-License-Identifier: GPL-2.0-or-later
#pragma once

#include <pkg/mpm/Grid.hpp>

#include <memory>
#include <string>
#include <vector>

namespace talik {

/// Points are worked on in blocks of this length, so that the weights of a block stay in the first-level cache.
constexpr int blockSize = 64;

/// Nodes per axis that a point touches.
constexpr int supportNodes = 3;

/// One-dimensional weights and slopes of consecutive points; the shape function of a node is their product.
template <int D> struct WeightBlock {
	int    first = 0;       ///< place of the first point
	int    count = 0;       ///< <= blockSize
	int    base[blockSize]; ///< index of the node with the lowest coordinates in the support
	double value[D][supportNodes][blockSize]; ///< [-]
	double slope[D][supportNodes][blockSize]; ///< [1/m]
};

/// A family of shape functions. A new one is one file: a class like those in QuadraticBSpline.cpp and Gimp.cpp, and its line in
/// the table of ShapeFunctions.cpp. The support of a point has supportNodes nodes per axis and covers the point's cell and
/// at most one node behind and two ahead of the cell's lower corner.
template <int D> class ShapeFunction {
public:
	virtual ~ShapeFunction() = default;

	virtual std::string name() const = 0;
	/// Weights of count <= blockSize points from place first on; position[axis] are whole arrays.
	virtual void evaluate(const Grid<D>& grid, const std::array<const double*, D>& position, int first, int count, WeightBlock<D>& weights) const
	        = 0;
};

template <int D> std::unique_ptr<ShapeFunction<D>> makeQuadraticBSpline();
template <int D> std::unique_ptr<ShapeFunction<D>> makeGimp();
template <int D> std::unique_ptr<ShapeFunction<D>> makeLinear();

/// "quadraticBSpline" (default), "gimp" (uniform, points a quarter of a cell in half-width), "linear" (debugging only).
std::vector<std::string> shapeFunctionNames();

/// Throws std::invalid_argument for an unknown name.
template <int D> std::unique_ptr<ShapeFunction<D>> makeShapeFunction(const std::string& name);

/// work(node, S, G) for every node of point k of the block; G is the gradient of S [1/m].
template <int D, class Work> [[gnu::always_inline]] inline void overNodes(const Grid<D>& grid, const WeightBlock<D>& w, int k, Work&& work)
{
	const int base = w.base[k];
	if constexpr (D == 2) {
		for (int b = 0; b < supportNodes; ++b) {
			const double ny = w.value[1][b][k], dy = w.slope[1][b][k];
			for (int a = 0; a < supportNodes; ++a) {
				const double nx = w.value[0][a][k], dx = w.slope[0][a][k];
				work(base + a * grid.nodeStride(0) + b * grid.nodeStride(1), nx * ny, Vec<2> { dx * ny, nx * dy });
			}
		}
	} else {
		for (int c = 0; c < supportNodes; ++c) {
			const double nz = w.value[2][c][k], dz = w.slope[2][c][k];
			for (int b = 0; b < supportNodes; ++b) {
				const double ny = w.value[1][b][k], dy = w.slope[1][b][k];
				for (int a = 0; a < supportNodes; ++a) {
					const double nx = w.value[0][a][k], dx = w.slope[0][a][k];
					work(base + a * grid.nodeStride(0) + b * grid.nodeStride(1) + c * grid.nodeStride(2),
					     nx * ny * nz,
					     Vec<3> { dx * ny * nz, nx * dy * nz, nx * ny * dz });
				}
			}
		}
	}
}

} // namespace talik
