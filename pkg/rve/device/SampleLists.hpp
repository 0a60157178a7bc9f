// SPDX-License-Identifier: GPL-2.0-or-later
// Lists of neighbours of a sample, built by its block of threads: the pairs and the order that PackedWorkspace::rebuildLists would give them.
// Where pairs are written during the steps there is room for all of it.
#pragma once
#include <pkg/rve/device/SampleMemory.hpp>
#include <pkg/rve/packed/CellInverse.hpp>
#include <pkg/rve/packed/ListSkins.hpp>
#include <pkg/rve/packed/PackedNeighbours.hpp>

namespace talik {
namespace N_ONE {

	HWY_INLINE bool finite(double x) { return x * 0 == 0; }

	HWY_INLINE One positionOf(const Shared<2>& s, int g, int d) { return d == 0 ? s.ofGrain(0, g).x : s.ofGrain(0, g).y; }
	HWY_INLINE One positionOf(const Shared<3>& s, int g, int d) { return d == 0 ? s.ofGrain(0, g).x : d == 1 ? s.ofGrain(0, g).y : s.ofGrain(1, g).x; }
	HWY_INLINE One speedOf(const Shared<2>& s, int g, int d) { return d == 0 ? s.ofGrain(1, g).x : s.ofGrain(1, g).y; }
	HWY_INLINE One speedOf(const Shared<3>& s, int g, int d) { return d == 0 ? s.ofGrain(2, g).x : d == 1 ? s.ofGrain(2, g).y : s.ofGrain(3, g).x; }

	/// A pair as its key has it. The key without its scrambling factor holds the cells in its lower 32 bits.
	template <int Dim> struct PairOf {
		std::uint32_t first, second, cells;
		HWY_INLINE    PairOf(std::uint32_t a, std::uint32_t b, const int* c)
		        : first(a)
		        , second(b)
		        , cells(0)
		{
			for (int d = 0; d < Dim; ++d)
				cells |= (std::uint32_t(c[d]) & 0xff) << (24 - 8 * d);
		}
		HWY_INLINE explicit PairOf(std::uint64_t key)
		{
			const std::uint64_t code = key * PairKey<Dim>::unscramble;
			first                    = std::uint32_t(code >> 48);
			second                   = std::uint32_t(code >> 32) & 0xffffu;
			cells                    = std::uint32_t(code);
		}
		HWY_INLINE std::uint64_t key() const { return ((std::uint64_t(first) << 48) | (std::uint64_t(second) << 32) | cells) * PairKey<Dim>::scramble; }
		HWY_INLINE static int    cell(std::uint32_t cells, int d) { return int(std::int8_t(std::uint8_t(cells >> (24 - 8 * d)))); }
		/// Numbers in the order of the cells.
		HWY_INLINE static std::uint32_t ordered(std::uint32_t cells) { return cells ^ 0x80808080u; }
	};

	/// Place of a key among those from `begin` to before `end`, in their order, or -1.
	HWY_INLINE int placeOf(const std::uint64_t* keys, int begin, int end, std::uint64_t key)
	{
		const int last = end;
		while (begin < end) {
			const int middle = (begin + end) / 2;
			if (keys[middle] < key) begin = middle + 1;
			else end = middle;
		}
		return begin < last && keys[begin] == key ? begin : -1;
	}

