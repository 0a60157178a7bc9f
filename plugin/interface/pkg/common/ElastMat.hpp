// SPDX-License-Identifier: GPL-2.0-or-later
#pragma once
#include <core/Material.hpp>

namespace yade {
class ElastMat : public Material {
public:
	Real young;
	Real poisson;

	ElastMat();
	virtual ~ElastMat();
	string                getBaseClassName(unsigned int = 0) const override;
	int                   getBaseClassNumber() const override;
	string                getClassName() const override;
	void                  pySetAttr(const std::string&, const ::boost::python::object&) override;
	::boost::python::dict pyDict() const override;
	void                  callPostLoad() override;
	void                  pyRegisterClass(::boost::python::object) override;
	TALIK_STOCK_INDEX()
};

class FrictMat : public ElastMat {
public:
	Real frictionAngle;

	FrictMat();
	virtual ~FrictMat();
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
TALIK_STOCK_BASE(FrictMat)
