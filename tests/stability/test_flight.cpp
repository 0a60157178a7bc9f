// SPDX-License-Identifier: GPL-2.0-or-later
// Case 6: ground that has lost its support.
#include "Held.hpp"
#include "Report.hpp"
#include "WetScenes.hpp"

#include <gtest/gtest.h>

using namespace talik;
using namespace talik::stability;
using namespace talik::validation;

// Found in an example: points that flew on within their strip of cells came into rows that were not cleared, met the masses and
// divergences of all steps before, and one step made forty volumes of one. A wet block with a hot surface died of it in mid-air.
TEST(Flight, AWetBlockWithAHotSurfaceFliesTwentyMetresInOnePiece)
{
	constexpr double  speed = 20.0;
	GroundSettings<2> s;
	s.gridSpacing = 0.25;
	s.upper       = { 22.0, 2.0 };
	s.motion.emplace();
	s.heat.emplace();
	s.heat->thermalTimeScale = 1e4;
	s.water                  = softWater();
	s.skeletons.push_back(elasticOedometer(5e6));
	addBoundary<SurfaceTemperature<2>>(s, Region<2>::freeSurface(), 20.0);
	Ground<2> ground(s);
	fillBox(ground, { 0.5, 0.5 }, { 1.0, 1.0 }, [](PointInput<2>& p) {
		p.temperature = 1.0;
		p.velocity    = { speed, 0.0 };
	});
	ground.initialise();
	Watch<2>     watch(ground);
	const double energy = ground.balance().kineticEnergy;
	watch.run(2100);
	const std::string name = "wet block in flight, 20 m/s, surface 20 degC above it";
	expectHeld(name, watch.figures(), { INFINITY, 1e-13, 1e-12, 1e-11 });
	expectSmall(name + ": kinetic energy gained", watch.figures().kineticPeak / energy - 1.0, 1e-9);
	expectSmall(name + ": largest change of a volume", watch.figures().strain, 1e-2);
}
