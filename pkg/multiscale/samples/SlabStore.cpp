// SPDX-License-Identifier: GPL-2.0-or-later
#include <pkg/multiscale/samples/SlabStore.hpp>

#include <algorithm>
#include <numeric>
#include <utility>

namespace talik {

namespace {
	const std::string aSample = "sample ";
} // namespace

template <int Dim>
SlabStore<Dim>::SlabStore(std::vector<typename PackedStore<Dim>::StatePointer> prototypes, std::shared_ptr<Communicator> others)
        : Packed(std::move(prototypes))
        , communicator(std::move(others))
{}

template <int Dim> SlabStore<Dim>::~SlabStore()
{
	if (number >= 0) communicator->dismiss(number);
}

template <int Dim> const SampleStart<Dim>& SlabStore<Dim>::add(int prototype, double iceSaturation, const PackedUpdateOptions& options)
{
	const auto& start = Packed::add(prototype, iceSaturation, options);
	beginAnew(this->size() - 1);
	return start;
}

/// Of the same owner.
template <int Dim> void SlabStore<Dim>::copy(std::size_t sample)
{
	Packed::copy(sample);
	known.push_back(known[sample]);
	known.back().cost = 0;
	if (sample < owner.size()) owner.push_back(owner[sample]);
}

template <int Dim> void SlabStore<Dim>::release(std::size_t sample)
{
	held().Packed::release(sample);
	beginAnew(sample);
}

template <int Dim> void SlabStore<Dim>::resize(std::size_t samples)
{
	Packed::resize(samples);
	seen.clear();
	brought.clear();
	beginnings.clear();
	known.assign(samples, Known {});
}

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
	known.resize(this->size());
	const auto found = beginnings.emplace(this->identity(sample), 0);
	if (found.second) found.first->second = nextOrigin();
	known[sample]        = Known {};
	known[sample].origin = found.first->second;
	brought.erase(sample);
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
		if (everywhere || isMine(sample)) mine.push_back(sample);
	}
	if (!mine.empty()) held().Packed::restoreState(reader, mine);
}

template <int Dim> bool SlabStore<Dim>::wants(const std::vector<std::size_t>& samples) const
{
	return std::any_of(samples.begin(), samples.end(), [&](std::size_t sample) { return isMine(sample) || ownerOf(sample) == nobody; });
}

// ---- owners ---------------------------------------------------------------------------------------------------------------

template <int Dim> void SlabStore<Dim>::own(std::vector<int> ownerOf)
{
	if (number < 0) number = communicator->enrol(this);
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
		if (isMine(s) && !known[s].everywhere && next[s] != nobody) states[std::size_t(next[s])][known[s].origin].push_back(s);
	}
	std::vector<std::string> going;
	for (const auto& byOrigin : states) {
		ByteWriter parcel;
		for (const auto& [origin, samples] : byOrigin) {
			parcel.array(samples);
			parcel.number(origin);
			for (const auto sample : samples)
				parcel.block(&known[sample].cost, sizeof(double));
			parcel.block(this->answer("state", samples.front()));
		}
		going.push_back(parcel.bytes());
	}
	for (const auto& byOrigin : states)
		for (const auto& leaving : byOrigin)
			for (const auto sample : leaving.second)
				held().Packed::release(sample);
	for (const auto& bytes : communicator->ranks().exchange(going)) {
		ByteReader parcel(bytes);
		while (!parcel.atEnd())
			receive(parcel);
	}
}

template <int Dim> void SlabStore<Dim>::receive(ByteReader& parcel)
{
	std::vector<std::size_t> samples;
	parcel.array(samples);
	const std::uint64_t origin = parcel.number();
	for (const auto sample : samples) {
		known[sample] = Known { false, origin, 0 };
		parcel.block(&known[sample].cost, sizeof(double));
		brought.erase(sample);
	}
	const std::string state = parcel.block();
	ByteReader        from(state);
	held().Packed::restoreState(from, samples);
}

// ---- update ---------------------------------------------------------------------------------------------------------------

template <int Dim> void SlabStore<Dim>::beginStep()
{
	++step;
	for (const auto sample : brought)
		held().Packed::release(sample);
	brought.clear();
	seen.clear();
}

