// SPDX-License-Identifier: GPL-2.0-or-later
#pragma once

#include <pkg/mpm/Boundary.hpp>

namespace talik {

/// Temperature of a side, which lies on nodes and is met exactly, or of a box or disc in the ground (a pipe), by the share of each
/// node that lies in it; of a flat box, the nodes in it.
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
	bool        takesVolumes() const override { return true; }
	bool        prescribesTemperature() const override { return true; }
	double      temperature(double time) const override { return temperature_.at(time); }

private:
	TimeTable temperature_;
};

} // namespace talik
