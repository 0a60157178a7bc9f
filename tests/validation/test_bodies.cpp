// SPDX-License-Identifier: GPL-2.0-or-later
// Rigid bodies that load the ground: not only the force on the body but how it is distributed in the ground, row by row and column by
// column, against closed forms of elasticity and plasticity.
#include "References.hpp"
#include "Report.hpp"
#include "Scenes.hpp"

#include <pkg/mpm/effects/RigidContact.hpp>

#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>
#include <cstdio>

using namespace talik;
using namespace talik::validation;

namespace {

/// A plane without end that pushes along -axis.
RigidBody<2> smoothPlane(double position, int axis)
{
	RigidBody<2> body;
	body.id = body.group = 0;
	body.shape           = &rigidPlane<2>();
	body.side            = -1;
	body.position[axis]  = position;
	body.axes            = axis == 0 ? decltype(body.axes) { { { 1.0, 0.0 }, { 0.0, 1.0 } } } : decltype(body.axes) { { { 0.0, 1.0 }, { -1.0, 0.0 } } };
	return body;
}

/// Moves the only body along an axis from its place by path [m] in a time [s] at constant speed; returns the mean force on it along the
/// axis [N/m] in the last part of that time.
double moveBody(Ground<2>& ground, int axis, double path, double duration, double part, const std::function<void()>& each = {})
{
	RigidBody<2>& body    = ground.bodies()->bodies[0];
	const double  from    = body.position[axis];
	double        counted = 0.0, impulse = 0.0;
	while (ground.time() < duration) {
		const double dt     = std::min(ground.stableTimeStep().step, duration - ground.time() + 1e-12);
		body.position[axis] = from + path * ground.time() / duration;
		body.velocity[axis] = path / duration;
		body.impulse        = {};
		ground.step(dt);
		if (ground.time() < (1.0 - part) * duration) continue;
		impulse += body.impulse[axis];
		counted += dt;
		if (each) each();
	}
	return impulse / counted;
}

/// Means of a field over slabs of the ground, added up over instants; slabs count by the place of the points at the start.
class PressureBands {
public:
	PressureBands(const Ground<2>& ground, int count, const std::function<double(double, double)>& bandOf)
	        : sum_(count, 0.0)
	        , weight_(count, 0.0)
	{
		const auto x = valuesOf(ground, "position", 0), y = valuesOf(ground, "position", 1);
		for (std::size_t p = 0; p < x.size(); ++p)
			band_.push_back(int(std::floor(bandOf(x[p], y[p]))));
	}
	void add(const std::vector<double>& values)
	{
		for (std::size_t p = 0; p < values.size(); ++p)
			if (band_[p] >= 0 && band_[p] < int(sum_.size())) {
				sum_[band_[p]] += values[p];
				weight_[band_[p]] += 1.0;
			}
	}
	double mean(int band) const { return sum_[band] / weight_[band]; }

private:
	std::vector<int>    band_;
	std::vector<double> sum_, weight_;
};

std::shared_ptr<MohrCoulombSkeleton<2>> soil(double young, double cohesion, double friction)
{
	auto law   = std::make_shared<MohrCoulombSkeleton<2>>();
	law->young = law->youngFrozen = young;
	law->poisson                  = 0.3;
	law->cohesion                 = cohesion;
	law->frictionAngle            = friction;
	law->dilationAngle            = 0.0;
	return law;
}

} // namespace

