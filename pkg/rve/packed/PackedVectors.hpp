// SPDX-License-Identifier: GPL-2.0-or-later
// Vectors of the fused step: rows of four numbers per grain to columns of one number of several grains, and back. As a header of
// Highway's it is read once for every kind of processor that the including file is compiled for. No vector is longer than a block of
// pairs.
#if defined(TALIK_RVE_PACKEDVECTORS) == defined(HWY_TARGET_TOGGLE)
#ifdef TALIK_RVE_PACKEDVECTORS
#undef TALIK_RVE_PACKEDVECTORS
#else
#define TALIK_RVE_PACKEDVECTORS
#endif

#include <hwy/highway.h>
#include <pkg/icebond/ContactForces.hpp>
#include <pkg/rve/packed/PackedStepView.hpp>
#include <utility>

// Functions that a loop is told to call are part of it.
#ifndef TALIK_INLINED
#define TALIK_INLINED __attribute__((always_inline))
#endif

HWY_BEFORE_NAMESPACE();
namespace talik {
namespace HWY_NAMESPACE {
	namespace {

		namespace hn = hwy::HWY_NAMESPACE;

		/// Pairs or grains that are dealt with at once. Eight only on processors that do not slow down for them: Ice Lake, Zen 4 and later.
		constexpr std::size_t laneCount = HWY_MIN(HWY_LANES(double), HWY_TARGET <= HWY_AVX3_DL ? packedWidth : 4);

#if HWY_TARGET == HWY_SCALAR
		template <std::size_t> using Some = double;
		using Many                        = double;
		HWY_INLINE Many                              splat(double value) { return value; }
		template <std::size_t = 1> HWY_INLINE double load(const double* from) { return *from; }
		HWY_INLINE void                              store(Many value, double* to) { *to = value; }
#else
		template <std::size_t Count> using Some = hn::Vec<hn::CappedTag<double, Count>>;
		using Lanes                             = hn::CappedTag<double, laneCount>;
		using Many                              = Some<laneCount>;
		constexpr Lanes                                     lanes;
		HWY_INLINE Many                                     splat(double value) { return hn::Set(lanes, value); }
		template <std::size_t Count = laneCount> HWY_INLINE Some<Count> load(const double* from)
		{
			return hn::Load(hn::CappedTag<double, Count>(), from);
		}
		template <class Vector> HWY_INLINE void store(Vector value, double* to) { hn::Store(value, hn::DFromV<Vector>(), to); }
		HWY_INLINE auto                         lowerHalf(Many v) { return hn::LowerHalf(hn::Half<Lanes>(), v); }
		HWY_INLINE auto                         upperHalf(Many v) { return hn::UpperHalf(hn::Half<Lanes>(), v); }
#endif

		/// Calls it for 0 to Count - 1. Compilers keep arrays in registers only where no loop runs over them.
		template <class Visitor, std::size_t... K> HWY_INLINE void  forEach(Visitor visit, std::index_sequence<K...>) { (visit(K), ...); }
		template <std::size_t Count, class Visitor> HWY_INLINE void forEach(Visitor visit) { forEach(visit, std::make_index_sequence<Count>()); }

		/// A vector that is kept in memory between two stages of a loop. Compilers copy structures of vectors, and not always as they were stored.
		struct alignas(laneCount * sizeof(double)) Kept {
			double          number[laneCount];
			HWY_INLINE Many operator()() const { return load(number); }
			HWY_INLINE void operator=(Many value) { store(value, number); }
		};

		/// Rows of four or eight numbers of laneCount grains, each in one vector or in several parts.
		template <std::size_t Length> struct Rows {
			static constexpr std::size_t size = HWY_MIN(laneCount, Length), parts = Length / size;
			Some<size>                   part[laneCount * parts];
			/// Parts of a row from numbers in memory: of(numbers) for each.
			template <class Of> HWY_INLINE void setRow(std::size_t row, Of of)
			{
				forEach<parts>([&](std::size_t k) HWY_ATTR TALIK_INLINED { part[row * parts + k] = of(k * size); });
			}
			/// Calls visit(part, where it begins) for the parts of a row.
			template <class Visitor> HWY_INLINE void forRow(std::size_t row, Visitor visit) const
			{
				forEach<parts>([&](std::size_t k) HWY_ATTR TALIK_INLINED { visit(part[row * parts + k], k * size); });
			}
			static HWY_INLINE auto numbers(const double* from) { return load<size>(from); }
		};
		constexpr std::size_t                    inRow = HWY_MAX(laneCount, 4); ///< numbers of a row that are dealt with at once
		template <class Visitor> HWY_INLINE void forRows(Visitor visit) { forEach<laneCount>(visit); }

