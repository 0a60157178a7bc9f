// SPDX-License-Identifier: GPL-2.0-or-later
#pragma once
#include <pkg/icebond/IceBondContacts.hpp>

namespace yade {
class RollingIceBondPhys;

/// Grains that resist rolling on each other, in the way and with the names of stock YADE's CohFrictMat.
class RollingIceBondMat : public IceBondMat {
public:
	void postLoad(RollingIceBondMat&);
	/// Whether etaRoll may be 0.
	virtual bool            mayRollFreely() const { return false; }
	shared_ptr<IceBondPhys> newContact(const IceBondMat& other, Real r1, Real r2, Real shearStiffness) const override;

protected:
	void resistRolling(RollingIceBondPhys&, const RollingIceBondMat& second, Real r1, Real r2, Real shearStiffness) const;

public:
	// clang-format off
	YADE_CLASS_BASE_DOC_ATTRS_CTOR(RollingIceBondMat,IceBondMat,":yref:`IceBondMat` of grains that resist rolling on each other, as rough and angular grains do: "
			"the incremental law of moments of Law2_ScGeom6D_CohFrictPhys_CohesionMoment, without twisting. A contact between grains of which one is an IceBondMat "
			"rolls freely. Example: RollingIceBondMat(young=0.6e9,poisson=0.8,frictionAngle=0.4636,density=2650,etaRoll=0.2).",
		((Real,alphaKr,2,Attr::triggerPostLoad,"Rolling stiffness over k_s R_1 R_2, as CohFrictMat.alphaKr [-], > 0; k_s is that of the grains without ice. Of two "
				"materials the harmonic mean counts."))
		((Real,etaRoll,0.1,Attr::triggerPostLoad,"Coefficient of rolling friction: largest moment over normal force and smaller radius, as CohFrictMat.etaRoll [-], "
				"> 0. Of two materials the smaller one counts.")),
		createIndex();
	);
	// clang-format on
	REGISTER_CLASS_INDEX(RollingIceBondMat, IceBondMat);
};
REGISTER_SERIALIZABLE(RollingIceBondMat);

/// Contact of grains that resist rolling.
class RollingIceBondPhys : public IceBondPhys {
public:
	void addMoments(const ScGeom&, const Interaction&, Scene&) override;
	void clearMoments() override { moment_bending = Vector3r::Zero(); }

protected:
	/// Angular velocity of the second grain less that of the first one [rad/s].
	static Vector3r spinBetween(const Interaction&, const Scene&);

public:
	// clang-format off
	YADE_CLASS_BASE_DOC_ATTRS_CTOR(RollingIceBondPhys,IceBondPhys,"Contact of two grains of :yref:`RollingIceBondMat`: an :yref:`IceBondPhys` with a moment "
			"against rolling, elastic up to maxRollPl times the normal force. Example: [i.phys.moment_bending for i in O.interactions if i.isReal].",
		((Real,kr,0,,"Rolling stiffness [N m]; of grains with hertzMindlin over 1.5 sqrt(u_n) [N m^0.5]."))
		((Real,maxRollPl,0,,"Largest moment over normal force [m]; none under tension."))
		((Vector3r,moment_bending,Vector3r::Zero(),,"Moment against rolling on the second grain [N m].")),
		createIndex();
	);
	// clang-format on
	REGISTER_CLASS_INDEX(RollingIceBondPhys, IceBondPhys);
};
REGISTER_SERIALIZABLE(RollingIceBondPhys);

/// Grains whose ice bonds carry moments; they may resist rolling, too.
class MomentIceBondMat : public RollingIceBondMat {
public:
	void                    postLoad(MomentIceBondMat&);
	bool                    mayRollFreely() const override { return true; }
	shared_ptr<IceBondPhys> newContact(const IceBondMat& other, Real r1, Real r2, Real shearStiffness) const override;
	talik::BondSection      section() const { return { bondRadiusFactor, momentContribution }; }
	// clang-format off
	YADE_CLASS_BASE_DOC_ATTRS_CTOR(MomentIceBondMat,RollingIceBondMat,":yref:`IceBondMat` of grains whose ice bonds carry moments: bending, and of spheres "
			"twisting. The edge of its section is at R_b = bondRadiusFactor sqrt(A_b/pi); it fails where the normal force less 4 momentContribution M_b/R_b falls "
			"below -C_eta A_b, or the shear force and 2 momentContribution M_t/R_b together exceed C_tau A_b + mu max(F_n,0) (parallel bond, Potyondy & Cundall 2004). "
			"Moments follow the stiffness of the ice; they do not creep. A contact between grains of which one is another material carries none. Grains roll freely "
			"unless etaRoll is given. Example: MomentIceBondMat(young=0.6e9,poisson=0.8,frictionAngle=0.4636,density=2650,iceSaturation=1,bondRadiusFactor=1).",
		((Real,bondRadiusFactor,1,Attr::triggerPostLoad,"Radius R_b of the section of a bond over that of a circle of its area A_b [-], > 0. The bending stiffness "
				"is k_ice R_b^2/4, the twisting stiffness poisson k_ice R_b^2/2. Of two materials the smaller one counts."))
		((Real,momentContribution,1,Attr::triggerPostLoad,"Share of the moments in the stress at the edge of the section [-], 0 to 1 (moment-contribution factor of "
				"Potyondy 2011); 0: moments never break a bond. Of two materials the larger one counts.")),
		etaRoll = 0;
		createIndex();
	);
	// clang-format on
	REGISTER_CLASS_INDEX(MomentIceBondMat, RollingIceBondMat);
};
REGISTER_SERIALIZABLE(MomentIceBondMat);

/// Contact of grains whose bonds carry moments.
class MomentIceBondPhys : public RollingIceBondPhys {
public:
	talik::BondSection        section() const { return { bondRadiusFactor, momentContribution }; }
	bool                      carriesMoments() const override { return true; }
	talik::EdgeForces<double> bend(const ScGeom&, const Interaction&, const Scene&, const talik::ContactStiffness&) override;
	void                      keepBondMoment(double share) override;
	void                      addMoments(const ScGeom&, const Interaction&, Scene&) override;
	void                      clearMoments() override;
	// clang-format off
	YADE_CLASS_BASE_DOC_ATTRS_CTOR(MomentIceBondPhys,RollingIceBondPhys,"Contact of two grains of :yref:`MomentIceBondMat`: a :yref:`RollingIceBondPhys` whose "
			"intact bond carries a moment. Example: [i.phys.bondMoment for i in O.interactions if i.isReal].",
		((Real,bondRadiusFactor,0,,"Radius of the section of the bond over that of a circle of its area [-]."))
		((Real,momentContribution,1,,"Share of the moments in the stress at the edge of the section [-]."))
		((Vector3r,bondMoment,Vector3r::Zero(),,"Moment of the bond on the second grain, bending and twisting [N m].")),
		createIndex();
	);
	// clang-format on
	REGISTER_CLASS_INDEX(MomentIceBondPhys, RollingIceBondPhys);
};
REGISTER_SERIALIZABLE(MomentIceBondPhys);

} // namespace yade
