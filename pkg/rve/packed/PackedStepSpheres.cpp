// SPDX-License-Identifier: GPL-2.0-or-later
// The fused step of spheres on vectors, in stock YADE's conventions (ScGeom with avoidGranularRatcheting), compiled once for every kind of
// processor that Highway knows. Which one runs is chosen when the program runs. Vectors of variable length (SVE, RVV) cannot be members of
// a structure and are left out.
#define HWY_WANT_AVX3_DL // Highway of Debian 12 leaves it out unless it is asked for
#undef HWY_DISABLED_TARGETS
#define HWY_DISABLED_TARGETS (HWY_SSSE3 | HWY_SVE | HWY_SVE2 | HWY_SVE_256 | HWY_SVE2_128 | HWY_RVV)
#undef HWY_TARGET_INCLUDE
#define HWY_TARGET_INCLUDE "pkg/rve/packed/PackedStepSpheres.cpp"
#include <hwy/foreach_target.h>

#include <hwy/highway.h>
#include <pkg/icebond/ContactForces.hpp>
#include <pkg/rve/packed/PackedVectors.hpp>

HWY_BEFORE_NAMESPACE();
namespace talik {
namespace HWY_NAMESPACE {
	namespace {

		using Vector = InSpace<Many>;
		using Forces = ContactForces<Many, Vector>;

		/// A vector in space, kept.
		struct KeptVector {
			Kept              x, y, z;
			HWY_INLINE Vector operator()() const { return { x(), y(), z() }; }
			HWY_INLINE void   operator=(const Vector& v)
			{
				x = v.x;
				y = v.y;
				z = v.z;
			}
		};

		/// Of some pairs.
		struct Gathered {
			KeptVector n;
			Kept       rimX; ///< of w_1 r_1 + w_2 r_2
			Kept       distance, inverse;
		};

		/// How some pairs move in the step: turn of the contact, as it carries forces along, and what reduces its shear force.
		struct Moved {
			KeptVector turn, increment;
		};

		/// What a contact gives the sums; Turning: moments that are not those of forces.
		template <bool Turning> struct ResponseOf {
			Kept normal;
		};
		template <> struct ResponseOf<true> : ResponseOf<false> {
			KeptVector moment; ///< of rolling and of bonds, on the second grain
		};

		/// Columns of second + sign first, Length numbers of rows that are Row numbers apart, and of the shift's row if there is one.
		template <std::size_t Length, std::size_t Row, bool Shifted = false>
		HWY_INLINE auto gatherColumns(double* from, const Place<3>& p, const double* sign, double* shifts = nullptr)
		{
			if constexpr (Length > inRow) {
				return EightColumns { gatherColumns<4, Row, Shifted>(from, p, sign, shifts),
					              gatherColumns<4, Row, Shifted>(from + 4, p, sign + 4, Shifted ? shifts + 4 : nullptr) };
			} else {
				Rows<Length> rows;
				forRows([&](std::size_t l) HWY_ATTR TALIK_INLINED {
					const double *first = rowAt<3, Row>(from, p.first()[l]), *second = rowAt<3, Row>(from, p.second()[l]);
					const double* shift = Shifted ? rowAt<3, Row>(shifts, p.shift()[l]) : nullptr;
					rows.setRow(l, [&](std::size_t at) HWY_ATTR TALIK_INLINED {
						const auto sum = MulAdd(rows.numbers(sign + at), rows.numbers(first + at), rows.numbers(second + at));
						if constexpr (Shifted) return Add(sum, rows.numbers(shift + at));
						else return sum;
					});
				});
				return columnsOf(rows);
			}
		}

		alignas(packedAlignment) static constexpr double lessButLast[8] = { -1, -1, -1, 1, 1, 1, 1, 1 };
		alignas(packedAlignment) static constexpr double lessFour[8]    = { -1, -1, -1, -1, 1, 1, 1, 1 };

