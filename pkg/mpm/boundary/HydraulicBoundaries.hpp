// SPDX-License-Identifier: GPL-2.0-or-later
#pragma once

#include <pkg/mpm/boundary/Boundary.hpp>

namespace talik {

/// Water crosses a side or the free surface freely against a prescribed pressure. Where no such boundary is, nothing leaves.
/// On a side with a roller or a fixed wall the solid stays held and the water passes.
template <int D> class DrainedBoundary final : public Boundary<D> {
public:
	/// pressure outside [Pa]; recharge false: water leaves but none comes in.
	explicit DrainedBoundary(const Region<D>& region, const TimeTable& pressure = 0.0, bool recharge = true)
	        : Boundary<D>(region)
	        , pressure_(pressure)
	        , recharge_(recharge)
	{}
	std::string name() const override { return "DrainedBoundary"; }
	std::string effect() const override { return "water"; }
	void        validate(const Grid<D>& grid) const override;
	void        constrainMotion(const Grid<D>&, MotionConstraints<D>&) const override;
	bool        usesSurface() const override { return true; }
	bool        drains() const override { return true; }
	double      pressure(double time) const override { return pressure_.at(time); }
	bool        recharges() const override { return recharge_; }

private:
	TimeTable pressure_;
	bool      recharge_;
};

/// Water does not cross: v_l.n = v_s.n on a side whose solid is free to move.
template <int D> class ImpermeableBoundary final : public Boundary<D> {
public:
	explicit ImpermeableBoundary(const Region<D>& region)
	        : Boundary<D>(region)
	{}
	std::string name() const override { return "ImpermeableBoundary"; }
	std::string effect() const override { return "water"; }
	void        validate(const Grid<D>& grid) const override;
	void        constrainMotion(const Grid<D>&, MotionConstraints<D>&) const override;
};

/// Water that is fed through a side or the free surface at a prescribed rate (infiltration, a spring, a well), positive into the
/// ground; negative values draw it out. On a side with a roller or a fixed wall the solid stays held and the water passes. It
/// arrives with the velocity of the water that is there.
template <int D> class WaterFlux final : public Boundary<D> {
public:
	/// flux [m^3 of water per m^2 and s], scaled by the hydraulic time scale like the conductivity; temperature [degC] of water
	/// that enters, NaN (default): that of the ground where it enters.
	explicit WaterFlux(const Region<D>& region, const TimeTable& flux, double temperature = std::numeric_limits<double>::quiet_NaN())
	        : Boundary<D>(region)
	        , flux_(flux)
	        , temperature_(temperature)
	{}
	std::string name() const override { return "WaterFlux"; }
	std::string effect() const override { return "water"; }
	void        validate(const Grid<D>& grid) const override;
	void        constrainMotion(const Grid<D>&, MotionConstraints<D>&) const override;
	bool        usesSurface() const override { return true; }
	bool        feeds() const override { return true; }
	double      inflow(double time) const override { return flux_.at(time); }
	double      inflowTemperature() const override { return temperature_; }

private:
	TimeTable flux_;
	double    temperature_;
};

} // namespace talik
