// SPDX-License-Identifier: GPL-2.0-or-later
#include <algorithm>
#include <cstring>
#include <pkg/rve/packed/PackedSamplePool.hpp>

namespace talik {

namespace {

	/// Blocks come in few sizes, so that the block one sample leaves fits the next.
	constexpr std::size_t blockStep = 1024;

	constexpr unsigned bondBits = 4;
	static_assert((PackedContacts<2>::iceSpringUncut | 3) < 1 << bondBits, "every bond fits");

	constexpr unsigned slackBits = 4;
	static_assert(PackedLists<2>::largestSlack < 1 << slackBits, "every slack fits");

	/// Bits of an index that its low byte does not hold: 0, 1, 2, 4 or 8, so that a whole number of them fills a byte.
	unsigned highBits(std::size_t largest)
	{
		unsigned bits = largest > 0xff ? 1 : 0;
		while (bits > 0 && bits < 8 && (largest >> 8 >> bits) != 0)
			bits *= 2;
		return bits;
	}

	struct Measure {
		std::size_t             bytes = 0;
		template <class T> void bitsOf(const std::vector<T>&, std::size_t number, unsigned bits, unsigned) { bytes += (number * bits + 7) / 8; }
		template <class T> void array(const std::vector<T>&, std::size_t to, std::size_t from = 0) { bytes += (to - from) * sizeof(T); }
		void                    sparse(const std::vector<double>&, std::size_t, std::size_t others) { bytes += others * (sizeof(double) + 4); }
	};

	/// Zero of either sign is another number here: it comes back to the last bit.
	bool isZero(double number)
	{
		std::uint64_t bits;
		std::memcpy(&bits, &number, sizeof(bits));
		return bits == 0;
	}

	struct Put {
		unsigned char*          at;
		template <class T> void value(const T& item)
		{
			std::memcpy(at, &item, sizeof(T));
			at += sizeof(T);
		}
		/// The numbers that are not zero, each after its place.
		void sparse(const std::vector<double>& items, std::size_t number, std::size_t)
		{
			for (std::size_t k = 0; k < number; ++k) {
				if (isZero(items[k])) continue;
				value(std::uint32_t(k));
				value(items[k]);
			}
		}
		/// Of each number the `bits` bits from `shift` on; 8 is a multiple of `bits`.
		template <class T> void bitsOf(const std::vector<T>& items, std::size_t number, unsigned bits, unsigned shift)
		{
			if (bits == 0) return;
			const std::size_t each = 8 / bits;
			const unsigned    mask = (1u << bits) - 1;
			for (std::size_t k = 0; k < number; k += each) {
				unsigned byte = 0;
				for (std::size_t j = 0; j < std::min(each, number - k); ++j)
					byte |= ((items[k + j] >> shift) & mask) << (j * bits);
				value(static_cast<unsigned char>(byte));
			}
		}
		template <class T> void array(const std::vector<T>& items, std::size_t to, std::size_t from = 0)
		{
			if (to == from) return;
			std::memcpy(at, static_cast<const void*>(items.data() + from), (to - from) * sizeof(T));
			at += (to - from) * sizeof(T);
		}
	};

	/// Entries in front of `from` are zero.
	struct Take {
		const unsigned char*    at;
		template <class T> void value(T& item)
		{
			std::memcpy(&item, at, sizeof(T));
			at += sizeof(T);
		}
		void sparse(std::vector<double>& items, std::size_t number, std::size_t others)
		{
			items.assign(number, 0.);
			for (std::uint32_t place; others > 0; --others) {
				value(place);
				value(items[place]);
			}
		}
		template <class T> void bitsOf(std::vector<T>& items, std::size_t number, unsigned bits, unsigned shift)
		{
			if (shift == 0) items.assign(number, 0);
			if (bits == 0) return;
			const std::size_t each = 8 / bits;
			const unsigned    mask = (1u << bits) - 1;
			for (std::size_t k = 0; k < number; k += each, ++at)
				for (std::size_t j = 0; j < std::min(each, number - k); ++j)
					items[k + j] = T(items[k + j] | ((*at >> (j * bits)) & mask) << shift);
		}
		template <class T> void array(std::vector<T>& items, std::size_t to, std::size_t from = 0)
		{
			items.resize(to);
			std::fill_n(items.begin(), from, T {});
			if (to == from) return;
			std::memcpy(static_cast<void*>(items.data() + from), at, (to - from) * sizeof(T));
			at += (to - from) * sizeof(T);
		}
	};

	/// Number of contacts in front of the first that crosses the cell.
	template <int Dim> std::uint32_t leadingInside(const PackedContacts<Dim>& contacts)
	{
		const std::array<std::int8_t, Dim> none {};
		const auto&                        c = contacts.cellDist;
		return std::uint32_t(std::find_if(c.begin(), c.end(), [&](const auto& cells) { return cells != none; }) - c.begin());
	}

