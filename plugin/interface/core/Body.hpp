// SPDX-License-Identifier: GPL-2.0-or-later
#pragma once
#include <core/Bound.hpp>
#include <core/Material.hpp>
#include <core/Shape.hpp>
#include <core/State.hpp>

namespace yade {
class Interaction;
class Scene;

class Body : public Serializable {
public:
	using id_t        = int;
	using MapId2IntrT = std::map<id_t, shared_ptr<Interaction>>;

	id_t                 id;
	mask_t               groupMask;
	int                  flags;
	int                  subdomain;
	shared_ptr<Material> material;
	shared_ptr<State>    state;
	shared_ptr<Shape>    shape;
	shared_ptr<Bound>    bound;
	MapId2IntrT          intrs;
	id_t                 clumpId;
	long                 iterBorn;
	Real                 timeBorn;

	Body();
	virtual ~Body();
	TALIK_STOCK_OVERRIDES()
	virtual void userForcedDisplacementRedrawHook();
};
} // namespace yade
