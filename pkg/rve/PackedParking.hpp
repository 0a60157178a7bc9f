// SPDX-License-Identifier: GPL-2.0-or-later
#pragma once
#include <cstddef>
#include <memory>
#include <pkg/rve/PackedNeighbours.hpp>
#include <pkg/rve/PackedState.hpp>

namespace talik {

/// A sample between two updates: its state, exactly, and the neighbour lists it was left with, in one block of memory. Never changes.
/// Contacts stand in the lists too: of those only the other pairs are parked.
template <int Dim> class ParkedSample {
public:
	/// lists: those of exactly this state, or nullptr. They are dropped where contacts are not in the order in which a workspace stores them.
	explicit ParkedSample(const PackedState<Dim>& state, const PackedLists<Dim>* lists = nullptr);

	/// The parked state to the last bit.
	void unpark(PackedState<Dim>& state) const;
	/// False if no lists are parked. contacts: those of this sample's state.
	bool unpark(PackedLists<Dim>& lists, const PackedContacts<Dim>& contacts) const;

	/// Bytes held, the constants of the grains excluded (they are shared).
	std::size_t bytes() const { return sizeof(*this) + capacity; }

private:
	/// Pairs of grains; the first `inside` of them do not cross the cell.
	struct PairCount {
		std::uint32_t all = 0, inside = 0;
	};

	template <class Stream, class State> void streamState(Stream& stream, State& state) const;
	template <class Stream, class Pairs> static void streamPairs(Stream& stream, const PairCount& count, Pairs& pairs);
	/// Pairs of the lists that are no contacts; false if some contact is missing in them.
	bool otherPairs(const PackedLists<Dim>& lists, const PackedContacts<Dim>& contacts, PackedContacts<Dim>& others);

	PackedParameters<Dim>               parameters;
	std::shared_ptr<const PackedGrains> grains;
	PackedListUse<Dim>                  use {};
	std::uint32_t                       grainCount;
	PairCount                           contactCount, otherCount;
	bool                                bonded, listed = false;
	std::size_t                         capacity = 0;
	std::unique_ptr<unsigned char[]>    block;
};

} // namespace talik
