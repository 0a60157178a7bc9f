// SPDX-License-Identifier: GPL-2.0-or-later
// Compiled once for every kind of processor that Highway knows; the best version that the processor has is chosen when the program runs.
#undef HWY_DISABLED_TARGETS
#define HWY_DISABLED_TARGETS (HWY_SSSE3 | HWY_SVE | HWY_SVE2 | HWY_SVE_256 | HWY_SVE2_128 | HWY_RVV) // vectors in structures have a fixed length
#undef HWY_TARGET_INCLUDE
#define HWY_TARGET_INCLUDE "pkg/mpm/kernels/PlaneLoops.cpp"
#include <hwy/foreach_target.h>

#include <cstdint>
#include <hwy/highway.h>
#include <pkg/mpm/kernels/PlaneLoops.hpp>

HWY_BEFORE_NAMESPACE();
namespace talik {
namespace HWY_NAMESPACE {
	namespace {

		namespace hn = hwy::HWY_NAMESPACE;

		/// n neighbouring numbers of a record, 1, 2, 4 or 8, in vectors of four where the processor has them: longer ones gain nothing on
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
			for (int i = 0; i < low.parts; ++i) {
				q.part[i]             = low.part[i];
				q.part[low.parts + i] = high.part[i];
			}
			return q;
		}

		/// Numbers that a record does not have: they cost nothing.
		struct Nothing {};
		HWY_INLINE Nothing          scaled(Nothing, double) { return {}; }
		HWY_INLINE Nothing          added(Nothing, double, Nothing) { return {}; }
		template <int n> HWY_INLINE Numbers<n> added(Nothing, double, const Numbers<n>& to) { return to; }
		template <int n> HWY_INLINE Numbers<n> added(const Numbers<n>& q, double s, Nothing) { return scaled(q, s); }

		/// Weights of one point: registers, where what is stored in records cannot change them.
		struct PointWeights {
			double     nx[supportNodes], ny[supportNodes], dx[supportNodes], dy[supportNodes];
			HWY_INLINE PointWeights(const WeightBlock<2>& w, int k)
			{
#pragma GCC unroll 3
				for (int n = 0; n < supportNodes; ++n) {
					nx[n] = w.value[0][n][k];
					ny[n] = w.value[1][n][k];
					dx[n] = w.slope[0][n][k];
					dy[n] = w.slope[1][n][k];
				}
			}
		};

		/// From the record of the base node to those of the support, [numbers]. A copy of the block's: what is stored in records could
		/// alias the block for all the compiler knows.
		struct Offsets {
			long number[supportCount<2>];
			Offsets(const WeightBlock<2>& w, int recordSize)
			{
				for (int n = 0; n < supportCount<2>; ++n)
					number[n] = static_cast<long>(w.offset[n]) * recordSize;
			}
			[[gnu::always_inline]] long operator[](int n) const { return number[n]; }
		};

		/// Adds S value + dS/dx alongX + dS/dy alongY to the records of the support; what the nodes of a row share is formed once.
		template <class Record, class Value, class X, class Y>
		HWY_INLINE void scatter(const PointWeights& s, const Offsets& at, double* base, const Value& value, const X& alongX, const Y& alongY)
		{
#pragma GCC unroll 3
			for (int row = 0; row < supportNodes; ++row) {
				const auto rowValue = added(alongY, s.dy[row], scaled(value, s.ny[row]));
				const auto rowSlope = scaled(alongX, s.ny[row]);
#pragma GCC unroll 3
				for (int column = 0; column < supportNodes; ++column) {
					double* to = base + at[row * supportNodes + column];
					Record  record;
					load(to, record);
					store(added(rowSlope, s.dx[column], added(rowValue, s.nx[column], record)), to);
				}
			}
		}
		template <class Record> HWY_INLINE void scatter(const PointWeights& s, const Offsets& at, double* base, const Record& value)
		{
			scatter<Record>(s, at, base, value, Nothing(), Nothing());
		}

