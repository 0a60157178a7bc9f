// SPDX-License-Identifier: GPL-2.0-or-later
#pragma once

#include <pkg/mpm/grid/Grid.hpp>

#include <cmath>
#include <memory>
#include <string>
#include <vector>

namespace talik {

/// Points are worked on in blocks of this length, so that the weights of a block stay in the first-level cache.
constexpr int blockSize = 32;

/// Nodes per axis that a point touches.
constexpr int supportNodes = 3;

/// Nodes that a point touches.
template <int D> constexpr int supportCount = D == 2 ? supportNodes* supportNodes : supportNodes* supportNodes* supportNodes;

/// Rows of nodes along the first axis that a point touches.
template <int D> constexpr int supportRows = supportCount<D> / supportNodes;

/// Shape functions of consecutive points as factors along the axes; loops form the products themselves (see overNodes).
template <int D> struct WeightFactors {
	int    first = 0;                         ///< place of the first point
	int    count = 0;                         ///< <= blockSize
	int    base[blockSize];                   ///< index of the node with the lowest coordinates in the support
	int    offset[supportCount<D>];           ///< from the base to each node of the support
	double value[D][supportNodes][blockSize]; ///< one-dimensional factors [-]
	double slope[D][supportNodes][blockSize]; ///< and their derivatives [1/m]
};

template <int D> struct WeightBlock;

template <> struct WeightBlock<2> : WeightFactors<2> {
	/// What the nodes of a row have in common: the factor along y (a = 0), and its slope (a = 1).
	const double* row(int a, int row) const { return a == 0 ? value[1][row] : slope[1][row]; }
};

template <> struct WeightBlock<3> : WeightFactors<3> {
	double product[3][supportRows<3>][blockSize];
	/// What the nodes of a row have in common: the product of the factors along y and z (a = 0), the same with the slope along axis a.
	const double* row(int a, int row) const { return product[a][row]; }
};

/// A family of shape functions. A new one is a class and its line in ShapeFunctions.cpp. The support of a point has supportNodes nodes per axis
/// and covers the point's cell and
/// at most one node behind and two ahead of the cell's lower corner.
template <int D> class ShapeFunction {
public:
	virtual ~ShapeFunction() = default;

	virtual std::string name() const = 0;
	/// Bound of h^2 sum_I (dS_I/dx)^2/S_I over all positions in one dimension [-]. By Cauchy and Schwarz no wave of speed c makes
	/// the nodes' lumped masses swing faster than omega = c/h sqrt(D bound), wherever the points lie.
	virtual double steepness() const = 0;
	/// Weights of count <= blockSize points from place first on; position[axis] are whole arrays.
	void evaluate(const Grid<D>& grid, const std::array<const double*, D>& position, int first, int count, WeightBlock<D>& weights) const;
	/// Moves the values (not slopes, not products) of one point of a block to its face at toFace from the middle, for points as wide as toFace is
	/// twice long: to what the slopes of such points behind it, times their width, add up to. A pressure on the face then balances
	/// the same stress in all points behind; put at the middle of the point it leaves stripes, for the face is where ground ends.
	void moveToFace(const Grid<D>& grid, const Vec<D>& toFace, int point, WeightBlock<D>& weights) const;
	/// The mean of the values at both faces of each point along the first axis, for points of these sizes in the plane, by place: the radius times a
	/// pressure in them then adds up to nothing at a node, as around it, also beside the axis.
	template <class Size> WeightBlock<D> meanOfFaces(const Grid<D>& grid, Size&& size, const WeightBlock<D>& weights) const
	{
		WeightBlock<D> mean = weights;
		for (int k = 0; k < mean.count; ++k) {
			double slope[supportNodes];
			for (int i = 0; i < supportNodes; ++i)
				slope[i] = mean.slope[0][i][k] * grid.spacing();
			const double curvature = faceCurvature(slope, std::sqrt(size(mean.first + k)) * grid.inverseSpacing());
			for (int i = 0; i < supportNodes; ++i)
				mean.value[0][i][k] += (i == 1 ? -2.0 : 1.0) * curvature;
		}
		return mean;
	}

protected:
	/// Factors and slopes along one axis; adds the axis' share to base.
	virtual void along(const Grid<D>& grid, int axis, const double* x, int count, WeightBlock<D>& weights) const = 0;
	/// What the value of an outer node at a face has beyond value and slope of the middle [-]; the middle node has twice the opposite.
	/// slope: of the three nodes, per cell; width: of a point [cells]. Vanishes with the slope of either outer node, and as fast: nodes
	/// that hardly feel the points hardly feel the face.
	virtual double faceCurvature(const double (&slope)[supportNodes], double width) const = 0;
};

/// "quadraticBSpline" (default), "gimp" (uniform, points a quarter of a cell in half-width).
std::vector<std::string> shapeFunctionNames();

/// Throws std::invalid_argument for an unknown name.
template <int D> std::unique_ptr<ShapeFunction<D>> makeShapeFunction(const std::string& name);

/// work(node, S, G) for every node of point k of the block; G is the gradient of S [1/m].
template <int D, class Work> [[gnu::always_inline]] inline void overNodes(const WeightBlock<D>& w, int k, Work&& work)
{
	const int base = w.base[k];
#pragma GCC unroll 9
	for (int n = 0; n < supportCount<D>; ++n) {
		int at[D];
		for (int a = 0, rest = n; a < D; ++a, rest /= supportNodes)
			at[a] = rest % supportNodes;
		double weight = w.value[0][at[0]][k];
		for (int a = 1; a < D; ++a)
			weight *= w.value[a][at[a]][k];
		Vec<D> g;
		for (int a = 0; a < D; ++a) {
			g[a] = a == 0 ? w.slope[0][at[0]][k] : w.value[0][at[0]][k];
			for (int b = 1; b < D; ++b)
				g[a] *= a == b ? w.slope[b][at[b]][k] : w.value[b][at[b]][k];
		}
		work(base + w.offset[n], weight, g);
	}
}

} // namespace talik
