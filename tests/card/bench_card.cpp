// SPDX-License-Identifier: GPL-2.0-or-later
// Time of packed samples on a device beside the processor, for scripts/bench gpu: bench_card DEVICE SAMPLES[,SAMPLES...] DATA prints JSON. Calls are whole
// ones, as the ground asks them. Where bits differ nothing is compared.
#include "packedStarts.hpp"

#include <pkg/mpm/ThreadPool.hpp>
#include <pkg/rve/device/SampleDevice.hpp>
#include <pkg/rve/packed/PackedSamplePool.hpp>

#include <chrono>
#include <cstdio>
#include <cstdlib>
#include <cstring>
#include <string>

using namespace talik;

namespace {

double now() { return std::chrono::duration<double>(std::chrono::steady_clock::now().time_since_epoch()).count(); }

template <int Dim> class Measured {
public:
	Measured(const PackedState<Dim>& start, std::size_t samples, std::shared_ptr<SampleDevice> device, int threads)
	        : grains(start.size())
	        , team(threads)
	{
		pool.useDevice(std::move(device), [](const std::string& sentence) { std::fprintf(stderr, "%s\n", sentence.c_str()); });
		for (std::size_t s = 0; s < samples; ++s)
			pool.add(start);
	}
	/// Nanoseconds a grain and step of some calls of so many steps.
	double call(long steps, int calls)
	{
		PackedUpdateOptions options;
		options.steps = steps;
		long   done   = 0;
		double start  = now();
		for (int k = 0; k < calls; ++k) {
			std::vector<PackedRequest<Dim>> requests(pool.size());
			for (std::size_t s = 0; s < pool.size(); ++s) {
				requests[s].sample                     = s;
				requests[s].displacementGradient(0, 1) = 1e-7 * double(steps) * (1 + 1e-3 * double(s % 100));
				requests[s].iceSaturation              = pool.parameters(s).iceSaturation;
			}
			for (const auto& result : pool.update(requests, options, team))
				done += result.steps;
			if (k == 0) start = now(), done = 0; // samples go to the device once
		}
		return (now() - start) * 1e9 / double(done) / double(grains);
	}
	std::string bytes() const { return pool.state(0).toBytes() + pool.state(pool.size() - 1).toBytes(); }

private:
	SamplePool<Dim> pool;
	std::size_t     grains;
	int             team;
};

bool first = true;

template <int Dim> bool row(const char* kind, const PackedState<Dim>& start, std::size_t samples, long steps, const std::shared_ptr<SampleDevice>& device)
{
	constexpr int calls = 6;
	Measured<Dim> one(start, std::min<std::size_t>(samples, 24), nullptr, 1), all(start, samples, nullptr, 0), there(start, samples, device, 0);
	const double  ofOne = one.call(steps, calls), ofAll = all.call(steps, calls), ofDevice = there.call(steps, calls);
	const bool    same = all.bytes() == there.bytes();
	std::printf(
	        "%s{\"kind\": \"%s\", \"samples\": %zu, \"grains\": %zu, \"steps\": %ld, \"same\": %s, \"core\": %.4g, \"all\": %.4g, \"device\": %.4g}",
	        first ? "" : ",\n", kind, samples, start.size(), steps, same ? "true" : "false", ofOne, ofAll, same ? ofDevice : 0.);
	first = false;
	return same;
}

/// Samples of one size, thawed and frozen, in calls of few and of many steps.
template <int Dim> bool rows(const PackedState<Dim>& moving, std::size_t samples, const std::shared_ptr<SampleDevice>& device)
{
	const std::string kind = Dim == 2 ? "discs" : "spheres";
	PackedSample<Dim> settled(moving);
	settled.advance(PackedTypes<Dim>::Matrix::Zero(), 5000); // samples of a ground that is updated are at rest
	const PackedState<Dim> start = settled.state(), frozen = packedStarts::frozenOf<Dim>(start, 0.5, 20);
	bool                   same = true;
	for (const long steps : { 10l, 40l }) {
		same &= row<Dim>(kind.c_str(), start, samples, steps, device);
		same &= row<Dim>((kind + ", frozen").c_str(), frozen, samples, steps, device);
	}
	return same;
}

} // namespace

int main(int count, char** words)
{
	if (count < 4) return 2;
	std::shared_ptr<SampleDevice> device;
	try {
		device = std::strcmp(words[1], "twin") == 0 ? makeTwin() : openCard();
	} catch (const DeviceFailure& failure) {
		std::printf("{\"missing\": \"%s\"}\n", failure.what());
		return 0;
	}
	const std::string data    = words[3];
	const auto        discs   = packedReference::read(data + "/packed_reference.txt").state();
	const auto        spheres = packedSpheres::read(data + "/packed_spheres_reference.txt").state();
	const auto        more    = packedStarts::tiled<2>(discs, { 2, 1, 1 });
	const auto        many    = packedStarts::tiled<3>(spheres, { 2, 2, 2 });
	bool              same    = true;
	std::printf("{\"device\": \"%s\", \"threads\": %d, \"rows\": [\n", device->name().c_str(), ThreadPool::threads());
	for (const char* at = words[2]; *at;) {
		char*             end;
		const std::size_t samples = std::strtoul(at, &end, 10);
		for (const auto& start : { discs, more })
			same &= rows<2>(start, samples, device);
		for (const auto& start : { spheres, many })
			same &= rows<3>(start, samples, device);
		at = *end == ',' ? end + 1 : end;
	}
	std::printf("\n]}\n");
	return same ? 0 : 1;
}
