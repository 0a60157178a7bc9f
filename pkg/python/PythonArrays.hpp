// SPDX-License-Identifier: GPL-2.0-or-later
#pragma once
#include <algorithm>
#include <boost/python/numpy.hpp>
#include <cmath>
#include <stdexcept>
#include <string>
#include <vector>

// NumPy arrays that functions of Python get and give. All of it under Python's lock.

namespace talik {

inline ::boost::python::numpy::ndarray zeros(const ::boost::python::tuple& shape)
{
	return ::boost::python::numpy::zeros(shape, ::boost::python::numpy::dtype::get_builtin<double>());
}

inline double* numbersOf(const ::boost::python::numpy::ndarray& array) { return reinterpret_cast<double*>(array.get_data()); }

inline std::string textOfShape(const ::boost::python::tuple& shape) { return ::boost::python::extract<std::string>(::boost::python::str(shape)); }

/// What a function gave, as contiguous numbers of this shape. Throws std::domain_error, in words that follow the name of the function.
inline ::boost::python::numpy::ndarray numbersOfShape(const ::boost::python::object& given, const std::string& what, const ::boost::python::tuple& shape)
{
	namespace py            = ::boost::python;
	const py::object  numpy = py::import("numpy"), array = numpy.attr("asarray")(given);
	const std::string kind = py::extract<std::string>(array.attr("dtype").attr("kind"));
	if (kind.find_first_of("fiub") == std::string::npos)
		throw std::domain_error(
		        "gave a " + what + " of type " + std::string(py::extract<std::string>(given.attr("__class__").attr("__name__")))
		        + ", not an array of numbers");
	const py::tuple found(array.attr("shape"));
	if (found != shape) throw std::domain_error("gave a " + what + " of shape " + textOfShape(found) + ", not " + textOfShape(shape));
	return py::extract<py::numpy::ndarray>(numpy.attr("ascontiguousarray")(array, "float64"))();
}

/// Row of the first number that is not finite, or -1.
inline long rowNotFinite(const ::boost::python::numpy::ndarray& array)
{
	const long          rows = array.shape(0), width = array.get_nd() > 1 ? array.shape(1) : 1;
	const double* const first = numbersOf(array);
	const double* const bad   = std::find_if(first, first + rows * width, [](double x) { return !std::isfinite(x); });
	return bad == first + rows * width ? -1 : (bad - first) / width;
}

} // namespace talik
