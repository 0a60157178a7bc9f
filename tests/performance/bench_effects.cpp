// SPDX-License-Identifier: GPL-2.0-or-later
// What each effect of the ground costs per point and step, beside a minimal dry code: a block of 100 x 100 cells with four points
// each on a rough floor, free at its sides. Every benchmark is one combination of effects; scripts/bench effects compares them.
#include "MinimalMpm.hpp"

#include <benchmark/benchmark.h>
#include <omp.h>
#include <pkg/mpm/boundary/Boundaries.hpp>
#include <pkg/mpm/Ground.hpp>
#include <pkg/mpm/points/ObjectiveUpdate.hpp>
#include <pkg/mpm/skeleton/ElasticSkeleton.hpp>
#include <pkg/mpm/skeleton/MohrCoulombSkeleton.hpp>

#include <algorithm>
#include <array>
#include <chrono>
#include <cmath>
#include <ctime>

using namespace talik;

namespace {

constexpr double spacing = 0.01, porosity = 0.4, gravity = 9.81, flipFraction = 0.97, courantNumber = 0.3;
constexpr int    columns = 140, rows = 112, perDirection = 2, points = 40000, limitInterval = 10;
const Vec<2>     corner { 0.2, 0.0 }, size { 1.0, 1.0 };

/// Effects of one combination.
struct Effects {
	bool motion = true, averaging = false, plastic = false, heat = false, freezing = false, water = false;
	bool record = false, ledger = false, surface = false;
	bool oneVelocity = false; ///< no thaw front, where frozen and thawed ground meet
	bool uniform     = false; ///< one temperature everywhere: heat rests
	bool lookups     = false; ///< of the stable time step, as often as a run does
};

std::shared_ptr<SkeletonModel<2>> skeletonOf(const Effects& e)
{
	if (e.plastic) return std::make_shared<MohrCoulombSkeleton<2>>();
	return std::make_shared<ElasticSkeleton<2>>();
}

GroundSettings<2> settingsOf(const Effects& e)
{
	GroundSettings<2> s;
	s.upper          = { columns * spacing, rows * spacing };
	s.gridSpacing    = spacing;
	s.courantNumber  = courantNumber;
	const auto floor = Region<2>::side("bottom");
	if (e.motion) {
		MotionSettings<2> m;
		m.gravity = { 0.0, -gravity };
		m.bBar    = e.averaging;
		s.motion  = m;
		s.skeletons.push_back(skeletonOf(e));
		s.boundaries.push_back(std::make_shared<FixedBoundary<2>>(floor));
	}
	if (e.heat) s.heat = HeatSettings {};
	if (e.freezing) s.freezing = makeFreezingCurve("gauss");
	if (e.water) {
		WaterSettings w;
		w.state.liquidBulkModulus = 2.2e7;
		w.state.iceBulkModulus    = 8.8e7;
		s.water                   = w;
	}
	if (e.surface) {
		if (e.heat) s.boundaries.push_back(std::make_shared<SurfaceTemperature<2>>(Region<2>::freeSurface(), 10.0));
		if (e.water) s.boundaries.push_back(std::make_shared<DrainedBoundary<2>>(Region<2>::freeSurface(), 0.0, false));
	}
	if (e.oneVelocity) s.thawFront.reset();
	s.deformationRecord = e.record;
	s.energyLedger      = e.ledger;
	return s;
}

/// Temperature falls from the top to the floor, through the freezing range, and pressure is hydrostatic: nothing rests; unless uniform.
std::unique_ptr<Ground<2>> groundWith(const Effects& e)
{
	auto         ground = std::make_unique<Ground<2>>(settingsOf(e));
	const double side   = spacing / perDirection;
	for (int i = 0; i < std::lround(size[0] / side); ++i)
		for (int j = 0; j < std::lround(size[1] / side); ++j) {
			PointInput<2> point;
			point.position    = { corner[0] + (i + 0.5) * side, corner[1] + (j + 0.5) * side };
			point.volume      = side * side;
			point.porosity    = porosity;
			point.temperature = e.uniform ? -5.0 : -5.0 + 10.0 * point.position[1] / size[1];
			point.pressure    = 1000.0 * gravity * (size[1] - point.position[1]);
			ground->addPoint(point);
		}
	ground->initialise();
	if (e.motion) ground->settings().motion->picTime = -ground->stableTimeStep().step / std::log(flipFraction); // the share per step of the minimal code
	return ground;
}

std::unique_ptr<minimal::Block> minimalBlock(bool plastic)
{
	const MohrCoulombSkeleton<2> law;
	const LameModuli             moduli { law.youngModulus, law.poissonRatio };
	const double                 angle = law.frictionAngle * M_PI / 180.0, density = (1.0 - porosity) * MixtureProperties {}.solid.density;
	Effects                      dry;
	dry.plastic = plastic;
	const minimal::Scene scene { columns, rows,         spacing,         groundWith(dry)->stableTimeStep().step,
		                     gravity, flipFraction, moduli.lambda,   moduli.shear,
		                     plastic, law.cohesion, std::sin(angle), std::cos(angle) };
	return std::make_unique<minimal::Block>(scene, corner[0], size[0], size[1], perDirection, density);
}

double meanHeight(const double* y) // of all points
{
	double sum = 0.0;
	for (int p = 0; p < points; ++p)
		sum += y[p];
	return sum / points;
}

/// Both codes do the same: after some steps the points have sunk equally far [m].
struct Settlement {
	double minimum, engine;
};

Settlement settlementAfter(int steps, bool plastic)
{
	Effects dry;
	dry.plastic       = plastic;
	const auto block  = minimalBlock(plastic);
	const auto ground = groundWith(dry);
	for (int k = 0; k < steps; ++k) {
		minimal::fastest().step(*block);
		ground->step(block->scene.step);
	}
	return { 0.5 * size[1] - meanHeight(block->y), 0.5 * size[1] - meanHeight(ground->points().position(1)) };
}

void perPointStep(benchmark::State& bench, int threads)
{
	bench.counters["points"]  = points;
	bench.counters["threads"] = threads;
	bench.SetItemsProcessed(bench.iterations() * points);
}

void minimum(benchmark::State& bench, const minimal::Kernel& kernel, bool plastic)
{
	const auto block = minimalBlock(plastic);
	for (int k = 0; k < 5; ++k)
		kernel.step(*block);
	for (auto _ : bench)
		kernel.step(*block);
	perPointStep(bench, 1);
}

void agreement(benchmark::State& bench, bool plastic)
{
	Settlement settlement {};
	for (auto _ : bench)
		settlement = settlementAfter(100, plastic);
	bench.counters["minimum"] = settlement.minimum;
	bench.counters["engine"]  = settlement.engine;
}

double threadTime()
{
	timespec t;
	clock_gettime(CLOCK_THREAD_CPUTIME_ID, &t);
	return t.tv_sec * 1e9 + t.tv_nsec;
}

/// The calls that a step consists of, and the time that each took [ns].
struct Phases {
	struct Phase {
		const char* name;
		void (*call)(Ground<2>&, double step);
		double time;
	};
	std::array<Phase, 5> all { {
		{ "to grid",
		  [](Ground<2>& g, double step) {
		          g.beginStep(step);
		          g.p2g();
		  },
		  0.0 },
		{ "nodes", [](Ground<2>& g, double) { g.solveNodes(); }, 0.0 },
		{ "to points", [](Ground<2>& g, double) { g.g2p(); }, 0.0 },
		{ "strain, pressure", [](Ground<2>& g, double) { g.updateStrainAndPressure(); }, 0.0 },
		{ "law", [](Ground<2>& g, double) { g.updateEffectiveStress(); }, 0.0 },
	} };

