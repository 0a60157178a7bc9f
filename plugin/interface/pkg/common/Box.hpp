// SPDX-License-Identifier: GPL-2.0-or-later
#pragma once
#include <core/Shape.hpp>

namespace yade {
class Box : public Shape {
public:
	Vector3r extents;

	virtual ~Box();
	TALIK_STOCK_OVERRIDES()
	TALIK_STOCK_INDEX()

private:
	Box();
};
} // namespace yade
