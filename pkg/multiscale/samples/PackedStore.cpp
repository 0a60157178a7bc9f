// SPDX-License-Identifier: GPL-2.0-or-later
#include <pkg/multiscale/samples/PackedStore.hpp>

#include <algorithm>
#include <stdexcept>

namespace talik {

namespace {
	/// Samples of one preparation hold its constants once, as they did before they were saved.
	template <int Dim> void shareGrains(PackedState<Dim>& state, std::vector<std::shared_ptr<const PackedGrains>>& known)
	{
		for (const auto& grains : known)
			if (*grains == *state.grains) {
				state.grains = grains;
				return;
			}
		known.push_back(state.grains);
	}

	template <int Dim> bool belongTogether(const PackedLists<Dim>& lists, std::size_t grains)
	{
		if (lists.slack.size() != grains) return false;
		if (std::any_of(lists.slack.begin(), lists.slack.end(), [](unsigned s) { return s > PackedLists<Dim>::largestSlack; })) return false;
		if (lists.second.size() != lists.size() || lists.inside + lists.cellDist.size() != lists.size()) return false;
		for (std::size_t k = 0; k < lists.size(); ++k)
			if (lists.first[k] >= grains || lists.second[k] >= grains) return false;
		return true;
	}

} // namespace

template <int Dim>
PackedStore<Dim>::PackedStore(std::vector<StatePointer> p)
        : prototypes(std::move(p))
{
	for (const auto& state : prototypes) {
		if (std::find(knownGrains.begin(), knownGrains.end(), state->grains) == knownGrains.end()) knownGrains.push_back(state->grains);
		double sum = 0;
		for (const double r : state->grains->radius)
			sum += r;
		meanRadius.push_back(sum / double(state->size()));
	}
}

// stiffness of grains and ice in contact, k_n/t_z or k_n/r: holds also for samples that have lost their contacts for a moment
template <int Dim> double PackedStore<Dim>::oedometricModulus(int prototype, double iceSaturation) const
{
	const auto& state = *prototypes.at(prototype);
	// of Hertz's grains under ten times the stress of the prototype
	const double young = state.ice.youngAt(iceSaturation) + state.ice.young * (overLinear(state, *state.grains, meanRadius[prototype], 10) - 1);
	return Dim == 2 ? 1.1 * young * meanRadius[prototype] / state.thickness : 0.8 * young;
}

template <int Dim> typename PackedStore<Dim>::Beginning PackedStore<Dim>::frozen(int prototype, double iceSaturation, const PackedUpdateOptions& options) const
{
	PackedSample<Dim> sample(*prototypes.at(prototype));
	if (prototypes[prototype]->iceSaturation != iceSaturation) {
		const auto result = sample.apply(PackedTypes<Dim>::Matrix::Zero(), iceSaturation, options);
		if (result.blewUp)
			throw std::runtime_error("RveSkeleton.samples[" + std::to_string(prototype) + "] does not survive freezing: " + result.reason);
	}
	Beginning beginning;
	beginning.sample        = std::make_shared<CompactSample<Dim>>(sample.state());
	beginning.start.stress  = sample.stress();
	beginning.start.tangent = sample.tangent();
	return beginning;
}

template <int Dim> const SampleStart<Dim>& PackedStore<Dim>::add(int prototype, double iceSaturation, const PackedUpdateOptions& options)
{
	auto found = beginnings.find({ prototype, iceSaturation });
	if (found == beginnings.end()) found = beginnings.emplace(std::make_pair(prototype, iceSaturation), frozen(prototype, iceSaturation, options)).first;
	pool.add(found->second.sample);
	return found->second.start;
}

template <int Dim>
std::vector<PackedUpdateResult<Dim>> PackedStore<Dim>::update(const std::vector<PackedRequest<Dim>>& requests, const PackedUpdateOptions& options, int threads)
{
	return pool.update(requests, options, threads);
}

template <int Dim> std::vector<double> PackedStore<Dim>::measureHere(std::size_t sample, const std::string& name) const
{
	const PackedParameters<Dim>& s = pool.parameters(sample);
	if (name == "bondsFormed") return { double(s.bondsFormed) };
	if (name == "bondsBroken") return { double(s.bondsBrokenInTension + s.bondsBrokenInShear) };
	if (name == "bondsMelted") return { double(s.bondsMelted) };
	if (name == "sampleIceSaturation") return { s.iceSaturation };
	if (name == "cellSlips") return { double(s.cellSlips) };
	return measureFrom<Dim>(pool.statistics(sample), name);
}

/// The neighbour lists go along: lists made anew sum the same forces in another order.
template <int Dim> void PackedStore<Dim>::saveState(ByteWriter& writer, std::size_t sample) const
{
	PackedState<Dim> state;
	PackedLists<Dim> lists;
	const bool       listed = pool.compact(sample)->expand(state, lists);
	writer.block(state.toBytes());
	writer.number(listed);
	if (!listed) return;
	writer.block(static_cast<const PackedListUse<Dim>*>(&lists), sizeof(PackedListUse<Dim>));
	writer.number(lists.inside);
	writer.array(lists.slack);
	writer.array(lists.first);
	writer.array(lists.second);
	writer.array(lists.cellDist);
}

template <int Dim> void PackedStore<Dim>::restoreState(ByteReader& reader, const std::vector<std::size_t>& samples)
{
	auto state = PackedState<Dim>::fromBytes(reader.block());
	shareGrains(state, knownGrains);
	typename SamplePool<Dim>::Compact compact;
	if (reader.number()) {
		PackedLists<Dim> lists;
		reader.block(static_cast<PackedListUse<Dim>*>(&lists), sizeof(PackedListUse<Dim>));
		lists.inside = reader.number();
		reader.array(lists.slack);
		reader.array(lists.first);
		reader.array(lists.second);
		reader.array(lists.cellDist);
		if (!belongTogether(lists, state.size())) throw std::runtime_error("the archive's neighbour lists do not belong to its samples; it is damaged");
		compact = std::make_shared<CompactSample<Dim>>(state, &lists);
	} else compact = std::make_shared<CompactSample<Dim>>(state);
	for (const auto sample : samples)
		pool.share(sample, compact);
}

template <int Dim> void PackedStore<Dim>::resize(std::size_t samples)
{
	const auto blank = std::make_shared<const CompactSample<Dim>>(*prototypes.front());
	pool.clear();
	for (std::size_t s = 0; s < samples; ++s)
		pool.add(blank);
}

TALIK_IN_PLANE_AND_SPACE(PackedStore);

} // namespace talik
