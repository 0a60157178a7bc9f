// SPDX-License-Identifier: GPL-2.0-or-later
// Time of one step of the packed sample. The stock YADE figure for the same sample and motion:
//   yade -n -x -j1 tests/yade/time_stock_step.py
// To compare, run both in turn in one shell loop: machines are not equally fast at all times.
#include "../unit/packedStarts.hpp"
#include <benchmark/benchmark.h>
#include <pkg/rve/packed/PackedSamplePool.hpp>

using namespace talik;
using packedReference::Matrix;
using packedReference::State;

namespace {

std::string dataFile(const char* name)
{
	const std::string here = __FILE__;
	return here.substr(0, here.find_last_of('/')) + "/../unit/data/" + name;
}

const packedReference::Reference& reference()
{
	static const auto read = packedReference::read(dataFile("packed_reference.txt"));
	return read;
}

Matrix shear(double rate)
{
	Matrix m;
	m << rate, 0, 0, -rate;
	return m;
}

State frozen(double iceSaturation)
{
	PackedSample<2> sample(reference().state());
	for (int k = 1; k <= 20; ++k) {
		sample.setIceSaturation(iceSaturation * k / 20);
		sample.advance(5);
	}
	return sample.state();
}

template <int Dim> void time(benchmark::State& bench, PackedSample<Dim>& sample, const Eigen::Matrix<double, Dim, Dim>& motion)
{
	constexpr long         steps = 500;
	const PackedState<Dim> start = sample.state();
	for (auto _ : bench) {
		bench.PauseTiming();
		sample.setState(start);
		bench.ResumeTiming();
		sample.advance(motion, steps);
	}
	const auto statistics               = sample.statistics();
	bench.counters["contacts"]          = double(statistics.contacts);
	bench.counters["bondsIntact"]       = double(statistics.bondsIntact);
	bench.counters["bondsBroken"]       = double(statistics.bondsBroken);
	bench.counters["time/(grain step)"] = benchmark::Counter(
	        double(steps * long(start.size())), benchmark::Counter::kIsIterationInvariantRate | benchmark::Counter::kInvert);
	bench.SetLabel(sample.path());
}

void run(benchmark::State& bench, State state, bool portable, double before)
{
	PackedSample<2>::forcePortable(portable);
	PackedSample<2> sample(state);
	PackedSample<2>::forcePortable(false);
	if (before > 0) sample.advance(shear(0.3), long(before / (0.3 * state.dt)));
	time(bench, sample, shear(0.01));
}

void frictional(benchmark::State& bench) { run(bench, reference().state(), bench.range(0), 0); }
void bonded(benchmark::State& bench) { run(bench, frozen(0.5), bench.range(0), 0); }
void bondedWithBreakage(benchmark::State& bench) { run(bench, frozen(0.06), bench.range(0), 0.05); }

void frictionalHertz(benchmark::State& bench) { run(bench, packedStarts::hertzian<2>(reference().state()), bench.range(0), 0); }
void bondedHertz(benchmark::State& bench) { run(bench, packedStarts::frozenOf<2>(packedStarts::hertzian<2>(reference().state()), 0.5, 20), bench.range(0), 0); }

/// The sample of grains that resist rolling.
State rolling(State state)
{
	auto grains     = std::make_shared<PackedGrains>(*state.grains);
	grains->rolling = { 2, 0.2 };
	state.grains    = grains;
	state.contacts.moment.assign(state.contacts.size(), 0.);
	return state;
}
void frictionalRolling(benchmark::State& bench) { run(bench, rolling(reference().state()), bench.range(0), 0); }
void bondedRolling(benchmark::State& bench) { run(bench, rolling(frozen(0.5)), bench.range(0), 0); }

/// The sample of bonds that carry moments.
void bondedWithMoments(benchmark::State& bench)
{
	State state     = frozen(0.5);
	auto  grains    = std::make_shared<PackedGrains>(*state.grains);
	grains->section = { 1, 1 };
	state.grains    = grains;
	state.contacts.bondMoment.assign(state.contacts.size(), 0.);
	run(bench, state, bench.range(0), 0);
}

/// Eight copies of the sample of spheres, in one cell.
packedSpheres::State spheres()
{
	static const auto          read   = packedSpheres::read(dataFile("packed_spheres_reference.txt"));
	const packedSpheres::State one    = read.state();
	packedSpheres::State       all    = one;
	auto                       grains = std::make_shared<PackedGrains>();
	const auto                 place  = [&](int copy) { return Eigen::Vector3d(copy & 1, copy >> 1 & 1, copy >> 2); };
	all.hSize = all.prevHSize = 2 * one.hSize;
	all.position.clear(), all.velocity.clear(), all.angularVelocity.clear();
	all.contacts = {};
	for (int copy = 0; copy < 8; ++copy)
		for (std::size_t g = 0; g < one.size(); ++g) {
			grains->radius.push_back(one.grains->radius[g]);
			grains->mass.push_back(one.grains->mass[g]);
			grains->inertia.push_back(one.grains->inertia[g]);
			grains->id.push_back(int(grains->id.size()));
			all.position.push_back(one.position[g] + one.hSize * place(copy));
			all.velocity.push_back(one.velocity[g]);
			all.angularVelocity.push_back(one.angularVelocity[g]);
		}
	all.grains = grains;
	return all;
}

packedSpheres::State frozenSpheres()
{
	PackedSample<3> sample(spheres());
	for (int k = 1; k <= 20; ++k) {
		sample.setIceSaturation(0.5 * k / 20);
		sample.advance(5);
	}
	return sample.state();
}

void run(benchmark::State& bench, const packedSpheres::State& state)
{
	PackedSample<3>::forcePortable(bench.range(0));
	PackedSample<3> sample(state);
	PackedSample<3>::forcePortable(false);
	packedSpheres::Matrix motion = packedSpheres::Matrix::Zero();
	motion.topLeftCorner<2, 2>() = shear(0.01);
	sample.advance(motion, 2000);
	time(bench, sample, motion);
}
void frictionalSpheres(benchmark::State& bench) { run(bench, spheres()); }
void frictionalHertzSpheres(benchmark::State& bench) { run(bench, packedStarts::hertzian<3>(spheres())); }
void bondedSpheres(benchmark::State& bench) { run(bench, frozenSpheres()); }

/// One update of many samples, all of it: load, motion, tangent, store.
void pool(benchmark::State& bench)
{
	SamplePool<2> samples;
	const State   state = reference().state();
	for (int k = 0; k < 200; ++k)
		samples.add(state);
	PackedUpdateOptions options;
	options.steps   = bench.range(0);
	options.tangent = true;
	std::vector<PackedRequest<2>> requests;
	for (std::size_t k = 0; k < samples.size(); ++k)
		requests.push_back({ k, shear(1e-7 * double(options.steps) * (1 + 1e-3 * double(k))), 0 });
	for (auto _ : bench)
		samples.update(requests, options, 1);
	bench.counters["time/(grain step)"] = benchmark::Counter(
	        double(samples.size() * std::size_t(options.steps + 1) * state.size()),
	        benchmark::Counter::kIsIterationInvariantRate | benchmark::Counter::kInvert);
}

} // namespace

BENCHMARK(frictional)->ArgName("portable")->Arg(0)->Arg(1);
BENCHMARK(bonded)->ArgName("portable")->Arg(0)->Arg(1);
BENCHMARK(bondedWithBreakage)->ArgName("portable")->Arg(0)->Arg(1);
BENCHMARK(frictionalHertz)->ArgName("portable")->Arg(0)->Arg(1);
BENCHMARK(bondedHertz)->ArgName("portable")->Arg(0)->Arg(1);
BENCHMARK(frictionalRolling)->ArgName("portable")->Arg(0)->Arg(1);
BENCHMARK(bondedRolling)->ArgName("portable")->Arg(0)->Arg(1);
BENCHMARK(bondedWithMoments)->ArgName("portable")->Arg(0)->Arg(1);
BENCHMARK(frictionalSpheres)->ArgName("portable")->Arg(0)->Arg(1);
BENCHMARK(frictionalHertzSpheres)->ArgName("portable")->Arg(0)->Arg(1);
BENCHMARK(bondedSpheres)->ArgName("portable")->Arg(0)->Arg(1);
BENCHMARK(pool)->ArgName("steps")->Arg(10)->Arg(50)->Arg(200);
