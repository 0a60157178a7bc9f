// SPDX-License-Identifier: GPL-2.0-or-later
#include <algorithm>
#include <cmath>
#include <numeric>
#include <pkg/multiscale/samples/SampleStore.hpp>
#include <stdexcept>
#include <unordered_map>

namespace talik {

namespace {
	const std::string measureOf = "measure ";

	template <class T> std::vector<T> valuesIn(const std::string& bytes)
	{
		std::vector<T> values(bytes.size() / sizeof(T));
		std::copy_n(bytes.data(), values.size() * sizeof(T), reinterpret_cast<char*>(values.data()));
		return values;
	}
} // namespace

const std::vector<std::string>& sampleMeasures()
{
	static const std::vector<std::string> names { "bondsIntact",    "bondsFormed",         "bondsBroken", "bondsMelted",   "contacts", "coordinationNumber",
		                                      "samplePorosity", "sampleIceSaturation", "fabric",      "cellThickness", "cellSlips" };
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

// ---- what all samples say -------------------------------------------------------------------------------------------------

SampleStore::Survey SampleStore::survey(const std::string&) const
{
	Survey                                       result;
	std::unordered_map<const void*, std::size_t> number;
	for (std::size_t s = 0; s < size(); ++s) {
		const auto added = number.emplace(identity(s), result.firstOf.size());
		if (added.second) result.firstOf.push_back(s);
		result.stateOf.push_back(added.first->second);
	}
	result.answers.resize(result.firstOf.size());
	return result;
}

std::string SampleStore::answer(const std::string& question, std::size_t sample) const
{
	ByteWriter writer;
	if (question == "state") saveState(writer, sample);
	if (question == "length") writer.number(answer("state", sample).size());
	if (question.compare(0, measureOf.size(), measureOf) != 0) return writer.bytes();
	const auto values = measureHere(sample, question.substr(measureOf.size()));
	return std::string(reinterpret_cast<const char*>(values.data()), values.size() * sizeof(double));
}

std::string SampleStore::said(const Survey& told, const std::string& question, std::size_t state) const
{
	return told.answers[state].empty() ? answer(question, told.firstOf[state]) : told.answers[state];
}

std::vector<std::vector<double>> SampleStore::measureAll(const std::string& name) const
{
	if (std::find(sampleMeasures().begin(), sampleMeasures().end(), name) == sampleMeasures().end()) refuseMeasure(name); // before anybody is asked
	const std::string                question = measureOf + name;
	const Survey                     told     = survey(question);
	std::vector<std::vector<double>> ofStates, result;
	for (std::size_t n = 0; n < told.firstOf.size(); ++n)
		ofStates.push_back(valuesIn<double>(said(told, question, n)));
	for (const auto state : told.stateOf)
		result.push_back(ofStates[state]);
	return result;
}

// ---- saved ----------------------------------------------------------------------------------------------------------------

std::uint64_t SampleStore::Layout::bytes() const { return std::accumulate(lengths.begin(), lengths.end(), std::uint64_t(0)); }

std::vector<std::size_t> SampleStore::Layout::firstOf() const
{
	std::vector<std::size_t> first;
	for (std::size_t s = 0; s < stateOf.size(); ++s)
		if (stateOf[s] == first.size()) first.push_back(s);
	return first;
}

void SampleStore::Layout::save(ByteWriter& writer) const
{
	writer.array(stateOf);
	writer.array(lengths);
}

SampleStore::Layout SampleStore::Layout::from(ByteReader& reader)
{
	Layout layout;
	reader.array(layout.stateOf);
	reader.array(layout.lengths);
	return layout;
}

SampleStore::Layout SampleStore::layout() const
{
	const Survey told = survey("length");
	Layout       layout;
	layout.stateOf.assign(told.stateOf.begin(), told.stateOf.end());
	for (std::size_t n = 0; n < told.firstOf.size(); ++n)
		layout.lengths.push_back(valuesIn<std::uint64_t>(said(told, "length", n)).at(0));
	return layout;
}

void SampleStore::writeStates(const Layout& layout, const FilePlace& place, PartSum& sum, const std::function<bool(std::size_t)>& writes) const
{
	const auto    firstOf = layout.firstOf();
	std::uint64_t at      = place.at;
	PartedFile    file(place.path, PartedFile::For::writing, place.end);
	for (std::size_t n = 0; n < firstOf.size(); at += layout.lengths[n++]) {
		if (!writes(firstOf[n])) continue;
		ByteWriter state;
		saveState(state, firstOf[n]);
		if (state.bytes().size() != layout.lengths[n]) throw std::logic_error("the state of a sample has changed while it was written");
		file.write(state.bytes().data(), state.bytes().size(), at);
	}
	file.close();
	sum.add(file.sum().value());
}

std::uint64_t SampleStore::writeStates(const Layout& layout, const FilePlace& place) const
{
	PartSum sum;
	writeStates(layout, place, sum, [](std::size_t) { return true; });
	return sum.value();
}

/// Ranks give the bytes that one process with all samples would give.
std::string SampleStore::states() const
{
	const Survey told = survey("state");
	std::string  all;
	for (std::size_t n = 0; n < told.firstOf.size(); ++n)
		all += said(told, "state", n);
	return all;
}

void SampleStore::restore(const Layout& layout, const std::function<std::string(std::uint64_t, std::uint64_t)>& bytesAt)
{
	std::uint64_t                         at = 0;
	std::vector<std::vector<std::size_t>> samplesOf(layout.lengths.size());
	for (std::size_t s = 0; s < layout.stateOf.size(); ++s)
		samplesOf.at(layout.stateOf[s]).push_back(s);
	resize(layout.stateOf.size());
	for (std::size_t n = 0; n < samplesOf.size(); at += layout.lengths[n++]) {
		const std::string bytes = wants(samplesOf[n]) ? bytesAt(at, layout.lengths[n]) : "";
		ByteReader        state(bytes);
		restoreState(state, samplesOf[n]);
	}
}

} // namespace talik
