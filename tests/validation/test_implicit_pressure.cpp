// SPDX-License-Identifier: GPL-2.0-or-later
// Implicit pore pressure, with water as stiff as it is: Terzaghi, Skempton, tight ground, water that freezes in a sealed box.
#include "References.hpp"
#include "Report.hpp"
#include "Scenes.hpp"

#include <pkg/mpm/effects/RigidContact.hpp>

#include <gtest/gtest.h>
#include <omp.h>

#include <algorithm>
#include <numeric>
#include <random>

using namespace talik;
using namespace talik::validation;

namespace {

constexpr double porosity = 0.4, oedometer = 1e7, load = 1e4;

template <int D> void addStiffWater(GroundSettings<D>& s, double conductivity, double bulkModulus)
{
	s.water.emplace();
	s.water->implicit                           = true;
	s.water->state.liquidBulkModulus            = bulkModulus;
	s.water->state.iceBulkModulus               = 4.0 * bulkModulus;
	s.water->state.cavitationPressure           = -0.01 * bulkModulus; // the closed forms are linear
	s.water->permeability.referenceConductivity = conductivity;
}

GroundSettings<2> loadedColumn(double conductivity, double bulkModulus, int cells, bool drained = true)
{
	const double h = 1.0 / cells;
	auto         s = columnSettings(h, 1.0 + 2 * h);
	standOnRollers(s);
	s.motion.emplace();
	s.motion->localDamping = 0.3;
	addStiffWater(s, conductivity, bulkModulus);
	s.skeletons.push_back(elasticOedometer(oedometer));
	if (drained) addBoundary<DrainedBoundary<2>>(s, Region<2>::freeSurface());
	addBoundary<Traction<2>>(s, Region<2>::freeSurface(), load);
	return s;
}

/// Points moved at random by up to this part of their spacing, but for those above a height.
Ground<2> started(const GroundSettings<2>& s, const Vec<2>& size, double moved = 0.0, double upTo = 1e300)
{
	Ground<2>                              ground(s);
	std::mt19937                           random(1);
	std::uniform_real_distribution<double> by(-moved, moved);
	fillBox(ground, { 0.0, 0.0 }, size, [&](PointInput<2>& p) {
		p.porosity = porosity;
		for (double& x : p.position)
			x += (p.position[1] < upTo ? by(random) : 0.0) * 0.5 * s.gridSpacing;
	});
	ground.initialise();
	return ground;
}

void expectTerzaghi(double conductivity, double bulkModulus, const std::vector<double>& factors, double tolerance, double moved = 0.0)
{
	citing("Terzaghi, compressible water");
	constexpr int             cells = 20;
	const reference::Terzaghi exact { 1.0, load, oedometer, porosity / bulkModulus, conductivity / 9810.0 };
	const auto                s = loadedColumn(conductivity, bulkModulus, cells);
	// not where nodes of the surface see them: the load acts on the area that points give
	Ground<2> ground = started(s, { s.gridSpacing, 1.0 }, moved, 1.0 - 3.0 * s.gridSpacing);
	char      name[120];
	std::snprintf(
	        name, sizeof name, "implicit pressure, Terzaghi, k = %.0e, K_w = %.1e%s: ", conductivity, bulkModulus, moved > 0.0 ? ", points moved" : "");
	for (const double factor : factors) {
		const double t = exact.timeAt(factor);
		marchTo(ground, t);
		const auto          found = cellPressures(ground, cells);
		std::vector<double> off(cells);
		double              square = 0.0, alternates = 0.0;
		for (int k = 0; k < cells; ++k) {
			off[k] = (found[k] - exact.pressure((k + 0.5) / cells, t)) / load;
			square += off[k] * off[k] / cells;
			if (k > 1) alternates = std::max(alternates, std::abs(off[k - 1] - 0.5 * (off[k] + off[k - 2])));
		}
		char at[40];
		std::snprintf(at, sizeof at, ", T_v = %.2f", factor);
		expectSmall(name + std::string("rms of the isochrone over q") + at, std::sqrt(square), tolerance);
		expectSmall(name + std::string("alternation from cell to cell over q") + at, alternates, 5e-3);
	}
}

} // namespace

TEST(ImplicitPressure, MeetsTerzaghiWithTheBulkModulusOfWater) { expectTerzaghi(1e-3, 2.2e9, { 0.02, 0.1, 0.5 }, 1e-2); }

TEST(ImplicitPressure, MeetsTerzaghiToThreeTenthsOfAPercentInTighterGround_slow)
{
	for (const double bulk : { 2.2e7, 2.2e9 })
		expectTerzaghi(1e-5, bulk, { 0.02, 0.1 }, 3e-3);
	expectTerzaghi(1e-3, 2.2e7, { 0.5 }, 1e-2); // before, the wave of the load goes to and fro in soft water
}

TEST(ImplicitPressure, MeetsTerzaghiWhereverPointsLie) { expectTerzaghi(1e-3, 2.2e9, { 0.1, 0.5 }, 1e-2, 0.1); }

