// SPDX-License-Identifier: GPL-2.0-or-later
#include <pkg/multiscale/samples/SlabStore.hpp>

#include <algorithm>
#include <cstring>
#include <set>

namespace talik {

template <int Dim>
SlabStore<Dim>::SlabStore(std::shared_ptr<SampleStoreOf<Dim>> here, std::shared_ptr<Communicator> others)
        : StoreOfRanks<Dim>(std::move(here), std::move(others))
{}

// ---- states that every rank has -------------------------------------------------------------------------------------------

/// Origins follow from what all ranks do alike.
template <int Dim> std::uint64_t SlabStore<Dim>::nextOrigin()
{
	Digest digest;
	digest.add(++origins);
	return digest.value();
}

/// The sample begins with a state that the store keeps for others, too.
template <int Dim> void SlabStore<Dim>::beginAnew(std::size_t sample)
{
	known.resize(held->size());
	const auto found = beginnings.emplace(held->identity(sample), 0);
	if (found.second) found.first->second = nextOrigin();
	known[sample]        = Known {};
	known[sample].origin = found.first->second;
	brought.erase(sample);
}

template <int Dim> void SlabStore<Dim>::forget(std::size_t samples)
{
	beginnings.clear();
	known.assign(samples, Known {});
}

template <int Dim> void SlabStore<Dim>::replaced(std::size_t sample)
{
	known[sample]        = Known {};
	known[sample].origin = nextOrigin();
	brought.erase(sample);
}

/// The states of a run are restored by their owners alone.
template <int Dim> void SlabStore<Dim>::restoreState(ByteReader& reader, const std::vector<std::size_t>& samples)
{
	const std::uint64_t      origin = nextOrigin();
	std::vector<std::size_t> mine;
	for (const auto sample : samples) {
		const bool everywhere = ownerOf(sample) == nobody;
		known[sample]         = Known { everywhere, origin, 0 };
		if (everywhere || this->isMine(sample)) mine.push_back(sample);
	}
	if (!mine.empty()) held->restoreState(reader, mine);
}

template <int Dim> bool SlabStore<Dim>::wants(const std::vector<std::size_t>& samples) const
{
	return std::any_of(samples.begin(), samples.end(), [&](std::size_t sample) { return this->isMine(sample) || ownerOf(sample) == nobody; });
}

// ---- owners ---------------------------------------------------------------------------------------------------------------

template <int Dim> void SlabStore<Dim>::own(std::vector<int> ownerOf)
{
	this->enrol();
	owner = std::move(ownerOf);
}

template <int Dim> void SlabStore<Dim>::deal(std::vector<int> next)
{
	if (owner.size() == next.size() && owner != next) send(next);
	own(std::move(next));
}

/// Those that share a state go together. Samples that were never asked are there already.
template <int Dim> void SlabStore<Dim>::send(const std::vector<int>& next)
{
	std::vector<std::map<std::uint64_t, std::vector<std::size_t>>> states(std::size_t(communicator->count()));
	for (std::size_t s = 0; s < next.size(); ++s) {
		if (owner[s] == next[s] || owner[s] == nobody) continue;
		++shared.moved;
		if (this->isMine(s) && !known[s].everywhere && next[s] != nobody) states[std::size_t(next[s])][known[s].origin].push_back(s);
	}
	std::vector<std::vector<typename StoreOfRanks<Dim>::Leaving>> leaving(states.size());
	for (std::size_t rank = 0; rank < states.size(); ++rank)
		for (const auto& [origin, samples] : states[rank]) {
			ByteWriter note;
			note.number(origin);
			for (const auto sample : samples)
				note.block(&known[sample].cost, sizeof(double));
			leaving[rank].push_back({ samples, note.bytes() });
		}
	this->move(leaving, [&](const std::vector<std::size_t>& samples, const std::string& note) {
		ByteReader          reader(note);
		const std::uint64_t origin = reader.number();
		for (const auto sample : samples) {
			known[sample] = Known { false, origin, 0 };
			reader.block(&known[sample].cost, sizeof(double));
			brought.erase(sample);
		}
	});
}

// ---- update ---------------------------------------------------------------------------------------------------------------

template <int Dim> void SlabStore<Dim>::beginStep()
{
	++step;
	for (const auto sample : brought)
		held->release(sample);
	brought.clear();
	this->seen.clear();
}

template <int Dim>
std::vector<PackedUpdateResult<Dim>> SlabStore<Dim>::update(const std::vector<Request>& requests, const PackedUpdateOptions& options, int threads)
{
	std::vector<const void*> before;
	for (const auto& request : requests)
		before.push_back(held->identity(request.sample));
	auto                  results = held->update(requests, options, threads);
	std::set<const void*> counted;
	for (std::size_t k = 0; k < requests.size(); ++k) {
		Known&      sample = known[requests[k].sample];
		const auto* now    = held->identity(requests[k].sample);
		const bool  stayed = now == before[k];
		if (stayed || counted.insert(now).second) { // one that shares the work of another costs nothing
			const double its = double(results[k].steps) * held->costOfStep(requests[k].sample);
			sample.cost += its;
			cost += its;
		}
		if (stayed) continue;
		Digest origin;
		origin.add(sample.origin);
		addTo(origin, requests[k]);
		origin.add(step);
		sample.origin     = origin.value();
		sample.everywhere = false;
	}
	return results;
}

template <int Dim> double SlabStore<Dim>::takeCost() { return std::exchange(cost, 0.0); }

template <int Dim> double SlabStore<Dim>::takeCost(std::size_t sample) { return std::exchange(known[sample].cost, 0.0); }

// ---- looking at samples that other ranks own ------------------------------------------------------------------------------

/// Of this rank's samples in their order the origin, then of each of their states what is asked for.
template <int Dim> std::string SlabStore<Dim>::answerOfMine(const std::string& question) const
{
	ByteWriter               writer;
	std::vector<std::size_t> mine;
	for (std::size_t s = 0; s < known.size(); ++s)
		if (this->isMine(s)) mine.push_back(s);
	for (const auto sample : mine)
		writer.number(known[sample].origin);
	std::set<std::uint64_t> told;
	for (const auto sample : mine)
		if (told.insert(known[sample].origin).second) writer.block(known[sample].everywhere ? "" : this->answer(question, sample));
	return writer.bytes();
}

template <int Dim> SampleStore::Survey SlabStore<Dim>::survey(const std::string& question) const
{
	std::vector<std::string> answers;
	if (number >= 0) answers = communicator->ask(number, question.empty() ? "origins" : question);
	std::vector<ByteReader>    readers(answers.begin(), answers.end());
	std::vector<std::uint64_t> originOf;
	for (std::size_t s = 0; s < known.size(); ++s)
		originOf.push_back(ownerOf(s) == nobody ? known[s].origin : readers.at(std::size_t(ownerOf(s))).number());
	SampleStore::Survey                  told;
	std::map<std::uint64_t, std::size_t> states;
	for (std::size_t s = 0; s < known.size(); ++s) {
		const auto added = states.emplace(originOf[s], told.firstOf.size());
		if (added.second) told.firstOf.push_back(s);
		told.stateOf.push_back(added.first->second);
	}
	told.answers.resize(told.firstOf.size());
	std::set<std::pair<int, std::uint64_t>> read;
	for (std::size_t s = 0; s < known.size(); ++s) {
		if (ownerOf(s) == nobody || !read.insert({ ownerOf(s), originOf[s] }).second) continue;
		std::string answer = readers[std::size_t(ownerOf(s))].block();
		if (told.firstOf[told.stateOf[s]] == s) told.answers[told.stateOf[s]] = std::move(answer);
	}
	return told;
}

template class SlabStore<2>;
template class SlabStore<3>;

} // namespace talik
