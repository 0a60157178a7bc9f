// SPDX-License-Identifier: GPL-2.0-or-later
// Level ground that thaws, freezes or both under its own weight. Nothing should happen: it moves with the thaw front as without, its rows stay in order,
// and each bears what lies on it.
#include "LevelGround.hpp"
#include "Report.hpp"

#include <gtest/gtest.h>

#include <algorithm>
#include <cstdio>

using namespace talik;
using namespace talik::validation;

namespace {

/// What the rows of both outcomes differ by at most [m].
double farthestApart(const Outcome& a, const Outcome& b)
{
	double largest = 0.0;
	for (std::size_t row = 0; row < a.sank.size(); ++row)
		largest = std::max(largest, std::abs(a.sank[row] - b.sank[row]));
	return largest;
}

double shortestDistance(const Outcome& o) { return *std::min_element(o.distance.begin(), o.distance.end()); }

/// Largest error of the vertical total stress of a cell over the weight above it, but for the uppermost cell, whose upper row bears next to nothing.
double stressError(const Outcome& o)
{
	double largest = 0.0;
	for (std::size_t row = 0; row + 3 < o.due.size(); row += 2)
		largest = std::max(largest, std::abs((o.stress[row] + o.stress[row + 1]) / (o.due[row] + o.due[row + 1]) - 1.0));
	return largest;
}

/// The thaw front against one velocity for all, in a scene where nothing should happen.
template <int D> void expectNothing(Level level, double apart, double stressTolerance)
{
	citing("one velocity for all");
	level.front               = true;
	const Outcome with        = outcomeOf<D>(level);
	level.front               = false;
	const Outcome     without = outcomeOf<D>(level);
	const std::string what    = std::string("level ground") + (D == 3 ? " in space, " : ", ") + level.words() + ": ";
	expectScaled(what + "surface sinks with the thaw front over without [mm]", 1e3 * with.surface, 1e3 * without.surface, 1e3, apart);
	expectSmall(what + "rows farther down than without thaw front, at most [m]", farthestApart(with, without), apart);
	expectAtLeast(what + "shortest distance of two rows over its first", shortestDistance(with), 0.5);
	if (stressTolerance < 1.0) expectSmall(what + "stress of a cell less the weight above, over that", stressError(with), stressTolerance);
}

Level thawedFrom(bool above, bool below, bool saturated)
{
	Level level;
	level.fromAbove = above;
	level.fromBelow = below;
	level.saturated = saturated;
	return level;
}

Level frozenBefore(bool saturated)
{
	Level level = thawedFrom(true, false, saturated);
	level.cycle = true;
	return level;
}

constexpr double millimetre = 1e-3, byStrain = 2e-3 * Level::depth;

} // namespace

TEST(LevelGround, ThatThawsMovesWithTheThawFrontAsWithoutAndBearsItsWeight)
{
	for (const bool saturated : { false, true }) {
		expectNothing<2>(thawedFrom(true, false, saturated), millimetre, 0.1);
		expectNothing<2>(thawedFrom(false, true, saturated), millimetre, 0.1);
		expectNothing<2>(thawedFrom(true, true, saturated), millimetre, 0.1);
		expectNothing<2>(frozenBefore(saturated), millimetre, 0.2);
	}
}

// dry ground thawed from below, whose frozen roof unloads what settles under it, is held on the fine grid alone: on cells of 1/4 m it sinks 4.6 mm less
TEST(LevelGround, ThatLosesVolumeAsItThawsSettlesWithTheThawFrontAsWithout)
{
	for (const bool saturated : { false, true })
		for (const bool below : { false, true }) {
			Level level      = thawedFrom(true, below, saturated);
			level.thawStrain = 0.05;
			expectNothing<2>(level, byStrain, INFINITY);
		}
}

TEST(LevelGround, OnAFineGridMovesWithTheThawFrontAsWithout_slow)
{
	for (const bool saturated : { false, true })
		for (const double strain : { 0.0, 0.05 })
			for (const int side : { 0, 1, 2, 3 }) {
				Level level      = side == 3 ? frozenBefore(saturated) : thawedFrom(side != 1, side != 0, saturated);
				level.spacing    = 0.125;
				level.thawStrain = strain;
				expectNothing<2>(level, strain > 0.0 ? byStrain : millimetre, INFINITY);
			}
}

TEST(LevelGround, InSpaceMovesWithTheThawFrontAsWithout_slow)
{
	for (const bool saturated : { false, true }) {
		expectNothing<3>(thawedFrom(true, false, saturated), millimetre, 0.1);
		expectNothing<3>(thawedFrom(false, true, saturated), millimetre, 0.1);
		expectNothing<3>(frozenBefore(saturated), millimetre, 0.2);
	}
}
