// SPDX-License-Identifier: GPL-2.0-or-later
// Thawing and freezing fronts in rigid ground: Neumann, Lunardini and similarity solutions.
#include "References.hpp"
#include "Report.hpp"
#include "Scenes.hpp"

#include <gtest/gtest.h>

using namespace talik;
using namespace talik::validation;

namespace {

constexpr double day = 86400.0, porosity = 0.4;

enum class Wall { onNodes, freeSurface };

struct FrontScene {
	std::string      name;
	double           surface, initial;
	FreezingCurvePtr curve;
	EnthalpyForm     form    = EnthalpyForm::capacityIntegral;
	LatentDensity    density = LatentDensity::ice;
	Wall             wall    = Wall::onNodes;
	double           spacing = 0.05;
	double           offset  = 0.0; ///< of the free surface above a node [h]
	double           depth   = 1.5; ///< of the ground [m]
	MixtureProperties mixture = withoutExpansion();
};

FreezingCurvePtr sharpCurve() { return makeFreezingCurve("sharp", { { "residualSaturation", 0.0 } }); }

struct FrontResult {
	double front;   ///< volume per area whose water has changed phase [m]
	double closure; ///< (gain of heat - logged heat)/logged heat
};

FrontResult marchFront(const FrontScene& scene, double time)
{
	const double h   = scene.spacing;
	const double top = scene.depth + scene.offset * h;
	auto         s   = columnSettings(h, std::ceil(top / h - 1e-9) * h + (scene.wall == Wall::freeSurface ? 2 * h : 0.0));
	s.mixture        = scene.mixture;
	s.heat.emplace();
	s.heat->enthalpyForm  = scene.form;
	s.heat->latentDensity = scene.density;
	s.freezing            = scene.curve;
	if (scene.wall == Wall::onNodes) addBoundary<WallTemperature<2>>(s, Region<2>::side("bottom"), scene.surface);
	else addBoundary<SurfaceTemperature<2>>(s, Region<2>::freeSurface().within({ -1.0, 0.5 * top }, { 1.0, 2.0 * top }), scene.surface);
	Ground<2> ground(s);
	fillBox(ground, { 0.0, top - scene.depth }, { h, top }, [&](PointInput<2>& p) {
		p.temperature = scene.initial;
		p.porosity    = porosity;
	});
	ground.initialise();
	const double heatBefore = ground.balance().enthalpy;
	const auto   before     = valuesOf(ground, "iceSaturation");
	marchTo(ground, time);
	const auto   after  = valuesOf(ground, "iceSaturation"), volume = valuesOf(ground, "volume");
	const double farIce = 1.0 - scene.curve->liquidSaturation(scene.initial), nearIce = 1.0 - scene.curve->liquidSaturation(scene.surface);
	double       changed = 0.0;
	for (std::size_t p = 0; p < after.size(); ++p)
		changed += (after[p] - farIce) / (nearIce - farIce) * volume[p];
	const auto balance = ground.balance();
	return { changed / h, (balance.enthalpy - heatBefore - balance.heatIn) / std::abs(balance.heatIn) };
}

reference::Conductor phase(const MixtureProperties& m, double liquidSaturation)
{
	const auto n = VolumeFractions::of(porosity, liquidSaturation);
	return { m.conductivity(n), m.heatCapacity(n) };
}

/// Neumann's solution with the capacities of eq. (4): volume fractions of a fixed porosity.
double neumann(const FrontScene& scene)
{
	const double rho    = scene.density == LatentDensity::ice ? scene.mixture.ice.density : scene.mixture.liquid.density;
	const double latent = porosity * rho * scene.mixture.latentHeat;
	const bool   thaws  = scene.surface > scene.initial;
	const auto   thawed = phase(scene.mixture, 1.0), frozen = phase(scene.mixture, 0.0);
	return reference::neumannFront(thaws ? thawed : frozen, thaws ? frozen : thawed, scene.surface, scene.initial, 0.0, latent);
}

void expectFront(const FrontScene& scene, double perRootTime, double days, double tolerance, bool inSpacings)
{
	const double exact  = perRootTime * std::sqrt(days * day);
	const auto   result = marchFront(scene, days * day);
	if (inSpacings) expectScaled(scene.name + ", error in h [m]", result.front, exact, scene.spacing, tolerance);
	else expectRelative(scene.name + " [m]", result.front, exact, tolerance);
	expectSmall(scene.name + ", heat closure", result.closure, 1e-12);
}

} // namespace

TEST(MovingFront, NeumannReferenceGivesThePublishedFrontOfThePapersSoil)
{
	FrontScene s { "", 10.0, -5.0, sharpCurve() };
	expectRelative("V02 reference: thaw -5/+10, X/sqrt(t) [m/s^0.5]", neumann(s), 3.154424e-4, 1e-6);
	s.surface = -5.0;
	s.initial = 5.0;
	expectRelative("V02 reference: freezing +5/-5, X after 1 d [m]", neumann(s) * std::sqrt(day), 0.08816, 1e-4);
}

