// SPDX-License-Identifier: GPL-2.0-or-later
#pragma once
#include <lib/multimethods/Indexable.hpp>
#include <lib/serialization/Serializable.hpp>

namespace yade {

class Bound : public Serializable, public Indexable {
public:
	int      lastUpdateIter = 0;
	Vector3r refPos;
	Real     sweepLength = 0;
	Vector3r color;
	Vector3r min;
	Vector3r max;

	Bound() {}
	virtual ~Bound();
	TALIK_STOCK_OVERRIDES()

	TALIK_STOCK_INDEX_COUNTER()
};
} // namespace yade
