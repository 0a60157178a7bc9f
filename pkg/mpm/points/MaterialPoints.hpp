// SPDX-License-Identifier: GPL-2.0-or-later
#pragma once

#include <pkg/mpm/grid/Grid.hpp>
#include <pkg/mpm/points/PointFields.hpp>
#include <pkg/mpm/grid/Strips.hpp>

#include <cstdint>
#include <vector>

namespace talik {

/// The material points: contiguous arrays, one per component, sorted by grid cell so that neighbours in space are neighbours in
/// memory. A point's place in the arrays changes when points are sorted; its id does not.
template <int D> class MaterialPoints {
public:
	/// Fields that any ground has: "position" [m], "volume" [m^D].
	MaterialPoints();

	PointFields&       fields() { return fields_; }
	const PointFields& fields() const { return fields_; }

	int count() const { return fields_.count(); }
	/// Allocates all declared fields for count points with ids 0 .. count-1.
	void allocate(int count);

	const int* ids() const { return id_.data(); }        ///< id of the point at a place
	int        id(int place) const { return id_[place]; }
	int        place(int id) const { return place_[id]; } ///< where the point with this id is now

	double*       position(int axis) { return fields_.component(position_, axis); }
	const double* position(int axis) const { return fields_.component(position_, axis); }
	double*       volume() { return fields_.component(volume_); }
	const double* volume() const { return fields_.component(volume_); }

	/// Skeleton model of the point at a place.
	int*       skeletons() { return skeleton_.data(); }
	const int* skeletons() const { return skeleton_.data(); }

	/// Sorts by cell (stable) and cuts the points into strips.
	void sort(const Grid<D>& grid);
	/// How often the points were sorted: caches of places are valid as long as it stands.
	long order() const { return order_; }

	const Strips& strips() const { return strips_; }
	Strips&       strips() { return strips_; }

	std::vector<int>&       idArray() { return id_; }
	void                    idsRestored();

private:
	PointFields         fields_;
	PointFields::Handle position_, volume_;
	std::vector<int>    id_, place_, skeleton_;
	std::vector<int>    cell_, from_, cellStart_, scratch_;
	Strips              strips_;
	long                order_ = 0;
};

extern template class MaterialPoints<2>;
extern template class MaterialPoints<3>;

} // namespace talik
