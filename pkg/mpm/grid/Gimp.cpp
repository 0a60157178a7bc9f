// SPDX-License-Identifier: GPL-2.0-or-later
#include <pkg/mpm/grid/ShapeFunctions.hpp>

#include <cmath>

namespace talik {

namespace {

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
				const int    node = static_cast<int>(s - 0.5);
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

template <int D> std::unique_ptr<ShapeFunction<D>> makeGimp() { return std::make_unique<Gimp<D>>(); }

template std::unique_ptr<ShapeFunction<2>> makeGimp<2>();
template std::unique_ptr<ShapeFunction<3>> makeGimp<3>();

} // namespace talik
