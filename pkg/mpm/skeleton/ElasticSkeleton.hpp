// SPDX-License-Identifier: GPL-2.0-or-later
#pragma once

#include <pkg/base/Errors.hpp>
#include <pkg/base/ParameterList.hpp>
#include <pkg/base/ThreadPool.hpp>
#include <pkg/mpm/points/ObjectiveUpdate.hpp>
#include <pkg/mpm/skeleton/SkeletonModel.hpp>

#include <algorithm>
#include <cmath>

/// Parameters of ElasticSkeleton, for the model and for the class that a script sees.
// clang-format off
#define TALIK_ELASTIC_SKELETON \
	((Real, young, 10e6,,"Young's modulus E [Pa], > 0.")) \
	((Real, poisson, 0.3,,"Poisson's ratio [-], in (-1, 0.5)."))
// clang-format on

namespace talik {

/// Elastic stress of a batch of points by the Jaumann rate; then after(first place, count) of each run of places that follow each other. A thread
/// works on pieces of Piece points; several threads do from Parallel points on, fewer take less time than threads to meet.
template <int D, int Piece = 256, int Parallel = 2000, class After> void updateElasticBatch(const SkeletonBatch<D>& b, const LameModuli& moduli, After&& after)
{
	double lambda[Piece], shear[Piece];
	std::fill(lambda, lambda + Piece, moduli.lambda);
	std::fill(shear, shear + Piece, moduli.shear);
	ThreadPool::run((b.count + Piece - 1) / Piece, b.count >= Parallel ? ThreadPool::threads() : 1, [&](int i, int) {
		const int end = std::min(b.count, (i + 1) * Piece);
		for (int k = i * Piece; k < end;) {
			// places that follow each other are worked on in one go
			const int first = k, place = b.place[k];
			while (k < end && b.place[k] == place + (k - first))
				++k;
			updateElastic<D>(k - first, lambda, shear, from(b.gradient, place), from(b.stress, place), b.hoopFrom(place));
			after(place, k - first);
		}
	});
}

/// Isotropic linear elasticity in rate form with the Jaumann stress rate, integrated with the midpoint rotation, so that a
/// rigid rotation turns the stress exactly.
template <int D> class ElasticSkeleton final : public SkeletonModel<D> {
public:
	TALIK_PARAMETERS(TALIK_ELASTIC_SKELETON)

	std::string name() const override { return "ElasticSkeleton"; }
	bool        canFail() const override { return false; }
	bool        knowsHoopStrain() const override { return true; }
	void        validate() const override
	{
		requireSetting(std::isfinite(young) && young > 0.0, "ElasticSkeleton.young", young, "must be positive, in Pa");
		requireSetting(poisson > -1.0 && poisson < 0.5, "ElasticSkeleton.poisson", poisson, "must lie in (-1, 0.5)");
	}
	void updateStress(const SkeletonBatch<D>& b) override
	{
		updateElasticBatch<D, 1024, 4000>(b, LameModuli(young, poisson), [](int, int) {});
	}
	void tangentModulus(const SkeletonBatch<D>& b, double* modulus) const override { b.fill(modulus, LameModuli(young, poisson).oedometer()); }
};

} // namespace talik
