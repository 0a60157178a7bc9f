// SPDX-License-Identifier: GPL-2.0-or-later
// What has to hold to round-off: mass of solid and water, momentum, heat; and pressure that must not push by itself.
#include "References.hpp"
#include "Report.hpp"
#include "Scenes.hpp"

#include <gtest/gtest.h>

#include <algorithm>
#include <omp.h>

using namespace talik;
using namespace talik::validation;

namespace {

GroundSettings<2> freezingSoil(double spacing)
{
	GroundSettings<2> s;
	s.gridSpacing = spacing;
	s.mixture     = MixtureProperties();
	s.motion.emplace();
	s.heat.emplace();
	s.freezing = makeFreezingCurve();
	s.water.emplace();
	s.water->state.liquidBulkModulus = 2.2e7;
	s.water->state.iceBulkModulus    = 8.8e7;
	s.skeletons.push_back(elasticOedometer(1e7));
	return s;
}

struct Drift {
	double solid, water, momentum, heat, seeped;
};

/// Marches and compares the balance before and after; momentum against the logged impulse, heat against logged heat.
Drift drift(Ground<2>& ground, int steps, double dt)
{
	const auto before = ground.balance();
	const auto water  = valuesOf(ground, "waterMass");
	double     path   = 0.0;
	for (int k = 0; k < steps; ++k) {
		ground.step(dt);
		if (k % 50 != 0) continue;
		const auto now = ground.balance();
		path           = std::max(path, std::sqrt(2.0 * now.kineticEnergy * (now.solidMass + now.waterMass)));
	}
	const auto after  = ground.balance();
	const auto water1 = valuesOf(ground, "waterMass");
	double     moved  = 0.0;
	for (std::size_t p = 0; p < water.size(); ++p)
		moved += 0.5 * std::abs(water1[p] - water[p]);
	double residual = 0.0, size = path;
	for (int a = 0; a < 2; ++a) {
		residual = std::max(residual, std::abs(after.momentum[a] - before.momentum[a] - (after.impulse[a] - before.impulse[a])));
		size     = std::max(size, std::abs(after.impulse[a]));
	}
	return { after.solidMass / before.solidMass - 1.0, (after.waterMass + after.waterOut - before.waterMass) / before.waterMass, residual / size,
		 (after.enthalpy + after.enthalpyOut - before.enthalpy - after.heatIn) / before.enthalpy, moved / before.waterMass };
}

void expectConserved(const std::string& name, const Drift& d, double seepedAtLeast)
{
	expectSmall(name + ": drift of solid mass", d.solid, 1e-14);
	expectSmall(name + ": drift of ice and water", d.water, 1e-13);
	expectSmall(name + ": momentum less impulse", d.momentum, 1e-11);
	expectSmall(name + ": drift of heat", d.heat, 1e-12);
	expectAtLeast(name + ": share of water that moved between points", d.seeped, seepedAtLeast);
}

} // namespace

TEST(Conservation, FloatingBlockWithSeepageKeepsMassMomentumAndHeat)
{
	auto s            = freezingSoil(0.1);
	s.lower           = { 0.0, 0.0 };
	s.upper           = { 2.0, 1.6 };
	s.motion->gravity = { 0.0, 0.0 };
	Ground<2> ground(s);
	fillBox(ground, { 0.4, 0.4 }, { 1.6, 1.2 }, [](PointInput<2>& p) {
		p.temperature = p.position[0] < 0.9 ? 8.0 : p.position[0] < 1.2 ? 1.0 : -2.0;
		p.pressure    = p.position[1] < 0.8 ? 4e4 : 1e4;
	});
	ground.initialise();
	const double dt = ground.stableTimeStep().step;
	expectConserved("floating block, thawed and frozen, seepage, 2000 steps", drift(ground, 2000, dt), 1e-5);
}

