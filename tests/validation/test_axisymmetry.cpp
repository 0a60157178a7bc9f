// SPDX-License-Identifier: GPL-2.0-or-later
// Ground in the plane that turns about an axis: closed forms in the radius.
#include "Report.hpp"
#include "Scenes.hpp"

#include <gtest/gtest.h>
#include <pkg/mpm/skeleton/CreepingSkeleton.hpp>

using namespace talik;
using namespace talik::validation;

namespace {

/// A ring from a radius to another, so many cells high, of square cells.
struct Ring {
	double inner = 1.0, outer = 2.0, spacing = 0.05;
	int    layers = 1;
	double height() const { return layers * spacing; }
};

GroundSettings<2> settingsOf(const Ring& ring)
{
	GroundSettings<2> s;
	s.axisymmetric = true;
	s.lower        = { ring.inner, 0.0 };
	s.upper        = { ring.outer, ring.height() };
	s.gridSpacing  = ring.spacing;
	s.mixture      = withoutExpansion();
	return s;
}

Ground<2> filled(const GroundSettings<2>& s, const PointPreparation<2>& prepare = {})
{
	Ground<2> ground(s);
	fillBox(ground, s.lower, s.upper, prepare);
	ground.initialise();
	return ground;
}

/// A field of the points in its mean over the cells from the inner radius on.
std::vector<double> ofCells(const Ground<2>& ground, const std::string& field, int component = 0)
{
	const auto          value = valuesOf(ground, field, component), x = valuesOf(ground, "position", 0);
	const auto&         s = ground.settings();
	std::vector<double> sum(std::lround((s.upper[0] - s.lower[0]) / s.gridSpacing), 0.0), count(sum.size(), 0.0);
	for (std::size_t p = 0; p < x.size(); ++p) {
		const auto c = std::min(sum.size() - 1, std::size_t((x[p] - s.lower[0]) / s.gridSpacing));
		sum[c] += value[p];
		count[c] += 1.0;
	}
	for (std::size_t c = 0; c < sum.size(); ++c)
		sum[c] /= count[c];
	return sum;
}

/// Largest difference from f(radius) over the points, over a scale.
double errorOf(const std::vector<double>& value, const std::vector<double>& radius, double scale, const std::function<double(double)>& f)
{
	double largest = 0.0;
	for (std::size_t p = 0; p < value.size(); ++p)
		largest = std::max(largest, std::abs(value[p] - f(radius[p])) / scale);
	return largest;
}

std::shared_ptr<ElasticSkeleton<2>> elastic(double young, double poisson)
{
	auto law     = std::make_shared<ElasticSkeleton<2>>();
	law->young   = young;
	law->poisson = poisson;
	return law;
}

/// Ground that moves along the axis alone, as between two planes of an infinite column.
struct AlongTheAxis final : Wall<2> {
	explicit AlongTheAxis(const Region<2>& region)
	        : Wall<2>(region, "AlongTheAxis")
	{}
	bool holds(int axis) const override { return axis == 0; }
};

} // namespace

/// Lame 1852: a thick cylinder under inner pressure, without strain along its axis.
TEST(Axisymmetry, AThickCylinderHasTheStressAndDisplacementOfLame)
{
	citing("Lamé 1852; Timoshenko & Goodier 1970, art. 28");
	const double a = 1.0, b = 2.0, pressure = 1e3, young = 1e7, A = pressure * a * a / (b * b - a * a), B = A * b * b;
	for (const double poisson : { 0.3, 0.49 }) {
		auto s = settingsOf({});
		s.motion.emplace();
		s.motion->localDamping = 0.5;
		s.skeletons            = { elastic(young, poisson) };
		addBoundary<Traction<2>>(s, Region<2>::side("left"), pressure);
		addBoundary<RollerBoundary<2>>(s, Region<2>::side("bottom"));
		addBoundary<RollerBoundary<2>>(s, Region<2>::side("top"));
		Ground<2> ground = filled(s);
		marchTo(ground, 0.6);
		const auto r = ofCells(ground, "position"), radius = valuesOf(ground, "position");
		char       label[64];
		const auto named = [&](const char* what) {
			return std::snprintf(label, sizeof label, "Lamé, nu = %.2f: %s", poisson, what), std::string(label);
		};
		expectSmall(
		        named("radial stress of cells over the pressure"),
		        errorOf(ofCells(ground, "stress", 0), r, pressure, [&](double x) { return A - B / (x * x); }), 1e-2);
		expectSmall(
		        named("hoop stress of cells over the largest"),
		        errorOf(ofCells(ground, "stress", 2), r, A + B, [&](double x) { return A + B / (x * x); }), 1e-2);
		const auto u = [&](double x) { return (1.0 + poisson) / young * ((1.0 - 2.0 * poisson) * A * x + B / x); };
		expectSmall(named("displacement of points over the largest"), errorOf(valuesOf(ground, "displacement"), radius, u(a), u), 1e-2);
	}
}

