// SPDX-License-Identifier: GPL-2.0-or-later
#include <pkg/thm/Mixture.hpp>
#include <pkg/thm/Permeability.hpp>

#include <stdexcept>

namespace talik {

namespace {
	constexpr const char* lawNames[] = { "impedance", "vanGenuchtenMualem", "power", "iceAsGrain" };
}

RelativeConductivity relativeConductivityFromName(const std::string& name)
{
	for (int k = 0; k < 4; ++k)
		if (name == lawNames[k]) return static_cast<RelativeConductivity>(k);
	throw std::invalid_argument("relativeConductivity = '" + name + "': choose impedance, vanGenuchtenMualem, power or iceAsGrain");
}

const char* nameOf(RelativeConductivity law) { return lawNames[static_cast<int>(law)]; }

void Permeability::validate() const
{
	const auto inside = [](double value, double low, double high) { return value > low && value < high; };
	requireProperty(inside(referenceConductivity, 0.0, 1e3), "referenceConductivity", referenceConductivity, "must be positive, in m/s (sand: 1e-4)");
	requireProperty(inside(referencePorosity, 0.0, 1.0), "referencePorosity", referencePorosity, "must lie in (0, 1)");
	requireProperty(impedance >= 0.0 && impedance < 100.0, "impedance", impedance, "must lie in [0, 100), usually 4 to 10");
	requireProperty(inside(exponent, 0.0, 100.0), "exponent", exponent, "must lie in (0, 100), usually 3 to 9");
	requireProperty(inside(lambda, 0.0, 1.0), "lambda", lambda, "must lie in (0, 1)");
	requireProperty(residualSaturation >= 0.0 && residualSaturation < 1.0, "residualSaturation", residualSaturation, "must lie in [0, 1)");
	requireProperty(floor > 0.0 && floor <= 1.0, "floor", floor, "must lie in (0, 1], default 1e-6");
	requireProperty(inside(hydraulicTimeScale, 1e-12, 1e12), "hydraulicTimeScale", hydraulicTimeScale, "must lie between 1e-12 and 1e12 (1: no scaling)");
}

} // namespace talik
