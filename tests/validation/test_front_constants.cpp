// SPDX-License-Identifier: GPL-2.0-or-later
// Each constant of the thaw front taken away, halved and doubled, on slabs, level ground and random columns: what it is there for, as a table.
#include "LayerOverFoot.hpp"
#include "LevelGround.hpp"
#include "Report.hpp"
#include "Roof.hpp"
#include "Slab.hpp"
#include "ThawSlump.hpp"

#include <gtest/gtest.h>

#include <algorithm>
#include <cstdio>

using namespace talik;
using namespace talik::validation;

namespace {

/// The thaw front with some of its constants changed.
struct Variant {
	const char*    name;
	FrontConstants constants;
};

FrontConstants with(double FrontConstants::*constant, double value)
{
	FrontConstants changed;
	changed.*constant = value;
	return changed;
}

FrontConstants withFill(double nearlyFull, double full)
{
	FrontConstants changed;
	changed.nearlyFull = nearlyFull;
	changed.full       = full;
	return changed;
}

/// Path of a slab over its closed form.
double slab(const FrontConstants& constants, double thickness, bool wet, double front)
{
	Slab s;
	s.thickness = thickness;
	s.wet       = wet;
	s.front     = front;
	s.change    = [=](GroundSettings<2>& g) { g.thawFront->constants = constants; };
	if (wet) s.length = 80.0;
	return SlabScene(s).slide(0.5);
}

/// Millimetres by which the surface of level ground sinks more with the front than without.
double sinksMore(const FrontConstants& constants, Level level)
{
	level.constants   = constants;
	const double with = outcomeOf<2>(level).surface;
	level.front       = false;
	return 1e3 * (with - outcomeOf<2>(level).surface);
}

struct Figures {
	double dry, saturated, inclined, both; ///< slabs over their closed form [-]
	double foot, roof;                     ///< layer over its foot over limit analysis, path under a roof over X [-]
	double level, winter, strain;          ///< level ground [mm]
	double surface, cohesive, base;        ///< slumps thawed from the surface, without and with cohesion, and from the base: path [m]
};

Figures figuresOf(const FrontConstants& constants)
{
	Level level, winter, strain;
	level.saturated = winter.saturated = strain.saturated = true;
	winter.cycle                                          = true;
	winter.spacing                                        = 0.125;
	strain.thawStrain                                     = 0.05;
	const auto change                                     = [&](GroundSettings<2>& s) { s.thawFront->constants = constants; };
	const Face face;
	Figures    f;
	f.dry       = slab(constants, 1.0, false, 0.0);
	f.saturated = slab(constants, 1.0, true, 0.0);
	f.inclined  = slab(constants, 2.0, false, 45.0);
	f.both      = slab(constants, 2.0, true, 30.0);
	f.foot      = acceleration(face, 0.25 * face.thickness, 0.5, change) / accelerationOverFoot;
	f.roof      = pathUnderRoof(2, change);
	f.level     = sinksMore(constants, level);
	f.winter    = sinksMore(constants, winter);
	f.strain    = sinksMore(constants, strain);
	f.surface   = pathOf({ false, 0.0, change }, 60.0);
	f.cohesive  = pathOf({ false, 2e3, change }, 60.0);
	f.base      = pathOf({ true, 2e3, change }, 600.0);
	return f;
}

/// How far the figures of a variant leave what is right by: slabs over 5 %, at 45 degrees and over a foot 10 %, a path under
/// a roof of a hundredth of the layer, level ground over 1 mm, with thaw strain 4 mm.
double worst(const Figures& f)
{
	return std::max({ std::abs(f.dry - 1.0) / 0.05, std::abs(f.saturated - 1.0) / 0.05, std::abs(f.inclined - 1.0) / 0.1, std::abs(f.both - 1.0) / 0.1,
	                  std::abs(f.foot - 1.0) / 0.1, std::abs(f.roof) / 1e-2, std::abs(f.level), std::abs(f.winter), std::abs(f.strain) / 4.0 });
}

} // namespace

TEST(FrontConstants, EachIsNeededAndNoneDecidesByItsSize_slow)
{
	constexpr double never                   = 1e9;
	double FrontConstants::*const rest       = &FrontConstants::restingWeight;
	const Variant                 variants[] = {
		                { "as it is", {} },
		                { "restingWeight away (thawed ground on frozen ground may always part)", with(rest, never) },
		                { "restingWeight 1/4", with(rest, 0.25) },
		                { "restingWeight 0.9", with(rest, 0.9) },
		                { "nearlyFull and full away (still water never bears)", withFill(never, 2.0 * never) },
		                { "pores count as full from 0.94 to 0.98", withFill(0.94, 0.98) },
		                { "pores count as full from 0.985 to 0.995", withFill(0.985, 0.995) },
	};
	std::printf("| constants | dry slab | saturated slab | dry slab at 45 degrees | saturated slab at 30 degrees | layer over its foot | under a roof | "
	            "level [mm] | after a winter [mm] | thaw strain [mm] | Case I, day 60 [m] | the same with 2 kPa [m] | Case II with 2 kPa, day 600 [m] |\n");
	std::printf("|---|---|---|---|---|---|---|---|---|---|---|---|---|\n");
	citing("closed forms; one velocity for all");
	for (const Variant& v : variants) {
		const Figures f = figuresOf(v.constants);
		std::printf(
		        "| %s | %.3f | %.3f | %.3f | %.3f | %.3f | %.4f | %.2f | %.2f | %.2f | %.2f | %.2f | %.2f |\n", v.name, f.dry, f.saturated, f.inclined,
		        f.both, f.foot, f.roof, f.level, f.winter, f.strain, f.surface, f.cohesive, f.base);
		const std::string name = v.name, what = "constants of the thaw front: worst figure over its tolerance, ";
		if (name.find("away") == std::string::npos && name.find("never") == std::string::npos) expectSmall(what + name, worst(f), 1.0);
	}
}