TEST(ImplicitPressure, MeetsTerzaghiWhereverPointsLieInTighterGround_slow) { expectTerzaghi(1e-5, 2.2e9, { 0.02, 0.1 }, 3e-3, 0.1); }

TEST(ImplicitPressure, LoadOnPointsThatDoNotLieEvenlyIsBorneToAFewPerCent)
{
	citing("bound");
	auto s                 = loadedColumn(1e-4, 2.2e9, 20, false);
	s.motion->localDamping = 0.6;
	Ground<2> ground       = started(s, { s.gridSpacing, 1.0 }, 0.1);
	marchTo(ground, 0.5);
	expectSmall(
	        "load on a column of one cell, points moved by a tenth of their spacing, implicit pressure: mean pressure over the load, less 1",
	        sumOf(ground, "pressure") / ground.points().count() / load - 1.0, 5e-2);
}

namespace {

/// A column of one cell by one in space, loaded on its top, drained there or sealed.
Ground<3> columnInSpace(double conductivity, int cells, bool drained)
{
	GroundSettings<3> s;
	s.gridSpacing = 1.0 / cells;
	s.upper       = { s.gridSpacing, s.gridSpacing, 1.0 + 2.0 * s.gridSpacing };
	s.mixture     = withoutExpansion();
	s.motion.emplace();
	s.motion->localDamping = drained ? 0.3 : 0.6;
	addStiffWater(s, conductivity, 2.2e9);
	auto skeleton     = std::make_shared<ElasticSkeleton<3>>();
	skeleton->young   = oedometer;
	skeleton->poisson = 0.0;
	s.skeletons.push_back(skeleton);
	for (const char* side : { "left", "right", "front", "back", "bottom" })
		s.boundaries.push_back(std::make_shared<RollerBoundary<3>>(Region<3>::side(side)));
	if (drained) s.boundaries.push_back(std::make_shared<DrainedBoundary<3>>(Region<3>::freeSurface()));
	s.boundaries.push_back(std::make_shared<Traction<3>>(Region<3>::freeSurface(), load));
	Ground<3> ground(s);
	for (int k = 0; k < 8 * cells; ++k) {
		PointInput<3> p;
		p.volume   = std::pow(0.5 * s.gridSpacing, 3);
		p.porosity = porosity;
		p.position = { (k % 2 + 0.5) * 0.5 * s.gridSpacing, (k / 2 % 2 + 0.5) * 0.5 * s.gridSpacing, (k / 4 + 0.5) * 0.5 * s.gridSpacing };
		ground.addPoint(p);
	}
	ground.initialise();
	return ground;
}

} // namespace

TEST(ImplicitPressure, MeetsTerzaghiInSpaceWithTheBulkModulusOfWater)
{
	citing("Terzaghi, compressible water");
	constexpr int cells = 20;
	for (const double conductivity : { 1e-3, 1e-4 }) {
		const reference::Terzaghi exact { 1.0, load, oedometer, porosity / 2.2e9, conductivity / 9810.0 };
		Ground<3>                 ground = columnInSpace(conductivity, cells, true);
		const double              factor = conductivity > 5e-4 ? 0.1 : 0.02, t = exact.timeAt(factor);
		marchTo(ground, t);
		const auto p = valuesOf(ground, "pressure"), z = valuesOf(ground, "position", 2);
		double     square = 0.0;
		for (std::size_t k = 0; k < p.size(); ++k)
			square += std::pow(p[k] / load - exact.pressure((std::floor(z[k] * cells) + 0.5) / cells, t) / load, 2) / p.size();
		char name[120];
		std::snprintf(
		        name, sizeof name, "implicit pressure, Terzaghi in space, k = %.0e: rms of the isochrone over q, T_v = %.2f", conductivity, factor);
		expectSmall(name, std::sqrt(square), 1e-2);
	}
}

TEST(ImplicitPressure, UndrainedLoadIsBorneByTheWaterInSpace)
{
	citing("Skempton 1954");
	Ground<3> ground = columnInSpace(1e-4, 4, false);
	marchTo(ground, 0.2);
	expectRelative(
	        "implicit pressure, undrained load in space: B, M = 1e7", sumOf(ground, "pressure") / ground.points().count() / load,
	        1.0 / (1.0 + oedometer * porosity / 2.2e9), 1e-3);
}

