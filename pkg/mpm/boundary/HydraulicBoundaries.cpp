// SPDX-License-Identifier: GPL-2.0-or-later
#include <pkg/mpm/boundary/HydraulicBoundaries.hpp>
#include <pkg/mpm/Errors.hpp>

#include <cmath>

namespace talik {

template <int D> void DrainedBoundary<D>::validate(const Grid<D>& grid) const
{
	requireSetting(
	        this->region_.kind != Region<D>::Kind::nodeBox, "DrainedBoundary.region", this->region_.describe(),
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

template <int D> void ImpermeableBoundary<D>::validate(const Grid<D>& grid) const
{
	requireSetting(
	        this->region_.kind == Region<D>::Kind::side, "ImpermeableBoundary.region", this->region_.describe(),
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

template <int D> void WaterFlux<D>::validate(const Grid<D>& grid) const
{
	requireSetting(
	        this->region_.kind != Region<D>::Kind::nodeBox, "WaterFlux.region", this->region_.describe(), "must be a side of the box or the free surface");
	flux_.validate("WaterFlux.flux");
	requireSetting(
	        std::isnan(temperature_) || (temperature_ >= 0.0 && temperature_ < 100.0), "WaterFlux.temperature", temperature_,
	        "must lie between 0 and 100 degC; leave it out for water as warm as the ground where it enters");
	Boundary<D>::validate(grid);
}

template <int D> void WaterFlux<D>::constrainMotion(const Grid<D>& grid, MotionConstraints<D>& constraints) const
{
	if (this->region_.kind == Region<D>::Kind::side) constraints.releaseLiquid(grid, this->region_);
}

template class WaterFlux<2>;
template class WaterFlux<3>;

} // namespace talik
