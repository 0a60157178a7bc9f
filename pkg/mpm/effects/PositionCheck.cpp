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
		double low = x[0], high = x[0], notFinite = 0.0;
#pragma omp simd reduction(min : low) reduction(max : high) reduction(+ : notFinite)
		for (int k = 0; k < count; ++k) {
			low  = x[k] < low ? x[k] : low;
			high = x[k] > high ? x[k] : high;
			notFinite += x[k] - x[k];
		}
		return { low, high, notFinite == 0.0 };
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
