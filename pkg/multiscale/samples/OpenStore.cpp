// SPDX-License-Identifier: GPL-2.0-or-later
#include <pkg/multiscale/samples/OpenStore.hpp>
#include <pkg/python/StepGate.hpp>

#include <omp.h>
#include <set>
#include <stdexcept>

namespace talik {
namespace {

	/// The tangent of the first Dim directions.
	template <int Dim> PackedTangent<Dim> part(const PackedTangent<3>& c)
	{
		PackedTangent<Dim> result;
		for (int i = 0; i < Dim; ++i)
			for (int j = 0; j < Dim; ++j)
				for (int k = 0; k < Dim; ++k)
					for (int l = 0; l < Dim; ++l)
						result[((i * Dim + j) * Dim + k) * Dim + l] = c[((i * 3 + j) * 3 + k) * 3 + l];
		return result;
	}

	template <int Dim> PackedUpdateResult<Dim> part(const PackedUpdateResult<3>& all)
	{
		PackedUpdateResult<Dim> result;
		result.stress  = partOf<Dim>(all.stress);
		result.steps   = all.steps;
		result.flipped = all.flipped;
		result.blewUp  = all.blewUp;
		result.reason  = all.reason;
		result.tangent = part<Dim>(all.tangent);
		return result;
	}

	std::shared_ptr<OpenSample> copyOf(const OpenSample& sample)
	{
		const auto copy = std::make_shared<OpenSample>(sceneToBytes(sample.yadeScene()));
		copy->setBondCounts(sample.bondCounts());
		return copy;
	}

} // namespace

template <int Dim> OpenStore<Dim>::OpenStore(const std::vector<std::string>& scenes)
{
	for (std::size_t k = 0; k < scenes.size(); ++k) {
		try {
			prototypes.push_back(std::make_shared<OpenSample>(scenes[k]));
			if (Dim == 3 && prototypes.back()->planar())
				throw std::invalid_argument("its grains are discs, and the ground is in space: give spheres.");
			stiffness.push_back(prototypes.back()->stiffnessBound());
		} catch (const std::invalid_argument& problem) {
			throw std::invalid_argument("RveSkeleton, sample " + std::to_string(k) + ": " + problem.what());
		}
	}
}

template <int Dim> const SampleStart<Dim>& OpenStore<Dim>::add(int prototype, double iceSaturation, const PackedUpdateOptions& options)
{
	Beginning& beginning = beginnings[{ prototype, iceSaturation }];
	if (!beginning.sample) {
		Pointer sample = prototypes.at(prototype);
		if (sample->hasIce() && sample->iceSaturation() != iceSaturation) {
			forbidRedirection();
			sample            = copyOf(*sample);
			const auto result = sample->apply(Eigen::Matrix3d::Zero(), iceSaturation, options);
			if (result.blewUp)
				throw std::runtime_error("RveSkeleton: sample " + std::to_string(prototype) + " does not survive freezing: " + result.reason);
		}
		beginning = { sample, { partOf<Dim>(sample->stress()), part<Dim>(sample->tangent()) } };
	}
	samples.push_back(beginning.sample);
	return beginning.start;
}

/// Scenes are made and archived by one thread: YADE's constructors ask the system for names.
template <int Dim> void OpenStore<Dim>::prepare(const std::vector<PackedRequest<Dim>>& requests)
{
	forbidRedirection();
	std::set<std::size_t> asked;
	for (const auto& request : requests)
		if (!asked.insert(request.sample).second)
			throw std::invalid_argument("open samples: sample " + std::to_string(request.sample) + " is asked twice in one update");
	for (const std::size_t s : asked) {
		Pointer& sample = samples.at(s);
		if (sample.use_count() > 1) sample = copyOf(*sample);
		sample->keepState();
	}
}

template <int Dim>
std::vector<PackedUpdateResult<Dim>> OpenStore<Dim>::update(const std::vector<PackedRequest<Dim>>& requests, const PackedUpdateOptions& options, int threads)
{
	prepare(requests);
	std::vector<PackedUpdateResult<Dim>> results(requests.size());
	std::vector<std::exception_ptr>      failures(requests.size());
	const int                            workers = std::max(1, std::min(threads > 0 ? threads : omp_get_max_threads(), int(requests.size())));
#pragma omp parallel for schedule(dynamic, 1) num_threads(workers)
	for (long k = 0; k < long(requests.size()); ++k) {
		const auto&            request = requests[std::size_t(k)];
		const StepGate::Helper helper;
		try {
			results[std::size_t(k)] = part<Dim>(
			        samples[request.sample]->apply(inSpace<Dim>(request.displacementGradient), request.iceSaturation, request.options(options)));
		} catch (...) {
			failures[std::size_t(k)] = std::current_exception();
		}
	}
	for (const auto& failure : failures)
		if (failure) std::rethrow_exception(failure);
	for (std::size_t k = 0; k < requests.size(); ++k)
		if (results[k].blewUp) samples[requests[k].sample]->recover();
	return results;
}

template <int Dim> std::vector<double> OpenStore<Dim>::measureHere(std::size_t number, const std::string& name) const
{
	const auto& sample = *samples.at(number);
	if (name == "cellSlips") return { 0. };
	if (name == "sampleIceSaturation") return { sample.iceSaturation() };
	const OpenStatistics statistics = sample.statistics();
	if (name == "bondsFormed") return { double(statistics.bondsFormed) };
	if (name == "bondsBroken") return { double(statistics.bondsBroken) };
	if (name == "bondsMelted") return { double(statistics.bondsMelted) };
	return measureFrom<Dim>(statistics, name);
}

template <int Dim> std::size_t OpenStore<Dim>::bytes() const
{
	const std::set<Pointer> distinct(samples.begin(), samples.end());
	std::size_t             sum = 0;
	for (const auto& sample : distinct)
		sum += sample->bytesKept();
	return sum;
}

template <int Dim> void OpenStore<Dim>::setScene(std::size_t number, const boost::shared_ptr<yade::Scene>& scene)
{
	const auto          replacement = std::make_shared<OpenSample>(sceneToBytes(scene));
	const std::uint64_t before = samples.at(number)->statistics().bondsIntact, now = replacement->statistics().bondsIntact;
	auto                counts = samples[number]->bondCounts();
	if (now > before) counts[0] += now - before;
	replacement->setBondCounts(counts);
	samples[number] = replacement;
}

template <int Dim> void OpenStore<Dim>::saveState(ByteWriter& writer, std::size_t number) const
{
	writer.block(sceneToBytes(samples.at(number)->yadeScene()));
	for (const auto count : samples[number]->bondCounts())
		writer.number(count);
}

template <int Dim> void OpenStore<Dim>::restoreState(ByteReader& reader, const std::vector<std::size_t>& numbers)
{
	const auto                   sample = std::make_shared<OpenSample>(reader.block());
	std::array<std::uint64_t, 2> counts;
	for (auto& count : counts)
		count = reader.number();
	sample->setBondCounts(counts);
	for (const auto number : numbers)
		samples.at(number) = sample;
}

TALIK_IN_PLANE_AND_SPACE(OpenStore);

} // namespace talik
