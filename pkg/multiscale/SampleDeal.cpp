// SPDX-License-Identifier: GPL-2.0-or-later
#include <pkg/multiscale/SampleDeal.hpp>

#include <algorithm>
#include <cmath>
#include <numeric>

namespace talik {

std::vector<int> dealtAgain(const std::vector<double>& cost, std::vector<int> owner, int ranks)
{
	constexpr double    enough = 1.02;
	std::vector<double> load(std::size_t(ranks), 0.);
	for (std::size_t k = 0; k < cost.size(); ++k)
		load[std::size_t(owner[k])] += cost[k];
	const double mean = std::accumulate(load.begin(), load.end(), 0.) / ranks;
	for (std::size_t moves = 0; moves < cost.size(); ++moves) {
		const auto   most = std::max_element(load.begin(), load.end()), least = std::min_element(load.begin(), load.end());
		const double gap = *most - *least;
		if (*most <= enough * mean) break;
		std::size_t best = cost.size();
		for (std::size_t k = 0; k < cost.size(); ++k) {
			if (owner[k] != int(most - load.begin()) || !(cost[k] > 0 && cost[k] < gap)) continue;
			if (best == cost.size() || std::fabs(gap - 2 * cost[k]) < std::fabs(gap - 2 * cost[best])) best = k;
		}
		if (best == cost.size()) break;
		*most -= cost[best];
		*least += cost[best];
		owner[best] = int(least - load.begin());
	}
	return owner;
}

} // namespace talik
