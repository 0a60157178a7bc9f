// SPDX-License-Identifier: GPL-2.0-or-later
// What ice carried is given back when it melts: columns loaded and unloaded while frozen, and seasons that close.
#include "Report.hpp"
#include "Scenes.hpp"

#include <gtest/gtest.h>

#include <algorithm>

using namespace talik;
using namespace talik::validation;

namespace {

constexpr double porosity = 0.4, spacing = 0.1, height = 0.4, load = 1e5, thawedModulus = 1e7, frozenModulus = 1e8;
constexpr double stableFrozen = 1.5e-4;          ///< time step for the waves of frozen ground [s]
constexpr double scale = 2e7, seasonScale = 2e6; ///< calendar time over time of motion [-]

/// A table of the calendar from times of motion [s].
TimeTable inMotion(double perSecond, std::vector<double> times, std::vector<double> values)
{
	for (double& time : times)
		time *= perSecond;
	return TimeTable(times, values);
}

/// Dry column between rollers, whose temperature its base sets and whose surface is loaded, by the calendar.
Ground<2> column(const TimeTable& temperatures, const TimeTable& loads, double start)
{
	auto s = columnSettings(spacing, 0.8);
	s.thawFront.reset(); // the law alone: no two velocities where its ice begins
	standOnRollers(s);
	s.motion.emplace();
	s.motion->localDamping = 0.5;
	s.heat.emplace();
	s.heat->thermalTimeScale = scale;
	s.freezing               = makeFreezingCurve();
	auto soil                = std::make_shared<MohrCoulombSkeleton<2>>();
	soil->young              = thawedModulus;
	soil->youngFrozen        = frozenModulus;
	soil->poisson            = 0.0;
	soil->cohesion = soil->cohesionFrozen = 1e7;
	soil->tensileStrength = soil->tensileStrengthFrozen = 1e7;
	s.skeletons.push_back(soil);
	addBoundary<WallTemperature<2>>(s, Region<2>::side("bottom"), temperatures);
	addBoundary<Traction<2>>(s, Region<2>::freeSurface(), loads);
	Ground<2> ground(s);
	fillBox(ground, { 0.0, 0.0 }, { spacing, height }, [&](PointInput<2>& p) { p.temperature = start; });
	ground.initialise();
	return ground;
}

double strainOf(const Ground<2>& ground) { return 1.0 - sumOf(ground, "volume") / (spacing * height); }

double meanIce(const Ground<2>& ground) { return sumOf(ground, "iceSaturation") / ground.points().count(); }

/// E at an ice saturation, exponent 2.
double modulusAt(double ice) { return thawedModulus + (frozenModulus - thawedModulus) * (1.0 - std::pow(1.0 - ice * ice, 2)); }

} // namespace

// The ice carries nine tenths of a load that comes while the ground is frozen; the grains take all of it when the ice is gone
TEST(ThawSettlement, ColumnLoadedWhileFrozenSettlesOnThawToTheStrainOfThawedGround)
{
	citing("Hooke, grains and ice in parallel");
	Ground<2>    ground = column(inMotion(scale, { 0.4, 0.5 }, { -5.0, 5.0 }), inMotion(scale, { 0.0, 0.1 }, { 0.0, load }), -5.0);
	const double ice    = meanIce(ground);
	marchTo(ground, 0.4);
	expectScaled(
	        "freeze-load-thaw, column: strain frozen, over that thawed", strainOf(ground), 1.0 - std::exp(-load / modulusAt(ice)), load / thawedModulus,
	        1e-3);
	marchTo(ground, 1.6);
	expectSmall("freeze-load-thaw, column: ice left after thaw", sumOf(ground, "iceSaturation"), 1e-12);
	expectRelative("freeze-load-thaw, column: strain after thaw", strainOf(ground), 1.0 - std::exp(-load / thawedModulus), 1e-2);
	expectScaled("freeze-load-thaw, column: stress left in ice over load", largestSize(valuesOf(ground, "skeleton0.iceStress", 1)), 0.0, load, 1e-12);
}

// Ice is born free of stress: freezing under load changes nothing, unloading stretches ice and grains together, thaw gives back all
TEST(ThawSettlement, ColumnLoadedFrozenUnloadedAndThawedReturnsToItsHeight)
{
	citing("Hooke, ice stress-free at birth");
	const TimeTable temperatures = inMotion(scale, { 0.3, 0.4, 1.3, 1.4 }, { 1.0, -5.0, -5.0, 5.0 });
	Ground<2>       ground       = column(temperatures, inMotion(scale, { 0.0, 0.1, 1.0, 1.1 }, { 0.0, load, load, 0.0 }), 1.0);
	const double    thawed       = 1.0 - std::exp(-load / thawedModulus);
	marchTo(ground, 0.3, stableFrozen);
	expectRelative("load-freeze-unload-thaw, column of the law: strain under load", strainOf(ground), thawed, 1e-2);
	marchTo(ground, 1.0, stableFrozen);
	expectRelative("load-freeze-unload-thaw, column of the law: strain under load, frozen", strainOf(ground), thawed, 1e-2);
	const double ice = meanIce(ground);
	marchTo(ground, 1.3, stableFrozen);
	expectScaled(
	        "load-freeze-unload-thaw, column of the law: strain held by the ice, over that of the load", strainOf(ground),
	        load / thawedModulus - load / modulusAt(ice), thawed, 1e-2);
	marchTo(ground, 2.5, stableFrozen);
	expectSmall("load-freeze-unload-thaw, column of the law: ice left after thaw", sumOf(ground, "iceSaturation"), 1e-12);
	expectScaled("load-freeze-unload-thaw, column of the law: strain after thaw, over that of the load", strainOf(ground), 0.0, thawed, 1e-2);
}

