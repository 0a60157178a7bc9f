// SPDX-License-Identifier: GPL-2.0-or-later
#pragma once
/// Functor families that laws and contact models plug into.
#include <core/Functor.hpp>
#include <core/Interaction.hpp>
#include <core/Scene.hpp>

namespace yade {
#define TALIK_STOCK_FUNCTOR(Class)                                                                    \
	Class() {}                                                                                    \
	virtual ~Class();                                                                             \
	string                getBaseClassName(unsigned int = 0) const override;                      \
	int                   getBaseClassNumber() const override;                                    \
	string                getClassName() const override;                                          \
	void                  pySetAttr(const std::string&, const ::boost::python::object&) override; \
	::boost::python::dict pyDict() const override;                                                \
	void                  callPostLoad() override;                                                \
	void                  pyRegisterClass(::boost::python::object) override;

class IPhysFunctor
        : public Functor2D<
                  Material, Material, void, boost::mpl::vector<const shared_ptr<Material>&, const shared_ptr<Material>&, const shared_ptr<Interaction>&>> {
public:
	TALIK_STOCK_FUNCTOR(IPhysFunctor)
};

class LawFunctor : public Functor2D<IGeom, IPhys, bool, boost::mpl::vector<shared_ptr<IGeom>&, shared_ptr<IPhys>&, Interaction*>> {
public:
	TALIK_STOCK_FUNCTOR(LawFunctor)
};
} // namespace yade
TALIK_STOCK_BASE(IPhysFunctor)
TALIK_STOCK_BASE(LawFunctor)
