// SPDX-License-Identifier: GPL-2.0-or-later
#pragma once
#include <map>
#include <pkg/multiscale/samples/StoreOfRanks.hpp>

namespace talik {

/// Samples behind the points of a ground in bands: the rank that has a point owns its sample, and alone asks it. Its answers go nowhere, but the
/// other ranks do not know how far its samples have come: they ask the owner. A sample that no rank has asked yet is on all ranks.
template <int Dim> class BandStore final : public StoreOfRanks<Dim> {
public:
	using Request = PackedRequest<Dim>;
	using Result  = PackedUpdateResult<Dim>;

	BandStore(std::shared_ptr<SampleStoreOf<Dim>> held, std::shared_ptr<RankTalk> talk);
	~BandStore() override;

	void clear() override;
	/// Of samples of this rank. Not collective.
	std::vector<Result> update(const std::vector<Request>&, const PackedUpdateOptions&, int threads) override;

	std::vector<std::vector<double>> measureAll(const std::string& name) const override;
	const void*                      identity(std::size_t sample) const override { return held->identity(sample); }
	std::size_t                      distinctStates() const override { return ask("origins").firstOf.size(); }
	void                             save(ByteWriter&) const override;
	void                             restoreState(ByteReader&, const std::vector<std::size_t>& samples) override;
	void                             resize(std::size_t samples) override;
	void                             replaced(std::size_t sample) override;
	const SampleStore::Sharing*      sharing() const override;

	/// The owner of each sample, -1 for one that no point has. Not collective: states stay where they are, as they may where all ranks have them
	/// or where they are restored next, each by its owner.
	void own(std::vector<int> ownerOf);
	/// The same, and samples whose owner has changed go to it as the bytes that a checkpoint holds of them. Collective.
	void deal(std::vector<int> ownerOf);
	/// On all ranks before the updates of a step: what was brought to be looked at is out of date.
	void beginStep();
	/// DEM steps times their cost in the updates of this rank since the last call, in the unit of costOfStep().
	double takeCost();
	/// Of the ranks in this step, by rank: for the balance.
	void bookCosts(const std::vector<double>& costs);
	/// The state of a sample of this rank; empty where it is on all ranks.
	std::string stateToShow(std::size_t sample) const;
	/// The same of another rank is here to be looked at.
	void show(std::size_t sample, const std::string& state) const;
	/// Cost of the updates of a sample of this rank since it was asked for, in the unit of costOfStep().
	double takeCost(std::size_t sample);

private:
	static constexpr int nobody = -1;
	/// What the owner of a sample knows of it.
	struct Known {
		bool          everywhere = true; ///< on all ranks alike
		std::uint64_t origin     = 0;    ///< the same, but for chance (2^-64), for samples that would share one state on one rank
		double        cost       = 0;
	};

	std::string answerTo(const std::string& question) const override;
	void        fetch(std::size_t sample) const override;
	bool        isMine(std::size_t sample) const override { return ownerOf(sample) == talk->rank(); }
	bool        isNobodys(std::size_t sample) const override { return ownerOf(sample) == nobody; }
	bool        wants(const std::vector<std::size_t>& samples) const override;

	std::vector<std::uint64_t> lengthsOfStates(std::vector<std::uint64_t>& stateOf) const override;

	int           ownerOf(std::size_t sample) const { return sample < owner.size() ? owner[sample] : nobody; }
	void          beginAnew(std::size_t sample) override;
	std::uint64_t nextOrigin();
	void          send(const std::vector<int>& next);
	/// For each sample its state's number, in the order of the first sample that has it; for each state that sample, and what its owner says.
	struct Told {
		std::vector<std::size_t> stateOf, firstOf;
		std::vector<std::string> parts; ///< empty for what is on all ranks
	};
	Told ask(const std::string& question) const;

	using StoreOfRanks<Dim>::held;
	using StoreOfRanks<Dim>::talk;
	using StoreOfRanks<Dim>::brought;
	using StoreOfRanks<Dim>::shared;
	using StoreOfRanks<Dim>::meanCost;
	using StoreOfRanks<Dim>::largestCost;
	using StoreOfRanks<Dim>::number;
	mutable std::set<std::size_t>        seen; ///< samples that are here as their owner has them, until the next step
	std::vector<int>                     owner;
	std::vector<Known>                   known;
	std::map<const void*, std::uint64_t> beginnings; ///< origins of the states that samples begin with
	std::uint64_t                        origins = 0, step = 0;
	double                               cost = 0;
};

} // namespace talik
