// SPDX-License-Identifier: GPL-2.0-or-later
#pragma once

#include <pkg/base/Errors.hpp>
#include <pkg/mpm/boundary/Boundary.hpp>

#include <cmath>

namespace talik {

/// Joins a side with the opposite one: the ground is repeated behind both, Grid::joinSides().
template <int D> class PeriodicBoundary final : public Boundary<D> {
public:
	explicit PeriodicBoundary(const Region<D>& region)
	        : Boundary<D>(region, "PeriodicBoundary", "")
	{}
	void validate(const Grid<D>& grid) const override
	{
		this->requireRegion(
		        this->onSide() && this->region_.on.axis < D - 1, "must be a side of the box, and not bottom or top: it joins two opposite sides");
		Boundary<D>::validate(grid);
	}
	bool joinsSides() const override { return true; }
};

// ---- mechanical ------------------------------------------------------------------------------------------------------------

/// Impermeable wall that holds grains and water along some axes.
template <int D> class Wall : public Boundary<D> {
public:
	void constrainMotion(const Grid<D>& grid, MotionConstraints<D>& constraints) const override
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

protected:
	Wall(const Region<D>& region, const char* name)
	        : Boundary<D>(region, name, "motion")
	{}
	virtual bool holds(int axis) const = 0;
};

/// Rough: v_s = v_l = 0 on a side or on the nodes of a box.
template <int D> class FixedBoundary final : public Wall<D> {
public:
	explicit FixedBoundary(const Region<D>& region)
	        : Wall<D>(region, "FixedBoundary")
	{}
	void validate(const Grid<D>& grid) const override
	{
		this->requireRegion(this->region_.kind != Region<D>::Kind::freeSurface, "must be a side of the box or a box of nodes");
		Boundary<D>::validate(grid);
	}
	bool holds(int) const override { return true; }
};

/// Frictionless: v_s.n = v_l.n = 0 on a side. The wall is a plane of symmetry: the ghost nodes mirror.
template <int D> class RollerBoundary final : public Wall<D> {
public:
	explicit RollerBoundary(const Region<D>& region)
	        : Wall<D>(region, "RollerBoundary")
	{}
	void validate(const Grid<D>& grid) const override
	{
		this->requireRegion(this->onSide(), "must be a side of the box, which has a normal; use FixedBoundary for other nodes");
		Boundary<D>::validate(grid);
	}
	bool holds(int axis) const override { return axis == this->region_.on.axis; }
};

/// Of prescribed velocity, on a side or on the nodes of a box: v_s = v_l = w, or of a smooth wall the component along w alone. Its
/// nodes stay where they are, so that its path across them is limited, see MomentumSolver::beginStep().
template <int D> class MovingBoundary final : public Wall<D> {
public:
	/// speed [m/s] along direction, of any length; zero direction on a side: into the ground. rough: the ground sticks to it. ahead: how far
	/// in front of its side the wall stands at the start [m].
	MovingBoundary(const Region<D>& region, const TimeTable& speed, const Vec<D>& direction, bool rough, double ahead = 0.0)
	        : Wall<D>(region, "MovingBoundary")
	        , speed_(speed)
	        , direction_(direction)
	        , rough_(rough)
	        , ahead_(ahead)
	{
		const double length = lengthOf<D>(direction);
		if (length == 0.0 && this->onSide()) direction_[region.on.axis] = region.on.upper ? -1.0 : 1.0;
		else if (length > 0.0) direction_ = direction / length;
	}
	void validate(const Grid<D>& grid) const override
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
	bool   moves() const override { return true; }
	Vec<D> velocity(double time) const override { return speed_.at(time) * direction_; }
	Vec<D> pathBefore() const override
	{
		Vec<D> path {};
		if (this->onSide()) path[this->region_.on.axis] = this->region_.on.upper ? -ahead_ : ahead_;
		return path;
	}
	bool holds(int axis) const override { return rough_ || direction_[axis] != 0.0; }

private:
	TimeTable speed_;
	Vec<D>    direction_;
	bool      rough_;
	double    ahead_;
};

/// Load on the free surface, a side or a line of nodes: traction vector plus pressure against the outward normal [Pa].
template <int D> class Traction final : public Boundary<D> {
public:
	/// pressure [Pa] pushes onto the surface; traction [Pa] one table per component, empty for none. On a node box, which has
	/// no normal, only the traction counts and each node carries one cell face (half at the ends of the box).
	explicit Traction(const Region<D>& region, const TimeTable& pressure, const std::vector<TimeTable>& traction = {})
	        : Boundary<D>(region, "Traction", "motion")
	        , pressure_(pressure)
	        , traction_(traction)
	{}
	void validate(const Grid<D>& grid) const override
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
	bool   loads() const override { return true; }
	Vec<D> traction(double time, const Vec<D>& normal) const override
	{
		const double p = pressure_.at(time);
		Vec<D>       t;
		for (int a = 0; a < D; ++a)
			t[a] = -p * normal[a] + (traction_.empty() ? 0.0 : traction_[a].at(time));
		return t;
	}

private:
	TimeTable              pressure_;
	std::vector<TimeTable> traction_;
};

// ---- hydraulic -------------------------------------------------------------------------------------------------------------

/// Water that crosses a side or the free surface; on a side with a roller or a fixed wall the solid stays held and the water passes.
template <int D> class WaterCrossing : public Boundary<D> {
public:
	void validate(const Grid<D>& grid) const override
	{
		this->requireRegion(this->region_.kind != Region<D>::Kind::nodeBox, "must be a side of the box or the free surface");
		table_.validate(what_);
		Boundary<D>::validate(grid);
	}
	void constrainMotion(const Grid<D>& grid, MotionConstraints<D>& constraints) const override
	{
		if (this->onSide()) constraints.releaseLiquid(grid, this->region_);
	}

protected:
	/// what: the attribute that the table is, for messages.
	WaterCrossing(const Region<D>& region, const char* name, const char* what, const TimeTable& table)
	        : Boundary<D>(region, name, "water")
	        , table_(table)
	        , what_(what)
	{}
	TimeTable   table_;
	const char* what_;
};

/// Freely against a prescribed pressure. Where no such boundary is, nothing leaves.
template <int D> class DrainedBoundary final : public WaterCrossing<D> {
public:
	/// pressure outside [Pa]; recharge false: water leaves but none comes in.
	explicit DrainedBoundary(const Region<D>& region, const TimeTable& pressure = 0.0, bool recharge = true)
	        : WaterCrossing<D>(region, "DrainedBoundary", "DrainedBoundary.pressure", pressure)
	        , recharge_(recharge)
	{}
	bool   drains() const override { return true; }
	double pressure(double time) const override { return this->table_.at(time); }
	bool   recharges() const override { return recharge_; }

private:
	bool recharge_;
};

/// Water does not cross: v_l.n = v_s.n on a side whose solid is free to move.
template <int D> class ImpermeableBoundary final : public Boundary<D> {
public:
	explicit ImpermeableBoundary(const Region<D>& region)
	        : Boundary<D>(region, "ImpermeableBoundary", "water")
	{}
	void validate(const Grid<D>& grid) const override
	{
		this->requireRegion(this->onSide(), "must be a side of the box; the free surface is impermeable where no DrainedBoundary is");
		Boundary<D>::validate(grid);
	}
	void constrainMotion(const Grid<D>& grid, MotionConstraints<D>& constraints) const override
	{
		const int axis = this->region_.on.axis, inward = this->inward(grid);
		for (int node : wallNodes(grid, this->region_)) {
			constraints.tieLiquid(node, axis);
			constraints.tieLiquid(node - inward, axis);
		}
	}
};

/// At a prescribed rate (infiltration, a spring, a well), positive into the ground; negative values draw it out. It arrives with the velocity of the
/// water that is there.
template <int D> class WaterFlux final : public WaterCrossing<D> {
public:
	/// flux [m^3 of water per m^2 and s], scaled by the hydraulic time scale like the conductivity; temperature [degC] of water
	/// that enters, NaN (default): that of the ground where it enters.
	explicit WaterFlux(const Region<D>& region, const TimeTable& flux, double temperature = std::numeric_limits<double>::quiet_NaN())
	        : WaterCrossing<D>(region, "WaterFlux", "WaterFlux.flux", flux)
	        , temperature_(temperature)
	{}
	void validate(const Grid<D>& grid) const override
	{
		WaterCrossing<D>::validate(grid);
		requireSetting(
		        std::isnan(temperature_) || (temperature_ >= 0.0 && temperature_ < 100.0), "WaterFlux.temperature", temperature_,
		        "must lie between 0 and 100 degC; leave it out for water as warm as the ground where it enters");
	}
	bool   feeds() const override { return true; }
	double inflow(double time) const override { return this->table_.at(time); }
	double inflowTemperature() const override { return temperature_; }

private:
	double temperature_;
};

// ---- thermal ---------------------------------------------------------------------------------------------------------------

/// Heat that the surface of the ground exchanges with something of given temperature.
template <int D> class HeatExchange : public Boundary<D> {
public:
	bool        heats() const override { return true; }
	SurfaceHeat heat(double time) const override
	{
		SurfaceHeat h;
		h.ambient   = temperature_.at(time);
		h.atSurface = std::isinf(coefficient_);
		if (!h.atSurface) h.coefficient = coefficient_;
		return h;
	}

protected:
	/// coefficient [W/(m^2 K)]; infinite: the surface itself has the temperature. Scaled by the thermal time scale like conduction.
	HeatExchange(const Region<D>& region, const char* name, const TimeTable& temperature, double coefficient)
	        : Boundary<D>(region, name, "heat")
	        , temperature_(temperature)
	        , coefficient_(coefficient)
	{}
	TimeTable temperature_; ///< [degC]
	double    coefficient_;
};

/// Temperature of the moving free surface, or of air that exchanges heat with it.
template <int D> class SurfaceTemperature final : public HeatExchange<D> {
public:
	/// heatTransferCoefficient [W/(m^2 K)]: infinite (default) prescribes the temperature of the surface itself, a finite one that of the air.
	explicit SurfaceTemperature(
	        const Region<D>& region, const TimeTable& temperature, double heatTransferCoefficient = std::numeric_limits<double>::infinity())
	        : HeatExchange<D>(region, "SurfaceTemperature", temperature, heatTransferCoefficient)
	{}
	void validate(const Grid<D>& grid) const override
	{
		this->requireRegion(
		        this->region_.kind != Region<D>::Kind::nodeBox, "must be the free surface or a side of the box; use WallTemperature for nodes");
		this->requireTemperatures(this->temperature_);
		requireSetting(
		        this->coefficient_ >= 0.0, "SurfaceTemperature.heatTransferCoefficient", this->coefficient_,
		        "must not be negative, in W/(m^2 K); leave it out to prescribe the temperature of the surface");
		Boundary<D>::validate(grid);
	}
};

/// Temperature of a side, which lies on nodes and is met exactly, or of a box or disc in the ground (a pipe), by the share of each
/// node that lies in it; of a flat box, the nodes in it.
template <int D> class WallTemperature final : public Boundary<D> {
public:
	/// temperature [degC]
	explicit WallTemperature(const Region<D>& region, const TimeTable& temperature)
	        : Boundary<D>(region, "WallTemperature", "heat")
	        , temperature_(temperature)
	{}
	void validate(const Grid<D>& grid) const override
	{
		this->requireRegion(
		        this->region_.kind != Region<D>::Kind::freeSurface,
		        "must be a side of the box or a box of nodes; use SurfaceTemperature for the free surface");
		this->requireTemperatures(temperature_);
		Boundary<D>::validate(grid);
	}
	bool   prescribesTemperature() const override { return true; }
	double temperature(double time) const override { return temperature_.at(time); }

private:
	TimeTable temperature_;
};

/// Temperature of rigid bodies: heat crosses where ground faces them, and moves along with them.
template <int D> class BodyTemperature final : public HeatExchange<D> {
public:
	/// bodies: numbers of bodies or of their groups; temperature inside; resistance of the body's wall [m^2 K/W], 0: the ground that it
	/// touches has the temperature itself.
	BodyTemperature(const std::vector<int>& bodies, const TimeTable& temperature, double resistance = 0.0)
	        : HeatExchange<D>(Region<D>::facing(bodies), "BodyTemperature", temperature, 1.0 / resistance)
	        , resistance_(resistance)
	{}
	void validate(const Grid<D>& grid) const override
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

private:
	double resistance_;
};

/// Heat flux through the free surface or a side, positive into the ground [W/m^2]; scaled by the thermal time scale.
template <int D> class HeatFlux final : public Boundary<D> {
public:
	explicit HeatFlux(const Region<D>& region, const TimeTable& flux)
	        : Boundary<D>(region, "HeatFlux", "heat")
	        , flux_(flux)
	{}
	void validate(const Grid<D>& grid) const override
	{
		this->requireRegion(
		        this->region_.kind != Region<D>::Kind::nodeBox, "must be the free surface or a side of the box; use HeatSource in the ground");
		flux_.validate("HeatFlux.flux");
		Boundary<D>::validate(grid);
	}
	bool        heats() const override { return true; }
	SurfaceHeat heat(double time) const override
	{
		SurfaceHeat h;
		h.flux = flux_.at(time);
		return h;
	}

private:
	TimeTable flux_;
};

/// Heat produced in the ground inside a box or disc, by the share of each node that lies in it.
template <int D> class HeatSource final : public Boundary<D> {
public:
	/// power [W per m^3 of ground], scaled by the thermal time scale like conduction
	explicit HeatSource(const Region<D>& region, const TimeTable& power)
	        : Boundary<D>(region, "HeatSource", "heat")
	        , power_(power)
	{}
	void validate(const Grid<D>& grid) const override
	{
		this->requireRegion(!nodeShares(grid, this->region_).empty(), "must be a box or disc with room in it that reaches the grid");
		power_.validate("HeatSource.power");
		Boundary<D>::validate(grid);
	}
	bool   producesHeat() const override { return true; }
	double power(double time) const override { return power_.at(time); }

private:
	TimeTable power_;
};

/// No heat crosses. This is what happens where no thermal boundary acts; the object states the intention and is refused
/// where another boundary heats the same side.
template <int D> class InsulatedBoundary final : public Boundary<D> {
public:
	explicit InsulatedBoundary(const Region<D>& region)
	        : Boundary<D>(region, "InsulatedBoundary", "heat")
	{}
};

} // namespace talik
