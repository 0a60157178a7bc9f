// SPDX-License-Identifier: GPL-2.0-or-later
#include <pkg/rve/packed/PackedStepView.hpp>

// This unit is compiled for AVX2 and FMA and called only where the processor has them. Everything below is local to the unit or is
// built into the compiler: an inline function shared with other units could be merged with theirs and run where it must not.
#if defined(__AVX2__) && defined(__FMA__)
#include <immintrin.h>

namespace talik {

namespace {

	using Four = __m256d;

	struct Columns {
		Four a, b, c, d;
	};

	/// Rows (a b c d) of four grains to columns, or back.
	inline Columns transpose(Four r0, Four r1, Four r2, Four r3)
	{
		const Four low01 = _mm256_unpacklo_pd(r0, r1), high01 = _mm256_unpackhi_pd(r0, r1);
		const Four low23 = _mm256_unpacklo_pd(r2, r3), high23 = _mm256_unpackhi_pd(r2, r3);
		return { _mm256_permute2f128_pd(low01, low23, 0x20), _mm256_permute2f128_pd(high01, high23, 0x20),
			     _mm256_permute2f128_pd(low01, low23, 0x31), _mm256_permute2f128_pd(high01, high23, 0x31) };
	}

	inline Four splat(double value) { return _mm256_set1_pd(value); }
	inline Four signBit() { return _mm256_set1_pd(-0.0); }

	/// Row numbers times four serve as offsets: row of four doubles at base + offset, single double at base + offset / 4.
	inline const double* rowAt(const double* base, std::uint32_t offset) { return base + offset; }
	inline double*       rowAt(double* base, std::uint32_t offset) { return base + offset; }
	inline const double* singleAt(const double* base, std::uint32_t offset)
	{
		return reinterpret_cast<const double*>(reinterpret_cast<const char*>(base) + 2 * std::size_t(offset));
	}

	/// Parameters of the contact law, four times each.
	struct Constants {
		Four friction, shearStep, bondFriction;
	};

	/// Force on the second grain, shear force and s u_n/2 of four pairs.
	struct Response {
		Four gx, gy, shear, moment;
	};

	/// Branch, relative velocity, w_1 r_1 + w_2 r_2 and distance of four pairs.
	struct Gathered {
		Four dx, dy, dvx, dvy, wr, distance, inverse;
	};

	template <bool Periodic> inline Gathered gather(const double* motion, const double* spin, const double* shiftMotion, const PackedBlock<2>& block, const std::uint32_t* shift)
	{
		Four rows[4];
		for (int l = 0; l < 4; ++l) {
			rows[l] = _mm256_sub_pd(_mm256_load_pd(rowAt(motion, block.second[l])), _mm256_load_pd(rowAt(motion, block.first[l])));
			if (Periodic) rows[l] = _mm256_add_pd(rows[l], _mm256_load_pd(rowAt(shiftMotion, shift[l])));
		}
		const Columns columns = transpose(rows[0], rows[1], rows[2], rows[3]);
		const __m128d first0  = _mm_loadh_pd(_mm_load_sd(singleAt(spin, block.first[0])), singleAt(spin, block.first[1]));
		const __m128d first1  = _mm_loadh_pd(_mm_load_sd(singleAt(spin, block.first[2])), singleAt(spin, block.first[3]));
		const __m128d second0 = _mm_loadh_pd(_mm_load_sd(singleAt(spin, block.second[0])), singleAt(spin, block.second[1]));
		const __m128d second1 = _mm_loadh_pd(_mm_load_sd(singleAt(spin, block.second[2])), singleAt(spin, block.second[3]));
		const Four    wr      = _mm256_set_m128d(_mm_add_pd(first1, second1), _mm_add_pd(first0, second0));
		const Four    distance = _mm256_sqrt_pd(_mm256_fmadd_pd(columns.a, columns.a, _mm256_mul_pd(columns.b, columns.b)));
		return { columns.a, columns.b, columns.c, columns.d, wr, distance, _mm256_div_pd(splat(1.), distance) };
	}

