// SPDX-License-Identifier: GPL-2.0-or-later
// The composed step: effects, free fall, balances, determinism, checkpoints, refusals.
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
#include <random>
#include <set>

using namespace talik;

namespace {

struct Effects {
	bool motion = true, heat = false, freezing = false, water = false;
};

template <int D> GroundSettings<D> sceneWith(const Effects& effects, double h = 0.1, double size = 1.0)
{
	GroundSettings<D> s;
	s.lower.fill(0.0);
	s.upper.fill(size);
	s.gridSpacing = h;
	if (effects.motion) {
		s.motion.emplace();
		auto skeleton   = std::make_shared<ElasticSkeleton<D>>();
		skeleton->young = 1e6;
		s.skeletons.push_back(skeleton);
	}
	if (effects.heat) s.heat.emplace();
	if (effects.freezing) s.freezing = makeFreezingCurve();
	if (effects.water) {
		s.water.emplace();
		s.water->state.liquidBulkModulus = 2.2e7;
		s.water->state.iceBulkModulus    = 8.8e7;
	}
	return s;
}

template <int D> void fill(Ground<D>& ground, const Vec<D>& lower, const Vec<D>& upper, const std::function<void(PointInput<D>&)>& prepare = {})
{
	const double       s = 0.5 * ground.settings().gridSpacing;
	std::array<int, D> n, i {};
	for (int a = 0; a < D; ++a)
		n[a] = int(std::lround((upper[a] - lower[a]) / s));
	while (true) {
		PointInput<D> p;
		p.volume = std::pow(s, D);
		for (int a = 0; a < D; ++a)
			p.position[a] = lower[a] + (i[a] + 0.5) * s;
		if (prepare) prepare(p);
		ground.addPoint(p);
		int a = 0;
		while (a < D && ++i[a] == n[a])
			i[a] = 0, ++a;
		if (a == D) return;
	}
}

template <int D> std::vector<double> valuesOf(const Ground<D>& ground, const std::string& field, int component = 0)
{
	std::vector<double> values(ground.points().count());
	ground.copyById(field, component, values.data());
	return values;
}

/// A thawing, draining, collapsing slope: every effect at once.
Ground<2> busyScene(int parallelFrom = 4000, VelocityTransfer transfer = VelocityTransfer::flip)
{
	GroundSettings<2> s      = sceneWith<2>({ true, true, true, true }, 0.1, 1.6);
	s.upper                  = { 2.4, 1.2 };
	s.motion->gravity        = { 0.0, -9.81 };
	s.motion->localDamping   = 0.1;
	s.motion->transfer       = transfer;
	s.heat->thermalTimeScale = 1e5;
	auto soil                = std::make_shared<MohrCoulombSkeleton<2>>();
	soil->young              = 2e6;
	soil->youngFrozen        = 2e7;
	s.skeletons.push_back(soil);
	s.boundaries   = { std::make_shared<RollerBoundary<2>>(Region<2>::side("left")),
		           std::make_shared<RollerBoundary<2>>(Region<2>::side("right")),
		           std::make_shared<FixedBoundary<2>>(Region<2>::side("bottom")),
		           std::make_shared<DrainedBoundary<2>>(Region<2>::freeSurface()),
		           std::make_shared<SurfaceTemperature<2>>(Region<2>::freeSurface(), TimeTable({ 0.0, 0.01 * 1e5 }, { -2.0, 10.0 })),
		           std::make_shared<WallTemperature<2>>(Region<2>::side("bottom").within({ 0.5, 0.0 }, { 1.0, 0.0 }), 8.0),
		           std::make_shared<Traction<2>>(Region<2>::freeSurface(), TimeTable({ 0.0, 0.05 * 1e5 }, { 0.0, 2e3 })) };
	s.energyLedger = true;
	s.parallelFrom = parallelFrom;
	Ground<2> ground(s);
	fill<2>(ground, { 0.0, 0.0 }, { 1.2, 0.8 }, [](PointInput<2>& p) {
		p.temperature = -2.0;
		p.skeleton    = p.position[1] > 0.4 ? 1 : 0;
		p.velocity    = { 0.5 * p.position[1], 0.0 };
	});
	ground.initialise();
	return ground;
}

std::string refusal(const std::function<void()>& action)
{
	try {
		action();
	} catch (const std::invalid_argument& e) {
		return e.what();
	} catch (const std::exception& e) {
		return std::string("other exception: ") + e.what();
	}
	return "accepted";
}

#define EXPECT_NAMES(text, word) EXPECT_NE((text).find(word), std::string::npos) << "message: " << (text)

} // namespace

