// SPDX-License-Identifier: GPL-2.0-or-later
// Thawing and freezing fronts in rigid ground: Neumann, Lunardini and similarity solutions.
#include "References.hpp"
#include "Report.hpp"
#include "Scenes.hpp"

#include <gtest/gtest.h>

#include <sstream>

using namespace talik;
using namespace talik::validation;

namespace {

constexpr double day = 86400.0, porosity = 0.4;

enum class HeatOfWall { onNodes, freeSurface };

struct FrontScene {
	std::string       name;
	double            surface, initial;
	FreezingCurvePtr  curve;
	HeatOfWall        wall         = HeatOfWall::onNodes;
	double            spacing      = 0.05;
	double            offset       = 0.0; ///< of the free surface above a node [h]
	double            depth        = 1.5; ///< of the ground [m]
	MixtureProperties mixture      = withoutExpansion();
	std::string       shape        = "quadraticBSpline";
	double            heatFraction = 0.9;
};

FreezingCurvePtr sharpCurve() { return makeFreezingCurve("sharp", { { "residualSaturation", 0.0 } }); }

struct FrontResult {
	std::vector<double> front;              ///< volume per area whose water has changed phase, at each instant [m]
	double              closure;            ///< (gain of heat - logged heat)/logged heat
	std::vector<double> depth, temperature; ///< of the points at the end [m, degC]
};

FrontResult marchFront(const FrontScene& scene, const std::vector<double>& instants)
{
	const double h   = scene.spacing;
	const double top = scene.depth + scene.offset * h;
	auto         s   = columnSettings(h, std::ceil(top / h - 1e-9) * h + (scene.wall == HeatOfWall::freeSurface ? 2 * h : 0.0));
	s.mixture        = scene.mixture;
	s.shapeFunction  = scene.shape;
	s.heatFraction   = scene.heatFraction;
	s.heat.emplace();
	s.freezing = scene.curve;
	if (scene.wall == HeatOfWall::onNodes) addBoundary<WallTemperature<2>>(s, Region<2>::side("bottom"), scene.surface);
	else addBoundary<SurfaceTemperature<2>>(s, Region<2>::freeSurface().within({ -1.0, 0.5 * top }, { 1.0, 2.0 * top }), scene.surface);
	Ground<2> ground(s);
	fillBox(ground, { 0.0, top - scene.depth }, { h, top }, [&](PointInput<2>& p) {
		p.temperature = scene.initial;
		p.porosity    = porosity;
	});
	ground.initialise();
	const double heatBefore = ground.balance().enthalpy;
	const double farIce = 1.0 - scene.curve->liquidSaturation(scene.initial), nearIce = 1.0 - scene.curve->liquidSaturation(scene.surface);
	FrontResult  result;
	for (const double instant : instants) {
		marchTo(ground, instant);
		const auto after = valuesOf(ground, "iceSaturation"), volume = valuesOf(ground, "volume");
		double     changed = 0.0;
		for (std::size_t p = 0; p < after.size(); ++p)
			changed += (after[p] - farIce) / (nearIce - farIce) * volume[p];
		result.front.push_back(changed / h);
	}
	const auto balance = ground.balance();
	result.closure     = (balance.enthalpy - heatBefore - balance.heatIn) / std::abs(balance.heatIn);
	result.temperature = valuesOf(ground, "temperature");
	for (const double y : valuesOf(ground, "position", 1))
		result.depth.push_back(scene.wall == HeatOfWall::onNodes ? y : top - y);
	return result;
}

reference::Conductor phase(const MixtureProperties& m, double liquidSaturation)
{
	const auto n = VolumeFractions::of(porosity, liquidSaturation);
	return { m.conductivity(n), m.heatCapacity(n) };
}

/// Water per volume of ground, which stays as it is at the start, and its ice where ice takes the place of that part of full pores.
struct Water {
	double mass, ice; ///< [kg/m^3]