namespace {

/// A smooth plate, which sinks at an even speed and then rests, presses a column that drains through its base.
struct Pressed {
	double undrained; ///< pressure in the upper half over the stress under the plate, when the plate has sunk and hardly any water has left
	double drained;   ///< stress under the plate when the water has left, over that of the skeleton alone
	double left;      ///< largest pressure then, over that stress
};

Pressed pressedByAPlate(bool implicit)
{
	constexpr int    cells = 8;
	constexpr double h = 1.0 / cells, path = 1e-3, sinking = 0.02, young = 1e6;
	auto             s = columnSettings(h, 1.0 + 2.0 * h);
	standOnRollers(s);
	s.motion.emplace();
	s.motion->localDamping = 0.5;
	s.bodies.emplace();
	addStiffWater(s, 1e-3, implicit ? 2.2e9 : 2.2e7);
	s.water->implicit = implicit;
	s.skeletons.push_back(elasticOedometer(young));
	addBoundary<DrainedBoundary<2>>(s, Region<2>::side("bottom"));
	Ground<2>    ground    = started(s, { h, 1.0 });
	const double stiffness = ground.bodies()->stiffness();
	RigidBody<2> plate;
	plate.id = plate.group   = 0;
	plate.shape              = &rigidPlane<2>();
	plate.side               = -1;
	plate.position[1]        = 1.0;
	plate.axes               = { { { 0.0, 1.0 }, { -1.0, 0.0 } } };
	ground.bodies()->bodies  = { plate };
	const auto pressureAbove = [&] { // where the base is not felt yet
		const auto p = cellPressures(ground, cells);
		return std::accumulate(p.begin() + cells / 2, p.end(), 0.0) / (cells / 2);
	};
	/// Impulse of the plate over its width, and the integral of the pressure over time.
	const auto press = [&](double duration) {
		double impulse = 0.0, ofWater = 0.0;
		for (const double end = ground.time() + duration; ground.time() < end;) {
			RigidBody<2>& body  = ground.bodies()->bodies[0];
			const double  dt    = std::min(ground.stableTimeStep().step, end - ground.time() + 1e-12);
			const bool    sinks = ground.time() < sinking;
			body.position[1]    = 1.0 - path * std::min(1.0, ground.time() / sinking);
			body.velocity[1]    = sinks ? -path / sinking : 0.0;
			body.impulse        = {};
			ground.step(dt);
			impulse += body.impulse[1] / h;
			ofWater += dt * pressureAbove();
		}
		return std::make_pair(impulse, ofWater);
	};
	press(sinking);
	const auto [impulse, ofWater] = press(0.1);
	Pressed found {};
	found.undrained = ofWater / impulse;
	press(40.0);
	found.drained = press(1.0).first / (young * path / (1.0 - 0.25 * h + young / stiffness));
	found.left    = largestSize(valuesOf(ground, "pressure")) / (young * path);
	return found;
}

} // namespace

TEST(ImplicitPressure, APlateIsBorneByTheWaterFirstAndByTheGrainsWhenTheWaterHasLeft)
{
	for (const bool implicit : { false, true }) {
		const std::string name = std::string("plate on a column that drains through its base, ") + (implicit ? "implicit" : "explicit") + " pressure: ";
		const Pressed     found = pressedByAPlate(implicit);
		citing("Skempton 1954");
		expectRelative(name + "pressure over stress at first", found.undrained, 1.0 / (1.0 + 1e6 * porosity / (implicit ? 2.2e9 : 2.2e7)), 2e-2);
		citing("Hooke");
		expectRelative(name + "stress over that of the grains at last", found.drained, 1.0, 2e-2);
		expectSmall(name + "pressure at last over stress", found.left, 1e-2);
	}
}

TEST(ImplicitPressure, UndrainedLoadIsBorneByTheWater)
{
	citing("Skempton 1954");
	auto s                 = loadedColumn(1e-4, 2.2e9, 4, false);
	s.motion->localDamping = 0.6;
	Ground<2> ground       = started(s, { s.gridSpacing, 1.0 });
	marchTo(ground, 0.2);
	const auto p = valuesOf(ground, "pressure");
	expectRelative(
	        "implicit pressure, undrained load: B, M = 1e7", sumOf(ground, "pressure") / p.size() / load, 1.0 / (1.0 + oedometer * porosity / 2.2e9), 1e-3);
}

namespace {

/// Largest pressure, and what alternates over four cells in both directions, over the load. Half of the surface is loaded.
std::pair<double, double> underAStrip(double conductivity, double bulkModulus, long steps)
{
	constexpr int     n = 8;
	constexpr double  h = 0.25;
	GroundSettings<2> s;
	s.lower       = { 0.0, 0.0 };
	s.upper       = { n * h, (n + 2) * h };
	s.gridSpacing = h;
	s.mixture     = withoutExpansion();
	standOnRollers(s);
	s.motion.emplace();
	s.motion->localDamping = 0.3;
	addStiffWater(s, conductivity, bulkModulus);
	s.skeletons.push_back(elasticOedometer(oedometer));
	addBoundary<Traction<2>>(s, Region<2>::freeSurface().within({ -1.0, 0.0 }, { 0.51 * n * h, 10.0 }), load);
	addBoundary<DrainedBoundary<2>>(s, Region<2>::freeSurface().within({ 0.51 * n * h, 0.0 }, { 10.0, 10.0 }));
	Ground<2>    ground = started(s, { n * h, n * h });
	const double dt     = ground.stableTimeStep().step;
	for (long k = 0; k < steps; ++k)
		ground.step(dt);
	const auto                p = valuesOf(ground, "pressure"), x = valuesOf(ground, "position", 0), y = valuesOf(ground, "position", 1);
	std::array<double, n * n> cells {};
	std::pair<double, double> found { largestSize(p), 0.0 };
	for (std::size_t k = 0; k < p.size(); ++k)
		cells[std::clamp(int(x[k] / h), 0, n - 1) + n * std::clamp(int(y[k] / h), 0, n - 1)] = p[k];
	for (int j = 0; j + 1 < n; ++j)
		for (int i = 0; i + 1 < n; ++i) {
			const double* const c = &cells[i + n * j];
			found.second += 0.0625 * std::pow(c[0] - c[1] - c[n] + c[n + 1], 2) / ((n - 1) * (n - 1));
		}
	return { found.first / load, std::sqrt(found.second) / load };
}

void expectSteadyUnderAStrip(const std::vector<double>& conductivities, const std::vector<double>& moduli, long steps)
{
	citing("bound");
	for (const double k : conductivities)
		for (const double bulk : moduli) {
			const auto [largest, alternates] = underAStrip(k, bulk, steps);
			char name[100];
			std::snprintf(name, sizeof name, "implicit pressure under a strip, k = %.0e, K_w = %.1e: ", k, bulk);
			expectSmall(name + std::string("largest pressure over the load"), largest, 1.2);
			expectSmall(name + std::string("rms over nodes of what alternates over four cells, over the load"), alternates, 5e-2);
		}
}

} // namespace

