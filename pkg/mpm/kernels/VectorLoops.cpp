// SPDX-License-Identifier: GPL-2.0-or-later
// Compiled once for every kind of processor that Highway knows; the best version that the processor has is chosen when the program runs.
#undef HWY_DISABLED_TARGETS
#define HWY_DISABLED_TARGETS (HWY_SSSE3 | HWY_SVE | HWY_SVE2 | HWY_SVE_256 | HWY_SVE2_128 | HWY_RVV) // vectors in structures have a fixed length
#undef HWY_TARGET_INCLUDE
#define HWY_TARGET_INCLUDE "pkg/mpm/kernels/VectorLoops.cpp"
#include <hwy/foreach_target.h>

#include <cstdint>
#include <hwy/highway.h>
#include <pkg/mpm/kernels/NodeLoops.hpp>

HWY_BEFORE_NAMESPACE();
namespace talik {
namespace HWY_NAMESPACE {
	namespace {

		namespace hn = hwy::HWY_NAMESPACE;

		/// n neighbouring numbers of a record, 1, 2 or a multiple of 4, in vectors of four where the processor has them: longer ones gain nothing on
		/// processors that have one unit for them.
		template <int n> struct Numbers {
			using Tag                  = hn::CappedTag<double, HWY_MIN(n, 4)>;
			static constexpr int lanes = HWY_MIN(HWY_LANES(double), HWY_MIN(n, 4)), parts = n / lanes;
			hn::Vec<Tag>         part[parts];
		};

		template <> struct Numbers<1> {
			double part;
		};

		template <int n> HWY_INLINE void load(const double* from, Numbers<n>& q)
		{
			for (int i = 0; i < q.parts; ++i)
				q.part[i] = hn::LoadU(typename Numbers<n>::Tag(), from + i * q.lanes);
		}
		template <int n> HWY_INLINE void store(const Numbers<n>& q, double* to)
		{
			for (int i = 0; i < q.parts; ++i)
				hn::StoreU(q.part[i], typename Numbers<n>::Tag(), to + i * q.lanes);
		}
		template <int n> HWY_INLINE void clear(Numbers<n>& q)
		{
			for (auto& part : q.part)
				part = hn::Zero(typename Numbers<n>::Tag());
		}
		template <int n> HWY_INLINE Numbers<n> scaled(Numbers<n> q, double s)
		{
			for (auto& part : q.part)
				part = hn::Mul(part, hn::Set(typename Numbers<n>::Tag(), s));
			return q;
		}
		/// to + q s, rounded once where the processor can: all such processors give the same bits.
		template <int n> HWY_INLINE Numbers<n> added(const Numbers<n>& q, double s, Numbers<n> to)
		{
			for (int i = 0; i < q.parts; ++i)
				to.part[i] = hn::MulAdd(q.part[i], hn::Set(typename Numbers<n>::Tag(), s), to.part[i]);
			return to;
		}
		HWY_INLINE void load(const double* from, Numbers<1>& q) { q.part = *from; }
		HWY_INLINE void store(const Numbers<1>& q, double* to) { *to = q.part; }
		HWY_INLINE void clear(Numbers<1>& q) { q.part = 0.0; }
		HWY_INLINE Numbers<1> scaled(const Numbers<1>& q, double s) { return { q.part * s }; }
		HWY_INLINE Numbers<1> added(const Numbers<1>& q, double s, const Numbers<1>& to)
		{
#if HWY_NATIVE_FMA
			return { __builtin_fma(q.part, s, to.part) };
#else
			return { to.part + q.part * s };
#endif
		}
		HWY_INLINE Numbers<2> numbers(double a, double b)
		{
#if HWY_TARGET == HWY_SCALAR
			const Numbers<2>::Tag one;
			return { { hn::Set(one, a), hn::Set(one, b) } };
#else
			const Numbers<2>::Tag two;
			return { { hn::InterleaveLower(two, hn::Set(two, a), hn::Set(two, b)) } };
#endif
		}
		HWY_INLINE Numbers<4> numbers(double a, double b, double c, double d)
		{
			const Numbers<2> low = numbers(a, b), high = numbers(c, d);
#if HWY_TARGET == HWY_SCALAR
			return { { low.part[0], low.part[1], high.part[0], high.part[1] } };
#elif HWY_MAX_BYTES == 16
			return { { low.part[0], high.part[0] } };
#else
			return { { hn::Combine(Numbers<4>::Tag(), high.part[0], low.part[0]) } };
#endif
		}

