// SPDX-License-Identifier: GPL-2.0-or-later
#include <pkg/base/Errors.hpp>
#include <pkg/mpm/skeleton/BinghamSkeleton.hpp>
#include <pkg/mpm/skeleton/ElasticSkeleton.hpp>
#include <pkg/mpm/skeleton/ShearStress.hpp>

#include <cmath>

namespace talik {

template <int D> void BinghamSkeleton<D>::validate() const
{
	requireSetting(std::isfinite(young) && young > 0.0, "BinghamSkeleton.young", young, "must be positive, in Pa");
	requireSetting(poisson > -1.0 && poisson < 0.5, "BinghamSkeleton.poisson", poisson, "must lie in (-1, 0.5)");
	requireSetting(std::isfinite(yieldStress) && yieldStress >= 0.0, "BinghamSkeleton.yieldStress", yieldStress, "must be finite and not negative, in Pa");
	requireSetting(
	        std::isfinite(yieldStressFrozen) && yieldStressFrozen >= yieldStress, "BinghamSkeleton.yieldStressFrozen", yieldStressFrozen,
	        "must be finite and at least yieldStress, in Pa");
	requireSetting(std::isfinite(viscosity) && viscosity > 0.0, "BinghamSkeleton.viscosity", viscosity, "must be positive, in Pa s");
}

template <int D> void BinghamSkeleton<D>::declareFields(PointFields& fields, const std::string& prefix)
{
	fields.declare(prefix + "flowStrain", "BinghamSkeleton", "-", strain_);
}

/// Eq. (27.2).
template <int D> void BinghamSkeleton<D>::flow(const SkeletonBatch<D>& b, int first, int count)
{
	const double shear = LameModuli(young, poisson).shear;
	const double ratio = shear * b.time.motion / viscosity;
	for (int p = first; p < first + count; ++p) {
		ShearStress<D> stress(b, p);
		const double   trial = stress.value(), yield = yieldStressAt(b.iceSaturation ? b.iceSaturation[p] : 0.0);
		if (!(trial > yield)) continue;
		const double tau = (trial + ratio * yield) / (1.0 + ratio);
		stress.become(tau);
		if (strain_) strain_[p] += (trial - tau) / shear;
	}
}

template <int D> void BinghamSkeleton<D>::updateStress(const SkeletonBatch<D>& b)
{
	updateElasticBatch<D>(b, LameModuli(young, poisson), [&](int first, int count) { flow(b, first, count); });
}

TALIK_IN_PLANE_AND_SPACE(BinghamSkeleton);

} // namespace talik
