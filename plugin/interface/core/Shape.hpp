// SPDX-License-Identifier: GPL-2.0-or-later
#pragma once
#include <lib/multimethods/Indexable.hpp>
#include <lib/serialization/Serializable.hpp>

namespace yade {
class BoundFunctor;
class InternalForceFunctor;

class Shape : public Serializable, public Indexable {
public:
	shared_ptr<BoundFunctor>         boundFunctor;
	shared_ptr<InternalForceFunctor> internalforcefunctor;
	Vector3r                         color;
	bool                             wire      = false;
	bool                             highlight = false;

	Shape() {}
	virtual ~Shape();
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
