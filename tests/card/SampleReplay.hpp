// SPDX-License-Identifier: GPL-2.0-or-later
#pragma once
#include <chrono>
#include <cstdint>
#include <cstring>
#include <fstream>
#include <memory>
#include <pkg/rve/device/SampleDevice.hpp>
#include <pkg/rve/packed/PackedSamplePool.hpp>
#include <stdexcept>
#include <string>
#include <vector>

namespace talik {

/// What a ground of some points asked its samples, step by step, for any number of points: point p does what point p modulo N of the record did, up
/// to a small part of its strain, so that each has a state of its own. scripts/benchmarks/cardreplay.py writes the file, numbers in 8 bytes:
/// N, I_max; of each sample the bytes of its state, after their number; then of each step the number of its requests, and of each request sample,
/// displacement gradient and ice saturation.
template <int Dim> class SampleReplay {
public:
	using Compact = std::shared_ptr<const CompactSample<Dim>>;

	explicit SampleReplay(const std::string& path)
	        : file(path, std::ios::binary)
	{
		const auto samples        = count();
		options.maxInertialNumber = number();
		options.tangent           = true;
		for (std::uint64_t s = 0; s < samples; ++s) {
			std::string bytes(count(), '\0');
			file.read(bytes.data(), std::streamsize(bytes.size()));
			starts.push_back(std::make_shared<const CompactSample<Dim>>(PackedState<Dim>::fromBytes(bytes)));
		}
		for (std::uint64_t requests; file.read(reinterpret_cast<char*>(&requests), sizeof(requests));) {
			steps.emplace_back();
			for (std::uint64_t r = 0; r < requests; ++r) {
				PackedRequest<Dim> request;
				request.sample = count();
				for (int k = 0; k < Dim * Dim; ++k)
					request.displacementGradient(k / Dim, k % Dim) = number();
				request.iceSaturation = number();
				steps.back().push_back(request);
			}
		}
	}

	/// Of one way to compute it.
	struct Took {
		double                   seconds = 0;
		std::size_t              updates = 0;
		long                     steps   = 0; ///< of grains
		DeviceUse                use {};
		std::vector<std::string> bytes; ///< of some of the samples in the end
	};
	Took run(std::size_t points, const std::shared_ptr<SampleDevice>& device, int threads) const
	{
		SamplePool<Dim> pool;
		pool.useDevice(device, [](const std::string& sentence) { std::fprintf(stderr, "%s\n", sentence.c_str()); });
		for (std::size_t p = 0; p < points; ++p)
			pool.add(starts[p % starts.size()]);
		Took       took;
		const auto begin = std::chrono::steady_clock::now();
		for (const auto& asked : steps) {
			const auto requests = forPoints(asked, points);
			took.updates += requests.size();
			for (const auto& result : pool.update(requests, options, threads))
				took.steps += result.steps;
		}
		took.seconds = std::chrono::duration<double>(std::chrono::steady_clock::now() - begin).count();
		took.use     = pool.deviceUse();
		for (std::size_t k = 0; k < looks; ++k)
			took.bytes.push_back(pool.state(k * points / looks).toBytes());
		return took;
	}

	std::size_t stepsOfGround() const { return steps.size(); }

private:
	static constexpr std::size_t looks = 50;

	std::vector<PackedRequest<Dim>> forPoints(const std::vector<PackedRequest<Dim>>& asked, std::size_t points) const
	{
		std::vector<PackedRequest<Dim>> requests;
		for (std::size_t copy = 0; copy * starts.size() < points; ++copy)
			for (PackedRequest<Dim> request : asked) {
				request.sample += copy * starts.size();
				request.displacementGradient *= 1 + 1e-6 * double(copy);
				if (request.sample < points) requests.push_back(request);
			}
		return requests;
	}
	template <class Number> Number take()
	{
		Number number;
		if (!file.read(reinterpret_cast<char*>(&number), sizeof(number))) throw std::runtime_error("the record of requests ends too early");
		return number;
	}
	std::uint64_t count() { return take<std::uint64_t>(); }
	double        number() { return take<double>(); }

	std::ifstream                                file;
	PackedUpdateOptions                          options;
	std::vector<Compact>                         starts;
	std::vector<std::vector<PackedRequest<Dim>>> steps;
};

} // namespace talik