		/// Sums over the support: S, dS/dx and dS/dy times records.
		template <class Record> struct Sums {
			Record value, alongX, alongY;
		};
		template <class Record> HWY_INLINE Sums<Record> gather(const PointWeights& s, const Offsets& at, const double* base)
		{
			Sums<Record> sums;
			clear(sums.value);
			clear(sums.alongX);
			clear(sums.alongY);
#pragma GCC unroll 3
			for (int row = 0; row < supportNodes; ++row) {
				Record rowSum, rowSlope;
				clear(rowSum);
				clear(rowSlope);
#pragma GCC unroll 3
				for (int column = 0; column < supportNodes; ++column) {
					Record record;
					load(base + at[row * supportNodes + column], record);
					rowSum   = added(record, s.nx[column], rowSum);
					rowSlope = added(record, s.dx[column], rowSlope);
				}
				sums.value  = added(rowSum, s.ny[row], sums.value);
				sums.alongX = added(rowSlope, s.ny[row], sums.alongX);
				sums.alongY = added(rowSum, s.dy[row], sums.alongY);
			}
			return sums;
		}

		void spline(
		        int count, const double* x, double lower, double inverse, int stride, int* base, PlaneLoops::AxisWeights& value,
		        PlaneLoops::AxisWeights& slope)
		{
			// positions are no part of the block
#pragma GCC ivdep
			for (int k = 0; k < count; ++k) {
				const double s    = (x[k] - lower) * inverse + 0.5; // half a cell behind the node coordinate: never negative inside the box
				const int    node = static_cast<int>(s);
				const double f    = s - node; // 0 .. 1 from the middle between the first two nodes
				base[k] += node * stride;
				value[0][k] = 0.5 * (1.0 - f) * (1.0 - f);
				value[1][k] = 0.5 + f * (1.0 - f);
				value[2][k] = 0.5 * f * f;
				slope[0][k] = (f - 1.0) * inverse;
				slope[1][k] = (1.0 - 2.0 * f) * inverse;
				slope[2][k] = f * inverse;
			}
		}

		template <bool Carried, bool Replaced> void mapMotionWith(const WeightBlock<2>& w, const PlaneLoops::MotionMap& a)
		{
			const Offsets at(w, PlaneLoops::motionSize);
			const int     count = w.count, first = w.first;
			double        mass[blockSize], px[blockSize], py[blockSize], txx[blockSize], txy[blockSize], tyy[blockSize];
			double        capacity[blockSize], content[blockSize];
			for (int k = 0; k < count; ++k) {
				const int    p       = first + k;
				const double replace = Replaced ? a.meanStress[p] - (a.stress[0][p] + a.stress[1][p]) * 0.5 : 0.0;
				mass[k]              = a.mass[p];
				px[k]                = a.mass[p] * a.velocity[0][p];
				py[k]                = a.mass[p] * a.velocity[1][p];
				txx[k]               = -a.volume[p] * (a.stress[0][p] + replace);
				txy[k]               = -a.volume[p] * a.stress[3][p];
				tyy[k]               = -a.volume[p] * (a.stress[1][p] + replace);
				capacity[k]          = Carried ? a.capacity[p] : 0.0;
				content[k]           = Carried ? a.capacity[p] * (a.carried[p] - a.carriedFrom) : 0.0;
			}
			for (int k = 0; k < count; ++k) {
				const PointWeights s(w, k);
				double*            base  = a.nodes + static_cast<long>(w.base[k]) * PlaneLoops::motionSize;
				const Numbers<4>   value = numbers(0.0, 0.0, capacity[k], content[k]);
				scatter(s, at, base, numbers(mass[k], px[k], py[k], 0.0));
				scatter<Numbers<4>>(s, at, base + 4, value, numbers(txx[k], txy[k], 0.0, 0.0), numbers(txy[k], tyy[k], 0.0, 0.0));
			}
		}

