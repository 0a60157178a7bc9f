// SPDX-License-Identifier: GPL-2.0-or-later
#include <pkg/mpm/Errors.hpp>
#include <pkg/mpm/kernels/PlaneLoops.hpp>
#include <pkg/mpm/points/ObjectiveUpdate.hpp>
#include <pkg/mpm/skeleton/ElasticSkeleton.hpp>
#include <pkg/mpm/ThreadTeam.hpp>

#include <algorithm>

namespace talik {

namespace {

	/// Places that follow each other are worked on in one go.
	void updateRuns(const SkeletonBatch<2>& b, const LameModuli& moduli)
	{
		constexpr int     piece  = 1024;
		const int         pieces = (b.count + piece - 1) / piece;
		const PlaneLoops& loops  = planeLoops();
		double            lambda[piece], shear[piece];
		std::fill(lambda, lambda + piece, moduli.lambda);
		std::fill(shear, shear + piece, moduli.shear);
		ThreadTeam::run(pieces, b.count >= 4000 ? ThreadTeam::threads() : 1, [&](int i, int) {
			const int end = std::min(b.count, (i + 1) * piece);
			for (int k = i * piece; k < end;) {
				const int first = k, place = b.place[k];
				while (k < end && b.place[k] == place + (k - first))
					++k;
				const double* const gradient[4] = { b.gradient[0] + place, b.gradient[1] + place, b.gradient[2] + place,
					                            b.gradient[3] + place };
				double* const       stress[4]   = { b.stress[0] + place, b.stress[1] + place, b.stress[2] + place, b.stress[3] + place };
				loops.elastic(k - first, lambda, shear, gradient, stress);
			}
		});
	}
	[[maybe_unused]] void updateRuns(const SkeletonBatch<3>&, const LameModuli&) {}

	template <int D> void updateInSpace(const SkeletonBatch<D>& b, int p, const LameModuli& moduli)
	{
		double gradient[D * D], s[stressSize<D>];
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

} // namespace

template <int D> void ElasticSkeleton<D>::validate() const
{
	requireSetting(std::isfinite(youngModulus) && youngModulus > 0.0, "ElasticSkeleton.youngModulus", youngModulus, "must be positive, in Pa");
	requireSetting(poissonRatio > -1.0 && poissonRatio < 0.5, "ElasticSkeleton.poissonRatio", poissonRatio, "must lie in (-1, 0.5)");
}

template <int D> void ElasticSkeleton<D>::updateStress(const SkeletonBatch<D>& b)
{
	const LameModuli moduli(youngModulus, poissonRatio);
	if constexpr (D == 2) {
		updateRuns(b, moduli);
		return;
	}
	constexpr int piece = 1024;
	ThreadTeam::run((b.count + piece - 1) / piece, b.count >= 4000 ? ThreadTeam::threads() : 1, [&](int i, int) {
		for (int k = i * piece; k < std::min(b.count, (i + 1) * piece); ++k)
			updateInSpace(b, b.place[k], moduli);
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
