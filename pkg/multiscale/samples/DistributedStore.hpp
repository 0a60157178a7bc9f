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
	DistributedStore(std::shared_ptr<SampleStoreOf<Dim>> held, std::shared_ptr<Communicator> communicator);

	/// An update that fails on one rank fails on all, with the same sentence.
	std::vector<Result> update(const std::vector<Request>&, const PackedUpdateOptions&, int threads) override;

	const void* identity(std::size_t sample) const override { return stateOf.at(sample).get(); }
	void        restoreState(ByteReader&, const std::vector<std::size_t>& samples) override;
	void        replaced(std::size_t sample) override { beginAnew(sample); }

private:
	using StoreOfRanks<Dim>::nobody;
	using StoreOfRanks<Dim>::held;
	using StoreOfRanks<Dim>::communicator;
	using StoreOfRanks<Dim>::shared;
	using StoreOfRanks<Dim>::number;

	/// What all ranks know of a state that one or several samples have.
	struct State {
		int    owner = nobody;
		double cost  = 0; ///< of its updates, older ones less and less
	};
	struct Batch;

	int                          ownerOf(std::size_t sample) const override { return stateOf.at(sample)->owner; }
	void                         beginAnew(std::size_t sample) override;
	void                         forget(std::size_t samples) override;
	typename SampleStore::Survey survey(const std::string& question) const override;
	std::string                  answerOfMine(const std::string& question) const override;
	std::vector<int>             assigned(const std::vector<Request>&) const;
	void                         compute(Batch&, const PackedUpdateOptions&, int threads) const;
	void                         spread(Batch&, bool tangent) const;
	void                         takeOver(const Batch&);
	void                         dealAgain();
	void                         changedElsewhere(std::size_t sample);

	std::vector<std::shared_ptr<State>>         stateOf;   ///< by sample
	std::map<const void*, std::weak_ptr<State>> beginning; ///< states that every rank has, by their identity here
	std::uint64_t                               updates = 0;
};

} // namespace talik