		template <class Vector> struct Four {
			Vector a, b, c, d;
		};
		/// Numbers of the rows, each in a vector of its own.
		using Columns = Four<Many>;
		struct EightColumns {
			Columns low, high;
		};

		/// The row of a grain, of Length numbers, where the offset is that of its longest row.
		template <int Dim, std::size_t Length> HWY_INLINE double* rowAt(double* base, std::uint32_t offset)
		{
			return reinterpret_cast<double*>(
			        reinterpret_cast<char*>(base) + Length * sizeof(double) / PackedLayout<Dim>::row * std::size_t(offset));
		}

#if HWY_TARGET == HWY_SCALAR
		HWY_INLINE Columns columnsOf(const Rows<4>& r) { return { r.part[0], r.part[1], r.part[2], r.part[3] }; }
		HWY_INLINE Rows<4> rowsOf(const Columns& c) { return { { c.a, c.b, c.c, c.d } }; }
		HWY_INLINE double  singles(double* base, const std::uint32_t* a) { return *rowAt<2, 1>(base, *a); }
		HWY_INLINE double  sumOfSingles(double* base, const std::uint32_t* a, const std::uint32_t* b) { return singles(base, a) + singles(base, b); }
#else
		/// Single numbers of discs, and the sums of two.
		template <std::size_t Count = laneCount> HWY_INLINE Some<Count> singles(double* base, const std::uint32_t* a)
		{
			constexpr hn::CappedTag<double, Count> all;
			constexpr std::size_t                  half = Count / 2;
			if constexpr (Count == 2)
				return hn::InterleaveLower(all, hn::Set(all, *rowAt<2, 1>(base, a[0])), hn::Set(all, *rowAt<2, 1>(base, a[1])));
			else return hn::Combine(all, singles<half>(base, a + half), singles<half>(base, a));
		}
		template <std::size_t Count = laneCount> HWY_INLINE Some<Count> sumOfSingles(double* base, const std::uint32_t* a, const std::uint32_t* b)
		{
			constexpr std::size_t half = Count / 2;
			if constexpr (Count == 2) return Add(singles<2>(base, a), singles<2>(base, b));
			else return hn::Combine(hn::CappedTag<double, Count>(), sumOfSingles<half>(base, a + half, b + half), sumOfSingles<half>(base, a, b));
		}
#endif

#if HWY_MAX_BYTES == 16 && HWY_TARGET != HWY_SCALAR
		HWY_INLINE Columns columnsOf(const Rows<4>& r)
		{
			return { hn::InterleaveLower(lanes, r.part[0], r.part[2]), hn::InterleaveUpper(lanes, r.part[0], r.part[2]),
				 hn::InterleaveLower(lanes, r.part[1], r.part[3]), hn::InterleaveUpper(lanes, r.part[1], r.part[3]) };
		}
		HWY_INLINE Rows<4> rowsOf(const Columns& c)
		{
			return { { hn::InterleaveLower(lanes, c.a, c.b), hn::InterleaveLower(lanes, c.c, c.d), hn::InterleaveUpper(lanes, c.a, c.b),
				   hn::InterleaveUpper(lanes, c.c, c.d) } };
		}
#elif HWY_MAX_BYTES >= 32
		/// Every second block of two numbers, of a and then of b: from the first one on, or from the second one on.
		template <class Vector> HWY_INLINE Vector evenBlocks(Vector a, Vector b) { return hn::ConcatLowerLower(hn::DFromV<Vector>(), b, a); }
		template <class Vector> HWY_INLINE Vector oddBlocks(Vector a, Vector b) { return hn::ConcatUpperUpper(hn::DFromV<Vector>(), b, a); }
#if HWY_TARGET <= HWY_AVX3_DL
		HWY_INLINE Many                           evenBlocks(Many a, Many b) { return Many { _mm512_shuffle_f64x2(a.raw, b.raw, 0x88) }; }
		HWY_INLINE Many                           oddBlocks(Many a, Many b) { return Many { _mm512_shuffle_f64x2(a.raw, b.raw, 0xDD) }; }
#endif
		template <class Vector> HWY_INLINE Four<Vector> transposed(Vector r0, Vector r1, Vector r2, Vector r3)
		{
			constexpr hn::DFromV<Vector> all;
			const Vector                 low01 = hn::InterleaveLower(all, r0, r1), high01 = hn::InterleaveUpper(all, r0, r1);
			const Vector                 low23 = hn::InterleaveLower(all, r2, r3), high23 = hn::InterleaveUpper(all, r2, r3);
			return { evenBlocks(low01, low23), evenBlocks(high01, high23), oddBlocks(low01, low23), oddBlocks(high01, high23) };
		}
#endif
#if HWY_TARGET <= HWY_AVX3_DL
		HWY_INLINE Columns columnsOf(const Rows<4>& r)
		{
			const auto both = [&](std::size_t k) HWY_ATTR TALIK_INLINED { return hn::Combine(lanes, r.part[k + 2], r.part[k]); };
			return transposed(both(0), both(1), both(4), both(5));
		}
		HWY_INLINE Rows<4> rowsOf(const Columns& c)
		{
			const auto low  = transposed(lowerHalf(c.a), lowerHalf(c.b), lowerHalf(c.c), lowerHalf(c.d));
			const auto high = transposed(upperHalf(c.a), upperHalf(c.b), upperHalf(c.c), upperHalf(c.d));
			return { { low.a, low.b, low.c, low.d, high.a, high.b, high.c, high.d } };
		}
		/// Eight vectors of eight numbers, rows to columns or back.
		HWY_INLINE EightColumns transposed(const Columns& r, const Columns& s)
		{
			const Columns t = transposed(r.a, r.b, r.c, r.d), u = transposed(s.a, s.b, s.c, s.d);
			return { { evenBlocks(t.a, u.a), evenBlocks(t.b, u.b), evenBlocks(t.c, u.c), evenBlocks(t.d, u.d) },
				 { oddBlocks(t.a, u.a), oddBlocks(t.b, u.b), oddBlocks(t.c, u.c), oddBlocks(t.d, u.d) } };
		}
		HWY_INLINE EightColumns columnsOf(const Rows<8>& r)
		{
			return transposed({ r.part[0], r.part[1], r.part[2], r.part[3] }, { r.part[4], r.part[5], r.part[6], r.part[7] });
		}
		HWY_INLINE Rows<8> rowsOf(const EightColumns& c)
		{
			const EightColumns r = transposed(c.low, c.high);
			return { { r.low.a, r.low.b, r.low.c, r.low.d, r.high.a, r.high.b, r.high.c, r.high.d } };
		}
#elif HWY_MAX_BYTES >= 32
		HWY_INLINE Columns columnsOf(const Rows<4>& r) { return transposed(r.part[0], r.part[1], r.part[2], r.part[3]); }
		HWY_INLINE Rows<4> rowsOf(const Columns& c)
		{
			const Columns r = transposed(c.a, c.b, c.c, c.d);
			return { { r.a, r.b, r.c, r.d } };
		}
#endif

