// SPDX-License-Identifier: GPL-2.0-or-later
#pragma once
#include <boost/preprocessor/seq/for_each.hpp>
#include <boost/preprocessor/tuple/elem.hpp>

#include <limits>
#include <vector>

/// The parameters of a law or an effect are written once, as a list in the form of YADE's attribute macros, in the header of the model. Entries of
/// such a list, TALIK_ELASTIC_SKELETON for instance, are ((Real, young, 10e6,, "Young's modulus E [Pa], > 0.")): type, name, default, flags, help.
/// In the model TALIK_PARAMETERS(list) declares members with these defaults. In the class that a script sees YADE_CLASS_BASE_DOC_ATTRS(…, list)
/// declares attributes with this help. TALIK_TAKE(model, attributes, list) copies attributes to members.
/// TALIK_PARAMETERS also defines Real, vector and NaN, so that no header of YADE is needed.
// clang-format off
#define TALIK_PARAMETERS(list) \
	using Real = double; \
	template <class Element> using vector = std::vector<Element>; \
	static constexpr double NaN = std::numeric_limits<double>::quiet_NaN(); \
	BOOST_PP_SEQ_FOR_EACH(TALIK_DECLARE_PARAMETER, ~, list)
#define TALIK_DECLARE_PARAMETER(r, unused, parameter) TALIK_PARAMETER_TYPE(parameter) TALIK_PARAMETER_NAME(parameter) { BOOST_PP_TUPLE_ELEM(5, 2, parameter) };

#define TALIK_TAKE(object, source, list) BOOST_PP_SEQ_FOR_EACH(TALIK_TAKE_PARAMETER, (object, source), list)
#define TALIK_TAKE_PARAMETER(r, place, parameter) \
	(BOOST_PP_TUPLE_ELEM(2, 0, place)).TALIK_PARAMETER_NAME(parameter) = (BOOST_PP_TUPLE_ELEM(2, 1, place)).TALIK_PARAMETER_NAME(parameter);

#define TALIK_PARAMETER_TYPE(parameter) BOOST_PP_TUPLE_ELEM(5, 0, parameter)
#define TALIK_PARAMETER_NAME(parameter) BOOST_PP_TUPLE_ELEM(5, 1, parameter)
// clang-format on
