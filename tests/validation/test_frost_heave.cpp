// SPDX-License-Identifier: GPL-2.0-or-later
// Freezing in a sealed volume: pressure, heave and conserved mass; expansion of a free element; freeze, load, unload, thaw.
#include "References.hpp"
#include "Report.hpp"
#include "Scenes.hpp"

#include <gtest/gtest.h>

#include <algorithm>

using namespace talik;
using namespace talik::validation;

namespace {

constexpr double porosity = 0.4, width = 0.5, residual = 0.05;

double liquidSaturation(double t) { return t >= 0.0 ? 1.0 : residual + (1.0 - residual) * std::exp(-t * t / (width * width)); }

/// Sealed column that freezes uniformly, free to heave against its skeleton: everything per unit initial volume, from the
/// balances of mass and force alone. Stress of the skeleton is M ln J (constant oedometer modulus, rate form).
struct SealedFreezing {
	double modulus, waterBulk, iceBulk, waterMass;

	double poreVolume(double j) const { return j - (1.0 - porosity); }
	double iceMass(double t, double j) const { return 910.0 * (1.0 - liquidSaturation(t)) * poreVolume(j); }
	double pressure(double t, double j) const
	{
		const double ice = iceMass(t, j) / 910.0, liquid = (waterMass - iceMass(t, j)) / 1000.0;
		return (ice + liquid - poreVolume(j)) / (ice / iceBulk + liquid / waterBulk);
	}
	/// volume ratio at which skeleton and pore pressure balance
	double volumeRatio(double t) const
	{
		return reference::bisect([&](double j) { return pressure(t, j) - modulus * std::log(j); }, 0.98, 1.2);
	}
};

} // namespace

TEST(FrostHeave, SealedColumnHeavesAndPressurisesAsTheBalancesSay)
{
	citing("balances of mass and force");
	const double h = 0.1, height = 0.4, modulus = 1e7;
	auto         s = columnSettings(h, 0.8);
	standOnRollers(s);
	s.motion.emplace();
	s.motion->localDamping = 0.5;
	s.heat.emplace();
	s.freezing = makeFreezingCurve();
	s.water.emplace();
	s.water->state.liquidBulkModulus = 2.2e8;
	s.water->state.iceBulkModulus    = 8.8e8;
	s.skeletons.push_back(elasticOedometer(modulus));
	// slow against the waves that phase change sends out: all heat leaves in two seconds, a wave crosses in a millisecond
	s.heat->source = -6.5e7;
	Ground<2> ground(s);
	fillBox(ground, { 0.0, 0.0 }, { h, height }, [](PointInput<2>& p) {
		p.porosity    = porosity;
		p.temperature = 0.05;
	});
	ground.initialise();
	const auto           start = ground.balance();
	const SealedFreezing exact { modulus, 2.2e8, 8.8e8, start.waterMass / (h * height) };
	Drawing              heave("sealed_freezing_heave", "Sealed freezing column, M = 10 MPa", "temperature [degC]", "heave [-]");
	Drawing              pressing("sealed_freezing_pressure", "Sealed freezing column, M = 10 MPa", "temperature [degC]", "pore pressure [kPa]");
	heave.reference("heave", -3.0, 0.05, [&](double t) { return exact.volumeRatio(t) - 1.0; });
	pressing.reference("pressure", -3.0, 0.05, [&](double t) { return 1e-3 * exact.pressure(t, exact.volumeRatio(t)); });
	for (const double instant : { 0.5, 0.75, 1.0, 1.25, 1.5, 1.75, 2.0 }) {
		marchTo(ground, instant);
		const double count = ground.points().count();
		const double t     = sumOf(ground, "temperature") / count;
		const double j     = sumOf(ground, "volume") / (h * height);
		const double p     = sumOf(ground, "pressure") / count;
		const double jRef  = exact.volumeRatio(t);
		char         label[64];
		std::snprintf(label, sizeof label, ", T = %.3f degC", t);
		heave.computed("heave", t, j - 1.0);
		pressing.computed("pressure", t, 1e-3 * p);
		expectScaled(std::string("sealed freezing: heave over full expansion") + label, j - 1.0, jRef - 1.0, 0.0989 * porosity, 1e-2);
		expectScaled(
		        std::string("sealed freezing: pore pressure [Pa]") + label, p, exact.pressure(t, jRef), modulus * std::log(1.0 + 0.0989 * porosity),
		        1e-2);
	}
	const auto end = ground.balance();
	expectSmall("sealed freezing: drift of ice and water", end.waterMass / start.waterMass - 1.0, 1e-13);
	expectSmall("sealed freezing: drift of heat", (end.enthalpy - start.enthalpy - end.heatIn) / end.heatIn, 1e-12);
	const auto t = valuesOf(ground, "temperature");
	expectSmall("sealed freezing: spread of temperature [K]", *std::max_element(t.begin(), t.end()) - *std::min_element(t.begin(), t.end()), 1e-2);
}

