// SPDX-License-Identifier: GPL-2.0-or-later
// Compiled once for every kind of processor that Highway knows; the best version that the processor has is chosen when the program runs.
#undef HWY_DISABLED_TARGETS
#define HWY_DISABLED_TARGETS (HWY_SSSE3 | HWY_SVE | HWY_SVE2 | HWY_SVE_256 | HWY_SVE2_128 | HWY_RVV) // vectors in structures have a fixed length
#undef HWY_TARGET_INCLUDE
#define HWY_TARGET_INCLUDE "pkg/mpm/kernels/VectorLoops.cpp"
#include <hwy/foreach_target.h>

#include <algorithm>
#include <cstdint>
#include <hwy/highway.h>
#include <pkg/mpm/grid/NodeLoops.hpp>

HWY_BEFORE_NAMESPACE();
namespace talik {
namespace HWY_NAMESPACE {
	namespace {

		namespace hn = hwy::HWY_NAMESPACE;

		/// n neighbouring numbers of a record, 1, 2, 4 or 8, in the longest vectors that they fill.
		template <int n> struct Numbers {
			static constexpr int lanes = HWY_MIN(HWY_LANES(double), n), parts = n / lanes;
			using Tag = hn::CappedTag<double, lanes>;
			hn::Vec<Tag> part[parts];
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

		HWY_INLINE Numbers<8> numbers(const Numbers<4>& low, const Numbers<4>& high)
		{
			Numbers<8> q;
#if HWY_TARGET != HWY_SCALAR && HWY_MAX_BYTES >= 64
			q.part[0] = hn::Combine(Numbers<8>::Tag(), high.part[0], low.part[0]);
#else
			for (int i = 0; i < low.parts; ++i) {
				q.part[i]             = low.part[i];
				q.part[low.parts + i] = high.part[i];
			}
#endif
			return q;
		}
		/// Numbers that a run of points adds to at once: more would not stay in registers.
		constexpr int mostTogether = HWY_MAX(4, HWY_LANES(double));
		/// n numbers of point k from number first of values on.
		template <int n, int size> HWY_INLINE Numbers<n> numbers(const double (&values)[size][blockSize], int k, int first = 0)
		{
			if constexpr (n == 2) return numbers(values[first][k], values[first + 1][k]);
			else if constexpr (n == 4) return numbers(values[first][k], values[first + 1][k], values[first + 2][k], values[first + 3][k]);
			else return numbers(numbers<4>(values, k, first), numbers<4>(values, k, first + 4));
		}
		/// The components of a vector behind a first number, and zero in what is left of four.
		template <int D> HWY_INLINE Numbers<4> numbers(double first, const double (&vector)[D][blockSize], int k)
		{
			if constexpr (D == 2) return numbers(first, vector[0][k], vector[1][k], 0.0);
			else return numbers(first, vector[0][k], vector[1][k], vector[2][k]);
		}
		/// The components of a vector, and zero in what is left of four.
		template <int D> HWY_INLINE Numbers<4> numbers(const double (&vector)[D][blockSize], int k)
		{
			if constexpr (D == 2) return numbers(vector[0][k], vector[1][k], 0.0, 0.0);
			else return numbers(vector[0][k], vector[1][k], vector[2][k], 0.0);
		}

		/// Numbers that a record does not have: they cost nothing.
		struct Nothing {};
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
					number[n] = long(w.offset[n]) * recordSize;
			}
			[[gnu::always_inline]] long at(int row, int column) const { return number[row * supportNodes + column]; }
		};

		/// The records of the support of a point; Number is double or const double. Rows for which any() is false are left out.
		template <int D, class Number> struct AllRecords {
			Number*           base;
			const Offsets<D>& offsets;
			AllRecords(const WeightBlock<D>& w, int k, Number* nodes, int recordSize, const Offsets<D>& at)
			        : base(nodes + long(w.base[k]) * recordSize)
			        , offsets(at)
			{}
			[[gnu::always_inline]] Number* at(int row, int column) const { return base + offsets.at(row, column); }
			static constexpr bool          any(int) { return true; }
		};

