// SPDX-License-Identifier: GPL-2.0-or-later
// What each effect of the ground costs per point and step, beside a minimal dry code: a block of 100 x 100 cells with four points
// each on a rough floor, free at its sides. Every benchmark is one combination of effects; scripts/bench effects compares them. In space
// the block has 18 x 18 x 20 cells with eight points each. The pore water of the block tears: it starts without effective stress. Level ground with
// one point in each cell, as freezing ground is filled, rests between the sides of its box.
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
const double     buoyant = (1.0 - porosity) * (MixtureProperties {}.solid.density - 1000.0); ///< density of ground in water [kg/m3]
const Vec<2>     corner { 0.2, 0.0 }, size { 1.0, 1.0 };

/// Where the block stands in its box, and how large both are [m].
template <int D> struct Place {
	Vec<D> corner, size, box;
};
const Place<2>& placeOf(std::integral_constant<int, 2>)
{
	static const Place<2> place { corner, size, { columns * spacing, rows * spacing } };
	return place;
}
const Place<3>& placeOf(std::integral_constant<int, 3>)
{
	static const Place<3> place { { 0.04, 0.04, 0.0 }, { 0.18, 0.18, 0.2 }, { 0.26, 0.26, 0.24 } };
	return place;
}

/// Effects of one combination.
struct Effects {
	bool motion = true, averaging = false, plastic = false, heat = false, freezing = false, water = false;
	bool record = false, ledger = false, surface = false;
	bool implicit    = false; ///< pressure of all cells at once, with water as stiff as it is
	bool segregation = false; ///< frozen ground draws water to its front
	bool settlement  = false; ///< thaw strain and compression of soil that has thawed
	bool oneVelocity = false; ///< no thaw front, where frozen and thawed ground meet
	bool lookups     = false; ///< of the stable time step, as often as a run does
	bool level       = false; ///< ground that rests, with one point in each cell

	int pointsAcross() const { return level ? 1 : perDirection; } ///< a cell
};

template <int D> std::shared_ptr<SkeletonModel<D>> skeletonOf(const Effects& e)
{
	if (e.plastic) return std::make_shared<MohrCoulombSkeleton<D>>();
	return std::make_shared<ElasticSkeleton<D>>();
}

template <int D> GroundSettings<D> settingsOf(const Effects& e)
{
	GroundSettings<D> s;
	s.upper = placeOf(std::integral_constant<int, D>()).box;
	for (int a = 0; a < D - 1 && e.level; ++a)
		s.upper[a] = placeOf(std::integral_constant<int, D>()).size[a];
	s.gridSpacing    = spacing;
	s.courantNumber  = courantNumber;
	const auto floor = Region<D>::side("bottom");
	if (e.motion) {
		MotionSettings<D> m;
		m.gravity[D - 1] = -gravity;
		m.bBar           = e.averaging;
		s.motion         = m;
		s.skeletons.push_back(skeletonOf<D>(e));
		s.boundaries.push_back(std::make_shared<FixedBoundary<D>>(floor));
		const char* const sides[] { "left", "right", "front", "back" };
		for (int k = 0; k < 2 * (D - 1) && e.level; ++k)
			s.boundaries.push_back(std::make_shared<RollerBoundary<D>>(Region<D>::side(sides[k])));
	}
	if (e.heat) s.heat = HeatSettings {};
	if (e.freezing) s.freezing = makeFreezingCurve("gauss");
	if (e.water) {
		WaterSettings w;
		w.implicit                = e.implicit;
		w.state.liquidBulkModulus = e.implicit ? 2.2e9 : 2.2e7;
		w.state.iceBulkModulus    = 4.0 * w.state.liquidBulkModulus;
		s.water                   = w;
	}
	if (e.segregation) s.segregation.emplace().segregationPotential = 1e-9;
	if (e.settlement) {
		SoilMaterial silt;
		silt.mixture                     = s.mixture;
		silt.thawStrain                  = 0.1;
		silt.compression.compressibility = 1e-6;
		if (s.water) silt.permeability = s.water->permeability;
		s.materials = { silt };
	}
	if (e.surface) {
		if (e.heat) s.boundaries.push_back(std::make_shared<SurfaceTemperature<D>>(Region<D>::freeSurface(), 10.0));
		if (e.water) s.boundaries.push_back(std::make_shared<DrainedBoundary<D>>(Region<D>::freeSurface(), 0.0, false));
	}
	if (e.oneVelocity) s.thawFront.reset();
	s.deformationRecord = e.record;
	s.energyLedger      = e.ledger;
	return s;
}

/// Temperature falls from the top to the floor, through the freezing range, and pressure is hydrostatic.
template <int D> std::unique_ptr<Ground<D>> groundWith(const Effects& e)
{
	auto               ground = std::make_unique<Ground<D>>(settingsOf<D>(e));
	const Place<D>&    place  = placeOf(std::integral_constant<int, D>());
	const double       side   = spacing / e.pointsAcross();
	std::array<int, D> at {};
	while (at[0] < std::lround(place.size[0] / side)) {
		PointInput<D> point;
		for (int a = 0; a < D; ++a)
			point.position[a] = (e.level ? 0.0 : place.corner[a]) + (at[a] + 0.5) * side;
		point.volume       = std::pow(side, D);
		point.porosity     = porosity;
		point.temperature  = -5.0 + 10.0 * point.position[D - 1] / place.size[D - 1];
		const double depth = place.size[D - 1] - point.position[D - 1];
		point.pressure     = 1000.0 * gravity * depth;
		for (int k = 0; k < 3 && e.level; ++k)
			point.stress[k] = -buoyant * gravity * depth / (k == D - 1 ? 1.0 : 3.0);
		ground->addPoint(point);
		for (int a = D - 1; ++at[a] == std::lround(place.size[a] / side) && a > 0; --a)
			at[a] = 0;
	}
	ground->initialise();
	if (e.motion) ground->settings().motion->picTime = -ground->stableTimeStep().step / std::log(flipFraction); // the share per step of the minimal code
	return ground;
}