// With hardly any skeleton the pores must take up the whole expansion of the water: V_pore = m_w/(rho_l S_l + rho_i S_i)
TEST(FrostHeave, FreeElementExpandsByTheVolumeOfItsIce)
{
	GroundSettings<2> s;
	citing("volume of ice and water");
	s.lower       = { 0.0, 0.0 };
	s.upper       = { 0.8, 0.8 };
	s.gridSpacing = 0.2;
	s.mixture     = withoutExpansion();
	s.motion.emplace();
	s.motion->localDamping = 0.5;
	s.heat.emplace();
	s.heat->source = -2e7;
	s.freezing     = makeFreezingCurve();
	s.water.emplace();
	s.water->state.liquidBulkModulus = 2.2e7;
	s.water->state.iceBulkModulus    = 8.8e7;
	s.skeletons.push_back(elasticOedometer(1e4));
	Ground<2>    ground(s);
	const double n = 0.35;
	fillBox(ground, { 0.3, 0.3 }, { 0.5, 0.5 }, [&](PointInput<2>& p) {
		p.porosity    = n;
		p.temperature = 0.05;
	});
	ground.initialise();
	const auto start = ground.balance();
	Drawing    drawing("nine_per_cent", "Free element, n = 0.35", "temperature [degC]", "volume gained [-]");
	const auto gained = [&](double temperature) {
		const double liquid = liquidSaturation(temperature);
		return n / (liquid + 0.91 * (1.0 - liquid)) - n;
	};
	drawing.reference("volume", -1.5, 0.05, gained);
	const auto meanTemperature = [&] { return sumOf(ground, "temperature") / ground.points().count(); };
	for (double last = 1.0; meanTemperature() > -1.5 && ground.time() < 30.0;) {
		ground.step(ground.stableTimeStep().step);
		if (last - meanTemperature() < 0.05) continue;
		last = meanTemperature();
		drawing.computed("volume", last, sumOf(ground, "volume") / 0.04 - 1.0);
	}
	const auto   volume = valuesOf(ground, "volume");
	const double ratio  = sumOf(ground, "volume") / 0.04;
	const double pores  = n + gained(meanTemperature());
	expectScaled("nine per cent: volume gained over n(rho_l/rho_i - 1)", ratio - 1.0, pores - n, n * 0.0989, 1e-2);
	const auto   x = valuesOf(ground, "position", 0), y = valuesOf(ground, "position", 1);
	const double wide = *std::max_element(x.begin(), x.end()) - *std::min_element(x.begin(), x.end());
	const double tall = *std::max_element(y.begin(), y.end()) - *std::min_element(y.begin(), y.end());
	expectRelative("nine per cent: width against square root of the volume ratio", wide / 0.1, std::sqrt(1.0 + pores - n), 5e-3);
	expectRelative("nine per cent: height against square root of the volume ratio", tall / 0.1, std::sqrt(1.0 + pores - n), 5e-3);
	expectSmall("nine per cent: drift of ice and water", ground.balance().waterMass / start.waterMass - 1.0, 1e-13);
}

