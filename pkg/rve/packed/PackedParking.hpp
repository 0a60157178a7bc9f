// SPDX-License-Identifier: GPL-2.0-or-later
#pragma once
#include <cstddef>
#include <memory>
#include <pkg/rve/packed/PackedNeighbours.hpp>
#include <pkg/rve/packed/PackedState.hpp>

namespace talik {

/// A sample between two updates: its state, exactly, and the neighbour lists it was left with, in one block of memory. Never changes.
/// Contacts stand in the lists too: which grains they join is parked once.
template <int Dim> class ParkedSample {
public:
	/// lists: those stored with exactly this state, or nullptr. They are dropped where they do not name the contacts of the state.
	explicit ParkedSample(const PackedState<Dim>& state, const PackedLists<Dim>* lists = nullptr);

	/// The parked state to the last bit.
	void unpark(PackedState<Dim>& state) const;
	/// The lists along with it; false if none are parked.
	bool unpark(PackedState<Dim>& state, PackedLists<Dim>& lists) const;

	/// Bytes held, the constants of the grains excluded (they are shared).
	std::size_t bytes() const { return sizeof(*this) + capacity; }

private:
	template <class Stream, class State, class Lists> void stream(Stream& stream, State& state, Lists& lists) const;

	PackedParameters<Dim>               parameters;
	std::shared_ptr<const PackedGrains> grains;
	PackedListUse<Dim>                  use {};
	std::uint32_t                       grainCount, contacts, contactsInside = 0, pairs = 0, pairsInside = 0, gaps = 0;
	bool                                bonded, listed;
	std::size_t                         capacity = 0;
	std::unique_ptr<unsigned char[]>    block;
};

} // namespace talik
