// SPDX-License-Identifier: GPL-2.0-or-later
#pragma once

#include <string>

namespace talik {

/// Strain of thawed soil under load, measured from its frozen state without the part that needs no load: linear in the effective stress along
/// gravity, or in its logarithm. Thawed soil follows it when it is loaded as never before, and keeps its strain when it is unloaded.
struct CompressionCurve {
	double compressibility  = 0.0; ///< a_0: strain, of the volume frozen, over stress [1/Pa], >= 0; 0: none, or compressionIndex
	double compressionIndex = 0.0; ///< C_c: void ratio lost as the stress grows tenfold [-], >= 0; 0: none
	double referenceStress  = 1e3; ///< up to which the strain with compressionIndex is 0 [Pa], > 0

	bool given() const { return compressibility > 0.0 || compressionIndex > 0.0; }
	/// Of the volume frozen [-]; pressure: effective, along gravity [Pa]; solidShare: 1 less the porosity frozen [-].
	double strain(double pressure, double solidShare) const;
	/// Throws std::invalid_argument naming attribute, value and remedy; prefix: of the attributes' names.
	void validate(const std::string& prefix) const;
};

} // namespace talik