TEST(MpmGround, OnlyFieldsOfPresentEffectsExist)
{
	const auto owners = [](const Effects& e) {
		Ground<2> ground(sceneWith<2>(e));
		fill<2>(ground, { 0.2, 0.2 }, { 0.6, 0.6 });
		ground.initialise();
		std::set<std::string> set;
		int                   arrays = 0;
		for (const FieldInfo& f : ground.fields()) {
			set.insert(f.owner);
			if (f.place == "points") arrays += f.components;
			EXPECT_GT(f.bytes, 0u) << f.name;
		}
		std::printf("motion %d heat %d freezing %d water %d: %d arrays of doubles on the points\n", e.motion, e.heat, e.freezing, e.water, arrays);
		return set;
	};
	using Set = std::set<std::string>;
	EXPECT_EQ(owners({ true, false, false, false }), (Set { "points", "motion" }));
	EXPECT_EQ(owners({ false, true, false, false }), (Set { "points", "poreContent", "heat" }));
	EXPECT_EQ(owners({ false, true, true, false }), (Set { "points", "poreContent", "heat", "freezing" }));
	EXPECT_EQ(owners({ true, false, false, true }), (Set { "points", "motion", "poreContent", "water" }));
	EXPECT_EQ(
	        owners({ true, true, true, true }),
	        (Set { "points", "motion", "poreContent", "heat", "freezing", "water", "thawStrain" })); // pore ice parts the grains
}

TEST(MpmGround, SaturatedFrozenBlockFallsFreelyInThreeDimensions)
{
	GroundSettings<3> s = sceneWith<3>({ true, true, true, true }, 0.1, 1.0);
	s.upper             = { 0.5, 0.5, 1.0 };
	s.motion->gravity   = { 0.0, 0.0, -9.81 };
	Ground<3> ground(s);
	fill<3>(ground, { 0.1, 0.1, 0.7 }, { 0.3, 0.3, 0.9 }, [](PointInput<3>& p) { p.temperature = -0.3; });
	ground.initialise();
	const auto   start = valuesOf(ground, "position", 2);
	const double dt    = ground.stableTimeStep().step;
	const int    steps = 1000;
	for (int k = 0; k < steps; ++k)
		ground.step(dt);
	const double path = -9.81 * dt * dt * steps * (steps + 1) / 2.0; // symplectic Euler
	const auto   z = valuesOf(ground, "position", 2), v = valuesOf(ground, "velocity", 2), vl = valuesOf(ground, "liquidVelocity", 2);
	double       worst = 0.0;
	for (std::size_t p = 0; p < z.size(); ++p)
		worst = std::max({ worst, std::abs(z[p] - start[p] - path), std::abs(v[p] + 9.81 * dt * steps), std::abs(vl[p] + 9.81 * dt * steps) });
	double stress = 0.0;
	for (int c = 0; c < 6; ++c)
		for (double value : valuesOf(ground, "stress", c))
			stress = std::max(stress, std::abs(value));
	std::printf("1000 steps of fall: largest deviation of path and velocities from the symplectic value %.1e, stress %.1e Pa\n", worst, stress);
	EXPECT_LT(worst, 1e-10);
	EXPECT_LT(stress, 1e-6);
}

