// SPDX-License-Identifier: GPL-2.0-or-later
// Effects that stand in files of their own (GroundSettings::effects).
#include "groundState.hpp"

#include <pkg/mpm/boundary/Boundaries.hpp>
#include <pkg/mpm/effects/BulkViscosity.hpp>
#include <pkg/mpm/Ground.hpp>
#include <pkg/mpm/skeleton/ElasticSkeleton.hpp>

#include <gtest/gtest.h>

#include <cmath>
#include <cstdio>
#include <limits>

using namespace talik;

namespace {

constexpr double pi = 3.14159265358979323846, young = 1e7, solidDensity = 2000.0, length = 1.0;

/// A bar between walls on all sides with the lowest standing pressure wave, sin(pi x/L) of velocity. eta < 0: without the effect.
template <int D> std::unique_ptr<Ground<D>> bar(double eta, int cells = 20)
{
	GroundSettings<D> s;
	s.gridSpacing = length / cells;
	s.lower.fill(0.0);
	s.upper.fill(2.0 * s.gridSpacing);
	s.upper[0]              = length;
	s.mixture.solid.density = solidDensity;
	s.poreFill              = 0.0;
	s.motion.emplace();
	s.motion->picTime = std::numeric_limits<double>::infinity();
	s.energyLedger    = true;
	auto law          = std::make_shared<ElasticSkeleton<D>>();
	law->young        = young;
	law->poisson      = 0.0;
	s.skeletons       = { law };
	for (const std::string& side : sideNames(D)) // the viscous stress acts in all directions
		s.boundaries.push_back(std::make_shared<RollerBoundary<D>>(Region<D>::side(side)));
	if (eta >= 0.0) {
		auto viscosity       = std::make_shared<BulkViscosity<D>>();
		viscosity->viscosity = eta;
		s.effects            = { viscosity };
	}
	auto               ground = std::make_unique<Ground<D>>(s);
	std::array<int, D> n, i {};
	n.fill(4);
	n[0] = 2 * cells;
	for (int a = 0; a < D;) {
		PointInput<D> p;
		p.volume   = std::pow(0.5 * s.gridSpacing, D);
		p.porosity = 0.5;
		for (int b = 0; b < D; ++b)
			p.position[b] = 0.5 * s.gridSpacing * (i[b] + 0.5);
		p.velocity[0] = 1e-3 * std::sin(pi * p.position[0] / length);
		ground->addPoint(p);
		for (a = 0; a < D && ++i[a] == n[a]; ++a)
			i[a] = 0;
	}
	ground->initialise();
	return ground;
}

template <int D> double mechanicalEnergy(const Ground<D>& ground)
{
	const Balance<D> b = ground.balance();
	return b.kineticEnergy + b.skeletonWork - b.workAhead;
}

/// The error falls as h^2.
template <int D> void expectDecay(int cells, double tolerance)
{
	// rho = (1 - n) rho_s, omega = pi c/L, c = sqrt(E/rho); a mode decays as exp(-eta omega^2 t/(2 E)), its energy twice as fast
	const double density = 0.5 * solidDensity, speed = std::sqrt(young / density), omega = pi * speed / length, period = 2.0 * pi / omega;
	const double eta = 2.0 * 0.05 * young / omega, rate = eta * omega * omega / young;
	const auto   ground = bar<D>(eta, cells);
	const double dt     = 0.5 * ground->stableTimeStep().step;
	const int    steps  = int(std::lround(2.0 * period / dt));
	const double before = mechanicalEnergy(*ground);
	for (int k = 0; k < steps; ++k)
		ground->step(dt);
	const double measured = std::log(before / mechanicalEnergy(*ground)) / (steps * dt), error = std::fabs(measured / rate - 1.0);
	const double lost = ground->balance().dampingDissipation, gone = before - mechanicalEnergy(*ground);
	std::printf("%d-D: energy decays at %.4g 1/s; closed form eta omega^2/E = %.4g 1/s; error %.2g, tolerance %.2g\n", D, measured, rate, error, tolerance);
	std::printf("dissipation booked %.4g J, energy lost %.4g J (reference): off by %.2g, tolerance 0.02\n", lost, gone, std::fabs(lost / gone - 1.0));
	EXPECT_LT(error, tolerance);
	EXPECT_LT(std::fabs(lost / gone - 1.0), 0.02);
}

} // namespace

