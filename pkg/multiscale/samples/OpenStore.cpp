// SPDX-License-Identifier: GPL-2.0-or-later
#include <pkg/multiscale/samples/OpenStore.hpp>
#include <pkg/python/StepGate.hpp>
#include <pkg/rve/open/ScenePacking.hpp>

#include <omp.h>
#include <set>
#include <stdexcept>

namespace talik {
namespace {

	template <int Dim> Eigen::Matrix3d inSpace(const typename PackedTypes<Dim>::Matrix& m)
	{
		Eigen::Matrix3d all                    = Eigen::Matrix3d::Zero();
		all.template topLeftCorner<Dim, Dim>() = m;
		return all;
	}

	template <int Dim> typename PackedTypes<Dim>::Matrix part(const Eigen::Matrix3d& m) { return m.template topLeftCorner<Dim, Dim>(); }

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

	template <int Dim> PackedUpdateResult<Dim> part(const OpenUpdateResult& all)
	{
		PackedUpdateResult<Dim> result;
		result.stress  = part<Dim>(all.stress);
		result.steps   = all.steps;
		result.flipped = all.flipped;
		result.blewUp  = all.blewUp;
		result.reason  = all.reason;
		result.tangent = part<Dim>(all.tangent);
		return result;
	}

} // namespace

template <int Dim> OpenSample OpenStore<Dim>::Beginning::makeSample() const
{
	OpenSample sample(scene);
	sample.setBondCounts(bondCounts);
	return sample;
}

template <int Dim> typename OpenStore<Dim>::BeginningPointer OpenStore<Dim>::describe(OpenSample& sample)
{
	auto beginning           = std::make_shared<Beginning>();
	beginning->scene         = sceneToBytes(sample.yadeScene());
	beginning->bondCounts    = sample.bondCounts();
	beginning->iceSaturation = sample.iceSaturation();
	beginning->hasIce        = sample.hasIce();
	beginning->start.stress  = part<Dim>(sample.stress());
	beginning->start.tangent = part<Dim>(sample.tangent());
	beginning->statistics    = sample.statistics();
	beginning->stiffness     = sample.stiffnessBound();
	return beginning;
}

template <int Dim> OpenStore<Dim>::OpenStore(const std::vector<std::string>& scenes)
{
	for (std::size_t k = 0; k < scenes.size(); ++k) {
		try {
			OpenSample sample(scenes[k]);
			if (Dim == 3 && sample.planar()) throw std::invalid_argument("its grains are discs, and the ground is in space: give spheres.");
			prototypes.push_back(describe(sample));
		} catch (const std::invalid_argument& problem) {
			throw std::invalid_argument("RveSkeleton, sample " + std::to_string(k) + ": " + problem.what());
		}
	}
}

template <int Dim>
typename OpenStore<Dim>::BeginningPointer OpenStore<Dim>::frozen(int prototype, double iceSaturation, const PackedUpdateOptions& options) const
{
	const BeginningPointer prepared = prototypes.at(prototype);
	if (!prepared->hasIce || prepared->iceSaturation == iceSaturation) return prepared;
	forbidRedirection();
	OpenSample sample = prepared->makeSample();
	const auto result = sample.apply(Eigen::Matrix3d::Zero(), iceSaturation, options);
	if (result.blewUp) throw std::runtime_error("RveSkeleton: sample " + std::to_string(prototype) + " does not survive freezing: " + result.reason);
	return describe(sample);
}

template <int Dim> const SampleStart<Dim>& OpenStore<Dim>::add(int prototype, double iceSaturation, const PackedUpdateOptions& options)
{
	auto& beginning = beginnings[{ prototype, iceSaturation }];
	if (!beginning) beginning = frozen(prototype, iceSaturation, options);
	samples.push_back({ beginning, nullptr });
	return beginning->start;
}

template <int Dim> typename OpenStore<Dim>::Sample& OpenStore<Dim>::at(std::size_t sample)
{
	if (sample >= samples.size()) throw std::invalid_argument("open samples: sample " + std::to_string(sample) + " of " + std::to_string(samples.size()));
	return samples[sample];
}

template <int Dim> const typename OpenStore<Dim>::Sample& OpenStore<Dim>::at(std::size_t sample) const { return const_cast<OpenStore*>(this)->at(sample); }

/// Scenes are made and archived by one thread: YADE's constructors ask the system for names.
template <int Dim> void OpenStore<Dim>::prepare(const std::vector<PackedRequest<Dim>>& requests)
{
	forbidRedirection();
	std::set<std::size_t> asked;
	for (const auto& request : requests) {
		at(request.sample);
		if (!asked.insert(request.sample).second)
			throw std::invalid_argument("open samples: sample " + std::to_string(request.sample) + " is asked twice in one update");
	}
	for (const std::size_t s : asked) {
		Sample& sample = samples[s];
		if (!sample.running) sample.running = std::make_unique<OpenSample>(sample.beginning->makeSample());
		sample.running->keepState();
		sample.beginning.reset();
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
		const auto&         request = requests[std::size_t(k)];
		PackedUpdateOptions chosen  = options;
		chosen.strength             = request.strength;
		chosen.iceStiffness         = request.iceStiffness;
		chosen.creep                = request.creep;
		const StepGate::Helper helper;
		try {
			results[std::size_t(k)] = part<Dim>(
			        samples[request.sample].running->apply(inSpace<Dim>(request.displacementGradient), request.iceSaturation, chosen));
		} catch (...) {
			failures[std::size_t(k)] = std::current_exception();
		}
	}
	for (const auto& failure : failures)
		if (failure) std::rethrow_exception(failure);
	for (std::size_t k = 0; k < requests.size(); ++k)
		if (results[k].blewUp) samples[requests[k].sample].running->recover();
	return results;
}

template <int Dim> std::vector<double> OpenStore<Dim>::measure(std::size_t number, const std::string& name) const
{
	const Sample&        sample     = at(number);
	const OpenStatistics statistics = sample.running ? sample.running->statistics() : sample.beginning->statistics;
	if (name == "bondsIntact") return { double(statistics.bondsIntact) };
	if (name == "bondsFormed") return { double(statistics.bondsFormed) };
	if (name == "bondsBroken") return { double(statistics.bondsBroken) };
	if (name == "bondsMelted") return { double(statistics.bondsMelted) };
	if (name == "contacts") return { double(statistics.contacts) };
	if (name == "coordinationNumber") return { statistics.coordinationNumber };
	if (name == "samplePorosity") return { statistics.porosity };
	if (name == "cellThickness") return { statistics.cellThickness };
	if (name == "cellSlips") return { 0. };
	if (name == "sampleIceSaturation") return { sample.running ? sample.running->iceSaturation() : sample.beginning->iceSaturation };
	if (name == "fabric") return components<Dim>(part<Dim>(statistics.fabric));
	refuseMeasure(name);
}

template <int Dim> const void* OpenStore<Dim>::identity(std::size_t sample) const
{
	const Sample& s = at(sample);
	return s.running ? static_cast<const void*>(s.running.get()) : static_cast<const void*>(s.beginning.get());
}

template <int Dim> std::size_t OpenStore<Dim>::bytes() const
{
	std::size_t                sum = 0;
	std::set<const Beginning*> counted;
	for (const auto& sample : samples) {
		if (sample.running) sum += sample.running->bytesKept();
		else if (counted.insert(sample.beginning.get()).second) sum += sample.beginning->scene.size();
	}
	return sum;
}

template <int Dim> boost::shared_ptr<yade::Scene> OpenStore<Dim>::scene(std::size_t number) const
{
	const Sample& sample = at(number);
	return sceneForView(sample.running ? sceneToBytes(sample.running->yadeScene()) : sample.beginning->scene);
}

template <int Dim> void OpenStore<Dim>::setScene(std::size_t number, const boost::shared_ptr<yade::Scene>& scene)
{
	auto    replacement = std::make_unique<OpenSample>(sceneToBytes(scene));
	Sample& sample      = at(number);
	if (!sample.running) sample.running = std::make_unique<OpenSample>(sample.beginning->makeSample());
	const std::uint64_t before = sample.running->statistics().bondsIntact, now = replacement->statistics().bondsIntact;
	auto                counts = sample.running->bondCounts();
	if (now > before) counts[0] += now - before;
	replacement->setBondCounts(counts);
	sample.running = std::move(replacement);
	sample.beginning.reset();
}

template <int Dim> double OpenStore<Dim>::costOfStep(std::size_t number) const
{
	const Sample& sample = at(number);
	return sample.running ? double(sample.running->yadeScene()->bodies->size()) : 1.;
}

// whether it runs or shares its beginning, then the scene
template <int Dim> void OpenStore<Dim>::saveState(ByteWriter& writer, std::size_t number) const
{
	const Sample& sample = at(number);
	writer.number(bool(sample.running));
	writer.block(sample.running ? sceneToBytes(sample.running->yadeScene()) : sample.beginning->scene);
	for (const auto count : sample.running ? sample.running->bondCounts() : sample.beginning->bondCounts)
		writer.number(count);
}

template <int Dim> void OpenStore<Dim>::restoreState(ByteReader& reader, const std::vector<std::size_t>& numbers)
{
	const bool                   running = reader.number();
	auto                         sample  = std::make_unique<OpenSample>(reader.block());
	std::array<std::uint64_t, 2> counts;
	for (auto& count : counts)
		count = reader.number();
	sample->setBondCounts(counts);
	if (running) samples.at(numbers.at(0)) = Sample { nullptr, std::move(sample) };
	else {
		const BeginningPointer beginning = describe(*sample);
		for (const auto number : numbers)
			samples.at(number) = Sample { beginning, nullptr };
	}
}

template <int Dim> void OpenStore<Dim>::resize(std::size_t count)
{
	samples.clear();
	samples.resize(count);
}

TALIK_IN_PLANE_AND_SPACE(OpenStore);

} // namespace talik