/// A triaxial column around its axis, under one pressure from the side and another from above.
TEST(Axisymmetry, ARoundColumnHasOneStressUnderLoads)
{
	citing("Hooke's law");
	const double side = 2e3, top = 5e3, young = 1e7, poisson = 0.3;
	auto         s = settingsOf({ 0.0, 0.5, 0.05, 10 });
	s.motion.emplace();
	s.motion->localDamping = 0.5;
	s.skeletons            = { elastic(young, poisson) };
	addBoundary<Traction<2>>(s, Region<2>::side("right"), side);
	addBoundary<Traction<2>>(s, Region<2>::side("top"), top);
	addBoundary<RollerBoundary<2>>(s, Region<2>::side("bottom"));
	Ground<2> ground = filled(s);
	marchTo(ground, 0.4);
	const auto scaled = [&](int component, double stress) {
		return errorOf(valuesOf(ground, "stress", component), valuesOf(ground, "position"), top, [&](double) { return -stress; });
	};
	expectSmall("round column: radial stress over the load", scaled(0, side), 1e-2);
	expectSmall("round column: hoop stress over the load", scaled(2, side), 1e-2);
	expectSmall("round column: axial stress over the load", scaled(1, top), 1e-2);
	const double perRadius = -(side - poisson * (side + top)) / young;
	expectSmall(
	        "round column: radial displacement over the largest",
	        errorOf(valuesOf(ground, "displacement"), valuesOf(ground, "position"), 0.5 * std::abs(perRadius), [&](double r) { return perRadius * r; }),
	        1e-2);
}

/// Between two radii of given temperature, and with a flux into the inner one.
TEST(Axisymmetry, SteadyHeatBetweenTwoRadiiFollowsTheLogarithm)
{
	citing("Carslaw & Jaeger 1959, 7.2");
	const double a = 0.5, b = 1.5, flux = 10.0, hot = 8.0, cold = 2.0;
	const auto   m     = withoutExpansion();
	const double kappa = m.conductivity(VolumeFractions::of(0.4, 1.0)), rise = flux * a * std::log(b / a) / kappa;
	for (const bool given : { true, false }) {
		auto s = settingsOf({ a, b, 0.05, 1 });
		s.heat.emplace();
		if (given) addBoundary<WallTemperature<2>>(s, Region<2>::side("left"), hot);
		else addBoundary<HeatFlux<2>>(s, Region<2>::side("left"), flux);
		addBoundary<WallTemperature<2>>(s, Region<2>::side("right"), cold);
		Ground<2> ground = filled(s, [&](PointInput<2>& p) { p.temperature = cold; });
		marchTo(ground, 2.5 * (b - a) * (b - a) * m.heatCapacity(VolumeFractions::of(0.4, 1.0)) / kappa);
		const double drop  = given ? hot - cold : rise;
		const auto   exact = [&](double r) { return cold + drop * std::log(b / r) / std::log(b / a); };
		auto         t = ofCells(ground, "temperature"), r = ofCells(ground, "position");
		if (!given) expectSmall("steady heat: flux into the inner radius, error over the rise", errorOf(t, r, drop, exact), 5e-2);
		t.erase(t.begin(), t.begin() + (given ? 0 : 2));
		r.erase(r.begin(), r.begin() + (given ? 0 : 2));
		expectSmall(
		        given ? "steady heat: two temperatures, error over the drop" : "steady heat: the same from the third cell on",
		        errorOf(t, r, drop, exact), 5e-3);
	}
}

