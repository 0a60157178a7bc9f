// SPDX-License-Identifier: GPL-2.0-or-later
// The fused step of discs on vectors, compiled once for every kind of processor that Highway knows. Which one runs is chosen when the
// program runs. Vectors of variable length (SVE, RVV) cannot be members of a structure and are left out.
#define HWY_WANT_AVX3_DL // Highway of Debian 12 leaves it out unless it is asked for
#undef HWY_DISABLED_TARGETS
#define HWY_DISABLED_TARGETS (HWY_SSSE3 | HWY_SVE | HWY_SVE2 | HWY_SVE_256 | HWY_SVE2_128 | HWY_RVV)
#undef HWY_TARGET_INCLUDE
#define HWY_TARGET_INCLUDE "pkg/rve/packed/PackedStepDiscs.cpp"
#include <hwy/foreach_target.h>

#include <hwy/highway.h>
#include <pkg/icebond/ContactForces.hpp>
#include <pkg/rve/packed/PackedVectors.hpp>

HWY_BEFORE_NAMESPACE();
namespace talik {
namespace HWY_NAMESPACE {
	namespace {

		/// Branch, relative velocity, w_1 r_1 + w_2 r_2 and distance of some pairs.
		struct Gathered {
			Many dx, dy, dvx, dvy, wr, distance, inverse;
		};

		template <bool Periodic> HWY_INLINE Gathered gather(const PackedStepView<2>& view, const Place<2>& p)
		{
			Rows<4> rows;
			forRows([&](std::size_t l) HWY_ATTR TALIK_INLINED {
				const double *first = view.place + p.first()[l], *second = view.place + p.second()[l];
				const double* shift = Periodic ? view.shiftPlace + p.shift()[l] : nullptr;
				rows.setRow(l, [&](std::size_t at) HWY_ATTR TALIK_INLINED {
					const auto branch = Sub(rows.numbers(second + at), rows.numbers(first + at));
					if constexpr (Periodic) return Add(branch, rows.numbers(shift + at));
					else return branch;
				});
			});
			const Columns c        = columnsOf(rows);
			const Many    wr       = sumOfSingles(view.rim, p.first(), p.second());
			const Many    distance = Sqrt(MulAdd(c.a, c.a, Mul(c.b, c.b)));
			return { c.a, c.b, c.c, c.d, wr, distance, Div(splat(1.), distance) };
		}

		/// Adds the rows of the first grains, and those of the second ones with G of other sign.
		template <bool Periodic>
		HWY_INLINE void addRows(const PackedStepView<2>& view, const Place<2>& p, const Rows<4>& ofFirst, const Rows<4>& ofSecond)
		{
			alignas(32) static constexpr double signs[4] = { -1, -1, 1, 1 };
			forRows([&](std::size_t l) HWY_ATTR TALIK_INLINED {
				double* const first  = view.force + p.first()[l];
				double* const second = view.force + p.second()[l];
				ofFirst.forRow(l, [&](auto part, std::size_t at) HWY_ATTR TALIK_INLINED {
					store(Add(ofFirst.numbers(first + at), part), first + at);
				});
				ofSecond.forRow(l, [&](auto part, std::size_t at) HWY_ATTR TALIK_INLINED {
					store(MulAdd(part, ofSecond.numbers(signs + at), ofSecond.numbers(second + at)), second + at);
				});
			});
			if (!Periodic || !view.sampleStress) return;
			forRows([&](std::size_t l) HWY_ATTR TALIK_INLINED {
				double* const sum = view.shiftForce + p.shift()[l];
				ofFirst.forRow(
				        l, [&](auto part, std::size_t at) HWY_ATTR TALIK_INLINED { store(Add(ofFirst.numbers(sum + at), part), sum + at); });
			});
		}

		/// Parameters of the contact law, in every lane.
		struct Constants {
			Many friction;
			Many shearStep; ///< k_s/k_n dt [s]
		};

		/// Angular velocity of the second grains less that of the first ones; Block knows the inverse radii.
		template <class Block> HWY_INLINE Many spinBetween(const PackedStepView<2>& view, const Place<2>& p, const Block& block)
		{
			const Many second = Mul(singles(view.rim, p.second()), load(block.inverseSecond + p.lane));
			return NegMulAdd(singles(view.rim, p.first()), load(block.inverseFirst + p.lane), second);
		}

		/// Moment of the bonds on the second grains, and what it adds at the edge of their sections.
		template <bool Moments> HWY_INLINE auto bendBonds(const PackedStepView<2>& view, const Place<2>& p)
		{
			if constexpr (Moments) {
				PackedMomentBlock<2>& block  = p.moments();
				const Many            angle  = Mul(splat(view.dt), spinBetween(view, p, block));
				const Many            moment = NegMulAdd(load(block.bending + p.lane), angle, load(block.moment[0] + p.lane));
				store(moment, block.moment[0] + p.lane);
				return EdgeForces<Many> { Mul(load(block.edgeOverMoment + p.lane), lengthOf(moment)), splat(0.) };
			} else {
				(void)view, (void)p;
				return NoMoments();
			}
		}