		constexpr std::size_t perBlock = packedWidth / laneCount; ///< places of a block

		/// Some pairs of a block.
		template <int Dim> struct Place {
			const PackedPairs<Dim>& pairs;
			std::size_t             block, lane;
			HWY_INLINE PackedBlock<Dim>& pair() const { return pairs.block[block]; }
			HWY_INLINE PackedIceBlock<Dim>& ice() const { return pairs.ice[block]; }
			HWY_INLINE PackedRollingBlock<Dim>& rolling() const { return pairs.rolling[block]; }
			HWY_INLINE PackedMomentBlock<Dim>& moments() const { return pairs.moments[block]; }
			HWY_INLINE const std::uint32_t* first() const { return pair().first + lane; }
			HWY_INLINE const std::uint32_t* second() const { return pair().second + lane; }
			HWY_INLINE const std::uint32_t* shift() const { return pairs.shift + packedWidth * block + lane; }
		};

		constexpr bool passesOver = HWY_TARGET == HWY_SCALAR; ///< vectors pass over no pair

		/// Response of some pairs at their overlap, and what a shear increment goes by.
		template <bool Hertz, int Dim> HWY_INLINE ContactResponse<Many> bondedResponse(const Place<Dim>& p, Many overlap)
		{
			const PackedIceBlock<Dim>& ice = p.ice();
			return responseAt<Hertz>(
			        ContactResponse<Many> { load(p.pair().stiffness + p.lane), load(ice.offset + p.lane), load(ice.floor + p.lane),
			                                load(ice.cohesion + p.lane), load(ice.iceShare + p.lane) },
			        overlap);
		}
		template <bool Hertz, bool Bonded, int Dim> HWY_INLINE Many tangentOf(const Place<Dim>& p, Many overlap)
		{
			const Many tangent = grainTangent<Hertz>(load(p.pair().stiffness + p.lane), overlap);
			if constexpr (Hertz && Bonded) return Add(tangent, load(p.ice().iceShare + p.lane));
			else return tangent;
		}

