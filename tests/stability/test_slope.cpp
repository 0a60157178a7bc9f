// SPDX-License-Identifier: GPL-2.0-or-later
// A whole slope in small, with every effect of the ground; also the scene that runs under valgrind (memcheck.sh).
#include "Held.hpp"
#include "Report.hpp"
#include "WetScenes.hpp"

#include <gtest/gtest.h>

using namespace talik;
using namespace talik::stability;
using namespace talik::validation;

TEST(Slope, ThawsAndMovesWithEveryEffectOfTheGroundInBalance)
{
	auto s              = everyEffect(0.5, { 4.0, 3.5 }, 8.64e5);
	s.deformationRecord = true;
	auto soil           = std::make_shared<MohrCoulombSkeleton<2>>();
	soil->young         = 5e6;
	soil->cohesion      = 100.0;
	s.skeletons         = { soil, elasticOedometer(2e8) };
	for (const char* side : { "left", "right" })
		addBoundary<RollerBoundary<2>>(s, Region<2>::side(side));
	addBoundary<FixedBoundary<2>>(s, Region<2>::side("bottom"));
	addBoundary<DrainedBoundary<2>>(s, Region<2>::freeSurface());
	addBoundary<SurfaceTemperature<2>>(s, Region<2>::freeSurface(), TimeTable({ 0.0, 0.01 * 8.64e5 }, { -1.0, 15.0 }));
	addBoundary<WallTemperature<2>>(s, Region<2>::side("bottom"), -1.0);
	Ground<2> ground(s);
	for (int j = 0; j < 10; ++j)
		for (int i = 0; i < 16 && (i + 0.5) * 0.25 + (j + 0.5) * 0.25 < 4.0; ++i) {
			PointInput<2> p;
			p.position    = { (i + 0.5) * 0.25, (j + 0.5) * 0.25 };
			p.volume      = 0.0625;
			p.temperature = -1.0;
			p.skeleton    = j < 2;
			ground.addPoint(p);
		}
	ground.initialise();
	const double ice = ground.balance().iceMass;
	Watch<2>     watch(ground);
	watch.run(1500, 50);
	Limits open;
	open.energy            = INFINITY; // water takes energy along through the surface
	const std::string name = "thawing slope in small";
	expectHeld(name, watch.figures(), open);
	expectAtLeast(name + ": ice melted [kg]", ice - ground.balance().iceMass, 1.0);
	EXPECT_GT(watch.figures().kineticPeak, 0.0);
}
