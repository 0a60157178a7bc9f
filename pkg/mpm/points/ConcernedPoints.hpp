// SPDX-License-Identifier: GPL-2.0-or-later
#pragma once

#include <pkg/mpm/points/MaterialPoints.hpp>

#include <string>
#include <vector>

namespace talik {

/// "material point 7 at (0.1, 0.2) in step 3".
template <int D> std::string whereabouts(const MaterialPoints<D>& points, int place, long step);

/// What a sentence says of points that cannot go on, of all ranks.
struct ConcernedPoints {
	std::size_t count = 0;
	std::string names; ///< of up to five
	std::string first; ///< where the first one is
	bool        finite = true;
};
/// places: those of this rank. With slabs collective.
template <int D> ConcernedPoints concernedPoints(const MaterialPoints<D>& points, const std::vector<int>& places, long step, SlabDecomposition* slabs);

} // namespace talik
