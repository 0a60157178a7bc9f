// SPDX-License-Identifier: GPL-2.0-or-later
#include <algorithm>
#include <cstring>
#include <exception>
#include <pkg/base/ThreadPool.hpp>
#include <pkg/rve/device/SamplesOnDevice.hpp>
#include <pkg/rve/packed/CellSlip.hpp>
#include <pkg/rve/packed/PackedSamplePool.hpp>
#include <stdexcept>
#include <unordered_set>

namespace talik {

namespace {

	/// Requests in groups of equal work: same state, same increment, same ice, bit for bit.
	template <int Dim> int compareWork(const PackedRequest<Dim>& a, const void* stateA, const PackedRequest<Dim>& b, const void* stateB)
	{
		if (stateA != stateB) return std::less<const void*>()(stateA, stateB) ? -1 : 1;
		int differs = 0;
		a.forBytes([&](const void* of, std::size_t bytes) {
			const char* const its = reinterpret_cast<const char*>(&b) + (static_cast<const char*>(of) - reinterpret_cast<const char*>(&a));
			if (differs == 0) differs = std::memcmp(of, its, bytes);
		});
		return differs;
	}

	constexpr long rateRefinement = 4; ///< steps of the finer of two compared updates over those of the coarser

	/// Requests of equal work, by their places in an order.
	struct Task {
		std::size_t        begin, end;
		std::exception_ptr failure;
	};

