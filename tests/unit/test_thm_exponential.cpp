// SPDX-License-Identifier: GPL-2.0-or-later
#include <pkg/base/ProcessorVersions.hpp>
#include <pkg/thm/Exponential.hpp>

#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>
#include <cstdio>
#include <vector>

using namespace talik;

namespace {

TALIK_PROCESSOR_VERSIONS void exponentials(const std::vector<double>& x, std::vector<double>& y)
{
	const double* from = x.data();
	double*       to   = y.data();
	const int     n    = int(x.size());
#pragma GCC ivdep
	for (int k = 0; k < n; ++k)
		to[k] = exponential(from[k]);
}

} // namespace

TEST(Exponential, AgreesWithTheLibraryToTwoUnitsInTheLastPlace)
{
	std::vector<double> x, y;
	for (double v = -690.0; v < 690.0; v += 0.0917)
		x.push_back(v);
	for (double v = -3.0; v < 3.0; v += 1e-4)
		x.push_back(v);
	x.push_back(0.0);
	y.resize(x.size());
	exponentials(x, y);
	double worst = 0.0;
	for (std::size_t i = 0; i < x.size(); ++i) {
		const double exact = std::exp(x[i]);
		worst              = std::max(worst, std::abs(y[i] - exact) / (std::nextafter(exact, INFINITY) - exact));
	}
	std::printf("exponential: largest error %.2f units in the last place, exp(0) = %.17g\n", worst, y.back());
	EXPECT_LE(worst, 2.0);
	EXPECT_EQ(y.back(), 1.0);
}

TEST(Exponential, VectorsGiveTheSameBitsAsSingleCalls)
{
	std::vector<double> x, y;
	for (double v = -760.0; v < 700.0; v += 0.0317)
		x.push_back(v);
	y.resize(x.size());
	exponentials(x, y);
	long different = 0;
	for (std::size_t i = 0; i < x.size(); ++i) {
		const volatile double alone = x[i];
		different += exponential(alone) != y[i];
	}
	std::printf("%ld of %zu numbers differ\n", different, x.size());
	EXPECT_EQ(different, 0);
}

TEST(Exponential, StaysPositiveAndTinyFarBelowZero)
{
	for (const double x : { -701.0, -1e4, -1e300 }) {
		EXPECT_GT(exponential(x), 0.0);
		EXPECT_LT(exponential(x), 1e-303);
	}
}
