// SPDX-License-Identifier: GPL-2.0-or-later
// Cases 4, 9 and 13: stiff water on coarse points, stiff beside soft, gravity and settings that change in mid-run.
#include "Held.hpp"
#include "Report.hpp"
#include "WetScenes.hpp"

#include <gtest/gtest.h>

#include <algorithm>

using namespace talik;
using namespace talik::stability;
using namespace talik::validation;

TEST(Loading, WaterOfTrueStiffnessOnOnePointPerCellShowsNoCheckerboard)
{
	citing("hydrostatic and undrained stress");
	for (const bool means : { true, false }) {
		GroundSettings<2> s;
		s.gridSpacing = 0.1;
		s.upper       = { 0.6, 1.2 };
		s.mixture     = withoutExpansion();
		s.motion.emplace();
		s.motion->gravity      = { 0.0, -9.81 };
		s.motion->localDamping = 0.5;
		s.motion->bBar         = means;
		s.water.emplace();
		s.skeletons.push_back(elasticOedometer(1e8));
		s.energyLedger = true;
		standOnRollers(s);
		Ground<2> ground(s);
		fillBox(ground, { 0.0, 0.0 }, { 0.6, 0.8 }, {}, 1);
		ground.initialise();
		Watch<2> watch(ground);
		watch.run(6000, 100);
		// undrained, the pressure grows linearly with depth; alternation: distance of a row from the mean of its neighbours
		const auto p           = valuesOf(ground, "pressure");
		double     alternation = 0.0, across = 0.0;
		for (int row = 1; row < 7; ++row)
			for (int i = 0; i < 6; ++i) {
				alternation = std::max(alternation, std::abs(p[6 * row + i] - 0.5 * (p[6 * (row - 1) + i] + p[6 * (row + 1) + i])));
				across      = std::max(across, std::abs(p[6 * row + i] - p[6 * row]));
			}
		const double      base = *std::max_element(p.begin(), p.end());
		const std::string name = std::string("K_w = 2.2 GPa, one point per cell, ") + (means ? "cell means" : "no cell means");
		expectHeld(name, watch.figures());
		expectSmall(name + ": alternation from row to row over the largest pressure", alternation / base, 0.05);
		expectSmall(name + ": alternation along a row over the largest pressure", across / base, 0.05);
	}
}

TEST(Loading, NeighboursWhoseModuliDifferByTenThousandSettleAsTheirMeanCompliance)
{
	citing("series of springs");
	auto s = columnSettings(0.1, 1.4);
	s.motion.emplace();
	s.motion->localDamping = 0.7;
	s.energyLedger         = true;
	constexpr double soft = 1e6, ratio = 1e4, load = 1e3;
	s.skeletons = { elasticOedometer(soft), elasticOedometer(soft * ratio) };
	standOnRollers(s);
	addBoundary<Traction<2>>(s, Region<2>::freeSurface(), load);
	Ground<2> ground(s);
	fillBox(ground, { 0.0, 0.0 }, { 0.1, 1.0 }, [](PointInput<2>& p) { p.skeleton = int(p.position[1] / 0.1) % 2; });
	ground.initialise();
	Watch<2>     watch(ground);
	const int    top = ground.points().count() - 1;
	const double y0  = valuesOf(ground, "position", 1)[top];
	watch.run(250000, 10000);
	expectHeld("modulus ratio 1e4 from cell to cell", watch.figures());
	const double settled = y0 - valuesOf(ground, "position", 1)[top];
	// layers no thicker than a cell are seen through smooth shape functions: five soft layers count as somewhat stiffer
	expectRelative("modulus ratio 1e4 from cell to cell: settlement over q sum h/M", settled, load * 0.5 / soft * (1.0 + 1.0 / ratio), 0.25);
}

TEST(Loading, GravityAndSettingsSwitchedInMidRunWithoutDampingBringNoEnergyOfTheirOwn)
{
	GroundSettings<2> s;
	s.gridSpacing = 0.1;
	s.upper       = { 0.8, 1.2 };
	s.motion.emplace();
	s.water = softWater(2.2e8);
	s.skeletons.push_back(elasticOedometer(1e7));
	s.energyLedger = true;
	standOnRollers(s);
	Ground<2> ground(s);
	fillBox(ground, { 0.0, 0.0 }, { 0.8, 0.8 });
	ground.initialise();
	const auto total = [&] {
		const auto b = ground.balance();
		return b.kineticEnergy + b.gravityEnergy + b.skeletonWork + b.porePressureWork + b.dragDissipation + b.dampingDissipation + b.slipWork
		        - b.loadWork;
	};
	double created = 0.0, turned = 0.0;
	for (int part = 0; part < 24; ++part) {
		auto& m = *ground.settings().motion;
		// what the switch itself does to the energy is the work of whoever switches
		m.gravity         = part % 3 == 0 ? Vec<2> { 0.0, -9.81 } : part % 3 == 1 ? Vec<2> {} : Vec<2> { 4.0, -9.81 };
		m.localDamping    = part % 4 == 2 ? 0.6 : 0.0;
		const double step = ground.stableTimeStep().step, infinity = std::numeric_limits<double>::infinity();
		m.picTime                        = part % 5 == 3 ? 10.0 * step : infinity;
		ground.settings().water->picTime = part % 2 ? 1.5 * step : infinity;
		const double before              = total();
		for (int k = 0; k < 150; ++k) {
			ground.step(ground.stableTimeStep().step);
			const auto b = ground.balance();
			turned       = std::max(turned, b.kineticEnergy + std::abs(b.skeletonWork) + std::abs(b.porePressureWork));
			created      = std::max(created, total() - before);
		}
	}
	EXPECT_TRUE(std::isfinite(total()));
	expectSmall("gravity, damping, transfer and rest switched 24 times: energy from nowhere", created / turned, 0.05);
	expectSmall("gravity, damping, transfer and rest switched 24 times: drift of water", ground.balance().waterMass / (0.64 * 0.4 * 1000.0) - 1.0, 1e-2);
}