		void mapMotion(const WeightBlock<2>& w, const PlaneLoops::MotionMap& a)
		{
			if (a.capacity) a.meanStress ? mapMotionWith<true, true>(w, a) : mapMotionWith<true, false>(w, a);
			else a.meanStress ? mapMotionWith<false, true>(w, a) : mapMotionWith<false, false>(w, a);
		}

		void gatherMotion(const WeightBlock<2>& w, const PlaneLoops::MotionGather& a)
		{
			const Offsets at(w, 4);
			const int     count = w.count, first = w.first;
			double        change[2][blockSize], v[2][blockSize], l[4][blockSize];
			for (int k = 0; k < count; ++k) {
				const Sums<Numbers<4>> sums = gather<Numbers<4>>(PointWeights(w, k), at, a.nodes + static_cast<long>(w.base[k]) * 4);
				double                 value[4], alongX[4], alongY[4];
				store(sums.value, value);
				store(sums.alongX, alongX);
				store(sums.alongY, alongY);
				change[0][k] = value[0];
				change[1][k] = value[1];
				v[0][k]      = value[2];
				v[1][k]      = value[3];
				l[0][k]      = alongX[2];
				l[1][k]      = alongY[2];
				l[2][k]      = alongX[3];
				l[3][k]      = alongY[3];
			}
			const double chi = a.kept, dt = a.dt;
			for (int i = 0; i < 2; ++i) {
				double* velocity     = a.velocity[i] + first;
				double* position     = a.position[i] + first;
				double* displacement = a.displacement[i] + first;
				for (int k = 0; k < count; ++k) {
					velocity[k] = chi * velocity[k] + change[i][k];
					position[k] += dt * v[i][k];
					displacement[k] += dt * v[i][k];
				}
			}
			for (int c = 0; c < 4; ++c) {
				double* gradient = a.gradient[c] + first;
				for (int k = 0; k < count; ++k)
					gradient[k] = dt * l[c][k];
			}
		}

		void mapEight(const WeightBlock<2>& w, const double (&values)[8][blockSize], double* nodes)
		{
			const Offsets at(w, 8);
			for (int k = 0; k < w.count; ++k) {
				const auto low  = numbers(values[0][k], values[1][k], values[2][k], values[3][k]),
				           high = numbers(values[4][k], values[5][k], values[6][k], values[7][k]);
				scatter(PointWeights(w, k), at, nodes + static_cast<long>(w.base[k]) * 8, numbers(low, high));
			}
		}

		void mapTwo(const WeightBlock<2>& w, const double (&values)[2][blockSize], double* nodes)
		{
			const Offsets at(w, 2);
			for (int k = 0; k < w.count; ++k)
				scatter(PointWeights(w, k), at, nodes + static_cast<long>(w.base[k]) * 2, numbers(values[0][k], values[1][k]));
		}

		void gatherEight(const WeightBlock<2>& w, const double* nodes, double (&sums)[8][blockSize])
		{
			const Offsets at(w, 8);
			for (int k = 0; k < w.count; ++k) {
				double record[8];
				store(gather<Numbers<8>>(PointWeights(w, k), at, nodes + static_cast<long>(w.base[k]) * 8).value, record);
				for (int i = 0; i < 8; ++i)
					sums[i][k] = record[i];
			}
		}

		void gatherScalar(const WeightBlock<2>& w, const double* nodes, double (&sums)[blockSize])
		{
			const Offsets at(w, 1);
			for (int k = 0; k < w.count; ++k)
				store(gather<Numbers<1>>(PointWeights(w, k), at, nodes + w.base[k]).value, sums + k);
		}

		/// Slopes of pressure (0 and 1), of temperature (2 and 3), and its value (4).
		struct Potentials {
			double number[5][blockSize];
		};

