// SPDX-License-Identifier: GPL-2.0-or-later
// A ground whose strips are shared out among ranks, which are threads of this process here.
#include "slopeScenes.hpp"

#include <gtest/gtest.h>
#include <omp.h>

#include <algorithm>
#include <cmath>
#include <cstdio>
#include <fstream>
#include <functional>

using namespace talik;

namespace {

/// The state after some steps, and what can be asked of the ground.
template <int D> std::vector<std::vector<char>> march(Ground<D>& ground, int steps)
{
	std::vector<double> said;
	for (int k = 0; k < steps; ++k) {
		if (k % 20 == 0)
			for (const TimeStepLimit& limit : ground.stableTimeStep().limits)
				said.insert(said.end(), { limit.step, double(limit.point) });
		ground.step(2e-4);
		if (k % 50) continue;
		const Balance<D> b = ground.balance();
		said.insert(said.end(), { b.momentum[0], b.kineticEnergy, b.enthalpy, b.heatIn, b.waterOut, b.skeletonWork, b.porePressureWork });
		said.insert(said.end(), { b.impulse[0], b.impulse[D - 1], b.dampingDissipation, b.dragDissipation, b.loadWork, b.slipWork });
		said.insert(said.end(), { b.waterDrawn, b.segregationWork });
	}
	if (ground.bodies())
		for (double v : ground.bodies()->bodies[0].impulse)
			said.push_back(v);
	auto  all   = copyOf(ground.state());
	auto* bytes = reinterpret_cast<const char*>(said.data());
	all.emplace_back(bytes, bytes + said.size() * sizeof(double));
	return all;
}

long differing(const std::vector<std::vector<char>>& a, const std::vector<std::vector<char>>& b)
{
	long different = std::abs(long(a.size()) - long(b.size()));
	for (std::size_t k = 0; k < std::min(a.size(), b.size()); ++k)
		for (std::size_t i = 0; i < a[k].size(); ++i)
			different += i >= b[k].size() || a[k][i] != b[k][i];
	return different;
}

template <int D> void expectSameBits(const Scene& scene, int steps, const std::vector<int>& rankCounts, const std::vector<int>& threadCounts)
{
	const int before = omp_get_max_threads();
	omp_set_num_threads(1);
	const auto one    = slope<D>(scene, nullptr);
	const auto wanted = march(*one, steps);
	EXPECT_GE(one->points().order(), 2) << "points were sorted, and slabs cut, anew";
	if (scene.thawStrain > 0.0) {
		std::vector<double> released(one->points().count());
		one->copyById("thawStrainReleased", 0, released.data());
		const long open = std::count_if(released.begin(), released.end(), [](double r) { return r > 0.0; });
		std::printf("%ld of %zu points have thawed and settle\n", open, released.size());
		EXPECT_GT(open, 20);
	}
	if (scene.divide) {
		std::printf("%zu points have divided\n", one->divisions().size());
		EXPECT_GT(one->divisions().size(), 20u);
	}
	if (scene.segregation > 0.0) {
		std::printf("%.3g kg of water were drawn\n", one->balance().waterDrawn);
		EXPECT_GT(one->balance().waterDrawn, 0.0);
	}
	for (const int ranks : rankCounts)
		for (const int threads : threadCounts) {
			std::vector<long> different(ranks, -1);
			asRanks(ranks, [&](const std::shared_ptr<Communicator>& communicator) {
				omp_set_num_threads(threads);
				const auto ground               = slope<D>(scene, communicator);
				different[communicator->rank()] = differing(wanted, march(*ground, steps));
			});
			std::printf("%d-D, %s: %d ranks of %d threads:", D, scene.name, ranks, threads);
			for (const long bytes : different) {
				std::printf(" %ld", bytes);
				EXPECT_EQ(bytes, 0);
			}
			std::printf(" bytes differ from one rank after %d steps\n", steps);
		}
	omp_set_num_threads(before);
}

} // namespace

TEST(GroundSlabs, OnTwoRanksGiveTheBitsOfOneRank)
{
	for (const Scene& scene : { dryApic, wet, all, withWalls, withBall, iceRichWet, heaving, heavingComputed, dividing, wetImplicit, wallImplicit,
	                            heavingImplicit, fillingImplicit, ballImplicit })
		expectSameBits<2>(scene, 260, { 2 }, { 1 });
	for (const Scene& scene : { all, allImplicit })
		expectSameBits<3>(scene, 130, { 2 }, { 1 });
}

TEST(GroundSlabs, AboutAnAxisGiveTheBitsOfOneRank)
{
	for (const Scene& scene : { aroundAxis, axisImplicit })
		expectSameBits<2>(scene, 260, { 2 }, { 1, 2 });
}

TEST(GroundSlabs, OfWhichTheLastHasNoPointsGiveTheBitsOfOneRank)
{
	Scene half   = all;
	half.name    = "heat, water, freezing, thaw front, a box that is filled to a third";
	half.columns = 26;
	expectSameBits<2>(half, 260, { 3 }, { 1 });
	expectSameBits<3>(half, 130, { 3 }, { 1 });
}

