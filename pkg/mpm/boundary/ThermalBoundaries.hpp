// SPDX-License-Identifier: GPL-2.0-or-later
#pragma once

#include <pkg/mpm/boundary/Boundary.hpp>

namespace talik {

/// Temperature of the moving free surface, or of air that exchanges heat with it.
template <int D> class SurfaceTemperature final : public Boundary<D> {
public:
	/// temperature [degC]; heatTransferCoefficient [W/(m^2 K)]: infinite (default) prescribes the temperature of the surface
	/// itself, a finite one that of the air. Scaled by the thermal time scale like conduction.
	explicit SurfaceTemperature(
	        const Region<D>& region, const TimeTable& temperature, double heatTransferCoefficient = std::numeric_limits<double>::infinity())
	        : Boundary<D>(region)
	        , temperature_(temperature)
	        , heatTransferCoefficient_(heatTransferCoefficient)
	{}
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

/// Temperature of a side, which lies on nodes and is met exactly, or of a box or disc in the ground (a pipe), by the share of each
/// node that lies in it; of a flat box, the nodes in it.
template <int D> class WallTemperature final : public Boundary<D> {
public:
	/// temperature [degC]
	explicit WallTemperature(const Region<D>& region, const TimeTable& temperature)
	        : Boundary<D>(region)
	        , temperature_(temperature)
	{}
	std::string name() const override { return "WallTemperature"; }
	std::string effect() const override { return "heat"; }
	void        validate(const Grid<D>& grid) const override;
	bool        takesVolumes() const override { return true; }
	bool        prescribesTemperature() const override { return true; }
	double      temperature(double time) const override { return temperature_.at(time); }

private:
	TimeTable temperature_;
};

/// Temperature of rigid bodies: heat crosses where ground faces them, and moves along with them.
template <int D> class BodyTemperature final : public Boundary<D> {
public:
	/// bodies: numbers of bodies or of their groups; temperature [degC] inside; resistance of the body's wall, 1/U [m^2 K/W], 0: the
	/// ground that it touches has the temperature itself. The resistance is divided by the thermal time scale.
	BodyTemperature(const std::vector<int>& bodies, const TimeTable& temperature, double resistance = 0.0)
	        : Boundary<D>(Region<D>::facing(bodies))
	        , temperature_(temperature)
	        , resistance_(resistance)
	{}
	std::string name() const override { return "BodyTemperature"; }
	std::string effect() const override { return "heat"; }
	void        validate(const Grid<D>& grid) const override;
	bool        usesSurface() const override { return true; }
	bool        heats() const override { return true; }
	SurfaceHeat heat(double time) const override;

private:
	TimeTable temperature_;
	double    resistance_;
};

/// Heat flux through the free surface or a side, positive into the ground [W/m^2]; scaled by the thermal time scale.
template <int D> class HeatFlux final : public Boundary<D> {
public:
	explicit HeatFlux(const Region<D>& region, const TimeTable& flux)
	        : Boundary<D>(region)
	        , flux_(flux)
	{}
	std::string name() const override { return "HeatFlux"; }
	std::string effect() const override { return "heat"; }
	void        validate(const Grid<D>& grid) const override;
	bool        usesSurface() const override { return true; }
	bool        heats() const override { return true; }
	SurfaceHeat heat(double time) const override;

private:
	TimeTable flux_;
};

/// No heat crosses. This is what happens where no thermal boundary acts; the object states the intention and is refused
/// where another boundary heats the same side.
template <int D> class InsulatedBoundary final : public Boundary<D> {
public:
	explicit InsulatedBoundary(const Region<D>& region)
	        : Boundary<D>(region)
	{}
	std::string name() const override { return "InsulatedBoundary"; }
	std::string effect() const override { return "heat"; }
};

} // namespace talik
