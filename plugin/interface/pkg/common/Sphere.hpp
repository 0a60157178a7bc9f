// SPDX-License-Identifier: GPL-2.0-or-later
#pragma once
#include <core/Shape.hpp>

namespace yade {
class Sphere : public Shape {
public:
	Real radius;

	Sphere();
	virtual ~Sphere();
	TALIK_STOCK_OVERRIDES()
	TALIK_STOCK_INDEX()
};
} // namespace yade
