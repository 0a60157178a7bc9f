// SPDX-License-Identifier: GPL-2.0-or-later
#pragma once
#include <boost/python.hpp>
#include <boost/serialization/level.hpp>
#include <boost/serialization/nvp.hpp>
#include <boost/serialization/tracking.hpp>
#include <memory>
#include <pkg/python/StepGate.hpp>
#include <string>

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

/// The error that Python has raised, in words on one line, "ValueError in soils.py, line 12: no cohesion"; it is cleared.
std::string takePythonError();

} // namespace talik

BOOST_CLASS_IMPLEMENTATION(talik::PythonFunction, boost::serialization::object_serializable)
BOOST_CLASS_TRACKING(talik::PythonFunction, boost::serialization::track_never)