/// Exponential integral E1.
TEST(Axisymmetry, ALineSourceWarmsTheGroundAsTheExponentialIntegral)
{
	citing("Carslaw & Jaeger 1959, 10.4");
	const double radius = 0.05, power = 20e3, spacing = 0.0125;
	const auto   m     = withoutExpansion();
	const auto   n     = VolumeFractions::of(0.4, 1.0);
	const double kappa = m.conductivity(n), alpha = kappa / m.heatCapacity(n), perRadian = 0.5 * power * radius * radius;
	auto         s = settingsOf({ 0.0, 2.5, spacing, 1 });
	s.heat.emplace();
	addBoundary<HeatSource<2>>(s, Region<2>::nodeBox({ -1.0, -1.0 }, { radius, 1.0 }), power);
	Ground<2> ground = filled(s, [](PointInput<2>& p) { p.temperature = 2.0; });
	for (const double days : { 2.0, 5.0 }) {
		marchTo(ground, days * 86400.0);
		const auto exact = [&](double r) { return 2.0 - perRadian / (2.0 * kappa) * std::expint(-r * r / (4.0 * alpha * ground.time())); };
		auto       t = ofCells(ground, "temperature"), r = ofCells(ground, "position");
		t.erase(t.begin(), t.begin() + 8);
		r.erase(r.begin(), r.begin() + 8);
		char label[80];
		std::snprintf(label, sizeof label, "line source: after %.0f days, from two radii on, over the rise there", days);
		expectSmall(label, errorOf(t, r, exact(r.front()) - 2.0, exact), 1e-2);
	}
	const double logged = ground.balance().heatIn, given = perRadian * spacing * ground.time();
	expectRelative("line source: heat of the account", logged, given, 5e-3);
}

/// Nixon & McRoberts 1976: ground that creeps by Glen's law around a pile that is pushed down.
TEST(Axisymmetry, APileInCreepingGroundHasThePowerLawVelocity)
{
	citing("Nixon & McRoberts 1976");
	const double a = 0.2, b = 0.6, exponent = 3.0, speed = 0.01, shear = 1e5;
	auto         law = std::make_shared<CreepingSkeleton<2>>();
	law->young       = 3e8;
	// v = 2 A tau_a^n a/(n - 1) (1 - (a/b)^(n - 1)) with the shear stress tau_a at the pile
	const double reach = a / (exponent - 1.0) * (1.0 - std::pow(a / b, exponent - 1.0)), rate = speed / (2.0 * std::pow(shear, exponent) * reach);
	law->rateFactor = [rate](double) { return rate; };
	auto s          = settingsOf({ a, b, 0.02, 1 });
	s.motion.emplace();
	s.skeletons = { law };
	addBoundary<MovingBoundary<2>>(s, Region<2>::side("left"), speed, Vec<2> { 0.0, -1.0 }, true);
	addBoundary<FixedBoundary<2>>(s, Region<2>::side("right"));
	addBoundary<AlongTheAxis>(s, Region<2>::side("bottom"));
	addBoundary<AlongTheAxis>(s, Region<2>::side("top"));
	Ground<2> ground = filled(s);
	marchTo(ground, 0.2);
	const auto before = ofCells(ground, "displacement", 1);
	marchTo(ground, 0.3);
	auto moved = ofCells(ground, "displacement", 1);
	for (std::size_t c = 0; c < moved.size(); ++c)
		moved[c] = (moved[c] - before[c]) / 0.1;
	const auto power = [&](double r) { return std::pow(r, 1.0 - exponent); };
	const auto v     = [&](double r) { return -speed * (power(r) - power(b)) / (power(a) - power(b)); };
	expectSmall("pile in creep: rate of settlement of cells over that of the pile", errorOf(moved, ofCells(ground, "position"), speed, v), 1e-2);
	expectSmall(
	        "pile in creep: shear stress of cells over that at the pile",
	        errorOf(ofCells(ground, "stress", 3), ofCells(ground, "position"), shear, [&](double r) { return shear * a / r; }), 1e-2);
}

