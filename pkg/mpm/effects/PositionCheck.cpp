// SPDX-License-Identifier: GPL-2.0-or-later
#include <pkg/base/ProcessorVersions.hpp>
#include <pkg/mpm/effects/PositionCheck.hpp>

#include <algorithm>

namespace talik {

namespace {
	/// The smallest and the largest of some numbers, count >= 1.
	struct Extent {
		double low, high;
		bool   numbers; ///< false: one of them is not finite
	};
	TALIK_PROCESSOR_VERSIONS Extent extentOf(int count, const double* x)
	{
		constexpr int lanes = 32; // independent of each other, and too many to be unrolled: the compiler makes vectors of them
		double        low[lanes], high[lanes], notFinite[lanes];
		for (int l = 0; l < lanes; ++l) {
			low[l] = high[l] = x[0];
			notFinite[l]     = 0.0;
		}
		int k = 0;
		for (; k + lanes <= count; k += lanes)
			for (int l = 0; l < lanes; ++l) {
				const double value = x[k + l];
				low[l]             = value < low[l] ? value : low[l];
				high[l]            = value > high[l] ? value : high[l];
				notFinite[l] += value - value;
			}
		for (; k < count; ++k) {
			low[0]  = x[k] < low[0] ? x[k] : low[0];
			high[0] = x[k] > high[0] ? x[k] : high[0];
			notFinite[0] += x[k] - x[k];
		}
		Extent all { low[0], high[0], notFinite[0] == 0.0 };
		for (int l = 1; l < lanes; ++l) {
			all.low     = low[l] < all.low ? low[l] : all.low;
			all.high    = high[l] > all.high ? high[l] : all.high;
			all.numbers = all.numbers && notFinite[l] == 0.0;
		}
		return all;
	}
} // namespace

template <int D> void PositionCheck<D>::start(const MaterialPoints<D>& points)
{
	bounds_.resize(points.strips().count());
	points.strips().gather([&](int strip, int first, int last) { bound(points, strip, first, last); });
}

template <int D> void PositionCheck<D>::bound(const MaterialPoints<D>& points, int strip, int first, int last)
{
	Bounds& b = bounds_[strip];
	b.numbers = true;
	for (int a = 0; a < D && first < last; ++a) {
		const Extent extent = extentOf(last - first, points.position(a) + first);
		b.low[a]            = extent.low;
		b.high[a]           = extent.high;
		b.numbers           = b.numbers && extent.numbers;
	}
}

template <int D>
typename PositionCheck<D>::Positions PositionCheck<D>::checkPositions(
        const StepContext<D>& step, const MaterialPoints<D>& points, const ActiveRange& cleared) const
{
	Positions      found;
	const Grid<D>& grid   = step.grid;
	const Strips&  strips = step.strips;
	const int      stride = grid.cellStride(strips.axis);
	const double   origin = grid.lower()[strips.axis], h = grid.spacing();
	const double   firstRow = cleared.firstCell / stride, endRow = cleared.lastCell / stride;
	for (int s = strips.begin(); s < strips.end(); ++s) {
		if (strips.first[s] == strips.first[s + 1]) continue;
		const Bounds& b = bounds_[s];
		if (!(b.numbers && grid.contains(b.low) && grid.contains(b.high))) {
			int p = strips.first[s];
			while (p < strips.first[s + 1] && grid.contains(points.at(p)))
				++p;
			if (p < strips.first[s + 1]) found.outside.push_back(p);
			continue;
		}
		const double low  = origin + std::max(s * Strips::rows - Strips::stray, firstRow) * h;
		const double high = origin + std::min((s + 1) * Strips::rows + Strips::stray, endRow) * h;
		found.strayed     = found.strayed || b.low[strips.axis] < low || b.high[strips.axis] >= high;
	}
	return found;
}

TALIK_IN_PLANE_AND_SPACE(PositionCheck);

} // namespace talik