		/// Where some nodes have a record. The others share `none`: zeros, or numbers that nobody reads.
		template <int D, class Number> struct SparseSupport {
			Number* record[supportCount<D>];
			bool    present[supportRows<D>], anywhere = false;
			SparseSupport(const WeightBlock<D>& w, int k, const typename NodeLoops<D>::template SparseRecords<Number>& some, Number* none)
			{
				const int* const slots = some.slot + w.base[k];
				for (int row = 0; row < supportRows<D>; ++row) {
					present[row] = false;
					for (int n = row * supportNodes; n < (row + 1) * supportNodes; ++n) {
						const int slot = slots[w.offset[n]];
						record[n]      = slot < 0 ? none : some.first + long(slot) * some.size;
						present[row] |= slot >= 0;
					}
					anywhere |= present[row];
				}
			}
			Number* at(int row, int column) const { return record[row * supportNodes + column]; }
			bool    any(int row) const { return present[row]; }
		};

		/// What a point gives to each record of its support: S value + sum_a dS/dx_a slope[a].
		template <int D, class Value, class Slope> struct Share {
			Value value;
			Slope slope[D];
		};
		template <int D, int n> HWY_INLINE Share<D, Numbers<n>, Nothing> shareOf(const Numbers<n>& value) { return { value, {} }; }

		/// Left sum of eq. (8.0): adds the shares of the points first .. last - 1, which have one base. The records of some rows stay in registers while all these
		/// points add to them: every record has one order of its sum, however long the run. What the nodes of a row share is formed once.
		/// Points k = first .. last - 1 are those with number pointAt(k) in the block and give shareAt(k) to the numbers from column on.
		template <class Record, int D, class Records, class ShareAt, class PointAt>
		HWY_INLINE void scatter(const WeightBlock<D>& w, int first, int last, const Records& records, int column, ShareAt&& shareAt, PointAt&& pointAt)
		{
			constexpr int rows = D == 2 ? 1 : supportNodes;
#pragma GCC unroll 3
			for (int firstRow = 0; firstRow < supportRows<D>; firstRow += rows) {
				bool any = false;
#pragma GCC unroll 3
				for (int row = 0; row < rows; ++row)
					any |= records.any(firstRow + row);
				if (!any) continue;
				Record record[rows][supportNodes];
#pragma GCC unroll 3
				for (int row = 0; row < rows; ++row)
#pragma GCC unroll 3
					for (int n = 0; n < supportNodes; ++n)
						load(records.at(firstRow + row, n) + column, record[row][n]);
				for (int k = first; k < last; ++k) {
					const int       p = pointAt(k);
					const FirstAxis s(w, p);
					const auto&     share = shareAt(k);
#pragma GCC unroll 3
					for (int row = 0; row < rows; ++row) {
						const double shared   = w.row(0, firstRow + row)[p];
						auto         rowValue = added(share.slope[1], w.row(1, firstRow + row)[p], scaled(share.value, shared));
						if constexpr (D == 3) rowValue = added(share.slope[2], w.row(2, firstRow + row)[p], rowValue);
						const auto rowSlope = scaled(share.slope[0], shared);
#pragma GCC unroll 3
						for (int n = 0; n < supportNodes; ++n)
							record[row][n] = added(rowSlope, s.slope[n], added(rowValue, s.value[n], record[row][n]));
					}
				}
#pragma GCC unroll 3
				for (int row = 0; row < rows; ++row)
#pragma GCC unroll 3
					for (int n = 0; n < supportNodes; ++n)
						store(record[row][n], records.at(firstRow + row, n) + column);
			}
		}

