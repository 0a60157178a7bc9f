// SPDX-License-Identifier: GPL-2.0-or-later
#pragma once
#include <core/GlobalEngine.hpp>

namespace yade {
class TimeStepper : public GlobalEngine {
public:
	bool         active;
	unsigned int timeStepUpdateInterval;

	virtual ~TimeStepper();
	string                getBaseClassName(unsigned int = 0) const override;
	int                   getBaseClassNumber() const override;
	string                getClassName() const override;
	void                  pySetAttr(const std::string&, const ::boost::python::object&) override;
	::boost::python::dict pyDict() const override;
	void                  callPostLoad() override;
	void                  pyRegisterClass(::boost::python::object) override;
	bool                  isActivated() override;
	void                  action() override;
	virtual void          computeTimeStep(Scene*);

private:
	TimeStepper();
};
} // namespace yade
