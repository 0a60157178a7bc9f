// SPDX-License-Identifier: GPL-2.0-or-later
#pragma once
#include <lib/serialization/Serializable.hpp>

namespace talik {

/// Lets Python assign a list of objects to an attribute vector<shared_ptr<T>> and read it back as a list.
template <class T> struct SequenceConverter {
	using Element  = boost::shared_ptr<T>;
	using Sequence = std::vector<Element>;

	static PyObject* convert(const Sequence& sequence)
	{
		boost::python::list result;
		for (const auto& element : sequence)
			result.append(element);
		return boost::python::incref(result.ptr());
	}

	static void* convertible(PyObject* object)
	{
		if (!PyList_Check(object) && !PyTuple_Check(object)) return nullptr;
		boost::python::object items { boost::python::handle<>(boost::python::borrowed(object)) };
		for (int i = 0; i < boost::python::len(items); i++)
			if (!boost::python::extract<Element>(items[i]).check() || boost::python::object(items[i]).is_none()) return nullptr;
		return object;
	}

	static void construct(PyObject* object, boost::python::converter::rvalue_from_python_stage1_data* data)
	{
		void*                 memory   = reinterpret_cast<boost::python::converter::rvalue_from_python_storage<Sequence>*>(data)->storage.bytes;
		auto*                 sequence = new (memory) Sequence;
		boost::python::object items { boost::python::handle<>(boost::python::borrowed(object)) };
		for (int i = 0; i < boost::python::len(items); i++)
			sequence->push_back(boost::python::extract<Element>(items[i])());
		data->convertible = memory;
	}

	static void registerOnce()
	{
		const auto* known = boost::python::converter::registry::query(boost::python::type_id<Sequence>());
		if (known && known->m_to_python) return;
		boost::python::to_python_converter<Sequence, SequenceConverter<T>>();
		boost::python::converter::registry::push_back(&convertible, &construct, boost::python::type_id<Sequence>());
	}
};

} // namespace talik
