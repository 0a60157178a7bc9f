// SPDX-License-Identifier: GPL-2.0-or-later
#pragma once
#include <core/Shape.hpp>

namespace yade {
class Wall : public Shape {
public:
	int sense;
	int axis;

	virtual ~Wall();
	TALIK_STOCK_OVERRIDES()
	TALIK_STOCK_INDEX()

private:
	Wall();
};
} // namespace yade
