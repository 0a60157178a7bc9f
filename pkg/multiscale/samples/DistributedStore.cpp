// SPDX-License-Identifier: GPL-2.0-or-later
#include <pkg/multiscale/samples/DistributedStore.hpp>

#include <algorithm>
#include <cstring>
#include <numeric>
#include <stdexcept>

namespace talik {

namespace {
	constexpr std::uint64_t dealInterval = 32;  ///< updates from one deal to the next
	constexpr double        keptCost     = 0.5; ///< part of the cost measured so far that counts in the next deal

	/// An answer as it goes round; the tangent follows where one is asked for.
	template <int Dim> struct Answer {
		double       stress[Dim * Dim];
		double       rateError, cost;
		std::int64_t steps;
		std::int32_t leader; ///< place of the first request with the same new state; none: the state stayed
		std::uint8_t flipped, slipped, blewUp;

		static constexpr std::int32_t none = -1;
	};

	/// Before the answers of a rank.
	struct Head {
		std::uint64_t hasWords; ///< why a sample blew up, or why the update failed
	};

	template <int Dim> std::uint64_t digestOf(const std::vector<PackedRequest<Dim>>& requests)
	{
		Digest digest;
		for (const auto& request : requests) {
			digest.add(std::uint64_t(request.sample));
			addTo(digest, request);
		}
		return digest.value();
	}

