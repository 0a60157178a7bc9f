// SPDX-License-Identifier: GPL-2.0-or-later
#pragma once
#include <core/IGeom.hpp>

namespace yade {
class GenericSpheresContact : public IGeom {
public:
	Vector3r normal;
	Vector3r contactPoint;
	Real     refR1, refR2;

	GenericSpheresContact();
	virtual ~GenericSpheresContact();
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