// A plane presses a block between smooth walls: sigma_yy is one number. The plane sinks in by q/k, and the points that it touches lie a
// quarter of a cell below the surface: q = M u/(H - h/4 + M/k).
TEST(Bodies, APlaneLoadsAnOedometerEvenlyInEveryRow)
{
	citing("Hooke");
	constexpr double height = 1.0, young = 1e7, path = 2.9e-3;
	Drawing          drawing("oedometer", "Oedometer under a smooth rigid plane, 8 cells", "height [m]", "vertical stress [kPa]");
	struct Case {
		const char*      shape;
		VelocityTransfer transfer;
		int              cells;
	};
	for (const Case& c : { Case { "quadraticBSpline", VelocityTransfer::flip, 8 }, Case { "quadraticBSpline", VelocityTransfer::flip, 16 },
	                       Case { "quadraticBSpline", VelocityTransfer::apic, 8 }, Case { "gimp", VelocityTransfer::flip, 8 },
	                       Case { "gimp", VelocityTransfer::flip, 16 } }) {
		const double      h = height / c.cells;
		GroundSettings<2> s;
		s.upper         = { 0.5, height + 2 * h };
		s.gridSpacing   = h;
		s.shapeFunction = c.shape;
		s.mixture       = withoutExpansion();
		s.motion.emplace();
		s.motion->transfer     = c.transfer;
		s.motion->localDamping = 0.5;
		s.bodies.emplace();
		standOnRollers(s);
		auto skeleton     = std::make_shared<ElasticSkeleton<2>>();
		skeleton->young   = young;
		skeleton->poisson = 0.3;
		s.skeletons.push_back(skeleton);
		Ground<2> ground(s);
		fillBox(ground, { 0.0, 0.0 }, { 0.5, height });
		ground.initialise();
		const double stiffness = ground.bodies()->stiffness(), modulus = young * 0.7 / (1.3 * 0.4);
		ground.bodies()->bodies = { smoothPlane(height, 1) };
		PressureBands rows(ground, 2 * c.cells, [&](double, double y) { return y / (0.5 * h); });
		moveBody(ground, 1, -path, 0.3, 0.1);
		ground.bodies()->bodies[0].velocity = {};
		for (int k = 0; k < 2000; ++k)
			ground.step(ground.stableTimeStep().step);
		rows.add(valuesOf(ground, "stress", 1));
		const double expected = modulus * path / (height - 0.25 * h + modulus / stiffness);
		double       least = 1e300, most = 0.0;
		const bool   drawn = c.cells == 8 && c.transfer == VelocityTransfer::flip;
		if (drawn) drawing.reference(c.shape, 0.0, height, [=](double) { return 1e-3 * expected; });
		for (int r = 0; r < 2 * c.cells; ++r) {
			least = std::min(least, -rows.mean(r));
			most  = std::max(most, -rows.mean(r));
			if (drawn) drawing.computed(c.shape, (r + 0.5) * 0.5 * h, -1e-3 * rows.mean(r));
		}
		char label[96];
		std::snprintf(
		        label, sizeof label, "oedometer under a plane, %s, %s, %d cells: ", c.shape, velocityTransferNames()[int(c.transfer)].c_str(), c.cells);
		expectRelative(label + std::string("stress of the row with the least [Pa]"), least, expected, 0.02);
		expectRelative(label + std::string("stress of the row with the most [Pa]"), most, expected, 0.02);
	}
}

