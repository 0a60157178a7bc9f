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
} // namespace

/// Speed of the fastest wave at a point, with that of the point or its water [m/s].
template <int D> double Ground<D>::Parts::signalSpeed(int p, double modulus) const
{
	const double tied = implicit ? content->liquidMass(p) : 0.0;
	double       c    = std::sqrt(modulus * points->volume()[p] / (motion->mass[p] + tied));
	double       v    = sizeAt<D>(motion->velocity, p);
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
		        whereabouts(*points, p, clock.steps) + " or its water moves at " + std::to_string(v)
		        + " m/s: the run became unstable; go on from a checkpoint with a smaller time step or slower scales of heat and seepage");
	return c + v;
}

/// Step in which seeping water passes a point's heat on by a cell [s].
template <int D> double Ground<D>::Parts::advectionStep(int p) const
{
	double q = 0.0;
	for (int a = 0; a < D; ++a) {
		const double w = implicit ? implicit->seepage[a][p] : water->velocity[a][p] - motion->velocity[a][p];
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
	g.cost.time(CostMeter::limits, [&] { result = g.ranks ? g.limitsOfRanks() : g.limitsOfPoints(); });
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
		const double reach = h * std::min(s.courantNumber, std::sqrt(2.0 / ((s.axisymmetric ? 3 : D) * g.shape->steepness())));
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

TALIK_IN_PLANE_AND_SPACE(Ground);

} // namespace talik
