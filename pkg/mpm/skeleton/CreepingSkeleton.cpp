// SPDX-License-Identifier: GPL-2.0-or-later
#include <pkg/base/Errors.hpp>
#include <pkg/mpm/skeleton/CreepingSkeleton.hpp>
#include <pkg/mpm/skeleton/ElasticSkeleton.hpp>
#include <pkg/mpm/skeleton/ShearStress.hpp>

#include <cmath>

namespace talik {

template <int D> void CreepingSkeleton<D>::validate() const
{
	requireSetting(std::isfinite(young) && young > 0.0, "CreepingSkeleton.young", young, "must be positive, in Pa");
	requireSetting(poisson > -1.0 && poisson < 0.5, "CreepingSkeleton.poisson", poisson, "must lie in (-1, 0.5)");
	requireSetting(exponent >= 1.0 && exponent <= 10.0, "CreepingSkeleton.iceCreep.exponent", exponent, "must lie in [1, 10]");
}

template <int D> void CreepingSkeleton<D>::declareFields(PointFields& fields, const std::string& prefix)
{
	fields.declare(prefix + "creepStrain", "CreepingSkeleton", "-", strain_);
}

template <int D> double CreepingSkeleton<D>::relaxed(double trial, double compliance, double exponent)
{
	// the left side is convex and rises: Newton's steps from the trial stress fall, and stop where rounding lets them rise
	double tau = trial;
	while (true) {
		const double flown = compliance * std::pow(tau, exponent);
		const double next  = tau - (tau + flown - trial) / (1.0 + exponent * flown / tau);
		if (!(next < tau)) return tau;
		tau = next;
	}
}

template <int D> void CreepingSkeleton<D>::creep(const SkeletonBatch<D>& b, int first, int count)
{
	const double shear = LameModuli(young, poisson).shear;
	for (int p = first; p < first + count; ++p) {
		if (b.iceSaturation && b.iceSaturation[p] == 0.0) continue;
		ShearStress<D> stress(b, p);
		const double   trial = stress.value();
		if (!(trial > 0.0)) continue;
		const double rate = rateFactor(b.temperature ? b.temperature[p] : temperatureWithoutHeat);
		const double tau  = relaxed(trial, 2.0 * shear * rate * b.time.calendar, exponent);
		stress.become(tau);
		if (strain_) strain_[p] += (trial - tau) / (2.0 * shear);
	}
}

template <int D> void CreepingSkeleton<D>::updateStress(const SkeletonBatch<D>& b)
{
	updateElasticBatch<D>(b, LameModuli(young, poisson), [&](int first, int count) {
		if (b.time.calendar > 0.0) creep(b, first, count);
	});
}

TALIK_IN_PLANE_AND_SPACE(CreepingSkeleton);

} // namespace talik
