// SPDX-License-Identifier: GPL-2.0-or-later
// What a change of ice does to a sample, by its block of threads: bonds follow the ice, melt and form, grains shrink, as PackedWorkspace has it in
// setIceSaturation() and bondAll(). All of it works on the place of the sample, which then is taken into the block anew.
#pragma once
#include <pkg/rve/device/SampleLists.hpp>
#include <pkg/rve/device/SampleMemory.hpp>

namespace talik {
namespace N_ONE {

	/// A shear force in space as IceBond wants it.
	struct PlainVector {
		double     v[3];
		TALIK_CARD PlainVector() {}
		TALIK_CARD explicit PlainVector(const InSpace<One>& s)
		        : v { s.x.value, s.y.value, s.z.value }
		{}
		TALIK_CARD InSpace<One> inSpace() const { return { { v[0] }, { v[1] }, { v[2] } }; }
		TALIK_CARD void         setZero() { v[0] = v[1] = v[2] = 0; }
		TALIK_CARD PlainVector& operator*=(double f)
		{
			for (double& c : v)
				c *= f;
			return *this;
		}
		TALIK_CARD PlainVector& operator-=(const PlainVector& other)
		{
			for (int d = 0; d < 3; ++d)
				v[d] -= other.v[d];
			return *this;
		}
		TALIK_CARD PlainVector& operator+=(const PlainVector& other)
		{
			for (int d = 0; d < 3; ++d)
				v[d] += other.v[d];
			return *this;
		}
		TALIK_CARD friend PlainVector operator*(PlainVector a, double f) { return a *= f; }
		TALIK_CARD friend double      shearNorm(const PlainVector& s) { return __builtin_sqrt(s.v[0] * s.v[0] + s.v[1] * s.v[1] + s.v[2] * s.v[2]); }
	};
	HWY_INLINE double      plainShear(One s) { return s.value; }
	HWY_INLINE PlainVector plainShear(const InSpace<One>& s) { return PlainVector(s); }
	HWY_INLINE One         shearOf(double s) { return { s }; }
	HWY_INLINE InSpace<One> shearOf(const PlainVector& s) { return s.inSpace(); }

	// the same in the place of a sample, from a row on
	template <bool Bonded> HWY_INLINE void takeShear(const Place<2, Bonded>& place, int row, int p, double& s) { s = place.pair(row, p); }
	template <bool Bonded> HWY_INLINE void keepShear(const Place<2, Bonded>& place, int row, int p, double s) { place.pair(row, p) = s; }
	template <bool Bonded> HWY_INLINE void takeShear(const Place<3, Bonded>& place, int row, int p, PlainVector& s)
	{
		for (int d = 0; d < 3; ++d)
			s.v[d] = place.pair(row + d, p);
	}
	template <bool Bonded> HWY_INLINE void keepShear(const Place<3, Bonded>& place, int row, int p, const PlainVector& s)
	{
		for (int d = 0; d < 3; ++d)
			place.pair(row + d, p) = s.v[d];
	}

	/// Branch of a pair and its square, as pairBranch() of the packed samples has it.
	template <int Dim, bool Bonded> HWY_INLINE double branchOf(const Shared<Dim>& s, const Place<Dim, Bonded>& place, int p, double* branch)
	{
		const std::uint32_t code   = place.index(p);
		double              square = 0;
		for (int d = 0; d < Dim; ++d) {
			branch[d] = positionOf(s, int(code >> 12 & 0xfff), d).value - positionOf(s, int(code & 0xfff), d).value;
			if (code >> 24) branch[d] += s.fixed.image[(code >> 24) - 1].place[d];
			square += branch[d] * branch[d];
		}
		return square;
	}

	/// Overlap of a pair as PackedWorkspace::geometry() has it.
	template <int Dim, bool Bonded> HWY_INLINE double overlapOf(const Shared<Dim>& s, const Place<Dim, Bonded>& place, int p)
	{
		double branch[Dim];
		return place.pair(Place<Dim, Bonded>::sumRadius, p) - __builtin_sqrt(branchOf(s, place, p, branch));
	}