namespace {

/// Saturated column of 1 m that weather of the surface freezes and thaws every four seconds, its surface drained. Twice as
/// fast its cells drop as they thaw, and ground that flies for a moment yields: a per cent of the heave stays then.
struct Seasons {
	std::shared_ptr<SkeletonModel<2>> skeleton;

	Ground<2> ground(int years) const
	{
		auto s = columnSettings(spacing, 1.4);
		standOnRollers(s);
		s.motion.emplace();
		s.motion->gravity      = { 0.0, -9.81 };
		s.motion->localDamping = 0.5;
		s.heat.emplace();
		s.heat->thermalTimeScale = seasonScale;
		s.freezing               = makeFreezingCurve();
		s.water.emplace();
		s.water->hydraulicTimeScale                 = 1.0;
		s.water->permeability.referenceConductivity = 1e-5;
		s.water->state.liquidBulkModulus            = 2.2e7;
		s.water->state.iceBulkModulus               = 8.8e7;
		s.skeletons.push_back(skeleton);
		std::vector<double> times, values;
		for (int year = 0; year < years; ++year)
			for (const auto& [time, value] : { std::pair { 0.0, 2.0 }, { 0.6, 2.0 }, { 0.7, -8.0 }, { 2.3, -8.0 }, { 2.4, 20.0 }, { 3.9, 20.0 } }) {
				times.push_back(4.0 * year + time);
				values.push_back(value);
			}
		addBoundary<SurfaceTemperature<2>>(s, Region<2>::freeSurface(), inMotion(seasonScale, times, values));
		addBoundary<DrainedBoundary<2>>(s, Region<2>::freeSurface());
		Ground<2> ground(s);
		fillBox(ground, { 0.0, 0.0 }, { spacing, 1.0 }, [&](PointInput<2>& p) {
			p.porosity    = porosity;
			p.temperature = 2.0;
			p.pressure    = 9810.0 * (1.0 - p.position[1]);
			// weight of the grains less that of the water they displace
			const double depth = 1.0 - p.position[1];
			p.stress[1]        = -0.6 * 1650.0 * 9.81 * depth;
			p.stress[0] = p.stress[2] = 3.0 / 7.0 * p.stress[1];
		});
		ground.initialise();
		return ground;
	}
};

double riseOf(const Ground<2>& ground) { return sumOf(ground, "volume") / spacing - 1.0; }

} // namespace

namespace {

/// Two winters and summers: what the first winter heaved, and what is left of it after each thaw.
void expectClosedSeasons(const char* law, const Seasons& scene, double mostLeft = 0.01)
{
	Ground<2>         ground = scene.ground(2);
	const std::string name   = std::string("seasons, drained column of 1 m, ") + law;
	const auto        march  = [&](double instant) {
                while (ground.time() < instant)
                        ground.step(std::min(ground.stableTimeStep().step, 5e-4));
	};
	march(0.6);
	const double start = riseOf(ground);
	march(2.3);
	const double heave = riseOf(ground) - start;
	std::printf("%s: heave %.2f mm at a mean ice saturation of %.2f\n", name.c_str(), 1e3 * heave, meanIce(ground));
	// seven tenths of the water freeze and push nine per cent of it up, less what leaves through the surface
	expectScaled(name + ": heave frozen over expansion of the ice", heave, 0.0989 * porosity * meanIce(ground), 0.0989 * porosity * meanIce(ground), 0.2);
	for (const double thawed : { 3.9, 7.9 }) {
		march(thawed);
		char label[48];
		std::snprintf(label, sizeof label, ": left after thaw %d over the heave", thawed < 4.0 ? 1 : 2);
		ASSERT_EQ(sumOf(ground, "iceSaturation"), 0.0);
		expectScaled(name + label, riseOf(ground) - start, 0.0, heave, mostLeft);
	}
}

} // namespace

// Where nothing is lost the ground comes back to where it was
TEST(ThawSettlement, DrainedColumnComesBackToItsHeightAfterEveryWinter)
{
	citing("closed cycle; volume of ice and water");
	auto soil      = std::make_shared<MohrCoulombSkeleton<2>>();
	soil->cohesion = soil->cohesionFrozen = 0.0;
	expectClosedSeasons("no cohesion", { soil });
}

TEST(ThawSettlement, DrainedColumnOfOtherLawsComesBackToItsHeightAfterEveryWinter_slow)
{
	citing("closed cycle; volume of ice and water");
	expectClosedSeasons("elastic", { elasticOedometer(13.46e6) });
	// falls short of a hundredth, as the limits page says
	expectClosedSeasons("Mohr-Coulomb", { std::make_shared<MohrCoulombSkeleton<2>>() }, 0.03);
}
