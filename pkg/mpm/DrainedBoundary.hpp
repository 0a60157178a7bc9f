// SPDX-License-Identifier: GPL-2.0-or-later
#pragma once

#include <pkg/mpm/Boundary.hpp>

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
	{
	}
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

} // namespace talik
