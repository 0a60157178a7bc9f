// SPDX-License-Identifier: GPL-2.0-or-later
// Ground with all effects that is repeated behind its sides: bits, balances, and what is refused beside such sides.
#include "slopeScenes.hpp"

#include <gtest/gtest.h>
#include <omp.h>

#include <set>

using namespace talik;

namespace {

const Scene scenes[] = { withoutEnds(dryApic, "dry, apic"), withoutEnds(iceRichWet, "all, thaw strain"), withoutEnds(allOwn, "all, points of their own"),
	                 withoutEnds(heaving, "all, segregation"), withoutEnds(allImplicit, "all, implicit pressure") };

void march(Ground<2>& ground, int steps)
{
	for (int k = 0; k < steps; ++k)
		ground.step(2e-4);
}

int wentRound(const Ground<2>& ground)
{
	const int           n = ground.points().count();
	std::vector<double> x(n), path(n);
	ground.copyById("position", 0, x.data());
	ground.copyById("displacement", 0, path.data());
	int count = 0;
	for (int p = 0; p < n; ++p)
		count += x[p] < path[p];
	return count;
}

template <class Change> void expectRefused(Change&& change, const std::string& words)
{
	GroundSettings<2> s;
	s.upper       = { 1.0, 1.0 };
	s.gridSpacing = 0.25;
	s.motion.emplace();
	s.skeletons  = { std::make_shared<ElasticSkeleton<2>>() };
	s.boundaries = { std::make_shared<PeriodicBoundary<2>>(Region<2>::side("left")) };
	change(s);
	Ground<2>     ground(s);
	PointInput<2> p;
	p.position = { 0.5, 0.5 };
	p.volume   = 0.1;
	ground.addPoint(p);
	try {
		ground.initialise();
		FAIL() << "not refused: " << words;
	} catch (const std::invalid_argument& error) {
		EXPECT_NE(std::string(error.what()).find(words), std::string::npos) << error.what();
	}
}

} // namespace

TEST(PeriodicSides, AreIdenticalOnAnyNumberOfThreadsAndThroughACheckpoint)
{
	constexpr int steps = 220, half = 110; // points are sorted anew after 200
	for (const Scene& scene : scenes) {
		omp_set_num_threads(1);
		const auto one = slope<2>(scene, nullptr);
		march(*one, half);
		const auto kept = copyOf(one->state());
		march(*one, steps - half);
		const auto last = copyOf(one->state());
		omp_set_num_threads(3);
		const auto three = slope<2>(scene, nullptr), restored = slope<2>(scene, nullptr);
		march(*three, steps);
		EXPECT_EQ(differingBytes(last, three->state()), 0) << scene.name << ", three threads";
		std::size_t k = 0;
		for (const StateArray& array : restored->state())
			std::copy(kept[k].begin(), kept[k].end(), static_cast<char*>(array.data)), ++k;
		restored->stateRestored();
		march(*restored, steps - half);
		omp_set_num_threads(1);
		EXPECT_EQ(differingBytes(last, restored->state()), 0) << scene.name << ", through a checkpoint";
		EXPECT_GT(wentRound(*one), 0) << scene.name << ": points have gone round";
		std::printf("%s: %d points have gone round, the same bits\n", scene.name, wentRound(*one));
	}
}

TEST(PeriodicSides, KeepMassHeatAndMomentum)
{
	for (const Scene& scene : scenes) {
		const auto       ground = slope<2>(scene, nullptr);
		const Balance<2> before = ground->balance();
		march(*ground, 220);
		const Balance<2> after = ground->balance();
		const double     mass = after.solidMass + after.waterMass, scale = mass * 9.81 * after.time;
		const auto       change   = [](double a, double b) { return std::abs(a / (b == 0.0 ? 1.0 : b) - (b == 0.0 ? 0.0 : 1.0)); };
		double           momentum = 0.0;
		for (int a = 0; a < 2; ++a)
			momentum = std::max(momentum, std::abs(after.momentum[a] - after.impulse[a] - before.momentum[a]) / scale);
		const double heat  = std::abs(after.enthalpy + after.enthalpyOut - after.heatIn - before.enthalpy) / std::max(std::abs(before.enthalpy), 1.0);
		const double water = change(after.waterMass + after.waterOut, before.waterMass), solid = change(after.solidMass, before.solidMass);
		std::printf(
		        "%s: momentum %.1e of weight and time, heat %.1e, water %.1e, solid %.1e of what there is; tolerance 1e-9\n", scene.name, momentum,
		        heat, water, solid);
		for (const double off : { momentum, heat, water, solid })
			EXPECT_LT(off, 1e-9) << scene.name;
	}
}

TEST(PeriodicSides, RefuseWhatIsNotTheSameOnBothOfThem)
{
	const auto add = [](std::shared_ptr<Boundary<2>> b) { return [b](GroundSettings<2>& s) { s.boundaries.push_back(b); }; };
	expectRefused(add(std::make_shared<RollerBoundary<2>>(Region<2>::side("right"))), "acts on a side that this joins");
	expectRefused(add(std::make_shared<PeriodicBoundary<2>>(Region<2>::side("right"))), "acts on a side that this joins");
	expectRefused(add(std::make_shared<FixedBoundary<2>>(Region<2>::side("bottom").within({ 0.0, 0.0 }, { 0.5, 0.0 }))), "ends between the sides");
	expectRefused(add(std::make_shared<FixedBoundary<2>>(Region<2>::nodeBox({ 0.2, 0.0 }, { 0.5, 0.5 }))), "ends between the sides");
	expectRefused(add(std::make_shared<PeriodicBoundary<2>>(Region<2>::side("top"))), "not bottom or top");
	expectRefused([](GroundSettings<2>& s) { s.bodies.emplace(); }, "bodies");
}
