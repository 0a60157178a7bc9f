// SPDX-License-Identifier: GPL-2.0-or-later
#include <pkg/mpm/FixedBoundary.hpp>
#include <pkg/mpm/Check.hpp>

namespace talik {

template <int D> void FixedBoundary<D>::validate(const Grid<D>& grid) const
{
	requireSetting(
	        this->region_.kind != Region<D>::Kind::freeSurface,
	        "FixedBoundary.region",
	        this->region_.describe(),
	        "must be a side of the box or a box of nodes");
	Boundary<D>::validate(grid);
}

template <int D> void FixedBoundary<D>::constrainMotion(const Grid<D>& grid, MotionConstraints<D>& constraints) const
{
	const Side side   = this->region_.on;
	const int  inward = side.upper ? -grid.nodeStride(side.axis) : grid.nodeStride(side.axis);
	Vec<D>     sign;
	sign.fill(-1.0);
	for (int node : wallNodes(grid, this->region_)) {
		for (int a = 0; a < D; ++a) {
			constraints.fixSolid(node, a);
			constraints.tieLiquid(node, a);
		}
		if (this->region_.kind == Region<D>::Kind::side) constraints.mirror(node - inward, node + inward, sign);
	}
}

template class FixedBoundary<2>;
template class FixedBoundary<3>;

} // namespace talik
