// SPDX-License-Identifier: GPL-2.0-or-later
#include <pkg/mpm/effects/PositionCheck.hpp>
#include <pkg/thm/ProcessorVersions.hpp>

#include <algorithm>
#include <cmath>

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

	/// The larger number, or what is not a number.
	double larger(double a, double b) { return std::isnan(a) || a > b ? a : b; }
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

/// Upper bound of |displacement| of any point in this step, per axis [m]; not a number in a run that became unstable.
template <int D> double PositionCheck<D>::longestPath(const StepContext<D>& step, const SolidMotion<D>& motion, const ThawFront<D>* front)
{
	partial_.assign(step.owned.chunks(), 0.0);
	step.owned.overNodes([&](int chunk, int first, int last) {
		Vec<D> most {}, notFinite {};
		for (int i = first; i < last; ++i)
			for (int a = 0; a < D; ++a) {
				const double speed = std::fabs(motion.solved[i][motion.velocityAt + a]);
				most[a]            = speed > most[a] ? speed : most[a];
				notFinite[a] += speed - speed;
			}
		for (int a = 0; a < D; ++a)
			partial_[chunk] = larger(partial_[chunk], most[a] + notFinite[a]);
	});
	double longest = 0.0;
	for (const double chunk : partial_)
		longest = larger(longest, chunk);
	return step.dt * (front ? larger(longest, longest + front->fastest()) : longest);
}

template <int D>
bool PositionCheck<D>::leaves(
        const StepContext<D>& step, const MaterialPoints<D>& points, const ShapeFunction<D>& shape, const SolidMotion<D>& motion, const ThawFront<D>* front,
        int p, WeightBlock<D>& w) const
{
	const Grid<D>& grid = step.grid;
	shape.evaluate(grid, points.positions(), p, 1, w);
	Vec<D> next = points.at(p);
	overNodes<D>(w, 0, [&](int node, double s, const Vec<D>&) {
		const double* jump = front ? front->correction(node, p) : nullptr;
		for (int a = 0; a < D; ++a)
			next[a] += step.dt * s * (motion.solved[node][motion.velocityAt + a] + (jump ? jump[a] : 0.0));
	});
	// rounding may differ from that of the step itself
	constexpr double rounding = 1e-13;
	const double     size     = grid.spacing() * rounding;
	for (int a = 0; a < D; ++a)
		if (!grid.isPeriodic(a) && !(next[a] >= grid.lower()[a] - size && next[a] <= grid.upper()[a] + size)) return true;
	return false;
}

template <int D>
typename PositionCheck<D>::Paths PositionCheck<D>::checkPaths(
        const StepContext<D>& step, const MaterialPoints<D>& points, const ShapeFunction<D>& shape, const SolidMotion<D>& motion, const ThawFront<D>* front)
{
	const double   reach    = longestPath(step, motion, front);
	const Grid<D>& grid     = step.grid;
	const auto     mayLeave = [&](const Vec<D>& low, const Vec<D>& high) {
                for (int a = 0; a < D; ++a)
                        if (!grid.isPeriodic(a) && !(low[a] - reach >= grid.lower()[a] && high[a] + reach <= grid.upper()[a])) return true;
                return false;
	};
	leave_.assign(bounds_.size(), 0);
	step.strips.gather([&](int strip, int first, int last) {
		if (first == last) return;
		const Bounds& b = bounds_[strip];
		if (b.numbers && !mayLeave(b.low, b.high)) return;
		WeightBlock<D> w;
		for (int p = first; p < last && !leave_[strip]; ++p) {
			const Vec<D> x = points.at(p);
			leave_[strip]  = mayLeave(x, x) && leaves(step, points, shape, motion, front, p, w);
		}
	});
	return { std::any_of(leave_.begin(), leave_.end(), [](char leave) { return leave != 0; }), std::isfinite(reach) };
}

template <int D>
std::vector<int> PositionCheck<D>::leaving(
        const StepContext<D>& step, const MaterialPoints<D>& points, const ShapeFunction<D>& shape, const SolidMotion<D>& motion,
        const ThawFront<D>* front) const
{
	WeightBlock<D>   w;
	std::vector<int> places;
	for (int p = step.strips.firstPoint(); p < step.strips.endPoint(); ++p)
		if (leaves(step, points, shape, motion, front, p, w)) places.push_back(p);
	return places;
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

template class PositionCheck<2>;
template class PositionCheck<3>;

} // namespace talik