	Water(const MixtureProperties& m, double liquidAtStart, double liquid)
	        : mass(porosity * (liquidAtStart * m.liquid.density + (1.0 - liquidAtStart) * m.ice.density))
	        , ice(std::min(porosity * (1.0 - liquid) * m.ice.density, (1.0 - EnthalpyModel::residualWaterFraction) * mass))
	{}
	double heatCapacity(const MixtureProperties& m) const
	{
		return (1.0 - porosity) * m.solid.density * m.solid.specificHeat + ice * m.ice.specificHeat + (mass - ice) * m.liquid.specificHeat;
	}
};

/// Neumann's solution.
double neumann(const FrontScene& scene)
{
	const MixtureProperties& m     = scene.mixture;
	const bool               thaws = scene.surface > scene.initial;
	const Water              asIce(m, thaws ? 0.0 : 1.0, 0.0), asLiquid(m, thaws ? 0.0 : 1.0, 1.0);
	const auto               thawed = reference::Conductor { phase(m, 1.0).conductivity, asLiquid.heatCapacity(m) };
	const auto               frozen = reference::Conductor { phase(m, 0.0).conductivity, asIce.heatCapacity(m) };
	return reference::neumannFront(thaws ? thawed : frozen, thaws ? frozen : thawed, scene.surface, scene.initial, 0.0, asIce.ice * m.latentHeat);
}

/// Heat that the ground takes per degree, that of melting included [J/(m^3 K)].
double apparentCapacity(const MixtureProperties& m, const FreezingCurve& curve, double liquidAtStart, double t)
{
	const Water  water(m, liquidAtStart, curve.liquidSaturation(t));
	const double perMass = m.latentHeat + (m.liquid.specificHeat - m.ice.specificHeat) * t;
	return water.heatCapacity(m) + porosity * m.ice.density * perMass * curve.derivative(t);
}

/// Depth where the ground has changed phase over sqrt(t), by the similarity solution for the scene's own curve.
reference::SimilarityFront similarity(const FrontScene& scene, double etaEnd = 8e-3, int steps = 20000)
{
	const MixtureProperties m      = scene.mixture;
	const auto              curve  = scene.curve;
	const double            before = curve->liquidSaturation(scene.initial);
	return { [=](double t) { return m.conductivity(VolumeFractions::of(porosity, curve->liquidSaturation(t))); },
		 [=](double t) { return apparentCapacity(m, *curve, before, t); },
		 scene.surface,
		 scene.initial,
		 etaEnd,
		 steps };
}

double frontOf(const reference::SimilarityFront& exact, const FrontScene& scene)
{
	const auto   curve = scene.curve;
	const double range = curve->liquidSaturation(scene.surface) - curve->liquidSaturation(scene.initial);
	return exact.integralOf([curve](double t) { return curve->liquidSaturation(t); }) / range;
}

double exactFront(const FrontScene& scene) { return scene.curve->isSharp() ? neumann(scene) : frontOf(similarity(scene), scene); }

std::vector<double> tenInstants(double days)
{
	std::vector<double> instants;
	for (int k = 1; k <= 10; ++k)
		instants.push_back(0.1 * k * days * day);
	return instants;
}

FrontResult expectFront(const FrontScene& scene, double perRootTime, double days, double tolerance, bool inSpacings)
{
	const double exact  = perRootTime * std::sqrt(days * day);
	const auto   result = marchFront(scene, tenInstants(days));
	char         label[48];
	std::snprintf(label, sizeof label, ", front [m], h = X/%.1f%s", exact / scene.spacing, inSpacings ? ", error in h" : "");
	if (inSpacings) expectScaled(scene.name + label, result.front.back(), exact, scene.spacing, tolerance);
	else expectRelative(scene.name + label, result.front.back(), exact, tolerance);
	expectSmall(scene.name + ", heat closure", result.closure, 1e-12);
	return result;
}

void drawFront(Drawing& drawing, const std::string& series, const FrontResult& result, double perRootTime, double days)
{
	const auto instants = tenInstants(days);
	for (std::size_t k = 0; k < instants.size(); ++k)
		drawing.computed(series, instants[k] / day, result.front[k]);
	drawing.reference(series, 0.0, days, [=](double d) { return perRootTime * std::sqrt(d * day); });
}

void drawProfile(Drawing& drawing, const std::string& series, const FrontResult& result, const reference::SimilarityFront& exact, double days, double deepest)
{
	for (std::size_t p = 0; p < result.depth.size(); ++p)
		if (result.depth[p] < deepest) drawing.computed(series, result.depth[p], result.temperature[p]);
	drawing.reference(series, 0.0, deepest, [&](double x) { return exact.temperature(x / std::sqrt(days * day)); });
}

constexpr const char* neumannSource    = "Carslaw & Jaeger 1959 (Neumann)";
constexpr const char* similaritySource = "similarity solution, Runge-Kutta";

} // namespace