	/// Changes of ice at rest. They are rare beside steps, and one function each serves all numbers of threads.
	template <int Dim, bool Bonded> struct NewIce {
		using At         = Place<Dim, Bonded>;
		using PlainShear = std::conditional_t<Dim == 2, double, PlainVector>;

		/// The ice, strengths and radii of `ice` come into force; no bond forms.
		TALIK_CARD static __attribute__((noinline)) void follow(
		        const Shared<Dim>& s, const At& place, SampleCall& call, const IcePart& ice, int threads)
		{
			Fixed<Dim>& fixed = s.fixed;
			together(threads, [&](int t) TALIK_INLINED {
				if (t != 0) return;
				fixed.formerIceRatio = call.iceRatio;
				call.iceRatio        = ice.iceRatio;
				call.tensileStrength = ice.tensileStrength;
				call.shearStrength   = ice.shearStrength;
				call.thawed          = ice.melted;
				call.largestRadius   = ice.largestRadius;
				call.smallestRadius  = ice.smallestRadius;
				call.meanRadius      = ice.meanRadius;
				fixed.someBond       = 0;
			});
			together(threads, [&](int t) TALIK_INLINED {
				for (int g = t; g < call.grains; g += threads)
					place.setRadius(g, place.constant(At::ownRadius, g) * ice.radiusFactor);
				for (int p = t; p < call.pairs; p += threads)
					followOf(s, place, call, ice, p);
			});
			together(threads, [&](int t) TALIK_INLINED {
				if (t == 0 && ice.melted) fixed.carries = fixed.someBond != 0;
			});
		}

		/// New ice bonds what is near, in lists that reach far enough. cell: of the next step.
		TALIK_CARD static __attribute__((noinline)) void form(const Shared<Dim>& s, const At& place, SampleCall& call, const double* cell, int threads)
		{
			Fixed<Dim>& fixed = s.fixed;
			together(threads, [&](int t) TALIK_INLINED {
				for (int k = t; k < call.images; k += threads)
					for (int d = 0; d < Dim; ++d) {
						double x = 0;
						for (int e = 0; e < Dim; ++e)
							x += cell[d * Dim + e] * fixed.cells[Dim * k + e];
						fixed.image[k].place[d] = x;
					}
				if (t == 0) fixed.someBond = fixed.formed = 0;
			});
			together(threads, [&](int t) TALIK_INLINED {
				for (int p = t; p < call.pairs; p += threads)
					formOf(s, place, call, p);
			});
			together(threads, [&](int t) TALIK_INLINED {
				if (t != 0) return;
				fixed.bondsFormed += fixed.formed;
				fixed.carries = fixed.formed != 0 || fixed.someBond != 0;
			});
		}

	private:
		HWY_INLINE static void followOf(const Shared<Dim>& s, const At& place, const SampleCall& call, const IcePart& ice, int p)
		{
			const std::uint32_t code  = place.index(p);
			const double        first = place.constant(At::ownRadius, int(code & 0xfff)) * ice.radiusFactor,
			             second       = place.constant(At::ownRadius, int(code >> 12 & 0xfff)) * ice.radiusFactor;
			if constexpr (Bonded) {
				IceBond    bond = place.iceBond(p);
				PlainShear shear, iceShear;
				takeShear(place, At::shear, p, shear);
				takeShear(place, At::iceShear, p, iceShear);
				const ContactStiffness now    = place.contactStiffness(call, p);
				ContactStiffness       before = now;
				before.iceRatio               = s.fixed.formerIceRatio;
				const IceChange change { ice.melted != 0, call.bondsOutlast != 0 };
				const auto      overlap = [&]() TALIK_INLINED { return overlapOf(s, place, p); };
				if (change.apply(bond, before, now, overlap, shear, iceShear)) count(s.fixed.bondsMelted);
				if (bond.state != BondState::NONE) s.fixed.someBond = 1;
				if (!bond.hasIceSpring()) clearShear(iceShear);
				keepShear(place, At::shear, p, shear);
				keepShear(place, At::iceShear, p, iceShear);
				place.setBond(p, bond);
				place.setResponse(p, bond.response(now, place.strength(call, p)));
			}
			place.pair(At::sumRadius, p) = first + second;
			if constexpr (Dim == 3) place.pair(At::halfDifference, p) = 0.5 * (first - second);
		}

		HWY_INLINE static void formOf(const Shared<Dim>& s, const At& place, const SampleCall& call, int p)
		{
			if constexpr (Bonded) {
				const std::uint32_t code  = place.index(p);
				const double        first = place.constant(At::radius, int(code & 0xfff)),
				             second       = place.constant(At::radius, int(code >> 12 & 0xfff));
				IceBond    bond           = place.iceBond(p);
				PlainShear iceShear;
				takeShear(place, At::iceShear, p, iceShear);
				if (formWithin(bond, overlapOf(s, place, p), call.bondRange * (second < first ? second : first), iceShear)) {
					count(s.fixed.formed);
					keepShear(place, At::iceShear, p, iceShear);
					place.setBond(p, bond);
					place.setResponse(p, bond.response(place.contactStiffness(call, p), place.strength(call, p)));
				}
				if (bond.state != BondState::NONE) s.fixed.someBond = 1;
			}
		}
	};

