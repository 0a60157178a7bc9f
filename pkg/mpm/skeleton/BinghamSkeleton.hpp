// SPDX-License-Identifier: GPL-2.0-or-later
#pragma once

#include <pkg/base/ParameterList.hpp>
#include <pkg/mpm/points/ObjectiveUpdate.hpp>
#include <pkg/mpm/skeleton/SkeletonModel.hpp>

/// Parameters of BinghamSkeleton, for the model and for the class that a script sees.
// clang-format off
#define TALIK_BINGHAM_SKELETON \
	((Real, young, 1e6,,"Young's modulus E [Pa], > 0. Sets the time step; steady flow does not depend on it while stress is much smaller.")) \
	((Real, poisson, 0.3,,"Poisson's ratio [-], in (-1, 0.5).")) \
	((Real, yieldStress, 1e3,,"Thawed yield stress in simple shear [Pa], >= 0: some 10 to 2000 of mud and debris flows.")) \
	((Real, yieldStressFrozen, 500e3,,"Yield stress at full ice saturation [Pa], >= yieldStress; linear in between.")) \
	((Real, viscosity, 100,,"Bingham viscosity [Pa s], > 0: some 1 to 1000 of mud and debris flows."))
// clang-format on

namespace talik {

/// Ground that flows like a Bingham fluid, eq. (27.1): elastic up to a yield stress, which ice raises, and a shear stress that grows with the rate
/// of flow beyond it. Volume responds elastically, also in tension. Trial stress by the Jaumann rate, then eq. (27.2): implicit, so that steady flow
/// has the stress of a Bingham fluid whatever the length of a step.
template <int D> class BinghamSkeleton final : public SkeletonModel<D> {
public:
	TALIK_PARAMETERS(TALIK_BINGHAM_SKELETON)

	std::string                  name() const override { return "BinghamSkeleton"; }
	std::optional<ShearStrength> shearStrength(double iceSaturation) const override { return ShearStrength { 0.0, yieldStressAt(iceSaturation) }; }
	bool                         knowsHoopStrain() const override { return true; }
	void                         validate() const override;
	void                         declareFields(PointFields&, const std::string& prefix) override;
	void                         updateStress(const SkeletonBatch<D>&) override;
	void tangentModulus(const SkeletonBatch<D>& b, double* modulus) const override { b.fill(modulus, LameModuli(young, poisson).oedometer()); }

private:
	double yieldStressAt(double iceSaturation) const { return yieldStress + (yieldStressFrozen - yieldStress) * iceSaturation; }
	/// Of points in sequence, from the trial stress.
	void flow(const SkeletonBatch<D>&, int first, int count);

	double* strain_ = nullptr; ///< of flow; null without a ground
};

} // namespace talik
