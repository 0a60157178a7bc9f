// SPDX-License-Identifier: GPL-2.0-or-later
#pragma once

#include <pkg/mpm/effects/SolidMotion.hpp>
#include <pkg/mpm/front/ThawFront.hpp>
#include <pkg/mpm/grid/ShapeFunctions.hpp>
#include <pkg/mpm/StepContext.hpp>

#include <vector>

namespace talik {

/// Finds points that are about to leave the grid's box, before the first of them moves, and those that have strayed from their strip.
template <int D> class PositionCheck {
public:
	/// After points were sorted.
	void start(const MaterialPoints<D>& points);
	/// Keeps the box around the points of a strip, first to last - 1, where they are now.
	void bound(const MaterialPoints<D>& points, int strip, int first, int last);

	struct Paths {
		bool leave;  ///< points of this rank would leave the box in the step
		bool finite; ///< all velocities are numbers
	};
	/// Of the velocities that nodes give back to the points; front may be null.
	Paths checkPaths(
	        const StepContext<D>& step, const MaterialPoints<D>& points, const ShapeFunction<D>& shape, const SolidMotion<D>& motion,
	        const ThawFront<D>* front);
	/// Places of these points.
	std::vector<int> leaving(
	        const StepContext<D>& step, const MaterialPoints<D>& points, const ShapeFunction<D>& shape, const SolidMotion<D>& motion,
	        const ThawFront<D>* front) const;

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
	double longestPath(const StepContext<D>& step, const SolidMotion<D>& motion, const ThawFront<D>* front);
	bool   leaves(
	          const StepContext<D>& step, const MaterialPoints<D>& points, const ShapeFunction<D>& shape, const SolidMotion<D>& motion,
	          const ThawFront<D>* front, int p, WeightBlock<D>& w) const;

	std::vector<Bounds> bounds_; ///< by strip
	std::vector<char>   leave_;  ///< by strip
	std::vector<double> partial_;
};

extern template class PositionCheck<2>;
extern template class PositionCheck<3>;

} // namespace talik
