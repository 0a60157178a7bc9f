// SPDX-License-Identifier: GPL-2.0-or-later
#include <core/Scene.hpp>
#include <pkg/mpm/skeleton/BinghamSkeleton.hpp>
#include <pkg/multiscale/settings/SkeletonLaws.hpp>
#include <pkg/python/ScriptValues.hpp>

namespace yade {

class BinghamSkeleton : public LawInAnyDimension<BinghamSkeleton> {
public:
	TALIK_MODEL_FROM_LIST(BinghamSkeleton, TALIK_BINGHAM_SKELETON)
	// clang-format off
	YADE_CLASS_BASE_DOC_ATTRS(BinghamSkeleton,SkeletonLaw,"Skeleton of thawed ground that flows as mud: elastic while the shear stress (root of the second "
			"invariant of the deviator) is below a yield stress, beyond it a Bingham fluid, shear stress = yieldStress + viscosity times shear rate, in time of motion. "
			"Volume responds elastically, also in tension. Field flowStrain [-]: shear strain that has flowed. Example: "
			"BinghamSkeleton(yieldStress=800,viscosity=50).",
		TALIK_BINGHAM_SKELETON
	);
	// clang-format on
};
REGISTER_SERIALIZABLE(BinghamSkeleton);
YADE_PLUGIN((BinghamSkeleton));

} // namespace yade
