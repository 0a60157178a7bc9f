// SPDX-License-Identifier: GPL-2.0-or-later
// Prescribed pressure and flux of water, and heat exchanged with air, against closed forms (Darcy; Carslaw & Jaeger 1959, 2.7).
#include "References.hpp"
#include "Report.hpp"
#include "Scenes.hpp"

#include <gtest/gtest.h>

using namespace talik;
using namespace talik::validation;

namespace {

constexpr double length = 1.0, conductivity = 1e-3, unitWeight = 1000.0 * 9.81;

/// Soft saturated strip of the given number of cells along x; walls hold the grains.
GroundSettings<2> strip(int cells)
{
	GroundSettings<2> s;
	s.gridSpacing = length / cells;
	s.upper       = { length, s.gridSpacing };
	s.mixture     = withoutExpansion();
	for (const char* side : { "left", "right", "bottom", "top" })
		addBoundary<RollerBoundary<2>>(s, Region<2>::side(side));
	s.motion.emplace();
	s.motion->localDamping = 0.3;
	s.water.emplace();
	s.water->state.liquidBulkModulus            = 2.2e7;
	s.water->state.cavitationPressure           = -1e6;
	s.water->permeability.referenceConductivity = conductivity;
	s.skeletons.push_back(elasticOedometer(1e8));
	return s;
}

Ground<2> started(const GroundSettings<2>& s, double height, const PointPreparation<2>& prepare = {})
{
	Ground<2> ground(s);
	fillBox(ground, { 0.0, 0.0 }, { s.upper[0], height }, prepare);
	ground.initialise();
	return ground;
}

/// Means of a field over the grid cells along an axis, ascending.
std::vector<double> cellMeans(const Ground<2>& ground, const std::string& field, int axis)
{
	const auto          v = valuesOf(ground, field), x = valuesOf(ground, "position", axis);
	const double        h = ground.settings().gridSpacing;
	std::vector<double> sum, count;
	for (std::size_t k = 0; k < v.size(); ++k) {
		const std::size_t c = std::size_t(x[k] / h);
		if (c >= sum.size()) sum.resize(c + 1, 0.0), count.resize(c + 1, 0.0);
		sum[c] += v[k];
		count[c] += 1.0;
	}
	for (std::size_t c = 0; c < sum.size(); ++c)
		sum[c] /= count[c];
	return sum;
}

struct LineError {
	double between;     ///< largest error of the mean of two neighbouring cells, which is what drives the water
	double alternation; ///< largest half difference of a cell to its neighbours' line: a pattern that the grid does not see
};

/// Pressure of the cells against the line at0 + slope x.
LineError lineError(const Ground<2>& ground, int axis, double at0, double slope)
{
	const auto   p = cellMeans(ground, "pressure", axis);
	const double h = ground.settings().gridSpacing;
	LineError    worst { 0.0, 0.0 };
	const auto   error = [&](std::size_t c) { return p[c] - at0 - slope * (c + 0.5) * h; };
	for (std::size_t c = 0; c + 1 < p.size(); ++c) {
		worst.between     = std::max(worst.between, std::abs(0.5 * (error(c) + error(c + 1))));
		worst.alternation = std::max(worst.alternation, std::abs(0.5 * (error(c) - error(c + 1))));
	}
	return worst;
}

void expectLine(const std::string& label, const Ground<2>& ground, int axis, double at0, double slope, Drawing& drawing)
{
	const auto pressure = cellMeans(ground, "pressure", axis);
	for (std::size_t c = 0; c < pressure.size(); ++c)
		drawing.computed(label, (c + 0.5) * ground.settings().gridSpacing, 1e-3 * pressure[c]);
	drawing.reference(label, 0.0, length, [=](double x) { return 1e-3 * (at0 + slope * x); });
	const LineError error      = lineError(ground, axis, at0, slope);
	const double    difference = std::abs(slope) * length;
	expectSmall(label + ": pressure between cells off the line", error.between / difference, 1e-2);
	// one cell's difference: a wall's node stands for the points in front of it, by up to half a cell, and a pattern that alternates
	// from cell to cell moves no water and so does not die out
	expectSmall(label + ": alternation from cell to cell", error.alternation / difference, ground.settings().gridSpacing / length);
}

/// Mean of n (v_l - v_s) over all points [m/s].
double meanFlux(const Ground<2>& ground, int axis)
{
	const auto vl = valuesOf(ground, "liquidVelocity", axis), vs = valuesOf(ground, "velocity", axis), n = valuesOf(ground, "liquidFraction");
	double     sum = 0.0;
	for (std::size_t k = 0; k < vl.size(); ++k)
		sum += n[k] * (vl[k] - vs[k]);
	return sum / vl.size();
}

} // namespace

