// SPDX-License-Identifier: GPL-2.0-or-later
#pragma once
#include <lib/multimethods/Indexable.hpp>
#include <lib/serialization/Serializable.hpp>
#include <mutex>

namespace yade {
/// Motion of a body.
class State : public Serializable, public Indexable {
public:
	Vector3r&    pos;
	Quaternionr& ori;
	std::mutex   updateMutex;
	Se3r         se3;
	Vector3r     vel;
	Real         mass;
	Vector3r     angVel;
	Vector3r     angMom;
	Vector3r     inertia;
	Vector3r     refPos;
	Quaternionr  refOri;
	unsigned     blockedDOFs;
	bool         isDamped;
	Real         densityScaling;
	enum { DOF_NONE = 0, DOF_X = 1, DOF_Y = 2, DOF_Z = 4, DOF_RX = 8, DOF_RY = 16, DOF_RZ = 32 };

	State();
	virtual ~State();
	TALIK_STOCK_OVERRIDES()
	TALIK_STOCK_INDEX_COUNTER()
};
} // namespace yade
