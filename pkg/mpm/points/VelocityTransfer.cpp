// SPDX-License-Identifier: GPL-2.0-or-later
#include <pkg/mpm/points/VelocityTransfer.hpp>

#include <algorithm>
#include <cmath>
#include <stdexcept>

namespace talik {

std::vector<std::string> velocityTransferNames() { return { "flip", "apic", "tpic" }; }

VelocityTransfer velocityTransferFromName(const std::string& name)
{
	std::string known;
	int         at = 0;
	for (const std::string& entry : velocityTransferNames()) {
		if (name == entry) return static_cast<VelocityTransfer>(at);
		known += (known.empty() ? "" : ", ") + entry;
		++at;
	}
	throw std::invalid_argument("transfer = '" + name + "': choose one of " + known);
}

double keptFraction(double picTime, double dt) { return std::exp(-dt / picTime); }

double gravityTime(double spacing, double gravity)
{
	constexpr double ofTheEarth = 9.81;
	return std::sqrt(spacing / std::max(gravity, ofTheEarth));
}

} // namespace talik