TEST(MovingFront, NeumannReferenceGivesThePublishedFrontOfThePapersSoil)
{
	citing("published value");
	// with the capacities of eq. (4): pores are full of ice, then of water
	const MixtureProperties m      = withoutExpansion();
	const auto              thawed = phase(m, 1.0), frozen = phase(m, 0.0);
	const double            latent = porosity * m.ice.density * m.latentHeat;
	expectRelative("V02 reference: thaw -5/+10, X/sqrt(t) [m/s^0.5]", reference::neumannFront(thawed, frozen, 10.0, -5.0, 0.0, latent), 3.154424e-4, 1e-6);
	expectRelative(
	        "V02 reference: freezing +5/-5, X after 1 d [m]", reference::neumannFront(frozen, thawed, -5.0, 5.0, 0.0, latent) * std::sqrt(day), 0.08816,
	        1e-4);
}

namespace {

/// One corner of V02: which way, from what boundary, which curve.
FrontScene cornerOfV02(bool thaws, HeatOfWall wall, bool sharp)
{
	FrontScene s { std::string("V02 ") + (thaws ? "thaw -5/+10, " : "freezing +5/-5, ") + (wall == HeatOfWall::onNodes ? "wall: " : "free surface: ")
		               + (sharp ? "sharp" : "smooth"),
		       thaws ? 10.0 : -5.0, thaws ? -5.0 : 5.0, sharp ? sharpCurve() : makeFreezingCurve("gauss", {}) };
	s.wall   = wall;
	s.offset = wall == HeatOfWall::onNodes ? 0.0 : 0.5;
	s.depth  = sharp ? 2.0 : 2.5;
	return s;
}

} // namespace

// At a wall a front that thaws is held to 1 %. One that freezes lags by up to a sixth of a spacing: points around it are partly
// frozen, and heat on its way out passes those that conduct like the ground ahead; when ground thaws the effect is the opposite
// and smaller. At a free surface a resistance of a quarter of a cell stands for the distance between surface and nodes, which is
// not the same for every place of the surface in its cell. Both are lengths, so they fall with h.
TEST(MovingFront, ThawAndFreezingFollowNeumannForBothKindsOfCurveAndBothBoundaries)
{
	citing(neumannSource);
	Drawing drawing("neumann_front", "V02 front, wall, h = 0.05 m", "time [d]", "front depth [m]");
	for (const bool sharp : { true, false })
		for (const bool thaws : { true, false })
			for (const auto wall : { HeatOfWall::onNodes, HeatOfWall::freeSurface }) {
				citing(sharp ? neumannSource : similaritySource);
				const FrontScene s          = cornerOfV02(thaws, wall, sharp);
				const bool       inSpacings = !thaws || wall == HeatOfWall::freeSurface;
				const double     tolerance  = !inSpacings ? 1e-2 : wall == HeatOfWall::onNodes ? 0.25 : 0.4;
				const double     exact      = exactFront(s);
				const auto       result     = expectFront(s, exact, 10.0, tolerance, inSpacings);
				if (wall == HeatOfWall::onNodes)
					drawFront(drawing, std::string(thaws ? "thaw, " : "freezing, ") + (sharp ? "sharp" : "gauss"), result, exact, 10.0);
			}
}

// The lag of a front that freezes is a length: 1 % is reached at h = X/17.
TEST(MovingFront, ErrorOfTheFrontFallsWithTheGridSpacing)
{
	citing(neumannSource);
	for (const double h : { 0.1, 0.05, 0.025 }) {
		FrontScene s { "V02 thaw -5/+10, wall: sharp", 10.0, -5.0, sharpCurve() };
		s.spacing = h;
		expectFront(s, neumann(s), 10.0, 1e-2, false);
	}
	for (const double h : { 0.1, 0.05, 0.025 }) {
		FrontScene s { "V02 freezing +5/-5, wall: sharp", -5.0, 5.0, sharpCurve() };
		s.spacing = h;
		s.depth   = 2.0;
		expectFront(s, neumann(s), 10.0, 0.25, true);
	}
}

