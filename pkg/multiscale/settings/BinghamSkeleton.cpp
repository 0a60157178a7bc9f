// SPDX-License-Identifier: GPL-2.0-or-later
#include <core/Scene.hpp>
#include <pkg/mpm/skeleton/BinghamSkeleton.hpp>
#include <pkg/multiscale/settings/SkeletonLaws.hpp>
#include <pkg/python/ScriptValues.hpp>

namespace yade {

class BinghamSkeleton : public LawInAnyDimension<BinghamSkeleton> {
public:
	template <int D> Model<D> model() const
	{
		auto model          = std::make_shared<talik::BinghamSkeleton<D>>();
		model->youngModulus = young;
		model->poissonRatio = poisson;
		TALIK_TAKE_ATTRIBUTES(*model, *this, (yieldStress)(yieldStressFrozen)(viscosity))
		model->validate();
		return model;
	}
	// clang-format off
	YADE_CLASS_BASE_DOC_ATTRS(BinghamSkeleton,SkeletonLaw,"Skeleton of thawed ground that flows as mud: elastic while the shear stress (root of the second "
			"invariant of the deviator) is below a yield stress, beyond it a Bingham fluid, shear stress = yieldStress + viscosity times shear rate, in time of motion. "
			"Volume responds elastically, also in tension. Field flowStrain [-]: shear strain that has flowed. Example: "
			"BinghamSkeleton(yieldStress=800,viscosity=50).",
		((Real,young,1e6,,"Young's modulus E [Pa], > 0. Sets the time step; steady flow does not depend on it while stress is much smaller."))
		((Real,poisson,0.3,,"Poisson's ratio [-], in (-1, 0.5)."))
		((Real,yieldStress,1e3,,"Thawed yield stress in simple shear [Pa], >= 0: some 10 to 2000 of mud and debris flows."))
		((Real,yieldStressFrozen,500e3,,"Yield stress at full ice saturation [Pa], >= yieldStress; linear in between."))
		((Real,viscosity,100,,"Bingham viscosity [Pa s], > 0: some 1 to 1000 of mud and debris flows."))
	);
	// clang-format on
};
REGISTER_SERIALIZABLE(BinghamSkeleton);
YADE_PLUGIN((BinghamSkeleton));

} // namespace yade
