// SPDX-License-Identifier: GPL-2.0-or-later
#include <pkg/mpm/grid/ShapeFunctions.hpp>

#include <cmath>

namespace talik {

namespace {

	/// Hat functions; points make noise when they cross cells: for debugging.
	template <int D> class Linear final : public ShapeFunction<D> {
	public:
		std::string name() const override { return "linear"; }
		// none at the nodes, where masses vanish: this one holds for points at least a fifteenth of a cell away from them
		double steepness() const override { return 16.0; }

	protected:
		void along(const Grid<D>& grid, int axis, const double* x, int count, WeightBlock<D>& w) const override
		{
			const double inverse = grid.inverseSpacing();
			for (int k = 0; k < count; ++k) {
				const double s    = grid.nodeCoordinate(axis, x[k]);
				const int    node = std::fmin(s, grid.cells(axis));
				const double f    = s - node;
				w.base[k] += node * grid.nodeStride(axis);
				w.value[axis][0][k] = 1.0 - f;
				w.value[axis][1][k] = f;
				w.value[axis][2][k] = 0.0;
				w.slope[axis][0][k] = -inverse;
				w.slope[axis][1][k] = inverse;
				w.slope[axis][2][k] = 0.0;
			}
		}
	};

} // namespace

template <int D> std::unique_ptr<ShapeFunction<D>> makeLinear() { return std::make_unique<Linear<D>>(); }

template std::unique_ptr<ShapeFunction<2>> makeLinear<2>();
template std::unique_ptr<ShapeFunction<3>> makeLinear<3>();

} // namespace talik
