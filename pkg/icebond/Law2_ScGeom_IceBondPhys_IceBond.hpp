// SPDX-License-Identifier: GPL-2.0-or-later
#pragma once
#include <core/Dispatching.hpp>
#include <pkg/dem/ScGeom.hpp>
#include <pkg/icebond/IceBondMat.hpp>
#include <pkg/icebond/IceBondPhys.hpp>

namespace yade {

/// Ice-bond contact law, Yu & Zhao eqs (5)-(7) with tension and shear failure, melting and refreezing.
class Law2_ScGeom_IceBondPhys_IceBond : public LawFunctor {
public:
	virtual ~Law2_ScGeom_IceBondPhys_IceBond() {};
	bool go(shared_ptr<IGeom>&, shared_ptr<IPhys>&, Interaction*) override;
	void postLoad(Law2_ScGeom_IceBondPhys_IceBond&);

private:
	/// What one evaluation works on.
	struct Contact {
		const ScGeom&       geom;
		IceBondPhys&        phys;
		talik::IceBondModel model;
		talik::IceBond      bond;
		double              un;
		const Interaction&  interaction;
	};
	talik::ContactStiffness stiffness(const Contact&, double iceSaturation) const;
	talik::IceBondModel     weakerModel(const Interaction*, double& iceSaturation) const;
	void                    takeUpIceSaturation(Contact&, double iceSaturation);
	void                    meltBond(Contact&);
	void                    formOrMelt(Contact&, double iceSaturation);
	void                    respond(Contact&, const talik::ContactStiffness&);
	void                    applyForces(const Contact&, const Interaction*) const;
	void                    countBroken();
	bool                    stayOpen(Contact&) const;
	talik::StiffnessRule    rule = talik::StiffnessRule::parallel;

	// clang-format off
	YADE_CLASS_BASE_DOC_ATTRS(Law2_ScGeom_IceBondPhys_IceBond,LawFunctor,"Contact law of grains bonded by pore ice. Without ice: linear springs with Coulomb "
			"friction as Law2_ScGeom_FrictPhys_CundallStrack. With ice (Yu & Zhao eqs 5-7): an ice spring beside the grain spring, grown free of stress; an intact "
			"bond fails in tension at C_eta A_b or in shear at C_tau A_b + mu max(F_n,0), then friction remains; melting takes the share of the ice away, complete "
			"melting every bond; ice that rises again through IceBondMat.bondSaturation bonds anew. The limits are checked in every step, also when only the ice "
			"saturation changes. Example: "
			"InteractionLoop([Ig2_Sphere_Sphere_ScGeom()],[Ip2_IceBondMat_IceBondMat_IceBondPhys()],[Law2_ScGeom_IceBondPhys_IceBond(healBroken=True)]).",
		((string,stiffnessRule,"parallel",Attr::triggerPostLoad,"How forces follow the ice-dependent stiffness of existing contacts: parallel (ice spring beside "
				"the grain spring, default), forceContinuous (no force ever jumps), secant (F = k(S_i) u)."))
		((bool,cohesionDisablesFriction,false,,"An intact bond has no frictional part in its shear limit."))
		((bool,healBroken,false,,"Refreezing bonds broken contacts, too; otherwise they stay broken until melted."))
		((bool,sphericalBodies,true,,"All bodies are spheres: torques from radii (always so in periodic scenes); else from contact points."))
		((long,brokenBonds,0,,"Number of bonds broken mechanically so far (melted ones do not count)."))
	);
	// clang-format on
	FUNCTOR2D(ScGeom, IceBondPhys);
};
REGISTER_SERIALIZABLE(Law2_ScGeom_IceBondPhys_IceBond);

} // namespace yade
