// SPDX-License-Identifier: GPL-2.0-or-later
#pragma once
#include <pkg/common/ElastMat.hpp>
#include <pkg/icebond/IceBondModel.hpp>

namespace yade {
class IceBondPhys;

/// Frictional grain material whose contacts may carry ice, Yu & Zhao eqs (5)-(7).
class IceBondMat : public FrictMat {
public:
	virtual ~IceBondMat() {};
	/// The material as the formulas see it; the stiffness rule belongs to the law.
	talik::IceBondModel model() const;
	void                postLoad(IceBondMat&);
	/// A new contact with a grain of another material, without its parameters of force; r1, r2: radii [m], shearStiffness: k_s without ice [N/m].
	virtual shared_ptr<IceBondPhys> newContact(const IceBondMat& other, Real r1, Real r2, Real shearStiffness) const;
	/// What a grain of this radius has grown in this step [m], 0 if it shrank.
	Real growth(Real radius) const { return radius * std::max(1 - radiusRatioBefore / radiusRatio, 0.); }
	// clang-format off
	YADE_CLASS_BASE_DOC_ATTRS_CTOR(IceBondMat,FrictMat,"Grain material with ice bonds: :yref:`young<ElastMat.young>` [Pa] and :yref:`poisson<ElastMat.poisson>` "
			"(ratio k_s/k_n) describe the contact without ice, the attributes below what ice adds (Yu & Zhao eqs 5-7: C = C0 + dC phi, E = E0 + dE phi, phi = "
			"1-(1-S_i^m)^m). Example: IceBondMat(young=0.6e9,poisson=0.8,frictionAngle=0.4636,density=2650,iceSaturation=1).",
		((Real,iceSaturation,0,Attr::triggerPostLoad,"Volumetric ice saturation of the pores around these grains, 0 to 1 [-]. A contact takes the smaller one of "
				"its two grains."))
		((Real,iceYoung,3e9,Attr::triggerPostLoad,"Contact modulus added at full ice saturation [Pa], >= 0."))
		((Real,tensileStrength,1e6,Attr::triggerPostLoad,"Tensile strength of a bond at vanishing ice saturation [Pa], >= 0; dropped once melted, see "
				"thawedStrength."))
		((Real,iceTensileStrength,50e6,Attr::triggerPostLoad,"Tensile strength added at full ice saturation [Pa], >= 0."))
		((Real,shearStrength,1e6,Attr::triggerPostLoad,"Cohesive shear strength of a bond at vanishing ice saturation [Pa], >= 0; dropped once melted, see "
				"thawedStrength."))
		((Real,iceShearStrength,50e6,Attr::triggerPostLoad,"Cohesive shear strength added at full ice saturation [Pa], >= 0."))
		((Real,exponent,2,Attr::triggerPostLoad,"Exponent m of eq. (7), > 1 [-]."))
		((Real,bondAreaFactor,1,Attr::triggerPostLoad,"Bond area over the square of the smaller radius, > 0 [-]."))
		((Real,meltSaturation,0.02,Attr::triggerPostLoad,"At or below this ice saturation every bond is gone and contacts are purely frictional [-]."))
		((Real,bondSaturation,0.05,Attr::triggerPostLoad,"Ice rising through this saturation bonds every frictional contact in range, >= meltSaturation [-]."))
		((Real,bondRange,0.05,Attr::triggerPostLoad,"Largest gap that is bonded, in units of the smaller radius, >= 0 [-]."))
		((Real,thawedStrength,0,Attr::triggerPostLoad,"Tensile and cohesive shear strength that a bond keeps when its ice has melted [Pa], >= 0: C_0 of eq. (5), "
				"the strength without ice. Such a bond holds until it breaks, once; ice that grows again bonds the contact anew. 0 (default): melting takes the bond "
				"away."))
		((Real,radiusRatio,1,Attr::readonly,"Radius of these grains over the one that stiffness and bonds are counted with [-]; set by GrainSwelling."))
		((Real,radiusRatioBefore,1,Attr::hidden,"radiusRatio of the step before.")),
		createIndex();
	);
	// clang-format on
	REGISTER_CLASS_INDEX(IceBondMat, FrictMat);
};
REGISTER_SERIALIZABLE(IceBondMat);

} // namespace yade
