// SPDX-License-Identifier: GPL-2.0-or-later
#include <pkg/mpm/kernels/PlaneLoops.hpp>

#include <gtest/gtest.h>

#include <cmath>
#include <cstdio>
#include <cstring>
#include <random>
#include <vector>

using namespace talik;

namespace {

/// Everything that one version computes from the same random block of 29 points, as one list of numbers.
std::vector<double> resultsOf(const PlaneLoops& loops)
{
	constexpr int                          count = 29, first = 3, stride = 20, nodes = 400;
	std::mt19937                           random(1);
	std::uniform_real_distribution<double> uniform(-1.0, 1.0);
	std::vector<std::vector<double>>       fields(24, std::vector<double>(40));
	for (auto& field : fields)
		for (double& v : field)
			v = uniform(random);
	const auto          at = [&](int k) { return fields[k].data(); };
	std::vector<double> x(count), y(count);
	for (int k = 0; k < count; ++k) {
		x[k] = 0.5 + 0.4 * uniform(random);
		y[k] = 0.5 + 0.4 * uniform(random);
	}
	WeightBlock<2> w;
	w.first = first;
	w.count = count;
	for (int k = 0; k < count; ++k)
		w.base[k] = 0;
	for (int n = 0; n < 9; ++n)
		w.offset[n] = n % 3 + n / 3 * stride;
	loops.spline(count, x.data(), 0.0, 10.0, 1, w.base, w.value[0], w.slope[0]);
	loops.spline(count, y.data(), 0.0, 10.0, stride, w.base, w.value[1], w.slope[1]);

	std::vector<double> all;
	const auto          keep = [&](const double* values, std::size_t n) { all.insert(all.end(), values, values + n); };
	for (int a = 0; a < 2; ++a)
		for (int i = 0; i < supportNodes; ++i) {
			keep(w.value[a][i], count);
			keep(w.slope[a][i], count);
		}
	std::vector<double> grid(nodes * 8);
	for (double& v : grid)
		v = uniform(random);
	const auto onGrid = [&](auto&& work) {
		std::vector<double> copy = grid;
		work(copy.data());
		keep(copy.data(), copy.size());
	};
	double     two[2][blockSize], eight[8][blockSize], one[blockSize];
	const auto randomise = [&](double* values, int n) {
		for (int i = 0; i < n; ++i)
			values[i] = uniform(random);
	};
	randomise(two[0], 2 * blockSize);
	randomise(eight[0], 8 * blockSize);
	for (const bool replaced : { false, true })
		for (const bool carried : { false, true })
			onGrid([&](double* g) {
				loops.mapMotion(
				        w,
				        { at(0),
				          at(1),
				          replaced ? at(2) : nullptr,
				          { at(3), at(4) },
				          { at(5), at(6), at(7), at(8) },
				          carried ? at(11) : nullptr,
				          at(12),
				          0.4,
				          g });
			});
	onGrid([&](double* g) { loops.mapEight(w, eight, g); });
	onGrid([&](double* g) { loops.mapTwo(w, two, g); });
	const PlaneLoops::HeatFlow heat { at(0), at(1), at(2), at(3), 0.7, 0.3, 0.2 };
	onGrid([&](double* g) { loops.flowHeat(w, heat, grid.data(), g); });
	onGrid([&](double* g) { loops.flowPressure(w, at(0), grid.data(), g); });
	onGrid([&](double* g) { loops.flowHeatAndPressure(w, heat, grid.data(), g); });
	onGrid([&](double* g) { loops.seep(w, { grid.data(), at(0), { at(3), at(4) }, at(5), 0.7, 4.2, 3.3, g }); });
	loops.gatherMotion(w, { grid.data(), { at(9), at(10) }, { at(11), at(12) }, { at(13), at(14) }, { at(15), at(16), at(17), at(18) }, 0.97, 1e-3 });
	loops.gatherEight(w, grid.data(), eight);
	for (auto& f : eight)
		keep(f, count);
	loops.gatherScalar(w, grid.data(), one);
	keep(one, count);
	const double* const gradient[4] = { at(15), at(16), at(17), at(18) };
	double* const       stress[4]   = { at(5), at(6), at(7), at(8) };
	loops.elastic(40, at(19), at(20), gradient, stress);
	for (int k = 0; k < 21; ++k)
		keep(at(k), 40);
	return all;
}

} // namespace

TEST(MpmPlaneLoops, VersionsThatRoundAlikeGiveTheSameBitsAndThoseThatRoundTwiceDifferByRoundOff)
{
	const std::vector<const PlaneLoops*> versions = planeLoopVersions();
	const PlaneLoops&                    chosen   = planeLoops();
	const std::vector<double>            best     = resultsOf(chosen);
	std::vector<double>                  roundedTwice;
	for (const PlaneLoops* version : versions) {
		const std::vector<double> results = resultsOf(*version);
		ASSERT_EQ(results.size(), best.size());
		if (!version->roundsOnce && roundedTwice.empty()) roundedTwice = results;
		const std::vector<double>& alike     = version->roundsOnce == chosen.roundsOnce ? best : roundedTwice;
		long                       different = 0;
		double                     worst     = 0.0;
		for (std::size_t i = 0; i < results.size(); ++i) {
			different += std::memcmp(&results[i], &alike[i], sizeof(double)) != 0;
			// sums of numbers of order one and of slopes of order ten
			worst = std::max(worst, std::abs(results[i] - best[i]) / std::max(10.0, std::abs(best[i])));
		}
		std::printf(
		        "%s rounds %s: %ld of %zu numbers differ from those of versions that round alike, by %.1e at most from %s, which runs here\n",
		        version->name, version->roundsOnce ? "once" : "twice", different, results.size(), worst, chosen.name);
		EXPECT_EQ(different, 0);
		EXPECT_LE(worst, 1e-14);
	}
	EXPECT_GE(versions.size(), 1u);
}
