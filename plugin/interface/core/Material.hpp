// SPDX-License-Identifier: GPL-2.0-or-later
#pragma once
#include <core/State.hpp>
#include <lib/multimethods/Indexable.hpp>
#include <lib/serialization/Serializable.hpp>

namespace yade {
class Scene;

class Material : public Serializable, public Indexable {
public:
	int    id = -1;
	string label;
	Real   density = 1000;

	Material() {}
	virtual ~Material();
	TALIK_STOCK_OVERRIDES()
	virtual shared_ptr<State> newAssocState() const;
	virtual bool              stateTypeOk(State*) const;
	TALIK_STOCK_INDEX_COUNTER()
};
} // namespace yade
