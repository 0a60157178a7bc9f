// SPDX-License-Identifier: GPL-2.0-or-later
#include <pkg/mpm/GroundParts.hpp>

#include <cstring>

// A ground whose strips are shared out among ranks.

namespace talik {

template <int D> void Ground<D>::distribute(std::shared_ptr<Communicator> communicator, bool required)
{
	parts_->ranks.distribute(std::move(communicator), required);
}

template <int D> bool Ground<D>::inSlabs() const { return bool(parts_->ranks); }

template <int D> std::string Ground<D>::Parts::refusalOfRanks() const
{
	if (!grid.images().empty()) return "PeriodicBoundary repeats the ground of one rank: choose 'none', or leave it out.";
	return "";
}

template <int D> void Ground<D>::Parts::followSlabs(bool moved)
{
	for (const auto& skeleton : settings.skeletons)
		skeleton->followSlabs(*ranks.slabs(), points->ids(), moved);
}

template <int D> void Ground<D>::Parts::keepOwnPart()
{
	const ActiveRange& halo  = ranks.halo();
	const int          first = halo.firstNode, last = halo.lastNode, begin = ranks.slabs()->firstPoint(), end = ranks.slabs()->endPoint();
	if (motion) motion->nodes.keepOnly(first, last);
	if (motion) motion->solved.keepOnly(first, last);
	if (mappedBack) mappedBack->missing.keepOnly(first, last);
	if (momentum) momentum->keepOnly(first, last);
	if (heat) heat->keepOnly(first, last);
	if (water) water->keepOnly(halo, begin, end);
	if (implicit) implicit->keepOnly(halo, begin, end);
	if (surface) surface->nodes.keepOnly(first, last);
	if (cells) cells->keepOnly(halo, begin, end);
	if (bodies) bodies->keepOnly(first, last);
	if (front) front->keepOnly(begin, end);
	if (thawStrain) thawStrain->keepOnly(halo, begin, end);
	if (segregation) segregation->keepOnly(halo, begin, end);
	if (compression) compression->keepOnly(begin, end);
	if (calendar) calendar->keepOnly(halo);
	scratch.keepOnly(begin, end);
}

/// Of this rank's points since the last sorting, by place, in steps of a point.
template <int D> const double* Ground<D>::Parts::costOfPoints() const
{
	double* const cost = scratch.data();
	std::fill(cost + ranks.slabs()->firstPoint(), cost + ranks.slabs()->endPoint(), double(std::max(1L, clock.steps - clock.lastSort)));
	if (motion)
		for (int k = 0; k < skeletons.count(); ++k)
			skeletons.law(k).addCost(skeletons.batch(k, stepTime()), cost);
	return cost;
}

template <int D> void Ground<D>::Parts::sortInSlabs(bool costKnown)
{
	points->sortInSlabs(grid, *ranks.slabs(), costKnown ? nullptr : costOfPoints(), [&] { ranks.cut(); });
	clock.range = ActiveRange::of(grid, *points);
	ranks.keepOwnPoints();
}

template <int D> std::string Ground<D>::Parts::ownLimits() const
{
	std::string bytes;
	try {
		for (const TimeStepLimit& limit : limitsOfPoints().limits) {
			bytes.append(reinterpret_cast<const char*>(&limit.step), sizeof limit.step);
			bytes.append(reinterpret_cast<const char*>(&limit.point), sizeof limit.point);
		}
	} catch (const std::exception& problem) {
		return "!" + std::string(problem.what());
	}
	return "." + bytes;
}

template <int D> StableTimeStep Ground<D>::Parts::limitsOfRanks() const
{
	const std::vector<std::string> byRank = ranks.askLimits();
	for (const std::string& words : byRank)
		if (words[0] == '!') throw std::runtime_error(words.substr(1));
	StableTimeStep result = limitsOfPoints();
	for (TimeStepLimit& limit : result.limits)
		limit.step = std::numeric_limits<double>::infinity();
	for (const std::string& bytes : byRank) {
		const char* from = bytes.data() + 1;
		for (TimeStepLimit& limit : result.limits) {
			double step  = 0.0;
			int    point = 0;
			std::memcpy(&step, from, sizeof step);
			std::memcpy(&point, from + sizeof step, sizeof point);
			from += sizeof step + sizeof point;
			if (step < limit.step) limit.step = step, limit.point = point;
		}
	}
	return result;
}

TALIK_IN_PLANE_AND_SPACE(Ground);

} // namespace talik
