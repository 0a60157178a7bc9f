// SPDX-License-Identifier: GPL-2.0-or-later
// All steps of a call of one packed sample, by a block of threads of a graphics card; on a processor one thread does the work of all. Contact
// law, failure of bonds and order of all sums are those of the packed samples: pkg/icebond/ContactForces.hpp and IceBond.hpp as they are, sums
// of a grain in the order of the keys of its pairs, those inside the cell first.
#pragma once
#include <pkg/rve/device/SampleIce.hpp>
#include <pkg/rve/device/SampleLists.hpp>
#include <pkg/rve/device/SampleMemory.hpp>

namespace talik {
namespace N_ONE {

	// ---------------------------------------------------------------------------------------------- laws

	/// 1 or -1
	HWY_INLINE One signOf(int negative) { return { negative ? -1. : 1. }; }

	/// A bond at its limit: forces of this step, and the contact from now on.
	template <int Dim, class PlainShear>
	TALIK_CARD __attribute__((noinline)) void settleBond(
	        const SampleCall& call, const Place<Dim, true>& place, Fixed<Dim>& fixed, int p, ContactForces<double, PlainShear>& forces)
	{
		IceBond                bond = place.iceBond(p);
		const ContactStiffness k    = place.contactStiffness(call, p);
		const BondStrength     s    = place.strength(call, p);
		const BondFailure      came = bond.settle(k, s, call.friction, call.thawed != 0, forces);
		if (came == BondFailure::tension) count(fixed.brokenInTension);
		if (came == BondFailure::shear) count(fixed.brokenInShear);
		if (forces.overlap < 0) bond = IceBond();
		place.setBond(p, bond);
		place.setResponse(p, bond.response(k, s));
	}

	template <int Dim, class Shear>
	HWY_INLINE void settle(const SampleCall& call, const Place<Dim, true>& place, Fixed<Dim>& fixed, int p, ContactForces<One, Shear>& f)
	{
		using PlainShear = decltype(plainShear(f.shear));
		ContactForces<double, PlainShear> forces;
		forces.overlap     = f.overlap.value;
		forces.trialNormal = f.trialNormal.value;
		forces.trialShear  = plainShear(f.trialShear);
		forces.increment   = plainShear(f.increment);
		forces.normal      = f.normal.value;
		forces.shear       = plainShear(f.shear);
		forces.iceShear    = plainShear(f.iceShear);
		settleBond<Dim>(call, place, fixed, p, forces);
		f.normal   = { forces.normal };
		f.shear    = shearOf(forces.shear);
		f.iceShear = shearOf(forces.iceShear);
	}

	/// What the law needs of a pair, kept by its thread.
	template <bool Bonded> struct PairConstants {
		One sumRadius, stiffness;
	};
	template <> struct PairConstants<true> : PairConstants<false> {
		One offset, floor, cohesion, iceShare;
	};

	template <int Dim, bool Bonded> HWY_INLINE PairConstants<Bonded> constantsOf(const Place<Dim, Bonded>& place, int p)
	{
		using At = Place<Dim, Bonded>;
		PairConstants<Bonded> c;
		c.sumRadius = { place.pair(At::sumRadius, p) };
		c.stiffness = { place.pair(At::stiffness, p) };
		if constexpr (Bonded) {
			c.offset   = { place.pair(At::offset, p) };
			c.floor    = { place.pair(At::floorForce, p) };
			c.cohesion = { place.pair(At::cohesion, p) };
			c.iceShare = { place.pair(At::iceShare, p) };
		}
		return c;
	}

	/// What a shear increment goes by at an overlap.
	template <bool Hertz, bool Bonded> HWY_INLINE One tangentOf(const PairConstants<Bonded>& c, One overlap)
	{
		const One tangent = grainTangent<Hertz>(c.stiffness, overlap);
		if constexpr (Hertz && Bonded) return Add(tangent, c.iceShare);
		else return tangent;
	}

	/// Forces of a pair from its geometry; shear and iceShear are carried along already and come back limited.
	template <int Dim, bool Bonded, bool Hertz, class Shear>
	HWY_INLINE ContactForces<One, Shear> forcesOf(
	        const SampleCall& call, const Place<Dim, Bonded>& place, Fixed<Dim>& fixed, int p, PairConstants<Bonded>& c, One overlap, const Shear& shear,
	        const Shear& iceShear, const Shear& increment)
	{
		if constexpr (Bonded) {
			const ContactResponse<One> springs { c.stiffness, c.offset, c.floor, c.cohesion, c.iceShare },
			        contact = responseAt<Hertz>(springs, overlap);
			return bondedForces(contact, One { call.friction }, overlap, shear, iceShear, increment, NoMoments(), [&](bool, auto& f) TALIK_INLINED {
				settle<Dim>(call, place, fixed, p, f);
				c = constantsOf<Dim, true>(place, p);
			});
		} else {
			(void)place, (void)fixed, (void)p, (void)iceShear;
			return frictionalForces(grainSecant<Hertz>(c.stiffness, overlap), One { call.friction }, overlap, shear, increment);
		}
	}

	// ---------------------------------------------------------------------------------------------- what discs and spheres share

	/// Bits of what a thread brings to the largest departure from the affine motion; what is no number is more than any.
	HWY_INLINE std::uint64_t bitsOf(One positive)
	{
		const double  number = finite(positive.value) ? positive.value : __builtin_huge_val();
		std::uint64_t bits;
		__builtin_memcpy(&bits, &number, sizeof(bits));
		return bits;
	}

