// SPDX-License-Identifier: GPL-2.0-or-later
#pragma once

#include <pkg/base/Errors.hpp>
#include <pkg/base/ParameterList.hpp>
#include <pkg/mpm/points/ObjectiveUpdate.hpp>
#include <pkg/mpm/skeleton/ElasticSkeleton.hpp>
#include <pkg/mpm/skeleton/ShearStress.hpp>
#include <pkg/mpm/skeleton/SkeletonModel.hpp>

#include <cmath>
#include <functional>

/// Parameters of CreepingSkeleton, for the model and for the class that a script sees; the rate of flow is that of IceCreep there.
// clang-format off
#define TALIK_CREEPING_SKELETON \
	((Real, young, 1e9,,"Young's modulus E [Pa], > 0. Sets the time step: a softer one runs faster, and steady creep does not know it.")) \
	((Real, poisson, 0.3,,"Poisson's ratio of the elastic part [-], in (-1, 0.5)."))
// clang-format on

namespace talik {

/// Elastic ground that flows by Glen's law while it has ice, eq. (25.1): strain rate A tau^(n-1) times the stress deviator, with tau the root
/// of its second invariant, over the time of slow processes. Volume does not creep. Ground without ice is elastic.
/// Trial stress by the Jaumann rate, then eq. (25.2): implicit in the stress, so that steady creep is exact whatever the length of a step.
template <int D> class CreepingSkeleton final : public SkeletonModel<D> {
public:
	TALIK_PARAMETERS(TALIK_CREEPING_SKELETON)
	double                        exponent = 3.0;                 ///< n of Glen's law [-], 1 to 10
	std::function<double(double)> rateFactor;                     ///< A [Pa^-n/s] at a temperature [degC]
	double                        temperatureWithoutHeat = -10.0; ///< of ground without heat [degC]

	std::string name() const override { return "CreepingSkeleton"; }
	bool        canFail() const override { return false; }
	bool        knowsHoopStrain() const override { return true; }
	void        validate() const override
	{
		requireSetting(std::isfinite(young) && young > 0.0, "CreepingSkeleton.young", young, "must be positive, in Pa");
		requireSetting(poisson > -1.0 && poisson < 0.5, "CreepingSkeleton.poisson", poisson, "must lie in (-1, 0.5)");
		requireSetting(exponent >= 1.0 && exponent <= 10.0, "CreepingSkeleton.iceCreep.exponent", exponent, "must lie in [1, 10]");
	}
	void declareFields(PointFields& fields, const std::string& prefix) override
	{
		fields.declare(prefix + "creepStrain", "CreepingSkeleton", "-", strain_);
	}
	void updateStress(const SkeletonBatch<D>& b) override
	{
		updateElasticBatch<D>(b, LameModuli(young, poisson), [&](int first, int count) {
			if (b.time.calendar > 0.0) creep(b, first, count);
		});
	}
	void tangentModulus(const SkeletonBatch<D>& b, double* modulus) const override { b.fill(modulus, LameModuli(young, poisson).oedometer()); }

	/// tau [Pa] with tau + compliance tau^n = trial; compliance: 2 G A t [Pa^(1-n)].
	static double relaxed(double trial, double compliance, double exponent)
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

private:
	/// Of points in sequence, from the trial stress.
	void creep(const SkeletonBatch<D>& b, int first, int count)
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

	double* strain_ = nullptr; ///< that has crept; null without a ground
};

} // namespace talik