		template <bool Periodic> HWY_INLINE void gather(const PackedStepView<3>& view, const Place<3>& p, Gathered& g)
		{
			const Columns x = gatherColumns<4, 4, Periodic>(view.place, p, lessButLast, view.shiftPlace);
			const Vector  branch { x.a, x.b, x.c };
			const Many    distance = Sqrt(dot(branch, branch)), inverse = Div(splat(1.), distance);
			g.n        = scaled(branch, inverse);
			g.rimX     = x.d;
			g.distance = distance;
			g.inverse  = inverse;
		}

		/// Adds to rows of force, from a number on: what comes first, the forces, with other sign to those of the second grains.
		template <bool Periodic, class SomeRows>
		HWY_INLINE void addRows(const PackedStepView<3>& view, const Place<3>& p, std::size_t from, const SomeRows& ofFirst, const SomeRows& ofSecond)
		{
			forRows([&](std::size_t l) HWY_ATTR TALIK_INLINED {
				double* const first  = rowAt<3, 8>(view.force, p.first()[l]) + from;
				double* const second = rowAt<3, 8>(view.force, p.second()[l]) + from;
				ofFirst.forRow(l, [&](auto part, std::size_t at) HWY_ATTR TALIK_INLINED {
					store(Add(ofFirst.numbers(first + at), part), first + at);
				});
				ofSecond.forRow(l, [&](auto part, std::size_t at) HWY_ATTR TALIK_INLINED {
					store(MulAdd(ofSecond.numbers(lessFour + from + at), part, ofSecond.numbers(second + at)), second + at);
				});
			});
			if (!Periodic || !view.sampleStress) return;
			forRows([&](std::size_t l) HWY_ATTR TALIK_INLINED {
				double* const sum = rowAt<3, 8>(view.shiftForce, p.shift()[l]) + from;
				ofFirst.forRow(
				        l, [&](auto part, std::size_t at) HWY_ATTR TALIK_INLINED { store(Add(ofFirst.numbers(sum + at), part), sum + at); });
			});
		}

		/// Adds G to the first grains' rows and subtracts it from the second ones'; moments of s on the arms r - u_n/2 to both.
		template <bool Periodic, bool Turning>
		HWY_INLINE void scatter(const PackedStepView<3>& view, const Place<3>& p, const Gathered& g, const ResponseOf<Turning>& f)
		{
			const Vector n = g.n(), shear = loadVector(p.pair().shear, p.lane), m = cross(n, shear);
			const Many   normal = f.normal();
			const Many   half = Mul(splat(0.5), g.distance()), difference = load(p.pair().halfDifference + p.lane);
			Vector       ofFirst = scaled(m, Add(half, difference)), ofSecond = scaled(m, Sub(half, difference));
			if constexpr (Turning) {
				const Vector moment = f.moment();
				ofFirst             = Add(ofFirst, moment);
				ofSecond            = Sub(ofSecond, moment);
			}
			const Many    none = splat(0.);
			const Columns forces { MulAdd(normal, n.x, shear.x), MulAdd(normal, n.y, shear.y), MulAdd(normal, n.z, shear.z), none };
			const Columns firstMoments { ofFirst.x, ofFirst.y, ofFirst.z, none }, secondMoments { ofSecond.x, ofSecond.y, ofSecond.z, none };
#if HWY_TARGET <= HWY_AVX3_DL
			addRows<Periodic>(view, p, 0, rowsOf(EightColumns { forces, firstMoments }), rowsOf(EightColumns { forces, secondMoments }));
#else
			const Rows<4> rows = rowsOf(forces);
			addRows<Periodic>(view, p, 0, rows, rows);
			addRows<Periodic>(view, p, 4, rowsOf(firstMoments), rowsOf(secondMoments));
#endif
		}

		/// Parameters of the contact law, in every lane.
		struct Constants {
			Many friction;
			Many shearStep;      ///< k_s/k_n dt [s]
			Many step, halfStep; ///< dt, dt/2 [s]
		};

		/// Angular velocity of the second grains less that of the first ones.
		HWY_INLINE Vector spinBetween(const PackedStepView<3>& view, const Place<3>& p)
		{
			const Columns w = gatherColumns<4, 8>(view.speed + 4, p, lessFour);
			return { w.a, w.b, w.c };
		}

