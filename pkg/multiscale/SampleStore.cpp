// SPDX-License-Identifier: GPL-2.0-or-later
#include <pkg/multiscale/SampleStore.hpp>

#include <stdexcept>
#include <unordered_map>

namespace talik {

void refuseMeasure(const std::string& name)
{
	throw std::invalid_argument(
	        "RveSkeleton.values: there is no measure '" + name
	        + "'; choose bondsIntact, bondsFormed, bondsBroken, bondsMelted, contacts, coordinationNumber, samplePorosity, sampleIceSaturation or fabric.");
}

SampleStore::Numbering SampleStore::numbering() const
{
	Numbering                                    result;
	std::unordered_map<const void*, std::size_t> number;
	for (std::size_t s = 0; s < size(); s++) {
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
	for (std::size_t s = 0; s < stateOf.size(); s++)
		samplesOf.at(stateOf[s]).push_back(s);
	resize(stateOf.size());
	for (const auto& samples : samplesOf) {
		const std::string bytes = reader.block();
		ByteReader        state(bytes);
		restoreState(state, samples);
	}
}

} // namespace talik
