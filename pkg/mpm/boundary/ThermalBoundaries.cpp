// SPDX-License-Identifier: GPL-2.0-or-later
#include <pkg/mpm/boundary/ThermalBoundaries.hpp>
#include <pkg/mpm/Errors.hpp>

#include <cmath>

namespace talik {

template <int D> void SurfaceTemperature<D>::validate(const Grid<D>& grid) const
{
	requireSetting(
	        this->region_.kind != Region<D>::Kind::nodeBox, "SurfaceTemperature.region", this->region_.describe(),
	        "must be the free surface or a side of the box; use WallTemperature for nodes");
	temperature_.validate("SurfaceTemperature.temperature");
	for (double t : temperature_.values())
		requireSetting(t > -100.0 && t < 100.0, "SurfaceTemperature.temperature", t, "must lie between -100 and 100 degC");
	requireSetting(
	        heatTransferCoefficient_ >= 0.0, "SurfaceTemperature.heatTransferCoefficient", heatTransferCoefficient_,
	        "must not be negative, in W/(m^2 K); leave it out to prescribe the temperature of the surface");
	Boundary<D>::validate(grid);
}

template <int D> SurfaceHeat SurfaceTemperature<D>::heat(double time) const
{
	SurfaceHeat h;
	h.ambient   = temperature_.at(time);
	h.atSurface = std::isinf(heatTransferCoefficient_);
	if (!h.atSurface) h.coefficient = heatTransferCoefficient_;
	return h;
}

template class SurfaceTemperature<2>;
template class SurfaceTemperature<3>;

template <int D> void WallTemperature<D>::validate(const Grid<D>& grid) const
{
	requireSetting(
	        this->region_.kind != Region<D>::Kind::freeSurface, "WallTemperature.region", this->region_.describe(),
	        "must be a side of the box or a box of nodes; use SurfaceTemperature for the free surface");
	temperature_.validate("WallTemperature.temperature");
	for (double t : temperature_.values())
		requireSetting(t > -100.0 && t < 100.0, "WallTemperature.temperature", t, "must lie between -100 and 100 degC");
	Boundary<D>::validate(grid);
}

template class WallTemperature<2>;
template class WallTemperature<3>;

template <int D> void BodyTemperature<D>::validate(const Grid<D>& grid) const
{
	const std::vector<int>& ids = this->region_.ids;
	if (ids.empty()) throw std::invalid_argument("BodyTemperature.bodies = []: names no body; give the numbers of bodies, e.g. [0]");
	for (int id : ids)
		requireSetting(id >= 0, "BodyTemperature.bodies", id, "must be numbers of bodies, 0 or more");
	temperature_.validate("BodyTemperature.temperature");
	for (double t : temperature_.values())
		requireSetting(t > -100.0 && t < 100.0, "BodyTemperature.temperature", t, "must lie between -100 and 100 degC");
	requireSetting(
	        std::isfinite(resistance_) && resistance_ >= 0.0, "BodyTemperature.resistance", resistance_,
	        "must not be negative, in m^2 K/W; 0: none; a body that no heat enters needs no BodyTemperature");
	Boundary<D>::validate(grid);
}

template <int D> SurfaceHeat BodyTemperature<D>::heat(double time) const
{
	SurfaceHeat h;
	h.ambient   = temperature_.at(time);
	h.atSurface = resistance_ == 0.0;
	if (!h.atSurface) h.coefficient = 1.0 / resistance_;
	return h;
}

template class BodyTemperature<2>;
template class BodyTemperature<3>;

template <int D> void HeatFlux<D>::validate(const Grid<D>& grid) const
{
	requireSetting(
	        this->region_.kind != Region<D>::Kind::nodeBox, "HeatFlux.region", this->region_.describe(), "must be the free surface or a side of the box");
	flux_.validate("HeatFlux.flux");
	Boundary<D>::validate(grid);
}

template <int D> SurfaceHeat HeatFlux<D>::heat(double time) const
{
	SurfaceHeat h;
	h.flux = flux_.at(time);
	return h;
}

template class HeatFlux<2>;
template class HeatFlux<3>;

template class InsulatedBoundary<2>;
template class InsulatedBoundary<3>;

} // namespace talik
