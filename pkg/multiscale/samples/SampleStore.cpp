// SPDX-License-Identifier: GPL-2.0-or-later
#include <algorithm>
#include <cmath>
#include <numeric>
#include <pkg/multiscale/samples/SampleStore.hpp>
#include <set>
#include <stdexcept>
#include <unordered_map>

namespace talik {

const std::vector<std::string>& sampleMeasures()
{
	static const std::vector<std::string> names { "bondsIntact",        "bondsFormed",    "bondsBroken",         "bondsMelted", "contacts",
		                                      "coordinationNumber", "samplePorosity", "sampleIceSaturation", "fabric" };
	return names;
}

void refuseMeasure(const std::string& name)
{
	const auto& names = sampleMeasures();
	std::string list;
	for (std::size_t k = 0; k + 1 < names.size(); ++k)
		list += (k ? ", " : "") + names[k];
	throw std::invalid_argument("RveSkeleton.values: there is no measure '" + name + "'; choose " + list + " or " + names.back() + ".");
}

SampleStore::Numbering SampleStore::numbering() const
{
	Numbering                                    result;
	std::unordered_map<const void*, std::size_t> number;
	for (std::size_t s = 0; s < size(); ++s) {
		const auto added = number.emplace(identity(s), result.firstOf.size());
		if (added.second) result.firstOf.push_back(s);
		result.stateOf.push_back(added.first->second);
	}
	return result;
}

std::vector<std::vector<double>> SampleStore::measureAll(const std::string& name) const
{
	const Numbering                  numbers = numbering();
	std::vector<std::vector<double>> ofStates, result;
	for (const auto sample : numbers.firstOf)
		ofStates.push_back(measure(sample, name));
	for (const auto state : numbers.stateOf)
		result.push_back(ofStates[state]);
	return result;
}

void SampleStore::save(ByteWriter& writer) const
{
	const Numbering numbers = numbering();
	writer.number(numbers.stateOf.size());
	for (const auto state : numbers.stateOf)
		writer.number(state);
	writer.number(numbers.firstOf.size());
	for (const auto sample : numbers.firstOf) {
		ByteWriter state;
		saveState(state, sample);
		writer.block(state.bytes());
	}
}

void SampleStore::restore(ByteReader& reader)
{
	std::vector<std::uint64_t> stateOf(reader.number());
	for (auto& state : stateOf)
		state = reader.number();
	std::vector<std::vector<std::size_t>> samplesOf(reader.number());
	for (std::size_t s = 0; s < stateOf.size(); ++s)
		samplesOf.at(stateOf[s]).push_back(s);
	resize(stateOf.size());
	for (const auto& samples : samplesOf) {
		const std::string bytes = reader.block();
		ByteReader        state(bytes);
		restoreState(state, samples);
	}
}

void SampleStore::skip(ByteReader& reader)
{
	for (std::uint64_t samples = reader.number(); samples > 0; --samples)
		reader.number();
	for (std::uint64_t states = reader.number(); states > 0; --states)
		reader.pass();
}

namespace {
	using Costs = std::set<std::pair<double, std::size_t>>; ///< of the states of a rank, and their numbers

	/// The state whose move closes a gap between two ranks best; end() where each would make the gap larger.
	Costs::const_iterator bestFor(const Costs& costs, double gap)
	{
		const auto above = costs.lower_bound({ 0.5 * gap, 0 });
		const bool fits  = above != costs.end() && above->first < gap;
		if (above == costs.begin() || !(std::prev(above)->first > 0)) return fits ? above : costs.end();
		const auto below = costs.lower_bound({ std::prev(above)->first, 0 });
		return fits && above->first - 0.5 * gap < 0.5 * gap - below->first ? above : below;
	}
} // namespace

std::vector<int> dealtAgain(const std::vector<double>& cost, std::vector<int> owner, int ranks)
{
	constexpr double    enough = 1.02;
	std::vector<double> load(std::size_t(ranks), 0.);
	std::vector<Costs>  costsOf(static_cast<std::size_t>(ranks));
	for (std::size_t k = 0; k < cost.size(); ++k) {
		load[std::size_t(owner[k])] += cost[k];
		costsOf[std::size_t(owner[k])].emplace(cost[k], k);
	}
	const double mean = std::accumulate(load.begin(), load.end(), 0.) / ranks;
	for (std::size_t moves = 0; moves < cost.size(); ++moves) {
		const auto most = std::max_element(load.begin(), load.end()), least = std::min_element(load.begin(), load.end());
		if (*most <= enough * mean) break;
		auto&      from = costsOf[std::size_t(most - load.begin())];
		const auto best = bestFor(from, *most - *least);
		if (best == from.end()) break;
		*most -= best->first;
		*least += best->first;
		owner[best->second] = int(least - load.begin());
		costsOf[std::size_t(least - load.begin())].insert(*best);
		from.erase(best);
	}
	return owner;
}

} // namespace talik
