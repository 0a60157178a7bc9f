// SPDX-License-Identifier: GPL-2.0-or-later
#include <pkg/mpm/boundary/TimeTable.hpp>

#include <algorithm>
#include <cmath>
#include <stdexcept>

namespace talik {

double TimeTable::at(double time) const
{
	if (time <= times_.front()) return values_.front();
	if (time >= times_.back()) return values_.back();
	const auto        next = std::upper_bound(times_.begin(), times_.end(), time);
	const std::size_t i    = static_cast<std::size_t>(next - times_.begin());
	const double      s    = (time - times_[i - 1]) / (times_[i] - times_[i - 1]);
	return values_[i - 1] + s * (values_[i] - values_[i - 1]);
}

bool TimeTable::isZero() const
{
	return std::all_of(values_.begin(), values_.end(), [](double v) { return v == 0.0; });
}

void TimeTable::validate(const std::string& owner) const
{
	if (times_.empty() || times_.size() != values_.size())
		throw std::invalid_argument(
		        owner + ": table with " + std::to_string(times_.size()) + " times and " + std::to_string(values_.size())
		        + " values; give one value for each time, at least one");
	for (std::size_t i = 0; i < times_.size(); ++i) {
		if (!std::isfinite(times_[i]) || !std::isfinite(values_[i]))
			throw std::invalid_argument(owner + ": entry " + std::to_string(i) + " of the table is not finite; give finite times and values");
		if (i > 0 && times_[i] <= times_[i - 1])
			throw std::invalid_argument(
			        owner + ": time " + std::to_string(times_[i]) + " follows " + std::to_string(times_[i - 1])
			        + " in the table; times must increase");
	}
}

} // namespace talik
