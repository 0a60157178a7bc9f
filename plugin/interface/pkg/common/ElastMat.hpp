// SPDX-License-Identifier: GPL-2.0-or-later
#pragma once
#include <core/Material.hpp>

namespace yade {
class ElastMat : public Material {
public:
	Real young;
	Real poisson;

	ElastMat();
	virtual ~ElastMat();
	TALIK_STOCK_OVERRIDES()
	TALIK_STOCK_INDEX()
};

class FrictMat : public ElastMat {
public:
	Real frictionAngle;

	FrictMat();
	virtual ~FrictMat();
	TALIK_STOCK_OVERRIDES()
	TALIK_STOCK_INDEX()
};
} // namespace yade
TALIK_STOCK_BASE(FrictMat)
