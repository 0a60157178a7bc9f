// SPDX-License-Identifier: GPL-2.0-or-later
// The loops between points and nodes: vectors against the reference, block by block and in whole grounds, in the plane and in space.
#include "groundState.hpp"
#include "ReferenceLoops.hpp"

#include <pkg/mpm/boundary/Boundaries.hpp>
#include <pkg/mpm/grid/NodeLoops.hpp>
#include <pkg/mpm/grid/ShapeFunctions.hpp>
#include <pkg/mpm/Ground.hpp>
#include <pkg/mpm/skeleton/MohrCoulombSkeleton.hpp>

#include <gtest/gtest.h>
#include <omp.h>

#include <cmath>
#include <cstdio>
#include <cstring>
#include <random>

using namespace talik;

namespace {

using Numbers = std::vector<double>;

/// Everything that one version computes from the same random block of 29 points, as one list of numbers.
template <int D> class BlockOfPoints {
public:
	explicit BlockOfPoints(const std::string& shapeFunction)
	        : grid_(filled(0.0), filled(1.0), 0.1)
	        , fields_(40, Numbers(first + count + 5))
	        , records_(grid_.nodeCount() * Columns::Liquid::size)
	{
		for (Numbers& field : fields_)
			randomise(field);
		randomise(records_);
		for (auto& value : values_)
			for (double& v : value)
				v = uniform_(random_);
		std::array<Numbers, D>       x;
		std::array<const double*, D> position;
		for (int a = 0; a < D; ++a) {
			x[a].resize(first + count);
			for (double& v : x[a])
				v = 0.5 + 0.4 * uniform_(random_);
			position[a] = x[a].data();
		}
		makeShapeFunction<D>(shapeFunction)->evaluate(grid_, position, first, count, weights_);
	}

	Numbers resultsOf(const NodeLoops<D>& loops) const
	{
		using Loops = NodeLoops<D>;
		Numbers              all;
		std::vector<Numbers> f      = fields_;
		const auto           keep   = [&](const double* values, std::size_t n) { all.insert(all.end(), values, values + n); };
		const auto           at     = [&](int k) { return f[k].data(); };
		const auto           onGrid = [&](auto&& work) {
                        Numbers copy = records_;
                        work(copy.data());
                        keep(copy.data(), copy.size());
		};
		for (const bool added : { false, true })
			for (const bool carried : { false, true }) {
				if (carried && !Columns::Moving::carriesHeat) continue;
				onGrid([&](double* g) {
					typename Loops::MotionMap m {
						at(0), at(1), added ? at(2) : nullptr, {}, {}, carried ? at(11) : nullptr, at(12), 0.4, g
					};
					for (int a = 0; a < D; ++a)
						m.velocity[a] = at(3 + a);
					for (int c = 0; c < stressSize<D>; ++c)
						m.stress[c] = at(21 + c);
					loops.mapMotion(weights_, m);
				});
			}
		double liquid[Columns::Liquid::size][blockSize], pair[2][blockSize], gathered[Columns::Gathered::size][blockSize], one[blockSize];
		std::memcpy(liquid, values_, sizeof(liquid));
		std::memcpy(pair, values_, sizeof(pair));
		onGrid([&](double* g) { loops.mapLiquid(weights_, liquid, g); });
		onGrid([&](double* g) { loops.mapPair(weights_, pair, g); });
		const typename Loops::HeatFlow heat { at(0), at(1), at(2), at(3), 0.7, 0.3, 0.2 };
		onGrid([&](double* g) { loops.flowHeat(weights_, heat, records_.data(), g); });
		onGrid([&](double* g) { loops.flowPressure(weights_, at(0), records_.data(), g); });
		onGrid([&](double* g) { loops.flowHeatAndPressure(weights_, heat, records_.data(), g); });
		for (const bool warm : { false, true })
			onGrid([&](double* g) {
				typename Loops::Seepage s { records_.data(), at(0), {}, warm ? at(6) : nullptr, 0.7, 4.2, 3.3, g };
				for (int a = 0; a < D; ++a)
					s.velocity[a] = at(3 + a);
				loops.seep(weights_, s);
			});
		double                       rise[blockSize] {};
		typename Loops::MotionGather m { records_.data(), {}, {}, {}, {}, 0.97, 0.1, Columns::Solved::carriesIncrement ? rise : nullptr };
		for (int a = 0; a < D; ++a) {
			m.velocity[a]     = at(7 + a);
			m.position[a]     = at(10 + a);
			m.displacement[a] = at(13 + a);
		}
		for (int c = 0; c < D * D; ++c)
			m.gradient[c] = at(27 + c);
		loops.gatherMotion(weights_, m);
		keep(rise, count);
		for (const Numbers& field : f)
			keep(field.data(), field.size());
		loops.gatherExchange(weights_, records_.data(), gathered);
		for (auto& number : gathered)
			keep(number, count);
		loops.gatherNumber(weights_, records_.data(), one);
		keep(one, count);
		keepFront(loops, keep);
		return all;
	}

	/// Some points bring to a third of the nodes and gather from them; in some supports no node has a record.
	template <class Keep> void keepFront(const NodeLoops<D>& loops, Keep&& keep) const
	{
		using Loops = NodeLoops<D>;
		std::vector<int> slot(grid_.nodeCount(), -1);
		int              records = 0;
		for (int node = 0; node < grid_.nodeCount() / 2; node += 1 + node % 5)
			slot[node] = records++;
		const int  size = D == 2 ? 32 : 48;
		const auto map  = [&](auto columns, auto loop) {
                        using Numbered = decltype(columns);
                        typename Loops::template Shares<Numbered> shares;
                        for (int k = 0; k < count; k += 1 + k % 3) {
                                auto& share = shares.next(k);
                                for (int i = 0; i < Numbered::size; ++i)
                                        share.value[i] = fields_[i][k];
                                for (int a = 0; a < D; ++a)
                                        for (int i = 0; i < Numbered::size - Numbered::straight; ++i)
                                                share.slope[a][i] = fields_[8 * a + i][k + 1];
                        }
                        Numbers copy(records_.begin(), records_.begin() + size * records);
                        loop(weights_, shares, { slot.data(), copy.data(), size });
                        keep(copy.data(), copy.size());
		};
		map(typename Columns::Frozen(), loops.mapFrozen);
		map(typename Columns::Thawed(), loops.mapThawed);
		map(typename Columns::Pores(), loops.mapPores);
		const typename Loops::template SparseRecords<const double> some { slot.data(), records_.data(), size };
		for (int k = 0; k < count; ++k) {
			typename Loops::FrontSums sums {};
			const auto                keepSums = [&] { keep(reinterpret_cast<const double*>(&sums), sizeof(sums) / sizeof(double)); };
			loops.gatherFrozen(weights_, k, some, sums);
			keepSums();
			loops.gatherThawed(weights_, k, some, sums);
			keepSums();
		}
	}

private:
	using Columns              = NodeColumns<D>;
	static constexpr int count = 29, first = 3;

	static Vec<D> filled(double value)
	{
		Vec<D> v;
		v.fill(value);
		return v;
	}
	void randomise(Numbers& values)
	{
		for (double& v : values)
			v = uniform_(random_);
	}

	std::mt19937                           random_ { 1 };
	std::uniform_real_distribution<double> uniform_ { -1.0, 1.0 };
	Grid<D>                                grid_;
	std::vector<Numbers>                   fields_;
	Numbers                                records_;
	double                                 values_[Columns::Liquid::size][blockSize];
	WeightBlock<D>                         weights_;
};

/// Largest difference, relative to numbers of order one and sums with slopes of order ten.
double difference(const Numbers& a, const Numbers& b)
{
	double worst = 0.0;
	for (std::size_t i = 0; i < a.size(); ++i)
		worst = std::max(worst, std::abs(a[i] - b[i]) / std::max(10.0, std::abs(b[i])));
	return worst;
}

template <int D> void expectVersionsToAgree(const std::string& shapeFunction)
{
	const BlockOfPoints<D> block(shapeFunction);
	const Numbers          best = block.resultsOf(bestVectorLoops<D>()), reference = block.resultsOf(referenceLoops<D>());
	Numbers                roundedTwice;
	const auto             versions = vectorLoops<D>();
	EXPECT_GE(versions.size(), 1u);
	for (const NodeLoops<D>* version : versions) {
		const Numbers results = block.resultsOf(*version);
		ASSERT_EQ(results.size(), best.size());
		if (!version->roundsOnce && roundedTwice.empty()) roundedTwice = results;
		const Numbers& alike     = version->roundsOnce == bestVectorLoops<D>().roundsOnce ? best : roundedTwice;
		long           different = 0;
		for (std::size_t i = 0; i < results.size(); ++i)
			different += std::memcmp(&results[i], &alike[i], sizeof(double)) != 0;
		const double off = difference(results, reference);
		std::printf(
		        "%d-D, %s, %s rounds %s: %ld of %zu numbers differ from those of versions that round alike, by %.1e at most from the reference\n", D,
		        shapeFunction.c_str(), version->name, version->roundsOnce ? "once" : "twice", different, results.size(), off);
		EXPECT_EQ(different, 0);
		EXPECT_LE(off, 1e-14);
	}
}

/// What a ground has.
struct Scene {
	const char*      name;
	bool             motion = true, bBar = false, heat = false, freezing = false, water = false, surface = false;
	VelocityTransfer transfer      = VelocityTransfer::flip;
	const char*      shapeFunction = "quadraticBSpline";
};

std::vector<Scene> scenes()
{
	const auto flip = VelocityTransfer::flip;
	return {
		{ "dry", true },
		{ "dry, B-bar", true, true },
		{ "dry, apic", true, false, false, false, false, false, VelocityTransfer::apic },
		{ "dry, tpic", true, false, false, false, false, false, VelocityTransfer::tpic },
		{ "dry, gimp", true, false, false, false, false, false, flip, "gimp" },
		{ "rigid, heat", false, false, true },
		{ "rigid, heat, freezing, surface", false, false, true, true, false, true },
		{ "heat", true, false, true },
		{ "heat, freezing, thaw front", true, false, true, true, false, true },
		{ "heat, freezing, thaw front, apic", true, false, true, true, false, true, VelocityTransfer::apic },
		{ "water", true, true, false, false, true },
		{ "water without B-bar", true, false, false, false, true },
		{ "water, heat", true, true, true, false, true, true },
		{ "water, heat, freezing, thaw front", true, true, true, true, true, true },
		{ "water, heat, freezing, thaw front, gimp", true, true, true, true, true, true, flip, "gimp" },
	};
}

/// A block whose temperature crosses the freezing range, on a floor, thrown sideways, in a box with room.
template <int D> std::unique_ptr<Ground<D>> groundOf(const Scene& scene, int parallelFrom = 0, int cells = 5)
{
	const double      h = 0.1;
	GroundSettings<D> s;
	for (int a = 0; a < D; ++a)
		s.upper[a] = (cells + 4) * h;
	s.upper[0] += 2.0 * h;
	s.gridSpacing   = h;
	s.shapeFunction = scene.shapeFunction;
	s.parallelFrom  = parallelFrom;
	s.courantNumber = 0.3;
	if (scene.motion) {
		s.motion.emplace();
		s.motion->gravity[D - 1] = -9.81;
		s.motion->bBar           = scene.bBar;
		s.motion->transfer       = scene.transfer;
		s.skeletons.push_back(std::make_shared<MohrCoulombSkeleton<D>>());
		s.boundaries.push_back(std::make_shared<FixedBoundary<D>>(Region<D>::side("bottom")));
	}
	if (scene.heat) s.heat.emplace();
	if (scene.freezing) s.freezing = makeFreezingCurve("gauss");
	if (scene.water) {
		s.water.emplace();
		s.water->state.liquidBulkModulus = 2.2e7;
		s.water->state.iceBulkModulus    = 8.8e7;
	}
	if (scene.surface) s.boundaries.push_back(std::make_shared<SurfaceTemperature<D>>(Region<D>::freeSurface(), 10.0));
	if (scene.surface && scene.water) s.boundaries.push_back(std::make_shared<DrainedBoundary<D>>(Region<D>::freeSurface(), 0.0, false));
	auto                                   ground = std::make_unique<Ground<D>>(s);
	std::mt19937                           random(7);
	std::uniform_real_distribution<double> jitter(-0.02, 0.02);
	std::array<int, D>                     at {};
	while (at[0] < 2 * cells) {
		PointInput<D> p;
		for (int a = 0; a < D; ++a)
			p.position[a] = (a == D - 1 ? 0.0 : 2.0 * h) + (at[a] + 0.5 + jitter(random)) * 0.5 * h;
		p.volume      = std::pow(0.5 * h, D);
		p.porosity    = 0.4;
		p.temperature = -5.0 + 10.0 * p.position[D - 1] / (cells * h);
		p.pressure    = 1e4 * (cells * h - p.position[D - 1]);
		p.velocity[0] = 0.3 * p.position[D - 1];
		// without stress the sides of a front would press each other by round-off alone, or not
		for (int a = 0; a < D; ++a)
			p.stress[a] = -(a == D - 1 ? 1.6e4 : 0.8e4) * (cells * h - p.position[D - 1]);
		ground->addPoint(p);
		for (int a = D - 1; ++at[a] == 2 * cells && a > 0; --a)
			at[a] = 0;
	}
	ground->initialise();
	return ground;
}

template <int D> void march(Ground<D>& ground, int steps)
{
	const double step = 0.5 * ground.stableTimeStep().step;
	for (int k = 0; k < steps; ++k)
		ground.step(std::min(step, 3600.0));
}

/// All fields of the points by id after some steps with these loops.
template <int D> std::vector<Numbers> fieldsAfter(const NodeLoops<D>& loops, const Scene& scene, int steps)
{
	chooseNodeLoops<D>(loops);
	const auto ground = groundOf<D>(scene);
	march(*ground, steps);
	chooseNodeLoops<D>(bestVectorLoops<D>());
	std::vector<Numbers> all;
	for (const FieldInfo& field : ground->points().fields().list())
		for (int c = 0; c < field.components; ++c) {
			all.emplace_back(ground->points().count());
			ground->copyById(field.name, c, all.back().data());
		}
	return all;
}

template <int D> void expectGroundsToAgree(int steps)
{
	for (const Scene& scene : scenes()) {
		const std::vector<Numbers> vector = fieldsAfter<D>(bestVectorLoops<D>(), scene, steps);
		const std::vector<Numbers> plain  = fieldsAfter<D>(referenceLoops<D>(), scene, steps);
		ASSERT_EQ(vector.size(), plain.size());
		double worst   = 0.0;
		bool   differs = false;
		for (std::size_t f = 0; f < plain.size(); ++f) {
			double size = 0.0, off = 0.0;
			for (std::size_t p = 0; p < plain[f].size(); ++p) {
				size    = std::max(size, std::abs(plain[f][p]));
				off     = std::max(off, std::abs(plain[f][p] - vector[f][p]));
				differs = differs || plain[f][p] != vector[f][p];
			}
			if (size > 0.0) worst = std::max(worst, off / size);
		}
		std::printf("%d-D, %s: after %d steps fields differ by %.1e of their largest value\n", D, scene.name, steps, worst);
		EXPECT_LE(worst, 1e-11) << scene.name;
		EXPECT_TRUE(differs) << scene.name << ": both grounds ran the same loops";
	}
}

} // namespace