// Prandtl 1920: a strip on weightless cohesive ground bears (2 + pi) c, evenly, be it rough or smooth, before it sinks in: at two cells of
// settlement it bears a tenth more.
namespace {

struct Footing {
	const char* shape;
	double      friction;
};

void expectFootingsToBear(const std::string& file, const std::vector<Footing>& footings)
{
	citing("Prandtl 1920");
	constexpr double cohesion = 10e3, half = 1.0, bearing = 2.0 + reference::pi;
	Drawing          drawing(
	                 file, "Strip footing on cohesive ground, 16 cells under it", "distance from the middle over half the width [-]",
	                 "contact pressure over cohesion [-]");
	for (const auto& [shape, friction] : footings) {
		const double      h = half / 8;
		GroundSettings<2> s;
		s.upper         = { 4.5, 3.0 };
		s.gridSpacing   = h;
		s.shapeFunction = shape;
		s.mixture       = withoutExpansion();
		s.motion.emplace();
		s.motion->localDamping = 0.3;
		s.bodies.emplace();
		addBoundary<RollerBoundary<2>>(s, Region<2>::side("left"));
		addBoundary<RollerBoundary<2>>(s, Region<2>::side("right"));
		addBoundary<FixedBoundary<2>>(s, Region<2>::side("bottom"));
		auto clay             = soil(1e8, cohesion, 0.0);
		clay->poisson         = 0.4;
		clay->tensileStrength = 1e6;
		s.skeletons.push_back(clay);
		Ground<2> ground(s);
		fillBox(ground, { 0.0, 0.0 }, { 4.5, 2.5 });
		ground.initialise();
		RigidBody<2> footing    = smoothPlane(0.0, 0);
		footing.shape           = &rigidBox<2>();
		footing.size            = { half, 0.5 };
		footing.position        = { 0.0, 3.0 };
		footing.friction        = friction;
		ground.bodies()->bodies = { footing };
		// of the first cell below the surface: what is below the footing but above the fans
		PressureBands     columns(ground, 4, [&](double x, double y) { return y > 2.5 - h ? 4.0 * x / half : -1.0; });
		const double      force  = moveBody(ground, 1, -0.012 * half, 0.6, 0.3, [&] { columns.add(valuesOf(ground, "stress", 1)); });
		const std::string label  = std::string("footing, ") + shape + (friction > 0.0 ? ", rough: " : ", smooth: "),
		                  series = std::string(shape) + (friction > 0.0 ? ", rough" : ", smooth");
		expectRelative(label + "bearing capacity over cohesion", force / (half * cohesion), bearing, 0.05);
		drawing.reference(series, 0.0, 1.0, [](double) { return bearing; });
		for (int q = 0; q < 4; ++q)
			drawing.computed(series, 0.25 * q + 0.125, -columns.mean(q) / cohesion);
		for (int q = 0; q < 3; ++q)
			expectRelative(
			        label + "contact pressure over cohesion, quarter " + std::to_string(q + 1) + " from the middle", -columns.mean(q) / cohesion,
			        bearing, 0.10);
	}
}

} // namespace

TEST(Bodies, AFootingOnCohesiveGroundBearsThePressureOfPrandtlEvenly) { expectFootingsToBear("footing", { { "quadraticBSpline", 0.7 } }); }

TEST(Bodies, SmoothFootingsOnCohesiveGroundBearThePressureOfPrandtlEvenly_slow)
{
	expectFootingsToBear("footing_smooth", { { "quadraticBSpline", 0.0 }, { "gimp", 0.0 } });
}

// Rankine 1857: a smooth wall that moves away from or into cohesionless ground bears K gamma z, K = tan^2(45 deg -+ phi/2).
namespace {

void expectPressureOfRankine(bool active, const std::string& file)
{
	citing("Rankine 1857");
	constexpr double  height = 1.0, weight = 0.6 * 2650.0 * 9.81, angle = 30.0;
	constexpr int     cells = 16, layers = 4;
	Drawing           drawing(file, "Smooth rigid wall, 16 cells high", "depth of the layer [m]", "pressure over gamma z [-]");
	const double      h = height / cells, sine = std::sin(angle * reference::pi / 180.0), rest = 1.0 - sine;
	const double      expected = active ? (1.0 - sine) / (1.0 + sine) : (1.0 + sine) / (1.0 - sine);
	GroundSettings<2> s;
	s.upper       = { 2.0 + 2 * h, height + 4 * h };
	s.gridSpacing = h;
	s.mixture     = withoutExpansion();
	s.motion.emplace();
	s.motion->gravity      = { 0.0, -9.81 };
	s.motion->localDamping = 0.3;
	s.bodies.emplace();
	addBoundary<RollerBoundary<2>>(s, Region<2>::side("left"));
	addBoundary<RollerBoundary<2>>(s, Region<2>::side("bottom"));
	auto sand             = soil(2e7, 0.0, angle);
	sand->tensileStrength = 0.0;
	s.skeletons.push_back(sand);
	Ground<2> ground(s);
	fillBox(ground, { 0.0, 0.0 }, { 2.0, height }, [&](PointInput<2>& p) {
		const double vertical = -weight * (height - p.position[1]);
		p.stress              = { rest * vertical, vertical, rest * vertical, 0.0 };
	});
	ground.initialise();
	ground.bodies()->bodies = { smoothPlane(2.0, 0) };
	// by depth, of the two cells at the wall
	PressureBands     depth(ground, layers, [&](double x, double y) { return x > 2.0 - 2 * h ? layers * (height - y) / height : -1.0; });
	const double      force = moveBody(ground, 0, active ? 0.01 : -0.03, 1.0, 0.5, [&] { depth.add(valuesOf(ground, "stress", 0)); });
	const std::string label = std::string("wall, ") + (active ? "active: " : "passive: "), series = active ? "active" : "passive";
	expectRelative(label + "force over gamma H^2/2", force / (0.5 * weight * height * height), expected, 0.05);
	drawing.reference(series, 0.0, height, [=](double) { return expected; });
	for (int layer = 0; layer < layers; ++layer) {
		const double ratio = -depth.mean(layer) / (weight * height * (layer + 0.5) / layers);
		drawing.computed(series, height * (layer + 0.5) / layers, ratio);
		if (layer > 0)
			expectRelative(
			        label + "pressure over gamma z, quarter " + std::to_string(layer + 1) + " of the height from the top", ratio, expected, 0.10);
	}
}

} // namespace