namespace {

/// Means of two neighbouring cells, between which explicit pressure alternates.
std::vector<double> pairsOf(const std::vector<double>& cells)
{
	std::vector<double> pairs;
	for (std::size_t c = 0; c + 1 < cells.size(); ++c)
		pairs.push_back(0.5 * (cells[c] + cells[c + 1]));
	return pairs;
}

/// A confined layer around a well.
GroundSettings<2> aquifer(const Ring& ring, double conductivity, double young)
{
	auto s = settingsOf(ring);
	s.motion.emplace();
	s.skeletons = { elastic(young, 0.3) };
	s.water.emplace();
	s.water->permeability.referenceConductivity = conductivity;
	s.water->state.liquidBulkModulus            = 2.2e7;
	for (const char* side : { "left", "right", "bottom", "top" })
		addBoundary<RollerBoundary<2>>(s, Region<2>::side(side));
	return s;
}

double mobilityOf(const GroundSettings<2>& s) { return s.water->permeability.referenceConductivity / (s.mixture.liquid.density * Permeability::gravity); }

} // namespace

/// Thiem 1906: steady flow to a well from a radius whose pressure stays.
TEST(Axisymmetry, SteadyFlowToAWellFollowsThiem)
{
	citing("Thiem 1906");
	const double a = 0.5, b = 3.0, pressure = 2e4;
	for (const bool implicit : { false, true }) {
		auto s              = aquifer({ a, b, 0.05, 1 }, 1e-2, 1e8);
		s.water->implicit   = implicit;
		const char* const m = implicit ? "Thiem, implicit pressure: " : "Thiem: ";
		addBoundary<DrainedBoundary<2>>(s, Region<2>::side("left"), 0.0);
		addBoundary<DrainedBoundary<2>>(s, Region<2>::side("right"), pressure);
		Ground<2> ground = filled(s, [&](PointInput<2>& p) { p.pressure = pressure; });
		marchTo(ground, 0.3);
		const auto r = ofCells(ground, "position"), velocity = ofCells(ground, implicit ? "seepageVelocity" : "liquidVelocity");
		const auto head = [&](double x) { return pressure * std::log(x / a) / std::log(b / a); };
		expectSmall(
		        std::string(m) + "pressure, means of two cells, over the drawdown",
		        errorOf(pairsOf(ofCells(ground, "pressure")), pairsOf(r), pressure, head), 1e-2);
		double flow = 0.0;
		for (std::size_t c = 0; c < r.size(); ++c)
			flow -= 0.4 * velocity[c] * r[c] / r.size();
		expectRelative(
		        std::string(m) + "flow to the well, mean of the cells [m2/s per radian]", flow, mobilityOf(s) * pressure / std::log(b / a), 1e-2);
	}
}

/// Theis 1935: a well that draws water from a layer at a constant rate.
TEST(Axisymmetry, AWellDrawsDownTheLayerAsTheis)
{
	citing("Theis 1935");
	const double a = 0.1, flux = 1e-2, pressure = 1e5, t = 0.4;
	for (const bool implicit : { false, true }) {
		const double young = implicit ? 5e8 : 1e9;
		auto         s     = aquifer({ a, implicit ? 8.1 : 10.1, 0.1, implicit ? 2 : 1 }, 1e-3, young);
		s.water->implicit  = implicit;
		addBoundary<WaterFlux<2>>(s, Region<2>::side("left"), -flux);
		Ground<2> ground = filled(s, [&](PointInput<2>& p) { p.pressure = pressure; });
		marchTo(ground, t);
		const double mobility = mobilityOf(s), storage = 1.0 / LameModuli(young, 0.3).oedometer() + 0.4 / s.water->state.liquidBulkModulus;
		const auto   exact = [&](double r) { return pressure + flux * a / (2.0 * mobility) * std::expint(-r * r * storage / (4.0 * mobility * t)); };
		auto         p = pairsOf(ofCells(ground, "pressure")), r = pairsOf(ofCells(ground, "position"));
		p.erase(p.begin(), p.begin() + 9);
		r.erase(r.begin(), r.begin() + 9);
		expectSmall(
		        std::string(implicit ? "Theis, implicit pressure" : "Theis") + ": pressure from 1 m on, means of two cells, over the drawdown there",
		        errorOf(p, r, pressure - exact(r.front()), exact), 2e-2);
	}
}

