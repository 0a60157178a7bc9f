// SPDX-License-Identifier: GPL-2.0-or-later
#pragma once
#include <lib/multimethods/Indexable.hpp>
#include <lib/serialization/Serializable.hpp>

namespace yade {

class IGeom : public Serializable, public Indexable {
public:
	IGeom() {}
	virtual ~IGeom();
	TALIK_STOCK_OVERRIDES()

	TALIK_STOCK_INDEX_COUNTER()
};
} // namespace yade
