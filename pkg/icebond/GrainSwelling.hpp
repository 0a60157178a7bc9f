// SPDX-License-Identifier: GPL-2.0-or-later
#pragma once
#include <core/GlobalEngine.hpp>
#include <core/Scene.hpp>

namespace yade {
class IceBondMat;
class IceBondPhys;

/// Grain radius with pore ice, Yu & Zhao eq. (8), and what it does to the contacts. Goes before the collider.
class GrainSwelling : public GlobalEngine {
public:
	void action() override;
	/// What every formula divides by or takes a root of is checked; throws std::invalid_argument.
	void postLoad(GrainSwelling&);

	/// eq. (8): r_eq/r_0 at an ice saturation in 0..1 [-].
	Real equivalentRatio(Real iceSaturation) const;
	/// Area (dimension 3: volume) strain released by complete thaw if all of eq. (8) acts [-].
	Real fullThawStrain() const;

private:
	enum class Rule { bookkeeping, referenceOverlap, mechanical };
	Rule         rule() const;
	Real         radiusRatio(Real iceSaturation) const;
	void         registerBodies();
	bool         followIce();
	void         moveReferences() const;
	void         report();
	vector<Real> radiusBefore; ///< by id, of the present step

public:
	// clang-format off
	YADE_CLASS_BASE_DOC_ATTRS_CTOR_PY(GrainSwelling,GlobalEngine,"Equivalent grain radius with pore ice, Yu & Zhao eq. (8): r_eq = r_0 "
			"[(1-n0+(n0+volumetricStrain) S_i)/(1-n0)]^(1/dimension), for spheres of :yref:`IceBondMat`. Put it before the collider. Mass, inertia, stiffness and bond "
			"area keep r_0 under every rule. Example: "
			"O.engines=[ForceResetter(),GrainSwelling(porosity=0.18,radiusRule='mechanical',thawStrain=0.03),"
			"InsertionSortCollider([Bo1_Sphere_Aabb()]),NewtonIntegrator()].",
		((string,radiusRule,"bookkeeping",Attr::triggerPostLoad,"bookkeeping: grains keep r_0, equivalentRadius is only reported (default). referenceOverlap: "
				"grains take r_eq; what they grow is subtracted from the overlap of their contacts, so no force appears, and at S_i = 0 they are back at r_0. mechanical: "
				"ice-rich ground; the grains were prepared frozen with the radii that they have in the first step; thaw shrinks them and contacts open, growth on "
				"refreezing is subtracted from the overlap."))
		((Real,porosity,0.18,Attr::triggerPostLoad,"n0, porosity of the sample of grains [-], above 0 and below 1."))
		((Real,volumetricStrain,0,Attr::triggerPostLoad,"Volumetric strain of the sample, extension positive [-], > -porosity."))
		((int,dimension,2,Attr::triggerPostLoad,"2: discs, 3: spheres."))
		((Real,thawStrain,0,Attr::triggerPostLoad,"Rule mechanical: area strain (dimension 3: volume strain) that the grains release on complete thaw [-], from 0 "
				"to fullThawStrain."))
		((vector<Real>,preparedRadius,,Attr::readonly,"Radius of every body by id when it was first met [m]: r_0, or with the rule mechanical the radius prepared "
				"frozen; 0: no sphere of IceBondMat."))
		((vector<Real>,equivalentRadius,,Attr::readonly,"r_eq of every body by id [m] at its present ice saturation; 0: no sphere of IceBondMat."))
		((Real,thawStrainReached,0,Attr::readonly,"Area (volume) of the grains lost by thaw over that prepared [-]."))
		,/*ctor*/ ,
		/*py*/
		.def("equivalentRatio",&GrainSwelling::equivalentRatio,(::boost::python::arg("iceSaturation")),"r_eq/r_0 of eq. (8) at an ice saturation [-].")
		.add_property("fullThawStrain",&GrainSwelling::fullThawStrain,"Area (dimension 3: volume) strain on complete thaw if all of eq. (8) acts, "
				"(n0+volumetricStrain)/(1+volumetricStrain) [-].")
	);
	// clang-format on
};
REGISTER_SERIALIZABLE(GrainSwelling);

} // namespace yade