	/// Adds rows (G_x, G_y, s, s u_n/2) to both grains; G changes sign for the second.
	template <bool Periodic>
	inline void scatter(double* force, double* shiftForce, const PackedBlock<2>& block, const std::uint32_t* shift, const Response& r)
	{
		const Columns rows   = transpose(r.gx, r.gy, r.shear, r.moment);
		const Four    row[4] = { rows.a, rows.b, rows.c, rows.d };
		const Four    turn   = _mm256_set_pd(0., 0., -0., -0.);
		for (int l = 0; l < 4; ++l) {
			double* first  = rowAt(force, block.first[l]);
			double* second = rowAt(force, block.second[l]);
			_mm256_store_pd(first, _mm256_add_pd(_mm256_load_pd(first), row[l]));
			_mm256_store_pd(second, _mm256_add_pd(_mm256_load_pd(second), _mm256_xor_pd(row[l], turn)));
			if (Periodic) {
				double* sum = rowAt(shiftForce, shift[l]);
				_mm256_store_pd(sum, _mm256_add_pd(_mm256_load_pd(sum), row[l]));
			}
		}
	}

	/// One block off the straight path.
	struct BondTrial {
		Four overlap, raw, trial, increment;
		Four normalForce, shear, iceShear; ///< in and out
	};

	/// Bonds that reached a limit, and broken ones that opened.
	__attribute__((noinline)) void reportBonds(PackedStepView<2>& view, int periodic, std::size_t blockNumber, int lanes, BondTrial& t)
	{
		alignas(32) double overlaps[4], forces[4], raws[4], shears[4], trials[4], iceShears[4], increments[4];
		_mm256_store_pd(overlaps, t.overlap);
		_mm256_store_pd(forces, t.normalForce);
		_mm256_store_pd(raws, t.raw);
		_mm256_store_pd(shears, t.shear);
		_mm256_store_pd(trials, t.trial);
		_mm256_store_pd(iceShears, t.iceShear);
		_mm256_store_pd(increments, t.increment);
		for (int l = 0; l < 4; ++l) {
			if (!(lanes >> l & 1)) continue;
			PackedBondEvent<2> event { periodic, 4 * blockNumber + std::size_t(l), overlaps[l], raws[l], { trials[l] }, { iceShears[l] }, { increments[l] } };
			view.bondEvent(view.owner, &event);
			forces[l]    = event.normalForce;
			shears[l]    = event.shear[0];
			iceShears[l] = event.iceShear[0];
		}
		t.normalForce = _mm256_load_pd(forces);
		t.shear       = _mm256_load_pd(shears);
		t.iceShear    = _mm256_load_pd(iceShears);
	}