		/// True for a pair on its own that neither touches nor is bonded; it carries no force then.
		template <bool Bonded, bool Rolling, int Dim> HWY_INLINE bool passedOver(const Place<Dim>& p, Many distance)
		{
#if HWY_TARGET == HWY_SCALAR
			if (!(distance > p.pair().sumRadius[p.lane]) || (Bonded && p.ice().floor[p.lane] != 0)) return false;
			for (auto& component : p.pair().shear)
				component[p.lane] = 0;
			if constexpr (Rolling)
				for (auto& component : p.rolling().moment)
					component[p.lane] = 0;
			return true;
#else
			(void)p, (void)distance;
			return false;
#endif
		}

		// The next pairs are gathered, and their square roots and quotients started, before the law and the sums of the present ones: the
		// long latencies then run under work that does not need them.
		template <int Dim, class Gather, class Finish> HWY_INLINE void inPipeline(const PackedPairs<Dim>& pairs, Gather gather, Finish finish)
		{
			const std::size_t end = perBlock * pairs.blocks;
			if (end == 0) return;
			const auto  place   = [&](std::size_t k) HWY_ATTR { return Place<Dim> { pairs, k / perBlock, k % perBlock * laneCount }; };
			auto        present = gather(place(0));
			std::size_t k       = 0;
			for (; k + 2 < end; k += 2) {
				const auto next = gather(place(k + 1));
				finish(place(k), present);
				present = gather(place(k + 2));
				finish(place(k + 1), next);
			}
			if (k + 1 < end) {
				const auto last = gather(place(k + 1));
				finish(place(k), present);
				finish(place(k + 1), last);
			} else {
				finish(place(k), present);
			}
		}

		/// The same for work that is too long for two places to be under way at once: each stage is done for a few places before the next
		/// one begins.
		template <
		        class Gathered, class Moved, class Response, bool Bonded, bool Rolling, int Dim, class Gather, class Move, class Respond, class Scatter>
		HWY_INLINE void inStages(const PackedPairs<Dim>& pairs, Gather gather, Move move, Respond respond, Scatter scatter)
		{
			constexpr std::size_t chunk = HWY_MAX(6 / perBlock, 1); // blocks: twice as many no longer stay in the first cache beside the rows
			Gathered              gathered[chunk * perBlock];
			Moved                 moved[chunk * perBlock];
			Response              responses[chunk * perBlock];
			bool                  idle[passesOver ? chunk * perBlock : 1];
			for (std::size_t from = 0; from < pairs.blocks; from += chunk) {
				const auto forPlaces = [&](auto visit) HWY_ATTR TALIK_INLINED {
					std::size_t k = 0;
					for (std::size_t block = from; block < HWY_MIN(from + chunk, pairs.blocks); ++block)
#pragma GCC unroll 2
						for (std::size_t lane = 0; lane < packedWidth; lane += laneCount, ++k)
							visit(Place<Dim> { pairs, block, lane }, k);
				};
				forPlaces([&](const Place<Dim>& p, std::size_t k) HWY_ATTR TALIK_INLINED { gather(p, gathered[k]); });
				forPlaces([&](const Place<Dim>& p, std::size_t k) HWY_ATTR TALIK_INLINED {
					if (!passesOver || !(idle[k] = passedOver<Bonded, Rolling>(p, gathered[k].distance()))) move(p, gathered[k], moved[k]);
				});
				forPlaces([&](const Place<Dim>& p, std::size_t k) HWY_ATTR TALIK_INLINED {
					if (!passesOver || !idle[k]) respond(p, gathered[k], moved[k], responses[k]);
				});
				forPlaces([&](const Place<Dim>& p, std::size_t k) HWY_ATTR TALIK_INLINED {
					if (!passesOver || !idle[k]) scatter(p, gathered[k], responses[k]);
				});
			}
		}

