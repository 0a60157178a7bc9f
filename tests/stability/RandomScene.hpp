// SPDX-License-Identifier: GPL-2.0-or-later
#pragma once

#include <pkg/mpm/Ground.hpp>

#include <cstdint>
#include <memory>
#include <random>
#include <string>

namespace talik::stability {

/// A small scene drawn at random from the ranges of every effect, with what it may be held to.
struct RandomScene {
	std::unique_ptr<Ground<2>> ground; ///< points added, not initialised
	std::string                described; ///< every setting that was drawn, in one line
	long                       steps = 0; ///< to run

	double coldest = INFINITY, hottest = -INFINITY; ///< of all temperatures given [degC]; the ground must stay between them
	bool   temperaturesBounded = true; ///< false: heat is produced
	bool   open = false; ///< a side of the box has no wall: points may leave
	bool   energyAccounted     = true; ///< false: water that crosses the surface, or percolates on the spot, has energy which the ledger does not see

	/// The same seed draws the same scene on any machine.
	explicit RandomScene(std::uint64_t seed);
};

} // namespace talik::stability
