// SPDX-License-Identifier: GPL-2.0-or-later
#pragma once
#include <map>
#include <pkg/multiscale/samples/PackedStore.hpp>
#include <pkg/ranks/Communicator.hpp>
#include <set>

namespace talik {

/// Samples behind the points of a ground in slabs: the rank that has a point owns its sample, and alone asks it. Its answers go nowhere, but the
/// other ranks do not know how far its samples have come: they ask the owner. A sample that no rank has asked yet is on all ranks. Where ranks
/// have no slabs nobody owns a sample, and each rank keeps all.
template <int Dim> class SlabStore final : public PackedStore<Dim>, private Communicator::Answerer {
public:
	using Request = PackedRequest<Dim>;
	using Result  = PackedUpdateResult<Dim>;

	SlabStore(std::vector<typename PackedStore<Dim>::StatePointer> prototypes, std::shared_ptr<Communicator> communicator);
	~SlabStore() override;

	std::size_t distinctStates() const override { return this->SampleStore::distinctStates(); }

	const SampleStart<Dim>& add(int prototype, double iceSaturation, const PackedUpdateOptions&) override;
	void                    copy(std::size_t sample) override;
	void                    release(std::size_t sample) override;
	void                    clear() override { resize(0); }
	void                    resize(std::size_t samples) override;
	/// Of samples of this rank. Not collective.
	std::vector<Result> update(const std::vector<Request>&, const PackedUpdateOptions&, int threads) override;

	void          restoreState(ByteReader&, const std::vector<std::size_t>& samples) override;
	std::uint64_t writeStates(const typename SampleStore::Layout&, const FilePlace&) const override;
	/// The owner asks, too: ranks that all look go on together, and none replaces a sample or ends its ground before the others have seen it.
	void bring(std::size_t sample) const override;
	void beforeReplacing(std::size_t sample) override;
	void replaced(std::size_t sample) override;
	/// The state of a sample of this rank, for others to look at; empty where all have it.
	std::string stateToShow(std::size_t sample) const;
	/// The same of another rank is here to be looked at.
	void show(std::size_t sample, const std::string& state) const;

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
	/// What the updates of a step have cost, by rank: for the balance.
	void                        bookCosts(const std::vector<double>& costs);
	const SampleStore::Sharing* sharing() const override;

private:
	static constexpr int nobody = -1; ///< owns a sample that all ranks have alike

	/// What the owner of a sample knows of it.
	struct Known {
		bool          everywhere = true; ///< on all ranks alike
		std::uint64_t origin     = 0;    ///< the same, but for chance (2^-64), for samples that would share one state on one rank
		double        cost       = 0;
	};

	using Packed = PackedStore<Dim>;
	/// What is brought or given back here leaves what the owner knows of a sample as it is.
	Packed& held() const { return const_cast<SlabStore&>(*this); }
	int     ownerOf(std::size_t sample) const { return sample < owner.size() ? owner[sample] : nobody; }
	bool    isMine(std::size_t sample) const { return ownerOf(sample) == communicator->rank(); }
	bool    wants(const std::vector<std::size_t>& samples) const override;
	void    beginAnew(std::size_t sample);
	/// All ask their owners first which samples would share a state on one rank.
	typename SampleStore::Survey survey(const std::string& question) const override;
	std::string                  answerTo(const std::string& question) const override;
	std::string                  answerOfMine(const std::string& question) const;
	std::string                  carryOut(const std::string& order) const override;
	std::uint64_t                nextOrigin();
	void                         send(const std::vector<int>& next);
	void                         receive(ByteReader& parcel);

	std::shared_ptr<Communicator>         communicator;
	int                                   number = -1; ///< of this store in the communicator, once there are owners
	std::vector<int>                      owner;
	std::vector<Known>                    known;
	mutable std::set<std::size_t>         seen;       ///< samples that are here as their owner has them
	mutable std::set<std::size_t>         brought;    ///< those of them that other ranks own
	std::map<const void*, std::uint64_t>  beginnings; ///< origins of the states that samples begin with
	std::uint64_t                         origins = 0, step = 0;
	double                                cost = 0, meanCost = 0, largestCost = 0; ///< of this rank now; of ranks, summed over updates
	mutable typename SampleStore::Sharing shared;
};

} // namespace talik