		/// Numbers of vectors in space, component by component, of pairs of a block from `lane` on.
		HWY_INLINE InSpace<Many> loadVector(const double (&rows)[3][packedWidth], std::size_t lane)
		{
			return { load(rows[0] + lane), load(rows[1] + lane), load(rows[2] + lane) };
		}
		HWY_INLINE void storeVector(const InSpace<Many>& v, double (&rows)[3][packedWidth], std::size_t lane)
		{
			store(v.x, rows[0] + lane);
			store(v.y, rows[1] + lane);
			store(v.z, rows[2] + lane);
		}

		/// Shear forces of some pairs of discs or spheres, where the sample reads and writes that of one.
		template <int Dim> struct SettledShear {
			alignas(packedAlignment) double rows[PackedLayout<Dim>::shear][packedWidth];
			template <class Shear> explicit SettledShear(const Shear& shear)
			{
				if constexpr (Dim == 2) store(shear, rows[0]);
				else storeVector(shear, rows, 0);
			}
			auto all() const
			{
				if constexpr (Dim == 2) return load(rows[0]);
				else return loadVector(rows, 0);
			}
			auto operator[](std::size_t lane) const { return laneShear<Dim>(rows, lane); }
			void set(std::size_t lane, const typename PackedTypes<Dim>::Shear& shear) { setLaneShear<Dim>(rows, lane, shear); }
		};

		/// Hands the contacts that `failed` over to the sample, which settles them.
		template <int Dim, class Condition, class Forces>
		HWY_NOINLINE void reportBonds(PackedStepView<Dim>& view, int periodic, std::size_t lane, Condition failed, Forces& f)
		{
			alignas(packedAlignment) double reported[packedWidth], overlap[packedWidth], trialNormal[packedWidth], normal[packedWidth];
			store(IfThenElse(failed, splat(1.), splat(0.)), reported);
			store(f.overlap, overlap);
			store(f.trialNormal, trialNormal);
			store(f.normal, normal);
			const SettledShear<Dim> trialShear(f.trialShear), increment(f.increment);
			SettledShear<Dim>       shear(f.shear), iceShear(f.iceShear);
			for (std::size_t l = 0; l < laneCount; ++l) {
				if (reported[l] == 0) continue;
				PackedBondEvent<Dim> event { periodic,
					                     lane + l,
					                     { overlap[l], trialNormal[l], trialShear[l], increment[l], normal[l], shear[l], iceShear[l] } };
				view.bondEvent(view.owner, &event);
				normal[l] = event.forces.normal;
				shear.set(l, event.forces.shear);
				iceShear.set(l, event.forces.iceShear);
			}
			f.normal   = load(normal);
			f.shear    = shear.all();
			f.iceShear = iceShear.all();
		}

		/// What bondedForces calls. Forces get a copy to be reported: the address of those at hand would keep them in memory.
		template <int Dim, class Condition, class Forces>
		HWY_INLINE void settleBonds(PackedStepView<Dim>& view, int periodic, std::size_t lane, Condition failed, Forces& forces)
		{
			Forces reported = forces;
			reportBonds<Dim>(view, periodic, lane, failed, reported);
			forces = reported;
		}