TEST(Boundaries, PressureDifferenceThatChangesInTimeDrivesTheFluxOfDarcy)
{
	auto s = strip(20);
	addBoundary<DrainedBoundary<2>>(s, Region<2>::side("left"), TimeTable({ 0.0, 0.1, 0.8, 1.0 }, { 1e4, 2e4, 2e4, 6e4 }));
	addBoundary<DrainedBoundary<2>>(s, Region<2>::side("right"), 1e4);
	Ground<2> ground = started(s, s.gridSpacing, [](PointInput<2>& p) { p.pressure = 1e4; });
	Drawing   drawing("prescribed_pressures", "Seepage between prescribed pressures", "distance [m]", "pore pressure [kPa]");
	for (const auto& [until, pressure] : { std::pair(0.8, 2e4), std::pair(1.8, 6e4) }) {
		marchTo(ground, until);
		const double flux = conductivity / unitWeight * (pressure - 1e4) / length;
		char         label[64];
		std::snprintf(label, sizeof label, "pressures %.0f | 10 kPa", 1e-3 * pressure);
		expectRelative(label + std::string(": flux against Darcy [m/s]"), meanFlux(ground, 0), flux, 1e-2);
		expectLine(label, ground, 0, pressure, (1e4 - pressure) / length, drawing);
	}
}

TEST(Boundaries, SeepageVelocityOfImplicitPressureIsThatOfDarcyInEveryCell)
{
	auto s                           = strip(20);
	s.water->implicit                = true;
	s.water->state.liquidBulkModulus = 2.2e9;
	s.motion->bBar                   = true;
	addBoundary<DrainedBoundary<2>>(s, Region<2>::side("left"), 2e4);
	addBoundary<DrainedBoundary<2>>(s, Region<2>::side("right"), 1e4);
	Ground<2> ground = started(s, s.gridSpacing, [](PointInput<2>& p) { p.pressure = 1e4; });
	marchTo(ground, 0.8);
	const double flux  = conductivity / unitWeight * 1e4 / length;
	double       worst = 0.0;
	const auto   along = valuesOf(ground, "seepageVelocity", 0), across = valuesOf(ground, "seepageVelocity", 1), n = valuesOf(ground, "liquidFraction");
	for (std::size_t k = 0; k < n.size(); ++k)
		worst = std::max({ worst, std::abs(n[k] * along[k] / flux - 1.0), std::abs(n[k] * across[k] / flux) });
	expectSmall("implicit pressures 20 to 10 kPa: largest error of a point's flux over Darcy's", worst, 1e-2);
}

TEST(Boundaries, PrescribedFluxThroughASideNeedsTheGradientOfDarcy)
{
	const double flux = 2e-3;
	auto         s    = strip(20);
	addBoundary<WaterFlux<2>>(s, Region<2>::side("left"), TimeTable({ 0.0, 0.1 }, { 0.0, flux }));
	addBoundary<DrainedBoundary<2>>(s, Region<2>::side("right"), 5e3);
	Ground<2> ground = started(s, s.gridSpacing, [](PointInput<2>& p) { p.pressure = 5e3; });
	marchTo(ground, 1.2);
	const double slope = -unitWeight / conductivity * flux;
	Drawing      drawing("prescribed_flux", "Seepage of a prescribed flux, 2 mm/s", "distance [m]", "pore pressure [kPa]");
	expectLine("inflow 2 mm/s", ground, 0, 5e3 - slope * length, slope, drawing);
	expectRelative("inflow 2 mm/s: flux that arrives [m/s]", meanFlux(ground, 0), flux, 1e-2);
}

