// SPDX-License-Identifier: GPL-2.0-or-later
#include <pkg/mpm/Errors.hpp>
#include <pkg/mpm/points/ObjectiveUpdate.hpp>
#include <pkg/mpm/skeleton/ElasticSkeleton.hpp>
#include <pkg/mpm/ThreadTeam.hpp>

#include <algorithm>

namespace talik {

template <int D> void ElasticSkeleton<D>::validate() const
{
	requireSetting(std::isfinite(youngModulus) && youngModulus > 0.0, "ElasticSkeleton.youngModulus", youngModulus, "must be positive, in Pa");
	requireSetting(poissonRatio > -1.0 && poissonRatio < 0.5, "ElasticSkeleton.poissonRatio", poissonRatio, "must lie in (-1, 0.5)");
}

template <int D> void ElasticSkeleton<D>::updateStress(const SkeletonBatch<D>& b)
{
	constexpr int    piece = 1024;
	const LameModuli moduli(youngModulus, poissonRatio);
	double           lambda[piece], shear[piece];
	std::fill(lambda, lambda + piece, moduli.lambda);
	std::fill(shear, shear + piece, moduli.shear);
	ThreadTeam::run((b.count + piece - 1) / piece, b.count >= 4000 ? ThreadTeam::threads() : 1, [&](int i, int) {
		const int end = std::min(b.count, (i + 1) * piece);
		for (int k = i * piece; k < end;) {
			// places that follow each other are worked on in one go
			const int first = k, place = b.place[k];
			while (k < end && b.place[k] == place + (k - first))
				++k;
			updateElastic<D>(k - first, lambda, shear, from(b.gradient, place), from(b.stress, place));
		}
	});
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
