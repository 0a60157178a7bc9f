// SPDX-License-Identifier: GPL-2.0-or-later
#pragma once
// Small slopes with all effects that a ground may have; tests run them on threads, on ranks, through checkpoints and in two builds.

#include "groundState.hpp"
#include "threadRanks.hpp"

#include <pkg/mpm/boundary/Boundaries.hpp>
#include <pkg/mpm/effects/RigidContact.hpp>
#include <pkg/mpm/Ground.hpp>
#include <pkg/mpm/skeleton/ElasticSkeleton.hpp>
#include <pkg/mpm/skeleton/MohrCoulombSkeleton.hpp>

#include <cmath>

namespace talik {

struct Scene {
	const char*      name;
	bool             heat = false, water = false, freezing = false, bBar = true;
	VelocityTransfer transfer = VelocityTransfer::flip;
	bool             bodies = false, calendar = false, walls = false;
	double           thawStrain  = 0.0; ///< above 0: soil that is compressible once it has thawed
	double           segregation = 0.0; ///< potential [m^2/(s K)]; infinite: computed, with a lens behind its fringe
	int              columns     = 0;   ///< of points, along the slope; 0: all that have room
	bool             implicit    = false;
	bool             periodic = false, axisymmetric = false; ///< periodic: left and right are joined, and ground fills the box between them
	bool             divide = false;                         ///< one point a cell in a slope that is drawn out
	bool             fills  = false;                         ///< one point a cell
};

/// Two soils, a wall that moves in, rain, and boundaries that act in boxes, on discs and on a side, across the borders of strips.
template <int D> void addWalls(GroundSettings<D>& s)
{
	Vec<D> low = Region<D>::filled(0.12), high = Region<D>::filled(0.48), direction {};
	low[0]          = 0.9;
	high[0]         = 2.1;
	direction[0]    = 1.0;
	s.boundaries[0] = std::make_shared<MovingBoundary<D>>(Region<D>::side("left"), TimeTable(0.3), direction, false);
	SoilMaterial sand;
	sand.mixture                    = s.mixture;
	sand.permeability               = s.water->permeability;
	SoilMaterial silt               = sand;
	silt.mixture.solid.conductivity = 1.5;
	s.materials                     = { sand, silt };
	s.boundaries.back()             = std::make_shared<WaterFlux<D>>(Region<D>::freeSurface(), 1e-7, 3.0);
	s.boundaries.push_back(std::make_shared<HeatFlux<D>>(Region<D>::side("left"), 5.0));
	s.boundaries.push_back(std::make_shared<HeatSource<D>>(Region<D>::disc(low, high), 20.0));
	s.boundaries.push_back(std::make_shared<WallTemperature<D>>(Region<D>::nodeBox(low, high), 0.5));
	s.boundaries.push_back(std::make_shared<Traction<D>>(Region<D>::nodeBox(low, high), 0.0, std::vector<TimeTable>(D, TimeTable(10.0))));
}

/// A slope that slides along the grid's longest axis, so that points cross strips; with heat it is warmed from above and from a wall, with
/// water it drains and is rained on.
template <int D> std::unique_ptr<Ground<D>> slope(const Scene& scene, const std::shared_ptr<Communicator>& communicator)
{
	constexpr double  h = 0.1, day = 86400.0;
	GroundSettings<D> s;
	s.gridSpacing = h;
	s.lower.fill(0.0);
	s.upper.fill(D == 2 ? 1.2 : 0.8);
	s.upper[0]     = D == 2 ? 3.8 : 3.0; // neither is a whole number of strips
	s.parallelFrom = 0;
	s.motion.emplace();
	s.motion->gravity[D - 1] = -9.81;
	s.motion->localDamping   = 0.05;
	s.motion->transfer       = scene.transfer;
	s.motion->bBar           = scene.bBar;
	s.energyLedger           = true;
	s.deformationRecord      = true;
	s.pointsDivide           = scene.divide;
	auto rock                = std::make_shared<ElasticSkeleton<D>>();
	rock->young              = 5e6;
	auto soil                = std::make_shared<MohrCoulombSkeleton<D>>();
	soil->young              = 2e6;
	soil->youngFrozen        = 2e7;
	s.skeletons              = { rock, soil };
	s.boundaries = { std::make_shared<RollerBoundary<D>>(Region<D>::side("left")), std::make_shared<RollerBoundary<D>>(Region<D>::side("right")),
		         std::make_shared<FixedBoundary<D>>(Region<D>::side("bottom")),
		         std::make_shared<Traction<D>>(Region<D>::freeSurface(), TimeTable({ 0.0, day }, { 0.0, 2e3 })) };
	if (scene.periodic) {
		s.boundaries.erase(s.boundaries.begin());
		s.boundaries[0]      = std::make_shared<PeriodicBoundary<D>>(Region<D>::side("right"));
		s.motion->gravity[0] = 4.0;
	}
	if (scene.axisymmetric) {
		s.axisymmetric = true;
		s.thawFront.reset();
	}
	if (scene.heat) {
		s.heat.emplace();
		s.heat->thermalTimeScale = 1e5;
		s.heat->source           = 3.0;
		s.heat->followsMotion    = scene.calendar;
		s.boundaries.push_back(std::make_shared<SurfaceTemperature<D>>(Region<D>::freeSurface(), TimeTable({ 0.0, 1e3 }, { -2.0, 10.0 })));
		s.boundaries.push_back(std::make_shared<WallTemperature<D>>(Region<D>::side("bottom"), 4.0));
	}
	if (scene.freezing) s.freezing = makeFreezingCurve();
	if (scene.water) {
		s.water.emplace();
		s.water->state.liquidBulkModulus = 2.2e7;
		s.water->state.iceBulkModulus    = 8.8e7;
		s.boundaries.push_back(std::make_shared<DrainedBoundary<D>>(Region<D>::freeSurface()));
	}
	if (scene.implicit) s.water->implicit = true;
	if (scene.walls) addWalls(s);
	if (scene.thawStrain > 0.0) {
		SoilMaterial silt;
		silt.mixture                     = s.mixture;
		silt.thawStrain                  = scene.thawStrain;
		silt.compression.compressibility = 1e-6;
		if (s.water) silt.permeability = s.water->permeability;
		s.materials = { silt };
	}
	if (scene.segregation > 0.0) {
		s.segregation.emplace();
		if (!std::isinf(scene.segregation)) s.segregation->segregationPotential = scene.segregation;
	}
	if (scene.bodies) {
		s.bodies.emplace();
		if (scene.heat) s.boundaries.push_back(std::make_shared<HeatFlux<D>>(Region<D>::facing({ 0 }), 300.0));
	}
	auto               ground = std::make_unique<Ground<D>>(s);
	std::array<int, D> n, i {};
	const bool         one  = scene.divide || scene.fills;
	const double       size = one ? h : 0.5 * h;
	for (int a = 0; a < D; ++a)
		n[a] = one ? (a > 0 ? 6 : scene.divide ? 14 : 31) : a == 0 ? (scene.columns ? scene.columns : D == 2 ? 62 : 50) : D == 2 ? 14 : 10;
	for (int a = 0; a < D;) {
		PointInput<D> p;
		p.volume = std::pow(size, D);
		for (int b = 0; b < D; ++b)
			p.position[b] = size * (i[b] + 0.5);
		p.temperature = p.position[0] < 1.1 ? -2.0 : 1.0;
		p.material    = scene.walls && p.position[D - 1] < 0.2 ? 1 : 0;
		p.velocity[0] = scene.divide ? 25.0 * p.position[0] : (scene.periodic ? 10.0 : D == 2 ? 3.0 : 8.0) * p.position[D - 1];
		p.skeleton    = p.position[D - 1] > 0.25 ? 1 : 0;
		ground->addPoint(p);
		for (a = 0; a < D && ++i[a] == n[a]; ++a)
			i[a] = 0;
	}
	if (communicator) ground->distribute(communicator);
	ground->initialise();
	if (!scene.bodies) return ground;
	RigidBody<D> ball;
	ball.id = ball.group = 0;
	ball.shape           = &rigidBall<D>();
	ball.size.fill(0.3);
	ball.position.fill(0.4);
	ball.position[0]     = 0.8; // across the border of two strips
	ball.position[D - 1] = D == 2 ? 0.98 : 0.78;
	ball.friction        = 0.3;
	for (int a = 0; a < D; ++a)
		ball.axes[a][a] = 1.0;
	ball.velocity[D - 1]     = -1.0;
	ground->bodies()->bodies = { ball };
	return ground;
}

inline const Scene dry { "dry" }, dryApic { "dry, apic", false, false, false, false, VelocityTransfer::apic }, warm { "heat", true },
        wet { "water", false, true }, frozen { "heat, freezing, thaw front", true, false, true }, all { "heat, water, freezing, thaw front", true, true, true },
        allOwn { "the same without means of cells, apic", true, true, true, false, VelocityTransfer::apic },
        withWalls { "all, two soils, a moving wall, rain, sources", true, true, true, true, VelocityTransfer::flip, false, true, true },
        iceRich { "heat, freezing, thaw strain", true, false, true, true, VelocityTransfer::flip, false, false, false, 0.1 },
        iceRichWet { "all, thaw strain", true, true, true, true, VelocityTransfer::flip, false, true, false, 0.1 },
        iceRichOwn { "all, thaw strain without means of cells", true, true, true, false, VelocityTransfer::apic, false, false, false, 0.1 },
        heaving { "all, ice segregation", true, true, true, true, VelocityTransfer::flip, false, false, false, 0.0, 1e-9 },
        heavingComputed { "all, computed ice segregation", true, true, true, true, VelocityTransfer::flip, false, false, false, 0.0, INFINITY },
        withBall { "all, a ball, a calendar that follows the motion", true, true, true, true, VelocityTransfer::flip, true, true };

inline Scene withDivision(Scene scene, const char* name)
{
	scene.name   = name;
	scene.divide = true;
	return scene;
}

inline Scene fillingCells(Scene scene, const char* name)
{
	scene.name  = name;
	scene.fills = true;
	return scene;
}

inline Scene withImplicitPressure(Scene scene, const char* name)
{
	scene.name     = name;
	scene.implicit = true;
	return scene;
}

/// From side to side in the plane.
inline Scene withoutEnds(Scene scene, const char* name)
{
	scene.name     = name;
	scene.periodic = true;
	scene.columns  = 76;
	return scene;
}

inline Scene aboutAxis(Scene scene, const char* name)
{
	scene.name         = name;
	scene.axisymmetric = true;
	return scene;
}

inline const Scene aroundAxis      = aboutAxis(frozen, "heat, freezing, about an axis");
inline const Scene wetImplicit     = withImplicitPressure(wet, "water, implicit pressure"),
                   allImplicit     = withImplicitPressure(all, "heat, water, freezing, thaw front, implicit pressure"),
                   wallImplicit    = withImplicitPressure(withWalls, "all, two soils, a moving wall, rain, sources, implicit pressure"),
                   heavingImplicit = withImplicitPressure(heavingComputed, "all, computed ice segregation, implicit pressure"),
                   dividing        = withDivision(heavingComputed, "all, computed ice segregation, points that divide"),
                   fillingImplicit = fillingCells(allImplicit, "heat, water, freezing, thaw front, implicit pressure, one point a cell"),
                   axisImplicit    = aboutAxis(wetImplicit, "water, implicit pressure, about an axis"),
                   ballImplicit    = withImplicitPressure(withBall, "all, a ball, a calendar that follows the motion, implicit pressure");

} // namespace talik
