// SPDX-License-Identifier: GPL-2.0-or-later
#pragma once

#include <pkg/mpm/skeleton/SkeletonModel.hpp>

namespace talik {

/// Ground that flows like a Bingham fluid, eq. (26.1): elastic up to a yield stress, which ice raises, and a shear stress that grows with the rate
/// of flow beyond it. Volume responds elastically, also in tension. Trial stress by the Jaumann rate, then eq. (26.2): implicit, so that steady flow
/// has the stress of a Bingham fluid whatever the length of a step.
template <int D> class BinghamSkeleton final : public SkeletonModel<D> {
public:
	double youngModulus      = 1e6;   ///< E [Pa], > 0
	double poissonRatio      = 0.3;   ///< nu [-], in (-1, 0.5)
	double yieldStress       = 1e3;   ///< thawed tau_y [Pa], >= 0
	double yieldStressFrozen = 500e3; ///< tau_y at S_i = 1 [Pa], >= yieldStress; linear in between
	double viscosity         = 100.0; ///< mu [Pa s of motion], > 0

	std::string                  name() const override { return "BinghamSkeleton"; }
	std::optional<ShearStrength> shearStrength(double iceSaturation) const override { return ShearStrength { 0.0, yieldStressAt(iceSaturation) }; }
	void                         validate() const override;
	void                         declareFields(PointFields&, const std::string& prefix) override;
	void                         updateStress(const SkeletonBatch<D>&) override;
	void                         tangentModulus(const SkeletonBatch<D>&, double* modulus) const override;

private:
	double yieldStressAt(double iceSaturation) const { return yieldStress + (yieldStressFrozen - yieldStress) * iceSaturation; }
	/// Of points in sequence, from the trial stress.
	void flow(const SkeletonBatch<D>&, int first, int count);

	PointFields*        fields_ = nullptr;
	PointFields::Handle strain_ = -1;
};

} // namespace talik
