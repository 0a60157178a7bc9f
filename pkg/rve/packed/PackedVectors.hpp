// SPDX-License-Identifier: GPL-2.0-or-later
// Vectors of the fused step: rows of four numbers per grain to columns of one number of several grains, and back. As a header of
// Highway's it is read once for every kind of processor that the including file is compiled for. Vectors of four numbers are the longest
// that a block of pairs fills.
#if defined(TALIK_RVE_PACKEDVECTORS) == defined(HWY_TARGET_TOGGLE)
#ifdef TALIK_RVE_PACKEDVECTORS
#undef TALIK_RVE_PACKEDVECTORS
#else
#define TALIK_RVE_PACKEDVECTORS
#endif

#include <hwy/highway.h>
#include <pkg/icebond/ContactForces.hpp>
#include <pkg/rve/packed/PackedStepView.hpp>

// Functions that a loop is told to call are part of it.
#ifndef TALIK_INLINED
#define TALIK_INLINED __attribute__((always_inline))
#endif

HWY_BEFORE_NAMESPACE();
namespace talik {
namespace HWY_NAMESPACE {
	namespace {

		namespace hn = hwy::HWY_NAMESPACE;

		constexpr std::size_t laneCount = HWY_MIN(HWY_LANES(double), 4); ///< pairs or grains that are dealt with at once

#if HWY_TARGET == HWY_SCALAR
		using Many = double;
		HWY_INLINE Many splat(double value) { return value; }
		HWY_INLINE Many load(const double* from) { return *from; }
		HWY_INLINE void store(Many value, double* to) { *to = value; }
#else
		using Lanes = hn::CappedTag<double, laneCount>;
		using Many  = hn::Vec<Lanes>;
		constexpr Lanes lanes;
		HWY_INLINE Many splat(double value) { return hn::Set(lanes, value); }
		HWY_INLINE Many load(const double* from) { return hn::Load(lanes, from); }
		HWY_INLINE void store(Many value, double* to) { hn::Store(value, lanes, to); }
#endif

		/// A vector that is kept in memory between two stages of a loop. Compilers copy structures of vectors, and not always as they were stored.
		struct alignas(32) Kept {
			double          number[laneCount];
			HWY_INLINE Many operator()() const { return load(number); }
			HWY_INLINE void operator=(Many value) { store(value, number); }
		};

		/// Four numbers of laneCount grains, each in a vector of its own.
		struct Columns {
			Many a, b, c, d;
		};

		/// Rows (a b c d) of laneCount grains in four vectors: part k holds numbers from (k laneCount) % 4 of row k laneCount/4.
		struct Rows {
			Many                         part[4];
			static constexpr std::size_t row(std::size_t k) { return k * laneCount / 4; }
			static constexpr std::size_t at(std::size_t k) { return k * laneCount % 4; }
		};

