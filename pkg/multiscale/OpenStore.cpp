// SPDX-License-Identifier: GPL-2.0-or-later
#include <pkg/multiscale/OpenStore.hpp>
#include <pkg/rve/open/ScenePacking.hpp>
#include <pkg/rve/open/StepGate.hpp>

#include <omp.h>
#include <set>
#include <stdexcept>

namespace talik {
namespace {

	Eigen::Matrix3d inSpace(const PackedTypes<2>::Matrix& inPlane)
	{
		Eigen::Matrix3d m       = Eigen::Matrix3d::Zero();
		m.topLeftCorner<2, 2>() = inPlane;
		return m;
	}

	PackedUpdateResult<2> inPlane(const OpenUpdateResult& all)
	{
		PackedUpdateResult<2> result;
		result.stress  = all.stress.topLeftCorner<2, 2>();
		result.steps   = all.steps;
		result.flipped = all.flipped;
		result.blewUp  = all.blewUp;
		result.reason  = all.reason;
		result.tangent = all.tangent;
		return result;
	}

} // namespace

OpenSample OpenStore::Beginning::makeSample() const
{
	OpenSample sample(scene);
	sample.setBondCounts(bondCounts);
	return sample;
}

OpenStore::BeginningPointer OpenStore::describe(OpenSample& sample)
{
	auto beginning           = std::make_shared<Beginning>();
	beginning->scene         = sceneToBytes(sample.yadeScene());
	beginning->bondCounts    = sample.bondCounts();
	beginning->iceSaturation = sample.iceSaturation();
	beginning->hasIce        = sample.hasIce();
	beginning->start.stress  = sample.stress().topLeftCorner<2, 2>();
	beginning->start.tangent = sample.tangent();
	beginning->statistics    = sample.statistics();
	beginning->stiffness     = sample.stiffnessBound();
	return beginning;
}

OpenStore::OpenStore(const std::vector<std::string>& scenes)
{
	for (std::size_t k = 0; k < scenes.size(); k++) {
		try {
			OpenSample sample(scenes[k]);
			prototypes.push_back(describe(sample));
		} catch (const std::invalid_argument& problem) {
			throw std::invalid_argument("RveSkeleton, sample " + std::to_string(k) + ": " + problem.what());
		}
	}
}

OpenStore::BeginningPointer OpenStore::frozen(int prototype, double iceSaturation, const PackedUpdateOptions& options) const
{
	const BeginningPointer prepared = prototypes.at(prototype);
	if (!prepared->hasIce || prepared->iceSaturation == iceSaturation) return prepared;
	forbidRedirection();
	OpenSample sample = prepared->makeSample();
	const auto result = sample.apply(Eigen::Matrix3d::Zero(), iceSaturation, options);
	if (result.blewUp) throw std::runtime_error("RveSkeleton: sample " + std::to_string(prototype) + " does not survive freezing: " + result.reason);
	return describe(sample);
}

const SampleStart& OpenStore::add(int prototype, double iceSaturation, const PackedUpdateOptions& options)
{
	auto& beginning = beginnings[{ prototype, iceSaturation }];
	if (!beginning) beginning = frozen(prototype, iceSaturation, options);
	samples.push_back({ beginning, nullptr });
	return beginning->start;
}

OpenStore::Sample& OpenStore::at(std::size_t sample)
{
	if (sample >= samples.size()) throw std::invalid_argument("open samples: sample " + std::to_string(sample) + " of " + std::to_string(samples.size()));
	return samples[sample];
}

const OpenStore::Sample& OpenStore::at(std::size_t sample) const { return const_cast<OpenStore*>(this)->at(sample); }

/// Scenes are made and archived by one thread: YADE's constructors ask the system for names.
void OpenStore::prepare(const std::vector<PackedRequest<2>>& requests)
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

std::vector<PackedUpdateResult<2>> OpenStore::update(const std::vector<PackedRequest<2>>& requests, const PackedUpdateOptions& options, int threads)
{
	prepare(requests);
	std::vector<PackedUpdateResult<2>> results(requests.size());
	std::vector<std::exception_ptr>    failures(requests.size());
	const int                          workers = std::max(1, std::min(threads > 0 ? threads : omp_get_max_threads(), int(requests.size())));
#pragma omp parallel for schedule(dynamic, 1) num_threads(workers)
	for (long k = 0; k < long(requests.size()); k++) {
		const auto&            request = requests[std::size_t(k)];
		const StepGate::Helper helper;
		try {
			results[std::size_t(k)] = inPlane(
			        samples[request.sample].running->apply(inSpace(request.displacementGradient), request.iceSaturation, options));
		} catch (...) {
			failures[std::size_t(k)] = std::current_exception();
		}
	}
	for (const auto& failure : failures)
		if (failure) std::rethrow_exception(failure);
	for (std::size_t k = 0; k < requests.size(); k++)
		if (results[k].blewUp) samples[requests[k].sample].running->recover();
	return results;
}

std::vector<double> OpenStore::measure(std::size_t number, const std::string& name) const
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
	if (name == "sampleIceSaturation") return { sample.running ? sample.running->iceSaturation() : sample.beginning->iceSaturation };
	if (name == "fabric") return { statistics.fabric(0, 0), statistics.fabric(1, 1), statistics.fabric(0, 1) };
	refuseMeasure(name);
}

