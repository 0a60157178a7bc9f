// SPDX-License-Identifier: GPL-2.0-or-later
#pragma once
#include <lib/multimethods/Indexable.hpp>
#include <lib/serialization/Serializable.hpp>

namespace yade {

class IPhys : public Serializable, public Indexable {
public:
	IPhys() {}
	virtual ~IPhys();
	string                getBaseClassName(unsigned int = 0) const override;
	int                   getBaseClassNumber() const override;
	string                getClassName() const override;
	void                  pySetAttr(const std::string&, const ::boost::python::object&) override;
	::boost::python::dict pyDict() const override;
	void                  callPostLoad() override;
	void                  pyRegisterClass(::boost::python::object) override;

	TALIK_STOCK_INDEX_COUNTER()
};
} // namespace yade
