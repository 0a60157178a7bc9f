// SPDX-License-Identifier: GPL-2.0-or-later
#pragma once

#include <pkg/base/Errors.hpp>
#include <pkg/base/ParameterList.hpp>
#include <pkg/mpm/points/ObjectiveUpdate.hpp>
#include <pkg/mpm/skeleton/ElasticSkeleton.hpp>
#include <pkg/mpm/skeleton/ShearStress.hpp>
#include <pkg/mpm/skeleton/SkeletonModel.hpp>

#include <cmath>

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
	void                         validate() const override
	{
		requireSetting(std::isfinite(young) && young > 0.0, "BinghamSkeleton.young", young, "must be positive, in Pa");
		requireSetting(poisson > -1.0 && poisson < 0.5, "BinghamSkeleton.poisson", poisson, "must lie in (-1, 0.5)");
		requireSetting(
		        std::isfinite(yieldStress) && yieldStress >= 0.0, "BinghamSkeleton.yieldStress", yieldStress, "must be finite and not negative, in Pa");
		requireSetting(
		        std::isfinite(yieldStressFrozen) && yieldStressFrozen >= yieldStress, "BinghamSkeleton.yieldStressFrozen", yieldStressFrozen,
		        "must be finite and at least yieldStress, in Pa");
		requireSetting(std::isfinite(viscosity) && viscosity > 0.0, "BinghamSkeleton.viscosity", viscosity, "must be positive, in Pa s");
	}
	void declareFields(PointFields& fields, const std::string& prefix) override { fields.declare(prefix + "flowStrain", "BinghamSkeleton", "-", strain_); }
	void updateStress(const SkeletonBatch<D>& b) override
	{
		updateElasticBatch<D>(b, LameModuli(young, poisson), [&](int first, int count) { flow(b, first, count); });
	}
	void tangentModulus(const SkeletonBatch<D>& b, double* modulus) const override { b.fill(modulus, LameModuli(young, poisson).oedometer()); }

private:
	double yieldStressAt(double iceSaturation) const { return yieldStress + (yieldStressFrozen - yieldStress) * iceSaturation; }
	/// Of points in sequence, from the trial stress.
	/// Eq. (27.2).
	void flow(const SkeletonBatch<D>& b, int first, int count)
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

	double* strain_ = nullptr; ///< of flow; null without a ground
};

} // namespace talik