// Frozen ground is loaded, unloaded and thawed: stiff while frozen, nothing left afterwards
TEST(FrostHeave, ColumnFrozenLoadedUnloadedAndThawedReturnsToItsHeight)
{
	citing("Hooke, stiffness of frozen ground");
	const double h = 0.1, height = 0.4, load = 1e5;
	auto         s = columnSettings(h, 0.8);
	standOnRollers(s);
	s.motion.emplace();
	s.motion->localDamping = 0.5;
	s.heat.emplace();
	constexpr double accelerated = 2e7;
	s.heat->thermalTimeScale     = accelerated;
	s.freezing                   = makeFreezingCurve();
	auto soil                    = std::make_shared<MohrCoulombSkeleton<2>>();
	soil->young                  = 1e7;
	soil->youngFrozen            = 1e8;
	soil->poisson                = 0.0;
	soil->cohesion = soil->cohesionFrozen = 1e7;
	soil->tensileStrength = soil->tensileStrengthFrozen = 1e7;
	s.skeletons.push_back(soil);
	addBoundary<WallTemperature<2>>(s, Region<2>::side("bottom"), TimeTable({ 1.4 * accelerated, 1.5 * accelerated }, { -5.0, 5.0 }));
	addBoundary<Traction<2>>(
	        s, Region<2>::freeSurface(),
	        TimeTable({ 0.0, 0.6 * accelerated, 0.7 * accelerated, 1.0 * accelerated, 1.1 * accelerated }, { 0.0, 0.0, load, load, 0.0 }));
	Ground<2> ground(s);
	fillBox(ground, { 0.0, 0.0 }, { h, height }, [](PointInput<2>& p) { p.temperature = 1.0; });
	ground.initialise();
	const auto strain = [&] { return 1.0 - sumOf(ground, "volume") / (h * height); };
	Drawing    drawing("freeze_load_unload_thaw", "Frozen, loaded, unloaded, thawed column", "time [s]", "vertical strain [1e-3]");
	const auto record = [&] {
		if (std::fmod(ground.time(), 0.04) < ground.stableTimeStep().step) drawing.computed("strain", ground.time(), 1e3 * strain());
	};
	const double    phiFull = 1.0 - std::pow(1.0 - 0.95 * 0.95, 2);
	const TimeTable loading({ 0.0, 0.6, 0.7, 1.0, 1.1 }, { 0.0, 0.0, load, load, 0.0 });
	drawing.reference("strain", 0.0, 2.4, [&](double t) { return 1e3 * loading.at(t) / (1e7 + 9e7 * phiFull); });
	marchTo(ground, 0.6, 1e300, record);
	const double frozen = sumOf(ground, "iceSaturation") / ground.points().count();
	expectRelative("freeze-load-unload-thaw: ice saturation when loaded", frozen, 0.95, 1e-2);
	marchTo(ground, 1.0, 1e300, record);
	const double phi = 1.0 - std::pow(1.0 - frozen * frozen, 2);
	expectRelative("freeze-load-unload-thaw: strain under load", strain(), 1.0 - std::exp(-load / (1e7 + 9e7 * phi)), 1e-2);
	marchTo(ground, 1.4, 1e300, record);
	expectScaled("freeze-load-unload-thaw: strain after unloading over that under load", strain(), 0.0, load / 1e8, 1e-2);
	marchTo(ground, 2.4, 1e300, record);
	expectSmall("freeze-load-unload-thaw: ice left after thaw", sumOf(ground, "iceSaturation"), 1e-12);
	expectScaled("freeze-load-unload-thaw: strain after thaw over that under load", strain(), 0.0, load / 1e8, 1e-2);
	expectScaled("freeze-load-unload-thaw: vertical stress after thaw over load", largestSize(valuesOf(ground, "stress", 1)), 0.0, load, 1e-2);
}