TEST(MovingFront, ThawFromAWallOnNodesFollowsNeumann)
{
	for (const auto density : { LatentDensity::ice, LatentDensity::liquid }) {
		FrontScene s { std::string("V02 thaw -5/+10, wall, sharp, rho_") + (density == LatentDensity::ice ? "i" : "l"), 10.0, -5.0, sharpCurve() };
		s.density = density;
		expectFront(s, neumann(s), 10.0, 1e-2, false);
	}
}

// A front that freezes lags by a third of a spacing: the nodes at the front average over both sides of it, and the ice just
// formed conducts like the ground ahead. When ground thaws the two effects cancel. The lag is a length, so it falls with h.
TEST(MovingFront, FreezingFromAWallOnNodesFollowsNeumannWithinFourTenthsOfASpacing)
{
	for (const auto density : { LatentDensity::ice, LatentDensity::liquid }) {
		FrontScene s { std::string("V02 freezing +5/-5, wall, sharp, rho_") + (density == LatentDensity::ice ? "i" : "l"), -5.0, 5.0, sharpCurve() };
		s.density = density;
		s.depth   = 2.0;
		expectFront(s, neumann(s), 10.0, 0.4, true);
	}
	for (const double h : { 0.1, 0.025 }) {
		FrontScene s { "V02 freezing +5/-5, wall, sharp, h = " + std::to_string(h).substr(0, 5), -5.0, 5.0, sharpCurve() };
		s.spacing = h;
		s.depth   = 2.0;
		expectFront(s, neumann(s), 10.0, 0.4, true);
	}
}

TEST(MovingFront, ThawFrontErrorFallsWithTheGridSpacing)
{
	for (const double h : { 0.1, 0.05, 0.025 }) {
		FrontScene s { "V02 thaw -5/+10, wall, sharp, h = " + std::to_string(h).substr(0, 5), 10.0, -5.0, sharpCurve() };
		s.spacing = h;
		expectFront(s, neumann(s), 10.0, 1e-2, false);
	}
}

// State-function form: mass is kept, so thawed ground holds the 0.91 rho_l of water that the ice held
TEST(MovingFront, ThawAndFreezingInTheStateFunctionFormFollowNeumannWithConservedMass)
{
	const MixtureProperties m     = withoutExpansion();
	const double            solid = (1.0 - porosity) * m.solid.density * m.solid.specificHeat;
	struct Case {
		const char* name;
		double      surface, initial, waterPerVolume;
	};
	for (const Case& c : { Case { "thaw -5/+10", 10.0, -5.0, porosity * m.ice.density }, Case { "freezing +5/-5", -5.0, 5.0, porosity * m.liquid.density } }) {
		FrontScene s { std::string("V02 ") + c.name + ", wall, sharp, state function", c.surface, c.initial, sharpCurve() };
		s.form  = EnthalpyForm::stateFunction;
		s.depth = 2.0;
		// with sharp ice fills the pores up to a thousandth of the water mass, see EnthalpyModel::residualWaterFraction
		const double ice = std::min(porosity * m.ice.density, (1.0 - EnthalpyModel::residualWaterFraction) * c.waterPerVolume);
		const double liquid = c.waterPerVolume - ice;
		const reference::Conductor thawed { phase(m, 1.0).conductivity, solid + c.waterPerVolume * m.liquid.specificHeat };
		const reference::Conductor frozen { phase(m, 0.0).conductivity, solid + ice * m.ice.specificHeat + liquid * m.liquid.specificHeat };
		const bool thaws = c.surface > c.initial;
		const double front = reference::neumannFront(thaws ? thawed : frozen, thaws ? frozen : thawed, c.surface, c.initial, 0.0, ice * m.latentHeat);
		expectFront(s, front, 10.0, thaws ? 1e-2 : 0.4, !thaws);
	}
}

TEST(MovingFront, SmoothFreezingCurvesFollowTheSimilaritySolution)
{
	struct Case {
		const char* name;
		double      surface, initial;
		CurveParameters parameters;
	};
	for (const Case& c : { Case { "gauss", 10.0, -5.0, {} }, Case { "gauss", -5.0, 5.0, {} }, Case { "exponential", 10.0, -5.0, { { "width", 0.3 } } } }) {
		FrontScene s { std::string("similarity ") + (c.surface > 0 ? "thaw" : "freezing") + ", " + c.name, c.surface, c.initial, makeFreezingCurve(c.name, c.parameters) };
		s.depth                    = 2.5;
		const MixtureProperties& m = s.mixture;
		const auto curve = s.curve;
		const auto kappa = [m, curve](double t) { return m.conductivity(VolumeFractions::of(porosity, curve->liquidSaturation(t))); };
		const auto capacity = [m, curve](double t) {
			return m.heatCapacity(VolumeFractions::of(porosity, curve->liquidSaturation(t)))
			        + porosity * m.ice.density * m.latentHeat * curve->derivative(t);
		};
		const reference::SimilarityFront exact(kappa, capacity, c.surface, c.initial, 8e-3);
		const double ice = exact.integralOf([curve](double t) { return curve->liquidSaturation(t); });
		const double range = curve->liquidSaturation(c.surface) - curve->liquidSaturation(c.initial);
		const bool thaws = c.surface > c.initial;
		expectFront(s, ice / range, 10.0, thaws ? 1e-2 : 0.4, !thaws);
	}
}

