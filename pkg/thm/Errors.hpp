// SPDX-License-Identifier: GPL-2.0-or-later
#pragma once

#include <sstream>
#include <stdexcept>
#include <string>

namespace talik {

/// Throws std::invalid_argument "<attribute> = <value>: <remedy>" unless valid.
template <class Value> void requireSetting(bool valid, const std::string& attribute, const Value& value, const std::string& remedy)
{
	if (valid) return;
	std::ostringstream text;
	text.precision(10);
	text << attribute << " = " << value << ": " << remedy;
	throw std::invalid_argument(text.str());
}

} // namespace talik