TEST(ImplicitPressure, IsBoundedAndDoesNotAlternateInTightGroundWithWaterThatDoesNotYield) { expectSteadyUnderAStrip({ 1e-16 }, { 2.2e9, 1e15 }, 1000); }

TEST(ImplicitPressure, IsBoundedAndDoesNotAlternateAtAnyConductivity_slow)
{
	expectSteadyUnderAStrip({ 1e-2, 1e-4, 1e-6, 1e-8, 1e-12, 1e-16 }, { 2.2e7, 2.2e9, 1e15 }, 20000);
}

namespace {

GroundSettings<2> freezingBox()
{
	GroundSettings<2> s;
	s.lower       = { 0.0, 0.0 };
	s.upper       = { 1.0, 1.25 };
	s.gridSpacing = 0.125;
	standOnRollers(s);
	s.motion.emplace();
	s.motion->gravity = { 0.0, -9.81 };
	s.heat.emplace();
	s.heat->thermalTimeScale = 1e5;
	s.freezing               = makeFreezingCurve();
	addStiffWater(s, 1e-5, 2.2e9);
	s.water->state.cavitationPressure = 0.0;
	s.skeletons.push_back(elasticOedometer(oedometer));
	return s;
}

void fillFreezingBox(Ground<2>& ground)
{
	fillBox(ground, { 0.0, 0.0 }, { 1.0, 1.0 }, [](PointInput<2>& p) {
		p.porosity    = porosity;
		p.temperature = p.position[0] < 0.5 ? 3.0 : -2.0;
	});
	ground.initialise();
}

} // namespace

TEST(ImplicitPressure, WaterThatFreezesAndThawsInASealedBoxIsKept)
{
	citing("exact");
	Ground<2> ground(freezingBox());
	fillFreezingBox(ground);
	const auto   start = ground.balance();
	const double dt    = ground.stableTimeStep().step;
	for (int k = 0; k < 1000; ++k)
		ground.step(dt);
	const auto end = ground.balance();
	expectSmall("implicit pressure, freezing in a sealed box: drift of ice and water", (end.waterMass - start.waterMass) / start.waterMass, 1e-13);
	expectSmall("implicit pressure, freezing in a sealed box: drift of heat", (end.enthalpy - start.enthalpy) / start.enthalpy, 1e-12);
	expectSmall("implicit pressure, freezing in a sealed box: largest pressure [MPa]", 1e-6 * largestSize(valuesOf(ground, "pressure")), 1.0);
}

