// SPDX-License-Identifier: GPL-2.0-or-later
#pragma once

#include "MetBody.hpp"

#include <pkg/mpm/Ground.hpp>

#include <cstdint>
#include <memory>
#include <string>

namespace talik::stability {

/// A small scene drawn at random from the ranges of every effect, with what it may be held to.
template <int D> struct RandomScene {
	std::unique_ptr<Ground<D>> ground; ///< points added, not initialised
	RigidBody<D>               drawn;  ///< the body before the start, if the ground has the effect
	MetBody<D>                 body;
	std::string                described; ///< every setting that was drawn, in one line
	long                       steps = 0; ///< to run

	double coldest = INFINITY, hottest = -INFINITY; ///< of all temperatures given [degC]; the ground must stay between them
	bool   temperaturesBounded = true;              ///< false: heat is produced
	bool   open                = false;             ///< points may leave: a side of the box has no wall, or they were thrown against one
	bool   energyAccounted     = true; ///< false: water that crosses the surface, or percolates on the spot, has energy which the ledger does not see

	/// The same seed draws the same scene on any machine. wallsRest: without the wall that moves, which scenes found earlier did not have. segregates:
	/// ground with heat, water and freezing draws water as it freezes, where it may.
	explicit RandomScene(std::uint64_t seed, bool wallsRest = false, bool segregates = false);
	/// Solves for the pressure of all cells at once, where the scene may. Returns whether it does; to be called before start().
	bool solvePressure();
	/// Initialises the ground and puts the body in its place. Throws what Ground::initialise() throws.
	void start();
	/// The body as the watch takes it; nothing in a scene without.
	Outside outside() { return body.contact ? body.outside() : Outside(); }
};

extern template struct RandomScene<2>;
extern template struct RandomScene<3>;

} // namespace talik::stability
