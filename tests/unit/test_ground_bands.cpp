// SPDX-License-Identifier: GPL-2.0-or-later
// A ground whose strips are shared out among ranks, which are threads of this process here.
#include "groundState.hpp"
#include "threadRanks.hpp"

#include <pkg/mpm/boundary/Boundaries.hpp>
#include <pkg/mpm/effects/RigidContact.hpp>
#include <pkg/mpm/Ground.hpp>
#include <pkg/mpm/skeleton/ElasticSkeleton.hpp>
#include <pkg/mpm/skeleton/MohrCoulombSkeleton.hpp>

#include <gtest/gtest.h>
#include <omp.h>

#include <algorithm>
#include <cmath>
#include <cstdio>
#include <fstream>
#include <functional>

using namespace talik;

namespace {

struct Scene {
	const char*      name;
	bool             heat = false, water = false, freezing = false, bBar = true;
	VelocityTransfer transfer = VelocityTransfer::flip;
	bool             bodies = false, calendar = false, walls = false;
	double           thawStrain = 0.0; ///< above 0: soil that is compressible once it has thawed
	int              columns    = 0;   ///< of points, along the slope; 0: all that have room
};

/// Two soils, a wall that moves in, rain, and boundaries that act in boxes, on discs and on a side, across the borders of strips.
template <int D> void addWalls(GroundSettings<D>& s)
{
	Vec<D> low = Region<D>::filled(0.12), high = Region<D>::filled(0.48), direction {};
	low[0]          = 0.9;
	high[0]         = 2.1;
	direction[0]    = 1.0;
	s.boundaries[0] = std::make_shared<MovingBoundary<D>>(Region<D>::side("left"), TimeTable(0.3), direction, false);
	SoilMaterial sand;
	sand.mixture                    = s.mixture;
	sand.permeability               = s.water->permeability;
	SoilMaterial silt               = sand;
	silt.mixture.solid.conductivity = 1.5;
	s.materials                     = { sand, silt };
	s.boundaries.back()             = std::make_shared<WaterFlux<D>>(Region<D>::freeSurface(), 1e-7, 3.0);
	s.boundaries.push_back(std::make_shared<HeatFlux<D>>(Region<D>::side("left"), 5.0));
	s.boundaries.push_back(std::make_shared<HeatSource<D>>(Region<D>::disc(low, high), 20.0));
	s.boundaries.push_back(std::make_shared<WallTemperature<D>>(Region<D>::nodeBox(low, high), 0.5));
	s.boundaries.push_back(std::make_shared<Traction<D>>(Region<D>::nodeBox(low, high), 0.0, std::vector<TimeTable>(D, TimeTable(10.0))));
}

/// A slope that slides along the grid's longest axis, so that points cross strips; with heat it is warmed from above and from a wall, with
/// water it drains and is rained on.
template <int D> std::unique_ptr<Ground<D>> slope(const Scene& scene, const std::shared_ptr<RankTalk>& talk)
{
	constexpr double  h = 0.1, day = 86400.0;
	GroundSettings<D> s;
	s.gridSpacing = h;
	s.lower.fill(0.0);
	s.upper.fill(D == 2 ? 1.2 : 0.8);
	s.upper[0]     = D == 2 ? 3.8 : 3.0; // neither is a whole number of strips
	s.parallelFrom = 0;
	s.motion.emplace();
	s.motion->gravity[D - 1] = -9.81;
	s.motion->localDamping   = 0.05;
	s.motion->transfer       = scene.transfer;
	s.motion->bBar           = scene.bBar;
	s.energyLedger           = true;
	s.deformationRecord      = true;
	auto rock                = std::make_shared<ElasticSkeleton<D>>();
	rock->youngModulus       = 5e6;
	auto soil                = std::make_shared<MohrCoulombSkeleton<D>>();
	soil->youngModulus       = 2e6;
	soil->youngModulusFrozen = 2e7;
	s.skeletons              = { rock, soil };
	s.boundaries = { std::make_shared<RollerBoundary<D>>(Region<D>::side("left")), std::make_shared<RollerBoundary<D>>(Region<D>::side("right")),
		         std::make_shared<FixedBoundary<D>>(Region<D>::side("bottom")),
		         std::make_shared<Traction<D>>(Region<D>::freeSurface(), TimeTable({ 0.0, day }, { 0.0, 2e3 })) };
	if (scene.heat) {
		s.heat.emplace();
		s.heat->thermalTimeScale = 1e5;
		s.heat->source           = 3.0;
		s.heat->followsMotion    = scene.calendar;
		s.boundaries.push_back(std::make_shared<SurfaceTemperature<D>>(Region<D>::freeSurface(), TimeTable({ 0.0, 1e3 }, { -2.0, 10.0 })));
		s.boundaries.push_back(std::make_shared<WallTemperature<D>>(Region<D>::side("bottom"), 4.0));
	}
	if (scene.freezing) s.freezing = makeFreezingCurve();
	if (scene.water) {
		s.water.emplace();
		s.water->state.liquidBulkModulus = 2.2e7;
		s.water->state.iceBulkModulus    = 8.8e7;
		s.boundaries.push_back(std::make_shared<DrainedBoundary<D>>(Region<D>::freeSurface()));
	}
	if (scene.walls) addWalls(s);
	if (scene.thawStrain > 0.0) {
		SoilMaterial silt;
		silt.mixture                     = s.mixture;
		silt.thawStrain                  = scene.thawStrain;
		silt.compression.compressibility = 1e-6;
		if (s.water) silt.permeability = s.water->permeability;
		s.materials = { silt };
	}
	if (scene.bodies) {
		s.bodies.emplace();
		if (scene.heat) s.boundaries.push_back(std::make_shared<HeatFlux<D>>(Region<D>::facing({ 0 }), 300.0));
	}
	auto               ground = std::make_unique<Ground<D>>(s);
	std::array<int, D> n, i {};
	for (int a = 0; a < D; ++a)
		n[a] = a == 0 ? (scene.columns ? scene.columns : D == 2 ? 62 : 50) : D == 2 ? 14 : 10;
	for (int a = 0; a < D;) {
		PointInput<D> p;
		p.volume = std::pow(0.5 * h, D);
		for (int b = 0; b < D; ++b)
			p.position[b] = 0.5 * h * (i[b] + 0.5);
		p.temperature = p.position[0] < 1.1 ? -2.0 : 1.0;
		p.material    = scene.walls && p.position[D - 1] < 0.2 ? 1 : 0;
		p.velocity[0] = (D == 2 ? 3.0 : 8.0) * p.position[D - 1];
		p.skeleton    = p.position[D - 1] > 0.25 ? 1 : 0;
		ground->addPoint(p);
		for (a = 0; a < D && ++i[a] == n[a]; ++a)
			i[a] = 0;
	}
	if (talk) ground->distribute(talk);
	ground->initialise();
	if (!scene.bodies) return ground;
	RigidBody<D> ball;
	ball.id = ball.group = 0;
	ball.shape           = &rigidBall<D>();
	ball.size.fill(0.3);
	ball.position.fill(0.4);
	ball.position[0]     = 0.8; // across the border of two strips
	ball.position[D - 1] = D == 2 ? 0.98 : 0.78;
	ball.friction        = 0.3;
	for (int a = 0; a < D; ++a)
		ball.axes[a][a] = 1.0;
	ball.velocity[D - 1]     = -1.0;
	ground->bodies()->bodies = { ball };
	return ground;
}

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
	EXPECT_GE(one->points().order(), 2) << "points were sorted, and bands cut, anew";
	if (scene.thawStrain > 0.0) {
		std::vector<double> released(one->points().count());
		one->copyById("thawStrainReleased", 0, released.data());
		const long open = std::count_if(released.begin(), released.end(), [](double r) { return r > 0.0; });
		std::printf("%ld of %zu points have thawed and settle\n", open, released.size());
		EXPECT_GT(open, 20);
	}
	for (const int ranks : rankCounts)
		for (const int threads : threadCounts) {
			std::vector<long> different(ranks, -1);
			asRanks(ranks, [&](const std::shared_ptr<RankTalk>& talk) {
				omp_set_num_threads(threads);
				const auto ground       = slope<D>(scene, talk);
				different[talk->rank()] = differing(wanted, march(*ground, steps));
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

const Scene dry { "dry" }, dryApic { "dry, apic", false, false, false, false, VelocityTransfer::apic }, warm { "heat", true }, wet { "water", false, true },
        frozen { "heat, freezing, thaw front", true, false, true }, all { "heat, water, freezing, thaw front", true, true, true },
        allOwn { "the same without means of cells, apic", true, true, true, false, VelocityTransfer::apic },
        withWalls { "all, two soils, a moving wall, rain, sources", true, true, true, true, VelocityTransfer::flip, false, true, true },
        iceRich { "heat, freezing, thaw strain", true, false, true, true, VelocityTransfer::flip, false, false, false, 0.1 },
        iceRichWet { "all, thaw strain", true, true, true, true, VelocityTransfer::flip, false, true, false, 0.1 },
        iceRichOwn { "all, thaw strain without means of cells", true, true, true, false, VelocityTransfer::apic, false, false, false, 0.1 },
        withBall { "all, a ball, a calendar that follows the motion", true, true, true, true, VelocityTransfer::flip, true, true };

} // namespace

TEST(GroundBands, OnTwoRanksGiveTheBitsOfOneRank)
{
	for (const Scene& scene : { dryApic, wet, all, withWalls, withBall, iceRichWet })
		expectSameBits<2>(scene, 260, { 2 }, { 1 });
	expectSameBits<3>(all, 130, { 2 }, { 1 });
}

TEST(GroundBands, OfWhichTheLastHasNoPointsGiveTheBitsOfOneRank)
{
	Scene half   = all;
	half.name    = "heat, water, freezing, thaw front, a box that is filled to a third";
	half.columns = 26;
	expectSameBits<2>(half, 260, { 3 }, { 1 });
	expectSameBits<3>(half, 130, { 3 }, { 1 });
}

TEST(GroundBands, InThePlaneOnAnyNumberOfRanksGiveTheBitsOfOneRank_slow)
{
	for (const Scene& scene : { dry, dryApic, warm, wet, frozen, all, allOwn, withWalls, withBall, iceRich, iceRichWet, iceRichOwn })
		expectSameBits<2>(scene, 260, { 2, 3, 4 }, { 1, 2 });
}

TEST(GroundBands, InSpaceOnAnyNumberOfRanksGiveTheBitsOfOneRank_slow)
{
	for (const Scene& scene : { dry, frozen, all, withWalls, withBall, iceRichWet })
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

TEST(GroundBands, WriteTheirPointsIntoOneFileFromWhichAnyNumberOfRanksGoesOn)
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
		asRanks(ranks, [&](const std::shared_ptr<RankTalk>& talk) {
			const auto ground = slope<2>(all, talk);
			stepOn(*ground, half);
			if (talk->rank() == 0) kept.write(*ground); // the others write their part when they come here
			talk->meet("it is written");
		});
		EXPECT_EQ(kept.sum, one.sum);
		EXPECT_EQ(kept.common, one.common);
		asRanks(4 - ranks, [&](const std::shared_ptr<RankTalk>& talk) {
			const auto ground = slope<2>(all, talk);
			kept.read(*ground);
			stepOn(*ground, 60);
			const long bytes = differingBytes(wanted, ground->state());
			if (talk->rank() == 0) different[0] = bytes;
		});
		std::printf("written by %d ranks, gone on with by %d: %ld bytes differ from one rank throughout\n", ranks, 4 - ranks, different[0]);
		EXPECT_EQ(different[0], 0);
	}
}

TEST(GroundBands, AreCutByCostAndStayWhereLittleIsGained)
{
	const std::vector<int> firstPoints { 0, 10, 20, 30, 40, 50, 60, 70, 80 };
	asRanks(2, [&](const std::shared_ptr<RankTalk>& talk) {
		Bands      bands(talk, [](const std::string&) { return std::string(); });
		const auto border = [&](std::vector<double> costs) {
			bands.weigh(std::move(costs));
			bands.cut(firstPoints, Bands::Rows());
			return talk->rank() == 0 ? bands.endStrip() : bands.firstStrip();
		};
		EXPECT_EQ(border({}), 4) << "points cost alike";
		EXPECT_EQ(border({ 1, 1, 1, 1, 1, 1, 3, 3 }), 6) << "6 and 6";
		EXPECT_EQ(border({ 1, 1, 1, 1, 1, 1.2, 3, 3 }), 6) << "as good as before";
		EXPECT_EQ(border({ 9, 9, 1, 1, 1, 1, 1, 1 }), 2) << "no band has less than two strips";
		EXPECT_EQ(bands.pointsOf(0), std::make_pair(0, 20));
	});
	std::printf("strips of unequal cost are shared out between two bands, and few that gain nothing move\n");
}
