// SPDX-License-Identifier: GPL-2.0-or-later
#pragma once
#include <core/Shape.hpp>

namespace yade {
class Facet : public Shape {
public:
	Vector3r         ne[3];
	Real             icr;
	Real             vl[3];
	Vector3r         vu[3];
	vector<Vector3r> vertices;
	Vector3r         normal;
	Real             area;

	virtual ~Facet();
	TALIK_STOCK_OVERRIDES()
	TALIK_STOCK_INDEX()

private:
	Facet();
};
} // namespace yade