/// Barron 1948, free strain: a loaded layer whose grains move along the axis alone gives its water to a drain in its middle.
TEST(Axisymmetry, ALayerConsolidatesAroundASandDrainAsBarron)
{
	citing("Barron 1948, free strain");
	const double a = 0.5, b = 1.5, load = 1e4, young = 1e7, poisson = 0.45; // little stiffness in shear, which the solution has not
	auto         s = settingsOf({ a, b, 0.05, 3 });
	s.motion.emplace();
	s.skeletons                                 = { elastic(young, poisson) };
	s.water.emplace().implicit                  = true;
	s.water->permeability.referenceConductivity = 1e-3;
	for (const char* side : { "left", "right", "bottom" })
		addBoundary<RollerBoundary<2>>(s, Region<2>::side(side));
	addBoundary<AlongTheAxis>(s, Region<2>::nodeBox({ 0.0, -1.0 }, { 2.0, 1.0 }));
	addBoundary<Traction<2>>(s, Region<2>::side("top"), load);
	addBoundary<DrainedBoundary<2>>(s, Region<2>::side("left"), 0.0);
	const double compliance = 1.0 / LameModuli(young, poisson).oedometer(), storage = compliance + 0.4 / s.water->state.liquidBulkModulus;
	const double start = load * compliance / storage, diffusivity = mobilityOf(s) / storage, t = 0.2 / diffusivity;
	Ground<2>    ground = filled(s, [&](PointInput<2>& p) {
                p.pressure  = start;
                p.stress[1] = start - load;
        });
	marchTo(ground, t);
	// sum over the roots of the slope at b of U(x r) = J0(x r) Y0(x a) - Y0(x r) J0(x a)
	const auto product = [&](int order, double x, double r) {
		return std::cyl_bessel_j(order, x * r) * std::cyl_neumann(0, x * a) - std::cyl_neumann(order, x * r) * std::cyl_bessel_j(0, x * a);
	};
	std::vector<double> exact(20, 0.0), radius(20);
	for (int c = 0; c < 20; ++c)
		radius[c] = a + (c + 0.5) * 0.05;
	int modes = 0;
	for (double x = 0.05; modes < 8; x += 0.05) {
		if (product(1, x, b) * product(1, x + 0.05, b) > 0.0) continue;
		double low = x, high = x + 0.05, first = 0.0, square = 0.0;
		while (high - low > 1e-12)
			(product(1, low, b) * product(1, 0.5 * (low + high), b) > 0.0 ? low : high) = 0.5 * (low + high);
		for (int k = 0; k < 2000; ++k) {
			const double r = a + (k + 0.5) / 2000 * (b - a), value = product(0, low, r);
			first += r * value;
			square += r * value * value;
		}
		for (int c = 0; c < 20; ++c)
			exact[c] += start * first / square * product(0, low, radius[c]) * std::exp(-diffusivity * low * low * t);
		++modes;
	}
	const auto found   = ofCells(ground, "pressure");
	double     largest = 0.0;
	for (int c = 0; c < 20; ++c)
		largest = std::max(largest, std::abs(found[c] - exact[c]) / start);
	expectSmall("sand drain, implicit pressure: pressure of cells over that of the start", largest, 1e-2);
}

