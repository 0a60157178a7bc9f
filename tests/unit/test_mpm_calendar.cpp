// SPDX-License-Identifier: GPL-2.0-or-later
// The calendar of slow processes: its scale, its events, and what depends on it.
#include "groundState.hpp"

#include <pkg/mpm/boundary/Boundaries.hpp>
#include <pkg/mpm/Ground.hpp>
#include <pkg/mpm/skeleton/ElasticSkeleton.hpp>
#include <pkg/mpm/skeleton/MohrCoulombSkeleton.hpp>

#include <gtest/gtest.h>
#include <omp.h>

#include <algorithm>
#include <cmath>
#include <cstdio>
#include <cstring>
#include <functional>
#include <memory>

using namespace talik;

namespace {

struct BlockScene {
	double speed = 0.0;
	double fast = 1e6, slow = 1.0, tolerance = 0.01;
	bool   follows = true;
	bool   wet     = false;
};

/// A block without weight that nothing stops, at one temperature.
GroundSettings<2> blockSettings(const BlockScene& c)
{
	GroundSettings<2> s;
	s.upper       = { 4.0, 2.0 };
	s.gridSpacing = 0.25;
	s.motion.emplace();
	s.heat.emplace();
	s.heat->thermalTimeScale = c.fast;
	s.heat->movingTimeScale  = c.slow;
	s.heat->motionTolerance  = c.tolerance;
	s.heat->followsMotion    = c.follows;
	if (c.wet) s.water.emplace();
	auto skeleton   = std::make_shared<ElasticSkeleton<2>>();
	skeleton->young = 1e7;
	s.skeletons.push_back(skeleton);
	return s;
}

Ground<2> blockOf(const GroundSettings<2>& s, double speed, double temperature = 5.0)
{
	Ground<2> ground(s);
	for (int j = 0; j < 4; ++j)
		for (int i = 0; i < 4; ++i) {
			PointInput<2> p;
			p.position    = { 0.5 + (i + 0.5) * 0.125, 0.5 + (j + 0.5) * 0.125 };
			p.volume      = 0.125 * 0.125;
			p.temperature = temperature;
			p.velocity    = { speed, 0.0 };
			ground.addPoint(p);
		}
	ground.initialise();
	return ground;
}

Ground<2> block(const BlockScene& c) { return blockOf(blockSettings(c), c.speed); }

void march(Ground<2>& ground, double until)
{
	const double dt    = ground.stableTimeStep().step;
	const long   count = std::lround(std::ceil((until - ground.time()) / dt));
	const double step  = (until - ground.time()) / count;
	for (long k = 0; k < count; ++k)
		ground.step(step);
}

/// A thawed, cohesionless face that slides at once under air that freezes it, every effect at once.
Ground<2> slidingFace()
{
	GroundSettings<2> s;
	s.gridSpacing = 0.1;
	s.upper       = { 2.4, 1.4 };
	s.motion.emplace();
	s.motion->gravity = { 0.0, -9.81 };
	s.heat.emplace();
	s.heat->thermalTimeScale  = 1e6;
	s.heat->followsMotion     = true;
	s.heat->eventDisplacement = 1e-3;
	s.freezing                = makeFreezingCurve();
	s.water.emplace();
	auto soil           = std::make_shared<MohrCoulombSkeleton<2>>();
	soil->young         = 2e6;
	soil->youngFrozen   = 2e7;
	soil->cohesion      = 0.0;
	soil->frictionAngle = 20.0;
	s.skeletons.push_back(soil);
	s.boundaries   = { std::make_shared<RollerBoundary<2>>(Region<2>::side("left")), std::make_shared<FixedBoundary<2>>(Region<2>::side("bottom")),
		           std::make_shared<DrainedBoundary<2>>(Region<2>::freeSurface()),
		           std::make_shared<SurfaceTemperature<2>>(Region<2>::freeSurface(), TimeTable({ 0.0, 1e4 }, { 1.0, -15.0 })) };
	s.parallelFrom = 0;
	Ground<2> ground(s);
	for (int j = 0; j < 20; ++j)
		for (int i = 0; i < 30 - j; ++i) {
			PointInput<2> p;
			p.position    = { (i + 0.5) * 0.05, (j + 0.5) * 0.05 };
			p.volume      = 0.0025;
			p.temperature = 1.0;
			p.velocity    = { 0.4 * p.position[1], 0.0 };
			ground.addPoint(p);
		}
	ground.initialise();
	return ground;
}

std::string refusalOf(const std::function<void(GroundSettings<2>&)>& change)
{
	auto s = blockSettings({});
	change(s);
	try {
		blockOf(s, 0.0);
	} catch (const std::invalid_argument& error) {
		return error.what();
	}
	return "no refusal";
}

} // namespace