	/// How far the lists of neighbours are used up, as PackedWorkspace::accumulateTravel has it.
	struct ListUse {
		double          travel, stretch;
		HWY_INLINE bool exhausted(const SampleCall& call) const { return !(travel + (call.largestRadius + call.skin) * stretch * 1.01 < call.skin); }
		HWY_INLINE void add(const SampleCall& call, bool moves, std::uint64_t mostBits)
		{
			double most;
			__builtin_memcpy(&most, &mostBits, sizeof(most));
			travel += call.dt * ((moves ? call.norm : 0.) * travel + __builtin_sqrt(most)) * (1 + 1e-12);
			stretch += call.dt * (moves ? call.strainRate : 0.);
		}
	};

	/// Kernel is DiscsOf or SpheresOf, which say what a step does.
	template <class Kernel> struct Run {
		static constexpr int  Dim = Kernel::Dim, Threads = Kernel::Threads;
		static constexpr bool Bonded = Kernel::Bonded;
		using At                     = Place<Dim, Bonded>;
		static_assert(Threads <= NewLists<Dim, Bonded>::mostThreads && Kernel::Pairs <= NewLists<Dim, Bonded>::mostPairsEach, "new lists fit");

		/// The call of a block of a launch.
		TALIK_CARD static inline TALIK_INLINED void block(const KernelArguments& a, int number, unsigned char* memory)
		{
			const std::uint32_t k = a.order[number];
			sample(a.calls[k], a.ice + std::size_t(mostIceParts) * k, a.answers[k], a.tangents + std::size_t(tangentSums(Dim)) * k, a.layout,
			       memory);
		}

		TALIK_CARD static inline TALIK_INLINED void sample(
		        const SampleCall& given, const IcePart* ice, SampleAnswer& answer, double* sums, const PlaceLayout& layout, unsigned char* memory)
		{
			const Shared<Dim> s(memory, layout);
			const At          place(given.place, layout);
			Fixed<Dim>&       fixed = s.fixed;
			SampleCall&       call  = fixed.call;
			Kernel            kernel;
			together<Threads>([&](int t) TALIK_INLINED {
				using Word = std::uint64_t __attribute__((may_alias));
				static_assert(sizeof(SampleCall) % sizeof(Word) == 0, "whole words");
				for (int k = t; k < int(sizeof(SampleCall) / sizeof(Word)); k += Threads)
					reinterpret_cast<Word*>(&call)[k] = reinterpret_cast<const Word*>(&given)[k];
				if (t != 0) return;
				fixed.most[0] = fixed.most[1] = fixed.most[2] = 0;
				fixed.brokenInTension = fixed.brokenInShear = fixed.bonds = fixed.unsound = fixed.lists = 0;
				fixed.bondsFormed = fixed.bondsMelted = 0;
				fixed.carries                         = std::uint32_t(given.carries);
			});
			if (call.formerPlace) bringFromFormerPlace<Dim, Bonded>(place, call, Threads);
			const int total = call.moving + call.resting;
			ListUse   use { call.travel, call.stretch };
			int       step = 0, part = 0; // of the ice
			bool      forms = false;      // bonds of the part that has just come into force
			for (;;) {
				take(kernel, call, s, place, step);
				if (part < call.iceParts && step == part * call.stepsOfIce) {
					NewIce<Dim, Bonded>::follow(s, place, call, ice[part], Threads);
					forms = ice[part++].forms != 0 && Bonded;
					if (!forms) continue;
				}
				const int until = forms ? step : part < call.iceParts ? part * call.stepsOfIce : total;
				for (; step < until && !use.exhausted(call); ++step) {
					together<Threads>([&](int t) TALIK_INLINED {
						if (t == 0) fixed.most[(step + 1) % 3] = 0;
						kernel.contacts(t, s, place, call);
					});
					together<Threads>([&](int t) TALIK_INLINED {
						const Gradients<Dim> l(call, step);
						kernel.integrate(t, s, place, call, l, step == 0 || step == call.moving, fixed.most[step % 3]);
						if (step + 1 == total) return;
						for (int k = Threads - 1 - t; k < call.images; k += Threads)
							moveCell<Dim>(
							        fixed.cell[step & 1], fixed.cell[~step & 1], k == 0, l.next, call.dt, fixed.cells + Dim * k,
							        fixed.image[k]);
					});
					use.add(call, step < call.moving, fixed.most[step % 3]);
				}
				if (step == total) stress(call, s, place, answer);
				if (!forms) together<Threads>([&](int t) TALIK_INLINED { kernel.store(t, s, place, call); });
				if (step == total) break;
				if (step == until && !forms) continue; // with the next part of the ice
				if (!newLists(call, s, place, step, forms ? ice[part - 1].bondSkin : 0.)) break;
				use = { 0, 0 };
				if (forms) NewIce<Dim, Bonded>::form(s, place, call, fixed.cell[step & 1], Threads);
				forms = false;
			}
			// lists that are used up before the end leave the cell one step ahead
			const int last = step > 0 ? (step - 1) & 1 : 0;
			together<Threads>([&](int t) TALIK_INLINED {
				if (Bonded)
					for (int p = t; p < call.pairs; p += Threads)
						if (place.bond(p) & 3) count(fixed.bonds);
				if (t < 2 * Dim * Dim) {
					const bool ofCell = t < Dim * Dim;
					const int  k      = ofCell ? t : t - Dim * Dim;
					if (ofCell) {
						answer.hSize[k]     = step > 0 ? fixed.cell[last][k] : call.hSize[k];
						answer.prevHSize[k] = step > 1 ? fixed.cell[last ^ 1][k] : call.hSize[k];
					} else {
						answer.trsf[k] = step > 0 ? fixed.cell[last][Dim * Dim + k] : call.trsf[k];
					}
				}
			});
			if (step == total) checkPairs(call, s, place);
			if (step == total && call.tangent) tangent(call, s, place, sums, fixed.cell[last]);
			together<Threads>([&](int t) TALIK_INLINED {
				if (t != 0) return;
				answer.lists           = fixed.lists;
				answer.pairs           = call.pairs;
				answer.inside          = call.inside;
				answer.images          = call.images;
				answer.skin            = call.skin;
				answer.travel          = use.travel;
				answer.stretch         = use.stretch;
				answer.steps           = std::uint32_t(step);
				answer.brokenInTension = fixed.brokenInTension;
				answer.brokenInShear   = fixed.brokenInShear;
				answer.bonds           = fixed.bonds;
				answer.unsound         = fixed.unsound;
				answer.bondsFormed     = fixed.bondsFormed;
				answer.bondsMelted     = fixed.bondsMelted;
				answer.carries         = fixed.carries;
				answer.awaitsBonds     = forms;
			});
		}

		/// From the place into the block, and the cell and its images for a step.
		TALIK_CARD static inline TALIK_INLINED void take(Kernel& kernel, const SampleCall& call, const Shared<Dim>& s, const At& place, int step)
		{
			Fixed<Dim>& fixed = s.fixed;
			together<Threads>([&](int t) TALIK_INLINED {
				kernel.load(t, s, place, call);
				for (int e = t; e < 2 * call.pairs; e += Threads)
					s.incidence[e] = place.incidence(e);
				for (int g = t; g <= call.grains; g += Threads)
					s.start[g] = place.start(g);
				const Gradients<Dim> l(call, step);
				double               cell[2 * Dim * Dim];
				TALIK_UNROLL for (int k = 0; k < Dim * Dim; ++k)
				{
					cell[k]             = step > 0 ? fixed.cell[~step & 1][k] : call.hSize[k];
					cell[Dim * Dim + k] = step > 0 ? 0. : call.trsf[k];
				}
				for (int k = Threads - 1 - t; k < call.images; k += Threads) {
					for (int d = 0; d < Dim; ++d)
						fixed.cells[Dim * k + d] = place.image(Dim * k + d);
					moveCell<Dim>(cell, fixed.cell[0], k == 0 && step == 0, l.now, call.dt, fixed.cells + Dim * k, fixed.image[k]);
				}
			});
		}

		/// Before a step that needs them, of a sample that has been stored. False where it is not sound, or the host must.
		TALIK_CARD static inline TALIK_INLINED bool newLists(SampleCall& call, const Shared<Dim>& s, const At& place, int step, double leastSkin)
		{
			Fixed<Dim>& fixed = s.fixed;
			together<Threads>([&](int t) TALIK_INLINED {
				for (int k = t; k < call.images; k += Threads)
					TALIK_UNROLL for (int d = 0; d < Dim; ++d) // where the images were in the step before
					{
						double x = 0;
						TALIK_UNROLL for (int e = 0; e < Dim; ++e) x += (step > 0 ? fixed.cell[~step & 1][d * Dim + e]
						                                                          : call.hSize[d * Dim + e])
						        * fixed.cells[Dim * k + e];
						fixed.image[k].place[d] = x;
					}
				if (t != 0) return;
				fixed.found[0] = fixed.found[1] = fixed.kept[0] = fixed.kept[1] = fixed.images = fixed.noLists = 0;
			});
			checkPairs(call, s, place);
			if (fixed.unsound) return false;
			return NewLists<Dim, Bonded>::of(s, place, call, Threads, fixed.cell[step & 1], Gradients<Dim>(call, step), leastSkin);
		}

		/// Love-Weber: sum of G (x) x over grains, less that of the images.
		TALIK_CARD static inline TALIK_INLINED void stress(const SampleCall& call, const Shared<Dim>& s, const At& place, SampleAnswer& answer)
		{
			Fixed<Dim>& fixed = s.fixed;
			together<Threads>([&](int t) TALIK_INLINED {
				for (int k = Threads - 1 - t; k < Dim * call.images; k += Threads) {
					One sum { 0 };
					for (int p = call.inside; p < call.pairs; ++p)
						if (int(place.index(p) >> 24) - 1 == k / Dim) sum = Add(sum, Kernel::force(s, p, k % Dim));
					fixed.imageForce[k / Dim][k % Dim] = sum.value;
				}
				for (int g = t; g < call.grains; g += Threads)
					Kernel::keepForce(s, g);
			});
			together<Threads>([&](int t) TALIK_INLINED {
				for (int c = t; c < 4 * Dim * Dim; c += Threads) {
					One       sum { 0 };
					const int i = c / (4 * Dim), j = c / 4 % Dim;
					for (int g = c % 4; g < call.grains; g += 4)
						sum = MulAdd(Kernel::keptForce(s, g, i), positionOf(s, g, j), sum);
					fixed.virial[c] = sum.value;
				}
			});
			together<Threads>([&](int t) TALIK_INLINED {
				if (t >= Dim * Dim) return;
				const double* const v   = fixed.virial + 4 * t;
				double              sum = (v[0] + v[1]) + (v[2] + v[3]);
				for (int k = 0; k < call.images; ++k)
					sum -= fixed.imageForce[k][t / Dim] * fixed.image[k].place[t % Dim];
				answer.forces[t] = sum;
			});
		}

		/// Overlaps of more than a radius.
		TALIK_CARD static inline TALIK_INLINED void checkPairs(const SampleCall& call, const Shared<Dim>& s, const At& place)
		{
			together<Threads>([&](int t) TALIK_INLINED {
				for (int p = t; p < call.pairs; p += Threads) {
					double       branch[Dim];
					const double square = branchOf(s, place, p, branch), sum = place.pair(At::sumRadius, p),
					             allowed = sum - call.smallestRadius;
					if (square >= allowed * allowed) continue;
					const std::uint32_t code = place.index(p);
					const double        a = place.constant(2, int(code & 0xfff)), b = place.constant(2, int(code >> 12 & 0xfff));
					if (sum - __builtin_sqrt(square) > (b < a ? b : a)) count(s.fixed.unsound);
				}
			});
		}

		/// Sums of (13.4) over the contacts in their order.
		TALIK_CARD static inline TALIK_INLINED void tangent(
		        const SampleCall& call, const Shared<Dim>& s, const At& place, double* sums, const double* cell)
		{
			constexpr int products = Dim * (Dim + 1) / 2;
			const double  volume   = volumeOf<Dim>(cell, call.thickness);
			together<Threads>([&](int t) TALIK_INLINED {
				for (int p = t; p < call.pairs; p += Threads) {
					double       n[3]   = { 0, 0, 0 };
					const double square = branchOf(s, place, p, n), distance = __builtin_sqrt(square), sum = place.pair(At::sumRadius, p);
					const double overlap   = sum - distance;
					const double own       = place.pair(At::stiffness, p);
					double       stiffness = ContactStiffness { own, 0, 0, Kernel::Hertz ? own : 0 }.grainSpring(overlap).tangent;
					for (int d = 0; d < Dim; ++d)
						n[d] /= distance;
					bool bears = !(square > sum * sum || overlap < 0);
					if constexpr (Bonded)
						if (s.fixed.carries) {
							const IceBond bond = place.iceBond(p).relaxed(overlap);
							bears              = !(overlap < 0 && !bond.intact());
							const auto k       = place.contactStiffness(call, p);
							stiffness          = k.spring(bond.response(k, place.strength(call, p)), overlap).tangent;
						}
					const double factor = distance * distance * stiffness / volume;
					s.ofPair(0, p)      = { { bears ? factor : 0. }, { n[0] } };
					s.ofPair(1, p)      = { { n[1] }, { n[2] } };
				}
			});
			together<Threads>([&](int t) TALIK_INLINED {
				for (int c = t; c < products + products * (products + 1) / 2; c += Threads) {
					int first = c, second = -1;
					for (int k = 0, at = products; k < products && c >= products; at += products - k, ++k)
						if (c < at + products - k) {
							first  = k;
							second = k + c - at;
							break;
						}
					double sum = 0;
					for (int p = 0; p < call.pairs; ++p) {
						const Two    a = s.ofPair(0, p), b = s.ofPair(1, p);
						const double n[3] = { a.y.value, b.x.value, b.y.value }, weighted = a.x.value * product(n, first);
						sum += second < 0 ? weighted : weighted * product(n, second);
					}
					sums[c] = sum;
				}
			});
		}

		/// n_j n_l with j <= l, row by row.
		HWY_INLINE static double product(const double* n, int k)
		{
			if (Dim == 2) return k == 0 ? n[0] * n[0] : k == 1 ? n[0] * n[1] : n[1] * n[1];
			return k < 3 ? n[0] * n[k] : k < 5 ? n[1] * n[k - 2] : n[2] * n[2];
		}
	};

