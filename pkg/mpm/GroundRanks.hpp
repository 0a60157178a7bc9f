// SPDX-License-Identifier: GPL-2.0-or-later
#pragma once

#include <pkg/mpm/grid/Grid.hpp>
#include <pkg/mpm/points/ActiveRange.hpp>
#include <pkg/mpm/points/MaterialPoints.hpp>

#include <functional>
#include <memory>
#include <string>
#include <vector>

namespace talik {

/// The ranks that divide a ground, and the part of it that is this rank's: rows of nodes and cells, and points. Where there is one rank, all is.
template <int D> class GroundRanks {
public:
	/// Before the ground is initialised. required: it is an error if the ranks cannot divide this ground; else each of them computes all of it.
	void distribute(std::shared_ptr<Communicator> communicator, bool required);
	/// There are ranks that want to divide the ground.
	bool wanted() const { return communicator_ != nullptr; }
	/// Once it is known which points each strip has. refusal: why this scene is not divided; empty: it is. limits: what this rank says when
	/// another one asks for time step limits. Collective. Throws std::invalid_argument.
	void start(const Grid<D>& grid, MaterialPoints<D>& points, const std::string& refusal, std::function<std::string()> limits);

	/// The ground is divided.
	explicit operator bool() const { return slabs_ != nullptr; }
	/// Null where it is not.
	SlabDecomposition* slabs() const { return slabs_.get(); }
	/// Rows of nodes and cells that the points of this rank may touch.
	const ActiveRange& owned() const { return owned_; }
	/// The same and as many more as it has to know to solve there.
	const ActiveRange& halo() const { return halo_; }

	/// After the points were sorted.
	void cut();
	/// The rows of this rank among those of the whole ground.
	void chooseRows(const ActiveRange& all);
	/// At the beginning of a step: waits for the other ranks; collective.
	void meet(long step);
	/// The points of other ranks take no memory from now on.
	void keepOwnPoints() const;
	/// All points become current here; the other ranks help when they come to their next step.
	void bringPoints() const;
	/// The points may be other ones than those that this rank had.
	void readAgain();
	/// Numbers by place become known to all ranks, for sums in the order of one; until keepOwnPoints(). Arrays may be null.
	template <class... Arrays> void showAll(Arrays*... arrays) const
	{
		if (slabs_) (void)std::initializer_list<int> { (arrays ? slabs_->shareByPoint(arrays) : void(), 0)... };
	}
	/// What the ranks say of their time step limits, by rank.
	std::vector<std::string> askLimits() const;
	/// Writes the points of this rank, array by array, each at its place among all.
	void writeOwnPoints(const FilePlace& place, PartSum& sum) const;

private:
	std::string refusalOfSize() const;
	std::string answer(const std::string& question, const std::function<std::string()>& limits) const;
	std::string ownPoints() const;
	void        takePoints(const std::vector<std::string>& byRank) const;
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
