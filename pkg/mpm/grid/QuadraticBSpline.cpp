// SPDX-License-Identifier: GPL-2.0-or-later
#include <pkg/mpm/kernels/PlaneLoops.hpp>
#include <pkg/mpm/grid/ShapeFunctions.hpp>

#include <algorithm>
#include <cmath>

namespace talik {

namespace {

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
			planeLoops().spline(count, x, grid.lower()[axis], grid.inverseSpacing(), grid.nodeStride(axis), w.base, w.value[axis], w.slope[axis]);
		}
	};

} // namespace

template <int D> std::unique_ptr<ShapeFunction<D>> makeQuadraticBSpline() { return std::make_unique<QuadraticBSpline<D>>(); }

template std::unique_ptr<ShapeFunction<2>> makeQuadraticBSpline<2>();
template std::unique_ptr<ShapeFunction<3>> makeQuadraticBSpline<3>();

} // namespace talik