		/// Adds the shares of all points of a block, shareOf(k) of point k, to records of recordSize numbers. In space points with one base
		/// follow each other, see MaterialPoints::sort.
		template <class Record, int D, class ShareOf>
		HWY_INLINE void scatterBlock(const WeightBlock<D>& w, double* nodes, int recordSize, ShareOf&& shareOf)
		{
			const Offsets<D> at(w, recordSize);
			const auto       own = [](int k) { return k; };
			if constexpr (D == 2) {
				for (int k = 0; k < w.count; ++k) {
					const auto share = shareOf(k);
					scatter<Record>(
					        w, k, k + 1, AllRecords<D, double>(w, k, nodes, recordSize, at), 0, [&](int) -> const auto& { return share; },
					        own);
				}
			} else {
				decltype(shareOf(0)) shares[blockSize];
				for (int k = 0; k < w.count; ++k)
					shares[k] = shareOf(k);
				for (int k = 0, end = 0; k < w.count; k = end) {
					while (end < w.count && w.base[end] == w.base[k])
						++end;
					scatter<Record>(
					        w, k, end, AllRecords<D, double>(w, k, nodes, recordSize, at),
					        0, [&](int of) -> const auto& { return shares[of]; }, own);
				}
			}
		}

		/// Right sums of eq. (8.0) over the support: S and dS/dx_a times records.
		template <class Record, int D> struct Sums {
			Record value, slope[D];
		};
		template <class Record, int D, class Records>
		HWY_INLINE Sums<Record, D> gather(const WeightBlock<D>& w, int k, const Records& records, int column = 0)
		{
			const FirstAxis s(w, k);
			Sums<Record, D> sums;
			clear(sums.value);
			for (Record& slope : sums.slope)
				clear(slope);
#pragma GCC unroll 3
			for (int row = 0; row < supportRows<D>; ++row) {
				if (!records.any(row)) continue;
				Record rowSum, rowSlope;
				clear(rowSum);
				clear(rowSlope);
#pragma GCC unroll 3
				for (int n = 0; n < supportNodes; ++n) {
					Record record;
					load(records.at(row, n) + column, record);
					rowSum   = added(record, s.value[n], rowSum);
					rowSlope = added(record, s.slope[n], rowSlope);
				}
				sums.value    = added(rowSum, w.row(0, row)[k], sums.value);
				sums.slope[0] = added(rowSlope, w.row(0, row)[k], sums.slope[0]);
#pragma GCC unroll 2
				for (int a = 1; a < D; ++a)
					sums.slope[a] = added(rowSum, w.row(a, row)[k], sums.slope[a]);
			}
			return sums;
		}

		/// What the points of a block give to records Moving.
		template <int D> struct MotionOfBlock {
			double mass[blockSize], momentum[D][blockSize], force[D][D][blockSize]; ///< -V sigma
			double heat[2][blockSize];                                              ///< capacity, capacity times carried
		};

		template <bool Carried, bool Added, int D>
		HWY_INLINE void load(const WeightBlock<D>& w, const typename NodeLoops<D>::MotionMap& a, MotionOfBlock<D>& b)
		{
			for (int k = 0; k < w.count; ++k) {
				const int    p     = w.first + k;
				const double added = Added ? a.addedStress[p] : 0.0;
				b.mass[k]          = a.mass[p];
				for (int i = 0; i < D; ++i) {
					b.momentum[i][k] = a.mass[p] * a.velocity[i][p];
					for (int j = 0; j < D; ++j)
						b.force[i][j][k] = -a.volume[p] * (i == j ? a.stress[i][p] + added : a.stress[stressIndex<D>(i, j)][p]);
				}
				b.heat[0][k] = Carried ? a.capacity[p] : 0.0;
				b.heat[1][k] = Carried ? a.capacity[p] * (a.carried[p] - a.carriedFrom) : 0.0;
			}
		}