template <int Dim>
std::vector<PackedUpdateResult<Dim>> SlabStore<Dim>::update(const std::vector<Request>& requests, const PackedUpdateOptions& options, int threads)
{
	std::vector<const void*> before;
	for (const auto& request : requests)
		before.push_back(this->identity(request.sample));
	auto                  results = Packed::update(requests, options, threads);
	std::set<const void*> counted;
	for (std::size_t k = 0; k < requests.size(); ++k) {
		Known&      sample = known[requests[k].sample];
		const auto* now    = this->identity(requests[k].sample);
		const bool  stayed = now == before[k];
		if (stayed || counted.insert(now).second) { // one that shares the work of another costs nothing
			const double its = double(results[k].steps) * this->costOfStep(requests[k].sample);
			sample.cost += its;
			cost += its;
		}
		if (stayed) continue;
		Digest origin;
		origin.add(sample.origin);
		requests[k].forBytes([&](const void* data, std::size_t bytes) { origin.add(data, bytes); });
		origin.add(step);
		sample.origin     = origin.value();
		sample.everywhere = false;
	}
	return results;
}

template <int Dim> double SlabStore<Dim>::takeCost() { return std::exchange(cost, 0.0); }

template <int Dim> double SlabStore<Dim>::takeCost(std::size_t sample) { return std::exchange(known[sample].cost, 0.0); }

template <int Dim> void SlabStore<Dim>::bookCosts(const std::vector<double>& costs)
{
	meanCost += std::accumulate(costs.begin(), costs.end(), 0.0) / communicator->count();
	largestCost += *std::max_element(costs.begin(), costs.end());
}

template <int Dim> const SampleStore::Sharing* SlabStore<Dim>::sharing() const
{
	if (number < 0) return nullptr;
	shared.samples = 0;
	for (std::size_t s = 0; s < this->size(); ++s)
		shared.samples += isMine(s);
	shared.balance = largestCost > 0 ? meanCost / largestCost : 1;
	return &shared;
}

// ---- looking at samples that other ranks own ------------------------------------------------------------------------------

template <int Dim> void SlabStore<Dim>::bring(std::size_t sample) const
{
	const int its = ownerOf(sample);
	if (its != nobody && !seen.count(sample)) show(sample, communicator->ask(number, aSample + std::to_string(sample)).at(std::size_t(its)));
}

template <int Dim> std::string SlabStore<Dim>::stateToShow(std::size_t sample) const
{
	return isMine(sample) && !known[sample].everywhere ? this->answer("state", sample) : "";
}

template <int Dim> void SlabStore<Dim>::show(std::size_t sample, const std::string& state) const
{
	seen.insert(sample);
	if (isMine(sample) || state.empty()) return; // it is here
	ByteReader reader(state);
	held().Packed::restoreState(reader, { sample });
	brought.insert(sample);
}

template <int Dim> void SlabStore<Dim>::beforeReplacing(std::size_t sample)
{
	if (number >= 0) communicator->meet("sample " + std::to_string(sample) + " is replaced");
}

template <int Dim> std::uint64_t SlabStore<Dim>::writeStates(const typename SampleStore::Layout& layout, const FilePlace& place) const
{
	if (number < 0) return this->SampleStore::writeStates(layout, place); // no rank has a sample of its own
	ByteWriter order;
	order.block(place.text());
	layout.save(order);
	return sumOfParts(*communicator, number, order.bytes());
}

template <int Dim> std::string SlabStore<Dim>::carryOut(const std::string& order) const
{
	return partWritten([&](PartSum& sum) {
		ByteReader reader(order);
		const auto place  = FilePlace::from(reader.block());
		const auto writes = [&](std::size_t sample) { return isMine(sample) || (communicator->rank() == 0 && ownerOf(sample) == nobody); };
		this->SampleStore::writeStates(SampleStore::Layout::from(reader), place, sum, writes);
	});
}

template <int Dim> std::string SlabStore<Dim>::answerTo(const std::string& question) const
{
	if (question.compare(0, aSample.size(), aSample) != 0) return answerOfMine(question);
	return stateToShow(std::stoul(question.substr(aSample.size())));
}

/// Of this rank's samples in their order the origin, then of each of their states what is asked for.
template <int Dim> std::string SlabStore<Dim>::answerOfMine(const std::string& question) const
{
	ByteWriter               writer;
	std::vector<std::size_t> mine;
	for (std::size_t s = 0; s < known.size(); ++s)
		if (isMine(s)) mine.push_back(s);
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

TALIK_IN_PLANE_AND_SPACE(SlabStore);

} // namespace talik
