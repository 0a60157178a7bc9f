// SPDX-License-Identifier: GPL-2.0-or-later
#pragma once

#include <cmath>
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

/// Thrown by a skeleton model that has given every point a stress and wants the run to stop: Ground ends the step first and passes
/// it on from updateEffectiveStress().
class StopAfterStep : public std::runtime_error {
public:
	using std::runtime_error::runtime_error;
};

} // namespace talik