	/// True if the contacts are those that the lists name, in the same order.
	template <int Dim> bool namesContacts(const PackedLists<Dim>& lists, const PackedContacts<Dim>& contacts)
	{
		const std::array<std::int8_t, Dim> none {};
		std::size_t                        at = 0;
		for (std::size_t k = 0; k < lists.size(); ++k) {
			if (!lists.contact(k)) continue;
			if (at == contacts.size() || contacts.first[at] != lists.first[k] || contacts.second[at] != lists.second[k]) return false;
			if (contacts.cellDist[at] != (k < lists.inside ? none : lists.cellDist[k - lists.inside])) return false;
			++at;
		}
		return at == contacts.size();
	}

	template <int Dim> void nameContacts(const PackedLists<Dim>& lists, std::size_t count, PackedContacts<Dim>& contacts)
	{
		contacts.first.resize(count);
		contacts.second.resize(count);
		contacts.cellDist.resize(count);
		std::size_t at = 0;
		for (std::size_t k = 0; k < lists.size(); ++k) {
			if (!lists.contact(k)) continue;
			contacts.first[at]    = lists.first[k];
			contacts.second[at]   = lists.second[k];
			contacts.cellDist[at] = k < lists.inside ? std::array<std::int8_t, Dim> {} : lists.cellDist[k - lists.inside];
			++at;
		}
	}

} // namespace

/// One order for measuring, putting and taking, the widest numbers first.
template <int Dim> template <class Stream, class State, class Lists> void CompactSample<Dim>::stream(Stream& stream, State& s, Lists& lists) const
{
	auto&             c     = s.contacts;
	const std::size_t bonds = bonded ? contacts : 0, unlisted = listed ? 0 : contacts;
	stream.array(s.position, grainCount);
	stream.array(s.velocity, grainCount);
	stream.array(s.angularVelocity, grainCount);
	stream.array(s.orientation, Dim == 2 ? grainCount : 0);
	stream.array(c.shear, contacts);
	stream.array(c.moment, grains->rolling.acts() ? contacts : 0);
	stream.array(c.iceShear, bonds);
	stream.array(c.bondMoment, grains->section.acts() ? bonds : 0);
	stream.array(c.iceReference, bonds);
	stream.sparse(c.grainReference, bonds, gaps);
	const auto indices = [&](auto& of, std::size_t number) {
		stream.bitsOf(of, number, 8, 0);
		stream.bitsOf(of, number, highBits(grainCount), 8);
	};
	indices(c.first, unlisted);
	indices(c.second, unlisted);
	indices(lists.first, pairs);
	indices(lists.second, pairs);
	stream.bitsOf(lists.slack, listed ? grainCount : 0, slackBits, 0);
	stream.array(c.cellDist, unlisted, listed ? 0 : contactsInside);
	stream.array(lists.cellDist, pairs - pairsInside);
	stream.bitsOf(c.bond, bonds, bondBits, 0);
}

template <int Dim>
CompactSample<Dim>::CompactSample(const PackedState<Dim>& state, const PackedLists<Dim>* lists)
        : parameters(state)
        , grains(state.grains)
        , grainCount(std::uint32_t(state.size()))
        , contacts(std::uint32_t(state.contacts.size()))
        , bonded(state.bonded())
        , listed(lists && namesContacts<Dim>(*lists, state.contacts))
{
	const PackedLists<Dim> none {};
	if (!listed) contactsInside = leadingInside<Dim>(state.contacts);
	if (listed) {
		use         = *lists;
		pairs       = std::uint32_t(lists->size());
		pairsInside = std::uint32_t(lists->inside);
	}
	gaps = std::uint32_t(std::count_if(state.contacts.grainReference.begin(), state.contacts.grainReference.end(), [](double u) { return !isZero(u); }));
	Measure measure;
	stream(measure, state, listed ? *lists : none);
	if (!listed) measure.bytes += contacts; // the lists that come with the first update then fit its place
	capacity = (measure.bytes + blockStep - 1) / blockStep * blockStep;
	block.reset(new unsigned char[capacity]);
	Put put { block.get() };
	stream(put, state, listed ? *lists : none);
}

template <int Dim> bool CompactSample<Dim>::expand(PackedState<Dim>& state, PackedLists<Dim>& lists) const
{
	static_cast<PackedParameters<Dim>&>(state) = parameters;
	state.grains                               = grains;
	Take take { block.get() };
	stream(take, state, lists);
	static_cast<PackedListUse<Dim>&>(lists) = use;
	lists.inside                            = pairsInside;
	if (listed) nameContacts<Dim>(lists, contacts, state.contacts);
	return listed;
}

template <int Dim> void CompactSample<Dim>::expand(PackedState<Dim>& state) const
{
	PackedLists<Dim> lists;
	expand(state, lists);
}

TALIK_IN_PLANE_AND_SPACE(CompactSample);

} // namespace talik