		/// Value i of point k for every number i of a record of values.
		template <int n> HWY_INLINE Numbers<n> numbers(const double (&values)[n][blockSize], int k)
		{
			if constexpr (n == 2) {
				return numbers(values[0][k], values[1][k]);
			} else {
				Numbers<n> all;
#pragma GCC unroll 3
				for (int first = 0; first < n; first += 4) {
					const Numbers<4> four = numbers(values[first][k], values[first + 1][k], values[first + 2][k], values[first + 3][k]);
					for (int i = 0; i < four.parts; ++i)
						all.part[first / four.lanes + i] = four.part[i];
				}
				return all;
			}
		}
		/// The components of a vector behind a first number, and zero in what is left of four.
		template <int D> HWY_INLINE Numbers<4> numbers(double first, const double (&vector)[D][blockSize], int k)
		{
			if constexpr (D == 2) return numbers(first, vector[0][k], vector[1][k], 0.0);
			else return numbers(first, vector[0][k], vector[1][k], vector[2][k]);
		}

		/// Numbers that a record does not have: they cost nothing.
		struct Nothing {
			HWY_INLINE Nothing operator[](int) const { return {}; }
		};
		HWY_INLINE Nothing          scaled(Nothing, double) { return {}; }
		HWY_INLINE Nothing          added(Nothing, double, Nothing) { return {}; }
		template <int n> HWY_INLINE Numbers<n> added(Nothing, double, const Numbers<n>& to) { return to; }
		template <int n> HWY_INLINE Numbers<n> added(const Numbers<n>& q, double s, Nothing) { return scaled(q, s); }

		/// Weights of one point along the first axis: registers, where what is stored in records cannot change them.
		struct FirstAxis {
			double                      value[supportNodes], slope[supportNodes];
			template <int D> HWY_INLINE FirstAxis(const WeightBlock<D>& w, int k)
			{
#pragma GCC unroll 3
				for (int n = 0; n < supportNodes; ++n) {
					value[n] = w.value[0][n][k];
					slope[n] = w.slope[0][n][k];
				}
			}
		};

		/// From the record of the base node to those of the support. A copy of the block's: what is stored in records could alias the
		/// block for all the compiler knows.
		template <int D> struct Offsets {
			long number[supportCount<D>];
			Offsets(const WeightBlock<D>& w, int recordSize)
			{
				for (int n = 0; n < supportCount<D>; ++n)
					number[n] = static_cast<long>(w.offset[n]) * recordSize;
			}
			[[gnu::always_inline]] long at(int row, int column) const { return number[row * supportNodes + column]; }
		};

		/// Adds S value + sum_a dS/dx_a slopes[a] to the records of the support of point k; what the nodes of a row share is formed once.
		template <class Record, int D, class Value, class Slopes>
		HWY_INLINE void scatter(const WeightBlock<D>& w, int k, const Offsets<D>& offsets, double* base, const Value& value, const Slopes& slopes)
		{
			const FirstAxis s(w, k);
#pragma GCC unroll 3
			for (int row = 0; row < supportRows<D>; ++row) {
				const double shared   = w.row(0, row)[k];
				auto         rowValue = added(slopes[1], w.row(1, row)[k], scaled(value, shared));
				if constexpr (D == 3) rowValue = added(slopes[2], w.row(2, row)[k], rowValue);
				const auto rowSlope = scaled(slopes[0], shared);
#pragma GCC unroll 3
				for (int column = 0; column < supportNodes; ++column) {
					double* to = base + offsets.at(row, column);
					Record  record;
					load(to, record);
					store(added(rowSlope, s.slope[column], added(rowValue, s.value[column], record)), to);
				}
			}
		}
		template <int n, int D>
		HWY_INLINE void scatter(const WeightBlock<D>& w, int k, const Offsets<D>& offsets, double* base, const Numbers<n>& value)
		{
			scatter<Numbers<n>>(w, k, offsets, base, value, Nothing());
		}

