// SPDX-License-Identifier: GPL-2.0-or-later
#pragma once

#include <pkg/mpm/skeleton/SkeletonModel.hpp>

namespace talik {

/// Isotropic linear elasticity in rate form with the Jaumann stress rate, integrated with the midpoint rotation, so that a
/// rigid rotation turns the stress exactly.
template <int D> class ElasticSkeleton final : public SkeletonModel<D> {
public:
	double youngModulus = 10e6; ///< E [Pa], > 0
	double poissonRatio = 0.3;  ///< nu [-], in (-1, 0.5)

	std::string name() const override { return "ElasticSkeleton"; }
	bool        canFail() const override { return false; }
	void        validate() const override;
	void        updateStress(const SkeletonBatch<D>&) override;
	void        tangentModulus(const SkeletonBatch<D>&, double* modulus) const override;
};

} // namespace talik