TEST(Bodies, AWallThatYieldsBearsThePressureOfRankineLayerByLayer) { expectPressureOfRankine(true, "wall"); }

TEST(Bodies, AWallThatPushesBearsThePressureOfRankineLayerByLayer_slow) { expectPressureOfRankine(false, "wall_passive"); }

// The wall is there when ground and water are put beside it, and bears K_0 gamma' H^2/2 + gamma_w H^2/2 from the first step on, also where
// a rough floor keeps the ground from following a wall that gives way.
namespace {

void expectWallAtRest(int cells)
{
	citing("K_0 gamma' H^2/2 + gamma_w H^2/2");
	constexpr double height = 3.0, g = 9.81, porosity = 0.4, poisson = 0.3, rest = poisson / (1.0 - poisson);
	const double     buoyant = (1.0 - porosity) * (2650.0 - 1000.0) * g, water = 1000.0 * g;
	for (const bool wet : { false, true }) {
		const double      h = height / cells;
		GroundSettings<2> s;
		s.upper       = { 6.0 + h, height + 2 * h };
		s.gridSpacing = h;
		s.mixture     = withoutExpansion();
		s.motion.emplace();
		s.motion->gravity      = { 0.0, -g };
		s.motion->localDamping = 0.3;
		s.bodies.emplace();
		if (wet) {
			s.water.emplace();
			s.water->state.liquidBulkModulus            = 2.2e7;
			s.water->permeability.referenceConductivity = 1e-4;
		}
		addBoundary<RollerBoundary<2>>(s, Region<2>::side("left"));
		addBoundary<FixedBoundary<2>>(s, Region<2>::side("bottom"));
		auto elastic     = std::make_shared<ElasticSkeleton<2>>();
		elastic->young   = 1e7;
		elastic->poisson = poisson;
		s.skeletons.push_back(elastic);
		Ground<2>    ground(s);
		const double effective = wet ? buoyant : (1.0 - porosity) * 2650.0 * g;
		fillBox(ground, { 0.0, 0.0 }, { 6.0, height }, [&](PointInput<2>& p) {
			const double depth = height - p.position[1], vertical = -effective * depth;
			p.porosity = porosity;
			p.stress   = { rest * vertical, vertical, rest * vertical, 0.0 };
			p.pressure = wet ? water * depth : 0.0;
		});
		ground.initialise();
		ground.bodies()->bodies = { smoothPlane(6.0, 0) };
		const double force      = moveBody(ground, 0, 0.0, 1.0, 0.3);
		char         label[80];
		std::snprintf(label, sizeof label, "wall beside a fixed floor, %s, %d cells: force [N/m]", wet ? "saturated" : "dry", cells);
		expectRelative(label, force, 0.5 * height * height * (rest * effective + (wet ? water : 0.0)), 0.03);
	}
}

} // namespace

