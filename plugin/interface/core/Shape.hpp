// SPDX-License-Identifier: GPL-2.0-or-later
#pragma once
#include <lib/multimethods/Indexable.hpp>
#include <lib/serialization/Serializable.hpp>

namespace yade {
class BoundFunctor;
class InternalForceFunctor;

class Shape : public Serializable, public Indexable {
public:
	shared_ptr<BoundFunctor>         boundFunctor;
	shared_ptr<InternalForceFunctor> internalforcefunctor;
	Vector3r                         color;
	bool                             wire      = false;
	bool                             highlight = false;

	Shape() {}
	virtual ~Shape();
	TALIK_STOCK_OVERRIDES()

	TALIK_STOCK_INDEX_COUNTER()
};
} // namespace yade