TEST(MovingFront, ThawFromAFreeSurfaceBetweenNodesFollowsNeumannWithinFourTenthsOfASpacing)
{
	for (const double offset : { 0.0, 0.25, 0.5, 0.75 }) {
		FrontScene s { "V02 thaw -5/+10, free surface " + std::to_string(offset).substr(0, 4) + " h above a node", 10.0, -5.0, sharpCurve() };
		s.wall   = Wall::freeSurface;
		s.offset = offset;
		expectFront(s, neumann(s), 10.0, 0.4, true);
	}
}

TEST(MovingFront, FreezingFromAFreeSurfaceBetweenNodesFollowsNeumannWithinHalfASpacing)
{
	for (const double offset : { 0.0, 0.25, 0.5, 0.75 }) {
		FrontScene s { "V02 freezing +5/-5, free surface " + std::to_string(offset).substr(0, 4) + " h above a node", -5.0, 5.0, sharpCurve() };
		s.wall   = Wall::freeSurface;
		s.offset = offset;
		s.depth  = 2.0;
		expectFront(s, neumann(s), 10.0, 0.5, true);
	}
}

// InterFrost T1 (Lunardini): latent heat released evenly over an interval; exact where all phases conduct and store alike
TEST(MovingFront, LunardiniThreeZonesWithEqualPhasesIsMet)
{
	FrontScene s { "Lunardini, +4 surface -6 (T_m = -4)", -6.0, 4.0, makeFreezingCurve("linear", { { "frozenTemperature", -4.0 }, { "residualSaturation", 0.0 } }) };
	s.mixture.ice.conductivity   = s.mixture.liquid.conductivity;
	s.mixture.ice.specificHeat   = 4200.0;
	s.mixture.ice.density        = 1000.0;
	s.depth                      = 2.0;
	s.spacing                    = 0.025;
	const auto   ground          = phase(s.mixture, 1.0);
	const double latent          = porosity * 1000.0 * s.mixture.latentHeat;
	const auto   exact           = reference::Lunardini::solve(ground, latent, -6.0, -4.0, 0.0, 4.0);
	const reference::SimilarityFront similarity(
	        [&](double) { return ground.conductivity; },
	        [&](double t) { return ground.capacity + (t > -4.0 && t < 0.0 ? latent / 4.0 : 0.0); },
	        -6.0,
	        4.0,
	        8e-3,
	        80000);
	expectSmall("Lunardini closed form against similarity integration, T at the near front [K]", similarity.temperature(exact.nearFront) + 4.0, 5e-3);
	expectSmall("Lunardini closed form against similarity integration, T at the far front [K]", similarity.temperature(exact.farFront), 5e-3);
	const auto   curve  = s.curve;
	const double frozen = -similarity.integralOf([curve](double t) { return curve->liquidSaturation(t); });
	expectFront(s, frozen, 5.0, 0.4, true);
}

TEST(MovingFront, InterFrostT1SoilFollowsTheSimilaritySolution)
{
	// phase properties quoted for InterFrost: lambda 9/0.6/2.14, c 835/4182/2060, rho 2650/1000/920, S_r 0.05; porosity as above
	FrontScene s { "InterFrost soil, +4 surface -6, interval -1..0", -6.0, 4.0, makeFreezingCurve("linear", { { "frozenTemperature", -1.0 } }) };
	s.mixture.solid  = { 2650.0, 835.0, 9.0, 0.0 };
	s.mixture.liquid = { 1000.0, 4182.0, 0.6, 0.0 };
	s.mixture.ice    = { 920.0, 2060.0, 2.14, 0.0 };
	s.depth          = 4.0;
	const auto m = s.mixture;
	const auto curve = s.curve;
	const reference::SimilarityFront exact(
	        [=](double t) { return m.conductivity(VolumeFractions::of(porosity, curve->liquidSaturation(t))); },
	        [=](double t) {
		        return m.heatCapacity(VolumeFractions::of(porosity, curve->liquidSaturation(t)))
		                + porosity * m.ice.density * m.latentHeat * curve->derivative(t);
	        },
	        -6.0,
	        4.0,
	        1.6e-2,
	        40000);
	const double frozen = -exact.integralOf([curve](double t) { return curve->liquidSaturation(t); }) / 0.95;
	expectFront(s, frozen, 5.0, 0.4, true);
}