		/// Sums over the support: S and dS/dx_a times records.
		template <class Record, int D> struct Sums {
			Record value, slope[D];
		};
		template <class Record, int D> HWY_INLINE Sums<Record, D> gather(const WeightBlock<D>& w, int k, const Offsets<D>& offsets, const double* base)
		{
			const FirstAxis s(w, k);
			Sums<Record, D> sums;
			clear(sums.value);
			for (Record& slope : sums.slope)
				clear(slope);
#pragma GCC unroll 3
			for (int row = 0; row < supportRows<D>; ++row) {
				Record rowSum, rowSlope;
				clear(rowSum);
				clear(rowSlope);
#pragma GCC unroll 3
				for (int column = 0; column < supportNodes; ++column) {
					Record record;
					load(base + offsets.at(row, column), record);
					rowSum   = added(record, s.value[column], rowSum);
					rowSlope = added(record, s.slope[column], rowSlope);
				}
				sums.value    = added(rowSum, w.row(0, row)[k], sums.value);
				sums.slope[0] = added(rowSlope, w.row(0, row)[k], sums.slope[0]);
#pragma GCC unroll 2
				for (int a = 1; a < D; ++a)
					sums.slope[a] = added(rowSum, w.row(a, row)[k], sums.slope[a]);
			}
			return sums;
		}

		/// The record of the base node of point k.
		template <int D> HWY_INLINE double* baseOf(const WeightBlock<D>& w, int k, double* nodes, int recordSize)
		{
			return nodes + static_cast<long>(w.base[k]) * recordSize;
		}
		template <int D> HWY_INLINE const double* baseOf(const WeightBlock<D>& w, int k, const double* nodes, int recordSize)
		{
			return nodes + static_cast<long>(w.base[k]) * recordSize;
		}

		/// What the points of a block give to records Moving.
		template <int D> struct MotionOfBlock {
			double mass[blockSize], momentum[D][blockSize], force[D][D][blockSize]; ///< -V sigma
			double heat[2][blockSize];                                              ///< capacity, capacity times carried
		};

		template <bool Carried, bool Replaced, int D>
		HWY_INLINE void load(const WeightBlock<D>& w, const typename NodeLoops<D>::MotionMap& a, MotionOfBlock<D>& b)
		{
			for (int k = 0; k < w.count; ++k) {
				const int p    = w.first + k;
				double    mean = 0.0;
				for (int i = 0; i < D; ++i)
					mean += a.stress[i][p];
				const double replace = Replaced ? a.meanStress[p] - mean * (1.0 / D) : 0.0;
				b.mass[k]            = a.mass[p];
				for (int i = 0; i < D; ++i) {
					b.momentum[i][k] = a.mass[p] * a.velocity[i][p];
					for (int j = 0; j < D; ++j)
						b.force[i][j][k] = -a.volume[p] * (i == j ? a.stress[i][p] + replace : a.stress[stressIndex<D>(i, j)][p]);
				}
				b.heat[0][k] = Carried ? a.capacity[p] : 0.0;
				b.heat[1][k] = Carried ? a.capacity[p] * (a.carried[p] - a.carriedFrom) : 0.0;
			}
		}

		template <bool Carried, bool Replaced, int D> void mapMotionWith(const WeightBlock<D>& w, const typename NodeLoops<D>::MotionMap& a)
		{
			using Moving = typename NodeColumns<D>::Moving;
			const Offsets<D> at(w, Moving::size);
			MotionOfBlock<D> b;
			load<Carried, Replaced>(w, a, b);
			for (int k = 0; k < w.count; ++k) {
				double* base = baseOf(w, k, a.nodes, Moving::size);
				scatter(w, k, at, base, numbers(b.mass[k], b.momentum, k));
				Numbers<4> slopes[D];
				for (int i = 0; i < D; ++i) {
					if constexpr (D == 2) slopes[i] = numbers(b.force[i][0][k], b.force[i][1][k], 0.0, 0.0);
					else slopes[i] = numbers(b.force[i][0][k], b.force[i][1][k], b.force[i][2][k], 0.0);
				}
				if constexpr (Moving::carriesHeat)
					scatter<Numbers<4>>(w, k, at, base + Moving::force, numbers(0.0, 0.0, b.heat[0][k], b.heat[1][k]), slopes);
				else scatter<Numbers<4>>(w, k, at, base + Moving::force, Nothing(), slopes);
			}
		}

		template <int D> void mapMotion(const WeightBlock<D>& w, const typename NodeLoops<D>::MotionMap& a)
		{
			if (a.capacity) a.meanStress ? mapMotionWith<true, true>(w, a) : mapMotionWith<true, false>(w, a);
			else a.meanStress ? mapMotionWith<false, true>(w, a) : mapMotionWith<false, false>(w, a);
		}

