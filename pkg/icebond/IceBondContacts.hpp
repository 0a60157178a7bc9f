// SPDX-License-Identifier: GPL-2.0-or-later
#pragma once
#include <core/Dispatching.hpp>
#include <pkg/common/ElastMat.hpp>
#include <pkg/dem/FrictPhys.hpp>
#include <pkg/dem/ScGeom.hpp>
#include <pkg/icebond/BondMixture.hpp>
#include <pkg/icebond/IceBond.hpp>

namespace yade {
class IceBondPhys;

#define TALIK_BOND_ATTRIBUTE(name, initial, unit, range, mixing, help, note) \
	((Real, name, initial, Attr::triggerPostLoad, TALIK_BOND_HELP(unit, range, mixing, help, note)))

/// Frictional grain material whose contacts may carry ice, Yu & Zhao eqs (5)-(7).
class IceBondMat : public FrictMat {
public:
	/// The material as the formulas see it; whether broken bonds heal belongs to the law.
	talik::IceBondModel model() const;
	/// Takes the parameters of bonds, all but young.
	void takeBonds(const talik::IceBondModel&);
	/// The bonds between grains of this material and of a second one: mixed once for all their contacts, until a parameter of one of them changes.
	std::shared_ptr<const talik::BondMixture> mixedWith(const IceBondMat& second) const;
	/// Whether a mixture is that of both as they are now.
	bool agree(const talik::BondMixture& mixture, const IceBondMat& second) const
	{
		return mixture.isOf(numbered.number, young, second.numbered.number, second.young);
	}
	void postLoad(IceBondMat&);
	/// Without ice; of grains with linear springs nothing.
	talik::HertzMindlin elasticity() const { return elasticityWith(*this); }
	talik::HertzMindlin elasticityWith(const IceBondMat& second) const;
	/// A new contact with a grain of another material, without its parameters of force; r1, r2: radii [m], shearStiffness: k_s without ice [N/m], of
	/// Hertz's grains over 1.5 sqrt(u_n).
	virtual shared_ptr<IceBondPhys> newContact(const IceBondMat& other, Real r1, Real r2, Real shearStiffness) const;
	/// What a grain of this radius has grown in this step [m], 0 if it shrank.
	Real growth(Real radius) const { return radius * std::max(1 - radiusRatioBefore / radiusRatio, 0.); }

private:
	void                        numberBonds();
	talik::NumberedBonds        numbered { talik::IceBondModel(), talik::nextBondNumber() }; ///< the parameters as they are now
	mutable talik::BondMixtures mixtures;

public:
	// clang-format off
	YADE_CLASS_BASE_DOC_ATTRS_CTOR(IceBondMat,FrictMat,"Grain material with ice bonds: :yref:`young<ElastMat.young>` [Pa] and :yref:`poisson<ElastMat.poisson>` "
			"(ratio k_s/k_n) describe the contact without ice, the attributes below what ice adds (Yu & Zhao eqs 5-7: C = C0 + dC phi, E = E0 + dE phi, phi = "
			"1-(1-S_i^m)^m). Example: IceBondMat(young=0.6e9,poisson=0.8,frictionAngle=0.4636,density=2650,iceSaturation=1).",
		((Real,iceSaturation,0,Attr::triggerPostLoad,"Volumetric ice saturation of the pores around these grains, 0 to 1 [-]. A contact takes the smaller one of "
				"its two grains."))
		((bool,hertzMindlin,false,Attr::triggerPostLoad,"Grains press on each other as elastic spheres, as in Ip2_FrictMat_FrictMat_MindlinPhys: "
				":yref:`young<ElastMat.young>` and :yref:`poisson<ElastMat.poisson>` are Young's modulus and Poisson's ratio of the grains, F_n = 4/3 E* sqrt(R*) "
				"u_n^1.5 and k_s = 8 G* sqrt(R* u_n). The ice keeps its linear springs. Contacts with grains of a material without it have linear ones. False: "
				"linear springs."))
		TALIK_BOND_PARAMETERS(TALIK_BOND_ATTRIBUTE)
		((Real,radiusRatio,1,Attr::readonly,"Radius of these grains over the one that stiffness and bonds are counted with [-]; set by GrainSwelling."))
		((Real,radiusRatioBefore,1,Attr::hidden,"radiusRatio of the step before.")),
		createIndex();
	);
	// clang-format on
	REGISTER_CLASS_INDEX(IceBondMat, FrictMat);
};
REGISTER_SERIALIZABLE(IceBondMat);

class Scene;
class ScGeom;

/// State of one contact between ice-bearing grains. kn and ks hold the stiffness in force now, so that YADE's own time
/// steppers and stress functions see it.
class IceBondPhys : public FrictPhys {
public:
	/// The bond as the formulas see it, and back.
	talik::IceBond bond() const;
	void           setBond(const talik::IceBond&);
	/// The parameters of a contact of grains of two materials; they take what has changed in one of them.
	const talik::IceBondModel& bonds(const IceBondMat& first, const IceBondMat& second);
	talik::ContactStiffness    stiffness(double iceStiffnessRatio) const { return { grainStiffness, stiffnessRatio, iceStiffnessRatio, kno }; }
	/// Whether an intact bond carries moments.
	virtual bool carriesMoments() const { return false; }
	/// The moment of an intact bond follows the turning of a step; what it adds at the edge of the section.
	virtual talik::EdgeForces<double> bend(const ScGeom&, const Interaction&, const Scene&, const talik::ContactStiffness&) { return { 0, 0 }; }
	/// A share of the moment of the bond stays, 0 to 1.
	virtual void keepBondMoment(double) {}
	/// Moments on the grains beyond those of the forces: none here. Called in every step after the forces.
	virtual void addMoments(const ScGeom&, const Interaction&, Scene&) {}
	virtual void clearMoments() {}

private:
	std::shared_ptr<const talik::BondMixture> mixture; ///< of the two materials

public:
	// clang-format off
	YADE_CLASS_BASE_DOC_ATTRS_CTOR(IceBondPhys,FrictPhys,"Contact of two grains of :yref:`IceBondMat`: frictional, bonded by ice, or broken. Forces and overlaps "
			"are positive in compression. Example: [i.phys.bondState for i in O.interactions if i.isReal].",
		((int,bondState,0,,"0: frictional, 1: intact ice bond, 2: bond broken mechanically (frictional until melted)."))
		((Real,iceSaturation,0,,"Ice saturation that the contact has taken up [-]."))
		((Real,grainStiffness,0,,"Normal stiffness without ice [N/m]."))
		((Real,stiffnessRatio,0,,"Shear over normal stiffness [-]."))
		((Real,kno,0,,"4/3 E* sqrt(R*) of grains with hertzMindlin, as MindlinPhys.kno [N/m^1.5]; 0: linear springs."))
		((Real,bondArea,0,,"Area of the bond [m^2]."))
		((Real,gapLimit,0,,"Largest gap that is bonded [m]."))
		((Real,uGrain,0,,"Overlap at which the grain spring of an intact bond is free [m]."))
		((Real,uIce,0,,"Overlap at which the ice spring is free [m]."))
		((Real,uRef,0,,"Part of the geometric overlap that stems from swollen radii and carries no force [m], see GrainSwelling."))
		((Vector3r,iceShear,Vector3r::Zero(),,"Part of the shear force carried by ice [N]."))
		((bool,iceCut,false,,"The ice of a broken bond has opened and carries nothing."))
		((bool,bondNow,false,,"Form a stress-free bond at the next evaluation (set by Ip2_IceBondMat_IceBondMat_IceBondPhys.bondNewContacts).")),
		createIndex();
	);
	// clang-format on
	REGISTER_CLASS_INDEX(IceBondPhys, FrictPhys);
};
REGISTER_SERIALIZABLE(IceBondPhys);

/// Radii [m] by which the stiffness of a contact is counted; a flat body has none of its own and takes that of the sphere.
std::pair<Real, Real> stiffnessRadii(const GenericSpheresContact&, const IceBondMat& first, const IceBondMat& second);

/// Stiffness as stock YADE: k_n = 2 E1 R1 E2 R2/(E1 R1 + E2 R2), the smaller friction angle.
class Ip2_IceBondMat_IceBondMat_IceBondPhys : public IPhysFunctor {
public:
	void go(const shared_ptr<Material>&, const shared_ptr<Material>&, const shared_ptr<Interaction>&) override;
	// clang-format off
	YADE_CLASS_BASE_DOC_ATTRS(Ip2_IceBondMat_IceBondMat_IceBondPhys,IPhysFunctor,"Makes the :yref:`IceBondPhys` of a new contact: k_n = 2 E1 R1 E2 R2/(E1 R1 + "
			"E2 R2) without ice, k_s = poisson k_n, or Hertz's and Mindlin's of grains with IceBondMat.hertzMindlin, the "
			"smaller friction angle, bond area from the smaller radius. Contacts are born frictional; ice that rises "
			"through IceBondMat.bondSaturation bonds them. Example: "
			"InteractionLoop([Ig2_Sphere_Sphere_ScGeom()],[Ip2_IceBondMat_IceBondMat_IceBondPhys()],[Law2_ScGeom_IceBondPhys_IceBond()]).",
		((bool,bondNewContacts,false,,"Contacts that come into being are bonded at once, free of stress. To bond across gaps, let "
				"Ig2_Sphere_Sphere_ScGeom.interactionDetectionFactor and Bo1_Sphere_Aabb.aabbEnlargeFactor exceed 1 while this is set."))
	);
	// clang-format on
	FUNCTOR2D(IceBondMat, IceBondMat);
};
REGISTER_SERIALIZABLE(Ip2_IceBondMat_IceBondMat_IceBondPhys);

/// Ice-bond contact law, Yu & Zhao eqs (5)-(7) with tension and shear failure, melting and refreezing.
class Law2_ScGeom_IceBondPhys_IceBond : public LawFunctor {
public:
	bool go(shared_ptr<IGeom>&, shared_ptr<IPhys>&, Interaction*) override;

private:
	/// What one evaluation works on.
	struct Contact {
		const ScGeom&              geom;
		IceBondPhys&               phys;
		const talik::IceBondModel& model;
		talik::IceBond             bond;
		double                     un;
		const Interaction&         interaction;
	};
	talik::ContactStiffness stiffness(const Contact&, double iceSaturation) const;
	void                    takeUpIceSaturation(Contact&, double iceSaturation);
	void                    meltBond(Contact&);
	void                    formOrMelt(Contact&, double iceSaturation);
	void                    respond(Contact&, const talik::ContactStiffness&);
	void                    applyForces(const Contact&, const Interaction*) const;
	void                    countBroken();
	bool                    stayOpen(Contact&) const;

