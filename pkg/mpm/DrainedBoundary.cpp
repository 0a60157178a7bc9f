// SPDX-License-Identifier: GPL-2.0-or-later
#include <pkg/mpm/DrainedBoundary.hpp>
#include <pkg/mpm/Check.hpp>

namespace talik {

template <int D> void DrainedBoundary<D>::validate(const Grid<D>& grid) const
{
	requireSetting(
	        this->region_.kind != Region<D>::Kind::nodeBox,
	        "DrainedBoundary.region",
	        this->region_.describe(),
	        "must be a side of the box or the free surface");
	pressure_.validate("DrainedBoundary.pressure");
	Boundary<D>::validate(grid);
}

template <int D> void DrainedBoundary<D>::constrainMotion(const Grid<D>& grid, MotionConstraints<D>& constraints) const
{
	if (this->region_.kind == Region<D>::Kind::side) constraints.releaseLiquid(grid, this->region_);
}

template class DrainedBoundary<2>;
template class DrainedBoundary<3>;

} // namespace talik
