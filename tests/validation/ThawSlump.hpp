// SPDX-License-Identifier: GPL-2.0-or-later
#pragma once

// The slope of Yu & Zhao with a Mohr-Coulomb law on coarse cells, thawed from its surface (Case I) or from a part of its base (Case II).

#include "Scenes.hpp"

#include <functional>

namespace talik::validation {

struct ThawSlump {
	static constexpr double spacing = 0.5, day = 86400.0, scale = 8.64e5; ///< [m], [s], f_T: a second of motion is ten days

	bool                                    fromBase = false;
	double                                  cohesion = 0.0; ///< of thawed ground [Pa]
	std::function<void(GroundSettings<2>&)> change;         ///< of the settings
};

/// Height of the slope at x [m].
inline double heightOf(double x) { return x < 3.0 ? 4.0 : x < 6.0 ? 7.0 - x : 1.0; }

inline Ground<2> groundOf(const ThawSlump& slump)
{
	const double      h = ThawSlump::spacing;
	GroundSettings<2> s;
	s.gridSpacing = h;
	s.upper       = { 10.0, 5.0 };
	s.mixture     = withoutExpansion();
	s.motion.emplace();
	s.motion->gravity      = { 0.0, -9.81 };
	s.motion->localDamping = 0.02;
	s.motion->picTime      = 4.0 * gravityTime(h, 9.81);
	s.heat.emplace();
	s.heat->thermalTimeScale = ThawSlump::scale;
	s.freezing               = makeFreezingCurve();
	s.water.emplace();
	s.water->permeability.referenceConductivity = 1e-4;
	s.water->state.liquidBulkModulus            = 5.5e6;
	s.water->state.iceBulkModulus               = 2.2e7;
	auto law                                    = std::make_shared<MohrCoulombSkeleton<2>>();
	law->young                                  = 4e6;
	law->youngFrozen                            = 2e7;
	law->cohesion                               = slump.cohesion;
	law->tensileStrength                        = 0.5 * slump.cohesion;
	law->frictionAngle                          = 16.0; // of samples in simple shear
	s.skeletons                                 = { law };
	for (const char* side : { "left", "right" })
		addBoundary<RollerBoundary<2>>(s, Region<2>::side(side));
	addBoundary<FixedBoundary<2>>(s, Region<2>::side("bottom"));
	addBoundary<DrainedBoundary<2>>(s, Region<2>::freeSurface());
	if (slump.fromBase) addBoundary<WallTemperature<2>>(s, Region<2>::side("bottom").within({ 2.0, -1.0 }, { 6.0, 1.0 }), 10.0);
	else addBoundary<SurfaceTemperature<2>>(s, Region<2>::freeSurface(), 10.0);
	if (slump.change) slump.change(s);
	Ground<2> ground(s);
	for (double y = 0.25 * h; y < 4.0; y += 0.5 * h)
		for (double x = 0.25 * h; x < 10.0; x += 0.5 * h) {
			if (y > heightOf(x)) continue;
			PointInput<2> p;
			p.position         = { x, y };
			p.volume           = 0.25 * h * h;
			p.porosity         = 0.4;
			p.temperature      = -5.0;
			const double below = heightOf(x) - y, vertical = -9.81 * (0.6 * 2650.0 + 0.4 * 920.0) * below;
			p.stress = { 0.7 * vertical, vertical, 0.7 * vertical, 0.0 };
			ground.addPoint(p);
		}
	return ground;
}

/// Largest displacement after so many days of thaw [m].
inline double pathOf(const ThawSlump& slump, double days)
{
	Ground<2> ground = groundOf(slump);
	ground.initialise();
	const double end = days * ThawSlump::day / ThawSlump::scale;
	while (ground.time() < end)
		ground.step(std::min(ground.stableTimeStep().step, end - ground.time()));
	const auto x = valuesOf(ground, "displacement", 0), y = valuesOf(ground, "displacement", 1);
	double     largest = 0.0;
	for (std::size_t p = 0; p < x.size(); ++p)
		largest = std::max(largest, std::hypot(x[p], y[p]));
	return largest;
}

} // namespace talik::validation
