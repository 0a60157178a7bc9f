// SPDX-License-Identifier: GPL-2.0-or-later
#pragma once

#include <pkg/base/ThreadPool.hpp>
#include <pkg/mpm/grid/Grid.hpp>
#include <pkg/mpm/points/PointFields.hpp>
#include <pkg/mpm/points/SlabDecomposition.hpp>
#include <string>

#include <array>
#include <cstdint>
#include <functional>
#include <vector>

namespace talik {

/// The points cut into strips of whole cell rows along the grid's slowest axis. Points of a strip write only to nodes of its own
/// rows and a margin, so that all even strips may run at the same time, then all odd ones; each sum then has one order,
/// whatever the number of threads. The height of a strip is fixed.
struct Strips {
	/// With four rows, quadratic support (one node behind, two ahead of the cell) and points strayed by up to half a cell,
	/// strips of one parity share no node.
	static constexpr int    rows  = 4;
	static constexpr double stray = 0.5; ///< how far points may leave their strip before they are sorted anew [cells]

	int              axis     = 0;
	bool             parallel = true; ///< false: one thread does all, which is faster for few points
	std::vector<int> first;           ///< place of the first point of each strip; one more entry for the end

	SlabDecomposition*            slabs  = nullptr; ///< strips are shared out among ranks: loops are over those of this one
	const std::vector<NodeImage>* images = nullptr; ///< nodes that periodic sides repeat; null: there are none

	int count() const { return int(first.size()) - 1; }
	/// Strips of this rank, and their points.
	int begin() const { return slabs ? slabs->firstStrip() : 0; }
	int end() const { return slabs ? slabs->endStrip() : count(); }
	int firstPoint() const { return first[begin()]; }
	int endPoint() const { return first[end()]; }

	/// work(strip, firstPoint, lastPoint) for all strips, never two neighbours at the same time. share(rows): names the arrays to which work
	/// adds, where there are several ranks.
	template <class Work, class Share> void scatter(Work&& work, Share&& share) const
	{
		if (slabs) share(slabs->shared());
		alternate(begin() + begin() % 2, work);
		if (slabs) slabs->handOver();
		alternate(begin() + 1 - begin() % 2, work);
		if (slabs) slabs->complete();
		if (!images) return;
		HaloExchange repeated;
		share(repeated);
		repeated.fold(*images);
	}

	/// work(strip, firstPoint, lastPoint) for all strips at once: for loops that write to their own points only.
	template <class Work> void gather(Work&& work) const
	{
		const int from = begin();
		ThreadPool::run(end() - from, threads(), [&](int s, int) { work(from + s, first[from + s], first[from + s + 1]); });
	}

private:
	/// Every other strip.
	template <class Work> void alternate(int from, Work&& work) const
	{
		ThreadPool::run((end() - from + 1) / 2, threads(), [&](int k, int) {
			const int s = from + 2 * k;
			work(s, first[s], first[s + 1]);
		});
	}
	int threads() const { return parallel ? ThreadPool::threads() : 1; }
};

/// A point that becomes two, at a distance on both sides of where it was, along an axis.
struct PointDivision {
	int    place, axis;
	double distance; ///< [m]
};

/// The material points: contiguous arrays, one per component, sorted so that neighbours in space are neighbours in
/// memory. A point's place in the arrays changes when points are sorted; its id does not.
template <int D> class MaterialPoints {
public:
	/// Fields that any ground has: "position" [m], "volume" [m^D].
	MaterialPoints();

	PointFields&       fields() { return fields_; }
	const PointFields& fields() const { return fields_; }

	int count() const { return fields_.count(); }
	/// Allocates all declared fields for count points with ids 0 .. count-1; see PointFields.
	void allocate(int count, int capacity = 0);
	/// Places that arrays by place have.
	int capacity() const { return fields_.capacity(); }

	/// Makes two of each of these points, in the order of places; in slabs each rank says those of its slab. Both halves have all that the point had, and
	/// half of its mass, volume and energy. The second has a new id: count() on, in the order of places. Returns the former ids of all, in the
	/// order of the new ones; unless there are none, the points are to be sorted next. Collective.
	std::vector<int> divide(const std::vector<PointDivision>& own);
	/// So many points; what they are is restored next.
	void resize(int count);

	const int* ids() const { return id_.data(); } ///< id of the point at a place
	int        id(int place) const { return id_[place]; }
	int        place(int id) const { return place_[id]; } ///< where the point with this id is now

	double*       position(int axis) { return fields_.component(position_, axis); }
	const double* position(int axis) const { return fields_.component(position_, axis); }
	/// position() of all axes.
	std::array<const double*, D> positions() const
	{
		std::array<const double*, D> x;
		for (int a = 0; a < D; ++a)
			x[a] = position(a);
		return x;
	}
	/// Where the point at a place is [m].
	Vec<D> at(int place) const
	{
		Vec<D> x;
		for (int a = 0; a < D; ++a)
			x[a] = position(a)[place];
		return x;
	}
	double*       volume() { return fields_.component(volume_); }
	const double* volume() const { return fields_.component(volume_); }

	/// Skeleton model of the point at a place.
	int*       skeletons() { return skeleton_.data(); }
	const int* skeletons() const { return skeleton_.data(); }

	/// Material of the point at a place; null in ground of one material.
	std::uint16_t*       materials() { return material_.empty() ? nullptr : material_.data(); }
	const std::uint16_t* materials() const { return material_.empty() ? nullptr : material_.data(); }
	int                  material(int place) const { return material_.empty() ? 0 : material_[place]; }
	/// Gives points materials, 0 so far; after allocate().
	void distinguishMaterials();

	/// Points first .. last that have left through a periodic side come in at the other one.
	void wrap(const Grid<D>& grid, int first, int last);
	/// Before the first sorting: gives the points, of which only this is known, the places that sort() would give them, and cuts them into strips.
	void arrange(const Grid<D>& grid, const std::function<Vec<D>(int id)>& at);
	/// Sorts the points (stable) and cuts them into strips. In the plane the points of a cell follow each other, in space those with the
	/// same support.
	void sort(const Grid<D>& grid);
	/// The same for the points of all ranks, each of which has those of its slab; cost: of each since the last cut, by place, or null for the cost
	/// that is known. cut() takes the new strips. Points whose strip belongs to another rank then go there with all that they have. Collective.
	void sortInSlabs(const Grid<D>& grid, SlabDecomposition& slabs, const double* cost, const std::function<void()>& cut);
	/// How often the points were sorted: caches of places are valid as long as it stands.
	long order() const { return order_; }

	const Strips& strips() const { return strips_; }
	Strips&       strips() { return strips_; }

	std::vector<int>& idArray() { return id_; }
	void              idsRestored();

private:
	PointFields                fields_;
	PointFields::Handle        position_, volume_;
	std::vector<int>           id_, place_, skeleton_;
	std::vector<int>           number_, from_, start_, scratch_;
	void                       reorder(int at);
	void                       findOrder(int firstNumber, int endNumber);
	template <class At> void   findStrips(const Grid<D>& grid, At&& at);
	std::vector<std::uint16_t> material_, materialScratch_; ///< empty in ground of one material
	Strips                     strips_;
	long                       order_ = 0;
};

} // namespace talik
