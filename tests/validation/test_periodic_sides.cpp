// SPDX-License-Identifier: GPL-2.0-or-later
// Ground that is repeated behind its sides: slopes without end.
#include "Report.hpp"
#include "Scenes.hpp"

#include <gtest/gtest.h>

#include <numeric>

using namespace talik;
using namespace talik::validation;

namespace {

constexpr double pi = 3.141592653589793, gravity = 9.81, porosity = 0.4, density = 0.6 * 2650.0 + 0.4 * 1000.0, height = 2.0;

double radians(double degrees) { return degrees * pi / 180.0; }

/// Layer on a plane that is inclined, x downhill; so many cells wide.
GroundSettings<2> inclined(double angle, int cells, double spacing)
{
	GroundSettings<2> s;
	s.gridSpacing = spacing;
	s.upper       = { cells * spacing, height + 2.0 * spacing };
	s.mixture     = withoutExpansion();
	s.motion.emplace();
	s.motion->gravity = { gravity * std::sin(radians(angle)), -gravity * std::cos(radians(angle)) };
	addBoundary<PeriodicBoundary<2>>(s, Region<2>::side("left"));
	return s;
}

/// Saturated, in balance, with water that flows parallel to the surface.
Ground<2> soaked(double angle, int cells, bool implicit, double conductivity)
{
	constexpr double spacing = 0.25;
	auto             s       = inclined(angle, cells, spacing);
	addBoundary<FixedBoundary<2>>(s, Region<2>::side("bottom"));
	addBoundary<DrainedBoundary<2>>(s, Region<2>::freeSurface());
	s.motion->localDamping = 0.3;
	s.water.emplace();
	s.water->implicit                           = implicit;
	s.water->permeability.referenceConductivity = conductivity;
	s.water->permeability.referencePorosity     = porosity;
	if (!implicit) s.water->state.liquidBulkModulus = 2.2e7;
	s.skeletons.push_back(elasticOedometer(2e7));
	Ground<2> ground(s);
	fillBox(ground, { 0.0, 0.0 }, { cells * spacing, height }, [&](PointInput<2>& p) {
		const double weight = gravity * (height - p.position[1]), c = std::cos(radians(angle));
		p.porosity  = porosity;
		p.pressure  = 1000.0 * weight * c;
		p.stress[1] = -(density - 1000.0) * weight * c;
		p.stress[3] = density * weight * std::sin(radians(angle));
	});
	ground.initialise();
	return ground;
}

double meanOf(const std::vector<double>& values) { return std::accumulate(values.begin(), values.end(), 0.0) / double(values.size()); }

} // namespace

TEST(PeriodicSides, ABlockSlidesDownAPlaneWithoutFrictionThroughTheSides)
{
	constexpr double spacing = 0.25, duration = 1.5, angle = 20.0;
	for (const bool front : { false, true }) {
		auto s     = inclined(angle, 6, spacing);
		s.upper[1] = 1.5;
		addBoundary<RollerBoundary<2>>(s, Region<2>::side("bottom"));
		s.skeletons.push_back(elasticOedometer(2e6));
		if (front) { // the upper half is thawed, and the front does not slip
			s.heat.emplace();
			s.freezing = makeFreezingCurve();
			auto law   = std::make_shared<MohrCoulombSkeleton<2>>();
			law->young = law->youngFrozen = 2e6;
			law->cohesion = law->cohesionFrozen = law->tensileStrength = law->tensileStrengthFrozen = 1e7;
			s.skeletons                                                                             = { law };
		}
		Ground<2> ground(s);
		fillBox(ground, { 0.25, 0.0 }, { 1.0, 0.75 }, [&](PointInput<2>& p) {
			p.stress[1]   = -0.6 * 2650.0 * gravity * std::cos(radians(angle)) * (0.75 - p.position[1]);
			p.temperature = p.position[1] > 0.375 ? 5.0 : -5.0;
		});
		ground.initialise();
		const auto began = valuesOf(ground, "position");
		marchTo(ground, duration);
		const double      acceleration = gravity * std::sin(radians(angle)), t = ground.time();
		const auto        path = valuesOf(ground, "displacement"), x = valuesOf(ground, "position");
		const auto        b    = ground.balance();
		const double      mass = b.solidMass + b.waterMass;
		const std::string name = front ? "block that slides through periodic sides, half thawed: " : "block that slides through periodic sides: ";
		citing("free sliding, g sin b");
		expectScaled(name + "momentum along the plane", b.momentum[0], mass * acceleration * t, mass * acceleration * t, 1e-11);
		expectRelative(name + "path [m]", meanOf(path), 0.5 * acceleration * t * t, 2e-3);
		citing("exact");
		double spread = 0.0, outside = 0.0, off = 0.0;
		for (std::size_t p = 0; p < path.size(); ++p) {
			spread  = std::max(spread, std::abs(path[p] - path[0]) / 1.5);
			outside = std::max({ outside, -x[p], x[p] - 1.5 });
			off     = std::max(off, std::abs(std::remainder(began[p] + path[p] - x[p], 1.5)));
		}
		expectSmall(name + "difference of paths over the width", spread, 2e-3);
		expectSmall(name + "distance outside of the box [m]", outside, 0.0);
		expectSmall(name + "position less start and path, but for whole widths [m]", off, 1e-12);
		expectSmall(name + "momentum less impulse across the plane over weight and time", (b.momentum[1] - b.impulse[1]) / (mass * gravity * t), 1e-12);
		EXPECT_GT(meanOf(path), 2.0 * 1.5) << "twice round";
	}
}

