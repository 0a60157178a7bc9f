// SPDX-License-Identifier: GPL-2.0-or-later
#pragma once

#include <pkg/mpm/points/MaterialPoints.hpp>
#include <pkg/mpm/StepContext.hpp>

#include <vector>

namespace talik {

/// Finds points that have left the grid's box, and those that have strayed from their strip.
template <int D> class PositionCheck {
public:
	/// After points were sorted.
	void start(const MaterialPoints<D>& points);
	/// Keeps the box around the points of a strip, first to last - 1, where they are now.
	void bound(const MaterialPoints<D>& points, int strip, int first, int last);

	struct Positions {
		bool             strayed = false; ///< far from their strip, or out of the rows that are cleared in every step: to be sorted anew
		std::vector<int> outside;         ///< of each strip, the place of the first point that is not in the box or not a number
	};
	/// After points have moved; cleared: the rows that are cleared in every step.
	Positions checkPositions(const StepContext<D>& step, const MaterialPoints<D>& points, const ActiveRange& cleared) const;

private:
	/// Smallest box around the points of a strip.
	struct Bounds {
		Vec<D> low, high;
		bool   numbers; ///< false: a position is not finite
	};
	std::vector<Bounds> bounds_; ///< by strip
};

} // namespace talik