/// A surface that cuts cells does not let water flow aside.
TEST(Axisymmetry, ARoundColumnConsolidatesAsTerzaghi)
{
	citing("Terzaghi 1943");
	for (const double cut : { 0.0, 0.5 }) {
		const double h = 0.1, height = 1.0 + cut * h, load = 1e4, modulus = 1e7, factor = 0.2;
		auto         s = settingsOf({ 0.0, 0.3, h, 13 });
		s.motion.emplace();
		s.skeletons                                 = { elastic(modulus, 0.0) };
		s.water.emplace().implicit                  = true;
		s.water->permeability.referenceConductivity = 1e-3;
		for (const char* side : { "right", "bottom" })
			addBoundary<RollerBoundary<2>>(s, Region<2>::side(side));
		addBoundary<Traction<2>>(s, Region<2>::freeSurface(), load);
		addBoundary<DrainedBoundary<2>>(s, Region<2>::freeSurface(), 0.0);
		const double storage = 1.0 / modulus + 0.4 / s.water->state.liquidBulkModulus, start = load / modulus / storage;
		const auto   atStart = [&](PointInput<2>& p) {
                        p.pressure  = start;
                        p.stress[1] = start - load;
                        if (p.position[1] < cut * h) p.volume *= cut; // the lowest row is as thick as the part that is cut off
		};
		Ground<2> ground(s);
		fillBox(ground, { 0.0, cut * h }, { 0.3, height }, atStart);
		if (cut > 0.0) fillBox(ground, { 0.0, 0.0 }, { 0.3, cut * h }, atStart);
		ground.initialise();
		marchTo(ground, factor * height * height * storage / mobilityOf(s));
		const auto p = valuesOf(ground, "pressure"), y = valuesOf(ground, "position", 1);
		double     squares = 0.0, aside = 0.0;
		for (std::size_t k = 0; k < p.size(); ++k) {
			const double depth = height - (int(y[k] / h) + 0.5) * h;
			double       exact = 0.0;
			for (int m = 0; m < 40; ++m) {
				const double a = (m + 0.5) * M_PI;
				exact += 2.0 / a * std::sin(a * depth / height) * std::exp(-a * a * factor);
			}
			squares += depth > 0.0 ? std::pow(p[k] / start - exact, 2) / p.size() : 0.0;
			for (std::size_t j = 0; j < k; ++j)
				if (int(y[j] / h) == int(y[k] / h)) aside = std::max(aside, std::abs(p[j] - p[k]) / start);
		}
		const std::string name = cut > 0.0 ? "round column, implicit pressure, surface in the middle of cells: " : "round column, implicit pressure: ";
		expectSmall(name + "rms of the isochrone over the pressure of the start, T_v = 0.2", std::sqrt(squares), cut > 0.0 ? 3e-2 : 1e-2);
		expectSmall(name + "largest difference within a row", aside, 1e-3);
	}
}

/// The strain of thaw closes along the axis, whatever the radius.
TEST(Axisymmetry, AThawingCylinderSettlesByItsThawStrain)
{
	citing("thaw strain times height");
	auto s                     = settingsOf({ 0.0, 0.5, 0.05, 12 });
	s.motion.emplace().gravity = { 0.0, -9.81 };
	s.heat.emplace().source    = 2e4;
	s.heat->thermalTimeScale   = 2e4;
	s.freezing                 = makeFreezingCurve("linear", { { "frozenTemperature", -0.5 } });
	s.skeletons                = { elastic(1e7, 0.3) };
	s.motion->localDamping     = 0.3;
	SoilMaterial soil;
	soil.thawStrain = 0.1;
	s.materials     = { soil };
	for (const char* side : { "right", "bottom" })
		addBoundary<RollerBoundary<2>>(s, Region<2>::side(side));
	Ground<2> ground(s);
	fillBox(
	        ground, { 0.0, 0.0 }, { 0.5, 0.5 }, [](PointInput<2>& p) { p.temperature = -0.6; }, 1);
	ground.initialise();
	marchTo(ground, 0.6);
	double settled = 0.0, aside = 0.0, ice = 0.0;
	for (const double v : valuesOf(ground, "displacement", 1))
		settled = std::min(settled, v);
	for (const double v : valuesOf(ground, "displacement"))
		aside = std::max(aside, std::abs(v));
	for (const double v : valuesOf(ground, "iceSaturation"))
		ice = std::max(ice, v);
	EXPECT_EQ(ice, 0.0);
	expectRelative("thawing cylinder: settlement of the topmost points [m]", -settled, 0.1 * 0.475, 2e-2);
	expectSmall("thawing cylinder: largest displacement aside over it", aside / -settled, 1e-2);
}
