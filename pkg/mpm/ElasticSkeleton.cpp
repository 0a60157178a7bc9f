// SPDX-License-Identifier: GPL-2.0-or-later
#include <pkg/mpm/Check.hpp>
#include <pkg/mpm/ElasticSkeleton.hpp>
#include <pkg/mpm/ObjectiveUpdate.hpp>

namespace talik {

template <int D> void ElasticSkeleton<D>::validate() const
{
	requireSetting(std::isfinite(youngModulus) && youngModulus > 0.0, "ElasticSkeleton.youngModulus", youngModulus, "must be positive, in Pa");
	requireSetting(poissonRatio > -1.0 && poissonRatio < 0.5, "ElasticSkeleton.poissonRatio", poissonRatio, "must lie in (-1, 0.5)");
}

template <int D> void ElasticSkeleton<D>::updateStress(const SkeletonBatch<D>& b)
{
	const LameModuli moduli(youngModulus, poissonRatio);
#pragma omp parallel for schedule(static) if (b.count >= 4000)
	for (int k = 0; k < b.count; ++k) {
		const int p = b.place[k];
		double    gradient[D * D], s[stressSize<D>];
		for (int c = 0; c < D * D; ++c)
			gradient[c] = b.gradient[c][p];
		for (int c = 0; c < stressSize<D>; ++c)
			s[c] = b.stress[c][p];
		const MidpointIncrement<D> increment(gradient);
		increment.rotate(s);
		increment.addElastic(s, moduli.lambda, moduli.shear);
		for (int c = 0; c < stressSize<D>; ++c)
			b.stress[c][p] = s[c];
	}
}

template <int D> void ElasticSkeleton<D>::tangentModulus(const SkeletonBatch<D>& b, double* modulus) const
{
	const double m = LameModuli(youngModulus, poissonRatio).oedometer();
	for (int k = 0; k < b.count; ++k)
		modulus[b.place[k]] = m;
}

template class ElasticSkeleton<2>;
template class ElasticSkeleton<3>;

} // namespace talik