TEST(Bodies, AWallBesideAFixedFloorBearsGroundAtRestAndWater) { expectWallAtRest(6); }

TEST(Bodies, AWallOfMoreCellsBesideAFixedFloorBearsGroundAtRestAndWater_slow) { expectWallAtRest(12); }

// Ground of +4 degC between walls, air of -15 degC: a wall that is a body shades the ground behind it as an insulated side of the box does.
TEST(Bodies, AWallShadesTheGroundThatItTouchesFromTheAir)
{
	citing("the same between insulated sides");
	constexpr double    height = 1.0, width = 1.5, air = -15.0, days = 10.0;
	constexpr int       cells = 8;
	const double        h     = height / cells;
	std::vector<double> temperature[2];
	for (const bool body : { false, true }) {
		GroundSettings<2> s;
		s.upper       = { body ? width + 4 * h : width, height + 2 * h };
		s.gridSpacing = h;
		s.mixture     = withoutExpansion();
		s.poreFill    = 0.0;
		s.motion.emplace();
		s.motion->gravity      = { 0.0, -9.81 };
		s.motion->localDamping = 0.3;
		s.heat.emplace();
		s.heat->thermalTimeScale = days * 86400.0;
		addBoundary<RollerBoundary<2>>(s, Region<2>::side("left"));
		addBoundary<RollerBoundary<2>>(s, Region<2>::side("bottom"));
		if (!body) addBoundary<RollerBoundary<2>>(s, Region<2>::side("right"));
		addBoundary<SurfaceTemperature<2>>(s, Region<2>::freeSurface(), air);
		if (body) s.bodies.emplace();
		auto elastic     = std::make_shared<ElasticSkeleton<2>>();
		elastic->young   = 1e7;
		elastic->poisson = 0.3;
		s.skeletons.push_back(elastic);
		Ground<2>    ground(s);
		const double weight = 0.6 * 2650.0 * 9.81;
		fillBox(ground, { 0.0, 0.0 }, { width, height }, [&](PointInput<2>& p) {
			const double vertical = -weight * (height - p.position[1]);
			p.stress              = { 3.0 / 7.0 * vertical, vertical, 3.0 / 7.0 * vertical, 0.0 };
			p.temperature         = 4.0;
		});
		ground.initialise();
		if (body) ground.bodies()->bodies = { smoothPlane(width, 0) };
		marchTo(ground, 1.0);
		temperature[body] = valuesOf(ground, "temperature");
	}
	double worst = 0.0, behind = 0.0, count = 0.0;
	for (int j = 0; j < 2 * cells; ++j)
		for (int i = 0; i < 24; ++i) {
			const int p = j * 24 + i;
			worst       = std::max(worst, std::abs(temperature[1][p] - temperature[0][p]));
			if (i < 20) continue;
			behind += temperature[1][p] - temperature[0][p];
			count += 1.0;
		}
	expectSmall("wall that shades the ground: temperature behind it off that at an insulated side, mean of two cells [degC]", behind / count, 0.2);
	expectSmall("wall that shades the ground: the same, any point, over the jump of 19 degC", worst / 19.0, 0.05);
}

// ---- bodies with a temperature ---------------------------------------------------------------------------------------------

