// SPDX-License-Identifier: GPL-2.0-or-later
#pragma once

#include <pkg/mpm/Boundary.hpp>

namespace talik {

/// Temperature of the moving free surface, or of air that exchanges heat with it.
template <int D> class SurfaceTemperature final : public Boundary<D> {
public:
	/// temperature [degC]; heatTransferCoefficient [W/(m^2 K)]: infinite (default) prescribes the temperature of the surface
	/// itself, a finite one that of the air. Scaled by the thermal time scale like conduction.
	explicit SurfaceTemperature(
	        const Region<D>& region,
	        const TimeTable& temperature,
	        double           heatTransferCoefficient = std::numeric_limits<double>::infinity())
	        : Boundary<D>(region)
	        , temperature_(temperature)
	        , heatTransferCoefficient_(heatTransferCoefficient)
	{
	}
	std::string name() const override { return "SurfaceTemperature"; }
	std::string effect() const override { return "heat"; }
	void        validate(const Grid<D>& grid) const override;
	bool        usesSurface() const override { return true; }
	bool        heats() const override { return true; }
	SurfaceHeat heat(double time) const override;

private:
	TimeTable temperature_;
	double    heatTransferCoefficient_;
};

} // namespace talik
