// SPDX-License-Identifier: GPL-2.0-or-later
#pragma once
#include <core/Dispatching.hpp>
#include <pkg/common/ElastMat.hpp>
#include <pkg/common/NormShearPhys.hpp>

namespace yade {
class FrictPhys : public NormShearPhys {
public:
	Real tangensOfFrictionAngle;

	FrictPhys();
	virtual ~FrictPhys();
	TALIK_STOCK_OVERRIDES()
	TALIK_STOCK_INDEX()
};
} // namespace yade
TALIK_STOCK_BASE(FrictPhys)
