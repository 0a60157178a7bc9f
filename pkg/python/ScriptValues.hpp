// SPDX-License-Identifier: GPL-2.0-or-later
#pragma once
#include <boost/python.hpp>
#include <cmath>
#include <initializer_list>
#include <lib/base/Math.hpp>
#include <lib/serialization/Serializable.hpp>
#include <sstream>
#include <stdexcept>
#include <string>
#include <utility>

/// Members of an object go into a dictionary for scripts under their own names: TALIK_PUT_MEMBERS(d, b, (time)(heatIn)).
#define TALIK_PUT_MEMBERS(dict, object, members) BOOST_PP_SEQ_FOR_EACH(TALIK_PUT_MEMBER, (dict, object), members)
#define TALIK_PUT_MEMBER(r, place, member) BOOST_PP_TUPLE_ELEM(2, 0, place)[BOOST_PP_STRINGIZE(member)] = BOOST_PP_TUPLE_ELEM(2, 1, place).member;

/// Members of an object take the attributes of the same names: TALIK_TAKE_ATTRIBUTES(settings, *this, (picTime)(smoothingTime)).
#define TALIK_TAKE_ATTRIBUTES(object, source, members) BOOST_PP_SEQ_FOR_EACH(TALIK_TAKE_ATTRIBUTE, (object, source), members)
#define TALIK_TAKE_ATTRIBUTE(r, place, member) (BOOST_PP_TUPLE_ELEM(2, 0, place)).member = (BOOST_PP_TUPLE_ELEM(2, 1, place)).member;

namespace talik {

/// Items as a list of Python's.
template <class Items> boost::python::list listOf(const Items& items)
{
	boost::python::list list;
	for (const auto& item : items)
		list.append(item);
	return list;
}

/// Lets Python assign a list of objects to an attribute vector<shared_ptr<T>> and read it back as a list.
template <class T> struct SequenceConverter {
	using Element  = boost::shared_ptr<T>;
	using Sequence = std::vector<Element>;

	static PyObject* convert(const Sequence& sequence) { return boost::python::incref(listOf(sequence).ptr()); }

	static void* convertible(PyObject* object)
	{
		if (!PyList_Check(object) && !PyTuple_Check(object)) return nullptr;
		boost::python::object items { boost::python::handle<>(boost::python::borrowed(object)) };
		for (int i = 0; i < boost::python::len(items); ++i)
			if (!boost::python::extract<Element>(items[i]).check() || boost::python::object(items[i]).is_none()) return nullptr;
		return object;
	}

	static void construct(PyObject* object, boost::python::converter::rvalue_from_python_stage1_data* data)
	{
		void*                 memory   = reinterpret_cast<boost::python::converter::rvalue_from_python_storage<Sequence>*>(data)->storage.bytes;
		auto*                 sequence = new (memory) Sequence;
		boost::python::object items { boost::python::handle<>(boost::python::borrowed(object)) };
		for (int i = 0; i < boost::python::len(items); ++i)
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

/// A number in a sentence, as a script gives it.
inline std::string asText(double number)
{
	std::ostringstream text;
	text.precision(10);
	text << number;
	return text.str();
}

} // namespace talik

namespace yade {

/// Refuses values of attributes of a class: std::invalid_argument with class, attribute, value and remedy.
struct AttributeRefusal {
	const char* className;
	/// Numbers that are not finite are never valid.
	void operator()(bool valid, const char* attribute, Real value, const string& remedy) const
	{
		if (valid && std::isfinite(value)) return;
		throw std::invalid_argument(string(className) + "." + attribute + " is " + talik::asText(value) + ": " + remedy);
	}
};

} // namespace yade