		template <bool Carried, bool Added, int D> void mapMotionWith(const WeightBlock<D>& w, const typename NodeLoops<D>::MotionMap& a)
		{
			using Moving = typename NodeColumns<D>::Moving;
			MotionOfBlock<D> b;
			load<Carried, Added>(w, a, b);
			scatterBlock<Numbers<4>>(w, a.nodes, Moving::size, [&](int k) { return shareOf<D>(numbers(b.mass[k], b.momentum, k)); });
			scatterBlock<Numbers<4>>(w, a.nodes + Moving::force, Moving::size, [&](int k) {
				if constexpr (D == 2)
					return Share<2, Numbers<4>, Numbers<4>> { numbers(0.0, 0.0, b.heat[0][k], b.heat[1][k]),
						                                  { numbers(b.force[0], k), numbers(b.force[1], k) } };
				else return Share<3, Nothing, Numbers<4>> { {}, { numbers(b.force[0], k), numbers(b.force[1], k), numbers(b.force[2], k) } };
			});
		}

		template <int D> void mapMotion(const WeightBlock<D>& w, const typename NodeLoops<D>::MotionMap& a)
		{
			if (a.capacity) a.addedStress ? mapMotionWith<true, true>(w, a) : mapMotionWith<true, false>(w, a);
			else a.addedStress ? mapMotionWith<false, true>(w, a) : mapMotionWith<false, false>(w, a);
		}

		/// What the points of a block gather from records Solved.
		template <int D> struct SolvedAtBlock {
			double change[D][blockSize], velocity[D][blockSize], gradient[D][D][blockSize], increment[blockSize];
		};

		template <int D> HWY_INLINE void gatherSolved(const WeightBlock<D>& w, const double* nodes, SolvedAtBlock<D>& b)
		{
			using Solved = typename NodeColumns<D>::Solved;
			// four numbers with the velocity; in the plane they begin with the change
			constexpr int    behind = Solved::size - 4, v = Solved::velocity - behind;
			const Offsets<D> at(w, Solved::size);
			for (int k = 0; k < w.count; ++k) {
				const AllRecords<D, const double> records(w, k, nodes, Solved::size, at);
				const Sums<Numbers<4>, D>         sums = gather<Numbers<4>>(w, k, records, behind);
				double                            change[4], value[4], slope[D][4];
				store(sums.value, value);
				if constexpr (behind > 0) store(gather<Numbers<4>>(w, k, records).value, change);
				for (int a = 0; a < D; ++a)
					store(sums.slope[a], slope[a]);
				if constexpr (Solved::carriesIncrement) b.increment[k] = change[Solved::increment];
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
			if (a.increment) std::copy_n(b.increment, count, a.increment);
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
			constexpr int together = D == 2 ? n : HWY_MIN(n, mostTogether), rest = n % together;
			for (int first = 0; first + together <= n; first += together)
				scatterBlock<Numbers<together>>(w, nodes + first, n, [&](int k) { return shareOf<D>(numbers<together>(values, k, first)); });
			if constexpr (rest > 0)
				scatterBlock<Numbers<rest>>(w, nodes + n - rest, n, [&](int k) { return shareOf<D>(numbers<rest>(values, k, n - rest)); });
		}

		template <int D, int n> void gatherRecords(const WeightBlock<D>& w, const double* nodes, double (&sums)[n][blockSize])
		{
			const Offsets<D> at(w, n);
			for (int k = 0; k < w.count; ++k) {
				double record[n];
				store(gather<Numbers<n>>(w, k, AllRecords<D, const double>(w, k, nodes, n, at)).value, record);
				for (int i = 0; i < n; ++i)
					sums[i][k] = record[i];
			}
		}

		template <int D> void gatherNumber(const WeightBlock<D>& w, const double* nodes, double (&sums)[blockSize])
		{
			const Offsets<D> at(w, 1);
			for (int k = 0; k < w.count; ++k)
				store(gather<Numbers<1>>(w, k, AllRecords<D, const double>(w, k, nodes, 1, at)).value, sums + k);
		}

		void mapSurface(const WeightBlock<3>& w, const double* volume, const double* conductivity, double* nodes)
		{
			using Surface = NodeColumns<3>::Surface;
			scatterBlock<Numbers<4>>(w, nodes, Surface::size, [&](int k) {
				const double v = volume[w.first + k];
				return Share<3, Numbers<4>, Numbers<4>> { numbers(0.0, 0.0, 0.0, v),
					                                  { numbers(v, 0.0, 0.0, 0.0), numbers(0.0, v, 0.0, 0.0), numbers(0.0, 0.0, v, 0.0) } };
			});
			if (!conductivity) return;
			scatterBlock<Numbers<1>>(w, nodes + Surface::conduction, Surface::size, [&](int k) {
				return shareOf<3>(Numbers<1> { volume[w.first + k] * conductivity[w.first + k] });
			});
		}

		/// In the plane a record is shorter than a vector.
		void mapSurface(const WeightBlock<2>& w, const double* volume, const double* conductivity, double* nodes)
		{
			using Surface = NodeColumns<2>::Surface;
			for (int k = 0; k < w.count; ++k) {
				const double v     = volume[w.first + k];
				const double kappa = conductivity ? conductivity[w.first + k] : 0.0;
				overNodes<2>(w, k, [&](int node, double s, const Vec<2>& g) {
					double* r = nodes + long(node) * Surface::size;
					for (int i = 0; i < 2; ++i)
						r[Surface::area + i] += v * g[i];
					r[Surface::volume] += s * v;
					r[Surface::conduction] += s * v * kappa;
				});
			}
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
				const Sums<Numbers<4>, D> sums = gather<Numbers<4>>(w, k, AllRecords<D, const double>(w, k, nodes, Driving::size, at));
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
				const Sums<Numbers<1>, D> sums = gather<Numbers<1>>(w, k, AllRecords<D, const double>(w, k, nodes, 1, at));
				for (int a = 0; a < D; ++a)
					store(sums.slope[a], &g.temperatureSlope[a][k]);
				store(sums.value, &g.temperature[k]);
			}
		}

