// SPDX-License-Identifier: GPL-2.0-or-later
#include <pkg/mpm/GroundParts.hpp>

#include <cmath>
#include <cstring>

// A ground whose strips are shared out among ranks.

namespace talik {

namespace {
	const std::string askPoints = "points of the bands", askLimits = "time step limits";
} // namespace

template <int D> void Ground<D>::distribute(std::shared_ptr<RankTalk> talk, bool required)
{
	parts_->talk          = std::move(talk);
	parts_->bandsRequired = required;
}

template <int D> bool Ground<D>::inBands() const { return parts_->bands != nullptr; }

/// Why this ground is not computed in bands; empty where it is.
template <int D> std::string Ground<D>::Parts::refusalOfBands() const
{
	const int strips = points->strips().count(), least = Bands::leastStrips;
	if (settings.motion && settings.motion->balanceStart) return "balanceStart is one system for the whole ground: choose 'samples', or leave it out.";
	if (implicit) return "the implicit pressure of its water is one system for the whole ground: choose 'samples', or the explicit pressure.";
	if (strips < least * talk->count())
		return "the grid has " + std::to_string(strips) + " strips of " + std::to_string(Strips::rows) + " rows of cells, and each of "
		        + std::to_string(talk->count()) + " ranks needs " + std::to_string(least) + ": choose 'samples', or run it on fewer ranks.";
	return "";
}

/// Once it is known which points each strip has. Collective.
template <int D> void Ground<D>::Parts::startBands()
{
	if (!talk) return;
	const std::string refusal = refusalOfBands();
	if (!refusal.empty()) {
		if (bandsRequired) throw std::invalid_argument("distribute is 'ground': " + refusal);
		return;
	}
	bands                  = std::make_unique<Bands>(talk, [this](const std::string& question) { return answer(question); });
	bands->writes          = [this](const FilePlace& place, PartSum& sum) { writeOwnPoints(place, sum); };
	points->strips().bands = bands.get();
	bands->allCurrent      = false;
	talk->meet("the beginning of a ground in bands");
	cutBands();
}

template <int D> void Ground<D>::Parts::cutBands()
{
	const Strips& strips = points->strips();
	const int     axis   = strips.axis;
	Bands::Rows   rows;
	rows.ofStrip    = Strips::rows;
	rows.nodes      = grid.nodes(axis);
	rows.cells      = grid.cells(axis);
	rows.nodesOfRow = grid.nodeStride(axis);
	rows.cellsOfRow = grid.cellStride(axis);
	bands->cut(strips.first, rows);
}

template <int D> void Ground<D>::Parts::followBands(bool moved)
{
	for (const auto& skeleton : settings.skeletons)
		skeleton->followBands(*bands, points->ids(), moved);
}

template <int D> void Ground<D>::Parts::chooseRows()
{
	reached = around = clock.range;
	if (!bands) return;
	const auto limit = [&](ActiveRange& range, const Bands::Part& part) {
		const int axis = points->strips().axis, nodes = grid.nodeStride(axis), cells = grid.cellStride(axis);
		range.firstNode = std::max(range.firstNode, part.firstNode * nodes);
		range.lastNode  = std::max(range.firstNode, std::min(range.lastNode, part.endNode * nodes)); // none in strips of the box that have no ground
		range.firstCell = std::max(range.firstCell, part.firstCell * cells);
		range.lastCell  = std::max(range.firstCell, std::min(range.lastCell, part.endCell * cells));
	};
	limit(reached, bands->touched(false));
	limit(around, bands->touched(true));
}

template <int D> void Ground<D>::Parts::meetRanks()
{
	bands->meet(clock.steps);
	if (!bands->allCurrent) return;
	bands->allCurrent = false;
	keepOwnPoints();
}

template <int D> void Ground<D>::Parts::keepOwnPoints() const { points->fields().keepOnly(bands->firstPoint(), bands->endPoint()); }

template <int D> void Ground<D>::Parts::keepOwnPart()
{
	const int first = around.firstNode, last = around.lastNode, begin = bands->firstPoint(), end = bands->endPoint();
	if (motion) motion->nodes.keepOnly(first, last);
	if (motion) motion->solved.keepOnly(first, last);
	if (momentum) momentum->keepOnly(first, last);
	if (heat) heat->keepOnly(first, last);
	if (water) water->keepOnly(around, begin, end);
	if (surface) surface->nodes.keepOnly(first, last);
	if (cells) cells->keepOnly(around, begin, end);
	if (bodies) bodies->keepOnly(first, last);
	if (front) front->keepOnly(begin, end);
	if (thawStrain) thawStrain->keepOnly(around, begin, end);
	if (segregation) segregation->keepOnly(around, begin, end);
	if (compression) compression->keepOnly(around, begin, end);
	if (calendar) calendar->keepOnly(around);
	scratch.keepOnly(begin, end);
}

/// Of this rank's points since the last sorting, by place, in steps of a point.
template <int D> const double* Ground<D>::Parts::costOfPoints() const
{
	double* const cost = scratch.data();
	std::fill(cost + bands->firstPoint(), cost + bands->endPoint(), double(std::max(1L, clock.steps - clock.lastSort)));
	if (motion)
		for (int k = 0; k < skeletons.count(); ++k)
			skeletons.law(k).addCost(skeletons.batch(k, stepTime()), cost);
	return cost;
}

template <int D> void Ground<D>::Parts::sortInBands()
{
	points->sortInBands(grid, *bands, costOfPoints(), [&] { cutBands(); });
	clock.range = ActiveRange::of(grid, *points);
	keepOwnPoints();
}

template <int D> void Ground<D>::Parts::bringPoints() const
{
	if (!bands || bands->allCurrent) return;
	takePoints(bands->ask(askPoints));
	bands->allCurrent = true;
}

template <int D> std::string Ground<D>::Parts::ownPoints() const
{
	const int   first = bands->firstPoint(), count = bands->endPoint() - first;
	std::string bytes;
	overArrays([&](double* values) { bytes.append(reinterpret_cast<const char*>(values + first), count * sizeof(double)); });
	return bytes;
}

template <int D> void Ground<D>::Parts::takePoints(const std::vector<std::string>& byRank) const
{
	for (int r = 0; r < bands->count(); ++r) {
		const auto [first, end] = bands->pointsOf(r);
		const std::size_t size  = (end - first) * sizeof(double);
		const char*       from  = byRank[r].data();
		overArrays([&, begin = first](double* values) {
			std::memcpy(values + begin, from, size);
			from += size;
		});
	}
}

/// Array by array, each with its points in the place that they have among all.
template <int D> void Ground<D>::Parts::writeOwnPoints(const FilePlace& place, PartSum& sum) const
{
	PartedFile        file(place.path, PartedFile::For::writing, place.end);
	PointFields&      f     = points->fields();
	const std::size_t first = points->strips().firstPoint(), end = points->strips().endPoint();
	std::uint64_t     at = place.at + first * sizeof(double);
	for (std::size_t k = 0; k < f.list().size(); ++k)
		for (int c = 0; f.list()[k].persistent && c < f.list()[k].components; ++c) {
			file.write(f.component(int(k), c) + first, (end - first) * sizeof(double), at);
			at += f.count() * sizeof(double);
		}
	file.close();
	sum.add(file.sum().value());
}

template <int D> std::string Ground<D>::Parts::answer(const std::string& question) const
{
	if (question == askPoints) return ownPoints();
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
	const std::vector<std::string> byRank = bands->ask(askLimits);
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

template void           Ground<2>::distribute(std::shared_ptr<RankTalk>, bool);
template bool           Ground<2>::inBands() const;
template void           Ground<2>::Parts::startBands();
template void           Ground<2>::Parts::cutBands();
template void           Ground<2>::Parts::followBands(bool);
template void           Ground<2>::Parts::chooseRows();
template void           Ground<2>::Parts::meetRanks();
template void           Ground<2>::Parts::keepOwnPart();
template void           Ground<2>::Parts::sortInBands();
template void           Ground<2>::Parts::bringPoints() const;
template void           Ground<2>::Parts::keepOwnPoints() const;
template void           Ground<2>::Parts::writeOwnPoints(const FilePlace&, PartSum&) const;
template StableTimeStep Ground<2>::Parts::limitsOfRanks() const;
template void           Ground<3>::distribute(std::shared_ptr<RankTalk>, bool);
template bool           Ground<3>::inBands() const;
template void           Ground<3>::Parts::startBands();
template void           Ground<3>::Parts::cutBands();
template void           Ground<3>::Parts::followBands(bool);
template void           Ground<3>::Parts::chooseRows();
template void           Ground<3>::Parts::meetRanks();
template void           Ground<3>::Parts::keepOwnPart();
template void           Ground<3>::Parts::sortInBands();
template void           Ground<3>::Parts::bringPoints() const;
template void           Ground<3>::Parts::keepOwnPoints() const;
template void           Ground<3>::Parts::writeOwnPoints(const FilePlace&, PartSum&) const;
template StableTimeStep Ground<3>::Parts::limitsOfRanks() const;

} // namespace talik
