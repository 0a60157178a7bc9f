// SPDX-License-Identifier: GPL-2.0-or-later
#pragma once

// Frozen ground that weighs upon a thawed layer.

#include "Slab.hpp"

#include <functional>
#include <memory>

namespace talik::validation {

/// Frozen ground without cohesion when thawed on a thawed layer of some rows of points on a rough floor; gravity at an angle to the layer.
class Roof {
public:
	static constexpr double spacing = 0.1, gravity = 9.81, friction = 26.0;

	/// height of the frozen ground over the layer, from and to: its ends, upper: of the box [m]; tilt of gravity [degrees]; whether there is
	/// ground at a place, and whether it is thawed; change: of the settings.
	Roof(int rows, double height, double from, double to, const Vec<2>& upper, double tilt, const std::function<bool(double x, double y)>& thawed,
	     const std::function<bool(double x, double y)>& empty, const std::function<void(GroundSettings<2>&)>& change = {})
	        : layer_(0.5 * rows * spacing)
	{
		GroundSettings<2> s;
		s.gridSpacing = spacing;
		s.upper       = upper;
		s.motion.emplace();
		s.motion->gravity = { gravity * std::sin(Slab::radians(tilt)), -gravity * std::cos(Slab::radians(tilt)) };
		s.heat.emplace();
		s.freezing    = makeFreezingCurve();
		auto law      = std::make_shared<MohrCoulombSkeleton<2>>();
		law->cohesion = 0.0, law->frictionAngle = friction;
		s.skeletons = { law };
		for (const char* side : { "left", "right" })
			addBoundary<RollerBoundary<2>>(s, Region<2>::side(side));
		addBoundary<FixedBoundary<2>>(s, Region<2>::side("bottom"));
		if (change) change(s);
		ground_              = std::make_unique<Ground<2>>(s);
		const double density = (1.0 - Slab::porosity) * 2650.0 + Slab::porosity * 1000.0, top = layer_ + height;
		for (double y = 0.25 * spacing; y < top; y += 0.5 * spacing)
			for (double x = from + 0.25 * spacing; x < to; x += 0.5 * spacing) {
				if (empty(x, y)) continue;
				PointInput<2> p;
				p.position          = { x, y };
				p.volume            = 0.25 * spacing * spacing;
				p.temperature       = y < layer_ && thawed(x, y) ? 5.0 : -10.0;
				const double weight = density * s.motion->gravity[1] * (top - y);
				p.stress            = { 0.5 * weight, weight, 0.5 * weight, 0.0 };
				ground_->addPoint(p);
			}
		ground_->initialise();
	}
	/// Mean path along the layer of points that started between two heights and near a place [m].
	double path(double duration, double lower, double upper, double middle, double near)
	{
		marchTo(*ground_, duration);
		const auto ux = valuesOf(*ground_, "displacement", 0), uy = valuesOf(*ground_, "displacement", 1);
		const auto x = valuesOf(*ground_, "position", 0), y = valuesOf(*ground_, "position", 1);
		double     sum = 0.0, count = 0.0;
		for (std::size_t k = 0; k < x.size(); ++k)
			if (y[k] - uy[k] > lower && y[k] - uy[k] < upper && std::abs(x[k] - ux[k] - middle) < near) {
				sum += ux[k];
				++count;
			}
		return sum / count;
	}
	double layer() const { return layer_; }

private:
	double                     layer_;
	std::unique_ptr<Ground<2>> ground_;
};

/// Path in 0.5 s, over its thickness, of a thawed layer of some rows of points under 0.8 m of frozen ground that its own weight pushes towards a gap.
inline double pathUnderRoof(int rows, const std::function<void(GroundSettings<2>&)>& change = {})
{
	const double X = 0.5 * rows * Roof::spacing, from = 0.4, to = from + 20.0 * X, end = to + 0.8;
	Roof         scene(
	                rows, 0.8, 0.0, end, { end, 1.4 }, 30.0, [&](double x, double) { return x > from && x < to; },
	                [&](double x, double y) { return y < X && x > to && x < to + 0.4; }, change);
	return scene.path(0.5, 0.0, X, 0.5 * (from + to), 3.0 * X) / X;
}

} // namespace talik::validation
