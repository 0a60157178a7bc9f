// SPDX-License-Identifier: GPL-2.0-or-later
#include <pkg/mpm/GroundRanks.hpp>

#include <algorithm>
#include <cstring>
#include <stdexcept>

namespace talik {

namespace {
	const std::string pointsOfBands = "points of the bands", timeStepLimits = "time step limits";
} // namespace

template <int D> void GroundRanks<D>::distribute(std::shared_ptr<RankTalk> talk, bool required)
{
	talk_     = std::move(talk);
	required_ = required;
}

template <int D> std::string GroundRanks<D>::refusalOfSize() const
{
	const int strips = points_->strips().count(), least = Bands::leastStrips;
	if (strips >= least * talk_->count()) return "";
	return "the grid has " + std::to_string(strips) + " strips of " + std::to_string(Strips::rows) + " rows of cells, and each of "
	        + std::to_string(talk_->count()) + " ranks needs " + std::to_string(least) + ": choose 'samples', or run it on fewer ranks.";
}

template <int D> void GroundRanks<D>::start(const Grid<D>& grid, MaterialPoints<D>& points, const std::string& refusal, std::function<std::string()> limits)
{
	grid_   = &grid;
	points_ = &points;
	if (!talk_) return;
	const std::string why = refusal.empty() ? refusalOfSize() : refusal;
	if (!why.empty()) {
		if (required_) throw std::invalid_argument("distribute is 'ground': " + why);
		return;
	}
	bands_         = std::make_unique<Bands>(talk_, [this, limits = std::move(limits)](const std::string& question) { return answer(question, limits); });
	bands_->writes = [this](const FilePlace& place, PartSum& sum) { writeOwnPoints(place, sum); };
	points.strips().bands = bands_.get();
	bands_->allCurrent    = false;
	talk_->meet("the beginning of a ground in bands");
	cut();
}

template <int D> void GroundRanks<D>::cut()
{
	const Strips& strips = points_->strips();
	const int     axis   = strips.axis;
	Bands::Rows   rows;
	rows.ofStrip    = Strips::rows;
	rows.nodes      = grid_->nodes(axis);
	rows.cells      = grid_->cells(axis);
	rows.nodesOfRow = grid_->nodeStride(axis);
	rows.cellsOfRow = grid_->cellStride(axis);
	bands_->cut(strips.first, rows);
}

template <int D> void GroundRanks<D>::chooseRows(const ActiveRange& all)
{
	owned_ = halo_ = all;
	if (!bands_) return;
	const auto limit = [&](ActiveRange& range, const Bands::Part& part) {
		const int axis = points_->strips().axis, nodes = grid_->nodeStride(axis), cells = grid_->cellStride(axis);
		range.firstNode = std::max(range.firstNode, part.firstNode * nodes);
		range.lastNode  = std::max(range.firstNode, std::min(range.lastNode, part.endNode * nodes)); // none in strips of the box that have no ground
		range.firstCell = std::max(range.firstCell, part.firstCell * cells);
		range.lastCell  = std::max(range.firstCell, std::min(range.lastCell, part.endCell * cells));
	};
	limit(owned_, bands_->touched(false));
	limit(halo_, bands_->touched(true));
}

template <int D> void GroundRanks<D>::meet(long step)
{
	bands_->meet(step);
	if (!bands_->allCurrent) return;
	bands_->allCurrent = false;
	keepOwnPoints();
}

template <int D> void GroundRanks<D>::keepOwnPoints() const { points_->fields().keepOnly(bands_->firstPoint(), bands_->endPoint()); }

template <int D> void GroundRanks<D>::readAgain()
{
	bands_->weigh({});
	cut();
	bands_->allCurrent = false;
	keepOwnPoints();
}

template <int D> void GroundRanks<D>::bringPoints() const
{
	if (!bands_ || bands_->allCurrent) return;
	takePoints(bands_->ask(pointsOfBands));
	bands_->allCurrent = true;
}

template <int D> std::string GroundRanks<D>::ownPoints() const
{
	const int   first = bands_->firstPoint(), count = bands_->endPoint() - first;
	std::string bytes;
	overArrays([&](double* values) { bytes.append(reinterpret_cast<const char*>(values + first), count * sizeof(double)); });
	return bytes;
}

template <int D> void GroundRanks<D>::takePoints(const std::vector<std::string>& byRank) const
{
	for (int r = 0; r < bands_->count(); ++r) {
		const auto [first, end] = bands_->pointsOf(r);
		const std::size_t size  = (end - first) * sizeof(double);
		const char*       from  = byRank[r].data();
		overArrays([&, begin = first](double* values) {
			std::memcpy(values + begin, from, size);
			from += size;
		});
	}
}

template <int D> void GroundRanks<D>::writeOwnPoints(const FilePlace& place, PartSum& sum) const
{
	PartedFile        file(place.path, PartedFile::For::writing, place.end);
	PointFields&      f     = points_->fields();
	const std::size_t first = points_->strips().firstPoint(), end = points_->strips().endPoint();
	std::uint64_t     at = place.at + first * sizeof(double);
	for (std::size_t k = 0; k < f.list().size(); ++k)
		for (int c = 0; f.list()[k].persistent && c < f.list()[k].components; ++c) {
			file.write(f.component(int(k), c) + first, (end - first) * sizeof(double), at);
			at += f.count() * sizeof(double);
		}
	file.close();
	sum.add(file.sum().value());
}

template <int D> std::string GroundRanks<D>::answer(const std::string& question, const std::function<std::string()>& limits) const
{
	return question == pointsOfBands ? ownPoints() : limits();
}

template <int D> std::vector<std::string> GroundRanks<D>::askLimits() const { return bands_->ask(timeStepLimits); }

template class GroundRanks<2>;
template class GroundRanks<3>;

} // namespace talik
