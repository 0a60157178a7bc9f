// SPDX-License-Identifier: GPL-2.0-or-later
#include <pkg/mpm/effects/StrainWork.hpp>

#include <algorithm>

namespace talik {

namespace {
	/// Sum of value(p, trace, mean) for first <= p < last, in the order of the points; the values are found in vectors. trace: sum of the first Direct
	/// direct strains; mean: that of the cell, the trace itself where means is null.
	template <int Direct, int D, class Value>
	[[gnu::always_inline]] inline double inOrder(int first, int last, const std::array<double*, 3>& direct, const CellMeans<D>* means, Value&& value)
	{
		constexpr int piece = 32;
		double        sum   = 0.0, values[piece], trace[piece], mean[piece];
		for (int start = first; start < last; start += piece) {
			const int n = std::min(piece, last - start);
#pragma GCC ivdep
			for (int k = 0; k < n; ++k) {
				trace[k] = 0.0;
#pragma GCC unroll 3
				for (int a = 0; a < Direct; ++a)
					trace[k] += direct[a][start + k];
				mean[k] = trace[k];
			}
			for (int k = 0; means && k < n; ++k)
				mean[k] = means->mean(start + k, trace[k]);
#pragma GCC ivdep
			for (int k = 0; k < n; ++k)
				values[k] = value(start + k, trace[k], mean[k]);
			for (int k = 0; k < n; ++k)
				sum += values[k];
		}
		return sum;
	}
} // namespace

template <int D>
double StrainWork<D>::skeletonWork(const MaterialPoints<D>& points, const SolidMotion<D>& motion, const CellMeans<D>* means, int first, int last)
{
	const std::array<double*, D* D>          g      = motion.gradient;
	const std::array<double*, stressSize<D>> stress = motion.stress;
	const double* const                      volume = points.volume();
	const std::array<double*, 3>             direct = motion.direct;
	const Vec<3>                             share  = motion.traceShare;
	return motion.overDirect([&](auto count) __attribute__((always_inline)) {
		return inOrder<count>(
		        first, last, direct, means, [&](int p, double trace, double mean) __attribute__((always_inline)) {
			        const double missing = mean - trace;
			        double       density = 0.0;
#pragma GCC unroll 3
			        for (int i = 0; i < D; ++i)
#pragma GCC unroll 3
				        for (int j = 0; j < D; ++j)
					        density += stress[stressIndex<D>(i, j)][p] * (g[i * D + j][p] + (i == j ? missing * share[i] : 0.0));
			        if constexpr (count > D) density += stress[2][p] * (direct[2][p] + missing * share[2]);
			        return volume[p] * density;
		        });
	});
}

template <int D>
double StrainWork<D>::pressureWork(
        const MaterialPoints<D>& points, const SolidMotion<D>& motion, const double* pressure, const CellMeans<D>* means, int first, int last)
{
	const std::array<double*, 3> direct = motion.direct;
	const double* const          volume = points.volume();
	return motion.overDirect([&](auto count) __attribute__((always_inline)) {
		return inOrder<count>(
		        first, last, direct, means, [&](int p, double, double mean) __attribute__((always_inline)) { return volume[p] * pressure[p] * mean; });
	});
}

template <int D>
void StrainWork<D>::bookStart(
        const StepContext<D>& step, const MaterialPoints<D>& points, const SolidMotion<D>& motion, const PoreWater<D>* water, const CellMeans<D>* means) const
{
	step.bookByStrip([&](StepAccount<D>& account, int first, int last) {
		account.skeletonWork += 0.5 * skeletonWork(points, motion, means, first, last);
		if (water && pressureAtStart != 0.0)
			account.porePressureWork += -pressureAtStart * pressureWork(points, motion, water->pressure, means, first, last);
	});
}

template <int D>
void StrainWork<D>::bookEnd(const StepContext<D>& step, const MaterialPoints<D>& points, const SolidMotion<D>& motion, const PoreWater<D>* water) const
{
	const double share = 1.0 - pressureAtStart;
	step.bookByStrip([&](StepAccount<D>& account, int first, int last) {
		const double ofStress   = 0.5 * skeletonWork(points, motion, nullptr, first, last);
		const double ofPressure = water && share != 0.0 ? -share * pressureWork(points, motion, water->pressure, nullptr, first, last) : 0.0;
		account.skeletonWork += ofStress;
		account.porePressureWork += ofPressure;
		account.workAhead += ofStress + (pressureActsNow ? 0.0 : ofPressure);
	});
	if (water && share != 0.0) water->bookSeepageWork(step.owned, share, step.ledger);
}

TALIK_IN_PLANE_AND_SPACE(StrainWork);

} // namespace talik