		/// What the points of a block gather from records Solved.
		template <int D> struct SolvedAtBlock {
			double change[D][blockSize], velocity[D][blockSize], gradient[D][D][blockSize];
		};

		template <int D> HWY_INLINE void gatherSolved(const WeightBlock<D>& w, const double* nodes, SolvedAtBlock<D>& b)
		{
			using Solved = typename NodeColumns<D>::Solved;
			// four numbers that end with the velocity; in the plane they begin with the change
			constexpr int    behind = Solved::size - 4, v = Solved::velocity - behind;
			const Offsets<D> at(w, Solved::size);
			for (int k = 0; k < w.count; ++k) {
				const double*             base = baseOf(w, k, nodes, Solved::size);
				const Sums<Numbers<4>, D> sums = gather<Numbers<4>>(w, k, at, base + behind);
				double                    change[4], value[4], slope[D][4];
				store(sums.value, value);
				if constexpr (behind > 0) store(gather<Numbers<4>>(w, k, at, base).value, change);
				for (int a = 0; a < D; ++a)
					store(sums.slope[a], slope[a]);
				for (int i = 0; i < D; ++i) {
					b.change[i][k]   = behind > 0 ? change[i] : value[i];
					b.velocity[i][k] = value[v + i];
					for (int j = 0; j < D; ++j)
						b.gradient[i][j][k] = slope[j][v + i];
				}
			}
		}

		template <int D> void gatherMotion(const WeightBlock<D>& w, const typename NodeLoops<D>::MotionGather& a)
		{
			const int        count = w.count, first = w.first;
			SolvedAtBlock<D> b;
			gatherSolved(w, a.nodes, b);
			const double chi = a.kept, dt = a.dt;
			for (int i = 0; i < D; ++i) {
				double* velocity     = a.velocity[i] + first;
				double* position     = a.position[i] + first;
				double* displacement = a.displacement[i] + first;
				for (int k = 0; k < count; ++k) {
					velocity[k] = chi * velocity[k] + b.change[i][k];
					position[k] += dt * b.velocity[i][k];
					displacement[k] += dt * b.velocity[i][k];
				}
				for (int j = 0; j < D; ++j) {
					double* gradient = a.gradient[i * D + j] + first;
					for (int k = 0; k < count; ++k)
						gradient[k] = dt * b.gradient[i][j][k];
				}
			}
		}

		template <int D, int n> void mapRecords(const WeightBlock<D>& w, const double (&values)[n][blockSize], double* nodes)
		{
			const Offsets<D> at(w, n);
			for (int k = 0; k < w.count; ++k)
				scatter(w, k, at, baseOf(w, k, nodes, n), numbers(values, k));
		}

		template <int D, int n> void gatherRecords(const WeightBlock<D>& w, const double* nodes, double (&sums)[n][blockSize])
		{
			const Offsets<D> at(w, n);
			for (int k = 0; k < w.count; ++k) {
				double record[n];
				store(gather<Numbers<n>>(w, k, at, baseOf(w, k, nodes, n)).value, record);
				for (int i = 0; i < n; ++i)
					sums[i][k] = record[i];
			}
		}

		template <int D> void gatherNumber(const WeightBlock<D>& w, const double* nodes, double (&sums)[blockSize])
		{
			const Offsets<D> at(w, 1);
			for (int k = 0; k < w.count; ++k)
				store(gather<Numbers<1>>(w, k, at, baseOf(w, k, nodes, 1)).value, sums + k);
		}

		/// Slopes of pressure and of temperature, and temperature itself, at the points of a block.
		template <int D> struct Potentials {
			double pressureSlope[D][blockSize], temperatureSlope[D][blockSize], temperature[blockSize];
		};

		template <bool Heat, int D> HWY_INLINE void gatherPotentials(const WeightBlock<D>& w, const double* nodes, Potentials<D>& g)
		{
			using Driving = typename NodeColumns<D>::Driving;
			const Offsets<D> at(w, Driving::size);
			for (int k = 0; k < w.count; ++k) {
				const Sums<Numbers<4>, D> sums = gather<Numbers<4>>(w, k, at, baseOf(w, k, nodes, Driving::size));
				double                    record[4];
				for (int a = 0; a < D; ++a) {
					store(sums.slope[a], record);
					g.pressureSlope[a][k] = record[Driving::pressure];
					if (Heat) g.temperatureSlope[a][k] = record[Driving::temperature];
				}
				store(sums.value, record);
				if (Heat) g.temperature[k] = record[Driving::temperature];
			}
		}