	// clang-format off
	YADE_CLASS_BASE_DOC_ATTRS(Law2_ScGeom_IceBondPhys_IceBond,LawFunctor,"Contact law of grains bonded by pore ice. Without ice: linear springs, or Hertz's and "
			"Mindlin's, with Coulomb friction as Law2_ScGeom_FrictPhys_CundallStrack. With ice (Yu & Zhao eqs 5-7): an ice "
			"spring beside the grain spring, grown free of stress; an intact bond fails in tension at C_eta A_b or in shear at C_tau A_b + mu max(F_n,0), "
			"then friction remains; melting takes the share of the ice away, complete melting every "
			"bond; ice that rises again through IceBondMat.bondSaturation bonds anew. The limits are checked in every step, also when only the ice "
			"saturation changes. Example: "
			"InteractionLoop([Ig2_Sphere_Sphere_ScGeom()],[Ip2_IceBondMat_IceBondMat_IceBondPhys()],[Law2_ScGeom_IceBondPhys_IceBond(healBroken=True)]).",
		((bool,healBroken,false,,"Refreezing bonds broken contacts, too; otherwise they stay broken until melted."))
		((bool,sphericalBodies,true,,"All bodies are spheres: torques from radii (always so in periodic scenes); else from contact points."))
		((long,brokenBonds,0,,"Number of bonds broken mechanically so far (melted ones do not count)."))
	);
	// clang-format on
	FUNCTOR2D(ScGeom, IceBondPhys);
};
REGISTER_SERIALIZABLE(Law2_ScGeom_IceBondPhys_IceBond);

} // namespace yade