namespace {

constexpr double frozenAt = -0.2, warm = 10.0;

/// Thaw depth over the square root of time, with a linear freezing curve down to -0.1 degC [m/s^0.5].
double frontPerRoot(const MixtureProperties& m, const FreezingCurve& curve)
{
	const reference::SimilarityFront front(
	        [&](double t) { return m.conductivity(VolumeFractions::of(porosity, curve.liquidSaturation(t))); },
	        [&](double t) {
		        return m.heatCapacity(VolumeFractions::of(porosity, curve.liquidSaturation(t))) + porosity * 910.0 * m.latentHeat * curve.derivative(t);
	        },
	        warm, frozenAt, 4e-3, 40000);
	return front.integralOf([&](double t) { return curve.liquidSaturation(t); }) / 0.95;
}

double thawDepth(const Ground<2>& ground)
{
	const auto ice = valuesOf(ground, "iceSaturation"), volume = valuesOf(ground, "volume");
	double     sum = 0.0;
	for (std::size_t k = 0; k < ice.size(); ++k)
		sum += (1.0 - ice[k] / 0.95) * volume[k] / ground.settings().gridSpacing;
	return sum;
}

/// Errors of the excess pressure behind a front while it goes from 0.3 to 0.6 of the height, over the load: of the cells from 0.1 to 0.8 of the thawed
/// depth; and over the pressure that is due, at 0.4 of that depth: mean and scatter in time.
struct ThawErrors {
	double ofProfile, mean, scatter;
};

ThawErrors thawUnderLoad(double ratio, int cells)
{
	auto s                        = loadedColumn(1e-4, 2.2e9, cells);
	s.water->state.densityChange  = false; // as in the theory
	s.water->state.iceBulkModulus = s.water->state.liquidBulkModulus;
	s.water->hydraulicTimeScale   = 1.0;
	s.heat.emplace();
	s.freezing                 = makeFreezingCurve("linear", { { "frozenTemperature", -0.1 } });
	const double consolidation = 1e-4 / 9810.0 / (1.0 / oedometer + porosity / 2.2e9), perRoot = frontPerRoot(s.mixture, *s.freezing);
	s.heat->thermalTimeScale = std::pow(2.0 * ratio * std::sqrt(consolidation) / perRoot, 2);
	addBoundary<SurfaceTemperature<2>>(s, Region<2>::freeSurface(), warm);
	Ground<2> ground(s);
	fillBox(ground, { 0.0, 0.0 }, { s.gridSpacing, 1.0 }, [](PointInput<2>& p) {
		p.porosity    = porosity;
		p.temperature = frozenAt;
		p.pressure    = load;
	});
	ground.initialise();
	const double end = std::pow(0.6 / (2.0 * ratio), 2) / consolidation;
	marchTo(ground, 0.1 * end);
	double                       last = ground.time(), squares = 0.0, sum = 0.0, square = 0.0;
	reference::ThawConsolidation exact(consolidation, thawDepth(ground), { 0.5 * thawDepth(ground) / std::sqrt(consolidation * last) });
	long                         compared = 0, looks = 0, step = 0;
	marchTo(ground, end, 1e300, [&] {
		if (++step % 20) return;
		const double depth = thawDepth(ground);
		exact.advance(depth, ground.time() - last);
		last = ground.time();
		if (last < 0.25 * end) return;
		const auto found = cellPressures(ground, cells);
		for (int k = 0; k < cells; ++k) {
			const double x = (1.0 - (k + 0.5) / cells) / depth;
			if (x < 0.1 || x > 0.8) continue;
			squares += std::pow(found[k] / load - exact.pressure(x), 2);
			++compared;
		}
		const double at   = (1.0 - 0.4 * depth) * cells - 0.5;
		const int    cell = int(at);
		const double off  = (found[cell] + (at - cell) * (found[cell + 1] - found[cell])) / (load * exact.pressure(0.4)) - 1.0;
		sum += off;
		square += off * off;
		++looks;
	});
	return { std::sqrt(squares / compared), sum / looks, std::sqrt(square / looks - sum * sum / looks / looks) };
}

void expectThawConsolidation(double ratio, int cells, double allowedScatter)
{
	citing("Morgenstern & Nixon 1971, R set by f_T");
	const ThawErrors found = thawUnderLoad(ratio, cells);
	char             name[100];
	std::snprintf(name, sizeof name, "implicit pressure, Morgenstern-Nixon R = %.2f, %d cells: ", ratio, cells);
	const double atFront = reference::MorgensternNixon { ratio }.atThawLine();
	std::printf("rms of u over its value at the thaw line: %.3f\n", found.ofProfile / atFront);
	expectSmall(name + std::string("rms of u/P0 within the thawed layer"), found.ofProfile, 5e-3);
	expectScaled(name + std::string("mean in time of u over exact at 0.4 X"), 1.0 + found.mean, 1.0, 1.0, 3e-2);
	expectSmall(name + std::string("scatter in time of u over exact at 0.4 X"), found.scatter, allowedScatter);
}

} // namespace

TEST(ImplicitPressure, ReferenceOfThawConsolidationKeepsTheSimilaritySolution)
{
	citing("Morgenstern & Nixon 1971");
	for (const double ratio : { 0.2, 1.0 }) {
		const reference::MorgensternNixon similar { ratio };
		reference::ThawConsolidation      moving(1.0, 0.3, similar);
		for (int k = 1; k <= 2000; ++k) { // X^2 = 4 R^2 t
			const double square = 0.09 + k * (0.36 - 0.09) / 2000;
			moving.advance(std::sqrt(square), (0.36 - 0.09) / 2000 / (4.0 * ratio * ratio));
		}
		char name[80];
		std::snprintf(name, sizeof name, "reference of thaw consolidation, R = %.1f: u/P0 at 0.5 X", ratio);
		expectScaled(name, moving.pressure(0.5), similar.pressure(0.5), similar.atThawLine(), 5e-3);
	}
}

TEST(ImplicitPressure, ThawOfLoadedGroundGivesTheExcessPressureOfMorgensternAndNixon)
{
	for (const double ratio : { 0.5, 1.0 })
		expectThawConsolidation(ratio, 12, 3e-2);
}

