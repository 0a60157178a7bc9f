// SPDX-License-Identifier: GPL-2.0-or-later
#pragma once
#include <pkg/icebond/IceBondModel.hpp>

namespace talik {

/// Stiffness of one contact without ice and what ice saturation makes of it.
struct ContactStiffness {
	double grain;      ///< k_g, normal stiffness of the grains alone [N/m]
	double shearRatio; ///< k_s/k_n [-]
	double iceRatio;   ///< stiffness of the ice spring over k_g, IceBondModel::iceStiffnessRatio [-]
	double ice() const { return grain * iceRatio; }
	double total() const { return grain * (1. + iceRatio); }
};

/// Memory of one contact: a grain spring beside an ice spring (rule parallel), or one spring with a moving reference
/// (forceContinuous, secant). Overlap u_n and normal force are positive in compression. Shear is a vector (YADE) or a scalar.
template <class Shear> struct IceBond {
	BondState state  = BondState::NONE;
	bool      iceCut = false; ///< the ice spring of a broken bond has opened and carries nothing any more
	double    uGrain = 0;     ///< overlap at which the grain spring of an intact bond is free [m]
	double    uIce   = 0;     ///< overlap at which the ice spring is free [m]
	Shear     iceShear;       ///< part of the shear force that the ice carries [N]

	bool hasIceSpring() const { return state == BondState::BONDED || (state == BondState::BROKEN && !iceCut); }

	/// Normal force [N] at overlap un [m]. A broken bond pushes only, and its ice opens for good when un falls to uIce.
	double normalForce(const ContactStiffness& k, double un, StiffnessRule rule)
	{
		if (rule != StiffnessRule::parallel) {
			const double force = k.total() * (un - uIce);
			return state == BondState::BONDED ? force : std::max(force, 0.);
		}
		if (state == BondState::BONDED) return k.grain * (un - uGrain) + k.ice() * (un - uIce);
		const double grainForce = k.grain * std::max(un, 0.);
		if (!hasIceSpring()) return grainForce;
		if (un <= uIce) cutIce();
		return grainForce + (iceCut ? 0. : k.ice() * (un - uIce));
	}

	/// Shear stiffness now [N/m].
	double shearStiffness(const ContactStiffness& k, StiffnessRule rule) const
	{
		return k.shearRatio * (rule == StiffnessRule::parallel && !hasIceSpring() ? k.grain : k.total());
	}

	/// New ice at overlap un is free of stress: no force appears. Reference of a bond across a gap is the gap. A broken bond whose
	/// ice still carries keeps what it carries.
	void form(double un, StiffnessRule rule)
	{
		if (!hasIceSpring()) {
			if (rule == StiffnessRule::parallel || un < 0) uIce = un;
			iceShear = iceShear * 0.;
		}
		state  = BondState::BONDED;
		iceCut = false;
		uGrain = std::min(un, 0.);
	}

	/// Ice grows (forces stay) or melts (melted ice drops its share), Yu & Zhao eqs (5)-(7) with the rule chosen.
	void changeStiffness(const ContactStiffness& before, const ContactStiffness& after, double un, Shear& shear, StiffnessRule rule)
	{
		if (rule == StiffnessRule::secant) shear = shear * (after.total() / before.total());
		else if (rule == StiffnessRule::forceContinuous) uIce = un - before.total() / after.total() * (un - uIce);
		else if (hasIceSpring()) changeIceSpring(before.ice(), after.ice(), un, shear);
	}

	/// Complete melt: back to friction, the ice share of the shear force is gone.
	void melt(Shear& shear, StiffnessRule rule)
	{
		if (state == BondState::NONE) return;
		if (rule == StiffnessRule::parallel) shear = shear - iceShear;
		state    = BondState::NONE;
		iceCut   = false;
		uGrain   = 0;
		uIce     = rule == StiffnessRule::forceContinuous ? uIce : 0;
		iceShear = iceShear * 0.;
	}

	/// Failure of a bond that has outlasted its ice: frictional at once, so that new ice bonds it again. Returns the normal force after it [N].
	double breakThawed(const ContactStiffness& k, double un)
	{
		state    = BondState::NONE;
		iceCut   = false;
		uGrain = uIce = 0;
		iceShear      = iceShear * 0.;
		return k.grain * std::max(un, 0.);
	}

	/// Failure in tension: nothing is carried in this step, only grains push from now on.
	void breakInTension(Shear& shear)
	{
		state  = BondState::BROKEN;
		iceCut = true;
		uGrain = uIce = 0;
		shear = iceShear = iceShear * 0.;
	}

	/// Failure in shear: friction remains. Returns the normal force after the break [N].
	double breakInShear(const ContactStiffness& k, double un, StiffnessRule rule)
	{
		state  = BondState::BROKEN;
		uGrain = 0;
		return normalForce(k, un, rule);
	}

private:
	void cutIce()
	{
		iceCut   = true;
		iceShear = iceShear * 0.;
	}
	void changeIceSpring(double before, double after, double un, Shear& shear)
	{
		if (after > before) {
			uIce = un - (before > 0 ? before / after : 0.) * (un - uIce);
		} else {
			const double remaining = before > 0 ? after / before : 0.;
			shear                  = shear - iceShear * (1. - remaining);
			iceShear               = iceShear * remaining;
		}
	}
};

} // namespace talik
