// SPDX-License-Identifier: GPL-2.0-or-later
#include <pkg/mpm/points/ConcernedPoints.hpp>

#include <algorithm>
#include <cmath>
#include <sstream>

namespace talik {

template <int D> std::string whereabouts(const MaterialPoints<D>& points, int place, long step)
{
	std::ostringstream text;
	text << "material point " << points.id(place) << " at (";
	for (int a = 0; a < D; ++a)
		text << (a ? ", " : "") << points.position(a)[place];
	text << ") in step " << step;
	return text.str();
}

template <int D> ConcernedPoints concernedPoints(const MaterialPoints<D>& points, const std::vector<int>& places, long step, SlabDecomposition* slabs)
{
	constexpr std::size_t most = 5;
	std::vector<int>      ids;
	ConcernedPoints       all;
	all.count = places.size();
	for (std::size_t k = 0; k < std::min(most, places.size()); ++k)
		ids.push_back(points.id(places[k]));
	if (!places.empty()) {
		all.first  = whereabouts(points, places.front(), step);
		double sum = 0.0;
		for (int a = 0; a < D; ++a)
			sum += points.position(a)[places.front()];
		all.finite = std::isfinite(sum);
	}
	if (slabs) {
		const auto counts = slabs->say(std::to_string(all.count));
		const auto firsts = slabs->say((all.finite ? "1" : "0") + all.first);
		const auto named  = slabs->say(std::string(reinterpret_cast<const char*>(ids.data()), ids.size() * sizeof(int)));
		all               = {};
		ids.clear();
		for (int r = 0; r < slabs->count(); ++r) {
			const std::size_t count = std::stoul(counts[r]);
			if (all.count == 0 && count > 0) {
				all.first  = firsts[r].substr(1);
				all.finite = firsts[r][0] == '1';
			}
			all.count += count;
			const auto* from = reinterpret_cast<const int*>(named[r].data());
			ids.insert(ids.end(), from, from + named[r].size() / sizeof(int));
		}
	}
	for (std::size_t k = 0; k < std::min(most, ids.size()); ++k)
		all.names += (k ? ", " : "") + std::to_string(ids[k]);
	return all;
}

template std::string     whereabouts(const MaterialPoints<2>&, int, long);
template std::string     whereabouts(const MaterialPoints<3>&, int, long);
template ConcernedPoints concernedPoints(const MaterialPoints<2>&, const std::vector<int>&, long, SlabDecomposition*);
template ConcernedPoints concernedPoints(const MaterialPoints<3>&, const std::vector<int>&, long, SlabDecomposition*);

} // namespace talik
