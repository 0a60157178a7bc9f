// SPDX-License-Identifier: GPL-2.0-or-later
#pragma once
#include <vector>

namespace talik {

/// Owners, 0 to ranks - 1, after a new deal: states go from the rank with most cost to that with least, one at a time and each the one that
/// brings the two closest, until the largest cost is within 2 % of the mean or no state can be moved with a gain. Depends on nothing else,
/// so that all ranks find the same.
std::vector<int> dealtAgain(const std::vector<double>& cost, std::vector<int> owner, int ranks);

} // namespace talik
