// SPDX-License-Identifier: GPL-2.0-or-later
#pragma once

#include <functional>
#include <string>
#include <vector>

/// One row of the validation table: prints "case: figure | measured | reference | error | tolerance | source" and asserts that the
/// error does not exceed the tolerance. What stands before the first colon of a row's name is its case; rows of one case are
/// summed up in one line of examples/validation.md.
/// Where the environment variable TALIK_VALIDATION_OUTPUT names a folder, rows go to <folder>/rows and curves to
/// <folder>/curves, as CSV, from which scripts/validate draws.
namespace talik::validation {

/// Where the references of the following rows of this test come from, for the table.
void citing(const std::string& source);

/// |measured/reference - 1| <= tolerance
void expectRelative(const std::string& what, double measured, double reference, double tolerance);

/// |measured - reference|/scale <= tolerance
void expectScaled(const std::string& what, double measured, double reference, double scale, double tolerance);

/// |value| <= bound, for drifts and residuals whose reference is zero
void expectSmall(const std::string& what, double value, double bound);

/// value >= bound, for orders of convergence
void expectAtLeast(const std::string& what, double value, double bound);

/// A drawing of computed values (markers) over their reference (line), written when it goes out of scope.
class Drawing {
public:
	/// name: of the file; labels with units.
	Drawing(const std::string& name, const std::string& title, const std::string& xLabel, const std::string& yLabel);
	~Drawing();
	Drawing(const Drawing&)            = delete;
	Drawing& operator=(const Drawing&) = delete;

	void computed(const std::string& series, double x, double y) { add(series, "computed", x, y); }
	void reference(const std::string& series, double x, double y) { add(series, "reference", x, y); }
	/// Reference as a function, sampled at 200 abscissas.
	void reference(const std::string& series, double from, double to, const std::function<double(double)>& f);

private:
	void add(const std::string& series, const char* kind, double x, double y);

	std::string name_, text_;
};

} // namespace talik::validation
