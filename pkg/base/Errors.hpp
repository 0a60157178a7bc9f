// SPDX-License-Identifier: GPL-2.0-or-later
#pragma once

#include <sstream>
#include <stdexcept>
#include <string>
#include <vector>

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

/// Place of a name among those that are possible. Throws std::invalid_argument with attribute, name and all possible ones.
inline int placeOfName(const std::string& attribute, const std::string& name, const std::vector<std::string>& possible)
{
	std::string known;
	for (std::size_t k = 0; k < possible.size(); ++k) {
		if (name == possible[k]) return int(k);
		known += (known.empty() ? "" : ", ") + possible[k];
	}
	throw std::invalid_argument(attribute + " = '" + name + "': choose one of " + known);
}

} // namespace talik
