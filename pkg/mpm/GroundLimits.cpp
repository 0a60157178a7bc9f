// SPDX-License-Identifier: GPL-2.0-or-later
#include <pkg/mpm/GroundParts.hpp>

#include <algorithm>
#include <cmath>
#include <functional>

namespace talik {

namespace {
	constexpr double infinity = std::numeric_limits<double>::infinity();
} // namespace

template <int D> StableTimeStep Ground<D>::stableTimeStep() const
{
	const Parts& g = *parts_;
	if (!g.ready) throw std::logic_error("stableTimeStep: the ground is not initialised");
	const GroundSettings<D>& s = g.settings;
	const double             h = g.grid.spacing();
	const int                n = g.points->count();
	const double*            volume = g.points->volume();

	g.cost.start();
	StableTimeStep result;
	const auto     add = [&](const char* name, const std::function<double(int)>& limitOf) {
                TimeStepLimit limit { name, infinity, -1 };
                for (int p = 0; p < n; ++p) {
                        const double step = limitOf(p);
                        if (step < limit.step) limit.step = step, limit.point = g.points->id(p);
                }
                result.limits.push_back(limit);
	};
	const auto speed = [&](const std::array<double*, D>& v, int p) {
		double sum = 0.0;
		for (int a = 0; a < D; ++a)
			sum += v[a][p] * v[a][p];
		return std::sqrt(sum);
	};

	if (g.motion) {
		// What a step adds to nodal velocities reaches the next one by way of the points, smoothed: a mode keeps the share s of it, and g of
		// its velocity, 0 <= s <= g <= 1. It grows where (omega dt)^2 > 2 (1 + g)/(1 + g - s), which is 4 without smoothing and never below 2.
		// No mode has omega > sqrt(D steepness) c/h.
		const double reach = h * std::min(s.courantNumber, std::sqrt(2.0 / (D * g.shape->steepness())));
		for (std::size_t k = 0; k < s.skeletons.size(); ++k)
			s.skeletons[k]->tangentModulus(g.batch(k), g.scratch.data());
		add("wave", [&](int p) {
			const double modulus = g.scratch[p];
			double       c       = std::sqrt(modulus * volume[p] / g.motion->mass[p]);
			double       v       = speed(g.motion->velocity, p);
			if (g.water) {
				const double  porosity = g.content->porosity[p];
				const double  sl       = g.content->iceSaturation ? 1.0 - g.content->iceSaturation[p] : 1.0;
				const double  t        = g.heat ? g.heat->temperature[p] : s.mixture.referenceTemperature;
				const PressureCoefficients k = s.water->state.coefficients(s.mixture, { porosity, sl, 0.0, t });
				c = largestWaveSpeed(s.mixture, VolumeFractions::of(porosity, sl), k, modulus);
				v = std::max(v, speed(g.water->velocity, p));
			}
			return reach / (c + v);
		});
		add("velocity", [&](int p) { return s.motionFraction * h / speed(g.motion->velocity, p); });
		if (g.bodies) add("contact", [&](int p) { return g.bodies->timeStep(p); });
	}
	if (g.heat) {
		// where the scale follows the motion it is lowered where heat needs that, and the step stays that of motion
		const double slowest = g.calendar ? s.heat->movingTimeScale : s.heat->thermalTimeScale;
		const double scale   = 2.0 * D * slowest / (s.heatFraction * h * h);
		add("heat", [&](int p) { return g.heat->heatCapacity[p] / (volume[p] * g.heat->conductivity[p] * scale); });
		if (g.water)
			add("heat advection", [&](int p) {
				double q = 0.0;
				for (int a = 0; a < D; ++a) {
					const double w = g.water->velocity[a][p] - g.motion->velocity[a][p];
					q += w * w;
				}
				q = g.water->liquidFraction[p] * std::sqrt(q);
				return h * g.heat->heatCapacity[p] / (volume[p] * s.mixture.liquid.density * s.mixture.liquid.specificHeat * q);
			});
	}
	result.step = infinity;
	for (const TimeStepLimit& limit : result.limits)
		if (limit.step < result.step) {
			result.step      = limit.step;
			result.governing = limit.name;
		}
	g.cost.lap(CostMeter::limits);
	return result;
}

template StableTimeStep Ground<2>::stableTimeStep() const;
template StableTimeStep Ground<3>::stableTimeStep() const;

} // namespace talik