TEST(Boundaries, WaterFedToSealedGroundIsExactlyTheWaterItGains)
{
	const double flux = 3e-6, duration = 0.05;
	auto         s = strip(10);
	s.heat.emplace();
	addBoundary<WaterFlux<2>>(s, Region<2>::side("left"), flux, 20.0);
	Ground<2>  ground = started(s, s.gridSpacing, [](PointInput<2>& p) { p.temperature = 5.0; });
	const auto before = ground.balance();
	marchTo(ground, duration);
	const auto   after = ground.balance();
	const double fed = 1000.0 * flux * s.gridSpacing * duration, gained = after.waterMass - before.waterMass;
	const double specificHeat = s.mixture.liquid.specificHeat * 20.0 + s.mixture.latentHeat;
	// the walls give way by 1e-8 of their length, elastically
	expectRelative("water fed at 3 um/s [kg/m]", -after.waterOut, fed, 1e-7);
	expectRelative("water gained [kg/m]", gained, fed, 1e-6);
	expectRelative("heat that 20 degC water brings into ground of 5 degC [J/m]", -after.enthalpyOut, fed * specificHeat, 1e-7);
	expectRelative("heat gained [J/m]", after.enthalpy - before.enthalpy, fed * specificHeat, 1e-6);
}

TEST(Boundaries, RainOnTheFreeSurfaceFlowsToTheBaseUnderGravity)
{
	// base held at hydrostatic pressure, half of k as rain: dp/dy = -rho g (1 - q/k)
	const int         cells = 20;
	GroundSettings<2> s     = columnSettings(length / cells, length + 2.0 * length / cells);
	standOnRollers(s);
	s.motion.emplace();
	s.motion->gravity      = { 0.0, -9.81 };
	s.motion->localDamping = 0.3;
	s.water.emplace();
	s.water->state.liquidBulkModulus            = 2.2e7;
	s.water->state.cavitationPressure           = -1e6;
	s.water->permeability.referenceConductivity = conductivity;
	s.skeletons.push_back(elasticOedometer(1e8));
	addBoundary<WaterFlux<2>>(s, Region<2>::freeSurface(), TimeTable({ 0.0, 0.1 }, { 0.0, 0.5 * conductivity }));
	addBoundary<DrainedBoundary<2>>(s, Region<2>::side("bottom"), unitWeight * length);
	Ground<2> ground = started(s, length, [](PointInput<2>& p) { p.pressure = unitWeight * (length - p.position[1]); });
	marchTo(ground, 1.2);
	Drawing drawing("rain", "Rain of half the conductivity on a column", "height [m]", "pore pressure [kPa]");
	expectLine("rain of k/2", ground, 1, unitWeight * length, -0.5 * unitWeight, drawing);
	const double before = ground.balance().waterOut;
	marchTo(ground, 1.3);
	expectSmall("rain of k/2: storage still changing over rain", (ground.balance().waterOut - before) / (100.0 * 0.5 * conductivity * s.upper[0]), 1e-2);
}

namespace {

struct Soil {
	double conductivity, capacity;
	double diffusivity() const { return conductivity / capacity; }
};

Soil thawed()
{
	const MixtureProperties m = withoutExpansion();
	const auto              n = VolumeFractions::of(0.4, 1.0);
	return { m.conductivity(n), m.heatCapacity(n) };
}

/// Carslaw & Jaeger 2.7 (1): half space at 0 whose surface exchanges H (1 - T) with its surroundings, H = h_c/kappa.
double halfSpaceUnderAir(double x, double t, double a, double perConductivity)
{
	const double s = std::sqrt(a * t);
	return std::erfc(x / (2.0 * s))
	        - std::exp(perConductivity * x + perConductivity * perConductivity * a * t) * std::erfc(x / (2.0 * s) + perConductivity * s);
}

/// Largest error over 15 K of the column's cells after a day of air at 10 degC over ground at -5 degC (no freezing here).
double errorUnderAir(bool atWall, double coefficient, int cells, Drawing* drawing = nullptr)
{
	const double depth = 2.0, h = depth / cells;
	auto         s = columnSettings(h, depth + 2.0 * h);
	s.heat.emplace();
	const auto region = atWall ? Region<2>::side("bottom") : Region<2>::freeSurface();
	addBoundary<SurfaceTemperature<2>>(s, region, 10.0, coefficient);
	Ground<2>    ground = started(s, depth, [](PointInput<2>& p) { p.temperature = -5.0; });
	const auto   soil   = thawed();
	const double day    = 86400.0;
	marchTo(ground, day);
	const auto t     = cellMeans(ground, "temperature", 1);
	double     worst = 0.0;
	for (int c = 0; c < cells; ++c) {
		const double below = atWall ? (c + 0.5) * h : depth - (c + 0.5) * h;
		const double exact = -5.0 + 15.0 * halfSpaceUnderAir(below, day, soil.diffusivity(), coefficient / soil.conductivity);
		worst              = std::max(worst, std::abs(t[c] - exact) / 15.0);
		if (!drawing || below > 1.0) continue;
		char series[64];
		std::snprintf(series, sizeof series, "%s, %.0f W/(m^2 K)", atWall ? "wall" : "free surface", coefficient);
		drawing->computed(series, below, t[c]);
		if (!atWall) drawing->reference(series, below, exact);
	}
	return worst;
}

} // namespace