	template <class T> T take(const char*& from)
	{
		T value;
		std::memcpy(&value, from, sizeof value);
		from += sizeof value;
		return value;
	}
	template <class T> void put(std::string& to, const T& value) { to.append(reinterpret_cast<const char*>(&value), sizeof value); }
} // namespace

/// The requests of an update, who computes them, and what came of it.
template <int Dim> struct DistributedStore<Dim>::Batch {
	const std::vector<Request>& requests;
	std::vector<int>            rankOf;
	std::vector<Result>         results;
	std::vector<std::int32_t>   leader;
	std::vector<double>         cost;
	std::string                 failure; ///< of this rank, or, after spread(), of any

	Batch(const std::vector<Request>& asked, std::vector<int> ranks, int count)
	        : requests(asked)
	        , rankOf(std::move(ranks))
	        , results(asked.size())
	        , leader(asked.size(), Answer<Dim>::none)
	        , cost(asked.size(), 0)
	        , places_(std::size_t(count))
	{
		for (std::size_t k = 0; k < rankOf.size(); ++k)
			places_[std::size_t(rankOf[k])].push_back(k);
	}
	/// Places of the requests of a rank, ascending.
	const std::vector<std::size_t>& of(int rank) const { return places_[std::size_t(rank)]; }

private:
	std::vector<std::vector<std::size_t>> places_;
};

template <int Dim>
DistributedStore<Dim>::DistributedStore(std::shared_ptr<SampleStoreOf<Dim>> here, std::shared_ptr<Communicator> others)
        : StoreOfRanks<Dim>(std::move(here), std::move(others))
{
	for (std::size_t s = 0; s < held->size(); ++s)
		beginAnew(s);
}

// ---- states that every rank has -------------------------------------------------------------------------------------------

template <int Dim> void DistributedStore<Dim>::beginAnew(std::size_t sample)
{
	stateOf.resize(held->size());
	stateOf[sample].reset();
	auto& known = beginning[held->identity(sample)];
	auto  state = known.lock(); // none, too, where the memory of a former state was used again
	if (!state) known = state = std::make_shared<State>();
	stateOf[sample] = state;
	changedElsewhere(sample);
}

template <int Dim> void DistributedStore<Dim>::forget(std::size_t samples)
{
	beginning.clear();
	stateOf.assign(samples, nullptr);
}

/// What was brought of it to be looked at is out of date.
template <int Dim> void DistributedStore<Dim>::changedElsewhere(std::size_t sample)
{
	this->seen.erase(sample);
	this->brought.erase(sample);
}

template <int Dim> void DistributedStore<Dim>::restoreState(ByteReader& reader, const std::vector<std::size_t>& samples)
{
	held->restoreState(reader, samples);
	for (const auto sample : samples)
		beginAnew(sample);
}

// ---- update ---------------------------------------------------------------------------------------------------------------

/// A rank for each request: the owner of the state. States that every rank has go to the rank with the fewest requests so far; those that
/// agree bit for bit stay together, since they will share the next state.
template <int Dim> std::vector<int> DistributedStore<Dim>::assigned(const std::vector<Request>& requests) const
{
	std::vector<int>         rankOf(requests.size(), nobody);
	std::vector<std::size_t> load(std::size_t(communicator->count()), 0);
	for (std::size_t k = 0; k < requests.size(); ++k) {
		rankOf[k] = stateOf.at(requests[k].sample)->owner;
		if (rankOf[k] != nobody) load[std::size_t(rankOf[k])]++;
	}
	std::map<std::pair<const State*, std::uint64_t>, int> together;
	for (std::size_t k = 0; k < requests.size(); ++k) {
		if (rankOf[k] != nobody) continue;
		Digest work;
		addTo(work, requests[k]);
		const auto found = together.emplace(std::make_pair(stateOf[requests[k].sample].get(), work.value()), 0);
		if (found.second) {
			const auto least = std::min_element(load.begin(), load.end());
			(*least)++;
			found.first->second = int(least - load.begin());
		}
		rankOf[k] = found.first->second;
	}
	return rankOf;
}

template <int Dim>
std::vector<PackedUpdateResult<Dim>> DistributedStore<Dim>::update(const std::vector<Request>& requests, const PackedUpdateOptions& options, int threads)
{
	this->enrol();
	++updates;
	communicator->meet("update " + std::to_string(updates) + " of samples " + std::to_string(number), digestOf(requests));
	Batch batch(requests, assigned(requests), communicator->count());
	compute(batch, options, threads);
	spread(batch, options.tangent);
	if (!batch.failure.empty()) throw std::runtime_error(batch.failure);
	takeOver(batch);
	if (updates % dealInterval == 0) dealAgain();
	return std::move(batch.results);
}

template <int Dim> void DistributedStore<Dim>::compute(Batch& batch, const PackedUpdateOptions& options, int threads) const
{
	const auto&              places = batch.of(communicator->rank());
	std::vector<Request>     own;
	std::vector<const void*> before;
	for (const auto k : places) {
		own.push_back(batch.requests[k]);
		before.push_back(held->identity(own.back().sample));
	}
	if (own.empty()) return;
	try {
		auto                                results = held->update(own, options, threads);
		std::map<const void*, std::int32_t> first;
		for (std::size_t i = 0; i < own.size(); ++i) {
			const auto  k   = places[i];
			const auto* now = held->identity(own[i].sample);
			if (now != before[i]) batch.leader[k] = first.emplace(now, std::int32_t(k)).first->second;
			if (batch.leader[k] == Answer<Dim>::none || batch.leader[k] == std::int32_t(k))
				batch.cost[k] = double(results[i].steps) * held->costOfStep(own[i].sample);
			batch.results[k] = std::move(results[i]);
		}
	} catch (const std::exception& problem) {
		batch.failure = problem.what();
	}
}

/// The answers of all ranks go to all. Their lengths are known; only where a sample blew up or a rank failed words follow.
template <int Dim> void DistributedStore<Dim>::spread(Batch& batch, bool tangent) const
{
	const std::size_t        answerBytes = sizeof(Answer<Dim>) + (tangent ? sizeof(PackedTangent<Dim>) : 0);
	std::vector<std::size_t> lengths;
	for (int rank = 0; rank < communicator->count(); ++rank)
		lengths.push_back(sizeof(Head) + batch.of(rank).size() * answerBytes);
	const auto& mine = batch.of(communicator->rank());
	std::string going;
	ByteWriter  words;
	words.block(batch.failure);
	bool hasWords = !batch.failure.empty();
	for (const auto k : mine)
		hasWords = hasWords || batch.results[k].blewUp;
	put(going, Head { hasWords });
	for (const auto k : mine) {
		const auto& result = batch.results[k];
		Answer<Dim> answer {};
		std::memcpy(answer.stress, result.stress.data(), sizeof answer.stress);
		answer.rateError = result.rateError;
		answer.cost      = batch.cost[k];
		answer.steps     = result.steps;
		answer.leader    = batch.leader[k];
		answer.flipped   = result.flipped;
		answer.slipped   = result.slipped;
		answer.blewUp    = result.blewUp;
		put(going, answer);
		if (tangent) put(going, result.tangent);
		if (result.blewUp) words.block(result.reason);
	}
	std::string all(std::accumulate(lengths.begin(), lengths.end(), std::size_t(0)), '\0');
	communicator->ranks().allGather(going.data(), lengths, &all[0]);
	const char* from     = all.data();
	bool        anyWords = false;
	for (int rank = 0; rank < communicator->count(); ++rank) {
		anyWords = take<Head>(from).hasWords || anyWords;
		for (const auto k : batch.of(rank)) {
			auto&      result = batch.results[k];
			const auto answer = take<Answer<Dim>>(from);
			std::memcpy(result.stress.data(), answer.stress, sizeof answer.stress);
			result.rateError = answer.rateError;
			result.steps     = long(answer.steps);
			result.flipped   = answer.flipped;
			result.slipped   = answer.slipped;
			result.blewUp    = answer.blewUp;
			if (tangent) result.tangent = take<PackedTangent<Dim>>(from);
			batch.cost[k]   = answer.cost;
			batch.leader[k] = answer.leader;
		}
	}
	if (!anyWords) return;
	const auto said = communicator->ranks().exchange(std::vector<std::string>(std::size_t(communicator->count()), words.bytes()));
	batch.failure.clear();
	for (int rank = 0; rank < communicator->count(); ++rank) {
		ByteReader reader(said[std::size_t(rank)]);
		const auto failure = reader.block();
		if (!failure.empty() && batch.failure.empty()) batch.failure = failure + " (on rank " + std::to_string(rank) + ")";
		for (const auto k : batch.of(rank))
			if (batch.results[k].blewUp) batch.results[k].reason = reader.block();
	}
}

/// Samples take their new states, in all ranks alike; those of other ranks leave this one.
template <int Dim> void DistributedStore<Dim>::takeOver(const Batch& batch)
{
	std::vector<double>                            load(std::size_t(communicator->count()), 0.);
	std::map<std::int32_t, std::shared_ptr<State>> made;
	for (std::size_t k = 0; k < batch.requests.size(); ++k) {
		const std::size_t sample = batch.requests[k].sample;
		const int         rank   = batch.rankOf[k];
		load[std::size_t(rank)] += batch.cost[k];
		if (batch.leader[k] == Answer<Dim>::none) {
			stateOf[sample]->cost += batch.cost[k];
			continue;
		}
		auto& state = made[batch.leader[k]];
		if (!state) state = std::make_shared<State>(State { rank, stateOf[sample]->owner == nobody ? 0 : stateOf[sample]->cost });
		state->cost += batch.cost[k];
		stateOf[sample] = state;
		changedElsewhere(sample);
		if (rank != communicator->rank()) held->release(sample);
	}
	this->bookCosts(load);
}

/// States go to other ranks, as the bytes that a checkpoint holds of them. Those that would not go on with the same bits stay.
template <int Dim> void DistributedStore<Dim>::dealAgain()
{
	if (!held->restoresExactly()) return;
	const auto               states = SampleStore::survey("");
	std::vector<std::size_t> owned; // numbers of states
	std::vector<double>      cost;
	std::vector<int>         owner;
	for (std::size_t n = 0; n < states.firstOf.size(); ++n) {
		State& state = *stateOf[states.firstOf[n]];
		if (state.owner == nobody) continue;
		owned.push_back(n);
		cost.push_back(state.cost);
		owner.push_back(state.owner);
		state.cost *= keptCost;
	}
	const auto next = rebalanced(cost, owner, communicator->count());
	if (owner == next) return;
	std::vector<std::vector<std::size_t>> samplesOf(states.firstOf.size());
	for (std::size_t s = 0; s < states.stateOf.size(); ++s)
		samplesOf[states.stateOf[s]].push_back(s);
	std::vector<std::vector<typename StoreOfRanks<Dim>::Leaving>> leaving(std::size_t(communicator->count()));
	for (std::size_t i = 0; i < owned.size(); ++i) {
		if (owner[i] == next[i]) continue;
		++shared.moved;
		for (const auto sample : samplesOf[owned[i]])
			changedElsewhere(sample);
		if (owner[i] == communicator->rank()) leaving[std::size_t(next[i])].push_back({ samplesOf[owned[i]], "" });
		stateOf[states.firstOf[owned[i]]]->owner = next[i];
	}
	this->move(leaving, [](const std::vector<std::size_t>&, const std::string&) {});
}

// ---- looking at samples that other ranks own ------------------------------------------------------------------------------

template <int Dim> std::string DistributedStore<Dim>::answerOfMine(const std::string& question) const
{
	ByteWriter writer;
	for (const auto sample : SampleStore::survey("").firstOf)
		if (this->isMine(sample)) writer.block(this->answer(question, sample));
	return writer.bytes();
}

/// All ranks know which samples share a state, and who owns it.
template <int Dim> SampleStore::Survey DistributedStore<Dim>::survey(const std::string& question) const
{
	auto told = SampleStore::survey("");
	if (number < 0 || question.empty()) return told;
	const auto              answers = communicator->ask(number, question);
	std::vector<ByteReader> readers(answers.begin(), answers.end());
	for (std::size_t n = 0; n < told.firstOf.size(); ++n)
		if (const int owner = ownerOf(told.firstOf[n]); owner != nobody) told.answers[n] = readers.at(std::size_t(owner)).block();
	return told;
}

template class DistributedStore<2>;
template class DistributedStore<3>;

} // namespace talik
