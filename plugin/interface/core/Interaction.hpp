// SPDX-License-Identifier: GPL-2.0-or-later
#pragma once
#include <core/Body.hpp>
#include <core/IGeom.hpp>
#include <core/IPhys.hpp>

namespace yade {
class IGeomFunctor;
class IPhysFunctor;
class LawFunctor;

class Interaction : public Serializable {
public:
	bool isActive;
	struct {
		bool                     geomExists;
		shared_ptr<IGeomFunctor> geom;
		shared_ptr<IPhysFunctor> phys;
		shared_ptr<LawFunctor>   constLaw;
	} functorCache;
	Body::id_t        id1, id2;
	long              iterMadeReal;
	long              iterLastSeen;
	shared_ptr<IGeom> geom;
	shared_ptr<IPhys> phys;
	Vector3i          cellDist;
	int               linIx;
	long              iterBorn;

	Interaction();
	Interaction(Body::id_t, Body::id_t);
	virtual ~Interaction();
	string                getBaseClassName(unsigned int = 0) const override;
	int                   getBaseClassNumber() const override;
	string                getClassName() const override;
	void                  pySetAttr(const std::string&, const ::boost::python::object&) override;
	::boost::python::dict pyDict() const override;
	::boost::python::dict pyDictCustom() const override;
	void                  callPostLoad() override;
	void                  pyRegisterClass(::boost::python::object) override;

	bool              isReal() const;
	const Body::id_t& getId1() const { return id1; }
	const Body::id_t& getId2() const { return id2; }
};
} // namespace yade
