// SPDX-License-Identifier: GPL-2.0-or-later
#pragma once
#include <core/Shape.hpp>

namespace yade {
class Facet : public Shape {
public:
	Vector3r         ne[3];
	Real             icr;
	Real             vl[3];
	Vector3r         vu[3];
	vector<Vector3r> vertices;
	Vector3r         normal;
	Real             area;

	virtual ~Facet();
	string                getBaseClassName(unsigned int = 0) const override;
	int                   getBaseClassNumber() const override;
	string                getClassName() const override;
	void                  pySetAttr(const std::string&, const ::boost::python::object&) override;
	::boost::python::dict pyDict() const override;
	void                  callPostLoad() override;
	void                  pyRegisterClass(::boost::python::object) override;
	TALIK_STOCK_INDEX()

private:
	Facet();
};
} // namespace yade