TEST(Conservation, SealedBoxUnderGravityKeepsMassMomentumAndHeat)
{
	auto s                      = freezingSoil(0.1);
	s.lower                     = { 0.0, 0.0 };
	s.upper                     = { 1.0, 1.0 };
	s.motion->gravity           = { 0.0, -9.81 };
	s.heat->thermalTimeScale    = 1e5;
	s.water->hydraulicTimeScale = 1.0;
	for (const char* side : { "left", "right", "bottom", "top" })
		addBoundary<RollerBoundary<2>>(s, Region<2>::side(side));
	Ground<2> ground(s);
	fillBox(ground, { 0.0, 0.0 }, { 1.0, 1.0 }, [](PointInput<2>& p) {
		p.temperature = p.position[0] < 0.5 ? 5.0 : -1.0;
		p.pressure    = 3e4;
	});
	ground.initialise();
	const double dt = ground.stableTimeStep().step;
	expectConserved("sealed box under gravity, thawing front, 2000 steps", drift(ground, 2000, dt), 1e-6);
}

TEST(Conservation, DrainedAndHeatedColumnAccountsForEverythingThatCrossesItsSurface)
{
	auto s                      = freezingSoil(0.1);
	s.lower                     = { 0.0, 0.0 };
	s.upper                     = { 0.4, 1.4 };
	s.motion->gravity           = { 0.0, -9.81 };
	s.heat->thermalTimeScale    = 1e5;
	s.water->hydraulicTimeScale = 1.0;
	standOnRollers(s);
	addBoundary<DrainedBoundary<2>>(s, Region<2>::freeSurface());
	addBoundary<Traction<2>>(s, Region<2>::freeSurface(), 2e4);
	addBoundary<SurfaceTemperature<2>>(s, Region<2>::freeSurface(), 10.0);
	Ground<2> ground(s);
	fillBox(ground, { 0.0, 0.0 }, { 0.4, 1.0 }, [](PointInput<2>& p) {
		p.temperature = -1.0;
		p.pressure    = 2e4;
	});
	ground.initialise();
	const double dt = ground.stableTimeStep().step;
	const auto   d  = drift(ground, 4000, dt);
	expectConserved("drained, loaded and thawed column, 4000 steps", d, 1e-7);
	EXPECT_NE(ground.balance().waterOut, 0.0);
	EXPECT_GT(ground.balance().heatIn, 0.0);
}

// A weak form that differentiates n_l p instead of p would push with 3.8e4 N/m^2 here (jump of n_l from 0.4 to 0.02)
TEST(Conservation, UniformPorePressureAtAnIceFrontMovesNothing)
{
	auto s                   = freezingSoil(0.05);
	s.mixture                = withoutExpansion();
	s.lower                  = { 0.0, 0.0 };
	s.upper                  = { 1.0, 0.1 };
	s.heat->thermalTimeScale = 1e-9;
	for (const char* side : { "left", "right", "bottom", "top" })
		addBoundary<RollerBoundary<2>>(s, Region<2>::side(side));
	Ground<2> ground(s);
	fillBox(ground, { 0.0, 0.0 }, { 1.0, 0.1 }, [](PointInput<2>& p) {
		p.temperature = p.position[0] < 0.5 ? 2.0 : -3.0;
		p.pressure    = 1e5;
	});
	ground.initialise();
	const double dt = ground.stableTimeStep().step;
	for (int k = 0; k < 1000; ++k)
		ground.step(dt);
	const double forceScale = 1e5 * 1000.0 * dt / (0.05 * 1000.0); // speed the wrong force would give: p t/(h rho)
	expectSmall(
	        "uniform pressure at an ice front: solid speed over p t/(h rho), 1000 steps", largestSize(valuesOf(ground, "velocity", 0)) / forceScale, 1e-12);
	expectSmall(
	        "uniform pressure at an ice front: liquid speed over p t/(h rho), 1000 steps", largestSize(valuesOf(ground, "liquidVelocity", 0)) / forceScale,
	        1e-12);
	auto       pressure = valuesOf(ground, "pressure");
	const auto x = valuesOf(ground, "position", 0), ice = valuesOf(ground, "iceSaturation");
	Drawing    drawing("ice_front", "Uniform pore pressure at an ice front after 1000 steps", "distance [m]", "p/p at the start, ice saturation [-]");
	for (std::size_t k = 0; k < x.size(); ++k) {
		drawing.computed("pressure", x[k], pressure[k] / 1e5);
		drawing.computed("ice", x[k], ice[k]);
	}
	drawing.reference("pressure", 0.0, 1.0, [](double) { return 1.0; });
	for (double& p : pressure)
		p = p / 1e5 - 1.0;
	expectSmall("uniform pressure at an ice front: change of p over p, 1000 steps", largestSize(pressure), 1e-9);
}