// A cell that thaws lets the whole load go, of which a slow front leaves but a few hundredths: what scatters is how evenly heat melts the cells
TEST(ImplicitPressure, PressureBehindASlowThawFrontIsSteadyInTime_slow)
{
	expectThawConsolidation(0.2, 12, 3e-2);
	expectThawConsolidation(0.25, 20, 3e-2);
}

TEST(ImplicitPressure, HasTheSameBitsWithAnyThreads)
{
	const auto run = [](int threads) {
		omp_set_num_threads(threads);
		auto s         = freezingBox();
		s.parallelFrom = 0;
		addBoundary<DrainedBoundary<2>>(s, Region<2>::freeSurface());
		Ground<2> ground(s);
		fillFreezingBox(ground);
		const double dt = ground.stableTimeStep().step;
		for (int k = 0; k < 200; ++k)
			ground.step(dt);
		return valuesOf(ground, "pressure");
	};
	const auto one = run(1), two = run(2);
	omp_set_num_threads(1);
	double differing = 0.0;
	for (std::size_t k = 0; k < one.size(); ++k)
		differing += one[k] != two[k];
	citing("exact");
	expectSmall("implicit pressure with one and two threads: points that differ", differing, 0.0);
}

namespace {

constexpr double gravity = 9.81, submerged = (1.0 - porosity) * 1650.0, wetDensity = (1.0 - porosity) * 2650.0 + porosity * 1000.0;

/// Means in the middle of a saturated slab with a drained surface on a base that is inclined by 30 degrees, over the time in which it slides. The
/// closed form: the ground follows gravity along the slope, so that b - a and the gradient of the pressure are normal to it.
struct Sliding {
	double acceleration, slope, base, along; ///< [m/s^2]; dp/dy and the pressure at the base over rho_l g cos b and that times H; flux over k sin b
};

Sliding slab(double depth, double length, double conductivity, bool implicit, std::shared_ptr<SkeletonModel<2>> skeleton, double lateral, bool smooth)
{
	constexpr double  h = 0.125, tilt = 0.5235987755982988;
	const double      across = gravity * std::cos(tilt), begin = 0.15, end = 0.35, middle = 0.5 + 0.5 * length, top = depth - 0.2;
	GroundSettings<2> s;
	s.lower       = { 0.0, 0.0 };
	s.upper       = { length + 2.0, depth + 0.5 };
	s.gridSpacing = h;
	s.mixture     = withoutExpansion();
	s.motion.emplace();
	s.motion->gravity = { gravity * std::sin(tilt), -across };
	addStiffWater(s, conductivity, implicit ? 2.2e9 : 2.2e7);
	s.water->implicit                 = implicit;
	s.water->state.cavitationPressure = 0.0;
	s.skeletons.push_back(std::move(skeleton));
	if (smooth) addBoundary<RollerBoundary<2>>(s, Region<2>::side("bottom"));
	else addBoundary<FixedBoundary<2>>(s, Region<2>::side("bottom"));
	addBoundary<DrainedBoundary<2>>(s, Region<2>::freeSurface());
	Ground<2> ground(s);
	fillBox(ground, { 0.5, 0.0 }, { 0.5 + length, depth }, [&](PointInput<2>& p) {
		p.porosity  = porosity;
		p.stress[1] = -submerged * across * (depth - p.position[1]);
		p.stress[0] = p.stress[2] = lateral * p.stress[1];
		p.pressure                = 1000.0 * across * (depth - p.position[1]);
	});
	ground.initialise();
	const auto start = valuesOf(ground, "position", 0), height = valuesOf(ground, "position", 1);
	Sliding    found {};
	double     weights = 0.0;
	const auto mean    = [&](const std::vector<double>& values, double above = 0.0) {
                double sum   = 0.0;
                long   count = 0;
                for (std::size_t p = 0; p < start.size(); ++p)
                        if (std::abs(start[p] - middle) < 0.5 && height[p] > above) sum += values[p], ++count;
                return sum / count;
	};
	const auto speed = [&] { return mean(valuesOf(ground, "velocity", 0), top); };
	marchTo(ground, begin);
	const double before = speed();
	long         step   = 0;
	marchTo(ground, end, 1e300, [&] {
		if (++step % 10) return;
		const auto p = valuesOf(ground, "pressure"), n = valuesOf(ground, "liquidFraction"), v = valuesOf(ground, "velocity", 0);
		auto       flux = valuesOf(ground, implicit ? "seepageVelocity" : "liquidVelocity", 0);
		auto       y = valuesOf(ground, "position", 1), products = y, squares = y;
		for (std::size_t k = 0; k < y.size(); ++k) {
			y[k]        = (std::floor(y[k] / h) + 0.5) * h; // the pressure of a point is that of its cell
			products[k] = y[k] * p[k];
			squares[k]  = y[k] * y[k];
			flux[k]     = n[k] * (flux[k] - (implicit ? 0.0 : v[k]));
		}
		const double gradient = (mean(products) - mean(y) * mean(p)) / (mean(squares) - mean(y) * mean(y));
		found.slope -= gradient / (1000.0 * across);
		found.base += (mean(p) - gradient * mean(y)) / (1000.0 * across * depth);
		found.along += mean(flux) / (conductivity * std::sin(tilt));
		++weights;
	});
	found.slope /= weights, found.base /= weights, found.along /= weights;
	found.acceleration = (speed() - before) / (end - begin);
	return found;
}

} // namespace

