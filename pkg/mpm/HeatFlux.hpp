// SPDX-License-Identifier: GPL-2.0-or-later
#pragma once

#include <pkg/mpm/Boundary.hpp>

namespace talik {

/// Heat flux through the free surface or a side, positive into the ground [W/m^2]; scaled by the thermal time scale.
template <int D> class HeatFlux final : public Boundary<D> {
public:
	explicit HeatFlux(const Region<D>& region, const TimeTable& flux)
	        : Boundary<D>(region)
	        , flux_(flux)
	{
	}
	std::string name() const override { return "HeatFlux"; }
	std::string effect() const override { return "heat"; }
	void        validate(const Grid<D>& grid) const override;
	bool        usesSurface() const override { return true; }
	bool        heats() const override { return true; }
	SurfaceHeat heat(double time) const override;

private:
	TimeTable flux_;
};

} // namespace talik
