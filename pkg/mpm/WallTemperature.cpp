// SPDX-License-Identifier: GPL-2.0-or-later
#include <pkg/mpm/WallTemperature.hpp>
#include <pkg/mpm/Check.hpp>

namespace talik {

template <int D> void WallTemperature<D>::validate(const Grid<D>& grid) const
{
	requireSetting(
	        this->region_.kind != Region<D>::Kind::freeSurface,
	        "WallTemperature.region",
	        this->region_.describe(),
	        "must be a side of the box or a box of nodes; use SurfaceTemperature for the free surface");
	temperature_.validate("WallTemperature.temperature");
	for (double t : temperature_.values())
		requireSetting(t > -100.0 && t < 100.0, "WallTemperature.temperature", t, "must lie between -100 and 100 degC");
	Boundary<D>::validate(grid);
}

template class WallTemperature<2>;
template class WallTemperature<3>;

} // namespace talik
