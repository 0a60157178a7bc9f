// SPDX-License-Identifier: GPL-2.0-or-later
#include <pkg/base/Errors.hpp>
#include <pkg/mpm/boundary/Boundaries.hpp>

#include <cmath>

namespace talik {

template <int D> void PeriodicBoundary<D>::validate(const Grid<D>& grid) const
{
	this->requireRegion(this->onSide() && this->region_.on.axis < D - 1, "must be a side of the box, and not bottom or top: it joins two opposite sides");
	Boundary<D>::validate(grid);
}

// ---- mechanical ------------------------------------------------------------------------------------------------------------

template <int D> void Wall<D>::constrainMotion(const Grid<D>& grid, MotionConstraints<D>& constraints) const
{
	const int inward = this->inward(grid);
	Vec<D>    sign;
	for (int a = 0; a < D; ++a)
		sign[a] = holds(a) ? -1.0 : 1.0;
	for (int node : wallNodes(grid, this->region_)) {
		for (int a = 0; a < D; ++a) {
			if (!holds(a)) continue;
			constraints.fixSolid(node, a);
			constraints.tieLiquid(node, a);
		}
		if (this->onSide()) constraints.mirror(node - inward, node + inward, sign);
	}
}

template <int D> void FixedBoundary<D>::validate(const Grid<D>& grid) const
{
	this->requireRegion(this->region_.kind != Region<D>::Kind::freeSurface, "must be a side of the box or a box of nodes");
	Boundary<D>::validate(grid);
}

template <int D> void RollerBoundary<D>::validate(const Grid<D>& grid) const
{
	this->requireRegion(this->onSide(), "must be a side of the box, which has a normal; use FixedBoundary for other nodes");
	Boundary<D>::validate(grid);
}

template <int D>
MovingBoundary<D>::MovingBoundary(const Region<D>& region, const TimeTable& speed, const Vec<D>& direction, bool rough, double ahead)
        : Wall<D>(region, "MovingBoundary")
        , speed_(speed)
        , direction_(direction)
        , rough_(rough)
        , ahead_(ahead)
{
	const double length = lengthOf<D>(direction);
	if (length == 0.0 && this->onSide()) direction_[region.on.axis] = region.on.upper ? -1.0 : 1.0;
	else if (length > 0.0)
		for (double& component : direction_)
			component /= length;
}

template <int D> void MovingBoundary<D>::validate(const Grid<D>& grid) const
{
	this->requireRegion(this->region_.kind != Region<D>::Kind::freeSurface, "must be a side of the box or a box of nodes");
	speed_.validate("MovingBoundary.speed");
	const double length = lengthOf<D>(direction_);
	requireSetting(
	        std::isfinite(length) && length > 0.5, "MovingBoundary.direction", length,
	        "must be finite and, on a box of nodes, which has no normal, not zero; its length does not matter");
	int components = 0;
	for (const double component : direction_)
		components += component != 0.0;
	const bool alongNormal = components == 1 && (!this->onSide() || direction_[this->region_.on.axis] != 0.0);
	requireSetting(
	        rough_ || alongNormal, "MovingBoundary.rough", "False",
	        this->onSide() ? "needs a direction along the normal of the side: a smooth wall that moves along itself moves nothing"
	                       : "needs a direction along one axis");
	requireSetting(
	        ahead_ >= 0.0 && ahead_ <= 0.5 * grid.spacing() && (ahead_ == 0.0 || this->onSide()), "MovingBoundary.ahead", ahead_,
	        "must lie between 0 and half of gridSpacing, on a side of the box; 0 in a box of nodes");
	Boundary<D>::validate(grid);
}

template <int D> Vec<D> MovingBoundary<D>::pathBefore() const
{
	Vec<D> path {};
	if (this->onSide()) path[this->region_.on.axis] = this->region_.on.upper ? -ahead_ : ahead_;
	return path;
}

template <int D> Vec<D> MovingBoundary<D>::velocity(double time) const
{
	const double speed = speed_.at(time);
	Vec<D>       v;
	for (int a = 0; a < D; ++a)
		v[a] = speed * direction_[a];
	return v;
}

template <int D> void Traction<D>::validate(const Grid<D>& grid) const
{
	pressure_.validate("SurfaceLoad.pressure");
	requireSetting(
	        traction_.empty() || traction_.size() == D, "SurfaceLoad.traction", std::to_string(traction_.size()) + " components",
	        "must have one component per dimension, or none");
	for (const TimeTable& t : traction_)
		t.validate("SurfaceLoad.traction");
	requireSetting(
	        this->region_.kind != Region<D>::Kind::nodeBox || pressure_.isZero(), "SurfaceLoad.pressure", pressure_.values().front(),
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

// ---- hydraulic -------------------------------------------------------------------------------------------------------------

template <int D> void WaterCrossing<D>::validate(const Grid<D>& grid) const
{
	this->requireRegion(this->region_.kind != Region<D>::Kind::nodeBox, "must be a side of the box or the free surface");
	table_.validate(what_);
	Boundary<D>::validate(grid);
}

template <int D> void WaterCrossing<D>::constrainMotion(const Grid<D>& grid, MotionConstraints<D>& constraints) const
{
	if (this->onSide()) constraints.releaseLiquid(grid, this->region_);
}

template <int D> void ImpermeableBoundary<D>::validate(const Grid<D>& grid) const
{
	this->requireRegion(this->onSide(), "must be a side of the box; the free surface is impermeable where no DrainedBoundary is");
	Boundary<D>::validate(grid);
}

template <int D> void ImpermeableBoundary<D>::constrainMotion(const Grid<D>& grid, MotionConstraints<D>& constraints) const
{
	const int axis = this->region_.on.axis, inward = this->inward(grid);
	for (int node : wallNodes(grid, this->region_)) {
		constraints.tieLiquid(node, axis);
		constraints.tieLiquid(node - inward, axis);
	}
}

template <int D> void WaterFlux<D>::validate(const Grid<D>& grid) const
{
	WaterCrossing<D>::validate(grid);
	requireSetting(
	        std::isnan(temperature_) || (temperature_ >= 0.0 && temperature_ < 100.0), "WaterFlux.temperature", temperature_,
	        "must lie between 0 and 100 degC; leave it out for water as warm as the ground where it enters");
}

// ---- thermal ---------------------------------------------------------------------------------------------------------------

template <int D> SurfaceHeat HeatExchange<D>::heat(double time) const
{
	SurfaceHeat h;
	h.ambient   = temperature_.at(time);
	h.atSurface = std::isinf(coefficient_);
	if (!h.atSurface) h.coefficient = coefficient_;
	return h;
}

template <int D> void SurfaceTemperature<D>::validate(const Grid<D>& grid) const
{
	this->requireRegion(this->region_.kind != Region<D>::Kind::nodeBox, "must be the free surface or a side of the box; use WallTemperature for nodes");
	this->requireTemperatures(this->temperature_);
	requireSetting(
	        this->coefficient_ >= 0.0, "SurfaceTemperature.heatTransferCoefficient", this->coefficient_,
	        "must not be negative, in W/(m^2 K); leave it out to prescribe the temperature of the surface");
	Boundary<D>::validate(grid);
}

template <int D> void WallTemperature<D>::validate(const Grid<D>& grid) const
{
	this->requireRegion(
	        this->region_.kind != Region<D>::Kind::freeSurface, "must be a side of the box or a box of nodes; use SurfaceTemperature for the free surface");
	this->requireTemperatures(temperature_);
	Boundary<D>::validate(grid);
}

template <int D> void BodyTemperature<D>::validate(const Grid<D>& grid) const
{
	const std::vector<int>& ids = this->region_.ids;
	if (ids.empty()) throw std::invalid_argument("BodyTemperature.bodies = []: names no body; give the numbers of bodies, e.g. [0]");
	for (int id : ids)
		requireSetting(id >= 0, "BodyTemperature.bodies", id, "must be numbers of bodies, 0 or more");
	this->requireTemperatures(this->temperature_);
	requireSetting(
	        std::isfinite(resistance_) && resistance_ >= 0.0, "BodyTemperature.resistance", resistance_,
	        "must not be negative, in m^2 K/W; 0: none; a body that no heat enters needs no BodyTemperature");
	Boundary<D>::validate(grid);
}

template <int D> void HeatFlux<D>::validate(const Grid<D>& grid) const
{
	this->requireRegion(this->region_.kind != Region<D>::Kind::nodeBox, "must be the free surface or a side of the box; use HeatSource in the ground");
	flux_.validate("HeatFlux.flux");
	Boundary<D>::validate(grid);
}

template <int D> SurfaceHeat HeatFlux<D>::heat(double time) const
{
	SurfaceHeat h;
	h.flux = flux_.at(time);
	return h;
}

template <int D> void HeatSource<D>::validate(const Grid<D>& grid) const
{
	this->requireRegion(!nodeShares(grid, this->region_).empty(), "must be a box or disc with room in it that reaches the grid");
	power_.validate("HeatSource.power");
	Boundary<D>::validate(grid);
}

TALIK_IN_PLANE_AND_SPACE(PeriodicBoundary);
TALIK_IN_PLANE_AND_SPACE(FixedBoundary);
TALIK_IN_PLANE_AND_SPACE(RollerBoundary);
TALIK_IN_PLANE_AND_SPACE(MovingBoundary);
TALIK_IN_PLANE_AND_SPACE(Traction);
TALIK_IN_PLANE_AND_SPACE(DrainedBoundary);
TALIK_IN_PLANE_AND_SPACE(ImpermeableBoundary);
TALIK_IN_PLANE_AND_SPACE(WaterFlux);
TALIK_IN_PLANE_AND_SPACE(SurfaceTemperature);
TALIK_IN_PLANE_AND_SPACE(WallTemperature);
TALIK_IN_PLANE_AND_SPACE(BodyTemperature);
TALIK_IN_PLANE_AND_SPACE(HeatFlux);
TALIK_IN_PLANE_AND_SPACE(HeatSource);
TALIK_IN_PLANE_AND_SPACE(InsulatedBoundary);

} // namespace talik