TEST(MpmCalendar, ScaleIsTheLargestAtRestHalfOfItAtTheToleranceAndTheSmallestInMotion)
{
	for (const double speed : { 0.0, 0.01, 0.1, 10.0 }) {
		BlockScene c;
		c.speed          = speed;
		c.slow           = 10.0;
		Ground<2> ground = block(c);
		ground.step(1e-5);
		const double ratio = speed / c.tolerance, expected = c.slow + (c.fast - c.slow) / (1.0 + ratio * ratio);
		std::printf("%g m/s: scale %.10g, expected %.10g\n", speed, ground.calendar().scale, expected);
		EXPECT_NEAR(ground.calendar().scale / expected, 1.0, 1e-9);
		EXPECT_DOUBLE_EQ(ground.calendar().time, ground.calendar().scale * 1e-5);
	}
}

TEST(MpmCalendar, WhereHeatNeedsItTheScaleIsLoweredAndNotTheTimeStep)
{
	BlockScene slow, fast, constant;
	slow.fast = 10.0, fast.fast = constant.fast = 1e12, constant.follows = false;
	const double step = block(slow).stableTimeStep().step, cut = block(constant).stableTimeStep().step;
	Ground<2>    ground = block(fast);
	EXPECT_DOUBLE_EQ(ground.stableTimeStep().step, step);
	ground.step(step);
	std::printf(
	        "step %.3g s, %.3g s with a constant scale; calendar %.6g s in it, limit of conduction %.6g s\n", step, cut, ground.calendar().time,
	        cut * 1e12);
	EXPECT_NEAR(ground.calendar().time / (cut * 1e12), 1.0, 1e-9);
}

TEST(MpmCalendar, ABlockThatFliesIsOneEventWithItsPathAndVolume)
{
	BlockScene c;
	c.speed          = 0.5;
	Ground<2> ground = block(c);
	march(ground, 1.0);
	const auto events = ground.events();
	ASSERT_EQ(events.size(), 1u);
	const MotionEvent& e = events.front();
	std::printf(
	        "event from %.3g s on for %.4f s, largest %.5f m, volume %.5f m2, %.3g s of calendar passed\n", e.start, e.duration, e.largest, e.volume,
	        e.passed);
	EXPECT_NEAR(e.start + e.duration, 1.0, 1e-12);
	EXPECT_NEAR(e.largest, 0.5 * e.duration, 1e-9);
	EXPECT_NEAR(e.volume, 0.25, 1e-12);
	const double ratio = 50.0;
	EXPECT_NEAR(e.passed / (e.duration * (1.0 + 1e6 / (1.0 + ratio * ratio))), 1.0, 1e-4);
	EXPECT_TRUE(ground.endedEvents().empty());
}

TEST(MpmCalendar, AnEventEndsWhenTheGroundHasBeenSlowForAWhileAndSmallOnesAreLeftOut)
{
	BlockScene c;
	c.speed             = 0.5;
	Ground<2>    ground = block(c);
	const double dt     = 1e-3;
	for (int k = 0; k < 100; ++k)
		ground.step(dt);
	PointFields& fields   = ground.points().fields();
	const auto   setSpeed = [&](double v) { std::fill_n(fields.find("velocity", 0), ground.points().count(), v); };
	setSpeed(0.001);
	for (int k = 0; k < 250; ++k)
		ground.step(dt);
	ASSERT_EQ(ground.endedEvents().size(), 1u);
	std::printf("moved for %.4f s, ended after %.4f s of quiet\n", ground.endedEvents()[0].duration, MotionEvent::quietTime);
	EXPECT_NEAR(ground.endedEvents()[0].duration, 0.1, 2.5 * dt);
	setSpeed(0.1); // 1 cm in 0.1 s, less than counts
	for (int k = 0; k < 100; ++k)
		ground.step(dt);
	setSpeed(0.0);
	for (int k = 0; k < 250; ++k)
		ground.step(dt);
	EXPECT_EQ(ground.endedEvents().size(), 1u);
	EXPECT_FALSE(ground.calendar().moving);
}

