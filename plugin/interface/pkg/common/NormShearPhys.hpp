// SPDX-License-Identifier: GPL-2.0-or-later
#pragma once
#include <core/IPhys.hpp>

namespace yade {
class NormPhys : public IPhys {
public:
	Real     kn;
	Vector3r normalForce;

	NormPhys();
	virtual ~NormPhys();
	string                getBaseClassName(unsigned int = 0) const override;
	int                   getBaseClassNumber() const override;
	string                getClassName() const override;
	void                  pySetAttr(const std::string&, const ::boost::python::object&) override;
	::boost::python::dict pyDict() const override;
	void                  callPostLoad() override;
	void                  pyRegisterClass(::boost::python::object) override;
	TALIK_STOCK_INDEX()
};

class NormShearPhys : public NormPhys {
public:
	Real     ks;
	Vector3r shearForce;

	NormShearPhys();
	virtual ~NormShearPhys();
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