// Until the front has crossed the first cell the ice depends on the cell. It must not depend on the step.
TEST(MovingFront, IceBehindAColdWallDoesNotFollowTheTimeStep)
{
	citing(neumannSource);
	const std::vector<double> days { 0.2, 1.0, 5.0, 20.0 };
	for (const double h : { 0.1, 0.05 }) {
		double least[4] = { HUGE_VAL, HUGE_VAL, HUGE_VAL, HUGE_VAL }, most[4] = {};
		for (const double fraction : { 0.5, 0.1, 0.01 }) {
			FrontScene s { "V02 freezing +0/-2", -2.0, 0.001, sharpCurve() };
			s.spacing        = h;
			s.depth          = 1.0;
			s.heatFraction   = fraction;
			const auto front = marchFront(s, { days[0] * day, days[1] * day, days[2] * day, days[3] * day }).front;
			for (int k = 0; k < 4; ++k) {
				const double over = front[k] / (neumann(s) * std::sqrt(days[k] * day));
				least[k]          = std::min(least[k], over);
				most[k]           = std::max(most[k], over);
			}
		}
		for (int k = 0; k < 4; ++k) {
			std::ostringstream name;
			name << "V02 freezing +0/-2, wall: three time steps, h = " << h << " m, day " << days[k] << ", ";
			expectSmall(name.str() + "largest ice over smallest less 1", most[k] / least[k] - 1.0, k < 2 ? 0.6 : 0.05);
			if (k == 0) continue;
			const double farthest = std::max(most[k] - 1.0, 1.0 - least[k]);
			expectSmall(name.str() + "largest error of the front over Neumann's", farthest, k == 1 ? 0.4 : 0.05);
		}
	}
}

// What passes in a step is f dt: a calendar that slows down and hastens by a thousand on the way ends in the same state
TEST(MovingFront, AScaleOfTheCalendarThatChangesAThousandfoldOnTheWayLeavesTheFrontWhereItIs)
{
	citing(neumannSource);
	const double days = 10.0;
	for (const bool sharp : { true, false })
		for (const bool thaws : { true, false }) {
			FrontScene   s     = cornerOfV02(thaws, HeatOfWall::onNodes, sharp);
			const double exact = exactFront(s) * std::sqrt(days * day);
			const auto   front = [&](bool changes) {
                                auto settings    = columnSettings(s.spacing, s.depth);
                                settings.mixture = s.mixture;
                                settings.heat.emplace();
                                settings.heat->thermalTimeScale = 1000.0;
                                settings.freezing               = s.curve;
                                addBoundary<WallTemperature<2>>(settings, Region<2>::side("bottom"), s.surface);
                                Ground<2> ground(settings);
                                fillBox(ground, { 0.0, 0.0 }, { s.spacing, s.depth }, [&](PointInput<2>& p) {
                                        p.temperature = s.initial;
                                        p.porosity    = porosity;
                                });
                                ground.initialise();
                                const double dt = ground.stableTimeStep().step;
                                for (long k = 0; ground.calendar().time < days * day; ++k) {
                                        double& scale = ground.settings().heat->thermalTimeScale;
                                        scale         = changes ? std::pow(10.0, 1.5 + 1.5 * std::cos(0.01 * k)) : 1000.0;
                                        scale         = std::min(scale, (days * day - ground.calendar().time) / dt * (1.0 + 1e-12));
                                        ground.step(dt);
                                }
                                const double farIce = 1.0 - s.curve->liquidSaturation(s.initial), nearIce = 1.0 - s.curve->liquidSaturation(s.surface);
                                const auto   after = valuesOf(ground, "iceSaturation"), volume = valuesOf(ground, "volume");
                                double       changed = 0.0;
                                for (std::size_t p = 0; p < after.size(); ++p)
                                        changed += (after[p] - farIce) / (nearIce - farIce) * volume[p];
                                return changed / s.spacing;
			};
			const double      constant = front(false), changing = front(true);
			const std::string name = s.name + ", scale of the calendar 1 to 1000";
			if (thaws) expectRelative(name + ": front [m]", changing, exact, 1e-2);
			else expectScaled(name + ": front [m], error in h", changing, exact, s.spacing, 0.25);
			expectScaled(name + ": front less that of a constant scale [m], in h", changing, constant, s.spacing, 0.02);
		}
}