TEST(MpmCalendar, HeatAndItsTablesPassTheSameAtAnyScale)
{
	double              worst = 0.0, warmest = 0.0;
	std::vector<double> inNaturesTime;
	for (const double scale : { 1.0, 1000.0 }) {
		GroundSettings<2> s;
		s.upper       = { 0.1, 1.0 };
		s.gridSpacing = 0.1;
		s.heat.emplace();
		s.heat->thermalTimeScale = scale;
		s.heat->source           = 5.0;
		s.boundaries             = { std::make_shared<WallTemperature<2>>(Region<2>::side("bottom"), TimeTable({ 0.0, 5000.0 }, { 5.0, 10.0 })),
			                     std::make_shared<HeatFlux<2>>(Region<2>::side("top"), TimeTable({ 0.0, 5000.0 }, { 0.0, 50.0 })) };
		Ground<2> ground(s);
		for (int j = 0; j < 20; ++j)
			for (int i = 0; i < 2; ++i) {
				PointInput<2> p;
				p.position    = { (i + 0.5) * 0.05, (j + 0.5) * 0.05 };
				p.volume      = 0.0025;
				p.temperature = 5.0;
				ground.addPoint(p);
			}
		ground.initialise();
		march(ground, 5000.0 / scale);
		EXPECT_NEAR(ground.calendar().time, 5000.0, 1e-6);
		const double* t = ground.points().fields().find("temperature");
		for (int p = 0; p < ground.points().count(); ++p) {
			if (scale == 1.0) inNaturesTime.push_back(t[p]);
			worst   = std::max(worst, std::abs(t[p] - inNaturesTime[p]));
			warmest = std::max(warmest, t[p]);
		}
	}
	std::printf("5000 s of the calendar in 5000 and in 5 s of motion: temperatures up to %.2f degC, %.1e K apart\n", warmest, worst);
	EXPECT_LT(worst, 1e-9);
	EXPECT_GT(warmest, 6.0);
}

TEST(MpmCalendar, SeepageFollowsTheCalendarUpToWhatPressureAtRestNeedsAndAnOwnScaleOverridesIt)
{
	BlockScene c;
	c.follows = false, c.wet = true;
	const auto scaleOf = [&](double fast, double conductivity, double own) {
		c.fast                                      = fast;
		auto s                                      = blockSettings(c);
		s.water->permeability.referenceConductivity = conductivity;
		s.water->hydraulicTimeScale                 = own;
		Ground<2> ground                            = blockOf(s, 0.0);
		ground.step(1e-6);
		return std::pair<double, double>(ground.seepageScale(), ground.largestConductivity());
	};
	const auto [silt, limit] = scaleOf(1e5, 1e-9, NAN);
	std::printf("silt x %g, sand x %g, gravel x %g; up to %.3g m/s\n", silt, scaleOf(1e5, 1e-4, NAN).first, scaleOf(1e5, 1.0, NAN).first, limit);
	EXPECT_DOUBLE_EQ(silt, 1e5);
	EXPECT_DOUBLE_EQ(scaleOf(1e5, 1e-4, NAN).first, limit / 1e-4);
	EXPECT_DOUBLE_EQ(scaleOf(1.0, 1e-2, NAN).first, 1.0);  // what sand has by nature is left as it is
	EXPECT_DOUBLE_EQ(scaleOf(1e5, 1.0, NAN).first, limit); // gravel is not
	EXPECT_DOUBLE_EQ(scaleOf(1.0, 1.0, 1.0).first, limit);
	EXPECT_DOUBLE_EQ(scaleOf(1e5, 1e-9, 7.0).first, 7.0);
	EXPECT_DOUBLE_EQ(scaleOf(0.5, 1e-4, NAN).first, 0.5);
	EXPECT_LT(limit / (0.4 * 9.81), 0.02); // [s], in which water comes to rest against its inertia
	EXPECT_GT(limit, 1e-3);
}

TEST(MpmCalendar, FrozenGroundConductsWaterInItsNaturalRatioToThaw)
{
	// 10^(-6 S_i) of sand at -1 degC is far below the limit, sand without ice at f_H = 1e5 far above it
	const auto drag = [](double temperature, double scale) {
		BlockScene c;
		c.follows = false, c.wet = true, c.fast = scale;
		auto s            = blockSettings(c);
		s.freezing        = makeFreezingCurve();
		s.water->implicit = true;
		Ground<2> ground  = blockOf(s, 0.0, temperature);
		ground.step(1e-6);
		std::vector<double> drag(ground.points().count());
		ground.copyById("drag", 0, drag.data());
		return std::pair<double, double>(drag[0], ground.largestConductivity());
	};
	const double frozen = drag(-1.0, 1.0).first / drag(-1.0, 1e5).first, thawed = drag(5.0, 1.0).first / drag(5.0, 1e5).first;
	const double due = drag(5.0, 1.0).second / 1e-4;
	std::printf("drag falls by %.6g in frozen ground (due 1e5), by %.6g in thawed ground (due %.6g)\n", frozen, thawed, due);
	EXPECT_NEAR(frozen / 1e5, 1.0, 1e-6);
	EXPECT_NEAR(thawed / due, 1.0, 1e-6);
}

