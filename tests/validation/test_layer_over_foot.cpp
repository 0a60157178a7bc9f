// SPDX-License-Identifier: GPL-2.0-or-later
// A thawed layer on a frozen face of 45 degrees that ends on level ground: it moves as fast as its foot lets it shear out, against rigid blocks.
#include "References.hpp"
#include "Report.hpp"
#include "Scenes.hpp"

#include <gtest/gtest.h>

#include <algorithm>

using namespace talik;
using namespace talik::validation;
using talik::reference::pi;

namespace {

constexpr double gravity = 9.81;

/// The origin is the toe, where face and bench meet; the face rises to the left.
struct Face {
	double thickness = 0.5;    ///< X of the thawed layer, normal to the face and to the bench [m]
	double height    = 3.0;    ///< of the face [m]
	double bench     = 1.0;    ///< height of the bench above the base of the box [m]
	double friction  = 26.0;   ///< phi [degrees]; no dilation
	double cohesion  = 1e3;    ///< of thawed ground [Pa]
	double density   = 1990.0; ///< [kg/m^3]

	double length() const { return height * std::sqrt(2.0); }
	/// tau over sigma_n, and the cohesion [Pa], with which simple shear goes on without dilation (Davis 1968).
	double ratio() const { return std::sin(friction * pi / 180.0); }
	double shearCohesion() const { return cohesion * std::cos(friction * pi / 180.0); }
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

Vec<2> direction(double angle) { return { std::cos(angle), std::sin(angle) }; }
double cross(const Vec<2>& a, const Vec<2>& b) { return a[0] * b[1] - a[1] * b[0]; }
Vec<2> minus(const Vec<2>& a, const Vec<2>& b) { return { a[0] - b[0], a[1] - b[1] }; }
double areaOf(const std::vector<Vec<2>>& corners)
{
	double sum = 0.0;
	for (std::size_t k = 0; k < corners.size(); ++k)
		sum += cross(corners[k], corners[(k + 1) % corners.size()]);
	return 0.5 * std::abs(sum);
}

/// Acceleration of two rigid blocks: the layer slides down its base from the crest to `foot` [m along the face], and pushes a wedge out on a line that
/// falls by `exit` below the horizontal there, past an interface that leans back by `lean` from the normal of the face [radians]. Zero where they
/// cannot move so. The blocks move at the angle of friction to each line (normality, with the strength of Davis), so that all work of friction is in
/// c |dv| cos(angle); with v the velocity of the layer, power of gravity less that work is what M_A v dv/dt + M_B v_B dv_B/dt takes up.
double accelerationOfBlocks(const Face& face, double foot, double exit, double lean)
{
	const double angle = std::atan(face.ratio()), X = face.thickness;
	const Vec<2> p = face.onFace(foot, X), back = face.onFace(foot - X * std::tan(lean), 0.0), toe = {};
	const Vec<2> line = direction(-exit);
	if (!(face.along(back) > 0.0) || face.along(back) > face.length() || p[1] < -X) return 0.0;
	// to the face above the toe, or to the bench beyond it
	const double toFace = -(p[0] + p[1]) / (line[0] + line[1]), onFace = p[1] + toFace * line[1];
	const double reach = onFace >= 0.0 ? toFace : -p[1] / line[1];
	if (!(reach > 0.0)) return 0.0;
	const Vec<2> out = { p[0] + reach * line[0], p[1] + reach * line[1] };
	if (face.along(out) < face.along(back) || (onFace < 0.0 && out[0] < 0.0)) return 0.0;
	std::vector<Vec<2>> wedge = { p, out };
	if (onFace < 0.0) wedge.push_back(toe);
	wedge.push_back(back);
	const Vec<2> interface = minus(back, p);
	const Vec<2> layer = direction(angle - 0.25 * pi), past = direction(std::atan2(interface[1], interface[0]) - angle), wedgeWay = direction(angle - exit);
	const double all = cross(wedgeWay, past);
	if (all == 0.0) return 0.0;
	// layer + slip * past = speed * wedgeWay
	const double speed = cross(layer, past) / all, slip = cross(layer, wedgeWay) / all;
	if (!(speed > 0.0) || !(slip > 0.0)) return 0.0;
	const double layerArea = areaOf({ face.onFace(0.0, 0.0), back, p, face.onFace(0.0, X) }), wedgeArea = areaOf(wedge);
	const double power = -face.density * gravity * (layerArea * layer[1] + wedgeArea * speed * wedgeWay[1]);
	const double work  = face.shearCohesion() * std::cos(angle) * (foot + slip * lengthOf<2>(interface) + speed * reach);
	return (power - work) / (face.density * (layerArea + wedgeArea * speed * speed));
}

/// Largest acceleration of such blocks [m/s^2].
double accelerationOfBlocks(const Face& face)
{
	constexpr int steps  = 60;
	const double  degree = pi / 180.0;
	double        best   = 0.0;
	for (int i = 1; i <= steps; ++i)
		for (double exit = -40.0; exit <= 40.0; exit += 2.0)
			for (double lean = -60.0; lean <= 75.0; lean += 3.0)
				best = std::max(
				        best, accelerationOfBlocks(face, face.length() - 3.0 * face.thickness * i / steps, exit * degree, lean * degree));
	return best;
}

/// The same in Talik: twice the mean path of the middle of the face after some time [s], over its square. It comes to rest with four times the cohesion.
double acceleration(const Face& face, double spacing, double duration)
{
	const double      crest = 3.0;
	const Vec<2>      toe   = { crest + face.height, face.bench };
	GroundSettings<2> s;
	s.gridSpacing = spacing;
	s.upper       = { toe[0] + 4.0, face.bench + face.height + 1.0 };
	s.mixture     = withoutExpansion();
	s.motion.emplace();
	s.motion->gravity      = { 0.0, -gravity };
	s.motion->localDamping = 0.7;
	s.heat.emplace();
	s.freezing                 = makeFreezingCurve();
	auto law                   = std::make_shared<MohrCoulombSkeleton<2>>();
	law->youngModulus          = 20e6;
	law->youngModulusFrozen    = 100e6;
	law->frictionAngle         = face.friction;
	law->cohesionFrozen        = 50e6;
	law->tensileStrengthFrozen = 50e6;
	law->cohesion              = 4.0 * face.cohesion;
	law->tensileStrength       = 0.5 * law->cohesion;
	s.skeletons.push_back(law);
	addBoundary<RollerBoundary<2>>(s, Region<2>::side("left"));
	addBoundary<RollerBoundary<2>>(s, Region<2>::side("right"));
	addBoundary<FixedBoundary<2>>(s, Region<2>::side("bottom"));
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
			const double weight = -face.density * gravity * above;
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
		return sum / static_cast<double>(middle.size());
	};
	marchTo(ground, 0.8);
	const double atRest                    = path();
	ground.settings().motion->localDamping = 0.0;
	law->cohesion                          = face.cohesion;
	law->tensileStrength                   = 0.5 * face.cohesion;
	marchTo(ground, 0.8 + duration);
	return 2.0 * (path() - atRest) / (duration * duration);
}

void expectToLeave(double cellsThick, double tolerance)
{
	citing("rigid blocks; Davis 1968");
	const Face face;
	char       text[160];
	std::snprintf(text, sizeof(text), "thawed layer that leaves a face of 45 degrees over its foot: X/h = %.0f, acceleration [m/s^2]", cellsThick);
	expectRelative(text, acceleration(face, face.thickness / cellsThick, 0.5), accelerationOfBlocks(face), tolerance);
}

} // namespace

// The layer shears through itself at the foot, across two cells or more: that band, not the front, is what coarse cells make too strong.
TEST(LayerOverFoot, AcceleratesAsRigidBlocksDo)
{
	expectToLeave(2.0, 0.45);
	expectToLeave(4.0, 0.15);
}

TEST(LayerOverFoot, AcceleratesAsRigidBlocksDoOnAFineGrid_slow) { expectToLeave(8.0, 0.15); }
