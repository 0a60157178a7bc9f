// SPDX-License-Identifier: GPL-2.0-or-later
#pragma once
#include <core/IGeom.hpp>

namespace yade {
class GenericSpheresContact : public IGeom {
public:
	Vector3r normal;
	Vector3r contactPoint;
	Real     refR1, refR2;

	GenericSpheresContact();
	virtual ~GenericSpheresContact();
	TALIK_STOCK_OVERRIDES()
	TALIK_STOCK_INDEX()
};
} // namespace yade
