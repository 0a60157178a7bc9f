// SPDX-License-Identifier: GPL-2.0-or-later
#pragma once
#include <core/Engine.hpp>

namespace yade {
class GlobalEngine : public Engine {
public:
	GlobalEngine() {}
	virtual ~GlobalEngine();
	string                getBaseClassName(unsigned int = 0) const override;
	int                   getBaseClassNumber() const override;
	string                getClassName() const override;
	void                  pySetAttr(const std::string&, const ::boost::python::object&) override;
	::boost::python::dict pyDict() const override;
	void                  callPostLoad() override;
	void                  pyRegisterClass(::boost::python::object) override;
};
} // namespace yade
TALIK_STOCK_BASE(GlobalEngine)
