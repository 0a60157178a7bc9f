// SPDX-License-Identifier: GPL-2.0-or-later
#pragma once

#include <pkg/mpm/grid/Grid.hpp>
#include <pkg/mpm/points/ActiveRange.hpp>
#include <pkg/mpm/points/MaterialPoints.hpp>

#include <algorithm>
#include <cstring>
#include <functional>
#include <memory>
#include <stdexcept>
#include <string>
#include <vector>

namespace talik {

/// The ranks that divide a ground, and the part of it that is this rank's: rows of nodes and cells, and points. Where there is one rank, all is.
template <int D> class GroundRanks {
public:
	/// Before the ground is initialised. required: it is an error if the ranks cannot divide this ground; else each of them computes all of it.
	void distribute(std::shared_ptr<Communicator> communicator, bool required)
	{
		communicator_ = std::move(communicator);
		required_     = required;
	}
	/// There are ranks that want to divide the ground.
	bool wanted() const { return communicator_ != nullptr; }
	/// Once it is known which points each strip has. refusal: why this scene is not divided; empty: it is. limits: what this rank says when
	/// another one asks for time step limits. Collective. Throws std::invalid_argument.
	void start(const Grid<D>& grid, MaterialPoints<D>& points, const std::string& refusal, std::function<std::string()> limits)
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

	/// The ground is divided.
	explicit operator bool() const { return slabs_ != nullptr; }
	/// Null where it is not.
	SlabDecomposition* slabs() const { return slabs_.get(); }
	/// Rows of nodes and cells that the points of this rank may touch.
	const ActiveRange& owned() const { return owned_; }
	/// The same and as many more as it has to know to solve there.
	const ActiveRange& halo() const { return halo_; }

	/// After the points were sorted.
	void cut()
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
	/// The rows of this rank among those of the whole ground.
	void chooseRows(const ActiveRange& all)
	{
		owned_ = halo_ = all;
		if (!slabs_) return;
		const auto limit = [&](ActiveRange& range, const SlabDecomposition::Part& part) {
			const int axis = points_->strips().axis, nodes = grid_->nodeStride(axis), cells = grid_->cellStride(axis);
			range.firstNode = std::max(range.firstNode, part.firstNode * nodes);
			range.lastNode  = std::max(
			         range.firstNode, std::min(range.lastNode, part.endNode * nodes)); // none in strips of the box that have no ground
			range.firstCell = std::max(range.firstCell, part.firstCell * cells);
			range.lastCell  = std::max(range.firstCell, std::min(range.lastCell, part.endCell * cells));
		};
		limit(owned_, slabs_->touched(false));
		limit(halo_, slabs_->touched(true));
	}
	/// At the beginning of a step: waits for the other ranks; collective.
	void meet(long step)
	{
		slabs_->meet(step);
		if (!slabs_->allCurrent) return;
		slabs_->allCurrent = false;
		keepOwnPoints();
	}
	/// The points of other ranks take no memory from now on.
	void keepOwnPoints() const { points_->fields().keepOnly(slabs_->firstPoint(), slabs_->endPoint()); }
	/// All points become current here; the other ranks help when they come to their next step.
	void bringPoints() const
	{
		if (!slabs_ || slabs_->allCurrent) return;
		takePoints(slabs_->ask(pointsOfSlabs));
		slabs_->allCurrent = true;
	}
	/// The points may be other ones than those that this rank had.
	void readAgain()
	{
		slabs_->weigh({});
		cut();
		slabs_->allCurrent = false;
		keepOwnPoints();
	}
	/// Numbers by place become known to all ranks, for sums in the order of one; until keepOwnPoints(). Arrays may be null.
	template <class... Arrays> void showAll(Arrays*... arrays) const
	{
		if (slabs_) (void)std::initializer_list<int> { (arrays ? slabs_->shareByPoint(arrays) : void(), 0)... };
	}
	/// What the ranks say of their time step limits, by rank.
	std::vector<std::string> askLimits() const { return slabs_->ask(timeStepLimits); }
	/// Writes the points of this rank, array by array, each at its place among all.
	void writeOwnPoints(const FilePlace& place, PartSum& sum) const
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

private:
	static constexpr const char *pointsOfSlabs = "points of the slabs", *timeStepLimits = "time step limits";

	std::string refusalOfSize() const
	{
		const int strips = points_->strips().count(), least = SlabDecomposition::leastStrips;
		if (strips >= least * communicator_->count()) return "";
		return "the grid has " + std::to_string(strips) + " strips of " + std::to_string(Strips::rows) + " rows of cells, and each of "
		        + std::to_string(communicator_->count()) + " ranks needs " + std::to_string(least) + ": choose 'none', or run it on fewer ranks.";
	}
	std::string answer(const std::string& question, const std::function<std::string()>& limits) const
	{
		return question == pointsOfSlabs ? ownPoints() : limits();
	}
	std::string ownPoints() const
	{
		const int   first = slabs_->firstPoint(), count = slabs_->endPoint() - first;
		std::string bytes;
		overArrays([&](double* values) { bytes.append(reinterpret_cast<const char*>(values + first), count * sizeof(double)); });
		return bytes;
	}
	void takePoints(const std::vector<std::string>& byRank) const
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
	/// All numbers of the points, array by array.
	template <class Work> void overArrays(Work&& work) const
	{
		PointFields& f = points_->fields();
		for (std::size_t k = 0; k < f.list().size(); ++k)
			for (int c = 0; c < f.list()[k].components; ++c)
				work(f.component(int(k), c));
	}

	std::shared_ptr<Communicator>      communicator_; ///< null: there is one rank
	bool                               required_ = true;
	std::unique_ptr<SlabDecomposition> slabs_; ///< from start() on
	const Grid<D>*                     grid_   = nullptr;
	MaterialPoints<D>*                 points_ = nullptr;
	ActiveRange                        owned_, halo_;
};

} // namespace talik