	template <bool Bonded> inline Response respond(PackedStepView<2>& view, const PackedPairs<2>& pairs, std::size_t b, int periodic, const Constants& c, const Gathered& g)
	{
		const Four      zero = _mm256_setzero_pd(), half = splat(0.5), sign = signBit();
		PackedBlock<2>& block      = pairs.block[b];
		const Four      sum        = _mm256_load_pd(block.sumRadius), stiffness = _mm256_load_pd(block.stiffness);
		const Four      overlap    = _mm256_sub_pd(sum, g.distance);
		const Four      nx         = _mm256_mul_pd(g.dx, g.inverse), ny = _mm256_mul_pd(g.dy, g.inverse);
		const Four      tangential = _mm256_fmsub_pd(g.dvy, nx, _mm256_mul_pd(g.dvx, ny));
		const Four      slip       = _mm256_fmsub_pd(_mm256_mul_pd(sum, g.inverse), tangential, g.wr);
		const Four      increment  = _mm256_mul_pd(_mm256_mul_pd(c.shearStep, stiffness), slip);
		const Four      trial      = _mm256_sub_pd(_mm256_load_pd(block.shear[0]), increment);
		Four            normalForce, shear;
		if (Bonded) {
			PackedIceBlock<2>& ice   = pairs.ice[b];
			const Four         floor = _mm256_load_pd(ice.floor), share = _mm256_load_pd(ice.iceShare);
			const Four         raw   = _mm256_sub_pd(_mm256_mul_pd(stiffness, overlap), _mm256_load_pd(ice.offset));
			normalForce              = _mm256_max_pd(raw, floor);
			const Four rub           = _mm256_blendv_pd(c.friction, c.bondFriction, floor); // by the sign: an intact bond
			const Four cap           = _mm256_fmadd_pd(rub, _mm256_max_pd(raw, zero), _mm256_load_pd(ice.cohesion));
			shear                    = _mm256_min_pd(_mm256_max_pd(trial, _mm256_xor_pd(cap, sign)), cap);
			Four       iceShear      = _mm256_fnmadd_pd(share, increment, _mm256_load_pd(ice.iceShear[0]));
			const Four limited       = _mm256_cmp_pd(trial, shear, _CMP_NEQ_OQ);
			const Four opened        = _mm256_and_pd(_mm256_cmp_pd(raw, floor, _CMP_LT_OQ), _mm256_cmp_pd(floor, zero, _CMP_NEQ_OQ));
			// from here on only sign bits count: that of the floor marks an intact bond
			const Four shared        = _mm256_and_pd(limited, _mm256_or_pd(floor, _mm256_cmp_pd(share, zero, _CMP_NEQ_OQ)));
			const int  aside         = _mm256_movemask_pd(_mm256_or_pd(opened, shared));
			if (__builtin_expect(aside != 0, 0)) {
				// a broken bond slides: the ice's share shrinks with the rest
				const Four sliding = _mm256_andnot_pd(_mm256_or_pd(opened, floor), shared);
				iceShear           = _mm256_blendv_pd(iceShear, _mm256_mul_pd(iceShear, _mm256_div_pd(shear, trial)), sliding);
				const int lanes    = _mm256_movemask_pd(_mm256_or_pd(opened, _mm256_andnot_pd(sliding, shared)));
				if (lanes != 0) {
					BondTrial t { overlap, raw, trial, increment, normalForce, shear, iceShear };
					reportBonds(view, periodic, b, lanes, t);
					normalForce = t.normalForce;
					shear       = t.shear;
					iceShear    = t.iceShear;
				}
			}
			_mm256_store_pd(ice.iceShear[0], iceShear);
		} else {
			normalForce    = _mm256_max_pd(_mm256_mul_pd(stiffness, overlap), zero);
			const Four cap = _mm256_mul_pd(c.friction, normalForce);
			shear          = _mm256_min_pd(_mm256_max_pd(trial, _mm256_xor_pd(cap, sign)), cap);
		}
		_mm256_store_pd(block.shear[0], shear);
		return { _mm256_fnmadd_pd(shear, ny, _mm256_mul_pd(normalForce, nx)), _mm256_fmadd_pd(shear, nx, _mm256_mul_pd(normalForce, ny)), shear,
			     _mm256_mul_pd(_mm256_mul_pd(half, overlap), shear) };
	}

