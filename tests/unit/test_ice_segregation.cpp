// SPDX-License-Identifier: GPL-2.0-or-later
// Ground that draws water as it freezes: the same bits with any number of threads and through a checkpoint, and those of ground without the effect
// where nothing freezes.
#include "groundState.hpp"
#include "threadRanks.hpp"

#include <pkg/mpm/boundary/Boundaries.hpp>
#include <pkg/mpm/skeleton/ElasticSkeleton.hpp>

#include <gtest/gtest.h>

#include <cstring>
#include <omp.h>

using namespace talik;

namespace {

/// Wet ground under a surface of one temperature, warmer towards one side.
template <int D> Ground<D> ground(double surface, double start, bool segregates)
{
	GroundSettings<D> s;
	s.gridSpacing = 0.1;
	for (int a = 0; a < D; ++a)
		s.upper[a] = a == D - 1 ? 0.9 : D == 2 ? 0.8 : 0.4;
	s.motion.emplace();
	s.motion->gravity[D - 1] = -9.81;
	s.heat.emplace();
	s.heat->thermalTimeScale = 3e6;
	s.freezing               = makeFreezingCurve();
	s.water.emplace();
	s.water->state.liquidBulkModulus = 2.2e7;
	s.water->state.iceBulkModulus    = 8.8e7;
	if (segregates) s.segregation.emplace().segregationPotential = 2e-9;
	auto law    = std::make_shared<ElasticSkeleton<D>>();
	law->young  = 1e7;
	s.skeletons = { law };
	for (const char* side : { "left", "right", "bottom" })
		s.boundaries.push_back(std::make_shared<RollerBoundary<D>>(Region<D>::side(side)));
	s.boundaries.push_back(std::make_shared<SurfaceTemperature<D>>(Region<D>::freeSurface(), TimeTable(surface)));
	s.boundaries.push_back(std::make_shared<DrainedBoundary<D>>(Region<D>::side("bottom"), TimeTable(0.0), true));
	Ground<D>     made(s);
	PointInput<D> p;
	p.volume = std::pow(0.05, D);
	for (int k = 0; k < 12; ++k)
		for (int j = 0; j < (D == 2 ? 1 : 8); ++j)
			for (int i = 0; i < (D == 2 ? 16 : 8); ++i) {
				p.position[0]     = 0.05 * (i + 0.5);
				p.position[1]     = 0.05 * (j + 0.5);
				p.position[D - 1] = 0.05 * (k + 0.5);
				p.temperature     = start * (1.0 + 0.05 * i);
				made.addPoint(p);
			}
	made.initialise();
	return made;
}

template <int D> void march(Ground<D>& ground, int steps)
{
	for (int k = 0; k < steps; ++k)
		ground.step(2e-4);
}

template <int D> void expectSameBitsWithTwoThreads()
{
	const int before = omp_get_max_threads();
	omp_set_num_threads(1);
	auto one = ground<D>(-5.0, 0.2, true);
	march(one, 600);
	omp_set_num_threads(2);
	auto two = ground<D>(-5.0, 0.2, true);
	march(two, 600);
	omp_set_num_threads(before);
	const long differing = differingBytes(copyOf(one.state()), two.state());
	std::printf("%d-D: %.3g kg of water drawn; %ld bytes differ with two threads\n", D, one.balance().waterDrawn, differing);
	EXPECT_GT(one.balance().waterDrawn, 0.0);
	EXPECT_EQ(differing, 0);
}

template <int D> void expectSameBitsThroughACheckpoint()
{
	auto whole = ground<D>(-5.0, 0.2, true);
	march(whole, 400);
	EXPECT_GT(whole.balance().waterDrawn, 0.0);
	const auto saved = copyOf(whole.state());
	march(whole, 300);
	auto       resumed = ground<D>(-5.0, 0.2, true);
	const auto state   = resumed.state();
	for (std::size_t k = 0; k < state.size(); ++k) {
		ASSERT_EQ(state[k].bytes, saved[k].size()) << state[k].name;
		std::memcpy(state[k].data, saved[k].data(), state[k].bytes);
	}
	resumed.stateRestored();
	march(resumed, 300);
	const long differing = differingBytes(copyOf(whole.state()), resumed.state());
	std::printf("%d-D, saved, restored and continued: %ld bytes differ\n", D, differing);
	EXPECT_EQ(differing, 0);
}

/// Warm ground, and ground that has been frozen throughout, with the effect and without it.
template <int D> void expectNothingWhereNothingFreezes()
{
	for (const double temperature : { 3.0, -3.0 }) {
		auto with = ground<D>(temperature, temperature, true), without = ground<D>(temperature, temperature, false);
		march(with, 300);
		march(without, 300);
		EXPECT_EQ(with.balance().waterDrawn, 0.0);
		long differing = 0;
		for (const FieldInfo& f : without.fields())
			for (int c = 0; f.place == "points" && c < f.components; ++c) {
				std::vector<double> a(with.points().count()), b(a.size());
				with.copyById(f.name, c, a.data());
				without.copyById(f.name, c, b.data());
				for (std::size_t p = 0; p < a.size(); ++p)
					differing += std::memcmp(&a[p], &b[p], sizeof(double)) != 0;
			}
		std::printf("%d-D at %+.0f degC: %ld values of the points differ from ground without the effect\n", D, temperature, differing);
		EXPECT_EQ(differing, 0);
	}
}

} // namespace

