// SPDX-License-Identifier: GPL-2.0-or-later
#pragma once

#include <string>

/// One row of the validation table: prints "case | measured | reference | error | tolerance" at once, keeps it for the table
/// that is printed after the last test, and asserts that the error does not exceed the tolerance.
namespace talik::validation {

/// |measured/reference - 1| <= tolerance
void expectRelative(const std::string& what, double measured, double reference, double tolerance);

/// |measured - reference|/scale <= tolerance
void expectScaled(const std::string& what, double measured, double reference, double scale, double tolerance);

/// |value| <= bound, for drifts and residuals whose reference is zero
void expectSmall(const std::string& what, double value, double bound);

/// value >= bound, for orders of convergence
void expectAtLeast(const std::string& what, double value, double bound);

} // namespace talik::validation