TEST(PeriodicSides, ATractionShearsTheLayerEvenly)
{
	citing("Hooke");
	constexpr double shear = 5e5, traction = 1e3;
	for (const int cells : { 1, 2, 3 }) {
		auto s                 = inclined(0.0, cells, 0.25);
		s.motion->gravity      = {};
		s.motion->localDamping = 0.3;
		addBoundary<FixedBoundary<2>>(s, Region<2>::side("bottom"));
		addBoundary<Traction<2>>(s, Region<2>::freeSurface(), 0.0, std::vector<TimeTable> { traction, 0.0 });
		auto law    = elasticOedometer(2.0 * shear);
		s.skeletons = { law };
		Ground<2> ground(s);
		fillBox(ground, { 0.0, 0.0 }, { cells * 0.25, height });
		ground.initialise();
		marchTo(ground, 4.0);
		const auto path = valuesOf(ground, "displacement"), up = valuesOf(ground, "displacement", 1), y = valuesOf(ground, "position", 1),
		           stress = valuesOf(ground, "stress", 3);
		double off = 0.0, ofStress = 0.0;
		for (std::size_t p = 0; p < path.size(); ++p) {
			off      = std::max(off, std::abs(path[p] - traction / shear * y[p]) / (traction / shear * height));
			ofStress = std::max(ofStress, std::abs(stress[p] / traction - 1.0));
		}
		const std::string name = "layer that is sheared between periodic sides, " + std::to_string(cells) + " cells: ";
		expectSmall(name + "largest error of a displacement over that of the surface", off, 1e-2);
		expectSmall(name + "largest error of a shear stress", ofStress, 1e-2);
		expectSmall(
		        name + "motion across the layer over that along it, of second order in the strain of 2e-3", largestSize(up) / largestSize(path), 2e-3);
	}
}

TEST(PeriodicSides, HeatFlowsThroughThem)
{
	citing("Carslaw & Jaeger 1959, 3.4");
	constexpr int     cells = 32;
	constexpr double  width = 1.6, shift = 0.7;
	GroundSettings<2> s;
	s.gridSpacing = width / cells;
	s.upper       = { width, 0.4 };
	s.mixture     = withoutExpansion();
	s.heat.emplace();
	addBoundary<PeriodicBoundary<2>>(s, Region<2>::side("right"));
	Ground<2>  ground(s);
	const auto wave = [&](double x) { return std::cos(2.0 * pi * x / width + shift); };
	fillBox(ground, { 0.0, 0.0 }, { width, 0.4 }, [&](PointInput<2>& p) {
		p.porosity    = porosity;
		p.temperature = 10.0 + 4.0 * wave(p.position[0]);
	});
	ground.initialise();
	const double diffusivity = valuesOf(ground, "conductivity")[0] * valuesOf(ground, "volume")[0] / valuesOf(ground, "heatCapacity")[0];
	const double before = ground.balance().enthalpy, rate = diffusivity * std::pow(2.0 * pi / width, 2);
	marchTo(ground, 1.0 / rate);
	const auto x = valuesOf(ground, "position"), found = valuesOf(ground, "temperature");
	double     square = 0.0;
	for (std::size_t p = 0; p < x.size(); ++p)
		square += std::pow((found[p] - 10.0) / 4.0 - std::exp(-1.0) * wave(x[p]), 2) / double(x.size());
	expectSmall("wave of temperature between periodic sides: rms error over the amplitude", std::sqrt(square), 1e-2);
	citing("exact");
	expectSmall(
	        "wave of temperature between periodic sides: change of enthalpy over that of the amplitude",
	        (ground.balance().enthalpy - before) / (4.0 * sumOf(ground, "heatCapacity")), 1e-12);
}

