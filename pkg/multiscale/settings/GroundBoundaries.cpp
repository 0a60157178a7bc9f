// SPDX-License-Identifier: GPL-2.0-or-later
#include <core/Scene.hpp>
#include <pkg/base/Errors.hpp>
#include <pkg/multiscale/settings/GroundBoundaries.hpp>

namespace yade {
template <int D> talik::Region<D> GroundBoundary::where() const
{
	using Region             = talik::Region<D>;
	const talik::Vec<D> from = lower.in<D>(getClassName() + ".lower"), to = upper.in<D>(getClassName() + ".upper");
	const auto          sides = talik::sideNames(D);
	if (region == "surface") return Region::freeSurface().within(from, to);
	if (region == "cavities") return Region::cavitySurface().within(from, to);
	if (region == "box") return Region::nodeBox(from, to);
	if (region == (D == 2 ? "disc" : "ball")) return Region::disc(from, to);
	if (std::count(sides.begin(), sides.end(), region)) return Region::side(region).within(from, to);
	string known;
	for (const string& side : sides)
		known += side + ", ";
	throw std::invalid_argument(
	        getClassName() + ".region is '" + region + "': choose " + known + "surface, cavities, box or " + (D == 2 ? "disc." : "ball."));
}

template <int D> talik::Region<D> GroundBoundary::always() const
{
	if (!times.empty() || !days.empty() || !values.empty())
		throw std::invalid_argument(
		        getClassName() + ".times has " + std::to_string(times.size()) + " numbers, .days " + std::to_string(days.size()) + ", .values "
		        + std::to_string(values.size()) + ": nothing of this boundary changes in time; leave them out.");
	return where<D>();
}

talik::TimeTable GroundBoundary::overTime(Real constant) const
{
	if (times.empty() && days.empty() && values.empty()) return talik::TimeTable(constant);
	if (!times.empty() && !days.empty())
		throw std::invalid_argument(
		        getClassName() + ".times has " + std::to_string(times.size()) + " numbers, .days " + std::to_string(days.size())
		        + ": give one of the two, in seconds or in days of the calendar.");
	vector<Real> instants = times;
	for (const Real day : days)
		instants.push_back(day * secondsPerDay);
	talik::TimeTable table(instants, values);
	table.validate(getClassName() + (days.empty() ? ".times/values" : ".days/values"));
	return table;
}

namespace {
	[[noreturn]] void refuseBase()
	{
		throw std::invalid_argument("GroundBoundary is only a base class: use RollerBoundary, FixedBoundary, SurfaceTemperature, …");
	}
} // namespace
GroundBoundary::Pointer<2> GroundBoundary::inPlane() const { refuseBase(); }
GroundBoundary::Pointer<3> GroundBoundary::inSpace() const { refuseBase(); }

template <int D> GroundBoundary::Pointer<D> RollerBoundary::make() const { return std::make_shared<talik::RollerBoundary<D>>(always<D>()); }
template <int D> GroundBoundary::Pointer<D> PeriodicBoundary::make() const { return std::make_shared<talik::PeriodicBoundary<D>>(always<D>()); }
template <int D> GroundBoundary::Pointer<D> FixedBoundary::make() const { return std::make_shared<talik::FixedBoundary<D>>(always<D>()); }
template <int D> GroundBoundary::Pointer<D> MovingBoundary::make() const
{
	return std::make_shared<talik::MovingBoundary<D>>(where<D>(), overTime(speed), direction.in<D>("MovingBoundary.direction"), rough, ahead);
}
template <int D> GroundBoundary::Pointer<D> ImpermeableBoundary::make() const { return std::make_shared<talik::ImpermeableBoundary<D>>(always<D>()); }
template <int D> GroundBoundary::Pointer<D> DrainedBoundary::make() const
{
	return std::make_shared<talik::DrainedBoundary<D>>(where<D>(), overTime(pressure), recharge);
}
template <int D> GroundBoundary::Pointer<D> InsulatedBoundary::make() const { return std::make_shared<talik::InsulatedBoundary<D>>(always<D>()); }
template <int D> GroundBoundary::Pointer<D> WallTemperature::make() const
{
	return std::make_shared<talik::WallTemperature<D>>(where<D>(), overTime(temperature));
}
template <int D> GroundBoundary::Pointer<D> SurfaceTemperature::make() const
{
	talik::requireSetting(
	        heatTransferCoefficient > 0, "SurfaceTemperature.heatTransferCoefficient", heatTransferCoefficient,
	        "must be positive, in W/(m^2 K); without exchange leave the boundary out");
	return std::make_shared<talik::SurfaceTemperature<D>>(where<D>(), overTime(temperature), heatTransferCoefficient);
}
template <int D> GroundBoundary::Pointer<D> BodyTemperature::make() const
{
	if (!region.empty() || lower.isGiven() || upper.isGiven())
		throw std::invalid_argument(
		        "BodyTemperature.region is '" + region + "', with lower and upper: it acts where its bodies are; leave region, lower and upper out.");
	return std::make_shared<talik::BodyTemperature<D>>(bodies, overTime(temperature), resistance);
}
void BodyTemperature::checkBodies(const std::set<int>& met) const
{
	for (const int id : bodies)
		if (!met.count(id))
			throw std::invalid_argument(
			        "BodyTemperature.bodies names " + std::to_string(id)
			        + ", which is no body that the ground meets: give numbers of O.bodies that BodyContact.mask does not leave out.");
}
template <int D> GroundBoundary::Pointer<D> HeatFlux::make() const { return std::make_shared<talik::HeatFlux<D>>(where<D>(), overTime(flux)); }
template <int D> GroundBoundary::Pointer<D> HeatSource::make() const { return std::make_shared<talik::HeatSource<D>>(where<D>(), overTime(power)); }
template <int D> GroundBoundary::Pointer<D> WaterFlux::make() const { return std::make_shared<talik::WaterFlux<D>>(where<D>(), overTime(flux), temperature); }
template <int D> GroundBoundary::Pointer<D> SurfaceLoad::make() const
{
	std::vector<talik::TimeTable> constant;
	const talik::Vec<D>           given = traction.in<D>("SurfaceLoad.traction");
	if (std::any_of(given.begin(), given.end(), [](double t) { return t != 0; })) constant.assign(given.begin(), given.end());
	return std::make_shared<talik::Traction<D>>(where<D>(), overTime(pressure), constant);
}

// for boundaries in other files
template talik::Region<2> GroundBoundary::where<2>() const;
template talik::Region<3> GroundBoundary::where<3>() const;
template talik::Region<2> GroundBoundary::always<2>() const;
template talik::Region<3> GroundBoundary::always<3>() const;

// clang-format off
#define TALIK_BOUNDARIES (RollerBoundary)(FixedBoundary)(PeriodicBoundary)(MovingBoundary)(ImpermeableBoundary)(DrainedBoundary)(InsulatedBoundary) \
	(WallTemperature)(SurfaceTemperature)(BodyTemperature)(HeatFlux)(HeatSource)(WaterFlux)(SurfaceLoad)
#define TALIK_IN_BOTH_DIMENSIONS(r, data, Kind)                    \
	template GroundBoundary::Pointer<2> Kind::make<2>() const; \
	template GroundBoundary::Pointer<3> Kind::make<3>() const;
BOOST_PP_SEQ_FOR_EACH(TALIK_IN_BOTH_DIMENSIONS, , TALIK_BOUNDARIES)
YADE_PLUGIN((GroundBoundary)TALIK_BOUNDARIES);
// clang-format on

} // namespace yade