TEST(MpmGround, SealedSeepageInThreeDimensionsKeepsMassMomentumAndHeat)
{
	GroundSettings<3> s                         = sceneWith<3>({ true, true, true, true }, 0.1, 1.0);
	s.heat->thermalTimeScale                    = 1e5;
	s.water->permeability.referenceConductivity = 0.1;
	s.water->hydraulicTimeScale                 = 1.0;
	Ground<3>                              ground(s);
	std::mt19937                           random(5);
	std::uniform_real_distribution<double> uniform(-1.0, 1.0);
	fill<3>(ground, { 0.3, 0.3, 0.3 }, { 0.7, 0.7, 0.7 }, [&](PointInput<3>& p) {
		p.temperature = 2.0 * uniform(random);
		p.pressure    = 2e4 * (1.0 + uniform(random));
		p.velocity    = { 0.1 * uniform(random), 0.1 * uniform(random), 0.1 * uniform(random) };
	});
	ground.initialise();
	const auto   before = ground.balance();
	const auto   water  = valuesOf(ground, "waterMass");
	const double dt     = 0.5 * ground.stableTimeStep().step;
	for (int k = 0; k < 200; ++k)
		ground.step(dt);
	const auto after = ground.balance();
	double     moved = 0.0;
	const auto now   = valuesOf(ground, "waterMass");
	for (std::size_t p = 0; p < now.size(); ++p)
		moved += 0.5 * std::abs(now[p] - water[p]);
	double momentum = 0.0;
	for (int a = 0; a < 3; ++a)
		momentum = std::max(momentum, std::abs(after.momentum[a] - before.momentum[a] - after.impulse[a]));
	std::printf(
	        "200 steps: water drift %.1e, heat drift %.1e, momentum drift over M v %.1e; share of water moved %.1e\n",
	        after.waterMass / before.waterMass - 1.0, (after.enthalpy - before.enthalpy) / std::abs(before.enthalpy),
	        momentum / (0.1 * (before.solidMass + before.waterMass)), moved / before.waterMass);
	EXPECT_NEAR(after.waterMass / before.waterMass, 1.0, 1e-13);
	EXPECT_NEAR(after.enthalpy / before.enthalpy, 1.0, 1e-12);
	EXPECT_LT(momentum / (0.1 * (before.solidMass + before.waterMass)), 1e-12);
	EXPECT_GT(moved / before.waterMass, 1e-7);
}

TEST(MpmGround, BalancesCloseWithAllBoundariesAtWork)
{
	Ground<2>  ground = busyScene();
	const auto before = ground.balance();
	for (int k = 0; k < 400; ++k)
		ground.step(ground.stableTimeStep().step);
	const auto   after    = ground.balance();
	const double water    = (after.waterMass - before.waterMass + after.waterOut) / before.waterMass;
	const double heat     = (after.enthalpy - before.enthalpy - after.heatIn + after.enthalpyOut) / std::abs(after.heatIn);
	double       momentum = 0.0;
	const double scale    = (before.solidMass + before.waterMass) * 9.81 * after.time;
	for (int a = 0; a < 2; ++a)
		momentum = std::max(momentum, std::abs(after.momentum[a] - before.momentum[a] - after.impulse[a]) / scale);
	std::printf(
	        "%.3f s: water %.1e (out %.2e kg), heat %.1e (in %.2e J), momentum %.1e\n", after.time, water, after.waterOut, heat, after.heatIn, momentum);
	EXPECT_LT(std::abs(water), 1e-13);
	EXPECT_LT(std::abs(heat), 1e-12);
	EXPECT_LT(momentum, 1e-11);
	EXPECT_GT(std::abs(after.waterOut), 0.0);
}

TEST(MpmGround, AnyNumberOfThreadsGivesTheSameBits)
{
	const int before = omp_get_max_threads();
	for (const VelocityTransfer transfer : { VelocityTransfer::flip, VelocityTransfer::apic }) {
		std::vector<std::vector<char>> reference;
		for (const int threads : { 1, 2, 3 }) {
			omp_set_num_threads(threads);
			Ground<2> ground = busyScene(0, transfer);
			for (int k = 0; k < 250; ++k)
				ground.step(1.5e-4);
			const auto state = ground.state();
			if (reference.empty()) reference = copyOf(state);
			const long different = differingBytes(reference, state);
			std::printf(
			        "%s, %d threads: %ld bytes differ from one thread\n", transfer == VelocityTransfer::flip ? "flip" : "apic", threads, different);
			EXPECT_EQ(different, 0);
		}
	}
	omp_set_num_threads(before);
}

