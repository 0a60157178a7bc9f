// SPDX-License-Identifier: GPL-2.0-or-later
#include <pkg/base/Errors.hpp>
#include <pkg/mpm/skeleton/ElasticSkeleton.hpp>

#include <cmath>

namespace talik {

template <int D> void ElasticSkeleton<D>::validate() const
{
	requireSetting(std::isfinite(young) && young > 0.0, "ElasticSkeleton.young", young, "must be positive, in Pa");
	requireSetting(poisson > -1.0 && poisson < 0.5, "ElasticSkeleton.poisson", poisson, "must lie in (-1, 0.5)");
}

template <int D> void ElasticSkeleton<D>::updateStress(const SkeletonBatch<D>& b)
{
	updateElasticBatch<D, 1024, 4000>(b, LameModuli(young, poisson), [](int, int) {});
}

TALIK_IN_PLANE_AND_SPACE(ElasticSkeleton);

} // namespace talik
