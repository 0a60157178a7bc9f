// SPDX-License-Identifier: GPL-2.0-or-later
#include <pkg/mpm/GroundRanks.hpp>

#include <algorithm>
#include <cstring>
#include <stdexcept>

namespace talik {

namespace {
	const std::string pointsOfSlabs = "points of the slabs", timeStepLimits = "time step limits";
} // namespace

template <int D> void GroundRanks<D>::distribute(std::shared_ptr<Communicator> communicator, bool required)
{
	communicator_ = std::move(communicator);
	required_     = required;
}

template <int D> std::string GroundRanks<D>::refusalOfSize() const
{
	const int strips = points_->strips().count(), least = SlabDecomposition::leastStrips;
	if (strips >= least * communicator_->count()) return "";
	return "the grid has " + std::to_string(strips) + " strips of " + std::to_string(Strips::rows) + " rows of cells, and each of "
	        + std::to_string(communicator_->count()) + " ranks needs " + std::to_string(least) + ": choose 'none', or run it on fewer ranks.";
}

template <int D> void GroundRanks<D>::start(const Grid<D>& grid, MaterialPoints<D>& points, const std::string& refusal, std::function<std::string()> limits)
{
	grid_   = &grid;
	points_ = &points;
	if (!communicator_) return;
	const std::string why = refusal.empty() ? refusalOfSize() : refusal;
	if (!why.empty()) {
		if (required_) throw std::invalid_argument("distribute is 'ground': " + why);
		return;
	}
	slabs_ = std::make_unique<SlabDecomposition>(
	        communicator_, [this, limits = std::move(limits)](const std::string& question) { return answer(question, limits); });
	slabs_->writes        = [this](const FilePlace& place, PartSum& sum) { writeOwnPoints(place, sum); };
	points.strips().slabs = slabs_.get();
	slabs_->allCurrent    = false;
	communicator_->meet("the beginning of a ground in slabs");
	cut();
}

template <int D> void GroundRanks<D>::cut()
{
	const Strips&           strips = points_->strips();
	const int               axis   = strips.axis;
	SlabDecomposition::Rows rows;
	rows.ofStrip    = Strips::rows;
	rows.nodes      = grid_->nodes(axis);
	rows.cells      = grid_->cells(axis);
	rows.nodesOfRow = grid_->nodeStride(axis);
	rows.cellsOfRow = grid_->cellStride(axis);
	slabs_->cut(strips.first, rows);
}

template <int D> void GroundRanks<D>::chooseRows(const ActiveRange& all)
{
	owned_ = halo_ = all;
	if (!slabs_) return;
	const auto limit = [&](ActiveRange& range, const SlabDecomposition::Part& part) {
		const int axis = points_->strips().axis, nodes = grid_->nodeStride(axis), cells = grid_->cellStride(axis);
		range.firstNode = std::max(range.firstNode, part.firstNode * nodes);
		range.lastNode  = std::max(range.firstNode, std::min(range.lastNode, part.endNode * nodes)); // none in strips of the box that have no ground
		range.firstCell = std::max(range.firstCell, part.firstCell * cells);
		range.lastCell  = std::max(range.firstCell, std::min(range.lastCell, part.endCell * cells));
	};
	limit(owned_, slabs_->touched(false));
	limit(halo_, slabs_->touched(true));
}

template <int D> void GroundRanks<D>::meet(long step)
{
	slabs_->meet(step);
	if (!slabs_->allCurrent) return;
	slabs_->allCurrent = false;
	keepOwnPoints();
}

template <int D> void GroundRanks<D>::keepOwnPoints() const { points_->fields().keepOnly(slabs_->firstPoint(), slabs_->endPoint()); }

template <int D> void GroundRanks<D>::readAgain()
{
	slabs_->weigh({});
	cut();
	slabs_->allCurrent = false;
	keepOwnPoints();
}

template <int D> void GroundRanks<D>::bringPoints() const
{
	if (!slabs_ || slabs_->allCurrent) return;
	takePoints(slabs_->ask(pointsOfSlabs));
	slabs_->allCurrent = true;
}

template <int D> std::string GroundRanks<D>::ownPoints() const
{
	const int   first = slabs_->firstPoint(), count = slabs_->endPoint() - first;
	std::string bytes;
	overArrays([&](double* values) { bytes.append(reinterpret_cast<const char*>(values + first), count * sizeof(double)); });
	return bytes;
}

template <int D> void GroundRanks<D>::takePoints(const std::vector<std::string>& byRank) const
{
	for (int r = 0; r < slabs_->count(); ++r) {
		const auto [first, end] = slabs_->pointsOf(r);
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
	return question == pointsOfSlabs ? ownPoints() : limits();
}

template <int D> std::vector<std::string> GroundRanks<D>::askLimits() const { return slabs_->ask(timeStepLimits); }

TALIK_IN_PLANE_AND_SPACE(GroundRanks);

} // namespace talik