TEST(MpmNodeLoops, VersionsThatRoundAlikeGiveTheSameBitsAndAllGiveTheReferenceToRoundOff)
{
	for (const std::string& shapeFunction : shapeFunctionNames()) {
		expectVersionsToAgree<2>(shapeFunction);
		expectVersionsToAgree<3>(shapeFunction);
	}
}

TEST(MpmNodeLoops, GroundOfThePlaneWithAnyEffectIsThatOfTheReferenceToRoundOff) { expectGroundsToAgree<2>(30); }

TEST(MpmNodeLoops, GroundInSpaceWithAnyEffectIsThatOfTheReferenceToRoundOff) { expectGroundsToAgree<3>(30); }

TEST(MpmNodeLoops, GroundInSpaceGivesTheSameBitsWithAnyNumberOfThreadsAndThroughACheckpoint)
{
	const Scene scene { "everything", true, true, true, true, true, true };
	const int   before = omp_get_max_threads(), steps = 40;
	const auto  whole = groundOf<3>(scene, 0, 6);
	omp_set_num_threads(1);
	march(*whole, steps);
	const auto saved = copyOf(whole->state());
	march(*whole, steps);
	const auto wanted = copyOf(whole->state());
	for (const int threads : { 1, 2, 3 }) {
		omp_set_num_threads(threads);
		const auto ground = groundOf<3>(scene, 0, 6);
		march(*ground, steps);
		march(*ground, steps);
		const auto resumed = groundOf<3>(scene, 0, 6);
		const auto state   = resumed->state();
		for (std::size_t k = 0; k < state.size(); ++k) {
			ASSERT_EQ(state[k].bytes, saved[k].size()) << state[k].name;
			std::memcpy(state[k].data, saved[k].data(), state[k].bytes);
		}
		resumed->stateRestored();
		march(*resumed, steps);
		const long through = differingBytes(wanted, ground->state()), after = differingBytes(wanted, resumed->state());
		std::printf("%d threads: %ld bytes differ from one thread, %ld after a checkpoint\n", threads, through, after);
		EXPECT_EQ(through, 0);
		EXPECT_EQ(after, 0);
	}
	omp_set_num_threads(before);
}