TEST(PeriodicSides, WaterFlowsParallelToASlopeThatRests)
{
	for (const bool implicit : { false, true })
		for (const int cells : { 1, 2, 5 })
			for (const double angle : { 0.0, 15.0 }) {
				constexpr double conductivity = 1e-4;
				Ground<2>        ground       = soaked(angle, cells, implicit, conductivity);
				marchTo(ground, 1.0);
				const double c = std::cos(radians(angle)), due = conductivity * std::sin(radians(angle)) / porosity;
				const auto   y = valuesOf(ground, "position", 1), pressure = valuesOf(ground, "pressure"),
				           path   = valuesOf(ground, "displacement");
				const auto flows  = implicit ? valuesOf(ground, "seepageVelocity") : valuesOf(ground, "liquidVelocity"),
				           across = valuesOf(ground, "displacement", 1);
				double off = 0.0, flow = 0.0;
				int    count = 0;
				for (std::size_t p = 0; p < y.size(); ++p) {
					const double middle = (std::floor(y[p] / 0.25) + 0.5) * 0.25; // of its cell
					// explicit pressure is low in the uppermost cell, and the base holds water that has a velocity of its own
					if (implicit || middle < height - 0.25)
						off = std::max(off, std::abs(pressure[p] - 1000.0 * gravity * c * (height - middle)));
					if (y[p] > 0.5 * height) flow += flows[p], ++count;
				}
				char name[160];
				std::snprintf(
				        name, sizeof(name), "slope of %.0f degrees with seepage along it, %s pressure: ", angle,
				        implicit ? "implicit" : "explicit");
				char of[40];
				std::snprintf(of, sizeof(of), ", %d cells", cells);
				citing("hydrostatic across the slope; Darcy");
				expectSmall(
				        name + std::string("largest error of a pressure over that at the base") + of, off / (1000.0 * gravity * height), 1e-2);
				expectScaled(
				        name + std::string("velocity of the water in the upper half, over k [m/s]") + of, flow / count, due, conductivity,
				        1e-2);
				citing("at rest");
				expectSmall(name + std::string("path along the slope [m]") + of, largestSize(path), 5e-4);
				expectSmall(name + std::string("path across the slope [m]") + of, largestSize(across), 2e-4);
				citing("exact");
				expectSmall(
				        name + std::string("water that has left over all") + of, ground.balance().waterOut / ground.balance().waterMass, 1e-4);
			}
}

namespace {

/// Saturated layer in space, one cell by two, on a smooth base that is inclined along x and y.
Ground<3> slidingInSpace(bool implicit)
{
	constexpr double  spacing = 0.25;
	GroundSettings<3> s;
	s.gridSpacing = spacing;
	s.upper       = { spacing, 2.0 * spacing, 1.0 + 2.0 * spacing };
	s.mixture     = withoutExpansion();
	s.motion.emplace();
	s.motion->gravity = { 2.0, -1.0, -9.0 };
	s.water.emplace();
	s.water->implicit = implicit;
	if (!implicit) s.water->state.liquidBulkModulus = 2.2e7;
	auto law     = std::make_shared<ElasticSkeleton<3>>();
	law->young   = 2e7;
	law->poisson = 0.0;
	s.skeletons.push_back(law);
	for (const char* side : { "left", "back" })
		s.boundaries.push_back(std::make_shared<PeriodicBoundary<3>>(Region<3>::side(side)));
	s.boundaries.push_back(std::make_shared<RollerBoundary<3>>(Region<3>::side("bottom")));
	s.boundaries.push_back(std::make_shared<DrainedBoundary<3>>(Region<3>::freeSurface()));
	Ground<3> ground(s);
	for (int k = 0; k < 64; ++k) {
		PointInput<3> p;
		p.volume    = std::pow(0.5 * spacing, 3);
		p.position  = { (k % 2 + 0.5) * 0.5 * spacing, (k / 2 % 4 + 0.5) * 0.5 * spacing, (k / 8 + 0.5) * 0.5 * spacing };
		p.pressure  = 9000.0 * (1.0 - p.position[2]);
		p.stress[2] = -(density - 1000.0) * 9.0 * (1.0 - p.position[2]);
		ground.addPoint(p);
	}
	ground.initialise();
	return ground;
}

} // namespace

TEST(PeriodicSides, ASaturatedLayerInSpaceSlidesAlongBothAxes)
{
	for (const bool implicit : { false, true }) {
		Ground<3> ground = slidingInSpace(implicit);
		marchTo(ground, 1.0);
		const std::string name = std::string("saturated layer in space that slides, ") + (implicit ? "implicit" : "explicit") + " pressure: ";
		const double      t    = ground.time();
		citing("free sliding, b t^2/2");
		expectRelative(name + "path along x [m]", meanOf(valuesOf(ground, "displacement", 0)), 0.5 * 2.0 * t * t, 5e-3);
		expectRelative(name + "path along y [m]", meanOf(valuesOf(ground, "displacement", 1)), -0.5 * 1.0 * t * t, 5e-3);
		const auto balance = ground.balance();
		citing("exact");
		for (int a = 0; a < 2; ++a)
			expectSmall(
			        name + "momentum less impulse over weight and time, " + "xy"[a],
			        (balance.momentum[a] - balance.impulse[a]) / (9.0 * t * (balance.solidMass + balance.waterMass)), 1e-11);
	}
}
