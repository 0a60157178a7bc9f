// SPDX-License-Identifier: GPL-2.0-or-later
#include <pkg/mpm/GroundParts.hpp>

#include <algorithm>
#include <cmath>
#include <functional>

namespace talik {

namespace {
	constexpr double infinity = std::numeric_limits<double>::infinity();
	/// Nothing that thaws or falls is as fast [m/s]. The time step would follow a run that diverges towards zero and never end.
	constexpr double fastestGround = 1e5;
} // namespace

namespace {
	/// Length of a vector of a point.
	template <int D> double sizeAt(const std::array<double*, D>& v, int p)
	{
		double sum = 0.0;
		for (int a = 0; a < D; ++a)
			sum += v[a][p] * v[a][p];
		return std::sqrt(sum);
	}

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

/// Speed of the fastest wave at a point, with that of the point or its water [m/s].
template <int D> double Ground<D>::Parts::signalSpeed(int p, double modulus) const
{
	double c = std::sqrt(modulus * points->volume()[p] / motion->mass[p]);
	double v = sizeAt<D>(motion->velocity, p);
	if (water) {
		if (!implicit) {
			const double               porosity = content->porosity[p];
			const double               sl       = content->iceSaturation ? 1.0 - content->iceSaturation[p] : 1.0;
			const double               t        = heat ? heat->temperature[p] : content->mixture(p).referenceTemperature;
			const PressureCoefficients k        = settings.water->state.coefficients(content->mixture(p), { porosity, sl, 0.0, t });
			c                                   = largestWaveSpeed(content->mixture(p), VolumeFractions::of(porosity, sl), k, modulus);
		}
		v = std::max(v, sizeAt<D>(water->velocity, p));
	}
	if (v > fastestGround)
		throw std::runtime_error(
		        whereabouts(p) + " or its water moves at " + std::to_string(v)
		        + " m/s: the run became unstable; go on from a checkpoint with a smaller time step or slower scales of heat and seepage");
	return c + v;
}

/// Step in which seeping water passes a point's heat on by a cell [s].
template <int D> double Ground<D>::Parts::advectionStep(int p) const
{
	double q = 0.0;
	for (int a = 0; a < D; ++a) {
		const double w = water->velocity[a][p] - motion->velocity[a][p];
		q += w * w;
	}
	q               = water->liquidFraction[p] * std::sqrt(q);
	const Phase& of = content->mixture(p).liquid;
	return grid.spacing() * heat->heatCapacity[p] / (points->volume()[p] * of.density * of.specificHeat * q);
}

template <int D> StableTimeStep Ground<D>::stableTimeStep() const
{
	const Parts& g = *parts_;
	if (!g.ready) throw std::logic_error("stableTimeStep: the ground is not initialised");
	StableTimeStep result;
	g.cost.start();
	g.cost.time(CostMeter::limits, [&] { result = g.bands ? g.limitsOfRanks() : g.limitsOfPoints(); });
	result.step = infinity;
	for (const TimeStepLimit& limit : result.limits)
		if (limit.step < result.step) {
			result.step      = limit.step;
			result.governing = limit.name;
		}
	return result;
}

template <int D> StableTimeStep Ground<D>::Parts::limitsOfPoints() const
{
	const Parts&             g = *this;
	const GroundSettings<D>& s = g.settings;
	const double             h = g.grid.spacing();

	StableTimeStep result;
	const auto     add = [&](const std::string& name, const std::function<double(int)>& limitOf) {
                TimeStepLimit limit { name, infinity, -1 };
                for (int p = g.points->strips().firstPoint(); p < g.points->strips().endPoint(); ++p) {
                        const double step = limitOf(p);
                        if (step < limit.step) limit.step = step, limit.point = g.points->id(p);
                }
                result.limits.push_back(limit);
	};
	if (g.motion) {
		// What a step adds to nodal velocities reaches the next one by way of the points, smoothed: a mode keeps the share s of it, and g of
		// its velocity, 0 <= s <= g <= 1. It grows where (omega dt)^2 > 2 (1 + g)/(1 + g - s), which is 4 without smoothing and never below 2.
		// No mode has omega > sqrt(D steepness) c/h.
		const double reach = h * std::min(s.courantNumber, std::sqrt(2.0 / (D * g.shape->steepness())));
		g.skeletons.tangentModulus(g.stepTime(), g.scratch.data());
		add("wave", [&](int p) { return reach / g.signalSpeed(p, g.scratch[p]); });
		add("velocity", [&](int p) { return s.motionFraction * h / sizeAt<D>(g.motion->velocity, p); });
		for (const auto& effect : g.effects)
			if (effect->limitsStep()) add(effect->name(), [&](int p) { return effect->largestStep(g.inMotion, p, h); });
		if (g.bodies) add("contact", [&](int p) { return g.bodies->timeStep(p); });
	}
	if (g.heat) {
		// where the scale follows the motion it is lowered where heat needs that, and the step stays that of motion
		const double slowest = g.calendar ? s.heat->movingTimeScale : s.heat->thermalTimeScale;
		const double scale   = 2.0 * D * slowest / (s.heatFraction * h * h);
		add("heat", [&](int p) { return g.heat->heatCapacity[p] / (g.points->volume()[p] * g.heat->conductivity[p] * scale); });
		if (g.water) add("heat advection", [&](int p) { return g.advectionStep(p); });
	}
	return result;
}

// ---- points that are about to leave the grid are found before the first of them has moved ---------------------------------

namespace {
	/// The larger number, or what is not a number.
	double larger(double a, double b) { return std::isnan(a) || a > b ? a : b; }
} // namespace

/// Upper bound of |displacement| of any point in this step, per axis [m]; not a number in a run that became unstable.
template <int D> double Ground<D>::Parts::longestPath()
{
	partial.assign(reached.chunks(), 0.0);
	reached.overNodes([&](int chunk, int first, int last) {
		Vec<D> most {}, notFinite {};
		for (int i = first; i < last; ++i)
			for (int a = 0; a < D; ++a) {
				const double speed = std::fabs(motion->solved[i][motion->velocityAt + a]);
				most[a]            = speed > most[a] ? speed : most[a];
				notFinite[a] += speed - speed;
			}
		for (int a = 0; a < D; ++a)
			partial[chunk] = larger(partial[chunk], most[a] + notFinite[a]);
	});
	double longest = 0.0;
	for (const double chunk : partial)
		longest = larger(longest, chunk);
	return clock.dt * (front ? larger(longest, longest + front->fastest()) : longest);
}

template <int D> bool Ground<D>::Parts::mayLeaveGrid(int p, double reach) const
{
	for (int a = 0; a < D; ++a) {
		const double x = points->position(a)[p];
		if (!(x - reach >= grid.lower()[a] && x + reach <= grid.upper()[a])) return true;
	}
	return false;
}

template <int D> bool Ground<D>::Parts::leavesGrid(int p, WeightBlock<D>& w) const
{
	std::array<const double*, D> x;
	for (int a = 0; a < D; ++a)
		x[a] = points->position(a);
	shape->evaluate(grid, x, p, 1, w);
	Vec<D> next;
	for (int a = 0; a < D; ++a)
		next[a] = x[a][p];
	overNodes<D>(w, 0, [&](int node, double s, const Vec<D>&) {
		const double* jump = front ? front->correction(node, p) : nullptr;
		for (int a = 0; a < D; ++a)
			next[a] += clock.dt * s * (motion->solved[node][motion->velocityAt + a] + (jump ? jump[a] : 0.0));
	});
	// rounding may differ from that of the step itself
	constexpr double rounding = 1e-13;
	const double     size     = grid.spacing() * rounding;
	for (int a = 0; a < D; ++a)
		if (!(next[a] >= grid.lower()[a] - size && next[a] <= grid.upper()[a] + size)) return true;
	return false;
}

template <int D> void Ground<D>::Parts::boundPositions(int strip, int first, int last)
{
	PositionBounds& b = bounds[strip];
	b.numbers         = true;
	for (int a = 0; a < D && first < last; ++a) {
		const Extent extent = extentOf(last - first, points->position(a) + first);
		b.low[a]            = extent.low;
		b.high[a]           = extent.high;
		b.numbers           = b.numbers && extent.numbers;
	}
}

/// Points outside the grid's box are noted, and sorting is asked for where points have strayed far from their strip or out of the
/// rows that are cleared in every step.
template <int D> void Ground<D>::Parts::checkPositions()
{
	const Strips& strips = points->strips();
	const int     stride = grid.cellStride(strips.axis);
	const double  origin = grid.lower()[strips.axis], h = grid.spacing();
	const double  cleared = clock.range.firstCell / stride, clearedEnd = clock.range.lastCell / stride;
	for (int s = strips.begin(); s < strips.end(); ++s) {
		if (strips.first[s] == strips.first[s + 1]) continue;
		const PositionBounds& b = bounds[s];
		if (!(b.numbers && grid.contains(b.low) && grid.contains(b.high))) {
			findOutside(s);
			continue;
		}
		const double low  = origin + std::max(s * Strips::rows - Strips::stray, cleared) * h;
		const double high = origin + std::min((s + 1) * Strips::rows + Strips::stray, clearedEnd) * h;
		if (b.low[strips.axis] < low || b.high[strips.axis] >= high) clock.sortWanted = 1;
	}
}

template <int D> void Ground<D>::Parts::findOutside(int strip)
{
	for (int p = points->strips().first[strip + 1] - 1; p >= points->strips().first[strip]; --p) {
		Vec<D> x;
		for (int a = 0; a < D; ++a)
			x[a] = points->position(a)[p];
		if (!grid.contains(x)) bad[strip] = p;
	}
}

template <int D> void Ground<D>::Parts::requirePathsInside()
{
	const double reach = longestPath();
	points->strips().gather([&](int strip, int first, int last) {
		if (first == last) return;
		const PositionBounds& b    = bounds[strip];
		bool                  near = !b.numbers;
		for (int a = 0; a < D; ++a)
			near = near || !(b.low[a] - reach >= grid.lower()[a]) || !(b.high[a] + reach <= grid.upper()[a]);
		if (!near) return;
		WeightBlock<D> w;
		for (int p = last - 1; p >= first; --p)
			if (mayLeaveGrid(p, reach) && leavesGrid(p, w)) bad[strip] = p;
	});
	constexpr unsigned leave = 1, unstable = 2;
	const unsigned     own   = (anyBad() ? leave : 0) | (std::isfinite(reach) ? 0 : unstable);
	const unsigned     found = bands ? bands->anyOf(own) : own;
	if (found & leave) refuseToLeave(!(found & unstable));
}

template <int D> void Ground<D>::Parts::refuseToLeave(bool stable)
{
	std::fill(bad.begin(), bad.end(), -1);
	WeightBlock<D>   w;
	std::vector<int> leaving;
	for (int p = points->strips().firstPoint(); p < points->strips().endPoint(); ++p)
		if (leavesGrid(p, w)) leaving.push_back(p);
	const Concerned   all   = concerned(leaving);
	const std::string place = all.count == 0 ? "a material point" : all.first;
	clock                   = clockBefore;
	throw std::runtime_error(
	        place + (stable ? " would have left the grid's box" : " has no finite velocity: the run became unstable") + " (" + std::to_string(all.count)
	        + (all.count == 1 ? " point concerned: " : " points concerned: ") + all.names + (all.count > 5 ? ", ..." : "")
	        + "); the ground is as it was before this step: "
	        + (stable ? "enlarge the box or hold the ground with a boundary there" : "use a smaller time step"));
}

template StableTimeStep Ground<2>::stableTimeStep() const;
template StableTimeStep Ground<3>::stableTimeStep() const;
template StableTimeStep Ground<2>::Parts::limitsOfPoints() const;
template StableTimeStep Ground<3>::Parts::limitsOfPoints() const;
template void           Ground<2>::Parts::boundPositions(int, int, int);
template void           Ground<3>::Parts::boundPositions(int, int, int);
template void           Ground<2>::Parts::checkPositions();
template void           Ground<3>::Parts::checkPositions();
template void           Ground<2>::Parts::requirePathsInside();
template void           Ground<3>::Parts::requirePathsInside();

} // namespace talik