		/// What the points of a block give to columns heat and nullSpace: with S, and with its slopes.
		template <int D> struct HeatOfBlock {
			double produced[blockSize], nullSpace[blockSize], flow[D][blockSize];
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
				b.nullSpace[k] = capacity[k] * (g.temperature[k] - (temperature[k] - h.reference));
				b.produced[k]  = volume[k] * h.produced;
			}
		}

		/// Adds heat and nullSpace to neighbouring columns.
		template <int D> HWY_INLINE void scatterHeat(const WeightBlock<D>& w, double* nodes, int recordSize, const HeatOfBlock<D>& b)
		{
			scatterBlock<Numbers<2>>(w, nodes, recordSize, [&](int k) {
				Share<D, Numbers<2>, Numbers<2>> share { numbers(b.produced[k], b.nullSpace[k]), {} };
				for (int a = 0; a < D; ++a)
					share.slope[a] = numbers(b.flow[a][k], 0.0);
				return share;
			});
		}

		template <int D> void flowHeat(const WeightBlock<D>& w, const typename NodeLoops<D>::HeatFlow& h, const double* temperature, double* conducted)
		{
			using Conducted = typename NodeColumns<D>::Conducted;
			Potentials<D>  g;
			HeatOfBlock<D> b;
			gatherTemperature(w, temperature, g);
			findHeatFlow(w, h, g, b);
			scatterHeat(w, conducted, Conducted::size, b);
		}