		template <bool Heat> void gatherPotentials(const WeightBlock<2>& w, const double* nodes, Potentials& g)
		{
			const Offsets at(w, PlaneLoops::potentialSize);
			for (int k = 0; k < w.count; ++k) {
				const Sums<Numbers<4>> sums = gather<Numbers<4>>(
				        PointWeights(w, k), at, nodes + static_cast<long>(w.base[k]) * PlaneLoops::potentialSize);
				double value[4], alongX[4], alongY[4];
				store(sums.value, value);
				store(sums.alongX, alongX);
				store(sums.alongY, alongY);
				g.number[0][k] = alongX[0];
				g.number[1][k] = alongY[0];
				if (!Heat) continue;
				g.number[2][k] = alongX[3];
				g.number[3][k] = alongY[3];
				g.number[4][k] = value[3];
			}
		}

		void gatherTemperature(const WeightBlock<2>& w, const double* nodes, Potentials& g)
		{
			const Offsets at(w, 1);
			for (int k = 0; k < w.count; ++k) {
				const Sums<Numbers<1>> sums = gather<Numbers<1>>(PointWeights(w, k), at, nodes + w.base[k]);
				store(sums.alongX, &g.number[2][k]);
				store(sums.alongY, &g.number[3][k]);
				store(sums.value, &g.number[4][k]);
			}
		}

		/// Heat that leaves a point per nodal slope, what it produces, and its capacity times what the grid does not see.
		void findHeatFlow(const WeightBlock<2>& w, const PlaneLoops::HeatFlow& h, Potentials& g, double (&produced)[blockSize])
		{
			const double* const volume       = h.volume + w.first;
			const double* const conductivity = h.conductivity + w.first;
			const double* const capacity     = h.capacity + w.first;
			const double* const temperature  = h.temperature + w.first;
			for (int k = 0; k < w.count; ++k) {
				const double conductance = -volume[k] * conductivity[k] * h.duration;
				g.number[2][k] *= conductance;
				g.number[3][k] *= conductance;
				g.number[4][k] = capacity[k] * (g.number[4][k] - (temperature[k] - h.reference));
				produced[k]    = volume[k] * h.produced;
			}
		}

		void flowHeat(const WeightBlock<2>& w, const PlaneLoops::HeatFlow& h, const double* potential, double* received)
		{
			const Offsets at(w, 2);
			Potentials    g;
			double        produced[blockSize];
			gatherTemperature(w, potential, g);
			findHeatFlow(w, h, g, produced);
			for (int k = 0; k < w.count; ++k) {
				const auto all = numbers(produced[k], g.number[4][k]), alongX = numbers(g.number[2][k], 0.0),
				           alongY = numbers(g.number[3][k], 0.0);
				scatter<Numbers<2>>(PointWeights(w, k), at, received + static_cast<long>(w.base[k]) * 2, all, alongX, alongY);
			}
		}

		template <bool Heat>
		void flowBoth(const WeightBlock<2>& w, const PlaneLoops::HeatFlow& h, const double* volume, const double* potential, double* received)
		{
			const Offsets at(w, PlaneLoops::potentialSize);
			Potentials    g;
			double        produced[blockSize];
			gatherPotentials<Heat>(w, potential, g);
			for (int k = 0; k < w.count; ++k) {
				g.number[0][k] *= volume[w.first + k];
				g.number[1][k] *= volume[w.first + k];
			}
			if (Heat) findHeatFlow(w, h, g, produced);
			for (int k = 0; k < w.count; ++k) {
				const PointWeights s(w, k);
				double*            base = received + static_cast<long>(w.base[k]) * PlaneLoops::potentialSize;
				if constexpr (Heat)
					scatter<Numbers<4>>(
					        s, at, base, numbers(g.number[0][k], g.number[1][k], produced[k], g.number[4][k]),
					        numbers(0.0, 0.0, g.number[2][k], 0.0), numbers(0.0, 0.0, g.number[3][k], 0.0));
				else scatter<Numbers<4>>(s, at, base, numbers(g.number[0][k], g.number[1][k], 0.0, 0.0));
			}
		}

