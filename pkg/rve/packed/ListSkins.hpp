// SPDX-License-Identifier: GPL-2.0-or-later
#pragma once

namespace talik {

/// Skins of the neighbour lists: rebuilds against pairs carried along in vain. They are made to last for so many steps at the strain rate
/// of now, that of a single grain for so many at its speed, within bounds over the mean radius.
struct ListSkins {
	static constexpr double stepsOfLists = 800, leastOverRadius = 0.001, largestOverRadius = 0.02;
	static constexpr double stepsOfGrain = 200, largestOfGrain = 0.1;
};

} // namespace talik