		alignas(packedAlignment) static constexpr double zeros[packedWidth] = {};

#if HWY_TARGET <= HWY_AVX3_DL
		/// Numbers of both vectors, by their place in the first one, or in the second one from 8 on.
		template <long long... Places> HWY_INLINE Many permuted(Many a, Many b)
		{
			alignas(64) static constexpr long long places[8] = { Places... };
			return Many { _mm512_permutex2var_pd(a.raw, _mm512_load_si512(places), b.raw) };
		}
		/// Columns of eight rows of four numbers, one after another, two in a vector.
		HWY_INLINE Columns columnsOfRun(const Many (&rows)[4])
		{
			const Many firstAB = permuted<0, 4, 8, 12, 1, 5, 9, 13>(rows[0], rows[1]),
			           firstCD = permuted<2, 6, 10, 14, 3, 7, 11, 15>(rows[0], rows[1]);
			const Many lastAB  = permuted<0, 4, 8, 12, 1, 5, 9, 13>(rows[2], rows[3]),
			           lastCD  = permuted<2, 6, 10, 14, 3, 7, 11, 15>(rows[2], rows[3]);
			return { hn::ConcatLowerLower(lanes, lastAB, firstAB), hn::ConcatUpperUpper(lanes, lastAB, firstAB),
				 hn::ConcatLowerLower(lanes, lastCD, firstCD), hn::ConcatUpperUpper(lanes, lastCD, firstCD) };
		}
		/// The way back, into memory.
		HWY_INLINE void putRun(const Columns& c, double* to)
		{
			const Many firstAB = permuted<0, 8, 1, 9, 2, 10, 3, 11>(c.a, c.b), firstCD = permuted<0, 8, 1, 9, 2, 10, 3, 11>(c.c, c.d);
			const Many lastAB = permuted<4, 12, 5, 13, 6, 14, 7, 15>(c.a, c.b), lastCD = permuted<4, 12, 5, 13, 6, 14, 7, 15>(c.c, c.d);
			store(permuted<0, 1, 8, 9, 2, 3, 10, 11>(firstAB, firstCD), to);
			store(permuted<4, 5, 12, 13, 6, 7, 14, 15>(firstAB, firstCD), to + 8);
			store(permuted<0, 1, 8, 9, 2, 3, 10, 11>(lastAB, lastCD), to + 16);
			store(permuted<4, 5, 12, 13, 6, 7, 14, 15>(lastAB, lastCD), to + 24);
		}
#endif

		/// Columns of Length numbers of rows that are Row numbers apart; Clear: zero is left where they were.
		template <std::size_t Length, std::size_t Row, bool Clear = false> HWY_INLINE auto takeColumns(double* from)
		{
			if constexpr (Length > inRow) {
				return EightColumns { takeColumns<4, Row, Clear>(from), takeColumns<4, Row, Clear>(from + 4) };
#if HWY_TARGET <= HWY_AVX3_DL
			} else if constexpr (Row == 4) {
				const Many rows[4] = { load(from), load(from + 8), load(from + 16), load(from + 24) };
				forEach<4>([&](std::size_t k) HWY_ATTR TALIK_INLINED {
					if (Clear) store(load(zeros), from + 8 * k);
				});
				return columnsOfRun(rows);
#endif
			} else {
				Rows<Length> rows;
				forRows([&](std::size_t l) HWY_ATTR TALIK_INLINED {
					rows.setRow(l, [&](std::size_t at) HWY_ATTR TALIK_INLINED {
						const auto taken = rows.numbers(from + Row * l + at);
						if (Clear) store(rows.numbers(zeros), from + Row * l + at);
						return taken;
					});
				});
				return columnsOf(rows);
			}
		}

		template <std::size_t Row, class SomeRows> HWY_INLINE void putRows(const SomeRows& rows, double* to)
		{
			forRows([&](std::size_t l) HWY_ATTR TALIK_INLINED {
				rows.forRow(l, [&](auto part, std::size_t at) HWY_ATTR TALIK_INLINED { store(part, to + Row * l + at); });
			});
		}
		/// The way back.
#if HWY_TARGET <= HWY_AVX3_DL
		template <std::size_t Row> HWY_INLINE void putColumns(const Columns& columns, double* to)
		{
			static_assert(Row == 4, "rows of four numbers are one after another");
			putRun(columns, to);
		}
		template <std::size_t Row> HWY_INLINE void putColumns(const EightColumns& columns, double* to) { putRows<Row>(rowsOf(columns), to); }
#else
		template <std::size_t Row> HWY_INLINE void putColumns(const Columns& columns, double* to) { putRows<Row>(rowsOf(columns), to); }
		template <std::size_t Row> HWY_INLINE void putColumns(const EightColumns& columns, double* to)
		{
			putColumns<Row>(columns.low, to);
			putColumns<Row>(columns.high, to + 4);
		}
#endif