		/// Moment of rolling on the second grains; it is carried along with the contact by `turn`.
		template <bool Hertz>
		HWY_INLINE Vector
		roll(const PackedStepView<3>& view, const Place<3>& p, const Constants& c, const Vector& n, const Vector& turn, Many overlap, Many normal)
		{
			PackedRollingBlock<3>& block = p.rolling();
			const Vector           spin = spinBetween(view, p), bending = NegMulAdd(dot(spin, n), n, spin);
			const Vector           before    = loadVector(block.moment, p.lane);
			const Vector           increment = scaled(bending, Mul(c.step, grainTangent<Hertz>(load(block.stiffness + p.lane), overlap)));
			const Vector           moment    = rollingMoment(load(block.lever + p.lane), normal, crossAdd(turn, before, before), increment);
			storeVector(moment, block.moment, p.lane);
			return moment;
		}

		/// Moment of the bonds on the second grains, carried along with the contact by `turn`, and what it adds at the edge of their sections.
		template <bool Moments>
		HWY_INLINE auto bendBonds(const PackedStepView<3>& view, const Place<3>& p, const Constants& c, const Vector& n, const Vector& turn)
		{
			if constexpr (Moments) {
				PackedMomentBlock<3>& block  = p.moments();
				const Vector          before = loadVector(block.moment, p.lane), spin = spinBetween(view, p);
				const Many            along = dot(spin, n), bending = Mul(c.step, load(block.bending + p.lane));
				const Many            twisting = MulSub(c.step, load(block.twisting + p.lane), bending);
				const Vector          bent     = NegMulAdd(bending, spin, crossAdd(turn, before, before));
				const Vector          moment   = NegMulAdd(Mul(twisting, along), n, bent);
				storeVector(moment, block.moment, p.lane);
				const Many twist = dot(moment, n), edge = load(block.edgeOverMoment + p.lane);
				return EdgeForces<Many> { Mul(edge, lengthOf(NegMulAdd(twist, n, moment))), Mul(Mul(splat(0.5), edge), lengthOf(twist)) };
			} else {
				(void)view, (void)p, (void)c, (void)n, (void)turn;
				return NoMoments();
			}
		}

		/// Moments of the bonds that are left, and of rolling.
		template <bool Hertz, bool Rolling, bool Moments>
		HWY_INLINE Vector
		momentOf(const PackedStepView<3>& view, const Place<3>& p, const Constants& c, const Vector& n, const Vector& turn, Many overlap, Many normal)
		{
			if constexpr (!Moments) return roll<Hertz>(view, p, c, n, turn, overlap, normal);
			const Vector ofBonds = loadVector(p.moments().moment, p.lane);
			if constexpr (!Rolling) return ofBonds;
			return Add(ofBonds, roll<Hertz>(view, p, c, n, turn, overlap, normal));
		}

		template <bool Hertz, bool Bonded, bool Periodic>
		HWY_INLINE void move(const PackedStepView<3>& view, const Place<3>& p, const Constants& c, const Gathered& g, Moved& m)
		{
			const Vector    n     = g.n();
			PackedBlock<3>& block = p.pair();
			const auto [v, w]     = gatherColumns<8, 8, Periodic>(view.speed, p, lessButLast, view.shiftSpeed);
			const Vector velocity { v.a, v.b, v.c }, spin { w.a, w.b, w.c }, rim { g.rimX(), v.d, w.d };
			const Many   sum = load(block.sumRadius + p.lane);
			// turn of the contact, eq. (13.5), and slip, eq. (13.6). The branch of the last step was l - dt v: from it the turn of the
			// normal follows, to the last place, eq. (13.7)
			const Many   inverse = g.inverse(), turning = Mul(c.step, inverse), stretch = Mul(sum, inverse);
			const Vector across = cross(n, velocity);
			const Many   bend   = MulAdd(Mul(turning, dot(velocity, n)), turning, turning);
			const Vector slip   = cross(n, NegMulAdd(stretch, across, rim));
			m.turn              = MulAdd(bend, across, scaled(n, Mul(c.halfStep, dot(n, spin))));
			m.increment         = scaled(slip, Mul(c.shearStep, tangentOf<Hertz, Bonded>(p, Sub(sum, g.distance()))));
		}