	/// A pair that has just got room for a bond.
	template <int Dim> HWY_INLINE void withoutBond(const Place<Dim, true>& place, const SampleCall& call, int p)
	{
		using At                  = Place<Dim, true>;
		const std::uint32_t code  = place.index(p);
		const double        first = place.constant(At::ownRadius, int(code & 0xfff)), second = place.constant(At::ownRadius, int(code >> 12 & 0xfff)),
		             smaller = second < first ? second : first;
		for (int d = 0; d < At::shearRows; ++d)
			place.pair(At::iceShear + d, p) = 0;
		place.pair(At::grainStiffness, p) = call.elasticity.acts() ? 2 * call.young * first * second / (first + second) : place.pair(At::stiffness, p);
		place.pair(At::area, p)           = call.bondAreaFactor * smaller * smaller;
		place.setBond(p, IceBond());
		place.setResponse(p, IceBond().response(place.contactStiffness(call, p), place.strength(call, p)));
	}

	/// A sample comes from its former place, which has room for bonds where this one has none, or none where this one has.
	template <int Dim, bool Bonded>
	TALIK_CARD __attribute__((noinline)) void bringFromFormerPlace(const Place<Dim, Bonded>& place, const SampleCall& call, int threads)
	{
		using Former             = Place<Dim, !Bonded>;
		using Here               = Place<Dim, Bonded>;
		const PlaceLayout layout = PlaceLayout::of(Dim, call.grains, call.formerPairs, !Bonded, call.elasticity.acts());
		const Former      former(call.formerPlace, layout);
		constexpr int     ofGrains = Here::motionRows + Here::constants, ofPairs = Here::shearRows + Dim; // what both have
		together(threads, [&](int t) TALIK_INLINED {
			for (int row = 0; row < ofGrains; ++row)
				for (int g = t; g < call.grains; g += threads)
					place.motion(row, g) = former.motion(row, g);
			for (int g = t; g <= call.grains; g += threads)
				place.setStart(g, former.start(g));
			for (int k = t; k < Dim * call.images; k += threads)
				place.setImage(k, former.image(k));
			for (int e = t; e < 2 * call.pairs; e += threads)
				place.setIncidence(e, former.incidence(e));
			for (int p = t; p < call.pairs; p += threads) {
				place.setIndex(p, former.index(p));
				for (int row = 0; row < ofPairs; ++row)
					place.pair(row, p) = former.pair(row, p);
			}
		});
		if constexpr (Bonded)
			together(threads, [&](int t) TALIK_INLINED {
				for (int p = t; p < call.pairs; p += threads)
					withoutBond(place, call, p);
			});
	}

} // namespace N_ONE
} // namespace talik