namespace {

constexpr double warm = 10.0, cold = 0.0;

/// Ground that lets heat and time pass quickly and hardly moves, with bodies above, in or beside it.
GroundSettings<2> heatedSettings(double h, const Vec<2>& upper, double timeScale)
{
	GroundSettings<2> s;
	s.upper       = upper;
	s.gridSpacing = h;
	s.mixture     = withoutExpansion();
	s.motion.emplace();
	s.heat.emplace();
	s.heat->thermalTimeScale = timeScale;
	s.skeletons.push_back(elasticOedometer(1e6));
	s.bodies.emplace();
	return s;
}

double conductivityOf(const GroundSettings<2>& s) { return s.mixture.conductivity(VolumeFractions::of(0.4, 1.0)); }

/// Slope of values over places by least squares.
double slopeOf(const std::vector<double>& places, const std::vector<double>& values)
{
	double n = 0.0, x = 0.0, y = 0.0, xx = 0.0, xy = 0.0;
	for (std::size_t k = 0; k < places.size(); ++k)
		n += 1.0, x += places[k], y += values[k], xx += places[k] * places[k], xy += places[k] * values[k];
	return (n * xy - x * y) / (n * xx - x * x);
}

RigidBody<2> still(const RigidShape<2>& shape, const Vec<2>& position, const Vec<2>& size, int id = 0)
{
	RigidBody<2> body;
	body.id = body.group = id;
	body.shape           = &shape;
	body.position        = position;
	body.size            = size;
	body.axes            = { { { 1.0, 0.0 }, { 0.0, 1.0 } } };
	return body;
}

} // namespace

namespace {

void expectHeatOfAPlate(const char* shape)
{
	citing("Fourier, resistances in series");
	constexpr double height = 1.0;
	constexpr int    cells  = 20;
	const double     h      = height / cells;
	for (const double share : { 0.0, 1.0, 4.0 }) { // of the ground's own resistance
		auto         s     = heatedSettings(h, { h, height + 2 * h }, 3e6);
		const double kappa = conductivityOf(s), own = height / kappa;
		s.shapeFunction = shape;
		s.skeletons     = { elasticOedometer(1e7) };
		standOnRollers(s);
		addBoundary<WallTemperature<2>>(s, Region<2>::side("bottom"), cold);
		addBoundary<BodyTemperature<2>>(s, std::vector<int> { 3 }, warm, share * own);
		Ground<2> ground(s);
		fillBox(ground, { 0.0, 0.0 }, { h, height }, [](PointInput<2>& p) { p.temperature = cold; });
		ground.initialise();
		ground.bodies()->bodies       = { smoothPlane(height, 1) };
		ground.bodies()->bodies[0].id = ground.bodies()->bodies[0].group = 3;
		marchTo(ground, 4.0);
		char label[100];
		std::snprintf(label, sizeof label, "plate of 10 degC, R = %.0f L/kappa, %s: heat flow through the layer [W/m2]", share, shape);
		expectRelative(
		        label, kappa * slopeOf(valuesOf(ground, "position", 1), valuesOf(ground, "temperature")), (warm - cold) / ((1.0 + share) * own), 0.02);
	}
}

} // namespace

TEST(Bodies, APlateOfGivenTemperatureSendsTheHeatOfItsResistanceAndTheGroundsInSeriesThroughALayer) { expectHeatOfAPlate("quadraticBSpline"); }

TEST(Bodies, APlateSendsItsHeatThroughALayerWithGimp_slow) { expectHeatOfAPlate("gimp"); }

