// SPDX-License-Identifier: GPL-2.0-or-later
#include <algorithm>
#include <cstring>
#include <exception>
#include <omp.h>
#include <pkg/rve/PackedProtocol.hpp>
#include <pkg/rve/PackedSamplePool.hpp>
#include <pkg/rve/PackedWorkspace.hpp>
#include <stdexcept>
#include <string>
#include <unordered_set>

namespace talik {

namespace {

	/// Requests in groups of equal work: same state, same increment, same ice, bit for bit.
	template <int Dim> int compareWork(const PackedRequest<Dim>& a, const PackedState<Dim>* stateA, const PackedRequest<Dim>& b, const PackedState<Dim>* stateB)
	{
		if (stateA != stateB) return std::less<const PackedState<Dim>*>()(stateA, stateB) ? -1 : 1;
		if (const int c = std::memcmp(a.displacementGradient.data(), b.displacementGradient.data(), sizeof(double) * Dim * Dim)) return c;
		return std::memcmp(&a.iceSaturation, &b.iceSaturation, sizeof(double));
	}

	template <int Dim> struct Task {
		std::size_t                            request; ///< the first of its group
		std::shared_ptr<const PackedState<Dim>> before, after;
		std::shared_ptr<const PackedLists<Dim>> listsBefore, listsAfter;
		PackedUpdateResult<Dim>                result;
		std::exception_ptr                     failure;
	};