		void flowPressure(const WeightBlock<2>& w, const double* volume, const double* potential, double* received)
		{
			flowBoth<false>(w, {}, volume, potential, received);
		}
		void flowHeatAndPressure(const WeightBlock<2>& w, const PlaneLoops::HeatFlow& h, const double* potential, double* received)
		{
			flowBoth<true>(w, h, h.volume, potential, received);
		}

		void seep(const WeightBlock<2>& w, const PlaneLoops::Seepage& s)
		{
			const Offsets at(w, 2), to(w, 8);
			double        q[2][blockSize], heat[blockSize];
			for (int k = 0; k < w.count; ++k) {
				double total[2];
				store(gather<Numbers<2>>(PointWeights(w, k), at, s.flux + static_cast<long>(w.base[k]) * 2).value, total);
				q[0][k] = total[0];
				q[1][k] = total[1];
			}
			for (int k = 0; k < w.count; ++k) {
				const double scale = s.massPerFlux * s.volume[w.first + k];
				q[0][k] *= scale;
				q[1][k] *= scale;
				heat[k] = s.temperature ? s.specificHeat * s.temperature[w.first + k] + s.enthalpyAtZero : 0.0;
			}
			for (int k = 0; k < w.count; ++k) {
				const Numbers<4> carried = numbers(1.0, heat[k], s.velocity[0][w.first + k], s.velocity[1][w.first + k]);
				scatter<Numbers<4>>(
				        PointWeights(w, k), to, s.exchange + static_cast<long>(w.base[k]) * 8, Nothing(), scaled(carried, q[0][k]),
				        scaled(carried, q[1][k]));
			}
		}

		void elastic(int count, const double* lambda, const double* shear, const double* const (&gradient)[4], double* const (&stress)[4])
		{
			const double* const g0 = gradient[0];
			const double* const g1 = gradient[1];
			const double* const g2 = gradient[2];
			const double* const g3 = gradient[3];
			double* const       sx = stress[0];
			double* const       sy = stress[1];
			double* const       sz = stress[2];
			double* const       st = stress[3];
			// fields of the points never overlap
#pragma GCC ivdep
			for (int p = 0; p < count; ++p) {
				const double a = 1.0 + 0.5 * g0[p], b = 0.5 * g1[p], c = 0.5 * g2[p], d = 1.0 + 0.5 * g3[p];
				const double inverse = 1.0 / (a * d - b * c);
				const double h00 = (g0[p] * d - g1[p] * c) * inverse, h01 = (g1[p] * a - g0[p] * b) * inverse;
				const double h10 = (g2[p] * d - g3[p] * c) * inverse, h11 = (g3[p] * a - g2[p] * b) * inverse;
				const double t = 0.25 * (h10 - h01), scale = 1.0 / (1.0 + t * t);
				const double cosine = (1.0 - t * t) * scale, sine = 2.0 * t * scale;
				const double xx         = cosine * cosine * sx[p] - 2.0 * cosine * sine * st[p] + sine * sine * sy[p];
				const double yy         = sine * sine * sx[p] + 2.0 * cosine * sine * st[p] + cosine * cosine * sy[p];
				const double xy         = cosine * sine * (sx[p] - sy[p]) + (cosine * cosine - sine * sine) * st[p];
				const double volumetric = lambda[p] * (h00 + h11);
				sx[p]                   = xx + (volumetric + 2.0 * shear[p] * h00);
				sy[p]                   = yy + (volumetric + 2.0 * shear[p] * h11);
				sz[p]                   = sz[p] + volumetric;
				st[p]                   = xy + 2.0 * shear[p] * (0.5 * (h01 + h10));
			}
		}

