// SPDX-License-Identifier: GPL-2.0-or-later
#pragma once
#include <algorithm>
#include <boost/python.hpp>
#include <boost/python/numpy.hpp>
#include <boost/serialization/level.hpp>
#include <boost/serialization/nvp.hpp>
#include <boost/serialization/tracking.hpp>
#include <cmath>
#include <memory>
#include <pkg/python/StepGate.hpp>
#include <stdexcept>
#include <string>
#include <vector>

namespace talik {

/// An object whose end takes Python's lock: for what holds Python's objects and may be let go of by any thread.
template <class T> std::shared_ptr<T> endingUnderLock(T* object)
{
	return std::shared_ptr<T>(object, [](T* last) {
		if (!Py_IsInitialized()) return; // the process ends, and its objects with it
		const PythonLock held;
		delete last;
	});
}

/// A function or callable object of a script, as an attribute: given as itself or as "module:name". An archive holds the name.
class PythonFunction {
public:
	PythonFunction() = default;
	explicit PythonFunction(const ::boost::python::object& given);

	bool isGiven() const { return object_ || !name_.empty(); }
	/// What a script reads: the function, its name if it was not looked up yet, or None.
	::boost::python::object forScript() const;
	/// The function; a name is imported. Call under Python's lock. Throws std::invalid_argument, naming the attribute.
	::boost::python::object find(const std::string& attribute) const;
	/// The same for a run, to be let go of by any thread. Says once if no checkpoint will give it back.
	std::shared_ptr<::boost::python::object> forRun(const std::string& attribute) const;
	/// "module:name", as sentences name it.
	std::string name() const;

	/// Conversion from and to Python.
	static void registerOnce();

	template <class Archive> void serialize(Archive& ar, unsigned)
	{
		std::string text;
		if (Archive::is_saving::value) text = archivedName();
		ar& boost::serialization::make_nvp("name", text);
		if (!Archive::is_loading::value) return;
		name_ = text;
		object_.reset();
	}

private:
	/// Before the name of a function in an archive that no import gives back.
	static constexpr char notImportable = '!';
	std::string           archivedName() const;

	std::string                              name_;
	std::shared_ptr<::boost::python::object> object_;
	mutable bool                             warned_ = false;
};

// NumPy arrays that functions of Python get and give. All of it under Python's lock.

inline ::boost::python::numpy::ndarray zeros(const ::boost::python::tuple& shape)
{
	return ::boost::python::numpy::zeros(shape, ::boost::python::numpy::dtype::get_builtin<double>());
}

inline double* numbersOf(const ::boost::python::numpy::ndarray& array) { return reinterpret_cast<double*>(array.get_data()); }

/// Array (rows,) of get(row, 0), or (rows, columns) of get(row, column).
template <class Get>::boost::python::numpy::ndarray tableOf(std::size_t rows, std::size_t columns, Get&& get)
{
	const auto table = zeros(columns == 1 ? ::boost::python::make_tuple(rows) : ::boost::python::make_tuple(rows, columns));
	for (std::size_t k = 0; k < rows * columns; ++k)
		numbersOf(table)[k] = get(k / columns, k % columns);
	return table;
}

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

/// The error that Python has raised, in words on one line, "ValueError in soils.py, line 12: no cohesion"; it is cleared.
std::string takePythonError();

/// A function of Python's; std::runtime_error with what it raises. The caller holds Python's lock.
template <class... Arguments>::boost::python::object callPython(const char* module, const char* function, const Arguments&... arguments)
{
	try {
		return ::boost::python::import(module).attr(function)(arguments...);
	} catch (const ::boost::python::error_already_set&) {
		throw std::runtime_error(std::string(module) + ": " + takePythonError());
	}
}

} // namespace talik

BOOST_CLASS_IMPLEMENTATION(talik::PythonFunction, boost::serialization::object_serializable)
BOOST_CLASS_TRACKING(talik::PythonFunction, boost::serialization::track_never)