	// ---------------------------------------------------------------------------------------------- discs

	/// Rows of grains in the block: x, v; of pairs: G, then s and s u_n/2.
	template <int ThreadsOfBlock, int GrainsEach, int PairsEach, bool WithBonds, bool OfHertz> struct DiscsOf {
		static constexpr int  Dim = 2, Threads = ThreadsOfBlock, Pairs = PairsEach;
		static constexpr bool Bonded = WithBonds, Hertz = OfHertz;
		using At = Place<2, Bonded>;

		Own<One, PairsEach, Threads>                   shear;
		Own<One, Bonded ? PairsEach : 0, Threads>      ice;
		Own<std::uint32_t, PairsEach, Threads>         index;
		Own<PairConstants<Bonded>, PairsEach, Threads> constants;
		Own<One, GrainsEach, Threads>                  spin, angle;

		HWY_INLINE void load(int t, const Shared<2>& s, const At& place, const SampleCall& call)
		{
			TALIK_UNROLL for (int k = 0; k < GrainsEach; ++k)
			{
				const int g = k * Threads + t;
				if (g >= call.grains) continue;
				s.ofGrain(0, g) = { { place.motion(0, g) }, { place.motion(1, g) } };
				s.ofGrain(1, g) = { { place.motion(2, g) }, { place.motion(3, g) } };
				spin(t, k)      = { place.motion(4, g) };
				angle(t, k)     = { place.motion(5, g) };
				s.rim[g]        = Mul(spin(t, k), { place.constant(2, g) });
			}
			TALIK_UNROLL for (int k = 0; k < PairsEach; ++k)
			{
				const int p = k * Threads + t;
				if (p >= call.pairs) continue;
				shear(t, k) = { place.pair(At::shear, p) };
				if (Bonded) ice(t, k) = { place.pair(At::iceShear, p) };
				index(t, k)     = place.index(p);
				constants(t, k) = constantsOf<2, Bonded>(place, p);
			}
		}

		HWY_INLINE void contacts(int t, const Shared<2>& s, const At& place, const SampleCall& call)
		{
			const One shearStep { call.stiffnessRatio * call.dt };
			TALIK_UNROLL for (int k = 0; k < PairsEach; ++k)
			{
				const int p = k * Threads + t;
				if (p >= call.pairs) continue;
				const std::uint32_t code = index(t, k), first = code & 0xfff, second = code >> 12 & 0xfff;
				const Two           a = s.ofGrain(0, first), b = s.ofGrain(0, second), va = s.ofGrain(1, first), vb = s.ofGrain(1, second);
				One                 dx = Sub(b.x, a.x), dy = Sub(b.y, a.y), dvx = Sub(vb.x, va.x), dvy = Sub(vb.y, va.y);
				if (code >> 24) {
					const Image<2>& image = s.fixed.image[(code >> 24) - 1];
					dx                    = Add(dx, { image.place[0] });
					dy                    = Add(dy, { image.place[1] });
					dvx                   = Add(dvx, { image.speed[0] });
					dvy                   = Add(dvy, { image.speed[1] });
				}
				PairConstants<Bonded>& c        = constants(t, k);
				const One              wr       = Add(s.rim[first], s.rim[second]);
				const One              distance = Sqrt(MulAdd(dx, dx, Mul(dy, dy))), inverse = Div({ 1. }, distance);
				const One              overlap = Sub(c.sumRadius, distance), nx = Mul(dx, inverse), ny = Mul(dy, inverse);
				const One              tangential = MulSub(dvy, nx, Mul(dvx, ny));
				const One              slip       = MulSub(Mul(c.sumRadius, inverse), tangential, wr);
				const One              increment  = Mul(Mul(shearStep, tangentOf<Hertz>(c, overlap)), slip);
				const auto             f          = forcesOf<2, Bonded, Hertz>(
                                        call, place, s.fixed, p, c, overlap, shear(t, k), Bonded ? ice(t, k) : One { 0 }, increment);
				if (Bonded) ice(t, k) = f.iceShear;
				shear(t, k)    = f.shear;
				s.ofPair(0, p) = { NegMulAdd(f.shear, ny, Mul(f.normal, nx)), MulAdd(f.shear, nx, Mul(f.normal, ny)) };
				s.ofPair(1, p) = { f.shear, Mul(Mul({ 0.5 }, f.overlap), f.shear) };
			}
		}

		HWY_INLINE void integrate(
		        int t, const Shared<2>& s, const At& place, const SampleCall& call, const Gradients<2>& l, bool jumps, std::uint64_t& most)
		{
			const One dt { call.dt }, halfStep { 0.5 * call.dt }, damping { call.damping };
			const One lxx { l.now[0] }, lxy { l.now[1] }, lyx { l.now[2] }, lyy { l.now[3] };
			TALIK_UNROLL for (int k = 0; k < GrainsEach; ++k)
			{
				const int g = k * Threads + t;
				if (g >= call.grains) continue;
				One fx { 0 }, fy { 0 }, sumOfShear { 0 }, sumOfMoments { 0 };
				for (int e = s.start[g], end = s.start[g + 1]; e < end; ++e) {
					const int code = s.incidence[e], p = code & 0x7fff;
					const Two force = s.ofPair(0, p), moment = s.ofPair(1, p);
					const One sign = signOf(code >> 15);
					fx             = MulAdd(force.x, sign, fx);
					fy             = MulAdd(force.y, sign, fy);
					sumOfShear     = Add(sumOfShear, moment.x);
					sumOfMoments   = Add(sumOfMoments, moment.y);
				}
				const Two x = s.ofGrain(0, g), v = s.ofGrain(1, g);
				const One minusInverseMass { place.constant(0, g) }, inverseInertia { place.constant(1, g) }, radius { place.constant(2, g) };
				const One meanX = MulAdd(lxx, x.x, Mul(lxy, x.y)), meanY = MulAdd(lyx, x.x, Mul(lyy, x.y));
				One       ax = damped(Mul(fx, minusInverseMass), Sub(v.x, meanX), damping, halfStep);
				One       ay = damped(Mul(fy, minusInverseMass), Sub(v.y, meanY), damping, halfStep);
				ax           = MulAdd(lxx, v.x, MulAdd(lxy, v.y, ax));
				ay           = MulAdd(lyx, v.x, MulAdd(lyy, v.y, ay));
				One       vx = MulAdd(dt, ax, v.x), vy = MulAdd(dt, ay, v.y);
				const One ux = Sub(vx, meanX), uy = Sub(vy, meanY);
				raise(most, bitsOf(Mul({ place.constant(3, g) }, MulAdd(ux, ux, Mul(uy, uy)))));
				if (jumps) {
					vx = MulAdd({ l.next[0] - l.now[0] }, x.x, MulAdd({ l.next[1] - l.now[1] }, x.y, vx));
					vy = MulAdd({ l.next[2] - l.now[2] }, x.x, MulAdd({ l.next[3] - l.now[3] }, x.y, vy));
				}
				s.ofGrain(0, g)  = { MulAdd(dt, vx, x.x), MulAdd(dt, vy, x.y) };
				s.ofGrain(1, g)  = { vx, vy };
				const One torque = NegMulAdd(radius, sumOfShear, sumOfMoments);
				One       w      = spin(t, k);
				w                = MulAdd(dt, damped(Mul(torque, inverseInertia), w, damping, halfStep), w);
				if (jumps) w = Add(w, { -0.5 * ((l.next[1] - l.now[1]) - (l.next[2] - l.now[2])) });
				spin(t, k)  = w;
				angle(t, k) = MulAdd(dt, w, angle(t, k));
				s.rim[g]    = Mul(w, radius);
			}
		}

		HWY_INLINE void store(int t, const Shared<2>& s, const At& place, const SampleCall& call)
		{
			TALIK_UNROLL for (int k = 0; k < GrainsEach; ++k)
			{
				const int g = k * Threads + t;
				if (g >= call.grains) continue;
				const Two    x = s.ofGrain(0, g), v = s.ofGrain(1, g);
				const double numbers[6] = { x.x.value, x.y.value, v.x.value, v.y.value, spin(t, k).value, angle(t, k).value };
				TALIK_UNROLL for (int m = 0; m < 6; ++m)
				{
					place.motion(m, g) = numbers[m];
					if (m < 4 && !finite(numbers[m])) count(s.fixed.unsound);
				}
			}
			TALIK_UNROLL for (int k = 0; k < PairsEach; ++k)
			{
				const int p = k * Threads + t;
				if (p >= call.pairs) continue;
				place.pair(At::shear, p) = shear(t, k).value;
				if (Bonded) place.pair(At::iceShear, p) = ice(t, k).value;
			}
		}

		/// Of the last step: G of a pair; sum of G of a grain, kept where its moments were.
		HWY_INLINE static One  force(const Shared<2>& s, int p, int d) { return d == 0 ? s.ofPair(0, p).x : s.ofPair(0, p).y; }
		HWY_INLINE static void keepForce(const Shared<2>& s, int g)
		{
			One fx { 0 }, fy { 0 };
			for (int e = s.start[g], end = s.start[g + 1]; e < end; ++e) {
				const int code  = s.incidence[e];
				const Two force = s.ofPair(0, code & 0x7fff);
				fx              = MulAdd(force.x, signOf(code >> 15), fx);
				fy              = MulAdd(force.y, signOf(code >> 15), fy);
			}
			s.ofPair(1, g) = { fx, fy };
		}
		HWY_INLINE static One keptForce(const Shared<2>& s, int g, int d) { return d == 0 ? s.ofPair(1, g).x : s.ofPair(1, g).y; }
	};

