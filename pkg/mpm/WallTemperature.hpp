// SPDX-License-Identifier: GPL-2.0-or-later
#pragma once

#include <pkg/mpm/Boundary.hpp>

namespace talik {

/// Temperature of the nodes of a side or of a box (wall, heated base): exact treatment for surfaces that lie on nodes.
template <int D> class WallTemperature final : public Boundary<D> {
public:
	/// temperature [degC]
	explicit WallTemperature(const Region<D>& region, const TimeTable& temperature)
	        : Boundary<D>(region)
	        , temperature_(temperature)
	{
	}
	std::string name() const override { return "WallTemperature"; }
	std::string effect() const override { return "heat"; }
	void        validate(const Grid<D>& grid) const override;
	bool        prescribesTemperature() const override { return true; }
	double      temperature(double time) const override { return temperature_.at(time); }

private:
	TimeTable temperature_;
};

} // namespace talik