TEST(MpmGround, RestoredStateContinuesBitForBit)
{
	for (const VelocityTransfer transfer : { VelocityTransfer::flip, VelocityTransfer::apic }) {
		Ground<2> whole = busyScene(4000, transfer);
		for (int k = 0; k < 150; ++k)
			whole.step(1.5e-4);
		const auto saved = copyOf(whole.state());
		for (int k = 0; k < 250; ++k) // beyond the next regular sorting
			whole.step(1.5e-4);

		Ground<2>  resumed = busyScene(4000, transfer);
		const auto state   = resumed.state();
		for (std::size_t k = 0; k < state.size(); ++k) {
			ASSERT_EQ(state[k].bytes, saved[k].size()) << state[k].name;
			std::memcpy(state[k].data, saved[k].data(), state[k].bytes);
		}
		resumed.stateRestored();
		EXPECT_EQ(resumed.steps(), 150);
		for (int k = 0; k < 250; ++k)
			resumed.step(1.5e-4);
		const long different = differingBytes(copyOf(whole.state()), resumed.state());
		std::printf("%s, saved, restored and continued: %ld bytes differ\n", transfer == VelocityTransfer::flip ? "flip" : "apic", different);
		EXPECT_EQ(different, 0);
	}
}

TEST(MpmGround, TimeStepLimitsAreThoseOfThePresentEffects)
{
	const auto names = [](const Effects& e) {
		Ground<2> ground(sceneWith<2>(e));
		fill<2>(ground, { 0.2, 0.2 }, { 0.6, 0.6 }, [](PointInput<2>& p) { p.velocity = { 0.1, 0.0 }; });
		ground.initialise();
		const auto            stable = ground.stableTimeStep();
		std::set<std::string> set;
		for (const auto& limit : stable.limits)
			set.insert(limit.name);
		EXPECT_EQ(set.count(stable.governing), 1u);
		return set;
	};
	using Set = std::set<std::string>;
	EXPECT_EQ(names({ true, false, false, false }), (Set { "wave", "velocity" }));
	EXPECT_EQ(names({ false, true, true, false }), (Set { "heat" }));
	EXPECT_EQ(names({ true, true, true, true }), (Set { "wave", "velocity", "heat", "heat advection" }));
	// rigid frozen ground, real time: days, not microseconds. kappa 1.48, C 2.0218e6, h 0.1: 0.9 h^2 C/(4 kappa)
	GroundSettings<2> s = sceneWith<2>({ false, true, true, false });
	s.freezing          = makeFreezingCurve("gauss", { { "residualSaturation", 0.01 } });
	Ground<2> rigid(s);
	fill<2>(rigid, { 0.2, 0.2 }, { 0.6, 0.6 }, [](PointInput<2>& p) { p.temperature = -20.0; });
	rigid.initialise();
	const double closed = 0.9 * 0.01 * 2.0218e6 / (4.0 * 1.48);
	std::printf("rigid frozen ground: stable step %.1f s, closed form without residual water %.1f s\n", rigid.stableTimeStep().step, closed);
	EXPECT_NEAR(rigid.stableTimeStep().step / closed, 1.0, 0.02);
}

TEST(MpmGround, DryWaveLimitIsTheOedometricOne)
{
	GroundSettings<2> s = sceneWith<2>({});
	s.poreFill          = 0.0;
	Ground<2> ground(s);
	fill<2>(ground, { 0.2, 0.2 }, { 0.6, 0.6 }, [](PointInput<2>& p) { p.porosity = 0.4; });
	ground.initialise();
	const double modulus = 1e6 * 0.7 / (1.3 * 0.4), density = 0.6 * 2650.0;
	EXPECT_NEAR(ground.stableTimeStep().step / (0.4 * 0.1 / std::sqrt(modulus / density)), 1.0, 1e-12);
	EXPECT_EQ(ground.stableTimeStep().governing, "wave");
}

