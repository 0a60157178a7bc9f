// SPDX-License-Identifier: GPL-2.0-or-later
#pragma once
#include <core/Interaction.hpp>
#include <core/State.hpp>
#include <pkg/dem/DemXDofGeom.hpp>

namespace yade {
/// Contact of two spheres, with the shear increment of the step.
class ScGeom : public GenericSpheresContact {
public:
	Vector3r twist_axis;
	Vector3r orthonormal_axis;
	Real &   radius1, &radius2;
	Real     penetrationDepth;
	Vector3r shearInc;

	ScGeom();
	virtual ~ScGeom();
	TALIK_STOCK_OVERRIDES()
	Vector3r&       rotate(Vector3r& tangentVector) const;
	const Vector3r& shearIncrement() const { return shearInc; }
	TALIK_STOCK_INDEX()
};
} // namespace yade