TEST(ImplicitPressure, SaturatedSlabThatSlidesWithoutFrictionHasThePressureOfItsWeightAcrossTheSlope)
{
	citing("closed form, b - a");
	const Sliding found = slab(0.5, 4.0, 2e-3, true, elasticOedometer(2.0 * oedometer), 0.0, true);
	const char*   what  = "saturated slab slides down 30 degrees without friction, implicit pressure: ";
	expectRelative(what + std::string("acceleration over g sin b"), found.acceleration, 0.5 * gravity, 1e-2);
	expectRelative(what + std::string("dp/dy over rho_l g cos b"), found.slope, 1.0, 5e-2);
	expectRelative(what + std::string("pressure at the base over that at rest"), found.base, 1.0, 5e-2);
	expectSmall(what + std::string("flux along the slope over k sin b"), found.along, 2e-2);
}

TEST(ImplicitPressure, SaturatedSlabThatSlidesWithFrictionIsHeldByItsEffectiveWeight)
{
	citing("Davis 1968, pressure of rest");
	const double ratio = 1.0 - 1000.0 / wetDensity, due = gravity * (0.5 - 0.5 * std::cos(0.5235987755982988) * ratio);
	for (const bool implicit : { false, true }) {
		auto skeleton           = std::make_shared<MohrCoulombSkeleton<2>>();
		skeleton->young         = 1e7;
		skeleton->cohesion      = 0.0;
		skeleton->frictionAngle = 30.0;
		const Sliding     found = slab(0.5, 5.0, 1e-2, implicit, skeleton, 0.6, false);
		const std::string what  = std::string("saturated slab slides down 30 degrees on friction of 30, ") + (implicit ? "implicit" : "explicit")
		        + " pressure: ";
		expectRelative(what + "acceleration", found.acceleration, due, 8e-2);
		expectRelative(what + "pressure at the base over that at rest", found.base, 1.0, 5e-2);
	}
}

TEST(ImplicitPressure, SaturatedGroundThatFallsFreelyKeepsItsWater)
{
	citing("exact");
	for (const double k : { 1e-2, 1e-4 }) {
		GroundSettings<2> s;
		s.lower       = { 0.0, 0.0 };
		s.upper       = { 2.0, 4.0 };
		s.gridSpacing = 0.1;
		s.motion.emplace();
		s.motion->gravity = { 0.0, -gravity };
		addStiffWater(s, k, 2.2e9);
		s.water->state.cavitationPressure = 0.0;
		s.skeletons.push_back(elasticOedometer(oedometer));
		addBoundary<DrainedBoundary<2>>(s, Region<2>::freeSurface());
		Ground<2> ground(s);
		fillBox(ground, { 0.43, 3.0 }, { 1.23, 3.8 }, [](PointInput<2>& p) { p.porosity = porosity; });
		ground.initialise();
		marchTo(ground, 0.2);
		const Balance<2> b = ground.balance();
		char             name[100];
		std::snprintf(name, sizeof name, "saturated block falls freely, implicit pressure, k = %.0e: ", k);
		expectSmall(name + std::string("water that leaves it over its water"), b.waterOut / b.waterMass, 1e-10);
		expectSmall(name + std::string("pressure [Pa]"), largestSize(valuesOf(ground, "pressure")), 1e-4);
	}
}

namespace {

/// Largest change of stress in a block under a load on all of its surface, which grains and water bear in these parts, over the load.
double unrestUnderLoad(bool implicit, double share, const Vec<2>& velocity)
{
	constexpr double  q = 5e4;
	GroundSettings<2> s;
	s.lower       = { 0.0, 0.0 };
	s.upper       = { 2.0, 2.0 };
	s.gridSpacing = 0.1;
	s.motion.emplace();
	addStiffWater(s, 1e-7, implicit ? 2.2e9 : 2.2e7);
	s.water->implicit                 = implicit;
	s.water->state.cavitationPressure = 0.0;
	auto skeleton                     = std::make_shared<ElasticSkeleton<2>>();
	skeleton->young                   = 2e7;
	s.skeletons.push_back(skeleton);
	addBoundary<Traction<2>>(s, Region<2>::freeSurface(), q);
	Ground<2> ground(s);
	fillBox(ground, { 0.43, 0.43 }, { 1.23, 1.23 }, [&](PointInput<2>& p) {
		p.porosity  = porosity;
		p.velocity  = velocity;
		p.stress[0] = p.stress[1] = p.stress[2] = -(1.0 - share) * q;
		p.pressure                              = share * q;
	});
	ground.initialise();
	double largest = 0.0;
	long   step    = 0;
	marchTo(ground, 0.15, 1e300, [&] {
		if (++step % 10) return;
		for (const int component : { 0, 1 })
			for (const double sigma : valuesOf(ground, "stress", component))
				largest = std::max(largest, std::abs(sigma / q + 1.0 - share));
		for (const double p : valuesOf(ground, "pressure"))
			largest = std::max(largest, std::abs(p / q - share));
	});
	return largest;
}

} // namespace

