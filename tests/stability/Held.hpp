// SPDX-License-Identifier: GPL-2.0-or-later
#pragma once

#include "Watch.hpp"

#include <string>

namespace talik::stability {

/// What a run is held to; the limits that are round-off are the same everywhere.
struct Limits {
	double energy   = 0.05;  ///< energy from nowhere over all that was turned over [-]; infinity where water or bodies carry some in and out
	double mass     = 1e-12; ///< [-]
	double heat     = 1e-11; ///< [-]
	double momentum = 1e-9;  ///< [-]
};

/// Prints a row for every figure against its limit, and asserts: finite, ended by no error, balances closed, energy bounded.
void expectHeld(const std::string& name, const Figures& figures, const Limits& limits = {});

/// A map of one figure over two parameters, written beside the rows for scripts/stability when it goes out of scope.
class Map {
public:
	/// name: of the file; labels with units.
	Map(const std::string& name, const std::string& title, const std::string& xLabel, const std::string& yLabel, const std::string& valueLabel);
	~Map();
	Map(const Map&)            = delete;
	Map& operator=(const Map&) = delete;

	void add(double x, double y, double value, bool held);

private:
	std::string name_, text_;
};

} // namespace talik::stability
