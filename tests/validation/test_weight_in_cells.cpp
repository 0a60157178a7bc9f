// SPDX-License-Identifier: GPL-2.0-or-later
// Rows of points near the surface of level ground that has thawed carry what lies on them.
#include "LevelGround.hpp"
#include "Report.hpp"

#include <gtest/gtest.h>

#include <algorithm>

using namespace talik;
using namespace talik::validation;

namespace {

/// Largest difference of the stress of the four topmost rows from the weight above, over that of a row of cells; and the path of the surface.
void expectRowsCarryTheirWeight(const Level& level, double stressTolerance, double pathTolerance)
{
	citing("weight above");
	const Outcome o     = outcomeOf<2>(level);
	const int     rows  = int(o.stress.size());
	double        worst = 0.0;
	for (int k = 1; k <= 4; ++k) {
		std::printf("row %d from the surface: %.2f kPa, due %.2f kPa\n", k, 1e-3 * o.stress[rows - k], 1e-3 * o.due[rows - k]);
		worst = std::max(worst, std::abs(o.stress[rows - k] - o.due[rows - k]));
	}
	const std::string name = "level ground, weight within cells, " + level.words() + (level.front ? ", thaw front: " : ": ");
	expectSmall(
	        name + "stress of the four topmost rows less the weight above, over that of a row of cells",
	        worst / (Level::density * Level::gravity * level.spacing), stressTolerance);
	expectSmall(name + "path of the surface [mm]", 1e3 * o.surface, pathTolerance);
}

Level thawing(bool saturated, double spacing, bool front)
{
	Level level;
	level.saturated = saturated;
	level.spacing   = spacing;
	level.front     = front;
	return level;
}

} // namespace

TEST(WeightInCells, RowsAtTheSurfaceOfThawedGroundCarryWhatLiesOnThem)
{
	expectRowsCarryTheirWeight(thawing(false, 0.5, true), 0.25, 0.5);
	expectRowsCarryTheirWeight(thawing(true, 0.5, true), 0.25, 0.5);
}

TEST(WeightInCells, RowsAtTheSurfaceOfThawedGroundCarryWhatLiesOnThemInFinerCells_slow)
{
	for (const bool front : { true, false })
		for (const bool saturated : { true, false })
			expectRowsCarryTheirWeight(thawing(saturated, 0.25, front), 0.25, 0.5);
}
