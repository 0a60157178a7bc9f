// SPDX-License-Identifier: GPL-2.0-or-later
#pragma once
#include <boost/python.hpp>
#include <boost/shared_ptr.hpp>
#include <pkg/python/StepGate.hpp>
#include <stdexcept>

namespace talik {

/// Deleter of a pointer that a script gave: the pointer holds the object of Python, and whatever thread drops the last copy lets go of
/// that under Python's lock.
struct HeldObject {
	PyObject* object;
	void      operator()(const void*) const
	{
		if (!Py_IsInitialized()) return; // the process ends, and its objects with it
		const PythonLock held;
		Py_DECREF(object);
	}
};

/// How boost::shared_ptr<T> comes from Python and goes back there, for a class of Boost.Python that is held by such a pointer.
///
/// Boost's own conversion makes a pointer that lets go of its Python object in the thread that drops it, without Python's lock. A step of
/// YADE runs beside Python: it would count references while Python does, and end the process where it frees the object. Like that of Boost
/// this conversion gives a script its own object back, not another one for the same C++ object.
template <class T> class HeldPointer {
	using Pointer      = boost::shared_ptr<T>;
	using Registration = boost::python::converter::registration;

public:
	/// Goes in front of Boost's, once class_<T, shared_ptr<T>> was made.
	static void registerOnce()
	{
		namespace converter = boost::python::converter;
		const auto type     = boost::python::type_id<Pointer>();
		auto&      known    = const_cast<Registration&>(converter::registry::lookup(type));
		if (known.m_to_python == &toPython) return;
		if (!known.m_to_python) throw std::logic_error("Boost.Python knows no class of this type yet");
		toPythonOfBoost   = known.m_to_python;
		known.m_to_python = &toPython;
		converter::registry::insert(&convertible, &construct, type, &converter::expected_from_python_type_direct<T>::get_pytype);
	}

private:
	static void* convertible(PyObject* object)
	{
		namespace converter = boost::python::converter;
		return object == Py_None ? object : converter::get_lvalue_from_python(object, converter::registered<T>::converters);
	}

	static void construct(PyObject* object, boost::python::converter::rvalue_from_python_stage1_data* data)
	{
		void* const memory = reinterpret_cast<boost::python::converter::rvalue_from_python_storage<Pointer>*>(data)->storage.bytes;
		if (data->convertible == object) new (memory) Pointer();
		else {
			Py_INCREF(object);
			const boost::shared_ptr<void> holds(nullptr, HeldObject { object });
			new (memory) Pointer(holds, static_cast<T*>(data->convertible));
		}
		data->convertible = memory;
	}

	static PyObject* toPython(const void* pointer)
	{
		const auto* const held = boost::get_deleter<HeldObject>(*static_cast<const Pointer*>(pointer));
		return held ? boost::python::incref(held->object) : toPythonOfBoost(pointer);
	}

	static inline boost::python::converter::to_python_function_t toPythonOfBoost = nullptr;
};

} // namespace talik
