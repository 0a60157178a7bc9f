// SPDX-License-Identifier: GPL-2.0-or-later
// Time of packed samples on a device beside the processor, for scripts/bench gpu: bench_card DEVICE SAMPLES[,SAMPLES...] DATA prints JSON. Calls are whole
// ones, as the ground asks them. bench_card DEVICE POINTS --replay RECORD does for so many points what was recorded of a scene in space. Where bits
// differ nothing is compared.
#include "packedStarts.hpp"
#include "SampleReplay.hpp"

#include <pkg/base/ThreadPool.hpp>
#include <pkg/rve/device/SampleDevice.hpp>
#include <pkg/rve/packed/PackedSamplePool.hpp>

#include <algorithm>
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
	/// Nanoseconds a grain and step of some calls of so many steps, each with such a strain.
	double call(long steps, int calls, double strain)
	{
		PackedUpdateOptions options;
		options.steps = steps;
		done          = 0;
		double start  = now();
		for (int k = 0; k < calls; ++k) {
			std::vector<PackedRequest<Dim>> requests(pool.size());
			for (std::size_t s = 0; s < pool.size(); ++s) {
				requests[s].sample                     = s;
				requests[s].displacementGradient(0, 1) = strain * double(steps) * (1 + 1e-3 * double(s % 100));
				requests[s].iceSaturation              = pool.parameters(s).iceSaturation;
			}
			for (const auto& result : pool.update(requests, options, team))
				done += result.steps;
			if (k == 0) start = now(), done = 0, before = pool.deviceUse(); // samples go to the device once
		}
		return perGrainAndStep(now() - start);
	}
	/// Where the time went, the same [ns], and how often lists were built in an update.
	void printParts() const
	{
		const DeviceUse use = pool.deviceUse();
		std::printf(
		        "\"making\": %.3g, \"sending\": %.3g, \"waiting\": %.3g, \"receiving\": %.3g, \"taking\": %.3g, \"lists\": %.3g, \"ended\": %.3g, ",
		        perGrainAndStep(use.making - before.making), perGrainAndStep(use.sending - before.sending),
		        perGrainAndStep(use.waiting - before.waiting), perGrainAndStep(use.receiving - before.receiving),
		        perGrainAndStep(use.taking - before.taking), perUpdate(use, use.lists - before.lists), perUpdate(use, use.ended - before.ended));
	}
	std::string bytes() const { return pool.state(0).toBytes() + pool.state(pool.size() - 1).toBytes(); }

private:
	double perGrainAndStep(double seconds) const { return seconds * 1e9 / double(done) / double(grains); }
	double perUpdate(const DeviceUse& use, std::size_t number) const
	{
		return double(number) / double(std::max<std::size_t>(1, use.done + use.ended - before.done - before.ended));
	}

	SamplePool<Dim> pool;
	std::size_t     grains;
	int             team;
	long            done = 0;
	DeviceUse       before;
};

bool first = true;

template <int Dim>
bool row(const char* kind, const PackedState<Dim>& start, std::size_t samples, long steps, const std::shared_ptr<SampleDevice>& device, double strain = 1e-7)
{
	constexpr int calls = 6;
	Measured<Dim> one(start, std::min<std::size_t>(samples, 24), nullptr, 1), all(start, samples, nullptr, 0), there(start, samples, device, 0);
	const double  ofOne = one.call(steps, calls, strain), ofAll = all.call(steps, calls, strain), ofDevice = there.call(steps, calls, strain);
	const bool    same = all.bytes() == there.bytes();
	std::printf("%s{\"kind\": \"%s\", \"samples\": %zu, \"grains\": %zu, \"steps\": %ld, ", first ? "" : ",\n", kind, samples, start.size(), steps);
	there.printParts();
	std::printf("\"same\": %s, \"core\": %.4g, \"all\": %.4g, \"device\": %.4g}", same ? "true" : "false", ofOne, ofAll, same ? ofDevice : 0.);
	std::fflush(stdout);
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
	same &= row<Dim>((kind + ", flowing").c_str(), moving, samples, 40, device, 1e-5); // lists of neighbours are used up
	return same;
}

/// The same on all cores and on the device.
bool replay(std::size_t points, const std::string& record, const std::shared_ptr<SampleDevice>& device)
{
	SampleReplay<3> asked(record);
	const auto      all = asked.run(points, nullptr, 0), there = asked.run(points, device, 0);
	const bool      same = all.bytes == there.bytes && all.steps == there.steps;
	std::printf(
	        "\"replay\": {\"points\": %zu, \"ground\": %zu, \"updates\": %zu, \"steps\": %ld, \"all\": %.4g, \"device\": %.4g, ", points,
	        asked.stepsOfGround(), all.updates, all.steps, all.seconds, same ? there.seconds : 0.);
	std::printf(
	        "\"done\": %zu, \"ended\": %zu, \"left\": %zu, \"waiting\": %.4g, \"same\": %s}", there.use.done, there.use.ended, there.use.left,
	        there.use.waiting, same ? "true" : "false");
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
	if (count == 5 && std::strcmp(words[3], "--replay") == 0) {
		std::printf("{\"device\": \"%s\", \"threads\": %d,\n", device->name().c_str(), ThreadPool::threads());
		const bool same = replay(std::strtoul(words[2], nullptr, 10), words[4], device);
		std::printf("}\n");
		return same ? 0 : 1;
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
