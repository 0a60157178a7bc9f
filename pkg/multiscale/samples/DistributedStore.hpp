// SPDX-License-Identifier: GPL-2.0-or-later
#pragma once
#include <map>
#include <pkg/multiscale/samples/StoreOfRanks.hpp>

namespace talik {

/// Samples that are shared out among ranks. All ranks ask for the same updates; each computes those of the states that it owns, and the
/// answers go round. A state has one owner from its first update on; until then every rank has it, and any may compute it. Results are
/// those of one rank bit for bit, whoever owns what.
template <int Dim> class DistributedStore final : public StoreOfRanks<Dim> {
public:
	using Request = PackedRequest<Dim>;
	using Result  = PackedUpdateResult<Dim>;

	/// held: the samples as this rank has them; up to date are those of its own states and those that every rank has.
	DistributedStore(std::shared_ptr<SampleStoreOf<Dim>> held, std::shared_ptr<RankTalk> talk);
	~DistributedStore() override;

	void clear() override;
	/// An update that fails on one rank fails on all, with the same sentence.
	std::vector<Result> update(const std::vector<Request>&, const PackedUpdateOptions&, int threads) override;

	std::vector<std::vector<double>> measureAll(const std::string& name) const override;
	const void*                      identity(std::size_t sample) const override { return stateOf.at(sample).get(); }
	std::size_t                      distinctStates() const override { return this->numbering().firstOf.size(); }
	void                             save(ByteWriter&) const override;
	void                             restoreState(ByteReader&, const std::vector<std::size_t>& samples) override;
	void                             resize(std::size_t samples) override;
	void                             replaced(std::size_t sample) override { beginAnew(sample); }
	const SampleStore::Sharing*      sharing() const override;

private:
	static constexpr int everywhere = -1;
	/// What all ranks know of a state that one or several samples have.
	struct State {
		int    owner = everywhere;
		double cost  = 0; ///< of its updates, older ones less and less
	};
	struct Batch;

	std::string              answerTo(const std::string& question) const override;
	bool                     isMine(std::size_t sample) const override { return stateOf[sample]->owner == talk->rank(); }
	bool                     isNobodys(std::size_t sample) const override { return stateOf[sample]->owner == everywhere; }
	void                     beginAnew(std::size_t sample) override;
	void                     fetch(std::size_t sample) const override;
	std::vector<int>         dealt(const std::vector<Request>&) const;
	void                     compute(Batch&, const PackedUpdateOptions&, int threads) const;
	void                     spread(Batch&, bool tangent) const;
	void                     takeOver(const Batch&);
	void                     dealAgain();
	std::vector<std::string> partsOfOwners(const std::string& question) const;

	std::vector<std::uint64_t> lengthsOfStates(std::vector<std::uint64_t>& numberOf) const override;

	using StoreOfRanks<Dim>::held;
	using StoreOfRanks<Dim>::talk;
	using StoreOfRanks<Dim>::brought;
	using StoreOfRanks<Dim>::shared;
	using StoreOfRanks<Dim>::meanCost;
	using StoreOfRanks<Dim>::largestCost;
	using StoreOfRanks<Dim>::number;
	std::vector<std::shared_ptr<State>>         stateOf;   ///< by sample
	std::map<const void*, std::weak_ptr<State>> beginning; ///< states that every rank has, by their identity here
	std::uint64_t                               updates = 0;
};

} // namespace talik
