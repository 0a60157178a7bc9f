// SPDX-License-Identifier: GPL-2.0-or-later
#pragma once

#include <pkg/mpm/grid/Grid.hpp>
#include <pkg/mpm/points/ActiveRange.hpp>
#include <pkg/mpm/points/MaterialPoints.hpp>
#include <pkg/mpm/skeleton/SkeletonModel.hpp>
#include <pkg/mpm/StepLedger.hpp>

#include <string>

namespace talik {

/// What a step is for every effect: how long it takes, on which part of the grid and of the points, and where it is booked. What an effect reads
/// and writes besides are arguments of its calls.
template <int D> struct StepContext {
	double             dt;            ///< Delta t [s of motion]
	double             calendarScale; ///< calendar time per time of motion in the step [-]
	double             calendarDt;    ///< Delta t_c, time of slow processes that passes in the step [s]
	double             calendarEnd;   ///< calendar time at the end of the step [s]
	const Grid<D>&     grid;
	const ActiveRange& owned;  ///< rows of nodes and cells that the points of this rank touch
	const ActiveRange& halo;   ///< the same rows and those of the neighbours that are needed to solve there
	const Strips&      strips; ///< points of this rank, and the threads that work on them
	SlabDecomposition* slabs;  ///< the ranks that divide the ground; null: there is one
	StepLedger<D>&     ledger; ///< what the step adds to the accounts

	/// work(account, firstPoint, lastPoint) for all strips.
	template <class Work> void bookByStrip(Work&& work) const
	{
		strips.gather([&](int strip, int first, int last) { work(ledger.ofStrip(strip), first, last); });
	}
	StepTime time() const { return { dt, calendarDt }; }
	/// The first words that any rank has; empty if none has. Collective.
	std::string firstWords(const std::string& own) const
	{
		if (slabs)
			for (const std::string& words : slabs->say(own))
				if (!words.empty()) return words;
		return own;
	}
	/// Bits that any rank sets; collective.
	unsigned onAnyRank(unsigned bits) const { return slabs ? slabs->anyOf(bits) : bits; }
};

} // namespace talik