		template <bool Hertz, bool Bonded, bool Moments, bool Periodic>
		HWY_INLINE ContactForces<Many, Many> respond(
		        PackedStepView<2>& shared, const PackedStepView<2>& view, const Place<2>& p, const Constants& c, const Gathered& g)
		{
			PackedBlock<2>&           block   = p.pair();
			const Many                sum     = load(block.sumRadius + p.lane);
			const Many                overlap = Sub(sum, g.distance);
			const Many                nx = Mul(g.dx, g.inverse), ny = Mul(g.dy, g.inverse);
			const Many                tangential = MulSub(g.dvy, nx, Mul(g.dvx, ny));
			const Many                slip       = MulSub(Mul(sum, g.inverse), tangential, g.wr);
			const Many                increment  = Mul(Mul(c.shearStep, tangentOf<Hertz, Bonded>(p, overlap)), slip);
			const Many                shear      = load(block.shear[0] + p.lane);
			ContactForces<Many, Many> f;
			if constexpr (Bonded) {
				PackedIceBlock<2>& ice = p.ice();
				f                      = bondedForces(
				                             bondedResponse<Hertz>(p, overlap), c.friction, overlap, shear, load(ice.iceShear[0] + p.lane), increment,
				                             bendBonds<Moments>(view, p), [&](auto failed, auto& forces) HWY_ATTR TALIK_INLINED {
                                                settleBonds<2>(shared, Periodic, packedWidth * p.block + p.lane, failed, forces);
                                        });
				store(f.iceShear, ice.iceShear[0] + p.lane);
			} else {
				f = frictionalForces(grainSecant<Hertz>(load(block.stiffness + p.lane), overlap), c.friction, overlap, shear, increment);
			}
			store(f.shear, block.shear[0] + p.lane);
			return f;
		}

		/// Moment of rolling on the second grains.
		template <bool Hertz> HWY_INLINE Many roll(const PackedStepView<2>& view, const Place<2>& p, Many overlap, Many normal)
		{
			PackedRollingBlock<2>& block     = p.rolling();
			const Many             increment = Mul(
			                    Mul(splat(view.dt), grainTangent<Hertz>(load(block.stiffness + p.lane), overlap)), spinBetween(view, p, block));
			const Many moment = rollingMoment(load(block.lever + p.lane), normal, load(block.moment[0] + p.lane), increment);
			store(moment, block.moment[0] + p.lane);
			return moment;
		}

		/// Moments of the bonds that are left, and of rolling.
		template <bool Hertz, bool Rolling, bool Moments>
		HWY_INLINE Many momentOf(const PackedStepView<2>& view, const Place<2>& p, Many overlap, Many normal)
		{
			if constexpr (!Moments) return roll<Hertz>(view, p, overlap, normal);
			const Many ofBonds = load(p.moments().moment[0] + p.lane);
			if constexpr (Rolling) return Add(ofBonds, roll<Hertz>(view, p, overlap, normal));
			return ofBonds;
		}

		/// Adds rows (G_x, G_y, s, s u_n/2) to both grains; moments act on the second ones and against the first ones.
		template <bool Hertz, bool Periodic, bool Rolling, bool Moments>
		HWY_INLINE void scatter(const PackedStepView<2>& view, const Place<2>& p, const Gathered& g, const ContactForces<Many, Many>& f)
		{
			const Many nx = Mul(g.dx, g.inverse), ny = Mul(g.dy, g.inverse);
			const Many gx = NegMulAdd(f.shear, ny, Mul(f.normal, nx)), gy = MulAdd(f.shear, nx, Mul(f.normal, ny));
			const Many ofShear = Mul(Mul(splat(0.5), f.overlap), f.shear);
			if constexpr (Rolling || Moments) {
				const Many moment = momentOf<Hertz, Rolling, Moments>(view, p, f.overlap, f.normal);
				addRows<Periodic>(
				        view, p, rowsOf(Columns { gx, gy, f.shear, Sub(ofShear, moment) }),
				        rowsOf(Columns { gx, gy, f.shear, Add(ofShear, moment) }));
			} else {
				const Rows<4> rows = rowsOf(Columns { gx, gy, f.shear, ofShear });
				addRows<Periodic>(view, p, rows, rows);
			}
		}