TEST(MpmGround, BadScenesAreRefusedBySentencesThatNameTheFault)
{
	const auto start = [](const std::function<void(GroundSettings<2>&)>& change, const std::function<void(PointInput<2>&)>& point = {}) {
		return refusal([&] {
			GroundSettings<2> s = sceneWith<2>({ true, true, true, true });
			change(s);
			Ground<2> ground(s);
			fill<2>(ground, { 0.2, 0.2 }, { 0.6, 0.6 }, point);
			ground.initialise();
		});
	};
	const auto same = [](GroundSettings<2>&) {};
	EXPECT_EQ(start(same), "accepted");
	EXPECT_NAMES(start([](auto& s) { s.heat.reset(); }), "freezing without heat");
	EXPECT_NAMES(start([](auto& s) { s.motion.reset(); }), "water without motion");
	EXPECT_NAMES(start([](auto& s) { s.skeletons.clear(); }), "skeletons");
	EXPECT_NAMES(
	        refusal([] {
		        GroundSettings<2> s = sceneWith<2>({});
		        s.gridSpacing       = -1.0;
		        Ground<2> ground(s);
		        ground.addPoint({});
		        ground.initialise();
	        }),
	        "gridSpacing = -1");
	EXPECT_NAMES(start([](auto& s) { s.motion->picTime = -1.5; }), "MpmEngine.picTime = -1.5");
	EXPECT_NAMES(start([](auto& s) { s.motion->localDamping = 1.0; }), "MpmEngine.damping = 1");
	EXPECT_NAMES(start([](auto& s) { s.motion->gravity[1] = NAN; }), "gravity");
	EXPECT_NAMES(start([](auto& s) { s.heat->thermalTimeScale = 0.0; }), "HeatTransfer.thermalTimeScale = 0");
	EXPECT_NAMES(start([](auto& s) { s.mixture.solid.density = -1.0; }), "GroundMaterial.solidDensity = -1");
	EXPECT_NAMES(start([](auto& s) { s.water->permeability.referenceConductivity = 0.0; }), "PoreWater.conductivity = 0");
	EXPECT_NAMES(start([](auto& s) { s.poreFill = 1.5; }), "MpmEngine.poreFill = 1.5");
	EXPECT_NAMES(start([](auto& s) { s.shapeFunction = "cubic"; }), "MpmEngine.shapeFunction = 'cubic'");
	EXPECT_NAMES(start(same, [](PointInput<2>& p) { p.position[0] = 7.0; }), "outside the grid");
	EXPECT_NAMES(start(same, [](PointInput<2>& p) { p.position[1] = NAN; }), "point 0.position[1]");
	EXPECT_NAMES(start(same, [](PointInput<2>& p) { p.volume = 0.0; }), "point 0.volume = 0");
	EXPECT_NAMES(start(same, [](PointInput<2>& p) { p.porosity = 1.0; }), "point 0.porosity = 1");
	EXPECT_NAMES(start(same, [](PointInput<2>& p) { p.temperature = -300.0; }), "temperature = -300");
	EXPECT_NAMES(start(same, [](PointInput<2>& p) { p.skeleton = 3; }), "point 0.skeleton = 3");
	EXPECT_NAMES(start(same, [](PointInput<2>& p) { p.stress[3] = INFINITY; }), "stress");
	const auto withBoundary = [&](std::shared_ptr<Boundary<2>> b) { return start([&](auto& s) { s.boundaries.push_back(b); }); };
	EXPECT_NAMES(withBoundary(std::make_shared<RollerBoundary<2>>(Region<2>::freeSurface())), "RollerBoundary.region");
	EXPECT_NAMES(withBoundary(std::make_shared<WallTemperature<2>>(Region<2>::side("left"), NAN)), "WallTemperature.temperature");
	EXPECT_NAMES(withBoundary(std::make_shared<FixedBoundary<2>>(Region<2>::nodeBox({ 5, 5 }, { 6, 6 }))), "holds no node");
	EXPECT_NAMES(withBoundary(std::make_shared<DrainedBoundary<2>>(Region<2>::side("left"))), "no ground there");
	EXPECT_NAMES(
	        start([](auto& s) {
		        s.boundaries = { std::make_shared<RollerBoundary<2>>(Region<2>::side("left")),
			                 std::make_shared<FixedBoundary<2>>(Region<2>::side("left")) };
	        }),
	        "overlaps MpmEngine.boundaries[0]");
	EXPECT_NAMES(
	        start([](auto& s) {
		        s.boundaries = { std::make_shared<WallTemperature<2>>(Region<2>::side("left"), 1.0) };
		        s.water.reset(), s.freezing.reset(), s.heat.reset();
	        }),
	        "the scene has no heat");
	EXPECT_NAMES(refusal([] { Region<2>::side("front"); }), "side = 'front'");
	EXPECT_NAMES(refusal([] { Region<2>::side("up"); }), "left, right, bottom, top");
	EXPECT_NAMES(
	        refusal([] {
		        Ground<2> ground(sceneWith<2>({}));
		        ground.initialise();
	        }),
	        "no material points");
}