	// The next block is gathered, and its square root and quotient started, before the law and the sums of the present one: the long
	// latencies then run under work that does not need them.
	template <bool Bonded, bool Periodic> inline void contactLoop(PackedStepView<2>& view, const PackedPairs<2>& pairs)
	{
		const Constants   c { splat(view.friction), splat(view.stiffnessRatio * view.dt), splat(view.bondFriction) };
		const std::size_t end = pairs.blocks;
		if (end == 0) return;
		const auto prepare = [&](std::size_t b) __attribute__((always_inline)) {
			return gather<Periodic>(view.motion, view.spin, view.shiftMotion, pairs.block[b], Periodic ? pairs.shift + 4 * b : nullptr);
		};
		const auto finish = [&](std::size_t b, const Gathered& gathered) __attribute__((always_inline)) {
			const Response r = respond<Bonded>(view, pairs, b, Periodic, c, gathered);
			scatter<Periodic>(view.force, view.shiftForce, pairs.block[b], Periodic ? pairs.shift + 4 * b : nullptr, r);
		};
		Gathered    present = prepare(0);
		std::size_t b       = 0;
		for (; b + 2 < end; b += 2) {
			const Gathered next = prepare(b + 1);
			finish(b, present);
			present = prepare(b + 2);
			finish(b + 1, next);
		}
		if (b + 1 < end) {
			const Gathered last = prepare(b + 1);
			finish(b, present);
			finish(b + 1, last);
		} else {
			finish(b, present);
		}
	}

	template <bool Bonded> void contacts(PackedStepView<2>* view)
	{
		contactLoop<Bonded, false>(*view, view->inner);
		contactLoop<Bonded, true>(*view, view->periodic);
	}

	/// Acceleration times 1 - damping sign(acceleration (velocity + dt/2 acceleration)).
	inline Four damped(Four acceleration, Four velocity, Four damping, Four halfStep)
	{
		const Four power = _mm256_mul_pd(acceleration, _mm256_fmadd_pd(halfStep, acceleration, velocity));
		const Four share = _mm256_or_pd(damping, _mm256_and_pd(power, signBit()));
		return _mm256_fnmadd_pd(share, acceleration, acceleration);
	}

