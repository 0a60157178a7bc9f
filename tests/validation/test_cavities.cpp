// SPDX-License-Identifier: GPL-2.0-or-later
// Hollows and pipes in the ground: what air outside reaches, and edges between nodes.
#include "References.hpp"
#include "Report.hpp"
#include "Scenes.hpp"

#include <gtest/gtest.h>

#include <algorithm>

using namespace talik;
using namespace talik::validation;

namespace {

constexpr double side = 4.0, hollowSize = 1.0, ground0 = 4.0, warm = 15.0;

/// Rigid block, 4 m by 4 m, with a square hollow of 1 m in its middle; heat leaves through one region to air that keeps its surface at -15.
Ground<2> hollowBlock(double h, const Region<2>& region)
{
	GroundSettings<2> s;
	s.lower       = { 0.0, 0.0 };
	s.upper       = { side, side + 4.0 * h };
	s.gridSpacing = h;
	s.mixture     = withoutExpansion();
	s.heat.emplace();
	addBoundary<SurfaceTemperature<2>>(s, region, -15.0);
	Ground<2>    ground(s);
	const double d = 0.5 * h, from = 0.5 * (side - hollowSize), to = 0.5 * (side + hollowSize);
	for (double y = 0.5 * d; y < side; y += d)
		for (double x = 0.5 * d; x < side; x += d) {
			if (x > from && x < to && y > from && y < to) continue;
			PointInput<2> point;
			point.position    = { x, y };
			point.volume      = d * d;
			point.porosity    = 0.4;
			point.temperature = ground0;
			ground.addPoint(point);
		}
	ground.initialise();
	return ground;
}

double distanceFromHollow(double x, double y)
{
	const double half = 0.5 * hollowSize, dx = std::max(0.0, std::abs(x - 0.5 * side) - half), dy = std::max(0.0, std::abs(y - 0.5 * side) - half);
	return std::hypot(dx, dy);
}

} // namespace

// Winter air cools the surface and leaves the ground around a hollow alone, and the other way round
TEST(Cavities, AirOutsideCoolsTheSurfaceAndNotTheGroundAroundAHollow)
{
	citing("Carslaw & Jaeger 1959, half space");
	const double time = 2.0 * 86400.0, h = 0.125;
	const auto   m     = withoutExpansion();
	const auto   n     = VolumeFractions::of(0.4, 1.0);
	const double kappa = m.conductivity(n), capacity = m.heatCapacity(n), depth = std::sqrt(kappa * time / (reference::pi * capacity));
	const double perArea = 2.0 * capacity * (ground0 + 15.0) * depth;
	for (const bool inside : { false, true }) {
		Ground<2> ground = hollowBlock(h, inside ? Region<2>::cavitySurface() : Region<2>::freeSurface());
		marchTo(ground, time);
		const auto t = valuesOf(ground, "temperature"), x = valuesOf(ground, "position", 0), y = valuesOf(ground, "position", 1);
		double     coldestAtHollow = ground0, coldestAtSurface = ground0;
		for (std::size_t k = 0; k < t.size(); ++k) {
			if (distanceFromHollow(x[k], y[k]) < 0.5 * h) coldestAtHollow = std::min(coldestAtHollow, t[k]);
			if (y[k] > side - 0.5 * h) coldestAtSurface = std::min(coldestAtSurface, t[k]);
		}
		const char* name = inside ? "hollow that is cooled" : "hollow below a cold surface";
		expectScaled(
		        std::string(name) + (inside ? ": change at the surface over that in the hollow" : ": change at the hollow over that at the surface"),
		        inside ? coldestAtSurface - ground0 : coldestAtHollow - ground0, 0.0, ground0 + 15.0, 1e-3);
		// heat reaches a fifth of the way: each face is one of a half space, corners of the hollow give a little more
		if (!inside) expectRelative(std::string(name) + ": heat lost [J/m]", -ground.balance().heatIn, perArea * side, 0.05);
		else expectRelative(std::string(name) + ": heat lost [J/m]", -ground.balance().heatIn, perArea * (4.0 * hollowSize + 4.0 * 0.5 * depth), 0.15);
	}
}

