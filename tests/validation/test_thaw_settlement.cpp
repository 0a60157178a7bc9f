// SPDX-License-Identifier: GPL-2.0-or-later
// What ice carried is given back when it melts: columns loaded and unloaded while frozen, and seasons that close.
#include "Report.hpp"
#include "Scenes.hpp"

#include <gtest/gtest.h>

#include <algorithm>

using namespace talik;
using namespace talik::validation;

namespace {

constexpr double spacing = 0.1, height = 0.4, load = 1e5, thawedModulus = 1e7, frozenModulus = 1e8;
constexpr double stableFrozen = 1.5e-4; ///< time step for the waves of frozen ground [s]

/// Dry column between rollers, whose temperature its base sets and whose surface is loaded, in times [s].
Ground<2> column(const TimeTable& temperatures, const TimeTable& loads, double start)
{
	auto s = columnSettings(spacing, 0.8);
	standOnRollers(s);
	s.motion.emplace();
	s.motion->localDamping = 0.5;
	s.heat.emplace();
	s.heat->thermalTimeScale = 2e7;
	s.freezing               = makeFreezingCurve();
	auto soil                = std::make_shared<MohrCoulombSkeleton<2>>();
	soil->youngModulus       = thawedModulus;
	soil->youngModulusFrozen = frozenModulus;
	soil->poissonRatio       = 0.0;
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
	Ground<2>    ground = column(TimeTable({ 0.4, 0.5 }, { -5.0, 5.0 }), TimeTable({ 0.0, 0.1 }, { 0.0, load }), -5.0);
	const double ice    = meanIce(ground);
	marchTo(ground, 0.4);
	expectScaled("freeze-load-thaw, column: strain frozen, over that thawed", strainOf(ground), 1.0 - std::exp(-load / modulusAt(ice)), load / thawedModulus, 1e-3);
	marchTo(ground, 1.6);
	expectSmall("freeze-load-thaw, column: ice left after thaw", sumOf(ground, "iceSaturation"), 1e-12);
	expectRelative("freeze-load-thaw, column: strain after thaw", strainOf(ground), 1.0 - std::exp(-load / thawedModulus), 1e-2);
	expectScaled("freeze-load-thaw, column: stress left in ice over load", largestSize(valuesOf(ground, "skeleton0.iceStress", 1)), 0.0, load, 1e-12);
}

// Ice is born free of stress: freezing under load changes nothing, unloading stretches ice and grains together, thaw gives back all
TEST(ThawSettlement, ColumnLoadedFrozenUnloadedAndThawedReturnsToItsHeight)
{
	citing("Hooke, ice stress-free at birth");
	const TimeTable temperatures({ 0.3, 0.4, 1.3, 1.4 }, { 1.0, -5.0, -5.0, 5.0 });
	Ground<2>       ground = column(temperatures, TimeTable({ 0.0, 0.1, 1.0, 1.1 }, { 0.0, load, load, 0.0 }), 1.0);
	const double    thawed = 1.0 - std::exp(-load / thawedModulus);
	marchTo(ground, 0.3, stableFrozen);
	expectRelative("load-freeze-unload-thaw, column of the law: strain under load", strainOf(ground), thawed, 1e-2);
	marchTo(ground, 1.0, stableFrozen);
	expectRelative("load-freeze-unload-thaw, column of the law: strain under load, frozen", strainOf(ground), thawed, 1e-2);
	const double ice = meanIce(ground);
	marchTo(ground, 1.3, stableFrozen);
	expectScaled(
	        "load-freeze-unload-thaw, column of the law: strain held by the ice, over that of the load", strainOf(ground), load / thawedModulus - load / modulusAt(ice),
	        thawed, 1e-2);
	marchTo(ground, 2.5, stableFrozen);
	expectSmall("load-freeze-unload-thaw, column of the law: ice left after thaw", sumOf(ground, "iceSaturation"), 1e-12);
	expectScaled("load-freeze-unload-thaw, column of the law: strain after thaw, over that of the load", strainOf(ground), 0.0, thawed, 1e-2);
}

namespace {

/// Saturated column of 1 m that weather of the surface freezes and thaws every two seconds, its surface drained.
struct Seasons {
	double conductivity = 1e-5;
	bool   recharged    = false;
	double heat         = 4e6;
	double damping      = 0.5;
	std::shared_ptr<SkeletonModel<2>> skeleton;

	Ground<2> ground(int years) const
	{
		auto s = columnSettings(spacing, 1.4);
		standOnRollers(s);
		s.motion.emplace();
		s.motion->gravity      = { 0.0, -9.81 };
		s.motion->localDamping = damping;
		s.heat.emplace();
		s.heat->thermalTimeScale = heat;
		s.freezing               = makeFreezingCurve();
		s.water.emplace();
		s.water->permeability.referenceConductivity = conductivity;
		s.water->state.liquidBulkModulus            = 2.2e7;
		s.water->state.iceBulkModulus               = 8.8e7;
		s.skeletons.push_back(skeleton);
		std::vector<double> times, values;
		for (int year = 0; year < years; ++year)
			for (const auto& [time, value] : { std::pair { 0.0, 2.0 }, { 0.3, 2.0 }, { 0.35, -8.0 }, { 1.15, -8.0 }, { 1.2, 20.0 }, { 1.95, 20.0 } }) {
				times.push_back(2.0 * year + time);
				values.push_back(value);
			}
		addBoundary<SurfaceTemperature<2>>(s, Region<2>::freeSurface(), TimeTable(times, values));
		addBoundary<DrainedBoundary<2>>(s, Region<2>::freeSurface(), 0.0, recharged);
		Ground<2> ground(s);
		fillBox(ground, { 0.0, 0.0 }, { spacing, 1.0 }, [&](PointInput<2>& p) {
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

TEST(ThawSettlement, Probe)
{
	for (const int kind : { 0, 1, 2 }) {
			Seasons scene;
			if (kind == 0) scene.skeleton = elasticOedometer(13.46e6);
			else {
				auto soil = std::make_shared<MohrCoulombSkeleton<2>>();
				if (kind == 2) soil->cohesion = soil->cohesionFrozen = 0.0;
				scene.skeleton = soil;
			}
			Ground<2> ground = scene.ground(3);
			for (double t : { 0.3, 1.15, 1.95, 3.15, 3.95, 5.15, 5.95 }) {
				while (ground.time() < t)
					ground.step(std::min(ground.stableTimeStep().step, 5e-4));
				std::printf("%d t %.2f: rise %.2f mm, ice %.3f water %.5f\n", kind, t, 1e3 * riseOf(ground), meanIce(ground), ground.balance().waterMass/spacing/400.0);
				if (t < 2.0 || t>5.9) {
					const auto y = valuesOf(ground, "position", 1), v = valuesOf(ground, "volume"), yy = valuesOf(ground, "stress", 1), xx = valuesOf(ground, "stress", 0), p = valuesOf(ground, "pressure"), S = valuesOf(ground, "iceSaturation");
					std::vector<double> o(y.size()), zi(y.size());
					if (kind) o = valuesOf(ground, "skeleton0.opening"), zi = valuesOf(ground, "skeleton0.iceStress", 1);
					for (std::size_t k = 0; k < y.size(); k += 2)
						std::printf("    y %.3f vol %+.5f yy %9.0f xx %9.0f p %9.0f S %.3f opening %.5f iceyy %9.0f\n", y[k], v[k]/0.0025 - 1.0, yy[k], xx[k], p[k], S[k], o[k], zi[k]);
				}
			}
	}
}