		struct DiscLoops {
			template <bool Hertz, bool Bonded, bool Rolling, bool Moments, bool Periodic>
			static HWY_NOINLINE void contacts(PackedStepView<2>& shared, const PackedPairs<2> pairs)
			{
				const PackedStepView<2> view = shared; // of its own: what vectors are stored to might be a part of a view that others know
				const Constants         c { splat(view.friction), splat(view.stiffnessRatio * view.dt) };
				const auto gatherAt = [&](const Place<2>& p) HWY_ATTR TALIK_INLINED { return gather<Periodic>(view, p); };
				const auto finish   = [&](const Place<2>& p, const Gathered& gathered) HWY_ATTR TALIK_INLINED {
                                        if (passedOver<Bonded, Rolling>(p, gathered.distance)) return;
                                        // forces are handed on without a name: with one GCC keeps them in memory, at half the speed
                                        scatter<Hertz, Periodic, Rolling, Moments>(
                                                view, p, gathered, respond<Hertz, Bonded, Moments, Periodic>(shared, view, p, c, gathered));
				};
				inPipeline(pairs, gatherAt, finish);
			}

			template <bool Jumps, bool Stress> static void integrate(PackedStepView<2>& shared)
			{
				const PackedStepView<2> view    = shared; // as in contacts()
				const double*           l       = view.prevVelGrad;
				const double            jump[4] = { view.nextVelGrad[0] - l[0], view.nextVelGrad[1] - l[1], view.nextVelGrad[2] - l[2],
					                            view.nextVelGrad[3] - l[3] };
				const Many              lxx = splat(l[0]), lxy = splat(l[1]), lyx = splat(l[2]), lyy = splat(l[3]);
				const Many              jxx = splat(jump[0]), jxy = splat(jump[1]), jyx = splat(jump[2]), jyy = splat(jump[3]);
				const Many              spinJump = splat(-0.5 * (jump[1] - jump[2]));
				const Many              dt = splat(view.dt), halfStep = splat(0.5 * view.dt), damping = splat(view.damping);
				Many                    fluctuation = splat(0.);
				Quad                    sxx, sxy, syx, syy;
				for (std::size_t g = 0; g < view.grains; g += laneCount) {
					const Columns motion = takeColumns<4, 4>(view.place + 4 * g), force = takeColumns<4, 4, true>(view.force + 4 * g);
					const Many    minusInverseMass = load(view.minusInverseMass + g);
					const Many    meanX = MulAdd(lxx, motion.a, Mul(lxy, motion.b)), meanY = MulAdd(lyx, motion.a, Mul(lyy, motion.b));
					Many          ax = damped(Mul(force.a, minusInverseMass), Sub(motion.c, meanX), damping, halfStep);
					Many          ay = damped(Mul(force.b, minusInverseMass), Sub(motion.d, meanY), damping, halfStep);
					ax               = MulAdd(lxx, motion.c, MulAdd(lxy, motion.d, ax));
					ay               = MulAdd(lyx, motion.c, MulAdd(lyy, motion.d, ay));
					Many       vx = MulAdd(dt, ax, motion.c), vy = MulAdd(dt, ay, motion.d);
					const Many fx = Sub(vx, meanX), fy = Sub(vy, meanY);
					fluctuation = Max(fluctuation, Mul(load(view.inverseSlackSquare + g), MulAdd(fx, fx, Mul(fy, fy))));
					if (Jumps) {
						vx = MulAdd(jxx, motion.a, MulAdd(jxy, motion.b, vx));
						vy = MulAdd(jyx, motion.a, MulAdd(jyy, motion.b, vy));
					}
					const Many x = MulAdd(dt, vx, motion.a), y = MulAdd(dt, vy, motion.b);
					putColumns<4>(Columns { x, y, vx, vy }, view.place + 4 * g);
					if (Stress) {
						sxx.add(g, force.a, x);
						sxy.add(g, force.a, y);
						syx.add(g, force.b, x);
						syy.add(g, force.b, y);
					}
					const Many radius = load(view.radius + g), torque = NegMulAdd(radius, force.c, force.d);
					Many       w = load(view.turning + g);
					w            = MulAdd(dt, damped(Mul(torque, load(view.inverseInertia + g)), w, damping, halfStep), w);
					if (Jumps) w = Add(w, spinJump);
					store(w, view.turning + g);
					store(MulAdd(dt, w, load(view.angle + g)), view.angle + g);
					store(Mul(w, radius), view.rim + g);
				}
				shared.maxFluctuationSquare = largest(fluctuation);
				if (!Stress) return;
				shared.virial[0] = sxx.sum();
				shared.virial[1] = sxy.sum();
				shared.virial[2] = syx.sum();
				shared.virial[3] = syy.sum();
			}
		};

	} // namespace

	PackedKernel<2> discKernel(PackedContactKind kind) { return KernelOf<2, DiscLoops>::chosen(kind); }

} // namespace HWY_NAMESPACE
} // namespace talik
HWY_AFTER_NAMESPACE();

#if HWY_ONCE
TALIK_STEP_KERNEL(2, discKernel)
#endif
