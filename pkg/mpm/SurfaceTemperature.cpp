// SPDX-License-Identifier: GPL-2.0-or-later
#include <pkg/mpm/SurfaceTemperature.hpp>
#include <pkg/mpm/Check.hpp>

namespace talik {

template <int D> void SurfaceTemperature<D>::validate(const Grid<D>& grid) const
{
	requireSetting(
	        this->region_.kind != Region<D>::Kind::nodeBox,
	        "SurfaceTemperature.region",
	        this->region_.describe(),
	        "must be the free surface or a side of the box; use WallTemperature for nodes");
	temperature_.validate("SurfaceTemperature.temperature");
	for (double t : temperature_.values())
		requireSetting(t > -100.0 && t < 100.0, "SurfaceTemperature.temperature", t, "must lie between -100 and 100 degC");
	requireSetting(
	        heatTransferCoefficient_ >= 0.0,
	        "SurfaceTemperature.heatTransferCoefficient",
	        heatTransferCoefficient_,
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

} // namespace talik