// 1.2 % at h = X/6 when ground thaws, where B-splines have 0.5 %: held to a length, as what freezes
TEST(MovingFront, ThawAndFreezingWithGimpFollowNeumannWithinATenthOfASpacing)
{
	citing(neumannSource);
	for (const bool thaws : { true, false }) {
		FrontScene s = cornerOfV02(thaws, HeatOfWall::onNodes, true);
		s.name       = std::string("V02 ") + (thaws ? "thaw -5/+10" : "freezing +5/-5") + ", wall, gimp: sharp";
		s.shape      = "gimp";
		expectFront(s, neumann(s), 10.0, 0.1, true);
	}
}

TEST(MovingFront, ExponentialFreezingCurveFollowsTheSimilaritySolution)
{
	citing(similaritySource);
	FrontScene s { "V02 thaw -5/+10, wall: exponential", 10.0, -5.0, makeFreezingCurve("exponential", { { "width", 0.3 } }) };
	s.depth = 2.5;
	expectFront(s, exactFront(s), 10.0, 1e-2, false);
}

TEST(MovingFront, TemperatureProfileBehindAndAheadOfASmoothFrontFollowsTheSimilaritySolution)
{
	citing(similaritySource);
	const double days = 10.0;
	Drawing      drawing("front_profile", "V02 temperature after 10 d, gauss curve, h = 0.05 m", "depth [m]", "temperature [degC]");
	for (const bool thaws : { true, false }) {
		const FrontScene s      = cornerOfV02(thaws, HeatOfWall::onNodes, false);
		const auto       exact  = similarity(s);
		const auto       result = marchFront(s, { days * day });
		drawProfile(drawing, thaws ? "thaw" : "freezing", result, exact, days, 1.0);
		double sum = 0.0;
		for (std::size_t p = 0; p < result.depth.size(); ++p)
			sum += std::pow(result.temperature[p] - exact.temperature(result.depth[p] / std::sqrt(days * day)), 2) / result.depth.size();
		expectSmall(
		        std::string("V02 temperature profile: ") + (thaws ? "thaw" : "freezing") + ", rms temperature error over the jump",
		        std::sqrt(sum) / std::abs(s.surface - s.initial), 1e-2);
	}
}

TEST(MovingFront, ThawFromAFreeSurfaceBetweenNodesFollowsNeumannWithinFourTenthsOfASpacing)
{
	citing(neumannSource);
	for (const double offset : { 0.0, 0.25, 0.5, 0.75 }) {
		FrontScene s { "V02 thaw -5/+10, free surface: " + std::to_string(offset).substr(0, 4) + " h above a node", 10.0, -5.0, sharpCurve() };
		s.wall   = HeatOfWall::freeSurface;
		s.offset = offset;
		expectFront(s, neumann(s), 10.0, 0.4, true);
	}
}

TEST(MovingFront, FreezingFromAFreeSurfaceBetweenNodesFollowsNeumannWithinFourTenthsOfASpacing)
{
	citing(neumannSource);
	for (const double offset : { 0.0, 0.25, 0.5, 0.75 }) {
		FrontScene s { "V02 freezing +5/-5, free surface: " + std::to_string(offset).substr(0, 4) + " h above a node", -5.0, 5.0, sharpCurve() };
		s.wall   = HeatOfWall::freeSurface;
		s.offset = offset;
		s.depth  = 2.0;
		expectFront(s, neumann(s), 10.0, 0.4, true);
	}
}

