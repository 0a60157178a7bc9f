// SPDX-License-Identifier: GPL-2.0-or-later
#pragma once
#include <algorithm>
#include <cmath>

namespace talik {

/// Strength of ice bonds over the one that their material gives them [-], > 0.
struct BondStrengthFactors {
	double tensile = 1, shear = 1;
	bool   operator==(const BondStrengthFactors& other) const { return tensile == other.tensile && shear == other.shear; }
};

/// How the strength of ice bonds follows temperature and strain rate, eq. (14.7). The numbers are those of frozen silt: rate by Haynes,
/// Karalius & Kalafut 1975, temperature by Haynes & Karalius 1977; compression is taken for the shear strength of bonds, tension for tensile.
struct IceStrengthLaw {
	/// Exponential growth with cold b [1/K] and exponent of the rate n [-] of one strength.
	struct Dependence {
		double cold, rate;
	};
	Dependence tensile { 0.0203, 0. }, shear { 0.0406, 0.228 };
	double     referenceTemperature = -10;  ///< at which the material's strengths hold [degC], <= 0
	double     referenceRate        = 1e-4; ///< the same [1/s of nature], > 0
	double     leastRate            = 1e-7; ///< slower strain counts as this [1/s], > 0

	BondStrengthFactors factors(double temperature, double strainRate) const
	{
		const double colder = referenceTemperature - std::min(temperature, 0.), faster = std::max(strainRate, leastRate) / referenceRate;
		const auto   factor = [&](const Dependence& of) { return std::exp(of.cold * colder) * std::pow(faster, of.rate); };
		return { factor(tensile), factor(shear) };
	}
};

} // namespace talik