		// Row numbers times four serve as offsets: a row of four numbers is at base + offset, a single number at base + offset / 4.
		HWY_INLINE const double* singleAt(const double* base, std::uint32_t offset)
		{
			return reinterpret_cast<const double*>(reinterpret_cast<const char*>(base) + 2 * std::size_t(offset));
		}
#if HWY_TARGET == HWY_SCALAR
		HWY_INLINE Columns columnsOf(const Rows& r) { return { r.part[0], r.part[1], r.part[2], r.part[3] }; }
		HWY_INLINE Rows    rowsOf(const Columns& c) { return { { c.a, c.b, c.c, c.d } }; }
		HWY_INLINE Many    sumOfSingles(const double* base, const std::uint32_t* a, const std::uint32_t* b)
		{
			return *singleAt(base, *a) + *singleAt(base, *b);
		}
		HWY_INLINE Many singles(const double* base, const std::uint32_t* a) { return *singleAt(base, *a); }
#else
		using Pair = hn::CappedTag<double, 2>;
		using Two  = hn::Vec<Pair>;
		HWY_INLINE Two singlePair(const double* base, const std::uint32_t* offset)
		{
			return hn::InterleaveLower(Pair(), hn::Set(Pair(), *singleAt(base, offset[0])), hn::Set(Pair(), *singleAt(base, offset[1])));
		}
#endif

#if HWY_MAX_BYTES == 16 && HWY_TARGET != HWY_SCALAR
		HWY_INLINE Columns columnsOf(const Rows& r)
		{
			return { hn::InterleaveLower(lanes, r.part[0], r.part[2]), hn::InterleaveUpper(lanes, r.part[0], r.part[2]),
				 hn::InterleaveLower(lanes, r.part[1], r.part[3]), hn::InterleaveUpper(lanes, r.part[1], r.part[3]) };
		}
		HWY_INLINE Rows rowsOf(const Columns& c)
		{
			return { { hn::InterleaveLower(lanes, c.a, c.b), hn::InterleaveLower(lanes, c.c, c.d), hn::InterleaveUpper(lanes, c.a, c.b),
				   hn::InterleaveUpper(lanes, c.c, c.d) } };
		}
		HWY_INLINE Many sumOfSingles(const double* base, const std::uint32_t* a, const std::uint32_t* b)
		{
			return Add(singlePair(base, a), singlePair(base, b));
		}
		HWY_INLINE Many singles(const double* base, const std::uint32_t* a) { return singlePair(base, a); }
#elif HWY_MAX_BYTES >= 32
		HWY_INLINE Columns transposed(Many r0, Many r1, Many r2, Many r3)
		{
			const Many low01 = hn::InterleaveLower(lanes, r0, r1), high01 = hn::InterleaveUpper(lanes, r0, r1);
			const Many low23 = hn::InterleaveLower(lanes, r2, r3), high23 = hn::InterleaveUpper(lanes, r2, r3);
			return { hn::ConcatLowerLower(lanes, low23, low01), hn::ConcatLowerLower(lanes, high23, high01),
				 hn::ConcatUpperUpper(lanes, low23, low01), hn::ConcatUpperUpper(lanes, high23, high01) };
		}
		HWY_INLINE Columns columnsOf(const Rows& r) { return transposed(r.part[0], r.part[1], r.part[2], r.part[3]); }
		HWY_INLINE Rows    rowsOf(const Columns& c)
		{
			const Columns t = transposed(c.a, c.b, c.c, c.d);
			return { { t.a, t.b, t.c, t.d } };
		}
		HWY_INLINE Many sumOfSingles(const double* base, const std::uint32_t* a, const std::uint32_t* b)
		{
			const Two low = Add(singlePair(base, a), singlePair(base, b)), high = Add(singlePair(base, a + 2), singlePair(base, b + 2));
			return hn::Combine(lanes, high, low);
		}
		HWY_INLINE Many singles(const double* base, const std::uint32_t* a) { return hn::Combine(lanes, singlePair(base, a + 2), singlePair(base, a)); }
#endif

		/// Calls it for the four parts of some rows. Compilers keep arrays in registers only where no loop runs over them.
		template <class Visitor> HWY_INLINE void forParts(Visitor visit)
		{
			visit(0);
			visit(1);
			visit(2);
			visit(3);
		}

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
			HWY_INLINE const std::uint32_t* shift() const { return pairs.shift + 4 * block + lane; }
		};

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
			const std::size_t end = 4 / laneCount * pairs.blocks;
			if (end == 0) return;
			const auto  place = [&](std::size_t k) HWY_ATTR { return Place<Dim> { pairs, k / (4 / laneCount), k % (4 / laneCount) * laneCount }; };
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
			constexpr std::size_t chunk = 12;
			const std::size_t     end   = 4 / laneCount * pairs.blocks;
			Gathered              gathered[chunk];
			Moved                 moved[chunk];
			Response              responses[chunk];
			bool                  idle[chunk];
			const auto place = [&](std::size_t k) HWY_ATTR { return Place<Dim> { pairs, k / (4 / laneCount), k % (4 / laneCount) * laneCount }; };
			for (std::size_t from = 0; from < end; from += chunk) {
				const std::size_t count = HWY_MIN(chunk, end - from);
				for (std::size_t k = 0; k < count; ++k)
					gather(place(from + k), gathered[k]);
				for (std::size_t k = 0; k < count; ++k)
					if (!(idle[k] = passedOver<Bonded, Rolling>(place(from + k), gathered[k].distance())))
						move(place(from + k), gathered[k], moved[k]);
				for (std::size_t k = 0; k < count; ++k)
					if (!idle[k]) respond(place(from + k), gathered[k], moved[k], responses[k]);
				for (std::size_t k = 0; k < count; ++k)
					if (!idle[k]) scatter(place(from + k), gathered[k], responses[k]);
			}
		}