	void step(Ground<2>& ground, double dt)
	{
		for (Phase& phase : all) {
			const double start = threadTime();
			phase.call(ground, dt);
			phase.time += threadTime() - start;
		}
	}
};

void engine(benchmark::State& bench, const Effects& effects, int threads)
{
	const int before = omp_get_max_threads();
	omp_set_num_threads(threads);
	const auto ground = groundWith(effects);
	double     step   = ground->stableTimeStep().step;
	for (int k = 0; k < 5; ++k)
		ground->step(step);
	Phases              phases;
	std::vector<double> wall;
	for (auto _ : bench) {
		const auto start = std::chrono::steady_clock::now();
		if (effects.lookups && wall.size() % limitInterval == 0) step = ground->stableTimeStep().step;
		phases.step(*ground, step);
		wall.push_back(std::chrono::duration<double, std::nano>(std::chrono::steady_clock::now() - start).count());
	}
	omp_set_num_threads(before);
	perPointStep(bench, threads);
	const long done = long(wall.size());
	std::nth_element(wall.begin(), wall.begin() + done / 2, wall.end());
	bench.counters["median step"] = wall[done / 2] / points; // steps in which other programs held a processor fall out
	for (const Phases::Phase& phase : phases.all)
		bench.counters[phase.name] = phase.time / (double(done) * points);
}

struct Combination {
	const char* name;
	Effects     effects;
	bool        threaded = false; ///< also on two threads
};

std::vector<Combination> combinations()
{
	const auto with = [](Effects e, auto... more) {
		((e.*more = true), ...);
		return e;
	};
	using E = Effects;
	Effects dry, rigid;
	rigid.motion           = false;
	const Effects averaged = with(dry, &E::averaging);
	return {
		{ "dry", dry, true },
		{ "dry, stable step looked up", with(dry, &E::lookups) },
		{ "dry, Mohr-Coulomb", with(dry, &E::plastic) },
		{ "dry, cell averages", averaged, true },
		{ "dry, deformation record", with(dry, &E::record) },
		{ "dry, energy ledger", with(dry, &E::ledger) },
		{ "rigid: heat", with(rigid, &E::heat) },
		{ "rigid: heat, freezing", with(rigid, &E::heat, &E::freezing) },
		{ "rigid: heat, freezing, at rest", with(rigid, &E::heat, &E::freezing, &E::uniform) },
		{ "dry, heat", with(dry, &E::heat) },
		{ "dry, heat, at rest", with(dry, &E::heat, &E::uniform) },
		{ "dry, heat, freezing", with(dry, &E::heat, &E::freezing) },
		{ "dry, heat, freezing, Mohr-Coulomb", with(dry, &E::heat, &E::freezing, &E::plastic, &E::oneVelocity) },
		{ "dry, heat, freezing, Mohr-Coulomb, thaw front", with(dry, &E::heat, &E::freezing, &E::plastic) },
		{ "water", with(averaged, &E::water) },
		{ "water, heat", with(averaged, &E::water, &E::heat) },
		{ "water, heat, freezing", with(averaged, &E::water, &E::heat, &E::freezing), true },
		{ "water, heat, freezing, surface", with(averaged, &E::water, &E::heat, &E::freezing, &E::surface) },
		{ "everything", with(averaged, &E::water, &E::heat, &E::freezing, &E::surface, &E::plastic, &E::record, &E::ledger, &E::lookups), true },
	};
}

constexpr int timedSteps = 40;

/// Processors know only some of the kernels.
std::vector<const minimal::Kernel*> knownKernels()
{
	std::vector<const minimal::Kernel*> known { &minimal::plain };
	if (&minimal::fastest() != &minimal::plain) known.push_back(&minimal::avx2);
	if (&minimal::fastest() == &minimal::avx512) known.push_back(&minimal::avx512);
	return known;
}

const int registered = [] {
	for (const bool plastic : { false, true }) {
		const std::string law = plastic ? ", Mohr-Coulomb" : "";
		for (const minimal::Kernel* kernel : knownKernels())
			benchmark::RegisterBenchmark(("effects/minimum " + std::string(kernel->name) + law).c_str(), minimum, *kernel, plastic)
			        ->Iterations(timedSteps);
		benchmark::RegisterBenchmark(("agreement/same steps" + law).c_str(), agreement, plastic)->Iterations(1);
	}
	for (const Combination& c : combinations())
		for (int threads = 1; threads <= (c.threaded ? 2 : 1); ++threads)
			benchmark::RegisterBenchmark(
			        ("effects/" + std::string(c.name) + (threads > 1 ? "/2 threads" : "/1 thread")).c_str(), engine, c.effects, threads)
			        ->Iterations(timedSteps)
			        ->UseRealTime();
	return 0;
}();

} // namespace
