// SPDX-License-Identifier: GPL-2.0-or-later
#include <pkg/multiscale/samples/BandStore.hpp>

#include <algorithm>
#include <cstring>
#include <numeric>
#include <set>

namespace talik {

template <int Dim>
BandStore<Dim>::BandStore(std::shared_ptr<SampleStoreOf<Dim>> here, std::shared_ptr<RankTalk> others)
        : StoreOfRanks<Dim>(std::move(here), std::move(others))
{}

template <int Dim> BandStore<Dim>::~BandStore()
{
	if (number >= 0) talk->dismiss(number);
}

// ---- states that every rank has -------------------------------------------------------------------------------------------

/// Origins follow from what all ranks do alike.
template <int Dim> std::uint64_t BandStore<Dim>::nextOrigin()
{
	Digest digest;
	digest.add(++origins);
	return digest.value();
}

/// The sample begins with a state that the store keeps for others, too.
template <int Dim> void BandStore<Dim>::beginAnew(std::size_t sample)
{
	known.resize(held->size());
	const auto found = beginnings.emplace(held->identity(sample), 0);
	if (found.second) found.first->second = nextOrigin();
	known[sample]        = Known {};
	known[sample].origin = found.first->second;
	brought.erase(sample);
}

template <int Dim> void BandStore<Dim>::clear()
{
	held->clear();
	known.clear();
	beginnings.clear();
	brought.clear();
}

template <int Dim> void BandStore<Dim>::resize(std::size_t samples)
{
	clear();
	held->resize(samples);
	known.resize(samples);
}

template <int Dim> void BandStore<Dim>::replaced(std::size_t sample)
{
	known[sample]        = Known {};
	known[sample].origin = nextOrigin();
	brought.erase(sample);
}

/// The states of a run are restored by their owners alone.
template <int Dim> void BandStore<Dim>::restoreState(ByteReader& reader, const std::vector<std::size_t>& samples)
{
	const std::uint64_t      origin = nextOrigin();
	std::vector<std::size_t> mine;
	for (const auto sample : samples) {
		const bool everywhere = ownerOf(sample) == nobody;
		known[sample]         = Known { everywhere, origin, 0 };
		if (everywhere || isMine(sample)) mine.push_back(sample);
	}
	if (!mine.empty()) held->restoreState(reader, mine);
}

template <int Dim> bool BandStore<Dim>::wants(const std::vector<std::size_t>& samples) const
{
	return std::any_of(samples.begin(), samples.end(), [&](std::size_t sample) { return isMine(sample) || isNobodys(sample); });
}

// ---- owners ---------------------------------------------------------------------------------------------------------------

template <int Dim> void BandStore<Dim>::own(std::vector<int> ownerOf)
{
	if (number < 0) number = talk->enrol(this);
	owner = std::move(ownerOf);
}

template <int Dim> void BandStore<Dim>::deal(std::vector<int> next)
{
	if (owner.size() == next.size() && owner != next) send(next);
	own(std::move(next));
}

/// Those that share a state go together. Samples that were never asked are there already.
template <int Dim> void BandStore<Dim>::send(const std::vector<int>& next)
{
	const int                                                      rank = talk->rank();
	std::vector<std::map<std::uint64_t, std::vector<std::size_t>>> leaving(std::size_t(talk->count()));
	for (std::size_t s = 0; s < next.size(); ++s) {
		if (owner[s] == next[s] || owner[s] == nobody) continue;
		++shared.moved;
		if (owner[s] == rank && !known[s].everywhere && next[s] != nobody) leaving[std::size_t(next[s])][known[s].origin].push_back(s);
	}
	std::vector<std::string> toEach;
	for (const auto& states : leaving) {
		ByteWriter writer;
		for (const auto& [origin, samples] : states) {
			ByteWriter state;
			held->saveState(state, samples.front());
			writer.number(origin);
			writer.block(samples.data(), samples.size() * sizeof(std::size_t));
			for (const auto sample : samples)
				writer.block(&known[sample].cost, sizeof(double));
			writer.block(state.bytes());
		}
		toEach.push_back(writer.bytes());
		for (const auto& [origin, samples] : states)
			for (const auto sample : samples)
				held->release(sample);
	}
	for (const auto& bytes : talk->ranks().exchange(toEach)) {
		ByteReader reader(bytes);
		while (!reader.atEnd()) {
			const std::uint64_t      origin  = reader.number();
			const std::string        numbers = reader.block();
			std::vector<std::size_t> samples(numbers.size() / sizeof(std::size_t));
			std::memcpy(samples.data(), numbers.data(), numbers.size());
			for (const auto sample : samples) {
				known[sample] = Known { false, origin, 0 };
				reader.block(&known[sample].cost, sizeof(double));
				brought.erase(sample);
			}
			const std::string state = reader.block();
			ByteReader        from(state);
			held->restoreState(from, samples);
		}
	}
}

// ---- update ---------------------------------------------------------------------------------------------------------------

template <int Dim> void BandStore<Dim>::beginStep()
{
	++step;
	for (const auto sample : brought)
		held->release(sample);
	brought.clear();
	seen.clear();
}

template <int Dim>
std::vector<PackedUpdateResult<Dim>> BandStore<Dim>::update(const std::vector<Request>& requests, const PackedUpdateOptions& options, int threads)
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

template <int Dim> double BandStore<Dim>::takeCost() { return std::exchange(cost, 0.0); }

template <int Dim> double BandStore<Dim>::takeCost(std::size_t sample) { return std::exchange(known[sample].cost, 0.0); }

template <int Dim> void BandStore<Dim>::bookCosts(const std::vector<double>& costs)
{
	meanCost += std::accumulate(costs.begin(), costs.end(), 0.0) / talk->count();
	largestCost += *std::max_element(costs.begin(), costs.end());
}

// ---- looking at samples that other ranks own ------------------------------------------------------------------------------

/// "state <sample>": its state, if it is of this rank and not on all. "origins", "states", "lengths", "measure <name>": of this rank's samples in
/// their order the origin, then of each of their states in the order of the first sample that has it what is asked for.
template <int Dim> std::string BandStore<Dim>::answerTo(const std::string& question) const
{
	ByteWriter        writer;
	const std::size_t blank = question.find(' ');
	const std::string what = question.substr(0, blank), which = blank == std::string::npos ? "" : question.substr(blank + 1);
	if (what == "state") return stateToShow(std::stoul(which));
	std::vector<std::size_t> mine;
	for (std::size_t s = 0; s < known.size(); ++s)
		if (isMine(s)) mine.push_back(s);
	for (const auto sample : mine)
		writer.number(known[sample].origin);
	std::set<std::uint64_t> told;
	for (const auto sample : mine) {
		if (!told.insert(known[sample].origin).second) continue;
		ByteWriter part;
		if (!known[sample].everywhere && what == "states") held->saveState(part, sample);
		if (!known[sample].everywhere && what == "lengths") part.number(this->lengthOf("", sample));
		if (!known[sample].everywhere && what == "measure") {
			const auto values = held->measure(sample, which);
			part.block(values.data(), values.size() * sizeof(double));
		}
		writer.block(part.bytes());
	}
	return writer.bytes();
}

template <int Dim> typename BandStore<Dim>::Told BandStore<Dim>::ask(const std::string& question) const
{
	std::vector<std::string> answers;
	if (number >= 0) answers = talk->ask(number, question);
	std::vector<ByteReader>    readers(answers.begin(), answers.end());
	std::vector<std::uint64_t> originOf;
	for (std::size_t s = 0; s < known.size(); ++s)
		originOf.push_back(ownerOf(s) == nobody ? known[s].origin : readers.at(std::size_t(ownerOf(s))).number());
	Told                                 told;
	std::map<std::uint64_t, std::size_t> states;
	for (std::size_t s = 0; s < known.size(); ++s) {
		const auto added = states.emplace(originOf[s], told.firstOf.size());
		if (added.second) told.firstOf.push_back(s);
		told.stateOf.push_back(added.first->second);
	}
	told.parts.resize(told.firstOf.size());
	std::set<std::pair<int, std::uint64_t>> read;
	for (std::size_t s = 0; s < known.size(); ++s) {
		if (ownerOf(s) == nobody || !read.insert({ ownerOf(s), originOf[s] }).second) continue;
		std::string part = readers[std::size_t(ownerOf(s))].block();
		if (told.firstOf[told.stateOf[s]] == s) told.parts[told.stateOf[s]] = std::move(part);
	}
	return told;
}

/// The owner asks, too: ranks that all look go on together, and none replaces a sample or ends its ground before the others have seen it.
template <int Dim> void BandStore<Dim>::fetch(std::size_t sample) const
{
	if (ownerOf(sample) == nobody || seen.count(sample)) return;
	show(sample, talk->ask(number, "state " + std::to_string(sample)).at(std::size_t(ownerOf(sample))));
}

template <int Dim> std::string BandStore<Dim>::stateToShow(std::size_t sample) const
{
	ByteWriter writer;
	if (isMine(sample) && !known[sample].everywhere) held->saveState(writer, sample);
	return writer.bytes();
}

template <int Dim> void BandStore<Dim>::show(std::size_t sample, const std::string& state) const
{
	seen.insert(sample);
	if (isMine(sample) || state.empty()) return; // it is here
	ByteReader reader(state);
	held->restoreState(reader, { sample });
	brought.insert(sample);
}

template <int Dim> std::vector<std::vector<double>> BandStore<Dim>::measureAll(const std::string& name) const
{
	if (held->size() > 0) held->measure(0, name); // an unknown name is refused before anybody is asked
	const Told                       told = ask("measure " + name);
	std::vector<std::vector<double>> ofStates, result;
	for (std::size_t n = 0; n < told.firstOf.size(); ++n) {
		if (told.parts[n].empty()) {
			ofStates.push_back(held->measure(told.firstOf[n], name));
			continue;
		}
		ByteReader        reader(told.parts[n]);
		const std::string bytes = reader.block();
		ofStates.emplace_back(bytes.size() / sizeof(double));
		std::memcpy(ofStates.back().data(), bytes.data(), bytes.size());
	}
	for (const auto state : told.stateOf)
		result.push_back(ofStates[state]);
	return result;
}

/// The bytes that one rank with all samples would write.
template <int Dim> void BandStore<Dim>::save(ByteWriter& writer) const
{
	const Told told = ask("states");
	writer.number(told.stateOf.size());
	for (const auto state : told.stateOf)
		writer.number(state);
	writer.number(told.firstOf.size());
	for (std::size_t n = 0; n < told.firstOf.size(); ++n) {
		ByteWriter here;
		if (told.parts[n].empty()) held->saveState(here, told.firstOf[n]);
		writer.block(told.parts[n].empty() ? here.bytes() : told.parts[n]);
	}
}

template <int Dim> std::vector<std::uint64_t> BandStore<Dim>::lengthsOfStates(std::vector<std::uint64_t>& stateOf) const
{
	const Told                 told = ask("lengths");
	std::vector<std::uint64_t> lengths;
	stateOf.assign(told.stateOf.begin(), told.stateOf.end());
	for (std::size_t n = 0; n < told.firstOf.size(); ++n)
		lengths.push_back(this->lengthOf(told.parts[n], told.firstOf[n]));
	return lengths;
}

template <int Dim> const SampleStore::Sharing* BandStore<Dim>::sharing() const
{
	shared.samples = std::uint64_t(std::count(owner.begin(), owner.end(), talk->rank()));
	shared.balance = largestCost > 0 ? meanCost / largestCost : 1;
	return &shared;
}

template class BandStore<2>;
template class BandStore<3>;

} // namespace talik
