// SPDX-License-Identifier: GPL-2.0-or-later
#pragma once

#include <pkg/thm/Errors.hpp>

#include <cmath>

namespace talik {

/// Thrown by a skeleton model that has given every point a stress and wants the run to stop: Ground ends the step first and passes
/// it on from updateEffectiveStress().
class StopAfterStep : public std::runtime_error {
public:
	using std::runtime_error::runtime_error;
};

} // namespace talik
