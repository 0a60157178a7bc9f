// SPDX-License-Identifier: GPL-2.0-or-later
#pragma once
#include <boost/python/numpy.hpp>
#include <cstdint>
#include <cstdlib>
#include <functional>
#include <lib/base/Math.hpp>
#include <lib/serialization/Serializable.hpp>
#include <pkg/mpm/GroundSettings.hpp>
#include <vector>

namespace talik {

/// Material points as a script added them, in the plane or in space, in columns: x y (z), volume, porosity, temperature, pressure, skeleton, stress,
/// velocity, poreFill; beside them the material. A column that is the same for all points is held once. Points that have divided in a run follow; they
/// have the numbers of those that they come of, but for the skeleton.
class PointTable {
	using Numbers = std::vector<double>;

public:
	int  dimension() const { return dimension_; } ///< 2 or 3; 0 without points
	int  count() const { return count_ + int(divisions_.size()); }
	int  given() const { return count_; } ///< by the script
	bool empty() const { return count_ == 0; }

	/// Adds points in columns, as talik._points makes them of the arguments of MpmEngine.addPoints.
	void add(int points, int dimension, const ::boost::python::object& arrays);

	template <int D> PointInput<D> point(int id) const;
	/// By their names, arrays with a row for each point.
	::boost::python::dict arrays() const;

	double position(int id, int axis) const { return number(0, id, axis); }
	double volume(int id) const { return number(1, id); }
	double porosity(int id) const { return number(2, id); }
	int    skeleton(int id) const { return int(number(ofSkeleton, id)); }
	int    material(int id) const { return materials_.empty() ? 0 : materials_[origin(id)]; }
	void   setSkeleton(int id, int number);

	/// See AnyGround::divisions().
	const std::vector<int>& divisions() const { return divisions_; }
	void                    follow(const std::vector<int>& divisions);

	/// Bit by bit, but for numbers that are none: archives of text keep only that.
	std::uint64_t digest() const;

	template <class Archive> void serialize(Archive& ar, unsigned)
	{
		ar& boost::serialization::make_nvp("dimension", dimension_);
		ar& boost::serialization::make_nvp("count", count_);
		ar& boost::serialization::make_nvp("columns", columns_);
		ar& boost::serialization::make_nvp("materials", materials_);
		ar& boost::serialization::make_nvp("divisions", divisions_);
	}

private:
	static constexpr int ofSkeleton = 5;

	/// The point of the script that a point is a part of.
	int origin(int id) const
	{
		while (id >= count_)
			id = divisions_[id - count_];
		return id;
	}
	std::size_t width(std::size_t column) const;
	double      number(std::size_t column, int id, int component = 0) const
	{
		const Numbers& numbers = columns_[column];
		const int      row     = column == ofSkeleton ? id : origin(id);
		return numbers[(numbers.size() == width(column) ? 0 : std::size_t(row) * width(column)) + std::size_t(component)];
	}
	void expand(std::size_t column);
	void append(std::size_t column, const Numbers& more, int points);

	int                  dimension_ = 0, count_ = 0;
	std::vector<Numbers> columns_;
	std::vector<int>     materials_; ///< empty: all have material 0
	std::vector<int>     divisions_;
};

} // namespace talik

BOOST_CLASS_IMPLEMENTATION(talik::PointTable, boost::serialization::object_serializable)
BOOST_CLASS_TRACKING(talik::PointTable, boost::serialization::track_never)

namespace yade {

/// Histories of a few material points: rows of numbers, one per watched point and instant.
class PointWatch : public Serializable {
public:
	/// Numbers of a field at a point, by id.
	using Look = std::function<vector<Real>(const string& field, int id)>;

	bool isDue(Real time) const { return times.empty() || (time > times.back() && time >= next); }
	void record(Real time, const Look&);
	/// Dictionary of NumPy arrays by instant: time and the fields of one watched point. Throws std::invalid_argument for others.
	::boost::python::dict history(int id) const;

	// clang-format off
	YADE_CLASS_BASE_DOC_ATTRS(PointWatch,Serializable,"What MpmEngine.watch() records of a few material points; see MpmEngine.history(). Example: "
			"mpm.watch([0],interval=0.01); mpm.history(0)['time'].",
		((vector<int>,ids,,Attr::readonly,"Watched points."))
		((Real,interval,0,Attr::readonly,"Time between two records [s]; 0: every step."))
		((vector<string>,fields,,Attr::readonly,"Recorded fields."))
		((vector<Real>,times,,Attr::readonly,"Instants of the records [s]."))
		((Real,next,0,Attr::hidden,"Earliest instant of the next record [s]."))
		((vector<int>,components,,Attr::hidden,"Numbers of each field."))
		((vector<Real>,rows,,Attr::hidden,"The records: by instant, watched point, field, component."))
	);
	// clang-format on
};
REGISTER_SERIALIZABLE(PointWatch);

} // namespace yade
