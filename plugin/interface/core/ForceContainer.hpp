// SPDX-License-Identifier: GPL-2.0-or-later
#pragma once
#include <core/Body.hpp>
#include <mutex>

namespace yade {
class ForceContainer {
	using vvector = vector<Vector3r>;
	vector<vvector> _forceData, _torqueData;
	vector<int>     _maxId;
	vector<size_t>  sizeOfThreads;
	vvector         _force, _torque, _permForce, _permTorque;
	size_t          size;
	bool            syncedSizes;
	int             nThreads;
	bool            permForceUsed, permForceSynced;
	std::mutex      globalMutex;
	const Vector3r  _zero;

public:
	bool   synced;
	size_t syncCount;
	long   lastReset;

	ForceContainer();
	~ForceContainer();
	void sync();
	void addForce(Body::id_t, const Vector3r&);
	void addTorque(Body::id_t, const Vector3r&);
	int  getNumAllocatedThreads() const;

private:
	friend struct ForceContainerLayout;
};
} // namespace yade
