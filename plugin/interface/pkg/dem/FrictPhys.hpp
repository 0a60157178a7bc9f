// SPDX-License-Identifier: GPL-2.0-or-later
#pragma once
#include <core/Dispatching.hpp>
#include <pkg/common/ElastMat.hpp>
#include <pkg/common/NormShearPhys.hpp>

namespace yade {
class FrictPhys : public NormShearPhys {
public:
	Real tangensOfFrictionAngle;

	FrictPhys();
	virtual ~FrictPhys();
	string                getBaseClassName(unsigned int = 0) const override;
	int                   getBaseClassNumber() const override;
	string                getClassName() const override;
	void                  pySetAttr(const std::string&, const ::boost::python::object&) override;
	::boost::python::dict pyDict() const override;
	void                  callPostLoad() override;
	void                  pyRegisterClass(::boost::python::object) override;
	TALIK_STOCK_INDEX()
};
} // namespace yade
TALIK_STOCK_BASE(FrictPhys)