	/// Throws std::invalid_argument on ice that no sample can have.
	template <int Dim> void checkRequest(const PackedRequest<Dim>& request)
	{
		if (!(request.iceSaturation >= 0 && request.iceSaturation <= 1))
			throw std::invalid_argument("packed sample: ice saturation " + std::to_string(request.iceSaturation) + " must lie in 0..1");
		request.checkIce();
	}

} // namespace

template <int Dim> struct SamplePool<Dim>::Worker : SampleWorker<Dim> {
	PackedUpdateResult<Dim> update(Compact& compact, const PackedRequest<Dim>& request, const PackedUpdateOptions& ofAll)
	{
		const PackedUpdateOptions options = request.options(ofAll);
		PackedUpdateResult<Dim>   result  = request.compareRates ? compareRates(*compact, request, options) : begin(*compact, request, options);
		if (result.blewUp) return result;
		slipWhereThin<Dim>(*this->sample, request.displacementGradient, options, result);
		compact = this->compact();
		return result;
	}

	/// The error of quasi-static motion is of first order in the rate: what is left of it beyond the finer steps is a geometric series.
	PackedUpdateResult<Dim> compareRates(const CompactSample<Dim>& compact, const PackedRequest<Dim>& request, PackedUpdateOptions options)
	{
		const PackedUpdateResult<Dim> coarse = begin(compact, request, options);
		if (coarse.blewUp) return coarse;
		options.steps                = rateRefinement * coarse.movingSteps;
		PackedUpdateResult<Dim> fine = begin(compact, request, options);
		fine.rateError               = (fine.stress - coarse.stress).norm() * rateRefinement / (rateRefinement - 1.);
		fine.steps += coarse.steps;
		return fine;
	}

	/// An increment that this sample cannot follow is a blow-up of this sample, not of the others.
	PackedUpdateResult<Dim> begin(const CompactSample<Dim>& compact, const PackedRequest<Dim>& request, const PackedUpdateOptions& options)
	{
		this->load(compact);
		try {
			return this->sample->update(this->state, request.displacementGradient, request.iceSaturation, options);
		} catch (const std::invalid_argument& problem) {
			PackedUpdateResult<Dim> result {};
			result.stress = 0.5 * (this->state.stress + this->state.stress.transpose());
			result.blewUp = true;
			result.reason = problem.what();
			return result;
		}
	}
};

template <int Dim> SamplePool<Dim>::SamplePool()  = default;
template <int Dim> SamplePool<Dim>::~SamplePool() = default;
template <int Dim>
SamplePool<Dim>::SamplePool(const SamplePool& other)
        : samples(other.samples)
{}

template <int Dim> SamplePool<Dim>& SamplePool<Dim>::operator=(const SamplePool& other)
{
	samples = other.samples;
	return *this;
}

template <int Dim> std::size_t SamplePool<Dim>::add(Compact compact)
{
	if (!compact) throw std::invalid_argument("sample pool: the compact sample is null");
	samples.push_back({ std::move(compact), nullptr });
	return samples.size() - 1;
}

template <int Dim> std::size_t SamplePool<Dim>::add(const PackedState<Dim>& state)
{
	state.check();
	return add(std::make_shared<const CompactSample<Dim>>(state));
}

template <int Dim> const typename SamplePool<Dim>::Held& SamplePool<Dim>::held(std::size_t sample) const
{
	if (sample >= samples.size()) throw std::invalid_argument("sample pool: sample " + std::to_string(sample) + " of " + std::to_string(samples.size()));
	return samples[sample];
}

template <int Dim> typename SamplePool<Dim>::Compact SamplePool<Dim>::compact(std::size_t sample) const
{
	const Held& now = held(sample);
	return now.away ? now.away->home() : now.home;
}

template <int Dim> const PackedParameters<Dim>& SamplePool<Dim>::parameters(std::size_t sample) const
{
	const Held& now = held(sample);
	return now.away ? now.away->parameters() : now.home->withoutArrays();
}

template <int Dim> DeviceUse SamplePool<Dim>::deviceUse() const { return device ? device->use() : DeviceUse(); }

template <int Dim> std::size_t SamplePool<Dim>::bytes(std::size_t sample) const
{
	const Held& now = held(sample);
	return now.away ? now.away->bytes() : now.home->bytes();
}

template <int Dim> void SamplePool<Dim>::share(std::size_t sample, Compact compact) { samples.at(sample) = { std::move(compact), nullptr }; }

template <int Dim> void SamplePool<Dim>::useDevice(std::shared_ptr<SampleDevice> chosen, std::function<void(const std::string&)> say)
{
	for (Held& sample : samples)
		if (sample.away) sample = { sample.away->home(), nullptr };
	device = chosen ? std::make_unique<SamplesOnDevice<Dim>>(std::move(chosen), std::move(say)) : nullptr;
}

template <int Dim> PackedState<Dim> SamplePool<Dim>::state(std::size_t sample) const
{
	PackedState<Dim> state;
	compact(sample)->expand(state);
	return state;
}

template <int Dim> void SamplePool<Dim>::setState(std::size_t sample, const PackedState<Dim>& state)
{
	state.check();
	held(sample);
	share(sample, std::make_shared<const CompactSample<Dim>>(state));
}

template <int Dim> const PackedStatistics<Dim>& SamplePool<Dim>::statistics(std::size_t sample) const
{
	const Compact now = compact(sample);
	measured.resize(samples.size());
	Measured& last = measured[sample];
	if (last.of.lock() == now) return last.statistics;
	if (!measurer) measurer = std::make_unique<Worker>();
	last.statistics = measurer->load(*now).statistics();
	last.of         = now;
	return last.statistics;
}

template <int Dim>
std::vector<PackedUpdateResult<Dim>> SamplePool<Dim>::update(const std::vector<PackedRequest<Dim>>& requests, const PackedUpdateOptions& options, int threads)
{
	checkOptions(options);
	std::vector<char> asked(samples.size(), 0);
	for (const PackedRequest<Dim>& request : requests) {
		if (request.sample >= samples.size())
			throw std::invalid_argument("sample pool: sample " + std::to_string(request.sample) + " of " + std::to_string(samples.size()));
		if (asked[request.sample]++)
			throw std::invalid_argument("sample pool: sample " + std::to_string(request.sample) + " is asked twice in one update");
		checkRequest(request);
	}
	// who shares with whom is settled here, before samples change in parallel; most share with nobody
	std::vector<std::size_t> order, shared;
	std::vector<Task>        tasks;
	order.reserve(requests.size());
	tasks.reserve(requests.size());
	for (std::size_t k = 0; k < requests.size(); ++k) {
		if (samples[requests[k].sample].isAlone()) {
			tasks.push_back({ order.size(), order.size() + 1, nullptr });
			order.push_back(k);
		} else {
			shared.push_back(k);
		}
	}
	const auto compare = [&](std::size_t a, std::size_t b) {
		return compareWork<Dim>(requests[a], samples[requests[a].sample].identity(), requests[b], samples[requests[b].sample].identity());
	};
	std::sort(shared.begin(), shared.end(), [&](std::size_t a, std::size_t b) {
		const int c = compare(a, b);
		return c != 0 ? c < 0 : a < b;
	});
	for (std::size_t k = 0; k < shared.size(); ++k) {
		if (k == 0 || compare(shared[k - 1], shared[k]) != 0) tasks.push_back({ order.size(), order.size(), nullptr });
		order.push_back(shared[k]);
		tasks.back().end = order.size();
	}
	const int wanted = std::max(1, std::min(threads > 0 ? threads : ThreadPool::threads(), int(std::max<std::size_t>(1, tasks.size()))));
	while (workers.size() < std::size_t(wanted))
		workers.push_back(std::make_unique<Worker>());
	std::vector<PackedUpdateResult<Dim>> results(requests.size());
	const auto                           take = [&](const Task& task, const PackedUpdateResult<Dim>& result, const Held& sample) {
                for (std::size_t k = task.begin; k < task.end; ++k) {
                        results[order[k]]                  = result;
                        samples[requests[order[k]].sample] = sample;
                }
	};
	const auto onProcessor = [&](Task& task, int member, Compact sample) {
		try {
			const auto result = workers[std::size_t(member)]->update(sample, requests[order[task.begin]], options);
			take(task, result, { sample, nullptr });
		} catch (...) {
			task.failure = std::current_exception();
		}
	};
	if (device && !device->lost()) {
		std::vector<typename SamplesOnDevice<Dim>::Task>& away = device->tasks();
		away.clear(); // an update that threw may have left some
		away.resize(tasks.size());
		for (std::size_t t = 0; t < tasks.size(); ++t) {
			const PackedRequest<Dim>& request = requests[order[tasks[t].begin]];
			const Held&               sample  = samples[request.sample];
			away[t].request                   = &request;
			away[t].result                    = &results[order[tasks[t].begin]];
			away[t].mayChange                 = std::size_t(sample.away.use_count()) == tasks[t].end - tasks[t].begin;
			away[t].home                      = sample.home;
			away[t].away                      = sample.away;
		}
		using Away       = typename SamplesOnDevice<Dim>::Task;
		const auto those = [&](auto which) {
			std::vector<std::size_t> chosen;
			for (std::size_t t = 0; t < tasks.size(); ++t)
				if (which(t)) chosen.push_back(t);
			ThreadPool::run(int(chosen.size()), wanted, [&](int k, int member) {
				const std::size_t t = chosen[std::size_t(k)];
				onProcessor(tasks[t], member, away[t].home);
			});
			return chosen;
		};
		device->begin(away, options, threads);
		std::vector<char> left(tasks.size(), 0);
		for (const std::size_t t : those([&](std::size_t k) { return away[k].stage == Away::processor; }))
			left[t] = 1;
		device->end(away, threads);
		those([&](std::size_t k) { return away[k].stage == Away::processor && !left[k]; });
		for (std::size_t t = 0; t < tasks.size(); ++t) {
			if (away[t].stage != Away::done) continue;
			const std::size_t first = order[tasks[t].begin];
			Held&             held  = samples[requests[first].sample];
			if (away[t].away) held.home.reset();
			else held.home = std::move(away[t].home);
			held.away = std::move(away[t].away);
			for (std::size_t k = tasks[t].begin + 1; k < tasks[t].end; ++k) {
				results[order[k]]                  = results[first];
				samples[requests[order[k]].sample] = held;
			}
		}
		away.clear();
	} else {
		ThreadPool::run(int(tasks.size()), wanted, [&](int t, int member) {
			Task& task = tasks[std::size_t(t)];
			onProcessor(task, member, compact(requests[order[task.begin]].sample));
		});
	}
	for (const Task& task : tasks)
		if (task.failure) std::rethrow_exception(task.failure);
	return results;
}

template <int Dim> std::size_t SamplePool<Dim>::distinctStates() const
{
	std::unordered_set<const void*> distinct;
	for (const Held& sample : samples)
		distinct.insert(sample.identity());
	return distinct.size();
}

template <int Dim> std::size_t SamplePool<Dim>::bytes() const
{
	std::unordered_set<const void*> distinct;
	std::size_t                     sum = 0;
	for (std::size_t s = 0; s < samples.size(); ++s)
		if (distinct.insert(samples[s].identity()).second) sum += bytes(s);
	return sum;
}

TALIK_IN_PLANE_AND_SPACE(SamplePool);

} // namespace talik
