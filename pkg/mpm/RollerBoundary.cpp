// SPDX-License-Identifier: GPL-2.0-or-later
#include <pkg/mpm/RollerBoundary.hpp>
#include <pkg/mpm/Check.hpp>

namespace talik {

template <int D> void RollerBoundary<D>::validate(const Grid<D>& grid) const
{
	requireSetting(
	        this->region_.kind == Region<D>::Kind::side,
	        "RollerBoundary.region",
	        this->region_.describe(),
	        "must be a side of the box, which has a normal; use FixedBoundary for other nodes");
	Boundary<D>::validate(grid);
}

template <int D> void RollerBoundary<D>::constrainMotion(const Grid<D>& grid, MotionConstraints<D>& constraints) const
{
	const Side side   = this->region_.on;
	const int  inward = side.upper ? -grid.nodeStride(side.axis) : grid.nodeStride(side.axis);
	Vec<D>     sign;
	sign.fill(1.0);
	sign[side.axis] = -1.0;
	for (int node : wallNodes(grid, this->region_)) {
		constraints.fixSolid(node, side.axis);
		constraints.tieLiquid(node, side.axis);
		constraints.mirror(node - inward, node + inward, sign);
	}
}

template class RollerBoundary<2>;
template class RollerBoundary<3>;

} // namespace talik
