// SPDX-License-Identifier: GPL-2.0-or-later
#include <pkg/mpm/HeatFlux.hpp>
#include <pkg/mpm/Check.hpp>

namespace talik {

template <int D> void HeatFlux<D>::validate(const Grid<D>& grid) const
{
	requireSetting(
	        this->region_.kind != Region<D>::Kind::nodeBox,
	        "HeatFlux.region",
	        this->region_.describe(),
	        "must be the free surface or a side of the box");
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

} // namespace talik
