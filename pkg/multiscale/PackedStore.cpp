// SPDX-License-Identifier: GPL-2.0-or-later
#include <pkg/multiscale/PackedStore.hpp>

#include <cstring>
#include <stdexcept>
#include <unordered_map>

namespace talik {

using Matrix = PackedTypes<2>::Matrix;

namespace {
	bool same(const PackedGrains& a, const PackedGrains& b) { return a.radius == b.radius && a.mass == b.mass && a.inertia == b.inertia && a.id == b.id; }

	/// Samples of one preparation hold its constants once, as they did before they were saved.
	void shareGrains(PackedState<2>& state, std::vector<std::shared_ptr<const PackedGrains>>& known)
	{
		for (const auto& grains : known)
			if (same(*grains, *state.grains)) {
				state.grains = grains;
				return;
			}
		known.push_back(state.grains);
	}

	template <class T> void saveArray(ByteWriter& writer, const std::vector<T>& array) { writer.block(array.data(), array.size() * sizeof(T)); }

	template <class T> void restoreArray(ByteReader& reader, std::vector<T>& array)
	{
		const std::string bytes = reader.block();
		array.resize(bytes.size() / sizeof(T));
		if (!array.empty()) std::memcpy(static_cast<void*>(array.data()), bytes.data(), array.size() * sizeof(T));
	}

	bool belongTogether(const PackedLists<2>& lists, std::size_t grains)
	{
		if (lists.second.size() != lists.size() || lists.inside + lists.cellDist.size() != lists.size()) return false;
		for (std::size_t k = 0; k < lists.size(); ++k)
			if (lists.first[k] >= grains || lists.second[k] >= grains) return false;
		return true;
	}

	/// The neighbour lists go along: lists made anew sum the same forces in another order.
	void saveSample(ByteWriter& writer, const ParkedSample<2>& sample)
	{
		PackedState<2> state;
		PackedLists<2> lists;
		const bool     listed = sample.unpark(state, lists);
		writer.block(state.toBytes());
		writer.number(listed);
		if (!listed) return;
		writer.block(static_cast<const PackedListUse<2>*>(&lists), sizeof(PackedListUse<2>));
		writer.number(lists.inside);
		saveArray(writer, lists.first);
		saveArray(writer, lists.second);
		saveArray(writer, lists.cellDist);
	}

	SamplePool<2>::Parked restoreSample(ByteReader& reader, std::vector<std::shared_ptr<const PackedGrains>>& known)
	{
		auto state = PackedState<2>::fromBytes(reader.block());
		shareGrains(state, known);
		if (!reader.number()) return std::make_shared<ParkedSample<2>>(state);
		PackedLists<2> lists;
		reader.block(static_cast<PackedListUse<2>*>(&lists), sizeof(PackedListUse<2>));
		lists.inside = reader.number();
		restoreArray(reader, lists.first);
		restoreArray(reader, lists.second);
		restoreArray(reader, lists.cellDist);
		if (!belongTogether(lists, state.size())) throw std::runtime_error("the archive's neighbour lists do not belong to its samples; it is damaged");
		return std::make_shared<ParkedSample<2>>(state, &lists);
	}
} // namespace

void refuseMeasure(const std::string& name)
{
	throw std::invalid_argument(
	        "RveSkeleton.values: there is no measure '" + name
	        + "'; choose bondsIntact, bondsFormed, bondsBroken, bondsMelted, contacts, coordinationNumber, samplePorosity, sampleIceSaturation or fabric.");
}

PackedStore::PackedStore(std::vector<StatePointer> p)
        : prototypes(std::move(p))
{
	for (const auto& state : prototypes) {
		double sum = 0;
		for (const double r : state->grains->radius)
			sum += r;
		meanRadius.push_back(sum / double(state->size()));
	}
}

// stiffness of grains and ice in contact, k_n/t_z: holds also for samples that have lost their contacts for a moment
double PackedStore::oedometricModulus(int prototype, double iceSaturation) const
{
	const auto& state = *prototypes.at(prototype);
	return 1.1 * state.ice.young(iceSaturation) * meanRadius[prototype] / state.thickness;
}

PackedStore::Beginning PackedStore::frozen(int prototype, double iceSaturation, const PackedUpdateOptions& options) const
{
	PackedSample<2> sample(*prototypes.at(prototype));
	if (prototypes[prototype]->iceSaturation != iceSaturation) {
		const auto result = sample.apply(Matrix::Zero(), iceSaturation, options);
		if (result.blewUp)
			throw std::runtime_error("RveSkeleton.samples[" + std::to_string(prototype) + "] does not survive freezing: " + result.reason);
	}
	Beginning beginning;
	beginning.sample        = std::make_shared<ParkedSample<2>>(sample.state());
	beginning.start.stress  = sample.stress();
	beginning.start.tangent = sample.tangent();
	return beginning;
}

const SampleStart& PackedStore::add(int prototype, double iceSaturation, const PackedUpdateOptions& options)
{
	auto found = beginnings.find({ prototype, iceSaturation });
	if (found == beginnings.end()) found = beginnings.emplace(std::make_pair(prototype, iceSaturation), frozen(prototype, iceSaturation, options)).first;
	pool.add(found->second.sample);
	return found->second.start;
}

std::vector<PackedUpdateResult<2>> PackedStore::update(const std::vector<PackedRequest<2>>& requests, const PackedUpdateOptions& options, int threads)
{
	return pool.update(requests, options, threads);
}

std::vector<double> PackedStore::measure(std::size_t sample, const std::string& name) const
{
	const PackedState<2> s = pool.state(sample);
	if (name == "bondsFormed") return { double(s.bondsFormed) };
	if (name == "bondsBroken") return { double(s.bondsBrokenInTension + s.bondsBrokenInShear) };
	if (name == "bondsMelted") return { double(s.bondsMelted) };
	if (name == "contacts") return { double(s.contacts.size()) };
	if (name == "sampleIceSaturation") return { s.iceSaturation };
	if (name == "bondsIntact") {
		double intact = 0;
		for (const auto bond : s.contacts.bond)
			intact += BondState(bond & 3) == BondState::BONDED;
		return { intact };
	}
	if (name != "coordinationNumber" && name != "samplePorosity" && name != "fabric") refuseMeasure(name);
	const auto statistics = PackedSample<2>(s).statistics();
	if (name == "coordinationNumber") return { statistics.coordinationNumber };
	if (name == "samplePorosity") return { statistics.porosity };
	return { statistics.fabric(0, 0), statistics.fabric(1, 1), statistics.fabric(0, 1) };
}

void PackedStore::save(ByteWriter& writer) const
{
	std::unordered_map<const void*, std::size_t> number;
	std::vector<std::size_t>                     distinct; // a sample of each state
	std::vector<std::uint64_t>                   which;
	for (std::size_t s = 0; s < pool.size(); s++) {
		const auto added = number.emplace(identity(s), distinct.size());
		if (added.second) distinct.push_back(s);
		which.push_back(added.first->second);
	}
	writer.number(distinct.size());
	for (const auto s : distinct)
		saveSample(writer, *pool.parked(s));
	writer.number(which.size());
	for (const auto w : which)
		writer.number(w);
}

void PackedStore::restore(ByteReader& reader)
{
	std::vector<SamplePool<2>::Parked>               distinct(reader.number());
	std::vector<std::shared_ptr<const PackedGrains>> known;
	for (auto& sample : distinct)
		sample = restoreSample(reader, known);
	pool.clear();
	for (std::uint64_t left = reader.number(); left > 0; left--)
		pool.add(distinct.at(reader.number()));
}

} // namespace talik
