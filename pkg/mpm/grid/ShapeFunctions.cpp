// SPDX-License-Identifier: GPL-2.0-or-later
#include <pkg/base/Errors.hpp>
#include <pkg/base/ProcessorVersions.hpp>
#include <pkg/mpm/grid/ShapeFunctions.hpp>

#include <algorithm>
#include <cmath>

namespace talik {

namespace {
	/// Factors and slopes along one axis of points whose support is the node and those beside it that lie nearest; adds the axis' share to base.
	TALIK_PROCESSOR_VERSIONS void quadraticSpline(
	        int count, const double* x, double lower, double inverseSpacing, int stride, int* base, double (&value)[supportNodes][blockSize],
	        double (&slope)[supportNodes][blockSize])
	{
		// positions are no part of the block
#pragma GCC ivdep
		for (int k = 0; k < count; ++k) {
			const double s    = (x[k] - lower) * inverseSpacing + 0.5; // half a cell behind the node coordinate: never negative inside the box
			const int    node = int(s);
			const double f    = s - node; // 0 .. 1 from the middle between the first two nodes
			base[k] += node * stride;
			value[0][k] = 0.5 * (1.0 - f) * (1.0 - f);
			value[1][k] = 0.5 + f * (1.0 - f);
			value[2][k] = 0.5 * f * f;
			slope[0][k] = (f - 1.0) * inverseSpacing;
			slope[1][k] = (1.0 - 2.0 * f) * inverseSpacing;
			slope[2][k] = f * inverseSpacing;
		}
	}

	void                          formProducts(WeightBlock<2>&) {}
	TALIK_PROCESSOR_VERSIONS void formProducts(WeightBlock<3>& w)
	{
		for (int row = 0; row < supportRows<3>; ++row) {
			const int y = row % supportNodes, z = row / supportNodes;
#pragma GCC ivdep
			for (int k = 0; k < w.count; ++k) {
				w.product[0][row][k] = w.value[1][y][k] * w.value[2][z][k];
				w.product[1][row][k] = w.slope[1][y][k] * w.value[2][z][k];
				w.product[2][row][k] = w.value[1][y][k] * w.slope[2][z][k];
			}
		}
	}

	/// N = 3/4 - xi^2 for |xi| <= 1/2, (3/2 - |xi|)^2/2 up to 3/2, xi = (x - x_I)/h.
	template <int D> class QuadraticBSpline final : public ShapeFunction<D> {
	public:
		std::string name() const override { return "quadraticBSpline"; }
		double      steepness() const override { return 6.0; } // next to the middle between two nodes

	protected:
		double faceCurvature(const double (&slope)[supportNodes], double width) const override
		{
			// a whole number of points per cell: then it vanishes at both ends of the support
			const double share = 1.0 / std::max(1.0, std::round(1.0 / width));
			const double rest  = std::fmod(slope[2], share);
			return 0.5 * rest * (share - rest);
		}
		void along(const Grid<D>& grid, int axis, const double* x, int count, WeightBlock<D>& w) const override
		{
			quadraticSpline(count, x, grid.lower()[axis], grid.inverseSpacing(), grid.nodeStride(axis), w.base, w.value[axis], w.slope[axis]);
		}
	};

	/// Uniform generalised interpolation: the linear hat averaged over a point of half-width h/4.
	template <int D> class Gimp final : public ShapeFunction<D> {
	public:
		std::string name() const override { return "gimp"; }
		double      steepness() const override { return 28.0 / 3.0; } // a quarter of a cell beside a node

	private:
		// Hat function averaged over [xi - l, xi + l], xi and l in cells, l <= 1/2, and its derivative with respect to xi.
		static double average(double xi)
		{
			const double r = std::abs(xi);
			if (r < halfWidth) return 1.0 - (r * r + halfWidth * halfWidth) / (2.0 * halfWidth);
			if (r < 1.0 - halfWidth) return 1.0 - r;
			if (r < 1.0 + halfWidth) return (1.0 + halfWidth - r) * (1.0 + halfWidth - r) / (4.0 * halfWidth);
			return 0.0;
		}
		static double derivative(double xi)
		{
			const double r    = std::abs(xi);
			const double sign = xi < 0.0 ? -1.0 : 1.0;
			if (r < halfWidth) return -xi / halfWidth;
			if (r < 1.0 - halfWidth) return -sign;
			if (r < 1.0 + halfWidth) return -sign * (1.0 + halfWidth - r) / (2.0 * halfWidth);
			return 0.0;
		}

	protected:
		double faceCurvature(const double (&slope)[supportNodes], double) const override
		{
			const double fromNode = halfWidth * slope[1];
			return 0.25 * (halfWidth * halfWidth - fromNode * fromNode) / halfWidth;
		}
		void along(const Grid<D>& grid, int axis, const double* x, int count, WeightBlock<D>& w) const override
		{
			const int stride = grid.nodeStride(axis);
			for (int k = 0; k < count; ++k) {
				const double s    = grid.nodeCoordinate(axis, x[k]);
				const int    node = int(s - 0.5);
				w.base[k] += node * stride;
				for (int i = 0; i < supportNodes; ++i) {
					w.value[axis][i][k] = average(s - (node + i));
					w.slope[axis][i][k] = derivative(s - (node + i)) * grid.inverseSpacing();
				}
			}
		}
		static constexpr double halfWidth = 0.25;
	};
} // namespace

std::vector<std::string> shapeFunctionNames() { return { "quadraticBSpline", "gimp" }; }

template <int D> std::unique_ptr<ShapeFunction<D>> makeShapeFunction(const std::string& name)
{
	const int place = placeOfName("MpmEngine.shapeFunction", name, shapeFunctionNames());
	if (place == 0) return std::make_unique<QuadraticBSpline<D>>();
	return std::make_unique<Gimp<D>>();
}

template <int D>
void ShapeFunction<D>::evaluate(const Grid<D>& grid, const std::array<const double*, D>& position, int first, int count, WeightBlock<D>& w) const
{
	w.first = first;
	w.count = count;
	for (int k = 0; k < count; ++k)
		w.base[k] = 0;
	for (int n = 0; n < supportCount<D>; ++n) {
		w.offset[n] = 0;
		for (int a = 0, rest = n; a < D; ++a, rest /= supportNodes)
			w.offset[n] += rest % supportNodes * grid.nodeStride(a);
	}
	for (int a = 0; a < D; ++a)
		along(grid, a, position[a] + first, count, w);
	formProducts(w);
}

template <int D> void ShapeFunction<D>::moveToFace(const Grid<D>& grid, const Vec<D>& toFace, int k, WeightBlock<D>& w) const
{
	const double width = 2.0 * lengthOf<D>(toFace) * grid.inverseSpacing();
	for (int a = 0; a < D; ++a) {
		double slope[supportNodes];
		for (int i = 0; i < supportNodes; ++i)
			slope[i] = w.slope[a][i][k] * grid.spacing();
		const double cells = toFace[a] * grid.inverseSpacing(), part = 2.0 * cells / width;
		const double curvature = width > 0.0 ? part * part * faceCurvature(slope, width) : 0.0;
		for (int i = 0; i < supportNodes; ++i)
			w.value[a][i][k] += cells * slope[i] + (i == 1 ? -2.0 : 1.0) * curvature;
	}
}

TALIK_IN_PLANE_AND_SPACE(ShapeFunction);

template std::unique_ptr<ShapeFunction<2>> makeShapeFunction<2>(const std::string&);
template std::unique_ptr<ShapeFunction<3>> makeShapeFunction<3>(const std::string&);

} // namespace talik
