// SPDX-License-Identifier: GPL-2.0-or-later
#pragma once
#include <boost/lexical_cast.hpp>
#include <cmath>
#include <lib/base/Math.hpp>
#include <stdexcept>

namespace yade {

/// Refuses values of attributes of a class: std::invalid_argument with class, attribute, value and remedy.
struct AttributeRefusal {
	const char* className;
	/// Numbers that are not finite are never valid.
	void operator()(bool valid, const char* attribute, Real value, const string& remedy) const
	{
		if (valid && std::isfinite(value)) return;
		throw std::invalid_argument(string(className) + "." + attribute + " is " + boost::lexical_cast<string>(value) + ": " + remedy);
	}
};

} // namespace yade
