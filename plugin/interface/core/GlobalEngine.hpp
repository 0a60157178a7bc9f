// SPDX-License-Identifier: GPL-2.0-or-later
#pragma once
#include <core/Engine.hpp>

namespace yade {
class GlobalEngine : public Engine {
public:
	GlobalEngine() {}
	virtual ~GlobalEngine();
	TALIK_STOCK_OVERRIDES()
};
} // namespace yade
TALIK_STOCK_BASE(GlobalEngine)
