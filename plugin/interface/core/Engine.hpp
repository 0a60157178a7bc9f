// SPDX-License-Identifier: GPL-2.0-or-later
#pragma once
#include <core/Omega.hpp>
#include <core/Timing.hpp>
#include <lib/serialization/Serializable.hpp>

namespace yade {
class Scene;

class Engine : public Serializable {
public:
	Scene*                   scene;
	TimingInfo               timingInfo;
	shared_ptr<TimingDeltas> timingDeltas;
	bool                     dead;
	int                      ompThreads;
	string                   label;

	Engine();
	virtual ~Engine();
	TALIK_STOCK_OVERRIDES()
	virtual bool isActivated();
	virtual void action();
};
} // namespace yade
TALIK_STOCK_HELD(Engine)