TEST(GroundSlabs, InThePlaneOnAnyNumberOfRanksGiveTheBitsOfOneRank_slow)
{
	for (const Scene& scene : { dry,       dryApic,     warm,        wet,          frozen,          all,         allOwn,
	                            withWalls, withBall,    iceRich,     iceRichWet,   iceRichOwn,      heaving,     heavingComputed,
	                            dividing,  wetImplicit, allImplicit, wallImplicit, heavingImplicit, ballImplicit })
		expectSameBits<2>(scene, 260, { 2, 3, 4 }, { 1, 2 });
}

TEST(GroundSlabs, InSpaceOnAnyNumberOfRanksGiveTheBitsOfOneRank_slow)
{
	for (const Scene& scene : { dry, frozen, all, withWalls, withBall, iceRichWet, heaving, heavingComputed, dividing, allImplicit, wallImplicit,
	                            heavingImplicit, ballImplicit })
		expectSameBits<3>(scene, 130, { 2, 3, 4 }, { 1, 2 });
}

namespace {

/// Points of a ground in a file that all ranks write, and the rest of its state.
struct Kept {
	std::string                    file;
	std::vector<std::vector<char>> common;
	std::uint64_t                  sum = 0;
	void                           write(Ground<2>& ground)
	{
		std::uint64_t bytes = 0;
		for (const StateArray& array : ground.pointState())
			bytes += array.bytes;
		std::ofstream(file, std::ios::binary).close();
		sum    = ground.writePoints({ file, 0, bytes });
		common = copyOf(ground.commonState());
	}
	void read(Ground<2>& ground) const
	{
		std::size_t k = 0;
		for (const StateArray& array : ground.commonState())
			std::copy(common[k].begin(), common[k].end(), static_cast<char*>(array.data)), ++k;
		ground.readPoints(PartedFile(file, PartedFile::For::reading), 0);
	}
};

} // namespace

TEST(GroundSlabs, WriteTheirPointsIntoOneFileFromWhichAnyNumberOfRanksGoesOn)
{
	constexpr int half   = 210;
	const auto    whole  = slope<2>(all, nullptr);
	const auto    stepOn = [](Ground<2>& ground, int steps) {
                for (int k = 0; k < steps; ++k)
                        ground.step(2e-4);
	};
	Kept one { testing::TempDir() + "points1", {}, 0 };
	stepOn(*whole, half);
	one.write(*whole);
	stepOn(*whole, 60);
	const auto wanted = copyOf(whole->state());
	for (const int ranks : { 1, 2, 3 }) {
		Kept              kept { testing::TempDir() + "points of " + std::to_string(ranks), {}, 0 };
		std::vector<long> different(ranks, -1);
		asRanks(ranks, [&](const std::shared_ptr<Communicator>& communicator) {
			const auto ground = slope<2>(all, communicator);
			stepOn(*ground, half);
			if (communicator->rank() == 0) kept.write(*ground); // the others write their part when they come here
			communicator->meet("it is written");
		});
		EXPECT_EQ(kept.sum, one.sum);
		EXPECT_EQ(kept.common, one.common);
		asRanks(4 - ranks, [&](const std::shared_ptr<Communicator>& communicator) {
			const auto ground = slope<2>(all, communicator);
			kept.read(*ground);
			stepOn(*ground, 60);
			const long bytes = differingBytes(wanted, ground->state());
			if (communicator->rank() == 0) different[0] = bytes;
		});
		std::printf("written by %d ranks, gone on with by %d: %ld bytes differ from one rank throughout\n", ranks, 4 - ranks, different[0]);
		EXPECT_EQ(different[0], 0);
	}
}

TEST(GroundSlabs, AreCutByCostAndStayWhereLittleIsGained)
{
	const std::vector<int> firstPoints { 0, 10, 20, 30, 40, 50, 60, 70, 80 };
	asRanks(2, [&](const std::shared_ptr<Communicator>& communicator) {
		SlabDecomposition slabs(communicator, [](const std::string&) { return std::string(); });
		const auto        border = [&](std::vector<double> costs) {
                        slabs.weigh(std::move(costs));
                        slabs.cut(firstPoints, SlabDecomposition::Rows());
                        return communicator->rank() == 0 ? slabs.endStrip() : slabs.firstStrip();
		};
		EXPECT_EQ(border({}), 4) << "points cost alike";
		EXPECT_EQ(border({ 1, 1, 1, 1, 1, 1, 3, 3 }), 6) << "6 and 6";
		EXPECT_EQ(border({ 1, 1, 1, 1, 1, 1.2, 3, 3 }), 6) << "as good as before";
		EXPECT_EQ(border({ 9, 9, 1, 1, 1, 1, 1, 1 }), 2) << "no band has less than two strips";
		EXPECT_EQ(slabs.pointsOf(0), std::make_pair(0, 20));
	});
	std::printf("strips of unequal cost are shared out between two slabs, and few that gain nothing move\n");
}