	/// One for all numbers of threads: it is long, and rarely asked.
	template <int Dim, bool Bonded> class NewLists {
	public:
		static constexpr int mostThreads = 512, mostPairsEach = 5;

	private:
		using At   = Place<Dim, Bonded>;
		using Pair = PairOf<Dim>;

		/// A grain wrapped into the cell.
		struct Wrapped {
			double       x[Dim], reach;
			float        reduced[Dim];
			std::int32_t image[Dim];
		};

		const Shared<Dim>&   s;
		const At&            place;
		Fixed<Dim>&          fixed;
		SampleCall&          call;
		const int            threads;
		unsigned char* const room;
		const int            most; ///< pairs that there is room for
		std::uint64_t *const found, *const sorted, *const former;
		Wrapped* const       wrapped;
		std::uint32_t* const cellsOf;           ///< of pairs across the cell
		std::uint8_t* const  isFirst;           ///< of those: none before it has the same cells
		std::uint32_t *const ends, *const next; ///< of grains: number of their pairs, where the next one goes
		std::uint16_t* const entries;
		static constexpr int shears = At::shearRows;

		HWY_INLINE NewLists(const Shared<Dim>& shared, const At& at, SampleCall& c, int threadsOfBlock)
		        : s(shared)
		        , place(at)
		        , fixed(shared.fixed)
		        , call(c)
		        , threads(threadsOfBlock)
		        , room(reinterpret_cast<unsigned char*>(shared.pair))
		        , most(shared.pairs)
		        , found(reinterpret_cast<std::uint64_t*>(room))
		        , sorted(found + most)
		        , former(sorted + most)
		        , wrapped(reinterpret_cast<Wrapped*>(sorted)) // until keys are sorted
		        , cellsOf(reinterpret_cast<std::uint32_t*>(former + most))
		        , isFirst(reinterpret_cast<std::uint8_t*>(cellsOf + most))
		        , ends(reinterpret_cast<std::uint32_t*>(former))
		        , next(reinterpret_cast<std::uint32_t*>(found))
		        , entries(reinterpret_cast<std::uint16_t*>(sorted))
		{}

		/// Slack of a grain, and where it lies in the cell of the next step.
		HWY_INLINE void wrap(int g, const double* h, const double (&inverse)[Dim * Dim], double skin, const double* velGrad)
		{
			double square = 0;
			for (int d = 0; d < Dim; ++d) {
				double v = speedOf(s, g, d).value;
				for (int e = 0; e < Dim; ++e)
					v -= velGrad[d * Dim + e] * positionOf(s, g, e).value;
				square += v * v;
			}
			const double fast   = skin + ListSkins::stepsOfGrain * call.dt * __builtin_sqrt(square),
			             bound  = ListSkins::largestOfGrain * call.meanRadius;
			const double wanted = bound < fast ? bound : fast;
			int          slack  = 0;
			for (double wide = skin; wide < wanted && slack < int(PackedLists<Dim>::largestSlack); wide *= 2)
				++slack;
			place.setSlack(g, slack);
			Wrapped w;
			w.reach = place.constant(At::radius, g) + skin * double(1u << slack);
			for (int d = 0; d < Dim; ++d) {
				double xi = 0;
				for (int e = 0; e < Dim; ++e)
					xi += inverse[d * Dim + e] * positionOf(s, g, e).value;
				if (!(__builtin_fabs(xi) < 1e6)) {
					fixed.noLists = 1; // it has flown out of reach: the host says so
					xi            = 0;
				}
				w.image[d]   = int(xi) - (xi < 0);
				w.reduced[d] = float(xi - w.image[d]);
			}
			for (int d = 0; d < Dim; ++d) {
				double shift = 0;
				for (int e = 0; e < Dim; ++e)
					shift += h[d * Dim + e] * w.image[e];
				w.x[d] = positionOf(s, g, d).value - shift;
			}
			wrapped[g] = w;
		}

		/// Keys of pairs inside the cell stand from the front, of those across it from the back.
		HWY_INLINE void add(std::uint32_t (&counts)[2], std::uint32_t (&before)[2], const Pair& pair)
		{
			const bool          crosses = pair.cells != 0;
			const std::uint32_t slot    = before[crosses] + countUp(counts[crosses]);
			if (slot < std::uint32_t(most)) found[crosses ? std::uint32_t(most) - 1 - slot : slot] = pair.key();
		}

		/// All images of a pair that reach, the first grain the one with the smaller number. Single numbers tell first which may.
		HWY_INLINE void search(int a, int b, const double* h, const float* widths, std::uint32_t (&none)[2])
		{
			const Wrapped &first = wrapped[a], &second = wrapped[b];
			const double   limit   = first.reach + second.reach;
			int            from[3] = { 0, 0, 0 }, to[3] = { 0, 0, 0 }, c[3];
			for (int d = 0; d < Dim; ++d) {
				constexpr float roundOff = 1e-5f;
				const float     apart = first.reduced[d] - second.reduced[d], part = float(limit) * widths[d] + roundOff;
				from[d] = int(__builtin_ceilf(apart - part));
				to[d]   = int(__builtin_floorf(apart + part));
				if (from[d] > to[d]) return;
			}
			for (c[0] = from[0]; c[0] <= to[0]; ++c[0])
				for (c[1] = from[1]; c[1] <= to[1]; ++c[1])
					for (c[2] = from[2]; c[2] <= to[2]; ++c[2]) {
						double square = 0;
						for (int d = 0; d < Dim; ++d) {
							double shift = 0;
							for (int e = 0; e < Dim; ++e)
								shift += h[d * Dim + e] * c[e];
							const double branch = second.x[d] + shift - first.x[d];
							square += branch * branch;
						}
						if (!(square <= limit * limit)) continue;
						int cells[Dim];
						for (int d = 0; d < Dim; ++d) {
							cells[d] = c[d] + first.image[d] - second.image[d];
							if (cells[d] < -127 || cells[d] > 127) fixed.noLists = 1;
						}
						add(fixed.found, none, Pair(std::uint32_t(a), std::uint32_t(b), cells));
					}
		}

		/// Keys into their order: each counts those that are smaller.
		HWY_INLINE void sort(int t, int inner, int crossing)
		{
			for (int k = t; k < inner + crossing; k += threads) {
				const bool                 crosses = k >= inner;
				const std::uint64_t* const keys    = crosses ? found + most - crossing : found;
				const int                  number  = crosses ? crossing : inner;
				const std::uint64_t        key     = keys[crosses ? k - inner : k];
				int                        rank    = crosses ? inner : 0;
				for (int l = 0; l < number; ++l)
					rank += keys[l] < key;
				sorted[rank] = key;
			}
		}

		HWY_INLINE std::uint64_t formerKey(int p) const
		{
			const std::uint32_t code = place.index(p);
			int                 cells[Dim];
			for (int d = 0; d < Dim; ++d)
				cells[d] = code >> 24 ? int(fixed.cells[Dim * ((code >> 24) - 1) + d]) : 0;
			return Pair(code & 0xfff, code >> 12 & 0xfff, cells).key();
		}

		/// Image of a pair across the cell in the new table.
		HWY_INLINE int imageOf(std::uint32_t cells, int images) const
		{
			for (int k = 0; k < images; ++k) {
				bool same = true;
				for (int d = 0; d < Dim; ++d)
					same &= int(fixed.cells[Dim * k + d]) == Pair::cell(cells, d);
				if (same) return k;
			}
			return 0;
		}

		/// What a pair remembers.
		struct History {
			double       shear[shears], iceShear[Bonded ? shears : 1], uGrain, uIce;
			std::uint8_t bond;
		};
		HWY_INLINE History historyOf(int p) const
		{
			History h {};
			if (p < 0) return h;
			for (int d = 0; d < shears; ++d)
				h.shear[d] = place.pair(At::shear + d, p);
			if constexpr (Bonded) {
				for (int d = 0; d < shears; ++d)
					h.iceShear[d] = place.pair(At::iceShear + d, p);
				h.bond   = place.bond(p);
				h.uGrain = place.pair(At::uGrain, p);
				h.uIce   = place.pair(At::uIce, p);
			}
			return h;
		}

		/// A pair into its row, as PackedWorkspace::setResponse() has it.
		HWY_INLINE void write(int p, std::uint64_t key, const History& history, int images)
		{
			const Pair pair(key);
			place.setIndex(p, PairCode::of(pair.first, pair.second, pair.cells ? imageOf(pair.cells, images) : -1));
			const int    a = int(pair.first), b = int(pair.second);
			const double first = place.constant(At::radius, a), second = place.constant(At::radius, b), own = place.constant(At::ownRadius, a),
			             ownSecond = place.constant(At::ownRadius, b), grain = 2 * call.young * own * ownSecond / (own + ownSecond);
			for (int d = 0; d < shears; ++d)
				place.pair(At::shear + d, p) = history.shear[d];
			place.pair(At::sumRadius, p) = first + second;
			place.pair(At::stiffness, p) = call.elasticity.acts() ? call.elasticity.stiffness(own, ownSecond) : grain;
			if constexpr (Dim == 3) place.pair(At::halfDifference, p) = 0.5 * (first - second);
			if constexpr (Bonded) {
				const double smaller = ownSecond < own ? ownSecond : own;
				for (int d = 0; d < shears; ++d)
					place.pair(At::iceShear + d, p) = history.iceShear[d];
				place.pair(At::grainStiffness, p) = grain;
				place.pair(At::area, p)           = call.bondAreaFactor * smaller * smaller;
				place.pair(At::uGrain, p)         = history.uGrain;
				place.pair(At::uIce, p)           = history.uIce;
				place.bond(p)                     = history.bond;
				const IceBond bond                = place.iceBond(p);
				place.setResponse(p, bond.response(place.contactStiffness(call, p), place.strength(call, p)));
				if (bond.hasIceSpring()) return;
				for (int d = 0; d < shears; ++d)
					place.pair(At::iceShear + d, p) = 0;
			}
		}

		/// The pairs of a grain in their order; few are out of it.
		HWY_INLINE void orderPairsOf(int g)
		{
			const int begin = int(place.start(g)), end = int(place.start(g + 1));
			for (int e = begin + 1; e < end; ++e) {
				const std::uint16_t entry = entries[e];
				int                 at    = e;
				for (; at > begin && (entries[at - 1] & 0x7fff) > (entry & 0x7fff); --at)
					entries[at] = entries[at - 1];
				entries[at] = entry;
			}
			for (int e = begin; e < end; ++e)
				place.setIncidence(e, entries[e]);
		}

		/// before: the lists, in force or not. False where the host must: no room, or a grain out of reach. cell: of the next step.
		HWY_INLINE bool build(const double* cell, const Gradients<Dim>& l, double leastSkin)
		{
			together(threads, [&](int t) TALIK_INLINED {
				bool moves = false;
				TALIK_UNROLL for (int k = 0; k < Dim * Dim; ++k) moves |= l.now[k] != 0 || l.next[k] != 0;
				const double strained = ListSkins::stepsOfLists * call.dt * call.largestRadius * (moves ? call.strainRate : 0.);
				const double least = ListSkins::leastOverRadius * call.meanRadius, largest = ListSkins::largestOverRadius * call.meanRadius;
				const double wanted = strained < least ? least : strained, bounded = wanted < largest ? wanted : largest;
				const double skin = bounded < leastSkin ? leastSkin : bounded;
				double       inverse[Dim * Dim];
				invert(cell, inverse);
				for (int g = t; g < call.grains; g += threads)
					wrap(g, cell, inverse, skin, l.now);
				if (t == 0) fixed.skin = skin;
			});
			together(threads, [&](int t) TALIK_INLINED {
				double        inverse[Dim * Dim];
				float         widths[Dim]; // distance of opposite sides, inverted
				std::uint32_t none[2] = { 0, 0 };
				invert(cell, inverse);
				TALIK_UNROLL for (int d = 0; d < Dim; ++d)
				{
					double square = 0;
					TALIK_UNROLL for (int e = 0; e < Dim; ++e) square += inverse[d * Dim + e] * inverse[d * Dim + e];
					widths[d] = float(__builtin_sqrt(square)) * 1.00001f;
				}
				// each pair once: a grain with those that follow it, round and round
				const int grains = call.grains;
				for (int a = t, ahead = 1;; a += threads) {
					for (; a >= grains; a -= grains)
						++ahead;
					if (2 * ahead > grains) return;
					if (2 * ahead == grains && 2 * a >= grains) continue;
					const int b = a + ahead < grains ? a + ahead : a + ahead - grains;
					search(a < b ? a : b, a < b ? b : a, cell, widths, none);
				}
			});
			int  inner = int(fixed.found[0]), crossing = int(fixed.found[1]);
			bool fits = inner + crossing <= most;
			if (!fits) inner = crossing = 0;
			together(threads, [&](int t) TALIK_INLINED {
				for (int p = t; p < call.pairs; p += threads)
					former[p] = formerKey(p);
				sort(t, inner, crossing);
			});
			if constexpr (Bonded) { // a bond stays whatever its distance
				together(threads, [&](int t) TALIK_INLINED {
					for (int p = t; fits && p < call.pairs; p += threads) {
						if (!place.iceBond(p).hasIceSpring()) continue;
						const bool crosses = p >= call.inside;
						if (placeOf(sorted, crosses ? inner : 0, crosses ? inner + crossing : inner, former[p]) < 0)
							add(fixed.kept, fixed.found, Pair(former[p]));
					}
				});
				const int keptInner = int(fixed.kept[0]), keptCrossing = int(fixed.kept[1]);
				fits = fits && inner + crossing + keptInner + keptCrossing <= most;
				if (fits && keptInner + keptCrossing > 0) {
					inner += keptInner;
					crossing += keptCrossing;
					together(threads, [&](int t) TALIK_INLINED { sort(t, inner, crossing); });
				}
			}
			findImages(inner, crossing);
			const int images = int(fixed.images);
			if (!fits || fixed.noLists || images > mostImages) return false;
			adopt(inner, crossing, images);
			return true;
		}

		/// Cells that pairs reach across, in their order.
		HWY_INLINE void findImages(int inner, int crossing)
		{
			together(threads, [&](int t) TALIK_INLINED {
				for (int k = t; k < crossing; k += threads)
					cellsOf[k] = Pair(sorted[inner + k]).cells;
			});
			together(threads, [&](int t) TALIK_INLINED {
				for (int k = t; k < crossing; k += threads) {
					bool first = true;
					for (int l = 0; first && l < k; ++l)
						first = cellsOf[l] != cellsOf[k];
					isFirst[k] = first;
					if (first) countUp(fixed.images);
				}
			});
			together(threads, [&](int t) TALIK_INLINED {
				if (t == 0 && crossing == 0)
					for (int d = 0; d < Dim; ++d)
						fixed.cells[d] = 0;
				for (int k = t; k < crossing; k += threads) {
					if (!isFirst[k]) continue;
					int rank = 0;
					for (int l = 0; l < crossing; ++l)
						rank += isFirst[l] && Pair::ordered(cellsOf[l]) < Pair::ordered(cellsOf[k]);
					for (int d = 0; rank < mostImages && d < Dim; ++d)
						fixed.cells[Dim * rank + d] = std::int8_t(Pair::cell(cellsOf[k], d));
				}
			});
		}

		/// The new lists in place of the former ones.
		HWY_INLINE void adopt(int inner, int crossing, int images)
		{
			const int                                pairs = inner + crossing;
			Own<History, mostPairsEach, mostThreads> history;
			together(threads, [&](int t) TALIK_INLINED {
				TALIK_UNROLL for (int k = 0; k < mostPairsEach; ++k)
				{
					const int p = k * threads + t;
					if (p >= pairs) continue;
					const bool crosses = p >= inner;
					history(t, k) = historyOf(placeOf(former, crosses ? call.inside : 0, crosses ? call.pairs : call.inside, sorted[p]));
				}
			});
			together(threads, [&](int t) TALIK_INLINED {
				for (int g = t; g < call.grains; g += threads)
					ends[g] = 0;
				TALIK_UNROLL for (int k = 0; k < mostPairsEach; ++k)
				{
					const int p = k * threads + t;
					if (p < pairs) write(p, sorted[p], history(t, k), images);
				}
			});
			together(threads, [&](int t) TALIK_INLINED {
				for (int p = t; p < pairs; p += threads) {
					countUp(ends[place.index(p) & 0xfff]);
					countUp(ends[place.index(p) >> 12 & 0xfff]);
				}
			});
			together(threads, [&](int t) TALIK_INLINED {
				for (int g = t; g <= call.grains; g += threads) {
					std::uint32_t before = 0;
					for (int k = 0; k < g; ++k)
						before += ends[k];
					place.setStart(g, std::uint16_t(before));
					if (g < call.grains) next[g] = before;
				}
			});
			together(threads, [&](int t) TALIK_INLINED {
				for (int p = t; p < pairs; p += threads) {
					entries[countUp(next[place.index(p) & 0xfff])]       = std::uint16_t(p);
					entries[countUp(next[place.index(p) >> 12 & 0xfff])] = std::uint16_t(p | 0x8000);
				}
			});
			together(threads, [&](int t) TALIK_INLINED {
				for (int g = t; g < call.grains; g += threads)
					orderPairsOf(g);
				const int rows = images > 0 ? images : 1;
				for (int k = t; k < Dim * rows; k += threads)
					place.setImage(k, fixed.cells[k]);
				if (t != 0) return;
				call.inside = inner;
				call.pairs  = pairs;
				call.images = rows;
				call.skin   = fixed.skin;
				++fixed.lists;
			});
		}

	public:
		/// Builds the lists of a sample that has been stored into its place, for the steps from the cell on. False where the host must.
		TALIK_CARD static __attribute__((noinline)) bool of(
		        const Shared<Dim>& s, const At& place, SampleCall& call, int threads, const double* cell, const Gradients<Dim>& l, double leastSkin)
		{
			return NewLists(s, place, call, threads).build(cell, l, leastSkin);
		}
	};

} // namespace N_ONE
} // namespace talik
