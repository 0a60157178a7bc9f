// SPDX-License-Identifier: GPL-2.0-or-later
#pragma once
#include <core/GlobalEngine.hpp>

namespace yade {
class TimeStepper : public GlobalEngine {
public:
	bool         active;
	unsigned int timeStepUpdateInterval;

	virtual ~TimeStepper();
	TALIK_STOCK_OVERRIDES()
	bool         isActivated() override;
	void         action() override;
	virtual void computeTimeStep(Scene*);

private:
	TimeStepper();
};
} // namespace yade
