// SPDX-License-Identifier: GPL-2.0-or-later
#include <core/Scene.hpp>
#include <pkg/multiscale/settings/GroundEffect.hpp>

namespace yade {

GroundEffect::Pointer<2> GroundEffect::inPlane() const
{
	throw std::invalid_argument("MpmEngine.effects: " + getClassName() + " is no effect of its own; give one of the classes derived from it.");
}
GroundEffect::Pointer<3> GroundEffect::inSpace() const
{
	inPlane();
	return {};
}

YADE_PLUGIN((GroundEffect));

} // namespace yade