		/// A sum over grains, kept by place in four neighbouring ones, so that all vectors give the same.
		struct Quad {
			static constexpr std::size_t size = HWY_MIN(laneCount, 4);
			Some<size>                   part[4 / size];
			HWY_INLINE                   Quad()
			{
				for (auto& p : part)
					p = load<size>(zeros);
			}
			/// Adds a b of the grains from one on.
			HWY_INLINE void add(std::size_t grain, Many a, Many b)
			{
				auto& p = part[grain % 4 / size];
#if HWY_TARGET <= HWY_AVX3_DL
				p = MulAdd(upperHalf(a), upperHalf(b), MulAdd(lowerHalf(a), lowerHalf(b), p));
#else
				p = MulAdd(a, b, p);
#endif
			}
			HWY_INLINE double sum() const
			{
				alignas(32) double n[4];
				for (std::size_t k = 0; k < 4; k += size)
					store(part[k / size], n + k);
				return (n[0] + n[1]) + (n[2] + n[3]);
			}
		};

		HWY_INLINE double largest(Many numbers)
		{
			alignas(packedAlignment) double n[laneCount];
			store(numbers, n);
			double most = 0;
			for (const double number : n)
				most = number > most ? number : most;
			return most;
		}

		/// Functions of a kernel from the loops of discs or spheres: contacts<Hertz, Bonded, Rolling, Moments, Periodic>(view, pairs) and
		/// integrate<Jumps, Stress>(view).
		template <int Dim, class Loops> struct KernelOf {
			using View = PackedStepView<Dim>;
			template <bool Hertz, bool Bonded, bool Rolling, bool Moments = false> static void contacts(View* view)
			{
				Loops::template contacts<Hertz, Bonded, Rolling, Moments, false>(*view, view->inner);
				Loops::template contacts<Hertz, Bonded, Rolling, Moments, true>(*view, view->periodic);
			}
			template <bool Hertz> static auto contactsOf(PackedContactKind kind)
			{
				auto* const free    = kind.moments ? contacts<Hertz, true, false, true>
				           : kind.bonded           ? contacts<Hertz, true, false>
				                                   : contacts<Hertz, false, false>;
				auto* const rolling = kind.moments ? contacts<Hertz, true, true, true>
				        : kind.bonded              ? contacts<Hertz, true, true>
				                                   : contacts<Hertz, false, true>;
				return kind.rolling ? rolling : free;
			}
			template <bool Stress> static void integrateWith(View& view)
			{
				view.jumps() ? Loops::template integrate<true, Stress>(view) : Loops::template integrate<false, Stress>(view);
			}
			static void              integrate(View* view) { view->sampleStress ? integrateWith<true>(*view) : integrateWith<false>(*view); }
			static PackedKernel<Dim> chosen(PackedContactKind kind)
			{
				return { kind.hertz ? contactsOf<true>(kind) : contactsOf<false>(kind), integrate, hwy::TargetName(HWY_TARGET) };
			}
		};

	} // namespace
} // namespace HWY_NAMESPACE
} // namespace talik
HWY_AFTER_NAMESPACE();

/// At the end of a source that HWY_TARGET_INCLUDE names: the kernels of a dimension, made by makeKernel(kind) in the namespace of each target.
#define TALIK_STEP_KERNEL(Dim, makeKernel)                                                                                           \
	namespace talik {                                                                                                            \
		HWY_EXPORT(makeKernel);                                                                                              \
		template <> PackedKernel<Dim> stepKernel<Dim>(PackedContactKind kind, bool portable)                                 \
		{                                                                                                                    \
			return portable ? HWY_STATIC_DISPATCH(makeKernel)(kind).portable() : HWY_DYNAMIC_DISPATCH(makeKernel)(kind); \
		}                                                                                                                    \
	}

#endif