TEST(Boundaries, GroundUnderAirWarmsAsTheHalfSpaceWithSurfaceExchange)
{
	Drawing drawing("surface_exchange", "Air of 10 degC over ground of -5 degC, one day, h = 0.05 m", "depth [m]", "temperature [degC]");
	for (const bool atWall : { false, true })
		for (const double coefficient : { 2.0, 15.0 }) {
			char label[80];
			std::snprintf(label, sizeof label, "air over a %s, h_c = %.0f W/(m^2 K): ", atWall ? "wall" : "free surface", coefficient);
			const double coarse = errorUnderAir(atWall, coefficient, 20), medium = errorUnderAir(atWall, coefficient, 40, &drawing);
			const double fine = errorUnderAir(atWall, coefficient, 160);
			expectSmall(label + std::string("error over 15 K, h = 0.1 m"), coarse, 5e-2);
			expectSmall(label + std::string("error over 15 K, h = 0.0125 m"), fine, 1e-2);
			expectAtLeast(label + std::string("order, 0.05 to 0.0125 m"), 0.5 * std::log2(medium / fine), 0.8);
		}
}

namespace {

/// Largest error of the column's cells under a heat flux of 50 W/m^2, over the rise of the surface (Carslaw & Jaeger 2.9 (7)).
double errorUnderFlux(int cells)
{
	const double h    = length / cells;
	auto         s    = columnSettings(h, length + 2.0 * h);
	const auto   soil = thawed();
	s.heat.emplace();
	addBoundary<HeatFlux<2>>(s, Region<2>::freeSurface(), 50.0);
	Ground<2>    ground = started(s, length, [](PointInput<2>& p) { p.temperature = 2.0; });
	const double span   = 0.05 * length * length / soil.diffusivity();
	marchTo(ground, span);
	expectRelative("heat flux 50 W/m^2: heat fed [J/m]", ground.balance().heatIn, 50.0 * span * h, 1e-12);
	const double spread = 2.0 * std::sqrt(soil.diffusivity() * span), rise = 50.0 / soil.conductivity * spread / std::sqrt(reference::pi);
	const auto   t     = cellMeans(ground, "temperature", 1);
	double       worst = 0.0;
	for (int c = 0; c < cells; ++c) {
		const double u     = (length - (c + 0.5) * h) / spread;
		const double exact = rise * (std::exp(-u * u) - std::sqrt(reference::pi) * u * std::erfc(u));
		worst              = std::max(worst, std::abs(t[c] - 2.0 - exact) / rise);
	}
	return worst;
}

} // namespace

TEST(Boundaries, GroundUnderAHeatFluxWarmsAsTheHalfSpace)
{
	const double coarse = errorUnderFlux(20), fine = errorUnderFlux(80);
	expectSmall("heat flux 50 W/m^2: error over the rise of the surface, h = 0.05 m", coarse, 5e-2);
	expectSmall("heat flux 50 W/m^2: error over the rise of the surface, h = 0.0125 m", fine, 1.5e-2);
	expectAtLeast("heat flux 50 W/m^2: order of convergence", 0.5 * std::log2(coarse / fine), 0.8);
}
