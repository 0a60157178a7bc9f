// SPDX-License-Identifier: GPL-2.0-or-later
#include <pkg/mpm/ImpermeableBoundary.hpp>
#include <pkg/mpm/Check.hpp>

namespace talik {

template <int D> void ImpermeableBoundary<D>::validate(const Grid<D>& grid) const
{
	requireSetting(
	        this->region_.kind == Region<D>::Kind::side,
	        "ImpermeableBoundary.region",
	        this->region_.describe(),
	        "must be a side of the box; the free surface is impermeable where no DrainedBoundary is");
	Boundary<D>::validate(grid);
}

template <int D> void ImpermeableBoundary<D>::constrainMotion(const Grid<D>& grid, MotionConstraints<D>& constraints) const
{
	const Side side   = this->region_.on;
	const int  inward = side.upper ? -grid.nodeStride(side.axis) : grid.nodeStride(side.axis);
	for (int node : wallNodes(grid, this->region_)) {
		constraints.tieLiquid(node, side.axis);
		constraints.tieLiquid(node - inward, side.axis);
	}
}

template class ImpermeableBoundary<2>;
template class ImpermeableBoundary<3>;

} // namespace talik