namespace {

/// One sealed cell of four points at rest; the first two hold a little more water than their pores at the common pressure, the others less.
Ground<2> unevenCell(double temperature, double conductivity)
{
	constexpr double h                          = 0.1;
	auto             s                          = freezingSoil(h);
	s.lower                                     = { 0.0, 0.0 };
	s.upper                                     = { h, h };
	s.motion->gravity                           = { 0.0, 0.0 };
	s.heat->thermalTimeScale                    = 1e-9;
	s.water->permeability.referenceConductivity = conductivity;
	s.water->hydraulicTimeScale                 = 1.0;
	for (const std::string side : { "left", "right", "bottom", "top" })
		s.boundaries.push_back(std::make_shared<RollerBoundary<2>>(Region<2>::side(side)));
	Ground<2> ground(s);
	int       number = 0;
	fillBox(ground, { 0.0, 0.0 }, { h, h }, [&](PointInput<2>& p) {
		p.temperature = temperature;
		p.pressure    = number++ < 2 ? 1.5e4 : 0.5e4;
	});
	ground.initialise();
	return ground;
}

} // namespace

// What the points of a cell have too much and too little decays by 1 + s in a step, s = dt 2 k/(rho g c) with c = V n/K_w: the flow between
// the halves of a cell of edge h is k/(rho g) h/(h/2) times the difference of their pressures.
TEST(Conservation, PointThatHoldsMoreThanItsPoresHandsItToTheOthersOfItsCell)
{
	constexpr double conductivity = 4e-7, dt = 2e-5, bulkModulus = 2.2e7, pointVolume = 0.05 * 0.05, porosity = 0.4;
	const auto       difference = [](const Ground<2>& ground) {
                const auto water = valuesOf(ground, "waterMass");
                return water[0] + water[1] - water[2] - water[3];
	};
	Ground<2>    ground = unevenCell(5.0, conductivity);
	const double before = difference(ground), rate = dt * 2.0 * conductivity / (1000.0 * 9.81) * bulkModulus / (pointVolume * porosity);
	const int    steps = int(std::lround(1.0 / rate));
	const Drift  d     = drift(ground, steps, dt);
	expectRelative("uneven cell: difference of its points after the time of levelling", difference(ground) / before, std::pow(1.0 + rate, -steps), 0.01);
	expectSmall("uneven cell: drift of ice and water", d.water, 1e-13);
	expectSmall("uneven cell: drift of heat", d.heat, 1e-12);
	Ground<2>    frozen = unevenCell(-5.0, conductivity);
	const double kept   = difference(frozen);
	drift(frozen, steps, dt);
	expectRelative("uneven cell, frozen: difference of its points after the same time", difference(frozen) / kept, 1.0, 1e-3);
}

TEST(Conservation, HydrostaticColumnStaysAtRest)
{
	auto s     = freezingSoil(0.1);
	s.freezing = nullptr;
	s.heat.reset();
	s.mixture         = withoutExpansion();
	s.lower           = { 0.0, 0.0 };
	s.upper           = { 0.2, 1.4 };
	s.motion->gravity = { 0.0, -9.81 };
	standOnRollers(s);
	addBoundary<DrainedBoundary<2>>(s, Region<2>::freeSurface());
	Ground<2> ground(s);
	fillBox(ground, { 0.0, 0.0 }, { 0.2, 1.0 }, [](PointInput<2>& p) {
		const double depth    = 1.0 - p.position[1];
		const double vertical = -0.6 * (2650.0 - 1000.0) * 9.81 * depth;
		p.pressure            = 1000.0 * 9.81 * depth;
		p.stress              = { 0.0, vertical, 0.0, 0.0 };
	});
	ground.initialise();
	const auto y0 = valuesOf(ground, "position", 1);
	marchTo(ground, 1.0);
	const auto y = valuesOf(ground, "position", 1), p = valuesOf(ground, "pressure");
	double     moved = 0.0, changed = 0.0;
	for (std::size_t k = 0; k < y.size(); ++k) {
		moved               = std::max(moved, std::abs(y[k] - y0[k]));
		const double middle = (std::floor(y0[k] / 0.1) + 0.5) * 0.1; // pore pressure is one value per cell
		changed             = std::max(changed, std::abs(p[k] - 9810.0 * (1.0 - middle)));
	}
	// the elastic column would settle by 8e-4 m under its own submerged weight if the initial stress did not carry it
	expectSmall("hydrostatic column, 1 s: largest displacement over self-weight settlement", moved / 8.1e-4, 5e-2);
	expectSmall("hydrostatic column, 1 s: largest change of p over rho g H", changed / 9810.0, 5e-2);
}

