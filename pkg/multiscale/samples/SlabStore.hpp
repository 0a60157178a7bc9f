// SPDX-License-Identifier: GPL-2.0-or-later
#pragma once
#include <map>
#include <pkg/multiscale/samples/StoreOfRanks.hpp>

namespace talik {

/// Samples behind the points of a ground in slabs: the rank that has a point owns its sample, and alone asks it. Its answers go nowhere, but the
/// other ranks do not know how far its samples have come: they ask the owner. A sample that no rank has asked yet is on all ranks.
template <int Dim> class SlabStore final : public StoreOfRanks<Dim> {
public:
	using Request = PackedRequest<Dim>;
	using Result  = PackedUpdateResult<Dim>;

	SlabStore(std::shared_ptr<SampleStoreOf<Dim>> held, std::shared_ptr<Communicator> communicator);

	/// Of samples of this rank. Not collective.
	std::vector<Result> update(const std::vector<Request>&, const PackedUpdateOptions&, int threads) override;

	const void* identity(std::size_t sample) const override { return held->identity(sample); }
	void        restoreState(ByteReader&, const std::vector<std::size_t>& samples) override;
	void        replaced(std::size_t sample) override;

	/// The owner of each sample, -1 for one that no point has. Not collective: states stay where they are, as they may where all ranks have them
	/// or where they are restored next, each by its owner.
	void own(std::vector<int> ownerOf);
	/// The same, and samples whose owner has changed go to it as the bytes that a checkpoint holds of them. Collective.
	void deal(std::vector<int> ownerOf);
	/// On all ranks before the updates of a step: what was brought to be looked at is out of date.
	void beginStep();
	/// DEM steps times their cost in the updates of this rank since the last call, in the unit of costOfStep().
	double takeCost();
	/// Cost of the updates of a sample of this rank since it was asked for, in the unit of costOfStep().
	double takeCost(std::size_t sample);

private:
	using StoreOfRanks<Dim>::nobody;
	using StoreOfRanks<Dim>::held;
	using StoreOfRanks<Dim>::communicator;
	using StoreOfRanks<Dim>::brought;
	using StoreOfRanks<Dim>::shared;
	using StoreOfRanks<Dim>::number;

	/// What the owner of a sample knows of it.
	struct Known {
		bool          everywhere = true; ///< on all ranks alike
		std::uint64_t origin     = 0;    ///< the same, but for chance (2^-64), for samples that would share one state on one rank
		double        cost       = 0;
	};

	int  ownerOf(std::size_t sample) const override { return sample < owner.size() ? owner[sample] : nobody; }
	bool isEverywhere(std::size_t sample) const override { return known[sample].everywhere; }
	bool wants(const std::vector<std::size_t>& samples) const override;
	void beginAnew(std::size_t sample) override;
	void forget(std::size_t samples) override;
	/// All ask their owners first which samples would share a state on one rank.
	typename SampleStore::Survey survey(const std::string& question) const override;
	std::string                  answerOfMine(const std::string& question) const override;
	std::uint64_t                nextOrigin();
	void                         send(const std::vector<int>& next);

	std::vector<int>                     owner;
	std::vector<Known>                   known;
	std::map<const void*, std::uint64_t> beginnings; ///< origins of the states that samples begin with
	std::uint64_t                        origins = 0, step = 0;
	double                               cost = 0;
};

} // namespace talik
