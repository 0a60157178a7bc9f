// SPDX-License-Identifier: GPL-2.0-or-later
#pragma once

// Level ground under its own weight that thaws, freezes or both, in the plane and in space.

#include "Scenes.hpp"

#include <cstdio>

namespace talik::validation {

/// A scene.
struct Level {
	static constexpr double gravity = 9.81, day = 86400.0, depth = 2.0, density = 1990.0; ///< [m/s^2], [s], [m], [kg/m^3]

	double         spacing   = 0.25;
	bool           saturated = false;
	bool           fromAbove = true, fromBelow = false;
	bool           cycle      = false; ///< frozen from above before it thaws
	double         thawStrain = 0.0;
	double         scale      = 2e6; ///< calendar time over time of motion
	bool           front      = true;
	FrontConstants constants;
	std::string    words() const
	{
		char text[160];
		std::snprintf(
		        text, sizeof(text), "%s%s, thawed from %s, h = %.3f m%s", saturated ? "saturated" : "dry", cycle ? ", frozen before" : "",
		        fromAbove ? fromBelow ? "both sides" : "above" : "below", spacing, thawStrain > 0.0 ? ", thaw strain 0.05" : "");
		return text;
	}
};

/// What became of it, by row of points from the base.
struct Outcome {
	std::vector<double> sank, distance, stress,
	        due;          ///< [m], distance to the next row over its first [-], total vertical stress and minus the weight above [Pa]
	double surface = 0.0; ///< path of the uppermost row downwards [m]
};

template <int D> GroundSettings<D> levelSettings(const Level& level)
{
	GroundSettings<D> s;
	s.gridSpacing = level.spacing;
	for (int a = 0; a < D; ++a)
		s.upper[a] = a == D - 1 ? Level::depth + 1.0 : 2.0 * level.spacing;
	return s;
}

template <int D> std::vector<std::string> sidesOf()
{
	if constexpr (D == 2) return { "left", "right", "bottom" };
	else return { "left", "right", "front", "back", "bottom" };
}

template <int D> Ground<D> groundOf(const Level& level)
{
	auto s    = levelSettings<D>(level);
	s.mixture = withoutExpansion();
	s.motion.emplace();
	s.motion->gravity[D - 1] = -Level::gravity;
	s.motion->localDamping   = 0.3;
	s.heat.emplace();
	s.heat->thermalTimeScale = level.scale;
	s.freezing               = makeFreezingCurve();
	s.thawFront->constants   = level.constants;
	if (!level.front) s.thawFront.reset();
	if (level.saturated) {
		s.water.emplace();
		s.water->permeability.referenceConductivity = 1e-4;
		s.water->state.liquidBulkModulus            = 2.2e7;
		s.water->state.iceBulkModulus               = 8.8e7;
	}
	if (level.thawStrain > 0.0) {
		SoilMaterial soil;
		soil.mixture    = s.mixture;
		soil.freezing   = s.freezing;
		soil.thawStrain = level.thawStrain;
		if (level.saturated) soil.permeability = s.water->permeability;
		s.materials.push_back(soil);
	}
	auto law           = std::make_shared<MohrCoulombSkeleton<D>>();
	law->young         = 1e7;
	law->youngFrozen   = 2e7;
	law->cohesion      = 2e3;
	law->frictionAngle = 30.0;
	s.skeletons.push_back(law);
	for (const std::string& side : sidesOf<D>())
		s.boundaries.push_back(std::make_shared<RollerBoundary<D>>(Region<D>::side(side)));
	const TimeTable air = level.cycle ? TimeTable({ 0.0, 60.0 * Level::day, 61.0 * Level::day }, { -10.0, -10.0, 10.0 }) : TimeTable(10.0);
	if (level.fromAbove || level.cycle) s.boundaries.push_back(std::make_shared<SurfaceTemperature<D>>(Region<D>::freeSurface(), air));
	if (level.fromBelow) s.boundaries.push_back(std::make_shared<WallTemperature<D>>(Region<D>::side("bottom"), TimeTable(10.0)));
	if (level.saturated) s.boundaries.push_back(std::make_shared<DrainedBoundary<D>>(Region<D>::freeSurface(), TimeTable(0.0)));
	Ground<D>    ground(s);
	const double size = 0.5 * level.spacing;
	const int    rows = int(std::lround(Level::depth / size));
	const auto   add  = [&](Vec<D> x, int row) {
                PointInput<D> p;
                p.position         = x;
                p.position[D - 1]  = (row + 0.5) * size;
                p.volume           = std::pow(size, D);
                p.porosity         = 0.4;
                p.temperature      = level.cycle ? 2.0 : -2.0;
                const double below = Level::depth - p.position[D - 1];
                p.pressure         = level.saturated ? 1000.0 * Level::gravity * below : 0.0;
                for (int a = 0; a < stressSize<D>; ++a)
                        p.stress[a] = a == D - 1 ? -Level::gravity * (Level::density - (level.saturated ? 1000.0 : 0.0)) * below : 0.0;
                for (int a = 0; a < D - 1; ++a)
                        p.stress[a] = 0.5 * p.stress[D - 1];
                if (D == 2) p.stress[2] = p.stress[0];
                ground.addPoint(p);
	};
	for (int row = 0; row < rows; ++row)
		for (int i = 0; i < 4; ++i)
			for (int j = 0; j < (D == 3 ? 4 : 1); ++j) {
				Vec<D> x {};
				x[0] = (i + 0.5) * size;
				if (D == 3) x[1] = (j + 0.5) * size;
				add(x, row);
			}
	return ground;
}

template <int D> Outcome outcomeOf(const Level& level)
{
	Ground<D> ground = groundOf<D>(level);
	ground.initialise();
	const double size  = 0.5 * level.spacing;
	const auto   start = valuesOf(ground, "position", D - 1);
	const auto   walk  = [&](double until) {
                while (ground.time() < until)
                        ground.step(ground.stableTimeStep().step);
	};
	const double cold = level.cycle ? 62.0 * Level::day / level.scale : 0.0;
	walk(cold);
	while (largestSize(valuesOf(ground, "iceSaturation")) > 1e-3 && ground.time() < 120.0)
		walk(ground.time() + 0.05);
	walk(ground.time() + 1.0);
	Outcome    o;
	const auto stress = valuesOf(ground, "stress", D - 1), pressure = level.saturated ? valuesOf(ground, "pressure") : std::vector<double>(start.size()),
	           at  = valuesOf(ground, "position", D - 1);
	const int rows = int(std::lround(Level::depth / size));
	o.sank.assign(rows, 0.0);
	o.stress.assign(rows, 0.0);
	std::vector<int> count(rows, 0);
	for (std::size_t p = 0; p < at.size(); ++p) {
		const int row = int(start[p] / size);
		o.sank[row] += start[p] - at[p];
		o.stress[row] += stress[p] - pressure[p];
		++count[row];
	}
	const auto   b    = ground.balance();
	const double area = std::pow(2.0 * level.spacing, D - 1), total = (b.solidMass + b.waterMass) / area / Level::depth;
	for (int row = 0; row < rows; ++row) {
		o.sank[row] /= count[row];
		o.stress[row] /= count[row];
		o.due.push_back(-Level::gravity * total * (Level::depth - (row + 0.5) * size));
	}
	for (int row = 0; row + 1 < rows; ++row)
		o.distance.push_back(1.0 + (o.sank[row] - o.sank[row + 1]) / size);
	o.surface = o.sank.back();
	return o;
}

} // namespace talik::validation