TEST(ImplicitPressure, LoadOnSurfacesThatCutCellsKeepsTheStressThatIsInBalanceWithIt)
{
	citing("exact");
	for (const bool implicit : { false, true })
		for (const bool moves : { false, true })
			for (const double share : { 0.0, 1.0 }) {
				const std::string name = std::string("block under a load all around, ") + (implicit ? "implicit" : "explicit") + " pressure, "
				        + (moves ? "which flies: " : "at rest: ");
				expectSmall(
				        name + (share > 0.0 ? "borne by water" : "borne by grains") + ", largest change of stress or pressure over the load",
				        unrestUnderLoad(implicit, share, moves ? Vec<2> { 1.0, 0.37 } : Vec<2> {}), 0.1);
			}
}

namespace {

/// Largest change of pressure and of vertical effective stress in so many steps, over the pressure at the base of a column of 20 cells.
std::pair<double, double> changeAtRest(bool saturated, int perDirection, double moved, long steps)
{
	constexpr int    cells = 20;
	constexpr double h = 0.25, height = cells * h, g = 9.81;
	const double     weight = ((1.0 - porosity) * 2650.0 - (saturated ? 1.0 - porosity : 0.0) * 1000.0) * g;
	auto             s      = columnSettings(h, height + 2 * h);
	s.upper[0]              = 2 * h;
	standOnRollers(s);
	s.motion.emplace();
	s.motion->gravity = { 0.0, -g };
	s.poreFill        = saturated ? s.poreFill : 0.0;
	if (saturated) {
		addStiffWater(s, 1e-4, 2.2e9);
		s.water->state.cavitationPressure = 0.0;
		addBoundary<DrainedBoundary<2>>(s, Region<2>::freeSurface());
	}
	s.skeletons.push_back(elasticOedometer(oedometer));
	Ground<2>                              ground(s);
	std::mt19937                           random(1);
	std::uniform_real_distribution<double> by(-moved, moved);
	const auto                             prepare = [&](PointInput<2>& p) {
                p.porosity  = porosity;
                p.stress[1] = -weight * (height - p.position[1]);
                p.stress[0] = 0.5 * p.stress[1];
                p.pressure  = saturated ? 1000.0 * g * (height - (std::floor(p.position[1] / h) + 0.5) * h) : 0.0;
                for (double& x : p.position)
                        x += by(random) * h / perDirection;
	};
	fillBox(ground, { 0.0, 0.0 }, { 2 * h, height }, prepare, perDirection);
	ground.initialise();
	const auto   stress   = valuesOf(ground, "stress", 1);
	const auto   pressure = saturated ? valuesOf(ground, "pressure") : stress;
	const double dt       = ground.stableTimeStep().step;
	for (long k = 0; k < steps; ++k)
		ground.step(dt);
	const auto                stressNow = valuesOf(ground, "stress", 1), pressureNow = saturated ? valuesOf(ground, "pressure") : stressNow;
	const double              scale = (saturated ? 1000.0 : (1.0 - porosity) * 2650.0) * g * height;
	std::pair<double, double> change;
	for (std::size_t p = 0; p < stress.size(); ++p) {
		change.first  = std::max(change.first, std::abs(pressureNow[p] - pressure[p]) / scale);
		change.second = std::max(change.second, std::abs(stressNow[p] - stress[p]) / scale);
	}
	return change;
}

void expectRest(long steps)
{
	citing("exact");
	const auto        dry = changeAtRest(false, 1, 0.0, steps), saturated = changeAtRest(true, 1, 0.0, steps);
	const std::string after = " in " + std::to_string(steps) + " steps over rho g H";
	expectSmall("at rest, one point a cell, dry: change of stress" + after, dry.second, 1e-10);
	expectSmall("at rest, one point a cell, saturated: change of stress" + after, saturated.second, 1e-5);
	expectSmall("at rest, one point a cell, saturated: change of pressure" + after, saturated.first, 1e-4);
}

} // namespace

TEST(Rest, GroundOfOnePointACellRests) { expectRest(10000); }

TEST(Rest, GroundOfOnePointACellRestsForAMillionSteps_slow) { expectRest(1000000); }

TEST(Rest, GroundOfFourPointsACellChangesByAPerCent)
{
	citing("exact");
	expectSmall("at rest, four points a cell, dry: change of stress in 10000 steps over rho g H", changeAtRest(false, 2, 0.0, 10000).second, 2e-2);
	for (const double moved : { 0.0, 0.1 })
		expectSmall(
		        "at rest, four points a cell, saturated, points moved by " + std::to_string(moved).substr(0, 3)
		                + ": change of pressure in 10000 steps over rho g H",
		        changeAtRest(true, 2, moved, 10000).first, 1e-2);
}