TEST(MpmCalendar, SameBitsForAnyNumberOfThreadsAndThroughACheckpointInTheMidstOfASlide)
{
	const int                      before = omp_get_max_threads();
	std::vector<std::vector<char>> wanted;
	std::vector<MotionEvent>       events;
	long                           different = 0;
	double                         lowest = INFINITY, highest = 0.0, dt = 0.0;
	for (const int threads : { 1, 2, 0 }) { // 0: one, by way of a checkpoint
		omp_set_num_threads(std::max(threads, 1));
		Ground<2> ground = slidingFace();
		if (dt == 0.0) dt = 0.8 * ground.stableTimeStep().step;
		for (int k = 0; k < 1000; ++k) {
			ground.step(dt);
			lowest  = std::min(lowest, ground.calendar().scale);
			highest = std::max(highest, ground.calendar().scale);
			if (threads > 0 || k != 500) continue;
			const auto saved = copyOf(ground.state());
			const auto ended = ground.endedEvents();
			ground           = slidingFace();
			const auto into  = ground.state();
			for (std::size_t a = 0; a < into.size(); ++a)
				std::memcpy(into[a].data, saved[a].data(), into[a].bytes);
			ground.setEndedEvents(ended);
			ground.stateRestored();
		}
		if (wanted.empty()) wanted = copyOf(ground.state()), events = ground.events();
		different += differingBytes(wanted, ground.state());
		ASSERT_EQ(ground.events().size(), events.size());
		for (std::size_t e = 0; e < events.size(); ++e)
			different += std::memcmp(&ground.events()[e], &events[e], sizeof(MotionEvent)) != 0;
	}
	omp_set_num_threads(before);
	std::printf("%zu events, scale from %.3g to %.3g: %ld bytes differ\n", events.size(), lowest, highest, different);
	EXPECT_EQ(different, 0);
	EXPECT_GE(events.size(), 1u);
	EXPECT_LT(lowest, 0.9 * highest);
	EXPECT_LT(highest, 1e-3 * 1e6);
}

TEST(MpmCalendar, IsNotThereWhereTheScaleIsConstant)
{
	BlockScene c;
	c.follows        = false;
	Ground<2> ground = block(c);
	for (const FieldInfo& field : ground.points().fields().list())
		EXPECT_NE(field.owner, "calendar");
	for (const auto& entry : ground.cost())
		EXPECT_NE(entry.first, "calendar");
	EXPECT_TRUE(ground.events().empty());
}

TEST(MpmCalendar, SettingsOutsideTheirRangeAreRefusedByNameAndValue)
{
	const std::pair<const char*, std::string> refusals[] = {
		{ "movingTimeScale = 0", refusalOf([](auto& s) { s.heat->movingTimeScale       = 0.0; }) },
		{ "movingTimeScale = -1", refusalOf([](auto& s) { s.heat->movingTimeScale= -1.0; }) },
		{ "movingTimeScale = 2000000", refusalOf([](auto& s) { s.heat->movingTimeScale= 2e6; }) },
		{ "motionTolerance = 0", refusalOf([](auto& s) { s.heat->motionTolerance= 0.0; }) },
		{ "motionTolerance = 2", refusalOf([](auto& s) { s.heat->motionTolerance= 2.0; }) },
		{ "motionTolerance = nan", refusalOf([](auto& s) { s.heat->motionTolerance= NAN; }) },
		{ "thermalTimeScale = -5", refusalOf([](auto& s) { s.heat->thermalTimeScale= -5.0; }) },
		{ "followsMotion = true without motion", refusalOf([](auto& s) { s.motion.reset(), s.skeletons.clear(); }) },
	};
	for (const auto& [expected, found] : refusals) {
		std::printf("%s\n", found.c_str());
		EXPECT_NE(found.find(expected), std::string::npos) << found;
	}
}
