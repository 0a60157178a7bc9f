// SPDX-License-Identifier: GPL-2.0-or-later
#include <core/Scene.hpp>
#include <pkg/mpm/Errors.hpp>
#include <pkg/multiscale/GroundBoundaries.hpp>

namespace yade {
// clang-format off
YADE_PLUGIN((GroundBoundary)(RollerBoundary)(FixedBoundary)(ImpermeableBoundary)(DrainedBoundary)(InsulatedBoundary)(WallTemperature)
        (SurfaceTemperature)(BodyTemperature)(HeatFlux)(WaterFlux)(SurfaceLoad));
// clang-format on

talik::Region<2> GroundBoundary::where() const
{
	using Region = talik::Region<2>;
	const talik::Vec<2> from { lower[0], lower[1] }, to { upper[0], upper[1] };
	if (region == "surface") return Region::freeSurface().within(from, to);
	if (region == "cavities") return Region::cavitySurface().within(from, to);
	if (region == "box") return Region::nodeBox(from, to);
	if (region == "disc") return Region::disc(from, to);
	if (region == "left" || region == "right" || region == "bottom" || region == "top") return Region::side(region).within(from, to);
	throw std::invalid_argument(getClassName() + ".region is '" + region + "': choose left, right, bottom, top, surface, cavities, box or disc.");
}

talik::Region<2> GroundBoundary::always() const
{
	if (!times.empty() || !values.empty())
		throw std::invalid_argument(
		        getClassName() + ".times has " + std::to_string(times.size()) + " numbers, .values " + std::to_string(values.size())
		        + ": nothing of this boundary changes in time; leave them out.");
	return where();
}

talik::TimeTable GroundBoundary::overTime(Real constant) const
{
	if (times.empty() && values.empty()) return talik::TimeTable(constant);
	talik::TimeTable table(times, values);
	table.validate(getClassName() + ".times/values");
	return table;
}

GroundBoundary::Pointer GroundBoundary::build() const
{
	throw std::invalid_argument("GroundBoundary is only a base class: use RollerBoundary, FixedBoundary, SurfaceTemperature, …");
}
GroundBoundary::Pointer RollerBoundary::build() const { return std::make_shared<talik::RollerBoundary<2>>(always()); }
GroundBoundary::Pointer FixedBoundary::build() const { return std::make_shared<talik::FixedBoundary<2>>(always()); }
GroundBoundary::Pointer ImpermeableBoundary::build() const { return std::make_shared<talik::ImpermeableBoundary<2>>(always()); }
GroundBoundary::Pointer DrainedBoundary::build() const { return std::make_shared<talik::DrainedBoundary<2>>(where(), overTime(pressure), recharge); }
GroundBoundary::Pointer InsulatedBoundary::build() const { return std::make_shared<talik::InsulatedBoundary<2>>(always()); }
GroundBoundary::Pointer WallTemperature::build() const { return std::make_shared<talik::WallTemperature<2>>(where(), overTime(temperature)); }
GroundBoundary::Pointer SurfaceTemperature::build() const
{
	talik::requireSetting(
	        heatTransferCoefficient > 0, "SurfaceTemperature.heatTransferCoefficient", heatTransferCoefficient,
	        "must be positive, in W/(m^2 K); without exchange leave the boundary out");
	return std::make_shared<talik::SurfaceTemperature<2>>(where(), overTime(temperature), heatTransferCoefficient);
}
GroundBoundary::Pointer BodyTemperature::build() const
{
	const GroundBoundary anywhere;
	if (!region.empty() || lower != anywhere.lower || upper != anywhere.upper)
		throw std::invalid_argument(
		        "BodyTemperature.region is '" + region + "', with lower and upper: it acts where its bodies are; leave region, lower and upper out.");
	return std::make_shared<talik::BodyTemperature<2>>(bodies, overTime(temperature), resistance);
}
void BodyTemperature::checkBodies(const vector<talik::RigidBody<2>>& met) const
{
	for (const int id : bodies)
		if (std::none_of(met.begin(), met.end(), [&](const auto& body) { return body.id == id || body.group == id; }))
			throw std::invalid_argument(
			        "BodyTemperature.bodies names " + std::to_string(id)
			        + ", which is no body that the ground meets: give numbers of O.bodies that BodyContact.mask does not leave out.");
}
GroundBoundary::Pointer HeatFlux::build() const { return std::make_shared<talik::HeatFlux<2>>(where(), overTime(flux)); }
GroundBoundary::Pointer WaterFlux::build() const { return std::make_shared<talik::WaterFlux<2>>(where(), overTime(flux), temperature); }
GroundBoundary::Pointer SurfaceLoad::build() const
{
	std::vector<talik::TimeTable> constant;
	if (!traction.isZero()) constant = { talik::TimeTable(traction[0]), talik::TimeTable(traction[1]) };
	return std::make_shared<talik::Traction<2>>(where(), overTime(pressure), constant);
}

} // namespace yade
