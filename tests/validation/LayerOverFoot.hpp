// SPDX-License-Identifier: GPL-2.0-or-later
#pragma once

// A thawed layer on a frozen face of 45 degrees that ends on level ground.

#include "Scenes.hpp"

#include <algorithm>

namespace talik::validation {

/// The origin is the toe, where face and bench meet; the face rises to the left.
struct Face {
	static constexpr double gravity = 9.81;

	double thickness = 0.5;    ///< X of the thawed layer, normal to the face and to the bench [m]
	double height    = 3.0;    ///< of the face [m]
	double bench     = 1.0;    ///< height of the bench above the base of the box [m]
	double friction  = 26.0;   ///< phi [degrees]; no dilation
	double cohesion  = 1e3;    ///< of thawed ground [Pa]
	double density   = 1990.0; ///< [kg/m^3]

	double length() const { return height * std::sqrt(2.0); }
	/// Point at a distance from the crest along the face and a depth normal to it.
	Vec<2> onFace(double along, double depth) const
	{
		const double left = (along - length()) / std::sqrt(2.0), down = depth / std::sqrt(2.0);
		return { left - down, -left - down };
	}
	/// Distance from the face and the bench.
	double depthBelowSurface(const Vec<2>& x) const
	{
		const double onFace = std::clamp(along(x), 0.0, length()), onBench = std::max(0.0, x[0]);
		const Vec<2> p = this->onFace(onFace, 0.0);
		return std::min(std::hypot(x[0] - p[0], x[1] - p[1]), std::hypot(x[0] - onBench, x[1]));
	}
	double along(const Vec<2>& x) const { return length() + (x[0] - x[1]) / std::sqrt(2.0); }
};

/// Acceleration with which the layer begins to move [m/s^2]: the best field of 16 cells over its thickness, by rigid_plastic_layer.py beside this file.
/// Two rigid blocks, one way to move among many, have 1.52.
constexpr double accelerationOverFoot = 1.62;

/// In Talik: twice the mean path of the middle of the face after some time [s], over its square. It comes to rest with four times the cohesion.
/// change: of the settings.
inline double acceleration(const Face& face, double spacing, double duration, const std::function<void(GroundSettings<2>&)>& change = {})
{
	const double      crest = 3.0;
	const Vec<2>      toe   = { crest + face.height, face.bench };
	GroundSettings<2> s;
	s.gridSpacing = spacing;
	s.upper       = { toe[0] + 4.0, face.bench + face.height + 1.0 };
	s.mixture     = withoutExpansion();
	s.motion.emplace();
	s.motion->gravity      = { 0.0, -Face::gravity };
	s.motion->localDamping = 0.7;
	s.heat.emplace();
	s.freezing                 = makeFreezingCurve();
	auto law                   = std::make_shared<MohrCoulombSkeleton<2>>();
	law->young                 = 20e6;
	law->youngFrozen           = 100e6;
	law->frictionAngle         = face.friction;
	law->cohesionFrozen        = 50e6;
	law->tensileStrengthFrozen = 50e6;
	law->cohesion              = 4.0 * face.cohesion;
	law->tensileStrength       = 0.5 * law->cohesion;
	s.skeletons.push_back(law);
	addBoundary<RollerBoundary<2>>(s, Region<2>::side("left"));
	addBoundary<RollerBoundary<2>>(s, Region<2>::side("right"));
	addBoundary<FixedBoundary<2>>(s, Region<2>::side("bottom"));
	if (change) change(s);
	Ground<2>        ground(s);
	std::vector<int> middle;
	int              id   = 0;
	const double     size = 0.5 * spacing;
	for (double y = 0.5 * size; y < s.upper[1]; y += size)
		for (double x = 0.5 * size; x < s.upper[0]; x += size) {
			const Vec<2> at    = { x - toe[0], y - toe[1] };
			const double above = std::clamp(-at[0], 0.0, face.height) - at[1], depth = face.depthBelowSurface(at), along = face.along(at);
			if (above < 0.0 || (depth < face.thickness && along < 0.5 * face.thickness)) continue;
			PointInput<2> p;
			p.position          = { x, y };
			p.volume            = size * size;
			p.porosity          = 0.4;
			p.temperature       = depth < face.thickness ? 5.0 : -10.0;
			const double weight = -face.density * Face::gravity * above;
			p.stress            = { 0.5 * weight, weight, 0.5 * weight, 0.0 };
			ground.addPoint(p);
			if (depth < face.thickness && std::abs(along / face.length() - 0.5) < 0.2) middle.push_back(id);
			++id;
		}
	ground.initialise();
	const auto path = [&] {
		const auto x = valuesOf(ground, "displacement", 0), y = valuesOf(ground, "displacement", 1);
		double     sum = 0.0;
		for (const int k : middle)
			sum += (x[k] - y[k]) / std::sqrt(2.0);
		return sum / double(middle.size());
	};
	marchTo(ground, 0.8);
	const double atRest                    = path();
	ground.settings().motion->localDamping = 0.0;
	law->cohesion                          = face.cohesion;
	law->tensileStrength                   = 0.5 * face.cohesion;
	marchTo(ground, 0.8 + duration);
	return 2.0 * (path() - atRest) / (duration * duration);
}

} // namespace talik::validation