// InterFrost T1 (Lunardini): latent heat released evenly over an interval; exact where all phases conduct and store alike
TEST(MovingFront, LunardiniThreeZonesWithEqualPhasesIsMet)
{
	citing("Lunardini 1985, three zones");
	FrontScene s { "Lunardini, three zones: +4 surface -6", -6.0, 4.0,
		       makeFreezingCurve("linear", { { "frozenTemperature", -4.0 }, { "residualSaturation", 0.0 } }) };
	s.mixture.ice.conductivity              = s.mixture.liquid.conductivity;
	s.mixture.ice.specificHeat              = 4200.0;
	s.mixture.ice.density                   = 1000.0;
	s.depth                                 = 2.0;
	s.spacing                               = 0.025;
	const auto                       ground = phase(s.mixture, 1.0);
	const double                     latent = porosity * 1000.0 * s.mixture.latentHeat;
	const auto                       exact  = reference::Lunardini::solve(ground, latent, -6.0, -4.0, 0.0, 4.0);
	const reference::SimilarityFront integrated(
	        [&](double) { return ground.conductivity; }, [&](double t) { return ground.capacity + (t > -4.0 && t < 0.0 ? latent / 4.0 : 0.0); }, -6.0, 4.0,
	        8e-3, 80000);
	expectSmall("Lunardini, three zones: reference against Runge-Kutta, T at the near front [K]", integrated.temperature(exact.nearFront) + 4.0, 5e-3);
	expectSmall("Lunardini, three zones: reference against Runge-Kutta, T at the far front [K]", integrated.temperature(exact.farFront), 5e-3);
	const auto result = expectFront(s, frontOf(integrated, s), 5.0, 0.1, true);
	// where the temperatures of both fronts lie, by interpolation between points
	const auto depthOf = [&](double t) {
		for (std::size_t p = 1; p < result.depth.size(); ++p)
			if (result.temperature[p] >= t && result.depth[p] > result.depth[p - 1])
				return result.depth[p - 1]
				        + (t - result.temperature[p - 1]) / (result.temperature[p] - result.temperature[p - 1])
				        * (result.depth[p] - result.depth[p - 1]);
		return result.depth.back();
	};
	const double root = std::sqrt(5.0 * day);
	expectScaled("Lunardini, three zones: depth of -4 degC [m], error in h", depthOf(-4.0), exact.nearFront * root, s.spacing, 0.25);
	expectScaled("Lunardini, three zones: depth of 0 degC [m], error in h", depthOf(0.0), exact.farFront * root, s.spacing, 0.25);
	Drawing drawing("lunardini", "Lunardini's three zones after 5 d, h = 0.025 m", "depth [m]", "temperature [degC]");
	drawProfile(drawing, "T", result, integrated, 5.0, 0.8);
	drawing.reference("fronts", exact.nearFront * root, -4.0);
	drawing.reference("fronts", exact.farFront * root, 0.0);
}

TEST(MovingFront, InterFrostT1SoilFollowsTheSimilaritySolution)
{
	// phase properties quoted for InterFrost: lambda 9/0.6/2.14, c 835/4182/2060, rho 2650/1000/920, S_r 0.05; porosity as above
	FrontScene s { "InterFrost T1 soil: +4 surface -6, interval -1..0", -6.0, 4.0, makeFreezingCurve("linear", { { "frozenTemperature", -1.0 } }) };
	s.mixture.solid  = { 2650.0, 835.0, 9.0, 0.0 };
	s.mixture.liquid = { 1000.0, 4182.0, 0.6, 0.0 };
	s.mixture.ice    = { 920.0, 2060.0, 2.14, 0.0 };
	s.depth          = 4.0;
	citing(similaritySource);
	const auto exact  = similarity(s, 1.6e-2, 40000);
	const auto result = expectFront(s, frontOf(exact, s), 5.0, 0.1, true);
	Drawing    drawing("interfrost_t1", "InterFrost soil, freezing interval -1..0 degC, after 5 d", "depth [m]", "temperature [degC]");
	drawProfile(drawing, "T", result, exact, 5.0, 2.0);
}