	template <bool Jumps, bool Stress> void integrateGrains(PackedStepView<2>& view)
	{
		const double* l = view.prevVelGrad;
		const double  jump[4] = { view.nextVelGrad[0] - l[0], view.nextVelGrad[1] - l[1], view.nextVelGrad[2] - l[2], view.nextVelGrad[3] - l[3] };
		const Four    lxx = splat(l[0]), lxy = splat(l[1]), lyx = splat(l[2]), lyy = splat(l[3]);
		const Four    jxx = splat(jump[0]), jxy = splat(jump[1]), jyx = splat(jump[2]), jyy = splat(jump[3]);
		const Four    spinJump = splat(-0.5 * (jump[1] - jump[2]));
		const Four    dt = splat(view.dt), halfStep = splat(0.5 * view.dt), damping = splat(view.damping), zero = _mm256_setzero_pd();
		Four          sxx = zero, sxy = zero, syx = zero, syy = zero, largest = zero;
		for (std::size_t i = 0; i < view.grains; i += 4) {
			double*       m = view.motion + 4 * i;
			double*       f = view.force + 4 * i;
			const Columns motion = transpose(_mm256_load_pd(m), _mm256_load_pd(m + 4), _mm256_load_pd(m + 8), _mm256_load_pd(m + 12));
			const Columns force  = transpose(_mm256_load_pd(f), _mm256_load_pd(f + 4), _mm256_load_pd(f + 8), _mm256_load_pd(f + 12));
			for (int k = 0; k < 16; k += 4)
				_mm256_store_pd(f + k, zero);
			const Four minusInverseMass = _mm256_load_pd(view.minusInverseMass + i);
			const Four meanX = _mm256_fmadd_pd(lxx, motion.a, _mm256_mul_pd(lxy, motion.b));
			const Four meanY = _mm256_fmadd_pd(lyx, motion.a, _mm256_mul_pd(lyy, motion.b));
			Four       ax    = damped(_mm256_mul_pd(force.a, minusInverseMass), _mm256_sub_pd(motion.c, meanX), damping, halfStep);
			Four       ay    = damped(_mm256_mul_pd(force.b, minusInverseMass), _mm256_sub_pd(motion.d, meanY), damping, halfStep);
			ax               = _mm256_fmadd_pd(lxx, motion.c, _mm256_fmadd_pd(lxy, motion.d, ax));
			ay               = _mm256_fmadd_pd(lyx, motion.c, _mm256_fmadd_pd(lyy, motion.d, ay));
			Four vx = _mm256_fmadd_pd(dt, ax, motion.c), vy = _mm256_fmadd_pd(dt, ay, motion.d);
			const Four fx = _mm256_sub_pd(vx, meanX), fy = _mm256_sub_pd(vy, meanY);
			largest = _mm256_max_pd(largest, _mm256_fmadd_pd(fx, fx, _mm256_mul_pd(fy, fy)));
			if (Jumps) {
				vx = _mm256_fmadd_pd(jxx, motion.a, _mm256_fmadd_pd(jxy, motion.b, vx));
				vy = _mm256_fmadd_pd(jyx, motion.a, _mm256_fmadd_pd(jyy, motion.b, vy));
			}
			const Four    x = _mm256_fmadd_pd(dt, vx, motion.a), y = _mm256_fmadd_pd(dt, vy, motion.b);
			const Columns rows = transpose(x, y, vx, vy);
			_mm256_store_pd(m, rows.a);
			_mm256_store_pd(m + 4, rows.b);
			_mm256_store_pd(m + 8, rows.c);
			_mm256_store_pd(m + 12, rows.d);
			if (Stress) {
				sxx = _mm256_fmadd_pd(force.a, x, sxx);
				sxy = _mm256_fmadd_pd(force.a, y, sxy);
				syx = _mm256_fmadd_pd(force.b, x, syx);
				syy = _mm256_fmadd_pd(force.b, y, syy);
			}
			const Four radius = _mm256_load_pd(view.radius + i);
			const Four torque = _mm256_fnmadd_pd(radius, force.c, force.d);
			Four       w      = _mm256_load_pd(view.angular + i);
			w                 = _mm256_fmadd_pd(dt, damped(_mm256_mul_pd(torque, _mm256_load_pd(view.inverseInertia + i)), w, damping, halfStep), w);
			if (Jumps) w = _mm256_add_pd(w, spinJump);
			_mm256_store_pd(view.angular + i, w);
			_mm256_store_pd(view.orientation + i, _mm256_fmadd_pd(dt, w, _mm256_load_pd(view.orientation + i)));
			_mm256_store_pd(view.spin + i, _mm256_mul_pd(w, radius));
		}
		alignas(32) double lane[4];
		_mm256_store_pd(lane, largest);
		double most = 0;
		for (int k = 0; k < 4; ++k)
			most = lane[k] > most ? lane[k] : most;
		view.maxFluctuationSquare = most;
		if (!Stress) return;
		const Four sums[4] = { sxx, sxy, syx, syy };
		for (int k = 0; k < 4; ++k) {
			_mm256_store_pd(lane, sums[k]);
			view.virial[k] = (lane[0] + lane[1]) + (lane[2] + lane[3]);
		}
	}

	void integrate(PackedStepView<2>* view)
	{
		bool jumps = false;
		for (int k = 0; k < 4; ++k)
			jumps |= view->nextVelGrad[k] != view->prevVelGrad[k];
		if (jumps) view->sampleStress ? integrateGrains<true, true>(*view) : integrateGrains<true, false>(*view);
		else view->sampleStress ? integrateGrains<false, true>(*view) : integrateGrains<false, false>(*view);
	}

} // namespace

PackedKernel<2> avx2Kernel(bool bonded)
{
	if (bonded) return { contacts<true>, integrate, "avx2" };
	return { contacts<false>, integrate, "avx2" };
}

bool avx2KernelBuilt() { return true; }

} // namespace talik

#else

namespace talik {

PackedKernel<2> avx2Kernel(bool) { return { nullptr, nullptr, "avx2" }; }
bool            avx2KernelBuilt() { return false; }

} // namespace talik

#endif
