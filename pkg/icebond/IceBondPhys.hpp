// SPDX-License-Identifier: GPL-2.0-or-later
#pragma once
#include <core/Dispatching.hpp>
#include <pkg/dem/FrictPhys.hpp>
#include <pkg/icebond/BondSection.hpp>
#include <pkg/icebond/IceBond.hpp>
#include <pkg/icebond/IceBondMat.hpp>

namespace yade {
class Scene;
class ScGeom;

/// State of one contact between ice-bearing grains. kn and ks hold the stiffness in force now, so that YADE's own time
/// steppers and stress functions see it.
class IceBondPhys : public FrictPhys {
public:
	virtual ~IceBondPhys() {};
	/// The bond as the formulas see it, and back.
	talik::IceBond bond() const;
	void           setBond(const talik::IceBond&);
	/// Whether an intact bond carries moments.
	virtual bool carriesMoments() const { return false; }
	/// The moment of an intact bond follows the turning of a step; what it adds at the edge of the section.
	virtual talik::EdgeForces<double> bend(const ScGeom&, const Interaction&, const Scene&, const talik::ContactStiffness&) { return { 0, 0 }; }
	/// A share of the moment of the bond stays, 0 to 1.
	virtual void keepBondMoment(double) {}
	/// Moments on the grains beyond those of the forces: none here. Called in every step after the forces.
	virtual void addMoments(const ScGeom&, const Interaction&, Scene&) {}
	virtual void clearMoments() {}
	// clang-format off
	YADE_CLASS_BASE_DOC_ATTRS_CTOR(IceBondPhys,FrictPhys,"Contact of two grains of :yref:`IceBondMat`: frictional, bonded by ice, or broken. Forces and overlaps "
			"are positive in compression. Example: [i.phys.bondState for i in O.interactions if i.isReal].",
		((int,bondState,0,,"0: frictional, 1: intact ice bond, 2: bond broken mechanically (frictional until melted)."))
		((Real,iceSaturation,0,,"Ice saturation that the contact has taken up [-]."))
		((Real,grainStiffness,0,,"Normal stiffness without ice [N/m]."))
		((Real,stiffnessRatio,0,,"Shear over normal stiffness [-]."))
		((Real,bondArea,0,,"Area of the bond [m^2]."))
		((Real,gapLimit,0,,"Largest gap that is bonded [m]."))
		((Real,uGrain,0,,"Overlap at which the grain spring of an intact bond is free [m]."))
		((Real,uIce,0,,"Overlap at which the ice spring is free [m]; reference of the single spring for the rules forceContinuous and secant."))
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

/// Stiffness as stock YADE: k_n = 2 E1 R1 E2 R2/(E1 R1 + E2 R2), the smaller friction angle.
class Ip2_IceBondMat_IceBondMat_IceBondPhys : public IPhysFunctor {
public:
	virtual ~Ip2_IceBondMat_IceBondMat_IceBondPhys() {};
	void go(const shared_ptr<Material>&, const shared_ptr<Material>&, const shared_ptr<Interaction>&) override;
	// clang-format off
	YADE_CLASS_BASE_DOC_ATTRS(Ip2_IceBondMat_IceBondMat_IceBondPhys,IPhysFunctor,"Makes the :yref:`IceBondPhys` of a new contact: k_n = 2 E1 R1 E2 R2/(E1 R1 + "
			"E2 R2) without ice, k_s = poisson k_n, the smaller friction angle, bond area from the smaller radius. Contacts are born frictional; ice that rises "
			"through IceBondMat.bondSaturation bonds them. Example: "
			"InteractionLoop([Ig2_Sphere_Sphere_ScGeom()],[Ip2_IceBondMat_IceBondMat_IceBondPhys()],[Law2_ScGeom_IceBondPhys_IceBond()]).",
		((bool,bondNewContacts,false,,"Contacts that come into being are bonded at once, free of stress. To bond across gaps, let "
				"Ig2_Sphere_Sphere_ScGeom.interactionDetectionFactor and Bo1_Sphere_Aabb.aabbEnlargeFactor exceed 1 while this is set."))
	);
	// clang-format on
	FUNCTOR2D(IceBondMat, IceBondMat);
};
REGISTER_SERIALIZABLE(Ip2_IceBondMat_IceBondMat_IceBondPhys);

} // namespace yade