const void* OpenStore::identity(std::size_t sample) const
{
	const Sample& s = at(sample);
	return s.running ? static_cast<const void*>(s.running.get()) : static_cast<const void*>(s.beginning.get());
}

std::size_t OpenStore::distinctStates() const
{
	std::set<const void*> distinct;
	for (std::size_t s = 0; s < samples.size(); s++)
		distinct.insert(identity(s));
	return distinct.size();
}

std::size_t OpenStore::bytes() const
{
	std::size_t                sum = 0;
	std::set<const Beginning*> counted;
	for (const auto& sample : samples) {
		if (sample.running) sum += sample.running->bytesKept();
		else if (counted.insert(sample.beginning.get()).second) sum += sample.beginning->scene.size();
	}
	return sum;
}

boost::shared_ptr<yade::Scene> OpenStore::scene(std::size_t number) const
{
	const Sample& sample = at(number);
	return sceneForView(sample.running ? sceneToBytes(sample.running->yadeScene()) : sample.beginning->scene);
}

void OpenStore::setScene(std::size_t number, const boost::shared_ptr<yade::Scene>& scene)
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

// Sleeping samples name one of the shared beginnings (number + 1), the others are written out (0).
void OpenStore::save(ByteWriter& writer) const
{
	std::map<const Beginning*, std::uint64_t> numbers;
	std::vector<const Beginning*>             shared;
	for (const auto& sample : samples)
		if (!sample.running && numbers.emplace(sample.beginning.get(), shared.size() + 1).second) shared.push_back(sample.beginning.get());
	writer.number(shared.size());
	for (const auto* beginning : shared) {
		writer.block(beginning->scene);
		for (const auto count : beginning->bondCounts)
			writer.number(count);
	}
	writer.number(samples.size());
	for (const auto& sample : samples) {
		writer.number(sample.running ? 0 : numbers.at(sample.beginning.get()));
		if (!sample.running) continue;
		writer.block(sceneToBytes(sample.running->yadeScene()));
		for (const auto count : sample.running->bondCounts())
			writer.number(count);
	}
}

void OpenStore::restore(ByteReader& reader)
{
	const auto makeSample = [&] {
		auto                         sample = std::make_unique<OpenSample>(reader.block());
		std::array<std::uint64_t, 2> counts;
		for (auto& count : counts)
			count = reader.number();
		sample->setBondCounts(counts);
		return sample;
	};
	std::vector<BeginningPointer> shared(reader.number());
	for (auto& beginning : shared)
		beginning = describe(*makeSample());
	samples.clear();
	samples.resize(reader.number());
	for (auto& sample : samples) {
		const std::uint64_t number = reader.number();
		if (number > 0) sample.beginning = shared.at(number - 1);
		else sample.running = makeSample();
	}
}

} // namespace talik
