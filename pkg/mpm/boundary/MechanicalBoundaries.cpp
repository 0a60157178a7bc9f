// SPDX-License-Identifier: GPL-2.0-or-later
#include <pkg/mpm/boundary/MechanicalBoundaries.hpp>
#include <pkg/mpm/Errors.hpp>

namespace talik {

template <int D> void FixedBoundary<D>::validate(const Grid<D>& grid) const
{
	requireSetting(
	        this->region_.kind != Region<D>::Kind::freeSurface, "FixedBoundary.region", this->region_.describe(),
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

template <int D> void RollerBoundary<D>::validate(const Grid<D>& grid) const
{
	requireSetting(
	        this->region_.kind == Region<D>::Kind::side, "RollerBoundary.region", this->region_.describe(),
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

template <int D> void Traction<D>::validate(const Grid<D>& grid) const
{
	pressure_.validate("Traction.pressure");
	requireSetting(
	        traction_.empty() || traction_.size() == D, "Traction.traction", std::to_string(traction_.size()) + " components",
	        "must have one component per dimension, or none");
	for (const TimeTable& t : traction_)
		t.validate("Traction.traction");
	requireSetting(
	        this->region_.kind != Region<D>::Kind::nodeBox || pressure_.isZero(), "Traction.pressure", pressure_.values().front(),
	        "must be zero on a box of nodes, which has no normal; give the traction vector");
	Boundary<D>::validate(grid);
}

template <int D> Vec<D> Traction<D>::traction(double time, const Vec<D>& normal) const
{
	const double p = pressure_.at(time);
	Vec<D>       t;
	for (int a = 0; a < D; ++a)
		t[a] = -p * normal[a] + (traction_.empty() ? 0.0 : traction_[a].at(time));
	return t;
}

template class Traction<2>;
template class Traction<3>;

} // namespace talik