	// ---------------------------------------------------------------------------------------------- spheres

	using Vector = InSpace<One>;

	/// M x + b
	HWY_INLINE Vector timesAdd(const double* m, const Vector& x, const Vector& b)
	{
		return { MulAdd({ m[0] }, x.x, MulAdd({ m[1] }, x.y, MulAdd({ m[2] }, x.z, b.x))),
			 MulAdd({ m[3] }, x.x, MulAdd({ m[4] }, x.y, MulAdd({ m[5] }, x.z, b.y))),
			 MulAdd({ m[6] }, x.x, MulAdd({ m[7] }, x.y, MulAdd({ m[8] }, x.z, b.z))) };
	}

	/// Rows of grains in the block: x, y; z, w_y r; v_x, v_y; v_z, w_z r (and w_x r beside w_x); of pairs: G, n x s, levers of first and second.
	template <int ThreadsOfBlock, int GrainsEach, int PairsEach, bool WithBonds, bool OfHertz> struct SpheresOf {
		static constexpr int  Dim = 3, Threads = ThreadsOfBlock, Pairs = PairsEach;
		static constexpr bool Bonded = WithBonds, Hertz = OfHertz;
		using At = Place<3, Bonded>;

		Own<Vector, PairsEach, Threads>                shear;
		Own<Vector, Bonded ? PairsEach : 0, Threads>   ice;
		Own<std::uint32_t, PairsEach, Threads>         index;
		Own<PairConstants<Bonded>, PairsEach, Threads> constants;
		Own<One, PairsEach, Threads>                   halfDifference;

		HWY_INLINE static void put(const Shared<3>& s, int g, const Vector& x, const Vector& v, const Vector& w, One radius)
		{
			const Vector rim = scaled(w, radius);
			s.ofGrain(0, g)  = { x.x, x.y };
			s.ofGrain(1, g)  = { x.z, rim.x };
			s.ofGrain(2, g)  = { v.x, v.y };
			s.ofGrain(3, g)  = { v.z, rim.y };
			s.ofGrain(4, g)  = { w.x, w.y };
			s.ofGrain(5, g)  = { w.z, rim.z };
		}
		HWY_INLINE static Vector vectorOf(const Shared<3>& s, int row, int g)
		{
			const Two xy = s.ofGrain(2 * row, g), z = s.ofGrain(2 * row + 1, g);
			return { xy.x, xy.y, z.x };
		}
		HWY_INLINE static Vector pairVector(const At& place, int row, int p)
		{
			return { { place.pair(row, p) }, { place.pair(row + 1, p) }, { place.pair(row + 2, p) } };
		}
		HWY_INLINE static void setPairVector(const At& place, int row, int p, const Vector& v)
		{
			place.pair(row, p)     = v.x.value;
			place.pair(row + 1, p) = v.y.value;
			place.pair(row + 2, p) = v.z.value;
		}

		HWY_INLINE void load(int t, const Shared<3>& s, const At& place, const SampleCall& call)
		{
			TALIK_UNROLL for (int k = 0; k < GrainsEach; ++k)
			{
				const int g = k * Threads + t;
				if (g >= call.grains) continue;
				const auto vector = [&](int row) TALIK_INLINED {
					return Vector { { place.motion(row, g) }, { place.motion(row + 1, g) }, { place.motion(row + 2, g) } };
				};
				put(s, g, vector(0), vector(3), vector(6), { place.constant(2, g) });
			}
			TALIK_UNROLL for (int k = 0; k < PairsEach; ++k)
			{
				const int p = k * Threads + t;
				if (p >= call.pairs) continue;
				shear(t, k) = pairVector(place, At::shear, p);
				if (Bonded) ice(t, k) = pairVector(place, At::iceShear, p);
				index(t, k)          = place.index(p);
				constants(t, k)      = constantsOf<3, Bonded>(place, p);
				halfDifference(t, k) = { place.pair(At::halfDifference, p) };
			}
		}

		HWY_INLINE void contacts(int t, const Shared<3>& s, const At& place, const SampleCall& call)
		{
			const One shearStep { call.stiffnessRatio * call.dt }, dt { call.dt }, halfStep { 0.5 * call.dt };
			TALIK_UNROLL for (int k = 0; k < PairsEach; ++k)
			{
				const int p = k * Threads + t;
				if (p >= call.pairs) continue;
				const std::uint32_t code = index(t, k), first = code & 0xfff, second = code >> 12 & 0xfff;
				Two                 a = s.ofGrain(0, first), b = s.ofGrain(0, second), c = s.ofGrain(1, first), d = s.ofGrain(1, second);
				Vector              branch { Sub(b.x, a.x), Sub(b.y, a.y), Sub(d.x, c.x) }, rim;
				rim.x = Add(c.y, d.y);
				a = s.ofGrain(2, first), b = s.ofGrain(2, second), c = s.ofGrain(3, first), d = s.ofGrain(3, second);
				Vector velocity { Sub(b.x, a.x), Sub(b.y, a.y), Sub(d.x, c.x) };
				rim.y = Add(c.y, d.y);
				a = s.ofGrain(4, first), b = s.ofGrain(4, second), c = s.ofGrain(5, first), d = s.ofGrain(5, second);
				const Vector spin { Add(a.x, b.x), Add(a.y, b.y), Add(c.x, d.x) };
				rim.z = Add(c.y, d.y);
				if (code >> 24) {
					const Image<3>& image = s.fixed.image[(code >> 24) - 1];
					branch                = Add(branch, Vector { { image.place[0] }, { image.place[1] }, { image.place[2] } });
					velocity              = Add(velocity, Vector { { image.speed[0] }, { image.speed[1] }, { image.speed[2] } });
				}
				PairConstants<Bonded>& constant = constants(t, k);
				const One              distance = Sqrt(dot(branch, branch)), inverse = Div({ 1. }, distance);
				const Vector           n       = scaled(branch, inverse);
				const One              turning = Mul(dt, inverse), stretch = Mul(constant.sumRadius, inverse);
				const Vector           across    = cross(n, velocity);
				const One              bend      = MulAdd(Mul(turning, dot(velocity, n)), turning, turning);
				const Vector           slip      = cross(n, NegMulAdd(stretch, across, rim));
				const Vector           turn      = MulAdd(bend, across, scaled(n, Mul(halfStep, dot(n, spin))));
				const One              overlap   = Sub(constant.sumRadius, distance);
				const Vector           increment = scaled(slip, Mul(shearStep, tangentOf<Hertz>(constant, overlap)));
				const Vector           before = shear(t, k), carried = crossAdd(turn, before, before);
				Vector                 ofIce { { 0 }, { 0 }, { 0 } };
				if (Bonded) {
					ofIce = ice(t, k);
					ofIce = crossAdd(turn, ofIce, ofIce);
				}
				const auto f = forcesOf<3, Bonded, Hertz>(call, place, s.fixed, p, constant, overlap, carried, ofIce, increment);
				if (Bonded) ice(t, k) = f.iceShear;
				shear(t, k)       = f.shear;
				const Vector m    = cross(n, f.shear);
				const One    half = Mul({ 0.5 }, distance), difference = halfDifference(t, k);
				s.ofPair(0, p) = { MulAdd(f.normal, n.x, f.shear.x), MulAdd(f.normal, n.y, f.shear.y) };
				s.ofPair(1, p) = { MulAdd(f.normal, n.z, f.shear.z), m.x };
				s.ofPair(2, p) = { m.y, m.z };
				s.ofPair(3, p) = { Add(half, difference), Sub(half, difference) };
			}
		}

		HWY_INLINE void integrate(
		        int t, const Shared<3>& s, const At& place, const SampleCall& call, const Gradients<3>& l, bool jumps, std::uint64_t& most)
		{
			const One    dt { call.dt }, halfStep { 0.5 * call.dt }, damping { call.damping };
			const Vector none { { 0 }, { 0 }, { 0 } };
			TALIK_UNROLL for (int k = 0; k < GrainsEach; ++k)
			{
				const int g = k * Threads + t;
				if (g >= call.grains) continue;
				Vector f = none, moment = none;
				for (int e = s.start[g], end = s.start[g + 1]; e < end; ++e) {
					const int code = s.incidence[e], p = code & 0x7fff;
					const Two a = s.ofPair(0, p), b = s.ofPair(1, p), c = s.ofPair(2, p), d = s.ofPair(3, p);
					const One sign = signOf(code >> 15), lever = code >> 15 ? d.y : d.x;
					f      = { MulAdd(a.x, sign, f.x), MulAdd(a.y, sign, f.y), MulAdd(b.x, sign, f.z) };
					moment = { Add(moment.x, Mul(b.y, lever)), Add(moment.y, Mul(c.x, lever)), Add(moment.z, Mul(c.y, lever)) };
				}
				const Vector x = vectorOf(s, 0, g), v = vectorOf(s, 1, g), w = vectorOf(s, 2, g);
				const One    minusInverseMass { place.constant(0, g) }, inverseInertia { place.constant(1, g) };
				const Vector meanField = timesAdd(l.now, x, none);
				const Vector a         = timesAdd(l.now, v, damped(scaled(f, minusInverseMass), Sub(v, meanField), damping, halfStep));
				Vector       velocity  = MulAdd(dt, a, v);
				const Vector carried   = Sub(velocity, meanField);
				raise(most, bitsOf(Mul({ place.constant(3, g) }, dot(carried, carried))));
				Vector turned = MulAdd(dt, damped(scaled(moment, inverseInertia), w, damping, halfStep), w);
				if (jumps) {
					double leap[9];
					TALIK_UNROLL for (int m = 0; m < 9; ++m) leap[m] = l.next[m] - l.now[m];
					velocity                                         = timesAdd(leap, x, velocity);
					turned = { Add(turned.x, { -0.5 * (leap[5] - leap[7]) }), Add(turned.y, { -0.5 * (leap[6] - leap[2]) }),
						   Add(turned.z, { -0.5 * (leap[1] - leap[3]) }) };
				}
				put(s, g, MulAdd(dt, velocity, x), velocity, turned, { place.constant(2, g) });
			}
		}

		HWY_INLINE void store(int t, const Shared<3>& s, const At& place, const SampleCall& call)
		{
			TALIK_UNROLL for (int k = 0; k < GrainsEach; ++k)
			{
				const int g = k * Threads + t;
				if (g >= call.grains) continue;
				TALIK_UNROLL for (int row = 0; row < 3; ++row)
				{
					const Vector v               = vectorOf(s, row, g);
					place.motion(3 * row, g)     = v.x.value;
					place.motion(3 * row + 1, g) = v.y.value;
					place.motion(3 * row + 2, g) = v.z.value;
					if (!finite(v.x.value) || !finite(v.y.value) || !finite(v.z.value)) count(s.fixed.unsound);
				}
			}
			TALIK_UNROLL for (int k = 0; k < PairsEach; ++k)
			{
				const int p = k * Threads + t;
				if (p >= call.pairs) continue;
				setPairVector(place, At::shear, p, shear(t, k));
				if (Bonded) setPairVector(place, At::iceShear, p, ice(t, k));
			}
		}

		HWY_INLINE static One force(const Shared<3>& s, int p, int d)
		{
			return d == 0 ? s.ofPair(0, p).x : d == 1 ? s.ofPair(0, p).y : s.ofPair(1, p).x;
		}
		HWY_INLINE static void keepForce(const Shared<3>& s, int g)
		{
			Vector f { { 0 }, { 0 }, { 0 } };
			for (int e = s.start[g], end = s.start[g + 1]; e < end; ++e) {
				const int code = s.incidence[e], p = code & 0x7fff;
				const Two a = s.ofPair(0, p), b = s.ofPair(1, p);
				const One sign = signOf(code >> 15);
				f              = { MulAdd(a.x, sign, f.x), MulAdd(a.y, sign, f.y), MulAdd(b.x, sign, f.z) };
			}
			s.ofPair(2, g) = { f.x, f.y };
			s.ofPair(3, g) = { f.z, { 0 } };
		}
		HWY_INLINE static One keptForce(const Shared<3>& s, int g, int d)
		{
			return d == 0 ? s.ofPair(2, g).x : d == 1 ? s.ofPair(2, g).y : s.ofPair(3, g).x;
		}
	};

	template <int Dim, int Threads, int GrainsEach, int PairsEach, bool Bonded, bool Hertz> struct KernelOf {
		using Type = Run<std::conditional_t<
		        Dim == 2, DiscsOf<Threads, GrainsEach, PairsEach, Bonded, Hertz>, SpheresOf<Threads, GrainsEach, PairsEach, Bonded, Hertz>>>;
	};

} // namespace N_ONE
} // namespace talik