		template <bool Hertz, bool Bonded, bool Periodic, bool Rolling, bool Moments>
		HWY_INLINE void respond(
		        PackedStepView<3>& shared, const PackedStepView<3>& view, const Place<3>& p, const Constants& c, const Gathered& g, const Moved& m,
		        ResponseOf<Rolling || Moments>& r)
		{
			const Vector    n = g.n(), turn = m.turn(), increment = m.increment();
			PackedBlock<3>& block   = p.pair();
			const Many      overlap = Sub(load(block.sumRadius + p.lane), g.distance());
			const Vector    before = loadVector(block.shear, p.lane), shear = crossAdd(turn, before, before);
			Forces          f;
			if constexpr (Bonded) {
				PackedIceBlock<3>& ice   = p.ice();
				const Vector       ofIce = loadVector(ice.iceShear, p.lane);
				f                        = bondedForces(
				                               bondedResponse<Hertz>(p, overlap), c.friction, overlap, shear, crossAdd(turn, ofIce, ofIce), increment,
				                               bendBonds<Moments>(view, p, c, n, turn), [&](auto failed, auto& forces) HWY_ATTR TALIK_INLINED {
                                                settleBonds<3>(shared, Periodic, packedWidth * p.block + p.lane, failed, forces);
                                        });
				storeVector(f.iceShear, ice.iceShear, p.lane);
			} else {
				f = frictionalForces(grainSecant<Hertz>(load(block.stiffness + p.lane), overlap), c.friction, overlap, shear, increment);
			}
			storeVector(f.shear, block.shear, p.lane);
			if constexpr (Rolling || Moments) r.moment = momentOf<Hertz, Rolling, Moments>(view, p, c, n, turn, overlap, f.normal);
			r.normal = f.normal;
		}

		/// A 3x3 matrix, the same in every lane.
		struct Matrix {
			Vector row[3];
			HWY_INLINE explicit Matrix(const double* m)
			{
				for (int d = 0; d < 3; ++d)
					row[d] = { splat(m[3 * d]), splat(m[3 * d + 1]), splat(m[3 * d + 2]) };
			}
			/// M x + b
			HWY_INLINE Vector timesAdd(const Vector& x, const Vector& b) const
			{
				return { MulAdd(row[0].x, x.x, MulAdd(row[0].y, x.y, MulAdd(row[0].z, x.z, b.x))),
					 MulAdd(row[1].x, x.x, MulAdd(row[1].y, x.y, MulAdd(row[1].z, x.z, b.y))),
					 MulAdd(row[2].x, x.x, MulAdd(row[2].y, x.y, MulAdd(row[2].z, x.z, b.z))) };
			}
		};

		/// Adds f (x) x to its sums.
		HWY_INLINE void addVirial(Quad (&sums)[9], std::size_t grain, const Vector& f, const Vector& x)
		{
			const Many fs[3] = { f.x, f.y, f.z }, xs[3] = { x.x, x.y, x.z };
			for (int k = 0; k < 9; ++k)
				sums[k].add(grain, fs[k / 3], xs[k % 3]);
		}