namespace {

struct Pipe {
	double radius, hottest;
};

/// A warm pipe of 0.8 m near the middle of a cold square of 4 m, in steady state: its radius as the temperatures around it show it, by the
/// shape factor 2 pi/ln(1.08 side/diameter), and the hottest point.
Pipe warmPipe(double h, double offset)
{
	GroundSettings<2> s;
	s.lower       = { -2.0, -2.0 };
	s.upper       = { 2.0, 2.0 };
	s.gridSpacing = h;
	s.mixture     = withoutExpansion();
	s.heat.emplace();
	for (const char* wall : { "left", "right", "bottom", "top" })
		addBoundary<WallTemperature<2>>(s, Region<2>::side(wall), 0.0);
	addBoundary<WallTemperature<2>>(s, Region<2>::disc({ -0.4 + offset, -0.4 + offset }, { 0.4 + offset, 0.4 + offset }), warm);
	Ground<2> ground(s);
	fillBox(ground, { -2.0, -2.0 }, { 2.0, 2.0 }, [](PointInput<2>& p) {
		p.porosity    = 0.4;
		p.temperature = 1.0;
	});
	ground.initialise();
	const auto   n         = VolumeFractions::of(0.4, 1.0);
	const double diffusion = s.mixture.conductivity(n) / s.mixture.heatCapacity(n);
	marchTo(ground, 1.5 * 4.0 / diffusion);
	const auto t = valuesOf(ground, "temperature"), x = valuesOf(ground, "position", 0), y = valuesOf(ground, "position", 1);
	double     sum = 0.0, logarithms = 0.0, hottest = 0.0;
	int        count = 0;
	for (std::size_t k = 0; k < t.size(); ++k) {
		hottest        = std::max(hottest, t[k]);
		const double r = std::hypot(x[k] - offset, y[k] - offset);
		if (r < 0.9 || r > 1.3) continue;
		sum += t[k];
		logarithms += std::log(r);
		++count;
	}
	const double outer = std::log(1.08 * 2.0), slope = (sum / count) / (outer - logarithms / count);
	return { std::exp(outer - warm / slope), hottest };
}

} // namespace

TEST(Cavities, APipeBetweenNodesIsAsWideAsItIs)
{
	citing("Incropera, shape factor of a pipe in a square");
	for (const double h : { 0.4, 0.25, 0.2 })
		for (const double offset : { 0.0, 0.3 * h }) {
			char label[80];
			std::snprintf(label, sizeof label, "pipe of 0.8 m%s, h = %.2f: ", offset > 0.0 ? " off the nodes" : "", h);
			const Pipe pipe = warmPipe(h, offset);
			expectScaled(label + std::string("apparent radius [m], error in h"), pipe.radius, 0.4, h, 0.15);
			// points around a node have its temperature in the mean: those on the warm side pass it a little
			expectSmall(label + std::string("hottest point beyond the pipe, over its warmth"), std::max(0.0, pipe.hottest / warm - 1.0), 0.06);
		}
}

TEST(Cavities, ARegionThatCannotBeMetIsRefused)
{
	const auto refusalOf = [](const Region<2>& region) -> std::string {
		GroundSettings<2> s;
		s.upper       = { 1.0, 1.0 };
		s.gridSpacing = 0.25;
		s.heat.emplace();
		addBoundary<WallTemperature<2>>(s, region, 1.0);
		Ground<2> ground(s);
		fillBox(ground, { 0.0, 0.0 }, { 1.0, 1.0 });
		try {
			ground.initialise();
		} catch (const std::invalid_argument& refusal) {
			return refusal.what();
		}
		return "";
	};
	EXPECT_EQ(refusalOf(Region<2>::disc({ 0.4, 0.4 }, { 0.5, 0.5 })), "") << "a pipe narrower than a cell acts by its share";
	EXPECT_NE(refusalOf(Region<2>::disc({ 4.0, 4.0 }, { 5.0, 5.0 })).find("holds no node"), std::string::npos);
	EXPECT_NE(refusalOf(Region<2>::disc({ 0.4, 0.4 }, { 0.4, 0.5 })).find("a disc needs lower and upper"), std::string::npos);
}
