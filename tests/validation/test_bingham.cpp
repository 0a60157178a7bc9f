// SPDX-License-Identifier: GPL-2.0-or-later
// Flow of a Bingham fluid down a long slope: a plug that rides on a sheared layer.
#include "Report.hpp"
#include "Scenes.hpp"
#include <pkg/mpm/skeleton/BinghamSkeleton.hpp>

#include <gtest/gtest.h>

using namespace talik;
using namespace talik::validation;

namespace {

/// A layer of the depth H that flows along its base under the driving stress w d in the depth d. At rest within itself down to the plug depth tau_y/w;
/// below it u_s - u = w (d - d_plug)^2/(2 mu), with the surface speed u_s = w (H - d_plug)^2/(2 mu). Gravity acts along the base: its part across would
/// add a pressure, which the closed form does not see, and which would drive the ends of a layer of finite length apart.
struct MudFlow {
	double depth = 1.0, length = 14.0, density = 1800.0, gravity = 1.7; // [m], [kg/m^3], [m/s^2]
	double yieldStress = 1200.0, viscosity = 2000.0, young = 1e6;       // [Pa], [Pa s]
	double spacing = 1.0 / 12.0, margin = 2.0;                          // [m]

	double weight() const { return density * gravity; } // along the base [Pa/m]
	double plugDepth() const { return yieldStress / weight(); }
	double speed(double d) const { return weight() * (std::pow(depth - plugDepth(), 2) - std::pow(std::max(0.0, d - plugDepth()), 2)) / (2.0 * viscosity); }
	double middle() const { return margin + 0.5 * length; }

	GroundSettings<2> settings() const
	{
		GroundSettings<2> s;
		s.gridSpacing           = spacing;
		s.upper                 = { length + 2.0 * margin, depth + 6.0 * spacing };
		s.mixture               = withoutExpansion();
		s.mixture.solid.density = density / 0.6;
		s.energyLedger          = false;
		s.motion.emplace();
		s.motion->gravity = { gravity, 0.0 };
		auto law          = std::make_shared<BinghamSkeleton<2>>();
		law->young        = young;
		law->yieldStress  = yieldStress;
		law->viscosity    = viscosity;
		s.skeletons.push_back(law);
		addBoundary<FixedBoundary<2>>(s, Region<2>::side("bottom"));
		return s;
	}
};

/// Mean velocity along the base of each row of points at mid-length, from the surface on: from paths, as a ground is seen to move.
struct Profile {
	std::vector<double> depth, speed;
};

Profile profileOf(Ground<2>& ground, const std::vector<double>& x, const std::vector<double>& y, const MudFlow& mud, double from, double to)
{
	marchTo(ground, from);
	const auto before = valuesOf(ground, "displacement", 0);
	marchTo(ground, to);
	const auto       after = valuesOf(ground, "displacement", 0);
	const double     step  = 0.5 * mud.spacing;
	const auto       rows  = std::size_t(std::lround(mud.depth / step));
	Profile          profile { std::vector<double>(rows), std::vector<double>(rows) };
	std::vector<int> count(rows);
	for (std::size_t k = 0; k < after.size(); ++k) {
		if (std::abs(x[k] - mud.middle()) > 4.0 * mud.spacing) continue;
		const auto row = std::min(rows - 1, std::size_t((mud.depth - y[k]) / step));
		profile.speed[row] += (after[k] - before[k]) / (to - from);
		++count[row];
	}
	for (std::size_t row = 0; row < rows; ++row) {
		profile.depth[row] = (double(row) + 0.5) * step;
		profile.speed[row] /= count[row];
	}
	return profile;
}

/// Depth at which the parabola below the plug begins: the root of u_s - u is linear in depth there.
double plugDepthOf(const Profile& profile, double surfaceSpeed)
{
	double n = 0.0, sx = 0.0, sy = 0.0, sxx = 0.0, sxy = 0.0;
	for (std::size_t row = 0; row < profile.depth.size(); ++row) {
		const double lag = surfaceSpeed - profile.speed[row];
		if (lag < 0.1 * surfaceSpeed || lag > 0.9 * surfaceSpeed) continue;
		const double root = std::sqrt(lag), d = profile.depth[row];
		n += 1.0, sx += d, sy += root, sxx += d * d, sxy += d * root;
	}
	const double slope = (n * sxy - sx * sy) / (n * sxx - sx * sx);
	return (sx - sy / slope) / n;
}

} // namespace

TEST(ValidationBingham, MudFlowsWithThePlugAndTheSurfaceSpeedOfABinghamFluid)
{
	citing("Bingham fluid on a slope (Liu & Mei 1989)");
	const MudFlow mud;
	Ground<2>     ground(mud.settings());
	fillBox(ground, { mud.margin, 0.0 }, { mud.margin + mud.length, mud.depth }, [](PointInput<2>& p) { p.porosity = 0.4; });
	ground.initialise();
	const auto    x = valuesOf(ground, "position", 0), y = valuesOf(ground, "position", 1);
	const Profile profile = profileOf(ground, x, y, mud, 1.4, 1.6); // it starts within some rho H^2/mu/4 = 0.2 s
	Drawing       drawing("bingham", "Mud on a base: velocity", "velocity [m/s]", "depth [m]");
	double        worst = 0.0;
	for (std::size_t row = 0; row < profile.depth.size(); ++row) {
		worst = std::max(worst, std::abs(profile.speed[row] - mud.speed(profile.depth[row])) / mud.speed(0.0));
		drawing.computed("Bingham", profile.speed[row], profile.depth[row]);
		drawing.reference("Bingham", mud.speed(profile.depth[row]), profile.depth[row]);
	}
	const std::string name = "mud on a base, 12 cells deep: ";
	expectRelative(name + "surface speed [m/s]", profile.speed[0], mud.speed(0.0), 0.03);
	expectRelative(name + "plug depth [m]", plugDepthOf(profile, profile.speed[0]), mud.plugDepth(), 0.03);
	expectSmall(name + "largest error of the velocity over that of the surface", worst, 0.03);
}