namespace {

/// A sink on the axis draws heat from the ground, which freezes in a cylinder. Pores with water of its own stay as they are, and give the
/// water to the side for which their ice has no room.
enum class SinkWater { kept, explicitPressure, implicitPressure };

void freezeAroundALineSink(SinkWater kind, double h, double radius, const std::string& name)
{
	const double power = -1.6e3 * 0.01 / (radius * radius), initial = 2.0, perRadian = -0.5 * power * radius * radius;
	auto         s = columnSettings(h, h);
	s.axisymmetric = true;
	s.upper        = { 4.0, h };
	s.heat.emplace();
	s.freezing = sharpCurve();
	addBoundary<HeatSource<2>>(s, Region<2>::nodeBox({ -1.0, -1.0 }, { radius, 1.0 }), power);
	const bool seeps = kind != SinkWater::kept;
	if (seeps) {
		s.motion.emplace();
		s.skeletons                                 = { elasticOedometer(1e9) };
		s.water.emplace().implicit                  = kind == SinkWater::implicitPressure;
		s.water->permeability.referenceConductivity = s.water->implicit ? 1e-7 : 1e-8;
		s.heat->thermalTimeScale                    = s.water->implicit ? 4e6 : 2e6;
		if (!s.water->implicit) {
			s.water->state.liquidBulkModulus = s.water->state.iceBulkModulus = 2.2e7;
			s.water->state.cavitationPressure                                = -1e6; // soft water swings, and would leave gaps
		}
		for (const char* side : { "right", "bottom", "top" })
			addBoundary<RollerBoundary<2>>(s, Region<2>::side(side));
		addBoundary<DrainedBoundary<2>>(s, Region<2>::side("right"), 0.0);
	}
	Ground<2> ground(s);
	fillBox(
	        ground, s.lower, s.upper,
	        [&](PointInput<2>& p) {
		        p.temperature = initial;
		        p.porosity    = porosity;
	        },
	        1);
	ground.initialise();
	const double waterBefore = ground.balance().waterMass;

	const Water  ice(s.mixture, 1.0, 0.0), liquid(s.mixture, 1.0, 1.0);
	const double ofFrozen = seeps ? ice.heatCapacity(s.mixture) - (ice.mass - ice.ice) * s.mixture.liquid.specificHeat : ice.heatCapacity(s.mixture);
	const double frozen = phase(s.mixture, 0.0).conductivity / ofFrozen, conductivity = phase(s.mixture, 1.0).conductivity;
	const double ratio = frozen * liquid.heatCapacity(s.mixture) / conductivity, latent = ice.ice * s.mixture.latentHeat;
	const auto   excess = [&](double square) { // of the sink over what freezing and the ground beyond give, by the square of X^2 = 4 square frozen t
                const double given = conductivity * initial * std::exp(-square * ratio) / -std::expint(-square * ratio);
                return 0.5 * perRadian * std::exp(-square) - given - square * frozen * latent;
	};
	double low = 1e-6, high = 1.0;
	while (high - low > 1e-12)
		(excess(0.5 * (low + high)) > 0.0 ? low : high) = 0.5 * (low + high);
	double largest = 0.0;
	for (const double days : { 15.0, 20.0, 25.0, 30.0 }) {
		if (seeps && days < 20.0) continue; // the frozen ground hardly reaches beyond the sink
		marchTo(ground, days * day / s.heat->thermalTimeScale);
		const auto saturation = valuesOf(ground, "iceSaturation"), volume = valuesOf(ground, "volume"), r = valuesOf(ground, "position");
		double     sum = 0.0;
		for (std::size_t p = 0; p < volume.size(); ++p)
			sum += saturation[p] * volume[p] * r[p];
		const double exact = std::sqrt(4.0 * low * frozen * days * day);
		largest            = std::max(largest, std::abs(std::sqrt(2.0 * sum / h) / exact - 1.0));
		if (days == 30.0) expectRelative(name + ": radius of the frozen cylinder after 30 days", std::sqrt(2.0 * sum / h), exact, 1e-2);
	}
	expectSmall(name + (seeps ? ": largest error of the radius from 20 days on" : ": largest error of the radius from 15 days on"), largest, 1e-2);
	if (!seeps) return;
	const auto   after    = ground.balance();
	const double expelled = after.iceMass * (s.mixture.liquid.density / s.mixture.ice.density - 1.0);
	expectSmall(name + ": water of the ground and what has left, over that of the start", (after.waterMass + after.waterOut) / waterBefore - 1.0, 1e-12);
	expectRelative(
	        name + ": water that has left, of that for which ice has no room", after.waterOut, expelled, kind == SinkWater::implicitPressure ? 1e-2 : 5e-2);
}

} // namespace

TEST(MovingFront, GroundAroundALineSinkFreezesAsInTheSolutionOfCarslawAndJaeger)
{
	citing("Carslaw & Jaeger 1959, 11.6 (III)");
	freezeAroundALineSink(SinkWater::kept, 0.025, 0.1, "line sink");
	freezeAroundALineSink(SinkWater::explicitPressure, 0.1, 0.2, "line sink, water expelled");
	freezeAroundALineSink(SinkWater::implicitPressure, 0.1, 0.2, "line sink, water expelled, implicit pressure");
}
