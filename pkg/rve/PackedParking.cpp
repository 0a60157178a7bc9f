// SPDX-License-Identifier: GPL-2.0-or-later
#include <algorithm>
#include <cstring>
#include <pkg/rve/PackedParking.hpp>

namespace talik {

namespace {

	/// Blocks come in few sizes, so that the block one sample leaves fits the next.
	constexpr std::size_t blockStep = 512;

	struct Measure {
		std::size_t bytes = 0;
		template <class T> void array(const std::vector<T>&, std::size_t from, std::size_t to) { bytes += (to - from) * sizeof(T); }
	};

	struct Put {
		unsigned char* at;
		template <class T> void array(const std::vector<T>& items, std::size_t from, std::size_t to)
		{
			if (to == from) return;
			std::memcpy(at, static_cast<const void*>(items.data() + from), (to - from) * sizeof(T));
			at += (to - from) * sizeof(T);
		}
	};

	/// Entries in front of `from` are zero.
	struct Take {
		const unsigned char* at;
		template <class T> void array(std::vector<T>& items, std::size_t from, std::size_t to)
		{
			items.resize(to);
			std::fill_n(items.begin(), from, T {});
			if (to == from) return;
			std::memcpy(static_cast<void*>(items.data() + from), at, (to - from) * sizeof(T));
			at += (to - from) * sizeof(T);
		}
	};

	template <int Dim> PairKey<Dim> pairOf(const PackedContacts<Dim>& c, std::size_t k) { return { c.first[k], c.second[k], c.cellDist[k] }; }

	template <int Dim> void append(PackedContacts<Dim>& pairs, const PairKey<Dim>& pair)
	{
		pairs.first.push_back(std::uint16_t(pair.first));
		pairs.second.push_back(std::uint16_t(pair.second));
		pairs.cellDist.push_back(pair.cellDist);
	}

	/// Appends to `others` the keys that are not among the pairs from..to; false unless these are a part of the keys in the same order.
	template <int Dim>
	bool subtract(const std::vector<std::uint64_t>& keys, const PackedContacts<Dim>& pairs, std::size_t from, std::size_t to, PackedContacts<Dim>& others)
	{
		for (const std::uint64_t key : keys) {
			if (from < to && pairOf(pairs, from).encode() == key) ++from;
			else append(others, PairKey<Dim>::decode(key));
		}
		return from == to;
	}

	/// Keys of two ranges of pairs, each sorted.
	template <int Dim> struct KeyRange {
		const PackedContacts<Dim>& pairs;
		std::size_t                at, end;
		bool                       empty() const { return at == end; }
		std::uint64_t              key() const { return pairOf(pairs, at).encode(); }
	};

	template <int Dim> void merge(KeyRange<Dim> many, KeyRange<Dim> few, std::vector<std::uint64_t>& keys)
	{
		keys.clear();
		std::uint64_t next = few.empty() ? 0 : few.key();
		for (; !many.empty(); ++many.at) {
			const std::uint64_t key = many.key();
			while (!few.empty() && next < key) {
				keys.push_back(next);
				++few.at;
				if (!few.empty()) next = few.key();
			}
			keys.push_back(key);
		}
		for (; !few.empty(); ++few.at)
			keys.push_back(few.key());
	}

} // namespace

template <int Dim> template <class Stream, class Pairs> void ParkedSample<Dim>::streamPairs(Stream& stream, const PairCount& count, Pairs& pairs)
{
	stream.array(pairs.first, 0, count.all);
	stream.array(pairs.second, 0, count.all);
	stream.array(pairs.cellDist, count.inside, count.all);
}

/// One order for measuring, putting and taking, the widest numbers first.
template <int Dim> template <class Stream, class State> void ParkedSample<Dim>::streamState(Stream& stream, State& s) const
{
	auto&             c     = s.contacts;
	const std::size_t bonds = bonded ? contactCount.all : 0;
	stream.array(s.position, 0, grainCount);
	stream.array(s.velocity, 0, grainCount);
	stream.array(s.angularVelocity, 0, grainCount);
	stream.array(s.orientation, 0, grainCount);
	stream.array(c.shear, 0, contactCount.all);
	stream.array(c.normal, 0, Dim == 3 ? contactCount.all : 0);
	stream.array(c.iceShear, 0, bonds);
	stream.array(c.iceReference, 0, bonds);
	stream.array(c.grainReference, 0, bonds);
	streamPairs(stream, contactCount, c);
	stream.array(c.bond, 0, bonds);
}

template <int Dim>
bool ParkedSample<Dim>::otherPairs(const PackedLists<Dim>& lists, const PackedContacts<Dim>& contacts, PackedContacts<Dim>& others)
{
	if (!subtract(lists.inner, contacts, 0, contactCount.inside, others)) return false;
	otherCount.inside = std::uint32_t(others.size());
	if (!subtract(lists.periodic, contacts, contactCount.inside, contactCount.all, others)) return false;
	otherCount.all = std::uint32_t(others.size());
	return true;
}

template <int Dim>
ParkedSample<Dim>::ParkedSample(const PackedState<Dim>& state, const PackedLists<Dim>* lists)
        : parameters(state)
        , grains(state.grains)
        , grainCount(std::uint32_t(state.size()))
        , bonded(state.bonded())
{
	const PackedContacts<Dim>& c = state.contacts;
	contactCount.all             = std::uint32_t(c.size());
	while (contactCount.inside < contactCount.all && !pairOf(c, contactCount.inside).crossesCell())
		++contactCount.inside;
	thread_local PackedContacts<Dim> others; // its memory is kept: nothing is allocated between the blocks
	others.first.clear();
	others.second.clear();
	others.cellDist.clear();
	listed = lists && otherPairs(*lists, c, others);
	if (listed) use = *lists;
	else otherCount = {};
	Measure measure;
	streamState(measure, state);
	streamPairs(measure, otherCount, others);
	capacity = (measure.bytes + blockStep - 1) / blockStep * blockStep;
	block.reset(new unsigned char[capacity]);
	Put put { block.get() };
	streamState(put, state);
	streamPairs(put, otherCount, others);
}

template <int Dim> void ParkedSample<Dim>::unpark(PackedState<Dim>& state) const
{
	static_cast<PackedParameters<Dim>&>(state) = parameters;
	state.grains                               = grains;
	Take take { block.get() };
	streamState(take, state);
}

template <int Dim> bool ParkedSample<Dim>::unpark(PackedLists<Dim>& lists, const PackedContacts<Dim>& contacts) const
{
	if (!listed) return false;
	static_cast<PackedListUse<Dim>&>(lists) = use;
	Measure             measure;
	PackedState<Dim>    empty;
	streamState(measure, empty);
	thread_local PackedContacts<Dim> others;
	Take                take { block.get() + measure.bytes };
	streamPairs(take, otherCount, others);
	merge<Dim>({ contacts, 0, contactCount.inside }, { others, 0, otherCount.inside }, lists.inner);
	merge<Dim>({ contacts, contactCount.inside, contactCount.all }, { others, otherCount.inside, otherCount.all }, lists.periodic);
	return true;
}

template class ParkedSample<2>;
template class ParkedSample<3>;

} // namespace talik
