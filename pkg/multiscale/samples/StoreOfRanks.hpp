// SPDX-License-Identifier: GPL-2.0-or-later
#pragma once
#include <pkg/multiscale/samples/SampleStore.hpp>
#include <pkg/ranks/RankTalk.hpp>
#include <set>

namespace talik {

/// All that an update of a sample follows from, but its state.
template <int Dim> void addTo(Digest& digest, const PackedRequest<Dim>& request)
{
	digest.add(request.displacementGradient.data(), sizeof(double) * Dim * Dim);
	digest.add(&request.iceSaturation, sizeof(double));
	digest.add(&request.inertialNumber, sizeof(double));
	digest.add(std::uint64_t(request.compareRates));
	digest.add(&request.strength, sizeof(request.strength));
	digest.add(&request.iceStiffness, sizeof(double));
	digest.add(&request.creep, sizeof(request.creep));
}

/// Samples of which each rank keeps its share up to date and has the others as they once were. One that a rank only looks at is brought, and
/// stays until its owner may have changed it.
template <int Dim> class StoreOfRanks : public SampleStoreOf<Dim>, protected RankTalk::Answerer {
public:
	int                 prototypeCount() const override { return held->prototypeCount(); }
	double              prototypeIce(int prototype) const override { return held->prototypeIce(prototype); }
	double              oedometricModulus(int prototype, double iceSaturation) const override { return held->oedometricModulus(prototype, iceSaturation); }
	std::size_t         size() const override { return held->size(); }
	bool                comparesRates() const override { return held->comparesRates(); }
	std::size_t         bytes() const override { return held->bytes(); } ///< on this rank
	double              costOfStep(std::size_t sample) const override { return held->costOfStep(sample); }
	bool                restoresExactly() const override { return held->restoresExactly(); }
	std::vector<double> measure(std::size_t sample, const std::string& name) const override
	{
		fetch(sample);
		return held->measure(sample, name);
	}
	void saveState(ByteWriter& writer, std::size_t sample) const override
	{
		fetch(sample);
		held->saveState(writer, sample);
	}
	void bring(std::size_t sample) override { fetch(sample); }
	void beforeReplacing(std::size_t sample) override
	{
		if (number >= 0) talk->meet("sample " + std::to_string(sample) + " is replaced");
	}
	typename SampleStore::Layout layout() const override
	{
		typename SampleStore::Layout layout;
		layout.lengths = lengthsOfStates(layout.stateOf);
		return layout;
	}
	std::uint64_t writeStates(const typename SampleStore::Layout& layout, const FilePlace& place) const override
	{
		if (number < 0) return held->writeStates(layout, place); // no rank has a sample of its own
		ByteWriter order;
		order.block(place.text());
		layout.save(order);
		return sumOfParts(*talk, number, order.bytes());
	}
	const SampleStart<Dim>& add(int prototype, double iceSaturation, const PackedUpdateOptions& options) override
	{
		const auto& start = held->add(prototype, iceSaturation, options);
		beginAnew(held->size() - 1);
		return start;
	}
	void release(std::size_t sample) override
	{
		held->release(sample);
		beginAnew(sample);
	}

protected:
	/// held: the samples as this rank has them.
	StoreOfRanks(std::shared_ptr<SampleStoreOf<Dim>> here, std::shared_ptr<RankTalk> others)
	        : held(std::move(here))
	        , talk(std::move(others))
	{}

	std::string carryOut(const std::string& order) const override
	{
		return partWritten([&](PartSum& sum) {
			ByteReader reader(order);
			const auto place  = FilePlace::from(reader.block());
			const auto writes = [&](std::size_t sample) { return isMine(sample) || (talk->rank() == 0 && isNobodys(sample)); };
			held->writeStates(SampleStore::Layout::from(reader), place, sum, writes);
		});
	}
	/// This rank owns the sample; no rank does, all have it alike.
	virtual bool isMine(std::size_t sample) const    = 0;
	virtual bool isNobodys(std::size_t sample) const = 0;
	/// Bytes of each state, and the number of that of each sample.
	virtual std::vector<std::uint64_t> lengthsOfStates(std::vector<std::uint64_t>& stateOf) const = 0;
	/// From what owners have said of their states: nothing where all have one alike.
	std::uint64_t lengthOf(const std::string& said, std::size_t sample) const
	{
		std::uint64_t length = 0;
		ByteWriter    here;
		if (said.empty()) held->saveState(here, sample);
		else std::memcpy(&length, said.data(), sizeof length);
		return said.empty() ? here.bytes().size() : length;
	}

	/// The state of a sample of another rank comes here, if it is not here already.
	virtual void fetch(std::size_t sample) const = 0;
	/// The sample takes the state that it has on this rank, the same on all ranks.
	virtual void beginAnew(std::size_t sample) = 0;

	std::shared_ptr<SampleStoreOf<Dim>>   held;
	std::shared_ptr<RankTalk>             talk;
	mutable std::set<std::size_t>         brought; ///< samples of other ranks whose state is here, too
	mutable typename SampleStore::Sharing shared;
	double                                meanCost = 0, largestCost = 0; ///< of ranks, summed over updates
	int                                   number = -1;                   ///< of this store in the talk
};

} // namespace talik
