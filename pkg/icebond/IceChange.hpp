// SPDX-License-Identifier: GPL-2.0-or-later
#pragma once
#include <pkg/icebond/IceBond.hpp>

namespace talik {

/// What a change of ice saturation does to one bond, for processors and for cards.
struct IceChange {
	bool melted;       ///< no ice is left
	bool bondsOutlast; ///< intact bonds hold without ice

	/// Stiffness of the contact before and after; overlap() is asked for where it is needed. True if an intact bond has melted.
	template <class Overlap, class Shear>
	bool apply(IceBond& bond, const ContactStiffness& before, const ContactStiffness& after, const Overlap& overlap, Shear& shear, Shear& iceShear) const
	{
		if (melted && !(bond.intact() && bondsOutlast)) {
			const bool wasIntact = bond.intact();
			bond.melt(shear, iceShear);
			return wasIntact;
		}
		if (bond.hasIceSpring()) bond.changeStiffness(before, after, overlap(), shear, iceShear);
		return false;
	}
};

/// New ice bonds a contact without bond whose grains are no farther apart than reach [m]. True if it did.
template <class Shear> bool formWithin(IceBond& bond, double overlap, double reach, Shear& iceShear)
{
	if (bond.state != BondState::NONE || overlap < -reach) return false;
	bond.form(overlap, iceShear);
	return true;
}

} // namespace talik
