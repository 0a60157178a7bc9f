// SPDX-License-Identifier: GPL-2.0-or-later
#include <core/Scene.hpp>
#include <pkg/mpm/effects/BulkViscosity.hpp>
#include <pkg/multiscale/settings/GroundEffect.hpp>

namespace yade {

class BulkViscosity : public EffectInAnyDimension<BulkViscosity> {
public:
	template <int D> Pointer<D> make() const
	{
		auto effect       = std::make_shared<talik::BulkViscosity<D>>();
		effect->viscosity = viscosity;
		return effect;
	}
	// clang-format off
	YADE_CLASS_BASE_DOC_ATTRS(BulkViscosity,GroundEffect,"A mean stress in proportion to the rate of volume change damps pressure waves, the shorter "
			"ones faster, and leaves shear alone. A wave of frequency omega [rad/s] decays as exp(-viscosity omega^2 t/(2 M)) with the oedometer "
			"modulus M. Dissipation is in dampingDissipation of MpmEngine.balance. Field viscousStress [Pa]. Example: mpm.effects=[BulkViscosity(viscosity=1e4)].",
		((Real,viscosity,0,,"Bulk viscosity eta [Pa s], >= 0, in time of motion. 0.06 rho c h, with density, wave speed and grid spacing, is common for shocks. "
				"Limits the time step to rho h^2/(6 D eta)."))
	);
	// clang-format on
};
REGISTER_SERIALIZABLE(BulkViscosity);
YADE_PLUGIN((BulkViscosity));

} // namespace yade
