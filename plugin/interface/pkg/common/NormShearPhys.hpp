// SPDX-License-Identifier: GPL-2.0-or-later
#pragma once
#include <core/IPhys.hpp>

namespace yade {
class NormPhys : public IPhys {
public:
	Real     kn;
	Vector3r normalForce;

	NormPhys();
	virtual ~NormPhys();
	TALIK_STOCK_OVERRIDES()
	TALIK_STOCK_INDEX()
};

class NormShearPhys : public NormPhys {
public:
	Real     ks;
	Vector3r shearForce;

	NormShearPhys();
	virtual ~NormShearPhys();
	TALIK_STOCK_OVERRIDES()
	TALIK_STOCK_INDEX()
};
} // namespace yade