TEST(Effects, BulkViscosityDampsAStandingWaveAtTheRateOfAKelvinVoigtBar)
{
	expectDecay<2>(40, 0.01);
	expectDecay<3>(20, 0.03);
}

TEST(Effects, BulkViscosityOfZeroChangesNoBitAndAnAbsentOneHasNoField)
{
	const auto without = bar<2>(-1.0), with = bar<2>(0.0);
	for (int k = 0; k < 50; ++k) {
		without->step(1e-5);
		with->step(1e-5);
	}
	EXPECT_FALSE(without->points().fields().has("viscousStress"));
	EXPECT_EQ(without->cost().size() + 1, with->cost().size());
	long different = 0;
	for (const FieldInfo& field : without->points().fields().list())
		for (int c = 0; c < field.components; ++c) {
			std::vector<double> one(without->points().count()), other(one);
			without->copyById(field.name, c, one.data());
			with->copyById(field.name, c, other.data());
			for (std::size_t p = 0; p < one.size(); ++p)
				different += one[p] != other[p];
		}
	std::printf("%ld numbers of the points differ after 50 steps (reference: the same scene without the effect)\n", different);
	EXPECT_EQ(different, 0);
}

TEST(Effects, BulkViscosityGoesOnThroughACheckpointToTheLastBit)
{
	const auto one = bar<2>(1e4), other = bar<2>(1e4);
	for (int k = 0; k < 20; ++k)
		one->step(1e-5);
	const auto  kept = copyOf(one->state());
	std::size_t k    = 0;
	for (const StateArray& array : other->state())
		std::copy(kept[k].begin(), kept[k].end(), static_cast<char*>(array.data)), ++k;
	other->stateRestored();
	for (int step = 0; step < 20; ++step) {
		one->step(1e-5);
		other->step(1e-5);
	}
	const long different = differingBytes(copyOf(one->state()), other->state());
	std::printf("%ld bytes differ from a run without a stop\n", different);
	EXPECT_EQ(different, 0);
}

TEST(Effects, BulkViscosityLimitsTheTimeStepAndIsStableThere)
{
	const auto   ground = bar<2>(5e5); // more than critical for the shortest waves
	const double limit = ground->stableTimeStep().step, closed = 0.5 * solidDensity * 0.05 * 0.05 / (12.0 * 5e5);
	std::printf("limit %.4g s by '%s', rho h^2/(6 D eta) = %.4g s\n", limit, ground->stableTimeStep().governing.c_str(), closed);
	EXPECT_EQ(ground->stableTimeStep().governing, "bulk viscosity");
	EXPECT_NEAR(limit, closed, 1e-9 * closed);
	const double before = mechanicalEnergy(*ground);
	for (int k = 0; k < 2000; ++k)
		ground->step(ground->stableTimeStep().step);
	EXPECT_LT(mechanicalEnergy(*ground), before);
}

TEST(Effects, WithoutMotionAreRefusedWithARemedy)
{
	GroundSettings<2> s;
	s.gridSpacing = 0.1;
	s.upper.fill(1.0);
	s.heat.emplace();
	s.effects = { std::make_shared<BulkViscosity<2>>() };
	try {
		checkSettings(s);
		FAIL();
	} catch (const std::invalid_argument& problem) {
		std::printf("%s\n", problem.what());
		EXPECT_STREQ(problem.what(), "effects = bulk viscosity: needs ground that moves; switch motion on or leave the effect out");
	}
}
