// SPDX-License-Identifier: GPL-2.0-or-later
#pragma once

#include <pkg/mpm/front/FrontContact.hpp>
#include <pkg/mpm/StepContext.hpp>

#include <vector>

namespace talik {

/// Walls at the front: a ghost node is folded into its image before the contact, and unfolded after it, side by side, eqs. (8.4) and (8.5).
template <int D> class FrontWalls {
public:
	using Mirrors = typename FrontNodes<D>::Mirrors;

	void applySymmetry(const StepContext<D>& step, const FrontNodes<D>& nodes, const Mirrors& mirrors, FrontRecords<D>& records);
	/// The frozen side's part of what walls that have left their nodes push; call after applySymmetry().
	void pushAhead(
	        const StepContext<D>& step, const FrontNodes<D>& nodes, const Mirrors& mirrors, const SolidMotion<D>& motion, FrontRecords<D>& records) const;
	/// Both sides move with such a wall where it stands; books what the wall gives.
	void leadWalls(
	        const StepContext<D>& step, const FrontNodes<D>& nodes, const Mirrors& mirrors, const SolidMotion<D>& motion, const FrontContact<D>& contact,
	        bool liquid, FrontRecords<D>& records) const;
	/// Answers of the ghosts; books what walls give to the sides apart.
	void unfold(const StepContext<D>& step, const FrontNodes<D>& nodes, const Mirrors& mirrors, FrontRecords<D>& records) const;

private:
	std::vector<std::array<double, 4>> folded_; ///< by mirror: masses that went from a ghost to its image, frozen, thawed, and their liquids [kg]
};

} // namespace talik