namespace {

void expectHeatOfAPipe(double h)
{
	citing("Carslaw & Jaeger 1959, hollow cylinder");
	const double inner = 0.5, outer = 2.0; // a quarter between planes of symmetry
	for (const double share : { 0.0, 1.0 }) {
		const double box   = outer + 3 * h;
		auto         s     = heatedSettings(h, { box, box }, 2e6);
		const double kappa = conductivityOf(s), own = inner * std::log(outer / inner) / kappa; // per area of the pipe
		for (const char* side : { "left", "bottom" })
			addBoundary<RollerBoundary<2>>(s, Region<2>::side(side));
		addBoundary<SurfaceTemperature<2>>(s, Region<2>::freeSurface(), cold);
		addBoundary<BodyTemperature<2>>(s, std::vector<int> { 0 }, warm, share * own);
		Ground<2>    ground(s);
		const double d = 0.5 * h;
		for (double y = 0.5 * d; y < box; y += d)
			for (double x = 0.5 * d; x < box; x += d) {
				const double r = std::hypot(x, y);
				if (r < inner || r > outer) continue;
				PointInput<2> p;
				p.position    = { x, y };
				p.volume      = d * d;
				p.porosity    = 0.4;
				p.temperature = cold;
				ground.addPoint(p);
			}
		ground.initialise();
		ground.bodies()->bodies = { still(rigidBall<2>(), { 0.0, 0.0 }, { inner, inner }) };
		marchTo(ground, 6.0);
		const auto          x = valuesOf(ground, "position", 0), y = valuesOf(ground, "position", 1), t = valuesOf(ground, "temperature");
		std::vector<double> logs, values;
		for (std::size_t k = 0; k < t.size(); ++k) {
			const double r = std::hypot(x[k], y[k]);
			if (r < inner + 2 * h || r > outer - 2 * h) continue;
			logs.push_back(std::log(r));
			values.push_back(t[k]);
		}
		char label[100];
		std::snprintf(label, sizeof label, "pipe of 10 degC, %.0f cells across, R = %.0f of the ground's: heat per length [W/m]", 2 * inner / h, share);
		expectRelative(
		        label, -2.0 * reference::pi * kappa * slopeOf(logs, values), 2.0 * reference::pi * inner * (warm - cold) / ((1.0 + share) * own),
		        h > 0.1 ? 0.08 : 0.04); // its area is counted by whole points
	}
}

} // namespace

TEST(Bodies, APipeInTheGroundGivesTheHeatOfConcentricCylinders) { expectHeatOfAPipe(0.125); }

TEST(Bodies, APipeInTheGroundGivesTheHeatOfConcentricCylindersOnAFineGrid_slow) { expectHeatOfAPipe(0.0625); }

// Where it is now: the ground that the plate left only cools, that which it reached warms as the other did before.
TEST(Bodies, AWarmPlateThatIsMovedWarmsTheGroundWhereItIsAndOneThatIsLiftedNone)
{
	citing("the same body one metre before");
	const double h = 0.1, height = 0.5;
	auto         s = heatedSettings(h, { 2.0, height + 3 * h }, 1e6);
	standOnRollers(s);
	addBoundary<BodyTemperature<2>>(s, std::vector<int> { 0 }, warm);
	Ground<2> ground(s);
	fillBox(ground, { 0.0, 0.0 }, { 2.0, height }, [](PointInput<2>& p) { p.temperature = cold; });
	ground.initialise();
	auto& bodies = ground.bodies()->bodies;
	bodies       = { still(rigidBox<2>(), { 0.5, height + 0.1 }, { 0.2, 0.1 }) };
	marchTo(ground, 0.03);
	const auto   first = valuesOf(ground, "temperature");
	const double heat  = ground.balance().heatIn;
	bodies[0].position[0] += 1.0;
	marchTo(ground, 0.06);
	const auto then  = valuesOf(ground, "temperature");
	double     worst = 0.0, warmed = 0.0;
	for (int j = 0; j < 10; ++j)
		for (int i = 6; i < 14; ++i) {
			worst  = std::max(worst, std::abs(then[j * 40 + i + 20] - first[j * 40 + i]));
			warmed = std::max(warmed, first[j * 40 + i]);
		}
	EXPECT_GT(warmed, 1.0);
	expectSmall("warm plate moved by a metre: temperatures below it off those below its former place, over the largest", worst / warmed, 0.01);
	expectRelative("warm plate moved by a metre: heat in the second period over that in the first", (ground.balance().heatIn - heat) / heat, 1.0, 0.01);
	const double before = ground.balance().heatIn;
	bodies[0].position[1] += 0.6 * h;
	marchTo(ground, 0.09);
	expectSmall(
	        "warm plate lifted off by more than half a point: heat that still enters, over that before", (ground.balance().heatIn - before) / before, 0.0);
}
