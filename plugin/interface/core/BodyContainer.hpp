// SPDX-License-Identifier: GPL-2.0-or-later
#pragma once
#include <core/Body.hpp>
#include <mutex>

namespace yade {
class BodyContainer : public Serializable {
	using ContainerT = std::vector<shared_ptr<Body>>;
	ContainerT body;

public:
	bool               dirty;
	bool               checkedByCollider;
	vector<Body::id_t> insertedBodies, erasedBodies, realBodies;
	bool               useRedirection;
	bool               enableRedirection;
	vector<Body::id_t> subdomainBodies;
	std::mutex         drawloopmutex;

	virtual ~BodyContainer();
	TALIK_STOCK_OVERRIDES()

	Body::id_t              insert(shared_ptr<Body>);
	void                    clear();
	size_t                  size() const;
	shared_ptr<Body>&       operator[](unsigned id);
	const shared_ptr<Body>& operator[](unsigned id) const;

private:
	BodyContainer();
	friend class InteractionContainer;
	friend struct BodyContainerLayout;
};
} // namespace yade