TEST(IceSegregationBits, AreTheSameWithOneAndTwoThreads)
{
	expectSameBitsWithTwoThreads<2>();
	expectSameBitsWithTwoThreads<3>();
}

TEST(IceSegregationBits, AreTheSameThroughACheckpoint)
{
	expectSameBitsThroughACheckpoint<2>();
	expectSameBitsThroughACheckpoint<3>();
}

TEST(IceSegregationBits, AreThoseOfGroundWithoutItWhereNothingFreezes)
{
	expectNothingWhereNothingFreezes<2>();
	expectNothingWhereNothingFreezes<3>();
}

namespace {

/// A column that freezes from its top, and draws by its own hydraulic conductivity; its front begins beside the surface and beside a slab's end.
std::unique_ptr<Ground<2>> column(const std::shared_ptr<Communicator>& ranks)
{
	const double      h = 0.025;
	GroundSettings<2> s;
	s.gridSpacing = h;
	s.upper       = { h, 0.6 };
	s.motion.emplace();
	s.motion->gravity      = { 0.0, -9.81 };
	s.motion->localDamping = 0.3;
	s.heat.emplace();
	s.heat->thermalTimeScale = 2e6;
	s.freezing               = makeFreezingCurve();
	s.water.emplace();
	s.water->permeability.referenceConductivity = 1e-9;
	s.water->state.liquidBulkModulus            = 1e8;
	s.water->state.iceBulkModulus               = 4e8;
	s.water->state.cavitationPressure           = -1e6;
	s.segregation.emplace();
	auto law    = std::make_shared<ElasticSkeleton<2>>();
	law->young  = 1e8;
	s.skeletons = { law };
	for (const char* side : { "left", "right", "bottom" })
		s.boundaries.push_back(std::make_shared<RollerBoundary<2>>(Region<2>::side(side)));
	s.boundaries.push_back(std::make_shared<SurfaceTemperature<2>>(Region<2>::freeSurface(), TimeTable(-3.0)));
	s.boundaries.push_back(std::make_shared<Traction<2>>(Region<2>::freeSurface(), TimeTable(50e3)));
	s.boundaries.push_back(std::make_shared<WallTemperature<2>>(Region<2>::side("bottom"), TimeTable(1.0)));
	s.boundaries.push_back(std::make_shared<DrainedBoundary<2>>(Region<2>::side("bottom"), TimeTable(0.0), true));
	auto          made = std::make_unique<Ground<2>>(s);
	PointInput<2> p;
	p.volume      = 0.25 * h * h;
	p.temperature = 1.0;
	for (int j = 0; j < 24; ++j)
		for (int i = 0; i < 2; ++i) {
			p.position  = { (0.5 * i + 0.25) * h, (0.5 * j + 0.25) * h };
			p.pressure  = -9810.0 * p.position[1];
			p.stress[1] = p.pressure - 50e3 - 9.81 * 1990.0 * (0.3 - p.position[1]);
			made->addPoint(p);
		}
	if (ranks) made->distribute(ranks);
	made->initialise();
	return made;
}

void freeze(Ground<2>& ground, double dt)
{
	for (int k = 0; k < 2500; ++k)
		ground.step(dt);
}

} // namespace

TEST(IceSegregationBits, OfAColumnThatFreezesFromItsSurfaceAreTheSameOnTwoRanks)
{
	const auto   one = column(nullptr);
	const double dt  = 0.8 * one->stableTimeStep().step;
	freeze(*one, dt);
	const auto wanted = copyOf(one->state());
	EXPECT_GT(one->balance().waterDrawn, 0.0);
	long differing[2] = { -1, -1 };
	asRanks(2, [&](const std::shared_ptr<Communicator>& ranks) {
		const auto ground = column(ranks);
		freeze(*ground, dt);
		differing[ranks->rank()] = differingBytes(wanted, ground->state());
	});
	std::printf(
	        "%.3g kg of water drawn in %.2f days; %ld and %ld bytes differ on two ranks\n", one->balance().waterDrawn, one->calendar().time / 86400.0,
	        differing[0], differing[1]);
	EXPECT_EQ(differing[0], 0);
	EXPECT_EQ(differing[1], 0);
}
