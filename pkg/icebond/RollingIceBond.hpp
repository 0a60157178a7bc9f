// SPDX-License-Identifier: GPL-2.0-or-later
#pragma once
#include <pkg/icebond/IceBondMat.hpp>
#include <pkg/icebond/IceBondPhys.hpp>

namespace yade {
class RollingIceBondPhys;

/// Grains that resist rolling on each other, in the way and with the names of stock YADE's CohFrictMat.
class RollingIceBondMat : public IceBondMat {
public:
	virtual ~RollingIceBondMat() {};
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
	virtual ~RollingIceBondPhys() {};
	void addMoments(const ScGeom&, const Interaction&, Scene&) override;
	void clearMoments() override { moment_bending = Vector3r::Zero(); }

protected:
	/// Angular velocity of the second grain less that of the first one [rad/s].
	static Vector3r spinBetween(const Interaction&, const Scene&);

public:
	// clang-format off
	YADE_CLASS_BASE_DOC_ATTRS_CTOR(RollingIceBondPhys,IceBondPhys,"Contact of two grains of :yref:`RollingIceBondMat`: an :yref:`IceBondPhys` with a moment "
			"against rolling, elastic up to maxRollPl times the normal force. Example: [i.phys.moment_bending for i in O.interactions if i.isReal].",
		((Real,kr,0,,"Rolling stiffness [N m]."))
		((Real,maxRollPl,0,,"Largest moment over normal force [m]; none under tension."))
		((Vector3r,moment_bending,Vector3r::Zero(),,"Moment against rolling on the second grain [N m].")),
		createIndex();
	);
	// clang-format on
	REGISTER_CLASS_INDEX(RollingIceBondPhys, IceBondPhys);
};
REGISTER_SERIALIZABLE(RollingIceBondPhys);

} // namespace yade
