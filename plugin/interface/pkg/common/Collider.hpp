// SPDX-License-Identifier: GPL-2.0-or-later
#pragma once
#include <core/Body.hpp>
#include <core/GlobalEngine.hpp>

namespace yade {
class BoundDispatcher;

class Collider : public GlobalEngine {
public:
	shared_ptr<BoundDispatcher> boundDispatcher;
	int                         avoidSelfInteractionMask;

	virtual ~Collider();
	TALIK_STOCK_OVERRIDES()
	void                            pyHandleCustomCtorArgs(::boost::python::tuple&, ::boost::python::dict&) override;
	virtual std::vector<Body::id_t> probeBoundingVolume(const Bound&);
	/// Everything known of bounds and pairs is forgotten and found anew in the next run.
	virtual void invalidatePersistentData();

private:
	Collider();
};
} // namespace yade
