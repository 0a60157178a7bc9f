// SPDX-License-Identifier: GPL-2.0-or-later
#include <core/Scene.hpp>
#include <pkg/mpm/effects/BulkViscosity.hpp>
#include <pkg/multiscale/settings/GroundEffect.hpp>

namespace yade {

class BulkViscosity : public EffectInAnyDimension<BulkViscosity> {
public:
	template <int D> Pointer<D> make() const
	{
		auto effect = std::make_shared<talik::BulkViscosity<D>>();
		TALIK_TAKE(*effect, *this, TALIK_BULK_VISCOSITY)
		return effect;
	}
	// clang-format off
	YADE_CLASS_BASE_DOC_ATTRS(BulkViscosity,GroundEffect,"A mean stress in proportion to the rate of volume change damps pressure waves, the shorter "
			"ones faster, and leaves shear alone. A wave of frequency omega [rad/s] decays as exp(-viscosity omega^2 t/(2 M)) with the oedometer "
			"modulus M. Dissipation is in dampingDissipation of MpmEngine.balance. Field viscousStress [Pa]. Example: mpm.effects=[BulkViscosity(viscosity=1e4)].",
		TALIK_BULK_VISCOSITY
	);
	// clang-format on
};
REGISTER_SERIALIZABLE(BulkViscosity);
YADE_PLUGIN((BulkViscosity));

} // namespace yade