	template <int Dim> void perform(Task<Dim>& task, const PackedRequest<Dim>& request, const PackedUpdateOptions& options, PackedWorkspace<Dim>& workspace)
	{
		try {
			workspace.load(*task.before, task.listsBefore.get());
			task.result = updateWorkspace<Dim>(workspace, *task.before, request.displacementGradient, request.iceSaturation, options);
			task.after      = task.before;
			task.listsAfter = task.listsBefore;
			if (task.result.blewUp) return;
			auto after = std::make_shared<PackedState<Dim>>();
			auto lists = std::make_shared<PackedLists<Dim>>();
			workspace.store(*after);
			workspace.store(*lists);
			task.after      = std::move(after);
			task.listsAfter = std::move(lists);
		} catch (...) {
			task.failure = std::current_exception();
		}
	}

} // namespace

template <int Dim> struct SamplePool<Dim>::Memory {
	std::vector<std::shared_ptr<const PackedLists<Dim>>>  lists; ///< of the state of the same index, or null
	std::vector<std::unique_ptr<PackedWorkspace<Dim>>>    workspaces;

	PackedWorkspace<Dim>& workspace(std::size_t worker)
	{
		std::unique_ptr<PackedWorkspace<Dim>>& mine = workspaces[worker];
		if (!mine || mine->portableOnly() != portablePathForced()) mine = std::make_unique<PackedWorkspace<Dim>>(portablePathForced());
		return *mine;
	}
};

template <int Dim> SamplePool<Dim>::SamplePool() : memory(std::make_shared<Memory>()) {}

template <int Dim> SamplePool<Dim>& SamplePool<Dim>::operator=(const SamplePool& other)
{
	states = other.states;
	memory = std::make_shared<Memory>();
	return *this;
}

template <int Dim> std::size_t SamplePool<Dim>::add(StatePointer state)
{
	if (!state) throw std::invalid_argument("sample pool: the state is null");
	state->check();
	states.push_back(std::move(state));
	return states.size() - 1;
}

template <int Dim> typename SamplePool<Dim>::StatePointer SamplePool<Dim>::state(std::size_t sample) const
{
	if (sample >= states.size()) throw std::invalid_argument("sample pool: sample " + std::to_string(sample) + " of " + std::to_string(states.size()));
	return states[sample];
}

template <int Dim> void SamplePool<Dim>::setState(std::size_t sample, StatePointer state)
{
	if (sample >= states.size()) throw std::invalid_argument("sample pool: sample " + std::to_string(sample) + " of " + std::to_string(states.size()));
	if (!state) throw std::invalid_argument("sample pool: the state is null");
	state->check();
	states[sample] = std::move(state);
	if (sample < memory->lists.size()) memory->lists[sample].reset();
}

template <int Dim> void SamplePool<Dim>::clear()
{
	states.clear();
	memory->lists.clear();
}

template <int Dim>
std::vector<PackedUpdateResult<Dim>>
SamplePool<Dim>::update(const std::vector<PackedRequest<Dim>>& requests, const PackedUpdateOptions& options, int threads)
{
	checkOptions(options);
	std::vector<char> asked(states.size(), 0);
	for (const PackedRequest<Dim>& request : requests) {
		if (request.sample >= states.size())
			throw std::invalid_argument("sample pool: sample " + std::to_string(request.sample) + " of " + std::to_string(states.size()));
		if (asked[request.sample]++) throw std::invalid_argument("sample pool: sample " + std::to_string(request.sample) + " is asked twice in one update");
	}
	std::vector<std::size_t> order(requests.size());
	for (std::size_t k = 0; k < order.size(); ++k)
		order[k] = k;
	const auto compare = [&](std::size_t a, std::size_t b) {
		return compareWork<Dim>(requests[a], states[requests[a].sample].get(), requests[b], states[requests[b].sample].get());
	};
	std::sort(order.begin(), order.end(), [&](std::size_t a, std::size_t b) {
		const int c = compare(a, b);
		return c != 0 ? c < 0 : a < b;
	});
	memory->lists.resize(states.size());
	std::vector<Task<Dim>>   tasks;
	std::vector<std::size_t> taskOf(requests.size());
	for (std::size_t k = 0; k < order.size(); ++k) {
		if (k == 0 || compare(order[k - 1], order[k]) != 0) {
			tasks.emplace_back();
			tasks.back().request     = order[k];
			tasks.back().before      = states[requests[order[k]].sample];
			tasks.back().listsBefore = memory->lists[requests[order[k]].sample];
		}
		taskOf[order[k]] = tasks.size() - 1;
	}
	const int workers = std::max(1, std::min(threads > 0 ? threads : omp_get_max_threads(), int(std::max<std::size_t>(1, tasks.size()))));
	memory->workspaces.resize(std::max(memory->workspaces.size(), std::size_t(workers)));
#pragma omp parallel num_threads(workers)
	{
		PackedWorkspace<Dim>& workspace = memory->workspace(std::size_t(omp_get_thread_num()));
#pragma omp for schedule(dynamic, 1)
		for (long k = 0; k < long(tasks.size()); ++k)
			perform<Dim>(tasks[std::size_t(k)], requests[tasks[std::size_t(k)].request], options, workspace);
	}
	for (const Task<Dim>& task : tasks)
		if (task.failure) std::rethrow_exception(task.failure);
	std::vector<PackedUpdateResult<Dim>> results(requests.size());
	for (std::size_t k = 0; k < requests.size(); ++k) {
		const Task<Dim>& task       = tasks[taskOf[k]];
		results[k]                  = task.result;
		states[requests[k].sample]        = task.after;
		memory->lists[requests[k].sample] = task.listsAfter;
	}
	return results;
}

template <int Dim> std::size_t SamplePool<Dim>::distinctStates() const
{
	std::unordered_set<const PackedState<Dim>*> distinct;
	for (const StatePointer& state : states)
		distinct.insert(state.get());
	return distinct.size();
}

template <int Dim> std::size_t SamplePool<Dim>::bytes() const
{
	std::unordered_set<const PackedState<Dim>*> distinct;
	std::size_t                                 sum = 0;
	for (const StatePointer& state : states)
		if (distinct.insert(state.get()).second) sum += state->parkedBytes();
	std::unordered_set<const PackedLists<Dim>*> distinctLists;
	for (const auto& lists : memory->lists)
		if (lists && distinctLists.insert(lists.get()).second) sum += sizeof(*lists) + 8 * (lists->inner.capacity() + lists->periodic.capacity());
	return sum;
}

template class SamplePool<2>;
template class SamplePool<3>;

} // namespace talik