		template <int D> HWY_INLINE void gatherTemperature(const WeightBlock<D>& w, const double* nodes, Potentials<D>& g)
		{
			const Offsets<D> at(w, 1);
			for (int k = 0; k < w.count; ++k) {
				const Sums<Numbers<1>, D> sums = gather<Numbers<1>>(w, k, at, baseOf(w, k, nodes, 1));
				for (int a = 0; a < D; ++a)
					store(sums.slope[a], &g.temperatureSlope[a][k]);
				store(sums.value, &g.temperature[k]);
			}
		}

		/// What the points of a block give to columns heat and unseen: with S, and with its slopes.
		template <int D> struct HeatOfBlock {
			double produced[blockSize], unseen[blockSize], flow[D][blockSize];
		};

		template <int D>
		HWY_INLINE void findHeatFlow(const WeightBlock<D>& w, const typename NodeLoops<D>::HeatFlow& h, const Potentials<D>& g, HeatOfBlock<D>& b)
		{
			const double* const volume       = h.volume + w.first;
			const double* const conductivity = h.conductivity + w.first;
			const double* const capacity     = h.capacity + w.first;
			const double* const temperature  = h.temperature + w.first;
			for (int k = 0; k < w.count; ++k) {
				const double conductance = -volume[k] * conductivity[k] * h.duration;
				for (int a = 0; a < D; ++a)
					b.flow[a][k] = g.temperatureSlope[a][k] * conductance;
				b.unseen[k]   = capacity[k] * (g.temperature[k] - (temperature[k] - h.reference));
				b.produced[k] = volume[k] * h.produced;
			}
		}

		/// Adds heat and unseen to neighbouring columns.
		template <int D> HWY_INLINE void scatterHeat(const WeightBlock<D>& w, int k, const Offsets<D>& at, double* base, const HeatOfBlock<D>& b)
		{
			Numbers<2> slopes[D];
			for (int a = 0; a < D; ++a)
				slopes[a] = numbers(b.flow[a][k], 0.0);
			scatter<Numbers<2>>(w, k, at, base, numbers(b.produced[k], b.unseen[k]), slopes);
		}

		template <int D> void flowHeat(const WeightBlock<D>& w, const typename NodeLoops<D>::HeatFlow& h, const double* temperature, double* conducted)
		{
			using Conducted = typename NodeColumns<D>::Conducted;
			const Offsets<D> at(w, Conducted::size);
			Potentials<D>    g;
			HeatOfBlock<D>   b;
			gatherTemperature(w, temperature, g);
			findHeatFlow(w, h, g, b);
			for (int k = 0; k < w.count; ++k)
				scatterHeat(w, k, at, baseOf(w, k, conducted, Conducted::size), b);
		}

		template <bool Heat, int D>
		void flowBoth(const WeightBlock<D>& w, const typename NodeLoops<D>::HeatFlow& h, const double* volume, const double* driving, double* driven)
		{
			using Driven = typename NodeColumns<D>::Driven;
			const Offsets<D> at(w, Driven::size);
			Potentials<D>    g;
			HeatOfBlock<D>   b;
			gatherPotentials<Heat>(w, driving, g);
			for (int k = 0; k < w.count; ++k)
				for (int a = 0; a < D; ++a)
					g.pressureSlope[a][k] *= volume[w.first + k];
			if (Heat) findHeatFlow(w, h, g, b);
			for (int k = 0; k < w.count; ++k) {
				double* base = baseOf(w, k, driven, Driven::size);
				if constexpr (D == 3) {
					scatter(w, k, at, base, numbers(g.pressureSlope[0][k], g.pressureSlope[1][k], g.pressureSlope[2][k], 0.0));
					if (Heat) scatterHeat(w, k, at, base + Driven::heat, b);
				} else if constexpr (Heat) {
					// one record has room for both
					const Numbers<4> slopes[2] = { numbers(0.0, 0.0, b.flow[0][k], 0.0), numbers(0.0, 0.0, b.flow[1][k], 0.0) };
					scatter<Numbers<4>>(
					        w, k, at, base, numbers(g.pressureSlope[0][k], g.pressureSlope[1][k], b.produced[k], b.unseen[k]), slopes);
				} else scatter(w, k, at, base, numbers(g.pressureSlope[0][k], g.pressureSlope[1][k], 0.0, 0.0));
			}
		}