		/// Acceleration times 1 - damping sign(acceleration (velocity + dt/2 acceleration)).
		HWY_INLINE Many damped(Many acceleration, Many velocity, Many damping, Many halfStep)
		{
			const Many power = Mul(acceleration, MulAdd(halfStep, acceleration, velocity));
			return NegMulAdd(CopySignToAbs(damping, power), acceleration, acceleration);
		}

		/// Columns of four numbers of rows that are Stride numbers apart; Clear: zero is left where they were.
		template <bool Clear, int Stride> HWY_INLINE Columns takeColumns(double* from)
		{
			Rows rows;
			forParts([&](std::size_t k) HWY_ATTR TALIK_INLINED {
				double* at   = from + Stride * Rows::row(k) + Rows::at(k);
				rows.part[k] = load(at);
				if (Clear) store(splat(0.), at);
			});
			return columnsOf(rows);
		}

		/// The way back.
		template <int Stride> HWY_INLINE void putColumns(const Columns& columns, double* to)
		{
			const Rows rows = rowsOf(columns);
			forParts([&](std::size_t k) HWY_ATTR TALIK_INLINED { store(rows.part[k], to + Stride * Rows::row(k) + Rows::at(k)); });
		}

		/// Numbers of four neighbouring grains; sums over grains are kept by place in the four, so that all vectors give the same sums.
		struct Quad {
			static constexpr std::size_t parts = 4 / laneCount;
			Many                         part[parts];
			HWY_INLINE                   Quad()
			{
				for (Many& p : part)
					p = splat(0.);
			}
			HWY_INLINE void numbers(double* four) const
			{
				for (std::size_t k = 0; k < parts; ++k)
					store(part[k], four + k * laneCount);
			}
			HWY_INLINE double sum() const
			{
				alignas(32) double n[4];
				numbers(n);
				return (n[0] + n[1]) + (n[2] + n[3]);
			}
			HWY_INLINE double largest() const
			{
				alignas(32) double n[4];
				numbers(n);
				double most = 0;
				for (const double number : n)
					most = number > most ? number : most;
				return most;
			}
		};

		/// Functions of a kernel from the loops of discs or spheres: contacts<Bonded, Rolling, Moments, Periodic>(view, pairs) and
		/// integrate<Jumps, Stress>(view).
		template <int Dim, class Loops> struct KernelOf {
			using View = PackedStepView<Dim>;
			template <bool Bonded, bool Rolling, bool Moments = false> static void contacts(View* view)
			{
				Loops::template contacts<Bonded, Rolling, Moments, false>(*view, view->inner);
				Loops::template contacts<Bonded, Rolling, Moments, true>(*view, view->periodic);
			}
			template <bool Stress> static void integrateWith(View& view)
			{
				view.jumps() ? Loops::template integrate<true, Stress>(view) : Loops::template integrate<false, Stress>(view);
			}
			static void              integrate(View* view) { view->sampleStress ? integrateWith<true>(*view) : integrateWith<false>(*view); }
			static PackedKernel<Dim> chosen(PackedContactKind kind)
			{
				auto* const free    = kind.moments ? contacts<true, false, true> : kind.bonded ? contacts<true, false> : contacts<false, false>;
				auto* const rolling = kind.moments ? contacts<true, true, true> : kind.bonded ? contacts<true, true> : contacts<false, true>;
				return { kind.rolling ? rolling : free, integrate, hwy::TargetName(HWY_TARGET) };
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
