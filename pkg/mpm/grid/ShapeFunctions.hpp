// SPDX-License-Identifier: GPL-2.0-or-later
#pragma once

#include <pkg/mpm/grid/Grid.hpp>
#include <pkg/mpm/grid/WeightBlock.hpp>

#include <memory>
#include <string>
#include <vector>

namespace talik {

/// A family of shape functions. A new one is a class and its line of the table in ShapeFunctions.cpp. The support of a point has supportNodes nodes per axis
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

protected:
	/// Factors and slopes along one axis; adds the axis' share to base.
	virtual void along(const Grid<D>& grid, int axis, const double* x, int count, WeightBlock<D>& weights) const = 0;
	/// What the value of an outer node at a face has beyond value and slope of the middle [-]; the middle node has twice the opposite.
	/// slope: of the three nodes, per cell; width: of a point [cells]. Vanishes with the slope of either outer node, and as fast: nodes
	/// that hardly feel the points hardly feel the face.
	virtual double faceCurvature(const double (&slope)[supportNodes], double width) const
	{
		(void)slope, (void)width;
		return 0.0;
	}
};

/// "quadraticBSpline" (default), "gimp" (uniform, points a quarter of a cell in half-width), "linear" (debugging only).
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