std::unique_ptr<minimal::Block> minimalBlock(bool plastic)
{
	const MohrCoulombSkeleton<2> law;
	const LameModuli             moduli { law.young, law.poisson };
	const double                 angle = law.frictionAngle * M_PI / 180.0, density = (1.0 - porosity) * MixtureProperties {}.solid.density;
	Effects                      dry;
	dry.plastic = plastic;
	const minimal::Scene scene { columns, rows,         spacing,         groundWith<2>(dry)->stableTimeStep().step,
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
	const auto ground = groundWith<2>(dry);
	for (int k = 0; k < steps; ++k) {
		minimal::fastest().step(*block);
		ground->step(block->scene.step);
	}
	return { 0.5 * size[1] - meanHeight(block->y), 0.5 * size[1] - meanHeight(ground->points().position(1)) };
}

void perPointStep(benchmark::State& bench, int threads, int count = points)
{
	bench.counters["points"]  = count;
	bench.counters["threads"] = threads;
	bench.SetItemsProcessed(bench.iterations() * count);
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
template <int D> struct Phases {
	struct Phase {
		const char* name;
		void (*call)(Ground<D>&, double step);
		double time;
	};
	std::array<Phase, 5> all { {
		{ "to grid",
		  [](Ground<D>& g, double step) {
		          g.beginStep(step);
		          g.p2g();
		  },
		  0.0 },
		{ "nodes", [](Ground<D>& g, double) { g.solveNodes(); }, 0.0 },
		{ "to points", [](Ground<D>& g, double) { g.g2p(); }, 0.0 },
		{ "strain, pressure", [](Ground<D>& g, double) { g.updateStrainAndPressure(); }, 0.0 },
		{ "law", [](Ground<D>& g, double) { g.updateEffectiveStress(); }, 0.0 },
	} };

	void step(Ground<D>& ground, double dt)
	{
		for (Phase& phase : all) {
			const double start = threadTime();
			phase.call(ground, dt);
			phase.time += threadTime() - start;
		}
	}
};

template <int D> void engine(benchmark::State& bench, const Effects& effects, int threads)
{
	const int before = omp_get_max_threads();
	omp_set_num_threads(threads);
	const auto ground = groundWith<D>(effects);
	double     step   = ground->stableTimeStep().step;
	for (int k = 0; k < 5; ++k)
		ground->step(step);
	Phases<D>           phases;
	std::vector<double> wall;
	for (auto _ : bench) {
		const auto start = std::chrono::steady_clock::now();
		if (effects.lookups && wall.size() % limitInterval == 0) step = ground->stableTimeStep().step;
		phases.step(*ground, step);
		wall.push_back(std::chrono::duration<double, std::nano>(std::chrono::steady_clock::now() - start).count());
	}
	omp_set_num_threads(before);
	const int count = ground->points().count();
	perPointStep(bench, threads, count);
	const long done = long(wall.size());
	std::nth_element(wall.begin(), wall.begin() + done / 2, wall.end());
	bench.counters["median step"] = wall[done / 2] / count; // steps in which other programs held a processor fall out
	for (const auto& phase : phases.all)
		bench.counters[phase.name] = phase.time / (double(done) * count);
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
		{ "dry, heat", with(dry, &E::heat) },
		{ "dry, heat, freezing", with(dry, &E::heat, &E::freezing) },
		{ "dry, heat, freezing, Mohr-Coulomb", with(dry, &E::heat, &E::freezing, &E::plastic, &E::oneVelocity) },
		{ "dry, heat, freezing, Mohr-Coulomb, thaw front", with(dry, &E::heat, &E::freezing, &E::plastic) },
		{ "water", with(averaged, &E::water) },
		{ "water, heat", with(averaged, &E::water, &E::heat) },
		{ "water, heat, freezing", with(averaged, &E::water, &E::heat, &E::freezing), true },
		{ "water, heat, freezing, implicit pressure", with(averaged, &E::water, &E::heat, &E::freezing, &E::implicit) },
		{ "water, heat, freezing, ice segregation", with(averaged, &E::water, &E::heat, &E::freezing, &E::segregation) },
		{ "water, heat, freezing, thaw settlement", with(averaged, &E::water, &E::heat, &E::freezing, &E::settlement) },
		{ "water, heat, freezing, surface", with(averaged, &E::water, &E::heat, &E::freezing, &E::surface) },
		{ "level ground", with(averaged, &E::water, &E::heat, &E::freezing, &E::level) },
		{ "level ground, implicit pressure", with(averaged, &E::water, &E::heat, &E::freezing, &E::level, &E::implicit) },
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
			        ("effects/" + std::string(c.name) + (threads > 1 ? "/2 threads" : "/1 thread")).c_str(), engine<2>, c.effects, threads)
			        ->Iterations(timedSteps)
			        ->UseRealTime();
	for (const Combination& c : combinations())
		benchmark::RegisterBenchmark(("space/" + std::string(c.name) + "/1 thread").c_str(), engine<3>, c.effects, 1)
		        ->Iterations(timedSteps / 2)
		        ->UseRealTime();
	return 0;
}();

} // namespace
