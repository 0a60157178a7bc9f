// SPDX-License-Identifier: GPL-2.0-or-later
#include <pkg/base/Errors.hpp>
#include <pkg/thm/CompressionCurve.hpp>

#include <cmath>

namespace talik {

double CompressionCurve::strain(double pressure, double solidShare) const
{
	if (compressionIndex == 0.0) return pressure > 0.0 ? compressibility * pressure : 0.0;
	return pressure > referenceStress ? compressionIndex * solidShare * std::log10(pressure / referenceStress) : 0.0;
}

void CompressionCurve::validate(const std::string& prefix) const
{
	requireSetting(
	        compressibility >= 0.0 && compressibility < 1e-3, prefix + "compressibility", compressibility,
	        "must lie between 0 and 1e-3, in 1/Pa: 1 % per kPa is 1e-5");
	requireSetting(compressionIndex >= 0.0 && compressionIndex < 100.0, prefix + "compressionIndex", compressionIndex, "must lie between 0 and 100");
	requireSetting(
	        compressibility == 0.0 || compressionIndex == 0.0, prefix + "compressionIndex", compressionIndex,
	        "and compressibility describe the same strain: leave one of them 0");
	requireSetting(std::isfinite(referenceStress) && referenceStress > 0.0, prefix + "referenceStress", referenceStress, "must be positive, in Pa");
}

} // namespace talik
