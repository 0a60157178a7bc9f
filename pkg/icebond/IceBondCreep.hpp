// SPDX-License-Identifier: GPL-2.0-or-later
#pragma once
#include <pkg/icebond/IceBond.hpp>
#include <pkg/icebond/IceCreepLaw.hpp>

namespace talik {

/// Why options of a sample or scene do not fit together.
constexpr const char* momentsDoNotCreep
        = "Bonds that carry moments do not creep: leave the creep out, or give the grains an IceBondMat or RollingIceBondMat in place of MomentIceBondMat.";

/// A contact whose ice creeps.
struct CreepingContact {
	ContactStiffness stiffness;
	double           young;    ///< E_c of the contact with its ice, eq. (6) [Pa]
	double           area;     ///< A_b [m^2]
	double           friction; ///< tangent of the friction angle [-]
	double           overlap;  ///< u_n, which does not change [m]
};

/// What grains without ice could not hold is the ice's, eq. (14.9); no force changes.
template <class Shear> void giveIceItsForce(IceBond& bond, const CreepingContact& c, const Shear& shear, Shear& iceShear)
{
	const double touching = std::max(c.overlap, 0.), apart = std::min(c.overlap, 0.);
	bond.uIce -= c.stiffness.grain * (apart - bond.uGrain) / c.stiffness.ice();
	bond.uGrain           = apart;
	const Shear  ofGrains = shear - iceShear;
	const double norm = shearNorm(ofGrains), limit = c.friction * c.stiffness.grain * touching;
	if (norm > limit) iceShear = shear - ofGrains * (limit / norm);
}

/// The force of the ice relaxes at constant overlap and slip, eq. (14.10). Stiffness rule parallel.
template <class Shear> void relaxIce(IceBond& bond, const BondCreep& creep, const CreepingContact& c, Shear& shear, Shear& iceShear)
{
	if (!bond.hasIceSpring() || !(c.stiffness.iceRatio > 0)) return;
	if (bond.intact()) giveIceItsForce(bond, c, shear, iceShear);
	else if (c.overlap <= bond.uIce) return; // broken ice that no longer pushes
	const double normal = c.stiffness.ice() * (c.overlap - bond.uIce), kept = creep.kept(c.young, std::hypot(normal, shearNorm(iceShear)) / c.area);
	bond.uIce = c.overlap - kept * (c.overlap - bond.uIce);
	shear -= iceShear * (1 - kept);
	iceShear *= kept;
}

} // namespace talik