		void findYielding(int count, const PlaneLoops::Strength& strength, const double* const (&stress)[4], long long* yielding)
		{
			const double* const xx       = stress[0];
			const double* const yy       = stress[1];
			const double* const zz       = stress[2];
			const double* const xy       = stress[3];
			const double* const cohesion = strength.cohesion;
			const double* const tensile  = strength.tensileStrength;
			const double        sine = strength.sinFriction, twoCosine = 2.0 * strength.cosFriction;
#pragma GCC ivdep
			for (int k = 0; k < count; ++k) {
				const double centre = 0.5 * (xx[k] + yy[k]), half = 0.5 * (xx[k] - yy[k]);
				const double radius = __builtin_sqrt(half * half + xy[k] * xy[k]), most = centre + radius, least = centre - radius;
				const double high = most > zz[k] ? most : zz[k], low = least < zz[k] ? least : zz[k];
				const double cone = (high - low) + (high + low) * sine - cohesion[k] * twoCosine, cut = high - tensile[k];
				// stresses that are not numbers count as yielding
				yielding[k] = (cone > cut ? cone : cut) <= 0.0 ? 0 : 1;
			}
		}

		PlaneLoops::Extent extent(int count, const double* x)
		{
			constexpr int lanes = 8; // independent of each other, so that the compiler makes vectors of them
			double        low[lanes], high[lanes], notFinite[lanes];
			for (int l = 0; l < lanes; ++l) {
				low[l] = high[l] = x[0];
				notFinite[l]     = 0.0;
			}
			int k = 0;
			for (; k + lanes <= count; k += lanes)
				for (int l = 0; l < lanes; ++l) {
					const double value = x[k + l];
					low[l]             = value < low[l] ? value : low[l];
					high[l]            = value > high[l] ? value : high[l];
					notFinite[l] += value - value;
				}
			for (; k < count; ++k) {
				low[0]  = x[k] < low[0] ? x[k] : low[0];
				high[0] = x[k] > high[0] ? x[k] : high[0];
				notFinite[0] += x[k] - x[k];
			}
			PlaneLoops::Extent all { low[0], high[0], notFinite[0] == 0.0 };
			for (int l = 1; l < lanes; ++l) {
				all.low     = low[l] < all.low ? low[l] : all.low;
				all.high    = high[l] > all.high ? high[l] : all.high;
				all.numbers = all.numbers && notFinite[l] == 0.0;
			}
			return all;
		}

	} // namespace

	const PlaneLoops& versionOfPlaneLoops()
	{
		static constexpr bool   roundsOnce = HWY_NATIVE_FMA != 0;
		static const PlaneLoops loops { hwy::TargetName(HWY_TARGET),
			                        roundsOnce,
			                        &spline,
			                        &mapMotion,
			                        &gatherMotion,
			                        &mapEight,
			                        &mapTwo,
			                        &gatherEight,
			                        &gatherScalar,
			                        &flowHeat,
			                        &flowPressure,
			                        &flowHeatAndPressure,
			                        &seep,
			                        &elastic,
			                        &findYielding,
			                        &extent };
		return loops;
	}

} // namespace HWY_NAMESPACE
} // namespace talik
HWY_AFTER_NAMESPACE();

#if HWY_ONCE
namespace talik {

HWY_EXPORT(versionOfPlaneLoops);

const PlaneLoops& planeLoops()
{
	static const PlaneLoops& best = HWY_DYNAMIC_DISPATCH(versionOfPlaneLoops)();
	return best;
}

std::vector<const PlaneLoops*> planeLoopVersions()
{
	std::vector<const PlaneLoops*> versions;
	const auto                     allow = [](std::int64_t targets) {
                hwy::SetSupportedTargetsForTest(targets);
                hwy::GetChosenTarget().Update(hwy::SupportedTargets());
	};
	for (const std::int64_t target : hwy::SupportedAndGeneratedTargets()) {
		allow(target);
		versions.push_back(&HWY_DYNAMIC_DISPATCH(versionOfPlaneLoops)());
	}
	allow(0); // all again
	return versions;
}

} // namespace talik
#endif