		struct SphereLoops {
			template <bool Hertz, bool Bonded, bool Rolling, bool Moments, bool Periodic>
			static HWY_NOINLINE void contacts(PackedStepView<3>& shared, const PackedPairs<3> pairs)
			{
				const PackedStepView<3> view = shared; // of its own: what vectors are stored to might be a part of a view that others know
				const Constants         c { splat(view.friction), splat(view.stiffnessRatio * view.dt), splat(view.dt), splat(0.5 * view.dt) };
				using Response = ResponseOf<Rolling || Moments>;
				inStages<Gathered, Moved, Response, Bonded, Rolling>(
				        pairs, [&](const Place<3>& p, Gathered& g) HWY_ATTR TALIK_INLINED { gather<Periodic>(view, p, g); },
				        [&](const Place<3>& p, const Gathered& g, Moved& m)
				                HWY_ATTR TALIK_INLINED { move<Hertz, Bonded, Periodic>(view, p, c, g, m); },
				        [&](const Place<3>& p, const Gathered& g, const Moved& m, Response& r)
				                HWY_ATTR TALIK_INLINED { respond<Hertz, Bonded, Periodic, Rolling, Moments>(shared, view, p, c, g, m, r); },
				        [&](const Place<3>& p, const Gathered& g, const Response& r)
				                HWY_ATTR TALIK_INLINED { scatter<Periodic, Rolling || Moments>(view, p, g, r); });
			}

			template <bool Jumps, bool Stress> static void integrate(PackedStepView<3>& shared)
			{
				const PackedStepView<3> view = shared; // as in contacts()
				double                  leap[9], leapOfSpin[3];
				for (int k = 0; k < 9; ++k)
					leap[k] = view.nextVelGrad[k] - view.prevVelGrad[k];
				for (int d = 0; d < 3; ++d)
					leapOfSpin[d] = -0.5 * (leap[(d + 1) % 3 * 3 + (d + 2) % 3] - leap[(d + 2) % 3 * 3 + (d + 1) % 3]);
				const Matrix gradient(view.prevVelGrad), jump(leap);
				const Vector none { splat(0.), splat(0.), splat(0.) },
				        spinJump { splat(leapOfSpin[0]), splat(leapOfSpin[1]), splat(leapOfSpin[2]) };
				const Many dt = splat(view.dt), halfStep = splat(0.5 * view.dt), damping = splat(view.damping);
				Many       fluctuation = splat(0.);
				Quad       virial[9];
				for (std::size_t g = 0; g < view.grains; g += laneCount) {
					const Columns xs    = takeColumns<4, 4>(view.position(g));
					const auto [vs, ws] = takeColumns<8, 8>(view.velocity(g));
					const auto [fs, ms] = takeColumns<8, 8, true>(view.force + 8 * g);
					const Vector x { xs.a, xs.b, xs.c }, v { vs.a, vs.b, vs.c }, force { fs.a, fs.b, fs.c }, moment { ms.a, ms.b, ms.c };
					const Vector meanField = gradient.timesAdd(x, none);
					const Vector a         = gradient.timesAdd(
					                v, damped(scaled(force, load(view.minusInverseMass + g)), Sub(v, meanField), damping, halfStep));
					Vector       velocity = MulAdd(dt, a, v);
					const Vector carried  = Sub(velocity, meanField);
					fluctuation           = Max(fluctuation, Mul(load(view.inverseSlackSquare + g), dot(carried, carried)));
					if (Jumps) velocity = jump.timesAdd(x, velocity);
					const Vector position = MulAdd(dt, velocity, x);
					if (Stress) addVirial(virial, g, force, position);
					const Vector before { ws.a, ws.b, ws.c };
					Vector       w = MulAdd(dt, damped(scaled(moment, load(view.inverseInertia + g)), before, damping, halfStep), before);
					if (Jumps) w = Add(w, spinJump);
					const Vector rim = scaled(w, load(view.radius + g));
					putColumns<4>(Columns { position.x, position.y, position.z, rim.x }, view.position(g));
					putColumns<8>(
					        EightColumns { { velocity.x, velocity.y, velocity.z, rim.y }, { w.x, w.y, w.z, rim.z } }, view.velocity(g));
				}
				shared.maxFluctuationSquare = largest(fluctuation);
				for (int k = 0; Stress && k < 9; ++k)
					shared.virial[k] = virial[k].sum();
			}
		};

	} // namespace

	PackedKernel<3> sphereKernel(PackedContactKind kind) { return KernelOf<3, SphereLoops>::chosen(kind); }

} // namespace HWY_NAMESPACE
} // namespace talik
HWY_AFTER_NAMESPACE();

#if HWY_ONCE
TALIK_STEP_KERNEL(3, sphereKernel)
#endif
