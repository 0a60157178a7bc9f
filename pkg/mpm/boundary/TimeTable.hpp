// SPDX-License-Identifier: GPL-2.0-or-later
#pragma once

#include <string>
#include <vector>

namespace talik {

/// A value that changes with time: piecewise linear between the given instants, constant before the first and after the last.
class TimeTable {
public:
	TimeTable(double constant = 0.0)
	        : times_ { 0.0 }
	        , values_ { constant }
	{
	}
	/// times [s] strictly increasing, as many as values; checked by validate().
	TimeTable(std::vector<double> times, std::vector<double> values)
	        : times_(std::move(times))
	        , values_(std::move(values))
	{
	}

	double at(double time) const;
	bool   isZero() const;

	/// Throws std::invalid_argument naming owner if the table is empty, not finite or its instants do not increase.
	void validate(const std::string& owner) const;

	const std::vector<double>& times() const { return times_; }
	const std::vector<double>& values() const { return values_; }

private:
	std::vector<double> times_;
	std::vector<double> values_;
};

} // namespace talik
