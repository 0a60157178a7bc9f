// SPDX-License-Identifier: GPL-2.0-or-later
#pragma once
#include <boost/preprocessor/seq/for_each.hpp>
#include <boost/preprocessor/tuple/elem.hpp>

#include <vector>

/// The parameters of a law or an effect are written once, as a list in the form of YADE's attribute macros, in the header of the model:
///
///     #define TALIK_ELASTIC_SKELETON \
///         ((Real, young, 10e6,, "Young's modulus E [Pa], > 0.")) \
///         ((Real, poisson, 0.3,, "Poisson's ratio [-], in (-1, 0.5)."))
///
/// The model declares its members from it, TALIK_MEMBERS(TALIK_ELASTIC_SKELETON), with the defaults; the class that a script sees its
/// attributes with their help, YADE_CLASS_BASE_DOC_ATTRS(…, TALIK_ELASTIC_SKELETON); and TALIK_TAKE(model, attributes, list) copies each.
/// This header and the models know no YADE: Real and vector are those of a class with members from a list.
#define TALIK_MEMBERS(list) \
	using Real = double; \
	template <class Element> using vector = std::vector<Element>; \
	BOOST_PP_SEQ_FOR_EACH(TALIK_MEMBER, ~, list)
#define TALIK_MEMBER(r, unused, parameter) TALIK_PARAMETER_TYPE(parameter) TALIK_PARAMETER_NAME(parameter) { BOOST_PP_TUPLE_ELEM(5, 2, parameter) };

#define TALIK_TAKE(object, source, list) BOOST_PP_SEQ_FOR_EACH(TALIK_TAKE_PARAMETER, (object, source), list)
#define TALIK_TAKE_PARAMETER(r, place, parameter) \
	(BOOST_PP_TUPLE_ELEM(2, 0, place)).TALIK_PARAMETER_NAME(parameter) = (BOOST_PP_TUPLE_ELEM(2, 1, place)).TALIK_PARAMETER_NAME(parameter);

#define TALIK_PARAMETER_TYPE(parameter) BOOST_PP_TUPLE_ELEM(5, 0, parameter)
#define TALIK_PARAMETER_NAME(parameter) BOOST_PP_TUPLE_ELEM(5, 1, parameter)
