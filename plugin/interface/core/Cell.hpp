// SPDX-License-Identifier: GPL-2.0-or-later
#pragma once
#include <lib/serialization/Serializable.hpp>

namespace yade {
/// Periodic cell; its base vectors are the columns of hSize.
class Cell : public Serializable {
	Matrix3r _invTrsf, _trsfInc, _vGradTimesPrevH;
	Vector3r _size, _cos, _refSize;
	bool     _hasShear;
	Matrix3r _shearTrsf, _unshearTrsf;
	double   _glShearTrsfMatrix[16];

public:
	Matrix3r trsf, refHSize, hSize, prevHSize, velGrad, nextVelGrad, prevVelGrad;
	int      homoDeform;
	bool     velGradChanged;
	bool     flipFlippable;

	Cell();
	virtual ~Cell();
	TALIK_STOCK_OVERRIDES()

	void integrateAndUpdate(Real dt);

private:
	friend struct CellLayout;
};
} // namespace yade
