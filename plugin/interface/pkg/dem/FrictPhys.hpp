// SPDX-License-Identifier: GPL-2.0-or-later
#pragma once
#include <core/Dispatching.hpp>
#include <pkg/common/ElastMat.hpp>
#include <pkg/common/NormShearPhys.hpp>

namespace yade {
class FrictPhys : public NormShearPhys {
public:
	Real tangensOfFrictionAngle;
#ifdef TALIK_YADE_2026
	Real frictDissip;
#endif

	FrictPhys();
	virtual ~FrictPhys();
	TALIK_STOCK_OVERRIDES()
	TALIK_STOCK_INDEX()
};
} // namespace yade
TALIK_STOCK_BASE(FrictPhys)