TEST(MpmGround, BadStepsAndUnknownFieldsAreRefused)
{
	Ground<2> ground(sceneWith<2>({}));
	fill<2>(ground, { 0.2, 0.2 }, { 0.6, 0.6 });
	ground.initialise();
	EXPECT_NAMES(refusal([&] { ground.step(0.0); }), "dt = 0");
	EXPECT_NAMES(refusal([&] { ground.step(NAN); }), "dt = ");
	double out[64];
	EXPECT_NAMES(refusal([&] { ground.copyById("temperature", 0, out); }), "velocity");
}

TEST(MpmGround, PointsThatLeaveTheBoxAreNamed)
{
	Ground<2> ground(sceneWith<2>({}));
	fill<2>(ground, { 0.2, 0.2 }, { 0.6, 0.6 }, [](PointInput<2>& p) { p.velocity = { 1.0, 0.0 }; });
	ground.initialise();
	std::string message;
	try {
		for (int k = 0; k < 1000; ++k)
			ground.step(1e-3);
	} catch (const std::runtime_error& e) {
		message = e.what();
	}
	std::printf("message: %s\n", message.c_str());
	EXPECT_NAMES(message, "left the grid's box");
	EXPECT_NAMES(message, "material point 7 "); // the lowest of those in front, which leaves first or with the others
}

TEST(MpmGround, AboutAnAxisRefusesWhatHasNoRadiusInASentence)
{
	const auto said = [](const std::function<void(GroundSettings<2>&)>& change) {
		GroundSettings<2> s;
		s.axisymmetric = true;
		s.upper        = { 1.0, 1.0 };
		s.gridSpacing  = 0.5;
		s.motion.emplace();
		s.skeletons = { std::make_shared<ElasticSkeleton<2>>() };
		change(s);
		const std::string text = refusal([&] {
			Ground<2>     ground(s);
			PointInput<2> point;
			point.position = { 0.25, 0.25 };
			point.volume   = 0.25;
			ground.addPoint(point);
			ground.initialise();
		});
		std::printf("%s\n", text.c_str());
		return text;
	};
	const auto with = [&](auto boundary) {
		return said([&](GroundSettings<2>& s) { s.boundaries.push_back(std::make_shared<decltype(boundary)>(boundary)); });
	};
	const auto left = Region<2>::side("left");
	EXPECT_EQ(said([](GroundSettings<2>&) {}), "accepted");
	EXPECT_EQ(with(RollerBoundary<2>(left)), "accepted");
	EXPECT_NAMES(said([](GroundSettings<2>& s) { s.lower[0] = -1.0; }), "lower.x = -1");
	EXPECT_EQ(said([](GroundSettings<2>& s) { s.water.emplace(); }), "accepted");
	EXPECT_EQ(said([](GroundSettings<2>& s) { s.water.emplace().implicit = true; }), "accepted");
	EXPECT_NAMES(said([](GroundSettings<2>& s) { s.segregation.emplace(); }), "segregation");
	EXPECT_NAMES(said([](GroundSettings<2>& s) { s.bodies.emplace(); }), "bodies");
	EXPECT_NAMES(with(Traction<2>(left, 1e3)), "axis has no area");
	EXPECT_NAMES(with(PeriodicBoundary<2>(Region<2>::side("right"))), "PeriodicBoundary");
	GroundSettings<3> space;
	space.axisymmetric = true;
	EXPECT_NAMES(refusal([&] { checkSettings(space); }), "in space");
}
