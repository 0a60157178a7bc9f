// SPDX-License-Identifier: GPL-2.0-or-later
#pragma once
#include <string>

namespace talik {

/// Valid ranges of what pore water and single soils both have. They throw std::invalid_argument with the attribute as its class in scripts calls it.
void requireConductivity(double value, const std::string& attribute);
void requireReferencePorosity(double value, const std::string& attribute);
void requireImpedance(double value, const std::string& attribute);

} // namespace talik
