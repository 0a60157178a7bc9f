// SPDX-License-Identifier: GPL-2.0-or-later
#pragma once
#include <algorithm>
#include <numeric>
#include <pkg/multiscale/samples/SampleStore.hpp>
#include <pkg/ranks/Communicator.hpp>
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

/// Samples of which each rank keeps its own up to date and has the others as they once were. What all of it share is here: owners answer for their
/// samples, one that a rank only looks at is brought, and states move to other ranks as the bytes that a checkpoint holds of them. How samples
/// get their owners, and who computes an update, is in the classes derived from it.
template <int Dim> class StoreOfRanks : public SampleStoreOf<Dim>, protected Communicator::Answerer {
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
		bring(sample);
		return held->measure(sample, name);
	}
	void saveState(ByteWriter& writer, std::size_t sample) const override
	{
		bring(sample);
		held->saveState(writer, sample);
	}
	/// The owner asks, too: ranks that all look go on together, and none replaces a sample or ends its ground before the others have seen it.
	void bring(std::size_t sample) const override
	{
		const int owner = ownerOf(sample);
		if (owner != nobody && !seen.count(sample)) show(sample, communicator->ask(number, aSample + std::to_string(sample)).at(std::size_t(owner)));
	}
	/// The state of a sample of this rank, for others to look at; empty where all have it.
	std::string stateToShow(std::size_t sample) const { return isMine(sample) && !isEverywhere(sample) ? this->answer("state", sample) : ""; }
	/// The same of another rank is here to be looked at.
	void show(std::size_t sample, const std::string& state) const
	{
		seen.insert(sample);
		if (isMine(sample) || state.empty()) return; // it is here
		ByteReader reader(state);
		held->restoreState(reader, { sample });
		brought.insert(sample);
	}
	void beforeReplacing(std::size_t sample) override
	{
		if (number >= 0) communicator->meet("sample " + std::to_string(sample) + " is replaced");
	}
	std::uint64_t writeStates(const typename SampleStore::Layout& layout, const FilePlace& place) const override
	{
		if (number < 0) return held->writeStates(layout, place); // no rank has a sample of its own
		ByteWriter order;
		order.block(place.text());
		layout.save(order);
		return sumOfParts(*communicator, number, order.bytes());
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
	void clear() override
	{
		held->clear();
		seen.clear();
		brought.clear();
		forget(0);
	}
	void resize(std::size_t samples) override
	{
		clear();
		held->resize(samples);
		forget(samples);
	}
	const SampleStore::Sharing* sharing() const override
	{
		shared.samples = 0;
		for (std::size_t s = 0; s < size(); ++s)
			shared.samples += isMine(s);
		shared.balance = largestCost > 0 ? meanCost / largestCost : 1;
		return &shared;
	}
	/// What the updates of a step have cost, by rank: for the balance.
	void bookCosts(const std::vector<double>& costs)
	{
		meanCost += std::accumulate(costs.begin(), costs.end(), 0.0) / communicator->count();
		largestCost += *std::max_element(costs.begin(), costs.end());
	}

protected:
	static constexpr int nobody = -1; ///< owns a sample that all ranks have alike

	/// held: the samples as this rank has them.
	StoreOfRanks(std::shared_ptr<SampleStoreOf<Dim>> here, std::shared_ptr<Communicator> others)
	        : held(std::move(here))
	        , communicator(std::move(others))
	{}
	~StoreOfRanks() override
	{
		if (number >= 0) communicator->dismiss(number);
	}

	const SampleStore& here() const override { return *held; }
	void               enrol()
	{
		if (number < 0) number = communicator->enrol(this);
	}

	virtual int ownerOf(std::size_t sample) const = 0;
	bool        isMine(std::size_t sample) const { return ownerOf(sample) == communicator->rank(); }
	/// Whether all ranks have the state of a sample, although one may own it.
	virtual bool isEverywhere(std::size_t sample) const { return ownerOf(sample) == nobody; }
	/// The sample takes the state that it has on this rank, the same on all ranks.
	virtual void beginAnew(std::size_t sample) = 0;
	/// So many samples, of which nothing is known yet.
	virtual void forget(std::size_t samples) = 0;
	/// What this rank says to a question of survey(), of all its samples.
	virtual std::string answerOfMine(const std::string& question) const = 0;

	/// A state that goes to another rank, with the samples that share it and what else is to be known of it.
	struct Leaving {
		std::vector<std::size_t> samples;
		std::string              note;
	};
	/// States that go to each rank; arrives(samples, note) is called for those that come here. Collective.
	template <class Arrives> void move(const std::vector<std::vector<Leaving>>& toEach, Arrives arrives)
	{
		std::vector<std::string> going;
		for (const auto& states : toEach) {
			ByteWriter writer;
			for (const auto& [samples, note] : states) {
				writer.block(samples.data(), samples.size() * sizeof(std::size_t));
				writer.block(note);
				writer.block(this->answer("state", samples.front()));
			}
			going.push_back(writer.bytes());
		}
		for (const auto& states : toEach)
			for (const auto& state : states)
				for (const auto sample : state.samples)
					held->release(sample);
		for (const auto& bytes : communicator->ranks().exchange(going)) {
			ByteReader reader(bytes);
			while (!reader.atEnd()) {
				const std::string        numbers = reader.block();
				std::vector<std::size_t> samples(numbers.size() / sizeof(std::size_t));
				std::memcpy(samples.data(), numbers.data(), numbers.size());
				arrives(samples, reader.block());
				const std::string state = reader.block();
				ByteReader        from(state);
				held->restoreState(from, samples);
			}
		}
	}

	std::shared_ptr<SampleStoreOf<Dim>>   held;
	std::shared_ptr<Communicator>         communicator;
	mutable std::set<std::size_t>         seen;    ///< samples that are here as their owner has them
	mutable std::set<std::size_t>         brought; ///< those of them that other ranks own
	mutable typename SampleStore::Sharing shared;
	int                                   number = -1; ///< of this store in the communicator

private:
	static inline const std::string aSample = "sample ";

	std::string answerTo(const std::string& question) const override
	{
		if (question.compare(0, aSample.size(), aSample) != 0) return answerOfMine(question);
		return stateToShow(std::stoul(question.substr(aSample.size())));
	}
	std::string carryOut(const std::string& order) const override
	{
		return partWritten([&](PartSum& sum) {
			ByteReader reader(order);
			const auto place  = FilePlace::from(reader.block());
			const auto writes = [&](std::size_t sample) { return isMine(sample) || (communicator->rank() == 0 && ownerOf(sample) == nobody); };
			held->writeStates(SampleStore::Layout::from(reader), place, sum, writes);
		});
	}

	double meanCost = 0, largestCost = 0; ///< of ranks, summed over updates
};

} // namespace talik