		template <int D> void flowPressure(const WeightBlock<D>& w, const double* volume, const double* driving, double* driven)
		{
			flowBoth<false>(w, {}, volume, driving, driven);
		}
		template <int D>
		void flowHeatAndPressure(const WeightBlock<D>& w, const typename NodeLoops<D>::HeatFlow& h, const double* driving, double* driven)
		{
			flowBoth<true>(w, h, h.volume, driving, driven);
		}

		template <int D> void seep(const WeightBlock<D>& w, const typename NodeLoops<D>::Seepage& s)
		{
			using Flux     = typename NodeColumns<D>::Flux;
			using Gathered = typename NodeColumns<D>::Gathered;
			const Offsets<D> from(w, Flux::size), to(w, Gathered::size);
			double           q[Flux::size][blockSize], heat[blockSize];
			gatherRecords<D, Flux::size>(w, s.flux, q);
			for (int k = 0; k < w.count; ++k) {
				const double scale = s.massPerFlux * s.volume[w.first + k];
				for (int a = 0; a < D; ++a)
					q[a][k] *= scale;
				heat[k] = s.temperature ? s.specificHeat * s.temperature[w.first + k] + s.enthalpyAtZero : 0.0;
			}
			for (int k = 0; k < w.count; ++k) {
				const int p    = w.first + k;
				double*   base = baseOf(w, k, s.exchange, Gathered::size);
				// mass, enthalpy and the first two components of momentum
				const Numbers<4> carried = numbers(1.0, heat[k], s.velocity[0][p], s.velocity[1][p]);
				Numbers<4>       flow[D];
				for (int a = 0; a < D; ++a)
					flow[a] = scaled(carried, q[a][k]);
				scatter<Numbers<4>>(w, k, to, base, Nothing(), flow);
				if constexpr (D == 3) {
					const double     v       = s.velocity[2][p];
					const Numbers<1> last[3] = { { q[0][k] * v }, { q[1][k] * v }, { q[2][k] * v } };
					scatter<Numbers<1>>(w, k, to, base + Gathered::momentum + 2, Nothing(), last);
				}
			}
		}

	} // namespace

	template <int D> const NodeLoops<D>& versionOfNodeLoops()
	{
		using Columns                        = NodeColumns<D>;
		static constexpr bool     roundsOnce = HWY_NATIVE_FMA != 0;
		static const NodeLoops<D> loops { hwy::TargetName(HWY_TARGET),
			                          roundsOnce,
			                          &mapMotion<D>,
			                          &gatherMotion<D>,
			                          &mapRecords<D, Columns::Liquid::size>,
			                          &mapRecords<D, 2>,
			                          &gatherRecords<D, Columns::Gathered::size>,
			                          &gatherNumber<D>,
			                          &flowHeat<D>,
			                          &flowPressure<D>,
			                          &flowHeatAndPressure<D>,
			                          &seep<D> };
		return loops;
	}
	const NodeLoops<2>& loopsOfPlane() { return versionOfNodeLoops<2>(); }
	const NodeLoops<3>& loopsOfSpace() { return versionOfNodeLoops<3>(); }

} // namespace HWY_NAMESPACE
} // namespace talik
HWY_AFTER_NAMESPACE();

#if HWY_ONCE
namespace talik {

HWY_EXPORT(loopsOfPlane);
HWY_EXPORT(loopsOfSpace);

template <int D> const NodeLoops<D>& bestVectorLoops()
{
	if constexpr (D == 2) return HWY_DYNAMIC_DISPATCH(loopsOfPlane)();
	else return HWY_DYNAMIC_DISPATCH(loopsOfSpace)();
}

template <int D> std::vector<const NodeLoops<D>*> vectorLoops()
{
	std::vector<const NodeLoops<D>*> versions;
	const auto                       allow = [](std::int64_t targets) {
                hwy::SetSupportedTargetsForTest(targets);
                hwy::GetChosenTarget().Update(hwy::SupportedTargets());
	};
	for (const std::int64_t target : hwy::SupportedAndGeneratedTargets()) {
		allow(target);
		versions.push_back(&bestVectorLoops<D>());
	}
	allow(0); // all again
	return versions;
}

template const NodeLoops<2>&              bestVectorLoops<2>();
template const NodeLoops<3>&              bestVectorLoops<3>();
template std::vector<const NodeLoops<2>*> vectorLoops<2>();
template std::vector<const NodeLoops<3>*> vectorLoops<3>();

} // namespace talik
#endif
