// SPDX-License-Identifier: GPL-2.0-or-later
#pragma once
#include <lib/base/Math.hpp>
#include <lib/serialization/Serializable.hpp>
#include <pkg/mpm/grid/Vector.hpp>

#include <string>

namespace talik {

/// A vector of a ground in the plane or in space, as an attribute: the two or three components that a script gave. A script reads it as
/// the Vector2 or Vector3 inside, so that a component can be assigned.
class GroundVector {
public:
	/// Not given: this value in each direction, whatever the dimension.
	GroundVector(double everywhere);
	explicit GroundVector(const yade::Vector2r& plane);
	explicit GroundVector(const yade::Vector3r& space);

	bool        isGiven() const;
	int         components() const { return inSpace_ ? 3 : 2; }
	double      operator[](int axis) const { return inSpace_ ? space_[axis] : plane_[axis]; }
	std::string text() const; ///< "(1, 2)"

	/// The vector in D dimensions. Throws std::invalid_argument naming the attribute if the script gave another number of components.
	template <int D> Vec<D> in(const std::string& attribute) const;

	/// The vector inside, as a Python object that keeps its owner alive.
	::boost::python::object inside(const ::boost::python::object& owner);
	/// Conversion from and to Python.
	static void registerOnce();

	template <class Archive> void serialize(Archive& ar, unsigned)
	{
		ar& boost::serialization::make_nvp("inSpace", inSpace_);
		ar& boost::serialization::make_nvp("given", given_);
		scripting::archiveAttribute(ar, "plane", plane_);
		scripting::archiveAttribute(ar, "space", space_);
	}

private:
	bool           inSpace_ = false, given_ = false;
	yade::Vector2r plane_;
	yade::Vector3r space_; ///< of a vector that was not given each component has the value in each direction
};

namespace scripting {
	template <class Class> struct Getter<Class, GroundVector> {
		struct Inside {
			GroundVector Class::*member;
			py::object           operator()(const py::object& self) const { return (py::extract<Class&>(self)().*member).inside(self); }
		};
		static py::object make(GroundVector Class::*member)
		{
			return py::make_function(Inside { member }, py::default_call_policies(), boost::mpl::vector2<py::object, const py::object&>());
		}
	};
} // namespace scripting
} // namespace talik

namespace yade {
using talik::GroundVector;
}

BOOST_CLASS_IMPLEMENTATION(talik::GroundVector, boost::serialization::object_serializable)
BOOST_CLASS_TRACKING(talik::GroundVector, boost::serialization::track_never)