		template <bool Heat, int D>
		void flowBoth(const WeightBlock<D>& w, const typename NodeLoops<D>::HeatFlow& h, const double* volume, const double* driving, double* driven)
		{
			using Driven = typename NodeColumns<D>::Driven;
			Potentials<D>  g;
			HeatOfBlock<D> b;
			gatherPotentials<Heat>(w, driving, g);
			for (int k = 0; k < w.count; ++k)
				for (int a = 0; a < D; ++a)
					g.pressureSlope[a][k] *= volume[w.first + k];
			if (Heat) findHeatFlow(w, h, g, b);
			if constexpr (Heat && D == 2) {
				// one record has room for both
				scatterBlock<Numbers<4>>(w, driven, Driven::size, [&](int k) {
					return Share<2, Numbers<4>, Numbers<4>> {
						numbers(g.pressureSlope[0][k], g.pressureSlope[1][k], b.produced[k], b.nullSpace[k]),
						{ numbers(0.0, 0.0, b.flow[0][k], 0.0), numbers(0.0, 0.0, b.flow[1][k], 0.0) }
					};
				});
				return;
			}
			scatterBlock<Numbers<4>>(w, driven, Driven::size, [&](int k) { return shareOf<D>(numbers(g.pressureSlope, k)); });
			if constexpr (Heat) scatterHeat(w, driven + Driven::heat, Driven::size, b);
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

		/// Adds sum_a dS/dx_a q[a] times what the water of point k carries, carriedBy(k), to n numbers of records Gathered.
		template <int n, int D, int size, class CarriedBy>
		HWY_INLINE void scatterFlow(const WeightBlock<D>& w, double* nodes, const double (&q)[size][blockSize], CarriedBy&& carriedBy)
		{
			scatterBlock<Numbers<n>>(w, nodes, NodeColumns<D>::Gathered::size, [&](int k) {
				const Numbers<n>              carried = carriedBy(k);
				Share<D, Nothing, Numbers<n>> share;
				for (int a = 0; a < D; ++a)
					share.slope[a] = scaled(carried, q[a][k]);
				return share;
			});
		}

		template <int D> void seep(const WeightBlock<D>& w, const typename NodeLoops<D>::Seepage& s)
		{
			using Flux     = typename NodeColumns<D>::Flux;
			using Gathered = typename NodeColumns<D>::Gathered;
			double q[Flux::size][blockSize], heat[blockSize];
			gatherRecords<D, Flux::size>(w, s.flux, q);
			for (int k = 0; k < w.count; ++k) {
				const double scale = s.massPerFlux * s.volume[w.first + k];
				for (int a = 0; a < D; ++a)
					q[a][k] *= scale;
				heat[k] = s.temperature ? s.specificHeat * s.temperature[w.first + k] + s.enthalpyAtZero : 0.0;
			}
			// mass, enthalpy and the first two components of momentum
			scatterFlow<4>(w, s.exchange, q, [&](int k) { return numbers(1.0, heat[k], s.velocity[0][w.first + k], s.velocity[1][w.first + k]); });
			if constexpr (D == 3)
				scatterFlow<1>(w, s.exchange + Gathered::momentum + 2, q, [&](int k) { return Numbers<1> { s.velocity[2][w.first + k] }; });
		}

		/// n neighbouring numbers.
		template <int n> HWY_INLINE Numbers<n> loaded(const double* from)
		{
			Numbers<n> q;
			load(from, q);
			return q;
		}

		/// Eight numbers at once that take S alone, or four where no more are left.
		template <class Columns, int first, int D>
		HWY_INLINE void scatterStraight(
		        const WeightBlock<D>& w, int begin, int end, const SparseSupport<D, double>& records,
		        const typename NodeLoops<D>::template Shares<Columns>& shares)
		{
			if constexpr (first < Columns::straight) {
				constexpr int n = HWY_MIN(8, Columns::straight - first);
				scatter<Numbers<n>>(
				        w, begin, end, records, Columns::at + first, [&](int k) { return shareOf<D>(loaded<n>(shares.of[k].value + first)); },
				        [&](int k) { return shares.of[k].point; });
				scatterStraight<Columns, first + n>(w, begin, end, records, shares);
			}
		}

		template <class Columns, int D>
		void mapSome(
		        const WeightBlock<D>& w, const typename NodeLoops<D>::template Shares<Columns>& shares,
		        const typename NodeLoops<D>::template SparseRecords<double>& some)
		{
			constexpr int sloping                              = Columns::size - Columns::straight;
			double        nobodys[Columns::at + Columns::size] = {};
			const auto    pointAt                              = [&](int k) { return shares.of[k].point; };
			for (int k = 0, end = 0; k < shares.count; k = end) {
				while (end < shares.count && w.base[pointAt(end)] == w.base[pointAt(k)])
					++end;
				const SparseSupport<D, double> records(w, pointAt(k), some, nobodys);
				if (!records.anywhere) continue;
				scatterStraight<Columns, 0>(w, k, end, records, shares);
				if constexpr (sloping > 0)
					scatter<Numbers<sloping>>(
					        w, k, end, records, Columns::at + Columns::straight,
					        [&](int of) {
						        const auto&                                  from = shares.of[of];
						        Share<D, Numbers<sloping>, Numbers<sloping>> share { loaded<sloping>(from.value + Columns::straight),
							                                                     {} };
						        for (int a = 0; a < D; ++a)
							        load(from.slope[a], share.slope[a]);
						        return share;
					        },
					        pointAt);
			}
		}

		/// What stands for the records that nodes without one would have.
		constexpr double zeros[64] = {};

		/// Sums of n numbers from column on.
		template <int n, int D>
		HWY_INLINE void gatherSome(const WeightBlock<D>& w, int k, const SparseSupport<D, const double>& records, int column, double* to)
		{
			constexpr int together = HWY_MIN(8, n);
			store(gather<Numbers<together>>(w, k, records, column).value, to);
			if constexpr (n > together) gatherSome<n - together>(w, k, records, column + together, to + together);
		}

		template <int D>
		HWY_INLINE void gatherSide(
		        const WeightBlock<D>& w, int k, const SparseSupport<D, const double>& records, int first, typename NodeLoops<D>::FrontSums& sums)
		{
			using Side                         = typename NodeColumns<D>::Side;
			const Sums<Numbers<4>, D> velocity = gather<Numbers<4>>(w, k, records, first + Side::velocity);
			store(velocity.value, sums.side);
			for (int a = 0; a < D; ++a)
				store(velocity.slope[a], sums.gradient[a]);
			gatherSome<Side::size - 4>(w, k, records, first + 4, sums.side + 4);
		}

		template <int D>
		void gatherFrozen(
		        const WeightBlock<D>& w, int k, const typename NodeLoops<D>::template SparseRecords<const double>& some,
		        typename NodeLoops<D>::FrontSums& sums)
		{
			gatherSide(w, k, SparseSupport<D, const double>(w, k, some, zeros), 0, sums);
		}

		template <int D>
		void gatherThawed(
		        const WeightBlock<D>& w, int k, const typename NodeLoops<D>::template SparseRecords<const double>& some,
		        typename NodeLoops<D>::FrontSums& sums)
		{
			using Columns = NodeColumns<D>;
			const SparseSupport<D, const double> records(w, k, some, zeros);
			gatherSide(w, k, records, Columns::Side::size, sums);
			gatherSome<Columns::Slip::size>(w, k, records, Columns::Slip::at, sums.slip);
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
			                          &mapSurface,
			                          &flowHeat<D>,
			                          &flowPressure<D>,
			                          &flowHeatAndPressure<D>,
			                          &seep<D>,
			                          &mapSome<typename Columns::Frozen, D>,
			                          &mapSome<typename Columns::Thawed, D>,
			                          &mapSome<typename Columns::Pores, D>,
			                          &gatherFrozen<D>,
			                          &gatherThawed<D> };
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

namespace {
	template <int D> const NodeLoops<D>*& chosen()
	{
		static const NodeLoops<D>* loops = &bestVectorLoops<D>();
		return loops;
	}
} // namespace

template <int D> const NodeLoops<D>& nodeLoops() { return *chosen<D>(); }
template <int D> void                chooseNodeLoops(const NodeLoops<D>& loops) { chosen<D>() = &loops; }

template const NodeLoops<2>& nodeLoops<2>();
template const NodeLoops<3>& nodeLoops<3>();
template void                chooseNodeLoops<2>(const NodeLoops<2>&);
template void                chooseNodeLoops<3>(const NodeLoops<3>&);

} // namespace talik
#endif