TEST(Conservation, ResultsHaveTheSameBitsWithOneAndTwoThreads)
{
	const auto run = [](int threads) {
		omp_set_num_threads(threads);
		auto s            = freezingSoil(0.1);
		s.lower           = { 0.0, 0.0 };
		s.upper           = { 1.4, 1.4 };
		s.motion->gravity = { 0.0, -9.81 };
		standOnRollers(s);
		addBoundary<DrainedBoundary<2>>(s, Region<2>::freeSurface());
		addBoundary<SurfaceTemperature<2>>(s, Region<2>::freeSurface(), 10.0);
		Ground<2> ground(s);
		fillBox(ground, { 0.0, 0.0 }, { 1.0, 1.0 }, [](PointInput<2>& p) { p.temperature = -1.0 + 2.0 * p.position[0]; });
		ground.initialise();
		const double dt = ground.stableTimeStep().step;
		for (int k = 0; k < 200; ++k)
			ground.step(dt);
		std::vector<double> all;
		for (const char* field : { "temperature", "pressure", "waterMass" })
			for (const double value : valuesOf(ground, field))
				all.push_back(value);
		for (int a = 0; a < 2; ++a)
			for (const double value : valuesOf(ground, "position", a))
				all.push_back(value);
		return all;
	};
	const auto one = run(1), two = run(2);
	ASSERT_EQ(one.size(), two.size());
	double differing = 0.0;
	for (std::size_t k = 0; k < one.size(); ++k)
		differing += one[k] != two[k];
	expectSmall("one and two threads, 200 steps: values that differ in any bit", differing, 0.0);
}

// Loads = kinetic + stored + dissipated energy; without gravity, which water that leaves would carry away with it
TEST(Conservation, MechanicalEnergyOfAConsolidatingColumnIsAccountedFor)
{
	auto s     = freezingSoil(0.1);
	s.freezing = nullptr;
	s.heat.reset();
	s.mixture                                   = withoutExpansion();
	s.lower                                     = { 0.0, 0.0 };
	s.upper                                     = { 0.8, 1.2 };
	s.energyLedger                              = true;
	s.motion->picTime                           = std::numeric_limits<double>::infinity();
	s.water->picTime                            = std::numeric_limits<double>::infinity();
	s.water->state.cavitationPressure           = -2e6;
	s.water->permeability.referenceConductivity = 1e-3;
	const double load = 2e4, modulus = 1e7;
	standOnRollers(s);
	addBoundary<DrainedBoundary<2>>(s, Region<2>::freeSurface());
	addBoundary<Traction<2>>(s, Region<2>::freeSurface(), TimeTable({ 0.0, 0.1 }, { 0.0, load }));
	Ground<2> ground(s);
	fillBox(ground, { 0.0, 0.0 }, { 0.8, 0.9 });
	ground.initialise();
	marchTo(ground, 3.0);
	const auto   b    = ground.balance();
	const double kept = b.kineticEnergy + b.skeletonWork + b.porePressureWork + b.dragDissipation + b.dampingDissipation;
	expectSmall("energy of a consolidating column: work of the load not accounted for", (b.loadWork - kept) / b.loadWork, 2e-2);
	expectRelative("energy stored in the skeleton after consolidation, q^2 V/2M [J]", b.skeletonWork, 0.5 * load * load / modulus * 0.72, 2e-2);
}
