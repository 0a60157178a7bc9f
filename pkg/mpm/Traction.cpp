// SPDX-License-Identifier: GPL-2.0-or-later
#include <pkg/mpm/Traction.hpp>
#include <pkg/mpm/Check.hpp>

namespace talik {

template <int D> void Traction<D>::validate(const Grid<D>& grid) const
{
	pressure_.validate("Traction.pressure");
	requireSetting(
	        traction_.empty() || traction_.size() == D,
	        "Traction.traction",
	        std::to_string(traction_.size()) + " components",
	        "must have one component per dimension, or none");
	for (const TimeTable& t : traction_)
		t.validate("Traction.traction");
	requireSetting(
	        this->region_.kind != Region<D>::Kind::nodeBox || pressure_.isZero(),
	        "Traction.pressure",
	        pressure_.values().front(),
	        "must be zero on a box of nodes, which has no normal; give the traction vector");
	Boundary<D>::validate(grid);
}

template <int D> Vec<D> Traction<D>::traction(double time, const Vec<D>& normal) const
{
	const double p = pressure_.at(time);
	Vec<D>       t;
	for (int a = 0; a < D; ++a)
		t[a] = -p * normal[a] + (traction_.empty() ? 0.0 : traction_[a].at(time));
	return t;
}

template class Traction<2>;
template class Traction<3>;

} // namespace talik
